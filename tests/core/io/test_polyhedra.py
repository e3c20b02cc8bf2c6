"""Polygons and polyhedra through files and pyvista: every point, face, cell and array comes back."""

import warnings

import numpy as np
import pytest
import pyvista

import meshcore as mc
from meshcore import InvalidInput, PolyhedralMesh
from meshcore.io.polyhedra import joined_faces
from tests.core.mesh.test_polyhedral_mesh import hexagon_and_square, of_bricks


def flat():
    mesh = hexagon_and_square()
    return mesh.with_point_data(u=np.sqrt(np.arange(mesh.n_points))).with_cell_data(site=np.array([7, 3]))


def solid():
    mesh, _ = of_bricks((2, 2, 1))
    return mesh.with_point_data(u=np.sqrt(np.arange(mesh.n_points)))


def same(found, expected):
    assert isinstance(found, PolyhedralMesh)
    for name in ("points", "face_offsets", "face_nodes", "owner", "neighbour"):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name), err_msg=name)
    for name in ("point_data", "cell_data", "field_data"):
        ours, theirs = getattr(found, name), getattr(expected, name)
        assert set(ours) == set(theirs)
        for key, values in theirs.items():
            np.testing.assert_array_equal(ours[key], values)


@pytest.mark.parametrize("binary", [True, False])
@pytest.mark.parametrize("extension", [".vtu", ".vtk"])
@pytest.mark.parametrize("make", [flat, solid])
def test_vtk_keeps_all(tmp_path, extension, make, binary):
    path = tmp_path / f"mesh{extension}"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mc.io.write(path, make(), binary=binary)
        same(mc.io.read(path), make())


@pytest.mark.parametrize("extension", [".vtu", ".vtk"])
def test_vtk_itself_reads_and_writes_them(tmp_path, extension):
    path = tmp_path / f"ours{extension}"
    mc.io.write(path, solid())
    grid = pyvista.read(path)
    assert set(grid.celltypes) == {42}
    np.testing.assert_allclose(grid.compute_cell_sizes()["Volume"], solid().volumes)
    theirs = tmp_path / f"theirs{extension}"
    grid.save(theirs)
    back = mc.io.read(theirs)
    np.testing.assert_allclose(back.volumes, solid().volumes)
    assert back.neighbours.tolist() == solid().neighbours.tolist()


@pytest.mark.parametrize("make", [flat, solid])
def test_pyvista_there_and_back(make):
    grid = mc.io.to_pyvista(make())
    assert grid.n_cells == make().n_cells
    same(mc.io.from_pyvista(grid), make())


@pytest.mark.parametrize("extension", [".obj", ".ply", ".vtp"])
def test_polygons_are_written_whole_as_surfaces(tmp_path, extension):
    path = tmp_path / f"mesh{extension}"
    mesh = hexagon_and_square()
    mc.io.write(path, PolyhedralMesh(mesh.points, mesh.face_offsets, mesh.face_nodes))
    surface = pyvista.read(path)
    assert [cell.n_points for cell in surface.cell] == [6, 4]
    np.testing.assert_allclose(surface.points, mesh.points, atol=1e-7)


def test_off_lists_whole_polygons(tmp_path):
    mesh = hexagon_and_square()
    mc.io.write(tmp_path / "mesh.off", PolyhedralMesh(mesh.points, mesh.face_offsets, mesh.face_nodes))
    assert (tmp_path / "mesh.off").read_text().splitlines()[-2:] == ["6 0 1 2 3 4 5", "4 5 6 7 0"]


@pytest.mark.parametrize("binary", [True, False])
def test_ply_keeps_data_of_polygons(tmp_path, binary):
    path = tmp_path / "mesh.ply"
    mc.io.write(path, flat(), binary=binary)
    with pytest.warns(mc.io.FormatWarning, match="polygons with 6 corners"):
        back = mc.io.read(path)  # PLY is read as triangles and quads
    assert sorted(back.cell_data["site"].tolist()) == [3, 7, 7, 7, 7]
    np.testing.assert_array_equal(back.point_data["u"], flat().point_data["u"])


@pytest.mark.parametrize("extension", [".obj", ".ply", ".off", ".vtp"])
def test_polyhedra_are_their_faces_where_a_format_holds_surfaces(tmp_path, extension):
    path = tmp_path / f"mesh{extension}"
    mesh, _ = of_bricks((2, 2, 1))
    with pytest.warns(mc.io.FormatWarning, match="'4 polyhedra' left out"):
        mc.io.write(path, PolyhedralMesh(mesh.points, mesh.face_offsets, mesh.face_nodes, mesh.owner, mesh.neighbour))
    assert len(mc.io.read(path).get("quad")) == mesh.n_faces


@pytest.mark.parametrize("extension", [".stl", ".su2", ".msh", ".vts"])
def test_other_formats_refuse_and_name_the_cure(tmp_path, extension):
    with pytest.raises(InvalidInput, match=r"to_mesh\(\)"):
        mc.io.write(tmp_path / f"mesh{extension}", flat())
    assert not list(tmp_path.iterdir())


def test_other_solid_cells_may_stand_beside_polyhedra():
    x, y, z = np.meshgrid([2, 3], [0, 2], [0, 3], indexing="ij")
    brick = mc.StructuredGrid(np.stack([x, y, z], axis=-1)).to_mesh()
    mesh = mc.io.from_pyvista(mc.io.to_pyvista(solid()).merge(mc.io.to_pyvista(brick), merge_points=True))
    assert mesh.n_cells == 5 and mesh.volumes.sum() == pytest.approx(solid().volumes.sum() + 6)
    assert len(mesh.neighbours) == len(solid().neighbours) + 1


def test_a_stream_of_faces_that_does_not_fit_is_refused(tmp_path):
    path = tmp_path / "mesh.vtu"
    mc.io.write(path, solid(), binary=False)
    text = path.read_text()
    at = text.index('Name="faces"')
    start = text.index(">", at) + 1
    for stream in ("6 4 0", "", "400000000 3 0 1 2", "1 -3 0 1 2"):
        path.write_text(text[:start] + stream + text[text.index("<", start) :])
        with pytest.raises(InvalidInput):
            mc.io.read(path)


def test_a_face_of_three_cells_is_refused():
    with pytest.raises(InvalidInput, match="belongs to 3 cells"):
        joined_faces(solid().points, np.array([0, 3, 6, 9]), np.array([0, 1, 2] * 3), np.arange(3))


@pytest.mark.parametrize("extension", [".vtu", ".vtk", ".ply", ".off"])
def test_no_polygons_at_all(tmp_path, extension):
    path = tmp_path / f"none{extension}"
    mc.io.write(path, PolyhedralMesh(np.empty((0, 3)), [0], np.empty(0, int)))
    assert mc.io.read(path).n_cells == 0
