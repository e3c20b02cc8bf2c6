"""Far fields: the outer curves of grids round sections, as circle, box, C-shape or given curve."""

from __future__ import annotations

from typing import Literal

import numpy as np

from ...errors import InvalidGeometry
from ...geometry.curves import Curve, arc_length, polyline, turning
from ...geometry.plane import Plane
from ...geometry.section import Section, doubled_area
from ..crossings import refuse_outside
from ..limits import check_extent

FarField = Literal["circle", "box"]
_EVEN = 0.1
"""Share of an even spacing in that of points that have to be put in order."""


class OuterCurve:
    """A curve round a section that is open downstream, from its apex ahead of the nose both ways.

    Parameters
    ----------
    points : (m, 2) float
        From below the wake's end, forward, and back to above it.
    ahead : (2,) float
        The apex: where it is cut into halves.

    Attributes
    ----------
    halves : two of (k, 2) float
        From the apex to the end below, and to the end above.
    """

    def __init__(self, points: np.ndarray, ahead: np.ndarray):
        edge = np.diff(points, axis=0)
        along = ((ahead - points[:-1]) * edge).sum(axis=1) / (edge**2).sum(axis=1)
        near = points[:-1] + np.clip(along, 0, 1)[:, None] * edge
        k = int(np.argmin(np.linalg.norm(near - ahead, axis=1)))
        self.halves = np.vstack([points[: k + 1], near[k]])[::-1], np.vstack([near[k], points[k + 1 :]])

    @classmethod
    def ahead_of(cls, points: np.ndarray, section: Section) -> OuterCurve:
        """A given curve, whose apex is straight ahead of the section's nose."""
        ahead = (section.nose - points) @ section.direction
        aside = np.abs((points - section.nose) @ np.array([-section.direction[1], section.direction[0]]))
        apex = points[np.argmin(np.where(ahead > 0, aside / np.maximum(ahead, 1e-300), np.inf))]
        return cls(points, apex)

    def at(self, fractions: np.ndarray) -> np.ndarray:
        """(n, 2) float: points at fractions of the halves: -1 is the end below, 0 the apex, 1 the end above."""
        found = np.empty((len(fractions), 2))
        for half, side in zip(self.halves, (fractions < 0, fractions >= 0), strict=True):
            length = arc_length(half)
            s = np.abs(fractions[side]) * length[-1]
            found[side] = np.column_stack([np.interp(s, length, x) for x in half.T])
        return found

    def like(self, points: np.ndarray, nose: int) -> np.ndarray:
        """(n, 2) float: points that stand along the curve as those of another do, whose apex is number ``nose``."""
        length = arc_length(points) - arc_length(points[: nose + 1])[-1]
        return self.at(length / np.where(length < 0, -length[0], length[-1]))


def c_shape(section: Section, radius: float, end: np.ndarray) -> np.ndarray:
    """(m, 2) float: half a circle about the middle of the chord, and straight lines on to beside the wake's end.

    Parameters
    ----------
    section : Section
        In whose chord's direction the lines go.
    radius : float
        Of the half circle.
    end : (2,) float
        The end of the wake.
    """
    forward, side, centre = _frame(section)
    reach = float((end - centre) @ forward)
    angle = np.linspace(-np.pi / 2, -3 * np.pi / 2, 721)
    arc = centre + radius * (np.cos(angle)[:, None] * forward + np.sin(angle)[:, None] * side)
    return np.vstack([arc[0] + reach * forward, arc, arc[-1] + reach * forward])


def half_box(section: Section, radius: float, end: np.ndarray) -> np.ndarray:
    """(m, 2) float: the box of half the size ``radius`` about the middle of the chord, open beside the wake's end."""
    forward, side, centre = _frame(section)
    reach = float((end - centre) @ forward)
    corners = [(reach, -radius), (-radius, -radius), (-radius, 0), (-radius, radius), (reach, radius)]
    return np.array([centre + x * forward + y * side for x, y in corners])


