"""The operation constrained_delaunay: visibility by brute force, crossings, conforming, lines with tags, bad input."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from meshcore import Cancelled, InvalidGeometry, InvalidInput, Mesh, constrained_delaunay, delaunay_refinement
from meshcore.gallery import circle, joined, square
from tests import naive
from tests.core.unstructured import invariants
from tests.core.unstructured.planar_graphs import comb, frame_mesh, framed_segments, loop_lines, loops, star_polygons

FRAME = [(0, 0), (8, 0), (8, 8), (0, 8)]


def triangulated(boundary, *seeds, **keywords):
    return constrained_delaunay(boundary, *seeds, **keywords).mesh


def seen_inside_circle(mesh, boundary):
    """Points that lie in the circle of a triangle and are seen from a place in it past the lines, exactly."""
    points = [tuple(map(Fraction, p)) for p in mesh.points[:, :2].tolist()]
    lines = [
        tuple(tuple(map(Fraction, p)) for p in ends) for ends in boundary.points[boundary.get("line"), :2].tolist()
    ]

    def blocked(p, q):
        for a, b in lines:
            sides = naive.side(p, q, a) * naive.side(p, q, b), naive.side(a, b, p) * naive.side(a, b, q)
            if sides[0] <= 0 and sides[1] < 0:
                return True
        return False

    shares = [(1, 1, 1), (6, 1, 1), (1, 6, 1), (1, 1, 6), (4, 4, 1), (1, 4, 4), (4, 1, 4)]
    found = []
    for cell in invariants.triangles(mesh):
        corners = [points[k] for k in cell]
        places = [
            tuple(sum(w * c[k] for w, c in zip(share, corners, strict=True)) / sum(share) for k in (0, 1))
            for share in shares
        ]
        found += [
            (cell, k)
            for k, p in enumerate(points)
            if k not in cell and naive.in_circle(*corners, p) > 0 and not all(blocked(p, place) for place in places)
        ]
    return found


@settings(max_examples=40)
@given(framed_segments(side=7, most=9))
@example(frame_mesh(7, [((1, 1), (6, 3)), ((1, 2), (3, 2)), ((5, 3), (6, 5))]))
def test_no_point_in_a_circle_is_seen_from_its_triangle(boundary):
    mesh = triangulated(boundary, keep="hull")
    invariants.assert_is_triangulation(mesh)
    assert seen_inside_circle(mesh, boundary) == []


def test_the_brute_force_sees_a_wrong_diagonal():
    boundary = loops([(0, 0), (4, 1), (8, 0), (4, -1)])
    wrong = Mesh(boundary.points, {"triangle": [[0, 3, 2], [0, 2, 1]]})
    assert seen_inside_circle(wrong, boundary)
    assert not seen_inside_circle(triangulated(boundary), boundary)


@st.composite
def long_segments(draw):
    """Many points with a few long lines among them, which end anywhere; lines that would cross are left out."""
    random = np.random.default_rng(draw(st.integers(0, 10**6)))
    n, on_grid = draw(st.integers(20, 80)), draw(st.booleans())
    points = random.integers(0, 25, (n, 2)) if on_grid else random.random((n, 2))
    points = np.unique(points, axis=0).astype(float)
    kept = []
    for _ in range(25):
        a, b = random.choice(len(points), 2, replace=False)
        p, q = points[[a, b]].tolist()
        if not any(naive.segments_cross(p, q, *points[list(old)].tolist()) for old in kept):
            kept.append((int(a), int(b)))
    return Mesh(points, {"line": kept, "vertex": np.arange(len(points))[:, None]})


def hull_area(points):
    from scipy.spatial import ConvexHull

    return invariants.shoelace(points[ConvexHull(points).vertices].tolist())


@settings(max_examples=50)
@given(long_segments())
def test_long_lines_through_many_points(boundary):
    mesh = triangulated(boundary, keep="hull")
    invariants.assert_is_triangulation(mesh)
    invariants.assert_constrained_delaunay(mesh, boundary)
    assert float(invariants.area(mesh)) == pytest.approx(float(hull_area(boundary.points[:, :2])), rel=1e-12)
    assert mesh.n_points == boundary.n_points and invariants.euler(mesh) == 1


@settings(max_examples=150)
@given(st.integers(0, 10**6), st.integers(1, 30), st.sampled_from(["real", "grid", "clump", "near"]))
def test_any_lines_at_all_are_split_where_they_cross(seed, n, kind):
    random = np.random.default_rng(seed)
    inside = {
        "real": lambda: 1 + 6 * random.random((2 * n, 2)),
        "grid": lambda: random.integers(1, 8, (2 * n, 2)).astype(float),
        "clump": lambda: 4 + 1e-7 * random.standard_normal((2 * n, 2)),
        # Lines that nearly coincide: their crossings are ill-defined.
        "near": lambda: np.column_stack([random.random(2 * n) * 6 + 1, 4 + 1e-13 * random.random(2 * n)]),
    }[kind]()
    lines = np.concatenate([loop_lines(4), 4 + np.arange(2 * n).reshape(-1, 2)])
    boundary = Mesh(np.concatenate([FRAME, inside]), {"line": lines})
    mesh = triangulated(boundary, crossings="split", holes=[[-1, -1]])
    invariants.assert_is_triangulation(mesh)
    if kind != "near":
        invariants.lines_as_edges(mesh, boundary)
    assert invariants.area(mesh) == 64 and invariants.euler(mesh) == 1


@settings(max_examples=40)
@given(long_segments(), st.randoms(use_true_random=False))
def test_there_is_one_triangulation_whatever_the_order_of_lines(boundary, random):
    def cells(boundary):
        return {frozenset(t) for t in invariants.triangles(triangulated(boundary, keep="hull"))}

    lines = boundary.get("line").tolist()
    random.shuffle(lines)
    shuffled = Mesh(boundary.points, {**boundary.cells, "line": [random.sample(line, 2) for line in lines]})
    assert cells(shuffled) == cells(boundary)


def test_ties_are_broken_by_the_lowest_number():
    """Of four corners of a square the lowest is lifted: the diagonal joins its neighbours, on both sides of a wall."""
    x, y = np.meshgrid(np.arange(7.0), np.arange(4.0))
    points = np.column_stack([x.ravel(), y.ravel()])
    vertex = np.arange(len(points))[:, None]
    mesh = triangulated(Mesh(points, {"vertex": vertex, "line": [(1, 26), (3, 10)]}), keep="hull")
    found = {frozenset(t) for t in invariants.triangles(mesh)}
    assert {frozenset((0, 1, 7)), frozenset((1, 8, 7)), frozenset((14, 15, 21)), frozenset((15, 22, 21))} <= found
    plain = triangulated(Mesh(points, {"vertex": vertex}), keep="hull")
    assert found != {frozenset(t) for t in invariants.triangles(plain)}
    for k in range(27):
        if k % 7 < 6 and k < 21:
            assert frozenset((k, k + 1, k + 7)) in {frozenset(t) for t in invariants.triangles(plain)}


def test_many_lines_that_cross_one_another():
    """n lines in general position have n (n - 1) / 2 crossings."""
    n = 40
    angle = np.pi * (np.arange(n) + 0.3) / n
    offset = 0.1 * np.cos(37 * np.arange(n))
    middle = offset[:, None] * np.column_stack([-np.sin(angle), np.cos(angle)])
    along = 100 * np.column_stack([np.cos(angle), np.sin(angle)])
    points = np.concatenate([middle - along, middle + along])
    boundary = Mesh(points, {"line": np.column_stack([np.arange(n), n + np.arange(n)])})
    mesh, report = constrained_delaunay(boundary, keep="hull", crossings="split", lines=True)
    assert report.counts["points added at crossings"] == n * (n - 1) // 2
    assert np.bincount(mesh.cell_data["line"][mesh.cell_data["line"] >= 0]).tolist() == [n] * n


def test_a_hub_of_many_lines():
    n = 500
    rim = circle(n).points[:, :2] * (1 + 0.3 * np.sin(np.arange(n) * 7.0))[:, None]
    for order in ((0, 1), (1, 0)):
        spokes = np.column_stack([np.zeros(n, int), 1 + np.arange(n)])[:, order]
        boundary = Mesh(np.concatenate([[[0, 0]], rim]), {"line": spokes})
        mesh = triangulated(boundary, keep="hull", lines=True)
        assert (np.sort(mesh.get("line"), axis=1) == np.sort(spokes, axis=1)).all()
        assert (mesh.get("line") == spokes).all()


# ---- conforming


def assert_delaunay(mesh):
    assert naive.delaunay_circles_are_empty(mesh.points[:, :2].tolist(), invariants.triangles(mesh))


@settings(max_examples=60)
@given(framed_segments())
def test_conforming_triangles_are_delaunay(boundary):
    mesh, report = constrained_delaunay(boundary, conforming=True, holes=[[-1, -1]])
    invariants.assert_is_triangulation(mesh)
    invariants.lines_as_edges(mesh, boundary)
    assert_delaunay(mesh)
    assert invariants.area(mesh) == 64 and report.converged
    given_points = {tuple(p) for p in boundary.points.tolist()}
    assert mesh.n_points == len(given_points) + report.counts["points added on lines"]


@settings(max_examples=30)
@given(star_polygons(most=12))
def test_conforming_star_polygons(polygon):
    boundary = loops(polygon)
    mesh, report = constrained_delaunay(boundary, conforming=True)
    invariants.lines_as_edges(mesh, boundary)
    assert_delaunay(mesh)
    assert float(invariants.area(mesh)) == pytest.approx(float(invariants.shoelace(polygon.tolist())), rel=1e-12)
    assert report.converged


@pytest.mark.parametrize("gap", [30.0, 5.0, 0.5, 0.01])
def test_conforming_ends_between_lines_at_small_angles(gap):
    angle = np.radians(gap * np.arange(5))
    tips = np.column_stack([np.cos(angle), np.sin(angle)]) * np.array([1.0, 0.7, 1.3, 0.9, 1.1])[:, None]
    boundary = Mesh(np.concatenate([[[0, 0]], tips]), {"line": [[0, k] for k in range(1, 6)]})
    mesh, report = constrained_delaunay(boundary, conforming=True, keep="hull")
    assert_delaunay(mesh)
    assert report.converged and mesh.n_points < 60


def test_conforming_adds_nothing_where_nothing_is_amiss():
    boundary = loops(comb(20, 3.0))
    _, report = constrained_delaunay(boundary, conforming=True)
    assert report.counts["points added on lines"] == 0


# ---- what is meshed, and what is told of the lines


def test_lines_come_with_tag_number_and_direction():
    outline = square().with_cell_data(tag=np.array([10, 11, 12, 13]))
    points = np.concatenate([outline.points, [[0.5, 0.0, 0], [0.5, 1.0, 0], [0.3, 0.4, 0]]])
    lines = [*outline.get("line").tolist(), (5, 4)]
    boundary = Mesh(points, {"vertex": [[6]], "line": lines}, cell_data={"tag": np.array([0, 10, 11, 12, 13, 7])})
    mesh = triangulated(boundary, lines=True)
    on = mesh.cell_data["line"] >= 0
    assert on.sum() == len(mesh.get("line")) == 7
    rows = zip(mesh.get("line").tolist(), mesh.cell_data["line"][on], mesh.cell_data["tag"][on], strict=True)
    assert [(tuple(ends), line, tag) for ends, line, tag in rows] == [
        ((0, 4), 1, 10),
        ((4, 1), 1, 10),
        ((1, 2), 2, 11),
        ((2, 5), 3, 12),
        ((5, 3), 3, 12),
        ((3, 0), 4, 13),
        ((5, 4), 5, 7),
    ]
    assert not mesh.cell_data["region"][on].any() and not mesh.cell_data["tag"][~on].any()
    edges = {tuple(sorted(e)) for e in Mesh(mesh.points, {"triangle": mesh.get("triangle")}).edges.tolist()}
    assert {tuple(sorted(e)) for e in mesh.get("line").tolist()} <= edges


def test_conforming_pieces_follow_their_line():
    boundary = frame_mesh(8, [((1, 4), (7, 4))], [(2, 5), (3, 3), (4, 5), (5, 3), (6, 5)])
    mesh = triangulated(boundary, conforming=True, lines=True)
    rows = mesh.get("line")[mesh.cell_data["line"][mesh.cell_data["line"] >= 0] == mesh.cell_data["line"].max()]
    assert len(rows) > 1 and (rows[1:, 0] == rows[:-1, 1]).all()
    assert (np.diff(mesh.points[np.append(rows[:, 0], rows[-1, 1]), 0]) > 0).all()


def test_the_hull_is_meshed_around_and_in_loops():
    boundary = joined(square(size=9.0), circle(12, radius=1.0, centre=(3, 3)))
    mesh = triangulated(boundary, keep="hull")
    assert invariants.area(mesh) == 81 and invariants.euler(mesh) == 1
    assert sorted(np.unique(mesh.cell_data["region"])) == [1, 2]
    corner = loops([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)])
    mesh = triangulated(corner, keep="hull")
    assert invariants.area(mesh) == Fraction(7, 2)
    assert sorted(np.unique(mesh.cell_data["region"])) == [0, 1]
    mesh = triangulated(corner, keep="hull", holes=[[1.4, 1.4]])
    assert invariants.area(mesh) == 3
    mesh = triangulated(corner, keep="hull", holes=[[0.5, 0.5]], regions=[[1.4, 1.4, 5]])
    assert invariants.area(mesh) == Fraction(1, 2) and (mesh.cell_data["region"] == 5).all()


def test_points_alone_have_a_hull():
    random = np.random.default_rng(5)
    points = random.random((40, 2))
    mesh = triangulated(Mesh(points, {"vertex": np.arange(40)[:, None]}), keep="hull", lines=True)
    assert_delaunay(mesh)
    assert len(mesh.get("line")) == 0 and invariants.euler(mesh) == 1
    with pytest.raises(InvalidGeometry, match="no line cells"):
        constrained_delaunay(Mesh(points, {"vertex": np.arange(40)[:, None]}))


def test_a_slanted_plane_is_meshed_in_it():
    turn = np.array([[0, 0, 1, 2], [1, 0, 0, 3], [0, 1, 0, 4], [0, 0, 0, 1]], float)
    flat = loops([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)])
    mesh = triangulated(flat.transformed(turn), lines=True)
    assert (mesh.get("triangle") == triangulated(flat).get("triangle")).all()
    assert (mesh.points == flat.transformed(turn).points).all() and len(mesh.get("line")) == 6


# ---- bad input


@pytest.mark.parametrize("scale", [1e-300, 1e-60, 1e60, 1e74])
def test_tiny_and_huge_coordinates(scale):
    polygon = np.array([(0, 0), (3, 1), (5, 0), (4, 4), (1, 3)]) * scale
    if scale < 1e-75:
        with pytest.raises(InvalidGeometry, match="scale them"):
            constrained_delaunay(loops(polygon))
        return
    mesh = triangulated(loops(polygon), conforming=True)
    invariants.assert_is_triangulation(mesh)
    assert invariants.area(mesh) == invariants.shoelace(polygon.tolist())


def test_far_from_the_origin():
    random = np.random.default_rng(1)
    angle = np.sort(random.random(200)) * 2 * np.pi
    polygon = 1e8 + np.column_stack([np.cos(angle), np.sin(angle)]) * (0.3 + random.random((200, 1)))
    boundary = loops(polygon)
    mesh = triangulated(boundary)
    invariants.assert_constrained_delaunay(mesh, boundary)
    assert invariants.area(mesh) == invariants.shoelace(polygon.tolist())


@pytest.mark.parametrize(
    "points, cells, keywords, message",
    [
        ([[0, 0], [1, 0], [0, 1]], {"line": loop_lines(3)}, {"holes": [[0.2, 0.2]]}, "leave nothing to mesh"),
        ([[0, 0], [1, 0], [0, 1]], {"line": loop_lines(3)}, {"regions": [[0.5, 0.5, 1]]}, "lies on a line"),
        ([[0, 0], [1, 0], [0, 1]], {"line": [(0, 1)]}, {"keep": "hull"}, "three different points, got 2"),
        ([[0, 0], [1, 0], [2, 0]], {"line": [(0, 1), (1, 2)]}, {"keep": "hull"}, "one line"),
        ([[1, 1], [1, 1], [1, 1]], {"line": [(0, 1), (1, 2)]}, {"keep": "hull"}, "only lines without length"),
        ([[0, 0], [1, 0], [0, 1]], {"line": [(0, 1), (1, 2)]}, {}, "the outline is open, with 2 loose ends"),
        ([[0, 0], [1, 0], [0, 1]], {"triangle": [(0, 1, 2)]}, {}, "no line cells"),
        ([[0, 0], [1, 0], [0, 1]], {"line": loop_lines(3)}, {"keep": "all"}, "not one of inside, hull"),
        ([[0, 0, 0], [1, 0, 0], [1, 1, 1], [0, 1, 0]], {"line": loop_lines(4)}, {}, "not planar"),
    ],
)
def test_bad_boundaries_are_refused(points, cells, keywords, message):
    with pytest.raises(InvalidInput, match=message):
        constrained_delaunay(Mesh(points, cells), **keywords)


def test_what_is_no_mesh_is_refused():
    with pytest.raises(InvalidInput, match="needs a Mesh of line cells, got list"):
        constrained_delaunay([[0, 0], [1, 0], [0, 1]])


def test_all_crossings_are_named():
    boundary = frame_mesh(8, [((1, 2), (7, 2)), ((2, 1), (2, 3)), ((4, 1), (4, 3)), ((6, 1), (6, 3))])
    with pytest.raises(InvalidGeometry, match=r"line 4 and line 5 cross at \(2, 2\) \(3 crossings in all\)") as caught:
        constrained_delaunay(boundary)
    assert caught.value.cells == (4, 5, 6, 7) and caught.value.parameter == "boundary"


@pytest.mark.parametrize("conforming", [False, True])
def test_it_can_be_cancelled_and_tells_progress(conforming):
    told = []

    def stop(fraction, message):
        told.append((fraction, message))
        return message != "inserting lines"

    with pytest.raises(Cancelled):
        constrained_delaunay(square(4), conforming=conforming, progress=stop)
    said = []
    constrained_delaunay(square(4), conforming=conforming, progress=lambda f, m: said.append(f) or True)
    assert said == sorted(said) and said[0] >= 0 and said[-1] <= 1


# ---- seeds as points


def test_points_mark_holes_and_regions():
    boundary = joined(square(size=9.0), circle(12, radius=1.0, centre=(3, 3)), circle(12, radius=1.0, centre=(6, 6)))
    expected = triangulated(boundary, holes=[[3, 3]], regions=[[1, 1, 7], [6, 6, 8]])
    points = Mesh([[3, 3], [1, 1], [6, 6]], {}, {"tag": [0, 7, 8], "hole": [1, 0, 0]})
    mesh = triangulated(boundary, points)
    assert (mesh.get("triangle") == expected.get("triangle")).all()
    assert (mesh.cell_data["region"] == expected.cell_data["region"]).all() and set(mesh.cell_data["region"]) == {7, 8}
    holes = triangulated(boundary, Mesh([[3, 3]], {}))
    assert holes.n_cells == triangulated(boundary, holes=[[3, 3]]).n_cells
    some = Mesh([[6, 6, 0]], {"vertex": [[0]]}, {"tag": [8]})
    both = triangulated(boundary, some, holes=[[3, 3]], regions=[[1, 1]])
    assert set(both.cell_data["region"]) == {1, 8} and (both.get("triangle") == expected.get("triangle")).all()
    mesh, _ = delaunay_refinement(boundary, seeds=Mesh([[1, 1]], {}, {"max_area": [0.1]}))
    p = mesh.points[mesh.cells["triangle"]]
    assert 0.5 * np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])[:, 2].max() <= 0.1


@pytest.mark.parametrize(
    "seeds, message",
    [
        ([[0.5, 0.5]], "seeds: needs a Mesh of points, got list"),
        (Mesh([[0.5, 0.5]], {}, {"tag": [[1, 2]]}), "seeds: point array 'tag' needs one number a point"),
        (Mesh([[0.5, 0.5]], {}, {"tag": [0.5]}), "whole numbers"),
        (Mesh([[0.5, 0.0]], {}), "lies on a line"),
    ],
)
def test_bad_seeds_are_refused(seeds, message):
    with pytest.raises(InvalidInput, match=message):
        constrained_delaunay(square(), seeds)
