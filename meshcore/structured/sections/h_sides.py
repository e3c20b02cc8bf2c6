"""The two sides of a section or a slit, from its nose to its tail, as the blocks of an H-grid see them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...errors import InvalidGeometry
from ...geometry.curves import Curve, is_closed, polyline, turning
from ...geometry.plane import Plane, fitted_plane, seen_upright
from ...geometry.section import Section
from ..limits import check_extent
from .section_input import section_loop
from .section_points import Points, respaced_section

_STEEP = np.radians(45)
"""Slope from the flow's direction from which on the front of a section counts as a step."""
_LEVEL = 1e-8
"""Of the extent: how far the points of a flat front or rear may be apart along the flow."""


@dataclass(frozen=True)
class Side:
    """One side of a section, from nose to tail, x along the flow and y away from the section.

    Attributes
    ----------
    points : (n, 2) float
        From the middle of the front, or the nose, to the middle of the rear, or the trailing edge.
    first, last : int
        Where the steps of its front and rear end and begin.
    base : float
        Height of its flat front or rear, the larger of them; 0 if it has none.
    """

    points: np.ndarray
    first: int
    last: int
    base: float = 0.0


class Sides(NamedTuple):
    """A section as an H-grid sees it.

    Attributes
    ----------
    lower, upper : Side
        Its sides, the lower one upside down.
    plane : Plane
        Where it lies.
    frame : (2, 2) float
        Axes of the flow, along it and to its left, as rows.
    loop : (m, 2) float
        All points in the plane.
    diagonal : float
        Of its bounding box.
    warnings : list of str
        What was changed.
    """

    lower: Side
    upper: Side
    plane: Plane
    frame: np.ndarray
    loop: np.ndarray
    diagonal: float
    warnings: list[str]


def sides_of(section: Curve, flow: float, asked: Callable[[float], Points]) -> Sides:
    """The sides of a section, or of a slit, turned so that the flow runs along x.

    Parameters
    ----------
    section : Curve
        As the user gives it.
    flow : float
        Degrees from its chord to the flow.
    asked : callable
        Takes the diagonal of its bounding box to what is asked of its points.
    """
    points = polyline(section, "section")
    if not is_closed(points) and not _narrow(points):
        kept = [] if asked(1.0).given else ["a slit keeps its own points; other spacings were not used"]
        return _slit(points, flow)._replace(warnings=kept)
    given = section_loop(section)
    shape = respaced_section(Section.of(given.loop), asked(given.diagonal))
    loop = shape.loop
    along, base = _turned(shape.direction, flow), shape.lower if shape.edge == "blunt" else None
    if shape.edge == "round" or len(np.flatnonzero(np.abs(turning(loop)) > np.radians(60))) > 3:
        along, base = _turned(np.array([1.0, 0.0]), flow), None  # bodies without a trailing edge, and slabs
    frame = np.array([along, [-along[1], along[0]]])
    local = loop @ frame.T
    tail = _end(local, base)
    nose = _end(local * [-1, 1], None)
    upper = _side(local, nose, tail)
    lower = _side(local[::-1] * [1, -1], *((len(local) - 1 - a, len(local) - 1 - b) for b, a in (nose, tail)))
    return Sides(lower, upper, given.plane, frame, loop, given.diagonal, list(given.warnings))


def _narrow(points: np.ndarray) -> bool:
    """Whether an open line is a section whose trailing edge is open, rather than a slit."""
    gap = float(np.linalg.norm(points[-1] - points[0]))
    return len(points) > 3 and gap < 0.05 * float(np.ptp(points, axis=0).max())


def _slit(points: np.ndarray, flow: float) -> Sides:
    diagonal = check_extent(points, parameter="section")
    straight = np.ptp(points - points[0], axis=0).max() > 0
    try:
        plane = seen_upright(fitted_plane(points, parameter="section"))
    except InvalidGeometry:
        if not straight:
            raise
        plane = Plane(np.zeros(3), np.eye(3)[:2])
    line = plane.to_plane(points)
    line = line if line[0, 0] <= line[-1, 0] else line[::-1]
    along = _turned((line[-1] - line[0]) / np.linalg.norm(line[-1] - line[0]), flow)
    frame = np.array([along, [-along[1], along[0]]])
    local = line @ frame.T
    if (np.diff(local[:, 0]) <= 0).any():
        raise InvalidGeometry("is a slit that turns back against the flow; make it shallower", parameter="section")
    n = len(local) - 1
    return Sides(Side(local * [1, -1], 0, n), Side(local, 0, n), plane, frame, line, diagonal, [])


def _turned(direction: np.ndarray, degrees: float) -> np.ndarray:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([c * direction[0] - s * direction[1], s * direction[0] + c * direction[1]])


def _end(local: np.ndarray, lower: int | None) -> tuple[int, int]:
    """Numbers of the lower and the upper corner of the rear of a counter-clockwise loop; the same if it is a point."""
    if lower is not None:
        return lower, 0
    x = local[:, 0]
    is_rear = x >= x.max() - _LEVEL * np.ptp(x)
    around = (np.argmin(is_rear) + np.arange(len(x))) % len(x)  # from a point that is not at the rear
    runs = np.split(around, np.flatnonzero(np.diff(is_rear[around])) + 1)[1::2]
    rear = max(runs, key=lambda run: float(np.ptp(local[run, 1])))  # tips with a bay between them are no flat rear
    return int(rear[np.argmin(local[rear, 1])]), int(rear[np.argmax(local[rear, 1])])


def _side(local: np.ndarray, nose: tuple[int, int], tail: tuple[int, int]) -> Side:
    """The upper side of a counter-clockwise loop: from the middle of its front over the top to that of its rear.

    ``nose`` and ``tail`` are the lower and upper corners of front and rear.
    """
    n = len(local)
    count = (nose[1] - tail[1]) % n
    top = local[(nose[1] - np.arange(count + 1)) % n]
    edges = np.linalg.norm(np.diff(top, axis=0), axis=1)
    front = _face(0.5 * (local[nose[0]] + local[nose[1]]), top[0], edges[0])
    rear = _face(top[-1], 0.5 * (local[tail[0]] + local[tail[1]]), edges[-1])
    points = np.vstack([front[:-1], top, rear[1:]])
    first, last = len(front) - 1, len(points) - len(rear)
    base = max(float(np.linalg.norm(face[-1] - face[0])) for face in (front, rear))
    if first == 0:
        first = _steep_until(points)
    if last == len(points) - 1:
        last = len(points) - 1 - _steep_until(points[::-1] * [-1, 1])
    return Side(points, first, max(last, first), base)


def _face(start: np.ndarray, stop: np.ndarray, size: float) -> np.ndarray:
    """Points of half a flat front or rear, in cells of about a size; one point where there is none."""
    length = float(np.linalg.norm(stop - start))
    if length == 0:
        return start[None]
    cells = int(np.clip(round(length / size), 2, 200))
    return start + np.linspace(0, 1, cells + 1)[:, None] * (stop - start)


def _steep_until(points: np.ndarray) -> int:
    """Number of the point up to which a side rises steeply from its nose; 0 if it does not."""
    edge = np.diff(points, axis=0)
    steep = np.arctan2(edge[:, 1], edge[:, 0]) > _STEEP
    return int(np.argmin(steep)) if not steep.all() else len(points) // 2
