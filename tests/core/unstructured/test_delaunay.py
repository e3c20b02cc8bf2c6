"""Delaunay triangulation of points in the plane: exact, unique, the same however it is built."""

import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial import Delaunay

from meshcore import Cancelled, InvalidGeometry, InvalidInput, Mesh, Triangulation, delaunay_2d
from meshcore.geometry.location import locate
from meshcore.unstructured import point_insertion
from meshcore.unstructured import triangulation as module
from meshcore.unstructured.thin_clouds import planar_order
from tests import naive, naive_delaunay
from tests.core.unstructured import invariants

lattice = st.integers(0, 5).map(float)


def cells(mesh):
    return mesh.cells["triangle"].tolist()


def as_set(mesh):
    return {tuple(sorted(c)) for c in cells(mesh)}


def assert_outline_is_convex(mesh):
    """One loop that never turns right: the triangles cover the convex hull."""
    directed = {(c[k], c[(k + 1) % 3]) for c in cells(mesh) for k in range(3)}
    after = dict(edge for edge in directed if edge[::-1] not in directed)
    loop = [next(iter(after))]
    while after[loop[-1]] != loop[0]:
        loop.append(after[loop[-1]])
    assert len(loop) == len(after)
    points = mesh.points[:, :2].tolist()
    assert all(naive.side(points[a], points[b], points[after[b]]) >= 0 for a, b in after.items())


def clouds():
    """Sets that are hard in one way each, of a thousand points and more."""
    rng = np.random.default_rng(11)
    grid = np.stack(np.meshgrid(np.arange(40.0), np.arange(50.0)), axis=-1).reshape(-1, 2)
    angle = np.linspace(0, 2 * np.pi, 2000, endpoint=False)
    x = rng.random(1500)
    return {
        "uniform": rng.random((3000, 2)),
        "integer grid": grid,
        "linspace grid": grid / 49,
        "rotated grid": grid @ [[0.6, 0.8], [-0.8, 0.6]],
        "hex lattice": np.column_stack([grid[:, 0] + 0.5 * (grid[:, 1] % 2), grid[:, 1] * np.sqrt(0.75)]),
        "circle and centre": np.append(np.column_stack([np.cos(angle), np.sin(angle)]), [[0, 0]], axis=0),
        "clumps": (rng.random((20, 1, 2)) + 1e-9 * rng.normal(size=(20, 100, 2))).reshape(-1, 2),
        "line up to rounding": np.column_stack([x, 0.3 * x + 0.1]),
        "line up to rounding, and an apex": np.column_stack([x, np.where(np.arange(1500) == 700, 1.0, 0.3 * x + 0.1)]),
        "two lines": np.column_stack([x, np.arange(1500) % 2]),
        "duplicates": rng.integers(0, 30, (3000, 2)).astype(float),
    }


CLOUDS = clouds()
each_cloud = pytest.mark.parametrize("name", CLOUDS)


@settings(max_examples=100)
@given(arrays(np.float64, st.tuples(st.integers(3, 14), st.just(2)), elements=lattice))
def test_small_sets_are_the_perturbed_triangulation(points):
    if not naive_delaunay.delaunay_cells(points):
        with pytest.raises(InvalidGeometry):
            delaunay_2d(points)
        return
    assert as_set(delaunay_2d(points).mesh) == naive_delaunay.delaunay_cells(points)


@settings(max_examples=40)
@given(arrays(np.float64, st.tuples(st.integers(3, 20), st.just(2)), elements=st.floats(-1, 1)))
def test_any_points_are_delaunay(points):
    try:
        mesh = delaunay_2d(points).mesh.compacted()
    except InvalidGeometry:
        different = np.unique(points + 0.0, axis=0)
        a, b = different[0], different[-1]
        assert all(naive.side(a, b, c) == 0 for c in different)
        return
    except InvalidInput as error:
        assert "too far apart" in str(error)
        return
    invariants.assert_is_triangulation(mesh)
    assert naive.delaunay_circles_are_empty(mesh.points[:, :2].tolist(), cells(mesh))


@each_cloud
def test_hard_clouds(name):
    points = CLOUDS[name]
    mesh, report = delaunay_2d(points)
    used = mesh.compacted()
    invariants.assert_is_triangulation(used)
    assert naive.not_locally_delaunay(used.points[:, :2].tolist(), cells(used), []) == []
    assert invariants.euler(used) == 1
    assert_outline_is_convex(used)
    assert report.counts["points"] == len(points) and report.counts["triangles"] == mesh.n_cells
    assert report.counts["duplicates"] == len(points) - len(np.unique(points, axis=0)) == len(points) - used.n_points
    assert bool(report.warnings) == bool(report.counts["duplicates"])


