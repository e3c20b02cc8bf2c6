"""Planar fronts marched by the hyperbolic equations, as arrays: what `hyperbolic` and the block topologies call."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...errors import InvalidGeometry, InvalidInput
from ...geometry.curves import turning
from ...progress import Progress, advance, part_of, silent
from ...quality.embedding import overlaps
from . import _hyperbolic_kernels as kernels
from . import _marching_front_kernels as fronts
from .marching_ends import Conditions, End, Free, as_numbers

POINTS_A_CHUNK = 100_000
"""Between reports of progress; about 30 ms."""
RAISED = (1.0, 1.5, 3.0, 6.0)
"""Times the dissipation asked for with which a march is tried, each if cells fold with the one before."""
MOST_BASE = 2.0
FOLDED, MET = "cells fold", "fronts meet"


@dataclass(frozen=True)
class Dissipation:
    """How much the front is smoothed while it marches.

    Parameters
    ----------
    base : float
        Dissipation in units of the cells' aspect ratio, height over length along the front; 0 to 2. More rounds
        concave corners sooner, and skews cells where points are unevenly spaced.
    implicitness : float
        Kinsey and Barth's theta: how far the equations look ahead beyond the next layer; 0 to 4. More keeps lines
        apart in concave regions.

    References
    ----------
    D. W. Kinsey, T. J. Barth, AFWAL-TM-84-191 (1984).
    """

    base: float = 0.3
    implicitness: float = 0.0

    def __post_init__(self) -> None:
        for name, most in (("base", MOST_BASE), ("implicitness", 4.0)):
            value = getattr(self, name)
            if not 0 <= value <= most:
                raise InvalidInput(f"must lie between 0 and {most:g}, got {value}", parameter=name)


class Stop(NamedTuple):
    """Where a march ended before its last layer.

    Attributes
    ----------
    point : int
        Point of the front.
    layer : int
        The layer that could not be made, the first at the front being 0.
    place : (2,) float
        Where the point is on the last layer that was made.
    concavity : float
        Degrees by which the last layer turns to the left: where it does so around that point, or between the two that
        meet.
    reason : str
        "cells fold" or "fronts meet".
    other : int or None
        The point of the front that it would meet.
    """

    point: int
    layer: int
    place: np.ndarray
    concavity: float
    reason: str
    other: int | None = None


class Marched(NamedTuple):
    """A marched grid.

    Attributes
    ----------
    points : (n, layers + 1, 2) float
        Sound cells all of them, that cover the plane once.
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


def layer_heights(
    first: float, growth: float, *, layers: int | None = None, distance: float | None = None, largest: float = math.inf
) -> np.ndarray:
    """Heights of layers that grow geometrically.

    Parameters
    ----------
    first : float
        Height of the first layer.
    growth : float
        Each height over the one before; with a distance but no number of layers the largest that is allowed.
    layers : int, optional
        Number of layers.
    distance : float, optional
        Sum of the heights. With a number of layers, growth follows from the two and `growth` is not used.
    largest : float
        Heights stay below.

    Returns
    -------
    (layers,) float

    Raises
    ------
    InvalidInput
        If no such heights exist. Heights that do not grow may be a little lower than `first`, to fill the distance.

    Examples
    --------
    >>> layer_heights(1, 2, layers=3), layer_heights(1, 2, layers=4, largest=3)
    (array([1., 2., 4.]), array([1., 2., 3., 3.]))
    >>> layer_heights(1, 3, distance=7).round(6)
    array([1., 2., 4.])
    >>> layer_heights(0.3, 1, distance=1)
    array([0.25, 0.25, 0.25, 0.25])
    """
    first, growth = float(first), float(growth)
    _check(first, growth, largest)
    if distance is None:
        return _heights(first, growth, _count(layers), largest)
    if not distance > 0 or not math.isfinite(distance):
        raise InvalidInput(f"must be greater than zero, got {distance:g}", parameter="distance")
    if layers is None:
        layers = _fewest(first, growth, distance, largest)
        if growth == 1 and layers > 1:
            return np.full(layers, distance / layers)  # what divides the distance: none higher than asked
    count = _count(layers)
    if count * first >= distance:
        if abs(count * first - distance) <= 1e-9 * distance:
            return np.full(count, distance / count)
        raise InvalidInput(
            f"{count} layers of {first:g} already reach past {distance:g}; make it smaller, or the distance larger",
            parameter="first_height",
        )
    low, high = 1.0, 3.0
    if _heights(first, high, count, largest).sum() < distance:
        raise InvalidInput(
            f"{count} layers from {first:g} on reach {distance:g} only with a growth above {high:g}; give more layers",
            parameter="layers",
        )
    for _ in range(200):
        middle = 0.5 * (low + high)
        short = _heights(first, middle, count, largest).sum() < distance
        low, high = (middle, high) if short else (low, middle)
    return _heights(first, high, count, largest)


def _heights(first: float, growth: float, count: int, largest: float) -> np.ndarray:
    with np.errstate(over="ignore"):  # infinite heights only tell that less growth is enough
        return np.minimum(first * growth ** np.arange(count), largest)


def _check(first: float, growth: float, largest: float) -> None:
    if not first > 0 or not math.isfinite(first):
        raise InvalidInput(f"must be greater than zero, got {first:g}", parameter="first_height")
    if not 1 <= growth <= 3:
        raise InvalidInput(f"must lie between 1 and 3, got {growth:g}", parameter="growth")
    if not largest >= first:
        raise InvalidInput(f"is {largest:g}, below the first height {first:g}", parameter="largest_height")


def _count(layers: int | None) -> int:
    if layers is None or layers != int(layers) or layers < 1:
        raise InvalidInput(f"needs a whole number of at least 1, got {layers}", parameter="layers")
    return int(layers)


