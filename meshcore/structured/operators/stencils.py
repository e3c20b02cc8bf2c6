"""Finite-difference stencils along the lines of a grid, in index units.

Points of a line stand at 0, 1, ..., its cells between them. A stencil takes values at the one or the other to either.
There is one rule for all ends of lines: ghost values, extrapolated by a polynomial, so that the stencil of the
interior serves there too. They are extrapolated two orders better than the stencil's, so that the error stays smooth
up to the end, and a derivative of a derivative keeps the order (the usual one-sided formulas of order p have another
error than the interior's, and the derivative of that jump is of order p - 1).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
import scipy.sparse


@dataclass(frozen=True)
class Stencil:
    """Weights that take the values along a line to a derivative, mean or interpolant.

    Parameters
    ----------
    first : int
        The value number k of the result is made of those number k + first, k + first + 1, ...
    weights : tuple of float
        One for each of these.
    growth : int
        How many more values the result has: -1 from points to cells, 1 from cells to points, else 0.
    needed : int
        Values from which ghosts are extrapolated: a line that is not periodic has at least so many.

    Examples
    --------
    >>> Stencil(-1, (-0.5, 0.0, 0.5), 0, 4).along(np.array([0.0, 1, 4, 9, 16]), 0).tolist()
    [0.0, 2.0, 4.0, 6.0, 8.0]
    """

    first: int
    weights: tuple[float, ...]
    growth: int
    needed: int

    def along(self, values: np.ndarray, axis: int, period: int = 0) -> np.ndarray:
        """The result along one axis of an array.

        Parameters
        ----------
        values : (..., n, ...) float
            Of points or of cells.
        axis : int
            Axis of the line.
        period : int
            Cells of a line that is closed, so that its last point repeats its first; 0 for an open one.

        Returns
        -------
        (..., n + growth, ...) float
        """
        extended = self._extended(values, axis, period)
        count = values.shape[axis] + self.growth
        before, after = (slice(None),) * axis, (slice(None),) * (values.ndim - axis - 1)
        result = np.zeros((*values.shape[:axis], count, *values.shape[axis + 1 :]))
        for k, weight in enumerate(self.weights):
            if weight:
                result += weight * extended[(*before, slice(k, k + count), *after)]
        return result

    def matrix(self, n: int, period: int = 0) -> scipy.sparse.csr_matrix:
        """(n + growth, n) sparse: the same for a line of n values."""
        band = scipy.sparse.diags(
            self.weights, range(len(self.weights)), shape=(n + self.growth, n + self.growth + len(self.weights) - 1)
        )
        return scipy.sparse.csr_matrix(band @ self._extended(np.eye(n), 0, period))

    def _extended(self, values: np.ndarray, axis: int, period: int) -> np.ndarray:
        """The values with ghosts before and after them along an axis, as many as the stencil reaches."""
        n = values.shape[axis]
        before, after = -self.first, self.growth + self.first + len(self.weights) - 1
        if period:
            return np.take(values, np.arange(-before, n + after) % period, axis)
        if not before and not after:
            return values
        first = np.take(values, np.arange(self.needed), axis)
        last = np.take(values, np.arange(n - 1, n - 1 - self.needed, -1), axis)
        low = np.tensordot(extrapolation(before, self.needed)[::-1], first, (1, axis))
        high = np.tensordot(extrapolation(after, self.needed), last, (1, axis))
        return np.concatenate([np.moveaxis(low, 0, axis), values, np.moveaxis(high, 0, axis)], axis)


@cache
def extrapolation(count: int, needed: int) -> np.ndarray:
    """(count, needed) float: Lagrange's weights of values at 0, 1, ... for ghosts at -1, -2, ..."""
    nodes = np.arange(needed)
    table = np.ones((count, needed))
    for ghost in range(count):
        for k in nodes:
            others = nodes[nodes != k]
            table[ghost, k] = np.prod((-1.0 - ghost - others) / (k - others))
    return table


def _stencil(order: int, first: int, weights: tuple[float, ...], over: float, growth: int) -> Stencil:
    return Stencil(first, tuple(w / over for w in weights), growth, order + 2)


class Stencils(NamedTuple):
    """The stencils of one order of accuracy.

    Attributes
    ----------
    derivative : Stencil
        Of values at points at the points; likewise of means over cells, or values in their middles, at the same.
    middle_derivative, middle : Stencil
        Derivative and value in the middle of each cell, of values at points.
    derivative_of_middles : Stencil
        Derivative at points, of values in the middles of cells.
    mean : Stencil
        Mean over each cell, of values at points.
    face, face_derivative : Stencil
        Value and derivative at points, of means over cells.
    """

    derivative: Stencil
    middle_derivative: Stencil
    middle: Stencil
    derivative_of_middles: Stencil
    mean: Stencil
    face: Stencil
    face_derivative: Stencil


STENCILS = {
    2: Stencils(
        derivative=_stencil(2, -1, (-1, 0, 1), 2, 0),
        middle_derivative=_stencil(2, 0, (-1, 1), 1, -1),
        middle=_stencil(2, 0, (1, 1), 2, -1),
        derivative_of_middles=_stencil(2, -1, (-1, 1), 1, 1),
        mean=_stencil(2, 0, (1, 1), 2, -1),
        face=_stencil(2, -1, (1, 1), 2, 1),
        face_derivative=_stencil(2, -1, (-1, 1), 1, 1),
    ),
    4: Stencils(
        derivative=_stencil(4, -2, (1, -8, 0, 8, -1), 12, 0),
        middle_derivative=_stencil(4, -1, (1, -27, 27, -1), 24, -1),
        middle=_stencil(4, -1, (-1, 9, 9, -1), 16, -1),
        derivative_of_middles=_stencil(4, -2, (1, -27, 27, -1), 24, 1),
        mean=_stencil(4, -1, (-1, 13, 13, -1), 24, -1),
        face=_stencil(4, -2, (-1, 7, 7, -1), 12, 1),
        face_derivative=_stencil(4, -2, (1, -15, 15, -1), 12, 1),
    ),
}
"""Order of accuracy -> `Stencils`."""
DIFFERENCE = _stencil(2, 0, (-1, 1), 1, -1)
"""What a cell's end has more than its start: the exact mean of a derivative over it, of values at points."""
SLOPE = Stencil(-1, (-0.5, 0.0, 0.5), 0, needed=6)
"""Derivative of second order with ghosts of the fourth's, for corrections of the fourth order."""
