"""Nonlinear multigrid for grid equations in any number of dimensions: cycles, acceleration, when to stop.

The full approximation scheme of A. Brandt, "Multi-level adaptive solutions to boundary-value problems", Math. Comp. 31
(1977), with a fold guard, started by full multigrid, and accelerated by D. G. Anderson, "Iterative procedures for
nonlinear integral equations", J. ACM 12 (1965). What the equations are, a `Level` knows.
"""

from __future__ import annotations

import itertools
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from ...progress import Progress, advance, silent
from ...threads import Workers
from . import _multigrid_kernels as kernels
from .transfer import NUMBERS_A_THREAD, Transfer

COARSEST_SWEEPS = 12
SHORTER, SHORTENINGS = 0.4, 4
"""A coarse correction that folds cells is shortened to this share, so often, before it is left out."""
DEPTH = 3
"""Earlier cycles that Anderson's acceleration looks back on."""
GROWTH = 2.0
"""A cycle after which the residual is larger by this factor is taken back."""
ROUNDING = 1e-15
"""A residual that is mere rounding, of a grid whose size is about one."""
PATIENCE = 5
"""Cycles that may pass without the residual being halved."""
DAMPED = 0.3
"""Part of coarse corrections that is taken when whole ones do not help any more."""
TINY = 1e-300
GAINED = 0.9
"""Part of the residual that a cycle must leave at most, for its moves to tell how far the solution is."""
MIXED_FROM = 3
"""Cycle from which is accelerated, if the grid need only be close: most are done by then, and remembering costs."""
CLOSE = 1e-3
"""Distance from the converged grid, in local spacings, at which the default stops."""


class Level(ABC):
    """One grid of a hierarchy: unknowns x and right side f, both (m, *shape), their equations and their smoother."""

    x: np.ndarray
    f: np.ndarray
    transfer: Transfer | None = None
    """To the next coarser level; None on the coarsest."""

    @abstractmethod
    def smooth(self, *, back: bool) -> None:
        """One sweep of relaxation, forth or back."""

    @abstractmethod
    def defect(self) -> np.ndarray:
        """f - N(x), zero on the boundary; the array is used again by the next call."""

    @abstractmethod
    def residual(self) -> float:
        """Root mean square of the lengths by which point relaxation would move the nodes."""

    @abstractmethod
    def folded(self) -> int:
        """Number of folded cells."""

    @abstractmethod
    def largest_move(self, before: np.ndarray) -> float:
        """Largest move of a node since ``before``, in local spacings."""


@dataclass
class Outcome:
    """How `solve` fared.

    Attributes
    ----------
    residuals : list of float
        That of the start, then after each cycle.
    converged : bool
    error : float
        Estimated distance from the converged grid, in local spacings.
    guarded : int
        How often coarse corrections were shortened or left out because they folded cells.
    """

    residuals: list[float] = field(default_factory=list)
    converged: bool = False
    error: float = np.inf
    guarded: int = 0

    @property
    def cycles(self) -> int:
        """Cycles on the finest level."""
        return len(self.residuals) - 1


def cycle(levels: list[Level], k: int, outcome: Outcome, step: float = 1.0) -> None:
    """One V(1, 1) cycle of the full approximation scheme from level k down, that takes a part of all corrections."""
    level = levels[k]
    if level.transfer is None:
        for sweep in range(COARSEST_SWEEPS):
            level.smooth(back=bool(sweep % 2))
        return
    coarse = levels[k + 1]
    level.smooth(back=False)
    start = level.transfer.sampled(level.x)
    coarse.x[...] = start
    coarse.f[...] = 0
    # f - N(x) without f is -N(x).
    right = level.transfer.scale * level.transfer.averaged(level.defect()) - coarse.defect()
    coarse.f[...] = right
    cycle(levels, k + 1, outcome, step)
    _correct(level, coarse.x - start, outcome, step)
    level.smooth(back=True)


def _correct(level: Level, correction: np.ndarray, outcome: Outcome, step: float = 1.0) -> None:
    """Add the coarse correction, guarded."""
    if np.isfinite(correction).all():
        outcome.guarded += guarded(lambda part: level.transfer.add(correction, part, level.x), level.folded, step)


