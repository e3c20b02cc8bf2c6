"""CGNS as other programs write it: curved elements, polygons and polyhedra, families of families, links, rind."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

import meshcore as mc
from meshcore.io.cgns_kinds import ELEMENTS, NFACE, NGON
from meshcore.io.cgns_nodes import Node, read_nodes, write_nodes
from meshcore.mesh.cells import CELL_TYPES
from tests.core.io.round_trip import grid, same, volume
from tests.core.io.test_cgns import vtk_output
from tests.core.io.test_polyhedra import flat, solid
from tests.cut_grids import c_shape

# Corners, from 1, of the nodes behind the corners in the order of CGNS's conventions, after the tables of the standard.
EDGES = {
    "BAR": ((1, 2),),
    "TRI": ((1, 2), (2, 3), (3, 1)),
    "QUAD": ((1, 2), (2, 3), (3, 4), (4, 1)),
    "TETRA": ((1, 2), (2, 3), (3, 1), (1, 4), (2, 4), (3, 4)),
    "PYRA": ((1, 2), (2, 3), (3, 4), (4, 1), (1, 5), (2, 5), (3, 5), (4, 5)),
    "PENTA": ((1, 2), (2, 3), (3, 1), (1, 4), (2, 5), (3, 6), (4, 5), (5, 6), (6, 4)),
    "HEXA": ((1, 2), (2, 3), (3, 4), (4, 1), (1, 5), (2, 6), (3, 7), (4, 8), (5, 6), (6, 7), (7, 8), (8, 5)),
}
INSIDE = {
    "QUAD_9": ((1, 2, 3, 4),),
    "PYRA_14": ((1, 2, 3, 4),),
    "PENTA_18": ((1, 2, 5, 4), (2, 3, 6, 5), (3, 1, 4, 6)),
    "HEXA_27": (
        (1, 2, 3, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 4, 8, 7), (1, 4, 8, 5), (5, 6, 7, 8), (1, 2, 3, 4, 5, 6, 7, 8)
    ),
}  # fmt: skip
# The same in VTK's order, after the drawings of its classes; corners count from 0.
VTK_INSIDE = {
    "quad9": ((0, 1, 2, 3),),
    "wedge18": ((0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    "hexahedron27": (
        (0, 3, 7, 4), (1, 2, 6, 5), (0, 1, 5, 4), (3, 2, 6, 7), (0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 2, 3, 4, 5, 6, 7)
    ),
}  # fmt: skip
CORNERS = {
    "BAR": [[0, 0, 0], [3, 0, 0]],
    "TRI": [[0, 0, 0], [3, 0, 0], [1, 2, 0]],
    "QUAD": [[0, 0, 0], [3, 0, 0], [4, 3, 0], [0, 2, 0]],
    "TETRA": [[0, 0, 0], [3, 0, 0], [1, 2, 0], [1, 1, 5]],
    "PYRA": [[0, 0, 0], [3, 0, 0], [4, 3, 0], [0, 2, 0], [1, 1, 5]],
    "PENTA": [[0, 0, 0], [3, 0, 0], [1, 2, 0], [0, 0, 4], [3, 0, 5], [1, 2, 7]],
    "HEXA": [[0, 0, 0], [3, 0, 0], [4, 3, 0], [0, 2, 0], [0, 0, 4], [3, 0, 5], [4, 3, 7], [0, 2, 4]],
}
CURVED = [
    (number, element)
    for number, element in ELEMENTS.items()
    if CELL_TYPES[element.kind].linear or "PYRA_14" in element.name
]


def zone_of(
    points: np.ndarray, sections: dict[str, tuple], cells: int, dimension: int = 3, **values: np.ndarray
) -> tuple[Node, Node]:
    """A base and its unstructured zone; a section is (type, first element, number of elements, {name: values})."""
    base = Node("Base", "CGNSBase_t", np.array([dimension, 3], np.int32))
    zone = base.add("zone", "Zone_t", np.array([[len(points)], [cells], [0]], np.int32))
    zone.add("ZoneType", "ZoneType_t", "Unstructured")
    coordinates = zone.add("GridCoordinates", "GridCoordinates_t")
    for axis, column in zip("XYZ", np.asarray(points, float).T, strict=True):
        coordinates.add(f"Coordinate{axis}", "DataArray_t", column)
    for name, (number, first, count, arrays) in sections.items():
        section = zone.add(name, "Elements_t", np.array([number, 0], np.int32))
        section.add("ElementRange", "IndexRange_t", np.array([first, first + count - 1], np.int32))
        for key, array in arrays.items():
            section.add(key, "DataArray_t", np.asarray(array, np.int32))
    return base, zone


def condition(zone: Node, name: str, family: str = "", **children: object) -> None:
    group = zone.find("ZoneBC") or zone.add("ZoneBC", "ZoneBC_t")
    made = group.add(name, "BC_t", "FamilySpecified")
    for key, value in children.items():
        label = {"PointRange": "IndexRange_t", "GridLocation": "GridLocation_t"}.get(key, "IndexArray_t")
        made.add(key, label, value if isinstance(value, str) else np.asarray(value, np.int32))
    if family:
        made.add("FamilyName", "FamilyName_t", family)


def as_read(path: Path, base: Node) -> mc.Mesh:
    write_nodes(path, [base])
    return mc.io.read(path)


@pytest.mark.parametrize(("number", "element"), CURVED)
def test_curved_elements_of_the_standard(number, element, tmp_path):
    """Each node beyond the corners is the mean of those that the standard's tables say, and is so in VTK's order."""
    shape = element.name.split("_")[0]
    corners = np.array(CORNERS[shape], float)
    places = [*EDGES[shape], *INSIDE.get(element.name, ())]
    points = np.array([*corners, *(corners[np.array(place) - 1].mean(axis=0) for place in places)])
    assert len(points) == element.nodes
    kind = CELL_TYPES[element.kind]
    nodes = {"ElementConnectivity": np.arange(len(points)) + 1}
    base, _ = zone_of(points, {"all": (number, 1, 1, nodes)}, 1, kind.dimension)
    if element.name == "PYRA_14":
        with pytest.warns(mc.io.FormatWarning, match=r"'PYRA_14' left out: they are read as pyramid13"):
            mesh = as_read(tmp_path / "a.cgns", base)
        assert mesh.n_points == 13
    else:
        mesh = as_read(tmp_path / "a.cgns", base)
    found = mesh.points[mesh.cells[element.kind][0]]
    linear = CELL_TYPES[kind.linear]
    expected = [*linear.edges, *VTK_INSIDE.get(element.kind, ())]
    np.testing.assert_allclose(found[: linear.nodes], corners)
    np.testing.assert_allclose(found[linear.nodes :], [corners[list(place)].mean(axis=0) for place in expected])
    mc.io.write(tmp_path / "b.cgns", mesh)
    same(mc.io.read(tmp_path / "b.cgns"), mesh)


@pytest.mark.parametrize("kind", ["triangle6", "quad8", "quad9", "tetra10", "hexahedron20", "hexahedron27", "wedge15"])
def test_vtk_reads_curved_cells_alike(kind, tmp_path):
    chance = np.random.default_rng(0)
    nodes = CELL_TYPES[kind].nodes
    made = mc.Mesh(chance.random((2 * nodes, 3)), {kind: chance.permutation(2 * nodes).reshape(2, nodes)})
    mc.io.write(tmp_path / "a.cgns", made)
    found = next(block for _, block in vtk_output(tmp_path / "a.cgns") if block.GetNumberOfCells())
    for k, cell in enumerate(made.cells[kind]):
        held = found.GetCell(k)
        assert held.GetCellType() == CELL_TYPES[kind].vtk
        assert [held.GetPointId(n) for n in range(nodes)] == cell.tolist()


def test_cubic_elements_keep_their_corners(tmp_path):
    """Points that only they had go, data with them; others that no cell has stay."""
    points = np.random.default_rng(0).random((11, 3))
    nodes = {"ElementConnectivity": [3, 1, 2, *range(4, 11)]}
    base, zone = zone_of(points, {"all": (26, 1, 1, nodes)}, 1, 2)
    zone.add("u", "FlowSolution_t").add("u", "DataArray_t", np.arange(11.0))
    with pytest.warns(mc.io.FormatWarning, match="'TRI_10'"):
        mesh = as_read(tmp_path / "a.cgns", base)
    assert mesh.cells["triangle"].tolist() == [[2, 0, 1]]
    assert mesh.point_data["u"].tolist() == [0, 1, 2, 10]


# ---- polygons and polyhedra


def test_polyhedra_come_back_and_vtk_sees_them(tmp_path):
    points = np.random.default_rng(3).random((40, 3))
    made, _ = mc.voronoi_3d(points)
    made = made.with_cell_data(site=np.arange(40)).with_point_data(u=made.points[:, 0])
    mc.io.write(tmp_path / "a.cgns", made)
    found = mc.io.read(tmp_path / "a.cgns")
    assert isinstance(found, mc.PolyhedralMesh)
    np.testing.assert_allclose(found.volumes, made.volumes, rtol=1e-12)
    np.testing.assert_array_equal(found.neighbours, made.neighbours)
    assert found.cell_data["site"].tolist() == list(range(40))
    inside = next(block for name, block in vtk_output(tmp_path / "a.cgns") if name == "Internal")
    corners = [set(_points_of(inside.GetCell(k))) for k in range(40)]
    offsets, faces = made.cell_faces
    expected = [
        {n for f in faces[a:b] for n in made.face_nodes[made.face_offsets[f] : made.face_offsets[f + 1]].tolist()}
        for a, b in itertools.pairwise(offsets)
    ]
    assert corners == expected


def _points_of(cell) -> list[int]:
    return [cell.GetPointId(n) for n in range(cell.GetNumberOfPoints())]


def test_polygons_come_back(tmp_path):
    made = flat()
    mc.io.write(tmp_path / "a.cgns", made)
    found = mc.io.read(tmp_path / "a.cgns")
    assert found.face_nodes.tolist() == made.face_nodes.tolist() and found.cell_data["site"].tolist() == [7, 3]
    few = mc.PolyhedralMesh([[0, 0], [1, 0], [1, 1], [0, 1], [2, 0]], [0, 4, 7], [0, 1, 2, 3, 1, 4, 2])
    mc.io.write(tmp_path / "b.cgns", few)
    assert mc.io.read(tmp_path / "b.cgns").cells["triangle"].tolist() == [[1, 4, 2]]


def faces_of(mesh: mc.Mesh) -> tuple[list[list[int]], list[list[int]]]:
    """Each face once, as the first cell sees it, and for each cell its faces from 1, with signs."""
    number: dict[frozenset, int] = {}
    faces, cells = [], []
    for kind, table in mesh.cells.items():
        for cell in table.tolist():
            seen = []
            for facet in CELL_TYPES[kind].facets:
                nodes = [cell[k] for k in facet]
                new = frozenset(nodes) not in number
                k = number.setdefault(frozenset(nodes), len(faces))
                faces += [nodes] if new else []
                seen.append(k + 1 if new else -k - 1)
            cells.append(seen)
    return faces, cells


def listed(rows: list[list[int]], style: str) -> dict[str, list[int]]:
    """Rows of any length as they stand since CGNS 3.4, or before, behind their lengths."""
    if style == "lengths":
        return {"ElementConnectivity": [n for row in rows for n in (len(row), *row)]}
    flat_rows = [n for row in rows for n in row]
    return {"ElementConnectivity": flat_rows, "ElementStartOffset": np.cumsum([0, *map(len, rows)])}


@pytest.mark.parametrize("style", ["offsets", "lengths", "parents", "cells first"])
def test_polyhedra_of_standard_shape_are_such_cells(style, tmp_path):
    """As CFD codes write hexahedra, wedges, pyramids and tetrahedra; boundary conditions hold faces."""
    mesh = volume()
    faces, cells = faces_of(mesh)
    first = 1 if style != "cells first" else 1 + len(cells)
    arrays = listed([[n + 1 for n in face] for face in faces], style)
    if style == "parents":
        parents = np.zeros((2, len(faces)), int)
        for k, seen in enumerate(cells):
            for face in seen:
                parents[int(face < 0), abs(face) - 1] = len(faces) + 1 + k
        arrays["ParentElements"] = parents
    sections = {"faces": (NGON, first, len(faces), arrays)}
    if style != "parents":
        shifted = [[face + np.sign(face) * (first - 1) for face in seen] for seen in cells]
        begin = 1 if style == "cells first" else 1 + len(faces)
        sections["cells"] = (NFACE, begin, len(cells), listed(shifted, style))
    base, zone = zone_of(mesh.points, sections, len(cells))
    bottom = [k for k, face in enumerate(faces) if (mesh.points[face][:, 2] == 0).all()]
    condition(zone, "bc", "ground", PointList=np.array(bottom)[:, None] + first, GridLocation="FaceCenter")
    zone.add("s", "FlowSolution_t").add("GridLocation", "GridLocation_t", "CellCenter")
    zone.find("s").add("n", "DataArray_t", np.arange(float(len(cells))))
    found = as_read(tmp_path / "a.cgns", base)
    expected = {kind: sorted(map(sorted, table.tolist())) for kind, table in mesh.cells.items()}
    kinds = {kind: sorted(map(sorted, found.cells[kind].tolist())) for kind in mesh.cells}
    assert kinds == expected
    assert mc.quality.measure(found, "volume")[: mesh.n_cells].sum() == pytest.approx(
        mc.quality.measure(mesh, "volume").sum()
    )
    assert (mc.quality.measure(found, "volume")[: mesh.n_cells] > 0).all()
    rows = [row for table in found.cells.values() for row in table.tolist()]
    assert sorted(sorted(rows[k]) for k in found.sets["ground"]) == sorted(sorted(faces[k]) for k in bottom)
    given = [row for table in mesh.cells.values() for row in map(sorted, table.tolist())]
    assert [given[int(n)] for n in found.cell_data["n"][: mesh.n_cells]] == [
        sorted(row) for row in rows[: mesh.n_cells]
    ]


def test_faces_that_each_cell_lists_for_itself(tmp_path):
    """As ParaView writes polyhedra: inner faces twice, all looking outward."""
    mesh = solid()
    rows, nodes, count = mc.io.polyhedra.rows_of_cells(mesh)
    faces = [(nodes[a:b] + 1).tolist() for a, b in itertools.pairwise(rows)]
    ends = np.cumsum(count)
    cells = [list(range(b - n + 1, b + 1)) for n, b in zip(count, ends, strict=True)]
    sections = {
        "f": (NGON, 1, len(faces), listed(faces, "offsets")),
        "c": (NFACE, len(faces) + 1, len(cells), listed(cells, "offsets")),
    }
    found = as_read(tmp_path / "a.cgns", zone_of(mesh.points, sections, len(cells))[0])
    assert found.cells["hexahedron"].shape == (4, 8)
    assert mc.quality.measure(found, "volume").sum() == pytest.approx(mesh.volumes.sum())


def bare(mesh):
    """A mesh without data."""
    return replace(mesh, point_data={}, cell_data={})


def zones_together(folder, *meshes):
    """A base with the zones of several meshes, each as it is written alone."""
    base = Node("Base", "CGNSBase_t", np.array([meshes[0].dimension, 3], np.int32))
    for k, mesh in enumerate(meshes):
        mc.io.write(folder / "one.cgns", mesh)
        for zone in next(read_nodes(folder / "one.cgns").of("CGNSBase_t")).of("Zone_t"):
            zone.name = f"zone {k}"
            base.children.append(zone)
    return base


def test_polyhedra_of_several_zones_are_one_mesh(tmp_path):
    """Other solid cells beside them become polyhedra; all volumes, neighbours and data are those of the zones."""
    cells, _ = mc.voronoi_3d(np.random.default_rng(3).random((12, 3)))
    cells = cells.with_cell_data(site=np.arange(12.0)).with_point_data(u=cells.points[:, 0])
    solids = volume().with_cell_data(site=np.arange(volume().n_cells) + 100.0).with_point_data(u=volume().points[:, 1])
    grid = mc.StructuredGrid(np.stack(np.meshgrid([5, 6, 7], [0, 1], [0, 2], indexing="ij"), -1))
    parts = [cells, solids, grid]
    with pytest.warns(mc.io.FormatWarning, match="not all blocks have it alike"):  # the grid has no data
        found = as_read(tmp_path / "a.cgns", zones_together(tmp_path, *parts))
    assert isinstance(found, mc.PolyhedralMesh)
    assert found.field_data["zone names"].tolist() == ["zone 0", "zone 1", "zone 2"]
    volumes = [cells.volumes, mc.quality.measure(solids, "volume"), [2.0, 2.0]]
    expected = np.repeat(np.arange(3), [len(of_zone) for of_zone in volumes])
    np.testing.assert_array_equal(found.cell_data["zone"], expected)
    np.testing.assert_allclose(found.volumes, np.concatenate(volumes), rtol=1e-12)
    facets = solids.facets
    pairs = [cells.neighbours, np.stack([facets.owner, facets.neighbour], 1)[facets.neighbour >= 0]]
    inner = {frozenset(pair) for pair in found.neighbours.tolist()}
    shifted = {
        frozenset(n + start for n in pair) for some, start in zip(pairs, (0, 12), strict=True) for pair in some.tolist()
    }
    last = found.n_cells - 2
    assert inner == shifted | {frozenset({last, last + 1})}
    both = as_read(tmp_path / "b.cgns", zones_together(tmp_path, cells, solids))
    np.testing.assert_array_equal(both.cell_data["site"], [*range(12), *range(100, 100 + solids.n_cells)])
    np.testing.assert_array_equal(both.point_data["u"], np.concatenate([cells.points[:, 0], solids.points[:, 1]]))


def test_polygons_of_several_zones_are_one_mesh(tmp_path):
    few = mc.Mesh(
        [[3, 0, 0], [4, 0, 0], [4, 1, 0], [3, 1, 0], [5, 0, 0]], {"quad": [[0, 1, 2, 3]], "triangle": [[1, 4, 2]]}
    )
    found = as_read(tmp_path / "a.cgns", zones_together(tmp_path, bare(flat()), few))
    np.testing.assert_allclose(found.volumes, [*flat().volumes, 1, 0.5])
    assert found.cell_data["zone"].tolist() == [0] * flat().n_cells + [1, 1]


def test_connections_of_meshes_are_told(tmp_path):
    base = zones_together(tmp_path, solid(), solid())
    group = base.children[-1].add("ZoneGridConnectivity", "ZoneGridConnectivity_t")
    group.add("to the first", "GridConnectivity_t", "zone 0")
    with pytest.warns(mc.io.FormatWarning, match="'to the first' left out: zones of a mesh do not share points"):
        as_read(tmp_path / "a.cgns", base)


def test_zones_that_do_not_go_with_polyhedra(tmp_path):
    cells = bare(mc.voronoi_3d(np.random.default_rng(3).random((12, 3))).mesh)
    curved = mc.Mesh(np.random.default_rng(0).random((10, 3)), {"tetra10": [range(10)]})
    with pytest.raises(mc.InvalidInput, match="'zone 1' has tetra10 cells"):
        as_read(tmp_path / "a.cgns", zones_together(tmp_path, cells, curved))
    with pytest.raises(mc.InvalidInput, match="'zone 0' has polygons"):
        as_read(tmp_path / "a.cgns", zones_together(tmp_path, bare(flat()), cells))
    named = mc.Mesh(volume().points, volume().cells | {"triangle": [volume().cells["tetra"][0][:3]]})
    named = replace(named, sets={"wall": [named.n_cells - 1]})
    with pytest.warns(mc.io.FormatWarning, match="'zone 1/wall' left out: a PolyhedralMesh has no sets"):
        as_read(tmp_path / "a.cgns", zones_together(tmp_path, cells, named))


def cube(**changes: tuple) -> Node:
    mesh = mc.Mesh(
        [[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], {"hexahedron": [[0, 1, 3, 2, 4, 5, 7, 6]]}
    )
    faces, cells = faces_of(mesh)
    sections = {
        "f": (NGON, 1, 6, listed([[n + 1 for n in face] for face in faces], "offsets")),
        "c": (NFACE, 7, 1, listed(cells, "offsets")),
    }
    return zone_of(mesh.points, {**sections, **changes}, 1)[0]


LIES = {
    "a face that is not there": ({"c": (NFACE, 7, 1, listed([[1, 2, 3, 4, 5, 9]], "offsets"))}, "face 9"),
    "no face": ({"c": (NFACE, 7, 1, listed([[0, 2, 3, 4, 5, 6]], "offsets"))}, "face 0"),
    "no faces": ({"f": (7, 1, 1, {"ElementConnectivity": [1, 2, 4, 3]})}, "no faces"),
    "three faces": ({"c": (NFACE, 7, 1, listed([[1, 2, 3]], "offsets"))}, "faces"),
    "a point that is not there": ({"f": (NGON, 1, 1, listed([[1, 2, 99]], "offsets"))}, "9|face"),
    "offsets beyond": (
        {"c": (NFACE, 7, 1, {"ElementConnectivity": [1, 2, 3, 4], "ElementStartOffset": [0, 9]})},
        "begins",
    ),
    "offsets back": (
        {"f": (NGON, 1, 2, {"ElementConnectivity": [1, 2, 3, 4], "ElementStartOffset": [0, 5, 4]})},
        "begins",
    ),
    "lengths beyond": ({"f": (NGON, 1, 2, {"ElementConnectivity": [3, 1, 2, 3, 9, 1, 2]})}, "begins"),
    "negative length": ({"f": (NGON, 1, 2, {"ElementConnectivity": [-3, 1, 2, 3]})}, "ends within"),
    "more elements than memory": ({"f": (7, 1, 2**31 - 2, {"ElementConnectivity": [1, 2, 4, 3]})}, "got 4 nodes"),
    "other cells": ({"h": (10, 8, 1, {"ElementConnectivity": [1, 2, 3, 5]})}, "TETRA_4 beside polyhedra"),
}


@pytest.mark.parametrize("name", LIES)
def test_polyhedra_that_lie(name, tmp_path):
    changes, words = LIES[name]
    write_nodes(tmp_path / "a.cgns", [cube(**changes)])
    with pytest.raises(mc.InvalidInput, match=words) as caught:
        mc.io.read(tmp_path / "a.cgns")
    assert "a.cgns" in str(caught.value)


def test_conditions_of_polyhedra_are_told(tmp_path):
    points = np.random.default_rng(3).random((12, 3))
    mc.io.write(tmp_path / "a.cgns", mc.voronoi_3d(points).mesh)
    with h5py.File(tmp_path / "a.cgns", "r+") as file:
        zone = Node("ZoneBC", "ZoneBC_t")
        condition(zone, "bc", "wall", PointRange=[[1], [3]], GridLocation="FaceCenter")
        from meshcore.io import cgns_nodes

        cgns_nodes._write_node(h5py, file["Base/mesh"], zone.children[0])
    with pytest.warns(mc.io.FormatWarning, match="'wall' left out: a PolyhedralMesh has no sets"):
        mc.io.read(tmp_path / "a.cgns")


# ---- bases, families, conditions


def test_of_several_bases_one_is_chosen(tmp_path):
    first, second = (
        zone_of(volume().points, {"c": (10, 1, 1, {"ElementConnectivity": [6, 11, 7, 12]})}, 1)[0] for _ in "ab"
    )
    second.name = "Coarse"
    second.children[0].find("c").find("ElementConnectivity").value = np.array([1, 2, 4, 5], np.int32)
    write_nodes(tmp_path / "a.cgns", [first, second])
    with pytest.warns(
        mc.io.FormatWarning, match=r"'Coarse' left out: 'Base', the first, is read; read\(path, base=name\)"
    ):
        assert mc.io.read(tmp_path / "a.cgns").cells["tetra"].tolist() == [[5, 10, 6, 11]]
    assert mc.io.read(tmp_path / "a.cgns", base="Coarse").cells["tetra"].tolist() == [[0, 1, 3, 4]]
    with pytest.raises(mc.InvalidInput, match=r"no base 'Coars', only 'Base', 'Coarse'; did you mean 'Coarse'\?"):
        mc.io.read(tmp_path / "a.cgns", base="Coars")
    with pytest.raises(mc.InvalidInput, match="no such option; it has base"):
        mc.io.read(tmp_path / "a.cgns", bass="Coarse")


def test_families_of_families(tmp_path):
    """As Gmsh writes physical groups: each entity's family belongs to those of its groups."""
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    sections = {
        "edges": (3, 1, 4, {"ElementConnectivity": [1, 2, 2, 3, 3, 4, 4, 1]}),
        "face": (7, 5, 1, {"ElementConnectivity": [1, 2, 3, 4]}),
    }
    base, zone = zone_of(points, sections, 1, 2)
    for name, groups in (("L_1", ["wall"]), ("L_2", ["wall", "hot"]), ("wall", ["all", "L_1"])):
        family = base.add(name, "Family_t")
        for group in groups:
            family.add(group, "FamilyName_t", group)
    condition(zone, "L_1", "L_1", PointRange=[[1], [1]], GridLocation="CellCenter")
    condition(zone, "L_2", "L_2", PointRange=[[2], [3]], GridLocation="CellCenter")
    condition(zone, "rest", ElementList=[[4]])
    condition(zone, "none", PointRange=np.empty((0, 1)), GridLocation="EdgeCenter")
    found = as_read(tmp_path / "a.cgns", base)
    sets = {name: members.tolist() for name, members in found.sets.items()}
    assert sets == {
        "L_1": [0, 1, 2],
        "wall": [0, 1, 2],
        "all": [0, 1, 2],
        "L_2": [1, 2],
        "hot": [1, 2],
        "rest": [3],
        "none": [],
    }


