"""Corners of the hexahedra of a structured grid, in one pass over its points."""

import math

import numpy as np

from .._numba import kernel

U = np.uint64


@kernel
def _determinant(a0, a1, a2, b0, b1, b2, c0, c1, c2):
    return a0 * (b1 * c2 - b2 * c1) + a1 * (b2 * c0 - b0 * c2) + a2 * (b0 * c1 - b1 * c0)


@kernel
def least_determinant(points):
    """The least of the corner determinants of all cells, nan if one is."""
    least = math.inf
    for i in range(points.shape[0] - 1):
        for j in range(points.shape[1] - 1):
            for k in range(points.shape[2] - 1):
                for corner in range(8):
                    p, q, r = corner & 1, (corner >> 1) & 1, corner >> 2
                    x = points[U(i + p), U(j + q), U(k + r)]
                    a = points[U(i + 1 - p), U(j + q), U(k + r)]
                    b = points[U(i + p), U(j + 1 - q), U(k + r)]
                    c = points[U(i + p), U(j + q), U(k + 1 - r)]
                    det = _determinant(
                        a[0] - x[0], a[1] - x[1], a[2] - x[2],
                        b[0] - x[0], b[1] - x[1], b[2] - x[2],
                        c[0] - x[0], c[1] - x[1], c[2] - x[2],
                    )  # fmt: skip
                    # Edges that run against their axes: an odd number of them changes the sign.
                    det = det if (p + q + r) % 2 == 0 else -det
                    if not det >= least:
                        least = det
    return least


@kernel
def summarise(points, edges, found):
    """Put the least corner determinant, the worst scaled Jacobian and the sum of shapes of all cells into ``found``.

    Verdict's definitions, as in `hexahedron`: the scaled Jacobian counts at corners and centre, the shape is the least
    mean ratio, ``3 det^(2/3) / (|a|^2 + |b|^2 + |c|^2)``, of the corners. ``edges`` (3, 4, 3) is for work: along
    i, j and k the four edges of a cell, at 00, 10, 01 and 11 of the two other directions. The first number is not
    positive, or not a number, if a cell has no three different edges at a corner.
    """
    n_i, n_j, n_k = points.shape[0] - 1, points.shape[1] - 1, points.shape[2] - 1
    least, worst, shapes = math.inf, math.inf, 0.0
    for i in range(n_i):
        for j in range(n_j):
            for k in range(n_k):
                for c in range(3):
                    for q in range(2):
                        for r in range(2):
                            edges[0, q + 2 * r, c] = points[i + 1, j + q, k + r, c] - points[i, j + q, k + r, c]
                            edges[1, q + 2 * r, c] = points[i + q, j + 1, k + r, c] - points[i + q, j, k + r, c]
                            edges[2, q + 2 * r, c] = points[i + q, j + r, k + 1, c] - points[i + q, j + r, k, c]
                ratio = math.inf
                for corner in range(8):
                    p, q, r = corner & 1, (corner >> 1) & 1, corner >> 2
                    a, b, c = edges[0, q + 2 * r], edges[1, p + 2 * r], edges[2, p + 2 * q]
                    det = _determinant(a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2])
                    aa = a[0] * a[0] + a[1] * a[1] + a[2] * a[2]
                    bb = b[0] * b[0] + b[1] * b[1] + b[2] * b[2]
                    cc = c[0] * c[0] + c[1] * c[1] + c[2] * c[2]
                    if not det > 0.0:
                        found[0] = det
                        return
                    least = min(least, det)
                    worst = min(worst, det / math.sqrt(aa * bb * cc))
                    size = aa + bb + cc
                    ratio = min(ratio, det * det / (size * size * size))
                shapes += min(3.0 * ratio ** (1.0 / 3.0), 1.0)
                for axis in range(3):  # the principal axes are sums of four edges
                    for c in range(3):
                        edges[axis, 0, c] += edges[axis, 1, c] + edges[axis, 2, c] + edges[axis, 3, c]
                a, b, c = edges[0, 0], edges[1, 0], edges[2, 0]
                det = _determinant(a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2])
                aa = a[0] * a[0] + a[1] * a[1] + a[2] * a[2]
                bb = b[0] * b[0] + b[1] * b[1] + b[2] * b[2]
                cc = c[0] * c[0] + c[1] * c[1] + c[2] * c[2]
                worst = min(worst, det / math.sqrt(aa * bb * cc))
    found[0], found[1], found[2] = least, worst, shapes
