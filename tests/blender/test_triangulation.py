"""Delaunay refinement from Blender: outlines with holes, curves, tilted planes, and what cannot be meshed."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from mathutils import Euler, Matrix

from tests.blender import scene

SQUARE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float)


def loop(name, points, *, select=True):
    """A closed chain through points."""
    n = len(points)
    return scene.add_mesh(name, points, [(k, (k + 1) % n) for k in range(n)], select=select)


def circle(n, radius=1.0, centre=(0, 0)):
    """Points of a regular polygon."""
    angle = 2 * np.pi * np.arange(n) / n
    return np.column_stack([centre[0] + radius * np.cos(angle), centre[1] + radius * np.sin(angle), 0 * angle])


def triangles(ob):
    """(m, 3, 3) float: corners of all faces, which must be triangles."""
    return scene.world_points(ob)[np.array(scene.faces(ob))]


def area(ob):
    """Sum of the triangles' areas."""
    a, b, c = triangles(ob).swapaxes(0, 1)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


def smallest_angle(ob):
    """In degrees."""
    corners = triangles(ob)
    out = [corners[:, (k + 1) % 3] - corners[:, k] for k in range(3)]
    unit = [v / np.linalg.norm(v, axis=1)[:, None] for v in out]
    cosines = [-(unit[k] * unit[k - 1]).sum(axis=1) for k in range(3)]
    return np.degrees(np.arccos(np.max(cosines)))


def refused(match, **keywords):
    """The operator fails with a line that matches and makes nothing."""
    before = scene.names()
    with pytest.raises(RuntimeError, match=match) as caught:
        bpy.ops.meshcore.delaunay_refinement(**keywords)
    assert "Unexpected" not in str(caught.value)
    assert scene.names() == before
    return str(caught.value)


def chosen(ob):
    """Numbers of the selected vertices."""
    return {v.index for v in ob.data.vertices if v.select}


def test_outline_and_hole_as_two_objects(installed):
    outline, hole = loop("outline", SQUARE), loop("hole", circle(16, 0.25, (0.5, 0.5)), select=False)
    scene.activate(outline, hole)
    assert bpy.ops.meshcore.delaunay_refinement(min_angle=25) == {"FINISHED"}
    made = scene.active()
    inner = 0.5 * 16 * 0.25**2 * np.sin(2 * np.pi / 16)
    assert area(made) == pytest.approx(1 - inner, rel=1e-5)
    assert smallest_angle(made) > 25 - 1e-3
    assert set(scene.values(made, "region")) == {1}


def test_size_holds_for_every_edge(installed):
    bpy.ops.curve.primitive_bezier_circle_add(radius=1)
    assert bpy.ops.meshcore.delaunay_refinement(size=0.15) == {"FINISHED"}
    corners = triangles(scene.active())
    longest = max(np.linalg.norm(corners[:, k] - corners[:, k - 1], axis=1).max() for k in range(3))
    assert longest <= 0.15 * (1 + 1e-5)


@pytest.mark.parametrize("angles", [(0.3, -1.1, 2.0), (1.5707963, 0, 0), (0.7853982, 0.6154797, 0.1)])
def test_tilted_plane_far_away(installed, angles):
    """Blender's 24 bits leave a tilted loop a little out of plane; that must not matter."""
    ob = loop("tilted", circle(40, 2))
    ob.matrix_world = Matrix.Translation((30, -50, 20)) @ Euler(angles).to_matrix().to_4x4()
    bpy.context.view_layer.update()
    assert bpy.ops.meshcore.delaunay_refinement(min_angle=20) == {"FINISHED"}
    made = scene.active()
    normal = np.array(ob.matrix_world)[:3, 2]
    off = (scene.world_points(made) - np.array(ob.location)) @ normal
    assert abs(off).max() < 1e-4
    assert area(made) == pytest.approx(0.5 * 40 * 4 * np.sin(2 * np.pi / 40), rel=1e-5)


def test_points_tilted_in_the_mesh_itself(installed):
    turned = circle(40, 2) @ np.array(Euler((0.4, 0.9, -0.2)).to_matrix()).T + [7, 8, 9]
    loop("tilted", turned)
    assert bpy.ops.meshcore.delaunay_refinement(min_angle=20) == {"FINISHED"}
    assert area(scene.active()) == pytest.approx(0.5 * 40 * 4 * np.sin(2 * np.pi / 40), rel=1e-5)


