"""Damaged, lying and missing files: always InvalidInput that names the file, and nothing printed."""

from __future__ import annotations

import os
import random
import warnings
from pathlib import Path

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery
from tests.core.io.round_trip import curve, grid, surface, volume, with_data, with_sets
from tests.cut_grids import turned_volumes

DATA = Path(mc.__file__).parent / "data"


def _flat(mesh: mc.Mesh) -> mc.Mesh:
    return mc.Mesh(mesh.points, {"triangle": mesh.cells["triangle"]})


SAMPLES = {
    "selig.dat": lambda path: path.write_bytes((DATA / "naca0012.dat").read_bytes()),
    "boundary.poly": lambda path: mc.io.write(path, with_sets(curve())),
    "mesh.ele": lambda path: mc.io.write(path, _flat(surface())),
    "mesh.obj": lambda path: mc.io.write(path, with_sets(surface(space=True))),
    "mesh.off": lambda path: mc.io.write(path, surface(space=True)),
    "text.ply": lambda path: mc.io.write(path, with_data(surface(), vectors=False), binary=False),
    "binary.ply": lambda path: mc.io.write(path, with_data(surface(), vectors=False)),
    "text.stl": lambda path: mc.io.write(path, _flat(surface()), binary=False),
    "text.vtu": lambda path: mc.io.write(path, with_data(volume()), binary=False),
    "binary.vtu": lambda path: mc.io.write(path, with_sets(with_data(volume()))),
    "binary.vtp": lambda path: mc.io.write(path, with_data(surface())),
    "binary.vts": lambda path: mc.io.write(path, grid()),
    "blocks.vtm": lambda path: mc.io.write(path, mc.MultiBlock((grid(), grid(layers=1)))),
    "text.vtk": lambda path: mc.io.write(path, with_sets(with_data(volume())), binary=False),
    "binary.vtk": lambda path: mc.io.write(path, with_sets(with_data(volume()))),
    "grid.vtk": lambda path: mc.io.write(path, grid()),
    "text.msh": lambda path: mc.io.write(path, with_sets(with_data(volume())), binary=False),
    "binary.msh": lambda path: mc.io.write(path, with_sets(with_data(volume()))),
    "mesh.mesh": lambda path: mc.io.write(path, with_sets(volume())),
    "mesh.su2": lambda path: mc.io.write(path, surface()),
    "text.xyz": lambda path: mc.io.write(path, grid(), binary=False),
    "records.p3d": lambda path: mc.io.write(path, mc.MultiBlock((grid(), grid(layers=1)))),
    "mesh.cgns": lambda path: mc.io.write(path, with_data(volume())),
    "blocks.cgns": lambda path: mc.io.write(path, turned_volumes((1, 2, 0), (True, False, True))),
    "solid.cgns": lambda path: mc.io.write(path, mc.voronoi_3d(np.random.default_rng(0).random((9, 3))).mesh),
    "stream.g": lambda path: mc.io.write(path, grid(), record_markers=False),
}


def refused(path: Path) -> str:
    """The message of the error, which must be one line about this file."""
    with pytest.raises(mc.InvalidInput) as caught:
        mc.io.read(path)
    text = str(caught.value)
    assert caught.value.parameter == "path"
    assert path.name in text
    assert "\n" not in text
    assert len(text) < 600
    return text


