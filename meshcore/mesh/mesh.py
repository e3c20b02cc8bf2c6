"""Mesh: points, cells by kind, data and named sets; frozen, so that derived topology never goes stale."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..errors import InvalidGeometry, InvalidInput
from . import topology
from .cells import CELL_TYPES
from .extent import bounds


@dataclass(frozen=True, eq=False, repr=False)
class Mesh:
    """An unstructured mesh, or a boundary, or a curve.

    A boundary is a mesh of "line" cells in the plane, of "triangle" and "quad" cells in space. Cells are positively
    oriented: counter-clockwise in the plane, positive volume in space, nodes in VTK's order. Cells are numbered
    through all kinds, in the order of `cells`.

    Parameters
    ----------
    points : (n, 3) or (n, 2) float
        Coordinates; planar points get z = 0.
    cells : dict of str to (m, k) int
        Nodes of the cells of each kind, by meshio's names: ``{"triangle": (m, 3), "quad": (k, 4)}``.
    point_data : dict of str to (n, ...) array
        Values at points.
    cell_data : dict of str to (number of cells, ...) array
        Values on cells, over all kinds in their order.
    sets : dict of str to (k,) int
        Named groups of cells, by number. A group of points is a group of "vertex" cells.
    field_data : dict of str to array
        Values of the mesh as a whole, such as ``"holes"`` (k, 2) and ``"regions"`` (k, 4) of a Triangle file.

    Raises
    ------
    InvalidInput
        If shapes or types do not fit; the message names the array.
    InvalidGeometry
        If points are not finite or a cell refers to a point that does not exist.

    Examples
    --------
    ::

        3---2
        | / |      two triangles of the unit square
        0---1

    >>> square = Mesh([[0, 0], [1, 0], [1, 1], [0, 1]], {"triangle": [[0, 1, 2], [0, 2, 3]]})
    >>> square
    Mesh(4 points, 2 triangle)
    >>> len(square.edges), square.boundary.n_cells
    (5, 4)
    """

    points: np.ndarray
    cells: dict[str, np.ndarray]
    point_data: dict[str, np.ndarray] = field(default_factory=dict)
    cell_data: dict[str, np.ndarray] = field(default_factory=dict)
    sets: dict[str, np.ndarray] = field(default_factory=dict)
    field_data: dict[str, np.ndarray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "points", checked_points(self.points))
        set_(self, "cells", {k: _checked_cells(k, v, len(self.points)) for k, v in dict(self.cells).items()})
        set_(self, "point_data", checked_data(self.point_data, self.n_points, "point"))
        set_(self, "cell_data", checked_data(self.cell_data, self.n_cells, "cell"))
        set_(self, "sets", {k: _checked_set(k, v, self.n_cells) for k, v in dict(self.sets).items()})
        set_(self, "field_data", {k: np.ascontiguousarray(v) for k, v in dict(self.field_data).items()})

    @classmethod
    def unchecked(
        cls,
        points: np.ndarray,
        cells: dict[str, np.ndarray],
        cell_data: dict[str, np.ndarray] | None = None,
        sets: dict[str, np.ndarray] | None = None,
    ) -> Mesh:
        """A mesh of arrays that are known to be as the constructor would make them; for generators' own results.

        Examples
        --------
        >>> Mesh.unchecked(np.eye(3), {"triangle": np.array([[0, 1, 2]])})
        Mesh(3 points, 1 triangle)
        """
        mesh = object.__new__(cls)
        data = {"point_data": {}, "cell_data": cell_data or {}, "sets": sets or {}, "field_data": {}}
        vars(mesh).update(points=points, cells=cells, **data)
        return mesh

    def __repr__(self) -> str:
        kinds = ", ".join(f"{len(c)} {kind}" for kind, c in self.cells.items())
        return f"Mesh({self.n_points} points, {kinds or 'no cells'})"

    # ---- sizes

    @property
    def n_points(self) -> int:
        """Number of points."""
        return len(self.points)

    @property
    def n_cells(self) -> int:
        """Number of cells of all kinds."""
        return sum(len(c) for c in self.cells.values())

    @property
    def dimension(self) -> int:
        """Largest topological dimension of the cells; 0 without any."""
        return max((CELL_TYPES[kind].dimension for kind, c in self.cells.items() if len(c)), default=0)

    @property
    def is_planar(self) -> bool:
        """Whether all points have z = 0."""
        return not self.points[:, 2].any()

    @cached_property
    def bounds(self) -> np.ndarray:
        """(2, 3) float: lower and upper corner of the bounding box; zeros without points."""
        if not self.n_points:
            return np.zeros((2, 3))
        return bounds(self.points)

    @property
    def diagonal(self) -> float:
        """Length of the bounding box's diagonal."""
        return float(np.linalg.norm(self.bounds[1] - self.bounds[0]))

    # ---- cells

    def get(self, kind: str) -> np.ndarray:
        """(m, k) int: the cells of one kind, empty if there are none."""
        return self.cells.get(kind, np.empty((0, CELL_TYPES[kind].nodes), np.int64))

    def blocks(self) -> Iterator[tuple[str, np.ndarray, slice]]:
        """For each kind: its name, its cells, and where they stand among all cells."""
        start = 0
        for kind, cells in self.cells.items():
            yield kind, cells, slice(start, start + len(cells))
            start += len(cells)

    @cached_property
    def centroids(self) -> np.ndarray:
        """(number of cells, 3) float: mean of each cell's nodes."""
        parts = [self.points[cells].mean(axis=1) for cells in self.cells.values()]
        return np.concatenate(parts) if parts else np.empty((0, 3))

    # ---- topology

    @cached_property
    def edges(self) -> np.ndarray:
        """(k, 2) int: each edge once, smaller point first."""
        return topology.edges(self)

    @cached_property
    def facets(self) -> topology.Facets:
        """Edges of cells in the plane, faces of cells in space, with the cells on either side."""
        return topology.facets(self)

    @cached_property
    def boundary(self) -> Mesh:
        """The facets of one cell only, outward, on the same points; ``cell_data["cell"]`` is their owner."""
        return topology.boundary(self)

    # ---- new meshes from old

    def with_cell_data(self, **arrays: np.ndarray) -> Mesh:
        """The same mesh with more cell data."""
        return replace(self, cell_data={**self.cell_data, **arrays})

    def with_point_data(self, **arrays: np.ndarray) -> Mesh:
        """The same mesh with more point data."""
        return replace(self, point_data={**self.point_data, **arrays})

    def with_points(self, points: np.ndarray) -> Mesh:
        """The same cells and data on moved points."""
        return replace(self, points=points)

    def transformed(self, matrix: np.ndarray) -> Mesh:
        """The mesh under a (4, 4) affine matrix; a mirror image is turned to keep cells positive."""
        matrix = np.asarray(matrix, float)
        linear = matrix[:3, :3]
        mirrors = np.cross(linear[0], linear[1]) @ linear[2] < 0  # the determinant
        return self.with_points(self.points @ linear.T + matrix[:3, 3]).reoriented(mirrors)

    def reoriented(self, flip: bool | np.ndarray = True) -> Mesh:
        """The mesh with the cells of ``flip`` (all, none, or (number of cells,) bool) turned inside out."""
        flip = np.broadcast_to(np.asarray(flip, bool), (self.n_cells,))
        cells = {kind: topology.turned(kind, c, flip[where]) for kind, c, where in self.blocks()}
        return replace(self, cells=cells)

    def selected(self, cells: np.ndarray) -> Mesh:
        """The mesh of some cells ((number of cells,) bool or (k,) int), on the points that they use."""
        keep = np.zeros(self.n_cells, bool)
        keep[np.asarray(cells)] = True
        number = np.cumsum(keep) - 1
        kinds = {kind: c[keep[where]] for kind, c, where in self.blocks() if keep[where].any()}
        chosen = replace(
            self,
            cells=kinds,
            cell_data={name: values[keep] for name, values in self.cell_data.items()},
            sets={name: number[members[keep[members]]] for name, members in self.sets.items()},
        )
        return chosen.compacted()

    def compacted(self) -> Mesh:
        """The mesh without the points that no cell uses."""
        used = np.zeros(self.n_points, bool)
        for c in self.cells.values():
            used[c] = True
        if used.all():
            return self
        number = np.cumsum(used) - 1
        return replace(
            self,
            points=self.points[used],
            cells={kind: number[c] for kind, c in self.cells.items()},
            point_data={name: values[used] for name, values in self.point_data.items()},
        )


