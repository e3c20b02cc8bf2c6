"""Reading CGNS files: a base's zones as a structured grid or several, as a mesh, or as polyhedra.

Boundary conditions are called by their families. Where a family belongs to others, as Gmsh writes physical groups, a
mesh has a set for each of them.
"""

from __future__ import annotations

import difflib
from dataclasses import replace
from pathlib import Path
from typing import Union

import numpy as np

from ..errors import InvalidInput
from ..mesh import CELL_TYPES, Mesh, MultiBlock, PolyhedralMesh, StructuredGrid
from .bounded import bounded
from .cgns_conditions import patches_of, read_sets
from .cgns_elements import read_elements, read_sections
from .cgns_joins import joins_of
from .cgns_nodes import AXES, Node, read_nodes
from .cgns_polyhedra import are_polyhedra, read_polyhedra
from .fit import warn_dropped
from .joined_polyhedra import joined_polyhedra
from .vtk_data import joined

_DATA = {"Vertex": "point_data", "CellCenter": "cell_data"}
Part = Union[Mesh, PolyhedralMesh, StructuredGrid]


def read_cgns(path: Path, *, base: str = "") -> Union[Part, MultiBlock]:
    """One structured zone as a grid, several as a `MultiBlock`, any other as a `Mesh` or `PolyhedralMesh`.

    A mesh of several zones has a set for each, and polyhedra the number of each cell's zone as data; their connections
    are not glued.

    Parameters
    ----------
    path : Path
        The file.
    base : str
        The name of a base; without it the first is read, and a warning names the others.
    """
    chosen = _base(read_nodes(path), base)
    zones = list(chosen.of("Zone_t"))
    if not zones:
        raise InvalidInput(f"the base {chosen.name!r} has no zones")
    families = _families(chosen)
    dimension = int(chosen.whole(2)[0])
    parts = [_part(zone, dimension, families) for zone in zones]
    blocks = [part for part in parts if isinstance(part, StructuredGrid)]
    if len(blocks) == len(parts):
        conditions = [patch for k, zone in enumerate(zones) for patch in patches_of(zone, k, blocks[k])]
        return bounded(blocks, [zone.name for zone in zones], conditions, joins_of(zones, blocks))
    if len(parts) == 1:
        return parts[0]
    told = [node.name for zone in zones for group in zone.of("ZoneGridConnectivity_t") for node in group.children]
    warn_dropped("connections", told, "zones of a mesh do not share points")
    named = {zone.name: part for zone, part in zip(zones, parts, strict=True)}
    if any(isinstance(part, PolyhedralMesh) for part in parts):
        return joined_polyhedra(named)
    return joined(named)


def _base(root: Node, name: str) -> Node:
    bases = {base.name: base for base in root.of("CGNSBase_t")}
    if not bases:
        raise InvalidInput("it has no CGNSBase_t, so it is HDF5 but not CGNS (meshio's .cgns has no types of nodes)")
    if name and name not in bases:
        near = difflib.get_close_matches(name, bases, n=1)
        guess = f"; did you mean {near[0]!r}?" if near else ""
        raise InvalidInput(f"it has no base {name!r}, only {', '.join(map(repr, bases))}{guess}")
    chosen = bases[name] if name else next(iter(bases.values()))
    if not name:
        others = [other for other in bases if other != chosen.name]
        warn_dropped("the bases", others, f"{chosen.name!r}, the first, is read; read(path, base=name) reads another")
    return chosen


def _families(base: Node) -> dict[str, list[str]]:
    """For each family those that it belongs to."""
    return {family.name: [named.text() for named in family.of("FamilyName_t")] for family in base.of("Family_t")}


def _part(zone: Node, dimension: int, families: dict[str, list[str]]) -> Part:
    kind = zone.need("ZoneType").text()
    if kind == "Structured":
        return _block(zone)
    if kind != "Unstructured":
        raise InvalidInput(f"the zone {zone.name!r} is {kind!r}, neither Structured nor Unstructured")
    return _mesh(zone, dimension, families)


def _block(zone: Node) -> StructuredGrid:
    axes = 2 if isinstance(zone.value, np.ndarray) and zone.value.shape[-1] == 2 else 3
    block = StructuredGrid(_points(zone, tuple(zone.whole(3, axes)[0].tolist())))
    data = _solutions(zone, block.shape[:axes], block.cell_shape[:axes])
    if axes == 2:
        data = {where: {n: values[:, :, None] for n, values in arrays.items()} for where, arrays in data.items()}
    return StructuredGrid(block.points, **data)


