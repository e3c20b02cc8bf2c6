"""Polylines: put in order, measured, resampled, and cut at their corners."""

from __future__ import annotations

from collections import defaultdict
from typing import Union

import numpy as np

from ..errors import InvalidGeometry, InvalidInput
from ..mesh import Mesh

Curve = Union[Mesh, np.ndarray]
"""A polyline: (n, 3) or (n, 2) points in order, or a `Mesh` whose "line" cells form one chain."""


SHARP = np.radians(60)
"""A turn that is a corner whatever stands beside it."""
NOTICEABLE = np.radians(30)
"""A turn that is a corner if the loop is nearly straight on one side of it."""


def chains(mesh: Mesh) -> list[np.ndarray]:
    """The "line" cells as chains of point numbers; a closed one ends with its first point.

    Chains end where other than two lines meet. Directions follow the first line of each chain.

    Examples
    --------
    >>> zigzag = Mesh([[0, 0], [2, 0], [1, 1]], {"line": [[0, 2], [1, 2]]})
    >>> chains(zigzag)
    [array([0, 2, 1])]
    """
    lines = mesh.get("line")
    at_point: dict[int, list[int]] = defaultdict(list)
    for number, (a, b) in enumerate(lines.tolist()):
        at_point[a].append(number)
        if a != b:
            at_point[b].append(number)
    unused = np.ones(len(lines), bool)

    def follow(start: int, number: int) -> np.ndarray:
        chain = [start]
        while unused[number]:
            unused[number] = False
            a, b = lines[number].tolist()
            chain.append(b if chain[-1] == a else a)
            if len(at_point[chain[-1]]) != 2:
                break
            number = next((k for k in at_point[chain[-1]] if unused[k]), number)
        return np.array(chain)

    found = []
    for number, (a, b) in enumerate(lines.tolist()):  # open chains, from their ends
        for end in (a, b):
            if unused[number] and len(at_point[end]) != 2:
                found.append(follow(end, number))
    for number in range(len(lines)):  # what remains is closed
        if unused[number]:
            found.append(follow(int(lines[number, 0]), number))
    return found


def polyline(curve: Curve, parameter: str = "curve") -> np.ndarray:
    """(n, 3) float: the points of a curve in order; a closed one ends with its first point.

    Raises
    ------
    InvalidGeometry
        If the curve is in several pieces, branches, or has fewer than two different points.

    Examples
    --------
    >>> polyline(Mesh([[0, 0], [2, 0], [1, 1]], {"line": [[0, 2], [1, 2]]}))[:, 0]
    array([0., 1., 2.])
    """
    return numbered_polyline(curve, parameter)[0]


def numbered_polyline(curve: Curve, parameter: str = "curve") -> tuple[np.ndarray, np.ndarray]:
    """The points of a curve in order as `polyline` gives them, and (n,) int, the numbers that the user has for them.

    Examples
    --------
    >>> numbered_polyline(Mesh([[0, 0], [2, 0], [1, 1]], {"line": [[0, 2], [1, 2]]}))[1]
    array([0, 2, 1])
    """
    if isinstance(curve, Mesh) and len(curve.get("line")):
        pieces = chains(curve)
        if len(pieces) != 1:
            ends = sorted({int(p) for piece in pieces for p in (piece[0], piece[-1])})
            loops = sum(int(piece[0] == piece[-1]) for piece in pieces)
            found = f"{len(pieces)}, of which {loops} closed" if loops else len(pieces)
            cure = "give one alone" if loops == len(pieces) else "join its ends or give one curve"
            raise InvalidGeometry(
                f"needs one chain of line cells, got {found}; {cure}",
                parameter=parameter,
                points=ends,
            )
        points, number = curve.points[pieces[0]], pieces[0]
    else:
        points = _points_of(curve, parameter)
        number = np.arange(len(points))
    if len(points) < 2 or not np.ptp(points, axis=0).any():
        raise InvalidGeometry(
            f"needs at least two different points, got {len(np.unique(points, axis=0))}", parameter=parameter
        )
    return points, number


def _points_of(curve: Curve, parameter: str) -> np.ndarray:
    """Those of a curve without lines, in the order they have; faults of an array are told under the curve's name."""
    if isinstance(curve, Mesh):
        other = next((kind for kind, cells in curve.cells.items() if len(cells) and kind != "vertex"), None)
        if other is not None:
            raise InvalidGeometry(
                f"has {other} cells but no lines; give the lines of its outline alone", parameter=parameter
            )
        return curve.points
    try:
        return Mesh(curve, {}).points
    except InvalidInput as error:
        where = getattr(error, "points", ())
        text = str(error).removeprefix("points: ")
        raise InvalidGeometry(text, parameter=parameter, points=where) from None


def is_closed(points: np.ndarray) -> bool:
    """Whether a polyline ends where it begins."""
    return len(points) > 2 and bool((points[0] == points[-1]).all())


def lines_through(points: np.ndarray, *, closed: bool = False) -> Mesh:
    """A `Mesh` of line cells through points in order.

    Examples
    --------
    >>> lines_through([[0, 0], [1, 0], [1, 1]], closed=True)
    Mesh(3 points, 3 line)
    """
    mesh = Mesh(points, {})
    n = mesh.n_points
    start = np.arange(n if closed else n - 1)
    return Mesh(mesh.points, {"line": np.column_stack([start, (start + 1) % n])})


