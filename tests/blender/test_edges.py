"""Layers off an open surface: its edges named by vertices and places, one of them on an object chosen as guide."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from tests.blender import scene


@pytest.fixture
def hub(core, installed):
    from meshcore import gallery

    return scene.rounded(gallery.hub_sector(8, 10).to_mesh())


def middle_of(mesh, turn):
    """The vertex of a straight side, halfway up."""
    place = np.array([np.cos(turn), np.sin(turn), 0.5])
    return int(np.argmin(np.linalg.norm(mesh.points - place, axis=1)))


def test_edges_are_named_and_stay_on_a_chosen_object(core, hub):
    from meshcore import gallery

    ob = scene.from_core("hub", hub)
    wall = scene.rounded(gallery.conical_wall(240).to_mesh())
    scene.from_core("wall", wall)
    scene.activate(ob)
    sides = [f"vertex {middle_of(hub, turn)} = periodic" for turn in (0.0, 0.2 * np.pi)]
    asked = {"first_height": 0.01, "layers": 6, "each_edge": ", ".join([*sides, "zmin = guide, zmax = splay 10"])}
    assert bpy.ops.meshcore.hyperbolic_volume(guide="wall", **asked) == {"FINISHED"}
    mesh, _ = core.hyperbolic_volume(hub, wall, **asked)
    found = scene.world_points(scene.active())
    np.testing.assert_allclose(found, mesh.points, rtol=0, atol=scene.SINGLE * mesh.diagonal)
    layers = found.reshape(7, -1, 3)
    foot = layers[:, hub.points[:, 2] == 0]
    assert np.abs(foot[..., 2] - 0.4 * (1 - np.hypot(foot[..., 0], foot[..., 1]))).max() < 1e-3
    turn = np.array([[np.cos(0.2 * np.pi), np.sin(0.2 * np.pi), 0], [-np.sin(0.2 * np.pi), np.cos(0.2 * np.pi), 0]])
    first, last = (layers[:, middle_of(hub, angle)] for angle in (0.0, 0.2 * np.pi))
    np.testing.assert_allclose(first @ np.array([*turn, [0, 0, 1]]), last, atol=1e-5)


def test_layers_end_on_a_chosen_object(core, installed):
    from meshcore import gallery

    ball, far = (scene.rounded(gallery.bumpy_ball(n, bump=bump)) for n, bump in ((162, 0.1), (642, 0.0)))
    far = scene.rounded(far.with_points(3 * far.points))
    ob = scene.from_core("ball", ball)
    scene.from_core("far", far)
    scene.activate(ob)
    assert bpy.ops.meshcore.hyperbolic_volume(outer="far", first_height=0.05, layers=8) == {"FINISHED"}
    mesh, _ = core.hyperbolic_volume(ball, outer=far, first_height=0.05, layers=8)
    found = scene.world_points(scene.active())
    np.testing.assert_allclose(found, mesh.points, rtol=0, atol=scene.SINGLE * mesh.diagonal)
    radius = np.linalg.norm(found.reshape(9, -1, 3)[-1], axis=1)
    assert radius.min() > 2.9 and radius.max() < 3.0 + 1e-5


def test_names_that_are_none_are_told(hub):
    scene.from_core("hub", hub)
    with pytest.raises(RuntimeError, match="no edge is called 'top'"):
        bpy.ops.meshcore.hyperbolic_volume(each_edge="top = plane")
