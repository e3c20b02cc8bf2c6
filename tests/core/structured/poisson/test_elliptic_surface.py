"""Elliptic grids of curved surfaces, by the operations: known grids, closed grids, poles, facets, what is refused."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery, io
from meshcore.cli import main
from meshcore.errors import GenerationFailed, InvalidGeometry, InvalidInput
from meshcore.geometry.closest import FacetedSurface
from meshcore.geometry.curves import lines_through
from meshcore.geometry.surfaces import ParametricSurface
from meshcore.structured.folds import folded_cells
from meshcore.structured.poisson.control_functions import from_boundary, from_poles
from meshcore.structured.poisson.winslow_surface import solved
from tests.core.structured.poisson.test_winslow_surface import on_sphere, rolled, square, wavy


def cylinder(n, m, rough=1.0):
    """A unit cylinder of height 2, closed along i, with points shifted about on it."""
    s, t = np.meshgrid(np.arange(n + 1) / n, np.arange(m + 1) / m, indexing="ij")
    inside = rough * np.sin(np.pi * t)
    angle = 2 * np.pi * s + 0.3 * inside * np.sin(6 * np.pi * s + 1)
    points = np.stack([np.cos(angle), np.sin(angle), 2 * t + 0.12 * inside * np.cos(8 * np.pi * s)], axis=-1)
    points[-1] = points[0]
    return points


def cap(n, m, rough=1.0, angle=0.5 * np.pi):
    """A unit sphere from its pole, j = 0, down to an angle, closed along i."""
    s, t = np.meshgrid(np.arange(n + 1) / n, np.arange(m + 1) / m, indexing="ij")
    inside = rough * np.sin(np.pi * t)
    turn = 2 * np.pi * s + 0.2 * inside * np.sin(6 * np.pi * s + 1)
    down = angle * (t + 0.06 * inside * np.cos(8 * np.pi * s))
    points = np.stack([np.cos(turn) * np.sin(down), np.sin(turn) * np.sin(down), np.cos(down)], axis=-1)
    points[-1], points[:, 0] = points[0], [0, 0, 1]
    return points


def test_a_closed_grid_on_a_cylinder_becomes_even():
    errors = []
    for n in (24, 48, 96):
        ring = mc.StructuredGrid(cylinder(n, n // 2), periodic=(True, False, False))
        grid, report = mc.elliptically_smoothed(ring, residual=1e-10)
        assert report.converged and not report.warnings and grid.periodic == (True, False, False)
        points = grid.points[:, :, 0]
        assert (points[0] == points[-1]).all() and (points[:, [0, -1]] == ring.points[:, [0, -1], 0]).all()
        errors.append(np.abs(points - cylinder(n, n // 2, 0.0)).max())
    # The surface is the spline through the points, which is the cylinder to fourth order.
    assert errors[-1] < 1e-5 and (np.log2(np.divide(errors[:-1], errors[1:])) > 3).all(), errors


def test_a_closed_grid_is_the_same_however_it_is_given():
    points = cylinder(24, 12)
    grid, _ = mc.elliptically_smoothed(mc.StructuredGrid(points, periodic=(True, False, False)), residual=1e-10)
    open_, _ = mc.elliptically_smoothed(mc.StructuredGrid(points), residual=1e-10)
    assert np.array_equal(open_.points, grid.points)
    across, _ = mc.elliptically_smoothed(mc.StructuredGrid(points.swapaxes(0, 1)), residual=1e-10)
    np.testing.assert_allclose(across.points[:, :, 0].swapaxes(0, 1), grid.points[:, :, 0], atol=1e-12)
    assert across.periodic == (False, True, False)
    # Where it is cut does not matter.
    moved = np.concatenate([points[7:-1], points[:8]])
    turned, _ = mc.elliptically_smoothed(mc.StructuredGrid(moved), residual=1e-10)
    np.testing.assert_allclose(turned.points[:-8], grid.points[7:-1], atol=1e-7)
    mesh, _ = mc.elliptically_smoothed(grid.to_mesh(), residual=1e-10)
    assert mesh.periodic == grid.periodic and mesh.shape == grid.shape


def test_a_pole_is_kept_and_circles_around_it_become_even():
    errors = []
    for n in (32, 64):
        grid, report = mc.elliptically_smoothed(mc.StructuredGrid(cap(n, n // 2, angle=0.5)), residual=1e-10)
        assert report.converged and "one point" in report.warnings[0]
        points = grid.points[:, :, 0]
        assert (points[:, 0] == [0, 0, 1]).all() and not folded_cells(points).any()
        errors.append(np.abs(points - cap(n, n // 2, 0.0, 0.5)).max())
    assert errors[-1] < 5e-3, errors  # even circles are exact in a plane; a cap of 30 degrees is nearly one
    kept, report = mc.elliptically_smoothed(mc.StructuredGrid(cap(40, 20)), control="boundary spacing")
    assert report.converged and not report.warnings
    down = np.degrees(np.arccos(np.clip(kept.points[:, :, 0, 2], -1, 1)))
    assert np.ptp(down[:-1], axis=0).max() < 0.1 and np.diff(down[0]).min() > 3  # of 4.5 degrees each


def test_even_circles_in_a_plane_obey_the_equations_with_the_control_of_a_pole():
    angle, radius = np.meshgrid(2 * np.pi * np.arange(25) / 24, np.arange(13) / 12, indexing="ij")
    fan = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle], axis=-1)
    fan[-1], fan[:, 0] = fan[0], 0
    expected = from_poles(fan)
    np.testing.assert_allclose(np.tanh(expected[1, 0, 1:] / 2), -0.5 / np.arange(1, 13))
    np.testing.assert_allclose(from_boundary(fan, cyclic=True)[1, :, 1:3], expected[1, :, 1:3], atol=0.05)
    assert from_poles(fan[:, 1:]) is None


def test_a_sphere_with_two_poles_is_held_at_its_cut():
    sphere = cap(32, 24, angle=np.pi)
    sphere[:, -1] = [0, 0, -1]
    grid, report = mc.elliptically_smoothed(mc.StructuredGrid(sphere))
    assert report.converged and "two poles" in report.warnings[0]
    assert (grid.points[0, :, 0] == sphere[0]).all() and not folded_cells(grid.points[:, :, 0]).any()
    assert abs(np.linalg.norm(grid.points, axis=-1) - 1).max() < 1e-3


def test_a_torus_is_held_at_one_line():
    s, t = np.meshgrid(2 * np.pi * np.arange(33) / 32, 2 * np.pi * np.arange(17) / 16, indexing="ij")
    s = s + 0.1 * np.sin(t) * np.sin(3 * s)
    torus = np.stack([(2 + np.cos(t)) * np.cos(s), (2 + np.cos(t)) * np.sin(s), np.sin(t)], axis=-1)
    grid, report = mc.elliptically_smoothed(mc.StructuredGrid(torus))
    assert report.converged and "closed both ways" in report.warnings[0]
    assert (grid.points[:, 0] == grid.points[:, -1]).all()
    assert (
        np.abs(
            np.hypot(np.hypot(*grid.points[:, :, 0, :2].reshape(-1, 2).T) - 2, grid.points[..., 2].ravel()) - 1
        ).max()
        < 1e-3
    )


def test_control_carries_the_boundarys_spacing_inside():
    s, t = np.meshgrid(np.linspace(0, 1, 25), np.linspace(0, 1, 21) ** 2, indexing="ij")
    exact = rolled(1.5 * s, t)
    rough = exact.copy()
    rough[1:-1, 1:-1] = rolled(1.5 * s + 0.02 * np.sin(6 * t), t * (1 + 0.1 * np.sin(9 * s) * (1 - t)))[1:-1, 1:-1]
    grid, report = mc.elliptically_smoothed(mc.StructuredGrid(rough), control="boundary spacing")
    even, _ = mc.elliptically_smoothed(mc.StructuredGrid(rough))
    heights = np.diff(grid.points[12, :, 0, 2])
    assert report.converged
    assert abs(heights[0] / np.diff(t[12])[0] - 1) < 0.3 < 5 < np.diff(even.points[12, :, 0, 2])[0] / heights[0]


def test_user_functions_and_attractors_are_heard():
    ring = mc.StructuredGrid(cylinder(24, 12, 0.0))
    drawn, _ = mc.elliptically_smoothed(ring, attractors=[mc.Attractor(j=3, strength=0.3)])
    pushed, _ = mc.elliptically_smoothed(ring, control_functions=(0.0, -0.2))
    for grid in (drawn, pushed):
        heights = grid.points[:-1, :, 0, 2]
        assert np.ptp(heights, axis=0).max() < 1e-6 and np.abs(np.diff(heights[0]) - 1 / 6).max() > 0.02


def test_the_grid_on_facets_is_mercators_to_second_order_of_the_facets():
    errors = []
    for k in (20, 40, 80):
        u, v = np.meshgrid(np.linspace(-0.6, 2.0, k + 1), np.linspace(-1.3, 1.3, k + 1), indexing="ij")
        exact = square(24, 24) * [1.2, 1.6] - [0, 0.7]
        exact[..., 1] = 2 * np.arctan(np.exp(exact[..., 1])) - np.pi / 2
        start = exact.copy()
        start[1:-1, 1:-1] += 0.03
        start, exact = (on_sphere(*np.moveaxis(x, -1, 0)) for x in (start, exact))
        facets = mc.StructuredGrid(on_sphere(u, v))
        grid, report = mc.elliptically_smoothed(mc.StructuredGrid(start), facets, residual=1e-6)
        assert report.converged and "off the surface" in report.warnings[0]
        assert FacetedSurface(facets).closest(grid.points.reshape(-1, 3)).distance.max() < 1e-14
        errors.append(np.linalg.norm(grid.points[:, :, 0] - exact, axis=-1).max())
    assert errors[-1] < 5e-4 and (np.log2(np.divide(errors[:-1], errors[1:])) > 1.7).all(), errors


def test_flat_facets_give_the_planar_grid_and_unfold():
    x = wavy(30, 22)
    folded = np.stack([*np.moveaxis(x, -1, 0), 0 * x[..., 0]], axis=-1)
    folded[1:-1, 1:-1, 0] += 0.05 * np.sin(40 * folded[1:-1, 1:-1, 1])
    planar, _ = mc.elliptically_smoothed(mc.StructuredGrid(folded), residual=1e-10)
    plate = mc.Mesh([[-2, -2, 0], [3, -2, 0], [3, 3, 0], [-2, 3, 0]], {"quad": [[0, 1, 2, 3]]})
    grid, report = mc.elliptically_smoothed(mc.StructuredGrid(folded), plate, residual=1e-10)
    assert report.converged and not report.warnings
    np.testing.assert_allclose(grid.points, planar.points, atol=1e-9)


def test_a_closed_grid_on_facets():
    facets = mc.StructuredGrid(cylinder(90, 30, 0.0)).to_mesh()
    grid, report = mc.elliptically_smoothed(mc.StructuredGrid(cylinder(36, 18)), facets)
    assert report.converged and grid.periodic == (True, False, False) and (grid.points[0] == grid.points[-1]).all()
    assert np.abs(grid.points[:, :, 0] - cylinder(36, 18, 0.0)).max() < 5e-3


def test_a_grid_that_folds_on_facets_is_refused():
    """A corner of 270 degrees on a cylinder: its cell cannot be sound."""
    s, t = np.moveaxis(square(16, 16), -1, 0)
    bent = np.stack([s - 0.8 * s * t, t - 0.8 * s * t], axis=-1)
    points = rolled(*np.moveaxis(bent, -1, 0))
    facets = mc.StructuredGrid(rolled(*np.moveaxis(square(40, 40) * 3 - 1, -1, 0)))
    for surface in (None, facets):
        with pytest.raises(GenerationFailed, match="folded or flat") as error:
            mc.elliptically_smoothed(mc.StructuredGrid(points), surface)
        assert len(error.value.cells) and error.value.partial.shape == (17, 17, 1)


def test_cells_that_bridge_a_gap_are_told():
    """A thin plate: the grid goes over its edge with cells that are larger than it is thick."""
    plate = mc.StructuredGrid(np.array([[[0, y, 0], [1, y, 0], [1, y, 0.02], [0, y, 0.02]] for y in (0, 1.0)]))
    s, t = np.meshgrid(np.linspace(0, 1, 8), np.linspace(0, 1, 8), indexing="ij")
    over = np.stack([1 - 0.7 * np.abs(2 * s - 1), t, np.where(s < 0.5, 0.0, 0.02)], axis=-1)
    try:
        _, report = mc.elliptically_smoothed(mc.StructuredGrid(over), plate)
    except GenerationFailed:
        return
    assert any("leave the surface" in warning for warning in report.warnings), report.warnings


def test_what_cannot_be_had_on_a_surface_is_refused():
    ring = mc.StructuredGrid(cylinder(24, 12))
    with pytest.raises(InvalidInput, match="slide along walls of planar grids only"):
        mc.elliptically_smoothed(ring, walls="south", sliding=True)
    with pytest.raises(InvalidInput, match="cut, not a wall"):
        mc.elliptically_smoothed(ring, walls="west")
    with pytest.raises(InvalidInput, match="south is one point"):
        mc.elliptically_smoothed(mc.StructuredGrid(cap(24, 12)), walls="south")
    with pytest.raises(InvalidGeometry, match="none of which has an area"):
        mc.elliptically_smoothed(ring, mc.Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], {"triangle": [[0, 1, 2]]}))
    with pytest.raises(InvalidInput, match="surface"):
        mc.elliptically_smoothed(ring, gallery.circle())


def torus_start(n, m):
    """Parameters of the patch of `gallery.sides_on_torus`, filled by transfinite interpolation in them."""
    s, t = np.moveaxis(square(n, m), -1, 0)
    across, along = 0.15 * np.sin(2 * np.pi * s), 0.12 * np.sin(2 * np.pi * t)
    u = 1.6 * s + along
    v = 1.8 * t - 0.4 + across * (1 - 2 * t)
    return np.stack([u, v], axis=-1)


def test_a_patch_on_a_scan_is_that_of_the_smooth_surface():
    """To second order of the facets, down to the difference between sides on facets and on the surface itself."""
    x = torus_start(24, 20)
    smooth = ParametricSurface(gallery.on_bumpy_torus, (-1, 3), (-2, 3))
    parameters, outcome = solved(smooth, x, tolerance=1e-9)
    exact = smooth.points(*np.moveaxis(parameters, -1, 0))
    assert outcome.converged
    errors = []
    for n in (60, 120, 240):
        torus = gallery.bumpy_torus(n, n // 2)
        grid, report = mc.elliptic(*gallery.sides_on_torus(24, 20), torus, control="none", residual=1e-5)
        assert report.converged and "the sides lay up to" in report.warnings[0]
        assert FacetedSurface(torus).closest(grid.points.reshape(-1, 3)).distance.max() < 1e-13
        errors.append(np.linalg.norm(grid.points[:, :, 0] - exact, axis=-1).max())
    assert errors[-1] < 5e-3 and (np.log2(np.divide(errors[:-1], errors[1:])) > 1.6).all(), errors


def test_transfinite_points_lie_on_the_scan_and_folds_there_are_refused():
    torus, sides = gallery.bumpy_torus(), gallery.sides_on_torus()
    grid, report = mc.transfinite(*sides, surface=torus)
    assert FacetedSurface(torus).closest(grid.points.reshape(-1, 3)).distance.max() < 1e-13
    assert len(report.warnings) == 1 and grid.names == {
        "jmin": "south",
        "imax": "east",
        "jmax": "north",
        "imin": "west",
    }
    quiet, report = mc.transfinite(*sides, surface=torus, tolerance=0.1)
    assert not report.warnings and np.array_equal(quiet.points, grid.points)
    elliptic, _ = mc.elliptic(*sides, surface=torus, control="none")
    assert np.array_equal(elliptic.points[0], grid.points[0]) and not np.array_equal(elliptic.points, grid.points)


def test_overspill_on_a_scan_is_cured_by_smoothing_there():
    s = np.linspace(0, 1, 25)
    dent = 1.3 * np.sin(np.pi * s) ** 2  # the south side rises over the chord of the north
    u, low, high = 1.6 * (s - 0.5), dent - 0.8, 0.9 + 0 * s
    across = np.linspace(-0.8, 0.9, 25)
    ends = (u, low), (0.8, across), (u, high), (-0.8, across)
    sides = [gallery.on_bumpy_torus(*np.broadcast_arrays(a, b)) for a, b in ends]
    with pytest.raises(GenerationFailed, match="folded or flat"):
        mc.transfinite(*sides, surface=gallery.bumpy_torus(), blending="linear")
    grid, report = mc.transfinite(*sides, surface=gallery.bumpy_torus(), blending="linear", cure="smoothing")
    assert any("smoothed on the surface" in warning for warning in report.warnings)
    assert FacetedSurface(gallery.bumpy_torus()).closest(grid.points.reshape(-1, 3)).distance.max() < 1e-13


def test_sides_in_space_are_filled_by_their_own_surface():
    errors = []
    for n in (12, 24, 48):
        x = wavy(n, n)
        sides = [rolled(*side.T) for side in (x[:, 0], x[-1], x[:, -1], x[0])]
        grid, report = mc.elliptic(*sides, control="none")
        assert report.converged and not folded_cells(grid.points[:, :, 0]).any()
        errors.append(abs(np.hypot(grid.points[..., 0], grid.points[..., 1]) / 0.7 - 1).max())
    assert max(errors) < 0.05  # the surface is the transfinite one, which is near the cylinder
    with pytest.raises(InvalidInput, match="biharmonic"):
        mc.elliptic(*sides, equation="biharmonic")
    with pytest.raises(InvalidInput, match="repeat"):
        mc.elliptic(*sides, periodic=True)


def test_a_ridge_is_crossed_without_folds_or_told():
    """A roof of 60 degrees: the patch crosses its ridge aslant."""
    for angle in (30, 60, 80):
        rise = np.tan(np.radians(angle))
        corners = [[x, y, -abs(x) * rise] for y in (-2, 2) for x in (-2, 0, 2)]
        roof = mc.Mesh(corners, {"quad": [[0, 1, 4, 3], [1, 2, 5, 4]]})
        ends = np.array([[-1, -0.6], [1, -1.0], [0.8, 1], [-0.7, 0.9]])

        sides = []
        for a, b in ((0, 1), (1, 2), (3, 2), (0, 3)):
            x, y = (ends[a] + np.linspace(0, 1, 21)[:, None] * (ends[b] - ends[a])).T
            sides.append(np.column_stack([x, y, -abs(x) * rise]))
        grid, report = mc.elliptic(*sides, roof, control="none")
        assert report.converged
        assert FacetedSurface(roof).closest(grid.points.reshape(-1, 3)).distance.max() < 1e-13
        x, y = grid.points[:, :, 0, 0], grid.points[:, :, 0, 1]
        flat = np.stack([x, y, 0 * x], axis=-1)  # seen from above, where it must not fold either
        assert not folded_cells(flat).any()


def test_closed_loops_and_walls_on_a_surface():
    south, east, north, west = gallery.sides_on_torus(16, 16)
    loop = np.concatenate([south[:-1], east[:-1], north[:0:-1], west[::-1]])
    corners = (0, 16, 32, 48)
    grid, report = mc.elliptic(loop, surface=gallery.bumpy_torus(), corners=corners)
    assert report.converged and grid.shape == (17, 17, 1)


def test_the_command_line_takes_a_surface(tmp_path):
    sides, torus = gallery.sides_on_torus(12, 10), gallery.bumpy_torus(48, 24)
    files = []
    for name, side in zip(("south", "east", "north", "west"), sides, strict=True):
        files.append(str(tmp_path / f"{name}.vtk"))
        io.write(files[-1], lines_through(side))
    io.write(tmp_path / "torus.ply", torus)
    out = tmp_path / "grid.vts"
    assert main(["elliptic", *files, "--surface", str(tmp_path / "torus.ply"), "-o", str(out)]) == 0
    expected, _ = mc.elliptic(*sides, surface=io.read(tmp_path / "torus.ply"))
    np.testing.assert_allclose(io.read(out).points, expected.points, atol=1e-12)


def test_few_cycles_do_on_facets_and_around_a_waist():
    """Where tangents jumped from node to node, or lines were swept once, cycles stalled or went astray."""
    torus = gallery.bumpy_torus()
    _, report = mc.elliptic(*gallery.sides_on_torus(64, 64), torus, control="none", residual=1e-6)
    assert report.converged and report.iterations <= 6, report.history
    for n in (32, 64):
        _, report = mc.elliptically_smoothed(gallery.rough_tube(n, n // 2))
        assert report.converged and report.iterations <= 12, report.history


def test_a_sheet_dropped_on_convex_facets_does_not_collapse():
    """Far outside, whole wedges of space have the closest point on one edge."""
    u, v = np.meshgrid(np.linspace(0, 0.8, 41), np.linspace(-0.4, 0.4, 41), indexing="ij")
    coarse = np.meshgrid(np.linspace(-0.5, 1.4, 9), np.linspace(-1, 1, 9), indexing="ij")
    facets = FacetedSurface(mc.StructuredGrid(on_sphere(*coarse)))
    sheet = 1.4 * on_sphere(u, v)
    spread = {}
    for name in ("closest", "dropped"):
        points = getattr(facets, name)(sheet.reshape(-1, 3)).points.reshape(sheet.shape)
        spread[name] = np.linalg.norm(np.diff(points, axis=0), axis=-1).min() / 0.02
    assert spread["closest"] < 0.1 < 0.6 < spread["dropped"]


def test_a_cone_that_is_folded_beside_its_apex_is_an_error_of_its_own():
    """Parameters run away there, farther than single precision remembers."""
    u, v = np.meshgrid(np.linspace(0, 3, 21), np.linspace(0, 1, 25), indexing="ij")
    points = np.stack([v * np.cos(u), v * np.sin(u), v], axis=-1)
    points[1:-1, 1:-1] += np.random.default_rng(1).normal(0, 0.004, points[1:-1, 1:-1].shape)
    with pytest.raises(GenerationFailed, match="folded or flat"):
        mc.elliptically_smoothed(mc.StructuredGrid(points[:, :, None]))


def steep_bump(n):
    x, y = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n), indexing="ij")
    bump = np.stack([x, y, 0.8 * (np.sin(np.pi * x) * np.sin(np.pi * y)) ** 2], axis=-1)
    return mc.StructuredGrid(bump[:, :, None])


@pytest.mark.parametrize("draped", [False, True])
@pytest.mark.parametrize("control", ["none", "boundary spacing"])
def test_on_a_steep_bump_grids_converge_and_stay_symmetric(draped, control):
    surface = steep_bump(97) if draped else None
    grid, report = mc.elliptically_smoothed(steep_bump(33), surface, control=control)
    assert report.converged and len(report.history) < 8
    height = grid.points[:, :, 0, 2]
    assert abs(height - height[::-1]).max() < 1e-5 and abs(height - height.T).max() < 1e-5
