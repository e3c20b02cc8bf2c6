"""CGNS: blocks with names, cuts and data come back, and VTK's reader, which is CGNS's own library, sees the same."""

from __future__ import annotations

import itertools
import sys
import tempfile
import warnings
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import meshcore as mc
from meshcore import Cut
from meshcore.io.cgns_nodes import NAME_LENGTH, unique
from tests.core.io.round_trip import curve, grid, round_trip, same, surface, volume, with_data
from tests.cut_grids import c_shape, h_shape, on_a_step, quarter_turned, ring, turned_volumes

NAMED = {"jmin": "wall", "jmax": "far field", "imin": "Öffnung #1"}
TURNS = list(itertools.product(itertools.permutations(range(3)), itertools.product([False, True], repeat=3)))


def same_joins(found: mc.StructuredGrid | mc.MultiBlock, expected: mc.StructuredGrid | mc.MultiBlock) -> None:
    same(found, expected)
    assert found.cuts == expected.cuts


@pytest.mark.parametrize(
    "made",
    [
        replace(ring(12, 3), names={"jmin": "wall", "jmax": "far field"}),
        replace(c_shape(4, 10, 3), names=NAMED),
        h_shape(3),
        on_a_step(),
        *map(quarter_turned, range(4)),
        grid(),
        grid(layers=1),
        mc.MultiBlock((grid(), grid(layers=5)), ("a", "b")),
    ],
)
def test_names_and_cuts_come_back(made, tmp_path):
    same_joins(round_trip(tmp_path, ".cgns", made), made)


@pytest.mark.parametrize(("order", "back"), TURNS)
def test_volumes_turned_in_any_way(order, back, tmp_path):
    made = turned_volumes(order, back)
    same_joins(round_trip(tmp_path, ".cgns", made), made)


@pytest.mark.parametrize("layers", [1, 3])
def test_data_come_back(layers, tmp_path):
    plain = grid(layers=layers)
    count = np.arange(plain.n_cells).reshape(plain.cell_shape)
    point_data = {"velocity": np.sin(plain.points), "p": np.cos(plain.points[..., 0]), "x": plain.points[..., 1]}
    cell_data = {"rank": count, "small": count.astype(np.float32), "normal": np.stack([count] * 3, axis=-1) / 7}
    made = mc.StructuredGrid(plain.points, point_data, cell_data)
    found = round_trip(tmp_path, ".cgns", made)
    same(found, made)
    assert found.cell_data["small"].dtype == np.float32


def told_by_lists(path: Path, *, by_ranges: bool, seed: int = 0) -> None:
    """Change the 1-to-1 connections of a file into general ones, which list the same points in any order."""
    from meshcore.io.cgns_nodes import Node, read_nodes, write_nodes

    root = read_nodes(path)
    base = next(root.of("CGNSBase_t"))
    for zone in base.of("Zone_t"):
        for group in zone.of("ZoneGridConnectivity_t"):
            for k, node in enumerate(group.children):
                first, last = node.find("PointRange").value.astype(int)
                there = node.find("PointRangeDonor").value.astype(int)[0]
                matrix = np.zeros((len(first),) * 2, int)
                for axis, to in enumerate(node.find("Transform").value.tolist()):
                    matrix[abs(to) - 1, axis] = np.sign(to)
                axes = [np.arange(min(a, b), max(a, b) + 1) for a, b in zip(first, last, strict=True)]
                points = np.stack(np.meshgrid(*axes[::-1], indexing="ij")[::-1], -1).reshape(-1, len(first))
                order = np.random.default_rng(seed).permutation(len(points)) if not by_ranges else slice(None)
                donors = there + (points - first) @ matrix.T
                made = Node(node.name, "GridConnectivity_t", node.value)
                made.add("GridConnectivityType", "GridConnectivityType_t", "Abutting1to1")
                if by_ranges:
                    made.add("PointRange", "IndexRange_t", np.array([points[0], points[-1]], np.int32))
                else:
                    made.add("PointList", "IndexArray_t", points[order].astype(np.int32))
                made.add("PointListDonor", "IndexArray_t", donors[order].astype(np.int32))
                made.children += [child for child in node.children if child.label == "GridConnectivityProperty_t"]
                group.children[k] = made
    write_nodes(path, root.children)


