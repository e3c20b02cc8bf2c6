# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's meshes and curves to meshcore's `Mesh`, and back.

Reading gives world coordinates of the evaluated object, so with its modifiers. Writing keeps quads as quads, line
cells as edges, point data as vertex attributes, cell data as face or edge attributes and sets as boolean attributes
whose names begin with ``set:``. Blender stores numbers with 32 bits, about seven digits, and each name once: where
points, edges and faces have data of one name, the later ones are called ``name.edge`` and ``name.face``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np

if TYPE_CHECKING:
    from meshcore import Mesh, PolyhedralMesh

SET_PREFIX = "set:"
# Attributes with a meaning of Blender's own, which are no data of the mesh.
_OWN = {"position", "sharp_face", "sharp_edge", "material_index", "crease_edge", "crease_vert", "uv_seam", "radius"}
_OWN |= {"bevel_weight_edge", "bevel_weight_vert", "freestyle_edge", "freestyle_face", "tilt"}
# Blender's type of an attribute: the name of its value, its number type, its numbers an element.
_READ = {
    "FLOAT": ("value", np.float32, 1),
    "INT": ("value", np.int32, 1),
    "INT8": ("value", np.int32, 1),
    "BOOLEAN": ("value", bool, 1),
    "FLOAT2": ("vector", np.float32, 2),
    "FLOAT_VECTOR": ("vector", np.float32, 3),
    "FLOAT_COLOR": ("color", np.float32, 4),
}


class ReadingFailed(Exception):
    """What is selected cannot be given to meshcore; the text is for the user.

    Attributes
    ----------
    name : str
        The object at fault.
    vertices : sequence of int
        Its vertices at fault.
    """

    def __init__(self, message: str, name: str = "", vertices: Sequence[int] = ()):
        super().__init__(message)
        self.name = name
        self.vertices = vertices


@dataclass(frozen=True)
class Source:
    """A mesh read from an object.

    Parameters
    ----------
    mesh : Mesh
        In world coordinates.
    name : str
        The object's name.
    vertices : (n,) int or None
        Vertex of the object for each point of the mesh; None if modifiers made the points.
    faces : (m,) int or None
        Face of the object for each cell of the mesh; None for lines, and if modifiers made the faces.
    parts : tuple of Source
        What the mesh was joined from, its points in this order.
    """

    mesh: Mesh
    name: str
    vertices: np.ndarray | None = None
    faces: np.ndarray | None = None
    parts: tuple[Source, ...] = ()


def read(context: Any, ob: Any, kinds: Sequence[str], groups: Sequence[str] = ()) -> Source:
    """An object as a mesh of the kinds of cell that an input accepts.

    Where lines are asked for and no faces, that is: loose edges and the open boundary of faces, or in Edit Mode the
    selected edges (a selected region gives its outline). Where triangles are asked for, all faces are triangulated.
    Where no kind is asked for, all vertices are taken, with or without faces. Of vertex groups, those that ``groups``
    names become point data.

    Raises
    ------
    ReadingFailed
        If the object has no such cells, or coordinates that are not finite.
    """
    from meshcore import InvalidGeometry

    from . import volume

    kept = volume.kinds(ob.data)
    if kept and (not kinds or kept <= set(kinds)):
        stored = volume.stored(ob.data).transformed(np.array(ob.matrix_world))
        return Source(stored, ob.name, np.arange(stored.n_points))
    lines_only = bool(kinds) and set(kinds) <= {"line"}
    with _geometry(context, ob, lines_only) as (data, matrix, selection):
        faces = None
        if lines_only:
            cells, cell_data = _lines(data, selection)
            missing = _no_lines(ob, data)
        else:
            cells, cell_data, faces = _faces(data, quads=not kinds or "quad" in kinds)
            missing = f"{ob.name} has no {'faces; give a mesh with faces' if kinds else 'vertices; add some'}"
        if not (sum(map(len, cells.values())) if kinds else len(data.vertices)):
            raise ReadingFailed(missing, ob.name)
        points = array(data.vertices, "co", np.float32, 3).astype(float)
        original = ob.type == "MESH" and len(ob.data.vertices) == len(points)
        original = original and len(ob.data.polygons) == len(data.polygons)
        used = np.full(len(points), not kinds)
        for nodes in cells.values():
            used[nodes] = True
        at_points = {**weights(ob, ob.data if original else data, groups), **attributes(data, "POINT")}
        point_data = {name: values[used] for name, values in at_points.items()}
    number = np.cumsum(used) - 1
    vertices = np.flatnonzero(used)
    cells = {kind: number[nodes] for kind, nodes in cells.items() if len(nodes)}
    try:
        mesh = _checked(points[used], cells, point_data, cell_data, matrix)
    except InvalidGeometry as error:
        at_fault = vertices[list(error.points)] if original else ()
        raise ReadingFailed(f"{ob.name}: {error}", ob.name, at_fault) from None
    return Source(mesh, ob.name, vertices, faces) if original else Source(mesh, ob.name)


