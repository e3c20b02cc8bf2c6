"""A kernel that tells at once that boundary edges meet at their ends only, which is nearly always so."""

import math

import numpy as np

from .._numba import kernel

U = np.uint64
# Above the rounding error of a determinant of two rows, as a share of the sum of its terms.
_ROUNDING = 8 * 2.0**-52


@kernel
def clear_side(plane, a, b, p, tolerance):
    """1 or -1 if p is clearly left or right of the line through a and b, farther than the tolerance; else 0."""
    ux = plane[U(b), U(0)] - plane[U(a), U(0)]
    uy = plane[U(b), U(1)] - plane[U(a), U(1)]
    left = ux * (plane[U(p), U(1)] - plane[U(a), U(1)])
    right = uy * (plane[U(p), U(0)] - plane[U(a), U(0)])
    bound = tolerance * math.sqrt(ux * ux + uy * uy) + _ROUNDING * (abs(left) + abs(right))
    return 1 if left - right > bound else (-1 if right - left > bound else 0)


@kernel
def may_touch(plane, a, b, c, d, tolerance):
    """Whether edges a-b and c-d may meet elsewhere than at a common end; False is certain."""
    if c == b or d == b:
        a, b = b, a
    if a == d:
        c, d = d, c
    if a == c:
        if b == d:
            return True
        if clear_side(plane, a, b, d, tolerance) != 0 and clear_side(plane, a, d, b, tolerance) != 0:
            return False
        x = plane[U(a), U(0)]
        y = plane[U(a), U(1)]
        dot = (plane[U(b), U(0)] - x) * (plane[U(d), U(0)] - x) + (plane[U(b), U(1)] - y) * (plane[U(d), U(1)] - y)
        return dot >= 0.0
    if clear_side(plane, a, b, c, tolerance) * clear_side(plane, a, b, d, tolerance) > 0:
        return False
    return clear_side(plane, c, d, a, tolerance) * clear_side(plane, c, d, b, tolerance) <= 0


@kernel
def any_may_touch(plane, edges, low, high, tolerance):
    """Whether any two edges may; they are sorted by ``low``, and cover ``low`` to ``high`` along some direction."""
    for i in range(len(edges)):
        a = edges[U(i), U(0)]
        b = edges[U(i), U(1)]
        ax = plane[U(a), U(0)]
        ay = plane[U(a), U(1)]
        bx = plane[U(b), U(0)]
        by = plane[U(b), U(1)]
        left = min(ax, bx) - tolerance
        right = max(ax, bx) + tolerance
        bottom = min(ay, by) - tolerance
        top = max(ay, by) + tolerance
        j = i + 1
        while j < len(edges) and low[U(j)] <= high[U(i)]:
            c = edges[U(j), U(0)]
            d = edges[U(j), U(1)]
            cx = plane[U(c), U(0)]
            cy = plane[U(c), U(1)]
            dx = plane[U(d), U(0)]
            dy = plane[U(d), U(1)]
            j += 1
            if max(cx, dx) < left or min(cx, dx) > right or max(cy, dy) < bottom or min(cy, dy) > top:
                continue
            if may_touch(plane, a, b, c, d, tolerance):
                return True
    return False
