"""The pieces of a boundary's lines in the mesh: tags, numbers and directions, after triangulation and refinement."""

import numpy as np
import pytest

from meshcore import Mesh, constrained_delaunay, delaunay_refinement
from meshcore.gallery import joined, square, square_with_hole
from tests.core.unstructured.planar_graphs import frame_mesh


def edge_set(cells):
    return {tuple(sorted(edge)) for edge in cells.tolist()}


@pytest.mark.parametrize(
    "generate",
    [
        lambda boundary: constrained_delaunay(boundary, lines=True),
        lambda boundary: constrained_delaunay(boundary, conforming=True, lines=True),
        lambda boundary: delaunay_refinement(boundary, lines=True),
        lambda boundary: delaunay_refinement(boundary, lines=True, size=0.03),
        lambda boundary: delaunay_refinement(boundary, lines=True, size=0.05, placement="off-centre"),
        lambda boundary: delaunay_refinement(boundary, lines=True, split_boundary=False, max_area=0.001),
    ],
)
def test_the_edges_of_the_mesh_know_their_lines(generate):
    boundary = square_with_hole(3)
    mesh = generate(boundary).mesh
    triangles = Mesh(mesh.points, {"triangle": mesh.get("triangle")})
    assert edge_set(mesh.get("line")) == edge_set(triangles.boundary.get("line"))
    n = len(mesh.get("triangle"))
    line, tag = mesh.cell_data["line"], mesh.cell_data["tag"]
    assert (line[:n] == -1).all() and (tag[:n] == 0).all() and (mesh.cell_data["region"][:n] == 1).all()
    assert (np.diff(line[n:]) >= 0).all() and set(line[n:]) == set(range(boundary.n_cells))
    assert (tag[n:] == boundary.cell_data["tag"][line[n:]]).all()
    # The pieces of each line follow one another from its start to its end.
    for k, (a, b) in enumerate(boundary.points[boundary.get("line")]):
        chain = mesh.get("line")[line[n:] == k]
        assert (chain[1:, 0] == chain[:-1, 1]).all()
        assert (mesh.points[chain[0, 0]] == a).all() and (mesh.points[chain[-1, 1]] == b).all()


def test_a_wall_between_two_regions_is_told_once():
    boundary = frame_mesh(4, [((2, 0), (2, 4))]).with_cell_data(tag=np.array([1, 2, 3, 4, 9]))
    mesh = delaunay_refinement(boundary, lines=True, max_area=0.5).mesh
    wall = mesh.get("line")[mesh.cell_data["tag"][-len(mesh.get("line")) :] == 9]
    assert len(wall) > 1 and (mesh.points[wall, 0] == 2).all()
    assert np.diff(mesh.points[wall, 1], axis=1).sum() == 4
    assert set(np.unique(mesh.cell_data["region"])) == {0, 1, 2}


def test_lines_without_tags_have_numbers_only():
    mesh = constrained_delaunay(joined(square()), lines=True).mesh
    assert "tag" in mesh.cell_data
    mesh = constrained_delaunay(square(), lines=True).mesh
    assert "tag" not in mesh.cell_data and mesh.cell_data["line"].tolist() == [-1, -1, 0, 1, 2, 3]
