"""Layers off an open surface: its edges named by vertices and places, one of them on a layer named as guide."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest

import meshlab_filters
from meshcore import gallery, hyperbolic_volume
from tests.meshlab.conftest import add


def asked_of(mesh):
    """Conditions of a sector of a hub, whose straight sides are found by a vertex halfway up."""
    places = [[np.cos(turn), np.sin(turn), 0.5] for turn in (0.0, 0.2 * np.pi)]
    vertices = [int(np.argmin(np.linalg.norm(mesh.points - place, axis=1))) for place in places]
    return ", ".join([f"vertex {k} = periodic" for k in vertices] + ["zmin = guide", "zmax = splay 10"])


def test_edges_are_named_and_stay_on_a_layer(ms):
    mesh, wall = gallery.hub_sector(8, 10).to_mesh(), gallery.conical_wall(240).to_mesh()
    add(ms, wall, "wall")
    ms.set_current_mesh(add(ms, mesh, "hub"))
    asked = {"first_height": 0.01, "layers": 6, "each_edge": asked_of(mesh)}
    made = meshlab_filters.hyperbolic_volume(ms, guide="wall", **asked).mesh
    expected, _ = hyperbolic_volume(mesh, wall, **asked)
    np.testing.assert_allclose(made.points, expected.points, rtol=0, atol=1e-5)
    foot = made.points.reshape(7, -1, 3)[:, mesh.points[:, 2] == 0]
    assert np.abs(foot[..., 2] - 0.4 * (1 - np.hypot(foot[..., 0], foot[..., 1]))).max() < 1e-3


def test_layers_end_on_a_named_layer(ms):
    ball, far = gallery.bumpy_ball(162), gallery.bumpy_ball(642, bump=0.0)
    far = far.with_points(3 * far.points)
    add(ms, far, "far")
    ms.set_current_mesh(add(ms, ball, "ball"))
    made = meshlab_filters.hyperbolic_volume(ms, outer="far", first_height=0.05, layers=8).mesh
    expected, _ = hyperbolic_volume(ball, outer=far, first_height=0.05, layers=8)
    np.testing.assert_allclose(made.points, expected.points, rtol=0, atol=1e-5)
    radius = np.linalg.norm(made.points.reshape(9, -1, 3)[-1], axis=1)
    assert radius.min() > 2.9 and radius.max() < 3.0 + 1e-5


def test_names_that_are_none_are_told(ms):
    add(ms, gallery.hub_sector(8, 10).to_mesh(), "hub")
    with pytest.raises(pymeshlab.PyMeshLabException, match="no edge is called 'top'"):
        meshlab_filters.hyperbolic_volume(ms, each_edge="top = plane")


def test_sides_of_layers_are_selected_by_their_names(ms):
    ms.set_current_mesh(add(ms, gallery.hub_sector(4, 6).to_mesh(), "hub"))
    made = meshlab_filters.hyperbolic_volume(ms, first_height=0.01, layers=3, edges="free")
    counts = {"wall": 24, "outer": 24, "zmin": 12, "zmax": 12}
    assert {name: len(made.mesh.sets[name]) for name in counts} == counts
    layer = ms.current_mesh()
    for name, count in counts.items():
        ms.compute_selection_by_condition_per_face(condselect=f"set_{name} == 1")
        assert layer.selected_face_number() == 2 * count  # triangles of quads
    z = layer.vertex_matrix()[layer.face_matrix()[layer.face_custom_scalar_attribute_array("set_zmin") > 0]][..., 2]
    assert abs(z).max() < 0.1
