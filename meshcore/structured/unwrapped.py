"""C-grids by unwrapping: the square root opens a section and its wake into a shallow bump over a straight line.

In ``w = sqrt(z - focus)``, the focus lying inside the nose at half its radius, section and wake become one curve
eta = S(xi) over the real axis and the C-shaped region the half plane above it (A. Jameson's parabolic coordinates).
Lines between that curve and the image of the far field cannot fold there, and the map back is conformal, so that
angles are kept. Lines leave the curve at right angles, as in `rays`, and turn away over a short distance.

At a blunt trailing edge the curve steps down to the wake. Lines from the base are moved downstream by a shift that
grows over the base and fades along the wake, so that they fan out between those of the wall and those of the wake.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..geometry.curves import arc_length

_SHIFT = 3.0
"""Shift of the line from a base's middle, in halves of the base."""
_FADE = 4.0
"""Shifts fade over so many times themselves, more than 1, so that lines keep their order."""
_AT_CORNER = 0.3
"""Shift of the line from a base's corner, of that from the base's middle."""


@dataclass(frozen=True, eq=False)
class Unwrapped:
    """A front of wake, section and wake, clockwise, in the half plane.

    Attributes
    ----------
    focus, scale, turn : complex, float, complex
        ``z = focus + scale turn w^2``: the branch point, the chord, and the direction downstream.
    front : (n,) complex
        The points of the front; real parts increase from wake to wake.
    normal : (n,) complex
        Unit normals, upwards.
    reach : (n,) float
        Distance to the nearest corner of the wall, at least the nearest edge.
    shift : (n,) float
        How far lines are moved downstream beside a blunt base.
    nose : int
        Number of the point nearest to the imaginary axis.
    """

    focus: complex
    scale: float
    turn: complex
    front: np.ndarray
    normal: np.ndarray
    reach: np.ndarray
    shift: np.ndarray
    nose: int

    def unwrap(self, points: np.ndarray, start: complex) -> np.ndarray:
        """(m,) complex: places w of (m, 2) points in order, the first on the same branch as ``start``."""
        z = (points[:, 0] + 1j * points[:, 1] - self.focus) / (self.scale * self.turn)
        angle = np.unwrap(np.angle(z))
        w = np.sqrt(np.abs(z)) * np.exp(0.5j * angle)
        return w if abs(w[0] - start) <= abs(w[0] + start) else -w

    def wrap(self, w: np.ndarray) -> np.ndarray:
        """(..., 2) float: points of places w."""
        z = self.focus + self.scale * self.turn * w**2
        return np.stack([z.real, z.imag], axis=-1)


def unwrapped(front: np.ndarray, wake: int, focus: np.ndarray, downstream: np.ndarray, base: int = 0) -> Unwrapped:
    """Open a front into the half plane.

    Parameters
    ----------
    front : (n, 2) float
        Wake to the trailing edge, clockwise round the section, and the wake again.
    wake : int
        Cells of the wake; its points stand at both ends of the front.
    focus : (2,) float
        A point inside the nose.
    downstream : (2,) float
        Vector from the nose to the trailing edge.
    base : int
        Cells between the trailing edge and each corner of a blunt base.
    """
    scale = float(np.linalg.norm(downstream))
    turn = complex(*downstream) / scale
    found = Unwrapped(complex(*focus), scale, turn, *(np.empty(0),) * 4, 0)
    w = found.unwrap(front, -1.0 + 0j)
    n = len(w)
    places = np.column_stack([w.real, w.imag])
    edge = np.diff(w)
    heading = np.unwrap(np.angle(edge))
    heading -= 2 * np.pi * np.round(heading[len(heading) // 2] / (2 * np.pi))
    normal = np.exp(1j * (0.5 * (np.append(heading[0], heading) + np.append(heading, heading[-1])) + np.pi / 2))
    straight = wake + base + 1 if base else wake  # shifts turn the lines of a base
    normal[:straight] = normal[n - straight :] = 1j
    length = arc_length(places)
    corners = np.array([wake, wake + base, n - 1 - wake - base, n - 1 - wake])
    reach = np.min(np.abs(length[:, None] - length[corners]), axis=1)
    steps = np.diff(length)
    reach = np.maximum(reach, np.minimum(np.append(steps, steps[-1]), np.append(steps[0], steps)))
    shift = _shifts(w, wake, base) if base else np.zeros(n)
    nose = wake + base + int(np.argmin(np.abs(w.real[wake + base : n - wake - base])))
    return Unwrapped(found.focus, scale, turn, w, normal, reach, shift, nose)


def _shifts(w: np.ndarray, wake: int, base: int) -> np.ndarray:
    """(n,) float: shifts of the lines, positive to the right, of both halves."""
    n = len(w)
    shift = np.zeros(n)
    for order, side in ((np.arange(n), 1.0), (np.arange(n)[::-1], -1.0)):
        tail, corner = order[n - 1 - wake], order[n - 1 - wake - base]
        most = _SHIFT * abs(w[corner] - w[tail])
        least = _AT_CORNER * most
        x = side * w.real[order]
        before = np.arange(n) < n - 1 - wake - base
        after = np.arange(n) > n - 1 - wake
        share = np.clip((np.arange(n) - (n - 1 - wake - base)) / base, 0, 1)
        own = least + (most - least) * share
        own[before] = least * np.exp(-np.abs(x[before] - x[n - 1 - wake - base]) / (_FADE * least))
        own[after] = most * np.exp(-(x[after] - x[n - 1 - wake]) / (_FADE * most))
        half = np.arange(n) >= n // 2
        shift[order[half]] = side * own[half]
    return shift


def paths(of: Unwrapped, outer: np.ndarray, bend: float, t: np.ndarray) -> np.ndarray:
    """(n, m) complex: points of the lines from the front to the far field.

    Parameters
    ----------
    of : Unwrapped
        The front.
    outer : (n,) complex
        Where the lines end.
    bend : float
        Largest distance over which a line turns away from its normal.
    t : (n, m) float
        From 0 at the front to 1 at the far field.
    """
    start, stop = of.front[:, None], outer[:, None]
    d = t * (stop.imag - start.imag)
    # Lines x = const of the plane are hyperbolas xi^2 - eta^2 = const here, which the lines become at the outflow.
    downstream = np.clip((np.abs(start.real) - 1) / np.maximum(np.abs(start.real[[0, -1]]).min() - 1, 1e-9), 0, 1)
    rise = ((start.imag + d) ** 2 - start.imag**2) / (stop.imag**2 - start.imag**2)
    share = (1 - downstream) * t**2 + downstream * rise
    xi = np.sign(stop.real) * np.sqrt(np.maximum(start.real**2 * (1 - share) + stop.real**2 * share, 0))
    xi = np.where(stop.real * start.real < 0, start.real + (stop.real - start.real) * t**2, xi)
    fading = (1 - t) ** 2
    w = xi + 1j * (start.imag + d)
    b = np.minimum(of.reach, bend)[:, None]
    w = w + fading * (d * b / (d + b)) * (of.normal[:, None] - 1j)
    most = np.abs(of.shift).max(initial=0.0)
    return w + (fading * of.shift[:, None] * d / (d + 0.5 * most) if most else 0.0)
