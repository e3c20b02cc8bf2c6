"""Fronts that meet themselves or each other: cells may all be sound, and lie over one another."""

from __future__ import annotations

import numpy as np

from ...geometry.alternating_digital_tree import Tree
from . import _front_crossing_kernels as kernels
from .front_graph import FrontGraph

LEVELS = 6
"""Layers looked at: the outermost one, and those at the surface's size, half of it, a quarter and so on; and twice."""


def crossing_node(graph: FrontGraph, points: np.ndarray) -> int:
    """A node of a front where it passes through itself, or -1.

    Quads count as two triangles. An edge that passes through a triangle of which it has no node is looked for, by an
    alternating digital tree.
    """
    faces = graph.faces
    quads = faces[:, 3] >= 0
    triangles = np.concatenate([faces[:, :3], faces[quads][:, [0, 2, 3]]])
    corners = points[triangles]
    tree = Tree(corners.min(axis=1), corners.max(axis=1))
    node = np.repeat(np.arange(len(points)), np.diff(graph.start))
    edges = np.column_stack([node, graph.ring])[node < graph.ring]
    crossed = np.empty(len(edges), np.int64)
    kernels.crossings(
        0, len(edges), points, edges, triangles, tree.order, tree.right, tree.first, tree.bounds,
        np.empty(kernels.DEPTH, np.int64), crossed,
    )  # fmt: skip
    found = np.flatnonzero(crossed >= 0)
    return int(edges[found[0], 0]) if len(found) else -1


def clear_layers(graph: FrontGraph, layers: np.ndarray, distance: np.ndarray) -> tuple[int, int]:
    """How many of the layers do not cross themselves, and a node where the next one does, or -1.

    Layers lie in one another, so the last that is clear is found by halving.

    Parameters
    ----------
    graph : FrontGraph
        The surface.
    layers : (k + 1, n, 3) float
        The surface and its layers.
    distance : (k + 1,) float
        How far each is from the surface.
    """
    last = len(layers) - 1
    size = float(np.linalg.norm(np.ptp(graph.points, axis=0)))
    steps = np.arange(1 - LEVELS, max(1, int(np.log2(distance[-1] / size)) + 1))
    looked = np.append(np.searchsorted(distance, size * 2.0**steps), last)
    clear, bad, node = 0, last + 1, -1
    for k in np.unique(looked[(looked > 0) & (looked <= last)]).tolist():
        node = crossing_node(graph, layers[k])
        if node >= 0:
            bad = k
            break
        clear = k
    while bad - clear > 1:
        middle = (clear + bad) // 2
        found = crossing_node(graph, layers[middle])
        if found >= 0:
            bad, node = middle, found
        else:
            clear = middle
    return (last, -1) if node < 0 else (clear, node)


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
