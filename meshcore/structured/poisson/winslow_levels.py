"""The levels of the planar Winslow solver: nonlinear multigrid (FAS) of the first kind, with smoothing by lines.

A. Brandt, O. E. Livne, "Multigrid Techniques" (2011): the full approximation scheme (8.4) and full multigrid (7).
Each level has about half as many cells a side as the next finer one, whatever their number: levels need not be nested.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from ...threads import Workers
from . import _winslow_kernels as kernels
from . import _winslow_transfer_kernels as transfer
from .multigrid import guarded

FEWEST_CELLS = (8, 8)
"""Cells along i and j below which a direction is not coarsened: a ten-chord annulus collapses on fewer."""
POINTS_A_THREAD = 60_000
"""With fewer points to work on, a further thread does not pay."""
_SWEEPS_AT_THE_BOTTOM = 8


@dataclass(frozen=True)
class Table:
    """Transfer along one direction between ``fine`` and ``coarse`` cells; node 0 is the first, ghosts come after.

    It stands beside `transfer.Line`, since kernels for both directions at once read one place and one share a node:
    with two of each, the small grids of a plane take 2 to 4 % longer.

    Parameters
    ----------
    fine, coarse : int
        Numbers of cells.
    cyclic : bool
        Whether the last node is the first.
    """

    fine: int
    coarse: int
    cyclic: bool

    @property
    def ratio(self) -> float:
        """Fine cells per coarse cell."""
        return self.fine / self.coarse

    @cached_property
    def to_coarse(self) -> tuple[np.ndarray, np.ndarray]:
        """For each coarse node the fine node before it, and that node's share in linear interpolation."""
        return _neighbours(np.arange(self.coarse + 1) * self.ratio, self.fine)

    @cached_property
    def to_fine(self) -> tuple[np.ndarray, np.ndarray]:
        """For each fine node the coarse node before it, and that node's share in linear interpolation."""
        return _neighbours(np.arange(self.fine + 1) / self.ratio, self.coarse)

    @cached_property
    def hats(self) -> tuple[np.ndarray, np.ndarray]:
        """For each coarse node the fine nodes under its hat function, and their weights, which add up to one."""
        at = np.arange(self.coarse + 1) * self.ratio
        nodes = np.round(at).astype(np.int64)[:, None] + np.arange(transfer.HAT) - transfer.HAT // 2
        weights = 1 - np.abs(nodes - at[:, None]) / self.ratio
        weights[weights < 1e-12] = 0  # boundaries, at the rim of a hat, have no part in it at all
        if self.cyclic:
            nodes = (nodes - 1) % self.fine + 1
        else:
            weights[(nodes < 0) | (nodes > self.fine)] = 0
            nodes = np.clip(nodes, 0, self.fine)
        return nodes, weights / weights.sum(axis=1, keepdims=True)


def _neighbours(at: np.ndarray, cells: int) -> tuple[np.ndarray, np.ndarray]:
    left = np.minimum(np.floor(at + 1e-12).astype(np.int64), cells - 1)
    return left, 1 - (at - left)


