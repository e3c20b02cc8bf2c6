"""The layout of tetrahedra that later rooms build on: steps of insertion, replaced cavities, constraints, regions."""

import numpy as np
import pytest

from meshcore import Tetrahedralization
from meshcore.geometry import predicates
from meshcore.unstructured import _cavity_kernels as cavity_kernels
from meshcore.unstructured import _delaunay_3d_kernels as kernels
from meshcore.unstructured import _tetrahedra_kernels as layout
from meshcore.unstructured import space_insertion
from tests import point_sets


def built(points):
    """A triangulation's cells, with all of its side arrays."""
    space = Tetrahedralization.from_points(points)._space
    space.require("region", "facet_id", "cell_of")
    return space


def records(space):
    return space.cells[: 16 * space.n_cells].reshape(-1, 16)


def live(space):
    return np.flatnonzero(records(space)[:, 0] >= 0)


def facet(corners, k):
    """The corners of a facet, in the order in which they turn as seen from the cell."""
    return corners[[layout.FACET_A[k], layout.FACET_B[k], layout.FACET_C[k]]]


def assert_sound(space):
    """Neighbours know each other by the same facet, ghosts have the infinite vertex last, the rest is as documented."""
    cells, xyz = records(space), space.points.reshape(-1, 4)[:, :3]
    alive = live(space)
    for t in alive:
        corners = cells[t, :4]
        assert (corners[:3] >= 0).all() and corners[3] >= -1 and len(set(corners.tolist())) == 4
        if corners[3] >= 0:
            assert predicates.orient3d(*xyz[corners]) == 1
        for k in range(4):
            word = int(cells[t, 4 + k])
            other, l = word >> 3, word & 3
            assert cells[other, 0] >= 0
            assert cells[other, 4 + l] == t << 3 | (word & layout.CONSTRAINED) | k
            ours, theirs = facet(corners, k).tolist(), facet(cells[other, :4], l).tolist()
            assert ours in ([theirs[j], theirs[j - 1], theirs[j - 2]] for j in range(3))
    for v, t in enumerate(space.cell_of.tolist()):
        assert t == -1 or v in cells[t, :4]
    for t in alive:
        cached = space.planes[8 * t + 4 : 8 * t + 8].copy()
        layout.set_plane(space.points, space.cells, space.planes, t)
        assert np.allclose(space.planes[8 * t + 4 : 8 * t + 8], cached, rtol=1e-9, atol=1e-15)
    free, head = 0, int(space.state[layout.FREE])
    while head >= 0:
        assert cells[head, 0] == -1
        free, head = free + 1, int(cells[head, 4])
    assert free + len(alive) == space.n_cells


def as_set(space):
    """The live cells, whatever their numbers, orders of corners and neighbours."""
    return {tuple(sorted(c)) for c in records(space)[live(space), :4].tolist()}


def snapshot(space):
    """All that a refused change must leave as it is."""
    arrays = (space.cells[: 16 * space.n_cells], space.planes[: 8 * space.n_cells], space.region, space.facet_id)
    return [a.copy() for a in (*arrays, space.cell_of, space.state)]


def assert_same(space, before):
    for now, then in zip(snapshot(space), before, strict=True):
        assert np.array_equal(now.view(np.uint8), then.view(np.uint8))


def step(space, q, step):
    """One step of the insertion of vertex q."""
    lists = space.lists
    lists.state[kernels.POINT] = 0
    todo, none = np.array([q], np.int32), np.empty(0, np.int32)
    fate = np.full(space.n_vertices, -1, np.int32)
    arguments = space_insertion._arguments(space, lists, todo, none, fate, none.astype(np.uint8), kernels.ANY, q + 1)
    return kernels.insert_points(*arguments, step, 10)


def with_a_point(points, q):
    """The cells of points, and vertex number len(points) at q, not yet inserted."""
    space = built(points)
    scale = space.points[:3] / points[space.rows[0]]
    record = np.append(np.asarray(q) * scale, 0.0)
    space.append(record, np.array([len(points)], np.int32), 0.0, space.extent)
    return space, space.n_vertices - 1


@pytest.fixture
def cloud():
    return 0.5 + 0.5 * np.random.default_rng(3).random((60, 3))


