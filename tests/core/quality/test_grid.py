"""Quality of structured grids against grids whose angles, growth and wall spacing are known."""

import numpy as np
import pytest

from meshcore import InvalidInput, Mesh, StructuredGrid, gallery, o_grid, quality
from meshcore.quality.grid import MEASURES
from meshcore.sizing import hyperbolic_tangent
from tests import curved_grids as curved


def box(*axes):
    """A grid with lines along x, y (and z) at the places given."""
    axes = axes if len(axes) == 3 else (*axes, [0.0])
    return StructuredGrid(np.stack(np.meshgrid(*map(np.asarray, axes), indexing="ij"), axis=-1))


def sheared(angle, depth=1):
    """A box of cells of height 1, whose j lines lean to an angle with its i lines."""
    grid = box(np.arange(5.0), np.arange(4.0), np.arange(float(depth)))
    return grid.with_points(grid.points + grid.points[..., [1]] / np.tan(np.radians(angle)) * [1, 0, 0])


def polar(ratio=1.3, around=24):
    """Around the unit circle, clockwise, radii in geometric progression."""
    r, t = ratio ** np.arange(6.0), -2 * np.pi * np.arange(around + 1) / around
    points = np.stack([np.outer(np.cos(t), r), np.outer(np.sin(t), r)], axis=-1)
    points[-1] = points[0]
    return StructuredGrid(points, periodic=(True, False, False), names={"jmin": "wall"})


@pytest.mark.parametrize("depth", [1, 3])
@pytest.mark.parametrize("angle", [90, 60, 45, 10, 135])
def test_sheared_box(angle, depth):
    grid = sheared(angle, depth)
    sharp = min(angle, 180 - angle)
    np.testing.assert_allclose(quality.line_angle(grid), sharp)
    np.testing.assert_allclose(quality.face_angle(grid, "jmin"), sharp)
    np.testing.assert_allclose(quality.face_angle(grid, "jmax"), sharp)
    np.testing.assert_allclose(quality.first_height(grid, "jmin"), 1.0)
    np.testing.assert_allclose(quality.first_height(grid, "imax"), np.sin(np.radians(angle)))
    np.testing.assert_allclose(quality.measure(grid, "line_angle"), sharp)
    np.testing.assert_allclose(quality.measure(grid, "equiangle_skew"), (90 - sharp) / 90, atol=1e-12)
    np.testing.assert_allclose(quality.measure(grid, "line_growth"), 1.0)
    heights = quality.measure(grid, "wall_height")
    np.testing.assert_allclose(heights[1:-1, 0], 1.0)
    np.testing.assert_allclose(heights[0], np.sin(np.radians(angle)))
    assert np.isnan(heights[1:-1, 1:-1, :1]).all() == (depth == 1)
    np.testing.assert_allclose(np.nanmin(quality.measure(grid, "wall_angle")), sharp)


def test_polar_grid_with_geometric_radii():
    grid = polar(1.3)
    np.testing.assert_allclose(quality.line_angle(grid), 90.0)
    np.testing.assert_allclose(quality.growth_ratio(grid, 1)[:, 1:-1], 1.3)
    np.testing.assert_allclose(quality.growth_ratio(grid, 0), 1.0)  # across the cut, too
    assert np.isnan(quality.growth_ratio(grid, 1)[:, [0, -1]]).all()
    np.testing.assert_allclose(quality.first_height(grid, "jmin"), 0.3)
    np.testing.assert_allclose(quality.first_height(grid, "jmax"), 1.3**5 - 1.3**4)
    np.testing.assert_allclose(quality.face_angle(grid, "jmin"), 90.0)
    np.testing.assert_allclose(quality.measure(grid, "line_growth"), 1.3)
    # The aspect ratio of Verdict's axes: the mean radius' arc's chord over the step of the radii.
    chord = 2 * np.sin(np.pi / 24) * np.cos(np.pi / 24) ** 0
    radii = 1.3 ** np.arange(6.0)
    across = chord * 0.5 * (radii[1:] + radii[:-1])
    step = np.diff(radii) * np.cos(np.pi / 24)
    expected = np.maximum(across / step, step / across)
    np.testing.assert_allclose(quality.measure(grid, "max_edge_ratio")[0, :, 0], expected)
    for name in ("first_height_imin", "face_angle_imax", "growth_k", "first_height_kmin"):
        assert np.isnan(quality.measure(grid, name)).all(), name