def connections(grid: mc.StructuredGrid | mc.MultiBlock) -> list[tuple]:
    """What is joined to what: for each cut its places, those of the partner, and which way they lead."""
    found = []
    for cut in grid.joins:
        place = cut.places()
        found.append(
            (cut.name, cut.block, cut.partner_block, place.tolist(), cut.across(place).tolist(), cut.transform)
        )
    return sorted(found)


@pytest.mark.parametrize("by_ranges", [False, True])
@pytest.mark.parametrize("made", [c_shape(4, 10, 3), h_shape(3), on_a_step(), *map(quarter_turned, range(4)), None])
def test_connections_by_lists_are_cuts_where_points_match(made, by_ranges, tmp_path):
    made = made or sector(np.eye(3), np.array([0.0, 3, 0]))
    mc.io.write(tmp_path / "a.cgns", made)
    expected = mc.io.read(tmp_path / "a.cgns")
    told_by_lists(tmp_path / "a.cgns", by_ranges=by_ranges)
    found = mc.io.read(tmp_path / "a.cgns")
    same(found, expected)
    assert connections(found) == connections(expected)


@pytest.mark.parametrize(("order", "back"), TURNS[::5])
def test_connections_by_lists_between_volumes_turned_in_any_way(order, back, tmp_path):
    mc.io.write(tmp_path / "a.cgns", turned_volumes(order, back))
    expected = connections(mc.io.read(tmp_path / "a.cgns"))
    told_by_lists(tmp_path / "a.cgns", by_ranges=False)
    assert connections(mc.io.read(tmp_path / "a.cgns")) == expected and expected


def test_other_connections_are_told(tmp_path):
    """Patches that do not match, a list with two points exchanged, and one that is no rectangle."""
    from meshcore.io.cgns_nodes import read_nodes, write_nodes

    path = tmp_path / "a.cgns"
    for fault in ("kind", "exchanged", "missing", "faces"):
        mc.io.write(path, h_shape(3))
        told_by_lists(path, by_ranges=False)
        root = read_nodes(path)
        zones = list(next(root.of("CGNSBase_t")).of("Zone_t"))
        for node in [node for zone in zones for group in zone.of("ZoneGridConnectivity_t") for node in group.children]:
            donors = node.find("PointListDonor")
            if fault == "kind":
                node.find("GridConnectivityType").value = "Abutting"
            elif fault == "exchanged":
                donors.value = donors.value[[1, 0, *range(2, len(donors.value))]]
            elif fault == "missing":
                donors.value = donors.value[1:]
            else:
                node.add("GridLocation", "GridLocation_t", "FaceCenter")
        write_nodes(path, root.children)
        with pytest.warns(mc.io.FormatWarning, match="only those that join rectangles point by point"):
            assert mc.io.read(path).joins == ()


def sector(turn: np.ndarray, shift: np.ndarray) -> mc.StructuredGrid:
    """A bent block whose jmax is its jmin, turned and moved."""
    s, t, u = np.meshgrid(np.linspace(1, 2, 4), np.linspace(0, 1, 5), np.linspace(0, 1, 3), indexing="ij")
    start = np.stack([s, 0.1 * np.sin(3 * s) * u, u + 0.2 * s], axis=-1)[:, 0]
    end = start @ turn.T + shift
    points = (1 - t[..., None]) * start[:, None] + t[..., None] * end[:, None]
    points[:, -1] = end
    rotation = None if np.array_equal(turn, np.eye(3)) else tuple(map(tuple, turn.tolist()))
    ranges = ((0, 0, 0), (3, 0, 2)), ((0, 4, 0), (3, 4, 2))
    return mc.StructuredGrid(points, cuts=(Cut(*ranges, rotation=rotation, translation=tuple(shift), name="pitch"),))


@pytest.mark.parametrize("seed", range(8))
def test_turned_and_moved_sides_come_back_to_round_off(seed, tmp_path):
    """Though the file keeps turn and shift in single precision."""
    chance = np.random.default_rng(seed)
    q, _ = np.linalg.qr(chance.normal(size=(3, 3)))
    turn = q * np.sign(np.linalg.det(q)) if seed else np.eye(3)
    made = sector(turn, chance.normal(size=3))
    found = round_trip(tmp_path, ".cgns", made).cuts[0]
    given = made.cuts[0]
    assert (found.points, found.partner, found.transform, found.name) == (
        given.points,
        given.partner,
        given.transform,
        "pitch",
    )
    np.testing.assert_allclose(found.moved(made.points), given.moved(made.points), atol=1e-13)


