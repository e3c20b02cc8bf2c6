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

from ...geometry.curves import arc_length

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
    shift : (2, n) float
        How far lines are moved downstream beside a blunt base, and how late, as `shifts_beyond` says.
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
    normal = normals(places)
    straight = wake + base + 1 if base else wake  # shifts turn the lines of a base
    normal[:straight] = normal[n - straight :] = 1j
    reach = free_reach(places, np.array([wake, wake + base, n - 1 - wake - base, n - 1 - wake]))
    shift = _shifts(w, wake, base) if base else np.zeros((2, n))
    nose = wake + base + int(np.argmin(np.abs(w.real[wake + base : n - wake - base])))
    return Unwrapped(found.focus, scale, turn, w, normal, reach, shift, nose)


def _shifts(w: np.ndarray, wake: int, base: int) -> np.ndarray:
    """(2, n) float: shifts of the lines, positive to the right, of both halves, and how late they come."""
    n = len(w)
    places = np.column_stack([w.real, w.imag])
    shift = shifts_beyond(places, n - 1 - wake - base, n - 1 - wake)
    other = shifts_beyond(places[::-1] * [-1, 1], n - 1 - wake - base, n - 1 - wake)[:, ::-1]
    shift[:, : n // 2] = other[:, : n // 2] * [[-1], [1]]
    return shift


def shifts_beyond(front: np.ndarray, corner: int, tail: int) -> np.ndarray:
    """How far lines of a front that steps down at its rear are moved along x, so that they fan out.

    Parameters
    ----------
    front : (n, 2) float
        A wall up to its corner, the step down to the tail, and a wake, all with growing x.
    corner, tail : int
        Numbers of the points where the step begins and ends.

    Returns
    -------
    (2, n) float
        The shifts, growing over the step, and fading to both sides slower than x grows; and how late in their rise
        they come, from 0 on the step to 1 away from it, where lines shall leave without leaning.
    """
    x, number = front[:, 0], np.arange(len(front))
    room = x[-1] - x[tail]
    most = min(_SHIFT * float(np.linalg.norm(front[corner] - front[tail])), 0.5 * room)
    least = _AT_CORNER * most
    length = arc_length(front[corner : tail + 1])
    shift = least * np.exp(-np.abs(x - x[corner]) / (_FADE * least))
    shift[corner : tail + 1] = least + (most - least) * length / length[-1]
    after = number > tail
    gone = x[after] - x[tail]
    shift[after] = most * np.exp(-gone / (_FADE * most)) * (1 - gone / room)
    late = np.clip(2 - 2 * shift / np.where(after, most, least), 0, 1)
    late[corner : tail + 1] = 0.0
    return np.array([shift, late])


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
    return xi + 1j * (start.imag + d) + leaving(of.normal, of.reach, of.shift, bend, d) * (1 - t) ** 2


def leaving(normal: np.ndarray, reach: np.ndarray, shift: np.ndarray, bend: float, d: np.ndarray) -> np.ndarray:
    """(n, m) complex: what lines are moved by so that they leave along their normals, instead of upwards.

    Parameters
    ----------
    normal : (n,) complex
        Unit normals of the front.
    reach : (n,) float
        Distance to the nearest corner.
    shift : (2, n) float
        How far lines are moved sideways in the end, and how late.
    bend : float
        Largest distance over which a line turns away from its normal.
    d : (n, m) float
        Heights over the front.
    """
    b = np.minimum(reach, bend)[:, None]
    amount, late = shift[0][:, None], shift[1][:, None]
    most = np.abs(amount).max(initial=0.0)
    rise = d / (d + 0.5 * most) if most else 0.0
    moved = amount * rise * (1 - late + late * rise)
    return d * b / (d + b) * (normal[:, None] - 1j) + moved


def normals(places: np.ndarray) -> np.ndarray:
    """(n,) complex: unit normals to the left of a curve, between those of the edges at each point."""
    heading = np.unwrap(np.angle(np.diff(places[:, 0] + 1j * places[:, 1])))
    mean = 0.5 * (np.append(heading[0], heading) + np.append(heading, heading[-1]))
    return 1j * np.exp(1j * mean)


def free_reach(places: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """(n,) float: distance along a curve to the nearest of some points, at least the nearest edge."""
    length = arc_length(places)
    steps = np.diff(length)
    nearest = np.minimum(np.append(steps, steps[-1]), np.append(steps[0], steps))
    return np.maximum(np.min(np.abs(length[:, None] - length[corners]), axis=1), nearest)