def _mesh(zone: Node, dimension: int, families: dict[str, list[str]]) -> Mesh | PolyhedralMesh:
    n_points, n_cells, _ = zone.whole(3, 1)[:, 0].tolist()
    points = _points(zone, (n_points,))
    data = _solutions(zone, (n_points,), (n_cells,))
    elements = read_elements(zone)
    lost = np.zeros(n_points, bool)
    if are_polyhedra(zone, elements, dimension):
        mesh, element = read_polyhedra(zone, elements, points, families)
    else:
        mesh, element, lost = read_sections(elements, points)
        mesh = Mesh(mesh.points, mesh.cells, sets=read_sets(zone, element, families))
    cell_data = _of_cells(zone, mesh, data["cell_data"], element, n_cells)
    if isinstance(mesh, PolyhedralMesh):
        return PolyhedralMesh(
            points, mesh.face_offsets, mesh.face_nodes, mesh.owner, mesh.neighbour, data["point_data"], cell_data
        )
    whole = Mesh(points, mesh.cells, data["point_data"], cell_data, mesh.sets)
    return _without(whole, lost) if lost.any() else whole


def _without(mesh: Mesh, lost: np.ndarray) -> Mesh:
    """The mesh without some points, which none of its cells has."""
    number = np.cumsum(~lost) - 1
    cells = {kind: number[c] for kind, c in mesh.cells.items()}
    point_data = {name: values[~lost] for name, values in mesh.point_data.items()}
    return replace(mesh, points=mesh.points[~lost], cells=cells, point_data=point_data)


def _of_cells(
    zone: Node, mesh: Mesh | PolyhedralMesh, data: dict[str, np.ndarray], element: np.ndarray, n_cells: int
) -> dict[str, np.ndarray]:
    """Data of the zone's cells, in the order of the mesh's; those of its boundary are nan or 0."""
    is_domain = np.ones(mesh.n_cells, bool)
    if isinstance(mesh, Mesh):
        for kind, _, where in mesh.blocks():
            is_domain[where] = CELL_TYPES[kind].dimension == mesh.dimension
    if n_cells != is_domain.sum() and data:
        raise InvalidInput(f"the zone {zone.name!r} promises {n_cells} cells, its sections have {is_domain.sum()}")
    rank = np.argsort(np.argsort(element[is_domain]))
    found = {}
    for name, values in data.items():
        fill = np.nan if values.dtype.kind == "f" else 0
        found[name] = np.full((mesh.n_cells, *values.shape[1:]), fill, values.dtype)
        found[name][is_domain] = values[rank]
    return found


def _points(zone: Node, shape: tuple[int, ...]) -> np.ndarray:
    """(..., 3) coordinates; those that the file lacks are 0."""
    coordinates = next(iter(zone.of("GridCoordinates_t")), None)
    if coordinates is None:
        raise InvalidInput(f"the zone {zone.name!r} has no GridCoordinates_t")
    columns = [_loaded(coordinates.need(f"Coordinate{AXES[axis]}"), shape, coordinates) for axis in range(2)]
    third = coordinates.find("CoordinateZ")
    columns.append(_loaded(third, shape, coordinates) if third else np.zeros(shape))
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
        held = [node for node in solution.of("DataArray_t") if node.value is not None]
        arrays = {node.name: _loaded(node, sizes, solution) for node in held}
        data[where] |= _vectors(arrays)
    return data


def _loaded(node: Node, shape: tuple[int, ...], parent: Node) -> np.ndarray:
    """An array of a zone, its axes in order, without the layers of rind round it."""
    rind = next(iter(parent.of("Rind_t")), None)
    around = np.zeros((len(shape), 2), np.int64) if rind is None else rind.whole(2 * len(shape)).reshape(-1, 2)
    if (around < 0).any():
        raise InvalidInput(f"{parent.label} {parent.name!r} has a negative number of layers of rind")
    full = tuple((np.array(shape) + around.sum(axis=1)).tolist())
    if not isinstance(node.value, np.ndarray) or node.value.shape[::-1] != full:
        found = node.value.shape[::-1] if isinstance(node.value, np.ndarray) else node.value
        raise InvalidInput(f"{node.label} {node.name!r} has shape {found}, its zone needs {full}")
    return node.value.T[tuple(slice(low, low + n) for (low, _), n in zip(around.tolist(), shape, strict=True))]


def _vectors(arrays: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The arrays, with those whose names end in X, Y and Z as one."""
    found = dict(arrays)
    for name in [key[:-1] for key in arrays if key.endswith("X") and len(key) > 1]:
        parts = [name + axis for axis in AXES]
        if all(part in found for part in parts) and name not in found:
            found[name] = np.stack([found.pop(part) for part in parts], axis=-1)
    return found
