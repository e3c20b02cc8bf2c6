"""The buffers of a triangulation of space: points, cells, and the lists of each thread that works on them."""

from __future__ import annotations

import numpy as np

from ..errors import GenerationFailed
from ..geometry import predicates
from . import _cavity_kernels as cavity_kernels
from . import _delaunay_3d_kernels as kernels
from . import _tetrahedra_kernels as layout
from . import _tetrahedra_query_kernels as queries

_CELLS_A_POINT = 7.2  # of uniform points 6.77, and as many are ever in use at once
_CACHE_LINE = 64
# A neighbour is a cell's number times eight in 32 bits; of the numbers some are left for ghosts and the cavity.
MAX_CELLS = 2**28 - 1
MAX_POINTS = int(MAX_CELLS / _CELLS_A_POINT) - 1024


def extended(buffer: np.ndarray, used: int, more: np.ndarray) -> np.ndarray:
    """A buffer with ``more`` after its first ``used`` entries: itself, or one twice as long if it has no room."""
    n = used + len(more)
    if n > len(buffer):
        longer = np.empty((max(n, 2 * len(buffer)), *buffer.shape[1:]), buffer.dtype)
        longer[:used] = buffer[:used]
        buffer = longer
    buffer[used:n] = more
    return buffer


class Lists:
    """What one thread needs while it inserts points; its cells are those from ``state[NEXT]`` to ``state[END]``."""

    def __init__(self, quantum: float, extent: float, size: int = 1024):
        self.state = np.zeros(kernels.STATE_SIZE, np.int64)
        self.state[layout.FREE] = -1
        self.limits = np.zeros(layout.LIMITS_SIZE)
        self.edges = np.empty(kernels.SMALL**2, np.int32)
        self.set_limits(quantum, extent)
        self.grow(size)

    def set_limits(self, quantum: float, extent: float) -> None:
        """Set up the filters of the predicates."""
        layout.set_limits(self.limits, extent)
        self.work = predicates.workspace(quantum)

    def grow(self, size: int = 0) -> None:
        """Make room for larger cavities; between two points nothing is kept in the lists."""
        size = size or 4 * len(self.cavity)
        self.cavity = np.empty(size, np.int32)
        self.facets = np.empty(8 * size, np.int32)
        self.corners = np.empty(size, np.int32)
        self.offsets = np.empty(4 * size)
        self.table = np.empty(48 * size, np.int64)


