"""Input that no operator can use: one plain line for the user, the scene as it was, never a crash."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from tests.blender import scene

SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
LOOP = [(0, 1), (1, 2), (2, 3), (3, 0)]


def refused(match, **keywords):
    """The operator fails with one line that matches, and makes nothing."""
    before = scene.names()
    with pytest.raises(RuntimeError, match=match) as caught:
        bpy.ops.meshcore.transfinite(**keywords)
    assert "Traceback" not in str(caught.value)
    assert scene.names() == before
    return str(caught.value)


def test_nothing_active(installed):
    refused("Select 4 curves .*south, east, north, west.* or one closed curve")
    assert not bpy.ops.meshcore.transfinite.poll()


@pytest.mark.parametrize(("kind", "word"), [("camera_add", "camera"), ("light_add", "light"), ("empty_add", "empty")])
def test_objects_without_geometry(installed, kind, word):
    getattr(bpy.ops.object, kind)()
    refused(rf"\({word}\) has no lines or faces; select 4 curves")


def test_empty_mesh(installed):
    scene.add_mesh("nothing", [])
    refused("nothing has no edges; give a curve")


def test_points_without_edges(installed):
    scene.add_mesh("cloud", SQUARE)
    refused("cloud has no edges")


def test_empty_curve(installed):
    scene.link(bpy.data.objects.new("empty curve", bpy.data.curves.new("empty curve", "CURVE")))
    refused("empty curve (is empty|has no edges)")


def test_closed_surface_has_no_boundary(installed):
    bpy.ops.mesh.primitive_cube_add()
    refused("Cube is closed .* Edit Mode")


def test_open_chain(installed):
    scene.add_mesh("chain", SQUARE, LOOP[:3])
    refused("is open")


def test_open_chain_selects_its_ends(installed):
    ob = scene.add_mesh("chain", SQUARE, LOOP[:3])
    assert "2 vertices selected on chain" in refused("is open")
    assert [v.select for v in ob.data.vertices] == [True, False, False, True]


def test_open_chain_whose_edges_are_in_no_order(installed):
    ob = scene.add_mesh("chain", SQUARE, [(3, 0), (1, 2), (0, 1)])
    assert "2 vertices selected on chain" in refused("is open")
    assert [v.select for v in ob.data.vertices] == [False, False, True, True]


def test_fault_of_one_side_is_marked_on_that_side(installed):
    south = scene.add_mesh("south", [(0, 0, 0), (1, 0, 0)], [(0, 1)])
    points = [(1, 0, 0), (1, 0.4, 0), (1, 0.6, 0), (1, 1, 0)]
    east = scene.add_mesh("east", points, [(0, 1), (2, 3)], select=False)
    north = scene.add_mesh("north", [(0, 1, 0), (1, 1, 0)], [(0, 1)], select=False)
    west = scene.add_mesh("west", [(0, 0, 0), (0, 1, 0)], [(0, 1)], select=False)
    scene.activate(south, east, north, west)
    assert "4 vertices selected on" in refused("one chain")
    assert [sum(v.select for v in ob.data.vertices) for ob in (south, east, north, west)].count(4) == 1
    assert all(v.select for v in east.data.vertices)


def test_open_chain_in_edit_mode_selects_its_ends(installed):
    ob = scene.add_mesh("chain", SQUARE, LOOP[:3])
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    refused("is open")
    assert ob.mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    assert [v.select for v in ob.data.vertices] == [True, False, False, True]


def test_two_objects_for_four_sides(installed):
    one = scene.add_mesh("one", SQUARE[:2], [(0, 1)])
    two = scene.add_mesh("two", SQUARE[2:], [(0, 1)], select=False)
    scene.activate(one, two)
    refused("2 objects are selected; select 4 curves")


def test_sides_that_do_not_meet(installed):
    sides = [scene.add_mesh(str(k), np.array([[0, k, 0], [1, k, 0]]), [(0, 1)], select=False) for k in range(4)]
    scene.activate(*sides)
    refused("apart")


def test_two_loops_for_one(installed):
    points = np.concatenate([SQUARE, np.array(SQUARE) + 3])
    scene.add_mesh("two loops", points, LOOP + [(a + 4, b + 4) for a, b in LOOP])
    refused("one closed loop")


@pytest.mark.parametrize("bad", [float("nan"), float("inf")])
def test_coordinates_that_are_no_numbers(installed, bad):
    ob = scene.add_mesh("broken", SQUARE, LOOP)
    points = np.array(SQUARE, np.float32)
    points[2, 1] = bad
    ob.data.vertices.foreach_set("co", points.ravel())  # which checks nothing
    assert "(1 vertex selected on broken)" in refused("broken: .*nan|inf")
    assert [v.select for v in ob.data.vertices] == [False, False, True, False]


def test_scale_of_zero(installed):
    ob = scene.add_mesh("flat", SQUARE, LOOP)
    ob.scale = (0, 0, 0)
    bpy.context.view_layer.update()
    refused(".")


def test_hidden_object(installed):
    ob = scene.add_mesh("hidden", SQUARE, LOOP)
    ob.hide_set(True)
    refused("hidden is hidden; show it first")


def test_object_in_a_hidden_collection(installed):
    ob = scene.add_mesh("away", SQUARE, LOOP)
    collection = bpy.data.collections.new("closed")
    bpy.context.scene.collection.children.link(collection)
    collection.objects.link(ob)
    bpy.context.scene.collection.objects.unlink(ob)
    scene.activate(ob)
    collection.hide_viewport = True
    bpy.context.view_layer.update()
    refused("away is hidden; show it first|Select 4 curves")


def test_sculpt_mode(installed):
    scene.add_mesh("clay", SQUARE, faces=[(0, 1, 2, 3)])
    bpy.ops.object.mode_set(mode="SCULPT")
    try:
        refused("Go to Object Mode or Edit Mode first")
    finally:
        bpy.ops.object.mode_set(mode="OBJECT")


def test_corners_beyond_the_loop(installed):
    scene.add_mesh("square", SQUARE, LOOP)
    refused("corners: needs four different points", corners=(0, 1, 2, 99))


def test_a_non_planar_loop_is_a_patch_in_space(installed):
    scene.add_mesh("warped", np.array(SQUARE) + [[0, 0, 0], [0, 0, 1], [0, 0, 0], [0, 0, 1]], LOOP)
    assert bpy.ops.meshcore.transfinite(cells_i=4, cells_j=4) == {"FINISHED"}
    assert np.ptp(scene.world_points(scene.active())[:, 2]) == pytest.approx(1)


def test_thousands_of_edges(installed):
    n = 5000
    angle = 2 * np.pi * np.arange(n) / n
    points = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    scene.add_mesh("circle", points, [(k, (k + 1) % n) for k in range(n)])
    assert bpy.ops.meshcore.transfinite(cells_i=40, cells_j=40) == {"FINISHED"}
    assert len(scene.active().data.polygons) == 1600


def test_what_nobody_foresaw_is_reported_with_its_place_in_the_console(installed, monkeypatch, capfd):
    scene.add_mesh("square", SQUARE, LOOP)
    inputs = scene.addon("inputs")

    def broken(*arguments):
        raise ZeroDivisionError("a fault of ours")

    monkeypatch.setattr(inputs, "gather", broken)
    refused("Unexpected ZeroDivisionError: a fault of ours; the console shows where")
    assert "Traceback" in capfd.readouterr().err


def test_errors_in_another_objects_collection_leave_mode_and_selection(installed):
    one = scene.add_mesh("one", SQUARE, LOOP[:3])
    other = scene.add_mesh("other", SQUARE, LOOP, select=False)
    scene.activate(one)
    refused("is open")
    assert scene.active() == one
    assert not other.select_get()


def test_a_gap_between_sides_is_marked(installed):
    ends = [((0, 0, 0), (1, 0, 0)), ((1, 0.2, 0), (1, 1, 0)), ((0, 1, 0), (1, 1, 0)), ((0, 0, 0), (0, 1, 0))]
    sides = [scene.add_mesh(f"side {k}", pair, [(0, 1)], select=False) for k, pair in enumerate(ends)]
    scene.activate(*sides)
    assert "apart at (1, 0, 0)" in refused("1 vertex selected on side 0")
    assert [v.select for v in sides[0].data.vertices] == [False, True]


def test_the_place_where_sides_cross_is_marked(installed):
    """The ends of the line of the named side that the other one crosses."""
    points = [(k / 4, 1.2 if k == 2 else 0.0, 0) for k in range(5)]
    south = scene.add_mesh("floor", points, [(k, k + 1) for k in range(4)], select=False)
    ends = [((1, 0, 0), (1, 1, 0)), ((0, 1, 0), (1, 1, 0)), ((0, 0, 0), (0, 1, 0))]
    others = [scene.add_mesh(f"side {k}", pair, [(0, 1)], select=False) for k, pair in enumerate(ends)]
    scene.activate(south, *others)
    assert "crosses" in refused("2 vertices selected on (floor|side 1)", cells_i=8, cells_j=4)