def guarded(add: Callable[[float], None], folded: Callable[[], int], step: float) -> int:
    """Add ``step`` of a coarse correction, less of it, or none, if it folds further cells; how often it was cut.

    The discrete equations have folded solutions, too, and coarse grids more of them.

    Examples
    --------
    >>> x = [0.0]
    >>> def add(part):
    ...     x[0] += part
    >>> guarded(add, lambda: int(x[0] > 0.5), 1.0), round(x[0], 3)
    (1, 0.4)
    >>> guarded(add, lambda: int(x[0] > 0.4), 1.0), round(x[0], 3)
    (5, 0.4)
    """
    before = folded()
    add(step)
    for number in range(SHORTENINGS):
        if folded() <= before:
            return number
        add((SHORTER - 1) * step)
        step *= SHORTER
    if folded() <= before:
        return SHORTENINGS
    add(-step)
    return SHORTENINGS + 1


def full_multigrid(levels: list[Level], first: int, outcome: Outcome) -> None:
    """A start for the finest level: solve on level ``first``, and carry the difference from the start upwards."""
    starts = [levels[0].x.copy()]
    for level in levels[:first]:
        starts.append(level.transfer.sampled(starts[-1]))
    for k in range(first, -1, -1):
        levels[k].f[...] = 0
        levels[k].x[...] = starts[k]
        if k < first:
            _correct(levels[k], levels[k + 1].x - starts[k + 1], outcome)
        for _ in range(1 if k < first else 4):
            cycle(levels, k, outcome)


def first_level(levels: list[Level], cells: int) -> int:
    """The coarsest level with so many cells, or as many as there are, in each direction: where to begin."""
    least = np.minimum(cells + 1, levels[0].x.shape[1:])
    return max(k for k, level in enumerate(levels) if (np.array(level.x.shape[1:]) >= least).all())


