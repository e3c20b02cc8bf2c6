"""The advancing front: lengths, angles, lines, limits, and what it shares with all refinement."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import meshcore
from meshcore import InvalidInput, Mesh, Relative, delaunay_refinement, quality
from meshcore.gallery import circle, joined, l_shape, square, square_with_hole
from meshcore.sizing.size_field import graded
from tests import naive
from tests.core.unstructured import invariants
from tests.core.unstructured.planar_graphs import comb, framed_segments, loops, star_polygons

MODELS = {
    "square": square(),
    "square with hole": square_with_hole(16),
    "l": l_shape(3),
    "comb": loops(comb(6, 4.0)),
    "discs": joined(circle(40, radius=3.0), circle(30), circle(9, radius=0.3)),
}

# What the project asks of fronts: the mean ratio of radii, and the smallest angle in degrees after smoothing.
WANTED_SHAPE, WANTED_ANGLE = 0.99, 35.0
# Area of the triangle with three edges of length one.
EQUILATERAL = np.sqrt(3) / 4


def front(boundary, **keywords):
    return delaunay_refinement(boundary, placement="front", **keywords)


def edge_lengths(mesh):
    """(m,) float: of the mesh's edges."""
    a, b = mesh.points[mesh.edges].transpose(1, 0, 2)
    return np.linalg.norm(a - b, axis=1)


def mean_shape(mesh):
    """Mean of twice the inscribed over the circumscribed radius."""
    return float((1 / quality.measure(mesh, "radius_ratio")).mean())


def expected_area(boundary):
    return float(invariants.area(delaunay_refinement(boundary, min_angle=0).mesh))


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("smoothing", [0, 3])
@pytest.mark.parametrize("keywords", [{}, {"size": 0.15}, {"max_area": 0.01}, {"min_angle": 0, "size": 0.2}])
def test_models(name, keywords, smoothing):
    boundary = MODELS[name]
    mesh, report = front(boundary, smoothing=smoothing, **keywords)
    assert report.converged and not report.warnings
    invariants.assert_is_triangulation(mesh)
    invariants.assert_constrained_delaunay(mesh, boundary)
    assert invariants.angles(mesh).min() >= keywords.get("min_angle", 30.0) - 1e-9
    assert (mesh.points[: boundary.n_points] == boundary.points).all()
    assert float(invariants.area(mesh)) == pytest.approx(expected_area(boundary), rel=1e-12)
    added = report.counts["points added on lines"] + report.counts["points added inside"]
    assert mesh.n_points == boundary.n_points + added == report.counts["points"]
    if "size" in keywords:
        assert invariants.longest_edges(mesh).max() <= keywords["size"]
    if "max_area" in keywords:
        assert quality.measure(mesh, "area").max() <= keywords["max_area"]


def test_edges_are_as_long_as_wanted():
    """A uniform size: nearly all edges within a fifth of 0.68 of the limit, triangles nearly equilateral."""
    mesh, report = front(square_with_hole(), size=0.02, smoothing=3)
    share = edge_lengths(mesh) / (0.68 * 0.02)
    assert abs(share.mean() - 1) < 0.03
    assert np.quantile(share, [0.02, 0.98]) == pytest.approx([1, 1], abs=0.2)
    assert share.min() > 0.55
    assert mesh.n_cells == pytest.approx(
        quality.measure(mesh, "area").sum() / (EQUILATERAL * (0.68 * 0.02) ** 2), rel=0.1
    )
    assert mean_shape(mesh) > WANTED_SHAPE
    assert report.quality["smallest angle (degree)"] > WANTED_ANGLE
    other, beside = delaunay_refinement(square_with_hole(), size=0.02, smoothing=3, placement="off-centre")
    assert mean_shape(mesh) > mean_shape(other)
    assert report.quality["smallest angle (degree)"] > beside.quality["smallest angle (degree)"]