def test_mirrored_sides_are_left_out_and_told(tmp_path):
    made = sector(np.diag([1.0, -1.0, 1.0]), np.array([0, -1.0, 0]))
    with pytest.warns(mc.io.FormatWarning, match="mirror"):
        mc.io.write(tmp_path / "m.cgns", made)
    assert mc.io.read(tmp_path / "m.cgns").cuts == ()


def vtk_output(path: Path) -> list[tuple[str, Any]]:
    """Names and data of all that VTK reads, boundaries too."""
    from vtkmodules.vtkIOCGNSReader import vtkCGNSReader

    reader = vtkCGNSReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    reader.EnableAllBases()
    reader.EnableAllFamilies()
    reader.LoadBndPatchOn()
    reader.Update()
    output = reader.GetOutput()
    found, at = [], output.NewIterator()
    at.InitTraversal()
    while not at.IsDoneWithTraversal():
        found.append((at.GetCurrentMetaData().Get(output.NAME()), at.GetCurrentDataObject()))
        at.GoToNextItem()
    return found


def vtk_blocks(path: Path) -> list[tuple[str, int, int]]:
    """Names, points and cells of all that VTK reads."""
    return [(name, block.GetNumberOfPoints(), block.GetNumberOfCells()) for name, block in vtk_output(path)]


def test_vtk_reads_blocks_and_boundaries(tmp_path):
    made = replace(c_shape(4, 10, 3), names={"jmin": "wall", "jmax": "far field", "imin": "out", "imax": "out"})
    mc.io.write(tmp_path / "c.cgns", made)
    expected = [("Internal", 76, 54), ("out", 4, 3), ("out 2", 4, 3), ("wall", 11, 10), ("far field", 19, 18)]
    assert vtk_blocks(tmp_path / "c.cgns") == expected
    volumes = turned_volumes((2, 0, 1), (False, True, False))
    mc.io.write(tmp_path / "v.cgns", volumes)
    inside = [row[1:] for row in vtk_blocks(tmp_path / "v.cgns") if row[0] == "Internal"]
    assert inside == [(block.n_points, block.n_cells) for block in volumes.blocks]


def test_every_node_says_what_it_is(tmp_path):
    """The mapping onto HDF5: attributes of every group, types of its data, names of 32 characters."""
    mc.io.write(tmp_path / "h.cgns", turned_volumes((0, 1, 2), (False,) * 3))
    kinds = {"MT": None, "C1": "i1", "I4": "i4", "R4": "f4", "R8": "f8"}
    labels: Counter[str] = Counter()

    def visit(name: str, item: h5py.Group | h5py.Dataset) -> None:
        if isinstance(item, h5py.Group):
            assert item.attrs["name"].decode() == name.rsplit("/", 1)[-1]
            assert item.attrs.get_id("label").get_type().get_size() == NAME_LENGTH + 1
            data = item.get(" data")
            assert kinds[item.attrs["type"].decode()] == (None if data is None else data.dtype.str[1:])
            labels[item.attrs["label"].decode()] += 1

    with h5py.File(tmp_path / "h.cgns") as file:
        assert bytes(file[" format"][()]).rstrip(b"\0") == b"IEEE_LITTLE_32"
        assert len(file[" hdf5version"]) == NAME_LENGTH + 1
        file.visititems(visit)
    assert labels["Zone_t"] == labels["GridConnectivity1to1_t"] == 2
    assert labels["BC_t"] == 10 and labels["Family_t"] == 4


def test_long_and_odd_names_are_shortened_and_told(tmp_path):
    names = {"imin": "a" * 40, "imax": "a" * 41, "jmin": "up/down"}
    with pytest.warns(mc.io.FormatWarning, match="32 characters"):
        mc.io.write(tmp_path / "n.cgns", replace(grid(), names=names))
    assert mc.io.read(tmp_path / "n.cgns").names == {"imin": "a" * 32, "imax": "a" * 30 + " 2", "jmin": "up_down"}
    assert len(unique("ö" * 40, set()).encode()) <= NAME_LENGTH


