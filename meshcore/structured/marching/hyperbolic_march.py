"""Planar fronts marched by the hyperbolic equations, as arrays: what `hyperbolic` and the block topologies call."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...errors import InvalidGeometry, InvalidInput
from ...progress import Progress, advance, part_of, silent
from . import _hyperbolic_kernels as kernels
from . import _marching_front_kernels as fronts
from .layer_heights import checked_heights
from .march_stops import FOLDED, Stop, crossing, folded, last_simple, met
from .marching_ends import Conditions, End, Free, as_numbers

POINTS_A_CHUNK = 100_000
"""Between reports of progress; about 30 ms."""
RAISED = (1.0, 1.5, 3.0, 6.0)
"""Times the dissipation asked for with which a march is tried, each if cells fold with the one before."""
MOST_BASE = 2.0


@dataclass(frozen=True)
class Dissipation:
    """How much the front, and the areas of its cells, are smoothed while it marches.

    Parameters
    ----------
    base : float
        Dissipation in units of the cells' aspect ratio, height over length along the front; 0 to 2. More rounds
        concave corners sooner, and skews cells where points are unevenly spaced.
    implicitness : float
        Kinsey and Barth's theta: how far the equations look ahead beyond the next layer; 0 to 4. More keeps lines
        apart in concave regions.
    volume_smoothing : float
        1 widens all cells of a layer alike, 0 keeps heights at each point.
    volume_averaging : float
        From 0 to 1: how far thick cells widen like those around. Lines off corners get less skew, fronts less round.

    References
    ----------
    D. W. Kinsey, T. J. Barth, AFWAL-TM-84-191 (1984).
    """

    base: float = 0.3
    implicitness: float = 0.0
    volume_smoothing: float = 1.0
    volume_averaging: float = 0.0

    def __post_init__(self) -> None:
        limits = {"base": MOST_BASE, "implicitness": 4.0, "volume_smoothing": 1.0, "volume_averaging": 1.0}
        for name, most in limits.items():
            value = getattr(self, name)
            if not 0 <= value <= most:
                raise InvalidInput(f"must lie between 0 and {most:g}, got {value}", parameter=name)


class Marched(NamedTuple):
    """A marched grid.

    Attributes
    ----------
    points : (n, layers + 1, 2) float
        Sound cells all of them, that cover the plane once. Fronts lie in memory one after the other, as they were made:
        a copy in the order of the indices would cost as much as the march once it no longer fits into caches.
    split : int
        Layers that were made in smaller steps.
    stop : Stop or None
        Where it ended too early.
    raised : float
        Times the dissipation asked for with which it was made: more than 1 where cells fold with that.
    """

    points: np.ndarray
    split: int
    stop: Stop | None
    raised: float = 1.0


def marched(
    front: np.ndarray,
    heights: np.ndarray,
    *,
    closed: bool = False,
    ends: tuple[End, End] = (Free(), Free()),
    dissipation: Dissipation = Dissipation(),
    progress: Progress = silent,
) -> Marched:
    """Layers that march off a front, to the left of its direction, by the hyperbolic equations.

    Parameters
    ----------
    front : (n, 2) float
        Points in order; around a section clockwise. The first point of a closed front is not repeated.
    heights : (layers,) or (layers, n) float
        Thickness of each layer, the same along the front or its own at each point.
    closed : bool
        Whether the last point is joined to the first.
    ends : tuple of two ends
        Conditions at the first and the last point of an open front.
    dissipation : Dissipation
        How much the front is smoothed.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Marched
        With fewer layers than asked for if it had to stop.

    Raises
    ------
    InvalidInput
        If shapes do not fit, or heights are not positive.
    InvalidGeometry
        If points repeat, or a closed front crosses itself.

    Examples
    --------
    >>> x = np.linspace(0, 1, 5)
    >>> result = marched(np.column_stack([x, 0 * x]), np.array([0.1, 0.2]))
    >>> result.points[2]
    array([[0.5, 0. ],
           [0.5, 0.1],
           [0.5, 0.3]])
    """
    front = checked_front(front, closed)
    heights = checked_heights(heights, len(front))
    conditions = as_numbers(ends, front, closed)
    return run_until_whole(front, heights, np.empty((2, 0)), conditions, dissipation, progress)


def run_until_whole(
    front: np.ndarray,
    heights: np.ndarray,
    outer: np.ndarray,
    conditions: Conditions,
    dissipation: Dissipation,
    progress: Progress,
) -> Marched:
    """March a checked front with more and more dissipation while cells fold, then with points drawn out of bays."""
    given = front, heights, outer, conditions
    farthest, done = None, 0.0
    for drawing in (False, True):
        for times in RAISED:
            stronger = replace(dissipation, base=min(times * dissipation.base, MOST_BASE))
            result = run(*given, stronger, part_of(progress, done, 0.5 * (1 + done)), drawing)
            done = 0.5 * (1 + done)
            if result.stop is None:
                return result._replace(raised=times)
            if farthest is None or result.stop.layer > farthest.stop.layer:
                farthest = result
            if result.stop.reason != FOLDED:
                break
    return farthest


def run(
    front: np.ndarray,
    heights: np.ndarray,
    outer: np.ndarray,
    conditions: Conditions,
    dissipation: Dissipation,
    progress: Progress,
    drawing: bool = False,
) -> Marched:
    """March a checked front, and see how far the grid covers the plane once; arguments as the kernel takes them."""
    closed = conditions.kinds[0] == fronts.CLOSED
    out, made, info = _march(front, heights, outer, conditions, dissipation, progress, drawing)
    stop = None
    if made < len(heights):
        stop = folded(out[made].T, int(info[1]), made, closed)
    sound, where = last_simple(out[: made + 1], closed)
    if sound < made:
        stop = met(out[sound].T, where, sound, closed)
    return Marched(out[: sound + 1].transpose(2, 0, 1), int(info[0]), stop)


def _march(front, heights, outer, conditions, dissipation, progress, drawing) -> tuple[np.ndarray, int, np.ndarray]:
    """(layers + 1, 2, n) fronts, how many were made, and what kernels tell."""
    n, layers = len(front), len(heights)
    out = np.empty((layers + 1, 2, n))
    out[0] = front.T
    info, reached = np.zeros(2, np.int64), np.zeros(2)
    scratch = np.zeros((2, n + 4)), np.zeros((n, 2)), np.zeros((fronts.ROWS, n + 4)), np.zeros((4, n, 4))
    d = dissipation
    numbers = d.base, d.implicitness, d.volume_smoothing, d.volume_averaging, float(drawing)
    made, chunk = 0, max(1, POINTS_A_CHUNK // n)
    while made < layers:
        advance(progress, made / layers, "marching")
        last = min(made + chunk, layers)
        done = kernels.march(out, heights, outer, *conditions, reached, *numbers, *scratch, info, made, last)
        if done < last:
            return out, done, info
        made = done
    return out, made, info


def checked_front(front: np.ndarray, closed: bool, parameter: str = "front") -> np.ndarray:
    """The (n, 2) points of a front, or an error that says what is wrong with them."""
    front = np.ascontiguousarray(front, float)
    least = 3 if closed else 2
    if front.ndim != 2 or front.shape[1] != 2 or len(front) < least:
        raise InvalidInput(f"needs shape (n, 2) with n of at least {least}, got {front.shape}", parameter=parameter)
    bad = np.flatnonzero(~np.isfinite(front).all(axis=1))
    if len(bad):
        raise InvalidGeometry(f"point {bad[0]} is {front[bad[0]].tolist()}", parameter=parameter, points=bad)
    steps = np.diff(front, axis=0, append=front[:1]) if closed else np.diff(front, axis=0)
    bad = np.flatnonzero((steps == 0).all(axis=1))
    if len(bad):
        raise InvalidGeometry(
            f"point {bad[0]} is the same as the next, {front[bad[0]].tolist()}; leave one out",
            parameter=parameter,
            points=bad,
        )
    if closed and (where := crossing(front, closed)) is not None:
        raise InvalidGeometry(
            f"crosses itself near {front[where[0]].tolist()}, at its point {where[0]}; undo the loop",
            parameter=parameter,
            points=[where[0]],
        )
    return front