@each_cloud
def test_the_cells_do_not_depend_on_threads_nor_on_the_way_there(name, monkeypatch):
    points = CLOUDS[name]
    expected = cells(delaunay_2d(points, threads=1).mesh)
    monkeypatch.setattr(module, "_POINTS_A_THREAD", 100)
    for threads in (2, 3, 7):
        assert cells(delaunay_2d(points, threads=threads).mesh) == expected
    growing = Triangulation.from_points(points[:50])
    for part in np.array_split(points[50:], [1, 2, 300, 301, 900]):
        growing.add(part)
    mesh = growing.mesh()
    assert (mesh.points[:, :2] == points).all() and cells(mesh) == expected
    monkeypatch.setattr(module, "_POINTS_IN_PLACE", 0)
    copied = Triangulation.from_points(points[:50])
    copied.add(points[50:])
    assert cells(copied.mesh()) == expected


def test_points_near_a_line_are_inserted_along_it():
    x = np.random.default_rng(12).random(4000)
    steps = []
    for n in (1000, 4000):
        points = np.column_stack([x[:n], 0.3 * x[:n] + 0.1])
        order, thin = planar_order(points)
        assert thin and order.rows.tolist() == np.argsort(x[:n]).tolist()
        state = steps_of(points)
        steps.append(state / n)
    assert max(steps) < 12 and steps[1] < 1.2 * steps[0]
    assert not planar_order(CLOUDS["uniform"])[1] and not planar_order(CLOUDS["two lines"])[1]


def steps_of(points):
    """How many triangles insertion looks at."""
    made = []
    step = point_insertion.Insertion.step

    class Counting(point_insertion.Insertion):
        def step(self):
            more = step(self)
            made.append(int(self.state[point_insertion.kernels.STEPS]))
            return more

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(point_insertion, "Insertion", Counting)
        delaunay_2d(points, threads=1)
    return max(made)


def test_shuffled_points_without_ties_give_the_same_triangles():
    points = CLOUDS["uniform"]
    shuffle = np.random.default_rng(3).permutation(len(points))
    shuffled = delaunay_2d(points[shuffle]).mesh
    assert {tuple(sorted(shuffle[list(c)])) for c in cells(shuffled)} == as_set(delaunay_2d(points).mesh)
    assert as_set(delaunay_2d(points).mesh) == {tuple(sorted(t)) for t in Delaunay(points).simplices.tolist()}


def test_cells_are_canonical():
    """By the places of the corners along the curve: the lowest first, then the second; each cell is near the last."""
    points = CLOUDS["uniform"]
    place = np.empty(len(points), int)
    place[module.insertion_order(points, 2, rounds=False).rows] = np.arange(len(points))
    corners = place[delaunay_2d(points).mesh.cells["triangle"]]
    assert (corners.argmin(axis=1) == 0).all()
    keys = [tuple(c) for c in corners[:, :2].tolist()]
    assert keys == sorted(keys) and len(set(keys)) == len(keys)


@pytest.mark.parametrize("hub", [0, 3001])
def test_the_fan_of_a_hub(hub):
    x = np.linspace(-1, 1, 3001)
    arc = np.column_stack([x, 0.01 * x**2])
    fan = delaunay_2d(np.insert(arc, hub, [0.0, 50.0], axis=0)).mesh.cells["triangle"]
    first = np.delete(np.arange(3002), hub)[:-1]
    expected = np.column_stack([first, first + 1, np.full(3000, hub)])
    assert {frozenset(t) for t in fan.tolist()} == {frozenset(t) for t in expected.tolist()}


@pytest.mark.parametrize("scale", [1e-300, 1e-8, 1e8, 1e300])
def test_any_scale_gives_the_same_cells(scale):
    points = np.random.default_rng(4).integers(0, 2**20, (300, 2)).astype(float)
    power = 2.0 ** np.round(np.log2(scale))
    assert cells(delaunay_2d(points * power).mesh) == cells(delaunay_2d(points).mesh)


def test_far_from_the_origin():
    points = 1e8 + np.random.default_rng(5).integers(0, 50, (400, 2)) * 2.0**-20
    invariants.assert_is_triangulation(delaunay_2d(points).mesh.compacted())