def test_surfaces_and_volumes_do_not_go_together(tmp_path):
    with pytest.raises(mc.InvalidInput, match="surfaces and volumes"):
        mc.io.write(tmp_path / "n.cgns", mc.MultiBlock((grid(), grid(layers=1))))


def test_without_h5py_the_error_says_how_to_get_it(tmp_path, monkeypatch):
    mc.io.write(tmp_path / "n.cgns", grid())
    monkeypatch.setitem(sys.modules, "h5py", None)
    for call in (lambda: mc.io.write(tmp_path / "m.cgns", grid()), lambda: mc.io.read(tmp_path / "n.cgns")):
        with pytest.raises(mc.MissingLibrary, match="pip install h5py"):
            call()
    assert not (tmp_path / "m.cgns").exists()


def without(path: str):
    return lambda file: file.pop(path)


def changed(path: str, values: object):
    def change(file: h5py.File) -> None:
        del file[path + "/ data"]
        file[path + "/ data"] = values

    return change


def in_circles(file: h5py.File) -> None:
    file["Base/circle"] = h5py.SoftLink("/Base")


ZONE = "Base/block 0/"
JOIN = ZONE + "ZoneGridConnectivity/middle/"
BAD = {
    "no base": (without("Base"), "no CGNSBase_t"),
    "no zones": (lambda file: (file.pop("Base/block 0"), file.pop("Base/block 1")), "no zones"),
    "no type": (without(ZONE + "ZoneType"), "lacks ZoneType"),
    "another type": (changed(ZONE + "ZoneType", np.frombuffer(b"Cloudy", np.int8)), "is 'Cloudy'"),
    "unstructured": (changed(ZONE + "ZoneType", np.frombuffer(b"Unstructured", np.int8)), "was expected"),
    "no points": (without(ZONE + "GridCoordinates"), "no GridCoordinates_t"),
    "no y": (without(ZONE + "GridCoordinates/CoordinateY"), "lacks CoordinateY"),
    "no values": (without(ZONE + "GridCoordinates/CoordinateY/ data"), "needs"),
    "wrong shape": (changed(ZONE + "GridCoordinates/CoordinateX", np.zeros((5, 4, 2))), "its zone needs"),
    "not finite": (changed(ZONE + "GridCoordinates/CoordinateX", np.full((5, 4, 3), np.nan)), "nan"),
    "text for points": (changed(ZONE + "GridCoordinates/CoordinateX", np.array([b"abc"])), "no number"),
    "size": (changed("Base/block 0", np.zeros((2, 3), np.int32)), "was expected"),
    "negative size": (changed("Base/block 0", np.full((3, 3), -4, np.int32)), "its zone needs"),
    "beyond": (changed(JOIN + "PointRange", np.array([[3, 1, 1], [3, 4, 9]])), "beyond a block"),
    "no donor": (without(JOIN + "PointRangeDonor"), "lacks PointRangeDonor"),
    "no such donor": (changed(JOIN[:-1], np.frombuffer(b"tail", np.int8)), "'tail'"),
    "transform": (changed(JOIN + "Transform", np.array([1, 1, 2], np.int32)), "transform"),
    "circle": (in_circles, "circles"),
    "broken link": (lambda file: file.__setitem__("Base/away", h5py.ExternalLink("gone.cgns", "/")), "leads nowhere"),
}


@pytest.mark.parametrize("name", BAD)
def test_files_that_lie(name, tmp_path):
    change, words = BAD[name]
    mc.io.write(tmp_path / "bad.cgns", turned_volumes((0, 1, 2), (False,) * 3))
    with h5py.File(tmp_path / "bad.cgns", "r+") as file:
        change(file)
    with pytest.raises(mc.InvalidInput, match=words) as caught:
        mc.io.read(tmp_path / "bad.cgns")
    assert "bad.cgns" in str(caught.value)


def test_hdf5_that_is_no_cgns_and_the_old_form(tmp_path):
    with h5py.File(tmp_path / "other.cgns", "w") as file:
        file["x"] = np.arange(3)
    with pytest.raises(mc.InvalidInput, match="not CGNS"):
        mc.io.read(tmp_path / "other.cgns")
    (tmp_path / "old.cgns").write_bytes(b"@(#)ADF Database Version A02011>" + bytes(200))
    with pytest.raises(mc.InvalidInput, match="adf2hdf"):
        mc.io.read(tmp_path / "old.cgns")


