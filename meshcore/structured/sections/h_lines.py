"""Lines of H-grids by interpolation: off the front at right angles, and on to the far field."""

from __future__ import annotations

import numpy as np

from ...geometry.curves import arc_length
from ...sizing import geometric
from .h_regions import Region
from .lines_out import geometric_lines
from .respacing import respaced
from .section_result import scaled_jacobians
from .spreading import SOUND, SPREADS, WORSE
from .unwrapped import free_reach, leaving, normals, shifts_beyond

_BENDS = (0.3, 0.1, 0.03)
_ROUND = 0.2
"""Width, in heights, over which layers share what lines lack that fan out at a thin edge; they would zigzag."""


def interpolated(region: Region, height: float, layers: int | None, growth: float) -> np.ndarray:
    """(n, layers + 1, 2) points of lines that leave the front along its normals and end on the far field's top.

    Lines beside a step of the section fan out. They go up to a top that may bend; where inflow and outflow do, lines
    ahead of the section and behind it bend with them.

    Parameters
    ----------
    region : Region
        To be filled.
    height : float
        Of the first points over the front.
    layers : int, optional
        Cells of each line, by default as many as growth needs.
    growth : float
        Largest growth of the heights, if ``layers`` is left out.
    """
    front = region.front
    normal, shifts = _leaving(region)
    free = free_reach(front, np.unique([region.nose, region.first, region.last, region.tail]))
    w, up = front[:, 0] + 1j * front[:, 1], np.full(len(front), 1j)
    share = (front[:, 0] - front[0, 0]) / (front[-1, 0] - front[0, 0])
    top = on_top(region, np.clip(share, 0, 1))[:, 1]
    chord, still = float(np.ptp(front[region.nose : region.tail + 1, 0])), np.zeros((2, len(front)))

    def lines(t: np.ndarray, bend: float, moved: list[np.ndarray]) -> np.ndarray:
        d = t * (top - w.imag)[:, None]
        turned = leaving(normal, free, still, bend * chord, d) * (1 - t) ** 2
        # Lines that begin above each other stay side by side up to the far field.
        found = w[:, None] + 1j * d + turned + sum(leaving(up, free, shift, bend * chord, d) for shift in moved)
        return np.stack([found.real, found.imag], axis=-1)

    levels = np.broadcast_to(np.concatenate([[0.0], np.geomspace(1e-4, 1, 24)]), (len(w), 25))
    worst = [scaled_jacobians(lines(levels, bend, shifts)).min() for bend in _BENDS]
    bend = _BENDS[int(np.argmax(worst))]
    # Beside steps lines that are moved sideways take the levels of lines that are not.
    t, _ = geometric_lines(lambda t: lines(t, bend, []), np.full(len(w), height), layers, growth)
    points = lines(t, bend, shifts)
    points[:, 0] = front
    return _onto_far_field(region, points, t, height)


def _leaving(region: Region) -> tuple[np.ndarray, list[np.ndarray]]:
    """(n,) complex normals, upright before and behind the steps, and how far the lines beside each step are shifted."""
    front, n = region.front, len(region.front) - 1
    nose, first, last, tail = region.nose, region.first, region.last, region.tail
    shifts = []
    if last < tail:
        shifts.append(shifts_beyond(front, last, tail))
    if first > nose:
        shifts.append(shifts_beyond(front[::-1] * [-1, 1], n - first, n - nose)[:, ::-1] * [[-1], [1]])
    for amount, _ in shifts:
        amount[[0, -1]] = 0.0
    normal = normals(front)
    normal[: first + (first > nose)] = normal[last + (last == tail) :] = 1j
    return normal, shifts


def on_top(region: Region, share: np.ndarray) -> np.ndarray:
    """(n, 2) points of the far field's top at shares of its length."""
    return _at(region.top, share)


def _at(line: np.ndarray, share: np.ndarray) -> np.ndarray:
    length = arc_length(line)
    return np.column_stack([np.interp(share, length / length[-1], x) for x in line.T])


def _onto_far_field(region: Region, points: np.ndarray, t: np.ndarray, height: float) -> np.ndarray:
    """Lines moved so that the first and the last are inflow and outflow and all end on the top.

    The moves of both ends fade towards the section, that of the top, like the square of the height, towards the front.
    """
    x, nose, tail = region.front[:, 0], region.nose, region.tail
    ahead = np.clip(1 - (x - x[0]) / (x[nose] - x[0]), 0, 1)[:, None, None] ** 2
    behind = np.clip(1 - (x[-1] - x) / (x[-1] - x[tail]), 0, 1)[:, None, None] ** 2
    layers = t.shape[1] - 1
    moved = ahead * (line_up(region.left, height, layers) - points[0])
    moved = moved + behind * (line_up(region.right, height, layers) - points[-1])
    top = on_top(region, np.clip((points[:, -1, 0] - x[0]) / (x[-1] - x[0]), 0, 1)) - points[:, -1] - moved[:, -1]
    return points + moved + t[..., None] ** 2 * top[:, None]


def line_up(end: np.ndarray, height: float, layers: int) -> np.ndarray:
    """(layers + 1, 2) points of inflow or outflow, from the front on, of which the first is this high."""
    return _at(end, geometric(layers, first=min(height / arc_length(end)[-1], 1 / layers)))


def steps_up(region: Region, target: np.ndarray, height: float, layers: int) -> np.ndarray:
    """(n, layers) heights of layers from the front to points of the top, each line's growing by one factor."""
    reach = np.linalg.norm(target - region.front, axis=1)
    return np.diff([geometric(layers, first=min(height / length, 1 / layers)) for length in reach]) * reach[:, None]


def evenly_growing(region: Region, points: np.ndarray, height: float, fanned: bool) -> np.ndarray:
    """Lines with points on them whose first heights are as asked and grow evenly, unless cells get much worse.

    Parameters
    ----------
    region : Region
        Which they fill.
    points : (n, layers + 1, 2) float
        The lines, inflow and outflow first and last.
    height : float
        Of the first points.
    fanned : bool
        Whether a march goes on from layers round a thin flat front or rear.
    """
    heights = np.full(len(points), height)
    least = min(WORSE * scaled_jacobians(points).min(), SOUND)
    for spread in (_ROUND, *SPREADS[1:]) if fanned else SPREADS:
        found = respaced(points, heights, slice(region.nose, region.tail + 1), spread)
        if found is None:
            continue
        for line, end in ((0, region.left), (-1, region.right)):
            found[line] = _onto_line(found[line], end)
        if scaled_jacobians(found).min() > least:
            return found
    return points


def _onto_line(points: np.ndarray, line: np.ndarray) -> np.ndarray:
    """The nearest points of a polyline."""
    start, edge = line[:-1], np.diff(line, axis=0)
    away = points[:, None] - start
    share = np.clip((away * edge).sum(axis=2) / (edge**2).sum(axis=1), 0, 1)
    near = start + share[..., None] * edge
    best = np.argmin(np.linalg.norm(points[:, None] - near, axis=2), axis=1)
    return near[np.arange(len(points)), best]
