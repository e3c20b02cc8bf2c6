"""Constrained Delaunay triangulation of a planar graph, and the faces of it that are to be meshed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..errors import GenerationFailed, InvalidGeometry
from ..geometry import predicates
from ..progress import Progress, advance, part_of
from . import _constrained_kernels as constrained_kernels
from . import _half_edge_kernels as half_edges
from . import _half_edge_query_kernels as queries
from .nesting import nesting_levels
from .planar_graph import ON_SEGMENT, Crossings, PlanarGraph, split_at_crossings
from .triangulation import Triangulation, grown, triangulated

_EDGES_A_CHUNK = 200_000
_MAX_CROSSING_ROUNDS = 64


@dataclass
class ConstrainedTriangulation:
    """A triangulation with every segment of a graph as edges.

    Attributes
    ----------
    triangulation : Triangulation
        Of the graph's points times ``2**exponent``.
    graph : PlanarGraph
        What was triangulated.
    exponent : int
        Scale, see `predicates.rescaled`.
    pieces : (p, 3) int32
        Vertices at the ends of each piece of a segment, and the segment.
    piece_of : (4 * capacity,) int32
        Piece under each constrained half-edge.
    face : (capacity,) int32
        Face of each triangle; 0 is the outside.
    n_faces : int
        Number of faces.
    """

    triangulation: Triangulation
    graph: PlanarGraph
    exponent: int
    pieces: np.ndarray
    piece_of: np.ndarray
    face: np.ndarray
    n_faces: int

    @property
    def line(self) -> np.ndarray:
        """(p,) int: number of the input line under each piece."""
        return self.graph.line[self.pieces[:, 2]]

    @property
    def constrained_half_edges(self) -> np.ndarray:
        """(2 e,) int: the half-edges on pieces of segments."""
        flags = self.triangulation.origin[3 : 4 * self.triangulation.n_triangles : 4]
        return np.concatenate([4 * np.flatnonzero(flags >> k & 1) + k for k in range(3)])

    @cached_property
    def faces_beside(self) -> np.ndarray:
        """(2, p) int: the faces left and right of each piece, as they are before refinement."""
        sides = np.zeros((2, len(self.pieces)), np.int64)
        whole = self.triangulation
        queries.faces_beside(whole.origin, whole.n_triangles, self.piece_of, self.pieces, self.face, sides)
        return sides

    def pieces_beside(self, keep: np.ndarray) -> np.ndarray:
        """(p,) bool: whether one of the faces beside each piece, by ``keep``, is meshed; beyond the hull nothing is."""
        left, right = self.faces_beside
        beside = keep[left] | keep[right]
        if keep[0]:
            half_edge = self.constrained_half_edges
            apex = self.triangulation.origin[half_edge + np.where(half_edge & 3 == 0, 2, -1)]
            on_hull = self.piece_of[half_edge[apex < 0]]
            beside[on_hull] = keep[np.maximum(left, right)[on_hull]]
        return beside


def constrained(graph: PlanarGraph, *, split_crossings: bool, parameter: str, progress: Progress):
    """Triangulate a planar graph with its segments kept.

    Points on segments split them. Where segments cross, they are split there too, or refused.

    Returns
    -------
    ConstrainedTriangulation

    Raises
    ------
    InvalidGeometry
        If segments cross and are not to be split; it names where.
    """
    for _ in range(_MAX_CROSSING_ROUNDS):
        scaled, exponent = predicates.rescaled(graph.points)
        mesh = triangulated(scaled, part_of(progress, 0.0, 0.5), parameter)
        pieces, piece_of, crossings = _inserted(mesh, graph, part_of(progress, 0.5, 1.0))
        if not len(crossings.pairs):
            face = np.empty(len(mesh.origin) // 4, np.int32)
            stack = np.empty(3 * mesh.n_triangles + 8, np.int32)
            n_faces = half_edges.label_faces(mesh.origin, mesh.twin, mesh.n_triangles, face, stack)
            return ConstrainedTriangulation(mesh, graph, exponent, pieces, piece_of, face, n_faces)
        crossings.places = np.ldexp(crossings.places, -exponent)
        if not split_crossings:
            _refuse(graph, crossings, parameter)
        graph = split_at_crossings(graph, crossings)
    raise InvalidGeometry(
        "crossings of lines lie so near each other that splitting does not come to an end; clean the lines there",
        parameter=parameter,
        cells=np.unique(graph.line[crossings.pairs]),
    )


def _refuse(graph: PlanarGraph, crossings: Crossings, parameter: str) -> None:
    ends = graph.source[graph.segments[crossings.pairs]].ravel()
    x, y = crossings.places[0]
    first, second = np.sort(graph.line[crossings.pairs[0]])
    more = f" ({len(crossings.pairs):,} crossings in all)" if len(crossings.pairs) > 1 else ""
    raise InvalidGeometry(
        f"line {first} and line {second} cross at ({x:.6g}, {y:.6g}){more}; separate them, or choose crossings = split",
        parameter=parameter,
        cells=np.unique(graph.line[crossings.pairs]),
        points=np.unique(ends[ends >= 0]),
    )


def _inserted(mesh: Triangulation, graph: PlanarGraph, progress: Progress):
    """Insert the segments; the pieces, the piece of each half-edge, and what cross."""
    kernels = constrained_kernels
    segments = np.empty(graph.segments.shape, np.int32)
    vertex, vertex_edge = np.empty(mesh.n_points, np.int32), np.empty(len(mesh.order) + 1, np.int32)
    piece_of = np.empty(len(mesh.origin), np.int32)
    largest = kernels.prepare(
        mesh.xy, mesh.order, mesh.merged, mesh.kept, mesh.origin, mesh.twin, mesh.n_triangles, graph.segments, vertex,
        segments, vertex_edge, piece_of,
    )  # fmt: skip
    pieces = np.empty((len(segments) + 64, 3), np.int32)
    crossed, places = np.empty((64, 2), np.int32), np.empty((64, 2))
    size = 1024
    chain, cavity, sweep, stack = _buffers(size)
    tolerance = ON_SEGMENT * largest
    state = np.zeros(kernels.STATE_SIZE, np.int64)
    state[kernels.FROM] = -1
    status = half_edges.MORE
    while status in (half_edges.MORE, half_edges.FULL, kernels.FULL_CROSSINGS):
        advance(progress, state[kernels.SEGMENT] / max(len(segments), 1), "inserting lines")
        status = kernels.insert_segments(
            mesh.xy, mesh.order, mesh.origin, mesh.twin, piece_of, vertex_edge, segments, pieces, crossed, places,
            chain, cavity, sweep, stack, mesh.scratch.work, tolerance, state, _EDGES_A_CHUNK,
        )  # fmt: skip
        if status == kernels.FULL_CROSSINGS:
            crossed, places = grown(crossed, 2 * len(crossed)), grown(places, 2 * len(places))
        elif status == half_edges.FULL and state[kernels.PIECES] == len(pieces):
            pieces = grown(pieces, 2 * len(pieces))
        elif status == half_edges.FULL:
            size *= 2
            depth, waiting = state[kernels.DEPTH], stack
            chain, cavity, sweep, stack = _buffers(size)
            stack[:depth] = waiting[:depth]
    if status != half_edges.DONE:
        raise GenerationFailed(
            f"line {graph.line[state[kernels.SEGMENT]]} could not be made an edge of the triangulation; "
            "please report the lines"
        )
    count = state[kernels.CROSSED]
    if not count:
        return pieces[: state[kernels.PIECES]], piece_of, Crossings(np.empty((0, 2), np.int64), places[:0])
    pairs, first = np.unique(np.sort(crossed[:count].astype(np.int64), axis=1), axis=0, return_index=True)
    return pieces[: state[kernels.PIECES]], piece_of, Crossings(pairs, places[first])


def _buffers(size: int) -> tuple[np.ndarray, ...]:
    """What the kernel needs for cavities of up to ``size`` triangles; only the stack keeps something between calls."""
    return (
        np.empty((2 * size, 4), np.int32),
        np.empty(size, np.int32),
        np.empty((2 * size, 2), np.int32),
        np.empty(8 * size, np.int32),
    )


def faces_of_points(mesh: ConstrainedTriangulation, points: np.ndarray, parameter: str) -> np.ndarray:
    """(k,) int: the face that each point lies in; 0 outside all loops, -1 outside the convex hull.

    Raises
    ------
    InvalidGeometry
        If a point lies on a line, between two faces.
    """
    found = np.empty(len(points), np.int64)
    whole = mesh.triangulation
    places = predicates.resolved(np.ldexp(points, mesh.exponent))
    k = queries.faces_at(whole.xy, whole.origin, whole.n_triangles, mesh.face, places, found, predicates.workspace())
    if k < len(points):
        raise InvalidGeometry(
            f"point {k} at ({points[k, 0]:.6g}, {points[k, 1]:.6g}) lies on a line, so on no side of it; move it",
            parameter=parameter,
        )
    return found


def levels(mesh: ConstrainedTriangulation) -> np.ndarray:
    """(n_faces,) int: 1 for faces inside by the even-odd rule, else 0."""
    if not len(mesh.pieces):
        return np.zeros(mesh.n_faces, np.int64)
    return nesting_levels(mesh.pieces, mesh.faces_beside, len(mesh.triangulation.order), mesh.n_faces)


def loose_ends(graph: PlanarGraph) -> np.ndarray:
    """(k,) int: points of the graph where one segment ends alone."""
    return np.flatnonzero(np.bincount(graph.segments.ravel(), minlength=len(graph.points)) == 1)
