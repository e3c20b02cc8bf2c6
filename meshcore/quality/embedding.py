"""Whether a planar mesh covers its domain once: no hanging nodes, no crossing boundary, nothing lies over itself.

A mesh of positive cells with matching edges maps its cells to the plane with degree one or more. If its boundary
edges meet at their ends only, the degree is constant along each chain of them; so if it is one beside each chain,
no point of the plane is covered twice.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..mesh import topology
from . import _embedding_kernels as kernels
from .orientation import determinant_sign

CHUNK = 1 << 20
# Projections of axis-parallel edges on this direction are short, and no common grid direction is orthogonal to it.
_SWEEP = np.array([np.cos(0.7), np.sin(0.7)])


class Overlaps(NamedTuple):
    """Where the boundary touches itself.

    Attributes
    ----------
    hanging : (k, 2) int
        Number of a boundary edge, and a point that lies inside it.
    crossing : (k, 2) int
        Pairs of boundary edges that cross.
    """

    hanging: np.ndarray
    crossing: np.ndarray


def overlaps(plane: np.ndarray, edges: np.ndarray, tolerance: float) -> Overlaps:
    """Boundary edges that touch or cross each other elsewhere than at common ends.

    Parameters
    ----------
    plane : (n, 2) float
        Points in the coordinates of the plane.
    edges : (b, 2) int
        Boundary edges.
    tolerance : float
        A point no farther than this from an edge lies on it.

    Examples
    --------
    A point on the middle of an edge, and two edges that cross:

    >>> points = np.array([[0.0, 0], [2, 0], [1, 0], [1, 1], [0, 1], [2, 2], [0, 2], [2, 1]])
    >>> overlaps(points, np.array([[0, 1], [2, 3]]), 1e-12).hanging.tolist()
    [[0, 2]]
    >>> overlaps(points, np.array([[4, 5], [6, 7]]), 1e-12).crossing.tolist()
    [[0, 1]]
    """
    hanging, crossing = [np.empty((0, 2), np.int64)], [np.empty((0, 2), np.int64)]
    plane = np.ascontiguousarray(plane)
    along = plane[edges] @ _SWEEP
    low, high = along.min(axis=1) - tolerance, along.max(axis=1) + tolerance
    order = np.argsort(low, kind="stable")
    if not kernels.any_may_touch(plane, edges[order], low[order], high[order], tolerance):
        return Overlaps(hanging[0], crossing[0])
    for first, second in _close_pairs(plane[edges], tolerance):
        touches = np.zeros(len(first), bool)
        for one, other in ((first, second), (second, first)):
            for end in (0, 1):
                point = edges[other, end]
                inside = (edges[one] != point[:, None]).all(axis=1) & _on_edge(plane, edges[one], point, tolerance)
                hanging.append(np.column_stack([one, point])[inside])
                touches |= inside
        apart = (edges[first][:, :, None] != edges[second][:, None, :]).all(axis=(1, 2)) & ~touches
        first, second = first[apart], second[apart]
        cross = _crosses(plane, edges[first], edges[second]) & _crosses(plane, edges[second], edges[first])
        crossing.append(np.column_stack([first, second])[cross])
    return Overlaps(np.unique(np.concatenate(hanging), axis=0), np.concatenate(crossing))


def _close_pairs(segments: np.ndarray, tolerance: float):
    """Chunks of pairs of (b, 2, 2) segments whose boxes come within ``tolerance``: arrays of first and of second."""
    along = segments @ _SWEEP
    low, high = along.min(axis=1) - tolerance, along.max(axis=1) + tolerance
    order = np.argsort(low, kind="stable")
    low, high = low[order], high[order]
    corner, opposite = segments.min(axis=1)[order] - tolerance, segments.max(axis=1)[order] + tolerance
    count = np.searchsorted(low, high, side="right") - np.arange(len(low)) - 1
    total = np.concatenate([[0], np.cumsum(count)])
    start = 0
    while start < len(low):
        stop = max(int(np.searchsorted(total, total[start] + CHUNK, side="right")) - 1, start + 1)
        first = np.repeat(np.arange(start, stop), count[start:stop])
        second = first + 1 + np.arange(len(first)) - np.repeat(total[start:stop] - total[start], count[start:stop])
        near = ((corner[first] <= opposite[second]) & (corner[second] <= opposite[first])).all(axis=1)
        yield order[first[near]], order[second[near]]
        start = stop


def _on_edge(plane: np.ndarray, edges: np.ndarray, points: np.ndarray, tolerance: float) -> np.ndarray:
    """(k,) bool: whether a point lies inside its edge, by distance."""
    a, b, p = plane[edges[:, 0]], plane[edges[:, 1]], plane[points]
    d, e = b - a, p - a
    squared = (d**2).sum(axis=1)
    along = (d * e).sum(axis=1)
    area = d[:, 0] * e[:, 1] - d[:, 1] * e[:, 0]
    return (along > 0) & (along < squared) & (np.abs(area) <= tolerance * np.sqrt(squared))


def _crosses(plane: np.ndarray, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """(k,) bool: whether the ends of ``other`` lie on different sides of the line through ``one``."""
    sides = [determinant_sign(plane, np.column_stack([one, other[:, end]])) for end in (0, 1)]
    return sides[0] * sides[1] < 0


def chain_representatives(edges: np.ndarray) -> np.ndarray:
    """(c,) int: one edge of each chain, where chains are cut at points that have more than two edges.

    Examples
    --------
    >>> chain_representatives(np.array([[0, 1], [1, 2], [2, 0], [2, 3], [3, 4], [4, 2]])).tolist()
    [0, 3]
    """
    ends = np.unique(edges.T, return_inverse=True)[1].ravel()
    degree = np.bincount(ends)
    number = np.tile(np.arange(len(edges)), 2)
    simple = degree[ends] == 2
    links = np.column_stack([number[simple], len(edges) + ends[simple]])
    label = topology.connected(links, len(edges) + len(degree))
    return np.sort(np.unique(label[: len(edges)], return_index=True)[1])


def degree_at(plane: np.ndarray, edges: np.ndarray, places: np.ndarray) -> np.ndarray:
    """(k,) int: how often the directed boundary ``edges`` turn around each of (k, 2) ``places``.

    Examples
    --------
    >>> square = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    >>> degree_at(square, np.array([[0, 1], [1, 2], [2, 3], [3, 0]]), np.array([[0.5, 0.5], [2, 0.5]]))
    array([1, 0])
    """
    a, b = plane[edges[:, 0]], plane[edges[:, 1]]
    turns = np.zeros(len(places), int)
    step = max(CHUNK // max(len(edges), 1), 1)
    for start in range(0, len(places), step):
        x, y = places[start : start + step, :, None].swapaxes(0, 1)
        up = (a[:, 1] <= y) & (b[:, 1] > y)
        down = (a[:, 1] > y) & (b[:, 1] <= y)
        left = (b[:, 0] - a[:, 0]) * (y - a[:, 1]) - (b[:, 1] - a[:, 1]) * (x - a[:, 0])
        turns[start : start + step] = (up & (left > 0)).sum(axis=1) - (down & (left < 0)).sum(axis=1)
    return turns
