"""What the nodes on edges of a front may do while it marches: stay in planes or on guides, lean, repeat others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from .edge_guides import Guide
from .edge_sides import Side
from .front_graph import FrontGraph
from .periodic_edges import NO_IMAGES, Images

_SETTLING = 20
_MEET = 1e-3
"""Sine of the angle between two surfaces below which a node is held by one of them only."""


class Condition(NamedTuple):
    """What one side does.

    Attributes
    ----------
    kind : str
        "free", "plane", "constant", "splay", "guide" or "periodic". Planes are of symmetry; at a constant coordinate
        the surface ends.
    plane : (3,) float, optional
        Normal of the plane in which it stays.
    splay : float
        Degrees by which its lines lean outwards.
    """

    kind: str = "free"
    plane: np.ndarray | None = None
    splay: float = 0.0

    @property
    def ends(self) -> bool:
        """Whether the surface ends at the side, instead of being mirrored or running on: nodes look along it only."""
        return self.kind not in ("plane", "periodic")


class Leaning(NamedTuple):
    """Nodes whose lines lean outwards: their numbers, the nodes between which the edge runs there, and degrees."""

    nodes: np.ndarray
    ahead: np.ndarray
    behind: np.ndarray
    degrees: np.ndarray


class Guided(NamedTuple):
    """Nodes on guides: whether on a curve, how far above the surface, and up to two planes in which they stay too."""

    nodes: np.ndarray
    on_curve: np.ndarray
    heights: np.ndarray
    planes: np.ndarray
    through: np.ndarray


_NONE = np.empty(0, np.int64)
NO_LEANING = Leaning(_NONE, _NONE, _NONE, np.empty(0))
NOT_GUIDED = Guided(_NONE, np.empty(0, bool), np.empty(0), np.empty((0, 2, 3)), np.empty((0, 3)))


@dataclass(frozen=True, eq=False)
class Hold:
    """What nodes may do, as kernels and the march ask it.

    Attributes
    ----------
    row : (n,) int
        Row of `projectors` for each node, or -1.
    projectors : (m, 3, 3) float
        Onto the plane or line in which a node may move. Those of nodes on guides change on the way.
    free : (n,) int
        1 at nodes all of whose sides are free.
    leaning : Leaning
    outer_slots : (k,) int
        Places in rings whose neighbours do not count, since they lie inwards of a side that ends there.
    guide, guided
        What edges stay on, and the nodes that do.
    images : Images
        Nodes that do what others do.
    """

    row: np.ndarray
    projectors: np.ndarray
    free: np.ndarray
    leaning: Leaning = NO_LEANING
    outer_slots: np.ndarray = field(default_factory=lambda: _NONE)
    guide: Guide | None = None
    guided: Guided = NOT_GUIDED
    images: Images = NO_IMAGES

    @property
    def marching(self) -> int:
        """Number of nodes that march; those that follow are images of them."""
        return len(self.row) - len(self.images.nodes)

    def aim(self, front: np.ndarray) -> None:
        """Let nodes on guides move along these where they are now."""
        if len(self.guided.nodes):
            self.projectors[self.row[self.guided.nodes]] = np.eye(3) - self._inverse_of(front)[2]

    def stuck(self, front: np.ndarray) -> np.ndarray:
        """Nodes whose conditions leave them no way to go."""
        self.aim(front)
        ways = np.trace(self.projectors, axis1=1, axis2=2)
        return np.flatnonzero((self.row >= 0) & (ways[self.row] < 0.5))

    def lean(self, front: np.ndarray, normal: np.ndarray) -> None:
        """Turn the normals on edges that splay outwards."""
        nodes, ahead, behind, degrees = self.leaning
        if len(nodes):
            outwards = _units(np.cross(front[ahead] - front[behind], normal[nodes]))
            angle = np.radians(degrees)[:, None]
            leant = np.cos(angle) * normal[nodes] + np.sin(angle) * outwards
            held = self.row[nodes] >= 0
            leant[held] = np.einsum("mpq,mq->mp", self.projectors[self.row[nodes[held]]], leant[held])
            normal[nodes] = _units(leant)

    def settle(self, front: np.ndarray) -> None:
        """Put nodes on their guides, and images where they belong."""
        nodes, _, _, planes, through = self.guided
        for _ in range(_SETTLING if len(nodes) else 0):
            inverse, off, _ = self._inverse_of(front)
            step = np.einsum("mpq,mq->mp", inverse, off)
            front[nodes] -= step
            if np.abs(step).max() <= 1e-15 * self.guide.diagonal:
                break
        for k in range(2):  # a coordinate that is to be kept is kept to the last bit
            m, axis = np.nonzero(np.abs(planes[:, k]) == 1.0)
            front[nodes[m], axis] = through[m, axis]
        self.images.set_places(front)

    def weigh(self, weight: np.ndarray, start: np.ndarray) -> None:
        """Let only those neighbours of nodes on sides that end there count which lie along them."""
        if len(self.outer_slots):
            weight[self.outer_slots] = 0.0
            nodes = np.unique(np.searchsorted(start, self.outer_slots, side="right") - 1)
            for node in nodes.tolist():
                ring = slice(start[node], start[node + 1])
                weight[ring] /= weight[ring].sum() or 1.0

    def _inverse_of(self, front: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(m, 3, 5): shortest way that makes up for what nodes are off the guide, (m, 5), and projectors off it."""
        nodes, on_curve, heights, planes, through = self.guided
        x = front[nodes]
        foot, off = self.guide.constraints(x, on_curve, heights)
        matrix = np.concatenate([off, planes], axis=1)
        wrong = np.concatenate(
            [np.einsum("mpq,mq->mp", off, x - foot), np.einsum("mkq,mq->mk", planes, x - through)], axis=1
        )
        inverse = np.linalg.pinv(matrix, rcond=_MEET)
        return inverse, wrong, inverse @ matrix


