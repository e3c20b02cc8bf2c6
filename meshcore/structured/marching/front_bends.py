"""Where a front is concave: the angles by which its faces bend towards each other."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .front_graph import FrontGraph

CONCAVE = 20.0
"""Degrees by which faces bend towards each other where the surface counts as concave."""
CONVEX = 1.0
"""Degrees up to which a surface counts as convex, and its layers cannot meet."""
BLIND = 1e-4
"""Cosine between a line and the normal of a face below which the face is not seen."""


class Bends(NamedTuple):
    """The bends at the edges inside a surface, each seen from both ends.

    Attributes
    ----------
    angle : (m,) float
        Degrees by which the two faces bend towards each other.
    middle : (m, 3) float
        Middle of the edge.
    width : (m,) float
        Mean height of the two faces over the edge.
    """

    angle: np.ndarray
    middle: np.ndarray
    width: np.ndarray


def concavity(graph: FrontGraph, place: np.ndarray) -> tuple[float, np.ndarray]:
    """Degrees by which the faces at the nearest concave edge bend towards each other, and its place; 0 if none is."""
    angle, middle, _ = bends(graph)
    concave = np.flatnonzero(angle > CONCAVE)
    if not len(concave):
        return 0.0, place
    nearest = concave[np.argmin(((middle[concave] - place) ** 2).sum(axis=1))]
    return float(angle[nearest]), middle[nearest]


def is_concave(graph: FrontGraph) -> bool:
    """Whether faces bend towards each other anywhere."""
    return bool((bends(graph).angle > CONVEX).any())


def concave_curvature(graph: FrontGraph) -> float:
    """Largest curvature by which the surface bends towards itself: its lines meet at the inverse of that."""
    angle, _, width = bends(graph)
    return max(0.0, float((np.radians(angle) / width).max(initial=0.0)))


def bends(graph: FrontGraph) -> Bends:
    """The bends at all edges inside."""
    count = np.diff(graph.start)
    node = np.repeat(np.arange(len(count)), count)
    k = np.arange(len(graph.ring)) - graph.start[node]
    before = graph.ring[graph.start[node] + (k - 1) % count[node]]
    after = graph.ring[graph.start[node] + (k + 1) % count[node]]
    edge, left, right = (graph.points[n] - graph.points[node] for n in (graph.ring, after, before))
    one, two = np.cross(right, edge), np.cross(edge, left)
    length = np.linalg.norm(edge, axis=1)
    sine = np.einsum("ij,ij->i", np.cross(one, two), edge) / length
    angle = np.degrees(np.arctan2(sine, np.einsum("ij,ij->i", one, two)))
    inner = (graph.opened[node] == 0) | ((k > 0) & (k < count[node] - 1))
    width = 0.5 * (np.linalg.norm(one, axis=1) + np.linalg.norm(two, axis=1)) / length
    return Bends(angle[inner], (graph.points[node] + 0.5 * edge)[inner], width[inner])


def blind_node(graph: FrontGraph, normal: np.ndarray) -> int:
    """The node whose line sees the faces around it least, if that is not at all, or -1."""
    count = np.diff(graph.start)
    node = np.repeat(np.arange(len(count)), count)
    k = np.arange(len(graph.ring)) - graph.start[node]
    after = graph.ring[graph.start[node] + (k + 1) % count[node]]
    corner = np.cross(graph.points[graph.ring] - graph.points[node], graph.points[after] - graph.points[node])
    cosine = np.einsum("ij,ij->i", corner, normal[node]) / np.maximum(np.linalg.norm(corner, axis=1), 1e-300)
    cosine[(graph.opened[node] == 1) & (k == count[node] - 1)] = 1.0
    worst = int(np.argmin(cosine))
    return int(node[worst]) if cosine[worst] <= BLIND else -1
