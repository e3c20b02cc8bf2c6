"""The linear equations of a step of layers: Chan and Steger's implicit terms, solved by BiCGStab."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...threads import Workers
from . import _layer_equations_kernels as kernels
from .front_edges import Hold
from .front_graph import FrontGraph

ITERATIONS = 40
"""Of a step's equations at most, two products each."""
ENOUGH = 1e-3
"""Rest of a step's equations, divided by their diagonal, in units of its height."""
FEW = 2
"""Products of a step from whose corrections the next step gains nothing."""
NODES_A_THREAD = 2048


@dataclass(eq=False)
class LayerEquations:
    """The corrections of a step over the front's offset along its normals.

    Chan and Steger's equations are linearised about the front and solved at the end of the step, so that heights may be
    many times the spacing. For that the change of the area vectors must count with both parts: across the normals,
    where tilted faces turn lines, and along them, where widened faces take height from cells of a given volume. Then
    disturbances are waves along the front, whose eigenvalues are imaginary, and rings of three and five nodes are no
    different from those of four: on a sphere of radius R a step h has the diagonal 1 + 2 h / R. With the second part of
    the other sign, as if heights followed areas, it is 1 - 2 h / R, and the equations grow instead: cubes folded.
    Without it heights are kept at each point, which does for convex fronts, whose lines spread, but bends no lines that
    meet: 44 of 60 layers off an edge of 60 degrees with 16 cells a side, instead of all.

    With dissipation, whose eigenvalues are real, none of the matrix is near zero, and BiCGStab (H. A. van der Vorst,
    SIAM J. Sci. Stat. Comput. 13, 1992) takes one product a step off convex fronts, some ten off concave ones, where
    it begins with the corrections of the last step: they change little from step to step, in units of their heights.

    Attributes
    ----------
    graph, hold, workers
        The front's nodes, what edges may do, and who works.
    volume_smoothing : float
        1 if all cells of a layer widen alike, 0 if each as its height asks.
    """

    graph: FrontGraph
    hold: Hold
    workers: Workers
    volume_smoothing: float

    def __post_init__(self) -> None:
        n, k = len(self.graph.points), len(self.graph.ring)
        self._marching = self.hold.marching
        self._most = max(1, self._marching // NODES_A_THREAD)
        self.right, self.solution = np.zeros((n, 3)), np.zeros((n, 3))
        self.across, self.own = np.zeros((k, 3)), np.zeros((n, 3))
        self.flat, self.widening, self.mean = np.zeros(n), np.zeros(n), np.zeros(n)
        self._rest, self._shadow, self._direction, self._image, self._second = (np.zeros((n, 3)) for _ in range(5))
        self._blocks = -(-self._marching // kernels.BLOCK)
        self._sums = np.zeros((4, 3, self._blocks))
        self._lengths = np.zeros((ITERATIONS + 1, 2))
        self._worth = 0.0  # height of the last step, if its corrections are worth to begin with
        self._share = _corner_areas(self.graph)
        self._part = np.zeros(n, np.int64)
        for corner in self.graph.faces.T:
            self._part[corner[corner >= 0]] = self.graph.part[corner >= 0]

    def solve(
        self, height: float, front: np.ndarray, normal: np.ndarray, now: np.ndarray, strength: np.ndarray
    ) -> tuple[float, int]:
        """Find `solution`, the corrections of a step; returns the rest, in units of the height, and the products.

        Parameters
        ----------
        height : float
            Of the step.
        front, normal : (n, 3) float
            Where the step begins, and its normals.
        now, strength : (k,), (n,) float
            Weights of the rings and strength of the dissipation, whose right side is in `right`.
        """
        graph, hold = self.graph, self.hold
        n = self._marching
        held = (hold.row, hold.projectors)
        self.workers.run(
            lambda first, last: kernels.hyperbolic_terms(
                first, last, height, front, normal, graph.start, graph.ring, graph.opened, *held, hold.free,
                self.across, self.own, self.flat, self.widening, self.right,
            ),
            0, n, most=self._most,
        )  # fmt: skip
        self._find_means()
        ratio = height / self._worth if self._worth else 0.0
        self._run(
            kernels.begin, self.volume_smoothing * height, ratio, self.flat, self.widening, self.mean, normal, strength,
            self.right, self.solution, self._rest, self._shadow, self._direction, self._sums[kernels.FULL],
        )  # fmt: skip
        terms = (
            self.volume_smoothing, graph.start, graph.ring, *held, normal, self.across, self.own, self.flat, now,
            strength, self._shadow,
        )  # fmt: skip
        products = self._begin_near(terms) if ratio else 0
        products += self._iterate(terms, ENOUGH * height)
        rest = float(self._sums[kernels.FULL, 1].max() / height)
        self._worth = height if products > FEW and rest <= ENOUGH else 0.0
        return rest, products

    def _begin_near(self, terms: tuple) -> int:
        """Take what the corrections to begin with solve off the rest; returns the products that were done."""
        sums = self._sums[kernels.FULL]
        self.hold.images.set_vectors(self.solution)
        self._run(kernels.product, *terms, self.solution, self._image, sums)
        self._run(kernels.begin_near, self._image, self._rest, self._shadow, self._direction, sums)
        return 1

    def _iterate(self, terms: tuple, enough: float) -> int:
        """Solve the equations; returns the products that were done."""
        sums, images = self._sums, self.hold.images
        self._lengths[0, 0] = sums[kernels.FULL, 0].sum()
        vectors = (self._direction, self._rest, self._image, self._second, self.solution, self._lengths, sums)
        alone = self.workers.parts(self._most) < 2 and not len(images.nodes)
        phase, stride, last = 0, 4 * ITERATIONS if alone else 1, 4 * ITERATIONS
        while phase < last:
            if phase % 4 in (kernels.PRODUCT, kernels.SECOND):
                images.set_vectors(self._direction if phase % 4 == kernels.PRODUCT else self._rest)
            reached = self._run(kernels.iterate, phase, phase + stride, enough, *terms, *vectors)
            last = reached if reached < phase + stride else last
            phase = reached
        return phase // 2 - int(phase > 0 and not sums[kernels.HALF, 1].max() > enough)

    def _find_means(self) -> None:
        """The mean widening of each connected part, by areas that nodes see, so that half a body is like the whole."""
        total = np.bincount(self._part, weights=self._share * self.widening)
        area = np.bincount(self._part, weights=self._share)
        self.mean[:] = (total / np.maximum(area, np.finfo(float).tiny))[self._part]

    def _run(self, kernel: Callable[..., int | None], *arguments: object) -> int | None:
        """Call a kernel on all blocks, shared by threads; returns what it returns, the same for all of them."""
        n, returned = self._marching, []
        self.workers.run(
            lambda first, last: returned.append(kernel(first, last, n, *arguments)),
            0,
            self._blocks,
            most=self._most,
        )
        return returned[0]


def _corner_areas(graph: FrontGraph) -> np.ndarray:
    """(n,) float: areas of the corners at each node."""
    count = np.diff(graph.start)
    node = np.repeat(np.arange(len(count)), count)
    k = np.arange(len(graph.ring)) - graph.start[node]
    after = graph.ring[graph.start[node] + (k + 1) % count[node]]
    one, two = graph.points[graph.ring] - graph.points[node], graph.points[after] - graph.points[node]
    is_corner = (graph.opened[node] == 0) | (k < count[node] - 1)
    area = np.linalg.norm(np.cross(one, two), axis=1) * is_corner
    return np.bincount(node, weights=area, minlength=len(graph.points))