def free_edges(graph: FrontGraph) -> Hold:
    """All edges free."""
    return Hold(np.full(len(graph.points), -1), np.zeros((1, 3, 3)), graph.opened)


def hold_of(
    graph: FrontGraph,
    sides: Sequence[Side],
    conditions: Sequence[Condition],
    *,
    guide: Guide | None = None,
    images: Images = NO_IMAGES,
    axes: dict[int, np.ndarray] | None = None,
) -> Hold:
    """What conditions at sides mean for their nodes; where sides meet, both hold.

    Parameters
    ----------
    graph : FrontGraph
        The front, extended beyond periodic sides.
    sides : sequence of Side
        With nodes of that graph.
    conditions : sequence of Condition
        One for each.
    guide : Guide, optional
        What sides stay on that do.
    images : Images
        Nodes that do what others do; what holds for them holds for these.
    axes : dict of int to (3,) float
        Nodes that stay on an axis.
    """
    n = len(graph.points)
    planes = _planes(sides, conditions, images, axes or {}, n)
    guided, free, held = (np.zeros(n, bool) for _ in range(3))
    for side, condition in zip(sides, conditions, strict=True):
        for flag, kinds in ((guided, ("guide",)), (free, ("free", "splay")), (held, ("plane", "constant", "guide"))):
            flag[side.nodes] |= condition.kind in kinds
    for flag in (guided, free, held):
        flag[images.nodes] = False
    held[list(planes)] = True
    nodes = np.flatnonzero(guided)
    row = np.full(n, -1)
    owners = np.union1d(nodes, np.array(list(planes), np.int64))
    row[owners] = np.arange(len(owners))
    projectors = np.zeros((max(len(owners), 1), 3, 3))
    for node, normals in planes.items():
        projectors[row[node]] = _projector(normals)
    return Hold(
        row,
        projectors,
        (free & ~held & (graph.opened == 1)).astype(np.int64),
        _leaning(graph, sides, conditions, n - len(images.nodes)),
        _outer_slots(graph, sides, conditions, held & (graph.opened == 1)),
        guide,
        _guided(graph.points, nodes, planes, guide),
        images,
    )