def test_many_triangles_are_nearly_equilateral():
    rough, smooth = (front(square_with_hole(40), size=0.012, smoothing=k) for k in (0, 3))
    assert mean_shape(smooth.mesh) > mean_shape(rough.mesh) > WANTED_SHAPE
    assert rough.report.quality["smallest angle (degree)"] >= 30 - 1e-9
    assert smooth.report.quality["smallest angle (degree)"] > WANTED_ANGLE


@pytest.mark.parametrize("smoothing", [0, 2])
def test_a_size_field_is_followed(smoothing):
    def field(points):
        return 0.01 + 0.15 * np.hypot(points[:, 0] - 0.2, points[:, 1] - 0.1)

    mesh, report = front(square_with_hole(), size_field=field, smoothing=smoothing)
    assert report.converged
    invariants.assert_is_triangulation(mesh)
    assert (invariants.longest_edges(mesh) <= field(mesh.centroids)).all()
    middle = mesh.points[mesh.edges].mean(axis=1)
    share = edge_lengths(mesh) / field(middle)
    assert 0.6 < np.median(share) < 0.7
    assert np.quantile(share, 0.05) > 0.45
    assert invariants.angles(mesh).min() >= 30 - 1e-9
    both = front(square_with_hole(), size=0.04, size_field=field, smoothing=smoothing).mesh
    assert (invariants.longest_edges(both) <= np.minimum(field(both.centroids), 0.04)).all()


def test_a_fine_spot_inside_is_found():
    """A size that is small only far from all lines."""

    def field(points):
        return 0.03 + 0.5 * np.hypot(points[:, 0] - 2.2, points[:, 1] - 1.9)

    mesh = front(square(size=4.0), size_field=field, smoothing=2).mesh
    distance = np.hypot(*(mesh.centroids[:, :2] - [2.2, 1.9]).T)
    area = quality.measure(mesh, "area")
    assert area[distance < 0.05].max() < 0.05**2 and area[distance > 1.5].min() > 0.1**2
    assert (invariants.longest_edges(mesh) <= field(mesh.centroids)).all()


def test_without_sizes_lengths_come_from_the_lines():
    """Outer lines of 0.5, a hole of lines of 0.05: lengths in between, growing from the hole."""
    boundary = joined(square(4, size=2.0), circle(32, radius=0.25, centre=(1.0, 1.0)))
    mesh, report = front(boundary, smoothing=2, min_angle=0)
    assert report.counts["points added on lines"] == 0
    middle = mesh.points[mesh.edges].mean(axis=1)
    distance = np.hypot(*(middle[:, :2] - 1).T) - 0.25
    length = edge_lengths(mesh)
    medians = [np.median(length[(distance >= a) & (distance < b)]) for a, b in ((0, 0.1), (0.1, 0.3), (0.3, 0.6))]
    assert 0.04 < medians[0] < medians[1] < medians[2] < 0.5


def test_fine_lines_are_left_gradually():
    """Lines ten times as fine as the size: neighbouring edges differ by little."""
    mesh, report = front(joined(square(size=4.0), circle(64, radius=0.5, centre=(2.0, 2.0))), size=0.7, smoothing=3)
    assert np.nanmax(quality.size_jump(mesh)) < 4
    assert report.quality["smallest angle (degree)"] > 33


def test_regions_have_their_own_areas():
    boundary = Mesh(
        [[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0], [0.5, 1]],
        {"line": [[0, 4], [4, 1], [1, 2], [2, 5], [5, 3], [3, 0], [4, 5]]},
    )
    regions = [[0.25, 0.5, 7, 0.0004], [0.75, 0.5, 9, 0.01]]
    mesh, report = front(boundary, regions=regions, smoothing=3)
    assert report.converged
    area, tag = quality.measure(mesh, "area"), mesh.cell_data["region"]
    assert set(tag.tolist()) == {7, 9}
    assert area[tag == 7].max() <= 0.0004 and area[tag == 9].max() <= 0.01
    assert area[tag == 7].mean() > 0.5 * 0.0004
    assert area[tag == 9].max() > 0.003
    assert (mesh.centroids[tag == 7][:, 0] < 0.5).all() and (mesh.centroids[tag == 9][:, 0] > 0.5).all()
    invariants.assert_constrained_delaunay(mesh, boundary)