def dug(space):
    return space.lists.cavity[: space.state[kernels.N_CAVITY]].copy()


def star(space, q):
    """Corners of the cells that `FILL` would make."""
    facets = space.lists.facets.reshape(-1, 8)[: space.state[kernels.N_FACETS], 1:4]
    return np.column_stack([np.full(len(facets), q), space.lists.corners[facets]])


def test_what_is_built_is_sound():
    for name in ("uniform", "integer_grid", "sphere"):
        assert_sound(built(point_sets.SPACE[name](125, 3, np.random.default_rng(1))))


def test_digging_and_leaving_has_no_trace(cloud):
    space, q = with_a_point(cloud, [0.7, 0.8, 0.7])
    before = snapshot(space)
    assert step(space, q, kernels.DIG) == layout.DONE
    cavity = dug(space)
    assert len(cavity) > 1 and (records(space)[cavity, 0] < -1).all()
    kernels.leave(space.cells, space.lists.cavity, len(cavity))
    assert np.array_equal(space.cells[: 16 * space.n_cells], before[0])
    assert np.array_equal(space.state[:4], before[-1][:4])


@pytest.mark.parametrize("place", [[0.7, 0.8, 0.7], [0.2, 0.6, 0.9], [3.0, 3.0, 3.0]])
def test_steps_replacement_and_insertion_agree(cloud, place):
    whole, q = with_a_point(cloud, place)
    assert step(whole, q, kernels.INSERT) == layout.DONE
    assert_sound(whole)
    stepwise, q = with_a_point(cloud, place)
    stepwise.require("cell_of")
    assert step(stepwise, q, kernels.DIG) == layout.DONE
    facets = stepwise.lists.facets
    assert kernels.is_star_shaped(
        stepwise.points, q, facets, stepwise.state[kernels.N_FACETS], stepwise.lists.corners, stepwise.lists.work
    )
    assert step(stepwise, q, kernels.FILL) == layout.DONE
    assert_sound(stepwise)
    replaced, q = with_a_point(cloud, place)
    assert step(replaced, q, kernels.DIG) == layout.DONE
    cavity, cells = dug(replaced), star(replaced, q)
    kernels.leave(replaced.cells, replaced.lists.cavity, len(cavity))
    status, made = replaced.replace(cavity, cells[:, [3, 2, 1, 0]])  # an even permutation
    assert status == layout.DONE
    assert set(made.tolist()) <= set(live(replaced).tolist())
    assert_sound(replaced)
    assert as_set(whole) == as_set(stepwise) == as_set(replaced)


def bipyramid():
    """Two tetrahedra with a common facet, whose flip is three around the line between the tips."""
    corners = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [0.1, 0.1, 0.1], [0.8, 0.8, 0.8]])
    space = built(corners)
    vertex = np.argsort(space.rows)
    a, b, c, low, high = vertex.tolist()
    two = [[low, a, b, c], [a, b, c, high]]
    three = [[low, high, a, b], [low, high, b, c], [low, high, c, a]]
    return space, two, three


def finite(space):
    return [t for t in live(space) if records(space)[t, 3] >= 0]


def test_flips_there_and_back():
    space, two, three = bipyramid()
    space.region[finite(space)] = 5
    start = as_set(space)
    other = three if {tuple(sorted(c)) for c in two} <= start else two
    this = two if other is three else three
    for new in (other, this, other):
        status, made = space.replace(finite(space), new)
        assert status == layout.DONE and len(made) == len(new)
        assert_sound(space)
        assert {tuple(sorted(c)) for c in new} <= as_set(space)
        assert (space.region[made] == 5).all()
    assert as_set(space) != start
    assert space.replace(finite(space), this)[0] == layout.DONE and as_set(space) == start