@settings(max_examples=50, deadline=None)
@given(
    arrays(np.float64, st.tuples(st.integers(4, 14), st.just(2)), elements=lattice),
    arrays(np.float64, st.tuples(st.integers(1, 10), st.just(2)), elements=st.integers(-2, 12).map(lambda k: k / 2)),
    st.integers(3, 14),
)
def test_adding_and_locating_agree_with_the_twins(points, queries, first):
    try:
        growing = Triangulation.from_points(points[:first])
    except InvalidGeometry:
        return
    growing.add(points[first:])
    mesh = growing.mesh()
    assert cells(mesh) == cells(delaunay_2d(points).mesh)
    assert dict(zip(growing.merged.tolist(), growing.kept.tolist(), strict=True)) == {
        row: kept for row, kept in enumerate(naive.first_of_equal(points)) if row != kept
    }
    cell, weights = growing.locate(queries)
    by_tree = locate(mesh, queries)
    assert cell.tolist() == by_tree.cell.tolist()
    inside = cell >= 0
    assert np.isnan(weights[~inside]).all() and (weights[inside] >= 0).all()
    np.testing.assert_allclose(weights[inside].sum(axis=1), 1, rtol=1e-15)
    corners = mesh.points[mesh.cells["triangle"][cell[inside]], :2]
    np.testing.assert_allclose(np.einsum("kc,kcx->kx", weights[inside], corners), queries[inside], atol=1e-13)


def test_each_point_has_a_vertex_whenever_it_came():
    mesh = Triangulation.from_points([[0, 0], [1, 0], [1, 1], [0, 1], [1, 0]])
    mesh.add([[0, 0], [0.5, 0.5], [0.5, 0.5]])
    assert len(mesh.vertex_of) == mesh.n_points == 8
    assert (mesh.xy.reshape(-1, 2)[mesh.vertex_of] == mesh.points[:, :2]).all()
    assert mesh.merged.tolist() == [4, 5, 7] and mesh.kept.tolist() == [1, 0, 6]


def test_vertices_and_odd_places_are_located():
    points = CLOUDS["clumps"]
    mesh = Triangulation.from_points(points)
    cell, weights = mesh.locate(points)
    corners = mesh.mesh().cells["triangle"][cell]
    assert (weights.max(axis=1) == 1).all()
    assert (corners[weights == 1] == np.arange(len(points))).all()
    owners = np.full(len(points), mesh.mesh().n_cells)
    np.minimum.at(owners, mesh.mesh().cells["triangle"], np.arange(mesh.mesh().n_cells)[:, None])
    assert (cell == owners).all()
    assert mesh.locate([[1e308, 0], [0, -1e308], [1e-320, 5.0]]).cell.tolist() == [-1, -1, -1]
    assert mesh.locate(np.empty((0, 2))).cell.tolist() == []
    with pytest.raises(InvalidGeometry):
        mesh.locate([[np.nan, 0]])


def test_a_mesh_gives_its_points_and_2d_and_3d_arrays_are_the_same():
    points = np.random.default_rng(6).random((50, 2))
    flat = np.column_stack([points, np.zeros(50)])
    expected = cells(delaunay_2d(points).mesh)
    assert cells(delaunay_2d(flat).mesh) == cells(delaunay_2d(Mesh(points, {"line": [[0, 1]]})).mesh) == expected


def test_merged_points_are_named():
    report = delaunay_2d([[0, 0], [1, 0], [0, 0.0], [0, 1], [-0.0, 0]]).report
    assert report.counts == {"points": 5, "triangles": 1, "duplicates": 2}
    assert report.warnings == ["2 points lie where another does and have no triangles: 2 at 0, 4 at 0"]


@pytest.mark.parametrize("threads", [1, 2])
def test_cancelling(threads, monkeypatch):
    monkeypatch.setattr(module, "_POINTS_A_THREAD", 100)
    monkeypatch.setattr(point_insertion, "_STEPS_A_CHUNK", 1000)
    points = np.random.default_rng(8).random((30_000, 2))
    seen = []

    def stop_late(fraction, message):
        seen.append(fraction)
        return fraction < 0.25

    with pytest.raises(Cancelled):
        delaunay_2d(points, threads=threads, progress=stop_late)
    assert seen == sorted(seen)
    mesh = Triangulation.from_points(points[:1000])
    before = cells(mesh.mesh())
    with pytest.raises(Cancelled):
        mesh.add(points[1000:], progress=stop_late)
    assert cells(mesh.mesh()) == before and mesh.n_points == 1000
    mesh.add(points[1000:])
    assert cells(mesh.mesh()) == cells(delaunay_2d(points).mesh)


