"""Files as other programs write them, by hand, and what they must mean."""

from __future__ import annotations

import itertools
import struct
import tempfile
from pathlib import Path

import meshio
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from meshio.gmsh.common import _gmsh_to_meshio_order

import meshcore as mc


def read(folder: Path, name: str, content: str | bytes) -> mc.Mesh:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return mc.io.read(path)


# ---- Triangle

BOX = """# A box with eight points in the plane, no attributes, one marker.
8 2 0 1
 # Outer box has these vertices:
 1   0 0   0
 2   0 3   0
 3   3 0   0
 4   3 3   33     # A special marker for this vertex.
 # Inner square has these vertices:
 5   1 1   0
 6   1 2   0
 7   2 1   0
 8   2 2   0
# Five segments with boundary markers.
5 1
 1   1 2   5
 2   5 7   0
 3   7 8   0
 4   8 6   10
 5   6 5   0
# One hole in the middle of the inner square.
1
 1   1.5 1.5
"""


def test_box_of_triangle(tmp_path: Path) -> None:
    mesh = read(tmp_path, "box.poly", BOX)
    assert mesh.n_points == 8
    assert mesh.cells["line"].tolist() == [[0, 1], [4, 6], [6, 7], [7, 5], [5, 4]]
    assert mesh.cell_data["tag"].tolist() == [5, 0, 0, 10, 0]
    assert mesh.point_data["tag"].tolist() == [0, 0, 0, 33, 0, 0, 0, 0]
    assert mesh.field_data["holes"].tolist() == [[1.5, 1.5]]


def test_poly_on_the_points_of_a_node_file(tmp_path: Path) -> None:
    (tmp_path / "box.1.node").write_text(
        "4 2 2 0\n0 0 0 1.5 7\n1 1 0 2.5 8\n2 1 1 3.5 9\n3 0 1 4.5 10\n# by triangle\n"
    )
    mesh = read(tmp_path, "box.1.poly", "0 2 0 0\n2 0\n0 0 1\n1 1 2\n0\n2\n0 .5 .5 7 0.1\n1 .2 .2 8\n")
    assert mesh.cells["line"].tolist() == [[0, 1], [1, 2]]
    assert mesh.point_data["attribute 1"].tolist() == [1.5, 2.5, 3.5, 4.5]
    assert mesh.point_data["attribute 2"].tolist() == [7, 8, 9, 10]
    assert mesh.field_data["regions"].tolist() == [[0.5, 0.5, 7, 0.1], [0.2, 0.2, 8, -1]]


@pytest.mark.parametrize("name", ["mesh.ele", "mesh.node"])
def test_pair_of_node_and_ele(name: str, tmp_path: Path) -> None:
    (tmp_path / "mesh.node").write_text("4 2 0 1\n1 0 0 1\n2 1 0 1\n3 1 1 1\n4 0 1 1\n")
    (tmp_path / "mesh.ele").write_text("2 3 1\n1 1 2 3 5\n2 1 3 4 6\n")
    mesh = mc.io.read(tmp_path / name)
    assert mesh.cells["triangle"].tolist() == [[0, 1, 2], [0, 2, 3]]
    assert mesh.cell_data["attribute 1"].tolist() == [5, 6]


def test_second_order_triangles(tmp_path: Path) -> None:
    """Triangle's middle nodes stand opposite the corners; in a Mesh each is the middle of its own edge."""
    points = np.array([[0, 0], [1, 0], [0, 1], [0.5, 0.5], [0, 0.5], [0.5, 0]])
    rows = [f"{k} {x} {y}" for k, (x, y) in enumerate(points.tolist())]
    (tmp_path / "mesh.node").write_text("\n".join(["6 2 0 0", *rows]))
    mesh = read(tmp_path, "mesh.ele", "1 6 0\n0 0 1 2 3 4 5\n")
    nodes = mesh.points[mesh.cells["triangle6"][0]]
    np.testing.assert_array_equal(nodes[3:], (nodes[:3] + nodes[[1, 2, 0]]) / 2)
    mc.io.write(tmp_path / "again.ele", mesh)
    assert (tmp_path / "again.ele").read_text().splitlines()[1].split()[1:] == ["1", "2", "3", "4", "5", "6"]


