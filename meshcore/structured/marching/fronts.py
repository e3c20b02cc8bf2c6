"""Fronts as hosts give them, made ready for marching: in their plane, without repeated points, turned the right way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...errors import InvalidGeometry
from ...geometry.curves import Curve, is_closed, numbered_polyline
from ...geometry.plane import Plane, fitted_plane
from ...geometry.section import doubled_area
from ..crossings import TOUCH, refuse_crossings
from ..limits import check_extent
from .hyperbolic_march import Marched
from .march_stops import Stop

_BLOCK = 20_000
"""Points that are put into space at once, so that they stay in caches."""


@dataclass(frozen=True)
class Front:
    """A polyline in its plane, which marches to the left of its direction.

    Attributes
    ----------
    points : (n, 2) float
        Different points; the first of a closed front is not repeated.
    closed : bool
        Whether the last point is joined to the first.
    diagonal : float
        Of the bounding box.
    plane : Plane
        Where it lies in space.
    reversed : bool
        Whether points were put in the opposite order.
    number : (n,) int
        The numbers that the user has for them.
    warnings : list of str
        What was changed on the way.
    """

    points: np.ndarray
    closed: bool
    diagonal: float
    plane: Plane
    reversed: bool
    number: np.ndarray
    warnings: list[str]

    def in_space(self, points: np.ndarray) -> np.ndarray:
        """(ni, nj, 3) points of a grid (n, nj, 2) made on the front, with the cut of a closed one repeated."""
        n, levels = points.shape[:2]
        found = np.empty((n + self.closed, levels, 3))
        block = max(1, _BLOCK // levels)
        for first in range(0, n, block):
            part = points[first : first + block]
            found[first : first + len(part)] = self.plane.to_space(part.reshape(-1, 2)).reshape(*part.shape[:2], 3)
        if self.closed:
            found[-1] = found[0]
        return found


def read_front(curve: Curve, *, other_side: bool = False, parameter: str = "front") -> Front:
    """Make a front ready: a closed one marches outwards, an open one to its left; to the other side if asked.

    Raises
    ------
    InvalidGeometry
        If it is not planar, has too few points, crosses itself, or a closed one encloses no area.

    Examples
    --------
    >>> front = read_front(np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]))
    >>> front.points.tolist(), front.closed, front.warnings
    ([[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]], True, [])
    """
    spatial, number = numbered_polyline(curve, parameter)
    closed = is_closed(spatial)
    if closed:
        spatial, number = spatial[:-1], number[:-1]
    fresh = (spatial != np.roll(spatial, 1, axis=0)).any(axis=1)
    fresh[0] |= not closed
    repeats = int((~fresh).sum())
    warnings = [f"{repeats} repeated points of the {parameter} were left out"] if repeats else []
    spatial, number = spatial[fresh], number[fresh]
    least = 3 if closed else 2
    if len(spatial) < least:
        raise InvalidGeometry(f"needs at least {least} different points, got {len(spatial)}", parameter=parameter)
    diagonal = check_extent(spatial, parameter=parameter)
    plane = fitted_plane(spatial, parameter=parameter)
    points = np.ascontiguousarray(plane.to_plane(spatial))
    refuse_crossings(points, number, plane, TOUCH * diagonal, closed=closed, parameter=parameter)
    backwards = other_side
    if closed:
        counter_clockwise = doubled_area(points) > 0
        if not counter_clockwise:
            warnings.append(f"the {parameter} is clockwise; it was taken the other way round")
        backwards = counter_clockwise != other_side
    if backwards:
        order = np.roll(np.arange(len(points))[::-1], 1 if closed else 0)
        points, number = np.ascontiguousarray(points[order]), number[order]
    return Front(points, closed, diagonal, plane, bool(backwards), number, warnings)


def stop_told(stop: Stop, ready: Front, asked: int) -> str:
    """What to say of a march that stopped: at which layer, at which point as the user numbers them, and why."""
    return f"stopped after {stop.layer} of {asked} layers, since {reason_told(stop, ready)}"


def reason_told(stop: Stop, ready: Front) -> str:
    """Why a march stopped, at which of the front's points as the user numbers them, where, and how concave it is."""
    x, y, z = ready.plane.to_space(stop.place[None])[0]
    place = f"near ({x:.6g}, {y:.6g}, {z:.6g})"
    if stop.other is not None:
        points = sorted(ready.number[[stop.point, stop.other]])
        bay = f"across a bay that is concave by {stop.concavity:.0f} degrees" if stop.concavity > 0 else "there"
        return f"{stop.reason} at the front's points {points[0]} and {points[1]} {place}, {bay}"
    bend = f"where it is concave by {stop.concavity:.0f} degrees" if stop.concavity > 0 else "where it is not concave"
    return f"{stop.reason} at the front's point {ready.number[stop.point]} {place}, {bend}"


def changes_told(result: Marched) -> tuple[dict[str, int], list[str]]:
    """For a report: counts and warnings of what a march did otherwise than asked, so that no cell folds.

    Examples
    --------
    >>> changes_told(Marched(np.zeros((5, 4, 2)), 2, None, 1.5))[0]
    {'layers in smaller steps': 2}
    """
    counts = {"layers in smaller steps": result.split} if result.split else {}
    if result.raised <= 1:
        return counts, []
    return counts, [f"cells would have folded; the grid was smoothed {result.raised:g} times as much as asked"]
