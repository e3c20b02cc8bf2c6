"""The shape of hexahedra's corners with a regularised barrier, and its gradient: what `barrier_3d` minimises.

Corners are numbered by bits: 1 for the far end along i, 2 along j, 4 along k. Edges are taken in the direction of the
index at either end, so that a right-handed corner has a positive determinant.
"""

from __future__ import annotations

import math

from ..._numba import kernel

HUGE = 1e300


@kernel
def put_edges(r, i, j, k, along_i, along_j, along_k, edges):
    """Put the edges of a cell, in units of the lengths ``along``, into ``edges`` (3, 4, 3).

    Along i, j and k, at 00, 10, 01 and 11 of the two other directions.
    """
    u, v, w = 1.0 / along_i[i], 1.0 / along_j[j], 1.0 / along_k[k]
    for c in range(3):
        for q in range(2):
            for s in range(2):
                edges[0, q + 2 * s, c] = u * (r[c, i + 1, j + q, k + s] - r[c, i, j + q, k + s])
                edges[1, q + 2 * s, c] = v * (r[c, i + q, j + 1, k + s] - r[c, i + q, j, k + s])
                edges[2, q + 2 * s, c] = w * (r[c, i + q, j + s, k + 1] - r[c, i + q, j + s, k])


@kernel
def add_edges(gradient, i, j, k, along_i, along_j, along_k, edges):
    """Add derivatives by the edges of a cell to those by its points: what `put_edges` does, transposed."""
    u, v, w = 1.0 / along_i[i], 1.0 / along_j[j], 1.0 / along_k[k]
    for c in range(3):
        for q in range(2):
            for s in range(2):
                one, two, three = u * edges[0, q + 2 * s, c], v * edges[1, q + 2 * s, c], w * edges[2, q + 2 * s, c]
                gradient[c, i + 1, j + q, k + s] += one
                gradient[c, i, j + q, k + s] -= one
                gradient[c, i + q, j + 1, k + s] += two
                gradient[c, i + q, j, k + s] -= two
                gradient[c, i + q, j + s, k + 1] += three
                gradient[c, i + q, j + s, k] -= three


@kernel
def is_fixed(shape, i, j, k, corner):
    """Whether a corner's points are all on the boundary, since it is at an edge of the block."""
    p, q, s = i + (corner & 1), j + ((corner >> 1) & 1), k + (corner >> 2)
    at_i, at_j, at_k = p == 0 or p == shape[1] - 1, q == 0 or q == shape[2] - 1, s == 0 or s == shape[3] - 1
    return (at_i and at_j) or (at_i and at_k) or (at_j and at_k)


@kernel
def corner_shape(a, b, c, delta, da, db, dc):
    """``f = (|a|^2 + |b|^2 + |c|^2)^(3/2) / h(J)`` of three edges; its derivatives are added to da, db, dc: f and J.

    Without the barrier, f is the power -3/2 of Knupp's mean ratio but for a factor, and in the plane it would be
    Winslow's functional. J = a . (b x c), and h(J) = (J + sqrt(J^2 + 4 delta^2)) / 2 stays positive.
    """
    bc = b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]
    ca = c[1] * a[2] - c[2] * a[1], c[2] * a[0] - c[0] * a[2], c[0] * a[1] - c[1] * a[0]
    ab = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
    J = a[0] * bc[0] + a[1] * bc[1] + a[2] * bc[2]
    root = math.sqrt(J * J + 4 * delta * delta)
    barrier = 0.5 * (J + root) if J > 0 else 2 * delta * delta / (root - J)
    if not barrier > 0:
        return HUGE, J
    square = 0.0
    for x in range(3):
        square += a[x] * a[x] + b[x] * b[x] + c[x] * c[x]
    size = math.sqrt(square)
    f = square * size / barrier
    by_edge, by_volume = 3 * size / barrier, -f / root  # h' = h / root, so that d(1 / h) / dJ = -1 / (h root)
    for x in range(3):
        da[x] += by_edge * a[x] + by_volume * bc[x]
        db[x] += by_edge * b[x] + by_volume * ca[x]
        dc[x] += by_edge * c[x] + by_volume * ab[x]
    return f, J


@kernel
def functional(r, along_i, along_j, along_k, delta, work, gradient):
    """Sum of `corner_shape` over the corners of all cells, its gradient by the points r, and the least J.

    Corners at the edges of the window, whose points are all fixed, do not count. ``work`` is (6, 4, 3).
    """
    edges, slopes = work[:3], work[3:6]
    gradient[:] = 0.0
    total, least = 0.0, HUGE
    for i in range(r.shape[1] - 1):
        for j in range(r.shape[2] - 1):
            for k in range(r.shape[3] - 1):
                put_edges(r, i, j, k, along_i, along_j, along_k, edges)
                slopes[:] = 0.0
                for corner in range(8):
                    if is_fixed(r.shape, i, j, k, corner):
                        continue
                    p, q, s = corner & 1, (corner >> 1) & 1, corner >> 2
                    one, two, three = q + 2 * s, p + 2 * s, p + 2 * q
                    f, J = corner_shape(
                        edges[0, one], edges[1, two], edges[2, three], delta,
                        slopes[0, one], slopes[1, two], slopes[2, three],
                    )  # fmt: skip
                    least = min(least, J)
                    total += f
                add_edges(gradient, i, j, k, along_i, along_j, along_k, slopes)
    return min(total, HUGE), least


@kernel
def weak_cells(r, units, sine, work, weak):
    """Mark cells with a corner that is not fixed and turned over or flat: J <= sine |a| |b| |c|.

    ``units`` (3, n) are ones, ``work`` is (6, 4, 3).
    """
    edges, ignored = work[:3], work[3]
    for i in range(r.shape[1] - 1):
        for j in range(r.shape[2] - 1):
            for k in range(r.shape[3] - 1):
                put_edges(r, i, j, k, units[0], units[1], units[2], edges)
                for corner in range(8):
                    p, q, s = corner & 1, (corner >> 1) & 1, corner >> 2
                    a, b, c = edges[0, q + 2 * s], edges[1, p + 2 * s], edges[2, p + 2 * q]
                    J = corner_shape(a, b, c, 1.0, ignored[0], ignored[1], ignored[2])[1]
                    size = 1.0
                    for e in (a, b, c):
                        size *= math.sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2])
                    if not sine * size < J and not is_fixed(r.shape, i, j, k, corner):
                        weak[i, j, k] = True
