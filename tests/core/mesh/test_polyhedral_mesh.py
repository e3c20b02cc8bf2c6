"""PolyhedralMesh: checks, measures against known shapes, topology, and meshes made from it."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import InvalidGeometry, InvalidInput, Mesh, PolyhedralMesh, StructuredGrid, quality
from meshcore.io.polyhedra import joined_faces
from meshcore.mesh import CELL_TYPES, polygons


def hexagon_and_square():
    """A regular hexagon of side 1 and a square on its right side."""
    angle = np.pi / 6 + np.pi / 3 * np.arange(6)
    hexagon = np.column_stack([np.cos(angle), np.sin(angle)])
    x = hexagon[0, 0]
    points = np.concatenate([hexagon, [[x + 1, -0.5], [x + 1, 0.5]]])
    return PolyhedralMesh.from_polygons(points, [[0, 1, 2, 3, 4, 5], [5, 6, 7, 0]], cell_data={"kind": [6, 4]})


def of_bricks(shape=(3, 2, 2)):
    """Hexahedra as polyhedra, and the same as a Mesh."""
    axes = [np.arange(n + 1.0) * size for n, size in zip(shape, (1, 2, 3), strict=True)]
    mesh = StructuredGrid(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)).to_mesh()
    facets = np.array(CELL_TYPES["hexahedron"].facets)
    nodes = mesh.get("hexahedron")[:, facets].reshape(-1, 4)
    cell = np.repeat(np.arange(mesh.n_cells), 6)
    made = joined_faces(mesh.points, 4 * np.arange(len(nodes) + 1), nodes.ravel(), cell)
    return made.with_cell_data(number=np.arange(made.n_cells)), mesh


def test_areas_centroids_and_neighbours_of_polygons():
    mesh = hexagon_and_square()
    np.testing.assert_allclose(mesh.volumes, [1.5 * np.sqrt(3), 1], rtol=1e-15)
    np.testing.assert_allclose(mesh.centroids, [[0, 0, 0], [np.sqrt(0.75) + 0.5, 0, 0]], atol=1e-15)
    assert mesh.neighbours.tolist() == [[0, 1]]
    assert (mesh.dimension, mesh.n_faces, mesh.n_cells) == (2, 2, 2)


def test_the_boundary_of_polygons_runs_around_them():
    lines = hexagon_and_square().boundary
    a, b = (lines.points[lines.get("line")[:, k]] for k in (0, 1))
    assert lines.n_cells == 8
    assert 0.5 * np.cross(a, b)[:, 2].sum() == pytest.approx(1.5 * np.sqrt(3) + 1)
    assert lines.cell_data["cell"].tolist() == [0] * 5 + [1] * 3


def test_the_area_of_a_polygon_in_space_does_not_depend_on_where_it_lies():
    flat = hexagon_and_square()
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    moved = flat.with_points(flat.points @ turn.T + [3, -7, 2])
    np.testing.assert_allclose(moved.volumes, flat.volumes, rtol=1e-13)
    np.testing.assert_allclose(moved.centroids, flat.centroids @ turn.T + [3, -7, 2], atol=1e-13)


def test_a_concave_polygon_has_its_area():
    mesh = PolyhedralMesh.from_polygons([[0, 0], [2, 0], [2, 1], [1, 0.2], [0, 1]], [[0, 1, 2, 3, 4]])
    assert mesh.volumes[0] == pytest.approx(2 - 0.8)


def test_polyhedra_agree_with_the_hexahedra_that_they_are():
    mesh, bricks = of_bricks()
    np.testing.assert_allclose(mesh.volumes, quality.measure(bricks, "volume"), rtol=1e-14)
    np.testing.assert_allclose(mesh.centroids, bricks.centroids, rtol=1e-14)
    facets = bricks.facets
    inner = facets.neighbour >= 0
    pairs = np.sort(np.column_stack([facets.owner, facets.neighbour])[inner], axis=1)
    assert mesh.neighbours.tolist() == sorted(pairs.tolist())
    assert mesh.n_faces == len(facets.owner)
    assert mesh.edges.tolist() == bricks.edges.tolist()
    assert mesh.boundary.n_cells == bricks.boundary.n_cells
    assert mesh.boundary.volumes.sum() == pytest.approx(2 * (3 * 4 + 4 * 6 + 3 * 6))


def test_faces_of_each_cell():
    mesh, _ = of_bricks()
    offsets, faces = mesh.cell_faces
    assert np.diff(offsets).tolist() == [6] * mesh.n_cells
    for cell in range(mesh.n_cells):
        own = faces[offsets[cell] : offsets[cell + 1]]
        assert ((mesh.owner[own] == cell) | (mesh.neighbour[own] == cell)).all()


@pytest.mark.parametrize("keep", [[0], [3, 4, 11], np.arange(12) % 2 == 1])
def test_selected_cells_stay_what_they_are(keep):
    mesh, _ = of_bricks()
    some = mesh.selected(keep)
    number = np.arange(12)[keep]
    assert some.cell_data["number"].tolist() == number.tolist()
    np.testing.assert_allclose(some.volumes, mesh.volumes[number])
    np.testing.assert_allclose(some.centroids, mesh.centroids[number])
    assert len(np.unique(some.face_nodes)) == some.n_points


def test_separated_cells_are_closed_and_shrink_about_their_middle():
    mesh, _ = of_bricks()
    pieces = mesh.separated(0.5)
    assert pieces.n_cells == 6 * mesh.n_cells and pieces.n_points == 8 * mesh.n_cells
    pairs, _ = polygons.edges(pieces.face_offsets, pieces.face_nodes)
    assert len(pieces.neighbours) and len(np.unique(pairs, axis=0)) == len(pairs)
    assert {tuple(p) for p in pairs.tolist()} == {(b, a) for a, b in pairs.tolist()}
    assert pieces.cell_data["number"].tolist() == np.repeat(np.arange(12), 6).tolist()
    np.testing.assert_allclose(np.bincount(pieces.cell_data["cell"], pieces.volumes), 22 / 4)


def test_separated_polygons():
    pieces = hexagon_and_square().separated()
    assert pieces.n_points == 10 and not len(pieces.neighbours)
    np.testing.assert_array_equal(pieces.volumes, hexagon_and_square().volumes)


def test_to_mesh_is_valid_conforming_and_as_large():
    solid, _ = of_bricks()
    tetrahedra = solid.to_mesh()
    assert quality.validate(tetrahedra) == []
    np.testing.assert_allclose(
        np.bincount(tetrahedra.cell_data["cell"], quality.measure(tetrahedra, "volume")), solid.volumes
    )
    flat = hexagon_and_square().to_mesh()
    assert quality.validate(flat) == [] and flat.cell_data["kind"].tolist() == [6] * 4 + [4] * 2


BAD = {
    "offsets": ({"face_offsets": [0, 4, 3]}, InvalidInput, "face_offsets"),
    "too short": ({"face_offsets": [0, 3]}, InvalidInput, "face_offsets"),
    "two nodes": ({"face_offsets": [0, 2, 4]}, InvalidGeometry, "face 0 has 2 nodes"),
    "no such point": ({"face_nodes": [0, 1, 2, 9]}, InvalidGeometry, "face 0 refers to point 9"),
    "fractions": ({"face_nodes": [0.0, 1.0, 2.0, 3.0]}, InvalidInput, "whole numbers"),
    "not finite": ({"points": [[0, 0], [1, 0], [1, np.nan], [0, 1]]}, InvalidGeometry, "point 2"),
    "a table": ({"face_nodes": [[0, 1, 2, 3]]}, InvalidInput, "face_nodes"),
    "owner alone": ({"owner": [0]}, InvalidInput, "neighbour"),
    "owners": ({"owner": [0, 1], "neighbour": [1, -1]}, InvalidInput, "owner"),
    "sides": ({"owner": [1], "neighbour": [0]}, InvalidInput, "face 0 lies between 1 and 0"),
    "negative": ({"owner": [-1], "neighbour": [-1]}, InvalidInput, "every face needs an owner"),
    "flat cell": ({"owner": [0], "neighbour": [-1]}, InvalidGeometry, "cell 0 has 1 faces"),
    "far cell": ({"owner": [10**15], "neighbour": [-1]}, InvalidInput, "names cell 1000000000000000"),
    "data": ({"cell_data": {"a": [1, 2]}}, InvalidInput, "cell_data"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_no_mesh_is_refused_by_name(case):
    good = {"points": [[0, 0], [1, 0], [1, 1], [0, 1]], "face_offsets": [0, 4], "face_nodes": [0, 1, 2, 3]}
    change, error, text = BAD[case]
    with pytest.raises(error, match=text):
        PolyhedralMesh(**{**good, **change})


def test_an_empty_mesh():
    mesh = PolyhedralMesh(np.empty((0, 3)), [0], np.empty(0, int))
    assert (mesh.n_cells, mesh.volumes.size, len(mesh.neighbours), mesh.boundary.n_cells) == (0, 0, 0, 0)
    assert isinstance(mesh.to_mesh(), Mesh) and mc.PolyhedralMesh is PolyhedralMesh


def test_a_cell_without_area_has_its_middle():
    mesh = PolyhedralMesh.from_polygons([[0, 0], [2, 0], [1, 0]], [[0, 1, 2]])
    assert mesh.volumes[0] == 0 and mesh.centroids[0].tolist() == [1, 0, 0]
