"""Constrained triangulation: lines kept, loops nested, dirty lines cleaned."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from meshcore import InvalidGeometry, InvalidInput, Mesh, delaunay_refinement
from meshcore.gallery import circle, joined, square
from meshcore.unstructured import _constrained_kernels as kernels
from meshcore.unstructured import _half_edge_kernels as half_edges
from meshcore.unstructured.planar_graph import planar_graph
from meshcore.unstructured.triangulation import triangulated
from tests import naive
from tests.core.unstructured import invariants
from tests.core.unstructured.planar_graphs import comb, frame_mesh, framed_segments, loop_lines, loops, star_polygons


def constrained(boundary, **keywords):
    return delaunay_refinement(boundary, min_angle=0, **keywords).mesh


@settings(max_examples=60)
@given(framed_segments())
@example(frame_mesh(8, [((2, 2), (6, 6)), ((4, 4), (6, 2))]))  # a line that touches another in its middle
@example(frame_mesh(8, [((1, 4), (5, 4)), ((3, 4), (7, 4))]))  # two lines that overlap
def test_random_segments_are_kept(boundary):
    mesh = constrained(boundary, holes=[[-1, -1]])
    invariants.assert_is_triangulation(mesh)
    invariants.assert_constrained_delaunay(mesh, boundary)
    assert invariants.area(mesh) == 64
    given_points = {tuple(p) for p in boundary.points.tolist()}
    assert {tuple(p) for p in mesh.points.tolist()} == given_points
    assert invariants.euler(mesh) == 1


def crossings_noted(graph, size):
    """Rows that `insert_segments` notes with buffers that begin at a size, and how often these were full."""
    mesh = triangulated(graph.points)
    segments = np.empty(graph.segments.shape, np.int32)
    vertex, vertex_edge = np.empty(mesh.n_points, np.int32), np.empty(len(mesh.order) + 1, np.int32)
    piece_of = np.empty(len(mesh.origin), np.int32)
    kernels.prepare(
        mesh.xy, mesh.order, mesh.merged, mesh.kept, mesh.origin, mesh.twin, mesh.n_triangles, graph.segments, vertex,
        segments, vertex_edge, piece_of,
    )  # fmt: skip
    pieces, state = np.empty((999, 3), np.int32), np.zeros(kernels.STATE_SIZE, np.int64)
    crossed, places = np.empty((999, 2), np.int32), np.empty((999, 2))
    state[kernels.FROM] = -1
    times_full = -1
    status = half_edges.FULL
    while status == half_edges.FULL:
        times_full += 1
        buffers = (np.empty((2 * size, 4), np.int32), np.empty(size, np.int32), np.empty((2 * size, 2), np.int32))
        status = kernels.insert_segments(
            mesh.xy, mesh.order, mesh.origin, mesh.twin, piece_of, vertex_edge, segments, pieces, crossed, places,
            *buffers, np.empty(8 * 999, np.int32), mesh.scratch.work, 0.0, state, 10**9,
        )  # fmt: skip
        size *= 2
    assert status == half_edges.DONE
    return crossed[: state[kernels.CROSSED]].tolist(), times_full


def test_what_a_full_buffer_stops_leaves_no_crossing():
    """A long line across a short one near its start, and then across a hundred triangles."""
    points = np.random.default_rng(5).random((400, 2)) + [0.0, 0.5]
    ends = [[-1.0, 1.0], [2.0, 1.0], [-0.5, 0.9], [-0.5, 1.1]]
    graph = planar_graph(
        np.concatenate([ends, points]), np.array([[2, 3], [0, 1]]), np.arange(len(points) + 4), "boundary"
    )
    wanted, times_full = crossings_noted(graph, 4096)
    assert len(wanted) == 1 and times_full == 0
    found, times_full = crossings_noted(graph, 16)
    assert times_full > 1
    assert found == wanted


@settings(max_examples=40)
@given(star_polygons(), st.integers(-30, 30))
def test_star_polygons_keep_their_area(polygon, exponent):
    boundary = loops(np.ldexp(polygon, exponent))
    mesh = constrained(boundary)
    invariants.assert_is_triangulation(mesh)
    invariants.assert_constrained_delaunay(mesh, boundary)
    assert invariants.area(mesh) == invariants.shoelace(np.ldexp(polygon, exponent).tolist())
    assert mesh.n_cells == len(polygon) - 2
    assert (mesh.points == boundary.points).all()


def test_a_comb_of_deep_gaps():
    polygon = comb(40, 1000.0)
    boundary = loops(polygon)
    mesh = constrained(boundary)
    invariants.assert_constrained_delaunay(mesh, boundary)
    assert invariants.area(mesh) == invariants.shoelace(polygon.tolist())


@settings(max_examples=30)
@given(st.lists(st.sampled_from([0, 1, 2]), min_size=1, max_size=4), st.integers(0, 3))
def test_loops_nest_by_even_odd(depths, turn):
    rings, centres = [], []
    for k, depth in enumerate(depths):  # towers of nested squares, side by side
        for level in range(depth + 1):
            h = 4.0 - level
            ring = np.array([[-h, -h], [h, -h], [h, h], [-h, h]]) + [10.0 * k, 0]
            rings.append(np.roll(ring, turn, axis=0)[:: 1 if (level + turn) % 2 else -1])
        centres.append(10.0 * k)
    mesh = constrained(loops(*rings))
    invariants.assert_is_triangulation(mesh)
    for centre in mesh.centroids.tolist():
        assert naive.is_inside([r.tolist() for r in rings], *centre[:2])
    expected = sum(sum((-1) ** level * 4 * (4 - level) ** 2 for level in range(d + 1)) for d in depths)
    assert invariants.area(mesh) == expected
    parts_minus_holes = sum(1 - (d >= 1) + (d >= 2) for d in depths)
    assert invariants.euler(mesh) == parts_minus_holes
    assert len(np.unique(mesh.cell_data["region"])) == sum(1 + (d >= 2) for d in depths)


def test_a_hole_may_touch_the_outline_in_a_point():
    boundary = loops([(0, 0), (4, 0), (4, 4), (0, 4)], [(0, 0), (2, 1), (1, 2)])
    mesh = constrained(boundary)
    assert invariants.area(mesh) == 16 - 1.5


def test_partitions_do_not_make_holes():
    """A three by three grid of lines: the middle is two lines away from the outside, but no hole."""
    segments = [((k, 0), (k, 9)) for k in (3, 6)] + [((0, k), (9, k)) for k in (3, 6)]
    boundary = frame_mesh(9, segments)
    mesh = constrained(boundary, crossings="split")
    assert invariants.area(mesh) == 81
    assert sorted(np.unique(mesh.cell_data["region"])) == list(range(1, 10))


def test_a_hole_inside_a_partitioned_outline():
    boundary = frame_mesh(8, [((4, 0), (4, 8))])
    hole = square(size=1.0).transformed(np.array([[1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 0], [0, 0, 0, 1]], float))
    mesh = constrained(joined(boundary, hole))
    assert invariants.area(mesh) == 63
    assert invariants.euler(mesh) == 0


def test_dangling_lines_and_single_points_are_kept():
    boundary = frame_mesh(8, [((2, 2), (5, 3))], [(6, 6)])
    mesh = constrained(boundary)
    invariants.lines_as_edges(mesh, boundary)
    assert mesh.n_points == 7 and invariants.area(mesh) == 64


def test_hole_points_replace_nesting():
    boundary = joined(square(size=9.0), circle(12, radius=1.0, centre=(3, 3)), circle(12, radius=1.0, centre=(6, 6)))
    disc = invariants.shoelace(circle(12).points[:, :2].tolist())
    mesh = constrained(boundary, holes=[[3, 3]])
    assert float(invariants.area(mesh)) == pytest.approx(81 - float(disc), rel=1e-12)
    assert constrained(Mesh(boundary.points, boundary.cells, field_data={"holes": [[3, 3]]})).n_cells == mesh.n_cells


def test_regions_are_tagged_and_meshed():
    boundary = joined(square(size=9.0), circle(12, radius=1.0, centre=(3, 3)), circle(12, radius=1.0, centre=(6, 6)))
    mesh = constrained(boundary, regions=[[1, 1, 7], [3, 3, 9]])
    where = np.hypot(*(mesh.centroids[:, :2] - 3).T) < 1
    assert (mesh.cell_data["region"][where] == 9).all() and (mesh.cell_data["region"][~where] == 7).all()
    assert not (np.hypot(*(mesh.centroids[:, :2] - 6).T) < 0.9).any()


def test_region_areas_bound_their_triangles():
    boundary = frame_mesh(8, [((4, 0), (4, 8))])
    mesh, _ = delaunay_refinement(boundary, regions=[[1, 1, 1, 0.5], [5, 5, 2, -1]])
    tag = mesh.cell_data["region"]
    p = mesh.points[mesh.cells["triangle"]]
    areas = 0.5 * np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])[:, 2]
    assert areas[tag == 1].max() <= 0.5 < areas[tag == 2].max()


def test_repeated_points_and_lines_are_merged_and_told():
    corners = np.array([(0, 0), (1, 0), (1, 0), (1, 1), (0, 1), (0, 0), (1e-17, 1)], float)
    boundary = Mesh(corners, {"line": [(0, 1), (2, 3), (3, 4), (6, 5), (1, 0), (1, 2)]})
    mesh, report = delaunay_refinement(boundary, min_angle=0)
    assert invariants.area(mesh) == 1 and mesh.n_points == 4
    assert (mesh.points == boundary.points[[0, 1, 3, 4]]).all()
    said = " ".join(report.warnings)
    assert "3 points" in said and "1 lines without length" in said and "1 lines that repeat" in said


def test_a_point_almost_on_a_line_splits_it():
    """A junction computed in floating point misses its line by rounding; it must not leak."""
    a, b = np.array([0.1, 0.2]), np.array([7.3, 3.9])
    boundary = loops([(0, 0), (10, 0), (10, 10), (0, 10)])
    for share in np.linspace(0.05, 0.95, 19):
        p = a + share * (b - a)
        points = np.concatenate([boundary.points[:, :2], [a, b, p, (5.0, 9.0)]])
        mesh = constrained(Mesh(points, {"line": [*boundary.get("line").tolist(), (4, 5), (6, 7)]}))
        edges = {tuple(e) for e in mesh.edges.tolist()}
        assert {(4, 6), (5, 6), (6, 7)} <= edges


def test_crossing_lines_are_refused_with_their_places():
    boundary = frame_mesh(8, [((1, 1), (5, 5)), ((1, 5), (5, 1)), ((6, 6), (7, 7))])
    with pytest.raises(InvalidGeometry, match=r"line 4 and line 5 cross at \(3, 3\)") as caught:
        constrained(boundary)
    assert caught.value.cells == (4, 5) and set(caught.value.points) == {4, 5, 6, 7}


@settings(max_examples=40)
@given(st.lists(st.tuples(*[st.integers(1, 11)] * 4), min_size=1, max_size=8))
def test_crossing_lines_are_split(quads):
    segments = [((a, b), (c, d)) for a, b, c, d in quads if (a, b) != (c, d)]
    boundary = frame_mesh(12, segments)
    mesh = constrained(boundary, crossings="split", holes=[[-1, -1]])
    invariants.assert_is_triangulation(mesh)
    invariants.lines_as_edges(mesh, boundary)
    assert invariants.area(mesh) == 144


def test_an_open_outline_names_its_loose_ends():
    boundary = Mesh([[0, 0], [1, 0], [1, 1], [0, 1]], {"line": [(0, 1), (1, 2), (2, 3)]})
    with pytest.raises(InvalidGeometry, match=r"open, with 2 loose ends, at \(0, 0\), \(0, 1\)") as caught:
        constrained(boundary)
    assert caught.value.points == (0, 3)


def test_lines_outside_are_told():
    boundary = Mesh([[0, 0], [1, 0], [1, 1], [0, 1], [2, 2], [3, 3]], {"line": [*loop_lines(4), (4, 5)]})
    _, report = delaunay_refinement(boundary)
    assert "1 lines lie outside what is meshed, the first is line 4" in report.warnings[0]


@pytest.mark.parametrize(
    "points, lines, keywords, message",
    [
        ([[0, 0], [1, 0], [0, 1]], np.empty((0, 2), int), {}, "no line cells"),
        ([[0, 0], [1, 0], [0, 1]], [(0, 0), (1, 1)], {}, "only lines without length"),
        ([[0, 0], [1, 0], [2, 0]], [(0, 1), (1, 2), (2, 0)], {}, "one line"),
        ([[0, 0], [1, 0], [0, 1]], loop_lines(3), {"holes": [[0.2, 0.2]]}, "leave nothing to mesh"),
        (
            [[0, 0], [1, 0], [0, 1], [5, 5], [6, 6]],
            [*loop_lines(3), (3, 4)],
            {"holes": [[0.2, 0.2]]},
            r"leave nothing to mesh; the outline is open, with 2 loose ends, at \(5, 5\)",
        ),
        ([[0, 0], [1, 0], [0, 1]], loop_lines(3), {"holes": [[0.5, 0.0]]}, "lies on a line"),
        ([[0, 0], [1, 0], [0, 1]], loop_lines(3), {"holes": [0.5, 0.0]}, "shape"),
        ([[0, 0], [1, 0], [0, 1]], loop_lines(3), {"holes": [["a", "b"]]}, "numbers"),
        ([[0, 0], [1, 0], [0, 1]], loop_lines(3), {"holes": [[np.nan, 0]]}, "not finite"),
        ([[0, 0], [1, 0], [0, 1]], loop_lines(3), {"regions": [[0.1, 0.1, 1.5]]}, "whole numbers"),
        ([[0, 0, 0], [1, 0, 0], [1, 1, 0.5], [0, 1, 0]], loop_lines(4), {}, "not planar.* off the best plane"),
        ([[0, 0], [1, 0], [0, 1e-300]], loop_lines(3), {}, "three different points, got 2"),
        ([[0, 0], [1e200, 0], [1e200, 1e-200], [0, 1e200]], loop_lines(4), {}, "coordinates up to 1e.200; scale them"),
    ],
)
def test_bad_boundaries_are_refused(points, lines, keywords, message):
    with pytest.raises(InvalidInput, match=message):
        constrained(Mesh(points, {"line": lines}), **keywords)


def test_seeds_outside_are_told():
    _, report = delaunay_refinement(square(), holes=[[5, 5]], regions=[[0.5, 0.5, 3], [9, 9, 4]])
    assert len(report.warnings) == 2 and all("lies outside" in w for w in report.warnings)
