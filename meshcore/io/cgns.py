"""CGNS files (.cgns) in HDF5: zones, with their boundary conditions, 1-to-1 connections and solutions.

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
from ..mesh import CELL_TYPES, Mesh, MultiBlock, Patch, StructuredGrid, patches
from ..mesh.patches import UNNAMED
from ..mesh.structured_grid import FACES
from .bounded import bounded
from .cgns_elements import KINDS, read_sections, write_sections
from .cgns_joins import index_range, joins_of, range_of, write_joins
from .cgns_nodes import Node, read_nodes, write_nodes
from .fit import Holds, warn_dropped
from .registry import register
from .vtk_data import joined

VERSION = 3.3
"""Of the standard: all that is written has been in it since then, and older libraries read it."""
_ONE = "grid"
_MESH = "mesh"
_AXES = "XYZ"
_DATA = {"Vertex": "point_data", "CellCenter": "cell_data"}
_CONDITIONS = {
    "wall": "BCWall",
    "far field": "BCFarfield",
    "inflow": "BCInflow",
    "outflow": "BCOutflow",
    "symmetry": "BCSymmetryPlane",
}


def write_cgns(path: Path, mesh: Mesh | StructuredGrid | MultiBlock) -> None:
    """One base with a zone for each block, or one for a mesh."""
    base = _base_of_mesh(mesh) if isinstance(mesh, Mesh) else _base_of_blocks(mesh)
    write_nodes(path, [Node("CGNSLibraryVersion", "CGNSLibraryVersion_t", np.array([VERSION], np.float32)), base])


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


def _base_of_mesh(mesh: Mesh) -> Node:
    if mesh.dimension < 1 or not mesh.n_cells:
        raise InvalidInput("has no lines, faces or volumes; a zone of CGNS needs some", parameter="mesh")
    flat = mesh.dimension < 3 and mesh.is_planar
    base = Node("Base", "CGNSBase_t", np.array([mesh.dimension, 2 if flat else 3], np.int32))
    families = {name: _family(base, name) for name in mesh.sets}
    zone = base.add(_MESH, "Zone_t", np.zeros((3, 1), np.int32))
    _warn_of_names(families)
    zone.add("ZoneType", "ZoneType_t", "Unstructured")
    points = zone.add("GridCoordinates", "GridCoordinates_t")
    for axis in range(2 if flat else 3):
        points.add(f"Coordinate{_AXES[axis]}", "DataArray_t", mesh.points[:, axis])
    domain = write_sections(zone, mesh, families.__getitem__)
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
        points.add(f"Coordinate{_AXES[axis]}", "DataArray_t", _stored(block.points[..., axis], axes))
    for location, attribute in _DATA.items():
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
        parts = {name: values} if values.ndim == axes else {name + _AXES[k]: values[..., k] for k in range(3)}
        columns.update(parts)
    warn_dropped(what, dropped, "CGNS holds numbers and vectors; .vts and .vtm hold them")
    return columns


# ---- reading


def read_cgns(path: Path) -> Mesh | StructuredGrid | MultiBlock:
    """One structured zone as a grid, several as a `MultiBlock`, any other as a `Mesh`; of several bases the first.

    A mesh of several zones has a set for each; their connections are not glued.
    """
    root = read_nodes(path)
    bases = list(root.of("CGNSBase_t"))
    if not bases:
        raise InvalidInput("it has no CGNSBase_t, so it is HDF5 but not CGNS")
    warn_dropped("the bases", [base.name for base in bases[1:]], "the first is read")
    zones = list(bases[0].of("Zone_t"))
    if not zones:
        raise InvalidInput(f"the base {bases[0].name!r} has no zones")
    names = [zone.name for zone in zones]
    parts = [_mesh(zone) if zone.need("ZoneType").text() == "Unstructured" else _block(zone) for zone in zones]
    blocks = [part for part in parts if isinstance(part, StructuredGrid)]
    if len(blocks) < len(parts):
        return parts[0] if len(parts) == 1 else joined(dict(zip(names, parts, strict=True)))
    conditions = [patch for k, zone in enumerate(zones) for patch in _patches(zone, k, blocks[k])]
    return bounded(blocks, names, conditions, joins_of(zones, blocks))


def _block(zone: Node) -> StructuredGrid:
    kind = zone.need("ZoneType").text()
    if kind != "Structured":
        raise InvalidInput(f"the zone {zone.name!r} is {kind!r}, neither Structured nor Unstructured")
    axes = 2 if isinstance(zone.value, np.ndarray) and zone.value.shape[-1] == 2 else 3
    block = StructuredGrid(_points(zone, tuple(zone.whole(3, axes)[0].tolist())))
    data = _solutions(zone, block.shape[:axes], block.cell_shape[:axes])
    if axes == 2:
        data = {where: {n: values[:, :, None] for n, values in arrays.items()} for where, arrays in data.items()}
    return StructuredGrid(block.points, **data)


def _mesh(zone: Node) -> Mesh:
    n_points, n_cells, _ = zone.whole(3, 1)[:, 0].tolist()
    mesh, element = read_sections(zone, _points(zone, (n_points,)))
    data = _solutions(zone, (n_points,), (n_cells,))
    is_domain = np.concatenate(
        [np.full(len(cells), CELL_TYPES[kind].dimension == mesh.dimension) for kind, cells in mesh.cells.items()]
    )
    if n_cells != is_domain.sum() and data["cell_data"]:
        raise InvalidInput(f"the zone {zone.name!r} promises {n_cells} cells, its sections have {is_domain.sum()}")
    rank = np.argsort(np.argsort(element[is_domain]))
    cell_data = {}
    for name, values in data["cell_data"].items():
        fill = np.nan if values.dtype.kind == "f" else 0
        cell_data[name] = np.full((mesh.n_cells, *values.shape[1:]), fill, values.dtype)
        cell_data[name][is_domain] = values[rank]
    return Mesh(mesh.points, mesh.cells, data["point_data"], cell_data, mesh.sets)


def _points(zone: Node, shape: tuple[int, ...]) -> np.ndarray:
    """(..., 3) coordinates; those that the file lacks are 0."""
    coordinates = next(iter(zone.of("GridCoordinates_t")), None)
    if coordinates is None:
        raise InvalidInput(f"the zone {zone.name!r} has no GridCoordinates_t")
    columns = [_loaded(coordinates.need(f"Coordinate{_AXES[axis]}"), shape) for axis in range(2)]
    third = coordinates.find("CoordinateZ")
    columns.append(_loaded(third, shape) if third else np.zeros(shape))
    return np.stack(columns, axis=-1)


def _solutions(zone: Node, points: tuple[int, ...], cells: tuple[int, ...]) -> dict[str, dict[str, np.ndarray]]:
    """Data on points and in cells, each with the zone's axes."""
    data: dict[str, dict[str, np.ndarray]] = {"point_data": {}, "cell_data": {}}
    for solution in zone.of("FlowSolution_t"):
        location = solution.find("GridLocation")
        where = _DATA.get(location.text() if location else "Vertex")
        if where is None:
            warn_dropped("the solution", [solution.name], "its values are neither on points nor in cells")
            continue
        sizes = points if where == "point_data" else cells
        arrays = {node.name: _loaded(node, sizes) for node in solution.of("DataArray_t") if node.value is not None}
        data[where] |= _vectors(arrays)
    return data


