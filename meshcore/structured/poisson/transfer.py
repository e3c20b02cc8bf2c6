"""Transfer of values between grids of any numbers of cells, direction by direction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...threads import Workers
from . import _multigrid_kernels as kernels

LEAST_CELLS = 8
"""Coarser than so many cells in a direction, a bent block may collapse."""


def coarser(cells: int, least: int = LEAST_CELLS) -> int:
    """Half as many cells, rounded up; the same if that were fewer than ``least``.

    Examples
    --------
    >>> coarser(128), coarser(33), coarser(15), coarser(14)
    (64, 17, 8, 14)
    """
    half = (cells + 1) // 2
    return half if half >= least else cells


NUMBERS_A_THREAD = 25_000
"""With fewer numbers to work on, a further thread does not pay."""

Table = tuple[np.ndarray, np.ndarray]
"""(m, t) places and (m, t) weights of the t values that make each of m new ones."""


@dataclass(frozen=True)
class Line:
    """Both grids of one direction: ``fine`` and ``coarse`` cells of equal size on the same interval.

    Examples
    --------
    >>> Line(5, 3).to_fine[1].round(2).tolist()
    [[1.0, 0.0], [0.4, 0.6], [0.8, 0.2], [0.2, 0.8], [0.6, 0.4], [0.0, 1.0]]
    """

    fine: int
    coarse: int

    @cached_property
    def to_fine(self) -> Table:
        """Linear interpolation from coarse to fine."""
        return _linear(self.coarse, self.fine)

    @cached_property
    def to_coarse(self) -> Table:
        """Linear interpolation from fine to coarse: for the solution."""
        return _linear(self.fine, self.coarse)

    @cached_property
    def averages(self) -> Table:
        """Means under hats as wide as coarse cells: for the defect."""
        index, weight = _hats(self)
        weight[(index < 0) | (index > self.fine)] = 0
        return np.clip(index, 0, self.fine), weight / weight.sum(axis=1, keepdims=True)


class Ring(Line):
    """A `Line` around a closed direction, whose last node is its first.

    Examples
    --------
    >>> Ring(4, 2).averages[0].tolist()
    [[2, 3, 0, 1, 2], [0, 1, 2, 3, 0], [2, 3, 0, 1, 2]]
    """

    @cached_property
    def averages(self) -> Table:
        """Means under hats as wide as coarse cells, across the cut, too."""
        index, weight = _hats(self)
        return index % self.fine, weight / weight.sum(axis=1, keepdims=True)


def _hats(line: Line) -> Table:
    """Nodes of the fine grid under the hats at coarse nodes, some beyond the ends, and the hats' values there."""
    ratio = line.fine / line.coarse
    at = np.arange(line.coarse + 1) * ratio
    index = np.rint(at).astype(np.int64)[:, None] + np.arange(-2, 3)
    return index, np.maximum(0.0, 1 - np.abs(index - at[:, None]) / ratio)


def _linear(n: int, m: int) -> Table:
    """Linear interpolation of n cells at the nodes of m cells."""
    whole, part = np.divmod(np.arange(m + 1) * n, m)  # exact, so that common nodes are copied
    left = np.minimum(whole, n - 1)
    share = (whole - left) + part / m
    return np.column_stack([left, left + 1]), np.column_stack([1 - share, share])


@dataclass(frozen=True)
class Transfer:
    """Between two grids of the same directions; a direction that is not coarsened is left alone."""

    lines: tuple[Line, ...]
    workers: Workers

    @property
    def scale(self) -> float:
        """Square of the ratio of the cells' sizes in index units."""
        return float(np.prod([line.fine / line.coarse for line in self.lines])) ** 2

    def sampled(self, fine: np.ndarray) -> np.ndarray:
        """(m, *fine shape) values at the coarse nodes."""
        return self._along(fine, [line.to_coarse for line in self.lines], range(len(self.lines)))

    def averaged(self, fine: np.ndarray) -> np.ndarray:
        """(m, *fine shape) values, averaged about the coarse nodes."""
        return self._along(fine, [line.averages for line in self.lines], range(len(self.lines)))

    def add(self, coarse: np.ndarray, factor: float, fine: np.ndarray) -> None:
        """Add ``factor`` times the values that are interpolated from (m, *coarse shape) to ``fine``."""
        axes = [d for d, line in enumerate(self.lines) if line.fine != line.coarse]
        tables = [line.to_fine for line in self.lines]
        # The axis that lies contiguous goes first, while there is least of it; the last pass adds at once.
        values = self._along(coarse, tables, axes[:0:-1])
        self._pass(values, axes[0], tables[axes[0]], factor, fine)

    def _along(self, values: np.ndarray, tables: list[Table], axes) -> np.ndarray:
        for axis in axes:
            if self.lines[axis].fine != self.lines[axis].coarse:
                values = self._pass(values, axis, tables[axis])
        return values

    def _pass(
        self, values: np.ndarray, axis: int, table: Table, factor: float = 1.0, target: np.ndarray | None = None
    ) -> np.ndarray:
        """One direction's transfer of (m, *shape) values; added to the target if there is one."""
        shape = list(values.shape)
        shape[1 + axis] = len(table[0])
        adds = target is not None
        out = target if adds else np.empty(shape)  # all of it is overwritten
        inner = int(np.prod(shape[2 + axis :]))
        source, flat = values.reshape(-1, values.shape[1 + axis], inner), out.reshape(-1, len(table[0]), inner)

        def combine(first: int, stop: int) -> None:
            kernels.combine(source, *table, factor, adds, flat, first, stop)

        self.workers.run(combine, 0, len(flat), most=out.size // NUMBERS_A_THREAD)
        return out


def coarsened(shape: Sequence[int], chosen: Sequence[bool] | None = None, least: int = LEAST_CELLS) -> tuple[Line, ...]:
    """The lines to a grid with half the cells in all directions, or the chosen ones; empty if none can be coarsened.

    Examples
    --------
    >>> coarsened((65, 11))
    (Line(fine=64, coarse=32), Line(fine=10, coarse=10))
    >>> coarsened((9, 11))
    ()
    """
    cells = [n - 1 for n in shape]
    chosen = [True] * len(cells) if chosen is None else chosen
    lines = tuple(Line(n, coarser(n, least) if yes else n) for n, yes in zip(cells, chosen, strict=True))
    return lines if any(line.coarse < line.fine for line in lines) else ()


def growth_on_coarse(transfer: Transfer, growth: np.ndarray) -> np.ndarray:
    """(m, *coarse shape) logarithms of growth on the coarse grid: of that over a coarse cell."""
    ratio = np.array([line.fine / line.coarse for line in transfer.lines])
    return transfer.averaged(growth) * ratio.reshape(-1, *[1] * len(ratio))
