"""CGNS files (.cgns) in HDF5: structured zones, with their boundary conditions and 1-to-1 connections.

Each name of faces is a family, and each patch a boundary condition that refers to it; cuts are 1-to-1 connections, told
by both zones. Surfaces have two indices, and two coordinates where z = 0.

References
----------
CGNS steering committee, "CGNS standard interface data structures", https://cgns.github.io/standard/SIDS.html
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..errors import InvalidInput
from ..mesh import MultiBlock, Patch, StructuredGrid, patches
from ..mesh.patches import UNNAMED
from ..mesh.structured_grid import FACES
from .bounded import bounded
from .cgns_joins import index_range, joins_of, range_of, write_joins
from .cgns_nodes import Node, read_nodes, write_nodes
from .fit import Holds, warn_dropped
from .registry import register

VERSION = 3.3
"""Of the standard: all that is written has been in it since then, and older libraries read it."""
_ONE = "grid"
_AXES = "XYZ"
_DATA = {"Vertex": "point_data", "CellCenter": "cell_data"}
_CONDITIONS = {
    "wall": "BCWall",
    "far field": "BCFarfield",
    "inflow": "BCInflow",
    "outflow": "BCOutflow",
    "symmetry": "BCSymmetryPlane",
}


def write_cgns(path: Path, grid: StructuredGrid | MultiBlock) -> None:
    """One base with a zone for each block."""
    blocks = grid if isinstance(grid, MultiBlock) else MultiBlock((grid,), (_ONE,))
    if len({block.is_surface for block in blocks.blocks}) > 1:
        raise InvalidInput("has surfaces and volumes; a base of CGNS holds the ones or the others", parameter="mesh")
    axes = 2 if blocks.blocks[0].is_surface else 3
    turned = any(cut.rotation is not None for cut in blocks.joins)
    flat = axes == 2 and not turned and all(not block.points[..., 2].any() for block in blocks.blocks)
    base = Node("Base", "CGNSBase_t", np.array([axes, 2 if flat else 3], np.int32))
    families: dict[str, str] = {}
    for patch in patches(blocks):
        if patch.name not in families:
            family = base.add(patch.name, "Family_t")
            family.add("FamilyBC", "FamilyBC_t", _CONDITIONS.get(patch.name, "UserDefined"))
            families[patch.name] = family.name
    zones = [_zone(base, name, b, axes, 2 if flat else 3) for name, b in zip(blocks.names, blocks.blocks, strict=True)]
    _warn_of_names({**families, **{name: zone.name for name, zone in zip(blocks.names, zones, strict=True)}})
    for patch in patches(blocks):
        zone = zones[patch.block]
        conditions = zone.find("ZoneBC") or zone.add("ZoneBC", "ZoneBC_t")
        condition = conditions.add(patch.name, "BC_t", "FamilySpecified")
        condition.add("PointRange", "IndexRange_t", index_range(patch.points, axes))
        condition.add("FamilyName", "FamilyName_t", families[patch.name])
    write_joins(zones, blocks.joins, axes, 2 if flat else 3)
    write_nodes(path, [Node("CGNSLibraryVersion", "CGNSLibraryVersion_t", np.array([VERSION], np.float32)), base])


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
        arrays = _columns(getattr(block, attribute), attribute)
        if arrays:
            solution = zone.add("PointData" if location == "Vertex" else "CellData", "FlowSolution_t")
            solution.add("GridLocation", "GridLocation_t", location)
            for key, values in arrays.items():
                solution.add(key, "DataArray_t", _stored(values, axes))
    return zone


def _stored(values: np.ndarray, axes: int) -> np.ndarray:
    """(ni, nj, nk) values with their axes in reverse, without the one layer of a surface."""
    return values.T if axes == 3 else values[:, :, 0].T


def _columns(data: dict[str, np.ndarray], attribute: str) -> dict[str, np.ndarray]:
    """Arrays of numbers by name; vectors as three, whose names end in X, Y and Z, as CGNS has them."""
    columns, dropped = {}, []
    for name, values in data.items():
        if values.dtype.kind not in "biuf" or values.shape[3:] not in ((), (3,)):
            dropped.append(name)
            continue
        values = values.astype(np.int32) if values.dtype.itemsize < 4 and values.dtype.kind in "biu" else values
        values = values if values.dtype.kind != "f" or values.dtype.itemsize == 4 else values.astype(np.float64)
        parts = {name: values} if values.ndim == 3 else {name + _AXES[k]: values[..., k] for k in range(3)}
        columns.update(parts)
    warn_dropped(attribute.replace("_", " "), dropped, "CGNS holds numbers and vectors; .vts and .vtm hold them")
    return columns


# ---- reading


def read_cgns(path: Path) -> StructuredGrid | MultiBlock:
    """One zone as a grid, several as a `MultiBlock`; of several bases the first."""
    root = read_nodes(path)
    bases = list(root.of("CGNSBase_t"))
    if not bases:
        raise InvalidInput("it has no CGNSBase_t, so it is HDF5 but not CGNS")
    warn_dropped("the bases", [base.name for base in bases[1:]], "the first is read")
    zones = list(bases[0].of("Zone_t"))
    if not zones:
        raise InvalidInput(f"the base {bases[0].name!r} has no zones")
    blocks = [_block(zone) for zone in zones]
    names = [zone.name for zone in zones]
    conditions = [patch for k, zone in enumerate(zones) for patch in _patches(zone, k, blocks[k])]
    return bounded(blocks, names, conditions, joins_of(zones, blocks))


def _block(zone: Node) -> StructuredGrid:
    kind = zone.need("ZoneType").text()
    if kind != "Structured":
        raise InvalidInput(f"the zone {zone.name!r} is {kind}; structured zones are read")
    axes = 2 if isinstance(zone.value, np.ndarray) and zone.value.shape[-1] == 2 else 3
    shape = tuple(zone.whole(3, axes)[0].tolist())
    coordinates = next(iter(zone.of("GridCoordinates_t")), None)
    if coordinates is None:
        raise InvalidInput(f"the zone {zone.name!r} has no GridCoordinates_t")
    columns = [_loaded(coordinates.need(f"Coordinate{_AXES[axis]}"), shape) for axis in range(2)]
    third = coordinates.find("CoordinateZ")
    columns.append(_loaded(third, shape) if third else np.zeros(shape))
    block = StructuredGrid(np.stack(columns, axis=-1))
    data: dict[str, dict[str, np.ndarray]] = {"point_data": {}, "cell_data": {}}
    for solution in zone.of("FlowSolution_t"):
        location = solution.find("GridLocation")
        where = _DATA.get(location.text() if location else "Vertex")
        if where is None:
            warn_dropped("the solution", [solution.name], "its values are neither on points nor in cells")
            continue
        sizes = (block.shape if where == "point_data" else block.cell_shape)[:axes]
        arrays = {node.name: _loaded(node, sizes) for node in solution.of("DataArray_t") if node.value is not None}
        full = block.shape if where == "point_data" else block.cell_shape
        data[where] |= {name: values.reshape(full + values.shape[axes:]) for name, values in _vectors(arrays).items()}
    return StructuredGrid(block.points, **data)


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
    "structured grids and blocks with named boundaries, cuts and data, in HDF5; needs h5py",
    Holds(blocks=2, point_data=True, cell_data=True),
    read=read_cgns,
    write=write_cgns,
)