def _loaded(node: Node, shape: tuple[int, ...]) -> np.ndarray:
    """An array of a zone, its axes in order."""
    if not isinstance(node.value, np.ndarray) or node.value.shape[::-1] != shape:
        found = node.value.shape[::-1] if isinstance(node.value, np.ndarray) else node.value
        raise InvalidInput(f"{node.label} {node.name!r} has shape {found}, its zone needs {shape} (rind is not read)")
    return node.value.T


def _vectors(arrays: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The arrays, with those whose names end in X, Y and Z as one."""
    found = dict(arrays)
    for name in [key[:-1] for key in arrays if key.endswith("X") and len(key) > 1]:
        parts = [name + axis for axis in _AXES]
        if all(part in found for part in parts) and name not in found:
            found[name] = np.stack([found.pop(part) for part in parts], axis=-1)
    return found


def _patches(zone: Node, number: int, block: StructuredGrid) -> list[Patch]:
    """The boundary conditions of a zone that are ranges of points on faces, by their families' names."""
    found, odd = [], []
    for condition in [c for group in zone.of("ZoneBC_t") for c in group.of("BC_t")]:
        points = condition.find("PointRange")
        corners = range_of(points, block) if points else None
        face = _face(np.array(corners), block.shape) if corners else ""
        if not face:
            odd.append(condition.name)
            continue
        family = condition.find("FamilyName")
        name = family.text() if family else condition.name
        found.append(Patch(number, face, corners, "" if name == UNNAMED else name))
    warn_dropped("boundary conditions", odd, "they are no range of points on a face")
    return found


def _face(corners: np.ndarray, shape: tuple[int, int, int]) -> str:
    """The face on which a range of points lies; "" if there is none."""
    for axis in [a for a in range(3) if shape[a] > 1]:
        first, last = corners[:, axis]
        across = [abs(b - a) for k, (a, b) in enumerate(corners.T) if k != axis and shape[k] > 1]
        if first == last and first in (0, shape[axis] - 1) and all(across):
            return FACES[2 * axis + int(first > 0)]
    return ""


register(
    "CGNS",
    (".cgns",),
    "structured grids and blocks with named boundaries and cuts, meshes with sets of boundary cells, data; needs h5py",
    Holds(cells=tuple(KINDS), blocks=2, point_data=True, cell_data=True, sets=True),
    read=read_cgns,
    write=write_cgns,
)
