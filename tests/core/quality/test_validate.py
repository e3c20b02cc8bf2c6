"""Each check of `validate` on a mesh that has just that fault, and on meshes that have none."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from meshcore import GenerationFailed, InvalidInput, Mesh, StructuredGrid, gallery, quality

SQUARE = gallery.triangulated_square(4)


def names(mesh, boundary=None):
    return [fault.name for fault in quality.validate(mesh, boundary, raise_=False)]


def delaunay(seed, count=60):
    points = np.random.default_rng(seed).random((count, 2))
    return Mesh(points, {"triangle": Delaunay(points).simplices.astype(np.int64)}).compacted()


def rotated(mesh, seed):
    """The mesh in a tilted plane, away from the origin."""
    turn, _ = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))
    return mesh.with_points(mesh.points @ turn.T + [1.0, 2.0, 3.0])


def joined(*meshes):
    """Meshes of triangles side by side, as one."""
    starts = np.cumsum([0] + [m.n_points for m in meshes])
    cells = [m.get("triangle") + start for m, start in zip(meshes, starts, strict=False)]
    return Mesh(np.concatenate([m.points for m in meshes]), {"triangle": np.concatenate(cells)})


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 10**6))
def test_delaunay_meshes_are_valid_in_any_plane(seed):
    mesh = delaunay(seed)
    assert names(mesh) == []
    assert names(mesh, mesh.boundary) == []
    assert names(rotated(mesh, seed)) == []


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 10**6), st.data())
def test_one_turned_cell_is_found(seed, data):
    mesh = delaunay(seed)
    cell = data.draw(st.integers(0, mesh.n_cells - 1))
    flip = np.arange(mesh.n_cells) == cell
    with pytest.raises(GenerationFailed, match="1 cell is not positively oriented") as error:
        quality.validate(mesh.reoriented(flip))
    assert cell in error.value.cells
    assert error.value.partial.n_cells == mesh.n_cells


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 10**6), st.data())
def test_one_point_across_is_found(seed, data):
    """A point moved to the far side of an edge folds the cells around it."""
    mesh = delaunay(seed)
    inner = np.setdiff1d(np.arange(mesh.n_points), mesh.boundary.get("line"))
    point = data.draw(st.sampled_from(inner.tolist()))
    points = mesh.points.copy()
    points[point] += [2.0, 0.0, 0.0]
    assert "orientation" in names(mesh.with_points(points))


def test_a_cell_without_area_is_found_exactly():
    flat = Mesh([[0, 0], [0.1, 0.1], [0.3, 0.3]], {"triangle": [[0, 1, 2]]})  # collinear in floats, too
    assert names(flat) == ["orientation"]
    thin = Mesh([[0, 0], [1, 1], [2, 2 + 2**-51]], {"triangle": [[0, 1, 2]]})
    assert names(thin) == []
    assert names(thin.reoriented()) == ["orientation"]


def test_quads_must_be_convex():
    dart = Mesh([[0, 0], [2, 1], [0, 2], [0.5, 1]], {"quad": [[0, 1, 2, 3]]})
    assert names(dart) == ["orientation"]
    bow = Mesh([[0, 0], [1, 1], [1, 0], [0, 1]], {"quad": [[0, 1, 2, 3]]})
    assert names(bow) == ["orientation"]


@pytest.mark.parametrize("kind", ["tetra", "hexahedron", "wedge", "pyramid"])
def test_solids_and_their_mirror_images(kind):
    from tests.core.quality.test_verdict import IDEAL

    mesh = Mesh(IDEAL[kind], {kind: [np.arange(len(IDEAL[kind]))]})
    assert names(mesh) == []
    assert names(mesh.reoriented()) == ["orientation"]
    assert quality.measure(mesh, "volume")[0] > 0


def test_flat_tetrahedron_is_found_exactly():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.1, 0.2, 0]])
    assert names(Mesh(points, {"tetra": [[0, 1, 2, 3]]})) == ["orientation"]
    points[3, 2] = 1e-300
    assert names(Mesh(points[:, [0, 1, 2]], {"tetra": [[0, 1, 2, 3]]})) != ["conformity"]


def test_three_cells_at_one_edge():
    fan = Mesh(
        [[0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, -1, 0]], {"triangle": [[0, 1, 2], [1, 0, 3], [0, 1, 4]]}
    )
    faults = quality.validate(fan, raise_=False)
    assert "conformity" in [f.name for f in faults]
    assert "more than two cells" in str(faults[0])


def test_neighbours_on_a_surface_that_turn_the_same_way():
    tent = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 1], [1, -1, 1]], {"triangle": [[0, 1, 2], [0, 1, 3]]})
    assert names(tent) == ["conformity"]
    assert names(tent.reoriented(np.array([False, True]))) == []


def test_solid_neighbours_that_overlap_at_a_face():
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.2, 0.2, 2], [0, 0, -1]]
    good = Mesh(points[:4] + points[5:], {"tetra": [[0, 1, 2, 3], [0, 2, 1, 4]]})
    assert names(good) == []
    same_side = Mesh(points[:5], {"tetra": [[0, 1, 2, 3], [0, 1, 2, 4]]})
    assert names(same_side) == ["conformity"]


def test_orphans_duplicates_and_repeats():
    lonely = Mesh(np.concatenate([SQUARE.points, [[5.0, 5.0, 0.0]]]), SQUARE.cells)
    assert names(lonely) == ["orphan points"]
    assert "orphan points" not in names(Mesh(lonely.points, {**SQUARE.cells, "vertex": [[SQUARE.n_points]]}))
    apart = joined(SQUARE.selected(np.arange(16)), SQUARE.selected(np.arange(16, 32)))
    assert "duplicate points" in names(apart)
    twice = Mesh(SQUARE.points, {"triangle": np.concatenate([SQUARE.get("triangle"), SQUARE.get("triangle")[:1]])})
    assert {"repeated cells", "conformity"} <= set(names(twice))
    pillow = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 1]], {"triangle": [[0, 1, 2], [0, 2, 1]]})
    assert "repeated cells" in names(pillow)


def test_zero_and_minus_zero_are_one_place():
    mesh = Mesh([[0.0, 0], [1, 0], [0, 1], [-0.0, -0.0], [-1, 0], [0, -1]], {"triangle": [[0, 1, 2], [3, 4, 5]]})
    assert "duplicate points" in names(mesh)


def test_nothing_at_all():
    assert names(Mesh(np.empty((0, 3)), {})) == ["empty"]
    with pytest.raises(GenerationFailed, match="no cells"):
        quality.validate(Mesh([[0, 0]], {"triangle": np.empty((0, 3), int)}))


def test_hanging_node():
    points = [[0, 0], [2, 0], [1, 1], [1, 0], [1, -1]]
    mesh = Mesh(points, {"triangle": [[0, 1, 2], [0, 4, 3], [3, 4, 1]]})
    faults = quality.validate(mesh, raise_=False)
    assert [f.name for f in faults] == ["hanging nodes"]
    assert faults[0].points.tolist() == [3]
    assert 0 in faults[0].cells.tolist()
    assert names(rotated(mesh, 8)) == ["hanging nodes"]


def test_several_points_hanging_on_one_edge():
    inner = [[0.1, 0.1], [0.9, 0.1], [0.1, 0.9]]
    mesh = Mesh([[0, 0], [1, 0], [0, 1], *inner], {"triangle": [[0, 1, 2], [3, 4, 5]]})
    (fault,) = quality.validate(mesh, raise_=False)
    assert fault.name == "hanging nodes" and fault.points.tolist() == [4, 5] and fault.cells.tolist() == [0]


def test_crossing_parts():
    one = Mesh([[0, 0], [2, 0], [1, 2]], {"triangle": [[0, 1, 2]]})
    two = one.with_points(one.points + [0.9, 0.5, 0.0])
    assert names(joined(one, two)) == ["overlap"]
    assert names(joined(one, one.with_points(one.points + [3, 0, 0]))) == []


def test_one_part_inside_another():
    """No edges cross: only the degree of the covering tells."""
    small = SQUARE.with_points(0.1 * SQUARE.points + [0.41, 0.43, 0.0])
    assert names(joined(SQUARE, small)) == ["overlap"]


def test_a_spiral_that_covers_the_plane_twice():
    """Positive cells and matching edges all the way: a strip that winds around by 1.5 turns."""
    angle = np.linspace(0, 2.9 * np.pi, 40)
    inner, outer = (np.column_stack([r * np.cos(angle), r * np.sin(angle)]) for r in (1.0, 2.0))
    k = np.arange(39)
    lower = np.column_stack([k, k + 40, k + 41])
    strip = Mesh(
        np.concatenate([inner, outer]), {"triangle": np.concatenate([lower, np.column_stack([k, k + 41, k + 1])])}
    )
    assert "overlap" in names(strip)
    once = strip.selected(np.concatenate([k < 24, k < 24]))
    assert names(once) == []


def test_parts_that_touch_at_a_point_are_fine():
    mesh = Mesh([[0, 0], [1, 0], [1, 1], [-1, 0], [-1, -1]], {"triangle": [[0, 1, 2], [0, 3, 4]]})
    assert names(mesh) == []


def test_holes_and_islands_are_fine():
    ring = SQUARE.selected(np.linalg.norm(SQUARE.centroids[:, :2] - 0.5, axis=1) > 0.2)
    assert names(ring) == []
    island = SQUARE.with_points(0.05 * SQUARE.points + [0.475, 0.475, 0.0])
    assert names(joined(ring, island)) == []


def test_boundary_kept_split_or_lost():
    assert names(SQUARE, gallery.square(4)) == []
    assert names(SQUARE, gallery.square(1)) == []  # each side is four edges in a row
    diagonal = Mesh([[0, 0], [1, 1]], {"line": [[0, 1]]})
    assert names(SQUARE, diagonal) == []
    other = Mesh([[0, 1], [1, 0]], {"line": [[0, 1]]})
    faults = quality.validate(SQUARE, other, raise_=False)
    assert [f.name for f in faults] == ["boundary"]
    assert "line 0 from (0, 1, 0) to (1, 0, 0)" in str(faults[0])
    absent = Mesh([[0, 0], [0.123, 0]], {"line": [[0, 1]]})
    assert names(SQUARE, absent) == ["boundary"]
    with pytest.raises(InvalidInput, match="needs line cells"):
        quality.validate(SQUARE, SQUARE)


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10**6), st.integers(1, 6))
def test_lines_are_followed_through_their_split_points(seed, parts):
    """Straight chords of random direction, cut at rounded places."""
    random = np.random.default_rng(seed)
    a, b = random.random((2, 2)) + [[0, 0], [1, 1]]
    t = np.sort(random.random(parts - 1))
    chain = np.concatenate([[a], a + t[:, None] * (b - a), [b]])
    side = np.array([[a[0] - 1, a[1] + 1.5], [a[0] + 1.5, a[1] - 1]])
    points = np.concatenate([chain, side])
    k, n = np.arange(parts), parts + 1
    left = np.column_stack([k, k + 1, np.full(parts, n)])
    right = np.column_stack([k + 1, k, np.full(parts, n + 1)])
    mesh = Mesh(points, {"triangle": np.concatenate([left, right])})
    line = Mesh([a, b], {"line": [[0, 1]]})
    assert "boundary" not in names(mesh, line)
    assert "boundary" in names(mesh.selected(np.arange(mesh.n_cells) % parts != parts // 2), line)


def test_many_random_triangles_against_a_plain_search():
    """Overlap of two triangles, against a test of all pairs of their edges and corners."""

    def inside(p, t):
        signs = [np.linalg.det([t[k] - p, t[(k + 1) % 3] - p]) for k in range(3)]
        return min(signs) > 0

    def cross(p, q, r, s):
        def side(a, b, c):
            return np.linalg.det([b - a, c - a])

        return side(p, q, r) * side(p, q, s) < 0 and side(r, s, p) * side(r, s, q) < 0

    random = np.random.default_rng(77)
    seen = set()
    for _ in range(150):
        a, b = random.random((2, 3, 2)) + [[[0, 0]], [random.random(2)]]
        a, b = (t if np.linalg.det([t[1] - t[0], t[2] - t[0]]) > 0 else t[::-1] for t in (a, b))
        expected = inside(a[0], b) or inside(b[0], a)
        expected |= any(cross(a[i], a[i - 1], b[j], b[j - 1]) for i in range(3) for j in range(3))
        found = names(Mesh(np.concatenate([a, b]), {"triangle": [[0, 1, 2], [3, 4, 5]]}))
        assert found == (["overlap"] if expected else [])
        seen.add(bool(expected))
    assert seen == {True, False}


def test_structured_grids_may_have_cuts():
    t = np.linspace(0, 2 * np.pi, 17)
    ring = np.stack([np.outer([1, 2, 3], np.cos(t)), np.outer([1, 2, 3], np.sin(t))], axis=-1)
    assert quality.validate(StructuredGrid(ring)) == []
    with pytest.raises(GenerationFailed, match="32 cells are not positively oriented"):
        quality.validate(StructuredGrid(ring[::-1]))


def test_lines_alone():
    assert names(gallery.square_with_hole()) == []
    star = Mesh([[0, 0], [1, 0], [0, 1], [-1, 0]], {"line": [[0, 1], [0, 2], [0, 3]]})
    assert names(star) == []
    assert names(Mesh([[0, 0], [1, 0]], {"line": [[0, 1], [1, 0]]})) == ["repeated cells"]
    assert names(Mesh([[0, 0], [0, 0], [1, 1]], {"line": [[0, 1], [1, 2]]})) == ["orientation", "duplicate points"]


def test_several_faults_in_one_message():
    bad = Mesh(np.concatenate([SQUARE.points, [[7, 7, 0]]]), SQUARE.cells).reoriented(np.arange(32) == 9)
    with pytest.raises(GenerationFailed) as error:
        quality.validate(bad)
    assert "cell 9" in str(error.value)
    assert "point 25 at (7, 7, 0)" in str(error.value)
    assert 9 in error.value.cells
