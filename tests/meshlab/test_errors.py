"""Awkward and wrong input: a PyMeshLabException with meshcore's message, and the MeshSet as it was."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest

import meshlab_filters
from meshcore import Mesh, gallery, operations
from tests.meshlab.conftest import add, faces_layer

MAKES_ITS_OWN = {name for name, operation in operations().items() if not operation.inputs}
NEED_A_LAYER = [name for name in meshlab_filters.filter_list() if name not in MAKES_ITS_OWN]
NEED_CELLS = [n for n in NEED_A_LAYER if n not in operations() or next(iter(operations()[n].inputs.values())).cells]

SQUARE = gallery.square(4)


def refused(ms, match, name, *arguments, **keywords):
    layers = [(mesh.id(), mesh.vertex_number(), mesh.face_number()) for mesh in ms]
    with pytest.raises(pymeshlab.PyMeshLabException, match=match) as error:
        getattr(meshlab_filters, name)(ms, *arguments, **keywords)
    assert str(error.value).startswith(f"{name}: ")
    assert [(mesh.id(), mesh.vertex_number(), mesh.face_number()) for mesh in ms] == layers


@pytest.mark.parametrize("name", NEED_A_LAYER)
def test_without_layers(ms, name):
    refused(ms, "no layers", name)


@pytest.mark.parametrize("name", NEED_CELLS)
def test_a_layer_of_points_alone(ms, name):
    ms.add_mesh(pymeshlab.Mesh(vertex_matrix=np.eye(3)), "cloud")
    refused(ms, "neither edges nor faces|no cells|no faces|needs at least four different points", name)


@pytest.mark.parametrize("name", meshlab_filters.filter_list())
def test_what_is_no_mesh_set(name):
    with pytest.raises(pymeshlab.PyMeshLabException, match=r"needs a pymeshlab\.MeshSet, got str"):
        getattr(meshlab_filters, name)("square.ply")


def test_a_layer_whose_faces_were_all_deleted(ms):
    ms.create_sphere()
    ms.set_selection_all()
    ms.meshing_remove_selected_vertices_and_faces()
    refused(ms, "has 0 vertices, but neither edges nor faces", "delaunay_refinement")
    refused(ms, "no cells", "refined")


def test_lines_where_faces_are_needed_and_a_closed_surface_where_lines_are(ms):
    add(ms, SQUARE, "square")
    refused(ms, "'square' has 16 line; this filter needs triangle cells", "refined")
    ms.create_sphere()
    refused(ms, "closed: it has no boundary edges", "delaunay_refinement")


def test_a_loop_that_is_not_planar(ms):
    bent = SQUARE.with_points(SQUARE.points + SQUARE.points[:, [0]] ** 2 * [[0, 0, 0.5]])
    add(ms, bent, "bent")
    refused(ms, "plan", "delaunay_refinement")


def test_two_pieces_where_one_chain_is_needed(ms):
    add(ms, gallery.joined(SQUARE, SQUARE.with_points(SQUARE.points + [3, 0, 0])), "two")
    refused(ms, "needs one closed loop or four chains of line cells, got 2", "transfinite")


def test_an_open_polyline(ms):
    add(ms, Mesh([[0, 0], [1, 0], [1, 1]], {"line": [[0, 1], [1, 2]]}), "open")
    refused(ms, "open", "transfinite")
    refused(ms, ".", "delaunay_refinement")


def test_points_that_are_no_numbers(ms):
    ms.add_mesh(
        pymeshlab.Mesh(np.array([[0, 0, np.nan], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]], np.int32)), "nan"
    )
    for name in ("refined", "delaunay_refinement", "compute_quality_per_face"):
        refused(ms, "not finite", name)


def test_wrong_types_and_values_name_the_parameter(ms):
    add(ms, SQUARE, "square")
    refused(ms, "min_angle: needs a number, got 'steep'", "delaunay_refinement", min_angle="steep")
    refused(ms, "min_angle: must be at most", "delaunay_refinement", min_angle=80)
    refused(ms, "size: ", "delaunay_refinement", size="big")
    refused(ms, "size: must be greater than zero", "delaunay_refinement", size=pymeshlab.PercentageValue(0))
    refused(ms, "cells_i: needs a whole number, got 2.5", "transfinite", cells_i=2.5)
    refused(ms, "attributes: needs names", "delaunay_refinement", attributes=(3,))


def test_unknown_names_say_what_is_near(ms):
    add(ms, SQUARE, "square")
    refused(ms, "min_angel: is no parameter of this filter; did you mean min_angle", "delaunay_refinement", min_angel=3)
    refused(ms, "'beauty' is no quality measure", "delaunay_refinement", measure="beauty")
    refused(ms, "east: no layer with the id or label 'nowhere'; there are 0 'square'", "transfinite", east="nowhere")
    refused(ms, "north: no layer with the id or label 99", "transfinite", east=0, north=99, west=0)
    add(ms, SQUARE, "square")
    ms.current_mesh().set_label("square")
    refused(ms, "2 layers with the id or label 'square'", "transfinite", east="square")


def test_unknown_attributes(ms):
    add(ms, gallery.triangulated_square(), "plate")
    refused(ms, "has no attribute 'pressure'", "refined", indicator="pressure")
    refused(ms, "has no attribute 'pressure'", "refined", attributes=("front", "pressure"))


def test_quality_filters_refuse_what_they_cannot_measure(ms):
    add(ms, SQUARE, "square")
    refused(ms, "has no faces", "compute_quality_per_face")
    ms.add_mesh(faces_layer(gallery.triangulated_square()), "plate")
    refused(ms, "'beauty' is no measure", "compute_quality_per_face", measure="beauty")
    refused(ms, "maximum: needs a number", "select_faces_by_quality", maximum="high")
    pentagon = np.array([[np.cos(a), np.sin(a), 0] for a in 2 * np.pi * np.arange(5) / 5])
    ms.add_mesh(pymeshlab.Mesh(pentagon, [np.arange(5, dtype=np.uint32)]), "pentagon")
    refused(ms, "polygon 0 has 5 corners", "compute_quality_per_face")
