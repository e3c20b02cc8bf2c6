"""Grids on curved surfaces: a layer of quads smoothed on its own, and patches on a layer named as surface."""

from __future__ import annotations

import numpy as np
import pytest

import meshlab_filters
from meshcore import elliptically_smoothed, gallery, operations
from meshcore.geometry.curves import lines_through
from tests.meshlab.conftest import add


def assert_is(ms, grid):
    assert np.abs(ms.current_mesh().vertex_matrix() - grid.to_mesh().points).max() < 1e-12


def test_a_tube_of_quads_is_smoothed_on_its_own_surface(ms):
    add(ms, gallery.rough_tube(16, 8), "tube")
    meshlab_filters.elliptically_smoothed(ms)
    assert_is(ms, elliptically_smoothed(gallery.rough_tube(16, 8)).mesh)


def test_a_tube_is_smoothed_on_a_named_layer(ms):
    add(ms, gallery.rough_tube(64, 24), "fine")
    tube = add(ms, gallery.rough_tube(16, 8), "tube")
    ms.set_current_mesh(tube)
    meshlab_filters.elliptically_smoothed(ms, surface="fine")
    assert_is(ms, elliptically_smoothed(gallery.rough_tube(16, 8), gallery.rough_tube(64, 24)).mesh)


@pytest.mark.parametrize("identifier", ["transfinite", "elliptic"])
def test_a_patch_between_edge_meshes_lies_on_a_layer(ms, identifier):
    sides = [lines_through(side) for side in gallery.sides_on_torus(12, 10)]
    ids = [add(ms, side, name) for side, name in zip(sides, ("south", "east", "north", "west"), strict=True)]
    add(ms, gallery.bumpy_torus(48, 24), "scan")
    ms.set_current_mesh(ids[0])
    getattr(meshlab_filters, identifier)(ms, east="east", north="north", west="west", surface="scan")
    assert_is(ms, operations()[identifier].function(*sides, surface=gallery.bumpy_torus(48, 24)).mesh)