@pytest.mark.parametrize("keywords", [{}, {"size": 0.3}, {"size_field": lambda p: 0.2 + 0.1 * p[:, 0]}])
def test_lines_may_be_kept_bit_by_bit(keywords):
    boundary = square_with_hole(8)
    mesh, report = front(boundary, split_boundary=False, min_angle=20, smoothing=2, **keywords)
    assert report.counts["points added on lines"] == 0
    outline = {tuple(sorted(edge)) for edge in mesh.boundary.cells["line"].tolist()}
    assert outline == {tuple(sorted(edge)) for edge in boundary.cells["line"].tolist()}
    invariants.assert_is_triangulation(mesh)


@pytest.mark.parametrize(
    "length",
    [lambda x: 0.1 + 0 * x, lambda x: 0.05 + 0.1 * x, lambda x: 0.4 - 0.12 * x, lambda x: 0.1 + 0.04 * np.sin(2 * x)],
)
def test_lines_are_divided_by_the_integral_of_one_over_length(length):
    """The survey's N_s and places, against quadrature by midpoints."""
    boundary = loops([(0, 0), (3, 0), (3, 2), (0, 2)])
    mesh = front(boundary, size_field=lambda p: length(p[:, 0]), min_angle=0).mesh
    on = np.sort(mesh.points[mesh.points[:, 1] == 0, 0])
    share = naive.line_integral(lambda x: 1 / (0.68 * length(x)), on)
    assert abs(len(share) - share.sum()) <= 0.6
    assert share == pytest.approx(share.mean(), rel=0.04)


@settings(max_examples=25)
@given(star_polygons(), st.sampled_from([0.08, 0.3, None]), st.integers(0, 2), st.integers(-20, 20))
def test_star_polygons(polygon, size, smoothing, exponent):
    boundary = loops(np.ldexp(polygon, exponent))
    size = None if size is None else np.ldexp(size, exponent)
    mesh, report = front(boundary, min_angle=25, size=size, smoothing=smoothing)
    assert report.converged
    invariants.assert_is_triangulation(mesh)
    exact = float(invariants.shoelace(boundary.points[:, :2].tolist()))
    assert float(invariants.area(mesh)) == pytest.approx(exact, rel=1e-12)
    assert mesh.n_cells < 20_000
    assert size is None or invariants.longest_edges(mesh).max() <= size


@settings(max_examples=25)
@given(framed_segments(most=8), st.sampled_from([None, 0.7]))
def test_random_segments_with_small_angles(boundary, size):
    mesh, report = front(boundary, min_angle=25, size=size, holes=[[-1, -1]], smoothing=1)
    assert report.converged
    invariants.assert_is_triangulation(mesh)
    invariants.lines_as_edges(mesh, boundary)
    assert float(invariants.area(mesh)) == pytest.approx(64, rel=1e-12)
    assert mesh.n_cells < 30_000


@pytest.mark.parametrize("degrees", [5.0, 0.5, 0.03, 1e-3])
def test_spikes_end(degrees):
    half = np.radians(degrees) / 2
    boundary = loops([(0, 0), (np.cos(half), -np.sin(half)), (1.0, 0.1), (np.cos(half), np.sin(half))])
    for keywords in ({}, {"size": 0.1}):
        mesh, report = front(boundary, min_angle=30, smoothing=2, **keywords)
        assert report.converged and mesh.n_cells < 3_000
        invariants.assert_is_triangulation(mesh)


def test_thin_strips():
    for height in (1e-2, 1e-5):
        mesh, report = front(loops([(0, 0), (1, 0), (1, height), (0, height)]), min_angle=20, size=0.1)
        assert report.converged
        assert float(invariants.area(mesh)) == pytest.approx(height, rel=1e-12)


