"""Adaptive refinement by a vertex attribute, a face attribute, and the faces selected in Edit Mode."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from tests.blender import scene


@pytest.fixture
def grid(installed):
    """A 6 x 6 grid of quads over the unit square."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=6, y_subdivisions=6, size=1, location=(0.5, 0.5, 0))
    return scene.active()


def small_cells(ob):
    """Centres of the triangles that are smaller than those of the grid."""
    points = scene.world_points(ob)
    corners = points[np.array(scene.faces(ob))]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = np.linalg.norm(np.cross(a, b), axis=1) / 2
    assert area.sum() == pytest.approx(1, rel=1e-5)
    return corners.mean(axis=1)[area < 0.9 / 72]


def test_without_indicator_everything_is_refined(grid):
    assert bpy.ops.meshcore.refined() == {"FINISHED"}
    made = scene.active()
    assert len(small_cells(made)) == len(made.data.polygons) >= 4 * 72 / 2


def test_vertex_attribute_as_indicator(grid):
    x = scene.world_points(grid)[:, 0]
    grid.data.attributes.new("step", "FLOAT", "POINT").data.foreach_set("value", (x > 0.6).astype(np.float32))
    assert bpy.ops.meshcore.refined(indicator="step", fraction=0.9) == {"FINISHED"}
    centres = small_cells(scene.active())
    assert len(centres)
    assert abs(centres[:, 0] - 0.58).max() < 0.3
    assert "step" in scene.active().data.attributes


def test_face_attribute_as_indicator(grid):
    load = np.zeros(len(grid.data.polygons), np.float32)
    load[0] = 1
    grid.data.attributes.new("load", "FLOAT", "FACE").data.foreach_set("value", load)
    assert bpy.ops.meshcore.refined(indicator="load") == {"FINISHED"}
    centres = small_cells(scene.active())
    assert 0 < len(centres) < 16
    assert np.linalg.norm(centres, axis=1).max() < 0.5


def test_unknown_attribute_is_named(grid):
    with pytest.raises(RuntimeError, match="heat"):
        bpy.ops.meshcore.refined(indicator="heat")
    assert len(bpy.data.objects) == 1


def test_faces_selected_in_edit_mode_are_refined(grid):
    for face in grid.data.polygons:
        face.select = face.center.x > 0.3 and face.center.y > 0.3  # local: the last corner
    for element in (*grid.data.vertices, *grid.data.edges):
        element.select = False
    chosen = sum(face.select for face in grid.data.polygons)
    assert 0 < chosen < 36
    bpy.context.tool_settings.mesh_select_mode = (False, False, True)
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.meshcore.refined() == {"FINISHED"}
    centres = small_cells(scene.active())
    assert len(centres) >= 2 * 2 * chosen
    assert centres[:, :2].min() > 0.5


def test_all_selected_in_edit_mode_means_everything(grid):
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    assert bpy.ops.meshcore.refined() == {"FINISHED"}
    made = scene.active()
    assert len(small_cells(made)) == len(made.data.polygons)


def test_curve_is_no_mesh_to_refine(installed):
    bpy.ops.curve.primitive_bezier_circle_add()
    with pytest.raises(RuntimeError, match="has no faces; give a mesh with faces"):
        bpy.ops.meshcore.refined()
    assert len(bpy.data.objects) == 1
