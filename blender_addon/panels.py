# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the operators are found: Add > Mesh, the Object menu, and the sidebar's meshcore tab."""

from __future__ import annotations

from typing import Any

import bpy

from . import inputs, properties, results, volume
from .operators import PREFIX


def _by_category() -> dict[str, list[tuple[str, dict[str, Any]]]]:
    groups: dict[str, list[tuple[str, dict[str, Any]]]] = {}
    for identifier, declaration in properties.registry()["operations"].items():
        groups.setdefault(declaration["category"], []).append((identifier, declaration))
    return groups


class MESHCORE_MT_operations(bpy.types.Menu):
    """All operations, by category."""

    bl_idname = "MESHCORE_MT_operations"
    bl_label = "meshcore"

    def draw(self, context: Any) -> None:
        """One entry an operation; those that do not fit what is selected are grey, their tooltip says why."""
        # Menus run an operator's `execute` by default in some places; the interface wants `invoke`.
        self.layout.operator_context = "INVOKE_DEFAULT"
        for category, members in _by_category().items():
            self.layout.label(text=category)
            for identifier, declaration in members:
                self.layout.operator(PREFIX + identifier, text=declaration["label"])


class _Sidebar:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "meshcore"


class VIEW3D_PT_meshcore(_Sidebar, bpy.types.Panel):
    """Operations, with what to select for each."""

    bl_idname = "VIEW3D_PT_meshcore"
    bl_label = "Generate"

    def draw(self, context: Any) -> None:
        """A button an operation."""
        layout = self.layout
        layout.operator_context = "INVOKE_DEFAULT"
        for category, members in _by_category().items():
            box = layout.box()
            box.label(text=category)
            for identifier, declaration in members:
                box.operator(PREFIX + identifier, text=declaration["label"])
                if inputs.problem(context, declaration):
                    box.label(text=f"Select {inputs.wanted_text(declaration)}", icon="INFO")


class VIEW3D_PT_meshcore_quality(_Sidebar, bpy.types.Panel):
    """Quality of the active mesh."""

    bl_idname = "VIEW3D_PT_meshcore_quality"
    bl_label = "Quality"

    @classmethod
    def poll(cls, context: Any) -> bool:
        """For meshes."""
        return context.active_object is not None and context.active_object.type == "MESH"

    def draw(self, context: Any) -> None:
        """The report kept on the mesh, and the tools to look at bad cells."""
        layout, settings = self.layout, context.scene.meshcore
        data = context.active_object.data
        rows = results.summary(data)
        if rows:
            layout.label(text=data[results.REPORT]["operation"])
        for name, text in rows:
            row = layout.row()
            row.label(text=name)
            row.label(text=text)
        column = layout.column()
        column.use_property_split = True
        column.prop(settings, "measure")
        column.prop(settings, "side")
        column.prop(settings, "threshold")
        column.operator_context = "INVOKE_DEFAULT"
        column.operator("meshcore.select_bad_cells")
        if volume.CELLS in data:
            column.operator("meshcore.cut_view")


def _menu(self: Any, context: Any) -> None:
    self.layout.menu(MESHCORE_MT_operations.bl_idname, icon="MESH_GRID")


_CLASSES = (MESHCORE_MT_operations, VIEW3D_PT_meshcore, VIEW3D_PT_meshcore_quality)
_MENUS = ("VIEW3D_MT_mesh_add", "VIEW3D_MT_object")


def register() -> None:
    """Show menus and panels."""
    for one in _CLASSES:
        bpy.utils.register_class(one)
    for menu in _MENUS:
        getattr(bpy.types, menu).append(_menu)


def unregister() -> None:
    """Take menus and panels away."""
    for menu in _MENUS:
        getattr(bpy.types, menu).remove(_menu)
    for one in reversed(_CLASSES):
        bpy.utils.unregister_class(one)
