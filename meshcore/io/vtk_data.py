"""Meshes as VTK lays them out in memory and in files, without VTK: the common ground of all its formats."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np

from ..errors import InvalidInput
from ..mesh import CELL_TYPES, Cut, Mesh, MultiBlock, PolyhedralMesh, StructuredGrid
from ..mesh.structured_grid import FACES
from .fit import warn_dropped
from .polyhedra import holds_polyhedra, listed, polyhedral
from .ragged import LINE, VERTEX, cells_by_kind

AnyGrid = TypeVar("AnyGrid", StructuredGrid, MultiBlock)
SET_PREFIX = "set:"
FACE_NAMES = "face_names"
PERIODIC = "periodic"
CUTS = "cuts"
MESH = "UnstructuredGrid"
GRID = "StructuredGrid"


@dataclass
class DataSet:
    """One data set of VTK.

    Attributes
    ----------
    kind : str
        "UnstructuredGrid" or "StructuredGrid".
    points : (n, 3) float
        Coordinates; i runs fastest in a structured grid.
    dimensions : tuple of three int
        Points along i, j, k of a structured grid.
    types, connectivity, offsets : int arrays
        Cells of an unstructured grid, as `cells_by_kind` takes them.
    faces, face_starts : int arrays
        VTK's streams of the faces of polyhedra, and where in them each cell begins; empty without polyhedra.
    whole_polygons : bool
        Whether polyhedra, or polygons alone, are read as a `PolyhedralMesh`; otherwise polygons are cut.
    point_data, cell_data, field_data : dict of str to (n, ...) array
        Data. Sets of cells stand in ``cell_data`` as 0 and 1, so that VTK's filters carry them along.
    """

    kind: str
    points: np.ndarray
    dimensions: tuple[int, int, int] = (0, 0, 0)
    types: np.ndarray = field(default_factory=lambda: np.empty(0, np.uint8))
    connectivity: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))
    offsets: np.ndarray = field(default_factory=lambda: np.zeros(1, np.int64))
    faces: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))
    face_starts: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))
    whole_polygons: bool = False
    point_data: dict[str, np.ndarray] = field(default_factory=dict)
    cell_data: dict[str, np.ndarray] = field(default_factory=dict)
    field_data: dict[str, np.ndarray] = field(default_factory=dict)


def encoded(mesh: Mesh | PolyhedralMesh | StructuredGrid) -> DataSet:
    """A mesh or a structured grid as VTK lays it out.

    Raises
    ------
    InvalidInput
        If a data array is of a type that VTK does not know, such as complex numbers.

    Examples
    --------
    >>> mesh = Mesh([[0, 0], [1, 0], [0, 1]], {"triangle": [[0, 1, 2]]}, sets={"all": [0]})
    >>> data = encoded(mesh)
    >>> data.types.tolist(), data.offsets.tolist(), data.cell_data
    ([5], [0, 3], {'set:all': array([1], dtype=uint8)})
    """
    if isinstance(mesh, StructuredGrid):
        return _encoded_grid(mesh)
    if isinstance(mesh, PolyhedralMesh):
        return DataSet(MESH, mesh.points, **listed(mesh), **_plain_data(mesh, mesh.cell_data), whole_polygons=True)
    blocks = list(mesh.cells.items())
    sizes = [np.full(len(c), c.shape[1]) for _, c in blocks]
    cell_data = dict(mesh.cell_data)
    for name, members in mesh.sets.items():
        inside = np.zeros(mesh.n_cells, np.uint8)
        inside[members] = 1
        cell_data[SET_PREFIX + name] = inside
    empty = np.empty(0, np.int64)
    return DataSet(
        MESH,
        mesh.points,
        types=np.concatenate([empty, *(np.full(len(c), CELL_TYPES[k].vtk) for k, c in blocks)]).astype(np.uint8),
        connectivity=np.concatenate([empty, *(c.ravel() for _, c in blocks)]),
        offsets=np.concatenate([[0], np.cumsum(np.concatenate([empty, *sizes]))]).astype(np.int64),
        **_plain_data(mesh, cell_data),
    )


def _plain_data(mesh: Mesh | PolyhedralMesh, cell_data: dict[str, np.ndarray]) -> dict[str, dict[str, np.ndarray]]:
    return {
        "point_data": {name: _plain(name, v) for name, v in mesh.point_data.items()},
        "cell_data": {name: _plain(name, v) for name, v in cell_data.items()},
        "field_data": {name: _plain(name, np.atleast_1d(v)) for name, v in mesh.field_data.items()},
    }


def _encoded_grid(grid: StructuredGrid) -> DataSet:
    fields: dict[str, np.ndarray] = {}
    if grid.names:
        fields[FACE_NAMES] = np.array([grid.names.get(face, "") for face in FACES])
    if any(grid.periodic):
        fields[PERIODIC] = np.array(grid.periodic, np.uint8)
    fields |= encoded_cuts(grid.cuts)
    return DataSet(
        GRID,
        grid.flat(grid.points),
        dimensions=grid.shape,
        point_data={name: _plain(name, grid.flat(v)) for name, v in grid.point_data.items()},
        cell_data={name: _plain(name, grid.flat(v)) for name, v in grid.cell_data.items()},
        field_data=fields,
    )


def encoded_cuts(cuts: Sequence[Cut]) -> dict[str, np.ndarray]:
    """Cuts as field data: JSON, one row a cut; nothing if there are none.

    Examples
    --------
    >>> encoded_cuts([])
    {}
    """
    return {CUTS: np.array([json.dumps(cut.as_data()) for cut in cuts])} if cuts else {}


def _plain(name: str, values: np.ndarray) -> np.ndarray:
    """Values as (n,) or (n, k) of a type that VTK knows."""
    values = np.asarray(values)
    if values.dtype.kind not in "biufU" or values.dtype == np.longdouble != np.float64:
        raise InvalidInput(
            f"the array {name!r} holds {values.dtype}, which VTK's formats do not know; convert it to float64, int64 "
            "or text first",
            parameter="mesh",
        )
    if values.dtype.kind == "b":
        values = values.astype(np.uint8)
    elif values.dtype == np.float16:
        values = values.astype(np.float32)
    if values.ndim > 2:
        values = values.reshape(len(values), int(np.prod(values.shape[1:])))
    return np.ascontiguousarray(values)


def decoded(data: DataSet) -> Mesh | PolyhedralMesh | StructuredGrid:
    """What `encoded` laid out, or what VTK itself made; a structured grid with one row of points becomes lines."""
    if data.kind == GRID:
        ni, nj, nk = data.dimensions
        if min(ni, nj, nk) < 1 or ni * nj * nk != len(data.points):
            raise InvalidInput(f"a grid of {ni} x {nj} x {nk} points does not fit the {len(data.points)} points given")
        if sum(n > 1 for n in data.dimensions) >= 2:
            return _decoded_grid(data)
        data = _row_of_points(data)
    if data.whole_polygons and holds_polyhedra(data):
        return polyhedral(data)
    cells, origin = cells_by_kind(data.types, data.connectivity, data.offsets, data.points)
    sets, cell_data = {}, {}
    for name, values in data.cell_data.items():
        values = np.asarray(values)
        if len(values) != len(data.types):
            raise InvalidInput(f"the cell array {name!r} has {len(values)} values for {len(data.types)} cells")
        if name.startswith(SET_PREFIX) and values.ndim == 1:
            sets[name[len(SET_PREFIX) :]] = np.flatnonzero(values[origin])
        else:
            cell_data[name] = values[origin]
    return Mesh(data.points, cells, data.point_data, cell_data, sets, data.field_data)


def _row_of_points(data: DataSet) -> DataSet:
    n = len(data.points)
    if n == 1:
        return DataSet(MESH, data.points, types=[VERTEX], connectivity=[0], offsets=[0, 1], point_data=data.point_data)
    start = np.arange(n - 1)
    return DataSet(
        MESH,
        data.points,
        types=np.full(n - 1, LINE),
        connectivity=np.column_stack([start, start + 1]).ravel(),
        offsets=2 * np.arange(n),
        point_data=data.point_data,
        cell_data=data.cell_data,
        field_data=data.field_data,
    )


def _decoded_grid(data: DataSet) -> StructuredGrid:
    shape = data.dimensions
    cell_shape = tuple(max(n - 1, 1) for n in shape)
    # A surface may be flat along any axis in VTK; a StructuredGrid has its single layer along k.
    axes = sorted(range(3), key=lambda axis: shape[axis] == 1)

    def unflat(name: str, values: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
        values = np.asarray(values)
        if len(values) != np.prod(shape):
            raise InvalidInput(f"the array {name!r} has {len(values)} values, the grid needs {int(np.prod(shape))}")
        block = values.reshape(*shape[::-1], *values.shape[1:]).swapaxes(0, 2)
        return block.transpose(*axes, *range(3, block.ndim))

    fields = data.field_data
    names = [str(name) for name in fields.get(FACE_NAMES, ())]
    periodic = [bool(flag) for flag in fields.get(PERIODIC, ())]
    grid = StructuredGrid(
        unflat("points", data.points, shape),
        {name: unflat(name, v, shape) for name, v in data.point_data.items()},
        {name: unflat(name, v, cell_shape) for name, v in data.cell_data.items()},
        {face: name for face, name in zip(FACES, names, strict=True) if name} if len(names) == 6 else {},
        tuple(periodic) if len(periodic) == 3 else (False, False, False),
    )
    return with_cuts(grid, fields)


def with_cuts(grid: AnyGrid, fields: Mapping[str, np.ndarray]) -> AnyGrid:
    """The grid or blocks with the cuts in field data; where they were changed since, so that they do not hold, without.

    Examples
    --------
    >>> grid = StructuredGrid([[[0, 0], [0, 1]], [[1, 0], [1, 1]]])
    >>> with_cuts(grid, {}) is grid
    True
    """
    texts = [str(text) for text in fields.get(CUTS, ())]
    try:
        return replace(grid, cuts=tuple(Cut(**json.loads(text)) for text in texts)) if texts else grid
    except (InvalidInput, TypeError, ValueError) as error:
        warn_dropped("the property", [CUTS], f"they do not fit the grid: {error}")
        return grid


def together(parts: dict[str, Mesh | StructuredGrid]) -> Mesh | StructuredGrid | MultiBlock:
    """Named parts as one: structured grids as a `MultiBlock`, anything else as one `Mesh` with a set for each part.

    Data that not all parts have is left out of a joined mesh, with a `FormatWarning`.
    """
    if not parts:
        raise InvalidInput("holds no blocks")
    if all(isinstance(part, StructuredGrid) for part in parts.values()):
        return MultiBlock(tuple(parts.values()), tuple(parts))
    return joined(parts)


def joined(parts: dict[str, Mesh | StructuredGrid]) -> Mesh:
    """Several meshes as one, points not shared; each part becomes a set by its name."""
    meshes = {name: p.to_mesh() if isinstance(p, StructuredGrid) else p for name, p in parts.items()}
    starts = np.cumsum([0] + [m.n_points for m in meshes.values()])
    kinds = dict.fromkeys(kind for m in meshes.values() for kind in m.cells)
    cells = {
        kind: np.concatenate([m.get(kind) + s for m, s in zip(meshes.values(), starts, strict=False)]) for kind in kinds
    }
    # Where the cells of each part went: by kind first, by part second.
    owner = np.concatenate([np.repeat(np.arange(len(meshes)), [len(m.get(k)) for m in meshes.values()]) for k in kinds])
    first = [np.flatnonzero(owner == k) for k in range(len(meshes))]
    place = np.concatenate([first[k][_order(m, list(kinds))] for k, m in enumerate(meshes.values())])
    sets: dict[str, np.ndarray] = {name: first[k] for k, name in enumerate(meshes)}
    for k, (name, m) in enumerate(meshes.items()):
        where = first[k][_order(m, list(kinds))]
        sets.update({f"{name}/{inner}": where[members] for inner, members in m.sets.items()})
    point_data = common_data([m.point_data for m in meshes.values()], "point data")
    cell_data = common_data([m.cell_data for m in meshes.values()], "cell data")
    back = np.argsort(place)
    return Mesh(
        np.concatenate([m.points for m in meshes.values()]),
        cells,
        point_data,
        {name: values[back] for name, values in cell_data.items()},
        sets,
    )


def _order(mesh: Mesh, kinds: list[str]) -> np.ndarray:
    """(number of cells,) int: where each cell of ``mesh`` stands when its kinds are put in the order of ``kinds``."""
    where = {kind: span for kind, _, span in mesh.blocks()}
    numbers = np.concatenate([np.arange(where[k].start, where[k].stop) for k in kinds if k in where])
    place = np.empty(mesh.n_cells, np.int64)
    place[numbers] = np.arange(mesh.n_cells)
    return place


def common_data(parts: list[dict[str, np.ndarray]], what: str) -> dict[str, np.ndarray]:
    """Arrays that all parts have alike, one part after the other; the others are left out, told."""
    names = dict.fromkeys(name for data in parts for name in data)
    kept = {}
    for name in names:
        arrays = [data.get(name) for data in parts]
        if all(a is not None and a.shape[1:] == arrays[0].shape[1:] for a in arrays if arrays[0] is not None) and (
            arrays[0] is not None
        ):
            kept[name] = np.concatenate(arrays)
    warn_dropped(what, [name for name in names if name not in kept], "not all blocks have it alike")
    return kept
