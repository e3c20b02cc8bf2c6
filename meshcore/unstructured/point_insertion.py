"""Runs the insertion kernel over lists of vertices: in chunks, with buffers that grow, on one or more threads."""

from __future__ import annotations

import threading
from concurrent.futures import FIRST_EXCEPTION, Future, ThreadPoolExecutor, wait
from typing import TYPE_CHECKING

import numpy as np

from ..errors import GenerationFailed
from ..progress import Progress, advance, part_of
from . import _delaunay_kernels as kernels
from . import _half_edge_kernels as half_edges
from .half_edge_arrays import Scratch

if TYPE_CHECKING:
    from .triangulation import Triangulation

# Triangles looked at in one call of the kernel: about 50 ms.
_STEPS_A_CHUNK = 2_000_000
_SECONDS_BETWEEN_REPORTS = 0.05
_EVERY_VERTEX = (-1, 2**31 - 1)


class Insertion:
    """A list of vertices on its way into a triangulation.

    Parameters
    ----------
    mesh : Triangulation
        Into which they go.
    todo : (k,) int32
        Vertices, whose coordinates and numbers the mesh has already; is overwritten.
    slots : (int, int)
        First and last but one of the free slots that may be used; two a vertex suffice.
    start : int
        A half-edge of a finite triangle where the first walk starts.
    owned : (int, int)
        The insertion stays among triangles whose vertices are in this range.
    """

    def __init__(
        self,
        mesh: Triangulation,
        todo: np.ndarray,
        slots: tuple[int, int],
        start: int,
        scratch: Scratch,
        owned: tuple[int, int] = _EVERY_VERTEX,
    ):
        self.mesh, self.todo, self.scratch, self.owned = mesh, todo, scratch, owned
        self.state = np.zeros(kernels.STATE_SIZE, np.int64)
        self.state[kernels.TRIANGLES], self.state[kernels.SLOT_END] = slots
        self.state[kernels.START] = start

    @property
    def put_off(self) -> np.ndarray:
        """(k,) int32: vertices that were not inserted."""
        return self.todo[: self.state[kernels.DEFERRED]]

    def put_off_all(self) -> None:
        """Insert nothing: without a triangle of its own a walk would start among those that others change."""
        self.state[[kernels.NEXT, kernels.DEFERRED]] = len(self.todo)

    @property
    def free_slots(self) -> tuple[int, int]:
        """The slots that are left."""
        return int(self.state[kernels.TRIANGLES]), int(self.state[kernels.SLOT_END])

    @property
    def fraction(self) -> float:
        """How much of the list is done."""
        return float(self.state[kernels.NEXT]) / max(len(self.todo), 1)

    def step(self) -> bool:
        """Do about 50 ms of work; whether there is more."""
        mesh, scratch = self.mesh, self.scratch
        status = kernels.insert_points(
            mesh.xy, mesh.order, mesh.origin, mesh.twin, self.todo, *self.owned, scratch.work, scratch.stack,
            scratch.ring, scratch.ring_from, scratch.cavity, self.state, _STEPS_A_CHUNK,
        )  # fmt: skip
        if status == half_edges.FULL:
            scratch.grow()
        return status in (half_edges.FULL, half_edges.MORE)


def insert(mesh: Triangulation, todo: np.ndarray, progress: Progress) -> np.ndarray:
    """Insert vertices one after the other; return those that are at the place of another, v: their number is ~v."""
    slots = (mesh.n_triangles, mesh.n_triangles + 2 * len(todo))
    insertion = Insertion(mesh, todo, slots, mesh.start, mesh.scratch)
    advance(progress, 0.0, "triangulating points")
    while insertion.step():
        advance(progress, insertion.fraction, "triangulating points")
    mesh.n_triangles, mesh.start = insertion.free_slots[0], int(insertion.state[kernels.START])
    return insertion.put_off


def insert_on_threads(mesh: Triangulation, todo: np.ndarray, threads: int, progress: Progress) -> None:
    """Insert different vertices, numbered along a curve, on threads.

    Each thread owns a range of vertices and stays among triangles of its own; vertices between the ranges, and those
    beyond the hull of what was there before, are put off and inserted afterwards (Marot, Pellerin, Remacle 2019).
    The slots of the triangles then depend on the number of threads, but not the triangles.
    """
    n, first_slot = len(mesh.order), mesh.n_triangles
    bounds = [n * k // threads for k in range(threads + 1)]
    corners = mesh.origin[: 4 * first_slot].reshape(-1, 4)[:, :3]
    owner = np.searchsorted(bounds[1:], todo, side="right")
    parts = []
    for k in range(threads):
        part = todo[owner == k]
        slots = (first_slot, first_slot + 2 * len(part))
        first_slot = slots[1]
        inside = np.flatnonzero(((corners >= bounds[k]) & (corners < bounds[k + 1])).all(axis=1))
        start = 4 * int(inside[0]) if len(inside) else mesh.start
        parts.append(Insertion(mesh, part, slots, start, Scratch(mesh.quantum), (bounds[k], bounds[k + 1])))
        if not len(inside):
            parts[-1].put_off_all()
    _run(parts, part_of(progress, 0.0, 0.8))
    waits = np.zeros(n, bool)
    for part in parts:
        waits[part.put_off] = True
    # In the order of all: where most were put off, as around a hub, its rounds matter.
    last = Insertion(mesh, todo[waits[todo]], (0, 0), mesh.start, mesh.scratch)
    for part in parts:
        last.state[kernels.TRIANGLES], last.state[kernels.SLOT_END] = part.free_slots
        while last.step():
            advance(progress, 0.8 + 0.2 * last.fraction, "triangulating points")
    if last.fraction < 1.0 or len(last.put_off):
        raise GenerationFailed("the Delaunay triangulation met an impossible state; please report the points")
    mesh.n_triangles, mesh.start = first_slot, int(last.state[kernels.START])


def _run(parts: list[Insertion], progress: Progress) -> None:
    """Run insertions on a thread each; cancelling stops them all."""
    stop = threading.Event()

    def work(part: Insertion) -> None:
        while not stop.is_set() and part.step():
            pass

    with ThreadPoolExecutor(len(parts)) as pool:
        waiting: set[Future] = {pool.submit(work, part) for part in parts}
        try:
            while waiting:
                advance(progress, min(part.fraction for part in parts), "triangulating points")
                done, waiting = wait(waiting, _SECONDS_BETWEEN_REPORTS, FIRST_EXCEPTION)
                for future in done:
                    future.result()
        finally:
            stop.set()