def checked_points(points: Any) -> np.ndarray:
    """(n, 3) float: finite coordinates, planar ones with z = 0; or `InvalidInput`, `InvalidGeometry`."""
    try:
        given = np.asarray(points)
        points = np.ascontiguousarray(given, dtype=np.float64) if given.dtype.kind != "c" else None
    except (TypeError, ValueError):
        points = None
    if points is None:
        raise InvalidInput("needs real numbers, as an (n, 3) array", parameter="points")
    if points.size == 0:
        points = np.empty((0, 3))
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise InvalidInput(f"needs shape (n, 3) or (n, 2), got {points.shape}", parameter="points")
    if not np.isfinite(points).all():
        bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
        raise InvalidGeometry(
            f"point {bad[0]} is {points[bad[0]].tolist()} ({len(bad)} points are not finite); remove or repair them",
            parameter="points",
            points=bad,
        )
    if points.shape[1] == 2:
        flat = points
        points = np.zeros((len(flat), 3))
        points[:, :2] = flat
    return points


def _checked_cells(kind: str, cells: Any, n_points: int) -> np.ndarray:
    name = f"cells[{kind!r}]"
    if kind not in CELL_TYPES:
        raise InvalidInput(f"unknown kind of cell; known are {', '.join(CELL_TYPES)}", parameter=name)
    nodes = CELL_TYPES[kind].nodes
    cells = np.asarray(cells)
    if cells.size == 0:
        return np.empty((0, nodes), np.int64)
    if cells.ndim != 2 or cells.shape[1] != nodes:
        raise InvalidInput(f"needs shape (m, {nodes}), got {cells.shape}", parameter=name)
    if cells.dtype.kind not in "iu":
        raise InvalidInput(f"needs whole numbers, got {cells.dtype}", parameter=name)
    cells = np.ascontiguousarray(cells, dtype=np.int64)
    if cells.min() < 0 or cells.max() >= n_points:
        bad = np.flatnonzero(((cells < 0) | (cells >= n_points)).any(axis=1))
        raise InvalidGeometry(
            f"cell {bad[0]} has nodes {cells[bad[0]].tolist()}, but points go from 0 to {n_points - 1}",
            parameter=name,
            cells=bad,
        )
    return cells


def checked_data(data: Mapping[str, Any], count: int, what: str) -> dict[str, np.ndarray]:
    """Arrays of ``count`` rows each, or `InvalidInput` that names the one at fault."""
    checked = {}
    for name, values in dict(data).items():
        values = np.ascontiguousarray(values)
        if values.shape[:1] != (count,):
            raise InvalidInput(
                f"needs one value per {what}, that is {count}, got shape {values.shape}",
                parameter=f"{what}_data[{name!r}]",
            )
        checked[name] = values
    return checked


def _checked_set(name: str, members: Any, n_cells: int) -> np.ndarray:
    members = np.ascontiguousarray(members, dtype=np.int64).reshape(-1)
    if members.size and (members.min() < 0 or members.max() >= n_cells):
        raise InvalidInput(f"refers to cells beyond the {n_cells} there are", parameter=f"sets[{name!r}]")
    return members
