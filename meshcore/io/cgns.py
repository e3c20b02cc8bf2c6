"""Writing CGNS files (.cgns) in HDF5: zones, with their boundary conditions, 1-to-1 connections and solutions.

Each name of faces is a family, and each patch a boundary condition that refers to it; cuts are 1-to-1 connections, told
by both zones. Surfaces have two indices, and two coordinates where z = 0. A `Mesh` is an unstructured zone.

References
----------
CGNS steering committee, "CGNS standard interface data structures", https://cgns.github.io/standard/SIDS.html
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..errors import InvalidInput
from ..mesh import Mesh, MultiBlock, PolyhedralMesh, StructuredGrid, patches
from .cgns_elements import write_sections
from .cgns_joins import index_range, write_joins
from .cgns_kinds import NUMBERS
from .cgns_nodes import AXES, Node, write_nodes
from .cgns_polyhedra import write_polyhedra
from .cgns_reader import read_cgns
from .fit import Holds, warn_dropped
from .registry import register

VERSION = 3.3
"""Of the standard: all that is written has been in it since then, and older libraries read it."""
VERSION_OF_POLYHEDRA = 3.4
"""Since then files tell where each polygon begins; before, lengths stood among the nodes."""
_ONE = "grid"
_MESH = "mesh"
_CONDITIONS = {
    "wall": "BCWall",
    "far field": "BCFarfield",
    "inflow": "BCInflow",
    "outflow": "BCOutflow",
    "symmetry": "BCSymmetryPlane",
}


def write_cgns(path: Path, mesh: Mesh | PolyhedralMesh | StructuredGrid | MultiBlock) -> None:
    """One base with a zone for each block, or one for a mesh."""
    any_length = isinstance(mesh, PolyhedralMesh)
    base = _base_of_mesh(mesh) if any_length or isinstance(mesh, Mesh) else _base_of_blocks(mesh)
    version = np.array([VERSION_OF_POLYHEDRA if any_length else VERSION], np.float32)
    write_nodes(path, [Node("CGNSLibraryVersion", "CGNSLibraryVersion_t", version), base])


def _base_of_blocks(grid: StructuredGrid | MultiBlock) -> Node:
    blocks = grid if isinstance(grid, MultiBlock) else MultiBlock((grid,), (_ONE,))
    if len({block.is_surface for block in blocks.blocks}) > 1:
        raise InvalidInput("has surfaces and volumes; a base of CGNS holds the ones or the others", parameter="mesh")
    axes = 2 if blocks.blocks[0].is_surface else 3
    turned = any(cut.rotation is not None for cut in blocks.joins)
    flat = axes == 2 and not turned and all(not block.points[..., 2].any() for block in blocks.blocks)
    base = Node("Base", "CGNSBase_t", np.array([axes, 2 if flat else 3], np.int32))
    families = {patch.name: "" for patch in patches(blocks)}
    families = {name: _family(base, name) for name in families}
    zones = [_zone(base, name, b, axes, 2 if flat else 3) for name, b in zip(blocks.names, blocks.blocks, strict=True)]
    _warn_of_names({**families, **{name: zone.name for name, zone in zip(blocks.names, zones, strict=True)}})
    for patch in patches(blocks):
        zone = zones[patch.block]
        conditions = zone.find("ZoneBC") or zone.add("ZoneBC", "ZoneBC_t")
        condition = conditions.add(patch.name, "BC_t", "FamilySpecified")
        condition.add("PointRange", "IndexRange_t", index_range(patch.points, axes))
        condition.add("FamilyName", "FamilyName_t", families[patch.name])
    write_joins(zones, blocks.joins, axes, 2 if flat else 3)
    return base


def _base_of_mesh(mesh: Mesh | PolyhedralMesh) -> Node:
    if mesh.dimension < 1 or not mesh.n_cells:
        raise InvalidInput("has no lines, faces or volumes; a zone of CGNS needs some", parameter="mesh")
    flat = mesh.dimension < 3 and mesh.is_planar
    base = Node("Base", "CGNSBase_t", np.array([mesh.dimension, 2 if flat else 3], np.int32))
    families = {name: _family(base, name) for name in mesh.sets} if isinstance(mesh, Mesh) else {}
    zone = base.add(_MESH, "Zone_t", np.zeros((3, 1), np.int32))
    _warn_of_names(families)
    zone.add("ZoneType", "ZoneType_t", "Unstructured")
    points = zone.add("GridCoordinates", "GridCoordinates_t")
    for axis in range(2 if flat else 3):
        points.add(f"Coordinate{AXES[axis]}", "DataArray_t", mesh.points[:, axis])
    if isinstance(mesh, Mesh):
        domain = write_sections(zone, mesh, families.__getitem__)
    else:
        domain = np.arange(mesh.n_cells)
        write_polyhedra(zone, mesh)
    zone.value = np.array([[mesh.n_points], [len(domain)], [0]], np.int32)
    if len(domain) < mesh.n_cells:
        warn_dropped("cell data of the boundary", list(mesh.cell_data), "CGNS has them for the cells of the domain")
    _write_solution(zone, "Vertex", _columns(mesh.point_data, 1, "point data"))
    cell_data = {name: values[domain] for name, values in mesh.cell_data.items()}
    _write_solution(zone, "CellCenter", _columns(cell_data, 1, "cell data"))
    return base


def _family(base: Node, name: str) -> str:
    """A new family under the base; its name."""
    family = base.add(name, "Family_t")
    family.add("FamilyBC", "FamilyBC_t", _CONDITIONS.get(name, "UserDefined"))
    return family.name


def _warn_of_names(given: dict[str, str]) -> None:
    changed = [name for name, written in given.items() if name != written]
    warn_dropped("parts of the names", changed, "CGNS has 32 characters a name, no slash, and each once in its place")


def _zone(base: Node, name: str, block: StructuredGrid, axes: int, coordinates: int) -> Node:
    """Sizes, points and data of a block."""
    sizes = np.array([block.shape, block.cell_shape, (0, 0, 0)], np.int32)[:, :axes]
    zone = base.add(name, "Zone_t", sizes)
    zone.add("ZoneType", "ZoneType_t", "Structured")
    points = zone.add("GridCoordinates", "GridCoordinates_t")
    for axis in range(coordinates):
        points.add(f"Coordinate{AXES[axis]}", "DataArray_t", _stored(block.points[..., axis], axes))
    for location, attribute in (("Vertex", "point_data"), ("CellCenter", "cell_data")):
        columns = _columns(getattr(block, attribute), 3, attribute.replace("_", " "))
        _write_solution(zone, location, {name: _stored(values, axes) for name, values in columns.items()})
    return zone


def _write_solution(zone: Node, location: str, arrays: dict[str, np.ndarray]) -> None:
    if arrays:
        solution = zone.add("PointData" if location == "Vertex" else "CellData", "FlowSolution_t")
        solution.add("GridLocation", "GridLocation_t", location)
        written = {name: solution.add(name, "DataArray_t", values).name for name, values in arrays.items()}
        _warn_of_names(written)


def _stored(values: np.ndarray, axes: int) -> np.ndarray:
    """(ni, nj, nk) values with their axes in reverse, without the one layer of a surface."""
    return values.T if axes == 3 else values[:, :, 0].T


def _columns(data: dict[str, np.ndarray], axes: int, what: str) -> dict[str, np.ndarray]:
    """Arrays of numbers by name; vectors as three, whose names end in X, Y and Z, as CGNS has them."""
    columns, dropped = {}, []
    for name, values in data.items():
        if values.dtype.kind not in "biuf" or values.shape[axes:] not in ((), (3,)):
            dropped.append(name)
            continue
        values = values.astype(np.int32) if values.dtype.itemsize < 4 and values.dtype.kind in "biu" else values
        values = values if values.dtype.kind != "f" or values.dtype.itemsize == 4 else values.astype(np.float64)
        parts = {name: values} if values.ndim == axes else {name + AXES[k]: values[..., k] for k in range(3)}
        columns.update(parts)
    warn_dropped(what, dropped, "CGNS holds numbers and vectors; .vts and .vtm hold them")
    return columns


register(
    "CGNS",
    (".cgns",),
    "structured grids and blocks with named boundaries and cuts, meshes with sets of boundary cells, polygons and "
    "polyhedra, data; needs h5py",
    Holds(cells=tuple(NUMBERS), blocks=2, point_data=True, cell_data=True, sets=True, polygons=True, polyhedra=True),
    read=read_cgns,
    write=write_cgns,
)
