"""Closed sections, such as airfoils: trailing edge, nose and chord found by themselves."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from ..errors import InvalidGeometry
from .curves import arc_length, corners, turning

TRAILING = 0.015
"""Corners this near to each other, as a fraction of the loop, belong to one (blunt) trailing edge."""
CUSP = np.radians(3.0)
"""Angle between the two sides below which a trailing edge is a cusp."""
ALIKE = 0.9
"""Of the sharpest turn: points of round bodies that turn by more are alike, and the rearmost along x is the tail."""
SIMILAR = np.radians(10.0)
"""Edges that turn by no less than this below the sharpest may be the trailing one: that farthest from the middle is."""
STRAIGHT = 2e-3
"""Of a base's width: how far its points may stand off it, as rounded coordinates do. Grids make a base a straight line;
what bends, has a point between its corners or a notch would be cut off."""
Edge = Literal["sharp", "cusped", "blunt", "round"]


@dataclass(frozen=True, eq=False)
class Section:
    """A counter-clockwise loop that begins at its trailing edge, and what it has.

    ::

                    .------.__ first side        edge "sharp" or "cusped": loop[0] is the trailing edge
          nose  -> (          `--..  0           "blunt": loop[0] is the base's upper corner, loop[lower] the other,
                    `---------------' lower       and what follows, back to loop[0], is the base
                      second side                 "round": there is no corner; loop[0] is where it turns most, the
                                                      rearmost along x of such points, as on a circle

    Parameters
    ----------
    loop : (n, 2) float
        Different points; the last is joined to the first.
    lower : int
        Number of the point where the second side ends; n, meaning loop[0] again, unless the edge is blunt.
    edge : {"sharp", "cusped", "blunt", "round"}
        What the trailing edge is.
    """

    loop: np.ndarray
    lower: int
    edge: Edge

    @classmethod
    def of(cls, loop: np.ndarray) -> Section:
        """The section of a loop in any direction that begins anywhere.

        Raises
        ------
        InvalidGeometry
            If it has no area.

        Examples
        --------
        >>> wedge = Section.of(np.array([[0.0, 0.1], [0, -0.1], [1, -0.01], [1, 0.01]]))
        >>> wedge.edge, wedge.loop[0].tolist(), wedge.lower, wedge.tail.tolist()
        ('blunt', [1.0, 0.01], 3, [1.0, 0.0])
        """
        loop = np.asarray(loop, float)
        area = doubled_area(loop)
        if area == 0:
            raise InvalidGeometry("encloses no area", parameter="section")
        loop = loop if area > 0 else loop[::-1]
        turn = turning(loop)
        convex = corners(turn) & (turn > 0)
        if not convex.any():
            rear = np.flatnonzero(turn > ALIKE * turn.max())
            return cls(np.roll(loop, -int(rear[np.argmax(loop[rear, 0])]), axis=0), len(loop), "round")
        first, last = _base(loop, turn, np.flatnonzero(convex))
        loop = np.roll(loop, -last, axis=0)
        if first != last:
            return cls(loop, (first - last) % len(loop), "blunt")
        cusped = np.pi - turn[last] < CUSP
        return cls(loop, len(loop), "cusped" if cusped else "sharp")

    @cached_property
    def tail(self) -> np.ndarray:
        """(2,) float: the trailing edge, or the middle of its base."""
        return 0.5 * (self.loop[0] + self.loop[self.lower % len(self.loop)])

    @cached_property
    def base(self) -> float:
        """Width of a blunt trailing edge, else 0."""
        return float(np.linalg.norm(self.loop[0] - self.loop[self.lower % len(self.loop)]))

    @cached_property
    def nose_index(self) -> int:
        """Number of the point that is farthest from the trailing edge."""
        return int(np.argmax(np.linalg.norm(self.loop - self.tail, axis=1)))

    @cached_property
    def nose(self) -> np.ndarray:
        """(2,) float: that point."""
        return self.loop[self.nose_index]

    @cached_property
    def chord(self) -> float:
        """Distance from nose to trailing edge."""
        return float(np.linalg.norm(self.tail - self.nose))

    @cached_property
    def direction(self) -> np.ndarray:
        """(2,) float: unit vector from nose to trailing edge."""
        return (self.tail - self.nose) / self.chord

    @cached_property
    def bisector(self) -> np.ndarray:
        """(2,) float: unit vector between the directions in which the two sides leave the trailing edge."""
        n = len(self.loop)
        upper = self.loop[0] - self.loop[1]
        lower = self.loop[self.lower % n] - self.loop[(self.lower - 1) % n]
        sum_ = upper / np.linalg.norm(upper) + lower / np.linalg.norm(lower)
        size = float(np.linalg.norm(sum_))
        return sum_ / size if size > 1e-6 else self.direction

    @cached_property
    def nose_radius(self) -> float:
        """Radius of the circle that turns as the section does about its nose, over 2 % of the chord each way."""
        closed = np.vstack([self.loop, self.loop[:1]])
        at = arc_length(closed)
        offset = at[:-1] - at[self.nose_index]
        turn = turning(self.loop)
        window = 0.02 * self.chord
        near = np.flatnonzero(np.abs(offset) <= window)
        while len(near) < 3 and window < self.chord:
            window *= 1.5
            near = np.flatnonzero(np.abs(offset) <= window)
        turned = float(turn[near].sum())
        first, last = near[0], near[-1]
        length = 0.5 * (at[last + 1] + at[last] - at[first] - at[max(first - 1, 0)])
        return min(length / max(turned, 1e-3), 0.5 * self.chord)

    @cached_property
    def focus(self) -> np.ndarray:
        """(2,) float: a point inside the nose at half its radius; behind a corner, on its bisector.

        Where a thin nose bends away that lies outside; a point between both sides near the nose is taken then.
        """
        inwards, nose = self.direction, self.nose_index
        if corners(turning(self.loop))[nose]:
            arms = self.loop[[nose - 1, (nose + 1) % len(self.loop)]] - self.nose
            both = (arms / np.linalg.norm(arms, axis=1)[:, None]).sum(axis=0)
            size = float(np.linalg.norm(both))
            inwards = both / size if size > 1e-6 else inwards
        found = self.nose + 0.5 * self.nose_radius * inwards
        return found if winds_round(self.loop, found) else self._between_sides()

    def _between_sides(self) -> np.ndarray:
        """A point inside, in the middle of points at equal lengths from the nose, the farther away the better."""
        closed = np.roll(self.loop, -self.nose_index, axis=0)
        closed = np.vstack([closed, closed[:1]])
        length = arc_length(closed)
        for way in 0.02 * self.chord * 0.5 ** np.arange(20):
            both = [np.interp([way, length[-1] - way], length, x) for x in closed.T]
            if winds_round(self.loop, middle := np.mean(both, axis=1)):
                return middle
        return self.nose


def winds_round(loop: np.ndarray, point: np.ndarray) -> bool:
    """Whether a closed loop, counter-clockwise or not, goes round a point.

    Examples
    --------
    >>> square = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    >>> winds_round(square, np.array([0.5, 0.2])), winds_round(square, np.array([1.5, 0.2]))
    (True, False)
    """
    away = loop - point
    after = np.roll(away, -1, axis=0)
    seen = np.arctan2(away[:, 0] * after[:, 1] - away[:, 1] * after[:, 0], (away * after).sum(axis=1))
    return bool(abs(seen.sum()) > np.pi)


def centroid(loop: np.ndarray) -> np.ndarray:
    """(2,) float: the middle of the area in a closed loop.

    Examples
    --------
    >>> centroid(np.array([[0.0, 0], [3, 0], [0, 3]]))
    array([1., 1.])
    """
    arm = loop - loop[0]
    after = np.roll(arm, -1, axis=0)
    part = arm[:, 0] * after[:, 1] - arm[:, 1] * after[:, 0]
    return loop[0] + part @ (arm + after) / (3 * part.sum())


def doubled_area(loop: np.ndarray) -> float:
    """Twice the area of a closed loop, positive counter-clockwise.

    Examples
    --------
    >>> doubled_area(np.array([[0.0, 0], [1, 0], [0, 1]]))
    1.0
    """
    x, y = (loop - loop[0]).T
    return float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


def _base(loop: np.ndarray, turn: np.ndarray, convex: np.ndarray) -> tuple[int, int]:
    """First and last corner, going round, of the trailing edge: of the groups of convex corners that turn most, the one
    farthest from the middle of the area, which lies nearer to a nose."""
    length = arc_length(np.vstack([loop, loop[:1]]))
    offset = (length[convex] - length[convex][:, None]) / length[-1]
    offset = (offset + 0.5) % 1.0 - 0.5
    # Turns of noise cancel in the sum of all points; its convex corners alone add up beside a nose of many points.
    every = np.abs(((length[:-1] - length[convex][:, None]) / length[-1] + 0.5) % 1.0 - 0.5)
    together = np.minimum((np.abs(offset) < TRAILING) @ turn[convex], (every < TRAILING) @ turn)
    away = np.linalg.norm(loop[convex] - centroid(loop), axis=1)
    alike = together > together.max() - SIMILAR
    farthest = np.flatnonzero(alike & (away > (1 - 1e-9) * away[alike].max()))
    sharpest = farthest[np.argmax(turn[convex][farthest])]
    own = offset[sharpest]
    near = np.flatnonzero(np.abs(own) < TRAILING)
    first, last = int(convex[near[np.argmin(own[near])]]), int(convex[near[np.argmax(own[near])]])
    if _is_straight(loop, first, last):
        return first, last
    return int(convex[sharpest]), int(convex[sharpest])


def _is_straight(loop: np.ndarray, first: int, last: int) -> bool:
    """Whether a loop runs nearly straight from one of its points to another."""
    between = loop[(first + np.arange((last - first) % len(loop) + 1)) % len(loop)] - loop[first]
    along = between[-1]
    off = np.abs(along[0] * between[:, 1] - along[1] * between[:, 0])
    return bool((off <= STRAIGHT * (along @ along)).all())