@pytest.mark.parametrize("layers", [1, 3])
def test_conditions_by_faces_and_by_lists_of_points(layers, tmp_path):
    """Ranges of faces between points, and lists of points that fill a rectangle, are sides as ranges of points are."""
    mc.io.write(tmp_path / "a.cgns", replace(grid(layers=layers), names={"imin": "a", "jmax": "b", "imax": "c"}))
    expected = mc.io.read(tmp_path / "a.cgns").names
    axes = 3 if layers > 1 else 2
    with h5py.File(tmp_path / "a.cgns", "r+") as file:
        conditions = file["Base/grid/ZoneBC"]
        for name, place, across in (("a", "IFaceCenter", 0), ("c", "FaceCenter", 0)):
            span = conditions[f"{name}/PointRange"]
            values = span[" data"][()]
            values[1, [k for k in range(axes) if k != across]] -= 1
            span[" data"][...] = values
            location = conditions[name].create_group("GridLocation")
            location.attrs["label"], location.attrs["type"] = np.bytes_("GridLocation_t"), np.bytes_("C1")
            location[" data"] = np.frombuffer(place.encode(), np.int8)
        low, high = conditions["b/PointRange/ data"][()]
        every = np.stack(np.meshgrid(*map(np.arange, low, high + 1)), axis=-1).reshape(-1, axes).astype(np.int32)
        made = conditions["b"].create_group("PointList")
        made.attrs["label"], made.attrs["type"] = np.bytes_("IndexArray_t"), np.bytes_("I4")
        made[" data"] = every[::-1]
        del conditions["b/PointRange"]
    assert mc.io.read(tmp_path / "a.cgns").names == expected == {"imin": "a", "jmax": "b", "imax": "c"}
    with h5py.File(tmp_path / "a.cgns", "r+") as file:
        del file["Base/grid/ZoneBC/b/PointList/ data"]
        file["Base/grid/ZoneBC/b/PointList/ data"] = every[1:]
    if layers > 1:
        with pytest.warns(mc.io.FormatWarning, match="'b' left out: they are no rectangle"):
            assert "jmax" not in mc.io.read(tmp_path / "a.cgns").names