def test_wall_grid_of_hyperbolic_tangents():
    first = 1e-3
    y = hyperbolic_tangent(20, first=first)
    grid = box(np.arange(4.0), y)
    steps = np.diff(y)
    np.testing.assert_allclose(quality.first_height(grid, "jmin"), first, rtol=1e-6)
    np.testing.assert_allclose(quality.growth_ratio(grid, 1)[0, 1:-1, 0], steps[1:] / steps[:-1])
    cells = quality.measure(grid, "growth_j")
    ratio = steps[1:] / steps[:-1]
    np.testing.assert_allclose(cells[0, :, 0], np.maximum([*ratio, 1.0], [1.0, *ratio]))
    np.testing.assert_allclose(quality.measure(grid, "line_growth"), cells)
    of_wall = quality.measure(grid, "first_height_jmin")
    np.testing.assert_allclose(of_wall[:, 0], first, rtol=1e-6)
    assert np.isnan(of_wall[:, 1:]).all()


@pytest.mark.parametrize("mapping", [curved.smooth, curved.annulus, curved.sphere, curved.bent_box, curved.shell])
def test_growth_of_the_grid_and_of_its_cells_as_a_mesh(mapping):
    """Two ways to one number: along index lines, and from facet to opposite facet."""
    grid = curved.grid(mapping, 6)
    along = np.fmax.reduce([quality.measure(grid, f"growth_{axis}") for axis in "ijk"])
    np.testing.assert_allclose(quality.measure(grid, "line_growth"), along, rtol=1e-9)


@pytest.mark.parametrize("depth", [1, 3])
def test_heights_of_the_grid_and_of_its_cells_as_a_mesh(depth):
    """On flat faces; on curved ones the normals are those of a point or of a facet."""
    rng = np.random.default_rng(8)
    grid = sheared(70, depth)
    points = grid.points.copy()
    points[1:-1, 1] += 0.2 * rng.random(points[1:-1, 1].shape) * [1, 1, 0]
    grid = grid.with_points(points)
    for grids, cells in (("first_height", "wall_height"), ("face_angle", "wall_angle")):
        of_faces = [
            quality.measure(grid, f"{grids}_{face}") for face in ("imin", "imax", "jmin", "jmax", "kmin", "kmax")
        ]
        np.testing.assert_allclose(quality.measure(grid, cells), np.fmin.reduce(of_faces), rtol=1e-9)


def test_prism_layers_have_lines_and_triangles_have_none():
    plane = gallery.triangulated_square(2)
    n, cells = plane.n_points, plane.get("triangle")
    points = np.concatenate([plane.points + [0, 0, z] for z in (0, 0.1, 0.35)])
    layers = Mesh(points, {"wedge": np.concatenate([np.hstack([cells + k * n, cells + (k + 1) * n]) for k in (0, 1)])})
    np.testing.assert_allclose(quality.measure(layers, "line_growth"), 2.5)
    np.testing.assert_allclose(np.nanmax(quality.wall_height(layers)), 0.25)
    assert not set(quality.measures("triangle")) & {"line_growth", "wall_angle", "wall_height"}
    assert {"line_growth", "wall_angle", "wall_height"} < set(quality.measures("quad8"))
    for name in ("line_growth", "wall_angle", "wall_height"):
        assert np.isnan(quality.measure(plane, name)).all()