def test_thousands_of_edges(installed):
    loop("fine", circle(4000))
    assert bpy.ops.meshcore.delaunay_refinement(min_angle=20) == {"FINISHED"}
    assert len(scene.active().data.vertices) >= 4000


def test_selected_region_of_a_mesh(installed):
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=4, y_subdivisions=4, size=4)
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.meshcore.delaunay_refinement() == {"FINISHED"}
    assert area(scene.active()) == pytest.approx(16, rel=1e-5)


def test_non_planar_loop_is_refused(installed):
    loop("warped", SQUARE + [[0, 0, 0], [0, 0, 0.3], [0, 0, 0], [0, 0, 0.3]])
    refused("plan")


def test_open_chain_is_refused(installed):
    scene.add_mesh("open", SQUARE, [(0, 1), (1, 2), (2, 3)])
    refused("open|clos")


def test_crossing_lines_are_refused_marked_or_split(installed):
    ob = loop("bow tie", SQUARE[[0, 2, 1, 3]])
    assert "selected on bow tie" in refused("cross")
    assert chosen(ob)
    assert bpy.ops.meshcore.delaunay_refinement(crossings="split") == {"FINISHED"}
    assert area(scene.active()) == pytest.approx(0.5, rel=1e-5)


def test_crossing_of_two_objects_is_marked_on_both(installed):
    one, two = loop("one", SQUARE), loop("two", SQUARE + [0.5, 0.5, 0], select=False)
    scene.activate(one, two)
    assert "selected on one and two" in refused("cross")
    assert chosen(one)
    assert chosen(two)


def test_size_that_nobody_can_store(installed):
    loop("square", SQUARE)
    refused("size", size=1e-7)


def test_flat_loop(installed):
    loop("flat", np.array([(0, 0, 0), (1, 0, 0), (2, 0, 0)], float))
    refused(".")


def test_doubled_points_and_edges(installed):
    points = np.concatenate([SQUARE, SQUARE[:1]])
    scene.add_mesh("doubled", points, [(0, 1), (1, 2), (2, 3), (3, 4)])  # closed by place, not by number
    assert bpy.ops.meshcore.delaunay_refinement(min_angle=20) == {"FINISHED"}
    assert area(scene.active()) == pytest.approx(1, rel=1e-5)


def test_mirrored_and_stretched_object(installed):
    ob = loop("square", SQUARE)
    ob.scale = (-2, 3, 1)
    bpy.context.view_layer.update()
    assert bpy.ops.meshcore.delaunay_refinement() == {"FINISHED"}
    made = scene.active()
    assert area(made) == pytest.approx(6, rel=1e-5)
    np.testing.assert_allclose(scene.world_points(made).min(axis=0), [-2, 0, 0], atol=1e-6)


def test_undo_of_an_error_leaves_nothing_to_undo(installed):
    loop("outline", SQUARE)
    bpy.ops.ed.undo_push(message="outline")
    bpy.ops.meshcore.delaunay_refinement("EXEC_DEFAULT", True, min_angle=20)
    scene.activate(bpy.data.objects["outline"])
    bpy.data.objects["outline"].data.vertices[0].co.z = 0.5
    with pytest.raises(RuntimeError):
        bpy.ops.meshcore.delaunay_refinement("EXEC_DEFAULT", True)
    bpy.ops.ed.undo()
    assert scene.names() == {"outline"}


def test_curve_in_edit_mode(installed):
    bpy.ops.curve.primitive_bezier_circle_add(radius=1)
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.meshcore.delaunay_refinement(min_angle=20) == {"FINISHED"}
    assert area(scene.active()) == pytest.approx(np.pi, rel=5e-3)


def test_text(installed):
    """Letters are outlines with holes; what is filled stays filled."""
    bpy.ops.object.text_add()
    text = scene.active()
    text.data.body = "Ro8"
    bpy.context.view_layer.update()
    mesh = text.to_mesh()
    filled = sum(face.area for face in mesh.polygons)
    text.to_mesh_clear()
    assert bpy.ops.meshcore.delaunay_refinement(min_angle=20) == {"FINISHED"}
    assert area(scene.active()) == pytest.approx(filled, rel=1e-4)
