"""What the multigrid solvers share: transfer, acceleration, when to stop; and the kernels that measure."""

import itertools

import numpy as np
import pytest

from meshcore import StructuredGrid, quality
from meshcore.structured.poisson import _winslow_3d_kernels as kernels
from meshcore.structured.poisson.multigrid import Anderson, Level, Outcome, cycle, solve
from meshcore.structured.poisson.transfer import Line, Transfer, coarsened, coarser
from meshcore.structured.poisson.winslow_3d import count_folded
from meshcore.threads import Workers


def hat(at, centre, width):
    """A hat function."""
    return max(0.0, 1 - abs(at - centre) / width)


@pytest.mark.parametrize("fine", [(17, 16, 33), (9, 40, 8)])
def test_transfer_is_that_of_hat_functions_in_each_direction(fine):
    coarse = [coarser(n) for n in fine]
    rng = np.random.default_rng(7)
    with Workers(2) as workers:
        transfer = Transfer(tuple(map(Line, fine, coarse)), workers)
        down, up = [], []
        for n, m in zip(fine, coarse, strict=True):
            up.append(np.array([[hat(i / n, k / m, 1 / m) for k in range(m + 1)] for i in range(n + 1)]))
            means = np.array([[hat(i / n, k / m, 1 / m) for i in range(n + 1)] for k in range(m + 1)])
            down.append(means / means.sum(axis=1, keepdims=True))
        values = rng.standard_normal((2, *(n + 1 for n in fine)))
        expected = np.einsum("ai,bj,ck,qijk->qabc", *down, values)
        np.testing.assert_allclose(transfer.averaged(values), expected, atol=1e-13)
        rough = rng.standard_normal(expected.shape)
        expected = values + 0.3 * np.einsum("ai,bj,ck,qijk->qabc", *up, rough)
        transfer.add(rough, 0.3, values)
        np.testing.assert_allclose(values, expected, atol=1e-13)
        linear = (
            np.einsum("i,qi->q", [1.0, 2, 3], np.eye(3))[:, None, None, None]
            * np.linspace(0, 1, fine[0] + 1)[:, None, None]
        )
        linear = np.broadcast_to(linear, (3, *(n + 1 for n in fine))).copy()
        sampled = transfer.sampled(linear)
        np.testing.assert_allclose(sampled[2, :, 0, 0], 3 * np.linspace(0, 1, coarse[0] + 1), atol=1e-14)


def test_coarsening_stops_before_grids_get_too_coarse():
    shapes = [(130, 40, 20)]
    while lines := coarsened(shapes[-1]):
        shapes.append(tuple(line.coarse + 1 for line in lines))
    assert min(itertools.chain(*shapes)) >= 9
    assert shapes[-1] == (9 + 1, 10 + 1, 10 + 1) or all(coarser(n - 1) == n - 1 for n in shapes[-1])


class Linear(Level):
    """A linear system with slow modes, as a level without coarser ones: a sweep is one step of Richardson."""

    def __init__(self, n):
        self.rates = np.choose(np.arange(n) % 3, [0.02, 0.2, 1.0])
        self.x, self.f = np.ones((1, n)), np.zeros((1, n))

    def smooth(self, *, back):
        self.x *= 1 - self.rates * 0.1

    def defect(self):
        return self.f - self.rates * self.x

    def residual(self):
        return float(np.sqrt((self.defect() ** 2).mean()))

    def folded(self):
        return 0

    def largest_move(self, before):
        return float(abs(self.x - before).max())


def test_acceleration_needs_far_fewer_cycles_and_ends_at_the_solution():
    plain = Linear(50_000)
    for _ in range(30 * 12):
        plain.smooth(back=False)
    level = Linear(50_000)
    with Workers(2) as workers:
        outcome = solve([level], tolerance=1e-9, most=40, workers=workers)
    assert outcome.converged
    assert outcome.cycles < 15
    assert level.residual() < 1e-3 * plain.residual()


def test_small_moves_that_leave_the_residual_as_it_was_are_no_convergence():
    level = Linear(30)
    level.rates = np.full(30, 1e-4)
    with Workers(1) as workers:
        outcome = solve([level], most=1, workers=workers)
    assert outcome.error < 1e-3 and outcome.residuals[-1] > 0.9 * outcome.residuals[-2]
    assert not outcome.converged


