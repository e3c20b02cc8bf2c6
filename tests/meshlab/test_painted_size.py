"""Refinement and curves by sizes in a layer's vertex scalars (MeshLab's quality) or custom vertex attributes."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest

import meshlab_filters
from meshcore import Mesh, delaunay_refinement, discretised, gallery
from tests.meshlab.conftest import add

BIG = Mesh([[-1, -1], [4, -1], [-1, 4]], {"triangle": [[0, 1, 2]]}, {"h": np.array([0.04, 0.29, 0.04])})


def assert_same(ms, expected):
    made = ms.current_mesh()
    assert (made.face_matrix() == expected.cells["triangle"]).all()
    assert np.abs(made.vertex_matrix() - expected.points).max() < 1e-12


def add_with_quality(ms, mesh, low, slope, label):
    """Add a layer whose vertices carry quality, as MeshLab's own filters compute and paint it."""
    add(ms, Mesh(mesh.points, mesh.cells), label)
    ms.compute_scalar_by_function_per_vertex(q=f"{low} + {slope} * x")
    assert np.allclose(ms.current_mesh().vertex_scalar_array(), low + slope * mesh.points[:, 0])


def test_custom_attribute_of_a_background_layer(ms):
    outline = add(ms, gallery.square_with_hole(), "outline")
    add(ms, BIG, "sizes")
    ms.set_current_mesh(outline)
    meshlab_filters.delaunay_refinement(ms, background="sizes", size_array="h")
    assert_same(ms, delaunay_refinement(gallery.square_with_hole(), BIG, size_array="h").mesh)


@pytest.mark.parametrize("name", ["vertex_scalar", ""], ids=["named", "the only one"])
def test_quality_of_a_background_layer(ms, name):
    outline = add(ms, gallery.square_with_hole(), "outline")
    add_with_quality(ms, BIG, 0.09, 0.05, "sizes")
    ms.set_current_mesh(outline)
    meshlab_filters.delaunay_refinement(ms, background="sizes", size_array=name)
    sizes = BIG.with_point_data(h=0.09 + 0.05 * BIG.points[:, 0])
    expected = delaunay_refinement(gallery.square_with_hole(), sizes, size_array="h").mesh
    assert abs(ms.current_mesh().face_number() / expected.n_cells - 1) < 0.01  # the formula is evaluated by MeshLab


def test_quality_of_the_outline_of_faces(ms):
    add_with_quality(ms, gallery.triangulated_square(4), 0.05, 0.2, "patch")
    result = meshlab_filters.delaunay_refinement(ms, size_array="vertex_scalar", gradation=0.5)
    triangles = ms.current_mesh().vertex_matrix()[ms.current_mesh().face_matrix()]
    longest = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max(axis=1)
    wanted = 0.05 + 0.2 * triangles.mean(axis=1)[:, 0]
    assert result["converged"] == 1
    assert (longest <= wanted * (1 + 1e-6)).all() and np.median(longest / wanted) > 0.5


def test_attribute_of_the_outline_of_lines(ms):
    square = gallery.square(2)
    square = square.with_point_data(h=0.05 + 0.2 * square.points[:, 1])
    add(ms, square, "outline")
    meshlab_filters.delaunay_refinement(ms, size_array="h")
    assert_same(ms, delaunay_refinement(square, size_array="h").mesh)


def test_a_curve_is_divided_by_a_layer_of_sizes(ms):
    outline = add(ms, gallery.square_with_hole(), "outline")
    add(ms, BIG, "sizes")
    ms.set_current_mesh(outline)
    result = meshlab_filters.discretised(ms, background="sizes", size_array="h")
    expected, _ = discretised(gallery.square_with_hole(), BIG, size_array="h")
    assert result["lines"] == expected.n_cells == ms.current_mesh().edge_number()
    assert np.abs(ms.current_mesh().vertex_matrix() - expected.points).max() < 1e-12


@pytest.mark.parametrize(
    "keywords, message",
    [
        ({"size_array": "heat"}, "no point array 'heat'"),
        ({"background": "sizes", "size_array": "heat"}, "no point array 'heat'"),
        ({"background": "nowhere"}, "background: no layer with the id or label 'nowhere'"),
        ({"background": "outline", "size_array": "h"}, "this filter needs triangle or quad cells"),
        ({"background": "zero", "size_array": "h"}, "'h' is 0 at point 1"),
    ],
)
def test_what_is_missing_or_wrong_is_named(ms, keywords, message):
    outline = add(ms, gallery.square(), "outline")
    add(ms, BIG, "sizes")
    add(ms, BIG.with_point_data(h=np.array([1.0, 0, 1])), "zero")
    ms.set_current_mesh(outline)
    with pytest.raises(pymeshlab.PyMeshLabException, match=message):
        meshlab_filters.delaunay_refinement(ms, **keywords)
    assert ms.mesh_number() == 3
