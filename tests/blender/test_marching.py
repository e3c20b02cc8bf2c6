"""Grids round curves and edge loops, layers on surfaces: what the panel tells, and where a march could not go on."""

from __future__ import annotations

import re

import bpy
import numpy as np
import pytest

from tests.blender import scene

TOLD = ("first height", "largest growth", "total height")


def section(core, name="airfoil"):
    """An airfoil as edges."""
    from meshcore import gallery

    return scene.from_core(name, gallery.airfoil("naca0012"))


def told(ob):
    """The rows of the panel."""
    return ob.data["meshcore_report"].to_dict()["quality"]


def selected(ob):
    """Numbers of the selected vertices."""
    return [vertex.index for vertex in ob.data.vertices if vertex.select]


@pytest.mark.parametrize("operator", ["o_grid", "c_grid", "hyperbolic"])
def test_the_panel_tells_heights_growth_and_the_worst_angle(core, operator):
    section(core)
    getattr(bpy.ops.meshcore, operator)(first_height=0.002)
    rows = told(scene.active())
    assert set(TOLD) <= set(rows) and "worst skew of lines (degree)" in rows
    assert rows["first height"] == pytest.approx(0.002)
    assert {"wall"} <= {group.name for group in scene.active().vertex_groups}


def test_layers_on_a_surface_with_modifiers_and_scale(core):
    bpy.ops.mesh.primitive_cube_add()
    ob = scene.active()
    ob.modifiers.new("smooth", "SUBSURF").levels = 2
    ob.scale = (1, 2, 0.5)
    bpy.context.view_layer.update()
    bpy.ops.meshcore.hyperbolic_volume(first_height=0.01, layers=5)
    rows = told(scene.active())
    assert set(TOLD) <= set(rows) and "worst corner (degree)" in rows
    x, y, z = np.ptp(scene.world_points(scene.active()), axis=0)  # a rounded box, as scaled, and its layers
    assert 1.5 < x < 2 and 3 < y < 4 and 0.75 < z < 1.2


def grouped(ob):
    """Vertices by vertex group."""
    names = {group.index: group.name for group in ob.vertex_groups}
    found = {name: set() for name in names.values()}
    for vertex in ob.data.vertices:
        for one in vertex.groups:
            found[names[one.group]].add(vertex.index)
    return found


def test_sides_of_layers_on_a_mesh_are_vertex_groups_also_after_a_cut(core):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=12, ring_count=8)
    body = scene.active()
    body.data.attributes.new("set:nose", "BOOLEAN", "FACE").data.foreach_set(
        "value", [f.center.z > 0.5 for f in body.data.polygons]
    )
    bpy.ops.meshcore.hyperbolic_volume(first_height=0.01, layers=3)
    ob = scene.active()
    n = len(body.data.vertices)
    groups = grouped(ob)
    assert set(groups) == {"wall", "outer", "nose"}
    height = scene.world_points(ob)[:, 2]
    assert groups["wall"] | groups["nose"] == set(range(n)) and groups["outer"] == set(range(3 * n, 4 * n))
    assert min(height[list(groups["nose"])]) > 0 > min(height[list(groups["wall"])])
    bpy.ops.meshcore.cut_view(axis="X", position=0.5)
    assert grouped(ob) == groups


def test_layers_of_layers_know_their_sides(core):
    from bl_ext.user_default.meshcore import volume

    bpy.ops.mesh.primitive_grid_add(x_subdivisions=4, y_subdivisions=4)
    bpy.ops.meshcore.hyperbolic_volume(first_height=0.01, layers=3)
    kept = volume.stored(scene.active().data)
    counts = {name: len(members) for name, members in kept.sets.items()}
    assert counts == {"wall": 16, "outer": 16, "xmin": 12, "xmax": 12, "ymin": 12, "ymax": 12}


def test_a_loop_of_a_surface_and_a_curve_get_grids(core):
    bpy.ops.mesh.primitive_cylinder_add(vertices=24)
    data = scene.active().data
    for face in data.polygons:
        face.select = False
    for vertex in data.vertices:
        vertex.select = vertex.co.z > 0
    for edge in data.edges:
        edge.select = all(data.vertices[k].select for k in edge.vertices)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.meshcore.o_grid(first_height=0.01)
    assert scene.active().data["meshcore_report"]["counts"]["around"] == 24
    np.testing.assert_allclose(scene.world_points(scene.active())[:, 2], 1, atol=1e-6)
    scene.activate()
    bpy.ops.curve.primitive_bezier_circle_add(radius=1)
    bpy.ops.meshcore.c_grid(first_height=0.01)
    assert "wall" in scene.active().vertex_groups


def test_where_a_march_stops_is_selected_on_what_was_made(core):
    section(core)
    bpy.ops.meshcore.hyperbolic(first_height=0.01, distance=1, other_side=True)  # farther than there is room inside
    ob = scene.active()
    (vertex,) = selected(ob)
    place = re.search(r"near \(([^)]*)\)", ob.data["meshcore_report"]["warnings"])[1]
    assert ob.data.vertices[vertex].co[:] == pytest.approx([float(x) for x in place.split(",")], abs=1e-5)


def test_where_layers_stop_is_selected(core):
    from meshcore import gallery

    ball = gallery.bumpy_ball()
    points = np.vstack([ball.points, ball.points + [2.2, 0, 0]])
    triangles = ball.get("triangle")
    scene.add_mesh("balls", points, faces=np.vstack([triangles, triangles + len(ball.points)]))
    bpy.ops.meshcore.hyperbolic_volume(first_height=0.01, distance=1.0)
    ob = scene.active()
    chosen = selected(ob)
    assert 3 <= len(chosen) < 30
    rows = told(ob)
    place = [rows[f"stopped at {axis}"] for axis in "xyz"]
    near = np.linalg.norm(scene.world_points(ob)[chosen] - place, axis=1)
    assert near.min() < 1e-5 and near.max() < 0.5


def test_a_march_that_cannot_begin_selects_the_point(core):
    ob = section(core)
    with pytest.raises(RuntimeError, match=r"no layer could be made.*1 vertex selected on airfoil") as caught:
        bpy.ops.meshcore.hyperbolic(first_height=1.0, layers=1, other_side=True)
    assert f"at the front's point {selected(ob)[0]} near" in str(caught.value)


def test_what_to_select_is_said_for_each(core):
    from bl_ext.user_default.meshcore import inputs, properties

    asked = {name: inputs.wanted_text(one) for name, one in properties.registry()["operations"].items()}
    assert asked["discretised"] == "a curve, or a mesh with open edges"
    assert asked["parabolic"] == "2 curves (front, outer; make the front the active one)"
    assert asked["o_grid"].startswith(
        "a curve, or a mesh with open edges, or 2 curves (section, outer; make the section"
    )
    assert asked["transfinite"].startswith("4 curves (south, east, north, west), or one closed curve or four chains")
