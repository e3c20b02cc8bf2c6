"""Polygons and polyhedra cut by the planes of a convex domain, the mesh conforming whatever the rounding.

Each point is inside or outside of a plane once for all cells, and each edge is cut once at a point that its faces
share. So neighbours stay neighbours, and what is left of the cells fills the domain: their areas and volumes add up,
since every inner edge or face counts once for each of its two sides.

References
----------
I. E. Sutherland, G. W. Hodgman, "Reentrant polygon clipping", Comm. ACM 17 (1974).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..mesh import polygons
from ..mesh.topology import edge_keys
from . import _voronoi_kernels as kernels
from .convex_domain import ConvexDomain


class Rows(NamedTuple):
    """Polygons in compressed rows on points of their own."""

    points: np.ndarray
    offsets: np.ndarray
    nodes: np.ndarray


class Faces(NamedTuple):
    """Faces between cells in compressed rows, each looking out of its owner; -1 is the outside."""

    points: np.ndarray
    offsets: np.ndarray
    nodes: np.ndarray
    owner: np.ndarray
    neighbour: np.ndarray


class _Cut(NamedTuple):
    """Rows after a cut, and the edges ``(start, end)`` of ``row`` that the cut made along the plane."""

    rows: Rows
    start: np.ndarray
    end: np.ndarray
    row: np.ndarray


def clipped_polygons(rows: Rows, domain: ConvexDomain) -> Rows:
    """The polygons within the domain; those wholly outside have no nodes left."""
    outside = domain.outside(rows.points)
    touched = _any(outside, rows.offsets, rows.nodes)
    if not touched.any():
        return rows
    part = Rows(rows.points, *polygons.taken(rows.offsets, rows.nodes, np.flatnonzero(touched)))
    for plane in range(len(domain.normals)):
        part = _cut(part, domain, plane).rows
    return _put_back(rows, touched, part)


def _any(flag: np.ndarray, offsets: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """(m,) bool: whether any node of each row has the flag."""
    found = np.zeros(len(offsets) - 1, bool)
    hits = np.flatnonzero(flag[nodes])
    found[np.searchsorted(offsets, hits, side="right") - 1] = True
    return found


def _put_back(rows: Rows, touched: np.ndarray, part: Rows) -> Rows:
    """All rows in their order, the touched ones from ``part``."""
    kept = np.flatnonzero(~touched)
    offsets, nodes = polygons.taken(rows.offsets, rows.nodes, kept)
    every = np.concatenate([offsets, offsets[-1] + part.offsets[1:]])
    order = np.empty(len(touched), np.int64)
    order[kept] = np.arange(len(kept))
    order[touched] = np.arange(len(kept), len(touched))
    return Rows(part.points, *polygons.taken(every, np.concatenate([nodes, part.nodes]), order))


def _cut(rows: Rows, domain: ConvexDomain, plane: int) -> _Cut:
    """What lies inside of one plane; a row may come out empty."""
    points, offsets, nodes = rows
    used = np.unique(nodes)
    height = np.zeros(len(points))
    height[used] = points[used] @ domain.normals[plane] - domain.offsets[plane]
    beyond = height > domain.tolerance
    if domain.is_box:
        axis = int(np.abs(domain.normals[plane]).argmax())
        on = used[np.abs(height[used]) <= domain.tolerance]
        if len(on):
            points = points.copy()
            points[on, axis] = domain.offsets[plane] * domain.normals[plane, axis]
    after = polygons.following(offsets, nodes)
    crossing = beyond[nodes] != beyond[after]
    key, edge = np.unique(
        edge_keys(np.column_stack([nodes[crossing], after[crossing]]), len(points)), return_inverse=True
    )
    a, b = key // len(points), key % len(points)
    share = (height[a] / (height[a] - height[b]))[:, None]
    made = points[a] + share * (points[b] - points[a])
    if domain.is_box:
        made[:, axis] = domain.offsets[plane] * domain.normals[plane, axis]
    # Each corner inside stays, and the point on each edge that crosses stands after the edge's first corner.
    stays = ~beyond[nodes]
    place = np.cumsum(stays.astype(np.int64) + crossing) - 1
    new = np.empty(place[-1] + 1 if len(place) else 0, np.int64)
    new[place[crossing]] = len(points) + edge.reshape(-1)
    new[place[stays] - crossing[stays]] = nodes[stays]
    count = np.concatenate([[0], place + 1])[offsets]
    leaving = crossing & stays
    start = place[leaving]
    row = np.searchsorted(offsets, np.flatnonzero(leaving), side="right") - 1
    end = polygons.following(count, new)[start]
    return _Cut(Rows(np.concatenate([points, made]), count, new), new[start], end, row)


def clipped_faces(faces: Faces, domain: ConvexDomain) -> Faces:
    """The cells within the domain: their faces cut, and closed by new faces along its planes."""
    touched = _any(domain.outside(faces.points), faces.offsets, faces.nodes)
    if not touched.any():
        return faces
    at = np.flatnonzero(touched)
    part = Faces(faces.points, *polygons.taken(faces.offsets, faces.nodes, at), faces.owner[at], faces.neighbour[at])
    for plane in range(len(domain.normals)):
        part = _cut_faces(part, domain, plane)
    rest = np.flatnonzero(~touched)
    offsets, nodes = polygons.taken(faces.offsets, faces.nodes, rest)
    owner = np.concatenate([faces.owner[rest], part.owner])
    order = np.argsort(owner, kind="stable")
    every = np.concatenate([offsets, offsets[-1] + part.offsets[1:]])
    rows = polygons.taken(every, np.concatenate([nodes, part.nodes]), order)
    return Faces(part.points, *rows, owner[order], np.concatenate([faces.neighbour[rest], part.neighbour])[order])


def _cut_faces(faces: Faces, domain: ConvexDomain, plane: int) -> Faces:
    """Cut the faces by one plane, and close each cell by the face that its new edges go around."""
    cut = _cut(Rows(*faces[:3]), domain, plane)
    left = np.flatnonzero(np.diff(cut.rows.offsets))
    offsets, nodes = polygons.taken(cut.rows.offsets, cut.rows.nodes, left)
    # Seen from the owner the new face runs against the cut face's edge, from the neighbour along it.
    inner = faces.neighbour[cut.row] >= 0
    start = np.concatenate([cut.end, cut.start[inner]])
    end = np.concatenate([cut.start, cut.end[inner]])
    cell = np.concatenate([faces.owner[cut.row], faces.neighbour[cut.row[inner]]])
    caps, corners, of_cell = _around(start, end, cell, len(cut.rows.points))
    return Faces(
        cut.rows.points,
        np.concatenate([offsets, offsets[-1] + caps[1:]]),
        np.concatenate([nodes, corners]),
        np.concatenate([faces.owner[left], of_cell]),
        np.concatenate([faces.neighbour[left], np.full(len(of_cell), -1)]),
    )


def _around(start: np.ndarray, end: np.ndarray, cell: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The loops that directed edges of cells make: offsets, nodes, and the cell of each.

    Where edges meet in more than two, by rounding, any pairing of those that arrive and leave closes the cell.
    """
    order = np.argsort(cell * n + start, kind="stable")
    arriving = np.argsort(cell * n + end, kind="stable")
    # The k-th edge to arrive at a place goes on in the k-th that leaves it.
    after = np.empty(len(order), np.int64)
    after[arriving] = order
    offsets, row = np.zeros(len(order) + 1, np.int64), np.empty(len(order), np.int64)
    count = kernels.loops(after.copy(), offsets, row)
    first = row[offsets[:count]]
    return offsets[: count + 1], start[row], cell[first]
