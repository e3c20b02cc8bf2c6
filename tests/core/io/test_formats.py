"""Round trips of shared meshes through every format, and what writing refuses or warns of."""

from __future__ import annotations

import os
import warnings
from pathlib import Path

import numpy as np
import pytest
import pyvista

import meshcore as mc
from meshcore.mesh import CELL_TYPES
from tests.core.io.round_trip import SPACE, check, curve, grid, round_trip, same, surface, volume, with_data, with_sets
from tests.cut_grids import h_shape


def triangles() -> mc.Mesh:
    return mc.Mesh(SPACE[:5], {"triangle": [[0, 1, 2], [0, 2, 3], [1, 4, 2]]})


def vertices() -> mc.Mesh:
    return mc.Mesh(SPACE, {"vertex": np.arange(7)[:, None]})


BINARY = {"binary": True}
TEXT = {"binary": False}
CASES = [
    *[(e, m(), o) for e in (".vtu", ".vtk") for o in (BINARY, TEXT) for m in (curve, surface, volume, vertices)],
    *[(".vtp", m(), o) for o in (BINARY, TEXT) for m in (curve, surface, vertices)],
    *[(".ply", m(), o) for o in (BINARY, TEXT) for m in (curve, surface)],
    *[(".msh", m(), o) for o in (BINARY, TEXT) for m in (curve, surface, volume, vertices)],
    *[(".mesh", m(), {}) for m in (curve, surface, volume)],
    *[(".obj", m(), {}) for m in (curve, surface, vertices)],
    (".off", surface(space=True), {}),
    (".stl", triangles(), TEXT),
    (".poly", curve(), {}),
    (".su2", surface(), {}),
    (".su2", volume(), {}),
]


@pytest.mark.parametrize(("extension", "mesh", "options"), CASES)
def test_points_and_cells(extension: str, mesh: mc.Mesh, options: dict, tmp_path: Path) -> None:
    check(tmp_path, extension, mesh, **options)


@pytest.mark.parametrize("extension", [".obj", ".vtp", ".vtu", ".vtk", ".ply", ".msh", ".mesh"])
def test_curves_in_space(extension: str, tmp_path: Path) -> None:
    check(tmp_path, extension, curve(space=True))


@pytest.mark.parametrize(("extension", "vectors"), [(".vtu", 1), (".vtp", 1), (".vtk", 1), (".msh", 1), (".ply", 0)])
@pytest.mark.parametrize("options", [BINARY, TEXT])
def test_data(extension: str, vectors: int, options: dict, tmp_path: Path) -> None:
    check(tmp_path, extension, with_data(surface(), vectors=bool(vectors)), **options)


@pytest.mark.parametrize("extension", [".vtu", ".vtp", ".vtk", ".msh", ".mesh", ".obj"])
def test_sets(extension: str, tmp_path: Path) -> None:
    check(tmp_path, extension, with_sets(surface(space=True)))
    check(tmp_path, extension, with_sets(curve()))


@pytest.mark.parametrize("extension", [".vtu", ".vtp", ".vtk", ".obj"])
def test_sets_that_share_cells(extension: str, tmp_path: Path) -> None:
    shared = mc.Mesh(SPACE, surface().cells, sets={"all": [0, 1, 2], "some": [1], "last": [2, 1]})
    check(tmp_path, extension, shared)


@pytest.mark.parametrize("extension", [".vtu", ".vtp", ".vtk"])
@pytest.mark.parametrize("options", [BINARY, TEXT])
def test_every_type_of_data(extension: str, options: dict, tmp_path: Path) -> None:
    mesh = surface()
    names = ["i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8"]
    cell_data = {name: np.array([1, 2, 100]).astype(name) / (3 if name[0] == "f" else 1) for name in names}
    cell_data = {name: values.astype(name) for name, values in cell_data.items()}
    cell_data["largest"] = np.array([2**63 - 1, -(2**63), 0])
    cell_data["odd"] = np.array([np.nan, np.inf, -np.inf])
    cell_data["text"] = np.array(["a b", "", "Ü<&>\"'"])
    cell_data['a <&> "\'name"'] = np.arange(3)
    field = {"title": np.array(["Flügel 1"]), "holes": np.array([[1 / 3, 0.1]]), "none": np.empty((0, 4))}
    mesh = mc.Mesh(mesh.points, mesh.cells, {}, cell_data, {}, field)
    found = round_trip(tmp_path, extension, mesh, **options)
    same(found, mesh)
    for name in names:
        assert found.cell_data[name].dtype == np.dtype(name)


