"""Bounding boxes of many short vectors, by rows that are long enough for numpy."""

from __future__ import annotations

import numpy as np

_ROW = 64
"""Points in a row: numpy reduces rows of three numbers fifty times slower."""


def bounds(points: np.ndarray) -> np.ndarray:
    """(2, d) float: lower and upper corner of the box round (..., d) points, of which there is at least one.

    Examples
    --------
    >>> bounds(np.array([[0.0, 5], [1, 2], [-1, 3]])).tolist()
    [[-1.0, 2.0], [1.0, 5.0]]
    """
    d = points.shape[-1]
    flat = points.reshape(-1, d)
    whole = len(flat) // _ROW * _ROW
    corners = []
    for reduce in (np.minimum.reduce, np.maximum.reduce):
        rest = flat[whole:]
        if whole:
            rest = np.concatenate([reduce(flat[:whole].reshape(-1, _ROW * d)).reshape(_ROW, d), rest])
        corners.append(reduce(rest))
    return np.array(corners)


def extents(points: np.ndarray) -> np.ndarray:
    """(d,) float: lengths of the box round (..., d) points.

    Examples
    --------
    >>> extents(np.array([[0.0, 5], [1, 2], [-1, 3]])).tolist()
    [2.0, 3.0]
    """
    low, high = bounds(points)
    return high - low