def test_tilted_planes_and_offsets():
    flat = square_with_hole()
    turn = np.linalg.qr(np.random.default_rng(11).normal(size=(3, 3)))[0]
    tilted = flat.with_points(flat.points @ turn.T + [3.0, -2.0, 5.0])
    mesh, report = front(tilted, size=0.1, smoothing=3)
    assert report.converged and quality.validate(mesh) == []
    assert (mesh.points[: flat.n_points] == tilted.points).all()
    assert invariants.angles(mesh).min() > 33
    moved = flat.with_points(np.round(1e-3 * flat.points, 6) + [1e8, -1e8, 0])
    mesh, report = front(moved, min_angle=25)
    invariants.assert_is_triangulation(mesh)


@pytest.mark.parametrize("power", [-100, -30, 30, 100])
def test_scale_does_not_matter(power):
    factor, boundary = 2.0**power, square_with_hole()
    one = front(boundary, size=0.1, smoothing=2).mesh
    other = front(boundary.with_points(boundary.points * factor), size=0.1 * factor, smoothing=2).mesh
    assert (one.cells["triangle"] == other.cells["triangle"]).all()
    assert (one.points * factor == other.points).all()


def test_the_same_lines_give_the_same_mesh():
    one, other = (front(square_with_hole(), size=0.05, smoothing=2).mesh for _ in range(2))
    assert (one.points == other.points).all() and (one.cells["triangle"] == other.cells["triangle"]).all()


def test_an_airfoil_in_a_far_field():
    airfoil = meshcore.gallery.airfoil("rae2822")
    boundary = joined(circle(48, radius=15.0, centre=(0.5, 0.0)), airfoil)
    field = graded(airfoil, near=0.02, growth=1.3, far=3.0)
    rough, _ = front(boundary, size_field=field)
    mesh, report = front(boundary, size_field=field, smoothing=3)
    assert report.converged and not report.warnings
    invariants.assert_is_triangulation(mesh)
    invariants.lines_as_edges(mesh, boundary)
    assert (invariants.longest_edges(mesh) <= field(mesh.centroids)).all()
    assert report.quality["smallest angle (degree)"] >= 30
    beside = delaunay_refinement(boundary, size_field=field, smoothing=3, placement="off-centre").mesh
    assert mean_shape(mesh) > max(mean_shape(rough), mean_shape(beside))


def test_absurd_sizes_are_refused_before_memory_is_used():
    for keywords, name in (
        ({"size": 1e-9}, "size"),
        ({"max_area": 1e-12}, "max_area"),
        ({"regions": [[0.01, 0.01, 1, 1e-12]]}, "max_area"),
        ({"size_field": lambda p: np.full(len(p), 1e-7)}, "size_field"),
    ):
        with pytest.raises(InvalidInput, match=rf"{name}: would make about .* triangles; at most 50,000,000"):
            front(square_with_hole(), **keywords)


@pytest.mark.parametrize("field", [lambda p: np.zeros(len(p)), lambda p: p[:, 0] - 0.5, lambda p: p[:, 0] * np.nan])
def test_bad_size_fields_are_refused(field):
    with pytest.raises(InvalidInput, match="size_field"):
        front(square_with_hole(), size_field=field)


def test_relative_sizes_and_vertices_inside():
    boundary = square(4)
    boundary = Mesh([*boundary.points, [0.31, 0.42, 0]], {**boundary.cells, "vertex": [[boundary.n_points]]})
    mesh, report = front(boundary, size=Relative(0.05), smoothing=3)
    assert report.converged
    assert (mesh.points == [0.31, 0.42, 0]).all(axis=1).any()
    assert invariants.longest_edges(mesh).max() <= 0.05 * np.sqrt(2)


def test_progress_can_cancel():
    seen = []

    def stop(fraction, message):
        seen.append((fraction, message))
        return "front" not in message

    with pytest.raises(meshcore.Cancelled):
        front(square_with_hole(), size=0.01, progress=stop)
    assert all(0 <= fraction <= 1 for fraction, _ in seen)