class Anderson:
    """Acceleration of a fixed-point iteration by what earlier steps told.

    Each step ``g(x)`` becomes the combination of the last ones whose change ``g(x) - x`` is least.

    Parameters
    ----------
    size : int
        Number of unknowns.
    workers : Workers
        Threads.
    depth : int
        Earlier steps that are remembered.
    dtype : type
        What they are remembered in. They steer only: single precision takes half the memory, but where steps hardly
        converge, double precision goes farther.

    Attributes
    ----------
    last : (size,) float
        What the last step made, before it was improved.
    """

    def __init__(self, size: int, workers: Workers, depth: int = DEPTH, dtype: type = np.float64):
        # Not zeros: they do not come in large pages, and first writes to small ones cost more than the sums.
        self._change, self.last = np.empty((2, size))
        self._changes, self._steps = np.empty((2, depth, size), dtype)
        self._gram = np.zeros((depth, depth))
        self._workers = workers
        self._chunks = -(-size // kernels.CHUNK)
        self.forget()

    def forget(self) -> None:
        """Begin anew."""
        self._taken = 0

    @property
    def active(self) -> bool:
        """Whether the last step was improved: the first has none to be compared with."""
        return self._taken > 1

    def accelerate(self, before: np.ndarray, after: np.ndarray) -> None:
        """Improve ``after``, what a step made of ``before``; both flat."""
        if not self._taken:
            np.subtract(after, before, out=self._change)
            self.last[:] = after
            self._taken = 1
            return
        depth = len(self._gram)
        slot = (self._taken - 1) % depth
        state = after, before, self._change, self.last, self._changes, self._steps, slot
        self._share(partial(kernels.remember, *state))
        used = min(self._taken, depth)
        sums = np.zeros((self._chunks, 2, used))
        self._share(partial(self._add_up, slot, sums))
        self._gram[slot, :used], right = sums.sum(axis=0)
        self._gram[:used, slot] = self._gram[slot, :used]
        if not (np.isfinite(right).all() and np.isfinite(self._gram[slot, :used]).all()):
            self.forget()  # the step went astray; its residual will tell
            return
        scale = 1 / np.sqrt(np.maximum(np.diag(self._gram)[:used], TINY))
        gram = self._gram[:used, :used] * scale[:, None] * scale
        factors = scale * np.linalg.lstsq(gram, scale * right, rcond=1e-10)[0]
        self._share(partial(kernels.subtract, after, self._steps, factors))
        self._taken += 1

    def _share(self, work: Callable[[int, int], object]) -> None:
        self._workers.run(work, 0, self._chunks, most=self.last.size // NUMBERS_A_THREAD)

    def _add_up(self, slot: int, sums: np.ndarray, first: int, stop: int) -> None:
        lanes = np.zeros((2, kernels.LANES))
        kernels.products(self._changes, sums.shape[2], slot, self._change, lanes, sums, first, stop)


def solve(
    levels: list[Level],
    *,
    first: int = 0,
    tolerance: float | None = None,
    most: int = 50,
    workers: Workers,
    progress: Progress = silent,
) -> Outcome:
    """Full multigrid, then accelerated cycles until the finest level is close enough or nothing more is gained.

    Parameters
    ----------
    levels : list of Level
        Finest first; the finest holds the start grid, which should be of a size about one.
    first : int
        Level on which full multigrid begins.
    tolerance : float, optional
        Residual to reach, as part of the start's; by default the grid is to be within `CLOSE` of the converged one.
    most : int
        Cycles that are done at most.
    workers : Workers
        Threads for the acceleration.
    progress : Progress
        Told after each cycle.
    """
    level = levels[0]
    outcome = Outcome([level.residual()])
    goal = max((tolerance or 0.0) * outcome.residuals[0], ROUNDING)
    before = level.x.copy()
    full_multigrid(levels, first, outcome)
    accelerator = Anderson(level.x.size, workers, dtype=np.float32)
    outcome.residuals.append(level.residual())
    if not outcome.residuals[1] <= max(GROWTH * outcome.residuals[0], goal):  # coarse grids had other solutions
        level.x[...], outcome.residuals[1] = before, outcome.residuals[0]
    if outcome.residuals[-1] <= goal:
        outcome.converged, outcome.error = True, 0.0
    moves: list[float] = []
    step, since = 1.0, 0
    for number in range(most):
        if outcome.converged:
            break
        if _stalled(outcome.residuals[since:]):
            if step < 1:
                break
            step, since = DAMPED, len(outcome.residuals) - 1
            accelerator.forget()
        before[...] = level.x
        cut = outcome.guarded
        cycle(levels, 0, outcome, step)
        moves.append(level.largest_move(before))
        outcome.error = _remaining(moves)
        near = tolerance is None and outcome.error <= CLOSE
        if not near and (tolerance is not None or number + 1 >= MIXED_FROM):
            _accelerate(level, before, accelerator)
        residual = level.residual()
        if not residual <= GROWTH * outcome.residuals[-1]:
            residual, near = _relaxed(level, before, accelerator), False
        # Small moves tell nothing of the distance where corrections were cut, or leave the residual as it was.
        near = bool(near and outcome.guarded == cut and residual <= GAINED * outcome.residuals[-1])
        outcome.residuals.append(residual)
        outcome.converged = near or residual <= goal
        advance(progress, (number + 1) / most, f"cycle {number + 1}: residual {residual:.1e}")
    return outcome


def _accelerate(level: Level, before: np.ndarray, accelerator: Anderson) -> None:
    """Accelerate what a cycle made of ``before``, unless that folds further cells."""
    folded = level.folded()
    accelerator.accelerate(before.reshape(-1), level.x.reshape(-1))
    if level.folded() > folded:
        level.x[...] = accelerator.last.reshape(level.x.shape)
        accelerator.forget()


def _relaxed(level: Level, before: np.ndarray, accelerator: Anderson) -> float:
    """Take back a cycle that made things worse: relaxation alone goes on from ``before``."""
    level.x[...] = before
    accelerator.forget()
    for sweep in range(COARSEST_SWEEPS):
        level.smooth(back=bool(sweep % 2))
    return level.residual()


def _remaining(moves: list[float]) -> float:
    """Distance from the limit after moves that shrink as the last ones did."""
    if len(moves) < 2:
        return moves[-1]
    rate = min(max(b / max(a, TINY) for a, b in itertools.pairwise(moves[-3:])), 0.95)
    return moves[-1] * rate / (1 - rate)


def _stalled(residuals: list[float]) -> bool:
    """Whether nothing is left to gain: not finite, zero, or the last cycles did not get below what went before."""
    if not 0 < residuals[-1] < np.inf:
        return True
    return len(residuals) > 2 * PATIENCE and min(residuals[-PATIENCE:]) > 0.5 * min(residuals[:-PATIENCE])