@pytest.mark.parametrize("extension", [".vtu", ".vtk", ".msh"])
@pytest.mark.parametrize("kind", CELL_TYPES)
def test_every_kind_of_cell(kind: str, extension: str, tmp_path: Path) -> None:
    nodes = CELL_TYPES[kind].nodes
    mesh = mc.Mesh(np.random.default_rng(73).random((nodes, 3)), {kind: [np.arange(nodes), np.arange(nodes)[::-1]]})
    check(tmp_path, extension, mesh)


@pytest.mark.parametrize("extension", [".vts", ".vtk", ".vtm"])
@pytest.mark.parametrize("layers", [1, 3])
@pytest.mark.parametrize("options", [BINARY, TEXT])
def test_structured(extension: str, layers: int, options: dict, tmp_path: Path) -> None:
    plain = grid(layers=layers)
    rich = mc.StructuredGrid(
        plain.points,
        {"velocity": np.sin(plain.points)},
        {"p": np.sqrt(np.arange(plain.n_cells)).reshape(plain.cell_shape)},
        {"jmin": "wall", "imax": "Öffnung"},
        (False, True, False),
    )
    expected = mc.MultiBlock((rich,)) if extension == ".vtm" else rich
    same(round_trip(tmp_path, extension, rich, **options), expected)


@pytest.mark.parametrize("options", [BINARY, TEXT])
def test_cuts_between_blocks_come_back_and_vtk_reads_on(options: dict, tmp_path: Path) -> None:
    made = h_shape(3)
    found = round_trip(tmp_path, ".vtm", made, **options)
    same(found, made)
    assert found.cuts == made.cuts and len(made.cuts) == 4
    assert pyvista.read(tmp_path / "mesh.vtm").keys() == list(made.names)


def test_blocks(tmp_path: Path) -> None:
    blocks = mc.MultiBlock((grid(), grid(layers=2)), ("inner & outer", "Flügel"))
    check(tmp_path, ".vtm", blocks)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["mesh", "mesh.vtm"]
    check(tmp_path, ".vtm", blocks)  # over what is there


def test_structured_as_mesh(tmp_path: Path) -> None:
    same(round_trip(tmp_path, ".vtu", grid()), grid().to_mesh())
    joined = round_trip(tmp_path, ".vtu", mc.MultiBlock((grid(), grid(layers=2))))
    assert joined.n_cells == grid().n_cells + grid(layers=2).n_cells
    assert [len(joined.sets[f"block {k}"]) for k in (0, 1)] == [grid().n_cells, grid(layers=2).n_cells]


def test_empty_mesh(tmp_path: Path) -> None:
    for extension in (".vtu", ".vtk", ".vtp"):
        check(tmp_path, extension, mc.Mesh([], {}))


def test_upper_case_and_table(tmp_path: Path) -> None:
    check(tmp_path, ".VTU", surface())
    rows = mc.io.formats()
    assert all(row.reads and row.description and row.extensions.startswith(".") for row in rows)
    listed = " ".join(row.extensions for row in rows).split()
    assert len(listed) == len(set(listed))
    wanted = ".dat .poly .node .ele .obj .ply .stl .off .vtu .vtp .vts .vtm .vtk .msh .mesh .su2 .xyz .p3d .cgns"
    assert set(wanted.split()) <= set(listed)


# ---- writing loses nothing without a word, and never what was there


@pytest.mark.parametrize(
    ("extension", "mesh"),
    [
        (".obj", volume()),
        (".stl", surface()),
        (".off", curve()),
        (".ply", vertices()),
        (".poly", surface()),
        (".poly", curve(space=True)),
        (".ele", surface()),
        (".dat", surface()),
        (".vts", surface()),
        (".vtm", volume()),
        (".xyz", surface()),
        (".mesh", vertices()),
        (".su2", curve()),
        (".su2", surface(space=True)),
        (".vts", mc.MultiBlock((grid(), grid()))),
        (".vtu", "a mesh"),
        (".vtu", mc.Result(surface(), mc.Report())),
        (".vtu", mc.Mesh(SPACE, {}, {"c": 1j * np.arange(7)})),
        (".vtu", mc.Mesh(SPACE, {}, {"a\x01b": np.arange(7)})),
    ],
)
def test_what_does_not_fit_is_refused(extension: str, mesh: object, tmp_path: Path) -> None:
    path = tmp_path / f"mesh{extension}"
    path.write_text("what was there")
    with pytest.raises(mc.InvalidInput):
        mc.io.write(path, mesh)
    assert path.read_text() == "what was there"
    assert os.listdir(tmp_path) == [path.name]


