"""One-dimensional spacings: fractions of a line from 0 to 1, dense where cells should be small."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal

import numpy as np

from ..errors import InvalidInput
from .end_cells import SMALLEST, count, fail, fraction, number, pinned, root


def uniform(cells: int) -> np.ndarray:
    """Equal cells.

    Parameters
    ----------
    cells : int
        Number of cells.

    Returns
    -------
    (cells + 1,) float
        Fractions from 0 to 1.

    Examples
    --------
    >>> uniform(4)
    array([0.  , 0.25, 0.5 , 0.75, 1.  ])
    """
    return np.arange(count(cells) + 1) / cells


def geometric(
    cells: int, *, ratio: float | None = None, first: float | None = None, last: float | None = None
) -> np.ndarray:
    """Cells that grow by a constant ratio, given by that ratio or by an end cell.

    Parameters
    ----------
    cells : int
        Number of cells.
    ratio : float, optional
        Each cell over the one before it; below 1 they shrink.
    first, last : float, optional
        The first or the last cell as a fraction of the whole.

    Returns
    -------
    (cells + 1,) float
        Fractions from 0 to 1, increasing.

    Raises
    ------
    InvalidInput
        If not exactly one of ratio, first and last is given, or no such spacing exists.

    Examples
    --------
    >>> geometric(3, ratio=2) * 7
    array([0., 1., 3., 7.])
    >>> geometric(3, first=1 / 7) * 7
    array([0., 1., 3., 7.])
    """
    cells = count(cells)
    if [ratio, first, last].count(None) != 2:
        raise InvalidInput("needs one of ratio, first and last, and no more", parameter="ratio")
    if ratio is not None:
        ratio = number(ratio, "ratio")
        if ratio <= 0:
            raise InvalidInput(f"must be greater than zero, got {ratio:g}", parameter="ratio")
        growth = math.log(ratio)
    elif first is not None:
        first = fraction(first, "first", cells)
        growth = _growth(cells, first)
    else:
        last = fraction(last, "last", cells)
        growth = -_growth(cells, last)
    smallest = _geometric_first(cells, -abs(growth)) * math.exp(-abs(growth) * (cells - 1))
    if smallest < SMALLEST:
        name = "ratio" if ratio is not None else "last" if first is None else "first"
        fail(name, f"makes a cell of {smallest:.3g} of the line, below {SMALLEST:g}")
    steps = np.arange(cells + 1)
    if abs(growth) * cells < 1e-9:
        fractions = steps / cells
    elif growth > 0:  # powers of the largest cell, so that nothing overflows
        fractions = np.exp((steps - cells) * growth) * np.expm1(-steps * growth) / math.expm1(-cells * growth)
    else:
        fractions = np.expm1(steps * growth) / math.expm1(cells * growth)
    return pinned(fractions, first, last)


def hyperbolic_tangent(cells: int, *, first: float | None = None, last: float | None = None) -> np.ndarray:
    """Vinokur's stretching, with the first cell, the last cell or both as given, exactly.

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
        If no such spacing exists, as where the end cells are longer than the line.

    Notes
    -----
    Vinokur matches the slopes at the ends, and so the end cells only nearly. Here the cells themselves are matched.
    With ``t = k / cells`` the two-sided function is ``s / (1 - s) = sinh(d t) / (A sinh(d (1 - t)))``, so that the
    odds ``o0``, ``o1`` of the two end cells give ``A^2 = o1 / o0`` in closed form and leave one equation,
    ``sinh(d / n) / sinh(d (n - 1) / n) = sqrt(o0 o1)``; where that exceeds ``1 / (n - 1)``, sinh becomes sin.

    References
    ----------
    M. Vinokur, "On one-dimensional stretching functions for finite-difference calculations", J. Comput. Phys. 50
    (1983), equations 20 to 29.

    Examples
    --------
    >>> hyperbolic_tangent(4, first=0.1, last=0.1).round(3)
    array([0. , 0.1, 0.5, 0.9, 1. ])
    >>> hyperbolic_tangent(4, first=0.01).round(3)
    array([0.   , 0.01 , 0.063, 0.308, 1.   ])
    """
    cells = count(cells)
    if first is None and last is None:
        return uniform(cells)
    if first is None:
        last = fraction(last, "last", cells)
        return pinned(1 - hyperbolic_tangent(cells, first=last)[::-1], None, last)
    first = fraction(first, "first", cells)
    t = np.arange(cells + 1) / cells
    if last is None:
        return pinned(_one_sided(cells, first, t), first, None)
    last = fraction(last, "last", cells)
    return pinned(_two_sided(cells, first, last, t), first, last)


def cosine(cells: int, *, ends: Literal["both", "first", "last"] = "both") -> np.ndarray:
    """Points of a half or quarter circle seen from the side: dense at both ends or at one.

    Parameters
    ----------
    cells : int
        Number of cells.
    ends : {"both", "first", "last"}
        Where cells are small.

    Returns
    -------
    (cells + 1,) float
        Fractions from 0 to 1, increasing.

    Raises
    ------
    InvalidInput
        If `ends` is none of the three.

    Examples
    --------
    >>> cosine(4).round(3)
    array([0.   , 0.146, 0.5  , 0.854, 1.   ])
    >>> cosine(3, ends="first").round(3)
    array([0.   , 0.134, 0.5  , 1.   ])
    """
    t = uniform(cells)
    if ends == "both":
        return pinned(np.sin(0.5 * np.pi * t) ** 2, None, None)
    if ends not in ("first", "last"):
        raise InvalidInput(f"{ends!r} is not one of both, first, last", parameter="ends")
    if ends == "first":
        return pinned(2 * np.sin(0.25 * np.pi * t) ** 2, None, None)
    return pinned(np.sin(0.5 * np.pi * t), None, None)


def cells_for_growth(first: float, ratio: float) -> int:
    """Number of cells whose geometric spacing starts with ``first`` and grows by no more than ``ratio``.

    Parameters
    ----------
    first : float
        The first cell as a fraction of the whole.
    ratio : float
        Largest growth from cell to cell, greater than 1.

    Returns
    -------
    int
        The least such number.

    Raises
    ------
    InvalidInput
        If first is not between 0 and 1, or ratio is not greater than 1.

    Examples
    --------
    >>> cells_for_growth(1 / 7, 2)
    3
    """
    first, ratio = number(first, "first"), number(ratio, "ratio")
    if not SMALLEST <= first <= 1:
        raise InvalidInput(f"must lie between {SMALLEST:g} and 1, got {first:g}", parameter="first")
    if ratio <= 1:
        raise InvalidInput(f"must be greater than 1, got {ratio:g}", parameter="ratio")
    # first (r^n - 1) / (r - 1) >= 1; the tolerance keeps an exact answer from being rounded up.
    exact = math.log1p((ratio - 1) / first) / math.log(ratio)
    return max(1, math.ceil(exact - 1e-9))


def cells_for_ends(first: float, last: float, ratio: float) -> int:
    """Number of cells of a hyperbolic tangent with given end cells, which change by no more than ``ratio``.

    Parameters
    ----------
    first, last : float
        The end cells as fractions of the whole.
    ratio : float
        Largest growth from cell to cell either way, greater than 1.

    Returns
    -------
    int
        The least such number; if there is none, as between long end cells, that with the least growth.

    Raises
    ------
    InvalidInput
        If the end cells are not between 0 and 1 together, or ratio is not greater than 1.

    Examples
    --------
    >>> cells_for_ends(0.01, 0.1, 1.2)
    20
    >>> steps = np.diff(hyperbolic_tangent(20, first=0.01, last=0.1))
    >>> float((steps[1:] / steps[:-1]).max()) < 1.2
    True
    """
    for name, value in (("first", first), ("last", last)):
        if not SMALLEST <= number(value, name) <= 1:
            raise InvalidInput(f"must lie between {SMALLEST:g} and 1, got {value:g}", parameter=name)
    if first + last > 1:
        raise InvalidInput(f"is {last:g}, which leaves no room beside a first cell of {first:g}", parameter="last")
    if number(ratio, "ratio") <= 1:
        raise InvalidInput(f"must be greater than 1, got {ratio:g}", parameter="ratio")

    def worst(cells: int) -> float:
        try:
            steps = np.diff(hyperbolic_tangent(cells, first=first, last=last))
        except InvalidInput:
            return np.inf
        change = steps[1:] / steps[:-1]
        return float(np.maximum(change, 1 / change).max())

    # Cells that grow from both ends as fast as may be, until they meet, are no more than are needed.
    rise = math.log(ratio)
    meet = min(max((last - first + rise) / (2 * rise), 0.0), 1.0)
    fewest = max(2, math.floor((math.log1p(rise * meet / first) + math.log1p(rise * (1 - meet) / last)) / rise))
    low, high, tried = fewest - 1, fewest, {}
    while (tried.setdefault(high, worst(high))) > ratio:
        if high * min(first, last) > 1:
            return min(tried, key=tried.get)
        low, high = high, math.ceil(1.2 * high)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if worst(middle) <= ratio else (middle, high)
    return high


def _geometric_first(cells: int, growth: float) -> float:
    """The larger end cell of a geometric spacing whose logarithm of the ratio is ``growth`` <= 0."""
    return math.expm1(growth) / math.expm1(cells * growth) if growth else 1 / cells


def _growth(cells: int, first: float) -> float:
    """Logarithm of the ratio that makes the first of ``cells`` cells ``first``."""
    if cells == 1 or first * cells == 1:
        return 0.0
    if first * cells > 1:  # shrinking: 1 - first <= ratio < 1
        return root(lambda g: _geometric_first(cells, g) - first, math.log1p(-first) * (1 + 1e-9), -1e-12)
    # growing: the first cell is the last one of the mirror image; ratio^(cells - 1) < 1 / first
    highest = -math.log(first) / (cells - 1)

    def excess(g: float) -> float:
        return -(cells - 1) * g + math.log(_geometric_first(cells, -g)) - math.log(first)

    return root(excess, 1e-12, highest * (1 + 1e-9))


def _one_sided(cells: int, first: float, t: np.ndarray) -> np.ndarray:
    """``s = 1 + tanh(a (t - 1)) / tanh(a)``, written without cancellation; tan where cells shrink from the start."""
    if cells == 1 or abs(first * cells - 1) < 1e-12:
        return t
    if first * cells < 1:
        # tanh a - tanh(a (1 - t)) = sinh(a t) / (cosh a cosh(a (1 - t))); exponentials scaled against overflow
        def value(a: float, t: np.ndarray | float) -> np.ndarray | float:
            decay = np.exp(-2 * a * (1 - t))
            return decay * 2 * np.expm1(-2 * a * t) / (np.expm1(-2 * a) * (1 + decay))

        at = 1 / cells
        largest = -math.log(first) / (1 - at) + 2  # s(t) < 4 exp(-2 a (1 - t)) beyond a = 1
        a = root(lambda a: math.log(value(a, at)) - math.log(first), 1e-7, largest)
        return value(a, t)

    def shrinking(a: float, t: np.ndarray | float) -> np.ndarray | float:
        return np.sin(a * t) / (np.sin(a) * np.cos(a * (1 - t)))

    a = root(lambda a: shrinking(a, 1 / cells) - first, 1e-7, math.pi / 2 * (1 - 1e-15))
    return shrinking(a, t)


def _two_sided(cells: int, first: float, last: float, t: np.ndarray) -> np.ndarray:
    if cells == 1:
        return t
    if cells == 2 and abs(first + last - 1) > 1e-12:
        fail(
            "first", f"and last are {first:g} and {last:g} of a line of two cells and must add up to 1; use more cells"
        )
    if cells > 2 and first + last >= 1:
        fail("first", f"and last are {first:g} and {last:g} of the line and leave nothing between; make them smaller")
    if cells == 2:
        return np.array([0.0, first, 1.0])
    odds = first / (1 - first), last / (1 - last)
    skew, target = math.sqrt(odds[1] / odds[0]), math.sqrt(odds[0] * odds[1])
    sine, d = _stretching(cells, target)
    left, right = sine(d, t), skew * sine(d, 1 - t)
    return left / (left + right)


def _stretching(cells: int, target: float) -> tuple[Callable, float]:
    """The odd function and its factor d with ``f(d / n) / f(d (n - 1) / n) = target``."""
    at, rest = 1 / cells, 1 - 1 / cells
    if abs(target * (cells - 1) - 1) < 1e-12:
        return (lambda d, t: t), 1.0
    if target * (cells - 1) < 1:

        def scaled_sinh(d: float, t: np.ndarray | float) -> np.ndarray | float:
            return 0.5 * (np.exp(d * (t - 1)) - np.exp(-d * (t + 1)))  # sinh(d t) exp(-d)

        highest = 2 + (2 - math.log(target)) / (rest - at)
        goal = math.log(target)
        d = root(lambda d: math.log(scaled_sinh(d, at) / scaled_sinh(d, rest)) - goal, 1e-6, highest)
        return scaled_sinh, d

    def sine(d: float, t: np.ndarray | float) -> np.ndarray | float:
        return np.sin(d * t)

    return sine, root(lambda d: sine(d, at) / sine(d, rest) - target, 1e-6, math.pi * (1 - 1e-15))
