"""Lattice fill: limits, angles and lines kept, fewer triangles than off-centres need, no harm where nothing fits."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshcore import InvalidInput, Mesh, delaunay_refinement, quality
from meshcore.gallery import circle, joined, l_shape, square, square_with_hole
from tests.core.unstructured import invariants
from tests.core.unstructured.planar_graphs import comb, frame_mesh, framed_segments, loops, star_polygons
from tests.core.unstructured.test_refinement import MODELS, assert_small_angles_are_excused


def areas(mesh):
    p = mesh.points[mesh.cells["triangle"]][:, :, :2]
    u, v = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    return 0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])


def limit_of(boundary, triangles):
    """The largest area that makes about so many triangles."""
    return float(invariants.area(delaunay_refinement(boundary, min_angle=0).mesh)) / triangles


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("min_angle", [0.0, 20.0, 31.0])
@pytest.mark.parametrize("triangles", [30, 3000])
def test_limits_of_area(name, min_angle, triangles):
    boundary = MODELS[name]
    max_area = limit_of(boundary, triangles)
    mesh, report = delaunay_refinement(boundary, min_angle=min_angle, max_area=max_area, placement="lattice")
    assert report.converged and not report.warnings
    invariants.assert_is_triangulation(mesh)
    invariants.assert_constrained_delaunay(mesh, boundary)
    assert areas(mesh).max() <= max_area
    assert invariants.angles(mesh).min() >= min_angle - 1e-9
    assert (mesh.points[: boundary.n_points] == boundary.points).all()
    plain, _ = delaunay_refinement(boundary, min_angle=min_angle, max_area=max_area, placement="off-centre")
    assert float(invariants.area(mesh)) == pytest.approx(float(invariants.area(plain)), rel=1e-13)
    assert invariants.euler(mesh) == invariants.euler(plain)
    counts = report.counts
    added = counts["points added on lines"] + counts["points added inside"]
    assert mesh.n_points == boundary.n_points + added == counts["points"]


@pytest.mark.parametrize("name", ["square", "square with hole", "l", "discs"])
def test_fewer_and_rounder_triangles(name):
    boundary = MODELS[name]
    max_area = limit_of(boundary, 3000)
    mesh = delaunay_refinement(boundary, max_area=max_area, placement="lattice").mesh
    plain = delaunay_refinement(boundary, max_area=max_area, placement="off-centre").mesh
    assert mesh.n_cells < 0.8 * plain.n_cells
    assert quality.summary(mesh)["mean radius ratio"] < 1.05 < quality.summary(plain)["mean radius ratio"]
    automatic = delaunay_refinement(boundary, max_area=max_area).mesh
    assert (automatic.cells["triangle"] == mesh.cells["triangle"]).all()


@pytest.mark.parametrize("name", MODELS)
def test_limits_of_length(name):
    boundary = MODELS[name]
    size = 1.5 * np.sqrt(limit_of(boundary, 2000))
    mesh, report = delaunay_refinement(boundary, size=size, placement="lattice")
    assert report.converged
    invariants.assert_is_triangulation(mesh)
    invariants.assert_constrained_delaunay(mesh, boundary)
    assert invariants.longest_edges(mesh).max() <= size
    assert invariants.angles(mesh).min() >= 30 - 1e-9
    assert mesh.n_cells <= delaunay_refinement(boundary, size=size, placement="off-centre").mesh.n_cells


def test_each_region_has_its_own_lattice():
    """Three strips: a fine one, a coarse one, one without a limit."""
    points = [(0, 0), (3, 0), (3, 1), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)]
    lines = [(0, 4), (4, 6), (6, 1), (1, 2), (2, 7), (7, 5), (5, 3), (3, 0), (4, 5), (6, 7)]
    regions = [[0.5, 0.5, 7, 0.0005], [1.5, 0.5, 8, 0.01], [2.5, 0.5, 9, -1]]
    mesh, report = delaunay_refinement(
        Mesh(np.array(points, float), {"line": lines}), regions=regions, holes=[[9, 9]], placement="lattice"
    )
    assert report.converged and report.warnings == ["hole 0 at (9, 9) lies outside and has no effect"]
    invariants.assert_is_triangulation(mesh)
    for tag, most in ((7, 0.0005), (8, 0.01), (9, 1.0)):
        own = mesh.selected(mesh.cell_data["region"] == tag)
        assert float(invariants.area(own)) == pytest.approx(1, rel=1e-12)
        assert areas(own).max() <= most
    count = [int((mesh.cell_data["region"] == tag).sum()) for tag in (7, 8, 9)]
    assert 2000 < count[0] < 3200 and 100 < count[1] < 400 and count[2] < 200


@settings(max_examples=30)
@given(framed_segments(most=8), st.sampled_from([20.0, 31.0]), st.sampled_from([0.05, 0.5, 5.0]))
def test_random_segments(boundary, min_angle, max_area):
    mesh, report = delaunay_refinement(
        boundary, min_angle=min_angle, max_area=max_area, holes=[[-1, -1]], placement="lattice"
    )
    assert report.converged
    invariants.assert_is_triangulation(mesh)
    invariants.lines_as_edges(mesh, boundary)
    assert float(invariants.area(mesh)) == pytest.approx(64, rel=1e-14)
    assert areas(mesh).max() <= max_area
    assert mesh.n_cells < 20_000


@settings(max_examples=30)
@given(star_polygons(), st.sampled_from([0.001, 0.02]), st.integers(-20, 20))
def test_star_polygons(polygon, share, exponent):
    boundary = loops(np.ldexp(polygon, exponent))
    max_area = share * 4.0**exponent
    mesh, report = delaunay_refinement(boundary, max_area=max_area, placement="lattice")
    assert report.converged
    invariants.assert_is_triangulation(mesh)
    exact = float(invariants.shoelace(boundary.points[:, :2].tolist()))
    assert float(invariants.area(mesh)) == pytest.approx(exact, rel=1e-12)
    assert areas(mesh).max() <= max_area
    assert mesh.n_cells < 20_000
    assert_small_angles_are_excused(mesh, boundary, 30.0)


@pytest.mark.parametrize("height", [1e-1, 1e-3])
@pytest.mark.parametrize("placement", ["lattice", "automatic"])
def test_thin_domains(height, placement):
    """Where hardly a site fits in, the lines alone give the points."""
    boundary = square().transformed(np.diag([1.0, height, 1, 1]))
    mesh, report = delaunay_refinement(boundary, max_area=height / 20, placement=placement)
    assert report.converged
    invariants.assert_is_triangulation(mesh)
    invariants.assert_constrained_delaunay(mesh, boundary)
    plain = delaunay_refinement(boundary, max_area=height / 20, placement="off-centre").mesh
    assert mesh.n_cells <= 1.1 * plain.n_cells + 20


def test_a_slanted_thread_in_a_large_box():
    """A domain that fills little of its bounding box: as many sites as fit there would fill the memory."""
    boundary = loops([(0, 0), (1, 0.0), (1000, 999), (1000, 1000), (999, 1000), (0, 1)])
    mesh, report = delaunay_refinement(boundary, size=0.2)
    assert report.converged
    assert invariants.longest_edges(mesh).max() <= 0.2
    assert quality.validate(mesh) == []


def test_tiny_features_beside_large_triangles():
    boundary = joined(square(), circle(200, radius=0.002, centre=(0.31, 0.62)))
    mesh, report = delaunay_refinement(boundary, max_area=0.001, placement="lattice")
    assert report.converged and not report.warnings
    invariants.assert_is_triangulation(mesh)
    assert invariants.angles(mesh).min() >= 30 - 1e-9
    plain = delaunay_refinement(boundary, max_area=0.001, placement="off-centre").mesh
    assert mesh.n_cells < plain.n_cells


def test_lines_on_the_lattice_itself():
    """Lines along rows and columns, at multiples of the spacing."""
    lines = [((1, k), (7, k)) for k in range(1, 8)] + [((1, 7), (1, 8))]
    boundary = frame_mesh(8, lines)
    for size in (1.0, 0.5, 0.25):
        mesh, report = delaunay_refinement(boundary, size=size, placement="lattice")
        assert report.converged
        invariants.assert_is_triangulation(mesh)
        assert invariants.longest_edges(mesh).max() <= size


@pytest.mark.parametrize(
    "keywords, message",
    [
        ({"min_angle": 32}, "angles up to 31 degrees, got min_angle = 32"),
        ({"size": 0.1, "size_field": lambda p: p[:, 0] + 1}, "but sizes vary"),
        ({"size": 0.1, "split_boundary": False}, "split_boundary is off"),
        ({}, "needs size, max_area or an area in regions"),
        ({"size": 1e-9}, "would make about"),
        ({"max_area": 1e-12}, "would make about"),
    ],
)
def test_what_a_lattice_cannot_do_is_refused(keywords, message):
    with pytest.raises(InvalidInput, match=message):
        delaunay_refinement(square_with_hole(), placement="lattice", **keywords)


@pytest.mark.parametrize("size", [10.0, 1e300])
def test_limits_without_effect(size):
    mesh, report = delaunay_refinement(l_shape(3), size=size, placement="lattice")
    assert report.converged
    assert mesh.n_cells == delaunay_refinement(l_shape(3)).mesh.n_cells


def test_tilted_far_and_scaled():
    flat = square_with_hole()
    turn = np.linalg.qr(np.random.default_rng(11).normal(size=(3, 3)))[0]
    for points in (
        flat.points @ turn.T + [3.0, -2.0, 5.0],
        flat.points * 2.0**200,
        flat.points * 1e-3 + [1e5, -1e5, 0],
    ):
        boundary = flat.with_points(points)
        mesh, report = delaunay_refinement(boundary, size=0.03 * np.ptp(points[:, 0]), placement="lattice")
        assert report.converged
        assert quality.validate(mesh) == []
        assert quality.summary(mesh)["smallest angle (degree)"] > 29.9


def test_comb_is_the_same_twice():
    one, other = (delaunay_refinement(loops(comb(6, 4.0)), size=0.1, placement="lattice").mesh for _ in range(2))
    assert (one.points == other.points).all() and (one.cells["triangle"] == other.cells["triangle"]).all()