@pytest.mark.parametrize(("dtype", "accuracy"), [(np.float32, 1e-5), (np.float64, 1e-12)])
def test_acceleration_is_least_squares_of_the_last_changes(dtype, accuracy):
    rng = np.random.default_rng(11)
    size, depth = 60_000, 3
    befores = [rng.standard_normal(size) for _ in range(6)]
    afters = [rng.standard_normal(size) for _ in range(6)]
    with Workers(2) as workers:
        accelerator = Anderson(size, workers, depth, dtype)
        for k, (before, after) in enumerate(zip(befores, afters, strict=True)):
            found = after.copy()
            accelerator.accelerate(before, found)
            changes = [a - b for a, b in zip(afters, befores, strict=True)]
            span = range(max(1, k + 1 - depth), k + 1)
            steps = np.array([afters[j] - afters[j - 1] for j in span]).reshape(len(span), size)
            differences = np.array([changes[j] - changes[j - 1] for j in span]).reshape(len(span), size)
            factors = np.linalg.lstsq(differences.T, changes[k], rcond=None)[0]
            np.testing.assert_allclose(found, after - factors @ steps, atol=accuracy)
            np.testing.assert_array_equal(accelerator.last, after)


@pytest.mark.parametrize("astray", [np.nan, np.inf, 1e300])
def test_steps_that_go_astray_are_left_as_they_are_and_forgotten(astray):
    rng = np.random.default_rng(0)
    with Workers(1) as workers:
        accelerator = Anderson(20, workers, 3, np.float32)
        for wrong in (False, False, True, False):
            before = rng.random(20)
            after = np.where(wrong, astray, before + rng.random(20))
            found = after.copy()
            with np.errstate(over="ignore"):
                accelerator.accelerate(before, found)
        np.testing.assert_array_equal(found, after)
        accelerator.accelerate(before := rng.random(20), after := before + rng.random(20))
        assert np.isfinite(after).all() and accelerator.active


def test_folded_cells_are_those_that_quality_finds():
    rng = np.random.default_rng(2)
    points = np.stack(np.meshgrid(np.arange(7.0), np.arange(6.0), np.arange(9.0), indexing="ij"), axis=-1)
    points += 0.3 * rng.standard_normal(points.shape)
    expected = int((quality.measure(StructuredGrid(points), "jacobian") <= 0).sum())
    assert 0 < expected < 6 * 5 * 8
    assert count_folded(points) == expected
    assert count_folded(points[::-1], -1.0) == expected


def test_moves_are_measured_in_local_spacings():
    rng = np.random.default_rng(3)
    shape = (5, 6, 7)
    points = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij")).astype(float) * [[[[2.0]]], [[[3]]], [[[1]]]]
    points += 0.1 * rng.standard_normal(points.shape)
    before = points + 0.01 * rng.standard_normal(points.shape)
    moves = np.zeros(shape[0])
    kernels.largest_move(points.ravel(), before.ravel(), shape, 1, shape[0] - 1, moves)
    spacing = np.min([np.linalg.norm(np.gradient(points, axis=d), axis=0) for d in (1, 2, 3)], axis=0)
    ratio = np.linalg.norm(points - before, axis=0) / spacing
    np.testing.assert_allclose(moves[1:-1], ratio[1:-1, 1:-1, 1:-1].max(axis=(1, 2)), rtol=1e-12)


class Halved(Linear):
    """The same with a coarser level; cells are folded as soon as any number is off by more than ``room``."""

    def __init__(self, n, workers, room):
        super().__init__(n)
        self.room, self.origin = room, self.x.copy()
        self.transfer = Transfer((Line(n - 1, n // 2),), workers)

    def smooth(self, *, back):
        pass

    def folded(self):
        return int((abs(self.x - self.origin) > self.room).sum())


@pytest.mark.parametrize(("room", "share", "cuts"), [(9.0, 1.0, 0), (0.05, 0.4**3, 3), (1e-3, 0.0, 5), (-1.0, 1.0, 0)])
def test_coarse_corrections_are_shortened_and_left_out_where_they_fold_cells_however_short(room, share, cuts):
    with Workers(1) as workers:
        fine, coarse = Halved(17, workers, room), Linear(9)
        outcome = Outcome()
        cycle([fine, coarse], 0, outcome)
    expected = share * np.interp(np.arange(17) / 2, np.arange(9), coarse.x[0] - fine.origin[0, ::2])
    np.testing.assert_allclose(fine.x[0] - fine.origin[0], expected, atol=1e-14)
    assert outcome.guarded == cuts
    assert abs(coarse.x - 1).max() > 0.2


def test_coarse_corrections_without_a_value_are_left_out():
    with Workers(1) as workers:
        fine, coarse = Halved(17, workers, 9.0), Linear(9)
        coarse.rates = np.full(9, np.nan)
        cycle([fine, coarse], 0, Outcome())
    assert (fine.x == fine.origin).all()
