"""Geometry made in MeshLab, through meshcore, back in MeshLab, read again: the same points, cells and data."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest

import meshlab_filters
from meshcore import Mesh, MultiBlock, PolyhedralMesh, StructuredGrid, operations, quality
from meshcore.io.polyhedra import joined_faces
from meshcore.mesh import CELL_TYPES
from tests.meshlab.conftest import add, model_call

EVERY = tuple(operations())
WITH_INPUT = tuple(name for name, operation in operations().items() if operation.inputs)


def as_mesh(result):
    if isinstance(result, PolyhedralMesh):
        surface = result.boundary if result.dimension == 3 else result.with_cell_data(cell=np.arange(result.n_cells))
        triangles = surface.to_mesh()
        cell = surface.cell_data["cell"][triangles.cell_data["cell"]]
        data = {name: values[cell] for name, values in result.cell_data.items()}
        return Mesh(triangles.points, triangles.cells, cell_data={**data, "cell": cell})
    return result.to_mesh() if isinstance(result, (StructuredGrid, MultiBlock)) else result


def same_cells(found, expected):
    """Polygons may begin at another of their corners."""
    assert found.shape == expected.shape
    turns = [np.roll(found, k, axis=1) == expected for k in range(found.shape[1])]
    assert np.any([turn.all(axis=1) for turn in turns], axis=0).all()


def test_every_operation_is_a_filter():
    assert set(EVERY) <= set(meshlab_filters.filter_list())
    assert {"transfinite", "delaunay_refinement", "refined"} <= set(EVERY)


@pytest.mark.parametrize("identifier", EVERY)
def test_round_trip(ms, identifier):
    keywords, inputs, given = model_call(ms, identifier)
    before = ms.mesh_number()
    result = getattr(meshlab_filters, identifier)(ms, **keywords)
    direct = operations()[identifier].function(*inputs, **given)

    assert ms.mesh_number() == before + result["added_layers"]
    assert ms.current_mesh_id() == result["layer"]
    true, expected = as_mesh(result.mesh), as_mesh(direct.mesh)
    np.testing.assert_array_equal(true.points, expected.points)
    assert {k: c.tolist() for k, c in true.cells.items()} == {k: c.tolist() for k, c in expected.cells.items()}

    shown = expected.boundary if expected.dimension == 3 else expected
    names = ("cell", *shown.cell_data, *shown.point_data) if shown.dimension > 1 else tuple(shown.point_data)
    cells = shown.cell_data.get("cell", np.arange(shown.n_cells))
    again = meshlab_filters.to_mesh(ms.current_mesh(), names)
    np.testing.assert_array_equal(again.points, shown.points)
    assert set(again.cells) == set(shown.cells)
    for kind, nodes in shown.cells.items():
        same_cells(again.get(kind), nodes)
    if shown.dimension == 1:
        return  # MeshLab has no data on edges
    np.testing.assert_array_equal(again.cell_data["cell"], cells)
    for name, values in shown.cell_data.items():
        np.testing.assert_array_equal(again.cell_data[name], values)
    for name, values in expected.point_data.items():
        np.testing.assert_array_equal(again.point_data[name], values)
    whole = isinstance(direct.mesh, PolyhedralMesh)
    scalar = direct.mesh.volumes[cells] if whole else quality.measure(expected, "scaled_jacobian")[cells]
    np.testing.assert_array_equal(again.cell_data["face_scalar"], scalar)


@pytest.mark.parametrize("identifier", WITH_INPUT)
def test_transformed_layers_are_read_where_they_are_seen(ms, identifier):
    keywords, _, _ = model_call(ms, identifier)
    straight = getattr(meshlab_filters, identifier)(ms, **keywords)
    ms.set_current_mesh(0)
    ms.compute_matrix_from_translation(traslmethod="XYZ translation", axisx=3, axisy=-2, freeze=False, alllayers=True)
    ms.set_current_mesh(0)
    assert not np.array_equal(ms.current_mesh().vertex_matrix(), ms.current_mesh().transformed_vertex_matrix())
    moved = getattr(meshlab_filters, identifier)(ms, **keywords)
    a, b = as_mesh(straight.mesh), as_mesh(moved.mesh)
    assert abs(a.n_cells - b.n_cells) <= 0.05 * a.n_cells  # rounding may decide a tie otherwise
    np.testing.assert_allclose(b.bounds - a.bounds, [[3, -2, 0]] * 2, atol=1e-9)


def test_faces_stand_in_for_lines_by_their_boundary(ms):
    plate = Mesh(
        [[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.5]], {"triangle": [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]}
    )
    add(ms, plate, "plate")
    result = meshlab_filters.transfinite(ms, cells_i=4, cells_j=3)
    assert result.mesh.shape == (5, 4, 1)
    assert result.mesh.diagonal == pytest.approx(np.sqrt(2))


def test_a_polygon_layer_is_read_as_quads_and_triangles(ms):
    points = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0], [3, 0.5, 0]]
    mesh = Mesh(points, {"quad": [[0, 1, 4, 3], [1, 2, 5, 4]], "triangle": [[2, 6, 5]]}, cell_data={"tag": [7, 8, 9]})
    meshlab_filters.conversion.add(ms, mesh, "mixed", "shape")
    again = meshlab_filters.to_mesh(ms.current_mesh(), ["cell", "tag"])
    for kind, cells in mesh.cells.items():
        same_cells(again.get(kind), cells)
    order = np.argsort(again.cell_data["cell"])
    np.testing.assert_array_equal(again.cell_data["tag"][order], [7, 8, 9])
    np.testing.assert_allclose(again.cell_data["face_scalar"][order], quality.measure(mesh, "shape"))
    split = meshlab_filters.to_mesh(ms.current_mesh(), polygons=False)
    assert len(split.get("triangle")) == 5


def bricks():
    x = np.stack(np.meshgrid(np.arange(3.0), np.arange(3.0), np.arange(2.0), indexing="ij"), axis=-1)
    return StructuredGrid(x)


@pytest.mark.parametrize("kind", ["tetra", "hexahedron", "wedge", "pyramid"])
def test_volumes_come_as_a_boundary_and_an_exploded_view(ms, kind):
    box = bricks().to_mesh()
    corners = box.get("hexahedron")
    split = {
        "hexahedron": [range(8)],
        "tetra": [(0, 1, 3, 4), (1, 2, 3, 6), (4, 6, 5, 1), (4, 7, 6, 3), (1, 3, 4, 6)],
        "wedge": [(0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7)],
        "pyramid": [(0, 1, 2, 3, 4)],
    }[kind]
    cells = np.concatenate([corners[:1, list(nodes)] for nodes in split])
    mesh = Mesh(box.points, {kind: cells}).compacted()
    assert quality.validate(mesh) == []
    ids = meshlab_filters.conversion.add(ms, mesh, "volume", "scaled_jacobian")
    assert len(ids) == 2
    assert ms.current_mesh_id() == ids[0]
    outer = meshlab_filters.to_mesh(ms.current_mesh(), ["cell"])
    boundary = mesh.boundary
    assert {k: len(c) for k, c in outer.cells.items()} == {k: len(c) for k, c in boundary.cells.items()}
    np.testing.assert_array_equal(outer.cell_data["cell"], boundary.cell_data["cell"])
    ms.set_current_mesh(ids[1])
    assert ms.current_mesh().label() == "volume exploded"
    pieces = meshlab_filters.to_mesh(ms.current_mesh(), ["cell"])
    assert pieces.n_points == cells.size
    assert ms.get_topological_measures()["connected_components_number"] == len(cells)
    volume = ms.get_geometric_measures()["mesh_volume"]
    assert volume == pytest.approx(0.85**3 * quality.measure(mesh, "volume").sum())  # every face looks outward


def test_polygons_come_as_triangles_with_the_number_of_their_cell(ms):
    angle = 2 * np.pi * np.arange(6) / 6
    points = np.concatenate([np.column_stack([np.cos(angle), np.sin(angle)]), [[2, 0]]])
    mesh = PolyhedralMesh.from_polygons(points, [[0, 1, 2, 3, 4, 5], [0, 6, 1]], cell_data={"site": np.array([4, 2])})
    ids = meshlab_filters.conversion.add(ms, mesh, "cells", "shape")
    again = meshlab_filters.to_mesh(ms.current_mesh(), ["cell", "site"])
    assert len(ids) == 1
    np.testing.assert_array_equal(again.points, mesh.points)
    assert again.cell_data["cell"].tolist() == [0, 0, 0, 0, 1]
    assert again.cell_data["site"].tolist() == [4, 4, 4, 4, 2]
    np.testing.assert_allclose(again.cell_data["face_scalar"], mesh.volumes[[0, 0, 0, 0, 1]])


def test_polyhedra_come_as_a_boundary_and_an_exploded_view(ms):
    box = bricks().to_mesh()
    facets = np.array(CELL_TYPES["hexahedron"].facets)
    nodes = box.get("hexahedron")[:, facets].reshape(-1, 4)
    cell = np.repeat(np.arange(box.n_cells), 6)
    mesh = joined_faces(box.points, 4 * np.arange(len(nodes) + 1), nodes.ravel(), cell)
    ids = meshlab_filters.conversion.add(ms, mesh, "cells", "shape")
    assert len(ids) == 2
    outer = meshlab_filters.to_mesh(ms.current_mesh(), ["cell"])
    assert outer.n_cells == 2 * box.boundary.n_cells
    ms.set_current_mesh(ids[1])
    assert ms.get_topological_measures()["connected_components_number"] == mesh.n_cells
    assert ms.get_geometric_measures()["mesh_volume"] == pytest.approx(0.85**3 * mesh.volumes.sum())


def test_blocks_come_one_by_one(ms):
    two = MultiBlock((bricks(), bricks()), names=("near", "far"))
    ids = meshlab_filters.conversion.add(ms, two, "grid", "volume")
    assert [mesh.label() for mesh in ms] == ["grid near", "grid near exploded", "grid far", "grid far exploded"]
    assert ms.current_mesh_id() == ids[0]


def test_meshlab_filters_run_on_the_layers_of_every_operation(ms):
    """MeshLab's function filters read all attributes; on layers of polygons they used to crash the process."""
    for identifier in EVERY:
        keywords, _, _ = model_call(ms, identifier)
        getattr(meshlab_filters, identifier)(ms, **keywords)
        layer = ms.current_mesh()
        if not layer.face_number():
            continue
        ms.compute_selection_by_condition_per_face(condselect="cell < 3")
        assert layer.selected_face_number() == (layer.face_custom_scalar_attribute_array("cell") < 3).sum()
        ms.compute_scalar_by_function_per_face(q="cell * 2")
        assert ms.current_mesh().face_scalar_array().max() > 2


