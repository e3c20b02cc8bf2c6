"""Splines through points of a curve in the plane that bend no oftener than the points do."""

from __future__ import annotations

import numpy as np

from .curves import arc_length

_INSIDE = 0.05
"""Of the turn at a point: how far its tangent keeps from both edges."""
_STRAIGHT = 1e-9
"""Turns, in radians, that are none."""
_LONGEST = 0.95
"""Of the way to where two tangents meet: how long a handle may be, so that no segment is a point of its own."""


class ShapeSpline:
    """A cubic spline through points, drawn in where it would wiggle.

    The spline is the usual one, with continuous curvature over the polyline's length. Where its tangent at a point is
    not between the directions of the two edges there, it is turned until it is; where the handles of a segment, as a
    Bezier curve, would cross, they are shortened. A segment then bends one way if the points on both its sides do, so
    that the curvature changes its sign no oftener than the turning of the polyline. There the curve has one tangent,
    but its curvature may jump.

    Parameters
    ----------
    points : (n, 2) float
        Different points in order.
    closed : bool
        Whether the last point repeats the first and the curve goes on smoothly there.

    Examples
    --------
    >>> import numpy as np
    >>> step = ShapeSpline(np.array([[0.0, 0], [1, 0], [2, 0], [2.5, 1], [3, 2], [4, 2], [5, 2]]))
    >>> float(step(np.linspace(0, 2, 50))[:, 1].min())  # no dip before the step
    0.0
    """

    def __init__(self, points: np.ndarray, *, closed: bool = False):
        self.points = np.asarray(points, float)
        self.length = arc_length(self.points)
        edge = np.diff(self.points, axis=0)
        size = np.linalg.norm(edge, axis=1)
        slope = _slopes(self.length, self.points, closed)
        angle = _between_edges(slope, edge, closed)
        speed = np.linalg.norm(slope, axis=1)
        direction = np.column_stack([np.cos(angle), np.sin(angle)])
        first, last = _handles(edge, size, angle, speed)
        self._controls = np.stack(
            [
                self.points[:-1],
                self.points[:-1] + first[:, None] * direction[:-1],
                self.points[1:] - last[:, None] * direction[1:],
                self.points[1:],
            ]
        )

    def __call__(self, at: np.ndarray) -> np.ndarray:
        """(m, 2) float: points at lengths (m,) of the polyline; those of its own points are kept to the bit."""
        at = np.asarray(at, float)
        segment = np.clip(np.searchsorted(self.length, at, side="right") - 1, 0, len(self.length) - 2)
        step = self.length[segment + 1] - self.length[segment]
        t = ((at - self.length[segment]) / step)[:, None]
        a, b, c, d = self._controls[:, segment]
        return (1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t**2 * c + t**3 * d


def _slopes(length: np.ndarray, points: np.ndarray, closed: bool) -> np.ndarray:
    """(n, 2) float: derivatives at the points of the cubic spline over length."""
    if len(points) == 2:
        return np.repeat(np.diff(points, axis=0) / length[-1], 2, axis=0)
    from scipy.interpolate import CubicSpline  # half a second, which not every start should take

    return CubicSpline(length, points, bc_type="periodic" if closed else "not-a-knot")(length, 1)


def _between_edges(slope: np.ndarray, edge: np.ndarray, closed: bool) -> np.ndarray:
    """(n,) float: directions of the tangents in radians, brought between those of the edges at each point."""
    heading = np.arctan2(edge[:, 1], edge[:, 0])
    before, after = np.append(heading[-1], heading), np.append(heading, heading[0])
    turn = _wrapped(after - before)
    offset = _wrapped(np.arctan2(slope[:, 1], slope[:, 0]) - before)
    inner, outer = _INSIDE * turn, (1 - _INSIDE) * turn
    offset = np.clip(offset, np.minimum(inner, outer), np.maximum(inner, outer))
    # A straight stretch stays straight to its end, whose tangent is the stretch's.
    straight = np.abs(turn) <= _STRAIGHT
    if not closed:
        straight[[0, -1]] = False
    offset[1:][straight[:-1]] = 0.0
    offset[:-1][straight[1:]] = turn[:-1][straight[1:]]
    angle = before + offset
    if not closed:  # ends have one edge; the curve may lean away from it as it would
        for end, own in ((0, heading[0]), (-1, heading[-1])):
            angle[end] = own + _end_lean(slope[end], own, turn[1:-1], end)
    return angle


def _end_lean(slope: np.ndarray, own: float, turn: np.ndarray, end: int) -> float:
    """Angle from an end's edge to the tangent there: as the next point turns, and no more than that."""
    if not len(turn):
        return 0.0
    near = turn[0] if end == 0 else -turn[-1]
    lean = float(_wrapped(np.arctan2(slope[1], slope[0]) - own))
    return float(np.clip(lean, min(-near, 0), max(-near, 0)))


def _handles(edge: np.ndarray, size: np.ndarray, angle: np.ndarray, speed: np.ndarray):
    """Lengths of the two handles of each segment."""
    heading = np.arctan2(edge[:, 1], edge[:, 0])
    start, stop = _wrapped(heading - angle[:-1]), _wrapped(angle[1:] - heading)
    first, last = speed[:-1] * size / 3, speed[1:] * size / 3
    start[np.abs(start) <= _STRAIGHT] = 0.0
    stop[np.abs(stop) <= _STRAIGHT] = 0.0
    convex = (start * stop >= 0) & (start + stop != 0) & (np.abs(start + stop) < np.pi)
    whole = np.where(convex, np.sin(start + stop), 1.0)
    whole = np.where(whole == 0, 1.0, whole)
    first = np.where(convex, np.minimum(first, _LONGEST * size * np.sin(stop) / whole), np.minimum(first, size / 2))
    last = np.where(convex, np.minimum(last, _LONGEST * size * np.sin(start) / whole), np.minimum(last, size / 2))
    return first, last


def _wrapped(angle: np.ndarray) -> np.ndarray:
    """Angles between -pi and pi."""
    return (angle + np.pi) % (2 * np.pi) - np.pi
