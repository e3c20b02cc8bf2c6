"""Grids on curved surfaces: a grid of quads smoothed on its own, and patches on an object chosen as surface."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from tests.blender import scene


@pytest.fixture
def gallery(core, installed):
    from meshcore import gallery

    return gallery


def sides(core, gallery):
    """The four sides of a patch of the torus as objects, and as meshcore sees them."""
    from meshcore.geometry.curves import lines_through

    meshes = [scene.rounded(lines_through(side)) for side in gallery.sides_on_torus(12, 10)]
    return [scene.from_core(f"side {k}", mesh) for k, mesh in enumerate(meshes)], meshes


def assert_is(ob, grid):
    mesh = grid.to_mesh()
    np.testing.assert_allclose(scene.world_points(ob), mesh.points, rtol=0, atol=scene.SINGLE * mesh.diagonal)
    assert scene.faces(ob) == mesh.get("quad").tolist()


def test_a_tube_of_quads_is_smoothed_on_its_own_surface(core, gallery):
    tube = scene.rounded(gallery.rough_tube(16, 8))
    ob = scene.from_core("tube", tube)
    assert bpy.ops.meshcore.elliptically_smoothed() == {"FINISHED"}
    assert scene.active() is not ob
    assert_is(scene.active(), core.elliptically_smoothed(tube).mesh)


@pytest.mark.parametrize("identifier", ["transfinite", "elliptic"])
def test_a_patch_between_curves_lies_on_a_chosen_object(core, gallery, identifier):
    objects, meshes = sides(core, gallery)
    scan = scene.rounded(gallery.bumpy_torus(48, 24))
    scene.from_core("scan", scan)
    scene.activate(*objects)
    assert scene.operator(identifier)(surface="scan") == {"FINISHED"}
    assert_is(scene.active(), core.operations()[identifier].function(*meshes, surface=scan).mesh)


def test_a_moved_surface_is_used_where_it_stands(core, gallery):
    objects, meshes = sides(core, gallery)
    scan = scene.rounded(gallery.bumpy_torus(48, 24))
    moved = scene.from_core("scan", scan.with_points(scan.points - [0, 0, 2]))
    moved.location = (0, 0, 2)
    scene.activate(*objects)
    assert bpy.ops.meshcore.elliptic(surface="scan") == {"FINISHED"}
    there = scan.with_points(scene.world_points(moved))
    assert_is(scene.active(), core.elliptic(*meshes, surface=there).mesh)


def test_a_surface_of_lines_is_refused(core, gallery):
    objects, _ = sides(core, gallery)
    scene.add_mesh("loop", [(0, 0, 0), (1, 0, 0)], [(0, 1)])
    scene.activate(*objects)
    with pytest.raises(RuntimeError, match="faces"):
        bpy.ops.meshcore.elliptic(surface="loop")
