"""Meshes written to Blender and read back: points, cells by kind, data, sets; volume cells and the cut view."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from tests.blender import scene


@pytest.fixture
def convert(installed):
    """The add-on's conversion."""
    return scene.addon("convert")


@pytest.fixture
def there_and_back(convert):
    """A mesh through Blender, and the object."""

    def go(mesh, *kinds):
        data, warnings = convert.write("made", mesh, np.zeros(3))
        ob = scene.link(bpy.data.objects.new("made", data))
        return convert.read(bpy.context, ob, kinds).mesh, ob, warnings

    return go


def surface(core):
    """Two triangles and a quad with data of every type and a set."""
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0.5], [2, 1, 0.25]])
    cells = {"triangle": [[1, 4, 2], [4, 5, 2]], "quad": [[0, 1, 2, 3]]}
    return core.Mesh(
        points,
        cells,
        point_data={"heat": np.linspace(0, 1, 6), "way": points * 2, "uv": points[:, :2], "on": points[:, 0] > 0},
        cell_data={"region": np.array([3, -1, 2**30]), "load": np.array([0.25, 0.5, 0.75])},
        sets={"wall": [0, 2]},
    )


def test_surface_with_data_and_sets(core, there_and_back):
    mesh = surface(core)
    back, _, warnings = there_and_back(mesh)
    assert warnings == []
    np.testing.assert_array_equal(back.points, mesh.points)
    assert {k: c.tolist() for k, c in back.cells.items()} == {k: c.tolist() for k, c in mesh.cells.items()}
    for old, new in ((mesh.point_data, back.point_data), (mesh.cell_data, back.cell_data)):
        assert old.keys() == new.keys()
        for name, values in old.items():
            np.testing.assert_allclose(new[name], values, rtol=scene.SINGLE)
            assert new[name].dtype.kind == values.dtype.kind
    assert back.sets["wall"].tolist() == [0, 2]


def test_lines_with_tags(core, there_and_back):
    mesh = core.Mesh(
        [[0, 0], [1, 0], [2, 0], [2, 1]],
        {"line": [[2, 3], [0, 1], [1, 2]]},
        cell_data={"tag": np.array([7, 8, 9])},
        point_data={"size": np.array([0.5, 1, 2, 4])},
    )
    back, _, _ = there_and_back(mesh, "line")
    assert back.get("line").tolist() == mesh.get("line").tolist()
    assert back.cell_data["tag"].tolist() == [7, 8, 9]
    np.testing.assert_array_equal(back.point_data["size"], mesh.point_data["size"])


def test_one_name_on_points_lines_and_faces(core, convert, there_and_back):
    mesh = core.Mesh(
        [[0, 0], [1, 0], [1, 1], [2, 2]],
        {"line": [[2, 3], [1, 0]], "triangle": [[0, 1, 2]]},
        cell_data={"tag": np.array([5, 6, 7])},
        point_data={"tag": np.array([0.5, 1.5, 2.5, 3.5])},
    )
    back, ob, warnings = there_and_back(mesh, "triangle")
    assert warnings == []
    assert back.cell_data["tag"].tolist() == [7]
    assert back.point_data["tag"].tolist() == [0.5, 1.5, 2.5]
    edges = {tuple(sorted(edge.vertices)): edge.index for edge in ob.data.edges}
    tags = scene.values(ob, "tag.edge")
    assert (tags[edges[2, 3]], tags[edges[0, 1]]) == (5, 6)
    assert convert.read(bpy.context, ob, ("line",)).mesh.cell_data["tag"].max() == 6


def test_data_that_blender_cannot_hold_are_named(core, there_and_back):
    mesh = surface(core).with_point_data(tensor=np.zeros((6, 3, 3)), position=np.zeros(6))
    back, _, warnings = there_and_back(mesh)
    assert len(warnings) == 2
    assert "'tensor'" in warnings[0]
    assert "'position'" in warnings[1]
    np.testing.assert_array_equal(back.points, mesh.points)


def hexahedra(core, n):
    """A block of n x n x n hexahedra with a number on each."""
    x = np.linspace(0, 1, n + 1)
    grid = core.StructuredGrid(np.stack(np.meshgrid(x, x, x, indexing="ij"), axis=-1))
    mesh = grid.to_mesh()
    return mesh.with_cell_data(load=np.arange(mesh.n_cells) / 2, way=mesh.centroids).with_point_data(
        heat=mesh.points[:, 0]
    )


