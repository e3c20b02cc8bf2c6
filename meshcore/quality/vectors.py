"""Small vectorised helpers that every measure is written with: products of vectors, lengths, guarded quotients."""

from __future__ import annotations

import numpy as np


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(...,) float: scalar products of (..., 3) vectors.

    Examples
    --------
    >>> float(dot(np.array([1.0, 2, 3]), np.array([1.0, 0, 1])))
    4.0
    """
    return np.einsum("...i,...i->...", a, b)[()]


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(..., 3) float: vector products; faster than numpy's for many short vectors.

    Examples
    --------
    >>> cross(np.array([1.0, 0, 0]), np.array([0.0, 1, 0]))
    array([0., 0., 1.])
    """
    product = np.empty(np.broadcast_shapes(a.shape, b.shape))
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
