"""Layers of a MeshSet to meshes, and meshes to layers.

MeshLab holds surfaces: faces of three corners, some of whose edges are hidden so that several faces show as one
polygon, and polylines of edges. A volume is shown as two layers, its boundary and an exploded view of its cells.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pymeshlab

from meshcore import InvalidGeometry, InvalidInput, Mesh, MultiBlock, PolyhedralMesh, StructuredGrid, quality
from meshcore.mesh import CELL_TYPES

VERTEX_SCALAR, FACE_SCALAR, CELL = "vertex_scalar", "face_scalar", "cell"
"""Names of MeshLab's own scalars among a mesh's data, and of the attribute that numbers cells."""

SHRINK = 0.85
"""Size of the cells of an exploded view."""


def layer_of(ms: pymeshlab.MeshSet, layer: int | str | None, parameter: str = "layer") -> pymeshlab.Mesh:
    """A layer by its id or label; the current one if None.

    Raises
    ------
    InvalidInput
        If there is none, or several have the label.
    """
    layers = {mesh.id(): mesh for mesh in ms}
    if not layers:
        raise InvalidInput("the MeshSet has no layers; load or create a mesh first", parameter=parameter)
    if layer is None:
        return ms.current_mesh()
    if isinstance(layer, (int, np.integer)) and not isinstance(layer, bool) and int(layer) in layers:
        return layers[int(layer)]
    named = [mesh for mesh in layers.values() if mesh.label() == layer]
    if len(named) == 1:
        return named[0]
    known = ", ".join(f"{number} {mesh.label()!r}" for number, mesh in layers.items())
    what = "no layer" if not named else f"{len(named)} layers"
    raise InvalidInput(f"{what} with the id or label {layer!r}; there are {known}", parameter=parameter)


def to_mesh(layer: pymeshlab.Mesh, attributes: Sequence[str] = (), *, polygons: bool = True) -> Mesh:
    """The layer as a mesh, in the world's coordinates: its faces, or its edges if it has no faces.

    Parameters
    ----------
    layer : pymeshlab.Mesh
        Is compacted: filters that delete leave gaps in the numbering.
    attributes : sequence of str
        Names of custom attributes to take along, since MeshLab cannot list them.
    polygons : bool
        Whether faces with hidden edges become quads, or stay the triangles that MeshLab has.

    Raises
    ------
    InvalidInput
        If an attribute does not exist, or a polygon has more than four corners.
    InvalidGeometry
        If coordinates are not finite.
    """
    if not layer.is_compact():
        layer.compact()
    points = layer.transformed_vertex_matrix() if layer.vertex_number() else np.empty((0, 3))
    if not layer.face_number():
        cells = {"line": layer.edge_matrix().astype(np.int64)} if layer.edge_number() else {}
        return Mesh(points, cells, point_data=_point_data(layer, attributes))
    faces = layer.polygonal_face_list() if polygons else None
    if faces is None or all(len(face) == 3 for face in faces):
        mesh = Mesh(points, {"triangle": layer.face_matrix().astype(np.int64)})
        first = np.arange(layer.face_number())
    else:
        mesh, first = _polygon_mesh(points, faces, layer.face_matrix())
    cell_data = {name: values[first] for name, values in _face_data(layer, attributes).items()}
    mesh = mesh.with_point_data(**_point_data(layer, attributes)).with_cell_data(**cell_data)
    for name in attributes:
        if name not in mesh.point_data and name not in mesh.cell_data:
            raise InvalidInput(f"the layer {layer.label()!r} has no attribute {name!r}", parameter="attributes")
    return mesh


def _polygon_mesh(points: np.ndarray, faces: list[np.ndarray], triangles: np.ndarray) -> tuple[Mesh, np.ndarray]:
    """A mesh of triangles and quads, and for each cell one of the triangles that show it."""
    sizes = np.array([len(face) for face in faces])
    if sizes.max() > 4:
        k = int(np.argmax(sizes > 4))
        raise InvalidInput(
            f"polygon {k} has {sizes[k]} corners; triangulate it by meshing_poly_to_tri first", parameter="layer"
        )
    cells, order = {}, []
    for kind, count in (("triangle", 3), ("quad", 4)):
        chosen = np.flatnonzero(sizes == count)
        if len(chosen):
            cells[kind] = np.array([faces[k] for k in chosen], np.int64)
            order.append(chosen)
    # The triangles of a polygon follow each other in MeshLab's order, n - 2 of them for n corners.
    start = np.concatenate([[0], np.cumsum(sizes - 2)[:-1]])
    if int((sizes - 2).sum()) != len(triangles):
        start = np.zeros(len(sizes), int)
    return Mesh(points, cells), start[np.concatenate(order)]


def _point_data(layer: pymeshlab.Mesh, attributes: Sequence[str]) -> dict[str, np.ndarray]:
    data = {VERTEX_SCALAR: layer.vertex_scalar_array()} if layer.has_vertex_scalar() else {}
    readers = (layer.vertex_custom_scalar_attribute_array, layer.vertex_custom_point_attribute_matrix)
    return {**data, **_custom(attributes, readers, layer.vertex_number())}


def _face_data(layer: pymeshlab.Mesh, attributes: Sequence[str]) -> dict[str, np.ndarray]:
    data = {FACE_SCALAR: layer.face_scalar_array()} if layer.has_face_scalar() else {}
    readers = (layer.face_custom_scalar_attribute_array, layer.face_custom_point_attribute_matrix)
    return {**data, **_custom(attributes, readers, layer.face_number())}


def _custom(attributes: Sequence[str], readers: Sequence, count: int) -> dict[str, np.ndarray]:
    found = {}
    for name in attributes:
        for read in readers:
            try:
                values = read(name)
            except pymeshlab.PyMeshLabException:
                continue  # the only way to ask whether an attribute exists
            if len(values) == count:
                found[name] = values
                break
    return found


def has(layer: pymeshlab.Mesh, name: str) -> bool:
    """Whether a layer has a custom attribute of its vertices or faces by this name."""
    if not layer.is_compact():
        layer.compact()
    return name in _point_data(layer, [name]) or name in _face_data(layer, [name])


def to_boundary(layer: pymeshlab.Mesh, parameter: str, attributes: Sequence[str] = ()) -> Mesh:
    """The layer as lines: its edges, or else the edges of its faces that have a face on one side only.

    Points at the same place are joined, since polylines often come with the ends of each edge on their own; of their
    data those of the first are kept.

    Parameters
    ----------
    layer : pymeshlab.Mesh
        Is compacted.
    parameter : str
        What errors call the layer.
    attributes : sequence of str
        Names of custom attributes of the vertices to take along.

    Raises
    ------
    InvalidGeometry
        If there are no such lines.
    """
    mesh = to_mesh(layer, attributes)
    if layer.face_number():
        mesh = Mesh(mesh.points, {"line": mesh.boundary.get("line")}, point_data=mesh.point_data)
        if not mesh.n_cells:
            raise InvalidGeometry(
                f"the surface {layer.label()!r} is closed: it has no boundary edges to begin from", parameter=parameter
            )
    elif layer.edge_number():
        places, first, number = np.unique(mesh.points, axis=0, return_index=True, return_inverse=True)
        if len(places) < mesh.n_points:
            lines = first[number.ravel()][mesh.get("line")]
            mesh = Mesh(mesh.points, {"line": lines}, point_data=mesh.point_data)
    else:
        raise InvalidGeometry(
            f"the layer {layer.label()!r} has {layer.vertex_number()} vertices, but neither edges nor faces",
            parameter=parameter,
        )
    return mesh.compacted()


class Layer(NamedTuple):
    """A layer to be added.

    Attributes
    ----------
    label : str
        Its label.
    mesh : pymeshlab.Mesh or bytes
        Its geometry and face scalars; polygons as a PLY file.
    face_data, vertex_data : dict of str to array
        Custom attributes. They are attached once the layer is in the MeshSet: `add_mesh` copies a mesh, but the
        copies of its attributes point to memory that is freed with the original.
    polygon : (number of faces,) int
        The number of the polygon that each of MeshLab's triangles is of.
    """

    label: str
    mesh: pymeshlab.Mesh | bytes
    face_data: dict[str, np.ndarray]
    vertex_data: dict[str, np.ndarray]
    polygon: np.ndarray = np.empty(0, np.int64)


def add(
    ms: pymeshlab.MeshSet, result: Mesh | PolyhedralMesh | StructuredGrid | MultiBlock, label: str, measure: str
) -> list[int]:
    """Add the layers that show a mesh, make the first of them current, and return their ids.

    Parameters
    ----------
    ms : pymeshlab.MeshSet
        Gets one layer for lines and surfaces, two for a volume, one or two for each block.
    result : Mesh, PolyhedralMesh, StructuredGrid or MultiBlock
        What to show.
    label : str
        Label of the first layer.
    measure : str
        Quality measure for the face scalars.
    """
    ids = []
    for layer in layers(result, label, measure):
        added = _added(ms, layer)
        ids.append(added.id())
        for name, array in layer.face_data.items():
            _attach(added.add_face_custom_scalar_attribute, added.add_face_custom_point_attribute, name, array)
        for name, array in layer.vertex_data.items():
            _attach(added.add_vertex_custom_scalar_attribute, added.add_vertex_custom_point_attribute, name, array)
    ms.set_current_mesh(ids[0])
    return ids


def _added(ms: pymeshlab.MeshSet, layer: Layer) -> pymeshlab.Mesh:
    """Add a layer without its attributes, and return it."""
    if isinstance(layer.mesh, bytes):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "layer.ply"
            path.write_bytes(layer.mesh)
            ms.load_new_mesh(str(path))
        ms.current_mesh().set_label(layer.label)
    else:
        ms.add_mesh(layer.mesh, layer.label, set_as_current=True)
    return ms.current_mesh()


def _ply(points: np.ndarray, polygons: list[np.ndarray], scalars: np.ndarray | None) -> bytes:
    """Polygons as a PLY file, which MeshLab reads with hidden edges and in double precision.

    pymeshlab's constructor of polygons is no way in: its layers have an attribute ``poly_birth_faces`` that points to
    memory which `add_mesh` frees, and MeshLab's function filters, which read all attributes, crash (2025.7).
    """
    quality_line = "" if scalars is None else "property double quality\n"
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
        "property double x\nproperty double y\nproperty double z\n"
        f"element face {sum(map(len, polygons))}\nproperty list uchar int vertex_indices\n{quality_line}end_header\n"
    )
    parts, start = [header.encode(), points.astype("<f8").tobytes()], 0
    for cells in polygons:
        fields = [("count", "u1"), ("nodes", "<i4", (cells.shape[1],))]
        rows = np.zeros(len(cells), fields if scalars is None else [*fields, ("quality", "<f8")])
        rows["count"], rows["nodes"] = cells.shape[1], cells
        if scalars is not None:
            rows["quality"] = scalars[start : start + len(cells)]
        start += len(cells)
        parts.append(rows.tobytes())
    return b"".join(parts)


def layers(result: Mesh | PolyhedralMesh | StructuredGrid | MultiBlock, label: str, measure: str) -> Iterator[Layer]:
    """The layers that show a mesh: one for lines and surfaces, two for a volume, one or two a block.

    Parameters
    ----------
    result : Mesh, StructuredGrid or MultiBlock
        What to show.
    label : str
        Label of the first layer.
    measure : str
        Quality measure for the face scalars; with no such measure for its cells, a layer has none.
    """
    if isinstance(result, MultiBlock) and result.cuts:
        result = result.to_mesh()  # blocks that are joined are one surface
    if isinstance(result, MultiBlock):
        for name, block in zip(result.names, result.blocks, strict=True):
            yield from layers(block, f"{label} {name}", measure)
        return
    if isinstance(result, PolyhedralMesh):
        yield from _polygon_layers(label, result)
        return
    mesh = result.to_mesh() if isinstance(result, StructuredGrid) else result
    values = quality.measure(mesh, measure) if measure else np.full(mesh.n_cells, np.nan)
    if mesh.dimension == 3:
        outside = mesh.boundary
        layer = _surface(label, outside, outside.cell_data["cell"], values, mesh.cell_data)
        sides = {_as_word(name): inside[layer.polygon] for name, inside in _sides(mesh, outside).items()}
        yield layer._replace(face_data={**layer.face_data, **sides})
        yield _exploded(f"{label} exploded", mesh, values)
    elif mesh.dimension == 2:
        kept = np.concatenate([np.arange(w.start, w.stop) for k, _, w in mesh.blocks() if CELL_TYPES[k].dimension == 2])
        surface = Mesh(
            mesh.points,
            {k: c for k, c in mesh.cells.items() if CELL_TYPES[k].dimension == 2},
            point_data=mesh.point_data,
        )
        yield _surface(label, surface, kept, values, mesh.cell_data)
    else:
        if not mesh.n_points:
            raise InvalidInput("the mesh is empty; there is nothing to show", parameter="result")
        lines = {"edge_matrix": mesh.get("line").astype(np.int32)} if len(mesh.get("line")) else {}
        yield Layer(label, pymeshlab.Mesh(vertex_matrix=mesh.points, **lines), {}, mesh.point_data)


def _surface(label: str, surface: Mesh, cell: np.ndarray, values: np.ndarray, data: dict[str, np.ndarray]) -> Layer:
    """Faces as a layer; ``cell`` is the number of each face's cell, ``values`` and ``data`` are by these numbers."""
    scalars = None if np.isnan(values[cell]).all() else np.nan_to_num(values[cell], posinf=1e30, neginf=-1e30)
    polygons = [c[:, : len(CELL_TYPES[k].edges)] for k, c in surface.cells.items() if len(c)]
    if any(c.shape[1] > 3 for c in polygons):
        layer = _ply(surface.points, polygons, scalars)
    else:
        use = {} if scalars is None else {"f_scalar_array": scalars}
        triangles = np.concatenate(polygons).astype(np.int32)
        layer = pymeshlab.Mesh(vertex_matrix=surface.points, face_matrix=triangles, **use)
    # MeshLab shows n corners by n - 2 triangles, one after the other.
    face = np.repeat(np.arange(len(cell)), np.concatenate([np.full(len(c), c.shape[1] - 2) for c in polygons]))
    face_data = {name: array[cell][face] for name, array in data.items() if name != CELL}
    return Layer(label, layer, {CELL: cell[face], **face_data}, surface.point_data, face)