class PolarCurve:
    """A closed far field that each direction from a point meets once: a circle, or a polygon.

    Parameters
    ----------
    centre : (2,) float
        The point.
    outline : float or (m, 2) float
        Radius of a circle, or the corners, counter-clockwise.

    Raises
    ------
    InvalidGeometry
        If the directions to the corners do not go once round the centre.
    """

    def __init__(self, centre: np.ndarray, outline: float | np.ndarray):
        self.centre, self.circle = centre, np.ndim(outline) == 0
        if self.circle:
            self.least = float(outline)
            return
        away = outline - centre
        angle = np.unwrap(np.arctan2(away[:, 1], away[:, 0]))
        closing = angle[0] + 2 * np.pi
        if (np.diff(np.append(angle, closing)) <= 0).any() or angle[-1] >= closing:
            raise InvalidGeometry(
                f"cannot be seen whole from the middle of the chord, ({centre[0]:.6g}, {centre[1]:.6g})",
                parameter="outer",
            )
        self._angle, self._away = np.append(angle, closing), np.vstack([away, away[:1]])
        self.corners = outline[np.abs(turning(outline)) > np.radians(30)]
        self.least = float(np.linalg.norm(away, axis=1).min())

    def radius(self, away: np.ndarray) -> np.ndarray:
        """(...,) float: the distance from the centre in the directions (..., 2)."""
        if self.circle:
            return np.full(away.shape[:-1], self.least)
        angle = np.arctan2(away[..., 1], away[..., 0])
        angle = self._angle[0] + (angle - self._angle[0]) % (2 * np.pi)
        edge = np.clip(np.searchsorted(self._angle, angle, side="right") - 1, 0, len(self._angle) - 2)
        start, along = self._away[edge], self._away[edge + 1] - self._away[edge]
        unit = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        across = unit[..., 0] * along[..., 1] - unit[..., 1] * along[..., 0]
        return (start[..., 0] * along[..., 1] - start[..., 1] * along[..., 0]) / across

    def beyond(self, points: np.ndarray) -> np.ndarray:
        """(...,) float: how much farther from the centre points are than the curve is."""
        away = points - self.centre
        return np.linalg.norm(away, axis=-1) - self.radius(away)

    def in_order(self, points: np.ndarray) -> np.ndarray:
        """(n, 2) float: counter-clockwise points of the curve put in order, or as they are if they run back nowhere.

        Lines that cross, as from deep teeth, end in another order than they begin; a march onto the curve needs it.
        """
        away = points - self.centre
        angle = np.unwrap(np.arctan2(away[:, 1], away[:, 0]))
        if (np.diff(np.append(angle, angle[0] + 2 * np.pi)) > 0).all():
            return points
        number = np.arange(len(points)) / len(points)
        ahead = np.maximum.accumulate(np.concatenate([angle - 2 * np.pi, angle]))[len(angle) :]
        ahead = np.minimum(ahead, ahead[0] + 2 * np.pi)
        even = ahead[0] + 2 * np.pi * number
        angle = (1 - _EVEN) * ahead + _EVEN * even
        unit = np.column_stack([np.cos(angle), np.sin(angle)])
        return self.onto(self.centre + unit)

    def onto(self, points: np.ndarray) -> np.ndarray:
        """(n, 2) float: points moved onto the curve along their directions; the nearest ones onto its corners."""
        away = points - self.centre
        found = self.centre + away * (self.radius(away) / np.linalg.norm(away, axis=1))[:, None]
        if not self.circle:
            for corner in self.corners:
                found[np.argmin(np.linalg.norm(found - corner, axis=1))] = corner
        return found


def box_corners(section: Section, radius: float) -> np.ndarray:
    """(4, 2) float: a square of half the size ``radius`` about the middle of the chord, counter-clockwise."""
    forward, side, centre = _frame(section)
    return np.array([centre + radius * (x * forward + y * side) for x, y in ((1, -1), (1, 1), (-1, 1), (-1, -1))])


def given_outer(curve: Curve, plane: Plane, section: np.ndarray, *, closed: bool) -> np.ndarray:
    """(m, 2) float: a far field as the user gives it, in the section's plane; open ones from below to above the wake.

    ``section`` are the section's points there.

    Raises
    ------
    InvalidGeometry
        If it is open where it should be closed or the other way, does not hold the section, or lies elsewhere.
    """
    points = polyline(curve, "outer")
    scale = check_extent(points, parameter="outer")
    if np.abs(plane.deviations(points)).max() > 1e-6 * scale:
        raise InvalidGeometry("is not in the section's plane; move it there", parameter="outer")
    ends_meet = bool((points[0] == points[-1]).all())
    if ends_meet != closed:
        raise InvalidGeometry(
            "is open; close the loop" if closed else "is closed; give it open, both ends beside the wake's end",
            parameter="outer",
        )
    flat = plane.to_plane(points)
    loop = flat[:-1] if closed else flat
    if doubled_area(loop) < 0:
        loop, flat = loop[::-1], flat[::-1]
    refuse_outside(section, loop, plane, "section")
    return loop if closed else flat[::-1]


def _frame(section: Section) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Directions along the chord downstream and to its left, and the middle of the chord."""
    forward = section.direction
    return forward, np.array([-forward[1], forward[0]]), 0.5 * (section.nose + section.tail)
