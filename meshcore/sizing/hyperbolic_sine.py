"""The hyperbolic sine as a law of spacing, with one or both end cells as given (survey 2.6)."""

from __future__ import annotations

import math

import numpy as np

from .end_cells import SMALLEST, count, fail, fraction, pinned, root
from .spacing import uniform

_CURE = "choose other end cells, or the hyperbolic tangent"


def hyperbolic_sine(cells: int, *, first: float | None = None, last: float | None = None) -> np.ndarray:
    """Vinokur's other stretching: cells that grow at the end of the line as by a ratio, from even ones at its start.

    Parameters
    ----------
    cells : int
        Number of cells.
    first, last : float, optional
        First and last cell as fractions of the whole. With one of them the other end is left free (one-sided);
        without any the cells are equal.

    Returns
    -------
    (cells + 1,) float
        Fractions from 0 to 1, increasing.

    Raises
    ------
    InvalidInput
        If no such spacing exists. The law reaches less than the hyperbolic tangent: two small ends of n cells add up
        to at least ``1 - cos(pi / n)``.

    Notes
    -----
    One-sided, ``s = sinh(d t) / sinh(d)``. Two-sided, the slope is ``a cosh(d (t - c))``, Vinokur's function for
    an interior point c, which is now whatever the end cells make of it. It is the sum of an even part,
    ``1/2 + sinh(d (t - 1/2)) / (2 sinh(d / 2))``, whose d follows from the sum of both end cells, and of a multiple
    of ``sinh(d t / 2) sinh(d (1 - t) / 2)``, by half their difference. Where the cells shrink, sinh becomes sin.

    References
    ----------
    M. Vinokur, "On one-dimensional stretching functions for finite-difference calculations", J. Comput. Phys. 50
    (1983). Survey, section 2.6.

    Examples
    --------
    >>> hyperbolic_sine(4, first=0.1).round(3)
    array([0.   , 0.1  , 0.246, 0.506, 1.   ])
    >>> hyperbolic_sine(4, first=0.2, last=0.2).round(3)
    array([0. , 0.2, 0.5, 0.8, 1. ])
    """
    cells = count(cells)
    if first is None and last is None:
        return uniform(cells)
    if first is None:
        last = fraction(last, "last", cells)
        return pinned(1 - _one_sided(cells, last, "last")[::-1], None, last)
    first = fraction(first, "first", cells)
    if last is None:
        return pinned(_one_sided(cells, first, "first"), first, None)
    return pinned(_two_sided(cells, first, fraction(last, "last", cells)), first, last)


def _sinh_ratio(a: np.ndarray | float, b: float) -> np.ndarray | float:
    """``sinh(a) / sinh(b)`` for |a| <= b, without overflow."""
    size = np.abs(a)
    return np.sign(a) * np.exp(size - b) * np.expm1(-2 * size) / np.expm1(-2 * b)


def _one_sided(cells: int, first: float, parameter: str) -> np.ndarray:
    t, h = uniform(cells), 1 / cells
    if cells == 1 or abs(first * cells - 1) < 1e-12:
        return t
    if first < h:
        d = root(lambda d: math.log(_sinh_ratio(d * h, d) / first), 1e-6, 2 - math.log(first) / (1 - h))
        return _sinh_ratio(d * t, d)
    largest = math.sin(0.5 * math.pi * h)
    if first > largest:
        fail(parameter, f"is {first:g} of the line; with {cells} cells it is at most {largest:g}; {_CURE}")
    d = root(lambda d: math.sin(d * h) / math.sin(d) - first, 1e-6, 0.5 * math.pi)
    return np.sin(d * t) / math.sin(d)


def _two_sided(cells: int, first: float, last: float) -> np.ndarray:
    t, h, total = uniform(cells), 1 / cells, first + last
    if cells == 1:
        return t
    if total >= 1 if cells > 2 else abs(total - 1) > 1e-12:
        fail("first", f"and last are {first:g} and {last:g} of a line of {cells} cells; make them add up to its length")
    if cells == 2:
        return np.array([0.0, first, 1.0])
    least = 2 * math.sin(0.5 * math.pi * h) ** 2
    if total < least:
        fail("first", f"and last are {first:g} and {last:g} of the line and add up to less than {least:.3g}; {_CURE}")
    if abs(total - 2 * h) < 1e-10 * h:
        even, uneven = t, t * (1 - t) / (h * (1 - h))
    elif total > 2 * h:
        d = root(lambda d: 1 - _sinh_ratio(d * (0.5 - h), 0.5 * d) - total, 1e-6, 2 - 2 * cells * math.log1p(-total))
        even = 0.5 + 0.5 * _sinh_ratio(d * (t - 0.5), 0.5 * d)
        uneven = np.expm1(-d * t) * np.expm1(-d * (1 - t)) / (math.expm1(-d * h) * math.expm1(-d * (1 - h)))
    else:
        d = root(lambda d: 1 - math.sin(d * (0.5 - h)) / math.sin(0.5 * d) - total, 1e-6, math.pi)
        even = 0.5 + 0.5 * np.sin(d * (t - 0.5)) / math.sin(0.5 * d)
        sine = math.sin(0.5 * d * h) * math.sin(0.5 * d * (1 - h))
        uneven = np.sin(0.5 * d * t) * np.sin(0.5 * d * (1 - t)) / sine
    s = even + 0.5 * (first - last) * uneven
    if (np.diff(s) < SMALLEST).any():
        fail("first", f"and last are {first:g} and {last:g} of the line, too different for {cells} cells; {_CURE}")
    return s
