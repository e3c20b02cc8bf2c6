"""Layers marched from a surface, one from the other: the hyperbolic equations on a graph of nodes (survey 2.7.1)."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ...progress import Progress, advance, silent
from ...threads import Workers, available_threads
from . import _layer_kernels as kernels
from .front_bends import blind_node, concave_curvature
from .front_edges import Hold, free_edges
from .front_graph import FrontGraph
from .layer_equations import LayerEquations
from .layer_repair import repair


class Scheme(NamedTuple):
    """How a front is held smooth.

    Attributes
    ----------
    base, growing : float
        Coefficients of dissipation.
    sharing : float
        Part of the volume smoothing.
    seen : float
        Sine above all faces that lines are to have where they can.
    """

    base: float
    growing: float
    sharing: float
    seen: float = kernels.SEEN


CALM, MILD = Scheme(0.02, 0.0, 0.0, 0.05), Scheme(1.0, 0.5, 0.0)
"""Where lines spread, heights are kept at each point. Dissipation would only draw layers off sharp tips: with that of
`FIRM` those of a wing's tip fold after 43 of 60, without after none; and lines that stand higher above its faces than
they must bring it no farther than 53."""
FIRM, HARD = Scheme(10.0, 5.0, 1.0), Scheme(40.0, 20.0, 1.0)
"""Where they meet, lines are bent and volumes kept."""
MEETING = 0.1
"""Distance that is marched, in units of the radius of the sharpest hollow, from which its lines count as meeting."""
NARROWEST = 0.3
"""Steps are split where a corner of the front would keep less than this part of its area."""
SOLVED = 0.01
"""Steps are split where this part of their height is left of their equations."""
HALVINGS = 2
"""How often a folded layer is tried again, with twice the steps and the dissipation."""
SOUND = 1e-4
"""Least sine of a cell's corner."""
STUCK = 0.1
"""Part of a layer's height that each node must have moved by."""
NODES_A_THREAD = 2048
_MOST_STEPS, _MOST_SPLITS = 200, 8


@dataclass
class Outcome:
    """How a march went.

    Attributes
    ----------
    steps, products : int
        Steps, and products of their equations' matrices with corrections, that were done.
    residual : float
        Most that was left of the equations of a step, in units of its height.
    worst : float
        Least sine of a cell's corner.
    stopped_at : int
        Node where the next layer could not be made, or -1.
    why : str
        What it would have done there.
    """

    steps: int = 0
    products: int = 0
    residual: float = 0.0
    worst: float = 1.0
    stopped_at: int = -1
    why: str = "would fold"


def first_normals(graph: FrontGraph) -> np.ndarray:
    """(n, 3) float: unit normals of the surface at its nodes."""
    hold, normal = free_edges(graph), np.empty_like(graph.points)
    ring = (graph.start, graph.ring, graph.opened)
    kernels.normals(0, len(normal), graph.points, *ring, hold.row, hold.projectors, kernels.SEEN, normal)
    return normal


def least_corner(graph: FrontGraph, layers: np.ndarray) -> float:
    """Least sine of the corners of the cells between layers, at all eight of hexahedra and six of wedges.

    With the surface's faces, each edge of which has two at most that are turned alike, it tells all that makes a mesh
    of layers valid, in a tenth of the time of a check that knows nothing of them.
    """
    least, worst = 1.0, np.empty(len(graph.points))
    for below, above in itertools.pairwise(layers):
        kernels.corner_volumes(0, len(worst), 0.0, below, above, graph.start, graph.ring, graph.opened, worst)
        least = min(least, float(worst.min()))
    return least


