"""What is read from objects: modifiers, transforms, curves, selections, several objects."""

from __future__ import annotations

import itertools
import math

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from tests.blender import scene

SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
LOOP = [(0, 1), (1, 2), (2, 3), (3, 0)]


@pytest.fixture
def reader(installed):
    """The add-on's reading, of one object, as lines or faces."""
    convert = scene.addon("convert")
    return lambda ob, *kinds: convert.read(bpy.context, ob, kinds)


def grid_ring(n, name="grid"):
    """An n by n grid of unit faces."""
    points = [(i, j, 0) for j in range(n + 1) for i in range(n + 1)]
    corner = [j * (n + 1) + i for j in range(n) for i in range(n)]
    return scene.add_mesh(name, points, faces=[(c, c + 1, c + n + 2, c + n + 1) for c in corner])


def side(name, a, b, n, *, select=True):
    """A straight chain of n lines."""
    points = np.linspace(a, b, n + 1)
    return scene.add_mesh(name, points, [(k, k + 1) for k in range(n)], select=select)


def corner_set(points):
    """Points as a set of rounded triples, whatever their order."""
    return {tuple(np.round(p, 5) + 0.0) for p in np.asarray(points)}


def test_faces_give_their_open_boundary_as_lines(reader):
    mesh = reader(grid_ring(3), "line").mesh
    assert mesh.n_points == len(mesh.get("line")) == 12
    assert len(mesh.boundary.cells) == 0  # closed


def test_loose_edges_beside_faces_are_kept(reader):
    ob = scene.add_mesh("mixed", [*SQUARE, (0.2, 0.2, 0), (0.8, 0.8, 0)], [(4, 5)], [(0, 1, 2, 3)])
    assert len(reader(ob, "line").mesh.get("line")) == 5


def test_selected_region_gives_its_outline(reader):
    ob = grid_ring(3)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.object.mode_set(mode="OBJECT")
    for number in (0, 1, 3, 4):  # a block of two by two
        ob.data.polygons[number].select = True
    bpy.ops.object.mode_set(mode="EDIT")
    mesh = reader(ob, "line").mesh
    assert len(mesh.get("line")) == 8
    assert corner_set(mesh.bounds) == {(0, 0, 0), (2, 2, 0)}


def test_selected_edges_are_read_through_edit_mode(reader):
    ob = grid_ring(2)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.object.mode_set(mode="OBJECT")
    ob.data.edges[0].select = True
    bpy.ops.object.mode_set(mode="EDIT")
    assert len(reader(ob, "line").mesh.get("line")) == 1
    bpy.ops.mesh.select_all(action="DESELECT")
    assert len(reader(ob, "line").mesh.get("line")) == 8  # nothing selected: the open boundary


def test_modifiers_are_applied(reader):
    ob = scene.add_mesh("plane", SQUARE, faces=[(0, 1, 2, 3)])
    array = ob.modifiers.new("twice", "ARRAY")
    array.use_merge_vertices = True
    bpy.context.view_layer.update()
    mesh = reader(ob, "triangle").mesh
    assert len(mesh.get("triangle")) == 4
    assert mesh.bounds[1, 0] == pytest.approx(2)
    assert reader(ob, "triangle").vertices is None


def test_world_matrix_is_applied_and_the_result_lies_on_its_source(installed):
    ob = scene.add_mesh("plane", SQUARE, faces=[(0, 1, 2, 3)])
    ob.matrix_world = Matrix.Translation((5, -3, 2)) @ Matrix.Rotation(0.7, 4, "X") @ Matrix.Diagonal((3, 0.5, 2, 1))
    bpy.context.view_layer.update()
    corners = corner_set(scene.world_points(ob))
    bpy.ops.meshcore.transfinite(cells_i=2, cells_j=2)
    made = scene.active()
    assert corners <= corner_set(scene.world_points(made))
    assert made.location == ob.matrix_world.translation
    assert made.scale[:] == (1, 1, 1)


def test_far_from_the_origin_no_digits_are_lost(installed):
    ob = scene.add_mesh("plane", 1e-3 * np.array(SQUARE), faces=[(0, 1, 2, 3)])
    ob.location = (4096, 0, 0)
    bpy.context.view_layer.update()
    bpy.ops.meshcore.transfinite(cells_i=3, cells_j=3)
    local = np.array([v.co for v in scene.active().data.vertices])
    ticks = np.unique(np.round(local[:, 0] / 1e-3 * 3, 3))
    np.testing.assert_array_equal(ticks, [0, 1, 2, 3])