@pytest.mark.parametrize("extension", [".obj", ".off", ".su2", ".mesh"])
def test_data_left_out_are_named(extension: str, tmp_path: Path) -> None:
    with pytest.warns(mc.io.FormatWarning) as caught:
        mc.io.write(tmp_path / f"mesh{extension}", with_data(surface(), vectors=False))
    texts = [str(w.message) for w in caught]
    assert [text.partition(" left out")[0] for text in texts] == [
        f"mesh{extension}: point data 'u'",
        f"mesh{extension}: cell data 'f'",
    ]
    assert caught[0].filename == __file__  # it points at the caller


def test_sets_left_out_are_named(tmp_path: Path) -> None:
    shared = mc.Mesh(surface().points, surface().cells, sets={"one": [0, 1], "two": [1]})
    for extension in (".msh", ".mesh", ".ply", ".off"):
        with pytest.warns(mc.io.FormatWarning, match="'two'"):
            mc.io.write(tmp_path / f"mesh{extension}", shared)


def test_rounding_is_named(tmp_path: Path) -> None:
    with pytest.warns(mc.io.FormatWarning, match="single precision"):
        mc.io.write(tmp_path / "mesh.stl", triangles())
    found = mc.io.read(tmp_path / "mesh.stl")
    np.testing.assert_array_equal(found.points, triangles().points.astype(np.float32))


def test_options(tmp_path: Path) -> None:
    with pytest.raises(mc.InvalidInput, match=r"record_markers: .* it has binary"):
        mc.io.write(tmp_path / "mesh.vtu", surface(), record_markers=True)
    mc.io.write(tmp_path / "text.vtu", surface(), binary=False)
    assert b"0.3333333333333333" in (tmp_path / "text.vtu").read_bytes()


def test_places_that_cannot_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(mc.InvalidInput, match="does not exist; make it first"):
        mc.io.write(tmp_path / "nowhere" / "mesh.vtu", surface())
    (tmp_path / "folder.vtu").mkdir()
    with pytest.raises(mc.InvalidInput, match="is a folder"):
        mc.io.write(tmp_path / "folder.vtu", surface())
    path = tmp_path / "mesh.vtu"
    path.write_text("what was there")

    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(mc.InvalidInput, match="No space left"):
        mc.io.write(path, surface())
    assert path.read_text() == "what was there"
    assert sorted(os.listdir(tmp_path)) == ["folder.vtu", "mesh.vtu"]


def test_link_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "real.vtu").write_text("old")
    (tmp_path / "link.vtu").symlink_to(tmp_path / "real.vtu")
    mc.io.write(tmp_path / "link.vtu", surface())
    assert (tmp_path / "link.vtu").is_symlink()
    same(mc.io.read(tmp_path / "real.vtu"), surface())


def test_missing_library_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "meshio", None)
    with pytest.raises(mc.MissingLibrary, match="pip install meshio"):
        mc.io.write(tmp_path / "mesh.mesh", surface())
    monkeypatch.setitem(__import__("sys").modules, "pyvista", None)
    with pytest.raises(mc.MissingLibrary, match="pip install pyvista"):
        mc.io.to_pyvista(surface())


def test_polygons_are_cut_with_a_word(tmp_path: Path) -> None:
    (tmp_path / "l.obj").write_text("v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5 6\n")
    with pytest.warns(mc.io.FormatWarning, match=r"l.obj: 1 polygons with 6 corners"):
        mesh = mc.io.read(tmp_path / "l.obj")
    a, b, c = (mesh.points[mesh.cells["triangle"][:, k]] for k in range(3))
    area = np.cross(b - a, c - a)[:, 2] / 2
    assert (area > 0).all()  # none lies outside the notch, or their sum would be larger
    assert area.sum() == 3
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert mc.io.read(tmp_path / "l.obj").n_cells == 4