def test_thousands_of_edges(ms):
    angle = 2 * np.pi * np.arange(5000) / 5000
    k = np.arange(5000)
    outline = Mesh(np.column_stack([np.cos(angle), np.sin(angle)]), {"line": np.column_stack([k, (k + 1) % 5000])})
    add(ms, outline, "circle")
    grid = meshlab_filters.transfinite(ms, cells_i=20, cells_j=20)
    assert grid["quads"] == 400
    ms.set_current_mesh(0)
    mesh = meshlab_filters.delaunay_refinement(ms, min_angle=20)
    assert mesh["triangles"] > 5000
    assert ms.current_mesh().face_number() == mesh["triangles"]


def test_edges_that_do_not_share_points_are_joined(ms):
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    points = np.concatenate([corners[[k, (k + 1) % 4]] for k in range(4)])
    add(ms, Mesh(points, {"line": np.arange(8).reshape(4, 2)}), "soup")
    assert meshlab_filters.delaunay_refinement(ms)["triangles"] >= 2


def test_a_layer_with_holes_in_its_numbering(ms):
    ms.create_grid(numvertx=5, numverty=5, absscalex=1, absscaley=1)
    ms.compute_selection_by_condition_per_face(condselect="fi == 0")
    ms.meshing_remove_selected_faces()
    assert meshlab_filters.refined(ms)["triangles"] > 31


def test_selected_faces_are_marks(ms):
    ms.create_grid(numvertx=9, numverty=9, absscalex=1, absscaley=1)
    everywhere = meshlab_filters.refined(ms)
    ms.set_current_mesh(0)
    ms.compute_selection_by_condition_per_face(condselect="fi < 2")
    here = meshlab_filters.refined(ms, marks="selected")
    assert 128 < here["triangles"] < everywhere["triangles"] == 512


def test_lengths_in_all_spellings(ms):
    outline = [[0, 0], [3, 0], [3, 4], [0, 4]]
    add(ms, Mesh(outline, {"line": [[0, 1], [1, 2], [2, 3], [3, 0]]}), "box")
    counts = []
    for size in (pymeshlab.PercentageValue(10), pymeshlab.PureValue(0.5), 0.5, "10%"):
        ms.set_current_mesh(0)
        counts.append(meshlab_filters.delaunay_refinement(ms, size=size)["triangles"])
    assert len(set(counts)) == 1
    assert counts[0] > 100
