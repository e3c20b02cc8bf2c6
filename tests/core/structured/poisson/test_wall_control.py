"""Angle and first height at walls: measured where they are known, and reached where they are asked."""

from dataclasses import replace

import numpy as np
import pytest

from meshcore import gallery
from meshcore.geometry.curves import polyline, resampled
from meshcore.sizing import hyperbolic_tangent
from meshcore.structured import elliptically_smoothed, o_grid
from meshcore.structured.poisson.barrier import weak_cells
from meshcore.structured.poisson.wall_control import FEWEST_CELLS, Wall, controlled, from_wall, measured
from meshcore.structured.poisson.winslow import CUT, SIDES, Frame, levels_of, orientation
from meshcore.threads import Workers
from tests.core.structured.poisson.test_winslow import annulus, between, wavy
from tests.sections import random_sections


def inside(points):
    return np.ascontiguousarray(np.moveaxis(points, -1, 0))


def run(start, walls, cyclic=False):
    """The controlled grid, and how it went, in the grid's own lengths."""
    frame = Frame.of(start)
    walls = [replace(w, first_height=w.first_height and w.first_height / frame.size) for w in walls]
    with Workers(1) as workers:
        levels = levels_of(frame.inside(start), cyclic, workers, FEWEST_CELLS)
        went = controlled(levels, walls, np.zeros((2, *start.shape[:2])))
        free = [*(CUT if cyclic else ()), *(wall.side for wall in walls if wall.slides)]
        return frame.outside(levels.levels[0].points_without_ghosts, start, free), went


def airfoil_annulus(name, around, out, radius=10.0):
    """Straight rays from a section, clustered at its ends, to a circle."""
    loop = polyline(gallery.airfoil(name, cells=around))[:, :2]
    loop = np.roll(loop[:-1], -int(np.argmax(loop[:-1, 0])), axis=0)[::-1]
    loop = np.vstack([loop[-1:], loop])
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(loop, axis=0), axis=1))])
    angle = -2 * np.pi * (0.8 * np.linspace(0, 1, len(loop)) + 0.2 * length / length[-1])
    circle = np.column_stack([0.5 + radius * np.cos(angle), radius * np.sin(angle)])
    circle[-1] = circle[0]
    t = np.expm1(6 * np.linspace(0, 1, out + 1)) / np.expm1(6)
    return (1 - t)[None, :, None] * loop[:, None] + t[None, :, None] * circle[:, None]


def swollen(ni, nj):
    """A unit square with a bump on each side, and right angles."""
    s, t = np.linspace(0, 1, ni), np.linspace(0, 1, nj)
    along_i, along_j = (np.column_stack([u, 0.08 * np.sin(np.pi * u) ** 2]) for u in (s, t))
    west = along_j[:, ::-1] * [-1, 1]
    return between(along_i * [1, -1], along_j[:, ::-1] * [-0.5, 1] + [1, 0], along_i + [0, 1], west)


def spaced(grid, first):
    """The transfinite grid between a grid's sides with their points close together at corners."""

    def side(points):
        length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
        spatial = np.column_stack([points, 0 * points[:, 0]])
        fractions = hyperbolic_tangent(len(points) - 1, first=first / length, last=first / length)
        return resampled(spatial, fractions)[:, :2]

    south, north, west, east = side(grid[:, 0]), side(grid[:, -1]), side(grid[0]), side(grid[-1])
    return between(south, east, north, west, "arc length")


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("mirrored", [False, True])
def test_a_sheared_grid_has_the_angles_of_its_shear(side, mirrored):
    shear = np.radians(70)
    i, j = np.meshgrid(np.arange(16.0), 2 * np.arange(15.0), indexing="ij")
    points = np.stack([i + j * np.cos(shear), j * np.sin(shear)], axis=-1) * [-1 if mirrored else 1, 1]
    found = measured(inside(points), side, orientation(points), False)
    along_i = side in ("south", "north")
    # The line leaves north and west towards the other way: the angle to it is the other one.
    expected = 70 if side in ("south", "west") else 110
    assert np.abs(found.angle - expected).max() < 1e-9
    assert np.abs(found.height - (2 if along_i else 1)).max() < 1e-12
    assert np.abs(found.spacing - (1 if along_i else 2)).max() < 1e-12
    assert found.counts[5:-5].all() and not found.counts[[0, 1, 2, -3, -2, -1]].any()


def test_views_lead_away_from_the_side():
    grid = np.arange(12).reshape(3, 4)
    assert from_wall(grid, "south")[1].tolist() == [4, 5, 6, 7]
    assert from_wall(grid, "north")[1].tolist() == [7, 6, 5, 4]
    assert from_wall(grid, "west")[1].tolist() == [1, 5, 9]
    assert from_wall(grid, "east")[1].tolist() == [9, 5, 1]
    assert np.shares_memory(from_wall(grid, "east"), grid)


