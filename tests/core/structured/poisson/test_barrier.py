"""The barrier on a patch: gradient, unfolding, and what it leaves alone."""

import numpy as np
import pytest

from meshcore.structured.poisson import _barrier_kernels as kernels
from meshcore.structured.poisson.barrier import unfolded, weak_cells
from meshcore.structured.poisson.winslow import smoothed_grid
from tests.core.structured.poisson.test_winslow import annulus, between


def square(n=12):
    return np.stack(np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n), indexing="ij"), axis=-1)


@pytest.mark.parametrize("delta", [0.5, 1e-2])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_gradient_is_that_of_differences(sign, delta):
    rng = np.random.default_rng(2)
    r = np.ascontiguousarray(np.moveaxis(square(5), -1, 0)) + 0.1 * rng.normal(size=(2, 5, 5))
    units = rng.uniform(0.5, 2, (2, 4))
    gradient, ignored = np.empty_like(r), np.empty_like(r)
    kernels.functional(r, *units, sign, delta, gradient)
    for at in np.ndindex(r.shape):
        step = 1e-6
        up, down = r.copy(), r.copy()
        up[at] += step
        down[at] -= step
        slope = kernels.functional(up, *units, sign, delta, ignored)[0]
        slope = (slope - kernels.functional(down, *units, sign, delta, ignored)[0]) / (2 * step)
        assert abs(slope - gradient[at]) < 1e-4 * max(1, np.abs(gradient).max())


def test_a_re_entrant_corner_is_unfolded_nearby_only():
    n = 33
    s = np.linspace(0, 1, n)
    south = np.where((s <= 0.5)[:, None], np.column_stack([2 * s, 0 * s]), np.column_stack([0 * s + 1, 1 - 2 * s]))
    east, west = np.column_stack([1 + 0 * s, -1 + 2 * s]), np.column_stack([0 * s, s])
    south[n // 2 + 1 :, 1] = -(s[n // 2 + 1 :] - 0.5) * 2
    east = np.column_stack([1 + s, -1 + 2 * s])
    north = np.column_stack([2 * s, 0 * s + 1])
    found = smoothed_grid(between(south, east, north, west))
    weak = weak_cells(found, 1.0)
    assert 0 < weak.sum() < 6
    cured = unfolded(found, 1.0)
    assert not weak_cells(cured, 1.0).any()
    moved = (cured != found).any(axis=-1)
    assert moved.sum() < 400 and not moved[0].any() and not moved[:, 0].any()


def test_the_cut_of_a_cyclic_grid_is_unfolded_too():
    grid = annulus(24, 8)
    grid[0, 4] = grid[-1, 4] = grid[2, 5]
    sign = -1.0 if not weak_cells(annulus(24, 8), -1.0).any() else 1.0
    assert weak_cells(grid, sign).any()
    cured = unfolded(grid, sign, cyclic=True)
    assert not weak_cells(cured, sign).any()
    assert (cured[0] == cured[-1]).all()
    assert (cured[:, [0, -1]] == grid[:, [0, -1]]).all()


def test_a_fold_at_the_cut_of_a_row_that_repeats_is_unfolded():
    grid = square(12)
    grid[0, 4, 0] = grid[-1, 4, 0] - 1
    grid[0, 4, 0] += 0.15
    grid[-1, 4, 0] = grid[0, 4, 0] + 1
    assert weak_cells(grid, 1.0).any()
    cured = unfolded(grid, 1.0, cyclic=True)
    assert not weak_cells(cured, 1.0).any()
    assert np.abs(cured[-1] - cured[0] - [1, 0]).max() < 1e-15 and np.abs(cured - grid).max() < 0.2


def test_stretching_is_kept():
    """Cells a thousand times as long as high stay so around the fold."""
    x, y = np.meshgrid(np.linspace(0, 1, 20), np.geomspace(1e-4, 1, 40) - 1e-4, indexing="ij")
    grid = np.stack([x, y], axis=-1)
    folded = grid.copy()
    folded[10, 2, 1] = 0.5 * grid[10, 1, 1]
    cured = unfolded(folded, 1.0)
    assert not weak_cells(cured, 1.0).any()
    ratio = np.diff(cured[..., 1], axis=1) / np.diff(grid[..., 1], axis=1)
    assert ratio.min() > 0.5 and ratio.max() < 2


def test_a_corner_that_points_inwards_stays_and_all_else_is_unfolded():
    grid = square(9)
    grid[0, 0] = (0.3, 0.3)
    grid[1, 2] = grid[1, 4]
    assert weak_cells(grid, 1.0).sum() > 1
    cured = unfolded(grid, 1.0)
    assert np.argwhere(weak_cells(cured, 1.0)).tolist() == [[0, 0]]
    alone = square(9)
    alone[0, 0] = (0.1, 0.1)
    assert np.array_equal(unfolded(alone, 1.0), alone)


def test_what_cannot_be_unfolded_is_given_up_when_it_gets_no_better(monkeypatch):
    from meshcore.structured.poisson import barrier

    x, y = np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 5), indexing="ij")
    points = np.stack([x, y], axis=-1)
    points[4, 0, 1] = 1.5  # a point of the boundary beyond the opposite side
    worst = []
    minimise = barrier.kernels.minimise

    def counted(*arguments):
        worst.append(minimise(*arguments))
        return worst[-1]

    monkeypatch.setattr(barrier.kernels, "minimise", counted)
    found = barrier._without_folds(points, 1.0)
    assert np.array_equal(found, points)
    assert barrier._IDLE < len(worst) < barrier._HALVINGS
    assert max(worst[-barrier._IDLE :]) - max(worst[: -barrier._IDLE]) < barrier._GAIN * barrier._IDLE * abs(max(worst))
