"""Polygons and polyhedra cut by the planes of a convex domain, the mesh conforming whatever the rounding.

Each point is inside or outside of a plane once for all cells, and each edge is cut once at a point that its faces
share. So neighbours stay neighbours, and what is left of the cells fills the domain: their areas and volumes add up,
since every inner edge or face counts once for each of its two sides.

Planes cut in their order, but only where something lies beyond them: each point knows the first plane that it is
beyond, and planes that do not meet on any edge cut at once. The result is that of one after the other.
In random order planes take few rounds (G. E. Blelloch, Y. Gu, J. Shun, Y. Sun, "Parallelism in randomized incremental
algorithms", J. ACM 67 (2020)).

References
----------
I. E. Sutherland, G. W. Hodgman, "Reentrant polygon clipping", Comm. ACM 17 (1974).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..mesh import polygons
from ..mesh.topology import edge_keys
from ..progress import Progress, advance, part_of, silent
from . import _voronoi_kernels as kernels
from .convex_domain import ConvexDomain


class Faces(NamedTuple):
    """Faces between cells in compressed rows, each looking out of its owner; -1 is the outside.

    In the plane each cell is one face, and nothing lies between them.
    """

    points: np.ndarray
    offsets: np.ndarray
    nodes: np.ndarray
    owner: np.ndarray
    neighbour: np.ndarray

    def only(self, which: np.ndarray) -> Faces:
        """Some faces, by a mask, on the same points."""
        rows = np.flatnonzero(which)
        taken = polygons.taken(self.offsets, self.nodes, rows)
        return Faces(self.points, *taken, self.owner[rows], self.neighbour[rows])


def clipped(faces: Faces, domain: ConvexDomain, progress: Progress = silent) -> Faces:
    """The cells within the domain, in the order of their owners; in space closed by new faces along its planes.

    Faces and cells wholly outside are left out.
    """
    first = domain.first_beyond(faces.points, progress=part_of(progress, 0.0, 0.2))
    touched = _any(first < domain.n_planes, faces.offsets, faces.nodes)
    if not touched.any():
        return faces
    part = faces.only(touched)
    number, nodes = polygons.numbered(part.nodes, len(faces.points))
    part = part._replace(points=faces.points[number], nodes=nodes)
    part = _cut(part, first[number], domain, part_of(progress, 0.2, 1.0))
    inner = domain.put_on(part.points)
    points = np.concatenate([faces.points, inner[len(number) :]])
    points[number] = inner[: len(number)]
    number = np.concatenate([number, np.arange(len(faces.points), len(points))])
    every = _joined([faces.only(~touched), part._replace(nodes=number[part.nodes])], points)
    order = np.argsort(every.owner, kind="stable")
    taken = polygons.taken(every.offsets, every.nodes, order)
    return Faces(points, *taken, every.owner[order], every.neighbour[order])


def _any(flag: np.ndarray, offsets: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """(m,) bool: whether any node of each row has the flag."""
    found = np.zeros(len(offsets) - 1, bool)
    hits = np.flatnonzero(flag[nodes])
    found[np.searchsorted(offsets, hits, side="right") - 1] = True
    return found


def _joined(parts: list[Faces], points: np.ndarray) -> Faces:
    """All faces of several parts."""
    sizes = np.concatenate([np.diff(part.offsets) for part in parts])
    nodes, owner, neighbour = (np.concatenate([part[k] for part in parts]) for k in (2, 3, 4))
    return Faces(points, np.concatenate([[0], np.cumsum(sizes)]), nodes, owner, neighbour)


def _cut(faces: Faces, first: np.ndarray, domain: ConvexDomain, progress: Progress) -> Faces:
    """What is inside of all planes; ``first`` has for each point the first plane that it is beyond.

    Points are added behind those that there are.
    """
    done, reached, finished = [], 0.0, 0
    while True:
        waits = _any(first < domain.n_planes, faces.offsets, faces.nodes)
        done.append(faces.only(~waits))
        faces = faces.only(waits)
        finished += len(done[-1].owner)
        if not waits.any():
            return _joined(done, faces.points)
        reached = max(reached, finished / (finished + len(faces.owner)))
        advance(progress, reached, "clipping cells")
        faces, first = _cut_once(faces, first, domain)


def _cut_once(faces: Faces, first: np.ndarray, domain: ConvexDomain) -> tuple[Faces, np.ndarray]:
    """Cut by all planes whose turn it is; faces that come out empty are left out."""
    points, offsets, nodes, owner, neighbour = faces
    after = polygons.following(offsets, nodes)
    beyond = _next_planes(first[nodes], first[after], domain.n_planes)[first]
    crossing = beyond[nodes] != beyond[after]
    key, edge = np.unique(
        edge_keys(np.column_stack([nodes[crossing], after[crossing]]), len(points)), return_inverse=True
    )
    ends = np.column_stack([key // len(points), key % len(points)])
    ends = np.where(beyond[ends[:, :1]], ends[:, ::-1], ends)  # from inside out
    plane = first[ends[:, 1]]
    made = domain.crossings(points[ends[:, 0]], points[ends[:, 1]], plane)
    first = np.concatenate([first, domain.first_beyond(made, after=plane)])
    # Each corner inside stays, and the point on each edge that crosses stands after the edge's first corner.
    stays = ~beyond[nodes]
    place = np.cumsum(stays.astype(np.int64) + crossing) - 1
    new = np.empty(place[-1] + 1, np.int64)
    new[place[crossing]] = len(points) + edge.reshape(-1)
    new[place[stays] - crossing[stays]] = nodes[stays]
    count = np.concatenate([[0], place + 1])[offsets]
    cut = Faces(np.concatenate([points, made]), count, new, owner, neighbour)
    left = cut.only(np.diff(count) > 0)
    if points.shape[1] == 2:
        return left, first
    leaving = crossing & stays
    start = place[leaving]
    row = np.searchsorted(offsets, np.flatnonzero(leaving), side="right") - 1
    end = polygons.following(count, new)[start]
    return _joined([left, _caps(cut, new[start], end, row)], cut.points), first


def _next_planes(start: np.ndarray, end: np.ndarray, n_planes: int) -> np.ndarray:
    """(n_planes + 1,) bool: which planes cut now, by the first planes that the ends of all edges are beyond.

    Corners of a cell that are beyond a plane hang together by edges. So where an earlier plane cuts some of them first,
    an edge leads from one to another that waits for that plane.
    """
    is_next = np.ones(n_planes + 1, bool)
    is_next[np.maximum(start, end)[start != end]] = False
    is_next[n_planes] = False
    return is_next


def _caps(faces: Faces, start: np.ndarray, end: np.ndarray, row: np.ndarray) -> Faces:
    """The faces that close cells along planes, where edges from ``start`` to ``end`` of rows are their cuts."""
    # Seen from the owner the new face runs against the cut face's edge, from the neighbour along it.
    inner = faces.neighbour[row] >= 0
    cell = np.concatenate([faces.owner[row], faces.neighbour[row[inner]]])
    start, end = np.concatenate([end, start[inner]]), np.concatenate([start, end[inner]])
    offsets, nodes, owner = _around(start, end, cell, len(faces.points))
    return Faces(faces.points, offsets, nodes, owner, np.full(len(owner), -1))


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