def _checked(points: np.ndarray, cells: dict, point_data: dict, cell_data: dict, matrix: np.ndarray) -> Mesh:
    """The mesh in world coordinates; a mirrored object keeps its faces' outside out."""
    from meshcore import Mesh

    sets = {n[len(SET_PREFIX) :]: np.flatnonzero(v) for n, v in cell_data.items() if n.startswith(SET_PREFIX)}
    cell_data = {n: v for n, v in cell_data.items() if not n.startswith(SET_PREFIX)}
    with np.errstate(invalid="ignore", over="ignore"):  # Mesh names coordinates that are no numbers
        world = points @ matrix[:3, :3].T + matrix[:3, 3]
    mesh = Mesh(world, cells, point_data=point_data, cell_data=cell_data, sets=sets)
    mirrored = np.linalg.det(matrix[:3, :3]) < 0
    return mesh.reoriented() if mirrored and "line" not in cells else mesh


@contextmanager
def _geometry(context: Any, ob: Any, lines_only: bool) -> Iterator[tuple[Any, np.ndarray, bool]]:
    """The mesh to read, its matrix, and whether only its selection is meant."""
    if ob.mode == "EDIT":
        ob.update_from_editmode()
        # What is selected is the cage that the user sees, before modifiers.
        if lines_only and ob.type == "MESH" and array(ob.data.edges, "select", bool).any():
            yield ob.data, np.array(ob.matrix_world), True
            return
    final = ob.evaluated_get(context.evaluated_depsgraph_get())
    data = final.to_mesh()
    if data is None:
        raise ReadingFailed(f"{ob.name} is empty; give a curve or a mesh with edges", ob.name)
    try:
        yield data, np.array(final.matrix_world), False
    finally:
        final.to_mesh_clear()


