"""Sides of a planar patch that cross or touch: no grid between them is sound, which is said before it is looked for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np
from scipy.spatial import cKDTree

from ...errors import InvalidGeometry
from ...geometry.curves import Curve
from ...geometry.plane import fitted_plane
from ...mesh import Mesh, StructuredGrid
from ...quality.embedding import overlaps
from ..folds import around

_ORDER = ("jmin", "imax", "jmax", "imin")
_SIDES = dict(zip(_ORDER, ("south", "east", "north", "west"), strict=True))
_TOUCHING = 1e-9  # of the size: what comes nearer touches, as both sides of a cut do
_SAME_WAY = 1e-6  # radians


def refuse_crossed_sides(
    grid: StructuredGrid, names: Mapping[str, str] = _SIDES, given: Mapping[str, Curve | None] | None = None
) -> None:
    """Raise `InvalidGeometry`, with the place and the points there, if the boundary of a planar grid crosses itself.

    Parameters
    ----------
    grid : StructuredGrid
        A surface; one that is not planar passes.
    names : mapping of str to str
        What the user calls its faces.
    given : mapping of str to Curve, optional
        By these names, the curves that the user gave, or one as south. Points are told by their numbers in these, or
        else in the grid.

    Examples
    --------
    >>> bow_tie = StructuredGrid([[[0, 0], [0, 1]], [[1, 1], [1, 0]]])
    >>> refuse_crossed_sides(bow_tie)
    Traceback (most recent call last):
    ...
    meshcore.errors.InvalidGeometry: south: crosses north near (0.5, 0.5, 0); move the sides apart, or turn one round
    """
    points = grid.points[:, :, 0]
    try:
        plane = fitted_plane(grid.flat(grid.points), parameter="grid")
    except InvalidGeometry:
        return
    ni, nj = points.shape[:2]
    loop = around(points)
    side = np.repeat(np.arange(4), [ni - 1, nj - 1, ni - 1, nj - 1])
    cuts = [k for k, face in enumerate(_ORDER) if grid.periodic["ij".index(face[0])]]
    edges = np.flatnonzero(~np.isin(side, cuts))
    found = crossing(plane.to_plane(loop), edges)
    if found is None:
        return
    first, second, place, how = found
    a, b = (names.get(_ORDER[side[edge]], _SIDES[_ORDER[side[edge]]]) for edge in (first, second))
    x, y, z = plane.to_space(place[None])[0]
    other = b if a != b else "itself"
    cure = "move them apart" if how == "touches" else "move the sides apart, or turn one round"
    cure = cure if a != b else "take the loop out of it"
    if given is None:
        number = np.arange(ni * nj).reshape(ni, nj, order="F")
        at = around(number)[[first, (first + 1) % len(loop), second, (second + 1) % len(loop)]]
    else:
        at = _line_at(given["south"] if given[a] is None else given[a], np.array([x, y, z]))
    raise InvalidGeometry(f"{how} {other} near ({x:.6g}, {y:.6g}, {z:.6g}); {cure}", parameter=a, points=at)


def _line_at(curve: Curve, place: np.ndarray) -> np.ndarray:
    """Numbers of the ends of a curve's line that comes nearest to a place."""
    points = curve.points if isinstance(curve, Mesh) else np.asarray(curve, float)
    points = np.pad(points, ((0, 0), (0, 3 - points.shape[1])))
    lines = curve.get("line") if isinstance(curve, Mesh) else np.empty((0, 2), int)
    lines = lines if len(lines) else np.column_stack([np.arange(len(points) - 1), np.arange(1, len(points))])
    start, along = points[lines[:, 0]], np.diff(points[lines], axis=1)[:, 0]
    squared = np.maximum((along**2).sum(axis=1), np.finfo(float).tiny)
    share = np.clip(((place - start) * along).sum(axis=1) / squared, 0, 1)
    return lines[np.linalg.norm(start + share[:, None] * along - place, axis=1).argmin()]


def crossing(loop: np.ndarray, edges: np.ndarray) -> tuple[int, int, np.ndarray, Literal["crosses", "touches"]] | None:
    """The first two of some edges of a closed polygon that cross each other, where, and how; or None.

    Where the polygon touches itself it may pass through itself, or leave nothing inside; that counts. Edges that run
    along each other, or touch with nothing between them outside, are both sides of a cut.

    Parameters
    ----------
    loop : (n, 2) float
        The polygon's points.
    edges : (m,) int
        Numbers of edges, each from the point of that number to the next.

    Examples
    --------
    >>> crossing(np.array([[0.0, 0], [2, 2], [2, 0], [0, 2]]), np.arange(4))
    (0, 2, array([1., 1.]), 'crosses')
    """
    n = len(loop)
    ends = np.column_stack([edges, (edges + 1) % n])
    tolerance = _TOUCHING * float(np.ptp(loop, axis=0).max())
    found = overlaps(loop, ends, tolerance)
    if len(found.crossing):
        a, b = np.sort(edges[found.crossing], axis=1)[np.lexsort(np.sort(edges[found.crossing], axis=1).T[::-1])][0]
        p, r = loop[a], loop[b]
        d, e = loop[(a + 1) % n] - p, loop[(b + 1) % n] - r
        t = ((r - p)[0] * e[1] - (r - p)[1] * e[0]) / (d[0] * e[1] - d[1] * e[0])
        return int(a), int(b), p + t * d, "crosses"
    used = np.unique(ends)
    same = used[cKDTree(loop[used]).query_pairs(tolerance, output_type="ndarray")]
    edge, point = np.concatenate([np.column_stack([edges[found.hanging[:, 0]], found.hanging[:, 1]]), same]).T
    through, inside = _at_points(loop, edge.astype(int), point.astype(int), tolerance)
    for found, how in ((through, "crosses"), (inside, "touches")):
        if found.any():
            k = np.argmax(found)
            return int(edge[k]), int(point[k]), loop[int(point[k])], how
    return None


def _at_points(
    loop: np.ndarray, edge: np.ndarray, point: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Two (k,) bool: whether the polygon, at points that lie on edges, goes through these, or touches them inside."""
    n = len(loop)
    z = loop @ [1, 1j]
    here, start, stop = z[point], edge, (edge + 1) % n
    start = np.where(np.abs(z[start] - here) <= tolerance, (start - 1) % n, start)  # at an end: both edges that meet
    stop = np.where(np.abs(z[stop] - here) <= tolerance, (stop + 1) % n, stop)
    with np.errstate(divide="ignore", invalid="ignore"):  # where points coincide nothing passes through
        turn = [np.angle((z[k] - here) / (z[start] - here)) for k in (stop, (point - 1) % n, (point + 1) % n)]
    along = np.mod(turn[0], 2 * np.pi)
    left, apart = [], np.ones(len(edge), bool)
    for angle in turn[1:]:
        angle = np.mod(angle, 2 * np.pi)
        left.append(angle < along)
        for other in (0.0, 2 * np.pi, along):
            apart &= np.abs(angle - other) > _SAME_WAY
    x, y = (loop - loop[0]).T
    within = left[0] if (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() < 0 else ~left[0]
    return apart & (left[0] != left[1]), apart & (left[0] == left[1]) & within
