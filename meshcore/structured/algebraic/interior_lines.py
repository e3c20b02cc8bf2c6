"""Lines inside a patch that become coordinate lines: where their ends meet the sides, and where they cross."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...errors import InvalidGeometry, InvalidInput
from ...geometry.curves import Curve, arc_length, chains, polyline, resampled
from ...mesh import Mesh
from ..limits import check_extent
from .sides import Sides, fractions_of

Lines = Mesh | Sequence[Curve]
_PLACES = {"i": ("south", "north"), "j": ("west", "east")}


@dataclass(frozen=True, eq=False)
class Line:
    """A line from south to north (it will have one i), or from west to east (one j).

    Attributes
    ----------
    number : int
        Which of the given lines it is.
    points : (n, 3) float
        In the direction of i or j.
    axis : {"i", "j"}
        Whose coordinate is constant along it.
    meets : (float, float)
        Fractions of the lengths of the two sides where its ends are.
    station : int
        The coordinate, -1 as long as it is not chosen.
    """

    number: int
    points: np.ndarray
    axis: str
    meets: tuple[float, float]
    station: int = -1


def read_lines(lines: Lines, sides: Sides) -> list[Line]:
    """The given lines, each with the pair of sides that it connects.

    Raises
    ------
    InvalidGeometry
        If a line does not end on opposite sides.
    """
    if isinstance(lines, Mesh):
        curves = [lines.points[chain] for chain in chains(lines)]
    else:
        curves = [polyline(curve, "lines") for curve in lines]
    for curve in curves:
        check_extent(curve, parameter="lines")
    found = [_connecting(number, points, sides) for number, points in enumerate(curves)]
    return sorted(found, key=lambda line: (line.axis, sum(line.meets)))


def _connecting(number: int, points: np.ndarray, sides: Sides) -> Line:
    best: tuple[float, Line] | None = None
    for axis, (low, high) in _PLACES.items():
        for run in (points, points[::-1]):
            near = [nearest(run[end], sides.lines[place]) for end, place in ((0, low), (-1, high))]
            gap = max(distance for _, distance in near)
            if best is None or gap < best[0]:
                best = gap, Line(number, run, axis, (near[0][0], near[1][0]))
    gap, line = best
    if gap > sides.gap:
        raise InvalidGeometry(
            f"line {number} does not connect opposite sides: an end is {gap:.6g} away; "
            "extend or trim it to the sides, or raise tolerance",
            parameter="lines",
        )
    inside = 1e-9
    if not all(inside < meet < 1 - inside for meet in line.meets):
        raise InvalidGeometry(
            f"line {number} ends in a corner of the patch; it must meet the sides between their ends", parameter="lines"
        )
    return line


def nearest(point: np.ndarray, line: np.ndarray) -> tuple[float, float]:
    """Where a polyline is nearest to a point, as a fraction of its length, and how far that is.

    Examples
    --------
    >>> nearest(np.array([1.0, 2, 0]), np.array([[0.0, 0, 0], [4, 0, 0]]))
    (0.25, 2.0)
    """
    along = np.diff(line, axis=0)
    square = (along**2).sum(axis=1)
    at = np.clip(((point - line[:-1]) * along).sum(axis=1) / np.where(square > 0, square, 1.0), 0, 1)
    away = np.linalg.norm(line[:-1] + at[:, None] * along - point, axis=1)
    k = int(np.argmin(away))
    length = arc_length(line)
    return float((length[k] + at[k] * (length[k + 1] - length[k])) / length[-1]), float(away[k])


def stationed(lines: list[Line], fractions: dict[str, np.ndarray]) -> list[Line]:
    """The lines with their stations: the points of the sides next to their ends, in order.

    Raises
    ------
    InvalidInput
        If there are more lines than points between the ends of a side.
    InvalidGeometry
        If lines meet one side in another order than the opposite one.
    """
    done = []
    for axis, places in _PLACES.items():
        own = [line for line in lines if line.axis == axis]
        meets = np.array([line.meets for line in own])
        if len(own) > 1 and (np.diff(meets, axis=0) <= 0).any():
            k = int(np.argwhere(np.diff(meets, axis=0) <= 0)[0][0])
            raise InvalidGeometry(
                f"lines {own[k].number} and {own[k + 1].number} cross, or meet a side at one place; move them apart",
                parameter="lines",
            )
        mean = np.mean([fractions[place] for place in places], axis=0)
        if len(own) > len(mean) - 2:
            raise InvalidInput(
                f"has {len(mean) - 1} cells, too few for {len(own)} lines inside; give more", parameter=f"cells_{axis}"
            )
        previous = 0
        for k, line in enumerate(own):
            last = len(mean) - 1 - (len(own) - k)
            free = np.arange(previous + 1, last + 1)
            previous = int(free[np.argmin(np.abs(mean[free] - np.mean(line.meets)))])
            done.append(replace(line, station=previous))
    return done


def bent(fractions: np.ndarray, stations: Sequence[int], wanted: Sequence[float], tolerance: float) -> np.ndarray:
    """Fractions changed smoothly so that they have wanted values at stations; the same if they have them already.

    Examples
    --------
    >>> bent(np.array([0, 0.25, 0.5, 1]), [2], [0.6], 1e-6).round(3)
    array([0.   , 0.327, 0.6  , 1.   ])
    """
    from scipy.interpolate import PchipInterpolator  # half a second, which not every start should take

    wanted = np.asarray(wanted, float)
    if not len(wanted) or np.abs(fractions[list(stations)] - wanted).max() <= tolerance:
        return fractions
    old = np.concatenate([[0.0], fractions[list(stations)], [1.0]])
    new = PchipInterpolator(old, np.concatenate([[0.0], wanted, [1.0]]))(fractions)
    new[0], new[-1] = 0.0, 1.0
    new[list(stations)] = wanted
    return new


def fitted_sides(
    sides: Sides, fractions: dict[str, np.ndarray | None], lines: list[Line], free: dict[str, bool]
) -> tuple[dict[str, np.ndarray | None], list[Line]]:
    """Fractions with which the sides have points where the lines end, and the lines with their stations.

    Parameters
    ----------
    sides : Sides
        As given.
    fractions : dict of str to (n,) float or None
        Wanted on each side; None where a side keeps its points.
    lines : list of Line
        From `read_lines`.
    free : dict of str to bool
        Whether the sides across "i" and "j" may have their points moved.

    Raises
    ------
    InvalidGeometry
        If a line ends between the points of a side that keeps them.
    """
    whole = {p: fractions_of(sides.lines[p]) if f is None else f for p, f in fractions.items()}
    lines = stationed(lines, whole)
    fitted = dict(fractions)
    for axis, places in _PLACES.items():
        own = [line for line in lines if line.axis == axis]
        for end, place in enumerate(places):
            tolerance = sides.gap / arc_length(sides.lines[place])[-1] + 1e-12
            new = bent(whole[place], [line.station for line in own], [line.meets[end] for line in own], tolerance)
            if new is whole[place]:
                continue
            if not free[axis]:
                off = [abs(whole[place][line.station] - line.meets[end]) for line in own]
                raise InvalidGeometry(
                    f"line {own[int(np.argmax(off))].number} ends between two points of {sides.names[place]}; "
                    f"end it at a point, or give cells_{axis} to move the points",
                    parameter="lines",
                )
            fitted[place] = new
    return fitted, lines


def fitted_lines(lines: list[Line], sides: Sides) -> dict[str, dict[int, np.ndarray]]:
    """By axis and station, the points of each line: as many as the sides have, equal to them and to each other.

    Raises
    ------
    InvalidGeometry
        If lines of different axes do not meet.
    """
    length = {line.number: arc_length(line.points)[-1] for line in lines}
    crossings = {(a.number, b.number): _crossing(a, b, sides.gap) for a in lines for b in lines if a.axis < b.axis}
    found: dict[str, dict[int, np.ndarray]] = {"i": {}, "j": {}}
    for line in lines:
        across = [other for other in lines if other.axis != line.axis]
        wanted = [
            crossings[line.number, o.number][0] if line.axis == "i" else crossings[o.number, line.number][1]
            for o in across
        ]
        low, high = (sides.lines[place] for place in _PLACES["j" if line.axis == "i" else "i"])
        count = len(low)
        mine = fractions_of(line.points)
        if len(line.points) != count:
            share = float(np.mean(line.meets))
            mine = (1 - share) * fractions_of(low) + share * fractions_of(high)
        new = bent(mine, [o.station for o in across], wanted, sides.gap / length[line.number] + 1e-12)
        keeps = len(line.points) == count and new is mine
        points = line.points.copy() if keeps else resampled(line.points, new)
        ends = (sides.lines[place][line.station] for place in _PLACES[line.axis])
        points[0], points[-1] = ends
        found[line.axis][line.station] = points
    for i, column in found["i"].items():
        for j, row in found["j"].items():
            row[i] = column[j]
    return found


def _crossing(a: Line, b: Line, gap: float) -> tuple[float, float]:
    """Fractions of the lengths of two lines where they are nearest to each other."""
    fraction_a, fraction_b, distance = nearest_approach(a.points, b.points)
    if distance > gap:
        raise InvalidGeometry(
            f"lines {a.number} and {b.number} pass each other at a distance of {distance:.6g}; "
            "let them cross, or raise tolerance",
            parameter="lines",
        )
    return fraction_a, fraction_b


def nearest_approach(a: np.ndarray, b: np.ndarray) -> tuple[float, float, float]:
    """Where two polylines are nearest, as fractions of their lengths, and their distance there.

    Examples
    --------
    >>> nearest_approach(np.array([[0.0, 0, 0], [4, 0, 0]]), np.array([[1.0, -1, 0], [1, 1, 0]]))
    (0.25, 0.5, 0.0)
    """
    u, v = np.diff(a, axis=0)[:, None], np.diff(b, axis=0)[None]
    w = a[:-1, None] - b[None, :-1]
    uu, vv, uv = (u * u).sum(-1), (v * v).sum(-1), (u * v).sum(-1)
    uw, vw = (u * w).sum(-1), (v * w).sum(-1)
    uu, vv = np.where(uu > 0, uu, 1.0), np.where(vv > 0, vv, 1.0)
    determinant = uu * vv - uv**2
    parallel = determinant <= 1e-14 * uu * vv
    s = np.clip(np.where(parallel, 0.0, (uv * vw - vv * uw) / np.where(parallel, 1.0, determinant)), 0, 1)
    t = np.clip((uv * s + vw) / vv, 0, 1)
    s = np.clip((uv * t - uw) / uu, 0, 1)
    away = np.linalg.norm(w + s[..., None] * u - t[..., None] * v, axis=-1)
    k, m = np.unravel_index(np.argmin(away), away.shape)
    fractions = []
    for line, segment, at in ((a, k, s[k, m]), (b, m, t[k, m])):
        length = arc_length(line)
        fractions.append(float((length[segment] + at * (length[segment + 1] - length[segment])) / length[-1]))
    return fractions[0], fractions[1], float(away[k, m])
