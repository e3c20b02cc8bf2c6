"""Slow and obvious twins of what meshcore does fast: the tests hold one against the other."""

from __future__ import annotations

import math

import numpy as np


def bisected(function, low, high):
    """Root of a function that changes sign between ``low`` and ``high``, by halving."""
    below = function(low) < 0
    for _ in range(200):
        middle = 0.5 * (low + high)
        if (function(middle) < 0) == below:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def one_sided_tanh(cells, first):
    """``1 + tanh(a (t - 1)) / tanh(a)`` with a found by halving so that the first cell is ``first``."""

    def s(a, t):
        return 1 + math.tanh(a * (t - 1)) / math.tanh(a)

    a = bisected(lambda a: first - s(a, 1 / cells), 1e-3, 17.0)
    return np.array([s(a, k / cells) for k in range(cells + 1)])


def vinokur(cells, first, last):
    """``u / (A + (1 - A) u)`` with Vinokur's u (tanh or tan), A and d found so that the end cells fit."""
    skew = math.sqrt(last / (1 - last) / (first / (1 - first)))

    def s(d, t):
        if d > 0:
            u = 0.5 * (1 + math.tanh(d * (t - 0.5)) / math.tanh(0.5 * d))
        else:
            u = 0.5 * (1 + math.tan(-d * (t - 0.5)) / math.tan(-0.5 * d))
        return u / (skew + (1 - skew) * u)

    def excess(d):
        return first - s(d, 1 / cells)

    d = bisected(excess, 1e-4, 34.0) if excess(1e-4) < 0 else bisected(excess, 1e-4 - math.pi, -1e-4)
    return np.array([s(d, k / cells) for k in range(cells + 1)])