def _as_word(name: str) -> str:
    """The attribute of a side, 1 on its faces; MeshLab's conditions fail as a whole beside names that are no words."""
    return "set_" + re.sub(r"\W", "_", name, flags=re.ASCII)


def _sides(mesh: Mesh, outside: Mesh) -> dict[str, np.ndarray]:
    """(faces of the outside,) bool: for each set of sides of a volume mesh, which of its outer faces are in it."""
    faces = [(kind, c, w) for kind, c, w in mesh.blocks() if CELL_TYPES[kind].dimension == 2]
    if not faces:
        return {}
    parts = [*outside.cells.items(), *((kind, c) for kind, c, _ in faces)]
    corners = [np.sort(c[:, : len(CELL_TYPES[kind].edges)], axis=1) for kind, c in parts]
    rows = np.concatenate([np.pad(c, ((0, 0), (4 - c.shape[1], 0)), constant_values=-1) for c in corners])
    _, same = np.unique(rows, axis=0, return_inverse=True)
    shown, given = np.split(same.ravel(), [outside.n_cells])
    number = np.concatenate([np.arange(where.start, where.stop) for _, _, where in faces])
    return {name: np.isin(shown, given[np.isin(number, members)]) for name, members in mesh.sets.items()}


def _polygon_layers(label: str, mesh: PolyhedralMesh) -> Iterator[Layer]:
    """Polygons cut into triangles, which MeshLab's filters need; of polyhedra the boundary and an exploded view.

    Each face carries the number of its cell; its scalar is the cell's area or volume.
    """
    views = [(label, mesh)]
    if mesh.dimension == 3:
        views = [(label, mesh.boundary), (f"{label} exploded", mesh.separated(SHRINK))]
    for name, view in views:
        triangles = view.to_mesh()
        cell = triangles.cell_data[CELL]
        yield _surface(
            name, triangles, view.cell_data.get(CELL, np.arange(mesh.n_cells))[cell], mesh.volumes, mesh.cell_data
        )


