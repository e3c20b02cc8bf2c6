"""The triangulation that the planar generators work on: half-edges in growing arrays, built by insertion."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..errors import GenerationFailed, InvalidGeometry
from ..geometry import predicates
from ..progress import Progress, advance, silent
from . import _delaunay_kernels as delaunay_kernels
from . import _half_edge_kernels as half_edges

_POINTS_A_CHUNK = 50_000
# A counter-clockwise triangle 0, 1, 2 and the ghosts (b, a, infinity) beyond its edges.
_FIRST_ORIGIN = [0, 1, 2, 0, 1, 0, -1, 0, 2, 1, -1, 0, 0, 2, -1, 0]
_FIRST_TWIN = [4, 8, 12, 0, 0, 14, 9, 0, 1, 6, 13, 0, 2, 10, 5, 0]


def grown(array: np.ndarray, size: int, fill: float = 0) -> np.ndarray:
    """A longer copy of an array along its first axis."""
    longer = np.zeros((size, *array.shape[1:]), array.dtype)  # no memory is touched before it is used
    longer[: len(array)] = array
    if fill:
        longer[len(array) :] = fill
    return longer


@dataclass
class Scratch:
    """Buffers that kernels need while they run; nothing is kept in them between calls that end with DONE."""

    size: int = 4096
    stack: np.ndarray = field(init=False)
    ring: np.ndarray = field(init=False)
    ring_from: np.ndarray = field(init=False)
    cavity: np.ndarray = field(init=False)
    work: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        self.stack = np.empty(4 * self.size, np.int32)
        self.ring = np.empty(self.size, np.int32)
        self.ring_from = np.empty(self.size, np.int32)
        self.cavity = np.empty(self.size, np.int32)
        self.work = predicates.workspace()

    def grow(self) -> None:
        """Double the buffers; their content is kept."""
        self.size *= 2
        self.stack = grown(self.stack, 4 * self.size)
        for name in ("ring", "ring_from", "cavity"):
            setattr(self, name, grown(getattr(self, name), self.size))


@dataclass
class Triangulation:
    """A Delaunay triangulation of the plane, ghosts included, as `_half_edge_kernels` lays it out.

    Attributes
    ----------
    xy : (2 * n,) float
        Coordinates of the vertices, in the order of their insertion.
    order : (n,) int
        For each vertex the number of the point that it stands for.
    origin, twin : (4 * capacity,) int32
        Half-edges, flags and stamps.
    n_triangles : int
        Slots in use, ghosts included.
    """

    xy: np.ndarray
    order: np.ndarray
    origin: np.ndarray
    twin: np.ndarray
    n_triangles: int
    scratch: Scratch

    @property
    def vertex_of(self) -> np.ndarray:
        """(n,) int: for each point its vertex."""
        vertex = np.empty(len(self.order), np.int64)
        vertex[self.order] = np.arange(len(self.order))
        return vertex

    def live(self) -> tuple[np.ndarray, np.ndarray]:
        """(m, 3) int32 corners, by vertex, and (m,) int32 slots of the finite triangles that are not dead."""
        corners = np.empty((self.n_triangles, 3), np.int32)
        slots = np.empty(self.n_triangles, np.int32)
        count = half_edges.live_triangles(self.origin, self.n_triangles, corners, slots)
        return corners[:count], slots[:count]


def triangulated(points: np.ndarray, progress: Progress = silent, parameter: str = "points") -> Triangulation:
    """Delaunay triangulation of different points, safe for exact arithmetic (`predicates.rescaled`).

    Parameters
    ----------
    points : (n, 2) float
        No two equal.
    progress : Progress, optional
        Called with fraction and message.
    parameter : str
        What errors call the points.

    Raises
    ------
    InvalidGeometry
        If there are fewer than three points, or all lie on one line.
    """
    n = len(points)
    order = _hilbert_order(points)
    order = _with_triangle_first(points, order, parameter)
    scratch = Scratch()
    xy = np.ascontiguousarray(points[order]).ravel()
    origin = np.zeros(4 * (2 * n + 8), np.int32)
    twin = np.zeros_like(origin)
    origin[:16], twin[:16] = _FIRST_ORIGIN, _FIRST_TWIN
    duplicate = np.full(n, -1, np.int32)
    state = np.array([3, 4, 0], np.int64)
    status = half_edges.MORE
    while status in (half_edges.MORE, half_edges.FULL):
        advance(progress, state[delaunay_kernels.POINT] / n, "triangulating points")
        status = delaunay_kernels.insert_points(
            xy, n, origin, twin, scratch.work, scratch.stack, scratch.ring, scratch.ring_from, scratch.cavity,
            duplicate, state, _POINTS_A_CHUNK,
        )  # fmt: skip
        if status == half_edges.FULL:
            scratch.grow()
    if status != half_edges.DONE or (duplicate >= 0).any():
        raise GenerationFailed("the Delaunay triangulation met an impossible state; please report the points")
    return Triangulation(xy, order, origin, twin, int(state[delaunay_kernels.TRIANGLES]), scratch)


def _hilbert_order(points: np.ndarray) -> np.ndarray:
    """(n,) int: the points along a Hilbert curve, so that each is inserted near the one before."""
    n = len(points)
    keys = np.empty(n, np.int64)
    if n:
        bits = min(24, (62 - n.bit_length()) // 2)
        delaunay_kernels.hilbert_keys(np.ascontiguousarray(points).ravel(), n, bits, keys)
        # One sort of plain integers: the key above, the point's own number below.
        keys = np.sort((keys << n.bit_length()) | np.arange(n)) & ((1 << n.bit_length()) - 1)
    return keys


def _with_triangle_first(points: np.ndarray, order: np.ndarray, parameter: str) -> np.ndarray:
    """``order`` with a counter-clockwise triangle as its first three points."""
    if len(order) < 3:
        raise InvalidGeometry(f"needs at least three different points, got {len(order)}", parameter=parameter)
    a, b = points[order[0]], points[order[1]]
    rest = points[order[2:]]
    left, right = (a[0] - rest[:, 0]) * (b[1] - rest[:, 1]), (a[1] - rest[:, 1]) * (b[0] - rest[:, 0])
    turn = left - right
    clear = np.flatnonzero(np.abs(turn) > 1e-15 * (np.abs(left) + np.abs(right)))
    if len(clear):
        third, sign = clear[0], turn[clear[0]]
    else:
        signs = predicates.orient2d(a, b, rest)
        if not signs.any():
            raise InvalidGeometry(f"all {len(order)} points lie on one line; no area to mesh", parameter=parameter)
        third = np.flatnonzero(signs)[0]
        sign = signs[third]
    first = [order[0], order[1], order[2 + third]] if sign > 0 else [order[1], order[0], order[2 + third]]
    return np.concatenate([first, np.delete(order[2:], third)])
