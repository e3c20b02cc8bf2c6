"""Layers respaced along the lines of a grid: first heights and even growth, lines and ends as they were."""

import numpy as np
import pytest

from meshcore import gallery, o_grid
from meshcore.structured.sections.respacing import respaced


def polar(levels, around=25):
    angle = np.linspace(0, 1.5, around)[:, None]
    return np.stack([levels * np.cos(angle), levels * np.sin(angle)], axis=-1)[::-1]


def steps(points):
    return np.linalg.norm(np.diff(points, axis=1), axis=-1)


def test_uneven_levels_of_a_polar_grid_become_geometric_ones():
    points = polar(1 + np.array([0, 0.1, 0.23, 0.4, 0.7, 1.2, 1.9, 3.0]))
    found = respaced(points, np.full(25, 0.05))
    height = steps(found)
    assert height[:, 0] == pytest.approx(0.05, rel=1e-3)
    growth = height[:, 1:] / height[:, :-1]
    assert np.ptp(growth) < 1e-3 * growth.mean()
    assert np.array_equal(found[:, [0, -1]], points[:, [0, -1]])
    assert np.abs(np.arctan2(*found.swapaxes(0, -1)[::-1]) - np.arctan2(*points.swapaxes(0, -1)[::-1])).max() < 1e-12


def test_first_heights_may_differ_and_fade_outwards():
    points = polar(1 + np.geomspace(0.01, 2, 40) - 0.01)
    heights = np.linspace(0.005, 0.02, 25)
    found = respaced(points, heights)
    assert steps(found)[:, 0] == pytest.approx(heights, rel=5e-3)
    assert (steps(found) > 0).all()
    mean = steps(found).mean(axis=0)
    assert np.ptp(mean[1:] / mean[:-1]) < 2e-3
    assert np.ptp(np.linalg.norm(found[:, 35], axis=-1)) < 0.05  # levels far out stay across the lines


def test_only_the_lines_that_are_judged_make_the_mean():
    points = polar(1 + np.linspace(0, 1, 9))
    points[:5] = 1 + 3 * (points[:5] - 1)
    mean = steps(respaced(points, np.full(25, 0.05), slice(5, None)))[5:].mean(axis=0)
    assert np.ptp(mean[1:] / mean[:-1]) < 2e-3


def test_a_first_height_that_does_not_fit_is_refused():
    assert respaced(polar(1 + np.linspace(0, 1, 4)), np.full(25, 5.0)) is None


def test_two_levels_are_what_they_are():
    points = polar(np.array([1.0, 2.0]))
    assert respaced(points, np.ones(25)) is points


@pytest.mark.parametrize("method", ["elliptic", "parabolic"])
@pytest.mark.parametrize("name", ["s1223", "naca0012"])
def test_o_grids_grow_evenly_from_the_heights_asked(name, method):
    grid, report = o_grid(gallery.airfoil(name), method=method, first_height=1e-4)
    height = steps(grid.points[:, :, 0])
    assert height[:, 0] == pytest.approx(1e-4, rel=0.005)
    mean = height.mean(axis=0)
    assert mean[1:] / mean[:-1] == pytest.approx(np.full(len(mean) - 1, np.median(mean[1:] / mean[:-1])), rel=0.005)
    assert np.array_equal(grid.points[0], grid.points[-1])
    assert report.quality["largest first height / asked"] == pytest.approx(height[:, 0].max() / 1e-4)
