"""PolyhedralMesh: cells with any number of corners and faces, polygons in the plane and polyhedra in space."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..errors import InvalidGeometry, InvalidInput
from . import polygons
from .mesh import Mesh, checked_data, checked_points
from .topology import distinct


@dataclass(frozen=True, eq=False, repr=False)
class PolyhedralMesh:
    """A mesh of polygons, or of polyhedra whose faces are polygons, such as a Voronoi diagram.

    Faces are kept as compressed rows: the nodes of face k are ``face_nodes[face_offsets[k]:face_offsets[k + 1]]``.
    Without `owner` each face is a cell, a polygon, counter-clockwise in the plane. With it faces lie between cells:
    each is kept once, and seen from its owner its nodes run clockwise, so that by the right-hand rule it looks out of
    its owner into its neighbour, which has the greater number. So an inner face cannot differ between its two cells.

    Parameters
    ----------
    points : (n, 3) or (n, 2) float
        Coordinates; planar points get z = 0.
    face_offsets : (number of faces + 1,) int
        Where each face begins in `face_nodes`, and where the last one ends.
    face_nodes : (k,) int
        Nodes of all faces, one face after the other, at least three a face.
    owner : (number of faces,) int, optional
        The cell that each face looks out of.
    neighbour : (number of faces,) int, optional
        The cell on the other side, -1 on the boundary; with `owner` only.
    point_data : dict of str to (n, ...) array
        Values at points.
    cell_data : dict of str to (number of cells, ...) array
        Values on cells.
    field_data : dict of str to array
        Values of the mesh as a whole.

    Raises
    ------
    InvalidInput
        If shapes or types do not fit; the message names the array.
    InvalidGeometry
        If points are not finite, a face refers to a point that does not exist or has fewer than three nodes, or a
        cell has fewer than four faces.

    Examples
    --------
    ::

        3---2
        |   | \\        a square and a triangle
        0---1---4

    >>> mesh = PolyhedralMesh([[0, 0], [1, 0], [1, 1], [0, 1], [2, 0]], [0, 4, 7], [0, 1, 2, 3, 1, 4, 2])
    >>> mesh
    PolyhedralMesh(5 points, 2 polygons)
    >>> mesh.volumes.tolist(), mesh.neighbours.tolist()
    ([1.0, 0.5], [[0, 1]])
    """

    points: np.ndarray
    face_offsets: np.ndarray
    face_nodes: np.ndarray
    owner: np.ndarray | None = None
    neighbour: np.ndarray | None = None
    point_data: dict[str, np.ndarray] = field(default_factory=dict)
    cell_data: dict[str, np.ndarray] = field(default_factory=dict)
    field_data: dict[str, np.ndarray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "points", checked_points(self.points))
        set_(self, "face_offsets", _whole(self.face_offsets, "face_offsets"))
        set_(self, "face_nodes", _whole(self.face_nodes, "face_nodes"))
        _check_faces(self.face_offsets, self.face_nodes, self.n_points)
        if (self.owner is None) != (self.neighbour is None):
            raise InvalidInput("needs a neighbour for every owner; give both or neither", parameter="neighbour")
        if self.owner is not None:
            set_(self, "owner", _whole(self.owner, "owner"))
            set_(self, "neighbour", _whole(self.neighbour, "neighbour"))
            _check_sides(self.owner, self.neighbour, self.n_faces)
        set_(self, "point_data", checked_data(self.point_data, self.n_points, "point"))
        set_(self, "cell_data", checked_data(self.cell_data, self.n_cells, "cell"))
        set_(self, "field_data", {k: np.ascontiguousarray(v) for k, v in dict(self.field_data).items()})

    def __repr__(self) -> str:
        if self.owner is None:
            return f"PolyhedralMesh({self.n_points} points, {self.n_cells} polygons)"
        return f"PolyhedralMesh({self.n_points} points, {self.n_faces} faces, {self.n_cells} polyhedra)"

    # ---- sizes

    @property
    def n_points(self) -> int:
        """Number of points."""
        return len(self.points)

    @property
    def n_faces(self) -> int:
        """Number of faces, each counted once."""
        return len(self.face_offsets) - 1

    @cached_property
    def n_cells(self) -> int:
        """Number of cells: polyhedra, or without owners polygons."""
        if self.owner is None:
            return self.n_faces
        return int(max(self.owner.max(), self.neighbour.max())) + 1 if self.n_faces else 0

    @property
    def dimension(self) -> int:
        """2 if the cells are polygons, 3 if they are polyhedra."""
        return 2 if self.owner is None else 3

    @property
    def is_planar(self) -> bool:
        """Whether all points have z = 0."""
        return not self.points[:, 2].any()

    @cached_property
    def bounds(self) -> np.ndarray:
        """(2, 3) float: lower and upper corner of the bounding box; zeros without points."""
        if not self.n_points:
            return np.zeros((2, 3))
        return np.array([self.points.min(axis=0), self.points.max(axis=0)])

    @property
    def diagonal(self) -> float:
        """Length of the bounding box's diagonal."""
        return float(np.linalg.norm(self.bounds[1] - self.bounds[0]))

    # ---- geometry

    @cached_property
    def volumes(self) -> np.ndarray:
        """(number of cells,) float: volume of each cell, of polygons the area; negative if inside out."""
        return self._moments[0]

    @cached_property
    def centroids(self) -> np.ndarray:
        """(number of cells, 3) float: centre of mass of each cell; of one without volume the mean of its nodes."""
        return self._moments[1]

    @cached_property
    def _moments(self) -> tuple[np.ndarray, np.ndarray]:
        if self.owner is None:
            return polygons.areas_and_centroids(self.points, self.face_offsets, self.face_nodes, self.is_planar)
        return polygons.volumes_and_centroids(
            self.points, self.face_offsets, self.face_nodes, self.owner, self.neighbour, self.n_cells
        )

    # ---- topology

    @cached_property
    def edges(self) -> np.ndarray:
        """(k, 2) int: each edge of all faces once, smaller point first, sorted."""
        pairs, _ = polygons.edges(self.face_offsets, self.face_nodes)
        count = max(self.n_points, 1)
        key = distinct(pairs.min(axis=1) * count + pairs.max(axis=1))
        return np.column_stack([key // count, key % count])

    @cached_property
    def neighbours(self) -> np.ndarray:
        """(k, 2) int: pairs of cells that share a face, in the plane an edge; the smaller first, sorted."""
        if self.owner is None:
            pairs = polygons.pairs_across_edges(self.face_offsets, self.face_nodes, self.n_points)
        else:
            inner = self.neighbour >= 0
            pairs = np.column_stack([self.owner[inner], self.neighbour[inner]])
        count = max(self.n_cells, 1)
        key = distinct(pairs[:, 0] * count + pairs[:, 1])
        return np.column_stack([key // count, key % count])

    @cached_property
    def cell_faces(self) -> tuple[np.ndarray, np.ndarray]:
        """Faces of each cell as compressed rows: (number of cells + 1,) offsets and the faces' numbers, ascending."""
        if self.owner is None:
            return np.arange(self.n_cells + 1), np.arange(self.n_cells)
        face = np.concatenate([np.arange(self.n_faces), np.flatnonzero(self.neighbour >= 0)])
        cell = np.concatenate([self.owner, self.neighbour[self.neighbour >= 0]])
        order = np.lexsort((face, cell))
        return np.concatenate([[0], np.cumsum(np.bincount(cell, minlength=self.n_cells))]), face[order]

    @cached_property
    def boundary(self) -> Mesh | PolyhedralMesh:
        """What belongs to one cell only, outward: lines of polygons, polygons of polyhedra, on the same points.

        ``cell_data["cell"]`` is the cell that each belongs to.
        """
        if self.owner is None:
            lines, cell = polygons.single_edges(self.face_offsets, self.face_nodes, self.n_points)
            return Mesh(self.points, {"line": lines}, point_data=self.point_data, cell_data={"cell": cell})
        return self._faces_alone(np.flatnonzero(self.neighbour < 0), np.empty(0, np.int64))

    def _faces_alone(self, out: np.ndarray, back: np.ndarray) -> PolyhedralMesh:
        """Polygons from the faces ``out`` as their owners see them, and ``back`` as their neighbours do."""
        offsets, nodes = polygons.taken(self.face_offsets, self.face_nodes, np.concatenate([out, back]))
        nodes = polygons.turned(offsets, nodes, np.arange(len(out) + len(back)) >= len(out))
        cell = np.concatenate([self.owner[out], self.neighbour[back]])
        order = np.argsort(cell, kind="stable")
        offsets, nodes = polygons.taken(offsets, nodes, order)
        return PolyhedralMesh(self.points, offsets, nodes, point_data=self.point_data, cell_data={"cell": cell[order]})

    # ---- new meshes from old

    def with_cell_data(self, **arrays: np.ndarray) -> PolyhedralMesh:
        """The same mesh with more cell data."""
        return replace(self, cell_data={**self.cell_data, **arrays})

    def with_point_data(self, **arrays: np.ndarray) -> PolyhedralMesh:
        """The same mesh with more point data."""
        return replace(self, point_data={**self.point_data, **arrays})

    def with_points(self, points: np.ndarray) -> PolyhedralMesh:
        """The same cells and data on moved points."""
        return replace(self, points=points)

    def selected(self, cells: np.ndarray) -> PolyhedralMesh:
        """The mesh of some cells ((number of cells,) bool or (k,) int), in their order, on the points they use."""
        keep = np.zeros(self.n_cells, bool)
        keep[np.asarray(cells)] = True
        data = {name: values[keep] for name, values in self.cell_data.items()}
        if self.owner is None:
            offsets, nodes = polygons.taken(self.face_offsets, self.face_nodes, np.flatnonzero(keep))
            return replace(self, face_offsets=offsets, face_nodes=nodes, cell_data=data).compacted()
        padded = np.append(keep, False)  # for the neighbour -1
        of_owner, of_neighbour = keep[self.owner], padded[self.neighbour]
        faces = np.flatnonzero(of_owner | of_neighbour)
        offsets, nodes = polygons.taken(self.face_offsets, self.face_nodes, faces)
        nodes = polygons.turned(offsets, nodes, ~of_owner[faces])
        number = np.append(np.cumsum(keep) - 1, -1)
        owner = np.where(of_owner, self.owner, self.neighbour)[faces]
        neighbour = np.where(of_owner & of_neighbour, self.neighbour, -1)[faces]
        chosen = replace(
            self,
            face_offsets=offsets,
            face_nodes=nodes,
            owner=number[owner],
            neighbour=number[neighbour],
            cell_data=data,
        )
        return chosen.compacted()

    def compacted(self) -> PolyhedralMesh:
        """The mesh without the points that no face uses."""
        used = np.zeros(self.n_points, bool)
        used[self.face_nodes] = True
        if used.all():
            return self
        number = np.cumsum(used) - 1
        return replace(
            self,
            points=self.points[used],
            face_nodes=number[self.face_nodes],
            point_data={name: values[used] for name, values in self.point_data.items()},
        )

    def separated(self, shrink: float = 1.0) -> PolyhedralMesh:
        """Each cell on its own: closed surfaces of polyhedra, or polygons, that share no points.

        Parameters
        ----------
        shrink : float
            Size of the cells about the mean of their corners; below 1 one can look between them.

        Returns
        -------
        PolyhedralMesh
            Polygons, cell after cell, with the cell data and ``cell_data["cell"]``, the number of the cell.
        """
        if self.owner is None:
            alone = self.with_cell_data(cell=np.arange(self.n_cells))
        else:
            alone = self._faces_alone(np.arange(self.n_faces), np.flatnonzero(self.neighbour >= 0))
        cell = alone.cell_data["cell"]
        corner_cell = np.repeat(cell, np.diff(alone.face_offsets))
        key, nodes = np.unique(corner_cell * max(self.n_points, 1) + alone.face_nodes, return_inverse=True)
        of_cell, node = key // max(self.n_points, 1), key % max(self.n_points, 1)
        points = self.points[node]
        if shrink != 1.0:
            count = np.bincount(of_cell, minlength=self.n_cells)
            middle = np.stack([np.bincount(of_cell, x, self.n_cells) for x in points.T], axis=1) / count[:, None]
            points = middle[of_cell] + shrink * (points - middle[of_cell])
        return PolyhedralMesh(
            points,
            alone.face_offsets,
            nodes.reshape(-1),
            point_data={name: values[node] for name, values in self.point_data.items()},
            cell_data={**{name: values[cell] for name, values in self.cell_data.items()}, "cell": cell},
            field_data=self.field_data,
        )

    def to_mesh(self) -> Mesh:
        """The cells cut into "triangle" or "tetra" cells, with the cell data and ``cell_data["cell"]``.

        Polygons are cut by fans from their first node; polyhedra into tetrahedra between their centroid, a new point
        after the others, and fans of their faces. That is valid for convex cells, as Voronoi's are, and conforming.
        Point data are left out where points are added.
        """
        fan, face = polygons.fans(self.face_offsets, self.face_nodes)
        if self.owner is None:
            return self._simplices(self.points, "triangle", fan, face, self.point_data)
        apex = self.n_points + np.arange(self.n_cells)
        inner = self.neighbour[face] >= 0
        out = np.column_stack([fan[:, [0, 2, 1]], apex[self.owner[face]]])
        back = np.column_stack([fan[inner], apex[self.neighbour[face[inner]]]])
        cell = np.concatenate([self.owner[face], self.neighbour[face[inner]]])
        order = np.argsort(cell, kind="stable")
        points = np.concatenate([self.points, self.centroids])
        return self._simplices(points, "tetra", np.concatenate([out, back])[order], cell[order], {})

    def _simplices(self, points: np.ndarray, kind: str, cells: np.ndarray, cell: np.ndarray, data: dict) -> Mesh:
        cell_data = {**{name: values[cell] for name, values in self.cell_data.items()}, "cell": cell}
        return Mesh(points, {kind: cells}, data, cell_data, field_data=self.field_data)

    @classmethod
    def from_polygons(cls, points: np.ndarray, faces: Sequence[Sequence[int]], **data: Any) -> PolyhedralMesh:
        """Polygons given as lists of nodes; ``data`` as in the constructor.

        Examples
        --------
        >>> PolyhedralMesh.from_polygons([[0, 0], [2, 0], [2, 1], [1, 2], [0, 1]], [[0, 1, 2, 3, 4]]).volumes
        array([3.])
        """
        sizes = [len(row) for row in faces]
        return cls(points, np.cumsum([0, *sizes]), np.array([node for row in faces for node in row], np.int64), **data)


def _whole(values: Any, name: str) -> np.ndarray:
    values = np.asarray(values)
    if values.ndim != 1:
        raise InvalidInput(f"needs one row of whole numbers, got shape {values.shape}", parameter=name)
    if values.size and values.dtype.kind not in "iu":
        raise InvalidInput(f"needs whole numbers, got {values.dtype}", parameter=name)
    return np.ascontiguousarray(values, dtype=np.int64)


def _check_faces(offsets: np.ndarray, nodes: np.ndarray, n_points: int) -> None:
    if not len(offsets) or offsets[0] != 0 or offsets[-1] != len(nodes) or (np.diff(offsets) < 0).any():
        raise InvalidInput(f"needs to rise from 0 to the {len(nodes)} nodes there are", parameter="face_offsets")
    small = np.flatnonzero(np.diff(offsets) < 3)
    if len(small):
        raise InvalidGeometry(
            f"face {small[0]} has {np.diff(offsets)[small[0]]} nodes, it needs at least three",
            parameter="face_offsets",
            cells=small,
        )
    bad = np.flatnonzero((nodes < 0) | (nodes >= n_points))
    if len(bad):
        face = int(np.searchsorted(offsets, bad[0], side="right")) - 1
        raise InvalidGeometry(
            f"face {face} refers to point {nodes[bad[0]]}, but points go from 0 to {n_points - 1}",
            parameter="face_nodes",
            cells=(face,),
        )


def _check_sides(owner: np.ndarray, neighbour: np.ndarray, n_faces: int) -> None:
    for name, cells in (("owner", owner), ("neighbour", neighbour)):
        if len(cells) != n_faces:
            raise InvalidInput(f"needs one cell a face, that is {n_faces}, got {len(cells)}", parameter=name)
    if n_faces and owner.min() < 0:
        raise InvalidInput("every face needs an owner; turn faces that have only a neighbour", parameter="owner")
    wrong = np.flatnonzero((neighbour != -1) & (neighbour <= owner))
    if len(wrong):
        k = wrong[0]
        raise InvalidInput(
            f"face {k} lies between {owner[k]} and {neighbour[k]}; the owner is the smaller one, -1 is the outside",
            parameter="neighbour",
        )
    if n_faces and max(owner.max(), neighbour.max()) >= n_faces:  # before memory is asked for as many cells
        raise InvalidInput(
            f"names cell {max(owner.max(), neighbour.max())}, but there are only {n_faces} faces; number cells from 0",
            parameter="owner",
        )
    count = np.bincount(np.concatenate([owner, neighbour[neighbour >= 0]]))
    few = np.flatnonzero(count < 4)
    if len(few):
        raise InvalidGeometry(
            f"cell {few[0]} has {count[few[0]]} faces, a polyhedron needs four", parameter="owner", cells=few
        )
