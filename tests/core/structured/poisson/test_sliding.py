"""Points that slide along a side until lines leave it at right angles."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import Wall, gallery
from meshcore.structured.poisson.sliding import _spread
from meshcore.structured.poisson.wall_control import measured
from tests.core.structured.poisson.test_wall_control import run
from tests.core.structured.poisson.test_winslow import annulus, between


def rectangle(n):
    """Two units wide; the points above stand askew."""
    s = np.linspace(0, 1, n)
    south, north = np.column_stack([2 * s, 0 * s]), np.column_stack([2 * s**1.5, 0 * s + 1])
    west = np.column_stack([0 * s, s])
    return between(south, west + [2, 0], north, west)


@pytest.mark.parametrize("n", [17, 40, 65])
def test_points_of_a_rectangle_come_to_stand_above_each_other(n):
    found, went = run(rectangle(n), [Wall("north", slides=True)])
    assert went.converged and len(went.history) < 14
    assert np.abs(found[:, -1, 0] - np.linspace(0, 2, n)).max() < 5e-3
    assert (found[:, -1, 1] == 1).all() and (np.diff(found[:, -1, 0]) > 0).all()


@pytest.mark.parametrize("n", [17, 65])
def test_lines_of_a_ring_become_radii(n):
    s = np.linspace(0, 1, n)
    even, uneven = np.pi / 2 * s, np.pi / 2 * (s + 0.3 * s * (1 - s))
    inner, outer = (r * np.column_stack([np.sin(a), np.cos(a)]) for r, a in ((1, even), (3, uneven)))
    radii = np.linspace(1, 3, n)[:, None]
    found, went = run(between(inner, radii * [1, 0], outer, radii * [0, 1]), [Wall("north", slides=True)])
    assert went.converged
    assert np.abs(np.arctan2(found[:, -1, 0], found[:, -1, 1]) - even).max() < 3e-3
    chord = 3 * (1 - np.cos(np.pi / 4 * 1.3 / (n - 1)))  # points slide along the polygon that was given
    assert np.abs(np.linalg.norm(found[:, -1], axis=-1) - 3).max() <= chord + 1e-12
    assert np.abs(found[[0, -1], -1] - outer[[0, -1]]).max() < 1e-12


def test_a_closed_side_slides_too():
    points = annulus(48, 16)
    angle = -np.linspace(0, 2 * np.pi, 49)
    uneven = angle + 0.2 * np.sin(angle)
    points[:, -1] = 4 * np.column_stack([np.cos(uneven), np.sin(uneven)])
    points[-1] = points[0]
    found, went = run(points, [Wall("north", slides=True)], cyclic=True)
    assert went.converged
    turned = np.unwrap(np.arctan2(found[:, -1, 1], found[:, -1, 0])) - angle
    assert np.ptp(turned) < 0.01


def test_a_wave_is_moved_by_its_lean_over_its_share():
    n, wave = 32, 3
    i = np.arange(n + 1)
    sine = np.sin(np.pi * wave * i / n)
    assert np.abs(_spread(sine, 0.7, False) * (1 - np.exp(-np.pi * wave / n * 0.7)) - sine).max() < 1e-12
    closed = np.sin(2 * np.pi * wave * i / n)
    assert np.abs(_spread(closed, 0.7, True) * (1 - np.exp(-2 * np.pi * wave / n * 0.7)) - closed)[:-1].max() < 1e-12


def test_sides_that_slide_keep_their_curve_and_the_others_their_points():
    s = np.linspace(0, 1, 41)
    south, north = np.column_stack([2 * s**1.3, 0 * s]), np.column_stack([2 * s, 1 + 0.2 * np.sin(np.pi * s) ** 2])
    west = np.column_stack([0 * s, s])
    sides = (south, west + [2, 0], north, west)
    kept, _ = mc.elliptic(*sides, walls="north")
    grid, report = mc.elliptic(*sides, walls="north", sliding=True)
    assert report.converged and report.quality["error of wall angles (degree)"] < 1
    assert (grid.points[:, 0, 0, :2] == south).all() and (grid.points[0, :, 0, :2] == west).all()
    assert (kept.points[:, -1, 0, :2] == north).all()
    moved = grid.points[:, -1, 0]
    assert np.abs(moved[1:-1, :2] - north[1:-1]).max() > 0.01
    assert np.abs(np.interp(moved[:, 0], north[:, 0], north[:, 1]) - moved[:, 1]).max() < 1e-9
    with pytest.raises(mc.InvalidInput, match="sliding: is given, but no walls"):
        mc.elliptic(*sides, sliding=True)


def test_where_the_corners_are_not_upright_the_rest_is_and_it_is_told():
    grid, report = mc.elliptic(*gallery.wavy_sides(40, 24), walls="north", sliding=True, control="none")
    points = grid.points[:, :, 0, :2]
    have = measured(np.ascontiguousarray(np.moveaxis(points, -1, 0)), "north", 1.0, False)
    assert np.abs(have.angle - 90)[8:-8].max() < 1.5
    assert not report.converged and "walls not controlled" in report.warnings[0]
