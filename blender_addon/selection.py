# SPDX-License-Identifier: GPL-3.0-or-later
"""Selecting what needs a look: cells of bad quality, and the points that an error names."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import bpy
import numpy as np

from . import properties, volume
from .convert import ReadingFailed, array, attributes, repair_selection

_ELEMENTS = ("vertices", "edges", "polygons")


def select_only(data: Any, elements: str, numbers: Sequence[int] | np.ndarray) -> None:
    """Select some vertices, edges or polygons of a mesh and nothing else."""
    repair_selection(data)
    for name in _ELEMENTS:
        chosen = np.zeros(len(getattr(data, name)), bool)
        if name == elements:
            chosen[np.asarray(numbers, int)] = True
        getattr(data, name).foreach_set("select", chosen)
    data.update()


def select_vertices(name: str, vertices: Sequence[int] | np.ndarray) -> int:
    """Select vertices of an object, whichever mode it is in; return how many could be."""
    ob = bpy.data.objects.get(name)
    if ob is None or ob.type != "MESH" or not len(vertices):
        return 0
    if ob.mode == "EDIT":
        import bmesh

        mesh = bmesh.from_edit_mesh(ob.data)
        mesh.verts.ensure_lookup_table()
        for element in (*mesh.verts, *mesh.edges, *mesh.faces):
            element.select = False
        for vertex in vertices:
            mesh.verts[int(vertex)].select = True
        mesh.select_flush_mode()
        bmesh.update_edit_mesh(ob.data, loop_triangles=False, destructive=False)
    else:
        select_only(ob.data, "vertices", vertices)
    return len(vertices)


class MESHCORE_OT_select_bad_cells(bpy.types.Operator):
    """Select the faces of the active mesh whose cells are of bad quality"""

    bl_idname = "meshcore.select_bad_cells"
    bl_label = "Select Bad Cells"
    bl_options = {"REGISTER", "UNDO"}

    measure: bpy.props.EnumProperty(name="Measure", description="Measure of quality", items=properties.measures_shown)
    side: bpy.props.EnumProperty(name="Select", description="Which cells are bad", items=properties.SIDES)
    threshold: bpy.props.FloatProperty(name="Threshold", description="Limit of the measure", default=0.3, precision=4)

    @classmethod
    def poll(cls, context: Any) -> bool:
        """A mesh with faces."""
        ob = context.active_object
        if ob is None or ob.type != "MESH" or ob.mode not in ("OBJECT", "EDIT") or not ob.visible_get():
            cls.poll_message_set("Select a mesh with faces, in Object Mode or Edit Mode")
            return False
        return True

    def invoke(self, context: Any, event: Any) -> set[str]:
        """Take what the panel shows."""
        settings = context.scene.meshcore
        self.measure, self.side, self.threshold = settings.measure, settings.side, settings.threshold
        return self.execute(context)

    def execute(self, context: Any) -> set[str]:
        """Measure, select, and go to Edit Mode with faces."""
        from meshcore import MeshcoreError

        ob = context.active_object
        if ob.mode == "EDIT":
            bpy.ops.object.mode_set(mode="OBJECT")
        try:
            values = face_values(ob, self.measure)
        except (ReadingFailed, MeshcoreError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        with np.errstate(invalid="ignore"):  # a measure is nan where it is not defined for the kind of cell
            bad = values < self.threshold if self.side == "BELOW" else values > self.threshold
        select_only(ob.data, "polygons", np.flatnonzero(bad))
        context.tool_settings.mesh_select_mode = (False, False, True)
        bpy.ops.object.mode_set(mode="EDIT")
        name = self.measure.replace("_", " ")
        self.report({"INFO"}, f"{int(bad.sum()):,} of {len(bad):,} faces have {name} {self.side.lower()} the threshold")
        return {"FINISHED"}


def face_values(ob: Any, measure: str) -> np.ndarray:
    """(number of faces,) float: a quality measure of the cell of each face of a mesh object, in world units."""
    from meshcore import Mesh, quality

    data = ob.data
    if not len(data.polygons):
        raise ReadingFailed(f"{ob.name} has no faces")
    matrix = np.array(ob.matrix_world)
    if (kept := volume.stored(data)) is not None:
        owner = attributes(data, "FACE")[volume.OWNER]
        return quality.measure(kept.transformed(matrix), measure)[owner]
    total = array(data.polygons, "loop_total", np.int32)
    start = array(data.polygons, "loop_start", np.int32)
    corners = array(data.loops, "vertex_index", np.int32)
    kinds = {"triangle": 3, "quad": 4}
    numbers = {kind: np.flatnonzero(total == count) for kind, count in kinds.items()}
    cells = {kind: corners[start[numbers[kind]][:, None] + np.arange(count)] for kind, count in kinds.items()}
    points = array(data.vertices, "co", np.float32, 3).astype(float)
    mesh = Mesh(points, cells).transformed(matrix)
    values = np.full(len(data.polygons), np.nan)  # faces of five corners and more have no measure
    values[np.concatenate(list(numbers.values()))] = quality.measure(mesh, measure)
    return values


register, unregister = bpy.utils.register_classes_factory((MESHCORE_OT_select_bad_cells,))
