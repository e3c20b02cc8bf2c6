"""The Delaunay triangulation of points in space, to which points can be added and in which they can be located."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..geometry import predicates
from ..geometry.location import Location
from ..mesh import Mesh
from ..progress import Progress, part_of, silent
from ..threads import checked_threads
from . import _tetrahedra_export_kernels as export_kernels
from . import _tetrahedra_kernels as layout
from . import _tetrahedra_location_kernels as location_kernels
from .insertion_order import insertion_order
from .space_cells import SpaceCells, extended
from .space_insertion import (
    extent_of,
    in_ranges,
    in_rounds,
    insert,
    number_of_threads,
    safe_exponent,
    space_order,
)

# What is smaller than this beside an extent of one could underflow in a predicate's products.
_NEGLIGIBLE = 2.0 ** (predicates.LOWEST_BIT + 53)


@dataclass
class _Canonical:
    """The finite cells in canonical order: bucket ends, corners by rank, and the row of each rank."""

    rank: np.ndarray
    starts: np.ndarray
    corners: np.ndarray
    row_of_rank: np.ndarray

    def rows(self, threads: int = 1) -> np.ndarray:
        """(m, 4) int64: the cells' corners by the caller's rows."""
        rows = np.empty(len(self.corners), np.int64)
        in_ranges(
            lambda start, stop: export_kernels.write_rows(self.corners, self.row_of_rank, rows, start, stop),
            len(rows) // 4,
            threads,
        )
        return rows.reshape(-1, 4)


class Tetrahedralization:
    """A Delaunay triangulation of space.

    Made by `from_points`. Of points at one place the first is used. Where five or more points lie on one sphere, the
    choice is made as if each point were lifted by an infinitesimal, the larger the lower its number: the triangulation
    is unique, whatever the order of insertion, the number of threads and the platform.

    Attributes
    ----------
    points : (n, 3) float
        All points, in the order in which they were given.
    merged, kept : (d,) int
        Points that are no corner of any cell, and the points at the same places that are.

    References
    ----------
    Survey, section 3.2.4. C. Marot, J. Pellerin, J.-F. Remacle, "One machine, one minute, three billion tetrahedra",
    Int. J. Numer. Methods Eng. 117 (2019). H. Edelsbrunner, E. P. Muecke, "Simulation of simplicity", ACM Trans.
    Graphics 9 (1990).

    Examples
    --------
    >>> cube = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    >>> space = Tetrahedralization.from_points(cube)
    >>> space.mesh()
    Mesh(8 points, 6 tetra)
    >>> space.add([[0.5, 0.5, 0.5]])
    >>> space.mesh()
    Mesh(9 points, 12 tetra)
    >>> cell, weights = space.locate([[0.5, 0.5, 0.5], [2, 0, 0]])
    >>> int(cell[1]), float(weights[0].max())
    (-1, 1.0)
    """

    def __init__(self, points: np.ndarray, space: SpaceCells, merged: np.ndarray, kept: np.ndarray, exponent: int):
        self.points = points
        self.merged, self.kept = merged, kept
        self._buffer = points  # begins with the points, and may have room for more
        self._box = _box_of(points)
        self._space: SpaceCells | None = space
        self._exponent = exponent
        self._threads = 1
        self._by_curve = True  # vertices are numbered as they would be if all points were given now

    @classmethod
    def from_points(cls, points: Any, *, threads: int | None = None, progress: Progress = silent) -> Tetrahedralization:
        """Triangulate points.

        Parameters
        ----------
        points : (n, 3) float, or Mesh
            At least four that do not lie in one plane.
        threads : int, optional
            How many threads share the work; all available cores if not given and there are many points. The result
            does not depend on it.
        progress : Progress, optional
            Called with fraction and message.

        Returns
        -------
        Tetrahedralization

        Raises
        ------
        InvalidInput
            If the points have a wrong shape, or coordinates too far apart in magnitude (more than about 1e109).
        InvalidGeometry
            If a coordinate is not finite, or all points lie in one plane.

        Examples
        --------
        >>> Tetrahedralization.from_points([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]).mesh()
        Mesh(4 points, 1 tetra)
        """
        threads = checked_threads(threads)
        points = _coordinates(points).copy()
        exponent = safe_exponent(points)
        order = space_order(_scaled(points, exponent), part_of(progress, 0.0, 0.1))
        space = SpaceCells(order.points, order.rows, order.first, order.quantum, order.extent)
        threads = number_of_threads(threads, len(order.rows))
        insert(space, order.todo, threads, part_of(progress, 0.1, 0.9))
        triangulation = cls(points, space, order.merged, order.kept, exponent)
        triangulation._threads = threads
        return triangulation

    def add(self, points: Any, *, threads: int | None = None, progress: Progress = silent) -> None:
        """Insert more points; they are numbered after those there are.

        The cells are those that all points given at once would have.

        Parameters
        ----------
        points : (k, 3) float, or Mesh
            More points.
        threads, progress
            As in `from_points`.

        Raises
        ------
        InvalidInput, InvalidGeometry
            As in `from_points`; nothing is added then.

        Examples
        --------
        >>> space = Tetrahedralization.from_points([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
        >>> space.add([[1, 1, 1], [1, 0, 0]])
        >>> space.mesh(), space.merged.tolist(), space.kept.tolist()
        (Mesh(6 points, 2 tetra), [5], [1])
        """
        threads = checked_threads(threads)
        more, n_old = _coordinates(points), len(self.points)
        if not len(more):
            return
        buffer = extended(self._buffer, n_old, more)
        together = buffer[: n_old + len(more)]
        exponent = 0 if self._exponent == 0 and predicates.is_safe(more) else safe_exponent(together)
        if exponent != self._exponent:  # other limits of magnitude: filters and cached spheres would not fit
            fresh = self.from_points(together, threads=threads, progress=progress)
            self.__dict__.clear()
            self.__dict__.update(fresh.__dict__)
            return
        box = _box_of(np.concatenate([self._box, more]))
        scaled = _scaled(more, exponent)
        order = insertion_order(scaled, 3, rounds=False, progress=part_of(progress, 0.0, 0.1))
        records = np.zeros((len(order.rows), 4))
        records[:, :3] = order.coordinates.reshape(-1, 3)
        space = self._cells()
        quantum, extent = min(space.quantum, predicates.quantum_of(scaled)), extent_of(_scaled(box, exponent))
        vertices = np.arange(space.n_vertices, space.n_vertices + len(order.rows), dtype=np.int32)
        todo = vertices[in_rounds(len(vertices))]
        self._space = None  # if the work is broken off, the points there were are triangulated anew when asked for
        space.append(records.ravel(), order.rows + np.int32(n_old), quantum, extent)
        fate = insert(space, todo, number_of_threads(threads, len(vertices)), part_of(progress, 0.1, 1.0))[vertices]
        self._space = space
        doubled = np.flatnonzero(fate >= 0)
        stays = np.arange(n_old, len(together))
        stays[order.rows[doubled]] = space.rows[fate[doubled]]
        stays[order.merged] = stays[order.kept]
        moved = np.flatnonzero(stays != np.arange(n_old, len(together)))
        self.merged = np.concatenate([self.merged, n_old + moved])
        self.kept = np.concatenate([self.kept, stays[moved]])
        self.points, self._buffer, self._box, self._by_curve = together, buffer, box, False
        self.__dict__.pop("_canonical", None)

    def _cells(self) -> SpaceCells:
        """The triangulation; made anew if the last `add` was broken off."""
        if self._space is None:
            self._space = self.from_points(self.points, threads=self._threads)._space
            self._by_curve = True
            self.__dict__.pop("_canonical", None)
        return self._space

    def mesh(self) -> Mesh:
        """The tetrahedra as a mesh on all points, in an order that depends on the points only.

        Returns
        -------
        Mesh
            Positive "tetra" cells that fill the convex hull.

        Examples
        --------
        >>> Tetrahedralization.from_points([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]).mesh().cells["tetra"]
        array([[1, 0, 3, 2]])
        """
        return Mesh(self.points.copy(), {"tetra": self._canonical.rows(self._threads)})

    def locate(self, points: Any) -> Location:
        """The cell that holds each of some points.

        Parameters
        ----------
        points : (k, 3) float
            Anywhere.

        Returns
        -------
        Location
            ``cell``, (k,) int, is the number of the cell of `mesh` that holds the point, the lowest if it lies between
            several, -1 outside the convex hull; decided exactly, but for coordinates below about 1e-48 of the points'
            extent, which count as zero.
            ``barycentric``, (k, 4) float, are weights of its corners, of sum 1 and not below zero but for rounding;
            nan outside.

        Examples
        --------
        >>> space = Tetrahedralization.from_points([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
        >>> space.locate([[0.25, 0.25, 0.25]])
        Location(cell=array([0]), barycentric=array([[0.25, 0.25, 0.25, 0.25]]))
        """
        asked = _coordinates(points)
        numbers = np.full(len(asked), -1, np.int64)
        low, high = self._box
        near = np.flatnonzero(((asked >= low) & (asked <= high)).all(axis=1))
        scaled = _scaled(asked[near], self._exponent)
        scaled[np.abs(scaled) < _NEGLIGIBLE] = 0.0
        numbers[near] = self._numbers_at(scaled)
        return Location(numbers, self._weights(numbers, asked))

    def _numbers_at(self, places: np.ndarray) -> np.ndarray:
        """(k,) int: the lowest-numbered cells that hold scaled places, -1 outside."""
        space = self._cells()
        canonical = self._canonical
        along_the_curve = insertion_order(places, 3, rounds=False)
        numbers, order = np.empty(len(places), np.int64), along_the_curve.rows
        marks, found, done = np.zeros(space.n_cells, np.int32), np.empty(64, np.int32), 0
        while done < len(order):
            done = location_kernels.locate(
                space.points, space.cells, places, order, done, space.state[layout.HINT], canonical.rank,
                canonical.starts, canonical.corners, marks, found, numbers, predicates.workspace(),
            )  # fmt: skip
            marks, found = np.zeros(space.n_cells, np.int32), np.empty(4 * len(found), np.int32)
        numbers[along_the_curve.merged] = numbers[along_the_curve.kept]
        return numbers

    def _weights(self, numbers: np.ndarray, asked: np.ndarray) -> np.ndarray:
        """(k, 4) float: barycentric coordinates of points in cells, NaN where the number is negative."""
        weights = np.full((len(asked), 4), np.nan)
        inside = np.flatnonzero(numbers >= 0)
        canonical = self._canonical
        rows = canonical.row_of_rank[canonical.corners.reshape(-1, 4)[numbers[inside]]]
        edges = _scaled(self.points[rows], self._exponent) - _scaled(asked[inside], self._exponent)[:, None]
        for k in range(4):
            a, b, c = (edges[:, (k + j) % 4] for j in (1, 2, 3))
            weights[inside, k] = np.abs(np.einsum("ij,ij->i", a, np.cross(b, c)))
        weights[inside] /= weights[inside].sum(axis=1, keepdims=True)
        return weights

    @cached_property
    def _canonical(self) -> _Canonical:
        space = self._cells()
        n = space.n_vertices
        rank, row_of_rank = np.empty(0, np.int32), space.rows[:n]
        if not self._by_curve:
            row_of_rank = insertion_order(_scaled(self.points, self._exponent), 3, rounds=False).rows
            rank_of_row = np.zeros(len(self.points), np.int32)
            rank_of_row[row_of_rank] = np.arange(len(row_of_rank))
            rank = rank_of_row[space.rows[:n]]
        starts = np.zeros(len(row_of_rank) + 1, np.int64)
        n_cells = export_kernels.count_cells(space.cells, space.n_cells, rank, starts)
        corners = np.empty(4 * n_cells, np.int32)
        export_kernels.fill_buckets(space.cells, space.n_cells, rank, starts, corners)
        in_ranges(
            lambda start, stop: export_kernels.sort_buckets(starts, corners, start, stop),
            len(row_of_rank),
            self._threads,
        )
        return _Canonical(rank, starts, corners, row_of_rank)

    def _into_mesh(self) -> Mesh:
        """`mesh` for the last time: memory is given back as soon as it is not needed, and before that of the mesh."""
        del self._space.points, self._space.place
        canonical = self._canonical
        del self._space
        return Mesh(self.points, {"tetra": canonical.rows(self._threads)})


def _coordinates(points: Any) -> np.ndarray:
    """(n, 3) float: the points of a mesh, or of an array that is checked like one's."""
    return (points if isinstance(points, Mesh) else Mesh(points, {})).points


def _box_of(points: np.ndarray) -> np.ndarray:
    """(2, 3) float: lower and upper corner."""
    return np.array([[axis.min() for axis in points.T], [axis.max() for axis in points.T]])


def _scaled(points: np.ndarray, exponent: int) -> np.ndarray:
    return np.ldexp(points, exponent) if exponent else points