def _lines(data: Any, selection: bool) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Edges of fewer than two faces."""
    corner_edge = array(data.loops, "edge_index", np.int32)
    keep = np.ones(len(data.edges), bool)
    if selection:
        keep = array(data.edges, "select", bool)
        chosen = array(data.polygons, "select", bool)
        corner_edge = corner_edge[np.repeat(chosen, array(data.polygons, "loop_total", np.int32))]
    keep &= np.bincount(corner_edge, minlength=len(data.edges)) < 2
    nodes = array(data.edges, "vertices", np.int32, 2)[keep]
    return {"line": nodes}, {name: values[keep] for name, values in attributes(data, "EDGE").items()}


def _no_lines(ob: Any, data: Any) -> str:
    if not len(data.edges):
        return f"{ob.name} has no edges; give a curve or a mesh with edges"
    return f"{ob.name} is closed and has no open boundary; select edges of it in Edit Mode"


def _faces(data: Any, quads: bool) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray], np.ndarray]:
    """Faces as triangles, and as quads where that is wanted, their data, and which face each cell is of."""
    total = array(data.polygons, "loop_total", np.int32)
    start = array(data.polygons, "loop_start", np.int32)
    corners = array(data.loops, "vertex_index", np.int32)
    data.calc_loop_triangles()
    triangles = array(data.loop_triangles, "vertices", np.int32, 3)
    owner = array(data.loop_triangles, "polygon_index", np.int32)
    whole = np.flatnonzero(total == 4) if quads else np.empty(0, int)
    left = ~np.isin(owner, whole)
    cells = {"triangle": triangles[left], "quad": corners[start[whole][:, None] + np.arange(4)]}
    faces = np.concatenate([owner[left], whole])
    return cells, {name: values[faces] for name, values in attributes(data, "FACE").items()}, faces


def array(collection: Any, name: str, dtype: Any, width: int = 1) -> np.ndarray:
    """One property of all elements, as (n,) or (n, width)."""
    flat = np.empty(len(collection) * width, dtype)
    collection.foreach_get(name, flat)
    return flat if width == 1 else flat.reshape(-1, width)


def attributes(data: Any, domain: str) -> dict[str, np.ndarray]:
    """The data of one domain: what the user or meshcore put there."""
    found = {}
    for attribute in data.attributes:
        own = attribute.name in _OWN or attribute.name.startswith(".")
        if attribute.domain == domain and attribute.data_type in _READ and not own:
            name, dtype, width = _READ[attribute.data_type]
            values = array(attribute.data, name, dtype, width)
            # meshcore computes with 64 bits; arithmetic on 32 would lose what digits there are.
            plain = attribute.name.removesuffix(f".{domain.lower()}")
            found[plain] = values.astype(float) if dtype is np.float32 else values
    return found


def weights(ob: Any, data: Any, names: Sequence[str]) -> dict[str, np.ndarray]:
    """The weights of vertex groups as numbers; vertices outside a group have the largest weight that is in it."""
    found = {}
    for name in names:
        group = ob.vertex_groups.get(name) if ob.type == "MESH" else None
        if group is None:
            continue
        values = np.full(len(data.vertices), -1.0)
        for k, vertex in enumerate(data.vertices):
            for one in vertex.groups:
                if one.group == group.index:
                    values[k] = float(str(np.float32(one.weight)))
        found[name] = np.where(values < 0, values.max(initial=0.0), values)
    return found


# ---- back to Blender


def write(name: str, mesh: Mesh, origin: np.ndarray) -> tuple[Any, list[str]]:
    """A new Blender mesh, its coordinates relative to ``origin``, and warnings of what it cannot hold."""
    from . import volume

    data = bpy.data.meshes.new(name)
    add_points(data, mesh.points - origin)
    if mesh.dimension == 3:
        return data, volume.store(data, mesh)
    lines = mesh.get("line")
    data.edges.add(len(lines))
    data.edges.foreach_set("vertices", np.ascontiguousarray(lines, np.int32).ravel())
    faces = {kind: nodes for kind, nodes in mesh.cells.items() if kind in _CORNERS}
    add_faces(data, [nodes[:, : _CORNERS[kind]] for kind, nodes in faces.items()])
    warnings = add_data(data, "POINT", mesh.point_data)
    if data.validate():
        return data, [*warnings, "Blender removed faces without area or drawn twice; cell data are left out"]
    return data, warnings + _add_cell_data(data, mesh)


def write_polygons(name: str, mesh: PolyhedralMesh, origin: np.ndarray) -> tuple[Any, list[str]]:
    """A new Blender mesh of polygons; of polyhedra each is a closed surface of its own, as pieces of a fracture are.

    "Separate by Loose Parts" makes objects of the pieces; the face attribute "cell" numbers them.
    """
    shown = mesh.separated() if mesh.dimension == 3 else mesh
    data = bpy.data.meshes.new(name)
    add_points(data, shown.points - origin)
    add_polygons(data, shown.face_nodes, np.diff(shown.face_offsets))
    warnings = add_data(data, "POINT", shown.point_data)
    if data.validate():
        return data, [*warnings, "Blender removed faces without area or drawn twice; cell data are left out"]
    return data, warnings + add_data(data, "FACE", shown.cell_data)


_CORNERS = {"triangle": 3, "quad": 4, "triangle6": 3, "quad8": 4, "quad9": 4}


def add_points(data: Any, points: np.ndarray) -> None:
    data.vertices.add(len(points))
    data.vertices.foreach_set("co", np.ascontiguousarray(points, np.float32).ravel())


def add_faces(data: Any, blocks: list[np.ndarray]) -> None:
    """Polygons from (m, k) arrays of vertices, one array after the other, and the edges that they need."""
    corners = np.concatenate([np.empty(0, np.int32), *[b.astype(np.int32).ravel() for b in blocks]])
    total = np.concatenate([np.empty(0, np.int32), *[np.full(len(b), b.shape[1], np.int32) for b in blocks]])
    add_polygons(data, corners, total)


def add_polygons(data: Any, corners: np.ndarray, total: np.ndarray) -> None:
    """Polygons from the vertices of all of them and the number of each one's, and the edges that they need."""
    corners, total = corners.astype(np.int32), total.astype(np.int32)
    start = np.cumsum(total, dtype=np.int32) - total
    data.loops.add(len(corners))
    data.loops.foreach_set("vertex_index", corners)
    data.polygons.add(len(total))
    data.polygons.foreach_set("loop_start", start)
    data.update(calc_edges=True)
    repair_selection(data)


