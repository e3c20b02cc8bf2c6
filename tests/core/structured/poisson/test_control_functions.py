"""Control functions: the boundary's spacing inside, the user's P and Q, and attraction."""

import numpy as np
import pytest

from meshcore.errors import InvalidInput
from meshcore.structured.poisson.control_functions import (
    Attractor,
    _own,
    from_attractors,
    from_boundary,
    from_grid,
    from_user,
)
from meshcore.structured.poisson.winslow import winslow
from tests.core.structured.poisson.test_winslow import annulus, between, distance, wavy


def test_a_stretched_rectangle_is_reproduced():
    x, y = np.linspace(0, 1, 20) ** 2 * 3, np.tanh(3 * np.linspace(0, 1, 27))
    exact = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    start = exact.copy()
    start[1:-1, 1:-1] += 0.01 * np.sin(np.arange(18 * 25 * 2)).reshape(18, 25, 2)
    found = winslow(start, growth=from_boundary(exact), tolerance=1e-12).points
    assert distance(found, exact) < 1e-9


@pytest.mark.parametrize("turn", [1.2, 2 * np.pi])
def test_radii_of_an_annulus_are_those_asked_at_second_order(turn):
    """Polar grids of any spacing are orthogonal: Thomas and Middlecoff's shorter form counts their own growth twice."""
    errors = []
    for n in (16, 32, 64):
        radii = 1 + 3 * np.linspace(0, 1, n + 1) ** 1.5 + 0.3 * np.linspace(0, 1, n + 1)
        exact = annulus(2 * n, n, turn=turn, radii=radii)
        found = winslow(exact, growth=from_boundary(exact, cyclic=turn > 6), cyclic=turn > 6, tolerance=1e-11).points
        errors.append(distance(found, exact))
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 4e-3 and rates.min() > 1.5


def test_spacing_at_a_wall_reaches_inside():
    """Laplace lifts the first line off a wavy wall; with the boundary's spacing it stays as near as at the sides."""
    ni, nj = 41, 41
    s, t = np.linspace(0, 2, ni), np.expm1(5 * np.linspace(0, 1, nj)) / np.expm1(5)
    south = np.column_stack([s, 0.1 * np.sin(np.pi * s)])
    north = np.column_stack([s, 0 * s + 1])
    east, west = np.column_stack([0 * t + 2, t]), np.column_stack([0 * t, t])
    south[[0, -1], 1] = 0
    start = between(south, east, north, west, "arc length")
    heights = [
        np.linalg.norm(grid[:, 1] - grid[:, 0], axis=-1)[5:-5] / t[1]
        for grid in (winslow(start).points, winslow(start, growth=from_boundary(start)).points)
    ]
    assert heights[0].mean() > 5
    assert heights[1].max() < 2 and heights[1].min() > 0.5


def test_user_functions_are_those_of_the_twin():
    rng = np.random.default_rng(11)
    p, q = rng.uniform(-0.5, 0.5, (2, 7, 9))
    growth = from_user((p, lambda i, j: q), (7, 9))
    assert np.abs(-2 * np.tanh(growth / 2) - [p, q]).max() < 1e-14


@pytest.mark.parametrize("value", [2.0, -3.0, np.nan])
def test_impossible_functions_are_refused(value):
    with pytest.raises(InvalidInput, match="P must stay between -2 and 2"):
        from_user((np.full((4, 4), value), np.zeros((4, 4))), (4, 4))
    with pytest.raises(InvalidInput, match="shape"):
        from_user((np.zeros((3, 4)), np.zeros((4, 4))), (4, 4))
    with pytest.raises(InvalidInput, match="2 directions, got 1"):
        from_user((np.zeros((4, 4)),), (4, 4))


def test_lines_come_near_an_attractor():
    start = wavy(33, 33, 0.05)
    plain = winslow(start).points
    growth = from_attractors([Attractor(j=16, strength=0.15, reach=6)], (33, 33))
    drawn = winslow(start, growth=growth).points

    def gap(grid):
        return np.linalg.norm(grid[:, 17] - grid[:, 16], axis=-1)[8:-8]

    assert (gap(drawn) < 0.75 * gap(plain)).all()
    point = winslow(start, growth=from_attractors([Attractor(i=16, j=16, strength=0.3, reach=4)], (33, 33))).points
    size = [np.linalg.norm(grid[17, 17] - grid[15, 15]) for grid in (plain, point)]
    far = [np.linalg.norm(grid[3, 3] - grid[1, 1]) for grid in (plain, point)]
    assert size[1] < 0.7 * size[0] and abs(far[1] / far[0] - 1) < 0.1


@pytest.mark.parametrize("bad", [{}, {"i": 1, "strength": 5}, {"i": 1, "reach": 0}, {"j": 1, "strength": np.nan}])
def test_impossible_attractors_are_refused(bad):
    with pytest.raises(InvalidInput, match="attractors"):
        Attractor(**bad)


def test_the_growth_of_a_whole_grid_keeps_it_if_its_lines_are_orthogonal():
    angle, radius = np.linspace(0, 1.5, 25)[:, None] ** 1.3, 1.2 ** np.arange(20)
    points = np.stack([radius * np.cos(-angle), radius * np.sin(-angle)], axis=-1)
    solution = winslow(points, growth=from_grid(points), tolerance=1e-10)
    assert solution.converged
    assert np.abs(solution.points - points).max() < 2e-2 * np.linalg.norm(np.diff(points, axis=1), axis=-1).max()
    plain = winslow(points, tolerance=1e-10).points
    assert np.abs(plain - points).max() > 20 * np.abs(solution.points - points).max()


@pytest.mark.parametrize("cyclic", [False, True])
def test_the_growth_of_a_whole_grid_is_smoothed_across_and_kept_along(cyclic):
    angle, j = np.meshgrid(np.linspace(0, -2 * np.pi, 61), np.arange(30.0), indexing="ij")
    radius = 5 + np.cumsum((1.1 + 0.02 * np.sin(9 * angle)) ** j, axis=1)
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
    points[-1] = points[0]
    own, smooth = _own(points, cyclic), from_grid(points, cyclic=cyclic)
    inner = np.s_[1:-1, 1:-1]
    assert np.std(smooth[1][inner], axis=0).max() < 0.3 * np.std(own[1][inner], axis=0).max()
    assert np.abs(smooth[1].mean(axis=0) - own[1].mean(axis=0)).max() < 0.02
    assert (smooth[:, 0] == smooth[:, -1]).all() or not cyclic
