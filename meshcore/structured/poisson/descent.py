"""Minimising a smooth function of many numbers: limited-memory BFGS with back-tracking, the same on any machine.

scipy's has its sums from BLAS, whose threads, on the few thousand numbers of a patch, take ten times as long as they
save, and whose rounding depends on their number.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from . import _descent_kernels as kernels

_WINDOW = 8
"""Steps that are remembered."""


def minimised(value: Callable[[np.ndarray, np.ndarray], float], x: np.ndarray, *, most: int) -> np.ndarray:
    """Numbers at which a function is as small as some steps make it.

    Parameters
    ----------
    value : callable
        Of (n,) numbers and room for the slope there, which it fills; returns the function. It is last called with
        the numbers that are returned.
    x : (n,) float
        Where to begin.
    most : int
        Steps at most.

    Returns
    -------
    (n,) float

    Examples
    --------
    >>> def bowl(x, slope):
    ...     slope[:] = [2, 20] * (x - [1, 3])
    ...     return float(([1, 10] * (x - [1, 3]) ** 2).sum())
    >>> minimised(bowl, np.zeros(2), most=30).round(6)
    array([1., 3.])
    """
    slope, new_slope, way = np.zeros((3, x.size))  # not empty: what is there is multiplied by zero
    steps, changes = np.zeros((2, _WINDOW, x.size))
    shares = np.empty(_WINDOW)
    reached, known = value(x, slope), 0
    for _ in range(most):
        descent = kernels.find_way(slope, steps, changes, known, shares, way)
        if not descent < 0:
            break
        length = 1.0
        for _ in range(kernels.SHORTENINGS):
            new = x - length * way
            new_value = value(new, new_slope)
            if new_value <= reached + kernels.ENOUGH * length * descent:
                break
            length *= 0.5
        else:
            value(x, slope)
            break
        known = kernels.remember(length, way, slope, new_slope, steps, changes, known)
        gain, x, reached = reached - new_value, new, new_value
        if gain <= kernels.FLAT * (reached + gain):
            break
    return x