def _planes(sides, conditions, images: Images, axes: dict[int, np.ndarray], n: int) -> dict[int, list[np.ndarray]]:
    """For each node that stays in planes, their normals; images hand theirs to what they are images of."""
    planes: dict[int, list[np.ndarray]] = {}
    image = np.full(n, -1)
    image[images.nodes] = np.arange(len(images.nodes))
    for side, condition in zip(sides, conditions, strict=True):
        if condition.plane is None:
            continue
        for node in side.nodes.tolist():
            k = image[node]
            normal = condition.plane if k < 0 else images.turn[k].T @ condition.plane
            known = planes.setdefault(node if k < 0 else int(images.sources[k]), [])
            if not any(np.abs(np.cross(normal, other)).max() < 1e-9 for other in known):
                known.append(normal)
    for node, axis in axes.items():
        planes.setdefault(node, []).extend(np.linalg.svd(axis[None])[2][1:])
    return planes


def _projector(normals: Sequence[np.ndarray]) -> np.ndarray:
    values, vectors = np.linalg.eigh(sum(np.outer(n, n) for n in normals))
    across = vectors[:, values > 1e-6]
    p = np.eye(3) - across @ across.T
    return np.where(np.abs(p) < 1e-15, 0.0, p)


def _guided(points: np.ndarray, nodes: np.ndarray, planes: dict[int, list[np.ndarray]], guide: Guide | None) -> Guided:
    if guide is None or not len(nodes):
        return NOT_GUIDED
    also = np.zeros((len(nodes), 2, 3))
    for m, node in enumerate(nodes.tolist()):
        for k, normal in enumerate(planes.get(node, [])[:2]):
            also[m, k] = normal
    at = points[nodes]
    return Guided(nodes, guide.on_curve(at), guide.heights(at), also, at)


def _slots(graph: FrontGraph, sides, conditions, nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The sides of the edges that leave nodes forwards and backwards; one that is periodic runs on like the other."""
    number = np.full(len(graph.points), -1)
    for k, (side, condition) in enumerate(zip(sides, conditions, strict=True)):
        if condition.kind != "periodic":
            number[side.nodes if side.closed else side.nodes[:-1]] = k
    ahead, behind = number[nodes], number[graph.ring[graph.start[nodes + 1] - 1]]
    return np.where(ahead < 0, behind, ahead), np.where(behind < 0, ahead, behind)


def _outer_slots(graph: FrontGraph, sides, conditions, held: np.ndarray) -> np.ndarray:
    """Places in rings of held nodes on edges that lie inwards of a side at which the surface ends.

    At the corner with a plane only the neighbour along the side counts, which the plane mirrors: along the other one
    the node would be drawn inwards. At the corner between two such sides none does.
    """
    nodes = np.flatnonzero(held)
    ends = np.append([condition.ends for condition in conditions], False)
    dropped = []
    for node, ahead, behind in zip(nodes.tolist(), *_slots(graph, sides, conditions, nodes), strict=True):
        first, last = graph.start[node], graph.start[node + 1] - 1
        corner = ahead != behind and ends[ahead] and ends[behind]
        if ends[ahead] or ends[behind]:
            dropped += range(first + 1, last)
            dropped += [slot for slot, side in ((first, ahead), (last, behind)) if corner or not ends[side]]
    return np.array(dropped, np.int64)


def _leaning(graph: FrontGraph, sides, conditions, marching: int) -> Leaning:
    splay = np.append([condition.splay for condition in conditions], 0.0)
    asked = [side.nodes for side, condition in zip(sides, conditions, strict=True) if condition.splay]
    if not asked:
        return NO_LEANING
    nodes = np.unique(np.concatenate(asked))
    nodes = nodes[(graph.opened[nodes] == 1) & (nodes < marching)]
    ahead, behind = _slots(graph, sides, conditions, nodes)
    after, before = graph.ring[graph.start[nodes]], graph.ring[graph.start[nodes + 1] - 1]
    return Leaning(
        nodes,
        np.where(splay[ahead] > 0, after, nodes),
        np.where(splay[behind] > 0, before, nodes),
        np.maximum(splay[ahead], splay[behind]),
    )


def _units(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
