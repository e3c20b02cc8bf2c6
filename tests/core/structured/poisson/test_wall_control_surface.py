"""Angles and first heights at walls of curved grids: as in the plane where that is rolled up, as asked elsewhere."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery
from meshcore.structured.algebraic.quad_nets import grid_of
from meshcore.structured.poisson.wall_control_surface import developed
from tests.core.structured.poisson.test_winslow_surface import on_sphere, rolled, square

ASKED = {"walls": "south", "first_height": 0.01}


def wavy_wall(n=48, m=32):
    s, t = np.moveaxis(square(n, m), -1, 0)
    return np.stack([2 * s, t + 0.2 * np.sin(2 * np.pi * s) * (1 - t)], axis=-1)


def test_a_rolled_up_plane_has_the_planar_grid():
    flat = wavy_wall()
    planar, report = mc.elliptically_smoothed(mc.StructuredGrid(flat), **ASKED)
    curved, also = mc.elliptically_smoothed(mc.StructuredGrid(rolled(*np.moveaxis(flat, -1, 0))), **ASKED)
    assert report.converged and also.converged
    expected = rolled(planar.points[..., 0], planar.points[..., 1])
    # Both stop within a degree and 5 % of the height.
    assert np.linalg.norm(curved.points - expected, axis=-1).max() < 3e-3
    assert also.quality["error of wall angles (degree)"] < 1 and also.quality["error of first heights (%)"] < 5


def test_a_developed_strip_of_a_rolled_plane_is_the_plane():
    flat = wavy_wall(96, 8)
    u, v = np.moveaxis(flat, -1, 0)
    normals = np.stack([np.cos(u / 0.7), np.sin(u / 0.7), 0 * u], axis=-1)
    for side, wall in (("south", np.s_[:, 0]), ("north", np.s_[:, -1]), ("west", np.s_[0]), ("east", np.s_[-1])):
        strip = developed(rolled(u, v), normals, side)
        length = np.linalg.norm(np.diff(flat[wall], axis=0), axis=1)
        np.testing.assert_allclose(np.linalg.norm(np.diff(strip[:, :, 0], axis=1), axis=0), length, rtol=1e-3)
        ends = flat[wall][-1] - flat[wall][0]
        assert abs(np.linalg.norm(strip[:, -1, 0] - strip[:, 0, 0]) / np.linalg.norm(ends) - 1) < 2e-3
        edge = strip[:, :, 1] - strip[:, :, 0]
        ahead = np.gradient(strip[:, :, 0], axis=1)
        assert (ahead[0] * edge[1] - ahead[1] * edge[0] > 0).all()  # to the left


@pytest.mark.parametrize("walls", ["south", "south and north"])
def test_walls_around_a_waisted_tube(walls):
    tube = grid_of(gallery.rough_tube(48, 32), "grid")
    grid, report = mc.elliptically_smoothed(tube, walls=walls, first_height=0.03)
    assert report.converged, report.warnings
    heights = np.linalg.norm(grid.points[:, 1, 0] - grid.points[:, 0, 0], axis=-1)
    assert np.abs(heights / 0.03 - 1).max() < 0.05
    edge, along = grid.points[1:-1, 1, 0] - grid.points[1:-1, 0, 0], grid.points[2:, 0, 0] - grid.points[:-2, 0, 0]
    cosine = (edge * along).sum(axis=-1) / np.linalg.norm(edge, axis=-1) / np.linalg.norm(along, axis=-1)
    assert np.degrees(np.abs(np.arcsin(cosine))).max() < 1.1
    assert (grid.points[0] == grid.points[-1]).all()


def test_a_wall_on_facets():
    u, v = np.meshgrid(np.linspace(-0.6, 2.0, 61), np.linspace(-1.3, 1.3, 61), indexing="ij")
    s, t = np.moveaxis(square(40, 32), -1, 0)
    start = on_sphere(1.2 * s, 0.9 * t + 0.1 * np.sin(2 * np.pi * s) * (1 - t))
    facets = mc.StructuredGrid(on_sphere(u, v))
    grid, report = mc.elliptically_smoothed(mc.StructuredGrid(start), facets, walls="south", first_height=0.01)
    assert report.converged and report.quality["error of first heights (%)"] < 5
    heights = np.linalg.norm(grid.points[5:-5, 1, 0] - grid.points[5:-5, 0, 0], axis=-1)
    assert np.abs(heights / 0.01 - 1).max() < 0.05


def test_another_angle():
    _, report = mc.elliptically_smoothed(gallery.rough_tube(48, 24), walls="south", wall_angle=70.0)
    assert report.converged and report.quality["error of wall angles (degree)"] < 1
