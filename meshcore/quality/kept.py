"""Whether the lines of an input boundary are still there, each as one edge of the mesh or as several in a row."""

from __future__ import annotations

import numpy as np

from . import _edge_kernels as kernels
from .keys import point_keys

# Share of the largest coordinate by which rounding moves points that split a line, and those that split its parts.
_ROUNDING = 2.0**-49


def missing_segments(
    points: np.ndarray, edges: np.ndarray, where: np.ndarray, lines: np.ndarray, likely: np.ndarray | None = None
) -> np.ndarray:
    """(k,) int: input lines that are no union of mesh edges.

    Parameters
    ----------
    points : (n, 3) float
        Points of the mesh.
    edges : (m,) int64
        Edges of the mesh as `keys.directed_edges` has them.
    where : (p,) int
        Number of the mesh's point for each point of the boundary; -1 where it has none.
    lines : (s, 2) int
        Lines of the boundary, in its own numbers.
    likely : (b, 2) int, optional
        Some of the edges, such as the mesh's own boundary, that lines are looked for along first.

    Notes
    -----
    A line that was split is followed from its start: at each point the edge is taken that leads on within the
    tolerance of rounding, 1e-10 of the mesh's diagonal and 2^-49 of the largest coordinate, which far from the origin
    is more.

    Examples
    --------
    >>> points = np.array([[0.0, 0, 0], [2, 0, 0], [1, 0, 0], [1, 1, 0]])
    >>> edges = 2 * np.array([2, 6, 7, 11])  # 0-2, 1-2, 1-3, 2-3
    >>> missing_segments(points, edges, np.arange(4), np.array([[0, 1], [0, 3]]))
    array([1])
    """
    n = len(points)
    at = where[lines]
    found = np.zeros(len(lines), bool)
    known = (at >= 0).all(axis=1)
    found[known] = _contains(edges, n * at[known].min(axis=1) + at[known].max(axis=1))
    left = np.flatnonzero(known & ~found)
    if len(left):
        tolerance = 1e-10 * float(np.linalg.norm([np.ptp(axis) for axis in points.T]))
        tolerance += _ROUNDING * float(np.abs(points).max())
        if likely is not None:
            some = 2 * np.sort(n * likely.min(axis=1) + likely.max(axis=1))
            found[left] = _followed(points, some, at[left], tolerance)
            left = left[~found[left]]
    if len(left):
        found[left] = _followed(points, edges, at[left], tolerance)
    return np.flatnonzero(~found)


def _contains(directed: np.ndarray, values: np.ndarray) -> np.ndarray:
    place = np.searchsorted(directed, 2 * values)
    return (place < len(directed)) & (directed[np.minimum(place, len(directed) - 1)] >> 1 == values)


def _followed(points: np.ndarray, edges: np.ndarray, lines: np.ndarray, tolerance: float) -> np.ndarray:
    """(k,) bool: whether a chain of edges leads straight from the first to the second point of each line."""
    start = np.zeros(len(points) + 1, np.int64)
    neighbour = np.empty(2 * len(edges), np.int64)
    kernels.neighbours_of_points(edges, len(points), start, neighbour)
    done = np.zeros(len(lines), bool)
    kernels.follow_lines(points, start, neighbour, np.ascontiguousarray(lines), tolerance, done)
    return done


def same_points(points: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """(k,) int: number of the point with exactly the coordinates of each wanted one; -1 where there is none.

    Examples
    --------
    >>> same_points(np.array([[0.0, 0, 0], [1, 0, 0]]), np.array([[1.0, 0, 0], [2, 0, 0]]))
    array([ 1, -1])
    """
    if not len(points):
        return np.full(len(wanted), -1)
    if points is wanted:
        return np.arange(len(points))
    shared = min(len(points), len(wanted))
    if (points[:shared] == wanted).all() if shared == len(wanted) else False:
        return np.arange(shared)  # generators keep the input's points first
    keys = point_keys(points)
    order = np.argsort(keys, kind="stable")
    place = np.minimum(np.searchsorted(keys[order], point_keys(wanted)), len(points) - 1)
    number = order[place]
    return np.where((points[number] == wanted).all(axis=1), number, -1)
