"""Conforming Delaunay triangulation: points on segments until these are edges of the Delaunay triangulation itself."""

from __future__ import annotations

import numpy as np

from ..geometry import predicates
from ..progress import Progress, advance
from . import _conforming_kernels as kernels
from . import _half_edge_kernels as half_edges
from .constrained import ConstrainedTriangulation
from .refiner import acute_vertices
from .triangulation import grown

_EDGES_A_CHUNK = 200_000
SPARE_POINTS = 1_000_000
"""Points that may be added beyond twenty for each there is, before it counts as endless."""


def conform(mesh: ConstrainedTriangulation, progress: Progress) -> tuple[int, int]:
    """Split pieces of segments until all triangles of a constrained triangulation, in all of the hull, are Delaunay.

    The triangulation is changed in place; the points that are added are vertices beyond ``mesh.triangulation.order``.

    Returns
    -------
    left : int
        Pieces that should be split further: coordinates cannot resolve it, or there would be too many points.
    added : int
        Points that were added.
    """
    base = mesh.triangulation
    n = len(base.order)
    acute = acute_vertices(base)
    vertex_edge = np.empty(len(base.xy) // 2 + 1, np.int32)
    half_edge = mesh.constrained_half_edges
    half_edge = half_edge[half_edge < base.twin[half_edge]]
    queue = np.append(half_edge, np.zeros(len(half_edge) + 1024)).astype(np.int32)
    stack = np.empty(4096, np.int32)
    state = np.zeros(kernels.STATE_SIZE, np.int64)
    state[[kernels.TRIANGLES, kernels.VERTICES, kernels.WAITING]] = base.n_triangles, n, len(half_edge)
    work = base.scratch.work = predicates.workspace()  # the points that are added lie on no grid, if those given do
    status = half_edges.MORE
    while status in (half_edges.MORE, half_edges.FULL):
        added = int(state[kernels.VERTICES]) - n
        if added > 20 * n + SPARE_POINTS:
            break
        advance(progress, added / (added + len(half_edge) + 1), "splitting lines")
        status = kernels.conform(
            base.xy, base.origin, base.twin, mesh.piece_of, mesh.face, vertex_edge, mesh.pieces, acute, queue, stack,
            work, state, _EDGES_A_CHUNK,
        )  # fmt: skip
        if status != half_edges.FULL:
            continue
        if 2 * state[kernels.VERTICES] + 2 > len(base.xy):
            base.xy = grown(base.xy, 2 * len(base.xy) + 1024)
            vertex_edge = grown(vertex_edge, len(base.xy) // 2 + 1)
        elif 4 * state[kernels.TRIANGLES] + 8 > len(base.origin):
            slots = len(base.origin) // 2 + 1024
            base.origin, base.twin = grown(base.origin, 4 * slots), grown(base.twin, 4 * slots)
            mesh.piece_of, mesh.face = grown(mesh.piece_of, 4 * slots), grown(mesh.face, slots)
        else:
            queue, stack = _unrolled(queue, state), grown(stack, 2 * len(stack))
    base.n_triangles = int(state[kernels.TRIANGLES])
    base.xy = base.xy[: 2 * state[kernels.VERTICES]]
    left = int(state[kernels.STUCK]) + (int(state[kernels.WAITING]) if status != half_edges.DONE else 0)
    return left, int(state[kernels.VERTICES]) - n


def _unrolled(queue: np.ndarray, state: np.ndarray) -> np.ndarray:
    """A ring of twice the length, whose entries start at its first place."""
    longer = grown(np.roll(queue, -int(state[kernels.HEAD])), 2 * len(queue))
    state[kernels.HEAD] = 0
    return longer
