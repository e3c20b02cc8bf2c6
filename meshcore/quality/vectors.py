"""Small vectorised helpers that every measure is written with: products of vectors, lengths, guarded quotients.

Arrays of vectors are fastest when the number of cells runs through memory first: `corners` gathers them that way,
and everything here keeps it, or another order that it is given.
"""

from __future__ import annotations

import numpy as np


def corners(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """(m, k, 3) float: the corners of (m, k) cells.

    Examples
    --------
    >>> corners(np.eye(3), np.array([[2, 0]])).tolist()
    [[[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]]
    """
    nodes = np.ascontiguousarray(cells.T)
    return np.stack([np.ascontiguousarray(axis)[nodes] for axis in points.T]).T


def side_by_side(columns: list[np.ndarray]) -> np.ndarray:
    """(m, k, ...) float: k arrays of (m, ...) as one.

    Examples
    --------
    >>> side_by_side([np.array([1.0, 2]), np.array([3.0, 4])]).tolist()
    [[1.0, 3.0], [2.0, 4.0]]
    """
    return np.stack([column.T for column in columns], axis=-2 if columns[0].ndim > 1 else 0).T


def chosen(x: np.ndarray, nodes: tuple[int, ...] | list[int]) -> np.ndarray:
    """(m, j, ...) float: some columns of (m, k, ...), in the order given.

    Examples
    --------
    >>> chosen(np.array([[1.0, 2, 3]]), (2, 0)).tolist()
    [[3.0, 1.0]]
    """
    return np.take(x.T, nodes, axis=x.ndim - 2).T


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(...,) float: scalar products of (..., 3) vectors.

    Examples
    --------
    >>> float(dot(np.array([1.0, 2, 3]), np.array([1.0, 0, 1])))
    4.0
    """
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(..., 3) float: vector products; faster than numpy's for many short vectors.

    Examples
    --------
    >>> cross(np.array([1.0, 0, 0]), np.array([0.0, 1, 0]))
    array([0., 0., 1.])
    """
    product = np.zeros_like(a, dtype=float, shape=np.broadcast_shapes(a.shape, b.shape))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.subtract(a[..., j] * b[..., k], a[..., k] * b[..., j], out=product[..., i])
    return product


def triple(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """(...,) float: determinants a . (b x c).

    Examples
    --------
    >>> float(triple(*np.eye(3)))
    1.0
    """
    return dot(a, cross(b, c))


def squared(a: np.ndarray) -> np.ndarray:
    """(...,) float: squared lengths of (..., 3) vectors.

    Examples
    --------
    >>> float(squared(np.array([3.0, 4, 0])))
    25.0
    """
    return dot(a, a)


def length(a: np.ndarray) -> np.ndarray:
    """(...,) float: lengths of (..., 3) vectors.

    Examples
    --------
    >>> float(length(np.array([3.0, 4, 0])))
    5.0
    """
    return np.sqrt(squared(a))


def quotient(a: np.ndarray, b: np.ndarray, otherwise: float | np.ndarray) -> np.ndarray:
    """(...,) float: a / b, and ``otherwise`` where b is zero or nan.

    Examples
    --------
    >>> quotient(np.array([1.0, 1.0]), np.array([2.0, 0.0]), np.inf)
    array([0.5, inf])
    """
    a, b = np.broadcast_arrays(np.asarray(a, float), np.asarray(b, float))
    usable = (b != 0) & ~np.isnan(b)
    return np.where(usable, a / np.where(usable, b, 1.0), otherwise)
