"""The triangulation that the planar generators work on: half-edges in growing arrays, built by insertion."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np

from ..errors import InvalidGeometry, InvalidInput
from ..geometry import predicates
from ..geometry.location import Location
from ..mesh import Mesh
from ..progress import Progress, part_of, silent
from ..threads import available_threads, checked_threads
from . import _delaunay_kernels as kernels
from . import _half_edge_kernels as half_edges
from .half_edge_arrays import Scratch, grown
from .insertion_order import InsertionOrder, insertion_order
from .point_insertion import insert, insert_on_threads
from .thin_clouds import planar_order

__all__ = ["Scratch", "Triangulation", "grown", "triangulated"]

# Of the points along the curve every so many are inserted first: cavities are then rounder than at the edge of a
# growing strip, and threads find triangles of their own.
_STRIDES, _ONE_ROUND = (256, 16), (1, 1)
# Below this number of points a second thread does not pay.
_POINTS_A_THREAD = 50_000
# Half-edges are numbered by 32 bits, four a triangle and two triangles a point.
MAX_POINTS = 2**28 - 8
# Up to this many points `Triangulation.add` is not to be cancelled.
_POINTS_IN_PLACE = 20_000


class Triangulation:
    """A Delaunay triangulation of points in the plane, to which points can be added and in which they can be found.

    It is made by `from_points`. Of points on one circle the one of lowest number decides which diagonals there are (it
    counts as lifted a little above the paraboloid), so that there is only one Delaunay triangulation: however it is
    built, in one go or by and by, on however many threads, the mesh is the same.

    Parameters
    ----------
    xy : (2 * n,) float
        Coordinates of the vertices, safe for the predicates; vertices are points in the order of their insertion.
    order : (n,) int32
        For each vertex the number of the point that it stands for.
    quantum : float
        A power of two that divides all coordinates, or zero (`predicates.quantum_of`).

    Attributes
    ----------
    origin, twin : (4 * capacity,) int32
        Half-edges, flags and stamps, ghosts included, as `_half_edge_kernels` lays them out.
    n_triangles : int
        Slots in use, ghosts included.
    start : int
        A half-edge of a finite triangle, where walks start.
    scratch : Scratch
        Buffers.

    References
    ----------
    Survey, section 3.2.4. H. Edelsbrunner, E. P. Muecke, "Simulation of simplicity", ACM Trans. Graphics 9 (1990).

    Examples
    --------
    >>> square = Triangulation.from_points([[0, 0], [1, 0], [1, 1], [0, 1]])
    >>> square.mesh()
    Mesh(4 points, 2 triangle)
    >>> square.add([[0.5, 0.5]])
    >>> square.mesh()
    Mesh(5 points, 4 triangle)
    >>> cell, barycentric = square.locate([[0.5, 0.25], [2.0, 2.0]])
    >>> square.mesh().cells["triangle"][cell[0]].tolist(), barycentric[0].tolist(), int(cell[1])
    ([0, 1, 4], [0.25, 0.25, 0.5], -1)
    """

    def __init__(self, xy: np.ndarray, order: np.ndarray, quantum: float):
        n = len(order)
        self.xy, self._order, self.n_vertices, self.quantum = xy, order, n, quantum
        # Room for a few more, who would copy all else; no memory is touched before it is used.
        slots = 2 * n + n // 16 + 8
        self.origin, self.twin = (np.zeros(4 * slots, np.int32) for _ in range(2))
        self.n_triangles = self.start = 0
        self.scratch = Scratch(quantum)
        # Of the points as the caller gave them; `from_points` fills these in.
        self.exponent = 0
        self._points = np.empty((0, 3))
        self.n_points = 0
        self.merged = self.kept = np.empty(0, np.int64)
        self._added = self._is_broken = False
        self._numbered: tuple[Mesh, np.ndarray] | None = None

    @classmethod
    def from_points(cls, points: Any, *, threads: int | None = None, progress: Progress = silent) -> Triangulation:
        """Triangulate points.

        Parameters
        ----------
        points : (n, 2) or (n, 3) float, or Mesh
            z must be zero. Of points at one place the first becomes a vertex.
        threads : int, optional
            How many to use; without it as many as pay, up to the cores there are.
        progress : Progress, optional
            Called with fraction and message.

        Returns
        -------
        Triangulation

        Raises
        ------
        InvalidInput
            If points are not in the plane z = 0, are too many, or too far apart in magnitude.
        InvalidGeometry
            If points are not finite, all on one line, or fewer than three.
        """
        cloud = planar_points(points).copy()  # the caller may change his own
        scaled, exponent = predicates.rescaled(cloud)
        mesh = triangulated(scaled, progress, threads=threads)
        mesh.exponent, mesh._points = exponent, cloud
        return mesh

    @property
    def order(self) -> np.ndarray:
        """(n,) int32: for each vertex the number of the point that it stands for."""
        return self._order[: self.n_vertices]

    @property
    def points(self) -> np.ndarray:
        """(m, 3) float: all points as given, those that were merged included; a copy."""
        return self._points[: self.n_points].copy()

    @property
    def vertex_of(self) -> np.ndarray:
        """(m,) int: for each point its vertex."""
        vertex = np.empty(self.n_points, np.int64)
        vertex[self.order] = np.arange(self.n_vertices)
        vertex[self.merged] = vertex[self.kept]
        return vertex

    def live(self) -> tuple[np.ndarray, np.ndarray]:
        """(m, 3) int32 corners, by vertex, and (m,) int32 slots of the finite triangles that are not dead."""
        corners = np.empty((self.n_triangles, 3), np.int32)
        slots = np.empty(self.n_triangles, np.int32)
        count = half_edges.live_triangles(self.origin, self.n_triangles, corners, slots)
        return corners[:count], slots[:count]

    def mesh(self) -> Mesh:
        """The triangles on all points.

        Returns
        -------
        Mesh
            Counter-clockwise "triangle" cells, in an order that depends on the points only: along a Hilbert curve.
        """
        return self._numbering()[0]

    def _numbering(self) -> tuple[Mesh, np.ndarray]:
        """The mesh, and for each slot the number of its cell as `canonical_cells` writes it."""
        self._mend()
        if self._numbered is None:
            number_of = np.empty(self.n_triangles, np.int32)
            cells = canonical_cells(self.origin, self.n_triangles, self.order, self._places(), number_of)
            self._numbered = Mesh(self.points, {"triangle": cells}), number_of
        return self._numbered

    def _places(self) -> np.ndarray:
        """For each vertex its place along the curve of all points; empty if that is its number."""
        if not self._added:
            return np.empty(0, np.int32)
        rows = planar_order(np.ldexp(self.points, self.exponent))[0].rows
        place = np.empty(self.n_vertices, np.int32)
        place[self.vertex_of[rows]] = np.arange(len(rows))
        return place

    def locate(self, points: Any) -> Location:
        """Find the triangle that holds each point, by walks along a Hilbert curve, with exact decisions.

        Parameters
        ----------
        points : (k, 2) or (k, 3) float, or Mesh
            Where to look; z does not count. A point on an edge or a vertex gets the first of its cells.

        Returns
        -------
        Location
            ``cell``, (k,) int, numbers the cells of `mesh`, -1 outside; ``barycentric`` is (k, 3) float, nan outside.

        Raises
        ------
        InvalidInput
            If the array has another shape.
        InvalidGeometry
            If points are not finite.
        """
        queries = Mesh(points, {}).points if not isinstance(points, Mesh) else points.points
        queries = predicates.resolved(np.ldexp(queries, self.exponent))
        order = insertion_order(queries, 2, rounds=False)
        number_of = self._numbering()[1]
        cell = np.empty(len(queries), np.int64)
        weights = np.full((len(queries), 3), np.nan)
        kernels.locate_points(
            self.xy, self.origin, self.twin, order.coordinates, order.rows, self.start, number_of, cell,
            weights.reshape(-1), predicates.workspace(),
        )  # fmt: skip
        cell[order.merged], weights[order.merged] = cell[order.kept], weights[order.kept]
        return Location(cell, weights)

    def add(self, points: Any, *, progress: Progress = silent) -> None:
        """Add points, inside or outside the hull; the mesh becomes that of all points together.

        Parameters
        ----------
        points : (k, 2) or (k, 3) float, or Mesh
            z must be zero. They are numbered on from those there are.
        progress : Progress, optional
            Called with fraction and message. If it cancels, the triangulation stays as it was.

        Raises
        ------
        InvalidInput
            If points are not in the plane z = 0, or all points together are too many or too far apart in magnitude.
        InvalidGeometry
            If points are not finite.
        """
        new = planar_points(points)
        if not len(new):
            return
        self._mend()
        _check_count(self.n_points + len(new))
        scaled = np.ldexp(new, self.exponent) if self.exponent else new
        if not predicates.is_safe(scaled):
            self._become(Triangulation.from_points(np.concatenate([self.points, new]), progress=progress))
            return
        order = insertion_order(scaled, 2, rounds=False, progress=part_of(progress, 0.0, 0.2))
        # Few points are inserted in place and at once; for many a copy may be thrown away if the user cancels.
        few = len(new) <= _POINTS_IN_PLACE
        bigger = self._extended(new, order, predicates.quantum_of(scaled), in_place=few)
        todo = np.arange(self.n_vertices, bigger.n_vertices, dtype=np.int32)
        self._is_broken = few  # should an interrupt come half-way through arrays that are shared
        again = insert(bigger, todo, silent if few else part_of(progress, 0.2, 1.0))
        self._replace_by(bigger, again, order)

    def _extended(self, new: np.ndarray, order: InsertionOrder, quantum: float, *, in_place: bool) -> Triangulation:
        """A copy with more vertices, not yet inserted; with ``in_place`` arrays are shared if they have the room."""
        n, k = self.n_vertices, len(order.rows)

        def roomy(array: np.ndarray, used: int, needed: int) -> np.ndarray:
            if in_place and needed <= len(array):
                return array
            return grown(array[:used], needed + needed // 2)

        bigger = copy.copy(self)
        bigger.xy = roomy(self.xy, 2 * n, 2 * (n + k))
        bigger.xy[2 * n : 2 * (n + k)] = order.coordinates
        bigger._order = roomy(self._order, n, n + k)
        bigger._order[n : n + k] = order.rows + np.int32(self.n_points)
        bigger._points = roomy(self._points, self.n_points, self.n_points + len(new))
        bigger._points[self.n_points : self.n_points + len(new)] = new
        slots = self.n_triangles + 2 * k + 8
        bigger.origin, bigger.twin = (
            roomy(array, 4 * self.n_triangles, 4 * slots) for array in (self.origin, self.twin)
        )
        bigger.n_vertices, bigger.n_points = n + k, self.n_points + len(new)
        bigger.quantum = min(self.quantum, quantum)
        bigger.scratch = Scratch(bigger.quantum)
        return bigger

    def _replace_by(self, bigger: Triangulation, again: np.ndarray, order: InsertionOrder) -> None:
        """Take over what `add` has made; ``again`` are new vertices at the places of others."""
        first = self.n_points
        rows = order.rows[again - self.n_vertices] + np.int64(first)
        others = bigger._order[~bigger._order[again]]
        bigger._order[again] = rows
        stays = np.arange(first, bigger.n_points)
        stays[rows - first] = others
        stays[order.merged] = stays[order.kept]
        merged = np.flatnonzero(stays != np.arange(first, bigger.n_points))
        bigger.merged = np.append(self.merged, merged + first)
        bigger.kept = np.append(self.kept, stays[merged])
        bigger._added, bigger._numbered = True, None
        self._become(bigger)

    def _mend(self) -> None:
        """Make the triangulation anew if the last `add` was interrupted."""
        if self._is_broken:
            self._become(Triangulation.from_points(self.points))

    def _become(self, other: Triangulation) -> None:
        """Take over all that another has."""
        vars(self).update(vars(other))


def triangulated(
    points: np.ndarray, progress: Progress = silent, parameter: str = "points", *, threads: int | None = 1
) -> Triangulation:
    """Delaunay triangulation of points that are safe for exact arithmetic (`predicates.rescaled`).

    Parameters
    ----------
    points : (n, 2) or (n, 3) float
        z is not looked at. Of equal points the first becomes a vertex.
    progress : Progress, optional
        Called with fraction and message.
    parameter : str
        What errors call the points.
    threads : int, optional
        None for as many as pay.

    Returns
    -------
    Triangulation

    Raises
    ------
    InvalidInput
        If there are too many points.
    InvalidGeometry
        If there are fewer than three different points, or all lie on one line.
    """
    _check_count(len(points), parameter)
    order, thin = planar_order(points, part_of(progress, 0.0, 0.2))
    mesh = Triangulation(order.coordinates, order.rows, predicates.quantum_of(points))
    mesh._points, mesh.n_points, mesh.merged, mesh.kept = points, len(points), order.merged, order.kept
    n = len(order.rows)
    todo = np.empty(max(n - 3, 0), np.int32)
    third = _begin(mesh, parameter)
    n_first = kernels.list_in_rounds(n, third, *(_ONE_ROUND if thin else _STRIDES), todo)
    threads = _threads(threads, n)
    progress = part_of(progress, 0.2, 1.0)
    if threads > 1 and not thin:
        insert(mesh, todo[:n_first], part_of(progress, 0.0, 0.05))
        insert_on_threads(mesh, todo[n_first:], threads, part_of(progress, 0.05, 1.0))
    else:
        insert(mesh, todo, progress)
    return mesh


def _threads(wanted: int | None, n: int) -> int:
    """How many threads to use for n points; none gets fewer than `_POINTS_A_THREAD`."""
    return max(1, min(checked_threads(wanted) or available_threads(), n // _POINTS_A_THREAD))


def _begin(mesh: Triangulation, parameter: str) -> int:
    """Make the first triangle, of the first two vertices and the first one that is not on their line; return that."""
    n = len(mesh.order)
    if n < 3:
        raise InvalidGeometry(f"needs at least three different points, got {n}", parameter=parameter)
    third = kernels.first_triangle(mesh.xy, mesh.origin, mesh.twin, mesh.scratch.work)
    if not third:
        raise InvalidGeometry(f"all {n} points lie on one line; no area to mesh", parameter=parameter)
    mesh.n_triangles = 4
    return third


def planar_points(points: Any, parameter: str = "points") -> np.ndarray:
    """(n, 3) float: points as an array or of a mesh, checked to be finite and in the plane z = 0."""
    cloud = points if isinstance(points, Mesh) else Mesh(points, {})
    if not cloud.is_planar:
        high = float(np.abs(cloud.points[:, 2]).max())
        raise InvalidInput(f"needs points in the plane z = 0, but z reaches {high:g}", parameter=parameter)
    return cloud.points


def canonical_cells(
    origin: np.ndarray, n_triangles: int, order: np.ndarray, place: np.ndarray, number_of: np.ndarray
) -> np.ndarray:
    """(m, 3) int64: the finite triangles by the points' numbers, in an order that depends on the set of them only.

    ``place`` and ``number_of`` may be empty: see the kernel of the same name.
    """
    cells = np.empty((n_triangles, 3), np.int64)
    counts = np.empty(len(order) + 1, np.int32)
    return cells[: kernels.canonical_cells(origin, n_triangles, place, order, counts, cells, number_of)]


def _check_count(n: int, parameter: str = "points") -> None:
    if n > MAX_POINTS:
        raise InvalidInput(f"{n:,} points are too many; the limit is {MAX_POINTS:,}", parameter=parameter)