def marched(
    graph: FrontGraph,
    heights: Sequence[float],
    *,
    hold: Hold | None = None,
    volume_smoothing: float = 1.0,
    threads: int | None = None,
    progress: Progress = silent,
) -> tuple[np.ndarray, Outcome]:
    """The layers of a surface, as many as can be without a folded cell.

    Each node moves along the front's normal, so that lines are orthogonal to layers, by the layer's height, so that
    cells have the volume of height times area. Corrections over that solve the equations implicitly, see
    `layer_equations`, with dissipation, see `_layer_kernels.dissipation`.

    Parameters
    ----------
    graph : FrontGraph
        The surface.
    heights : sequence of float
        Heights of the layers, from the surface.
    hold : Hold, optional
        What edges may do; by default they are free.
    volume_smoothing : float
        1 if all cells of a layer widen alike, so that hollows fill and bulges lag, 0 if each as its height asks.
    threads : int, optional
        By default as many as there are cores; layers do not depend on it.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    layers : (k + 1, n, 3) float
        The surface and its layers.
    outcome : Outcome
    """
    best: tuple[np.ndarray, Outcome] | None = None
    with Workers(threads or available_threads()) as workers:
        for scheme in _schemes(graph, float(sum(heights))):
            scheme = scheme._replace(sharing=scheme.sharing * volume_smoothing)
            march = _March(graph, hold or free_edges(graph), workers, scheme)
            if best is None and (node := blind_node(graph, march.normal)) >= 0:
                return graph.points[None].copy(), Outcome(stopped_at=node, why="would fold, as no line sees all faces,")
            layers = march.all(heights, progress)
            if best is None or len(layers) > len(best[0]):
                best = layers, march.outcome
            if len(layers) == len(heights) + 1:
                break
    return best


def _schemes(graph: FrontGraph, distance: float) -> tuple[Scheme, ...]:
    """What is tried, until all layers are sound: by whether the surface's lines would meet in that distance."""
    meeting = concave_curvature(graph) * distance > MEETING
    return (FIRM, MILD, HARD, CALM) if meeting else (CALM, MILD, FIRM, HARD)


