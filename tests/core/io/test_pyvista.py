"""pyvista and VTK as witnesses: the bridge, and VTK's files in each of their encodings."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
from vtkmodules import vtkIOLegacy, vtkIOXML

import meshcore as mc
from tests.core.io.round_trip import curve, grid, same, surface, volume, with_data, with_sets


@pytest.mark.parametrize("mesh", [curve(), surface(), volume()])
def test_bridge_there_and_back(mesh: mc.Mesh) -> None:
    rich = with_sets(with_data(mesh))
    same(mc.io.from_pyvista(mc.io.to_pyvista(rich)), rich)


def test_bridge_of_grids() -> None:
    rich = mc.StructuredGrid(
        grid().points,
        {"u": np.sin(grid().points)},
        {"c": np.arange(12).reshape(3, 2, 2)},
        {"jmin": "wall"},
        (True, False, False),
    )
    same(mc.io.from_pyvista(mc.io.to_pyvista(rich)), rich)
    same(mc.io.from_pyvista(mc.io.to_pyvista(mc.MultiBlock((rich, grid())))), mc.MultiBlock((rich, grid())))


def test_structured_cells_are_numbered_as_in_vtk() -> None:
    there = mc.io.to_pyvista(grid())
    np.testing.assert_allclose(there.cell_centers().points, grid().to_mesh().centroids, atol=1e-12)


def test_bridge_shares_nothing() -> None:
    mesh = with_data(surface())
    there = mc.io.to_pyvista(mesh)
    there.points[:] = 7
    there.point_data["u"][:] = 7
    assert not (mesh.points == 7).any()
    assert not (mesh.point_data["u"] == 7).any()


def test_other_data_sets() -> None:
    sphere = pv.Sphere()
    mesh = mc.io.from_pyvista(sphere)
    np.testing.assert_array_equal(mesh.cells["triangle"], sphere.regular_faces)
    assert mc.io.from_pyvista(pv.ImageData(dimensions=(1, 3, 4))).shape == (3, 4, 1)
    assert mc.io.from_pyvista(pv.ImageData(dimensions=(5, 1, 1))).cells["line"].shape == (4, 2)
    voxels = pv.ImageData(dimensions=(2, 3, 4)).cast_to_unstructured_grid()
    hexes = mc.io.from_pyvista(voxels)
    assert mc.quality.measure(hexes, "volume").tolist() == [1] * 6
    strip = mc.io.from_pyvista(pv.Plane().triangulate().strip())
    assert mc.quality.measure(strip, "area").sum() == pytest.approx(1)
    both = mc.io.from_pyvista(pv.MultiBlock({"a": pv.Line(), "b": pv.MultiBlock({"c": pv.Line(), "d": None})}))
    assert {name: len(s) for name, s in both.sets.items()} == {"a": 1, "b/c": 1}
    for wrong in (3, mc.Mesh([], {})):
        with pytest.raises(mc.InvalidInput, match="pyvista data set"):
            mc.io.from_pyvista(wrong)


ENCODINGS = list(itertools.product(("Ascii", "Binary", "Appended"), ("None", "ZLib", "LZMA"), (0, 1), (32, 64), (0, 1)))
WRITERS = {
    ".vtu": (vtkIOXML.vtkXMLUnstructuredGridWriter, lambda: mc.io.to_pyvista(with_sets(with_data(volume())))),
    ".vtp": (vtkIOXML.vtkXMLPolyDataWriter, lambda: pv.Sphere(theta_resolution=7, phi_resolution=5)),
    ".vts": (vtkIOXML.vtkXMLStructuredGridWriter, lambda: mc.io.to_pyvista(grid())),
}


@pytest.mark.parametrize("extension", WRITERS)
def test_every_encoding_of_vtk(extension: str, tmp_path: Path) -> None:
    make, data_set = WRITERS[extension]
    data = data_set()
    data.points = np.asarray(data.points, float)
    path = tmp_path / f"mesh{extension}"
    for mode, compressor, encode, header, order in ENCODINGS:
        writer = make()
        writer.SetInputData(data)
        getattr(writer, f"SetDataModeTo{mode}")()
        getattr(writer, f"SetCompressorTypeTo{compressor}")()
        writer.SetEncodeAppendedData(encode)
        getattr(writer, f"SetHeaderTypeToUInt{header}")()
        writer.SetByteOrder(order)
        writer.SetBlockSize(160)  # several blocks, the last one not full
        writer.SetFileName(str(path))
        assert writer.Write()
        found, expected = mc.io.read(path), mc.io.from_pyvista(data)
        if mode != "Ascii":
            same(found, expected)
        else:
            np.testing.assert_allclose(found.points, expected.points, rtol=1e-10, atol=1e-15)


LEGACY = {
    "UnstructuredGrid": lambda: mc.io.to_pyvista(with_sets(with_data(volume()))),
    "PolyData": lambda: pv.Sphere(theta_resolution=7, phi_resolution=5),
    "StructuredGrid": lambda: mc.io.to_pyvista(grid()),
    "StructuredPoints": lambda: pv.ImageData(dimensions=(3, 4, 5), spacing=(0.5, 1, 2), origin=(1, 2, 3)),
    "RectilinearGrid": lambda: pv.RectilinearGrid(np.array([0, 1, 3.0]), np.array([0, 2.0]), np.array([0.0])),
}


@pytest.mark.parametrize("kind", LEGACY)
@pytest.mark.parametrize(("form", "version"), [(1, 42), (1, 51), (2, 42), (2, 51)])
def test_legacy_files_of_vtk(kind: str, form: int, version: int, tmp_path: Path) -> None:
    data = LEGACY[kind]()
    path = tmp_path / "mesh.vtk"
    writer = getattr(vtkIOLegacy, f"vtk{kind}Writer")()
    writer.SetInputData(data)
    writer.SetFileType(form)
    writer.SetFileVersion(version)
    writer.SetFileName(str(path))
    assert writer.Write()
    found, expected = mc.io.read(path), mc.io.from_pyvista(data)
    if form == 2:
        same(found, expected)
    else:
        np.testing.assert_allclose(found.points, expected.points, rtol=1e-5)  # VTK's legacy text has six digits
        assert set(found.point_data) == set(expected.point_data)


@pytest.mark.parametrize("binary", [True, False])
@pytest.mark.parametrize("extension", [".vtu", ".vtp", ".vtk", ".vts", ".vtm", ".ply", ".stl", ".obj"])
def test_vtk_reads_what_we_write(extension: str, binary: bool, tmp_path: Path) -> None:
    path = tmp_path / f"mesh{extension}"
    options = {} if extension == ".obj" else {"binary": binary}
    if extension in (".vts", ".vtm"):
        mesh = grid() if extension == ".vts" else mc.MultiBlock((grid(), grid(layers=1)), ("a", "b"))
    elif extension in (".ply", ".stl", ".obj"):
        points = surface().points.astype(np.float32).astype(float)
        mesh = mc.Mesh(points[:4], {"triangle": [[0, 1, 2], [0, 2, 3]]})
    else:
        mesh = with_sets(with_data(surface()))
    mc.io.write(path, mesh, **options)
    found = mc.io.from_pyvista(pv.read(path))
    if extension in (".ply", ".stl", ".obj"):
        np.testing.assert_array_equal(found.points, mesh.points)
        np.testing.assert_array_equal(found.cells["triangle"], mesh.cells["triangle"])
    elif extension == ".vtp":  # VTK sorts the cells of a surface
        same(found, mc.io.read(path))
    else:
        same(found, mesh)


def test_multi_block_of_meshes(tmp_path: Path) -> None:
    line = pv.Line()
    line.clear_data()
    pv.MultiBlock({"a": line, "b": mc.io.to_pyvista(grid())}).save(tmp_path / "mixed.vtm")
    mesh = mc.io.read(tmp_path / "mixed.vtm")
    assert {name: len(s) for name, s in mesh.sets.items()} == {"a": 1, "b": 12}
