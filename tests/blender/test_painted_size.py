"""Refinement with sizes painted on the outline, or on a second object chosen as background."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from tests.blender import scene

SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
SIDES = [(0, 1), (1, 2), (2, 3), (3, 0)]


def paint(ob, name, sizes):
    ob.data.attributes.new(name, "FLOAT", "POINT").data.foreach_set("value", np.asarray(sizes, np.float32))
    return ob


def longest_edges(ob):
    """Middle of each triangle of an object, and its longest edge."""
    corners = scene.world_points(ob)[np.array(scene.faces(ob))]
    return corners.mean(axis=1), np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)


def assert_sizes_follow(ob, wanted):
    """Edges are at most as long as wanted, and not everywhere much shorter."""
    middle, longest = longest_edges(ob)
    share = longest / wanted(middle)
    assert share.max() < 1 + 1e-4
    assert np.median(share) > 0.45


@pytest.fixture
def outline(installed):
    return paint(scene.add_mesh("outline", SQUARE, SIDES), "size", [0.02, 0.2, 0.2, 0.02])


def test_vertex_attribute_of_the_outline(outline):
    assert bpy.ops.meshcore.delaunay_refinement(size_array="size") == {"FINISHED"}
    assert_sizes_follow(scene.active(), lambda p: 0.02 + 0.18 * p[:, 0])
    middle, longest = longest_edges(scene.active())
    assert longest[middle[:, 0] > 0.8].max() > 3 * longest[middle[:, 0] < 0.2].max()


def test_vertex_attribute_of_a_background_object(outline):
    corners = [(-1, -1, 0.5), (3, -1, 0.5), (-1, 3, 0.5)]  # above the plane of the outline: its shadow counts
    background = paint(scene.add_mesh("sizes", corners, [], [(0, 1, 2)]), "h", [0.02, 0.22, 0.02])
    scene.activate(outline, background)
    assert bpy.ops.meshcore.delaunay_refinement(background="sizes", size_array="h") == {"FINISHED"}
    assert_sizes_follow(scene.active(), lambda p: 0.02 + 0.05 * (p[:, 0] + 1))


def test_a_moved_background_of_quads_and_the_only_array(outline):
    corners = [(-1, 0, 0), (1, 0, 0), (1, 1, 0), (-1, 1, 0)]
    background = paint(scene.add_mesh("sizes", corners, [], [(0, 1, 2, 3)]), "h", [0.02, 0.22, 0.22, 0.02])
    background.location = (1, 0, 0)  # from x = 0 to x = 2
    scene.activate(outline)
    assert bpy.ops.meshcore.delaunay_refinement(background="sizes") == {"FINISHED"}
    assert_sizes_follow(scene.active(), lambda p: 0.02 + 0.1 * p[:, 0])


def test_outline_and_hole_painted_alike_are_joined_with_their_sizes(outline):
    hole = paint(
        scene.add_mesh("hole", [(x * 0.2 + 0.4, y * 0.2 + 0.4, 0) for x, y, _ in SQUARE], SIDES), "size", [0.03] * 4
    )
    scene.activate(outline, hole)
    assert bpy.ops.meshcore.delaunay_refinement(size_array="size", gradation=0.3) == {"FINISHED"}
    middle, longest = longest_edges(scene.active())
    beside = np.abs(middle[:, :2] - 0.5).max(axis=1) < 0.12
    assert beside.any() and longest[beside].max() < 0.04


def test_a_weight_painted_vertex_group_is_a_size_in_blender_units(outline):
    """Vertices outside the group take its largest weight."""
    corners = [(-1, -1, 0), (3, -1, 0), (3, 3, 0), (-1, 3, 0)]
    background = scene.add_mesh("sizes", corners, [], [(0, 1, 2), (0, 2, 3)])
    group = background.vertex_groups.new(name="painted")
    group.add([0, 3], 0.03, "REPLACE")
    group.add([1], 0.23, "REPLACE")
    scene.activate(outline)
    assert bpy.ops.meshcore.delaunay_refinement(background="sizes", size_array="painted") == {"FINISHED"}
    assert_sizes_follow(scene.active(), lambda p: 0.03 + 0.05 * (p[:, 0] + 1))
    group = outline.vertex_groups.new(name="painted")
    group.add([0, 3], 0.02, "REPLACE")
    group.add([1, 2], 0.2, "REPLACE")
    scene.activate(outline)
    assert bpy.ops.meshcore.delaunay_refinement(size_array="painted") == {"FINISHED"}
    assert_sizes_follow(scene.active(), lambda p: 0.02 + 0.18 * p[:, 0])
    properties = scene.addon("properties")
    scene.activate(outline)
    assert properties._attribute_names(None, bpy.context, "") == ["size", "painted"]


@pytest.mark.parametrize(
    "keywords, message",
    [
        ({"size_array": "heat"}, "no point array 'heat'.* there are: size"),
        ({"background": "nothing"}, "there is no object 'nothing'"),
        ({"background": "outline"}, "outline is the active object and chosen by name"),
        ({"background": "unpainted"}, "name the point array .* there are: none"),
    ],
)
def test_what_is_missing_is_named(outline, keywords, message):
    scene.add_mesh("unpainted", SQUARE, [], [(0, 1, 2, 3)], select=False)
    with pytest.raises(RuntimeError, match=message):
        bpy.ops.meshcore.delaunay_refinement(**keywords)
    assert scene.names() == {"outline", "unpainted"}


def test_a_size_of_zero_is_refused_and_its_vertex_selected(installed):
    ob = paint(scene.add_mesh("outline", SQUARE, SIDES), "size", [0.1, 0.1, 0, 0.1])
    with pytest.raises(RuntimeError, match=r"is 0 at point 2, \(1, 1, 0\).*1 vertex selected on outline"):
        bpy.ops.meshcore.delaunay_refinement(size_array="size")
    assert [v.select for v in ob.data.vertices] == [False, False, True, False]


def test_the_search_offers_both_objects_arrays_and_meshes_with_faces(outline):
    properties = scene.addon("properties")
    paint(scene.add_mesh("sizes", SQUARE, [], [(0, 1, 2, 3)], select=False), "h", [1] * 4)

    class Shown:
        background = "sizes"

    assert properties._attribute_names(Shown(), bpy.context, "") == ["size", "h"]
    assert properties._objects_with_faces(None, bpy.context, "") == ["sizes"]