# ---- links and rind


def test_links_lead_into_other_files(tmp_path):
    """As CGNS's library writes them: a node of type LK whose member " link" is HDF5's."""
    made = c_shape(4, 10, 3)
    mc.io.write(tmp_path / "grid.cgns", made)
    mc.io.write(tmp_path / "flow.cgns", made)
    with h5py.File(tmp_path / "flow.cgns", "r+") as file:
        zone = file["Base/grid"]
        del zone["GridCoordinates"]
        group = zone.create_group("GridCoordinates")
        group.attrs["name"], group.attrs["label"], group.attrs["type"] = map(np.bytes_, ("GridCoordinates", "", "LK"))
        group[" link"] = h5py.ExternalLink("grid.cgns", "/Base/grid/GridCoordinates")
    same(mc.io.read(tmp_path / "flow.cgns"), made)
    (tmp_path / "grid.cgns").unlink()
    with pytest.raises(mc.InvalidInput, match=r"flow.cgns .*one of its links leads nowhere"):
        mc.io.read(tmp_path / "flow.cgns")
    with h5py.File(tmp_path / "flow.cgns", "r+") as file:
        del file["Base/grid/GridCoordinates/ link"]
        file["Base/grid/GridCoordinates/ link"] = h5py.SoftLink("/Base/grid/GridCoordinates")
    with pytest.raises(mc.InvalidInput, match="in circles"):
        mc.io.read(tmp_path / "flow.cgns")


def test_rind_is_taken_off(tmp_path):
    plain = grid(layers=3)
    count = np.arange(float(plain.n_cells)).reshape(plain.cell_shape)
    mc.io.write(tmp_path / "a.cgns", mc.StructuredGrid(plain.points, {}, {"p": count}))
    with h5py.File(tmp_path / "a.cgns", "r+") as file:
        solution = file["Base/grid/CellData"]
        del solution["p/ data"]
        solution["p/ data"] = np.pad(count, ((1, 0), (2, 1), (0, 0)), constant_values=-9).T
        rind = solution.create_group("Rind")
        rind.attrs["label"], rind.attrs["type"] = np.bytes_("Rind_t"), np.bytes_("I4")
        rind[" data"] = np.array([1, 0, 2, 1, 0, 0], np.int32)
    np.testing.assert_array_equal(mc.io.read(tmp_path / "a.cgns").cell_data["p"], count)
    with h5py.File(tmp_path / "a.cgns", "r+") as file:
        file["Base/grid/CellData/Rind/ data"][...] = np.array([1, 0, 1, 1, 0, 0])
    with pytest.raises(mc.InvalidInput, match="its zone needs"):
        mc.io.read(tmp_path / "a.cgns")
