"""Objects made and read by hand, apart from the add-on's own conversion, which is what is tested."""

from __future__ import annotations

import importlib
from typing import Any

import bpy
import numpy as np

SINGLE = 1e-6
"""Blender keeps coordinates with 24 bits: half a unit in the last place is 6e-8 of a coordinate."""


def add_mesh(name: str, points: Any, edges: Any = (), faces: Any = (), *, select: bool = True) -> Any:
    """A mesh object in the scene, active and the only one selected unless ``select`` is False."""
    data = bpy.data.meshes.new(name)
    data.from_pydata(
        [tuple(map(float, p)) for p in points], [tuple(map(int, e)) for e in edges], [list(map(int, f)) for f in faces]
    )
    return link(bpy.data.objects.new(name, data), select=select)


def link(ob: Any, *, select: bool = True) -> Any:
    """Put an object into the scene."""
    bpy.context.scene.collection.objects.link(ob)
    if select:
        activate(ob)
    return ob


def activate(*objects: Any) -> None:
    """Select these objects alone; the first is active."""
    bpy.context.view_layer.update()
    for ob in bpy.context.view_layer.objects:
        ob.select_set(ob in objects)
    bpy.context.view_layer.objects.active = objects[0] if objects else None
    bpy.context.view_layer.update()


def from_core(name: str, mesh: Any) -> Any:
    """A core mesh as an object, element by element, with its scalar data as attributes."""
    kinds = {kind: cells.tolist() for kind, cells in mesh.cells.items()}
    lines = kinds.pop("line", [])
    kinds.pop("vertex", None)  # every vertex of Blender's is one
    faces = [face for cells in kinds.values() for face in cells]
    ob = add_mesh(name, mesh.points, lines, faces)
    domain = "FACE" if faces else "EDGE"
    for where, arrays in (("POINT", mesh.point_data), (domain, mesh.cell_data)):
        for key, values in arrays.items():
            attribute = ob.data.attributes.new(key, "INT" if values.dtype.kind in "iu" else "FLOAT", where)
            for element, value in zip(attribute.data, values.tolist(), strict=True):
                element.value = value
    return ob


def rounded(mesh: Any) -> Any:
    """A core mesh as Blender stores it: coordinates and data of 32 bits."""

    def single(values: np.ndarray) -> np.ndarray:
        return values.astype(np.float32).astype(float) if values.dtype.kind == "f" else values

    points = {name: single(values) for name, values in mesh.point_data.items()}
    cells = {name: single(values) for name, values in mesh.cell_data.items()}
    return mesh.with_points(single(mesh.points)).with_point_data(**points).with_cell_data(**cells)


def world_points(ob: Any) -> np.ndarray:
    """(n, 3) float: vertices in the world."""
    bpy.context.view_layer.update()
    return np.array([ob.matrix_world @ vertex.co for vertex in ob.data.vertices]).reshape(-1, 3)


def faces(ob: Any) -> list[list[int]]:
    """Vertices of each face."""
    return [list(face.vertices) for face in ob.data.polygons]


def values(ob: Any, name: str) -> np.ndarray:
    """A number attribute, element by element."""
    return np.array([element.value for element in ob.data.attributes[name].data])


def active() -> Any:
    """The active object."""
    return bpy.context.view_layer.objects.active


def operator(identifier: str) -> Any:
    """The operator of an operation."""
    return getattr(bpy.ops.meshcore, identifier)


def addon(module: str) -> Any:
    """A module of the installed extension."""
    return importlib.import_module(f"bl_ext.user_default.meshcore.{module}")


def names() -> set[str]:
    """Names of all objects."""
    return {ob.name for ob in bpy.data.objects}
