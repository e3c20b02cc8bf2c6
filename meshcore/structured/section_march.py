"""Marching grids round sections: heights of the transfinite grid, lines as the march finds them."""

from __future__ import annotations

import numpy as np

from ..progress import Progress, part_of
from ..sizing import geometric
from . import hyperbolic_march, parabolic_march
from .hyperbolic_march import Marched, Stop
from .marching_ends import OnCurve


def marched_lines(
    points: np.ndarray, method: str, *, closed: bool, progress: Progress, first: np.ndarray | None = None
) -> tuple[np.ndarray | None, list[str]]:
    """A marched grid in place of a transfinite one, whose front, heights and far field it takes.

    Parameters
    ----------
    points : (n, layers + 1, 2) float
        The transfinite grid; the front at j = 0 runs clockwise round the section. If closed the last line is the first.
    method : {"hyperbolic", "parabolic"}
        A hyperbolic march goes as far as the heights of the layers take it; where it has to stop, the parabolic one,
        which ends on the far field, takes its place.
    closed : bool
        Whether the front is.
    progress : Progress
        Called with fraction and message.
    first : (n,) float, optional
        Other first heights for the lines, which then grow geometrically over the same lengths.

    Returns
    -------
    points : (n, layers + 1, 2) float or None
        None if no march could reach the end.
    warnings : list of str
        What had to be done, and where a march stopped.
    """
    lines = points[:-1] if closed else points
    steps = np.linalg.norm(np.diff(lines, axis=1), axis=-1)
    if first is not None:
        steps = np.array(
            [s.sum() * np.diff(geometric(len(s), first=f / s.sum())) for s, f in zip(steps, first, strict=True)]
        )
    warnings: list[str] = []
    if method == "hyperbolic":
        ends = (OnCurve(points[0]), OnCurve(points[-1]))
        found = hyperbolic_march.marched(
            lines[:, 0], steps.T, closed=closed, ends=ends, progress=part_of(progress, 0.0, 0.5)
        )
        if found.stop is None:
            return _closed(found, closed), warnings
        warnings.append(f"the hyperbolic march {_told(found.stop)}; the parabolic one took its place")
    fractions = np.concatenate([np.zeros((1, len(lines))), np.cumsum(steps, axis=1).T])
    fractions /= fractions[-1]
    fractions[-1] = 1.0
    found = parabolic_march.marched(
        lines[:, 0],
        lines[:, -1],
        fractions,
        closed=closed,
        sides=(None, None) if closed else (points[0], points[-1]),
        progress=part_of(progress, 0.5, 1.0),
    )
    if found.stop is None:
        return _closed(found, closed), warnings
    return None, [*warnings, f"the parabolic march {_told(found.stop)}; the elliptic equations took its place"]


def _closed(found: Marched, closed: bool) -> np.ndarray:
    return np.concatenate([found.points, found.points[:1]]) if closed else found.points


def _told(stop: Stop) -> str:
    x, y = stop.place
    concave = f", where the front is concave by {stop.concavity:.0f} degrees" if stop.concavity > 1 else ""
    return f"stopped at layer {stop.layer}, point {stop.point} near ({x:.6g}, {y:.6g}), as {stop.reason}{concave}"
