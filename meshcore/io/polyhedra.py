"""Polygons and polyhedra as VTK lays them out: a PolyhedralMesh to cells with streams of faces, and back."""

from __future__ import annotations

from typing import TYPE_CHECKING, Union

import numpy as np

from ..errors import InvalidInput
from ..mesh import BY_VTK, Mesh, PolyhedralMesh, polygons
from .ragged import POLYGON

if TYPE_CHECKING:
    from .vtk_data import DataSet

POLYHEDRON = 42


def rows_of_cells(mesh: PolyhedralMesh) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Offsets and nodes of the faces that each polyhedron sees, outward, and the (number of cells,) int count of them.

    An inner face stands twice, once for each side.
    """
    offsets, faces = mesh.cell_faces
    cell = np.repeat(np.arange(mesh.n_cells), np.diff(offsets))
    rows, nodes = polygons.taken(mesh.face_offsets, mesh.face_nodes, faces)
    return rows, polygons.turned(rows, nodes, mesh.owner[faces] != cell), np.diff(offsets)


def listed(mesh: PolyhedralMesh) -> dict[str, np.ndarray]:
    """Types, connectivity and offsets of the cells, and for polyhedra ``faces`` and ``face_starts``.

    Examples
    --------
    >>> mesh = PolyhedralMesh([[0, 0], [1, 0], [0, 1]], [0, 3], [0, 1, 2])
    >>> listed(mesh)["types"].tolist()
    [7]
    """
    if mesh.dimension == 2:
        types = np.full(mesh.n_cells, POLYGON, np.uint8)
        return {"types": types, "connectivity": mesh.face_nodes, "offsets": mesh.face_offsets}
    rows, nodes, count = rows_of_cells(mesh)
    stream, starts = face_streams(rows, nodes, count)
    cell = np.repeat(np.repeat(np.arange(mesh.n_cells), count), np.diff(rows))
    key = np.unique(cell * max(mesh.n_points, 1) + nodes)
    used = np.bincount(key // max(mesh.n_points, 1), minlength=mesh.n_cells)
    return {
        "types": np.full(mesh.n_cells, POLYHEDRON, np.uint8),
        "connectivity": key % max(mesh.n_points, 1),
        "offsets": np.concatenate([[0], np.cumsum(used)]).astype(np.int64),
        "faces": stream,
        "face_starts": starts,
    }


def face_streams(rows: np.ndarray, nodes: np.ndarray, count: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """VTK's streams of faces, and where each cell's begins: number of faces, then each face's size and nodes.

    Examples
    --------
    >>> face_streams(np.array([0, 3, 6]), np.array([0, 1, 2, 0, 2, 1]), np.array([2]))[0].tolist()
    [2, 3, 0, 1, 2, 3, 0, 2, 1]
    """
    stream = np.insert(nodes, rows[:-1], np.diff(rows))
    first = (rows + np.arange(len(rows)))[np.concatenate([[0], np.cumsum(count[:-1])]).astype(np.int64)]
    return np.insert(stream, first, count), first + np.arange(len(count))


def holds_polyhedra(data: DataSet) -> bool:
    """Whether the cells make a `PolyhedralMesh`: some are polyhedra, or all are given as polygons."""
    types = np.asarray(data.types)
    return bool(len(types)) and bool((types == POLYHEDRON).any() or (types == POLYGON).all())


def polyhedral(data: DataSet) -> PolyhedralMesh:
    """The cells as a `PolyhedralMesh`; other solid cells among polyhedra become such.

    Raises
    ------
    InvalidInput
        If a cell has no volume, a stream of faces does not fit, or a face has more than two cells.
    """
    types, offsets = np.asarray(data.types, np.int64), np.asarray(data.offsets, np.int64)
    connectivity = np.asarray(data.connectivity, np.int64)
    arrays = {"point_data": data.point_data, "cell_data": data.cell_data, "field_data": data.field_data}
    if not (types == POLYHEDRON).any():
        return PolyhedralMesh(data.points, offsets - offsets[:1], connectivity, **arrays)
    sizes, nodes, cells = [], [], []
    for cell, kind in enumerate(types.tolist()):
        if kind == POLYHEDRON:
            faces = _faces_in_stream(data.faces, int(data.face_starts[cell]), cell)
        elif kind in BY_VTK and BY_VTK[kind].dimension == 3 and not BY_VTK[kind].linear:
            corners = connectivity[offsets[cell] : offsets[cell + 1]].tolist()
            faces = [[corners[k] for k in facet] for facet in BY_VTK[kind].facets]
        else:
            raise InvalidInput(f"cell {cell} is of VTK type {kind}, which cannot stand beside polyhedra; remove it")
        for face in faces:
            sizes.append(len(face))
            nodes.append(face)
        cells += [cell] * len(faces)
    flat = np.array([node for face in nodes for node in face], np.int64)
    rows = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    return joined_faces(data.points, rows, flat, np.array(cells, np.int64), **arrays)


def _faces_in_stream(stream: np.ndarray, start: int, cell: int) -> list[list[int]]:
    faces, at = [], start + 1
    if 0 <= start < len(stream):
        for _ in range(int(stream[start])):
            size = int(stream[at]) if at < len(stream) else -1
            if size < 3 or at + size >= len(stream):
                break
            faces.append(stream[at + 1 : at + 1 + size].tolist())
            at += 1 + size
        if len(faces) == stream[start] >= 4:
            return faces
    raise InvalidInput(f"the faces of cell {cell} do not fit the stream of {len(stream)} numbers")


def joined_faces(
    points: np.ndarray, offsets: np.ndarray, nodes: np.ndarray, cell: np.ndarray, **arrays: dict
) -> PolyhedralMesh:
    """A mesh from the faces that each cell sees, outward: what two cells see is one face between them.

    Parameters
    ----------
    points : (n, 3) float
        Coordinates.
    offsets, nodes : (m + 1,) int, (k,) int
        Faces as compressed rows.
    cell : (m,) int
        The cell that sees each face, ascending.
    **arrays
        Data, as `PolyhedralMesh` takes them.

    Raises
    ------
    InvalidInput
        If three cells see one face.
    """
    sizes = np.diff(offsets)
    same = np.empty(len(sizes), np.int64)  # of each row the first one with its nodes
    shared = np.zeros(len(sizes), np.int64)
    for size in np.unique(sizes):
        some = np.flatnonzero(sizes == size)
        corners = np.sort(nodes[offsets[some][:, None] + np.arange(size)], axis=1)
        _, first, number, count = np.unique(corners, axis=0, return_index=True, return_inverse=True, return_counts=True)
        same[some] = some[first[number.reshape(-1)]]
        shared[some] = count[number.reshape(-1)]
    if (shared > 2).any():
        row = int(np.argmax(shared > 2))
        raise InvalidInput(f"a face of cell {cell[row]} belongs to {shared[row]} cells; at most two can share one")
    kept = np.flatnonzero(same == np.arange(len(sizes)))
    neighbour = np.full(len(sizes), -1)
    second = np.flatnonzero(same != np.arange(len(sizes)))
    neighbour[same[second]] = cell[second]
    rows, corners = polygons.taken(offsets, nodes, kept)
    return PolyhedralMesh(points, rows, corners, cell[kept], neighbour[kept], **arrays)


def corner_tables(mesh: Union[Mesh, PolyhedralMesh]) -> list[np.ndarray]:
    """The corners of the cells, or of a polyhedral mesh's faces: an (m, k) table for each run that has as many.

    Examples
    --------
    >>> corner_tables(PolyhedralMesh([[0, 0], [1, 0], [0, 1]], [0, 3], [0, 1, 2]))
    [array([[0, 1, 2]])]
    """
    if isinstance(mesh, Mesh):
        return [cells for cells in mesh.cells.values() if len(cells)]
    sizes = np.diff(mesh.face_offsets)
    starts = np.flatnonzero(np.concatenate([sizes[:1] > 0, sizes[1:] != sizes[:-1]]))
    nodes = np.split(mesh.face_nodes, mesh.face_offsets[starts[1:]])
    return [part.reshape(-1, sizes[start]) for start, part in zip(starts, nodes, strict=False)]
