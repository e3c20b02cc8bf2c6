"""Slow and obvious twins of what meshcore does fast: the tests hold one against the other."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

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


def coons(south, east, north, west, s, t):
    """The Coons patch point by point, from Gordon and Hall's formula; ``s``, ``t`` are (ni, nj) blending values."""
    ni, nj = len(south), len(west)
    points = np.empty((ni, nj, 3))
    for i in range(ni):
        for j in range(nj):
            for x in range(3):
                u, v = s[i][j], t[i][j]
                sides = (1 - u) * west[j][x] + u * east[j][x] + (1 - v) * south[i][x] + v * north[i][x]
                corners = (
                    (1 - u) * (1 - v) * south[0][x]
                    + u * (1 - v) * south[-1][x]
                    + (1 - u) * v * north[0][x]
                    + u * v * north[-1][x]
                )
                points[i, j, x] = sides - corners
    return points


def crossing_of_lengths(south, east, north, west):
    """(ni, nj) s and t of blending by arc length, by sweeping the two equations until they agree."""

    def fractions(side):
        steps = [math.dist(a, b) for a, b in itertools.pairwise(side)]
        return [sum(steps[:k]) / sum(steps) for k in range(len(side))]

    low, right, high, left = (fractions(side) for side in (south, east, north, west))
    s = np.empty((len(low), len(left)))
    t = np.empty_like(s)
    for i in range(len(low)):
        for j in range(len(left)):
            u = v = 0.5
            for _ in range(2000):
                u = (1 - v) * low[i] + v * high[i]
                v = (1 - u) * left[j] + u * right[j]
            s[i, j], t[i, j] = u, v
    return s, t


def cross_areas(points):
    """(ni - 1, nj - 1, 4) twice the signed areas of the triangles at the corners of planar cells."""
    ni, nj = len(points), len(points[0])
    areas = np.empty((ni - 1, nj - 1, 4))
    for i in range(ni - 1):
        for j in range(nj - 1):
            quad = [points[i][j], points[i + 1][j], points[i + 1][j + 1], points[i][j + 1]]
            for k in range(4):
                a, b, c = quad[k - 1], quad[k], quad[(k + 1) % 4]
                areas[i, j, k] = (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
    return areas


# ---- predicates: determinants of whole numbers; tests are (count, points, dimension) float


def whole_numbers(values: np.ndarray) -> np.ndarray:
    """Doubles as exact Python integers, all times one power of two."""
    ratios = [Fraction(x) for x in np.ravel(values).tolist()]
    scale = max((r.denominator for r in ratios), default=1)
    numbers = np.empty(len(ratios), object)
    numbers[:] = [r.numerator * (scale // r.denominator) for r in ratios]
    return numbers.reshape(np.shape(values))


def determinant(matrix: np.ndarray) -> np.ndarray:
    """Laplace's expansion along the first row of (..., k, k) objects."""
    if matrix.shape[-1] == 1:
        return matrix[..., 0, 0]
    minors = [determinant(np.delete(matrix[..., 1:, :], j, axis=-1)) for j in range(matrix.shape[-1])]
    return sum((-1) ** j * matrix[..., 0, j] * minor for j, minor in enumerate(minors))


def _edges(tests: np.ndarray) -> np.ndarray:
    points = whole_numbers(tests)
    return points[:, 1:] - points[:, :1]


def _lifted_edges(tests: np.ndarray) -> np.ndarray:
    """Edges from the first point, each with the square of its length: its place on the paraboloid there."""
    edges = _edges(tests)
    return np.concatenate([edges, (edges**2).sum(axis=2, keepdims=True)], axis=2)


def orient2d(tests: np.ndarray) -> np.ndarray:
    """Sign of the area of a, b, c."""
    return np.sign(determinant(_edges(tests))).astype(int)


def orient3d(tests: np.ndarray) -> np.ndarray:
    """Sign of the volume of a, b, c, d."""
    return np.sign(determinant(_edges(tests))).astype(int)


def incircle(tests: np.ndarray) -> np.ndarray:
    """1 if d lies below the plane through a, b, c on the paraboloid: the volume there is negative."""
    return -np.sign(determinant(_lifted_edges(tests))).astype(int)


def insphere(tests: np.ndarray) -> np.ndarray:
    """1 if e lies below the hyperplane through a, b, c, d on the paraboloid."""
    return -np.sign(determinant(_lifted_edges(tests))).astype(int)