def test_names_of_triangle_data_come_back(tmp_path: Path) -> None:
    points = [[0, 0], [1, 0], [0, 1 / 3]]
    mesh = mc.Mesh(points, {"triangle": [[0, 1, 2]]}, {"u": np.sqrt([1, 2, 3])}, {"region": [7], "area": [1 / 6]})
    mc.io.write(tmp_path / "mesh.ele", mesh)
    found = mc.io.read(tmp_path / "mesh.ele")
    assert found.cell_data["region"].tolist() == [7]
    assert found.cell_data["area"].tolist() == [1 / 6]
    np.testing.assert_array_equal(found.point_data["u"], mesh.point_data["u"])
    boundary = mc.Mesh(points, {"line": [[0, 1], [1, 2]]}, {}, {}, {"wall": [1], "inlet": [0]})
    mc.io.write(tmp_path / "edge.poly", boundary)
    assert {k: v.tolist() for k, v in mc.io.read(tmp_path / "edge.poly").sets.items()} == {"wall": [1], "inlet": [0]}


# ---- Gmsh

GMSH_2 = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
2
1 1 "inlet pipe"
2 6 "fluid"
$EndPhysicalNames
$Nodes
6
1 0.0 0.0 0.0
2 1.0 0.0 0.0
3 1.0 1.0 0.0
4 0.0 1.0 0.0
15 2.0 0.0 0.0
6 2.0 1.0 0.0
$EndNodes
$Elements
4
7 1 2 1 4 1 4
1 3 2 6 2 1 2 3 4
2 3 2 6 2 2 15 6 3
3 1 2 0 4 15 6
$EndElements
$NodeData
1
"A scalar view"
1
0.0
3
0
1
3
1 0.5
2 0.25
6 0.125
$EndNodeData
"""

GMSH_4 = """$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
1
2 1 "My surface"
$EndPhysicalNames
$Entities
1 1 1 0
1 0 0 0 0
5 0 0 0 1 0 0 1 9 2 1 -1
1 0 0 0 2 1 0 1 1 0
$EndEntities
$Nodes
1 6 1 6
2 1 0 6
1
2
3
4
5
6
0. 0. 0.
1. 0. 0.
1. 1. 0.
0. 1. 0.
2. 0. 0.
2. 1. 0.
$EndNodes
$Elements
2 3 1 3
1 5 1 1
3 1 2
2 1 3 2
1 1 2 3 4
2 2 5 6 3
$EndElements
$ElementData
1
"cost"
1
0.0
3
0
1
2
2 7.5
1 8.5
$EndElementData
"""


def test_gmsh_2(tmp_path: Path) -> None:
    mesh = read(tmp_path, "mesh.msh", GMSH_2)
    assert mesh.cells["quad"].tolist() == [[0, 1, 2, 3], [1, 4, 5, 2]]
    assert mesh.cells["line"].tolist() == [[0, 3], [4, 5]]
    kinds = list(mesh.cells)
    number = {"line": 0 if kinds[0] == "line" else 2, "quad": 0 if kinds[0] == "quad" else 2}
    assert mesh.sets["inlet pipe"].tolist() == [number["line"]]
    assert mesh.sets["fluid"].tolist() == [number["quad"], number["quad"] + 1]
    values = mesh.point_data["A scalar view"]
    np.testing.assert_array_equal(values, [0.5, 0.25, np.nan, np.nan, np.nan, 0.125])


def test_gmsh_4(tmp_path: Path) -> None:
    mesh = read(tmp_path, "mesh.msh", GMSH_4)
    assert mesh.cells["quad"].tolist() == [[0, 1, 2, 3], [1, 4, 5, 2]]
    assert mesh.sets["My surface"].tolist() == [1, 2]
    assert mesh.cell_data["tag"].tolist() == [9, 1, 1]
    np.testing.assert_array_equal(mesh.cell_data["cost"], [np.nan, 8.5, 7.5])


def gmsh_4_binary(order: str) -> bytes:
    """The quads of `GMSH_4` as Gmsh's binary."""
    points = [0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 2, 0, 0, 2, 1, 0]
    parts = [b"$MeshFormat\n4.1 1 8\n", struct.pack(order + "i", 1), b"\n$EndMeshFormat\n"]
    parts += [b"$Entities\n", struct.pack(order + "4Q", 0, 0, 1, 0)]
    parts += [struct.pack(order + "i6dQiQ", 1, 0, 0, 0, 2, 1, 0, 1, 12, 0), b"\n$EndEntities\n"]
    parts += [b"$Nodes\n", struct.pack(order + "4Q3iQ6Q18d", 1, 6, 1, 6, 2, 1, 0, 6, *range(1, 7), *points)]
    parts += [b"\n$EndNodes\n$Elements\n", struct.pack(order + "4Q3iQ", 1, 2, 1, 2, 2, 1, 3, 2)]
    parts += [struct.pack(order + "10Q", 1, 1, 2, 3, 4, 2, 2, 5, 6, 3), b"\n$EndElements\n"]
    return b"".join(parts)


