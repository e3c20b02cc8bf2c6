"""Inserts points into a triangulation of space, in chunks, in one thread or many."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np

from ..errors import GenerationFailed, InvalidGeometry, InvalidInput
from ..geometry import predicates
from ..progress import Progress, advance, part_of, silent
from ..threads import available_threads
from . import _delaunay_3d_kernels as kernels
from . import _insertion_order_kernels as order_kernels
from . import _tetrahedra_kernels as layout
from .insertion_order import insertion_order
from .space_cells import MAX_POINTS, Lists, SpaceCells
from .thin_clouds import places_along_line_in_space

_POINTS_A_CHUNK = 20_000
_CELLS_A_RANGE = 32_768
_POINTS_WORTH_A_THREAD = 100_000
_FIRST_ALONE = 1 / 16  # of the points are inserted by one thread, so that parts have cells of their own
_PARTITIONS = 3  # points put off are dealt anew this many times before one thread inserts the rest
_ROUND_RATIO = 8
_FIRST_ROUND = 50
_NOTHING = np.empty(0, np.int32)


@dataclass(frozen=True)
class SpaceOrder:
    """Different points of space along a Hilbert curve, and the order in which they are inserted.

    Attributes
    ----------
    rows : (k,) int32
        Row of each point among the caller's.
    points : (4 * k,) float
        x, y, z of each, and a zero.
    merged, kept : (d,) int64
        Rows left out, since another point is at the same place, and the rows that stay for them.
    first : (4,) int
        Numbers, in `rows`, of the corners of a positive cell.
    todo : (k - 4,) int32
        The others, in the order of their insertion.
    quantum, extent : float
        See `SpaceCells`.
    """

    rows: np.ndarray
    points: np.ndarray
    merged: np.ndarray
    kept: np.ndarray
    first: np.ndarray
    todo: np.ndarray
    quantum: float
    extent: float


def safe_exponent(points: np.ndarray) -> int:
    """The power of two by which points are scaled, so that predicates are exact and the filter's bound holds.

    The largest extent becomes at least 1/2, as `_tetrahedra_kernels` asks; the scaling rounds nothing.
    """
    scaled, exponent = predicates.rescaled(points)
    extent = max([0.0, *(float(axis.max() - axis.min()) for axis in scaled.T if len(points))])
    return exponent - int(np.frexp(extent)[1]) if 0.0 < extent < 0.5 else exponent


def extent_of(points: np.ndarray) -> float:
    """A bound, at least 1/2, of the differences of coordinates of (n, 3) scaled points."""
    return max([0.5, *(float(axis.max() - axis.min()) for axis in points.T if len(points))]) * (1 + 2.0**-50)


def space_order(points: np.ndarray, progress: Progress = silent) -> SpaceOrder:
    """Order scaled points for insertion.

    Raises
    ------
    InvalidGeometry
        If the points do not span space.
    """
    if len(points) > MAX_POINTS:
        raise InvalidInput(f"has {len(points)} points; at most {MAX_POINTS} can be numbered", parameter="points")
    order = insertion_order(points, 3, rounds=False, progress=progress)
    n = len(order.rows)
    records = np.zeros((n, 4))
    records[:, :3] = order.coordinates.reshape(-1, 3)
    records = records.ravel()
    quantum = predicates.quantum_of(points)
    first = np.zeros(4, np.int64)
    rank = layout.first_cell(records, n, predicates.workspace(quantum), first)
    if rank < 4:
        raise InvalidGeometry(_flatness(n, rank), parameter="points")
    places = places_along_line_in_space(records.reshape(-1, 4)[:, :3])
    todo = in_rounds(n) if places is None else np.argsort(places, kind="stable").astype(np.int32)
    todo = todo[~np.isin(todo, first)]
    return SpaceOrder(order.rows, records, order.merged, order.kept, first, todo, quantum, extent_of(points))


def in_rounds(n: int) -> np.ndarray:
    """The numbers below n, int32, in the order of insertion: first every so many along the curve, then more.

    Each round is about eight times the size of all before, and goes along the curve. So points are spread over all of
    space soon, as in a random order, and cavities stay small even on grids; but each point is near the one before.
    """
    rounds = []
    rest = np.arange(n, dtype=np.int32)
    stride = _ROUND_RATIO ** max(0, int(np.log(max(n, 1) / _FIRST_ROUND) / np.log(_ROUND_RATIO)))
    while stride > 1:
        rounds.append(rest[rest % stride == 0])
        rest = rest[rest % stride != 0]
        stride //= _ROUND_RATIO
    return np.concatenate([*rounds, rest])


def _flatness(n: int, rank: int) -> str:
    if n < 4:
        return f"needs at least four different points, got {n}"
    if rank == 2:
        return f"all {n} points lie on one line; no volume to mesh"
    return f"all {n} points lie in one plane; use delaunay_2d for them, or add points off the plane"


def number_of_threads(threads: int | None, n_points: int) -> int:
    """Threads to use: as asked, or all available cores as far as there are points enough for each."""
    if threads is not None:
        return threads
    return max(1, min(available_threads(), n_points // _POINTS_WORTH_A_THREAD))


def in_ranges(work: Callable[[int, int], None], n: int, threads: int) -> None:
    """Call ``work(start, stop)`` for ranges that make up the numbers below n, each in a thread of its own."""
    bounds = [n * k // threads for k in range(threads + 1)]
    if threads == 1:
        work(0, n)
        return
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(work, bounds[:-1], bounds[1:]))


def insert(space: SpaceCells, todo: np.ndarray, threads: int, progress: Progress = silent) -> np.ndarray:
    """Insert vertices.

    Parameters
    ----------
    space : SpaceCells
        Changed in place.
    todo : (k,) int32
        Vertices in the order of their insertion.
    threads : int
        How many; the triangulation does not depend on it.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    fate : (number of vertices,) int32
        For each inserted vertex the older one at its place, or -1; the former is then no corner of any cell. Nothing
        for other vertices.

    Raises
    ------
    GenerationFailed
        If the kernels meet an impossible state.
    Cancelled
        If ``progress`` asks for it; the triangulation is whole then, but lacks points.
    """
    n = len(todo)
    fate = np.empty(space.n_vertices, np.int32)
    fate[todo] = -1
    if threads > 1:
        alone = min(n, max(int(_FIRST_ALONE * n), _POINTS_A_CHUNK))
        _insert_alone(space, todo[:alone], fate, part_of(progress, 0.0, alone / max(n, 1)))
        todo = todo[alone:]
        for attempt in range(_PARTITIONS):
            if len(todo) < threads * _POINTS_A_CHUNK:
                break
            todo = _insert_in_parts(space, todo, fate, threads, attempt, part_of(progress, 1 - len(todo) / n, 1.0))
    _insert_alone(space, todo, fate, part_of(progress, 1 - len(todo) / max(n, 1), 1.0))
    return fate


def _arguments(space: SpaceCells, lists: Lists, todo, put_off, fate, owner, part, infinite_slot) -> tuple:
    """All arguments of `insert_points` but the last two."""
    return (
        space.points, space.rows, space.cells, space.planes, space.region, space.facet_id, space.cell_of,
        todo, put_off, fate, owner, part, infinite_slot, lists.cavity, lists.facets, lists.corners, lists.offsets,
        space.place, lists.edges, lists.table, lists.work, lists.limits, lists.state,
    )  # fmt: skip


def _insert_alone(space: SpaceCells, todo: np.ndarray, fate: np.ndarray, progress: Progress) -> None:
    """Insert vertices in this thread, whatever cells they touch."""
    lists = space.lists
    lists.state[kernels.POINT] = 0
    status = layout.MORE if len(todo) else layout.DONE
    owner = np.empty(0, np.uint8)
    infinite_slot = len(space.place) - 1
    while status != layout.DONE:
        advance(progress, lists.state[kernels.POINT] / len(todo), "triangulating points")
        status = kernels.insert_points(
            *_arguments(space, lists, todo, _NOTHING, fate, owner, kernels.ANY, infinite_slot),
            kernels.INSERT, _POINTS_A_CHUNK,
        )  # fmt: skip
        if status == layout.FULL_CELLS:
            space.grow()
        elif status == layout.FULL_CAVITY:
            lists.grow()
        elif status == layout.FAILED:
            raise GenerationFailed("the Delaunay triangulation met an impossible state; please report the points")


@dataclass
class _Part:
    """The work of one thread."""

    number: int
    lists: Lists
    todo: np.ndarray
    put_off: np.ndarray = field(init=False)
    failure: BaseException | None = None

    def __post_init__(self) -> None:
        self.put_off = np.empty(len(self.todo), np.int32)

    def rest(self) -> np.ndarray:
        """The points that were not inserted."""
        done, put_off = self.lists.state[kernels.POINT], self.lists.state[kernels.PUT_OFF]
        return np.concatenate([self.put_off[:put_off], self.todo[done:]])


def _insert_in_parts(
    space: SpaceCells, todo: np.ndarray, fate: np.ndarray, threads: int, attempt: int, progress: Progress
) -> np.ndarray:
    """Insert vertices by threads, each within the cells of its own part of space; return those that need more.

    A part is a stretch of the Hilbert curve (Marot, Pellerin, Remacle 2019). A cell with corners in two parts is
    changed by nobody, so that no thread ever waits for another; and since the triangulation is unique, it does not
    matter who inserted what, and when.
    """
    owner = _parts(space, todo, threads, attempt)
    if len(space.place) < space.n_vertices + threads:
        space.place = np.zeros(space.n_vertices + threads, np.int32)
    parts = []
    for k in range(threads):
        part = _Part(k, Lists(space.quantum, space.extent), todo[owner[todo] == k])
        part.lists.state[layout.HINT] = layout.first_own(space.cells, space.n_cells, owner, k)
        parts.append(part)
    lock, stop = threading.Lock(), threading.Event()
    workers = [threading.Thread(target=_work, args=(space, part, owner, fate, lock, stop)) for part in parts]
    for worker in workers:
        worker.start()
    try:
        while any(worker.is_alive() for worker in workers):
            done = sum(int(part.lists.state[kernels.POINT]) for part in parts)
            advance(progress, done / len(todo), "triangulating points")
            for worker in workers:
                worker.join(0.05 / threads)
    finally:
        stop.set()
        for worker in workers:
            worker.join()
        for part in parts:
            layout.give_back(space.cells, part.lists.state, space.state)
    for part in parts:
        if part.failure is not None:
            raise part.failure
    rest = np.zeros(space.n_vertices, bool)
    for part in parts:
        rest[part.rest()] = True
    return todo[rest[todo]]  # in the order in which they were


def _parts(space: SpaceCells, todo: np.ndarray, threads: int, attempt: int) -> np.ndarray:
    """(number of vertices,) uint8: the part of each, by stretches of a Hilbert curve with as many points to insert.

    Each attempt takes another box for the curve, so that points near a border come to lie inside a part.
    """
    n = space.n_vertices
    points = space.points.reshape(-1, 4)[:n]
    table = np.empty(order_kernels.TABLE_SIZE, np.int32)
    order_kernels.fill_curve_table(3, table)
    packed = np.arange(n, dtype=np.uint64)
    box = np.zeros(4)
    order_kernels.set_box(points, 3, packed, 0, n, box)
    box[:3] -= np.array([0.31, 0.17, 0.23]) * attempt * box[3]
    box[3] *= 1 + 0.37 * attempt
    order_kernels.set_keys(points, 3, box, table, order_kernels.SHORT_KEY_BITS, packed, 0, n)
    keys = (packed >> np.uint64(32)).astype(np.uint32)
    cuts = np.quantile(keys[todo[:: max(1, len(todo) // 100_000)]], np.arange(1, threads) / threads)
    return np.searchsorted(cuts.astype(np.uint32), keys, side="right").astype(np.uint8)


def _work(
    space: SpaceCells, part: _Part, owner: np.ndarray, fate: np.ndarray, lock: threading.Lock, stop: threading.Event
) -> None:
    """Insert a part's points, range of cells after range of cells, until done, told to stop, or out of cells."""
    lists = part.lists
    status = layout.MORE if len(part.todo) and lists.state[layout.HINT] >= 0 else layout.DONE
    infinite_slot = space.n_vertices + part.number
    try:
        while status != layout.DONE and not stop.is_set():
            status = kernels.insert_points(
                *_arguments(space, lists, part.todo, part.put_off, fate, owner, part.number, infinite_slot),
                kernels.INSERT, _POINTS_A_CHUNK,
            )  # fmt: skip
            if status == layout.FULL_CAVITY:
                lists.grow()
            elif status == layout.FULL_CELLS:
                with lock:
                    if not _next_range(space, lists):
                        return
    except BaseException as failure:  # shown in the thread that asked for the work
        part.failure = failure


def _next_range(space: SpaceCells, lists: Lists) -> bool:
    """Give a thread a new range of unused cells; False if the buffer is full, which cannot grow while others work."""
    size = max(_CELLS_A_RANGE, len(lists.cavity))
    if space.n_cells + size > space.capacity:
        return False
    layout.take_range(space.cells, lists.state, space.state, size)
    return True
