"""Fronts that meet themselves or each other: cells may all be sound, and lie over one another."""

from __future__ import annotations

import numpy as np

from ...geometry import predicates
from ...geometry.alternating_digital_tree import Tree
from . import _front_crossing_kernels as kernels
from .front_graph import FrontGraph


def clear_layers(graph: FrontGraph, layers: np.ndarray) -> tuple[int, int]:
    """How many of the layers do not lie over one another, and a node where the next one does, or -1.

    What the layers fill grows from layer to layer, so the last that is clear is found by halving; and once they lie
    over one another they do so for ever, so that mostly one look is enough.

    Parameters
    ----------
    graph : FrontGraph
        The surface.
    layers : (k + 1, n, 3) float
        The surface and its layers.
    """
    last = len(layers) - 1
    clear, bad, node = 0, last + 1, -1
    middle = last
    while bad - clear > 1:
        found = overlapping_node(graph, layers[: middle + 1])
        if found >= 0:
            bad, node = middle, found
        else:
            clear = middle
        middle = (clear + bad) // 2
    return (last, -1) if node < 0 else (clear, node)


def overlapping_node(graph: FrontGraph, layers: np.ndarray) -> int:
    """A node above which what the layers fill lies over itself, or -1.

    Cells that are all sound fill each place once if and only if the boundary of what they fill, surface, outermost
    layer and the sheets that edges leave, does not pass through itself, and no part of it lies in another.
    """
    n = len(graph.points)
    faces = _boundary(graph, len(layers) - 1)
    quads = faces[:, 3] >= 0
    triangles = np.concatenate([faces[:, :3], faces[quads][:, [0, 2, 3]]])
    points = np.ascontiguousarray(layers.reshape(-1, 3))
    node = _crossing(points, np.arange(len(points)) % n, triangles, _edges(faces))
    if node >= 0 or not graph.part.any():
        return node
    part = np.empty(n, np.int64)
    part[graph.faces[:, :3]] = graph.part[:, None]
    part[graph.faces[graph.faces[:, 3] >= 0, 3]] = graph.part[graph.faces[:, 3] >= 0]
    return _inside_another(points, part[triangles[:, 0] % n], triangles, part)


def _boundary(graph: FrontGraph, count: int) -> np.ndarray:
    """(m, 4) int: faces of the boundary of ``count`` layers, outwards; of none the surface."""
    n = len(graph.points)
    outer = np.where(graph.faces < 0, -1, graph.faces + n * count)
    if count == 0:
        return outer
    triangle = graph.faces[:, 3:] < 0
    wall = np.where(triangle, graph.faces[:, [0, 2, 1, 3]], graph.faces[:, [0, 3, 2, 1]])
    edge = np.flatnonzero(graph.opened)
    after = graph.ring[graph.start[edge]]
    sheet = np.column_stack([after + n, edge + n, edge, after])
    sheets = (sheet + n * np.arange(count)[:, None, None]).reshape(-1, 4)
    return np.concatenate([outer, wall, sheets])


def _edges(faces: np.ndarray) -> np.ndarray:
    """(k, 2) int: the edges of faces, each once."""
    after = np.roll(faces, -1, axis=1)
    triangle = faces[:, 3] < 0
    after[triangle, 2] = faces[triangle, 0]
    ends = np.stack([faces, after], axis=-1)[faces >= 0]
    low, high = ends[(ends >= 0).all(axis=1)].T
    size = int(faces.max()) + 1
    return np.column_stack(divmod(np.unique(np.minimum(low, high) * size + np.maximum(low, high)), size))


def _crossing(points: np.ndarray, column: np.ndarray, triangles: np.ndarray, edges: np.ndarray) -> int:
    """The column of an edge that passes through a triangle of none of its columns, or -1; by a tree of the boxes."""
    corners = points[triangles]
    tree = Tree(corners.min(axis=1), corners.max(axis=1))
    crossed = np.empty(len(edges), np.int64)
    kernels.crossings(
        0, len(edges), points, column, edges, triangles, tree.order, tree.right, tree.first, tree.bounds,
        np.empty(kernels.DEPTH, np.int64), predicates.workspace(), crossed,
    )  # fmt: skip
    found = np.flatnonzero(crossed >= 0)
    return int(column[edges[found[0], 0]]) if len(found) else -1


def _inside_another(points: np.ndarray, owner: np.ndarray, triangles: np.ndarray, part: np.ndarray) -> int:
    """A node of a part that lies wholly in what another fills, or -1: it is wound round by the other's boundary."""
    nodes = np.unique(part, return_index=True)[1]
    for k in range(len(nodes)):
        corners = points[triangles[owner == k]]
        low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
        near = nodes[((points[nodes] >= low) & (points[nodes] <= high)).all(axis=1)]
        for node in near[part[near] != k].tolist():
            if abs(winding(corners - points[node])) > 0.5:
                return node
    return -1


def winding(corners: np.ndarray) -> float:
    """How often (m, 3, 3) triangles of a closed surface go round the origin (A. van Oosterom, J. Strackee, 1983)."""
    a, b, c = corners.transpose(1, 0, 2)
    u, v, w = (np.linalg.norm(x, axis=1) for x in (a, b, c))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    scale = u * v * w + (a * b).sum(axis=1) * w + (b * c).sum(axis=1) * u + (c * a).sum(axis=1) * v
    return float(np.arctan2(volume, scale).sum() / (2 * np.pi))


def emptied_layer(graph: FrontGraph, layers: np.ndarray) -> int:
    """The first layer that leaves nothing of the inside of a closed surface that is marched into, or their number."""
    a, b, c, d = (graph.faces[:, k] for k in range(4))
    d = np.where(d < 0, c, d)
    for k, layer in enumerate(layers):
        p = layer - layer.mean(axis=0)
        six = np.cross(p[b], p[c]) + np.cross(p[c], p[d])
        if np.bincount(graph.part, weights=np.einsum("ij,ij->i", p[a], six)).max() >= 0:
            return k
    return len(layers)