def tetrahedra(core):
    """A cube of six tetrahedra around its diagonal."""
    points = [[i, j, k] for k in (0, 1) for j in (0, 1) for i in (0, 1)]
    path = [1, 3, 2, 6, 4, 5]
    return core.Mesh(points, {"tetra": [[0, a, b, 7] for a, b in zip(path, path[1:] + path[:1], strict=True)]})


def test_hexahedra_are_kept_and_their_surface_shown(core, there_and_back):
    mesh = hexahedra(core, 3)
    back, ob, warnings = there_and_back(mesh, "hexahedron")
    assert warnings == []
    assert len(ob.data.polygons) == 6 * 9
    assert not ob.data.validate()
    np.testing.assert_allclose(back.points, mesh.points, atol=1e-7)
    np.testing.assert_array_equal(back.get("hexahedron"), mesh.get("hexahedron"))
    for name in ("load", "way"):
        np.testing.assert_allclose(back.cell_data[name], mesh.cell_data[name])
    np.testing.assert_allclose(back.point_data["heat"], mesh.point_data["heat"], atol=1e-7)
    owner = scene.values(ob, "cell")
    np.testing.assert_allclose(scene.values(ob, "load"), mesh.cell_data["load"][owner])
    outward = [
        (face.center - ob.data.vertices[0].co.__class__((0.5, 0.5, 0.5))).dot(face.normal) for face in ob.data.polygons
    ]
    assert min(outward) > 0


def test_tetrahedra_survive_save_and_open(core, there_and_back, convert, tmp_path):
    mesh = tetrahedra(core)
    there_and_back(mesh, "tetra")
    file = str(tmp_path / "volume.blend")
    bpy.ops.wm.save_as_mainfile(filepath=file)
    bpy.ops.wm.open_mainfile(filepath=file)
    back = convert.read(bpy.context, bpy.data.objects["made"], ("tetra",)).mesh
    np.testing.assert_array_equal(back.get("tetra"), mesh.get("tetra"))
    assert len(bpy.data.objects["made"].data.polygons) == 12


def test_volume_moves_with_its_object(core, there_and_back, convert):
    _, ob, _ = there_and_back(tetrahedra(core), "tetra")
    ob.scale, ob.location = (2, 2, 2), (1, 0, 0)
    bpy.context.view_layer.update()
    bounds = convert.read(bpy.context, ob, ("tetra",)).mesh.bounds
    np.testing.assert_allclose(bounds, [[1, 0, 0], [3, 2, 2]])


def test_a_volume_is_a_surface_to_who_asks_for_triangles(core, there_and_back):
    back, _, _ = there_and_back(hexahedra(core, 2), "triangle")
    assert len(back.get("triangle")) == 2 * 24


@pytest.mark.parametrize("other_side", [False, True])
def test_cut_view_shows_one_side(core, there_and_back, convert, other_side):
    mesh = hexahedra(core, 4)
    _, ob, _ = there_and_back(mesh, "hexahedron")
    assert bpy.ops.meshcore.cut_view(axis="Z", position=0.3, other_side=other_side) == {"FINISHED"}
    layers = 3 if other_side else 1
    assert len(ob.data.polygons) == 2 * 16 + layers * 16
    heights = mesh.centroids[np.unique(scene.values(ob, "cell")), 2]
    assert ((heights > 0.3) == other_side).all()
    np.testing.assert_array_equal(
        convert.read(bpy.context, ob, ("hexahedron",)).mesh.get("hexahedron"), mesh.get("hexahedron")
    )
    bpy.ops.meshcore.cut_view(axis="Z", position=1.0)
    assert len(ob.data.polygons) == 96


def test_bad_cells_of_a_volume(core, there_and_back):
    mesh = hexahedra(core, 2)
    points = mesh.points.copy()
    corner = np.flatnonzero((points == 1).all(axis=1))[0]
    points[corner] -= 0.3
    _, ob, _ = there_and_back(mesh.with_points(points), "hexahedron")
    bpy.ops.meshcore.select_bad_cells(measure="scaled_jacobian", side="BELOW", threshold=0.99)
    bpy.ops.object.mode_set(mode="OBJECT")
    chosen = {scene.values(ob, "cell")[face.index] for face in ob.data.polygons if face.select}
    assert chosen == {7}


