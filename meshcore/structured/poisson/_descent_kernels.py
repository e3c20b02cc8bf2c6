"""Steps of limited-memory BFGS on flat arrays: J. Nocedal, S. J. Wright, "Numerical Optimization" (2006), chapter 7.

``steps`` and ``changes`` (m, n) hold the last m steps and how they changed the slope, the one of number k in row k
modulo m; ``known`` is their number.
"""

from __future__ import annotations

import math

from ..._numba import kernel

ENOUGH = 1e-4
"""Part of the descent that the slope promises which a step must make (Armijo's condition)."""
SHORTENINGS = 30
FLAT = 1e-9
"""Relative gain of a step below which nothing more is to be had."""


@kernel
def inner(a, b):
    """Inner product."""
    total = 0.0
    for k in range(a.size):
        total += a[k] * b[k]
    return total


@kernel
def combine(target, keep, share, other):
    """target = keep target + share other, without an array between."""
    for k in range(target.size):
        target[k] = keep * target[k] + share * other[k]


@kernel
def find_way(slope, steps, changes, known, shares, way):
    """Put an approximate Newton step, to be subtracted, into ``way``: algorithm 7.4; its descent, which is negative.

    ``shares`` (m,) is for work.
    """
    window = len(steps)
    combine(way, 0.0, 1.0, slope)
    for k in range(known - 1, max(known - window, 0) - 1, -1):
        s, y = steps[k % window], changes[k % window]
        shares[k % window] = inner(s, way) / inner(s, y)
        combine(way, 1.0, -shares[k % window], y)
    if known:
        s, y = steps[(known - 1) % window], changes[(known - 1) % window]
        combine(way, inner(s, y) / inner(y, y), 0.0, way)
    else:
        combine(way, 0.1 / (math.sqrt(inner(slope, slope)) + 1e-300), 0.0, way)
    for k in range(max(known - window, 0), known):
        s, y = steps[k % window], changes[k % window]
        combine(way, 1.0, shares[k % window] - inner(y, way) / inner(s, y), s)
    return -inner(way, slope)


@kernel
def remember(length, way, slope, new_slope, steps, changes, known):
    """Keep the step ``-length way``, after which the slope is the new one; how many are known then: algorithm 7.5."""
    s, y = steps[known % len(steps)], changes[known % len(steps)]
    combine(s, 0.0, -length, way)
    combine(y, 0.0, 1.0, new_slope)
    combine(y, 1.0, -1.0, slope)
    combine(slope, 0.0, 1.0, new_slope)
    return known + 1 if inner(s, y) > 1e-12 * inner(y, y) else known
