"""Kernel that finds where a surface of triangles passes through itself."""

import numpy as np

from ..._numba import kernel
from ...geometry._predicates_kernels import orient3d

U = np.uint64
DEPTH = 64


@kernel
def _above(points, one, two, three, four, work):
    """The sign of `orient3d` of four of the points."""
    return orient3d(
        points[U(one), 0], points[U(one), 1], points[U(one), 2], points[U(two), 0], points[U(two), 1],
        points[U(two), 2], points[U(three), 0], points[U(three), 1], points[U(three), 2], points[U(four), 0],
        points[U(four), 1], points[U(four), 2], work,
    )  # fmt: skip


@kernel
def _pierces(points, a, b, one, two, three, work):
    """Whether the segment from a to b goes from one side of the triangle's plane to the other, through the triangle.

    By exact signs: edges beside a triangle in its plane, as on cylinders, must not be told to pass through it, and
    those through its corners must, as in symmetric fronts.
    """
    start = _above(points, one, two, three, a, work)
    end = _above(points, one, two, three, b, work)
    if start == 0 or end == 0 or (start > 0) == (end > 0):
        return False
    first = _above(points, a, b, one, two, work)
    second = _above(points, a, b, two, three, work)
    third = _above(points, a, b, three, one, work)
    return (first >= 0 and second >= 0 and third >= 0) or (first <= 0 and second <= 0 and third <= 0)


@kernel
def crossings(first, last, points, column, edges, triangles, order, right, begin, bounds, stack, work, crossed):
    """Mark the edges that pass through a triangle with which they share no column.

    Parameters
    ----------
    column : (n,) int
        Number of the surface's node above which each point is.
    edges : (m, 2) int
        Of which `first` to `last` are looked at.
    triangles : (t, 3) int
    order, right, begin, bounds
        The alternating digital tree of the triangles' boxes, see its `build`.
    stack, work : (DEPTH,) int, (k,) float
        Room; the second from `predicates.workspace`.
    crossed : (m,) int
        The triangle, or -1; out.
    """
    for e in range(first, last):
        a, b = edges[U(e), 0], edges[U(e), 1]
        here, there = column[U(a)], column[U(b)]
        crossed[U(e)] = -1
        stack[0] = 0
        waiting = 1
        while waiting > 0 and crossed[U(e)] < 0:
            waiting -= 1
            node = stack[waiting]
            apart = False
            for k in range(3):
                low = min(points[U(a), k], points[U(b), k])
                high = max(points[U(a), k], points[U(b), k])
                apart |= low > bounds[U(6 * node + 3 + k)] or high < bounds[U(6 * node + k)]
            if apart:
                continue
            if right[U(node)] > 0:
                stack[waiting] = right[U(node)]
                stack[waiting + 1] = node + 1
                waiting += 2
                continue
            for item in range(begin[U(node)], begin[U(node)] - right[U(node)]):
                t = order[U(item)]
                one, two, three = triangles[U(t), 0], triangles[U(t), 1], triangles[U(t), 2]
                around = (column[U(one)], column[U(two)], column[U(three)])
                if here in around or there in around:
                    continue
                if _pierces(points, a, b, one, two, three, work):
                    crossed[U(e)] = t
                    break
