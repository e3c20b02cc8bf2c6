"""Mesh: what the constructor refuses, and the new meshes made from old ones."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from meshcore import InvalidGeometry, InvalidInput, Mesh, gallery
from meshcore.mesh import BY_VTK, CELL_TYPES

SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]


def two_triangles(**more) -> Mesh:
    return Mesh(SQUARE, {"triangle": [[0, 1, 2], [0, 2, 3]]}, **more)


def test_planar_points_get_a_third_coordinate_and_arrays_one_form():
    mesh = two_triangles()
    assert mesh.points.shape == (4, 3) and mesh.points.dtype == np.float64 and mesh.is_planar
    assert mesh.cells["triangle"].dtype == np.int64 and mesh.cells["triangle"].flags.c_contiguous


@pytest.mark.parametrize(
    ("points", "cells", "error", "text"),
    [
        ([[0, 0], [np.nan, 1]], {}, InvalidGeometry, r"points: point 1 is \[nan, 1.0\]"),
        ([[0, 0], [np.inf, 1]], {}, InvalidGeometry, "not finite"),
        ([0, 1, 2], {}, InvalidInput, r"points: needs shape \(n, 3\)"),
        ([[0, 1, 2, 3]], {}, InvalidInput, r"got \(1, 4\)"),
        ([["a", "b"]], {}, InvalidInput, "needs real numbers"),
        ([[1, 2], [3]], {}, InvalidInput, "needs real numbers"),
        ([[1, 2j]], {}, InvalidInput, "needs real numbers"),
        (SQUARE, {"triangel": [[0, 1, 2]]}, InvalidInput, "unknown kind of cell"),
        (SQUARE, {"triangle": [[0, 1]]}, InvalidInput, r"needs shape \(m, 3\), got \(1, 2\)"),
        (SQUARE, {"triangle": [[0, 1, 2.5]]}, InvalidInput, "whole numbers"),
        (SQUARE, {"triangle": [[0, 1, 4]]}, InvalidGeometry, r"cell 0 has nodes \[0, 1, 4\].*from 0 to 3"),
        (SQUARE, {"triangle": [[0, 1, 2], [0, -1, 2]]}, InvalidGeometry, "cell 1"),
        ([], {"line": [[0, 1]]}, InvalidGeometry, "cell 0"),
    ],
)
def test_what_the_constructor_refuses(points, cells, error, text):
    with pytest.raises(error, match=text):
        Mesh(points, cells)


def test_faults_carry_their_places():
    with pytest.raises(InvalidGeometry) as caught:
        Mesh([[0, 0], [np.nan, 0], [0, 0], [0, np.inf]], {})
    assert caught.value.points == (1, 3)
    with pytest.raises(InvalidGeometry) as caught:
        Mesh(SQUARE, {"line": [[0, 1], [1, 9], [2, 8]]})
    assert caught.value.cells == (1, 2)


def test_data_must_fit():
    with pytest.raises(InvalidInput, match=r"point_data\['t'\]: needs one value per point, that is 4"):
        two_triangles(point_data={"t": [1, 2]})
    with pytest.raises(InvalidInput, match=r"cell_data\['t'\]: needs one value per cell, that is 2"):
        two_triangles(cell_data={"t": np.zeros((3, 2))})
    with pytest.raises(InvalidInput, match=r"sets\['wall'\]"):
        two_triangles(sets={"wall": [2]})


def test_nothing_at_all_is_a_mesh():
    empty = Mesh([], {})
    assert (empty.n_points, empty.n_cells, empty.dimension, empty.diagonal) == (0, 0, 0, 0.0)
    assert empty.boundary.n_cells == 0 and len(empty.edges) == 0 and empty.centroids.shape == (0, 3)


def test_a_change_is_a_new_mesh():
    mesh = two_triangles()
    with pytest.raises(AttributeError):
        mesh.points = np.zeros((4, 3))
    more = mesh.with_cell_data(tag=[1, 2]).with_point_data(height=np.arange(4.0))
    assert not mesh.cell_data and not mesh.point_data
    assert more.cell_data["tag"].tolist() == [1, 2] and more.point_data["height"].tolist() == [0, 1, 2, 3]


def test_cells_are_numbered_through_all_kinds():
    mesh = Mesh(SQUARE, {"line": [[0, 1]], "triangle": [[0, 1, 2], [0, 2, 3]], "vertex": [[3]]})
    assert [(kind, where.start, where.stop) for kind, _, where in mesh.blocks()] == [
        ("line", 0, 1),
        ("triangle", 1, 3),
        ("vertex", 3, 4),
    ]
    assert mesh.dimension == 2 and len(mesh.centroids) == 4
    assert np.allclose(mesh.centroids[0], [0.5, 0, 0])


def test_selecting_renumbers_points_data_and_sets():
    mesh = two_triangles(
        cell_data={"tag": [7, 8]}, point_data={"x": [0, 1, 2, 3]}, sets={"a": [0, 1], "b": [0], "c": [1]}
    )
    chosen = mesh.selected([1])
    assert chosen.cells["triangle"].tolist() == [[0, 1, 2]]
    assert chosen.point_data["x"].tolist() == [0, 2, 3] and chosen.cell_data["tag"].tolist() == [8]
    assert {k: v.tolist() for k, v in chosen.sets.items()} == {"a": [0], "b": [], "c": [0]}
    assert mesh.selected(np.array([False, True])).points.tolist() == chosen.points.tolist()


def test_a_mirror_image_keeps_cells_positive():
    mesh = two_triangles()
    mirrored = mesh.transformed(np.diag([-1.0, 1, 1, 1]))
    assert mirrored.cells["triangle"].tolist() == [[0, 2, 1], [0, 3, 2]]
    shifted = np.eye(4)
    shifted[:3, 3] = 1, 2, 3
    assert np.allclose(mesh.transformed(shifted).points, mesh.points + [1, 2, 3])


@given(arrays(float, (4, 4), elements=st.floats(-3, 3)))
def test_transforming_scales_the_signed_area_of_each_triangle(matrix):
    matrix[2:] = [0, 0, 1, 0], [0, 0, 0, 1]
    matrix[:2, 2] = 0
    mesh = gallery.triangulated_square(2)
    before, after = signed_areas(mesh), signed_areas(mesh.transformed(matrix))
    (a, b), (c, d) = matrix[:2, :2]
    assert np.allclose(after, before * abs(a * d - b * c), atol=1e-9)


def signed_areas(mesh: Mesh) -> np.ndarray:
    a, b, c = (mesh.points[mesh.cells["triangle"][:, k]] for k in range(3))
    return np.cross(b - a, c - a)[:, 2] / 2


def test_compacting_drops_only_points_without_cells():
    mesh = Mesh([[9, 9], *SQUARE], {"triangle": [[1, 2, 3]]}, point_data={"k": np.arange(5)})
    assert mesh.compacted().point_data["k"].tolist() == [1, 2, 3]
    assert two_triangles().compacted().n_points == 4


def test_numbers_of_vtk_are_unique_and_facets_lie_within_their_cell():
    assert len(BY_VTK) == len(CELL_TYPES)
    for kind in CELL_TYPES.values():
        for facet in (*kind.facets, *kind.edges):
            assert max(facet) < kind.nodes
