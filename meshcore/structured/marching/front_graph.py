"""The front of layers as a graph: nodes with their rings of neighbours, from grids, blocks and meshes alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ...errors import InvalidGeometry
from ...mesh import topology
from . import _front_graph_kernels as kernels


@dataclass(frozen=True, eq=False)
class FrontGraph:
    """A surface by its nodes, turned so that its faces are counter-clockwise from the side that is marched to.

    Attributes
    ----------
    points : (n, 3) float
        Nodes; each place once.
    faces : (m, 4) int
        Nodes of the faces; triangles have -1 last.
    start, ring : (n + 1,), (k,) int
        Offsets, and neighbours in order round each node.
    opened : (n,) int
        1 on edges of the surface, where the ring is open.
    part : (m,) int
        Number of the connected part of each face.
    """

    points: np.ndarray
    faces: np.ndarray
    start: np.ndarray
    ring: np.ndarray
    opened: np.ndarray
    part: np.ndarray


def welded(points: np.ndarray, gap: float) -> tuple[np.ndarray, np.ndarray]:
    """Points with those no farther apart than ``gap`` made one, and the number of each in these."""
    pairs = cKDTree(points).query_pairs(gap, output_type="ndarray")
    if not len(pairs):
        return points, np.arange(len(points))
    number = topology.connected(pairs, len(points))
    first = np.full(number.max() + 1, len(points))
    np.minimum.at(first, number, np.arange(len(points)))
    return points[first], number


def without_repeats(faces: np.ndarray) -> np.ndarray:
    """(m, 4) faces whose collapsed edges are taken out: quads become triangles; fewer corners leave -1 in the third."""
    shown = faces.copy()
    kept = (faces >= 0) & (faces != _following(faces))
    order = np.argsort(~kept, axis=1, kind="stable")
    shown = np.take_along_axis(np.where(kept, faces, -1), order, axis=1)
    return shown


def _following(faces: np.ndarray) -> np.ndarray:
    """(m, 4) int: the node after each node in its face."""
    after = np.roll(faces, -1, axis=1)
    triangle = faces[:, 3] < 0
    after[triangle, 2] = faces[triangle, 0]
    return after


def turned_alike(faces: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
    """Faces turned so that neighbours agree, the number of each one's connected part, and how many were turned.

    Raises
    ------
    InvalidGeometry
        If more than two faces meet at an edge, or no turning makes neighbours agree, as on a Moebius strip.
    """
    after = _following(faces)
    where = np.flatnonzero((faces >= 0).ravel())
    a, b, owner = faces.ravel()[where], after.ravel()[where], where // 4
    key = np.minimum(a, b) * len(points) + np.maximum(a, b)
    order = np.argsort(key, kind="stable")
    key, owner, forward = key[order], owner[order], (a < b)[order]
    same = key[1:] == key[:-1]
    crowded = np.flatnonzero(same[1:] & same[:-1])
    if len(crowded):
        a, b = divmod(int(key[crowded[0]]), len(points))
        raise InvalidGeometry(
            f"more than two faces meet at {len(np.unique(key[crowded]))} edges, the first from {at(points[a])} to "
            f"{at(points[b])}; layers need a surface with one outside: remove the inner faces",
            parameter="surface",
            points=(a, b),
        )
    first = np.flatnonzero(same)
    f, g, agree = owner[first], owner[first + 1], (forward[first] != forward[first + 1]).astype(np.int64)
    ends, others, agrees = np.concatenate([f, g]), np.concatenate([g, f]), np.concatenate([agree, agree])
    order = np.argsort(ends, kind="stable")
    start = np.concatenate([[0], np.cumsum(np.bincount(ends, minlength=len(faces)))])
    turned, part, stack = np.zeros(len(faces), np.int64), np.full(len(faces), -1), np.empty(len(faces), np.int64)
    bad = kernels.turn_alike(start, others[order], agrees[order], turned, part, stack)
    if bad >= 0:
        raise InvalidGeometry(
            f"its faces cannot all be turned alike, found near {at(points[faces[bad, 0]])}: it has one side only, "
            "as a Moebius strip; cut it",
            parameter="surface",
            points=faces[bad][faces[bad] >= 0],
        )
    # The fewer faces of each part are turned.
    most = np.bincount(part, weights=turned) * 2 > np.bincount(part)
    turned ^= most[part]
    flip = turned.astype(bool)
    return np.where(flip[:, None], reversed_faces(faces), faces), part, int(flip.sum())


def reversed_faces(faces: np.ndarray) -> np.ndarray:
    """The faces seen from the other side; each keeps its first node."""
    quad = faces[:, [0, 3, 2, 1]]
    return np.where(faces[:, 3:] < 0, faces[:, [0, 2, 1, 3]], quad)


def front_graph(
    points: np.ndarray,
    faces: np.ndarray,
    part: np.ndarray,
    *,
    corners: np.ndarray | None = None,
    marching: int | None = None,
) -> FrontGraph:
    """The graph of faces that are turned alike.

    Parameters
    ----------
    points, faces, part
        As those of the graph.
    corners : (m, 4) bool, optional
        Corners of the faces that nodes see; by default all.
    marching : int, optional
        Number of nodes with a ring, which come first; the others only have places.

    Raises
    ------
    InvalidGeometry
        If parts of the surface touch in a single point.
    """
    after = _following(faces)
    before = np.roll(faces, 1, axis=1)
    triangle = faces[:, 3] < 0
    before[triangle, 0] = faces[triangle, 2]
    where = np.flatnonzero((faces >= 0 if corners is None else corners).ravel())
    node = faces.ravel()[where]
    order = np.argsort(node, kind="stable")
    count = len(points) if marching is None else marching
    corner_start = np.concatenate([[0], np.cumsum(np.bincount(node, minlength=count))])
    start, opened = np.empty(count + 1, np.int64), np.zeros(len(points), np.int64)
    ring = np.empty(2 * len(node), np.int64)
    bad = kernels.rings(corner_start, after.ravel()[where][order], before.ravel()[where][order], start, ring, opened)
    if bad >= 0:
        raise InvalidGeometry(
            f"parts of it touch in a single point, {at(points[bad])}; separate them, join them by faces, or "
            "split edges that others end on",
            parameter="surface",
            points=(bad,),
        )
    start = np.concatenate([start, np.full(len(points) - count, start[-1])])
    return FrontGraph(points, faces, start, ring[: start[-1]].copy(), opened, part)


def at(place: np.ndarray) -> str:
    """A place as text."""
    return "(" + ", ".join(f"{float(v):.6g}" for v in place) + ")"