@pytest.mark.parametrize("where", ["step", "_replace_by"])
def test_an_interrupt_while_points_are_added_in_place(where, monkeypatch):
    points = np.random.default_rng(12).random((3000, 2))
    mesh = Triangulation.from_points(points[:1000])
    mesh.add(points[1000:1010])  # makes room
    before = cells(mesh.mesh())
    with monkeypatch.context() as patched:
        patched.setattr(point_insertion, "_STEPS_A_CHUNK", 1000)
        owner = Triangulation if where == "_replace_by" else point_insertion.Insertion
        whole, calls = getattr(owner, where), []

        def interrupted(*given):
            if len(calls) == 3 or where == "_replace_by":
                raise KeyboardInterrupt
            calls.append(1)
            return whole(*given)

        patched.setattr(owner, where, interrupted)
        with pytest.raises(KeyboardInterrupt):
            mesh.add(points[1010:1400])
    assert cells(mesh.mesh()) == before and mesh.n_points == 1010
    assert (mesh.locate(points[1010:1100]).cell >= -1).all()
    mesh.add(points[1010:])
    assert cells(mesh.mesh()) == cells(delaunay_2d(points).mesh)


def test_what_the_caller_does_to_his_points_later_does_not_matter():
    points = np.zeros((300, 3))
    points[:, :2] = np.random.default_rng(13).random((300, 2))
    given = points[:200].copy()
    mesh = Triangulation.from_points(given)
    given[:] = np.nan
    mesh.points[:] = np.nan
    more = points[200:].copy()
    mesh.add(more)
    more[:] = np.nan
    assert (mesh.mesh().points == points).all()
    assert cells(mesh.mesh()) == cells(delaunay_2d(points).mesh)


def hub_above_an_arc(n):
    x = np.linspace(-1, 1, n)
    return np.concatenate([[[0.0, 50.0]], np.column_stack([x, 0.01 * x**2])])


def hub_below_a_strip(n):
    x = np.random.default_rng(14).random(n)
    return np.concatenate([[[0.5, -10.0]], np.column_stack([x, 0.01 * x * (1 - x)])])


@pytest.mark.parametrize("made", [hub_above_an_arc, hub_below_a_strip])
def test_the_fan_of_a_hub_takes_no_more_steps_on_threads(made, monkeypatch):
    points, steps = made(20_000), []
    monkeypatch.setattr(module, "_POINTS_A_THREAD", 100)
    whole = point_insertion.Insertion.step

    def counted(insertion):
        before = insertion.state[point_insertion.kernels.STEPS]
        more = whole(insertion)
        steps[-1] += insertion.state[point_insertion.kernels.STEPS] - before
        return more

    monkeypatch.setattr(point_insertion.Insertion, "step", counted)
    for threads in (1, 2, 3):
        steps.append(0)
        delaunay_2d(points, threads=threads)
    assert max(steps) < 1.5 * steps[0]


def test_memory_a_point():
    n = 100_000
    points = np.random.default_rng(9).random((n, 2))
    delaunay_2d(points[:100])
    tracemalloc.start()
    try:
        delaunay_2d(points, threads=1)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak / n < 150


@pytest.mark.parametrize(
    "points, message",
    [
        (np.empty((0, 2)), "three different points, got 0"),
        ([[0, 0], [1, 1]], "three different points, got 2"),
        ([[0, 0], [1, 1], [0, 0]], "three different points, got 2"),
        (np.zeros((1000, 2)), "three different points, got 1"),
        ([[0, 0], [1, 1], [2, 2], [3, 3]], "one line"),
        (np.column_stack([np.arange(5000.0), np.arange(5000.0)]), "one line"),
        ([[0, 0, 0], [1, 0, 2], [0, 1, 0]], "z = 0"),
        ([[0, 0], [1, np.nan], [0, 1]], "not finite"),
        ([[0, 0], [1, np.inf], [0, 1]], "not finite"),
        ([[0, 0], [1e300, 1], [1e-300, 1]], "too far apart"),
        ([[0, 1, 2, 3]], "shape"),
        ("points", "numbers"),
    ],
)
def test_bad_points_are_refused(points, message):
    with pytest.raises(InvalidInput, match=message):
        delaunay_2d(points)
    mesh = Triangulation.from_points([[0, 0], [1, 0], [0, 1]])
    if "line" not in message and "three" not in message:
        with pytest.raises(InvalidInput, match=message):
            mesh.add(points)
    assert mesh.n_points == 3


@pytest.mark.parametrize("threads", [0, -1, 1.5, "two", True])
def test_bad_numbers_of_threads_are_refused(threads):
    with pytest.raises(InvalidInput, match="threads"):
        delaunay_2d([[0, 0], [1, 0], [0, 1]], threads=threads)


def test_too_many_points_are_refused_before_anything_is_done(monkeypatch):
    monkeypatch.setattr(module, "MAX_POINTS", 3)
    with pytest.raises(InvalidInput, match="too many"):
        delaunay_2d(np.random.default_rng(1).random((4, 2)))
