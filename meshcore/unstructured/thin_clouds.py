"""The order of insertion for points that nearly lie on one line, such as a slanted line up to rounding."""

from __future__ import annotations

import numpy as np

from ..progress import Progress, silent
from . import _insertion_order_kernels as kernels
from .insertion_order import InsertionOrder, insertion_order

_SAMPLE = 1000
# So many points may lie anywhere.
_OUTLIERS = 8


def planar_order(points: np.ndarray, progress: Progress = silent) -> tuple[InsertionOrder, bool]:
    """The order of insertion of points in the plane, and whether they are thin: inserted along their line.

    The triangles of points that lie on a line up to rounding are slivers from end to end of it, and whoever walks
    there, or digs a cavity, crosses many: along a Hilbert curve, which runs along such a line in pieces of either
    direction, they are ever more with more points (31 a point for 20 000 of y = 0.3 x + 0.1). Along the line they are
    seven, for any number of points.

    Parameters
    ----------
    points : (n, 2) or (n, 3) float
        Safe for the predicates; z is not looked at.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    order : InsertionOrder
        Depends on the points only.
    thin : bool
        Whether it follows a line.

    Examples
    --------
    >>> x = np.array([3.0, 1.0, 2.0, 1.0, 5.0])
    >>> order, thin = planar_order(np.column_stack([x, 0.3 * x + 0.1]))
    >>> order.rows.tolist(), order.merged.tolist(), thin
    ([1, 2, 0, 4], [3], True)
    """
    line, n = np.empty(5), len(points)
    thick = n < 3 or kernels.is_surely_thick(points, max(1, n // _SAMPLE), n, _OUTLIERS, line)
    along = None if thick else _places_along_line(points[:, :2], line)
    if along is None:
        return insertion_order(points, 2, rounds=False, progress=progress), False
    rows = np.lexsort((points[:, 1], points[:, 0], along))
    xy = points[rows, :2]
    # Equal points lie side by side now, the lowest row first.
    new = np.concatenate([[True], (xy[1:] != xy[:-1]).any(axis=1)])
    kept = rows[new][np.cumsum(new) - 1]
    merged = np.sort(rows[~new])
    first = np.empty(len(points), np.int64)
    first[rows] = kept
    return InsertionOrder(rows[new].astype(np.int32), xy[new].ravel(), merged, first[merged]), True


def places_along_line_in_space(points: np.ndarray) -> np.ndarray | None:
    """(n,) float: where (n, 3) points lie along their line, if they are thin in the sense of `planar_order`; else None.

    They are if they are so seen from two sides; their longest extent tells the places.

    Examples
    --------
    >>> x = np.array([3.0, 1.0, 2.0, 5.0])
    >>> places_along_line_in_space(np.column_stack([x, 0.3 * x + 0.1, -0.7 * x])).tolist()
    [3.0, 1.0, 2.0, 5.0]
    """
    n, line = len(points), np.empty(5)
    sample = points[:: max(1, n // _SAMPLE)]
    longest = int(np.argmax(sample.max(axis=0) - sample.min(axis=0)))
    for axis in {0, 1, 2} - {longest}:
        view = [longest, axis]
        if n < 3 or kernels.is_surely_thick(np.ascontiguousarray(sample[:, view]), 1, n, _OUTLIERS, line):
            return None
        if _places_along_line(points[:, view], line) is None:
            return None
    return points[:, longest]


def _places_along_line(xy: np.ndarray, line: np.ndarray) -> np.ndarray | None:
    """(n,) float: where points lie along a line, if all but few are nearer to it than to each other; else None."""
    x, y = ((xy - line[:2]) / line[2]).T
    along, across = line[3] * x + line[4] * y, line[3] * y - line[4] * x
    return along if _is_thin(along, across, len(xy)) else None


def _is_thin(along: np.ndarray, across: np.ndarray, n: int) -> bool:
    """Whether the band around the line is thinner than the mean distance of n points along it."""
    last = max(len(across) - 1 - _OUTLIERS, len(across) // 2)
    width = np.partition(np.abs(across), last)[last]
    return bool(width * n <= along.max() - along.min())