def repair_selection(data: Any) -> None:
    """Drop the edges' selection where it has the wrong type.

    Blender 5.0 gives it pairs of integers when it makes a mesh's edges, and crashes when that is then written to.
    """
    layer = data.attributes.get(".select_edge")
    if layer is not None and layer.data_type != "BOOLEAN":
        data.attributes.remove(layer)


def _add_cell_data(data: Any, mesh: Mesh) -> list[str]:
    """Cell data and sets as attributes of faces and edges; cells of both kinds are numbered as in ``mesh``."""
    arrays = dict(mesh.cell_data)
    for name, members in mesh.sets.items():
        arrays[SET_PREFIX + name] = np.isin(np.arange(mesh.n_cells), members)
    faces = np.concatenate([np.arange(0), *[np.arange(w.start, w.stop) for k, _, w in mesh.blocks() if k in _CORNERS]])
    warnings = []
    if len(faces):
        warnings = add_data(data, "FACE", {name: values[faces] for name, values in arrays.items()})
    lines = next((where for kind, _, where in mesh.blocks() if kind == "line"), slice(0, 0))
    if lines.stop > lines.start:
        edge = _edges_of(data, mesh.get("line"))
        for name, values in arrays.items():
            spread = np.zeros((len(data.edges), *values.shape[1:]), values.dtype)
            spread[edge] = values[lines]
            warnings += add_data(data, "EDGE", {name: spread})
    return warnings


def _edges_of(data: Any, lines: np.ndarray) -> np.ndarray:
    """Number of the Blender edge of each line; Blender may have put its edges in another order."""
    n = len(data.vertices)
    edges = np.sort(array(data.edges, "vertices", np.int32, 2).astype(np.int64), axis=1) @ [n, 1]
    order = np.argsort(edges)
    return order[np.searchsorted(edges, np.sort(lines, axis=1) @ [n, 1], sorter=order)]


def add_data(data: Any, domain: str, arrays: dict[str, np.ndarray]) -> list[str]:
    """Attributes from arrays; a warning for each that Blender has no type for."""
    warnings = []
    for name, values in arrays.items():
        kind = _blender_type(values)
        if kind is None or name in _OWN or name.startswith("."):
            warnings.append(f"data {name!r} ({values.dtype}, shape {values.shape}) cannot be kept in Blender")
            continue
        taken = data.attributes.get(name)
        attribute = data.attributes.new(f"{name}.{domain.lower()}" if taken else name, kind, domain)
        item, dtype, _ = _READ[kind]
        attribute.data.foreach_set(item, np.ascontiguousarray(values, dtype).ravel())
    return warnings


def _blender_type(values: np.ndarray) -> str | None:
    kind, width = values.dtype.kind, int(np.prod(values.shape[1:]))
    if kind == "b" and width == 1:
        return "BOOLEAN"
    if kind in "iu" and width == 1 and (not values.size or np.abs(values.astype(float)).max() < 2**31):
        return "INT"
    if kind in "iuf":
        return {1: "FLOAT", 2: "FLOAT2", 3: "FLOAT_VECTOR", 4: "FLOAT_COLOR"}.get(width)
    return None
