"""Paths from a closed section out to a far field, which leave the section at right angles and never cross.

A path of point w with outward normal n and ray r is the Hermite blend ``p(d) = w + d r + psi(d) (n - r)`` with
``psi = d b / (d + b)``: it starts along n, turns over the distance b, and goes on along r. Rays that open
monotonically do not cross. Beside a corner b is the distance to it, which makes the pattern self-similar: with a
ray along the surface the Jacobian is ``(1 + (d / b)^2) / (1 + d / b)^2``, positive at any distance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...geometry.curves import arc_length, corners, turning
from ...geometry.section import TRAILING
from ...sizing.around_loop import accumulated, smoothed_turning
from .far_field import PolarCurve


@dataclass(frozen=True)
class Section:
    """A counter-clockwise loop that begins at its cut, with what its rays need.

    Attributes
    ----------
    points : (n + 1, 2) float
        The loop; the last point repeats the first.
    fractions : (n + 1,) float
        Fraction of the length up to each point.
    turn : (n,) float
        Turning at each point, radians.
    normal : (n + 1,) float
        Direction of the outward normal at each point, radians, going on by 2 pi around the loop.
    reach : (n + 1,) float
        Distance to the nearest corner, at least the nearest edge: how far a path may follow its normal.
    wake : (float, float)
        Fraction of the trailing edge's middle, and the direction of its bisector, radians.
    """

    points: np.ndarray
    fractions: np.ndarray
    turn: np.ndarray
    normal: np.ndarray
    reach: np.ndarray
    wake: tuple[float, float]

    @classmethod
    def of(cls, loop: np.ndarray) -> Section:
        """What rays need to know of (n, 2) points of a counter-clockwise loop that begins at its cut."""
        points = np.vstack([loop, loop[:1]])
        length = arc_length(points)
        fractions = length / length[-1]
        turn = turning(loop)
        edge = points[1] - points[0]
        # Directions of the edges' normals are unrolled from the first, so that they never jump by 2 pi.
        after = np.arctan2(edge[1], edge[0]) - np.pi / 2 + np.concatenate([[0.0], np.cumsum(turn[1:])])
        normal = after - 0.5 * turn
        normal = np.append(normal, normal[0] + 2 * np.pi)
        steps = np.diff(length)
        nearest = np.minimum(np.append(steps, steps[0]), np.append(steps[-1], steps))
        at = length[:-1][corners(turn)]
        reach = np.full(len(points), np.inf)
        if len(at):
            around = np.concatenate([at - length[-1], at, at + length[-1]])
            right = np.searchsorted(around, length)
            reach = np.minimum(around[right] - length, length - around[right - 1])
        return cls(points, fractions, turn, normal, np.maximum(reach, nearest), _wake(fractions, turn, after))


def _wake(fractions: np.ndarray, turn: np.ndarray, after: np.ndarray) -> tuple[float, float]:
    """Middle and bisector of the corners at the cut: between the edges before the first and after the last."""
    offset = (fractions[:-1] + 0.5) % 1.0 - 0.5
    near = np.flatnonzero(corners(turn) & (np.abs(offset) < TRAILING))
    near = np.append(near, 0)
    first, last = near[np.argmin(offset[near])], near[np.argmax(offset[near])]
    before_first = after[first] - turn[first] - (2 * np.pi if offset[first] < 0 else 0.0)
    after_last = after[last] - (2 * np.pi if offset[last] < 0 else 0.0)
    return 0.5 * (offset[first] + offset[last]), 0.5 * (before_first + after_last)


def ray_directions(of: Section, width: float, evenness: float) -> np.ndarray:
    """Directions of the rays, radians, growing by 2 pi around the section.

    Parameters
    ----------
    of : Section
        The section.
    width : float
        How far the turning of the section is spread along it before rays follow it, as a fraction of its length.
    evenness : float
        1 for rays that open in proportion to length, 0 for rays that follow the (positive) turning.

    Returns
    -------
    (n + 1,) float
    """
    density = np.maximum(smoothed_turning(of.fractions[:-1], of.turn, width), 0)
    density = (1 - evenness) * density / density.sum() + evenness / len(density)
    middle, bisector = of.wake
    return bisector + 2 * np.pi * (accumulated(density, of.fractions) - accumulated(density, np.array([middle])))


def paths(of: Section, rays: np.ndarray, bend: float, distance: np.ndarray) -> np.ndarray:
    """(n + 1, m, 2) points of the paths.

    Parameters
    ----------
    of : Section
        The section.
    rays : (n + 1,) float
        Directions of the rays, radians.
    bend : float
        Largest distance over which a path turns from its normal to its ray.
    distance : (n + 1, m) float
        The parameter d of each path.
    """
    ray = np.column_stack([np.cos(rays), np.sin(rays)])[:, None]
    normal = np.column_stack([np.cos(of.normal), np.sin(of.normal)])[:, None]
    d = distance[..., None]
    b = np.minimum(of.reach, bend)[:, None, None]
    return of.points[:, None] + d * ray + d * b / (d + b) * (normal - ray)


def to_far_field(of: Section, rays: np.ndarray, bend: float, far: PolarCurve) -> np.ndarray:
    """(n + 1,) float: the parameter at which each path meets a far field that holds the section, by Newton's method."""
    radius = far.least
    d = np.full((len(rays), 1), radius)
    for _ in range(50):
        here = far.beyond(paths(of, rays, bend, d))
        step = 1e-6 * radius
        slope = (far.beyond(paths(of, rays, bend, d + step)) - here) / step
        change = -here / np.where(slope > 0.05, slope, 1.0)
        d = np.maximum(d + change, 0.01 * radius)
        if np.abs(change).max() < 1e-13 * radius:
            break
    return d[:, 0]


def at_height(of: Section, rays: np.ndarray, bend: float, height: float) -> np.ndarray:
    """(n + 1,) float: the parameter at which each path is ``height`` away from its wall point."""
    d = np.full((len(rays), 1), height)
    for _ in range(60):
        away = np.linalg.norm(paths(of, rays, bend, d) - of.points[:, None], axis=-1)
        d *= height / away
    return d[:, 0]
