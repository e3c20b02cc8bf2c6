"""Alternating digital tree: bounding boxes as points of a space of twice as many dimensions, found by halving."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from . import _alternating_digital_tree_kernels as kernels

# A query sorts its points along a curve if there are so many that the tree will not stay in the cache by itself.
_MANY = 2000
# Beyond so many sizes of what is searched, its squared distance would overflow; such a point is taken to be that far.
_FAR = 2.0**300


class Tree:
    """An alternating digital tree over axis-parallel boxes.

    Parameters
    ----------
    low, high : (n, 2) or (n, 3) float
        Corners of the boxes.

    Attributes
    ----------
    order : (n,) int
        Numbers of the boxes in the order of the leaves.
    right, first : (k,) int
        Right child and first box of each node; leaves have minus the number of their boxes as right child.
    bounds : (2 * dimension * k,) float
        Lower and upper corner of what lies below each node.

    References
    ----------
    J. Bonet, J. Peraire, "An alternating digital tree (ADT) algorithm for 3D geometric searching and intersection
    problems", Int. J. Numer. Meth. Engng 31 (1991).

    Examples
    --------
    >>> corners = np.arange(6.0)[:, None] * [1.0, 0.5]
    >>> Tree(corners, corners + 1).order
    array([0, 1, 2, 3, 4, 5])
    """

    def __init__(self, low: np.ndarray, high: np.ndarray):
        n, dimension = low.shape
        self.order = np.arange(n)
        right = np.empty(max(2 * n, 1), np.int64)
        first = np.empty_like(right)
        bounds = np.empty(2 * dimension * len(right))
        boxes = np.column_stack([low, high]).ravel()
        nodes = kernels.build(boxes, self.order, n, dimension, right, first, bounds)
        self.right, self.first = right[:nodes].copy(), first[:nodes].copy()
        self.bounds = bounds[: 2 * dimension * nodes].copy()


class Found(NamedTuple):
    """What is nearest to points.

    Attributes
    ----------
    item : (m,) int
        Number of the nearest simplex; the first of equally near ones.
    weights : (m, k) float
        Weights of its corners at its nearest point.
    distance : (m,) float
        How far that is.
    """

    item: np.ndarray
    weights: np.ndarray
    distance: np.ndarray


class Nearest:
    """Points, segments or triangles in space, prepared for the search of the nearest.

    Parameters
    ----------
    corners : (n, k, 3) float
        Finite corners, k from 1 to 3, n at least 1.

    Examples
    --------
    >>> segments = np.array([[[0.0, 0, 0], [1, 0, 0]], [[0, 3, 0], [1, 3, 0]]])
    >>> item, weights, distance = Nearest(segments).query(np.array([[0.25, 2.0, 0.0]]))
    >>> item, weights, distance
    (array([1]), array([[0.75, 0.25]]), array([1.]))
    """

    def __init__(self, corners: np.ndarray):
        self._n_corners = corners.shape[1]
        # About the middle and of size 1: squares neither over- nor underflow, and far from zero no digits are lost.
        low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
        self._centre = 0.5 * low + 0.5 * high
        self._exponent = int(np.frexp(np.maximum(high - self._centre, self._centre - low).max())[1])
        corners = np.ldexp(corners - self._centre, -self._exponent)
        self._tree = Tree(corners.min(axis=1), corners.max(axis=1))
        # Points count as segments without length.
        triple = corners[self._tree.order][:, [0, min(1, self._n_corners - 1), self._n_corners - 1]]
        self._corners = np.ascontiguousarray(triple).ravel()

    def query(self, points: np.ndarray) -> Found:
        """The nearest simplex to each of (m, 3) points.

        Parameters
        ----------
        points : (m, 3) float
            Finite.
        """
        with np.errstate(over="ignore"):
            scaled = np.ldexp(np.asarray(points, float) - self._centre, -self._exponent)
        scaled = np.ascontiguousarray(np.clip(scaled, -_FAR, _FAR))
        tree, m = self._tree, len(scaled)
        item, weights, distance2 = np.empty(m, np.int64), np.empty((m, 3)), np.empty(m)
        kernels.find_nearest(
            scaled.ravel(), near_each_other(scaled), 0, m, self._corners, max(self._n_corners, 2), tree.order,
            tree.right, tree.first, tree.bounds, item, weights, distance2,
        )  # fmt: skip
        weights = weights[:, : self._n_corners] if self._n_corners > 1 else np.ones((m, 1))
        return Found(item, weights, np.ldexp(np.sqrt(distance2), self._exponent))


def near_each_other(points: np.ndarray) -> np.ndarray:
    """(m,) int: an order in which points that follow each other lie near each other; few are left as they are.

    Examples
    --------
    >>> near_each_other(np.array([[0.0, 0.0], [1.0, 1.0]]))
    array([0, 1])
    """
    m, dimension = points.shape
    if m < _MANY:
        return np.arange(m)
    low, high = np.quantile(points[:: m // 1000], [0.01, 0.99], axis=0)  # a few points far away do not matter
    extent = float((high - low).max())
    if not (np.isfinite(extent) and extent > 1e-300):
        return np.arange(m)
    keys = np.empty(m, np.int64)
    kernels.morton_keys(points.ravel(), dimension, m, low, 65535 / extent, keys)
    return np.argsort(keys, kind="stable")
