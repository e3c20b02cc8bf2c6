"""Points on the outer curve of a marching grid, one for each of the front's."""

from __future__ import annotations

import numpy as np

from ...errors import InvalidGeometry
from ...geometry.curves import NOTICEABLE, Curve, arc_length, is_closed, numbered_polyline, resampled, turning
from ..crossings import TOUCH, refuse_crossings, refuse_outside
from ..limits import check_extent
from .fronts import Front

EVENNESS = 0.5
"""Share of the outer curve's points that stand evenly; the rest follow the front's own spacing. A front that has come
half of the way has evened out by itself."""


def outer_points(ready: Front, curve: Curve, evenness: float = EVENNESS) -> np.ndarray:
    """(n, 2) float: points of the outer curve for those of the front, in its direction.

    With as many points as the front the curve's own are kept, from the one on that is nearest to the front's first.

    Raises
    ------
    InvalidGeometry
        If the curve is not in the front's plane, crosses itself, does not go round a closed front, or one is open and
        the other closed.

    Examples
    --------
    >>> from meshcore.structured.marching.fronts import read_front
    >>> outer_points(read_front(np.array([[0, 0], [1, 0], [2, 0]])), np.array([[2, 1], [0, 1]]))[:, 0]
    array([0., 1., 2.])
    """
    spatial, number = numbered_polyline(curve, "outer")
    check_extent(spatial, parameter="outer")
    closed = is_closed(spatial)
    if closed != ready.closed:
        words = ("closed", "open")
        raise InvalidGeometry(
            f"is {words[not closed]}, but the front is {words[not ready.closed]}; make them alike", parameter="outer"
        )
    off = float(np.abs(ready.plane.deviations(spatial)).max())
    if off > 1e-6 * ready.diagonal:
        raise InvalidGeometry(f"lies up to {off:.4g} off the front's plane; move it there", parameter="outer")
    points = ready.plane.to_plane(spatial)
    once = slice(None, -1) if closed else slice(None)
    refuse_crossings(points[once], number[once], ready.plane, TOUCH * ready.diagonal, closed=closed, parameter="outer")
    front, n = ready.points, len(ready.points)
    if not closed:
        ends = points[[0, -1]]
        straight = np.linalg.norm(ends - front[[0, -1]], axis=1).sum()
        if np.linalg.norm(ends[::-1] - front[[0, -1]], axis=1).sum() < straight:
            points = points[::-1]
        return points if len(points) == n else resampled(points, _shares(front, points, evenness, closed=False))
    ring = points[:-1]
    refuse_outside(front, ring, ready.plane, "front")
    x, y = (ring - ring[0]).T
    if (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() > 0:
        ring = ring[::-1]
    if len(ring) == n:
        return np.roll(ring, -int(np.argmin(np.linalg.norm(ring - front[0], axis=1))), axis=0)
    ring = _begun_beside(ring, front)
    return resampled(ring, _shares(front, ring, evenness, closed=True))[:-1]


def _begun_beside(ring: np.ndarray, front: np.ndarray) -> np.ndarray:
    """A closed ring (m + 1, 2) that begins where the line from the front's middle through its first point meets it."""
    away = front[0] - front.mean(axis=0)
    after = np.roll(ring, -1, axis=0)
    side = away[0] * (ring - front[0])[:, 1] - away[1] * (ring - front[0])[:, 0]
    other = np.roll(side, -1)
    share = np.where(side != other, side / np.where(side != other, side - other, 1.0), 0.0)
    places = ring + share[:, None] * (after - ring)
    ahead = (places - front[0]) @ away
    meets = np.flatnonzero((side * other <= 0) & (ahead >= 0) & (share < 1))
    if not len(meets):
        k = int(np.argmin(np.linalg.norm(ring - front[0], axis=1)))
        return np.concatenate([ring[k:], ring[: k + 1]])
    k = meets[np.argmin(ahead[meets])]
    begun = np.concatenate([places[k : k + 1], ring[k + 1 :], ring[: k + 1], places[k : k + 1]])
    return begun[np.concatenate([[True], (np.diff(begun, axis=0) != 0).any(axis=1)])]


def _shares(front: np.ndarray, curve: np.ndarray, evenness: float, *, closed: bool) -> np.ndarray:
    """Where the front's points stand along the outer curve, from 0 to 1: evenly in part, in part as on the front.

    The nearest points move to the curve's corners.
    """
    line = np.concatenate([front, front[:1]]) if closed else front
    length, along = arc_length(line), arc_length(curve)
    shares = evenness * np.linspace(0, 1, len(line)) + (1 - evenness) * length / length[-1]
    turn = turning(curve[:-1] if closed else curve)
    for corner in np.flatnonzero(np.abs(turn) > NOTICEABLE):
        at = along[corner] / along[-1]
        k = int(np.argmin(np.abs(shares - at)))
        if 0 < k < len(shares) - 1 and shares[k - 1] < at < shares[k + 1]:
            shares[k] = at
    return shares
