"""Lines of H-grids that march off the front, hyperbolic ones onto the far field by the parabolic scheme."""

from __future__ import annotations

import numpy as np

from ...geometry.curves import arc_length
from ...progress import Progress, part_of
from ...sizing import geometric
from ..folds import FLAT
from ..marching import hyperbolic_march, parabolic_march
from ..marching.fronts import changes_told
from ..marching.march_stops import Stop
from ..marching.marching_ends import OnCurve
from .h_lines import on_top, steps_up
from .h_regions import Region
from .section_march import PART, Lines, beyond, heights_for_march, layers_within, stop_told
from .section_result import scaled_jacobians

_THIN = 0.02
"""Of the chord: flat fronts and rears below are rounded by interpolated layers, as marches do not see their corners."""
_PAST = 3.0
"""Heights over the section, in those of its flat front or rear, up to which these layers reach."""


def lines_of(method: str, region: Region, points: np.ndarray, height: float, kept: int, progress: Progress) -> Lines:
    """The lines of a method in place of interpolated ones, and those of a march where interpolated ones cross.

    Parameters
    ----------
    method : {"transfinite", "elliptic", "hyperbolic", "parabolic"}
        What is asked for. Elliptic lines start from the parabolic march, which leaves the front at right angles.
    region : Region
        To be filled.
    points : (n, layers + 1, 2) float
        The interpolated lines.
    height : float
        Of the first points.
    kept : int
        Interpolated layers that a march goes on from, as `past_base` has them.
    progress : Progress
        Called with fraction and message.

    Returns
    -------
    Lines
        Of the method "elliptic" if no march could reach the far field.
    """
    crossed = int((scaled_jacobians(points) <= FLAT).sum())
    if method == "transfinite" and not crossed:
        return Lines(method, points, [], {})
    found = _marched("hyperbolic" if method == "hyperbolic" else "parabolic", region, points, height, kept, progress)
    if method == "transfinite":
        told = f"lines crossed in {crossed} cells"
        if found.method == "elliptic":
            return found._replace(warnings=[told, *found.warnings])
        return found._replace(
            method=method, warnings=[f"{told}; the parabolic march took their place", *found.warnings]
        )
    return found._replace(method="elliptic", warnings=[]) if method == "elliptic" else found


def past_base(region: Region, points: np.ndarray) -> int:
    """Interpolated layers that marches and smoothing keep: those that round a thin flat front or rear, if sound."""
    chord = region.front[region.tail, 0] - region.front[region.nose, 0]
    if not 0 < region.base < _THIN * chord or points.shape[1] < 5:
        return 0
    return layers_within(points, (region.first + region.last) // 2, _PAST * region.base, 3)


def _marched(method: str, region: Region, points: np.ndarray, height: float, kept: int, progress: Progress) -> Lines:
    """Lines of a march from the last of the layers that are kept; if none reaches the far field, interpolated ones."""
    layers, warnings = points.shape[1] - 1, []
    target = on_top(region, region.along())
    front = points[:, kept]
    steps = steps_up(region, target, height, layers)[:, kept:]
    if not kept:
        steps = heights_for_march(front, steps, False, (OnCurve(region.left), OnCurve(region.right)))
    if method == "hyperbolic":
        found = _hyperbolic(region, points, steps, kept, part_of(progress, 0.0, 0.5))
        if found is not None:
            return found
        warnings.append("no hyperbolic march could be continued to the far field; the parabolic one took its place")
    rest = _onto(region, front, target, steps, part_of(progress, 0.5, 1.0))
    if rest.stop is not None:
        stopped = f"the parabolic march {_told(rest.stop, region, kept)}; the elliptic equations took its place"
        return Lines("elliptic", points, [*warnings, stopped], {})
    counts, changed = changes_told(rest)
    made = np.concatenate([points[:, :kept], rest.points], axis=1)
    return Lines(method, made, [*warnings, *changed], counts)


def _hyperbolic(region: Region, points: np.ndarray, steps: np.ndarray, kept: int, progress: Progress) -> Lines | None:
    """Lines that march a part of the way, or as far as they come, and from there onto the far field; None if never."""
    ends = OnCurve(beyond(region.left, points[0, kept])), OnCurve(beyond(region.right, points[-1, kept]))
    share = np.cumsum(steps.mean(axis=0)) / steps.mean(axis=0).sum()
    some = int(np.clip(np.searchsorted(share, PART) + 1, 1, max(steps.shape[1] - 2, 1)))
    march = hyperbolic_march.marched(
        points[:, kept], steps[:, :some].T, ends=ends, progress=part_of(progress, 0.0, 0.5)
    )
    made = march.points.shape[1] - 1
    told = (
        []
        if march.stop is None
        else [f"the hyperbolic march {_told(march.stop, region, kept)}; it is parabolic from there on"]
    )
    for last in dict.fromkeys((made, max(made - 8, 0), made // 2)):
        front = march.points[:, last]
        length = arc_length(front)
        target = on_top(region, length / length[-1])
        rest = _onto(region, front, target, steps[:, last:], part_of(progress, 0.5, 1.0))
        if last and rest.stop is None:
            counts, changed = changes_told(march)
            whole = np.concatenate([points[:, :kept], march.points[:, :last], rest.points], axis=1)
            return Lines("hyperbolic", whole, [*told, *changed], counts)
    return None


def _onto(
    region: Region, front: np.ndarray, target: np.ndarray, steps: np.ndarray, progress: Progress
) -> parabolic_march.Marched:
    """The parabolic march from a front to points of the far field's top, first steps as given, then growing evenly."""
    layers, reach = steps.shape[1], np.linalg.norm(target - front, axis=1)
    first = np.minimum(steps[:, 0] / reach, 1 / layers)
    fractions = np.array([geometric(layers, first=share) for share in first]).T
    sides = beyond(region.left, front[0]), beyond(region.right, front[-1])
    return parabolic_march.marched(front, target, fractions, sides=sides, progress=progress)


def _told(stop: Stop, region: Region, kept: int) -> str:
    """Where and why a march stopped that began after some layers."""
    return stop_told(stop._replace(place=stop.place @ region.axes, layer=stop.layer + kept), region.plane)
