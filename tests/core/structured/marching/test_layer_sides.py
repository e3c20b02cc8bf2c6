"""Named boundaries of layers that are a mesh: wall, outer side and edges, in memory and through files."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery
from tests.named_sides import middles, sides_of_volumes, solid

ASKED = {"first_height": 0.01, "layers": 4}


def counts(mesh):
    return {name: len(cells) for name, cells in sides_of_volumes(mesh).items()}


def sheet(kind="quad", n=5, m=4):
    """A bent rectangle, 0 to 1 in x, 0 to 2 in y, of quads or triangles."""
    u, v = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 2, m), indexing="ij")
    grid = mc.StructuredGrid(np.stack([u, v, 0.1 * np.sin(3 * u) * v + 0.1 * u], axis=-1))
    mesh = grid.to_mesh()
    if kind == "triangle":
        quads = mesh.get("quad")
        return mc.Mesh(mesh.points, {"triangle": np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])})
    return mesh


def with_lines(mesh, **names):
    """The mesh with line cells where the points fulfil something, in sets."""
    lines, sets, count = [], dict(mesh.sets), mesh.n_cells
    for name, there in names.items():
        edges = mesh.boundary.get("line")
        some = edges[there(mesh.points)[edges].all(axis=1)]
        sets[name] = count + np.arange(len(some))
        lines.append(some)
        count += len(some)
    data = {key: np.pad(values, (0, count - mesh.n_cells)) for key, values in mesh.cell_data.items()}
    return replace(mesh, cells={**mesh.cells, "line": np.concatenate(lines)}, sets=sets, cell_data=data)


# ---- what sides are called


def test_a_closed_surface_has_a_wall_and_an_outer_side():
    ball = gallery.bumpy_ball(80)
    mesh, report = mc.hyperbolic_volume(ball, **ASKED)
    assert counts(mesh) == {"outer": ball.n_cells, "wall": ball.n_cells}
    radius = {name: np.linalg.norm(middles(mesh, name), axis=1) for name in mesh.sets}
    assert (radius["outer"] > radius["wall"] + 0.04).all()
    assert report.counts["cells"] == solid(mesh).n_cells == 4 * ball.n_cells
    layer = mesh.cell_data["layer"]
    assert (layer[mesh.sets["outer"]] == 3).all() and not layer[mesh.sets["wall"]].any()


def test_marched_into_a_surface_the_outer_side_lies_inside():
    ball = gallery.bumpy_ball(80)
    mesh, _ = mc.hyperbolic_volume(ball, **ASKED, other_side=True)
    assert counts(mesh) == {"outer": ball.n_cells, "wall": ball.n_cells}
    radius = {name: np.linalg.norm(middles(mesh, name), axis=1) for name in mesh.sets}
    assert (radius["outer"] < radius["wall"] - 0.04).all()


@pytest.mark.parametrize("other_side", [False, True])
@pytest.mark.parametrize("kind", ["quad", "triangle"])
def test_edges_are_called_by_where_they_lie(kind, other_side):
    surface = sheet(kind)
    mesh, _ = mc.hyperbolic_volume(surface, **ASKED, edges="free", other_side=other_side)
    n = surface.n_cells
    assert counts(mesh) == {"wall": n, "outer": n, "xmin": 12, "xmax": 12, "ymin": 16, "ymax": 16}
    assert np.abs(middles(mesh, "xmin")[:, 0]).max() < 0.1 < 0.9 < middles(mesh, "xmax")[:, 0].min()
    assert np.abs(middles(mesh, "ymin")[:, 1]).max() < 0.1 < 1.9 < middles(mesh, "ymax")[:, 1].min()


def test_names_of_a_mesh_come_first_then_those_that_the_user_spoke_of():
    surface = with_lines(sheet(), root=lambda p: p[:, 0] == 0)
    corner = int(np.flatnonzero((surface.points[:, 0] == 1) & (surface.points[:, 1] > 0.1))[0])
    asked = f"xmin = constant x, vertex {corner} = splay 5, ymax = free"
    mesh, _ = mc.hyperbolic_volume(surface, **ASKED, each_edge=asked)
    assert list(counts(mesh)) == ["wall", "outer", *[name for name in mesh.sets if name not in ("wall", "outer")]]
    assert set(mesh.sets) == {"wall", "outer", "root", f"vertex {corner}", "ymin", "ymax"}
    assert not middles(mesh, "root")[:, 0].any()
    assert (middles(mesh, f"vertex {corner}")[:, 0] > 0.9).all()


def test_a_round_hole_that_lies_nowhere_special_is_a_boundary():
    t, s = np.meshgrid(np.linspace(0, 2 * np.pi, 13), np.linspace(0, 1, 4), indexing="ij")
    cup = mc.StructuredGrid(np.stack([(1 - 0.3 * s) * np.cos(t), (1 - 0.3 * s) * np.sin(t), s + 0.1 * np.cos(t)], -1))
    mesh, _ = mc.hyperbolic_volume(cup.to_mesh(), **ASKED, edges="free", other_side=True)
    assert counts(mesh) == {"wall": 36, "outer": 36, "boundary": 2 * 12 * 4}


def test_patches_of_the_surface_stay_patches_of_the_wall():
    ball = gallery.bumpy_ball(80)
    x, z = ball.centroids[:, 0], ball.centroids[:, 2]
    sets = {"wing": np.flatnonzero(x > 0.5), "upper": np.flatnonzero(z > 0), "nothing": []}
    tags = np.where(x < -0.5, 3, 0)
    mesh, _ = mc.hyperbolic_volume(replace(ball, sets=sets, cell_data={"tag": tags}), **ASKED)
    first = {
        "wing": x > 0.5,
        "upper": (x <= 0.5) & (z > 0),
        "tag 3": (x < -0.5) & (z <= 0),
        "wall": (x <= 0.5) & (z <= 0) & (x >= -0.5),
    }
    assert counts(mesh) == {"outer": ball.n_cells, **{name: int(where.sum()) for name, where in first.items()}}
    for name, where in first.items():
        assert sorted(middles(mesh, name).round(9).tolist()) == sorted(ball.centroids[where].round(9).tolist())


def test_patches_keep_their_faces_where_faces_are_left_out_and_turned():
    quads = sheet().get("quad")
    flat = quads.copy()
    flat[3] = flat[3, [0, 0, 1, 1]]  # without area
    flat[7] = flat[7, ::-1]
    surface = replace(sheet(), cells={"quad": np.concatenate([flat[3:4], quads[:3], quads[3:7], flat[7:8], quads[8:]])})
    surface = replace(surface, sets={"last": np.arange(9, surface.n_cells)})
    mesh, report = mc.hyperbolic_volume(surface, **ASKED, edges="free")
    assert any("without area" in text for text in report.warnings) and any("turned" in text for text in report.warnings)
    assert counts(mesh)["last"] == len(quads) - 8
    assert sorted(middles(mesh, "last").round(9).tolist()) == sorted(surface.centroids[9:].round(9).tolist())


def test_names_that_meet_are_told_apart():
    surface = with_lines(sheet(), outer=lambda p: p[:, 0] == 0, wing=lambda p: p[:, 0] == 1)
    surface = replace(surface, sets={**surface.sets, "wing": np.concatenate([[0, 1], surface.sets["wing"]])})
    mesh, report = mc.hyperbolic_volume(surface, **ASKED, edges="free")
    assert counts(mesh) == {"wing": 2, "wall": 10, "outer": 12, "outer 2": 12, "wing 2": 12, "ymin": 16, "ymax": 16}
    assert sum("is called" in text for text in report.warnings) == 2


def test_periodic_edges_are_called_as_those_of_grids():
    hub = gallery.hub_sector(6, 5)
    grid, _ = mc.hyperbolic_volume(hub, **ASKED, each_edge="imin = periodic, imax = periodic, jmin = constant z")
    ends = [np.round(row.reshape(-1, 3), 9).tolist() for row in (hub.points[0], hub.points[-1])]

    def on(rows):
        return lambda points: np.array([row in rows for row in np.round(points, 9).tolist()])

    named = with_lines(hub.to_mesh(), first=on(ends[0]), last=on(ends[1]))
    tags = np.zeros(named.n_cells, int)
    tags[named.sets["first"]], tags[named.sets["last"]] = 1, 2
    rims = hub.to_mesh(), replace(named, sets={}, cell_data={"tag": tags}), named
    k = [int(np.flatnonzero((rims[0].points == hub.points[end, 2].ravel()).all(axis=1))[0]) for end in (0, -1)]
    words = ((f"vertex {k[0]}", f"vertex {k[1]}"), ("tag 1", "tag 2"), ("first", "last"))
    called = (("periodic", "periodic donor"), ("tag 1", "tag 2"), ("first", "last"))
    expected = mc.with_named_sides(grid)
    for surface, (one, two), pair in zip(rims, words, called, strict=True):
        asked = f"{one} = periodic, {two} = periodic, zmin = constant z"
        mesh, _ = mc.hyperbolic_volume(surface, **ASKED, each_edge=asked)
        assert set(counts(mesh)) == {"wall", "outer", "zmin", "zmax", *pair}
        for mine, theirs in ((("wall",), ("wall",)), (("outer",), ("outer",)), (pair, called[0])):
            here = np.concatenate([middles(mesh, name) for name in mine])
            there = np.concatenate([middles(expected, name) for name in theirs])
            assert np.abs(here[np.lexsort(here.round(6).T)] - there[np.lexsort(there.round(6).T)]).max() < 1e-4


def test_a_grid_with_a_pole_gives_a_mesh_with_its_names():
    t, s = np.meshgrid(np.linspace(0, np.pi, 9), np.linspace(0, 1, 6), indexing="ij")
    half = np.stack([np.sin(s) * np.cos(t), np.sin(s) * np.sin(t), np.cos(s)], axis=-1)
    mesh, _ = mc.hyperbolic_volume(mc.StructuredGrid(half, names={"jmax": "rim"}), **ASKED, other_side=True)
    assert isinstance(mesh, mc.Mesh)
    assert counts(mesh) == {"wall": 40, "outer": 40, "rim": 8 * 4, "ymin": 2 * 5 * 4}


def test_stopped_layers_have_their_sides_too():
    filled = np.ones((6, 6, 3), bool)
    filled[3:, 3:] = False
    x, y, z = (body := gallery.bricks(filled, size=1 / 3)).points.T
    narrow = body.with_points(np.column_stack([x + 0.9 * y, np.sqrt(1 - 0.81) * y, z]))
    mesh, report = mc.hyperbolic_volume(narrow, first_height=0.01, layers=60, distance=8.0)
    assert not report.converged and 0 < report.counts["layers"] < 60
    assert counts(mesh) == {"wall": body.n_cells, "outer": body.n_cells}


# ---- through files


@pytest.fixture(scope="module")
def layers():
    """Wedges and hexahedra off a wing tip of two patches, with a plane of symmetry at its root."""
    wing = gallery.wing_tip(12, 6, 2)
    tip = np.flatnonzero(wing.centroids[:, 2] > 1.45)
    return mc.hyperbolic_volume(replace(wing, sets={"tip": tip}), first_height=0.01, layers=3).mesh


def places(mesh):
    """Middles of the faces of each set."""
    return {name: sorted(middles(mesh, name).round(6).tolist()) for name in mesh.sets}


def test_the_wing_has_its_sides(layers):
    assert set(counts(layers)) == {"wall", "tip", "outer", "zmin"}
    assert not middles(layers, "zmin")[:, 2].any()


@pytest.mark.parametrize("ending", ["su2", "msh", "cgns", "vtu", "vtk"])
def test_files_keep_the_sides(layers, ending, tmp_path):
    path = tmp_path / f"layers.{ending}"
    mc.io.write(path, replace(layers, cell_data={}))
    back = mc.io.read(path)
    assert places(back) == places(layers)
    assert counts(back) == counts(layers)
    assert solid(back).n_cells == solid(layers).n_cells


def test_meshio_finds_physical_groups(layers, tmp_path):
    import meshio

    mc.io.write(tmp_path / "layers.msh", replace(layers, cell_data={}))
    read = meshio.read(tmp_path / "layers.msh")
    tags = np.concatenate(
        [t for block, t in zip(read.cells, read.cell_data["gmsh:physical"], strict=True) if block.dim == 2]
    )
    found = {name: int((tags == tag).sum()) for name, (tag, dimension) in read.field_data.items() if dimension == 2}
    assert found == counts(layers)