def arc_length(points: np.ndarray) -> np.ndarray:
    """(n,) float: length along a polyline up to each point.

    Examples
    --------
    >>> arc_length(np.array([[0.0, 0], [3, 4], [3, 5]]))
    array([0., 5., 6.])
    """
    steps = np.diff(points, axis=0)
    scale = float(np.abs(steps).max(initial=0.0)) or 1.0  # squares of lengths below 1e-154 would underflow
    return np.concatenate([[0.0], np.cumsum(scale * np.linalg.norm(steps / scale, axis=1))])


def turning(loop: np.ndarray) -> np.ndarray:
    """Angle in radians by which a closed polyline turns at each of its points, positive to the left.

    Parameters
    ----------
    loop : (n, 2) float
        Points in order; the last is joined to the first.

    Returns
    -------
    (n,) float
        Between -pi and pi; for a simple counter-clockwise loop they add up to 2 pi.

    Examples
    --------
    >>> np.degrees(turning(np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])))
    array([90., 90., 90., 90.])
    """
    after = np.roll(loop, -1, axis=0) - loop
    before = np.roll(after, 1, axis=0)
    return np.arctan2(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0], (before * after).sum(axis=1))


def corners(turn: np.ndarray) -> np.ndarray:
    """Which points of a loop are corners rather than samples of a round: (n,) bool from its (n,) turning.

    Examples
    --------
    >>> corners(turning(np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])))
    array([ True,  True,  True,  True])
    """
    size = np.abs(turn)
    straighter = np.minimum(np.roll(size, 1), np.roll(size, -1))
    return (size > SHARP) | ((size > NOTICEABLE) & (size > 2.5 * straighter))


def resampled(points: np.ndarray, fractions: np.ndarray) -> np.ndarray:
    """(m, 3) float: points of a polyline at fractions of its length; the ends are kept exactly.

    Examples
    --------
    >>> resampled(np.array([[0.0, 0, 0], [3, 0, 0], [4, 0, 0]]), np.array([0, 0.5, 1]))[:, 0]
    array([0., 2., 4.])
    """
    length = arc_length(points)
    at = np.asarray(fractions, float) * length[-1]
    new = np.column_stack([np.interp(at, length, x) for x in points.T])
    new[at <= 0] = points[0]
    new[at >= length[-1]] = points[-1]
    return new


def sharpest_corners(loop: np.ndarray, count: int = 4) -> np.ndarray:
    """(count,) int: the points of a closed polyline where it turns most, in order, apart from each other.

    Turning is measured over a part of the loop's length, so that a rounded corner counts as one, and a circle of few
    points has none; corners that point inwards do not count. Of corners that turn alike the farthest from those chosen
    is taken, and where the loop has fewer than ``count`` the rest are set evenly between.

    Raises
    ------
    InvalidInput
        If the loop is open or has fewer than ``count`` points.

    Examples
    --------
    >>> square = np.array([[0.0, 0, 0], [0.5, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 0]])
    >>> sharpest_corners(square)
    array([0, 2, 3, 4])
    """
    if not is_closed(loop):
        raise InvalidInput("needs a closed loop: its last point must repeat its first")
    n = len(loop) - 1
    if n < count:
        raise InvalidInput(f"needs at least {count} points, got {n}")
    at = arc_length(loop)[:-1] / arc_length(loop)[-1]
    nearest = _NEAREST / count
    turn = _turns(loop, 0.5 * nearest)
    free = turn > _LEAST_TURN
    chosen: list[int] = []
    while len(chosen) < count and free.any():
        alike = np.flatnonzero(free & (turn > _ALIKE * turn[free].max()))
        far = alike[np.argmax(_apart(at[alike], at[chosen]))]
        corner = np.flatnonzero(free & (_apart(at, at[[far]]) <= 0.5 * nearest))
        chosen.append(int(corner[np.argmax(turn[corner])]))
        free &= _apart(at, at[chosen]) > nearest
    while len(chosen) < count:  # halve the longest stretch between corners
        rest = np.setdiff1d(np.arange(n), chosen)
        chosen.append(int(rest[np.argmax(_apart(at[rest], at[chosen]))]))
    return np.sort(np.array(chosen))


_NEAREST = 0.2  # of the length over the number of corners: none is nearer than this to a sharper one
_LEAST_TURN = 20.0  # degrees: what turns by less is no corner, as a circle nowhere does
_ALIKE = 0.99  # of the sharpest turn


def _turns(loop: np.ndarray, reach: float) -> np.ndarray:
    """(n,) float: degrees by which a loop turns at each point, seen from a share of its length before and after.

    Below zero where it turns against the way that it runs around.
    """
    length = arc_length(loop)
    loop, at = (loop - loop.mean(axis=0)) / length[-1], length[:-1] / length[-1]
    points, around = np.tile(loop[:-1].T, 3), np.concatenate([at - 1, at, at + 1])
    before, after = (
        sign * (np.column_stack([np.interp(at + sign * reach, around, x) for x in points]) - loop[:-1])
        for sign in (-1, 1)
    )
    sine, cosine = np.cross(before, after), (before * after).sum(axis=1)
    normal = np.cross(loop[:-1], loop[1:]).sum(axis=0)
    turn = np.degrees(np.arctan2(np.linalg.norm(sine, axis=1), cosine))
    return np.where(sine @ normal < 0, -turn, turn)


def _apart(at: np.ndarray, others: np.ndarray) -> np.ndarray:
    """(n,) float: distance along a loop of length 1 to the nearest of some other places."""
    if not len(others):
        return np.ones(len(at))
    gap = np.abs(at[:, None] - others)
    return np.minimum(gap, 1 - gap).min(axis=1)
