"""Layers that fold at a few nodes are repaired there, where the equations' layer is not sound."""

from __future__ import annotations

import numpy as np

from . import _layer_repair_kernels as kernels
from .front_edges import Hold
from .front_graph import FrontGraph

GOOD = 0.05
"""Share of the wall's sine that corners should keep: nodes below, and those around, move."""
ROUNDS, LOOK = 60, 5
"""How often nodes move at most, and after how many times it is looked which need to."""
AROUND = 2
"""How many rings of neighbours may move too."""


def repair(graph: FrontGraph, hold: Hold, below: np.ndarray, above: np.ndarray, height: float) -> None:
    """Move nodes of a layer ``above``, near those at which cells fold, until none does, if that can be.

    Each goes down the slope of a sum over its corners, in which folded ones count most, and stays near where the
    equations put it. The nodes move one after the other, so that the result does not depend on who shares the work.

    Parameters
    ----------
    graph : FrontGraph
        The surface.
    hold : Hold
        What edges may do.
    below, above : (n, 3) float
        The last layer and this one, which is changed.
    height : float
        Of the layer.
    """
    n, target, slope = hold.marching, above.copy(), np.empty(3)
    topology = (graph.start, graph.ring, graph.opened)
    worst = np.ones(len(above))
    nodes = np.empty(0, np.int64)
    for number in range(ROUNDS):
        if number % LOOK == 0:
            kernels.worst_shares(0, n, graph.points, below, above, *topology, worst)
            if worst.min() > GOOD:
                return
            nodes = _around(graph, ~(worst > GOOD))
            nodes = nodes[nodes < n]
        moved = kernels.relax(
            nodes, graph.points, below, above, target, height, *topology, hold.row, hold.projectors, slope
        )
        hold.settle(above)
        if not moved:
            return


def _around(graph: FrontGraph, chosen: np.ndarray) -> np.ndarray:
    """(k,) int: nodes that are chosen, and those around them."""
    node = np.repeat(np.arange(len(chosen)), np.diff(graph.start))
    for _ in range(AROUND):
        beside = np.zeros_like(chosen)
        beside[node[chosen[graph.ring]]] = True
        chosen = chosen | beside
    return np.flatnonzero(chosen)
