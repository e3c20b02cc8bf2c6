"""Curves that cross themselves, or do not go round what they should, are refused with the place in space."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ..errors import InvalidGeometry
from ..geometry.plane import Plane
from ..geometry.section import doubled_area, winds_round
from ..quality.embedding import overlaps

TOUCH = 1e-14
"""Of a curve's diagonal: a point nearer to an edge counts as on it."""
_FLAT = 1e-12
"""Of the extent squared: an area that counts as none."""


def refuse_crossings(
    points: np.ndarray, number: np.ndarray, plane: Plane, hair: float, *, closed: bool, parameter: str
) -> None:
    """Refuse a curve that crosses or touches itself, and a closed one that encloses no area.

    Parameters
    ----------
    points : (n, 2) float
        Different points in order, in coordinates of their plane; the first of a closed curve is not repeated.
    number : (n,) int
        The numbers that the user has for them.
    plane : Plane
        Where they lie in space.
    hair : float
        A point no farther than this from an edge touches it.
    closed : bool
        Whether the last point is joined to the first.
    parameter : str
        The curve's name.

    Raises
    ------
    InvalidGeometry
        If it does; `points` are the user's numbers of the points there.

    Examples
    --------
    >>> from meshcore.geometry.plane import fitted_plane
    >>> bow = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
    >>> plane = fitted_plane(bow)
    >>> refuse_crossings(plane.to_plane(bow), np.arange(4), plane, 1e-12, closed=True, parameter="section")
    Traceback (most recent call last):
    meshcore.errors.InvalidGeometry: section: crosses itself near (0.5, 0.5, 0), between points 3, 0 and 1, 2; undo ...
    """
    _refuse_meetings(points, number, plane, hair, parameter)
    start = np.arange(len(points) if closed else len(points) - 1)
    edges = np.column_stack([start, (start + 1) % len(points)])
    found = overlaps(points, edges, hair)
    if len(found.crossing):
        a, b = edges[found.crossing[0]]
        where = _named(plane, _meeting(points[a], points[b]))
        raise InvalidGeometry(
            f"crosses itself near {where}, between points {number[a[0]]}, {number[a[1]]} and "
            f"{number[b[0]]}, {number[b[1]]}; undo the loop",
            parameter=parameter,
            points=number[np.unique([a, b])],
        )
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    if closed and abs(doubled_area(points)) <= _FLAT * diagonal**2:
        raise InvalidGeometry(f"encloses no area (extent {diagonal:.6g}); give a simple loop", parameter=parameter)
    if len(found.hanging):
        edge, point = found.hanging[0]
        raise InvalidGeometry(
            f"touches itself at point {number[point]}, {_named(plane, points[point])}; move it off, or make two curves",
            parameter=parameter,
            points=number[np.unique([*edges[edge], point])],
        )


def _refuse_meetings(points: np.ndarray, number: np.ndarray, plane: Plane, hair: float, parameter: str) -> None:
    """Refuse a curve two points of which are one, as where it runs round twice."""
    pairs = cKDTree(points).query_pairs(hair, output_type="ndarray")
    if len(pairs) == 0:
        return
    a, b = pairs[np.argmin(pairs[:, 0])]
    fault = "runs round more than once" if 2 * len(pairs) >= len(points) else "touches itself"
    raise InvalidGeometry(
        f"{fault}: points {number[a]} and {number[b]} are both at {_named(plane, points[a])}; move them apart, or make "
        "two curves",
        parameter=parameter,
        points=number[[a, b]],
    )


def refuse_outside(loop: np.ndarray, ring: np.ndarray, plane: Plane, what: str) -> None:
    """Refuse an outer curve that does not go round all of a loop; some points of many are asked.

    Parameters
    ----------
    loop, ring : (n, 2) float
        In coordinates of their plane; the last points are joined to the first. `ring` is the curve called "outer".
    plane : Plane
        Where they lie in space.
    what : str
        What the loop is called.

    Raises
    ------
    InvalidGeometry
        If it does not; the text tells a point outside.

    Examples
    --------
    >>> from meshcore.geometry.plane import fitted_plane
    >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> plane = fitted_plane(square)
    >>> refuse_outside(plane.to_plane(square), plane.to_plane(square + 0.5), plane, "section")
    Traceback (most recent call last):
    meshcore.errors.InvalidGeometry: outer: does not go round all of the section: (0, 0, 0) is outside; make it ...
    """
    for point in loop[:: max(1, len(loop) // 64)]:
        if not winds_round(ring, point):
            raise InvalidGeometry(
                f"does not go round all of the {what}: {_named(plane, point)} is outside; make it larger, move it, "
                "or exchange the two",
                parameter="outer",
            )


def _meeting(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """(2,) float: where two edges (2, 2) that cross meet."""
    d, e, between = one[1] - one[0], other[1] - other[0], other[0] - one[0]
    across = d[0] * e[1] - d[1] * e[0]
    if across == 0:  # in rounded numbers they lie upon each other
        return other[0]
    return one[0] + (between[0] * e[1] - between[1] * e[0]) / across * d


def _named(plane: Plane, place: np.ndarray) -> str:
    x, y, z = plane.to_space(place[None])[0]
    return f"({x:.6g}, {y:.6g}, {z:.6g})"