@pytest.mark.parametrize("order", "<>")
def test_gmsh_4_binary(order: str, tmp_path: Path) -> None:
    mesh = read(tmp_path, "mesh.msh", gmsh_4_binary(order))
    assert mesh.cells["quad"].tolist() == [[0, 1, 2, 3], [1, 4, 5, 2]]
    assert mesh.points[5].tolist() == [2, 1, 0]
    assert mesh.cell_data["tag"].tolist() == [12, 12]


EDGE_KINDS = ["tetra10", "hexahedron20", "wedge15", "pyramid13", "triangle6", "quad8", "line3"]


@pytest.mark.parametrize("kind", EDGE_KINDS)
def test_gmsh_order_of_middle_nodes(kind: str, tmp_path: Path) -> None:
    """meshio, which has a table of Gmsh's order of its own, agrees."""
    n = mc.mesh.CELL_TYPES[kind].nodes
    points = np.random.default_rng(5).random((n, 3))
    mc.io.write(tmp_path / "ours.msh", mc.Mesh(points, {kind: [np.arange(n)]}), binary=False)
    lines = (tmp_path / "ours.msh").read_text().splitlines()
    nodes = [int(word) - 1 for word in lines[lines.index("$Elements") + 2].split()[5:]]
    np.testing.assert_array_equal(_gmsh_to_meshio_order(kind, np.array([nodes])), [np.arange(n)])


