"""Parts of a file as one `PolyhedralMesh`: polygons or polyhedra, with cells of standard shape turned into such."""

from __future__ import annotations

from typing import Union

import numpy as np

from ..errors import InvalidInput
from ..mesh import CELL_TYPES, Mesh, PolyhedralMesh, StructuredGrid, polygons
from .fit import warn_dropped
from .polyhedra import joined_faces
from .vtk_data import common_data

ZONE = "zone"
ZONE_NAMES = "zone names"


def joined_polyhedra(parts: dict[str, Union[Mesh, StructuredGrid, PolyhedralMesh]]) -> PolyhedralMesh:
    """Several parts as one mesh, points not shared.

    ``cell_data["zone"]`` is the number of each cell's part, ``field_data["zone names"]`` what the parts are called.

    Raises
    ------
    InvalidInput
        If a part's cells have no flat faces, or some parts are surfaces and others volumes.
    """
    meshes = [as_polyhedra(name, part) for name, part in parts.items()]
    if len({mesh.dimension for mesh in meshes}) > 1:
        flat = next(name for name, mesh in zip(parts, meshes, strict=True) if mesh.dimension == 2)
        raise InvalidInput(f"the zone {flat!r} has polygons and others have polyhedra; put it into a file of its own")
    points, cells, faces = (
        np.cumsum([0] + [count(mesh) for mesh in meshes])
        for count in (lambda m: m.n_points, lambda m: m.n_cells, lambda m: len(m.face_nodes))
    )
    offsets = [mesh.face_offsets[1:] + start for mesh, start in zip(meshes, faces, strict=False)]
    nodes = [mesh.face_nodes + start for mesh, start in zip(meshes, points, strict=False)]
    sides = [None, None]
    if meshes[0].dimension == 3:
        sides = [
            np.concatenate([np.where(side >= 0, side + start, -1) for side, start in zip(some, cells, strict=False)])
            for some in ([mesh.owner for mesh in meshes], [mesh.neighbour for mesh in meshes])
        ]
    return PolyhedralMesh(
        np.concatenate([mesh.points for mesh in meshes]),
        np.concatenate([[0], *offsets]).astype(np.int64),
        np.concatenate(nodes),
        *sides,
        common_data([mesh.point_data for mesh in meshes], "point data"),
        {
            **common_data([mesh.cell_data for mesh in meshes], "cell data"),
            ZONE: np.repeat(np.arange(len(meshes)), np.diff(cells)),
        },
        {ZONE_NAMES: np.array(list(parts))},
    )


def as_polyhedra(name: str, part: Union[Mesh, StructuredGrid, PolyhedralMesh]) -> PolyhedralMesh:
    """The cells of a part's dimension as polygons or polyhedra; its cells of the boundary and sets are left out."""
    if isinstance(part, PolyhedralMesh):
        return part
    mesh = part.to_mesh() if isinstance(part, StructuredGrid) else part
    domain = [block for block in mesh.blocks() if CELL_TYPES[block[0]].dimension == mesh.dimension]
    if odd := [kind for kind, _, _ in domain if CELL_TYPES[kind].linear or mesh.dimension < 2]:
        raise InvalidInput(f"the zone {name!r} has {odd[0]} cells, which are no polygons or polyhedra")
    warn_dropped("sets", [f"{name}/{inner}" for inner in mesh.sets], "a PolyhedralMesh has no sets")
    number = np.concatenate([np.arange(where.start, where.stop) for _, _, where in domain])
    data = {key: values[number] for key, values in mesh.cell_data.items()}
    if mesh.dimension == 2:
        sizes = np.concatenate([np.full(len(cells), cells.shape[1]) for _, cells, _ in domain])
        offsets, nodes = _offsets(sizes), np.concatenate([c.ravel() for _, c, _ in domain])
        return PolyhedralMesh(mesh.points, offsets, nodes, point_data=mesh.point_data, cell_data=data)
    tables, before = [], 0  # of the cells that see a facet, and its nodes
    for kind, cells, _ in domain:
        own = np.arange(before, before + len(cells))
        tables += [(own, cells[:, list(facet)]) for facet in CELL_TYPES[kind].facets]
        before += len(cells)
    cell = np.concatenate([own for own, _ in tables])
    sizes = np.concatenate([np.full(len(seen), seen.shape[1]) for _, seen in tables])
    nodes = np.concatenate([seen.ravel() for _, seen in tables])
    order = np.argsort(cell, kind="stable")
    rows, nodes = polygons.taken(_offsets(sizes), nodes, order)
    return joined_faces(mesh.points, rows, nodes, cell[order], point_data=mesh.point_data, cell_data=data)


def _offsets(sizes: np.ndarray) -> np.ndarray:
    return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
