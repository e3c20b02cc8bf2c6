"""Where and why planar marches stop: fronts that cross themselves, cells that fold, and what to tell of both."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...geometry.curves import turning
from ...quality.embedding import overlaps

FOLDED, MET = "cells fold", "fronts meet"


class Stop(NamedTuple):
    """Where a march ended before its last layer.

    Attributes
    ----------
    point : int
        Point of the front.
    layer : int
        The layer that could not be made, the first at the front being 0.
    place : (2,) float
        Where the point is on the last layer that was made.
    concavity : float
        Degrees by which the last layer turns to the left: where it does so around that point, or between the two that
        meet.
    reason : str
        "cells fold" or "fronts meet".
    other : int or None
        The point of the front that it would meet.
    """

    point: int
    layer: int
    place: np.ndarray
    concavity: float
    reason: str
    other: int | None = None


def crossing(front: np.ndarray, closed: bool) -> tuple[int, int] | None:
    """Two points whose edges to their next ones cross, the first first, or None."""
    n = len(front)
    start = np.arange(n if closed else n - 1)
    edges = np.column_stack([start, (start + 1) % n])
    found = overlaps(front, edges, 0.0).crossing
    return (int(found[0].min()), int(found[0].max())) if len(found) else None


def last_simple(layers: np.ndarray, closed: bool) -> tuple[int, tuple[int, int] | None]:
    """The last front that does not cross itself, and where the next one does.

    Sound cells between two fronts without crossings cover what lies between them once, so that the fronts between need
    no look. That holds for closed fronts; the lines at the ends of an open one may still meet.
    """
    last = len(layers) - 1
    where = crossing(np.ascontiguousarray(layers[last].T), closed)
    if where is None:
        return last, None
    low, high = 0, last
    while high - low > 1:
        middle = (low + high) // 2
        found = crossing(np.ascontiguousarray(layers[middle].T), closed)
        low, high, where = (middle, high, where) if found is None else (low, middle, found)
    return low, where


def folded(front: np.ndarray, cell: int, layer: int, closed: bool) -> Stop:
    """The stop at a cell: its point where the front turns most to the left, and by how much it does around there."""
    n, turn = len(front), _turning(front, closed)
    near = [k % n if closed else min(max(k, 0), n - 1) for k in range(cell - 2, cell + 4)]
    point = max(near, key=lambda k: turn[k])
    concavity = max(turn[point], 0.0)
    for step in (-1, 1):
        k = point + step
        while concavity > 0 and concavity < 360 and (closed or 0 <= k < n) and turn[k % n] > 0:
            concavity += turn[k % n]
            k += step
    return Stop(point, layer, front[point].copy(), float(min(concavity, 360.0)), FOLDED)


def met(front: np.ndarray, edges: tuple[int, int], layer: int, closed: bool) -> Stop:
    """The stop where two edges would cross: the points of theirs that are nearest, and the bay between them."""
    n, turn = len(front), _turning(front, closed)
    first, second = edges
    ends = [(a % n, b % n) for a in (first, first + 1) for b in (second, second + 1) if a % n != b % n]
    point, other = min(ends, key=lambda pair: np.linalg.norm(front[pair[0]] - front[pair[1]]))
    bay = turn[first + 1 : second + 1].sum()
    if closed:
        bay = max(bay, turn.sum() - bay)
    return Stop(point, layer, front[point].copy(), float(max(bay, 0.0)), MET, other)


def _turning(front: np.ndarray, closed: bool) -> np.ndarray:
    """Degrees by which a front turns to the left at each point; none at the ends of an open one."""
    turn = np.degrees(turning(front))
    if not closed:
        turn[[0, -1]] = 0
    return turn