MOST_LAYERS = 100_000


def _fewest(first: float, growth: float, distance: float, largest: float) -> int:
    """The smallest number of layers that reaches a distance."""
    total, count, height = 0.0, 0, first
    while total < distance * (1 - 1e-9):
        total, count, height = total + min(height, largest), count + 1, height * growth
        if count > MOST_LAYERS:
            raise InvalidInput(
                f"{first:g} needs more than {MOST_LAYERS:,} layers to reach {distance:g}; let heights grow faster",
                parameter="growth",
            )
    return count


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
    >>> result = marched(np.column_stack([x, 0 * x]), layer_heights(0.1, 2, layers=2))
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
        stop = _folded(out[made].T, int(info[1]), made, closed)
    sound, where = _last_simple(out[: made + 1], closed)
    if sound < made:
        stop = _met(out[sound].T, where, sound, closed)
    return Marched(np.ascontiguousarray(out[: sound + 1].transpose(2, 0, 1)), int(info[0]), stop)


def _march(front, heights, outer, conditions, dissipation, progress, drawing) -> tuple[np.ndarray, int, np.ndarray]:
    """(layers + 1, 2, n) fronts, how many were made, and what kernels tell."""
    n, layers = len(front), len(heights)
    out = np.empty((layers + 1, 2, n))
    out[0] = front.T
    info, reached = np.zeros(2, np.int64), np.zeros(2)
    scratch = np.zeros((2, n + 4)), np.zeros((n, 2)), np.zeros((kernels.ROWS, n + 4)), np.zeros((4, n, 4))
    numbers = dissipation.base, dissipation.implicitness, float(drawing)
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
    if closed and (crossing := _crossing(front, closed)) is not None:
        raise InvalidGeometry(
            f"crosses itself near {front[crossing[0]].tolist()}, at its point {crossing[0]}; undo the loop",
            parameter=parameter,
            points=[crossing[0]],
        )
    return front


def checked_heights(heights: np.ndarray, n: int) -> np.ndarray:
    """(layers, 1 or n) heights of layers, or an error that says what is wrong with them."""
    heights = _real(heights)
    if heights.ndim not in (1, 2) or not heights.size or heights.shape[1:] not in ((), (1,), (n,)):
        raise InvalidInput(f"needs shape (layers,) or (layers, {n}), got {heights.shape}", parameter="heights")
    heights = np.ascontiguousarray(heights.reshape(len(heights), -1))
    if not (np.isfinite(heights) & (heights > 0)).all():
        raise InvalidInput("must be finite and greater than zero", parameter="heights")
    return heights


def _real(heights: np.ndarray) -> np.ndarray:
    """Heights as an array, if they are real numbers."""
    try:
        found = np.asarray(heights)
        if found.dtype.kind in "biuf":
            return found.astype(float)
    except ValueError:  # of rows of different lengths
        pass
    raise InvalidInput("needs real numbers", parameter="heights")


def _crossing(front: np.ndarray, closed: bool) -> tuple[int, int] | None:
    """Two points whose edges to their next ones cross, the first first, or None."""
    n = len(front)
    start = np.arange(n if closed else n - 1)
    edges = np.column_stack([start, (start + 1) % n])
    crossing = overlaps(front, edges, 0.0).crossing
    return (int(crossing[0].min()), int(crossing[0].max())) if len(crossing) else None


def _last_simple(layers: np.ndarray, closed: bool) -> tuple[int, tuple[int, int] | None]:
    """The last front that does not cross itself, and where the next one does.

    Sound cells between two fronts without crossings cover what lies between them once, so that the fronts between need
    no look. That holds for closed fronts; the lines at the ends of an open one may still meet.
    """
    last = len(layers) - 1
    where = _crossing(np.ascontiguousarray(layers[last].T), closed)
    if where is None:
        return last, None
    low, high = 0, last
    while high - low > 1:
        middle = (low + high) // 2
        found = _crossing(np.ascontiguousarray(layers[middle].T), closed)
        low, high, where = (middle, high, where) if found is None else (low, middle, found)
    return low, where


def _folded(front: np.ndarray, cell: int, layer: int, closed: bool) -> Stop:
    """The stop at a cell: its point where the front turns most to the left, and by how much it does around there."""
    n, turn = len(front), _turning(front, closed)
    near = [k % n if closed else min(max(k, 0), n - 1) for k in range(cell - 2, cell + 4)]
    point = max(near, key=lambda k: turn[k])
    concavity = max(turn[point], 0.0)
    for step in (-1, 1):
        k = point + step
        while concavity > 0 and concavity < 360 and (closed or 0 <= k < n) and turn[k % n] > 0:
            concavity += turn[k % n]
            k += step
    return Stop(point, layer, front[point].copy(), float(min(concavity, 360.0)), FOLDED)


def _met(front: np.ndarray, edges: tuple[int, int], layer: int, closed: bool) -> Stop:
    """The stop where two edges would cross: the points of theirs that are nearest, and the bay between them."""
    n, turn = len(front), _turning(front, closed)
    first, second = edges
    ends = [(a % n, b % n) for a in (first, first + 1) for b in (second, second + 1) if a % n != b % n]
    point, other = min(ends, key=lambda pair: np.linalg.norm(front[pair[0]] - front[pair[1]]))
    bay = turn[first + 1 : second + 1].sum()
    if closed:
        bay = max(bay, turn.sum() - bay)
    return Stop(point, layer, front[point].copy(), float(max(bay, 0.0)), MET, other)


def _turning(front: np.ndarray, closed: bool) -> np.ndarray:
    """Degrees by which a front turns to the left at each point; none at the ends of an open one."""
    turn = np.degrees(turning(front))
    if not closed:
        turn[[0, -1]] = 0
    return turn