def test_edited_volume_is_refused_not_misread(core, there_and_back, convert):
    _, ob, _ = there_and_back(tetrahedra(core), "tetra")
    ob.data.vertices.add(1)
    with pytest.raises(convert.ReadingFailed, match=r"had 8 vertices .* has 9 now"):
        convert.read(bpy.context, ob, ("tetra",))
    with pytest.raises(RuntimeError, match="had 8 vertices"):
        bpy.ops.meshcore.cut_view()
    assert len(convert.read(bpy.context, ob, ("triangle",)).mesh.get("triangle")) == 12  # its surface is still one


def test_cut_view_needs_volume_cells(installed):
    bpy.ops.mesh.primitive_cube_add()
    with pytest.raises(RuntimeError, match="Select a mesh with volume cells"):
        bpy.ops.meshcore.cut_view()


def test_many_cells_are_quick_enough_to_be_one_array(core, there_and_back):
    mesh = hexahedra(core, 30)
    back, ob, _ = there_and_back(mesh, "hexahedron")
    assert type(ob.data["meshcore_cells"]["hexahedron"]).__name__ == "IDPropertyArray"
    assert ob.data["meshcore_cells"]["hexahedron"].typecode == "i"
    np.testing.assert_array_equal(back.get("hexahedron"), mesh.get("hexahedron"))


def test_where_no_kind_is_asked_for_all_vertices_are_read(core, convert):
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [5, 5, 0], [0, 2, 1]]
    alone = scene.add_mesh("alone", points)
    faced = scene.add_mesh("faced", points, faces=[[0, 1, 2]])
    for ob in (alone, faced):
        np.testing.assert_array_equal(convert.read(bpy.context, ob, ()).mesh.points, points)
    empty = scene.add_mesh("empty", [])
    with pytest.raises(convert.ReadingFailed, match="empty has no vertices"):
        convert.read(bpy.context, empty, ())


def test_polygons_are_written_whole(core, convert):
    angle = 2 * np.pi * np.arange(6) / 6
    points = np.concatenate([np.column_stack([np.cos(angle), np.sin(angle)]), [[2, 0]]])
    mesh = core.PolyhedralMesh.from_polygons(
        points, [[0, 1, 2, 3, 4, 5], [0, 6, 1]], cell_data={"site": np.array([4, 2])}
    )
    data, warnings = convert.write_polygons("cells", mesh, np.zeros(3))
    ob = scene.link(bpy.data.objects.new("cells", data))
    assert warnings == [] and not data.validate()
    assert scene.faces(ob) == [[0, 1, 2, 3, 4, 5], [0, 6, 1]]
    assert scene.values(ob, "site").tolist() == [4, 2]


def test_polyhedra_are_closed_pieces(core, convert):
    # Two pyramids on one square.
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1], [0.5, 0.5, -1]]
    sides = [[k, (k + 1) % 4] for k in range(4)]
    faces = [[0, 3, 2, 1], *[[a, b, 4] for a, b in sides], *[[b, a, 5] for a, b in sides]]
    mesh = core.PolyhedralMesh(
        points,
        np.cumsum([0, *map(len, faces)]),
        np.concatenate(faces),
        owner=[0] * 5 + [1] * 4,
        neighbour=[1] + [-1] * 8,
        cell_data={"site": np.array([3, 8])},
    )
    np.testing.assert_allclose(mesh.volumes, [1 / 3, 1 / 3])
    data, warnings = convert.write_polygons("pieces", mesh, np.zeros(3))
    ob = scene.link(bpy.data.objects.new("pieces", data))
    assert warnings == [] and not data.validate()
    assert (len(data.vertices), len(data.polygons), len(data.edges)) == (10, 10, 16)
    assert scene.values(ob, "site").tolist() == [3] * 5 + [8] * 5
    middle = np.array([[0.5, 0.5, 0.5]] * 5 + [[0.5, 0.5, -0.5]] * 5)
    outward = [np.dot(face.normal, np.array(face.center) - m) for face, m in zip(data.polygons, middle, strict=True)]
    assert min(outward) > 0