def test_what_other_programs_leave_out(tmp_path):
    """Conditions without families are called by their own names; sizes are of 64 bits."""
    mc.io.write(tmp_path / "p.cgns", c_shape(4, 10, 3))
    with h5py.File(tmp_path / "p.cgns", "r+") as file:
        zone = file["Base/grid"]
        conditions = zone["ZoneBC"]
        for name in list(conditions):
            del conditions[name + "/FamilyName"]
        changed("Base/grid", zone[" data"][()].astype(np.int64))(file)
    found = mc.io.read(tmp_path / "p.cgns")
    assert found.names == {"imax": "boundary 2", "jmin": "boundary 3", "jmax": "boundary 4"}
    assert found.cuts == c_shape(4, 10, 3).cuts


# ---- unstructured zones


@pytest.mark.parametrize("made", [curve(), curve(space=True), surface(), surface(space=True), volume()])
@pytest.mark.parametrize("data", [False, True])
def test_meshes_come_back(made, data, tmp_path):
    made = with_data(made) if data else made
    same(round_trip(tmp_path, ".cgns", made), made)


@pytest.mark.parametrize("made", [c_shape(4, 10, 3), h_shape(3), turned_volumes((1, 2, 0), (False,) * 3)])
def test_named_sides_come_back_and_vtk_reads_them(made, tmp_path):
    mesh = mc.with_named_sides(made)
    count = np.arange(mesh.n_cells)
    same(round_trip(tmp_path, ".cgns", mesh), mesh)
    inside = next(row for row in vtk_blocks(tmp_path / "mesh.cgns") if row[0] == "Internal" or row[2] == made.n_cells)
    assert inside[1:] == (mesh.n_points, made.n_cells)
    with pytest.warns(mc.io.FormatWarning, match="of the boundary"):
        mc.io.write(tmp_path / "data.cgns", mc.Mesh(mesh.points, mesh.cells, {}, {"n": count}, mesh.sets))
    found = mc.io.read(tmp_path / "data.cgns").cell_data["n"]
    assert found[: made.n_cells].tolist() == count[: made.n_cells].tolist() and not found[made.n_cells :].any()


def test_sets_of_any_cells_of_the_boundary(tmp_path):
    """Sets whose cells lie apart, share cells, or have two kinds; sets of the domain are told."""
    mesh = volume()
    cells = {**mesh.cells, "quad": [[0, 3, 2, 1], [0, 1, 5, 4], [2, 3, 7, 6], [3, 0, 4, 7]], "triangle": [[4, 5, 8]]}
    sets = {"a": [4, 6], "b": [5, 8], "c": [6, 7], "inside": [0]}
    with pytest.warns(mc.io.FormatWarning, match="'inside'"):
        mc.io.write(tmp_path / "s.cgns", mc.Mesh(mesh.points, cells, sets=sets))
    found = mc.io.read(tmp_path / "s.cgns")

    def corners(mesh: mc.Mesh, name: str) -> set:
        listed = [row for kind in mesh.cells for row in mesh.cells[kind].tolist()]
        return {tuple(listed[k]) for k in mesh.sets[name]}

    given = mc.Mesh(mesh.points, cells, sets=sets)
    assert all(len(found.sets[name]) == 2 for name in found.sets)
    assert set(found.sets) == {"a", "b", "c"}
    assert all(corners(found, name) == corners(given, name) for name in found.sets)


def test_mixed_sections_and_several_zones(tmp_path):
    """As other programs write them: elements that begin with their types, the boundary first."""
    from meshcore.io.cgns_nodes import Node, write_nodes

    base = Node("b", "CGNSBase_t", np.array([2, 2], np.int32))
    for k in range(2):
        zone = base.add(f"part {k}", "Zone_t", np.array([[5], [2], [0]], np.int32))
        zone.add("ZoneType", "ZoneType_t", "Unstructured")
        points = zone.add("GridCoordinates", "GridCoordinates_t")
        points.add("CoordinateX", "DataArray_t", np.array([0, 1, 1, 0, 2], np.float32))
        points.add("CoordinateY", "DataArray_t", np.array([0, 0, 1, 1, 0], np.float32) + k)
        for name, kind, span, nodes in (("edge", 3, (1, 1), (1, 2)), ("all", 20, (2, 3), (7, 1, 2, 3, 4, 5, 2, 5, 3))):
            section = zone.add(name, "Elements_t", np.array([kind, 0], np.int32))
            section.add("ElementRange", "IndexRange_t", np.array(span, np.int32))
            section.add("ElementConnectivity", "DataArray_t", np.array(nodes, np.int32))
        solution = zone.add("s", "FlowSolution_t")
        solution.add("GridLocation", "GridLocation_t", "CellCenter")
        solution.add("n", "DataArray_t", np.array([7, 8], np.int32))
    write_nodes(tmp_path / "two.cgns", [base])
    found = mc.io.read(tmp_path / "two.cgns")
    assert {kind: len(cells) for kind, cells in found.cells.items()} == {"line": 2, "quad": 2, "triangle": 2}
    assert found.cell_data["n"].tolist() == [0, 0, 7, 7, 8, 8]
    assert {"part 0", "part 1"} <= set(found.sets)


