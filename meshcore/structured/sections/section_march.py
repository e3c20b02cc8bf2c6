"""Marching grids round sections: heights of the transfinite grid, lines as the march finds them."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...geometry.curves import arc_length
from ...geometry.plane import Plane
from ...progress import Progress, part_of
from ..folds import FLAT
from ..marching import hyperbolic_march, parabolic_march
from ..marching.fronts import changes_told
from ..marching.hyperbolic_march import Marched
from ..marching.march_stops import Stop
from ..marching.marching_ends import End, OnCurve
from .lines_out import lengths_along
from .section_result import scaled_jacobians

PART = 0.25
"""Of the way to a far field that is to be met: from there on hyperbolic lines are drawn onto it."""
_PASSES, _MOST, _CORRECTED = 6, 3.0, 10
"""Times that first heights are corrected, the largest factor, and over how many layers it fades."""
_EQUATIONS = "the elliptic equations took its place"
_ARRIVES = "the hyperbolic one took its place, and the far field is where that arrives"


Onto = Callable[[np.ndarray], np.ndarray]


class Lines(NamedTuple):
    """Lines of a grid round a section.

    Attributes
    ----------
    method : str
        What is still to be done, or was: "elliptic" if no march could reach the end.
    points : (n, layers + 1, 2) float
        The lines, which the elliptic equations start from.
    warnings : list of str
        What had to be done, and where a march stopped.
    counts : dict
        For the report: what a march did otherwise than asked, as `hyperbolic` counts it.
    """

    method: str
    points: np.ndarray
    warnings: list[str]
    counts: dict[str, int]


def lines_by(
    method: str,
    points: np.ndarray,
    *,
    closed: bool,
    plane: Plane,
    progress: Progress,
    kept: int = 0,
    bound: bool = True,
    onto: Onto | None = None,
) -> Lines:
    """The lines of a method in place of transfinite ones, and those of a march where transfinite ones cross.

    Parameters
    ----------
    method : {"transfinite", "elliptic", "hyperbolic", "parabolic"}
        What is asked for. A hyperbolic march goes as far as the heights of the layers take it; where it has to stop,
        the parabolic one, which ends on the far field, takes its place.
    points : (n, layers + 1, 2) float
        The transfinite grid; the front at j = 0 runs clockwise round the section. If closed the last line is the first.
    closed : bool
        Whether the front is.
    plane : Plane
        Where points lie in space, which is where users are told that a march stopped.
    progress : Progress
        Called with fraction and message.
    kept : int
        Layers of the transfinite grid that stay; a march that is asked for goes on from the last of them.
    bound : bool
        Whether lines have to end on the far field. If not, a hyperbolic march is tried where the parabolic one stops.
    onto : callable, optional
        From where a hyperbolic march arrives to points of the far field, if it is to be met.
    """
    found = _by(method, points, closed, plane, progress, kept, onto)
    tried = method == "hyperbolic" and onto is None
    if bound or tried or found.method != "elliptic" or not found.warnings:
        return found
    marched = _marched(points, "hyperbolic", closed, plane, progress, kept)
    if marched.method != "hyperbolic":
        return found
    told = [text.replace(_EQUATIONS, _ARRIVES) for text in found.warnings]
    return marched._replace(
        method="elliptic" if method == "elliptic" else "hyperbolic", warnings=[*told, *marched.warnings]
    )


def _by(
    method: str, points: np.ndarray, closed: bool, plane: Plane, progress: Progress, kept: int, onto: Onto | None
) -> Lines:
    """As `lines_by`; "elliptic" with warnings if no march has reached the far field."""
    if method in ("hyperbolic", "parabolic"):
        return _marched(points, method, closed, plane, progress, kept, onto)
    crossed = int((scaled_jacobians(points) <= FLAT).sum())
    if not crossed:
        return Lines(method, points, [], {})
    found = _marched(points, "parabolic", closed, plane, progress, 0)
    if found.method == "elliptic":
        return found._replace(warnings=[f"lines crossed in {crossed} cells", *found.warnings])
    if method == "elliptic":
        return Lines(method, found.points, [], {})
    return found._replace(
        method=method,
        warnings=[f"lines crossed in {crossed} cells; the parabolic march took their place", *found.warnings],
    )


def _marched(
    points: np.ndarray,
    method: str,
    closed: bool,
    plane: Plane,
    progress: Progress,
    kept: int,
    onto: Onto | None = None,
) -> Lines:
    """A marched grid in place of a transfinite one, whose front, heights and far field it takes.

    If no march could reach the end it is the transfinite one, for the elliptic equations.
    """
    lines = points[:-1] if closed else points
    steps = np.linalg.norm(np.diff(lines, axis=1), axis=-1)[:, kept:]
    front = lines[:, kept]
    warnings: list[str] = []
    ends = (OnCurve(points[0, kept:]), OnCurve(points[-1, kept:]))
    if not kept:
        steps = heights_for_march(front, steps, closed, ends)
    if method == "hyperbolic":
        found = hyperbolic_march.marched(front, steps.T, closed=closed, ends=ends, progress=part_of(progress, 0.0, 0.5))
        if found.stop is None and onto is not None:
            found = _drawn(found, onto, None if closed else points[[0, -1], kept:])
        elif found.stop is None and not closed:
            found = found._replace(points=_ends_in_line(found.points))
        if found.stop is None:
            return _whole(method, points, found, kept, closed, warnings)
        warnings.append(f"the hyperbolic march {stop_told(found.stop, plane)}; the parabolic one took its place")
    fractions = np.concatenate([np.zeros((1, len(lines))), np.cumsum(steps, axis=1).T])
    fractions /= fractions[-1]
    fractions[-1] = 1.0
    found = parabolic_march.marched(
        front,
        lines[:, -1],
        fractions,
        closed=closed,
        sides=(None, None) if closed else (points[0, kept:], points[-1, kept:]),
        progress=part_of(progress, 0.5, 1.0),
    )
    if found.stop is None:
        return _whole(method, points, found, kept, closed, warnings)
    stopped = f"the parabolic march {stop_told(found.stop, plane)}; {_EQUATIONS}"
    return Lines("elliptic", points, [*warnings, stopped], {})


def _ends_in_line(points: np.ndarray) -> np.ndarray:
    """Lines along outflows as high as their neighbours, beyond the first layer; they alone have the heights asked for.

    Inside, a front's dissipation shares heights between neighbours. A straight line takes no part in that, and all
    layers would bend in the last column.
    """
    points = points.copy()
    for line, neighbour in ((0, 1), (-1, -2)):
        height, beside = lengths_along(points[[line, neighbour]])
        share = beside[1:] / height[1:] * (height[1] / beside[1])
        points[line, 1:] = points[line, 0] + share[:, None] * (points[line, 1:] - points[line, 0])
    return points


def _drawn(march: Marched, onto: Onto, sides: np.ndarray | None) -> Marched:
    """The march with its layers beyond a part of the way drawn onto the far field, by the parabolic scheme."""
    length = lengths_along(march.points)
    mean, layers = length.mean(axis=0), length.shape[1] - 1
    some = int(np.clip(np.searchsorted(mean / mean[-1], PART) - 1, 0, layers - 1))
    front, steps = march.points[:, some], (length[:, some:] - length[:, some : some + 1]).T
    ends = (None, None) if sides is None else (beyond(sides[0], front[0]), beyond(sides[1], front[-1]))
    outside = parabolic_march.marched(
        front, onto(march.points[:, -1]), steps / steps[-1], closed=sides is None, sides=ends
    )
    stop = None if outside.stop is None else outside.stop._replace(layer=outside.stop.layer + some)
    points = np.concatenate([march.points[:, :some], outside.points], axis=1)
    return march._replace(points=points, stop=stop)


def beyond(end: np.ndarray, start: np.ndarray) -> np.ndarray:
    """The part of inflow or outflow beyond a point of it."""
    length = arc_length(end)
    edge, away = np.diff(end, axis=0), start - end[:-1]
    share = np.clip((edge * away).sum(axis=1) / (edge**2).sum(axis=1), 0, 1)
    k = int(np.argmin(np.linalg.norm(away - share[:, None] * edge, axis=1)))
    rest = end[k + 1 :]
    near = np.linalg.norm(rest - start, axis=1) > 1e-9 * length[-1]
    return np.vstack([start, rest[near]])


def layers_within(points: np.ndarray, line: int, reach: float, left: int) -> int:
    """Layers of a transfinite grid up to a distance along one of its lines, ``left`` of which stay; 0 if unsound."""
    height = np.linalg.norm(points[line] - points[line, 0], axis=1)
    past = int(np.clip(np.searchsorted(height, reach), 2, len(height) - left))
    return past if (scaled_jacobians(points[:, : past + 1]) > FLAT).all() else 0


def heights_for_march(front: np.ndarray, steps: np.ndarray, closed: bool, ends: tuple[End, End]) -> np.ndarray:
    """(n, layers) heights that make the march's first layer as high as the first of those given.

    A march holds areas, and on coarse points, where the front turns by many degrees from edge to edge, an area is not
    length times height. What is lacking in the first layer is added there and, less and less, to the next ones.
    """
    layers = steps.shape[1]
    factor = np.ones(len(steps))
    for _ in range(_PASSES):
        first = (factor * steps[:, 0])[None]
        found = hyperbolic_march.marched(front, first, closed=closed, ends=ends)
        if found.stop is not None:
            return steps
        reached = np.linalg.norm(found.points[:, 1] - found.points[:, 0], axis=1)
        factor = np.clip(factor * steps[:, 0] / reached, 1 / _MOST, _MOST)
    return steps * factor[:, None] ** np.maximum(0, 1 - np.arange(layers) / _CORRECTED)


def _whole(method: str, points: np.ndarray, found: Marched, kept: int, closed: bool, warnings: list[str]) -> Lines:
    """The lines of a march that reached the end, on the layers that are kept."""
    made = np.concatenate([found.points, found.points[:1]]) if closed else found.points
    counts, changed = changes_told(found)
    return Lines(method, np.concatenate([points[:, :kept], made], axis=1), [*warnings, *changed], counts)


def stop_told(stop: Stop, plane: Plane) -> str:
    """Where and why a march stopped that is in a plane; the number of the front's point would tell users nothing."""
    x, y, z = plane.to_space(stop.place[None])[0]
    concave = f", where the front is concave by {stop.concavity:.0f} degrees" if stop.concavity > 1 else ""
    return f"stopped at layer {stop.layer} near ({x:.6g}, {y:.6g}, {z:.6g}), as {stop.reason}{concave}"