@dataclass
class _March:
    """A front on its way."""

    graph: FrontGraph
    hold: Hold
    workers: Workers
    scheme: Scheme
    outcome: Outcome = field(default_factory=Outcome)

    def __post_init__(self) -> None:
        graph = self.graph
        n, k = len(graph.points), len(graph.ring)
        self.topology = (graph.start, graph.ring, graph.opened)
        self.held = (self.hold.row, self.hold.projectors)
        self.normal, self.ahead = np.zeros((n, 3)), np.zeros((n, 3))
        self.strength, self.zone, self.new_zone = (np.zeros(n) for _ in range(3))
        self.narrow, self.worst = np.ones(n), np.ones(n)  # of nodes that march; images of them never fold first
        self.weight, self.ratio, self.now = (np.zeros(k) for _ in range(3))
        ends = np.repeat(graph.points, np.diff(graph.start), axis=0)
        self.spacing = np.linalg.norm(graph.points[graph.ring] - ends, axis=1)
        self.equations = LayerEquations(graph, self.hold, self.workers, self.scheme.sharing)
        self._find_normals(graph.points)
        self._run(kernels.ring_weights, graph.points, self.normal, *self.topology, self.hold.free, self.weight)
        self.hold.weigh(self.weight, graph.start)

    def all(self, heights: Sequence[float], progress: Progress) -> np.ndarray:
        """(k + 1, n, 3): the surface and all layers that are sound."""
        layers = np.empty((len(heights) + 1, *self.graph.points.shape))
        layers[0] = self.graph.points
        distance = 0.0
        for k, height in enumerate(heights):
            advance(progress, k / len(heights), f"layer {k + 1} of {len(heights)}")
            if not self._layer(layers[k], layers[k + 1], height, distance):
                self.outcome.stopped_at = int(np.argmin(self.worst))
                return layers[: k + 1].copy()
            self.outcome.worst = min(self.outcome.worst, float(self.worst.min()))
            distance += height
        return layers

    def _layer(self, below: np.ndarray, above: np.ndarray, height: float, distance: float) -> bool:
        """Fill ``above`` with the next layer; False if cells would fold.

        Smaller steps with more dissipation come first, repairs last: the march goes on from what is smooth.
        """
        zone, folded = self.zone.copy(), []
        for halving in range(HALVINGS + 1):
            self.zone[:] = zone
            front, done = self._steps(below, height, distance, halving)
            above[:] = front
            sound = self._is_sound(below, above, height)
            if done and sound:
                return True
            if done:
                folded.append(front)
        for front in folded:
            above[:] = front
            repair(self.graph, self.hold, below, above, height)
            if self._is_sound(below, above, height):
                return True
        return False

    def _steps(self, below: np.ndarray, height: float, distance: float, halving: int) -> tuple[np.ndarray, bool]:
        """The front after a layer's height in steps that are halved so often, and whether it came so far."""
        front, done, steps = below, 0.0, 0
        while done < 1 - 1e-9 and steps < _MOST_STEPS:
            part = min(1 - done, 0.5**halving)
            front, part = self._step(front, height, part, distance + done * height, 2.0**halving)
            if part == 0:
                break
            done += part
            steps += 1
        self.outcome.steps += steps
        return front, done >= 1 - 1e-9

    def _is_sound(self, below: np.ndarray, above: np.ndarray, height: float) -> bool:
        """Whether no cell folds between two layers, and all nodes have moved."""
        self._run(kernels.corner_volumes, STUCK * height, below, above, *self.topology, self.worst)
        return self.worst.min() > SOUND

    def _step(
        self, front: np.ndarray, height: float, part: float, distance: float, factor: float
    ) -> tuple[np.ndarray, float]:
        """The front after at most that part of a layer's height, and the part that was done, 0 if it cannot be."""
        self._find_normals(front)
        for _ in range(_MOST_SPLITS):
            np.multiply(self.normal, part * height, out=self.ahead)
            self.ahead += front
            self._run(kernels.narrowing, front, self.ahead, *self.topology, self.narrow)
            least = self.narrow.min()
            if least < NARROWEST:
                part *= max(0.1, min(0.9, (1 - NARROWEST) / (1 - least)))
            elif (rest := self._correct(front, part * height, distance + part * height, factor)) <= SOLVED:
                break
            else:
                part *= 0.5
        else:
            return front, 0.0
        self.zone, self.new_zone = self.new_zone, self.zone
        self.hold.images.set_numbers(self.zone)
        self.outcome.residual = max(self.outcome.residual, rest)
        front = self.ahead + self.equations.solution
        self.hold.settle(front)
        return front, part

    def _correct(self, front: np.ndarray, step: float, total: float, factor: float) -> float:
        """Find the corrections of a step; returns what is left of its equations, in units of its height."""
        equations = self.equations
        self._run(
            kernels.dissipation, step, total, factor * self.scheme.base, factor * self.scheme.growing, self.ahead,
            self.normal, *self.topology, *self.held, self.hold.free, self.weight, self.spacing, self.ratio, self.now,
            self.zone, self.new_zone, self.strength, equations.right,
        )  # fmt: skip
        rest, products = equations.solve(step, front, self.normal, self.now, self.strength)
        self.outcome.products += products
        return rest

    def _find_normals(self, front: np.ndarray) -> None:
        self.hold.aim(front)
        self._run(kernels.normals, front, *self.topology, *self.held, self.scheme.seen, self.normal)
        self.hold.lean(front, self.normal)
        self.hold.images.set_vectors(self.normal)

    def _run(self, kernel: Callable[..., float | None], *arguments: object) -> list[float | None]:
        """Call a kernel on all nodes that march, shared by threads; what each part returned."""
        n, returned = self.hold.marching, []
        self.workers.run(
            lambda first, last: returned.append(kernel(first, last, *arguments)),
            0,
            n,
            most=max(1, n // NODES_A_THREAD),
        )
        return returned
