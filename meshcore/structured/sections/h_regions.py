"""The two regions of an H-grid: a front of cut, section and cut below, far field on the three other sides."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...errors import InvalidGeometry
from ...geometry.curves import Curve, arc_length
from ...geometry.plane import Plane
from ...sizing import cells_for_growth, geometric
from .far_field import given_outer
from .h_sides import Side, Sides


@dataclass(frozen=True)
class Region:
    """What one block fills, x along the flow and y away from the section.

    Attributes
    ----------
    front : (n, 2) float
        The cut ahead, the section from nose to tail, and the wake.
    nose, first, last, tail : int
        Numbers of the front's points where the section begins and ends, and the steps of its front and rear between.
    left, top, right : (k, 2) float
        The far field as polylines: from the front's first point up, from there to the right, and from its last point
        up.
    base : float
        Height of the section's flat front or rear.
    axes : (2, 2) float
        Rows that take places of the region to the section's plane.
    plane : Plane
        The section's.
    """

    front: np.ndarray
    nose: int
    first: int
    last: int
    tail: int
    left: np.ndarray
    top: np.ndarray
    right: np.ndarray
    base: float
    axes: np.ndarray
    plane: Plane

    def along(self) -> np.ndarray:
        """(n,) float: how far points of the front are on their way along the flow, never backwards."""
        x = self.front[:, 0].copy()
        section = slice(self.nose, self.tail + 1)
        length = arc_length(self.front[section])
        x[section] = x[self.nose] + (x[self.tail] - x[self.nose]) * length / length[-1]
        return (x - x[0]) / (x[-1] - x[0])


def box_regions(sides: Sides, reach: float, behind: float, growth: float) -> tuple[Region, Region]:
    """The regions below and above in a box.

    Parameters
    ----------
    sides : Sides
        Of the section.
    reach : float
        How far the box reaches ahead of mid-chord, above and below.
    behind : float
        How far it reaches behind the section.
    growth : float
        Largest growth of cells along the cuts.
    """
    nose, tail = sides.upper.points[[0, -1]]
    left, right = 0.5 * (nose[0] + tail[0]) - reach, tail[0] + behind
    regions = []
    for side, up in ((sides.lower, -1), (sides.upper, 1)):
        front, *numbers = _front(side, sides, left, right, growth)
        top = 0.5 * (side.points[0, 1] + side.points[-1, 1]) + reach
        corners = np.array([[left, top], [right, top]])
        ends = np.vstack([front[0], corners[0]]), corners, np.vstack([front[-1], corners[1]])
        regions.append(Region(front, *numbers, *ends, side.base, sides.frame * [[1], [up]], sides.plane))
    return regions[0], regions[1]


def given_regions(sides: Sides, outer: Curve, growth: float) -> tuple[Region, Region]:
    """The regions below and above within a closed curve.

    Its four corners are the points that lie farthest towards those of its bounding box.

    Raises
    ------
    InvalidGeometry
        If it is not closed, does not hold the section, has no four corners in order, or its ends are crossed more than
        once by the straight lines ahead of the section and behind it.
    """
    loop = given_outer(outer, sides.plane, sides.loop, closed=True) @ sides.frame.T
    low, high = loop.min(axis=0), loop.max(axis=0)
    unit = 2 * (loop - low) / (high - low) - 1
    at = [int(np.argmax(unit @ corner)) for corner in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    loop, at = np.roll(loop, -at[0], axis=0), [(k - at[0]) % len(loop) for k in at]
    if len(set(at)) < 4 or at != sorted(at):
        raise InvalidGeometry(
            "has no four corners, ahead and behind, above and below; give a curve more like a box", parameter="outer"
        )
    closed = np.vstack([loop, loop[:1]])
    bottom, right, top, left = (closed[a : b + 1] for a, b in zip(at, [*at[1:], len(loop)], strict=True))
    nose, tail = sides.upper.points[[0, -1]]
    ends = [_above(end, level, name) for end, level, name in ((left[::-1], nose, "inflow"), (right, tail, "outflow"))]
    lower = [_above(end[::-1] * [1, -1], -level, "") for end, level in ((left[::-1], nose), (right, tail))]
    regions = []
    for side, up, (start, stop), far in (
        (sides.lower, -1, lower, bottom * [1, -1]),
        (sides.upper, 1, ends, top[::-1]),
    ):
        front, *numbers = _front(side, sides, start[0, 0], stop[0, 0], growth)
        start[0], stop[0] = front[0], front[-1]
        regions.append(Region(front, *numbers, start, far, stop, side.base, sides.frame * [[1], [up]], sides.plane))
    return regions[0], regions[1]


def _above(end: np.ndarray, level: np.ndarray, name: str) -> np.ndarray:
    """The part of a far field's end from the height of a point upwards; it is given from below to above."""
    up = end[:, 1] > level[1]
    crossed = np.flatnonzero(up[1:] != up[:-1])
    if len(crossed) != 1:
        raise InvalidGeometry(
            f"is crossed {len(crossed)} times at its {name} by the straight line from ({level[0]:.6g}, {level[1]:.6g}) "
            "along the flow; it should be once",
            parameter="outer",
        )
    a, b = end[crossed[0]], end[crossed[0] + 1]
    place = a + (level[1] - a[1]) / (b[1] - a[1]) * (b - a)
    return np.vstack([place, end[crossed[0] + 1 :]])


def _front(side: Side, sides: Sides, left: float, right: float, growth: float):
    """Points from x = ``left`` to x = ``right``, and numbers of those where nose, steps and tail are."""
    chains = sides.lower.points, sides.upper.points
    sizes = [min(np.linalg.norm(chain[a] - chain[b]) for chain in chains) for a, b in ((0, 1), (-1, -2))]
    nose, tail = side.points[0], side.points[-1]
    ahead, wake = _growing(nose[0] - left, sizes[0], growth), _growing(right - tail[0], sizes[1], growth)
    before = np.column_stack([nose[0] - ahead[:0:-1], np.full(len(ahead) - 1, nose[1])])
    behind = np.column_stack([tail[0] + wake[1:], np.full(len(wake) - 1, tail[1])])
    before[0, 0], behind[-1, 0] = left, right
    first = len(before)
    numbers = first, first + side.first, first + side.last, first + len(side.points) - 1
    return np.vstack([before, side.points, behind]), *numbers


def _growing(length: float, first: float, growth: float) -> np.ndarray:
    share = min(first / length, 0.2)
    return length * geometric(max(2, cells_for_growth(share, growth)), first=share)