# Places of all nodes in Gmsh's own order, as its getElementProperties tells them for types 12 and 13.
GMSH_PLACES = {
    "hexahedron27": (
        12,
        "--- +-- ++- -+- --+ +-+ +++ -++ 0-- -0- --0 +0- +-0 0+- ++0 -+0 0-+ -0+ +0+ 0++ 00- 0-0 -00 +00 0+0 00+ 000",
    ),
    "wedge18": (13, "ooa Xoa oYa oob Xob oYb xoa oya oo0 xya Xo0 oY0 xob oyb xyb xo0 oy0 xy0"),
}
COORDINATES = {"-": -1, "+": 1, "0": 0, "o": 0, "X": 1, "Y": 1, "x": 0.5, "y": 0.5, "a": -1, "b": 1}
FACES = {
    "hexahedron27": ((0, 3, 7, 4), (1, 2, 6, 5), (0, 1, 5, 4), (3, 2, 6, 7), (0, 1, 2, 3), (4, 5, 6, 7), range(8)),
    "wedge18": ((0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
}  # in VTK's order, after the drawings of its classes


@pytest.mark.parametrize("kind", GMSH_PLACES)
def test_gmsh_order_of_middles_of_faces(kind: str, tmp_path: Path) -> None:
    """Each node beyond the corners is in the middle of the edge or face that VTK has there."""
    number, text = GMSH_PLACES[kind]
    places = np.array([[COORDINATES[c] for c in word] for word in text.split()], float)
    nodes = "\n".join(f"{k} {x} {y} {z}" for k, (x, y, z) in enumerate(places.tolist(), 1))
    cell = " ".join(map(str, range(1, len(places) + 1)))
    content = f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{len(places)}\n{nodes}\n$EndNodes\n"
    mesh = read(tmp_path, "a.msh", content + f"$Elements\n1\n1 {number} 2 0 0 {cell}\n$EndElements\n")
    found = mesh.points[mesh.cells[kind][0]]
    linear = mc.mesh.CELL_TYPES[mc.mesh.CELL_TYPES[kind].linear]
    corners = found[: linear.nodes]
    middles = [corners[list(part)].mean(axis=0) for part in (*linear.edges, *FACES[kind])]
    np.testing.assert_allclose(found[linear.nodes :], middles, atol=1e-15)
    mc.io.write(tmp_path / "b.msh", mesh)
    assert mc.io.read(tmp_path / "b.msh").cells[kind].tolist() == mesh.cells[kind].tolist()


# ---- SU2, Medit, surfaces

SU2 = """%
% Problem dimension
%
NDIME= 2
NELEM= 3
5 0 1 3 0
5 1 4 3 1   % with its number
9 1 2 5 4 2
NPOIN= 6 6
0.0 0.0 0
1.0 0.0 1
2.0 0.0 2
0.0 1.0 3
1.0 1.0 4
2.0 1.0 5
NMARK= 2
MARKER_TAG= lower
MARKER_ELEMS= 2
3 0 1 0
3 1 2 1
MARKER_TAG= right_side
MARKER_ELEMS= 1
3 2 5
"""


def test_su2(tmp_path: Path) -> None:
    mesh = read(tmp_path, "mesh.su2", SU2)
    assert mesh.cells["triangle"].tolist() == [[0, 1, 3], [1, 4, 3]]
    assert mesh.cells["quad"].tolist() == [[1, 2, 5, 4]]
    assert mesh.cells["line"].tolist() == [[0, 1], [1, 2], [2, 5]]
    assert {name: s.tolist() for name, s in mesh.sets.items()} == {"lower": [3, 4], "right_side": [5]}
    mc.io.write(tmp_path / "again.su2", mesh)
    again = mc.io.read(tmp_path / "again.su2")
    assert {name: s.tolist() for name, s in again.sets.items()} == {"lower": [3, 4], "right_side": [5]}
    assert meshio.su2.read(tmp_path / "again.su2").points.tolist() == mesh.points[:, :2].tolist()


def test_boundary_cells_of_no_set_are_kept(tmp_path: Path) -> None:
    mesh = read(tmp_path, "mesh.su2", SU2)
    mc.io.write(tmp_path / "again.su2", mc.Mesh(mesh.points, mesh.cells, sets={"lower": mesh.sets["lower"]}))
    again = mc.io.read(tmp_path / "again.su2")
    assert again.n_cells == mesh.n_cells
    assert again.sets["unnamed"].tolist() == [5]


def test_medit(tmp_path: Path) -> None:
    text = "MeshVersionFormatted 2\n\nDimension\n2\n\n# points\nVertices\n3\n0 0 4\n1 0 0\n0 1 0\n\nEdges\n1\n1 2 7\n"
    mesh = read(tmp_path, "mesh.mesh", text + "\nTriangles\n1\n1 2 3 9\n\nEnd\n")
    assert mesh.cells["line"].tolist() == [[0, 1]]
    assert mesh.cell_data["tag"].tolist() == [7, 9]
    assert mesh.point_data["tag"].tolist() == [4, 0, 0]
    mc.io.write(tmp_path / "again.mesh", mesh)
    assert "Dimension 2" in (tmp_path / "again.mesh").read_text()
    assert mc.io.read(tmp_path / "again.mesh").cell_data["tag"].tolist() == [7, 9]


def test_obj_of_a_modeller(tmp_path: Path) -> None:
    text = (
        "# Blender\nmtllib a.mtl\no Cube\nv 0 0 0 1.0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nusemtl red\ns off\n"
        "f 1/1/1 2/1/1 \\\n3//1 4//1\no Line\ng one two\nl 1 2 -2\np 4\n"
    )
    mesh = read(tmp_path, "cube.obj", text)
    assert mesh.cells["quad"].tolist() == [[0, 1, 2, 3]]
    assert mesh.cells["line"].tolist() == [[0, 1], [1, 2]]
    assert mesh.cells["vertex"].tolist() == [[3]]
    assert {n: s.tolist() for n, s in mesh.sets.items()} == {
        "Cube": [0],
        "Line": [1, 2, 3],
        "one": [1, 2, 3],
        "two": [1, 2, 3],
    }


def test_off_of_other_programs(tmp_path: Path) -> None:
    mesh = read(
        tmp_path, "a.off", "# made\nCOFF 4 2 0 # counts\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3 255 0 0\n3 0 1 2\n"
    )
    assert mesh.cells["quad"].tolist() == [[0, 1, 2, 3]]
    assert mesh.cells["triangle"].tolist() == [[0, 1, 2]]


def ply(form: str, order: str) -> bytes:
    """A scanner's file: floats, colours, faces of mixed size with a flag, an element of its own, edges."""
    head = (
        f"ply\nformat {form} 1.0\ncomment scanned\nelement vertex 4\nproperty float x\nproperty float y\n"
        "property float z\nproperty uchar red\nelement face 2\nproperty uchar flag\n"
        "property list uchar uint vertex_index\n"
        "element camera 1\nproperty double view_px\nelement edge 1\nproperty int vertex1\nproperty int vertex2\n"
        "property uchar flag\nend_header\n"
    ).encode()
    points = [(0.5, 0, 0, 10), (1, 0, 0, 20), (1, 1, 0, 30), (0, 1, 0, 40)]
    faces = [(1, 3, 0, 1, 2), (2, 4, 0, 1, 2, 3)]
    rest = [(0.25,), (3, 0, 7)]
    if not order:
        return head + "\n".join(" ".join(map(str, row)) for row in [*points, *faces, *rest]).encode()
    body = b"".join(struct.pack(order + "3fB", *row) for row in points)
    body += b"".join(struct.pack(f"{order}BB{row[1]}I", *row) for row in faces)
    return head + body + struct.pack(order + "d", 0.25) + struct.pack(order + "iiB", 3, 0, 7)


@pytest.mark.parametrize(("form", "order"), [("ascii", ""), ("binary_little_endian", "<"), ("binary_big_endian", ">")])
def test_ply_of_a_scanner(form: str, order: str, tmp_path: Path) -> None:
    mesh = read(tmp_path, "a.ply", ply(form, order))
    assert mesh.points[0].tolist() == [0.5, 0, 0]
    assert mesh.point_data["red"].tolist() == [10, 20, 30, 40]
    assert mesh.cells["triangle"].tolist() == [[0, 1, 2]]
    assert mesh.cells["quad"].tolist() == [[0, 1, 2, 3]]
    assert mesh.cells["line"].tolist() == [[3, 0]]
    assert mesh.cell_data["flag"].tolist() == [1, 2, 7]


def test_stl_of_several_solids(tmp_path: Path) -> None:
    facet = (
        "facet normal 0 0 1\n outer loop\n  vertex 0 0 {z}\n  vertex 1 0 {z}\n  vertex 0 1 {z}\n endloop\nendfacet\n"
    )
    text = "".join(f"solid {name}\n{facet.format(z=z)}endsolid {name}\n" for name, z in (("a b", 0), ("c", 1)))
    mesh = read(tmp_path, "a.stl", text)
    assert {n: s.tolist() for n, s in mesh.sets.items()} == {"a b": [0], "c": [1]}
    assert mesh.n_points == 6
    assert mc.io.read(tmp_path / "a.stl").cells["triangle"].tolist() == [[0, 1, 2], [3, 4, 5]]


def test_binary_stl_that_begins_with_solid(tmp_path: Path) -> None:
    """Some programs do, against the format's advice."""
    record = struct.pack("<12fH", 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0)
    mesh = read(tmp_path, "a.stl", b"solid of a CAD system".ljust(80) + struct.pack("<I", 2) + 2 * record)
    assert mesh.n_points == 3
    assert mesh.n_cells == 2


def test_equal_corners_of_stl_become_one_point(tmp_path: Path) -> None:
    corners = np.array(list(itertools.product([0.0, -0.0, 1.5], [0.0, 2.5], [0.25])))
    faces = [(0, 1, 4), (2, 3, 5)]  # 0 and 2, 1 and 3 are the same places but for the sign of zero
    mesh = mc.Mesh(corners, {"triangle": faces})
    mc.io.write(tmp_path / "a.stl", mesh)
    assert mc.io.read(tmp_path / "a.stl").cells["triangle"].tolist() == [[0, 1, 2], [0, 1, 3]]


def test_markers_have_names_that_su2_takes(tmp_path: Path) -> None:
    cells = {"quad": [[0, 1, 2, 3]], "line": [[0, 1], [1, 2], [2, 3], [3, 0]]}
    sets = {"far field": [1], "far_field": [2], "wall (upper), 1": [3]}
    mc.io.write(tmp_path / "mesh.su2", mc.Mesh([[0, 0], [1, 0], [1, 1], [0, 1]], cells, sets=sets))
    again = mc.io.read(tmp_path / "mesh.su2")
    named = {"far_field": [1], "far_field_2": [2], "wall_upper_1": [3], "unnamed": [4]}
    assert {name: members.tolist() for name, members in again.sets.items()} == named


@given(st.lists(st.text(max_size=8), min_size=3, max_size=3, unique=True))
def test_markers_of_any_names(names):
    cells = {"quad": [[0, 1, 2, 3]], "line": [[0, 1], [1, 2], [2, 3], [3, 0]]}
    sets = {name: [k] for k, name in enumerate(names, 1)}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mesh.su2"
        mc.io.write(path, mc.Mesh([[0, 0], [1, 0], [1, 1], [0, 1]], cells, sets=sets))
        again = mc.io.read(path)
    assert [members.tolist() for members in again.sets.values()] == [[1], [2], [3], [4]]
    assert not any(set(name) & set(" ,;()=%'\"\t\n") for name in again.sets)


def test_sides_that_repeat_are_a_pair_of_markers(tmp_path: Path) -> None:
    x, y = np.meshgrid([0.0, 1, 2, 4], [0.0, 1, 3], indexing="ij")
    cut = mc.Cut(((0, 0, 0), (0, 2, 0)), ((3, 0, 0), (3, 2, 0)), translation=(4, 0, 0), name="pitch")
    mc.io.write(tmp_path / "row.su2", mc.StructuredGrid(np.stack([x, y], axis=-1), names={"jmin": "hub"}, cuts=(cut,)))
    again = mc.io.read(tmp_path / "row.su2")
    assert {name: len(cells) for name, cells in again.sets.items()} == {
        "pitch": 2,
        "pitch_donor": 2,
        "hub": 3,
        "boundary": 3,
    }
    here, there = (again.points[np.unique(again.get("line")[again.sets[n] - 6])] for n in ("pitch", "pitch_donor"))
    np.testing.assert_allclose(here + [4, 0, 0], there)


def test_legacy_vtk_with_kinds_in_turns(tmp_path):
    """Each cell's size stands before its corners, and every one may be another."""
    chance = np.random.default_rng(0)
    sizes = chance.choice([3, 4], 60).tolist() + [3] * 40
    rows = [chance.permutation(50)[:size].tolist() for size in sizes]
    points = "\n".join(" ".join(map(repr, point)) for point in chance.random((50, 3)).tolist())
    cells = "\n".join(" ".join(map(str, [len(row), *row])) for row in rows)
    types = "\n".join("5" if size == 3 else "9" for size in sizes)
    count = sum(sizes) + len(sizes)
    head = f"# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 50 double\n{points}\n"
    path = tmp_path / "a.vtk"
    path.write_text(f"{head}CELLS 100 {count}\n{cells}\nCELL_TYPES 100\n{types}\n")
    found = mc.io.read(path)
    assert found.cells["triangle"].tolist() == [row for row in rows if len(row) == 3]
    assert found.cells["quad"].tolist() == [row for row in rows if len(row) == 4]
    for lie in (cells.replace("\n3 ", "\n-3 ", 1), cells.replace("\n4 ", "\n4000 ", 1), cells[: len(cells) // 2]):
        path.write_text(f"{head}CELLS 100 {len(lie.split())}\n{lie}\nCELL_TYPES 100\n{types}\n")
        with pytest.raises(mc.InvalidInput, match="the 100 cells of CELLS do not fit"):
            mc.io.read(path)


def test_gmsh_tags_in_any_order(tmp_path):
    mesh = mc.Mesh([[0, 0], [1, 0], [1, 1], [0, 1]], {"quad": [[0, 1, 2, 3]]})
    path = tmp_path / "a.msh"
    nodes = {7: (0, 0), 3: (1, 0), 9: (1, 1), 4: (0, 1)}
    listed = "\n".join(f"{tag} {x} {y} 0" for tag, (x, y) in nodes.items())
    text = f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n{listed}\n$EndNodes\n$Elements\n1\n"
    for first in (0, 5):  # as they are, and counting up from 5
        known = list(nodes) if not first else [5, 6, 7, 8]
        rows = "\n".join(f"{k} {x} {y} 0" for k, (x, y) in zip(known, nodes.values(), strict=True))
        told = text.replace(listed, rows)
        path.write_text(told + "1 3 2 0 1 " + " ".join(map(str, known)) + "\n$EndElements\n")
        found = mc.io.read(path)
        np.testing.assert_array_equal(found.points[found.cells["quad"][0]], mesh.points)
        path.write_text(told + f"1 3 2 0 1 {known[0]} {known[1]} {known[2]} 2\n$EndElements\n")
        with pytest.raises(mc.InvalidInput, match="point 2 is referred to"):
            mc.io.read(path)
