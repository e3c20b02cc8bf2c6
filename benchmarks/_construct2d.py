"""Skew as Construct2D measures it, and the fronts and layers that its defaults make, for a like comparison.

Its skew of a point is the departure from 90 degrees of the smallest of the four angles between neighbouring edges
there; the worst of a grid is so that of the smallest corner of any cell, those at the wall included. Its defaults: 250
points round the section, 0.004 chords apart at the nose; a C-grid of 50 points in the wake to 15.5 chords if the edge
is sharp, else an O-grid whose base is rounded, with 14 points more; 100 levels to 15 chords, from y+ = 0.9 at half the
chord and a Reynolds number of a million on.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline, CubicSpline

from meshcore.geometry.curves import arc_length, resampled, turning
from meshcore.sizing import Spacing, geometric
from meshcore.structured.marching.hyperbolic_march import marched
from meshcore.structured.marching.layer_heights import layer_heights
from meshcore.structured.marching.marching_ends import Along

KNOWN = {"naca0012": 17.3, "rae2822": 17.7, "ag35": 19.9, "e387": 25.5, "s1223": 51.2, "ls417mod": 23.4}
AROUND, WAKE, BASE, LAYERS, REACH = 250, 50, 14, 99, 15.0
NOSE, EDGE = 0.004, 2 / 250 / 1.5
FIRST = 0.9 * 0.5 / (1e6 * np.sqrt(0.5 * (2 * np.log10(1e6) - 0.65) ** -2.3))


def skew(grid: np.ndarray) -> float:
    """Degrees, of a planar grid (ni, nj, 2)."""
    quad = np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]])
    ahead = np.roll(quad, -1, axis=0) - quad
    ahead /= np.linalg.norm(ahead, axis=-1)[..., None]
    cosine = -(ahead * np.roll(ahead, 1, axis=0)).sum(axis=-1)
    return float(np.degrees(np.arcsin(cosine.max())))


def marched_alike(loop: np.ndarray) -> tuple[np.ndarray, bool, float]:
    """The grid (ni, nj, 2) round a closed section, whether its edge is blunt, its front's sharpest turn (degrees)."""
    gap = float(np.linalg.norm(loop[0] - loop[-2]))
    blunt = abs(loop[0, 0] - loop[-2, 0]) < 1e-4 and gap > 1e-4
    points = respaced(loop[:-1] if blunt else loop, gap / 10 if blunt else EDGE)
    heights = layer_heights(FIRST, 3.0, layers=LAYERS, distance=REACH)
    if blunt:
        front = np.ascontiguousarray(with_round_base(points)[::-1])
        grid = marched(front, heights, closed=True).points
        return np.concatenate([grid, grid[:1]]), blunt, float(np.degrees(np.abs(turning(front)).max()))
    front = with_wake(points)
    grid = marched(front, heights, ends=(Along((0, 1)), Along((0, 1)))).points
    return grid, blunt, float(np.degrees(np.abs(turning(front)[1:-1]).max()))


def respaced(points: np.ndarray, edge: float) -> np.ndarray:
    """250 points from the edge over the nose to the edge, on a spline."""
    length = arc_length(points)
    curve, nose = CubicSpline(length, points), length[np.argmin(points[:, 0])]
    parts = []
    for start, stop, first, last, cells in (
        (0.0, nose, edge, NOSE, AROUND // 2),
        (nose, length[-1], NOSE, edge, AROUND // 2 - 1),
    ):
        law = Spacing("hyperbolic tangent", first=first, last=last)
        shares = law.fractions(cells, np.array([[0.0, 0, 0], [stop - start, 0, 0]]), diagonal=1.0)
        parts.append(curve(start + shares * (stop - start)))
    return np.concatenate([parts[0], parts[1][1:]])


def with_round_base(points: np.ndarray) -> np.ndarray:
    """A blunt section whose base is a cubic spline, which leaves the sides three quarters of a cell before it."""
    lower, upper = points[-1], points[0]
    middle = 0.5 * (lower + upper)
    start, stop = 0.75 * points[-2] + 0.25 * lower, 0.75 * points[1] + 0.25 * upper
    between = [0.5 * (start + lower), 0.5 * (lower + middle), middle, 0.5 * (middle + upper), 0.5 * (upper + stop)]
    knots = np.concatenate([[0.0] * 3, np.linspace(0, 1, 5), [1.0] * 3])
    base = BSpline(knots, np.array([start, *between, stop]), 3)(np.linspace(0, 1, 400))
    return np.concatenate([points[1:-1], resampled(base, base_shares(BASE + 2))[1:-1]])


def base_shares(cells: int) -> np.ndarray:
    """Where points stand along a base: a little closer at its ends, by a bell of variance 0.025."""
    bell = np.exp(-((np.linspace(0, 1, cells) - 0.5) ** 2) / 0.05)
    bell = (bell - bell[0]) / (1 - bell[0])
    widths = (1 + (1.05 - 1) * cells * bell / bell.sum()) / 1.05 / cells
    return np.concatenate([[0], np.cumsum(widths)])


def with_wake(points: np.ndarray) -> np.ndarray:
    """The front of a C-grid: wake, lower and upper side clockwise, wake."""
    away = np.array([REACH + 0.5, 0.0]) - points[0]
    first = np.linalg.norm(points[1] - points[0]) / np.linalg.norm(away)
    wake = points[0] + geometric(WAKE, first=first)[1:, None] * away
    return np.concatenate([wake[::-1], points[::-1], wake])
