"""Delaunay refinement: angles, sizes, termination, budgets, planes, progress."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import meshcore
from meshcore import Cancelled, GenerationFailed, InvalidInput, Mesh, Relative, delaunay_refinement, quality
from meshcore.gallery import circle, joined, l_shape, square, square_with_hole
from meshcore.progress import silent
from meshcore.sizing.size_field import graded
from meshcore.unstructured import refiner
from meshcore.unstructured.constrained import constrained
from meshcore.unstructured.domain import Seeds, domain
from meshcore.unstructured.planar_graph import planar_graph
from tests.core.unstructured import invariants
from tests.core.unstructured.planar_graphs import comb, frame_mesh, framed_segments, loop_lines, loops, star_polygons

MODELS = {
    "square": square(),
    "square with hole": square_with_hole(16),
    "l": l_shape(3),
    "comb": loops(comb(6, 4.0)),
    "discs": joined(circle(40, radius=3.0), circle(30), circle(9, radius=0.3)),
    "grid of lines": frame_mesh(8, [((2, 2), (6, 2)), ((2, 4), (6, 4)), ((2, 6), (6, 6))], [(1, 1), (7, 7), (4, 5)]),
}


def polygon_area(boundary, n):
    return invariants.shoelace(boundary.points[:n, :2].tolist())


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("min_angle", [0.0, 20.0, 30.0, 33.0])
def test_models(name, min_angle):
    boundary = MODELS[name]
    mesh, report = delaunay_refinement(boundary, min_angle=min_angle)
    assert report.converged and not report.warnings
    invariants.assert_is_triangulation(mesh)
    invariants.assert_constrained_delaunay(mesh, boundary)
    assert invariants.angles(mesh).min() >= min_angle - 1e-9
    assert (mesh.points[: boundary.n_points] == boundary.points).all()
    without = delaunay_refinement(boundary, min_angle=0).mesh
    assert float(invariants.area(mesh)) == pytest.approx(float(invariants.area(without)), rel=1e-13)
    assert invariants.euler(mesh) == invariants.euler(without)
    added = report.counts["points added on lines"] + report.counts["points added inside"]
    assert mesh.n_points == boundary.n_points + added == report.counts["points"]


@pytest.mark.parametrize("keywords", [{"size": 0.07}, {"size": Relative(0.05)}, {"max_area": 0.001}])
@pytest.mark.parametrize("min_angle", [0.0, 30.0])
def test_sizes_are_limits(keywords, min_angle):
    mesh, report = delaunay_refinement(square_with_hole(), min_angle=min_angle, **keywords)
    assert report.converged
    invariants.assert_is_triangulation(mesh)
    invariants.assert_constrained_delaunay(mesh, square_with_hole())
    assert invariants.angles(mesh).min() >= min_angle - 1e-9
    if "size" in keywords:
        size = keywords["size"]
        size = size.fraction * np.sqrt(2) if isinstance(size, Relative) else size
        assert 0.7 * size < invariants.longest_edges(mesh).max() <= size
    else:
        p = mesh.points[mesh.cells["triangle"]]
        assert (0.5 * np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])[:, 2]).max() <= 0.001


@pytest.mark.parametrize("min_angle", [0.0, 30.0])
def test_a_size_field_is_kept_at_every_centroid(min_angle):
    def field(points):
        return 0.02 + 0.2 * np.hypot(points[:, 0] - 0.2, points[:, 1] - 0.1)

    mesh, report = delaunay_refinement(square_with_hole(), min_angle=min_angle, size_field=field)
    assert report.converged
    assert (invariants.longest_edges(mesh) <= field(mesh.centroids)).all()
    assert invariants.angles(mesh).min() >= min_angle - 1e-9
    invariants.assert_is_triangulation(mesh)
    both = delaunay_refinement(square_with_hole(), size=0.05, size_field=field).mesh
    assert (invariants.longest_edges(both) <= np.minimum(field(both.centroids), 0.05)).all()


@settings(max_examples=40)
@given(framed_segments(most=8), st.sampled_from([15.0, 25.0, 32.0]))
def test_random_segments_with_small_angles(boundary, min_angle):
    mesh, report = delaunay_refinement(boundary, min_angle=min_angle, holes=[[-1, -1]])
    assert report.converged
    invariants.assert_is_triangulation(mesh)
    invariants.lines_as_edges(mesh, boundary)
    assert float(invariants.area(mesh)) == pytest.approx(64, rel=1e-14)
    assert mesh.n_cells < 20_000
    assert_small_angles_are_excused(mesh, boundary, min_angle)


@settings(max_examples=40)
@given(star_polygons(), st.sampled_from([10.0, 20.0, 30.0]), st.integers(-20, 20))
def test_star_polygons(polygon, min_angle, exponent):
    boundary = loops(np.ldexp(polygon, exponent))
    mesh, report = delaunay_refinement(boundary, min_angle=min_angle)
    assert report.converged
    invariants.assert_is_triangulation(mesh)
    exact = float(invariants.shoelace(boundary.points[:, :2].tolist()))
    assert float(invariants.area(mesh)) == pytest.approx(exact, rel=1e-12)
    assert mesh.n_cells < 5_000
    assert_small_angles_are_excused(mesh, boundary, min_angle)


def assert_small_angles_are_excused(mesh, boundary, min_angle):
    """A triangle below the bound has its shortest edge between two lines that meet at less than 60 degrees."""
    cells = mesh.cells["triangle"]
    corner = invariants.angles(mesh)
    on_line = [{k for edge in chain for k in edge} for chain in invariants.lines_as_edges(mesh, boundary)]
    for t in np.flatnonzero(corner.min(axis=1) < min_angle - 1e-9):
        p, q = np.delete(cells[t], corner[t].argmin())
        ends = [k for k, line in enumerate(on_line) if p in line], [k for k, line in enumerate(on_line) if q in line]
        pairs = [(i, j) for i in ends[0] for j in ends[1] if i != j and on_line[i] & on_line[j]]
        assert pairs, f"triangle {t} is thin without the excuse of a small input angle"


@pytest.mark.parametrize("degrees", [5.0, 1.0, 0.1, 0.03, 1e-3])
@pytest.mark.parametrize("min_angle", [20.0, 33.0])
def test_spikes_end(degrees, min_angle):
    half = np.radians(degrees) / 2
    boundary = loops([(0, 0), (np.cos(half), -np.sin(half)), (1.0, 0.1), (np.cos(half), np.sin(half))])
    mesh, report = delaunay_refinement(boundary, min_angle=min_angle)
    assert report.converged and mesh.n_cells < 1_000  # Triangle makes 2.7 million at 0.1 degree
    invariants.assert_is_triangulation(mesh)
    if degrees > 0.01:  # at the tip of a finer spike both lines are one within the helper's tolerance
        assert_small_angles_are_excused(mesh, boundary, min_angle)
    assert any("small angles of the input" in w for w in report.warnings)


def test_many_lines_at_one_point():
    """A fan of lines a degree apart, of all lengths."""
    angle = np.radians(np.arange(0, 90, 1.0))
    radius = 1 + 0.5 * np.cos(37 * angle)
    tips = np.column_stack([np.cos(angle), np.sin(angle)]) * radius[:, None] + 2
    points = np.concatenate([[(0, 0), (5, 0), (5, 5), (0, 5), (2, 2)], tips])
    boundary = Mesh(points, {"line": [*loop_lines(4), *[(4, 5 + k) for k in range(len(tips))]]})
    mesh, report = delaunay_refinement(boundary, min_angle=30)
    assert report.converged and mesh.n_cells < 20_000
    invariants.assert_is_triangulation(mesh)
    invariants.lines_as_edges(mesh, boundary)


@pytest.mark.parametrize("name", ["rae2822", "naca0012", "s1223"])
def test_airfoils_in_a_far_field(name, root):
    airfoil = meshcore.io.read(root / "meshcore" / "data" / f"{name}.dat")
    boundary = joined(circle(48, radius=15.0, centre=(0.5, 0.0)), airfoil)
    field = graded(airfoil, near=0.02, growth=1.3, far=3.0)
    mesh, report = delaunay_refinement(boundary, min_angle=30, size_field=field)
    assert report.converged and not report.warnings
    invariants.assert_is_triangulation(mesh)
    invariants.lines_as_edges(mesh, boundary)
    assert (invariants.longest_edges(mesh) <= field(mesh.centroids)).all()
    assert invariants.angles(mesh).min() >= 30 - 1e-9
    exact = polygon_area(boundary, 48) - invariants.shoelace(airfoil.points[airfoil.get("line")[:, 0], :2].tolist())
    assert float(invariants.area(mesh)) == pytest.approx(float(exact), rel=1e-12)
    assert invariants.euler(mesh) == 0


def test_tiny_features_far_from_the_origin():
    """At 1e8 doubles are 1.5e-8 apart; features of 1e-3 must still mesh."""
    boundary = square_with_hole(4)
    moved = boundary.with_points(np.round(1e-3 * boundary.points, 6) + [1e8, -1e8, 0])
    mesh, report = delaunay_refinement(moved, min_angle=25)
    invariants.assert_is_triangulation(mesh)
    assert report.converged
    assert invariants.angles(mesh).min() > 24.9


@pytest.mark.parametrize("placement", ["lattice", "off-centre", "circumcentre", "front"])
@pytest.mark.parametrize("extent", [1.0, 1e-3])
def test_lines_far_from_the_origin_are_split(extent, placement):
    """Points on slanted lines are off them by the rounding of coordinates, far more than of lengths."""
    boundary = square_with_hole()
    moved = boundary.with_points(extent * boundary.points + [1e8, 1e8, 0])
    mesh, report = delaunay_refinement(moved, size=0.05 * extent, min_angle=25, placement=placement)
    assert report.converged and report.counts["points added on lines"] > 50
    invariants.assert_is_triangulation(mesh)
    assert invariants.angles(mesh).min() > 24.9
    assert invariants.longest_edges(mesh).max() <= 0.05 * extent + 1e-7


@pytest.mark.parametrize("scale", [1e-30, 1e-8, 1e8, 1e30])
def test_scale_does_not_matter(scale):
    power = 2.0 ** round(np.log2(scale))
    one = delaunay_refinement(square_with_hole(), size=0.1).mesh
    other = delaunay_refinement(
        square_with_hole().with_points(square_with_hole().points * power), size=0.1 * power
    ).mesh
    assert (one.cells["triangle"] == other.cells["triangle"]).all()
    assert (one.points * power == other.points).all()


@pytest.mark.parametrize("placement", ["automatic", "off-centre", "circumcentre"])
@pytest.mark.parametrize("limits", [{}, {"max_area": 0.01}, {"size": 0.1}])
def test_placements(placement, limits):
    mesh, report = delaunay_refinement(MODELS["l"], min_angle=25, placement=placement, **limits)
    assert report.converged and not report.warnings
    invariants.assert_is_triangulation(mesh)
    invariants.assert_constrained_delaunay(mesh, MODELS["l"])
    assert invariants.angles(mesh).min() >= 25 - 1e-9


@pytest.mark.parametrize("seed", range(6))
def test_circumcentres_begin_with_the_largest_circle(seed):
    """The first point is the centre of a circle among the largest; they are sorted by quarters of an octave."""
    rng = np.random.default_rng(seed)
    inner = np.round(rng.uniform(1, 7, (40, 2)), 3).tolist()
    rim = [(k, y) for k in range(1, 8) for y in (0, 8)] + [(x, k) for k in range(1, 8) for x in (0, 8)]
    points = np.array([(0, 0), (8, 0), (8, 8), (0, 8), *rim, *inner], float)
    boundary = Mesh(points, {"line": loop_lines(4), "vertex": [[k] for k in range(4, len(points))]})
    before = delaunay_refinement(boundary, min_angle=0).mesh
    after = delaunay_refinement(boundary, min_angle=0, max_area=0.3, placement="circumcentre").mesh
    first = after.points[len(points), :2]
    a, b, c = (before.points[before.cells["triangle"][:, k], :2] for k in range(3))
    u, v = b - a, c - a
    doubled = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    u2, v2 = (u**2).sum(axis=1), (v**2).sum(axis=1)
    to = np.column_stack([v[:, 1] * u2 - u[:, 1] * v2, u[:, 0] * v2 - v[:, 0] * u2]) / (2 * doubled[:, None])
    radius2 = (to**2).sum(axis=1)
    inside = ((a + to > 0) & (a + to < 8)).all(axis=1)
    poor = doubled > 0.6
    assert inside[poor].all()
    chosen = np.linalg.norm(a + to - first, axis=1).argmin()
    assert np.allclose(a[chosen] + to[chosen], first)
    assert radius2[chosen] > 0.75 * radius2[poor].max()


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("placement", ["off-centre", "circumcentre"])
@pytest.mark.parametrize("limits", [{}, {"max_area": 0.01}, {"size_field": lambda p: 0.05 + 0.1 * np.abs(p[:, 0])}])
def test_a_boundary_that_may_not_be_split_stays(name, placement, limits):
    boundary = MODELS[name]
    mesh, report = delaunay_refinement(boundary, placement=placement, split_boundary=False, **limits)
    invariants.assert_is_triangulation(mesh)
    invariants.assert_constrained_delaunay(mesh, boundary)
    assert (mesh.points[: boundary.n_points] == boundary.points).all()
    assert report.counts["points added on lines"] == 0
    edges = {tuple(edge) for edge in mesh.edges.tolist()}
    assert {tuple(sorted(line)) for line in boundary.get("line").tolist()} <= edges
    thin = int((invariants.angles(mesh).min(axis=1) < 30 - 1e-9).sum())
    assert report.converged == (not report.warnings)
    if thin:
        told = int(report.warnings[0].split()[0].replace(",", ""))
        assert not report.converged and told >= thin and "may not be split" in report.warnings[0]


@pytest.mark.parametrize("rounds", [1, 3])
def test_smoothing_lets_no_line_be_split_that_may_not(rounds):
    star = [(4.02, 7.03), (2.86, 5.55), (1.47, 0.17), (3.66, 1.8), (5.31, 2.78), (7.56, 2.71), (5.86, 3.52)]
    star += [(7.56, 4.81), (5.13, 7.32)]
    mesh, report = delaunay_refinement(
        loops(star), min_angle=0, max_area=0.05, smoothing=rounds, split_boundary=False, placement="off-centre"
    )
    assert report.counts["points added on lines"] == 0
    assert mesh.boundary.n_cells == len(star)


def test_areas_are_as_asked_after_smoothing_with_a_size_field_and_no_angle():
    outline = loops([(0, 0), (8, 0), (8, 8), (0, 8)])
    boundary = joined(outline, Mesh([[1.0, 1.0]], {"line": [[0, 0]]}))  # whose length makes sizes small there
    mesh, report = delaunay_refinement(boundary, min_angle=0, max_area=0.1, gradation=0.2, smoothing=1)
    assert report.converged
    corners = mesh.points[mesh.get("triangle")]
    assert np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2].max() <= 0.2


def test_spikes_that_may_not_be_split_end():
    half = np.radians(1e-3) / 2
    boundary = loops([(0, 0), (np.cos(half), -np.sin(half)), (1.0, 0.1), (np.cos(half), np.sin(half))])
    mesh, report = delaunay_refinement(boundary, size=0.02, split_boundary=False)
    assert not report.converged and mesh.n_cells < 20_000
    invariants.assert_is_triangulation(mesh)


def test_the_same_lines_give_the_same_mesh():
    one, other = (delaunay_refinement(square_with_hole(), size=0.05).mesh for _ in range(2))
    assert (one.points == other.points).all() and (one.cells["triangle"] == other.cells["triangle"]).all()


def test_loops_in_a_tilted_plane():
    flat = square_with_hole()
    turn = np.linalg.qr(np.random.default_rng(11).normal(size=(3, 3)))[0]
    tilted = flat.with_points(flat.points @ turn.T + [3.0, -2.0, 5.0])
    mesh, report = delaunay_refinement(tilted, min_angle=30)
    assert report.converged
    assert (mesh.points[: flat.n_points] == tilted.points).all()
    back = mesh.with_points((mesh.points - [3.0, -2.0, 5.0]) @ turn)
    assert np.abs(back.points[:, 2]).max() < 1e-14
    assert invariants.angles(mesh).min() >= 30 - 1e-9
    assert quality.validate(mesh) == []


@pytest.mark.parametrize("axes", [(0, 2), (1, 0), (2, 1)])
def test_upright_planes_keep_every_bit(axes):
    flat = square_with_hole()
    points = np.full_like(flat.points, 0.3)
    points[:, axes] = flat.points[:, :2]
    mesh = delaunay_refinement(flat.with_points(points), size=0.1).mesh
    assert (mesh.points[: flat.n_points] == points).all()
    assert (mesh.points[:, (set(range(3)) - set(axes)).pop()] == 0.3).all()
    area = (
        np.linalg.norm(
            np.cross(
                *(mesh.points[mesh.cells["triangle"]][:, k] - mesh.points[mesh.cells["triangle"]][:, 0] for k in (1, 2))
            ),
            axis=1,
        ).sum()
        / 2
    )
    disc = float(invariants.shoelace(circle(13, radius=0.25).points[:, :2].tolist()))
    assert area == pytest.approx(1 - disc, rel=1e-12)


@pytest.mark.parametrize("placement", ["automatic", "off-centre", "circumcentre", "lattice", "front"])
@pytest.mark.parametrize("smallest", [1e-170, 1e-300, 5e-324])
def test_sizes_whose_squares_underflow_are_refused(placement, smallest):
    for keywords in ({"size": smallest}, {"max_area": smallest}, {"size_field": lambda p: np.full(len(p), smallest)}):
        if placement != "lattice" or "size_field" not in keywords:
            with pytest.raises(InvalidInput, match=r"would make about .* triangles"):
                delaunay_refinement(square_with_hole(), placement=placement, **keywords)


def test_absurd_sizes_are_refused_before_memory_is_used():
    for keywords in ({"size": 1e-9}, {"max_area": 1e-12}, {"regions": [[0.01, 0.01, 1, 1e-12]]}):
        with pytest.raises(InvalidInput, match=r"would make about .* triangles; at most 50,000,000"):
            delaunay_refinement(square_with_hole(), **keywords)
    with pytest.raises(InvalidInput, match="size_field: would make about"):
        delaunay_refinement(square_with_hole(), size_field=lambda p: np.full(len(p), 1e-7))


@pytest.mark.parametrize(
    "field, message",
    [
        (lambda p: np.zeros(len(p)), "greater than zero"),
        (lambda p: p[:, 0] - 0.5, "greater than zero"),
        (lambda p: np.full(len(p), np.nan), "is nan at"),
        (lambda p: np.ones((len(p), 2)), "one size a point"),
        (lambda p: ["x"] * len(p), "failed on"),
    ],
)
def test_bad_size_fields_are_refused(field, message):
    with pytest.raises(InvalidInput, match=message):
        delaunay_refinement(square_with_hole(), size_field=field)


@pytest.mark.parametrize(
    "keywords",
    [
        {"min_angle": 35},
        {"min_angle": -1},
        {"size": 0},
        {"size": -1.0},
        {"max_area": 0},
        {"max_area": -1},
        {"min_angle": np.nan},
        {"crossings": "maybe"},
    ],
)
def test_bad_parameters_are_refused(keywords):
    with pytest.raises(InvalidInput, match=next(iter(keywords))):
        delaunay_refinement(square(), **keywords)


def test_34_degrees_ends_one_way_or_the_other():
    rng = np.random.default_rng(17)
    angle = np.sort(rng.random(30)) * 2 * np.pi
    boundary = loops(np.column_stack([np.cos(angle), np.sin(angle)]) * rng.uniform(0.2, 1, (30, 1)))
    mesh, report = delaunay_refinement(boundary, min_angle=34)
    assert quality.validate(mesh) == []
    assert report.converged or any("may never end" in w for w in report.warnings)


def test_progress_is_told_and_may_cancel():
    seen = []
    delaunay_refinement(square_with_hole(), size=0.005, progress=lambda f, m: seen.append((f, m)))
    fractions = [f for f, _ in seen]
    assert fractions == sorted(fractions) and fractions[0] >= 0 and fractions[-1] <= 1 and len(seen) > 4
    for stop in (0.0, 0.1, 0.3):
        boundary = square_with_hole()
        with pytest.raises(Cancelled):
            delaunay_refinement(boundary, size=0.005, progress=lambda f, m, stop=stop: f < stop)
        assert delaunay_refinement(boundary).report.converged


def fine_in_a_corner(points):
    return 0.01 + 0.1 * np.hypot(points[:, 0], points[:, 1])


@pytest.mark.parametrize(
    "keywords",
    [
        {"size": 0.02, "smoothing": 2},
        {"size": 0.02, "smoothing": 2, "placement": "off-centre"},
        {"size": 0.02, "smoothing": 2, "placement": "front"},
        {"size_field": fine_in_a_corner, "smoothing": 2},
        {"size_field": fine_in_a_corner, "smoothing": 2, "placement": "front"},
    ],
)
def test_progress_never_runs_backwards(keywords):
    seen = []
    delaunay_refinement(square_with_hole(), **keywords, progress=lambda f, m: seen.append((f, m)))
    fractions = [f for f, _ in seen]
    assert fractions == sorted(fractions)
    smoothing = [f for f, message in seen if message.startswith("smoothing")]
    refining = [f for f, message in seen if message == "refining"]
    assert min(refining) < min(smoothing) < max(smoothing) < max(refining) < fractions[-1]


def test_progress_never_runs_backwards_where_lines_cross():
    seen = []
    lines = [((1, 1), (7, 6)), ((1, 6), (7, 1)), ((1, 2), (7, 4))]
    delaunay_refinement(frame_mesh(8, lines), crossings="split", progress=lambda f, m: seen.append(f))
    assert seen == sorted(seen)


def test_area_of_fractions():
    """The helper itself: a triangle of known area."""
    assert invariants.shoelace([(0, 0), (1, 0), (0, Fraction(1, 3))]) == Fraction(1, 6)


def test_other_things_than_meshes_are_refused():
    with pytest.raises(InvalidInput, match="boundary: needs a Mesh of line cells, got ndarray"):
        delaunay_refinement(np.zeros((3, 3)))


@pytest.mark.parametrize(
    "limits",
    [
        {"size": 1e300},
        {"size_field": lambda points: np.full(len(points), 1e200)},
        {"max_area": 1e305},
        {"regions": [[0.3, 0.4, 1, 1e305]]},
    ],
)
def test_limits_beyond_all_edges_are_no_limits(limits):
    mesh, report = delaunay_refinement(square(), **limits)
    assert mesh.n_cells == 2 and report.converged


def test_tags_that_are_no_integers_of_the_machine():
    with pytest.raises(InvalidInput, match="regions: tags must be within 2\\^53"):
        delaunay_refinement(square(), regions=[[0.3, 0.4, 1e300]])
    tag = 2**53
    assert set(delaunay_refinement(square(), regions=[[0.3, 0.4, tag]]).mesh.cell_data["region"]) == {tag}


def test_two_tags_in_one_region_are_told():
    mesh, report = delaunay_refinement(square(), regions=[[0.2, 0.3, 1], [0.7, 0.8, 2]])
    assert set(mesh.cell_data["region"]) == {2}
    assert report.warnings == ["region 0 lies in one part with a later one, so its tag 1 has no effect"]
    assert not delaunay_refinement(square(), regions=[[0.2, 0.3, 2], [0.7, 0.8, 2]]).report.warnings


def test_a_thin_domain_is_refused_by_a_front_whose_divided_lines_are_all_of_one_length_up_to_rounding():
    with pytest.raises(InvalidInput, match=r"min_angle: 30 would make about .* only 1 wide"):
        delaunay_refinement(square().transformed(np.diag([1e9, 1.0, 1, 1])), placement="front", size="5%")


@pytest.mark.parametrize("height", [1e-9, 1e-12])
@pytest.mark.parametrize("keywords", [{}, {"max_area": 1.0}, {"placement": "circumcentre"}])
def test_a_domain_too_thin_for_its_angle_is_refused_at_once(height, keywords):
    sliver = square().transformed(np.diag([1.0, height, 1, 1]))
    with pytest.raises(
        InvalidInput, match=f"min_angle: 30 would make about .* only {height:g} wide over a length of 1;"
    ):
        delaunay_refinement(sliver, min_angle=30, **keywords)
    for cure in ({"min_angle": 0}, {"split_boundary": False}):
        mesh, _ = delaunay_refinement(sliver, **cure)
        assert mesh.n_cells == 2


@pytest.mark.parametrize("gap", [1e-2, 1e-4])
def test_two_lines_near_each_other_end(gap):
    boundary = frame_mesh(8, [((1, 4), (7, 4)), ((1, 4 + gap), (7, 4 + gap))])
    mesh, report = delaunay_refinement(boundary, min_angle=30)
    assert report.converged
    assert quality.validate(mesh) == []
    assert 1.0 < mesh.n_cells * gap / 6 < 20


def test_refinement_that_does_not_end_is_stopped(monkeypatch):
    """Without the estimate, the budget of points is what ends it."""
    monkeypatch.setattr(refiner, "SPARE_POINTS", 2000)
    monkeypatch.setattr(refiner.Refiner, "_between_near_lines", lambda *_: 0.0)
    sliver = square().transformed(np.diag([1.0, 1e-6, 1, 1]))
    try:
        _, report = delaunay_refinement(sliver, min_angle=30)
    except GenerationFailed as error:
        told = str(error)
    else:
        assert not report.converged
        told = report.warnings[0]
    assert told.startswith("refinement was stopped after") and "less than min_angle = 30" in told


@pytest.mark.parametrize("n_rays", [2, 3, 5, 7, 40])
def test_corners_are_acute_where_two_lines_meet_at_less_than_60_degrees(n_rays):
    rng = np.random.default_rng(n_rays)
    for scale in (1.0, 1e-70, 1e70):
        for _ in range(20):
            angles = rng.permutation(np.sort(rng.uniform(0, 2 * np.pi, n_rays)))
            ends = scale * rng.uniform(0.1, 10, n_rays)[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
            rays = np.column_stack([np.zeros(n_rays, int), np.arange(1, n_rays + 1)])
            rays[::2] = rays[::2, ::-1]
            triangulation = triangulated_graph(np.concatenate([np.zeros((1, 2)), ends]), rays).triangulation
            found = refiner.acute_vertices(triangulation)[triangulation.vertex_of]
            between = np.abs((angles[:, None] - angles + np.pi) % (2 * np.pi) - np.pi)[np.triu_indices(n_rays, 1)]
            assert found[0] == (between.min() < np.pi / 3) and not found[1:].any()


def triangulated_graph(points, lines):
    graph = planar_graph(points, lines, np.arange(len(points)), "lines")
    return constrained(graph, split_crossings=False, parameter="lines", progress=silent)


@pytest.mark.parametrize("tip", [0.5, 1.5])
def test_acute_corners_count_where_they_are_meshed(tip):
    """A tooth cut out of a square, which is acute outside, and one that stands on it."""
    points = np.array([[0, 0], [1, 0], [1, 1], [0.55, 1], [0.5, tip], [0.45, 1], [0, 1]])
    mesh = triangulated_graph(points, np.array(loop_lines(7)))
    parts = domain(mesh, Seeds(None, np.empty((0, 2)), np.empty(0, int), np.empty(0)), np.inf)
    limits = {"min_angle": 20.0, "size": np.inf, "placement": "automatic", "split_boundary": True, "size_field": None}
    acute = refiner.Refiner(mesh, parts, **limits, progress=silent).acute[mesh.triangulation.vertex_of]
    assert np.flatnonzero(acute).tolist() == ([4] if tip > 1 else [])