def _attach(scalar, vector, name: str, array: np.ndarray) -> None:
    """Attach an array of numbers or of 3-vectors; MeshLab has no place for others."""
    if array.dtype.kind not in "fiub" or name in (FACE_SCALAR, VERTEX_SCALAR):
        return
    if array.ndim == 1:
        scalar(array.astype(float), name)
    elif array.ndim == 2 and array.shape[1] == 3:
        vector(array.astype(float), name)


def _exploded(label: str, mesh: Mesh, values: np.ndarray) -> Layer:
    """Each solid cell with its own corners and faces, shrunk towards its middle, so that one can look between."""
    points, faces, cell, start = [], {3: [], 4: []}, {3: [], 4: []}, 0
    for kind, cells, where in mesh.blocks():
        if CELL_TYPES[kind].dimension < 3 or not len(cells):
            continue
        corners = mesh.points[cells[:, : CELL_TYPES[CELL_TYPES[kind].linear or kind].nodes]]
        middle = corners.mean(axis=1, keepdims=True)
        points.append((middle + SHRINK * (corners - middle)).reshape(-1, 3))
        own = start + np.arange(corners[..., 0].size).reshape(corners.shape[:2])
        start += own.size
        for local in CELL_TYPES[kind].facets:
            faces[len(local)].append(own[:, local])
            cell[len(local)].append(np.arange(where.start, where.stop))
    kinds = {name: np.concatenate(faces[n]) for n, name in ((3, "triangle"), (4, "quad")) if faces[n]}
    numbers = np.concatenate([part for n in (3, 4) for part in cell[n]])
    return _surface(label, Mesh(np.concatenate(points), kinds), numbers, values, mesh.cell_data)
