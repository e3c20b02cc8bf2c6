"""The one-dimensional Poisson equation as a law of spacing: that of edges in elliptic generation (survey 2.6)."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..errors import InvalidInput
from .end_cells import SMALLEST, count, fail, fraction, pinned, root
from .spacing import geometric, uniform


def poisson(
    cells: int,
    *,
    control: Sequence[float] | None = None,
    first: float | None = None,
    last: float | None = None,
) -> np.ndarray:
    """Solve ``x'' + P x' = 0`` along an edge, with a given control function or with given end cells.

    Parameters
    ----------
    cells : int
        Number of cells.
    control : (cells - 1,) float, optional
        P at the points between the ends, in units of the points' numbers; between -2 and 2. Positive values draw
        the points towards the end.
    first, last : float, optional
        First and last cell as fractions of the whole, in place of `control`. With one of them P is constant, which
        makes cells grow by a constant ratio; with both, the logarithm of the growth varies linearly between the ends.

    Returns
    -------
    (cells + 1,) float
        Fractions from 0 to 1, increasing.

    Raises
    ------
    InvalidInput
        If both control and end cells are given, or P leaves its range, or no such spacing exists.

    Notes
    -----
    With central differences the equation says that cells grow by ``(1 - P/2) / (1 + P/2) = exp(-2 artanh(P/2))`` at
    each point, so that it is solved by a sum, exactly, and is monotone for any P between -2 and 2.
    For both end cells a solution exists as long as they leave room between them.

    References
    ----------
    Survey, section 2.6: "the gridding of the edges is calculated using a 1D Poisson equation".

    Examples
    --------
    >>> (7 * poisson(3, control=[-2 / 3, -2 / 3])).round(6)
    array([0., 1., 3., 7.])
    >>> poisson(4, first=0.1, last=0.1).round(3)
    array([0. , 0.1, 0.5, 0.9, 1. ])
    """
    cells = count(cells)
    if control is not None:
        if first is not None or last is not None:
            raise InvalidInput("is given together with end cells; give the one or the other", parameter="control")
        return pinned(_summed(_log_growth(control, cells)), None, None)
    if first is None and last is None:
        return uniform(cells)
    if first is None or last is None:
        return geometric(cells, first=first, last=last)
    first, last = fraction(first, "first", cells), fraction(last, "last", cells)
    return pinned(_two_sided(cells, first, last), first, last)


def _log_growth(control: Sequence[float], cells: int) -> np.ndarray:
    try:
        values = np.asarray(control, float)
    except (TypeError, ValueError):
        raise InvalidInput("needs numbers", parameter="control") from None
    if values.shape != (cells - 1,):
        raise InvalidInput(f"needs {cells - 1} values for {cells} cells, got {values.shape}", parameter="control")
    bad = np.flatnonzero(~(np.abs(values) < 2))
    if len(bad):
        raise InvalidInput(
            f"must lie between -2 and 2, got {values[bad[0]]:g} at {bad[0]}; use more cells", parameter="control"
        )
    return -2 * np.arctanh(0.5 * values)


def _summed(log_growth: np.ndarray) -> np.ndarray:
    """Fractions of cells whose logarithms differ by ``log_growth``."""
    size = np.concatenate([[0.0], np.cumsum(log_growth)])
    steps = np.exp(size - size.max())
    steps /= steps.sum()
    if steps.min() < SMALLEST:
        fail("control", f"makes a cell of {steps.min():.3g} of the line, below {SMALLEST:g}; make it smaller")
    return np.concatenate([[0.0], np.cumsum(steps)])


def _two_sided(cells: int, first: float, last: float) -> np.ndarray:
    """Cells whose logarithm is a parabola between those of the ends, with its height from their sum."""
    if cells == 1:
        return uniform(1)
    total = first + last
    if total >= 1 if cells > 2 else abs(total - 1) > 1e-12:
        fail("first", f"and last are {first:g} and {last:g} of a line of {cells} cells; make them add up to its length")
    if cells == 2:
        return np.array([0.0, first, 1.0])
    i = np.arange(cells) / (cells - 1)
    straight = (1 - i) * math.log(first) + i * math.log(last)
    bow = 4 * i * (1 - i)
    middle = cells // 2  # this cell alone fills the line at ``high``, and at ``low`` all others together leave room
    high = -straight[middle] / bow[middle]
    low = min(0.0, (math.log((1 - total) / cells) - straight.max()) / bow[1])

    def excess(height: float) -> float:
        return float(np.exp(straight + height * bow).sum()) - 1

    steps = np.exp(straight + root(excess, low, high) * bow)
    if steps.min() < SMALLEST:
        fail("first", f"and last make a cell of {steps.min():.3g} of the line, below {SMALLEST:g}; make them smaller")
    return np.concatenate([[0.0], np.cumsum(steps)])