def test_lines_end_where_triangles_begin():
    points = [[0, 0], [1, 0], [3, 0], [0, 1], [1, 1], [3, 1], [4, 0.5]]
    mesh = Mesh(points, {"triangle": [[2, 6, 5]], "quad": [[0, 1, 4, 3], [1, 2, 5, 4]]})
    np.testing.assert_allclose(quality.measure(mesh, "line_growth"), [np.nan, 2.0, 2.0])


def test_cells_without_size_have_the_worst_of_marks():
    grid = box(np.arange(4.0), np.arange(4.0))
    points = grid.points.copy()
    points[:, 1] = points[:, 0]
    grid = grid.with_points(points)
    assert np.isinf(quality.measure(grid, "growth_j")[:, 0]).all()
    assert np.isinf(quality.measure(grid, "line_growth")[:, 0]).all()
    assert (quality.face_angle(grid, "jmin") == 0).all()
    assert (quality.first_height(grid, "jmin") == 0).all()
    assert quality.line_angle(grid.with_points(0 * points)).max() == 0


@pytest.mark.parametrize("mapping", [curved.smooth, curved.bent_box])
def test_measures_do_not_see_place_turn_or_scale(mapping):
    turn, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    grid = curved.grid(mapping, 5)
    there = grid.with_points(1e3 * (grid.points @ turn.T + 0.5))
    for name in MEASURES:
        scale = 1e3 if "height" in name else 1.0
        np.testing.assert_allclose(
            quality.measure(there, name), scale * quality.measure(grid, name), rtol=1e-6, err_msg=name
        )


def test_the_report_of_a_grid_has_lines_for_directions_and_walls():
    report = quality.report(polar())
    for name in ("line_angle", "growth_i", "growth_j", "first_height_jmin", "face_angle_jmax", "equiangle_skew"):
        assert report.rows[name].count == (24 if "_jm" in name else 120), name
    assert not {"growth_k", "first_height_imin"} & report.rows.keys()
    assert report.rows["growth_j"].maximum == pytest.approx(1.3)
    assert report.rows["first_height_jmin"].minimum == pytest.approx(0.3)
    assert "growth_j" in str(report) and all(len(line) < 120 for line in str(report).splitlines())
    assert "line_angle" not in quality.report(polar().to_mesh()).rows


def test_the_worst_cells_of_a_grid_are_numbered_as_those_of_its_mesh():
    y = np.array([0.0, 1, 2, 3, 8, 9])
    grid = box(np.arange(4.0), y)
    row = quality.report(grid, "growth_j").rows["growth_j"]
    assert row.maximum == 5 and row.outside == 9
    same = quality.report(grid, "line_growth").rows["line_growth"]
    assert set(row.worst.tolist()) == set(same.worst.tolist())
    np.testing.assert_array_equal(row.worst[:9], same.worst[:9])


def test_quality_as_data_of_the_grid():
    grid, _ = o_grid(gallery.circle(24), radius=3, layers=8)
    marked = quality.with_quality(grid)
    assert set(marked.point_data) == {"growth_i", "growth_j", "line_angle"}
    assert {"line_angle", "growth_j", "first_height_jmin", "face_angle_jmin"} <= set(marked.cell_data)
    assert "growth_k" not in marked.cell_data
    assert set(quality.with_quality(curved.grid(curved.bent_box, 4)).point_data) > {"growth_k"}


@pytest.mark.parametrize(
    "wrong, text",
    [
        (lambda: quality.first_height(polar(), "top"), "face: 'top' is no face; faces are imin"),
        (lambda: quality.face_angle(polar(), "kmin"), "a surface has no faces across k"),
        (lambda: quality.measure(polar().to_mesh(), "growth_j"), "'growth_j' is a measure of a StructuredGrid only"),
        (lambda: quality.report(polar().to_mesh(), "line_angle"), "of a StructuredGrid only"),
        (lambda: quality.measure(polar(), "growth_l"), "no measure; try growth"),
        (lambda: quality.measures("grids"), "no kind of cell"),
    ],
)
def test_bad_input_is_named(wrong, text):
    with pytest.raises(InvalidInput, match=text):
        wrong()
