"""Layers that go on from a marched front to a given outer surface, and end on it (survey 2.7.2)."""

from __future__ import annotations

import itertools
from typing import Union

import numpy as np
from scipy.sparse import csr_matrix

from ...errors import InvalidInput
from ...geometry.closest import FacetedSurface
from ...mesh import Mesh, MultiBlock, StructuredGrid
from ...progress import Progress, advance
from ...sizing import cells_for_growth, geometric
from . import _layer_kernels as kernels
from .edge_conditions import FrontEdges
from .front_crossing import overlapping_node, winding
from .front_edges import Hold
from .front_graph import FrontGraph, at
from .layer_marching import SOUND, Outcome
from .layer_surface import LayerSurface

SHARE = 0.5
"""Of the least way to the outer surface: how much of it is marched."""
TRIES = (("parabolic", 1.0), ("parabolic", 20.0), ("lines", 0), ("lines", 40), ("lines", 160))
"""How the surface is tried to be reached: dissipation in units of height over spacing, or how often ends of lines are
averaged with their neighbours'."""
SMOOTHED = 5
"""How often directions towards the surface are averaged with their neighbours'."""
_STEPS, _NEAR, _HIT = 30, 1e-9, 1e-4
_SETTLING, _SWEEPS = 30, 60


class OuterSurface:
    """A surface at which layers end.

    Attributes
    ----------
    marching : int
        How many layers are marched before they turn to it; known once there are `heights`.
    warnings : list of str
        What there is to tell of the way.

    Parameters
    ----------
    given : Mesh, StructuredGrid or MultiBlock
        Triangles and quads.
    ready : LayerSurface
        The surface that is marched from.
    distance, largest_height : optional
        What was asked besides.

    Raises
    ------
    InvalidInput
        If it has no facets, touches the surface or does not hold it, or heights are asked for that it contradicts.
    """

    def __init__(self, given: Union[Mesh, StructuredGrid, MultiBlock], ready: LayerSurface, distance, largest_height):
        for name, value in (("distance", distance), ("largest_height", largest_height)):
            if value is not None:
                raise InvalidInput("is given beside an outer surface, which says how far layers go", parameter=name)
        points = ready.graph.points
        if ready.graph.part.any():
            raise InvalidInput(
                f"can be met by one surface only, but this one has {int(ready.graph.part.max()) + 1} parts; march off "
                "them one by one",
                parameter="outer",
            )
        mesh = given.to_mesh() if isinstance(given, (StructuredGrid, MultiBlock)) else given
        self.ready, self.surface, self.marching = ready, FacetedSurface(mesh, "outer"), 0
        self.warnings: list[str] = []
        self.size = float(np.linalg.norm(np.ptp(np.concatenate([mesh.points, points]), axis=0)))
        self.gaps = self.surface.closest(points).distance
        if not self.gaps.min() > _NEAR * self.size:
            raise InvalidInput(f"touches the surface at {at(points[np.argmin(self.gaps)])}", parameter="outer")
        turns = winding(self.surface.points[self.surface.corners] - points[0])
        if ready.is_closed and not ready.inwards and abs(turns) < 0.1:
            raise InvalidInput(f"does not go round the surface's point {at(points[0])}", parameter="outer")

    def heights(self, first: float, growth: float, layers: int | None) -> np.ndarray:
        """(layers,) float: heights of layers that come as far as this surface is on average.

        Parameters
        ----------
        first : float
            Height of the first.
        growth : float
            The largest growth, by which the number of layers is found.
        layers : int, optional
            Their number; growth follows from it.
        """
        nearest, mean = float(self.gaps.min()), float(self.gaps.mean())
        if first >= nearest:
            raise InvalidInput(
                f"is {first:.6g}, but the outer surface comes as near as {nearest:.6g}; make it smaller",
                parameter="first_height",
            )
        if layers is None:
            if growth <= 1:
                raise InvalidInput("must be above 1 for the number of layers to be found", parameter="growth")
            layers = cells_for_growth(first / float(self.gaps.max()), growth)
        fractions = np.array([0.0, 1.0]) if layers == 1 else geometric(layers, first=first / mean)
        heights = np.diff(fractions) * mean
        marching = int(np.searchsorted(np.cumsum(heights), SHARE * nearest, side="right"))
        self.marching = max(0, min(marching, layers - 2))
        return heights

    def joined(
        self, front: FrontEdges, layers: np.ndarray, heights: np.ndarray, outcome: Outcome, progress: Progress
    ) -> np.ndarray:
        """(k + 1, n, 3) layers of the surface's nodes that end on this one, or what was marched of them.

        Parameters
        ----------
        front : FrontEdges
            What was marched from.
        layers : (m + 1, ., 3) float
            Its front and sound layers.
        heights : (k,) float
            Of all layers.
        outcome : Outcome
            How the march went; tells in the end where layers would fold on their way here.
        progress : Progress
            Called with fraction and message.
        """
        made = len(layers) - 1
        tries = list(dict.fromkeys((made, max(0, made - 8), made // 2, made // 4, 0)))
        weights = _weights(front.graph, front.hold)
        for number, kept in enumerate(tries):
            advance(progress, number / len(tries), "on the way to the outer surface")
            whole, node = self._reached(front, weights, layers[: kept + 1], heights[kept:], outcome)
            if whole is not None:
                if kept < made or outcome.stopped_at >= 0:
                    self.warnings.append(f"{kept} layers are marched; those beyond head for the outer surface at once")
                outcome.stopped_at = -1
                return whole
            outcome.stopped_at = node if number == 0 else outcome.stopped_at
        outcome.why = "would fold on its way to the outer surface"
        return front.of_surface(layers, -1)[0]

    def _reached(
        self, front: FrontEdges, weights: csr_matrix, layers: np.ndarray, heights: np.ndarray, outcome: Outcome
    ) -> tuple[np.ndarray | None, int]:
        """Sound layers of the surface's nodes, or none; and a node where the last ones that were tried are not."""
        graph, hold = front.graph, front.hold
        node = 0
        for scheme, amount in TRIES:
            make = self._parabolic if scheme == "parabolic" else self._lines
            rest = make(graph, hold, weights, layers, heights, amount)
            worst = _worst_corners(graph, hold, np.concatenate([layers[-1:], rest]))
            node = int(np.argmin(worst))
            if worst[node] > SOUND:
                whole, _ = front.of_surface(np.concatenate([layers, rest]), -1)
                crossing = overlapping_node(self.ready.graph, whole)
                if crossing < 0:
                    outcome.worst = min(outcome.worst, float(worst[node]))
                    return whole, -1
                return None, crossing
        return None, front.of_surface(layers, node)[1]

    def _lines(self, graph, hold, weights, layers, heights, sweeps: float) -> np.ndarray:
        """(len(heights), n, 3): layers on lines that leave the last front as they came there, and end straight.

        Their ends are drawn to the mean of their neighbours', so that they do not cross.
        """
        front = layers[-1]
        ahead = _units(front - layers[-2]) if len(layers) > 1 else _normals(graph, hold, front)
        direction = ahead
        for _ in range(int(sweeps)):
            direction = _units(direction + _images_of(weights @ direction, hold))
        ends = self._met(hold, front, direction)
        for _ in range(int(sweeps)):
            ends = self._on(hold, front, ends + 0.7 * _along_edges(graph, hold, weights @ ends - ends, ends))
        way = ends - front
        share = self._shares(heights, way)[1:, :, None]
        turn = share * share * (3 - 2 * share)
        rest = front + share * ((1 - turn) * ahead * np.linalg.norm(way, axis=1)[:, None] + turn * way)
        for layer in rest[:-1]:
            hold.settle(layer)
        rest[-1] = ends
        return rest

    def _parabolic(self, graph, hold, weights, layers, heights, strength: float) -> np.ndarray:
        """(len(heights), n, 3): layers marched from the last front to the surface.

        Each is a part of the way to the surface, along the front's normals; the local reference grid of parabolic
        marches. It is held smooth along itself by the elliptic equation's second difference, and dissipation besides.
        """
        front, count = layers[-1], len(heights)
        ahead = _units(front - layers[-2]) if len(layers) > 1 else np.zeros_like(front)
        layers = []
        share = self._shares(heights, self._way(graph, hold, weights, front, ahead)[0])
        for k in range(count):
            way, normal = self._way(graph, hold, weights, front, (1 - share[k])[:, None] * ahead)
            move = ((share[k + 1] - share[k]) / (1 - share[k]))[:, None] * way
            front = _smoothed(graph, hold, weights, front, move, normal, strength)
            layers.append(self._on(hold, front, front) if k == count - 1 else front)
        return np.stack(layers)

    def _shares(self, heights: np.ndarray, way: np.ndarray) -> np.ndarray:
        """(len(heights) + 1, n): the share of its way at which each line comes to each layer."""
        length = np.maximum(np.linalg.norm(way, axis=1), _NEAR * self.size)  # of lines that pass by
        return fractions(len(heights), np.minimum(heights[0] / length, 1 / len(heights)))

    def _way(self, graph: FrontGraph, hold: Hold, weights: csr_matrix, front: np.ndarray, ahead: np.ndarray):
        """(n, 3): from each node to the surface, along normals turned to where lines come from; and the normals."""
        normal = _normals(graph, hold, front)
        direction = _units(normal + ahead)
        for _ in range(SMOOTHED):
            direction = _units(direction + _images_of(weights @ direction, hold))
        return self._met(hold, front, direction) - front, normal

    def _met(self, hold: Hold, front: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """Where rays from the front meet the surface; rays that pass by end at its nearest place.

        Each goes on by its distance from the surface, so that it cannot pass through (J. C. Hart, "Sphere tracing",
        1996).
        """
        x = front.copy()
        on_its_way = np.arange(len(x))
        for _ in range(_STEPS):
            distance = self.surface.closest(x[on_its_way]).distance
            x[on_its_way] += distance[:, None] * direction[on_its_way]
            far = np.linalg.norm(x[on_its_way] - front[on_its_way], axis=1) > 2 * self.size
            x[on_its_way[far]] = front[on_its_way[far]]
            on_its_way = on_its_way[~far & (distance > _HIT * self.size)]
            if not len(on_its_way):
                break
        return self._on(hold, front, x)

    def _on(self, hold: Hold, front: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Points put on the surface; those of edges also in their planes and on their guides."""
        held = np.flatnonzero(hold.row >= 0)
        points = self.surface.closest(points).points
        for _ in range(_SETTLING if len(held) else 0):
            before = points[held]
            away = np.einsum("mpq,mq->mp", hold.projectors[hold.row[held]], before - front[held])
            points[held] = front[held] + away
            hold.settle(points)
            if np.abs(points[held] - before).max() < 1e-14 * self.size:
                break
            points[held] = self.surface.closest(points[held]).points
        points[held] = front[held] + np.einsum(
            "mpq,mq->mp", hold.projectors[hold.row[held]], points[held] - front[held]
        )
        hold.images.set_places(points)
        return points


def fractions(count: int, first: np.ndarray) -> np.ndarray:
    """(count + 1, n) float: fractions from 0 to 1 of cells that grow geometrically, for (n,) first ones of each line.

    Examples
    --------
    >>> fractions(3, np.array([1 / 7, 1 / 3])).round(4)[:, 0]
    array([0.    , 0.1429, 0.4286, 1.    ])
    """
    low, high = np.zeros(len(first)), np.full(len(first), np.log(1e6))
    steps = np.arange(count)[:, None]
    for _ in range(60):
        middle = 0.5 * (low + high)
        short = (first * np.exp(np.minimum(steps * middle, 600.0))).sum(axis=0) < 1
        low, high = np.where(short, middle, low), np.where(short, high, middle)
    cells = np.exp(steps * high - (count - 1) * high)
    return np.concatenate([np.zeros((1, len(first))), np.cumsum(cells, axis=0) / cells.sum(axis=0)])


def _smoothed(graph, hold, weights, front, move, normal, strength) -> np.ndarray:
    """A front that is moved, and then smoothed implicitly; where it is convex along itself only."""
    ahead = front + move
    hold.images.set_places(ahead)
    high = np.linalg.norm(move, axis=1)
    ratio = high / _spacing(graph, front)
    e = (ratio**2 + strength * ratio)[:, None]
    bend = weights @ ahead - ahead
    up = np.einsum("mq,mq->m", bend, normal)
    bend = _along_edges(graph, hold, bend - np.minimum(up, 0.0)[:, None] * normal, ahead)
    d = np.zeros_like(ahead)
    for _ in range(_SWEEPS):
        new = _images_of(_along_edges(graph, hold, e * (bend + weights @ d) / (1 + e), ahead), hold)
        change, d = np.abs(new - d).max(), new
        if change < 1e-3 * high.max():
            break
    ahead += d
    hold.settle(ahead)
    return ahead


def _weights(graph: FrontGraph, hold: Hold) -> csr_matrix:
    """The mean of each node's ring by the wall's weights, in which the wall's own spacing is at rest."""
    n = len(graph.points)
    topology = (graph.start, graph.ring, graph.opened)
    normal, weight = np.zeros((n, 3)), np.zeros(len(graph.ring))
    hold.aim(graph.points)
    kernels.normals(0, hold.marching, graph.points, *topology, hold.row, hold.projectors, kernels.SEEN, normal)
    kernels.ring_weights(0, hold.marching, graph.points, normal, *topology, hold.free, weight)
    hold.weigh(weight, graph.start)
    alone = np.concatenate([np.add.reduceat(weight, graph.start[: hold.marching]), np.ones(n - hold.marching)]) == 0
    return csr_matrix((weight, graph.ring, graph.start), (n, n)) + csr_matrix(
        (np.ones(alone.sum()), (np.flatnonzero(alone), np.flatnonzero(alone))), (n, n)
    )


def _along_edges(graph: FrontGraph, hold: Hold, step: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Steps of nodes on free edges only along these, of others as their conditions let them."""
    nodes = np.flatnonzero(hold.free)
    if len(nodes):
        along = points[graph.ring[graph.start[nodes]]] - points[graph.ring[graph.start[nodes + 1] - 1]]
        along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)
        step[nodes] = np.einsum("mq,mq->m", step[nodes], along)[:, None] * along
    held = np.flatnonzero(hold.row >= 0)
    step[held] = np.einsum("mpq,mq->mp", hold.projectors[hold.row[held]], step[held])
    return step


def _normals(graph: FrontGraph, hold: Hold, front: np.ndarray) -> np.ndarray:
    normal = np.zeros_like(front)
    hold.aim(front)
    topology = (graph.start, graph.ring, graph.opened)
    kernels.normals(0, hold.marching, front, *topology, hold.row, hold.projectors, kernels.SEEN, normal)
    return _images_of(normal, hold)


def _spacing(graph: FrontGraph, front: np.ndarray) -> np.ndarray:
    """Harmonic mean distance of each node to its ring; 1 for images."""
    node = np.repeat(np.arange(len(front)), np.diff(graph.start))
    inverse = 1 / np.linalg.norm(front[graph.ring] - front[node], axis=1)
    total = np.bincount(node, weights=inverse, minlength=len(front))
    return np.divide(np.diff(graph.start), total, out=np.ones(len(front)), where=total > 0)


def _images_of(vectors: np.ndarray, hold: Hold) -> np.ndarray:
    hold.images.set_vectors(vectors)
    return vectors


def _worst_corners(graph: FrontGraph, hold: Hold, layers: np.ndarray) -> np.ndarray:
    """(n,) float: least sine of the corners at each node of the cells between layers."""
    least, worst = np.ones(len(graph.points)), np.ones(len(graph.points))
    topology = (graph.start, graph.ring, graph.opened)
    for below, above in itertools.pairwise(layers):
        kernels.corner_volumes(0, hold.marching, 0.0, below, above, *topology, worst)
        np.minimum(least, worst, out=least)
    return least


def _units(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-300)
