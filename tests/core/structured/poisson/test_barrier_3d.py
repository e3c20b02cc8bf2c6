"""The barrier in space: functional and minimiser against their slow twins, unfolding, and what nothing can unfold."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import meshcore as mc
from meshcore import Cancelled, GenerationFailed, StructuredGrid, gallery, quality
from meshcore.structured.algebraic.block_corners import refuse_corners
from meshcore.structured.poisson import _barrier_3d_kernels as kernels
from meshcore.structured.poisson import _descent_kernels as descent
from meshcore.structured.poisson.barrier_3d import unfolded, weak_cells
from meshcore.structured.poisson.descent import minimised
from meshcore.structured.poisson.winslow_3d import count_folded
from tests import naive


def box(*cells):
    """Unit cube of so many cells."""
    return np.stack(np.meshgrid(*[np.linspace(0, 1, n + 1) for n in cells], indexing="ij"), axis=-1)


def shaken(seed, *cells, by):
    """A cube whose points were moved by random parts of a cell."""
    points = box(*cells)
    return points + by / max(cells) * np.random.default_rng(seed).standard_normal(points.shape)


def functional(points, lengths, delta):
    r = np.ascontiguousarray(np.moveaxis(points, -1, 0))
    gradient = np.empty_like(r)
    value, least = kernels.functional(r, *lengths, delta, np.empty((6, 4, 3)), gradient)
    return value, least, np.moveaxis(gradient, 0, -1)


@pytest.mark.parametrize("delta", [0.5, 1e-2])
def test_the_functional_is_that_of_the_slow_twin_and_its_gradient_that_of_differences(delta):
    points = shaken(4, 3, 4, 3, by=0.4)
    lengths = [np.random.default_rng(d).uniform(0.2, 0.5, n) for d, n in enumerate((3, 4, 3))]
    value, least, gradient = functional(points, lengths, delta)
    expected = naive.barrier_functional(points, lengths, delta)
    np.testing.assert_allclose((value, least), expected, rtol=1e-9)  # the twin loses digits where J << 0
    assert least < 0
    step = 1e-6
    for at in np.ndindex(2, 3, 2, 3):
        node = (at[0] + 1, at[1] + 1, at[2] + 1, at[3])
        up, down = points.copy(), points.copy()
        up[node] += step
        down[node] -= step
        slope = (functional(up, lengths, delta)[0] - functional(down, lengths, delta)[0]) / (2 * step)
        assert abs(slope - gradient[node]) < 1e-6 * np.abs(gradient).max()


def test_weak_cells_are_those_of_the_slow_twin():
    points = shaken(1, 5, 4, 6, by=0.35)
    weak = weak_cells(points)
    np.testing.assert_array_equal(weak, naive.weak_hexahedra(points, 1e-6))
    assert 10 < weak.sum() < 100


def test_steps_of_the_minimiser_are_those_of_the_slow_twin():
    rng = np.random.default_rng(6)
    hessian = rng.standard_normal((7, 7))
    hessian = hessian @ hessian.T + np.eye(7)
    steps, slope = rng.standard_normal((5, 7)), rng.standard_normal(7)
    changes = steps @ hessian
    kept, known, way = np.zeros((2, 3, 7)), 0, np.zeros(7)
    for s in steps:
        old = rng.standard_normal(7)
        known = descent.remember(1.0, -s, old, old + s @ hessian, *kept, known)
    slopes = descent.find_way(slope, *kept, known, np.zeros(3), way)
    np.testing.assert_allclose(way, naive.quasi_newton_step(slope, steps[2:], changes[2:]), rtol=1e-9)
    assert slopes == pytest.approx(-way @ slope)


def test_the_minimiser_goes_down_a_curved_valley():
    def rosenbrock(x, slope):
        off = x[1:] - x[:-1] ** 2
        slope[:] = 0
        slope[:-1] = -400 * x[:-1] * off - 2 * (1 - x[:-1])
        slope[1:] += 200 * off
        return float((100 * off**2 + (1 - x[:-1]) ** 2).sum())

    np.testing.assert_allclose(minimised(rosenbrock, np.full(6, -0.5), most=500), 1, atol=1e-3)


def test_folds_are_unfolded_nearby_only():
    points = box(14, 12, 16)
    points[5, 5, 5] += 0.2
    points[10, 3, 12, 2] -= 0.2
    cured = unfolded(points)
    assert weak_cells(points).sum() > 8
    assert not naive.weak_hexahedra(cured, 1e-6).any()
    assert quality.measure(StructuredGrid(cured), "scaled_jacobian").min() > 0.1
    moved = (cured != points).any(axis=-1)
    assert 0 < moved.sum() < 400
    assert not any(np.moveaxis(moved, d, 0)[e].any() for d in range(3) for e in (0, -1))


def test_stretching_is_kept():
    points = box(8, 10, 24)
    points[..., 2] = (np.geomspace(1e-4, 1, 25) - 1e-4) / (1 - 1e-4)
    folded = points.copy()
    folded[4, 5, 3, 2] = 0.5 * points[4, 5, 2, 2]
    cured = unfolded(folded)
    assert not weak_cells(cured).any()
    ratio = np.diff(cured[..., 2], axis=2) / np.diff(points[..., 2], axis=2)
    assert ratio.min() > 0.5
    assert ratio.max() < 2


def test_what_cannot_be_unfolded_stays_and_progress_may_cancel():
    points = box(8, 8, 8)
    points[:, :, -1, 2] -= 1.4 * (np.sin(np.pi * points[:, :, -1, 0]) * np.sin(np.pi * points[:, :, -1, 1])) ** 2
    seen = []
    same = unfolded(points, progress=lambda done, message: seen.append(done) is None)
    assert (same == points).all()
    assert seen == sorted(seen)
    with pytest.raises(Cancelled):
        unfolded(points, progress=lambda done, message: False)


# ---- the operation


@pytest.mark.parametrize(
    ("cells", "depth", "bulge"),
    [(8, 0.6, 0.1), (8, 0.8, 0.2), (12, 0.7, 0.2), (16, 0.8, 0.2), (20, 0.7, 0.3), (24, 0.6, 0.2)],
)
@pytest.mark.parametrize("control", ["none", "boundary spacing"])
def test_bulbs_are_filled_at_any_resolution(cells, depth, bulge, control):
    grid, report = mc.elliptic_volume(gallery.dented_box(cells, depth=depth, bulge=bulge), control=control)
    assert report.converged
    assert quality.measure(grid, "scaled_jacobian").min() > 0.005
    assert "cells that the discrete equations leave folded were unfolded" in report.warnings[0]


@settings(max_examples=40, deadline=None)
@given(
    cells=st.tuples(*[st.integers(3, 9)] * 3),
    seed=st.integers(0, 10**6),
    size=st.floats(0.1, 0.5),
    control=st.sampled_from(["none", "boundary spacing"]),
)
def test_wherever_a_sound_grid_is_known_one_is_found(cells, seed, size, control):
    """Of a map of the cube without folds only the boundary is told."""
    rng = np.random.default_rng(seed)
    known = box(*cells)
    waves, phases = rng.uniform(-5, 5, (3, 3, 3)), rng.uniform(0, 6, (3, 3))
    known = known + size / 3 * sum(
        np.sin(known @ w + p) * rng.uniform(0, 1) for w, p in zip(waves, phases, strict=True)
    )
    assume(count_folded(known) == 0)
    grid, _ = mc.elliptic_volume(StructuredGrid(naive.filled_box(known)), control=control)
    assert count_folded(grid.points) == 0
    inner = (slice(1, -1),) * 3
    boundary = np.ones(known.shape[:3], bool)
    boundary[inner] = False
    assert (grid.points[boundary] == naive.filled_box(known)[boundary]).all()


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize(("low", "high"), [(0, 0), (0, -1), (-1, 0), (-1, -1)])
def test_edges_where_the_boundary_turns_too_far_are_named(axis, low, high):
    points = box(5, 6, 7)
    at = [low, high]
    at.insert(axis, 3)
    middle = points[tuple(at)].copy()
    points[tuple(at)] += 1.1 * (0.5 - middle) * (np.arange(3) != axis) * [0.8, 0.9, 1]
    with pytest.raises(GenerationFailed, match=r"turns by 2[0-9]+ degrees at the edge of") as failure:
        mc.elliptic_volume(StructuredGrid(points))
    assert f"at {'ijk'[axis]} = 3" in str(failure.value)
    for d, end in zip([d for d in range(3) if d != axis], (low, high), strict=True):
        assert f"{'ijk'[d]}{'max' if end else 'min'}" in str(failure.value)
    expected = np.flatnonzero(naive.weak_hexahedra(points, 0.0, free=False).ravel(order="F"))
    np.testing.assert_array_equal(failure.value.cells, expected)


def test_corners_that_the_boundary_folds_are_the_slow_twins():
    points = shaken(3, 4, 5, 3, by=0.35)
    with pytest.raises(GenerationFailed) as failure:
        refuse_corners(StructuredGrid(points))
    expected = np.flatnonzero(naive.weak_hexahedra(points, 0.0, free=False).ravel(order="F"))
    np.testing.assert_array_equal(failure.value.cells, expected)


def test_names_of_the_user_are_told():
    points = box(4, 4, 4)
    points[0, 0, 0] = 0.4
    with pytest.raises(GenerationFailed, match="at the corner of hub, jmin and kmin, near"):
        refuse_corners(StructuredGrid(points, names={"imin": "hub"}))


def test_nothing_is_said_of_edges_whose_points_are_free():
    points = box(4, 4, 4)
    points[0, 0, 2] = 0.4
    refuse_corners(StructuredGrid(points), free=["imin"])
    with pytest.raises(GenerationFailed, match="edge of imin and jmin at k = 2"):
        refuse_corners(StructuredGrid(points), free=["imax"])