def test_constraints_stay_or_refuse():
    space, two, three = bipyramid()
    space.replace(finite(space), two)
    t = finite(space)[0]
    inner = next(k for k in range(4) if records(space)[records(space)[t, 4 + k] >> 3, 3] >= 0)
    around = next(k for k in range(4) if k != inner)
    outside = facet(records(space)[t, :4], around).tolist()
    space.constrain(t, around, 7)
    status, made = space.replace(finite(space), three)
    assert status == layout.DONE
    assert_sound(space)
    kept = [
        (facet(records(space)[s, :4], k).tolist(), space.facet_id[4 * s + k])
        for s in made
        for k in range(4)
        if records(space)[s, 4 + k] & layout.CONSTRAINED
    ]
    assert len(kept) == 1 and sorted(kept[0][0]) == sorted(outside) and kept[0][1] == 7
    space.replace(finite(space), two)
    t = finite(space)[0]
    inner = next(k for k in range(4) if records(space)[records(space)[t, 4 + k] >> 3, 3] >= 0)
    space.constrain(t, inner, 9)
    before = snapshot(space)
    assert space.replace(finite(space), three)[0] == cavity_kernels.LOST_FACET
    assert_same(space, before)
    status, made = space.replace(finite(space), two)  # the same cells anew: the facet between them is kept
    assert status == layout.DONE
    assert_sound(space)
    ids = [space.facet_id[4 * s + k] for s in made for k in range(4) if records(space)[s, 4 + k] & layout.CONSTRAINED]
    assert sorted(ids) == [7, 9, 9]


def test_what_does_not_fit_is_refused_without_a_trace():
    space, two, three = bipyramid()
    space.replace(finite(space), two)
    before, old = snapshot(space), finite(space)
    mirrored = [[b, a, c, d] for a, b, c, d in three]
    assert space.replace(old, mirrored)[0] == cavity_kernels.INVERTED
    assert space.replace(old, three[:2])[0] == cavity_kernels.MISMATCH
    assert space.replace(old, three + three[:1])[0] == cavity_kernels.MISMATCH
    assert space.replace(old[:1], three)[0] == cavity_kernels.MISMATCH
    assert space.replace(old + old[:1], three)[0] == cavity_kernels.MISMATCH
    assert space.replace([], three)[0] == cavity_kernels.MISMATCH
    assert_same(space, before)


def test_digging_stops_at_constrained_facets(cloud):
    space, q = with_a_point(cloud, [0.7, 0.8, 0.7])
    step(space, q, kernels.DIG)
    cavity = set(dug(space).tolist())
    kernels.leave(space.cells, space.lists.cavity, len(cavity))
    step(space, q, kernels.LOCATE)
    first = int(space.state[layout.HINT])
    for k in range(4):
        space.constrain(first, k, k + 1)
    space.region[first] = 3
    assert step(space, q, kernels.DIG) == layout.DONE
    assert dug(space).tolist() == [first] and len(cavity) > 1
    assert step(space, q, kernels.FILL) == layout.DONE
    assert_sound(space)
    new = [t for t in live(space) if records(space)[t, 0] == q]
    assert len(new) == 4 and (space.region[new] == 3).all()
    assert sorted(space.facet_id[4 * np.array(new)].tolist()) == [1, 2, 3, 4]
    assert all(records(space)[t, 4] & layout.CONSTRAINED for t in new)


def test_compaction_keeps_everything(cloud):
    points = np.concatenate([cloud, np.random.default_rng(5).random((200, 3))])
    triangulation = Tetrahedralization.from_points(points)
    space = triangulation._space
    space.require("region", "facet_id", "cell_of")
    before = triangulation.mesh().cells["tetra"]
    cells = finite(space)
    status, _ = space.replace(cells[:1], records(space)[cells[:1], :4])
    assert status == layout.DONE
    space.region[:] = np.arange(len(space.region))
    dead = space.n_cells - len(live(space))
    regions = space.region[live(space)].tolist()
    number = space.compact()
    assert space.n_cells == len(live(space)) == len(number) - dead
    assert_sound(space)
    assert space.region[: space.n_cells].tolist() == regions
    del triangulation.__dict__["_canonical"]
    assert np.array_equal(triangulation.mesh().cells["tetra"], before)


def test_many_replacements_reuse_cells(cloud):
    space, two, three = bipyramid()
    for _ in range(50):
        assert space.replace(finite(space), two)[0] == layout.DONE
        assert space.replace(finite(space), three)[0] == layout.DONE
    assert space.n_cells < 20
