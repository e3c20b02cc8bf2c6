"""Amounts spread along a wall: whole at its first points, shared higher up, none lost, alike everywhere on a circle."""

import numpy as np

from meshcore.structured.sections.spreading import spread_with_height

RNG = np.random.default_rng(5)


def fan(angle, radii):
    return np.stack([np.cos(angle)[:, None] * radii, np.sin(angle)[:, None] * radii], axis=-1)


def test_nothing_is_lost_and_first_points_keep_what_is_theirs():
    x = np.cumsum(RNG.uniform(0.1, 1, 40))
    points = np.stack(np.meshgrid(x, np.geomspace(1, 1e4, 9) - 1, indexing="ij"), axis=-1)
    amounts = RNG.normal(size=(40, 8))
    found = spread_with_height(amounts, points)
    share = 0.5 * (np.append(np.diff(x), 0) + np.append(0, np.diff(x)))  # trapezoidal rule
    assert np.abs(share @ found - share @ amounts).max() < 1e-6
    assert (found[:, 0] == amounts[:, 0]).all()
    assert (np.diff(np.ptp(found, axis=0)[1:]) < 0).all()
    assert np.ptp(found[:, -1]) < 1e-3


def test_one_line_of_many_is_spread_as_the_exponential_of_the_distance():
    x = np.arange(401.0)
    points = np.stack(np.meshgrid(x, [0.0, 1.0, 11.0], indexing="ij"), axis=-1)
    amounts = np.zeros((401, 2))
    amounts[200] = 1.0
    found = spread_with_height(amounts, points)[:, 1]
    exact = np.exp(-np.abs(x - 200) / 10) / 20
    assert np.abs(found - exact).max() < 5e-3 * exact.max()
    assert np.abs(spread_with_height(amounts, points, 0.5)[200, 1] / (1 / 10) - 1) < 0.01


def test_a_closed_front_has_no_first_line():
    angle = np.linspace(0, 2 * np.pi, 61)
    points = fan(angle, 1 + np.array([0, 0.01, 0.1, 0.3]))
    points[-1] = points[0]
    amounts = np.zeros((61, 3))
    amounts[20] = 1.0
    found = spread_with_height(amounts, points)
    turned = np.zeros((61, 3))
    turned[0] = turned[-1] = 1.0
    at_end = spread_with_height(turned, points)
    assert (at_end[0] == at_end[-1]).all()
    assert np.abs(np.roll(found[:-1], -20, axis=0) - at_end[:-1]).max() < 1e-6