MESH = "Base/mesh/"
BAD_MESHES = {
    "no sections": (lambda file: [file.pop(MESH + k) for k in ("quad", "triangle", "wall")], "no Elements_t"),
    "lengths": (changed(MESH + "quad", np.array([22, 0], np.int32)), "begins"),
    "type": (changed(MESH + "quad", np.array([57, 0], np.int32)), "unknown type 57"),
    "no faces": (changed(MESH + "quad", np.array([23, 0], np.int32)), "begins"),
    "short": (changed(MESH + "quad/ElementConnectivity", np.array([1, 2, 3], np.int32)), "promises"),
    "beyond": (changed(MESH + "quad/ElementConnectivity", np.array([1, 2, 3, 77], np.int32)), "76|77"),
    "mixed": (changed(MESH + "quad", np.array([20, 0], np.int32)), "of type 1"),
    "range": (changed(MESH + "quad/ElementRange", np.array([5, 2], np.int32)), "promises"),
    "size": (changed(MESH[:-1], np.array([[6], [9], [0]], np.int32)), None),
}


@pytest.mark.parametrize("name", BAD_MESHES)
def test_meshes_that_lie(name, tmp_path):
    change, words = BAD_MESHES[name]
    plain = surface()
    mesh = mc.Mesh(plain.points, {**plain.cells, "line": [[0, 1], [1, 2]]}, sets={"wall": [3, 4]})
    mc.io.write(tmp_path / "bad.cgns", mesh)
    with h5py.File(tmp_path / "bad.cgns", "r+") as file:
        change(file)
    if words is None:
        assert mc.io.read(tmp_path / "bad.cgns").n_cells == mesh.n_cells
        return
    with pytest.raises(mc.InvalidInput, match=words):
        mc.io.read(tmp_path / "bad.cgns")


def test_sets_of_points_or_of_ends_of_curves_are_told(tmp_path):
    ends = mc.Mesh(curve().points, {**curve().cells, "vertex": [[0], [5]]}, sets={"ends": [3, 4]})
    with pytest.warns(mc.io.FormatWarning, match="'ends'"):
        mc.io.write(tmp_path / "c.cgns", ends)
    assert mc.io.read(tmp_path / "c.cgns").cells["vertex"].tolist() == [[0], [5]]
    plain = surface()
    mesh = mc.Mesh(plain.points, {**plain.cells, "line": [[0, 1], [1, 2]]}, sets={"wall": [3, 4]})
    mc.io.write(tmp_path / "m.cgns", mesh)
    with h5py.File(tmp_path / "m.cgns", "r+") as file:
        del file[MESH + "ZoneBC/wall/GridLocation"]
    with pytest.warns(mc.io.FormatWarning, match="'wall'"):
        assert mc.io.read(tmp_path / "m.cgns").sets == {}


@given(st.dictionaries(st.sampled_from(["imin", "imax", "jmin", "jmax", "kmin", "kmax"]), st.text(max_size=34)))
def test_any_names(names):
    """Those that fit come back as they are, the others as something else, and a face with a name keeps one."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore", mc.io.FormatWarning)
        mc.io.write(Path(folder) / "box.cgns", replace(grid(), names=names))
        found = mc.io.read(Path(folder) / "box.cgns").names
    for face, name in names.items():
        if name == unique(name, set()) and name != "boundary":
            assert found[face] == name
        elif name not in ("", "boundary"):
            assert found[face] not in ("", "boundary")
    assert set(found) <= set(names)
