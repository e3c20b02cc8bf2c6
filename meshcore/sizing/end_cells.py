"""What all one-dimensional laws of spacing share: checks of their numbers, a root, exact ends."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NoReturn

import numpy as np

from ..errors import InvalidInput

SMALLEST = 1e-12
"""Least cell, as a fraction of the line, that double precision still resolves at either end."""


def count(cells: int) -> int:
    """``cells`` if it is a whole number of at least 1."""
    if isinstance(cells, bool) or not math.isfinite(cells) or cells != int(cells) or cells < 1:
        raise InvalidInput(f"needs a whole number of at least 1, got {cells!r}", parameter="cells")
    return int(cells)


def number(value: float, parameter: str) -> float:
    """``value`` if it is finite."""
    if not math.isfinite(value):
        raise InvalidInput(f"must be finite, got {value}", parameter=parameter)
    return float(value)


def fraction(value: float, parameter: str, cells: int) -> float:
    """``value`` if it can be an end cell of a line with so many cells."""
    value = number(value, parameter)
    if cells == 1:
        if abs(value - 1) > 1e-12:
            fail(parameter, f"is {value:g} of the line, but its only cell is all of it; use more cells")
        return 1.0
    if not SMALLEST <= value < 1:
        fail(parameter, f"must be at least {SMALLEST:g} and less than 1 of the line, got {value:g}")
    return value


def fail(parameter: str, message: str) -> NoReturn:
    """Raise `InvalidInput`."""
    raise InvalidInput(message, parameter=parameter)


def root(function: Callable[[float], float], low: float, high: float) -> float:
    """Root between ``low`` and ``high``; where round-off hides the change of sign it is at the smaller of the two."""
    from scipy.optimize import brentq  # a third of a second, which not every start should take

    if function(low) * function(high) > 0:
        return min(low, high, key=abs)
    return brentq(function, low, high, xtol=1e-300, rtol=8.9e-16)


def pinned(fractions: np.ndarray, first: float | None, last: float | None) -> np.ndarray:
    """``fractions`` with the ends and the demanded cells free of the last digits' error."""
    fractions = np.ascontiguousarray(fractions, float)
    fractions[0], fractions[-1] = 0.0, 1.0
    if first is not None and len(fractions) > 2:
        fractions[1] = first
    if last is not None and len(fractions) > 2:
        fractions[-2] = 1 - last
    return fractions