def test_a_mirrored_object_keeps_its_faces_outside_out(reader, core):
    points = np.array(list(itertools.product((0, 1), repeat=3)), float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    ob = scene.add_mesh("cube", points, faces=quads)

    def volume(mesh):
        a, b, c = (mesh.points[mesh.get("triangle")[:, k]] for k in range(3))
        return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6

    plain = volume(reader(ob, "triangle").mesh)
    ob.scale = (-1, 2, 3)
    bpy.context.view_layer.update()
    assert abs(plain) == pytest.approx(1)
    assert volume(reader(ob, "triangle").mesh) == pytest.approx(6 * plain)


def test_quads_stay_quads_and_larger_faces_are_triangulated(reader):
    points = [*SQUARE, (2, 0, 0), (2.5, 0.5, 0), (2, 1, 0)]
    ob = scene.add_mesh("mixed", points, faces=[(1, 4, 5, 6, 2), (0, 1, 2, 3)])
    mesh = reader(ob).mesh
    assert {kind: len(cells) for kind, cells in mesh.cells.items()} == {"triangle": 3, "quad": 1}
    assert len(reader(ob, "triangle").mesh.get("triangle")) == 5


def test_face_data_follow_the_triangles(reader):
    ob = scene.add_mesh("two", [*SQUARE, (2, 0, 0), (2, 1, 0)], faces=[(0, 1, 2, 3), (1, 4, 5, 2)])
    attribute = ob.data.attributes.new("load", "FLOAT", "FACE")
    attribute.data.foreach_set("value", [1.5, 2.5])
    mesh = reader(ob, "triangle").mesh
    left = mesh.centroids[:, 0] < 1
    np.testing.assert_array_equal(mesh.cell_data["load"], np.where(left, 1.5, 2.5))


def test_bezier_curve_at_its_resolution(reader):
    bpy.ops.curve.primitive_bezier_circle_add(radius=2)
    curve = scene.active()
    for resolution in (4, 24):
        curve.data.resolution_u = resolution
        bpy.context.view_layer.update()
        mesh = reader(curve, "line").mesh
        assert mesh.n_points == len(mesh.get("line")) == 4 * resolution
        radius = np.linalg.norm(mesh.points, axis=1)
        assert abs(radius - 2).max() < 2e-3  # a Bezier circle's own error


def test_filled_curve_gives_its_outline(reader):
    bpy.ops.curve.primitive_bezier_circle_add(radius=1)
    curve = scene.active()
    curve.data.dimensions, curve.data.fill_mode = "2D", "BOTH"
    bpy.context.view_layer.update()
    mesh = reader(curve, "line").mesh
    assert math.isclose(np.linalg.norm(mesh.points, axis=1).min(), 1, abs_tol=1e-2)
    assert (np.bincount(mesh.get("line").ravel()) == 2).all()


def test_closed_curve_through_the_operator(installed):
    bpy.ops.curve.primitive_bezier_circle_add(radius=1)
    assert bpy.ops.meshcore.transfinite(cells_i=6, cells_j=6) == {"FINISHED"}
    assert len(scene.active().data.polygons) == 36


@pytest.mark.parametrize("order", list(itertools.permutations("abc")))
def test_four_sides_in_any_order_of_names(installed, order):
    names = dict(zip(("east", "north", "west"), order, strict=True))
    south = side("south", (0, 0, 0), (3, 0, 0), 3)
    others = [
        side(names["north"], (3, 2, 0), (0, 2, 0), 3, select=False),
        side(names["east"], (3, 2, 0), (3, 0, 0), 2, select=False),
        side(names["west"], (0, 0, 0), (0, 2, 0), 2, select=False),
    ]
    scene.activate(south, *others)
    assert bpy.ops.meshcore.transfinite() == {"FINISHED"}
    made = scene.active()
    assert corner_set(scene.world_points(made)) == {(i, j, 0) for i in range(4) for j in range(3)}
    assert all(face.normal.z > 0.99 for face in made.data.polygons)


def test_all_selected_objects_make_one_boundary(installed):
    inputs = scene.addon("inputs")
    outer = scene.add_mesh("outer", SQUARE, LOOP)
    inner = scene.add_mesh("inner", 0.25 * np.array(SQUARE) + 0.3, LOOP, select=False)
    scene.activate(outer, inner)
    ports = {"boundary": {"description": "", "cells": ["line"], "optional": False}}
    mesh = inputs.gather(bpy.context, {"inputs": ports})[0].mesh
    assert len(mesh.get("line")) == 8
    assert mesh.cell_data["tag"].tolist() == [1] * 4 + [2] * 4
    np.testing.assert_allclose(mesh.points[4:], scene.world_points(inner))


# ---- four sides in one object, and corners of a loop


def straight(a, b, n=6):
    return np.linspace(a, b, n + 1)


SIDES = [straight(*ends) for ends in itertools.pairwise([*map(np.array, SQUARE), np.array(SQUARE[0])])]


def grid_corners(ob):
    """Places of the vertices that two named sides share."""
    group = {g.index: g.name for g in ob.vertex_groups}
    points = scene.world_points(ob)
    return {
        frozenset(names): tuple(np.round(points[v.index], 4) + 0.0)
        for v in ob.data.vertices
        if len(names := [group[g.group] for g in v.groups]) == 2
    }


def test_four_chains_of_edges_in_one_mesh(installed):
    points = np.concatenate(SIDES)
    scene.add_mesh("chains", points, [(k, k + 1) for k in range(27) if k % 7 != 6])
    assert bpy.ops.meshcore.elliptic() == {"FINISHED"}
    assert len(scene.active().data.polygons) == 36


def test_four_splines_in_one_curve(installed):
    data = bpy.data.curves.new("four", "CURVE")
    data.dimensions = "3D"
    for points in SIDES:
        spline = data.splines.new("POLY")
        spline.points.add(len(points) - 1)
        for point, co in zip(spline.points, points, strict=True):
            point.co = (*co, 1)
    scene.link(bpy.data.objects.new("four", data))
    assert bpy.ops.meshcore.transfinite() == {"FINISHED"}
    assert len(scene.active().data.polygons) == 36


def test_four_selected_chains_of_a_mesh(installed):
    """Rows and columns of a grid selected in Edit Mode, as far as they bound a block."""
    ob = grid_ring(6)
    ends = np.array([edge.vertices[:] for edge in ob.data.edges])
    middle = np.array([v.co for v in ob.data.vertices])[ends].mean(axis=1)[:, :2]
    inside = ((middle >= 1) & (middle <= 4)).all(axis=1) & ((middle == 1) | (middle == 4)).any(axis=1)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.object.mode_set(mode="OBJECT")
    for number in np.flatnonzero(inside):
        ob.data.edges[int(number)].select = True
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.meshcore.elliptic() == {"FINISHED"}
    made = scene.active()
    assert len(made.data.polygons) == 9
    assert set(grid_corners(made).values()) == {(1, 1, 0), (4, 1, 0), (4, 4, 0), (1, 4, 0)}


def select_vertices(ob, numbers):
    """Edit Mode, with these vertices selected and nothing else."""
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.object.mode_set(mode="OBJECT")
    for number in numbers:
        ob.data.vertices[number].select = True
    bpy.ops.object.mode_set(mode="EDIT")


@pytest.mark.parametrize("operation", ["elliptic", "transfinite"])
def test_four_selected_vertices_are_the_corners(installed, operation):
    bpy.ops.mesh.primitive_circle_add(vertices=32)
    circle = bpy.context.active_object
    chosen = (1, 9, 17, 27)
    select_vertices(circle, chosen)
    wanted = {tuple(np.round(scene.world_points(circle)[k], 4) + 0.0) for k in chosen}
    assert scene.operator(operation)(cells_i=8, cells_j=8) == {"FINISHED"}
    assert set(grid_corners(scene.active()).values()) == wanted


def test_corners_of_a_loop_are_moved_in_the_redo_panel(installed):
    bpy.ops.mesh.primitive_circle_add(vertices=32)
    circle = bpy.context.active_object
    number = {tuple(np.round(p, 4) + 0.0): k for k, p in enumerate(scene.world_points(circle))}

    def corners(**keywords):
        scene.activate(circle)
        assert bpy.ops.meshcore.elliptic(cells_i=8, cells_j=8, **keywords) == {"FINISHED"}
        return {number[at] for at in grid_corners(scene.active()).values()}

    found, moved = corners(), corners(shift_corners=(0, 1, 0, -3))
    assert np.diff(sorted(found)).tolist() == [8, 8, 8]
    assert len(found & moved) == 2
    assert sorted(abs(a - b) for a, b in zip(sorted(found - moved), sorted(moved - found), strict=True)) == [1, 3]


def test_named_sides_are_vertex_groups(installed):
    scene.activate(*[scene.add_mesh(f"side {k}", p, [(i, i + 1) for i in range(6)]) for k, p in enumerate(SIDES)])
    assert bpy.ops.meshcore.elliptic(walls="south", first_height=0.02) == {"FINISHED"}
    made = scene.active()
    assert {g.name for g in made.vertex_groups} == {"south", "east", "north", "west"}
    assert len(grid_corners(made)) == 4