def test_polar_grids_are_orthogonal_all_round():
    points = annulus(24, 6)
    found = measured(inside(points), "south", orientation(points), True)
    assert np.abs(found.angle - 90).max() < 1e-9 and found.counts.all()


def test_nodes_near_a_sharp_corner_do_not_count():
    points = airfoil_annulus("naca0012", 64, 10)
    found = measured(inside(points), "south", orientation(points), True)
    short = np.flatnonzero(~found.counts)
    assert {0, 1, 2, 62, 63, 64} <= set(short.tolist()) and len(short) < 32


@pytest.mark.parametrize("walls", [("south",), ("north",), ("east",), ("west",), ("south", "north"), tuple(SIDES)])
def test_any_subset_of_sides(walls):
    # Where two walls meet, they must do so at the angle asked, the points on one at the height that the other asks.
    start = spaced(swollen(49, 65), 0.004) if len(walls) == 4 else wavy(49, 65, 0.06)
    found, went = run(start, [Wall(side, 0.004) for side in walls])
    assert went.converged
    for side in walls:
        have = measured(inside(found), side, orientation(found), False)
        assert np.abs(have.angle - 90)[have.counts].max() < 1
        assert np.abs(have.height / 0.004 - 1)[have.counts].max() < 0.05
    assert not weak_cells(found, orientation(found)).any()


@pytest.mark.parametrize("angle", [60.0, 115.0])
def test_other_angles_than_right_ones(angle):
    n = 41
    s = np.linspace(0, 1, n)
    south, north = np.column_stack([2 * s, 0 * s]), np.column_stack([2 * s, 0 * s + 1])
    west = np.column_stack([0 * s, s])
    found, _ = run(between(south, west + [2, 0], north, west), [Wall("south", 0.01, angle)])
    have = measured(inside(found), "south", 1.0, False)
    off = np.abs(have.angle - angle)[4:-4]
    assert off.max() < 1.5 and np.abs(have.height / 0.01 - 1)[4:-4].max() < 0.05


def test_height_alone_leaves_the_angle_and_angle_alone_the_height():
    start = wavy(41, 41, 0.08)
    plain, _ = run(start, [Wall("south", None, None)])
    heights, _ = run(start, [Wall("south", 0.003, None)])
    angles, _ = run(start, [Wall("south", None, 90.0)])
    before, lower, upright = (measured(inside(g), "south", 1.0, False) for g in (plain, heights, angles))
    assert np.abs(lower.height / 0.003 - 1)[4:-4].max() < 0.05 < np.abs(before.height / 0.003 - 1)[4:-4].min()
    assert np.abs(upright.angle - 90)[4:-4].max() < 1 < np.abs(before.angle - 90)[4:-4].max()
    assert np.median(upright.height / before.height) > 0.5


@pytest.mark.parametrize("name", gallery.airfoils())
@pytest.mark.parametrize("height", [1e-3, 1e-5])
def test_o_grids_of_airfoils_reach_angle_and_height(name, height):
    start = airfoil_annulus(name, 160, 64)
    found, went = run(start, [Wall("south", height)], cyclic=True)
    assert went.converged and went.angle < 1 and went.height < 0.05
    have = measured(inside(found), "south", orientation(start), True)
    assert np.abs(have.angle - 90)[have.counts].max() < 1
    assert np.abs(have.height / height - 1)[have.counts].max() < 0.05
    assert have.counts.sum() > 145
    assert weak_cells(found, orientation(start)).sum() < 12


def test_lines_stay_upright_where_the_wall_s_edges_jump():
    """Points of sections as they stand in files: one edge four times as long as the one before."""
    south = np.concatenate([np.linspace(0, 0.2, 21), np.linspace(0.2, 1.0, 21)[1:]])
    even = np.linspace(0, 1, 41)
    west = np.column_stack([0 * even, even])
    start = between(np.column_stack([south, 0 * south]), west + [1, 0], np.column_stack([even, 0 * even + 1]), west)
    found, went = run(start, [Wall("south", 0.002)])
    assert went.converged and went.angle < 1 and went.height < 0.01
    assert not weak_cells(found, 1.0).any()


@pytest.mark.parametrize(("number", "loop"), list(enumerate(loop for _, loop in random_sections(18, 11))))
def test_walls_of_random_sections(number, loop):
    height = 10.0 ** -(3 + number % 3)
    start, _ = o_grid(loop, around=(None, 97)[number % 2], first_height=height)
    _, report = elliptically_smoothed(start, walls="south", first_height=height)
    assert report.converged
    assert report.quality["error of wall angles (degree)"] < 1
    assert report.quality["error of first heights (%)"] < 5