class Level:
    """Arrays of one level and what is done on it alone.

    Parameters
    ----------
    cells : tuple of two int
        Cells along i and j.
    cyclic : bool
        Whether the last node along i is the first, up to ``shift``; a ghost row is added then.
    sharp : bool
        Whether the boundary turns back on itself where a cyclic grid is cut, see `_winslow_kernels.CORNER`.
    shift : (2,) float
        From the first to the last node along i of a cyclic grid; zero for an O-grid.
    workers : Workers
        Who does the work.
    is_finest : bool
        Whether its right-hand side is zero for ever.

    Attributes
    ----------
    step : float
        Share of each line's correction that smoothing makes.
    """

    def __init__(
        self, cells: tuple[int, int], cyclic: bool, sharp: bool, shift: np.ndarray, workers: Workers, *, is_finest: bool
    ):
        self.cells, self.cyclic, self.shift, self._workers = cells, cyclic, shift, workers
        self.step = 1.0
        shape = (2, cells[0] + 1 + cyclic, cells[1] + 1)
        self.sharp = cells[0] if cyclic and sharp else 0  # row 0 is no unknown, so this is none
        # Not `zeros`, which do not come in large pages: first writes to small ones take as long as smoothing lines.
        self.r, self.d = np.full(shape, 0.0), np.full(shape, 0.0)
        one_row = (2, 1, shape[2])
        self.f, self.c = np.zeros(one_row if is_finest else shape), np.zeros(one_row)
        self._per_row = np.zeros(shape[1])
        self._folds = np.zeros(shape[1] - 1, np.int64)

    @property
    def points(self) -> int:
        """Nodes, ghosts included."""
        return self.r[0].size

    def share(self, work: Callable[[int, int], object], first: int, last: int, grain: int = 1) -> None:
        """Call ``work(first, last)`` on parts of some rows or columns at once."""
        self._workers.run(work, first, last, most=self.points // POINTS_A_THREAD, grain=grain)

    def rows(self, number: int) -> np.ndarray:
        """(number, nj) room for rows, of no value yet: for one thread."""
        return np.empty((number, self.r.shape[2]))

    def wrap(self) -> None:
        """Make ghosts follow."""
        if self.cyclic:
            kernels.wrap(self.r, self.shift)

    def put(self, points: np.ndarray) -> None:
        """Set (2, ni, nj) coordinates, without ghosts."""
        self.r[:, : self.cells[0] + 1] = points
        self.wrap()

    @property
    def points_without_ghosts(self) -> np.ndarray:
        """(2, ni, nj) coordinates."""
        return self.r[:, : self.cells[0] + 1]

    def smooth(self) -> None:
        """Solve every line of odd number, then of even, first along j, then along i."""
        r, f, c = self.r, self.f, self.c

        def along_j(a: int, b: int) -> None:
            lines = np.empty(kernels.RECORD * r.shape[2])
            kernels.smooth_along_j(r, f, c, self.sharp, self.step, self.rows(4), lines, a, b)

        def along_i(a: int, b: int) -> None:
            lines = np.empty(kernels.RECORD * r.shape[1])
            kernels.smooth_along_i(r, f, c, self.sharp, self.cyclic, self.step, lines, a, b)

        for run, lines in ((along_j, r.shape[1]), (along_i, r.shape[2])):
            for odd in (1, 2):
                self.share(run, odd, lines - 1, 2 * kernels.LANES)
                self.wrap()

    def find_defect(self) -> None:
        """d = f - N(r)."""
        self.share(
            lambda a, b: kernels.defect(self.r, self.f, self.c, self.d, self.sharp, a, b), 1, self.r.shape[1] - 1
        )

    def residual(self) -> float:
        """Root of the mean square of the way that a step of point Jacobi would move a node."""
        last = self.r.shape[1] - 1

        def run(a: int, b: int) -> None:
            kernels.jacobi_moves(self.r, self.f, self.c, self.sharp, self.rows(4), self._per_row, a, b)

        self.share(run, 1, last)
        return float(np.sqrt(self._per_row[1:last].sum() / ((last - 1) * (self.r.shape[2] - 2))))

    def largest_move(self, before: np.ndarray) -> float:
        """The longest way of a node since ``before``, in units of the shortest edge at the node."""
        last = self.r.shape[1] - 1
        self.share(lambda a, b: kernels.largest_moves(self.r, before, self._per_row, a, b), 1, last)
        return float(np.sqrt(self._per_row[1:last].max()))

    def folds(self, sign: float) -> int:
        """How many cells have no area of the given sign."""
        last = self.r.shape[1] - 1
        self.share(lambda a, b: kernels.count_folds(self.r, sign, self._folds, a, b), 0, last)
        return int(self._folds.sum())


class Levels:
    """All levels, the finest first, and the cycles through them.

    Parameters
    ----------
    cells, cyclic, sharp, shift, workers
        As of the finest `Level`.
    sign : float
        1 or -1, the sign of the grid's area: the orientation that cells must keep.
    fewest : tuple of two int
        Cells along i and j that are not made fewer.
    """

    def __init__(
        self,
        cells: tuple[int, int],
        *,
        cyclic: bool,
        sharp: bool,
        shift: np.ndarray,
        sign: float,
        workers: Workers,
        fewest: tuple[int, int] = FEWEST_CELLS,
    ):
        self.sign, self.workers = sign, workers
        self.levels, self.tables = [], []
        while True:
            self.levels.append(Level(cells, cyclic, sharp, shift, workers, is_finest=not self.levels))
            coarser = tuple((n + 1) // 2 if n > least else n for n, least in zip(cells, fewest, strict=True))
            if coarser == cells:
                break
            self.tables.append((Table(cells[0], coarser[0], cyclic), Table(cells[1], coarser[1], False)))
            cells = coarser
        self._before = [level.r.copy() for level in self.levels[1:]]

    def set_growth(self, theta: np.ndarray) -> None:
        """Set the control functions of all levels from the finest's (2, ni, nj) logarithms of growth per cell.

        On a straight line ``p = -2 tanh(theta / 2)`` makes each cell exp(theta) times as long as the one before. It is
        theta that is averaged and multiplied on the way to coarser levels, so that |p| < 2 on all of them: the
        off-diagonals of every line keep their sign.
        """
        for number, level in enumerate(self.levels):
            if level.c.shape != level.r.shape:
                level.c = np.zeros(level.r.shape)
            level.c[:, : theta.shape[1]] = -2 * np.tanh(0.5 * theta)
            if level.cyclic:
                kernels.wrap(level.c, np.zeros(2))
            if number < len(self.tables):
                along_i, along_j = self.tables[number]
                padded = np.zeros(level.r.shape)
                padded[:, : theta.shape[1]] = theta
                coarse = np.zeros(self.levels[number + 1].r.shape)
                self._average(number, padded, coarse, 1.0)
                coarse *= np.array([along_i.ratio, along_j.ratio])[:, None, None]
                if level.cyclic:
                    kernels.wrap(coarse, np.zeros(2))
                theta = coarse[:, : self.levels[number + 1].cells[0] + 1]

    def set_step(self, step: float) -> None:
        """Set the share of each line's correction that smoothing makes on all levels."""
        for level in self.levels:
            level.step = step

    def cycle(self, number: int = 0, damping: float = 1.0) -> None:
        """One V(1, 1) cycle from level ``number`` down and up again."""
        level = self.levels[number]
        if number == len(self.tables):
            for _ in range(_SWEEPS_AT_THE_BOTTOM):
                level.smooth()
            return
        coarser = self.levels[number + 1]
        level.smooth()
        level.find_defect()
        self.sample(number)
        self._before[number][:] = coarser.r
        coarser.f[:] = 0
        coarser.find_defect()
        along_i, along_j = self.tables[number]
        self._average(number, level.d, coarser.f, along_i.ratio**2 * along_j.ratio**2)
        coarser.f -= coarser.d
        self.cycle(number + 1, damping)
        self._correct_guarded(number, damping)
        level.smooth()

    def sample(self, number: int) -> None:
        """Set the coordinates of the level after ``number`` by interpolation."""
        along_i, along_j = self.tables[number]
        coarser = self.levels[number + 1]
        transfer.sample(self.levels[number].r, coarser.r, *along_i.to_coarse, *along_j.to_coarse)
        coarser.wrap()

    def correct(self, number: int, before: np.ndarray, step: float = 1.0) -> None:
        """Add what changed since ``before`` on the next coarser level to level ``number``."""
        along_i, along_j = self.tables[number]
        level, coarser = self.levels[number], self.levels[number + 1]

        def run(a: int, b: int) -> None:
            row = coarser.rows(1)[0]
            transfer.correct(coarser.r, before, level.r, *along_i.to_fine, *along_j.to_fine, step, row, a, b)

        level.share(run, 1, level.r.shape[1] - 1)
        level.wrap()

    def _correct_guarded(self, number: int, step: float) -> None:
        """The same, shortened or left out where it folds more cells."""
        level, before = self.levels[number], self._before[number]
        if np.isfinite(self.levels[number + 1].r).all():
            guarded(partial(self.correct, number, before), lambda: level.folds(self.sign), step)

    def _average(self, number: int, fine: np.ndarray, coarse: np.ndarray, scale: float) -> None:
        along_i, along_j = self.tables[number]
        level = self.levels[number]

        def run(a: int, b: int) -> None:
            transfer.average(fine, coarse, *along_i.hats, *along_j.hats, scale, level.rows(1)[0], a, b)

        level.share(run, 1, coarse.shape[1] - 1)
