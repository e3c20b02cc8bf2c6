"""What the edges of an open surface do while layers are marched from it: free, on a plane, or leaning outwards."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from ...errors import InvalidGeometry, InvalidInput
from ...mesh import topology
from .front_graph import FrontGraph, at

EdgeChoice = Literal["automatic", "free", "plane", "constant x", "constant y", "constant z", "splay"]
CORNER = 40.0
"""Degrees by which an edge turns at the corner between two sides."""
FLAT = 1e-6
"""Distance from a plane, in units of a side's length, up to which the side lies in it."""
UPRIGHT = 30.0
"""Degrees by which a surface may miss the right angle with its plane of symmetry."""


class Hold(NamedTuple):
    """What the nodes on edges may do.

    Attributes
    ----------
    row : (n,) int
        Row of `projectors` for each node, or -1.
    projectors : (m, 3, 3) float
        Onto the plane or line in which a node stays.
    free : (n,) int
        1 at nodes of free edges.
    splay : float
        Degrees by which the lines of free edges lean outwards.
    """

    row: np.ndarray
    projectors: np.ndarray
    free: np.ndarray
    splay: float = 0.0


class Side(NamedTuple):
    """A stretch of the surface's edge between corners: its nodes, and the normal of the plane it stays in, or None."""

    nodes: np.ndarray
    plane: np.ndarray | None


def free_edges(graph: FrontGraph, splay: float = 0.0) -> Hold:
    """All edges free."""
    return Hold(np.full(len(graph.points), -1), np.zeros((1, 3, 3)), graph.opened, splay)


def held_edges(graph: FrontGraph, normal: np.ndarray, choice: EdgeChoice, splay: float) -> tuple[Hold, list[Side]]:
    """What a choice means at the edges of a surface, and its sides.

    Parameters
    ----------
    graph : FrontGraph
        The surface.
    normal : (n, 3) float
        Its normals at the nodes.
    choice : str
        "automatic" finds planes of symmetry: sides that lie in a plane which the surface meets nearly at right angles;
        a straight side stays in the plane that it spans with the normals. The other sides are free.
    splay : float
        Degrees.

    Raises
    ------
    InvalidInput
        If a condition is asked for but the surface is closed, or a side does not lie in a plane as was asked.
    """
    if not graph.opened.any():
        if choice not in ("automatic", "free"):
            raise InvalidInput(f"is {choice!r}, but the surface is closed and has no edges", parameter="edges")
        return free_edges(graph), []
    sides = [Side(nodes, _plane_of(graph.points[nodes], normal[nodes], choice)) for nodes in _sides(graph)]
    if choice == "plane":
        for side in sides:
            if side.plane is None:
                raise InvalidGeometry(
                    f"the edge near {at(graph.points[side.nodes[0]])} lies in no plane that the surface meets at a "
                    "right angle; take edges='automatic', or constant x, y or z",
                    parameter="surface",
                    points=side.nodes,
                )
    return _hold(graph, sides, splay if choice == "splay" else 0.0), sides


def _sides(graph: FrontGraph) -> list[np.ndarray]:
    """Nodes of each side, both ends included."""
    nodes = np.flatnonzero(graph.opened)
    after, before = graph.ring[graph.start[nodes]], graph.ring[graph.start[nodes + 1] - 1]
    place = graph.points
    leaving, coming = _units(place[after] - place[nodes]), _units(place[nodes] - place[before])
    smooth = np.einsum("ij,ij->i", leaving, coming) > np.cos(np.radians(CORNER))
    # The edge from a node to the next has the number of the node.
    number = np.zeros(len(place), np.int64)
    number[nodes] = np.arange(len(nodes))
    pairs = np.column_stack([number[before], number[nodes]])[smooth]
    side = topology.connected(pairs, len(nodes))
    return [np.union1d(nodes[side == k], after[side == k]) for k in range(side.max() + 1)]


def _plane_of(points: np.ndarray, normals: np.ndarray, choice: EdgeChoice) -> np.ndarray | None:
    if choice.startswith("constant"):
        return np.eye(3)["xyz".index(choice[-1])]
    if choice in ("free", "splay"):
        return None
    centred = points - points.mean(axis=0)
    size, axes = np.linalg.svd(centred, full_matrices=True)[1:]
    size = np.append(size, np.zeros(3))
    extent = np.linalg.norm(np.ptp(points, axis=0))
    if size[1] <= FLAT * extent * np.sqrt(len(points)):
        plane = np.cross(axes[0], normals.mean(axis=0))
        plane /= np.linalg.norm(plane) or 1.0
    else:
        plane = axes[2]
    flat = np.abs(centred @ plane).max() <= FLAT * extent
    upright = np.abs(normals @ plane).max() <= np.sin(np.radians(UPRIGHT))
    # A tidy normal keeps a coordinate of the plane to the last bit.
    axis = int(np.argmax(np.abs(plane)))
    plane = np.eye(3)[axis] if abs(plane[axis]) > 1 - 1e-12 else plane
    return plane if flat and upright else None


def _hold(graph: FrontGraph, sides: list[Side], splay: float) -> Hold:
    planes: dict[int, list[np.ndarray]] = {}
    free = np.zeros(len(graph.points), np.int64)
    for side in sides:
        if side.plane is None:
            free[side.nodes] = 1
        else:
            for node in side.nodes.tolist():
                planes.setdefault(node, []).append(side.plane)
    row = np.full(len(graph.points), -1)
    row[list(planes)] = np.arange(len(planes))
    projectors = np.empty((max(len(planes), 1), 3, 3))
    for k, normals in enumerate(planes.values()):
        values, vectors = np.linalg.eigh(sum(np.outer(n, n) for n in normals))
        across = vectors[:, values > 1e-6]
        projectors[k] = np.where(np.abs(p := np.eye(3) - across @ across.T) < 1e-15, 0.0, p)
    return Hold(row, projectors, free, splay)


def _units(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