def read_or_refused(path: Path) -> mc.Mesh | mc.StructuredGrid | mc.MultiBlock | None:
    """What was read, a valid mesh since its constructor checked it; None if the file was refused by name."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", mc.io.FormatWarning)
        try:
            return mc.io.read(path)
        except mc.InvalidInput as error:
            assert path.name in str(error)
            return None


def geometry(mesh: mc.Mesh | mc.StructuredGrid | mc.MultiBlock) -> list[list]:
    """Points and cells as lists."""
    if isinstance(mesh, mc.MultiBlock):
        return [block.points.tolist() for block in mesh.blocks]
    if isinstance(mesh, mc.PolyhedralMesh):
        return [mesh.points.tolist(), mesh.face_nodes.tolist(), mesh.owner.tolist()]
    return [mesh.points.tolist(), *(c.tolist() for c in getattr(mesh, "cells", {}).values())]


@pytest.mark.parametrize("name", SAMPLES)
def test_truncated_anywhere(name: str, tmp_path: Path, capfd: pytest.CaptureFixture) -> None:
    path = tmp_path / name
    SAMPLES[name](path)
    whole = path.read_bytes()
    expected = geometry(mc.io.read(path))
    cuts = sorted({0, 1, 2, 5, len(whole) // 2, *np.linspace(3, len(whole) - 1, 60).astype(int).tolist()})
    for cut in cuts:
        path.write_bytes(whole[:cut])
        found = read_or_refused(path)
        # A list without a count may end anywhere. All others are refused, or have lost no more than sections of data
        # behind the last cell, and perhaps digits of the last number.
        if found is not None and not name.endswith((".obj", ".dat")) and cut < len(whole.rstrip()) - 20:
            assert geometry(found) == expected, cut
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("name", SAMPLES)
def test_flipped_bytes(name: str, tmp_path: Path, capfd: pytest.CaptureFixture) -> None:
    path = tmp_path / name
    SAMPLES[name](path)
    whole = path.read_bytes()
    chance = random.Random(name)
    for _ in range(80):
        damaged = bytearray(whole)
        for _ in range(chance.choice([1, 1, 3, 20])):
            damaged[chance.randrange(len(damaged))] = chance.choice(
                [chance.randrange(256), 0x30 + chance.randrange(10)]
            )
        path.write_bytes(damaged)
        read_or_refused(path)
    assert capfd.readouterr() == ("", "")


EXTENSIONS = [ext for row in mc.io.formats() if row.reads for ext in row.extensions.split()]
LIES = {
    "PNG picture": b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" + bytes(range(200)),
    "HTML page": b"<!DOCTYPE html><html><body><p>404 1.0 2.0</p></body></html>\n",
    "zip archive": b"PK\x03\x04" + bytes(100),
}


@pytest.mark.parametrize("extension", EXTENSIONS)
def test_content_that_is_something_else(extension: str, tmp_path: Path) -> None:
    path = tmp_path / f"liar{extension}"
    for what, content in LIES.items():
        path.write_bytes(content)
        assert what in refused(path)
    for content in (b"", b"\n \t\n", bytes(1000)):
        path.write_bytes(content)
        assert "empty" in refused(path)
    chance = random.Random(extension)
    for size in (1, 4, 7, 50, 84, 3000):
        path.write_bytes(bytes(chance.randrange(1, 256) for _ in range(size)))
        refused(path)
    path.write_text("once upon a time\nthere was no mesh\n")
    refused(path)


@pytest.mark.parametrize("name", SAMPLES)
def test_wrong_extension(name: str, tmp_path: Path) -> None:
    """A sample under each other format's name is refused, or read where the content is the same format's."""
    SAMPLES[name](tmp_path / name)
    content = (tmp_path / name).read_bytes()
    family = {
        e: k for k, group in enumerate(([".vtu", ".vtp", ".vts", ".vtm"], [".xyz", ".p3d", ".x", ".g"])) for e in group
    }
    own = Path(name).suffix
    for extension in EXTENSIONS:
        if (own, extension) == (".poly", ".node"):  # a boundary begins as its points alone would
            continue
        if extension != own and (own not in family or family.get(own) != family.get(extension)):
            path = tmp_path / f"other{extension}"
            path.write_bytes(content)
            refused(path)
            path.unlink()


HUGE = {
    "counts.poly": "9999999999999 2 0 0\n1 0 0\n",
    "attributes.poly": "3 2 99999999999 0\n1 0 0\n2 1 0\n3 0 1\n0\n0\n",
    "counts.off": "OFF\n999999999999 1 0\n0 0 0\n",
    "counts.ply": "ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty float x\nproperty float y\n"
    "property float z\nend_header\n0 0 0\n",
    "binary.ply": "ply\nformat binary_little_endian 1.0\nelement vertex 99999999999\nproperty float x\n"
    "property float y\nproperty float z\nend_header\nabcdefgh",
    "counts.su2": "NDIME= 2\nNELEM= 99999999999\n5 0 1 2\nNPOIN= 3\n0 0\n1 0\n0 1\n",
    "counts.msh": "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n99999999999\n1 0 0 0\n$EndNodes\n"
    "$Elements\n0\n$EndElements\n",
    "tags.msh": "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 99999999999 1 99999999999\n2 1 0 99999999999\n"
    "1\n0 0 0\n$EndNodes\n$Elements\n0 0 0 0\n$EndElements\n",
    "counts.mesh": "MeshVersionFormatted 2\nDimension 3\nVertices\n99999999999999\n0 0 0 0\nEnd\n",
    "counts.vtk": "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 99999999999 double\n0 0 0\n",
    "image.vtk": "# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 99999 99999 99999\n"
    "ORIGIN 0 0 0\nSPACING 1 1 1\n",
    "counts.vtu": '<VTKFile type="UnstructuredGrid"><UnstructuredGrid><Piece NumberOfPoints="99999999999" '
    'NumberOfCells="0"><Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0</DataArray>'
    "</Points></Piece></UnstructuredGrid></VTKFile>",
    "extent.vts": '<VTKFile type="StructuredGrid"><StructuredGrid><Piece Extent="0 999999 0 999999 0 999999"><Points>'
    '<DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0</DataArray></Points></Piece>'
    "</StructuredGrid></VTKFile>",
    "counts.xyz": "99999999 99999999 99999999\n0 0 0\n",
    "repeated.xyz": "2 2 1\n999999999999*0.0\n",
}


@pytest.mark.parametrize("name", HUGE)
def test_huge_promises_take_no_memory(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text(HUGE[name])
    refused(path)


POOR = {
    "nan.dat": ("wing\n1 0\n0.5 nan\n0 0\n0.5 -0.1\n", "line 3"),
    "half.dat": ("wing\n1 0\n0.5 0.1\n0 0\n0.5\n", "line 5"),
    "counts.dat": ("wing\n5. 5.\n\n0 0\n0.5 0.1\n1 0\n\n0 0\n0.5 -0.1\n1 0\n", "promises 5 and 5"),
    "line.dat": ("wing\n1 0\n0.5 0\n0 0\n0.5 0\n1 0\n", "no area"),
    "elements.dat": ("two\n1 0\n0.5 .1\n0 0\n0.5 -.1\n999. 999.\n2 0\n1.5 .1\n1.5 -.1\n", "several elements"),
    "part.dat": ("wing\n1 0\n0.7 0.1\n0.3 0.1\n0 0\n", "missing"),
    "range.poly": ("3 2 0 0\n1 0 0\n2 1 0\n3 0 1\n1 0\n1 1 4\n0\n", "line 6"),
    "order.poly": ("3 2 0 0\n1 0 0\n3 1 0\n2 0 1\n1 0\n1 1 2\n0\n", "numbered in order"),
    "alone.poly": ("0 2 0 0\n1 0\n1 1 2\n0\n", "alone.node"),
    "alone.ele": ("1 3 0\n1 1 2 3\n", "alone.node"),
    "space.node": ("1 3 0 0\n1 0 0 0\n", "3 coordinates"),
    "word.obj": ("v 0 0 zero\n", "line 1"),
    "range.obj": ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "point 8"),
    "before.obj": ("v 0 0 0\nv 1 0 0\nf 1 2 -3\n", "line 3"),
    "nan.obj": ("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "point 0"),
    "range.off": ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", "point 7"),
    "corner.stl": (
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\nendfacet\nendsolid\n",
        "line 7",
    ),
    "nan.stl": (
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 nan 0\nendloop\n"
        "endfacet\nendsolid\n",
        "nan",
    ),
    "dimension.su2": ("NDIME= 4\n", "dimension is 4"),
    "zones.su2": ("NZONE= 2\n", "2 zones"),
    "range.su2": ("NDIME= 2\nNELEM= 1\n5 0 1 3\nNPOIN= 3\n0 0\n1 0\n0 1\nNMARK= 0\n", "point 3"),
    "version.msh": ("$MeshFormat\n1.0 0 8\n$EndMeshFormat\n", "2.2 or 4.1"),
    "range.msh": (
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 0 0 0\n$EndNodes\n$Elements\n1\n1 15 0 7\n$EndElements\n",
        "point 7",
    ),
    "range.mesh": ("MeshVersionFormatted 2\nDimension 2\nVertices\n1\n0 0 0\nEdges\n1\n1 5 0\nEnd\n", "0 to 0"),
    "kind.vtu": ('<VTKFile type="ImageData"></VTKFile>', "ImageData"),
    "entity.vtu": ('<!DOCTYPE x [<!ENTITY a "b">]><VTKFile type="UnstructuredGrid"></VTKFile>', "entities"),
    "block.vtm": (
        '<VTKFile type="vtkMultiBlockDataSet"><vtkMultiBlockDataSet><DataSet index="0" file="gone.vts"/>'
        "</vtkMultiBlockDataSet></VTKFile>",
        "gone.vts",
    ),
    "self.vtm": (
        '<VTKFile type="vtkMultiBlockDataSet"><vtkMultiBlockDataSet><DataSet index="0" file="self.vtm"/>'
        "</vtkMultiBlockDataSet></VTKFile>",
        "again",
    ),
    "polyhedron.vtk": (
        "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 1 double\n0 0 0\nCELLS 1 2\n1 0\n"
        "CELL_TYPES 1\n42\n",
        "faces of cell 0",
    ),
}


@pytest.mark.parametrize("name", POOR)
def test_fault_is_named(name: str, tmp_path: Path) -> None:
    text, expected = POOR[name]
    (tmp_path / name).write_text(text)
    assert expected in refused(tmp_path / name)


def test_paths_that_are_no_files(tmp_path: Path) -> None:
    (tmp_path / "wing.dat").write_text("x")
    with pytest.raises(mc.InvalidInput, match=r"wnig.dat does not exist; did you mean wing.dat\?"):
        mc.io.read(tmp_path / "wnig.dat")
    with pytest.raises(mc.InvalidInput, match="no folder"):
        mc.io.read(tmp_path / "nowhere" / "wing.dat")
    (tmp_path / "folder.vtu").mkdir()
    with pytest.raises(mc.InvalidInput, match="is a folder"):
        mc.io.read(tmp_path / "folder.vtu")
    for nothing in ("", "  ", None, 3, "a\0b.vtu"):
        with pytest.raises(mc.InvalidInput, match="file name"):
            mc.io.read(nothing)


def test_unknown_extension(tmp_path: Path) -> None:
    (tmp_path / "mesh.vtx").write_text("x")
    (tmp_path / "mesh").write_text("x")
    with pytest.raises(mc.InvalidInput, match=r"'.vtx' is unknown; did you mean .vt.\? Known are .*\.stl"):
        mc.io.read(tmp_path / "mesh.vtx")
    with pytest.raises(mc.InvalidInput, match="has no extension"):
        mc.io.read(tmp_path / "mesh")
    with pytest.raises(mc.InvalidInput, match="unknown"):
        mc.io.write(tmp_path / "mesh.doc", surface())


def test_unreadable_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "mesh.obj").write_text("v 0 0 0")

    def denied(*_: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("builtins.open", denied)
    with pytest.raises(mc.InvalidInput, match=r"mesh.obj cannot be opened: Permission denied"):
        mc.io.read(tmp_path / "mesh.obj")


def test_working_folder_is_left_alone(tmp_path: Path) -> None:
    before = os.getcwd()
    (tmp_path / "mesh.stl").write_bytes(b"\x89PNG")
    refused(tmp_path / "mesh.stl")
    assert os.getcwd() == before
    assert [p.name for p in tmp_path.iterdir()] == ["mesh.stl"]


def test_a_name_without_extension_gets_a_whole_sentence():
    with pytest.raises(mc.InvalidInput, match=r"mesh: has no extension; known are .*\.stl"):
        mc.io.write("mesh", gallery.square())