class SpaceCells:
    """A triangulation of space, ghosts included, as `_tetrahedra_kernels` lays it out.

    Attributes
    ----------
    points : (4 * capacity,) float
        x, y, z and size of each vertex.
    rows : (capacity,) int32
        For each vertex the row of its point among the caller's, which decides ties.
    cells, planes : (16 * capacity,) int32, (8 * capacity,) float
        Two views of the cells' records.
    region, facet_id, cell_of : int32
        Side arrays; empty unless asked for.
    place : (at least number of vertices + threads,) int32
        See `_delaunay_3d_kernels`.
    n_vertices : int
        Vertices in use.
    quantum, extent : float
        A power of two that divides all coordinates, or 0, and a bound, at least 1/2, of their differences.
    lists : Lists
        Counters of the triangulation, and lists for one thread.
    """

    def __init__(self, points: np.ndarray, rows: np.ndarray, first: np.ndarray, quantum: float, extent: float):
        """Take vertices, and insert the four of a positive first cell, with its ghosts."""
        self.points = points
        self.rows = rows
        self.n_vertices = len(rows)
        self.region = np.empty(0, np.int32)
        self.facet_id = np.empty(0, np.int32)
        self.cell_of = np.empty(0, np.int32)
        self.place = np.zeros(self.n_vertices + 1, np.int32)
        self.quantum, self.extent = quantum, extent
        self.lists = Lists(quantum, extent)
        self._set_capacity(int(_CELLS_A_POINT * len(rows)) + 1024)
        layout.set_first_cells(self.points, self.cells, self.planes, first)
        self.lists.state[layout.NEXT] = 5

    @property
    def state(self) -> np.ndarray:
        """Counters of the triangulation."""
        return self.lists.state

    @property
    def n_cells(self) -> int:
        """Records in use, those of ghosts and of free cells included."""
        return int(self.state[layout.NEXT])

    @property
    def capacity(self) -> int:
        """Records that there is room for."""
        return len(self.cells) // 16

    def grow(self) -> None:
        """Make room for half as many cells again.

        Raises
        ------
        GenerationFailed
            If there are as many as can be numbered.
        """
        if self.capacity >= MAX_CELLS:
            raise GenerationFailed(
                f"the triangulation of {self.n_vertices} points needs more than {MAX_CELLS} tetrahedra, which happens "
                "for points along two skew lines or curves; use fewer points"
            )
        self._set_capacity(min(MAX_CELLS, self.capacity + self.capacity // 2), self.n_cells)

    def _set_capacity(self, capacity: int, used: int = 0) -> None:
        raw = np.empty(_CACHE_LINE * (capacity + 1), np.uint8)
        start = -raw.ctypes.data % _CACHE_LINE
        raw = raw[start : start + _CACHE_LINE * capacity]
        if used:
            raw[: _CACHE_LINE * used] = self.cells[: 16 * used].view(np.uint8)
        self.cells, self.planes = raw.view(np.int32), raw.view(np.float64)
        for name, width in (("region", 1), ("facet_id", 4)):
            old = getattr(self, name)
            if len(old):
                new = np.zeros(width * capacity, np.int32)
                new[: width * used] = old[: width * used]
                setattr(self, name, new)
        self.lists.state[layout.END] = capacity

    def append(self, points: np.ndarray, rows: np.ndarray, quantum: float, extent: float) -> None:
        """Add vertices, (4 * k,) coordinates and rows, that are yet to be inserted; takes time for them only."""
        used = self.n_vertices
        self.points = extended(self.points, 4 * used, points)
        self.rows = extended(self.rows, used, rows)
        self.n_vertices += len(rows)
        if len(self.place) <= self.n_vertices:
            self.place = np.zeros(2 * self.n_vertices + 1, np.int32)
        if len(self.cell_of):
            self.cell_of = np.concatenate([self.cell_of[:used], np.full(len(rows), -1, np.int32)])
        self.quantum, self.extent = quantum, extent
        self.lists.set_limits(quantum, extent)

    def map_vertices(self) -> np.ndarray:
        """``cell_of``, made at the first call; insertion keeps it from then on."""
        if len(self.cell_of) == 0:
            self.cell_of = np.empty(self.n_vertices, np.int32)
            queries.map_vertices(self.cells, self.n_cells, self.cell_of)
        return self.cell_of

    # ---- what later rooms stand on

    def require(self, *names: str) -> None:
        """Make side arrays, all zero, or the map ``cell_of``; from then on insertion and `replace` keep them."""
        for name in names:
            if name == "cell_of":
                self.map_vertices()
            elif not len(getattr(self, name)):
                setattr(self, name, np.zeros(self.capacity * {"region": 1, "facet_id": 4}[name], np.int32))

    def constrain(self, cell: int, facet: int, number: int = 0) -> None:
        """Make a facet constrained, on both sides, and give it an id if there are any."""
        word = int(self.cells[16 * cell + 4 + facet])
        for t, k in ((cell, facet), (word >> 3, word & 3)):
            self.cells[16 * t + 4 + k] |= layout.CONSTRAINED
            if len(self.facet_id):
                self.facet_id[4 * t + k] = number

    def replace(self, old: np.ndarray, new: np.ndarray) -> tuple[int, np.ndarray]:
        """`replace_cavity`: status, and the numbers of the (m, 4) new cells in the place of the (n,) old ones."""
        old = np.ascontiguousarray(old, np.int32)
        new = np.array(new, np.int32).ravel()
        made = np.empty(len(new) // 4, np.int32)
        table = np.empty(90 * (len(old) + len(made)) + 90, np.int32)
        while True:
            status = cavity_kernels.replace_cavity(
                self.points, self.cells, self.planes, self.region, self.facet_id, self.cell_of, old, new, made, table,
                self.state, self.lists.work,
            )  # fmt: skip
            if status != layout.FULL_CELLS:
                return status, made
            self.grow()

    def compact(self) -> np.ndarray:
        """Leave no free cells between live ones; return for each former cell its number now, or -1."""
        number = np.empty(self.n_cells, np.int32)
        cavity_kernels.compact(
            self.cells, self.planes, self.region, self.facet_id, self.cell_of, self.state, number
        )  # fmt: skip
        return number
