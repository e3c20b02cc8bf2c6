"""Edges of surfaces that layers are marched from, one by one: names, planes, guides, and corners where both hold."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery, quality
from meshcore.errors import InvalidGeometry, InvalidInput
from meshcore.geometry.curves import lines_through
from meshcore.structured.marching.edge_conditions import parsed
from meshcore.structured.marching.edge_sides import sides_of
from meshcore.structured.marching.layer_surface import read_surface


def wavy_patch(n=9, names=None):
    u, v = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 2, 2 * n), indexing="ij")
    return mc.StructuredGrid(np.stack([u, v, 0.1 * np.sin(4 * u) * np.cos(3 * v)], axis=-1), names=names or {})


def leaning_wall(n=80):
    """The surface x = -0.4 z^2 - 0.3 z, in which the patch's side imin lies but for facets that cut corners."""
    y, z = np.meshgrid(np.linspace(-1, 3, 9), np.linspace(-0.1, 1.0, n), indexing="ij")
    return mc.StructuredGrid(np.stack([-0.4 * z**2 - 0.3 * z, y, z], axis=-1))


def off_the_wall(points):
    x, _, z = np.moveaxis(points, -1, 0)
    return np.abs(x + 0.4 * z**2 + 0.3 * z)


def layered(surface, **arguments):
    grid, report = mc.hyperbolic_volume(surface, first_height=0.01, layers=12, **arguments)
    assert report.converged and quality.validate(grid) == []
    return grid


# ---- sides and their names


def test_sides_end_at_corners_and_where_names_change():
    ready = read_surface(wavy_patch(names={"jmin": "root"}))
    sides = sides_of(ready.graph, ready.source, ready.number)
    assert sorted(len(side.nodes) for side in sides) == [9, 9, 18, 18]
    assert {name for side in sides for name in side.names} >= {"imin", "imax", "jmin", "jmax", "root", "ymin", "xmax"}
    # A half disk of two rows has a smooth side from imin over jmax to imax, which is three sides by name.
    t, r = np.meshgrid(np.linspace(0, np.pi, 17), [0.3, 1.0], indexing="ij")
    band = mc.StructuredGrid(np.stack([r * np.cos(t), r * np.sin(t)], axis=-1))
    ready = read_surface(band)
    assert len(sides_of(ready.graph, ready.source, ready.number)) == 4


def test_a_smooth_loop_is_one_side():
    t, z = np.meshgrid(np.linspace(0, 2 * np.pi, 33), [0.0, 0.2, 0.4], indexing="ij")
    tube = mc.StructuredGrid(np.stack([np.cos(t), np.sin(t), z], axis=-1))
    ready = read_surface(tube)
    sides = sides_of(ready.graph, ready.source, ready.number)
    assert [(len(side.nodes), side.closed) for side in sides] == [(32, True)] * 2
    assert layered(tube, each_edge="zmin = constant z").points[:, 0, :, 2].max() == 0


def test_conditions_are_read_from_text():
    assert [(name, a.choice) for name, a in parsed(" a b =plane;c= constant   z,, ")] == [
        ("a b", "plane"),
        ("c", "constant z"),
    ]
    for text in ("imin", "imin plane", "= plane", "imin = sideways", "imin = splay wide", "imin = splay 95"):
        with pytest.raises(InvalidInput):
            parsed(text)


def test_edges_are_found_by_block_set_tag_vertex_and_place():
    patch = wavy_patch().points
    blocks = mc.MultiBlock((mc.StructuredGrid(patch[:5]), mc.StructuredGrid(patch[4:])), ("left", "right"))
    made, _ = mc.hyperbolic_volume(blocks, first_height=0.01, layers=12, each_edge="right imax = constant x")
    assert np.abs(made.blocks[1].points[-1, ..., 0] - 1).max() == 0
    mesh = wavy_patch().to_mesh()
    rim = np.flatnonzero(mesh.points[:, 0] == 1)
    lines = np.column_stack([rim[:-1], rim[1:]])
    tags = np.concatenate([np.zeros(mesh.n_cells), np.full(len(lines), 4)])
    count = mesh.n_cells + np.arange(len(lines))
    named = mc.Mesh(mesh.points, {**mesh.cells, "line": lines}, cell_data={"tag": tags}, sets={"far end": count})
    for name in ("far end", "tag 4", f"vertex {rim[3]}", "xmax"):
        points = layered(named, each_edge=f"{name} = constant x", edges="free").points.reshape(13, -1, 3)
        assert np.abs(points[:, rim, 0] - 1).max() == 0, name
        assert np.abs(points[-1, mesh.points[:, 0] == 0, 0]).max() > 1e-4


def test_names_that_are_none_are_told_those_that_are():
    with pytest.raises(InvalidInput, match=r"no edge is called 'top'; names are .*imin.*jmax.* has 4 edges"):
        layered(wavy_patch(), each_edge="top = plane")
    with pytest.raises(InvalidInput, match="vertex 4000"):
        layered(wavy_patch().to_mesh(), each_edge="vertex 4000 = plane")
    with pytest.raises(InvalidInput, match="asks both"):
        layered(wavy_patch(), each_edge="imin = free, xmin = plane")
    with pytest.raises(InvalidInput, match="closed and has no edges"):
        layered(gallery.bumpy_ball(60), each_edge="imin = free")


# ---- corners where two conditions meet


def test_both_conditions_hold_at_a_corner():
    grid = layered(wavy_patch(), edges="free", each_edge="imin = constant x, jmin = constant y, jmax = splay 20")
    assert np.abs(grid.points[0, ..., 0]).max() == 0 and np.abs(grid.points[:, 0, :, 1]).max() == 0
    assert (grid.points[:, -1, 1:, 1] > 2).all()  # leans outwards, also in the plane x = 0
    assert np.abs(np.diff(grid.points[0, -1, :, 1])).min() > 0
    for corner, step in ((grid.points[0, -1], 1.0), (grid.points[-1, -1], 0.9)):
        first = corner[1] - corner[0]
        assert first[1] > step * np.linalg.norm(first) * np.sin(np.radians(15))


def test_a_free_side_is_not_drawn_along_the_plane_it_ends_at():
    """The corner of a flat plate between a plane of symmetry and a free side goes straight up."""
    u, v = np.meshgrid(np.linspace(0, 1, 7), np.linspace(0, 1, 7), indexing="ij")
    plate = mc.StructuredGrid(np.stack([u, v, 0 * u], axis=-1))
    grid = layered(plate, edges="free", each_edge="imin = plane")
    assert np.abs(grid.points[..., :2] - plate.points[..., :2]).max() < 1e-14


def test_a_side_in_no_plane_is_refused():
    bowed = wavy_patch()
    bowed = bowed.with_points(bowed.points + np.array([0, 0, 1]) * bowed.points[..., 1:2] ** 2 + 0.2 * np.array(
        [1, 0, 0]) * np.sin(bowed.points[..., 1:2]))  # fmt: skip
    with pytest.raises(InvalidGeometry, match="no plane") as caught:
        layered(bowed, each_edge="imin = plane")
    assert caught.value.points == tuple(range(0, 9 * 18, 9))  # as in files, where i runs fastest


# ---- guides


def test_an_edge_stays_on_a_surface():
    wall = leaning_wall()
    for arguments in ({"each_edge": "imin = guide"}, {}):
        grid = layered(wavy_patch(), guide=wall, **arguments)
        edge = grid.points[0]
        assert off_the_wall(edge).max() < 2e-5  # the facets' own error
        assert (
            np.abs(edge[0, :, 1]).max() == 0 and np.abs(edge[-1, :, 1] - 2).max() < 1e-15
        )  # and in the planes of jmin, jmax
        heights = np.linalg.norm(np.diff(edge[9], axis=0), axis=1)
        assert heights[1:] / heights[:-1] == pytest.approx(1.15, rel=0.05)
    assert off_the_wall(layered(wavy_patch()).points[0]).max() > 0.05


def test_beyond_its_end_a_guide_goes_straight_on():
    wall = leaning_wall()
    short = mc.StructuredGrid(wall.points[:, :16])
    edge = layered(wavy_patch(), guide=short).points[0, 9]
    beyond = edge[edge[:, 2] > short.points[0, -1, 0, 2]]
    assert len(beyond) > 3
    (x, _, z), (along, _, up) = (beyond - beyond[0]).T, beyond[-1] - beyond[0]
    assert np.abs(x * up - z * along).max() < 1e-12  # in y they may slide along the guide


def test_coarse_guides_keep_edges_at_the_distance_they_had():
    wall = leaning_wall(12)
    edge = layered(wavy_patch(), guide=wall, each_edge="imin = guide").points[0]
    given = wavy_patch().points[0, :, 0]
    assert np.abs(edge[:, 0] - given).max() == 0
    step = edge[:, 1] - edge[:, 0]
    assert np.abs(np.linalg.norm(step, axis=1) - 0.01).max() < 1e-3  # no jump onto the facets


def test_corners_stay_on_curves():
    t = np.linspace(0, 1, 40)
    curve = np.column_stack([-0.2 * t**2, -0.3 * t, t])
    wall = leaning_wall().to_mesh()
    lines = lines_through(curve)
    both = mc.Mesh(
        np.concatenate([wall.points, lines.points]), {**wall.cells, "line": lines.get("line") + wall.n_points}
    )
    with pytest.raises(InvalidInput, match=r"leave no way to go at \(0, 0, 0\)"):  # the curve leaves the plane of jmin
        layered(wavy_patch(), guide=both, each_edge="imin = guide")
    grid = layered(wavy_patch(), guide=both, each_edge="imin = guide, jmin = free")
    corner = grid.points[0, 0]
    assert np.abs(corner[:, 1] + 0.3 * corner[:, 2]).max() < 1e-12
    assert np.abs(corner[:, 0] + 0.2 * corner[:, 2] ** 2).max() < 1e-4
    assert off_the_wall(grid.points[0, 1:]).max() < 2e-5


def test_guides_that_are_none_are_refused():
    with pytest.raises(InvalidInput, match="is needed"):
        layered(wavy_patch(), edges="guide")
    with pytest.raises(InvalidInput, match="does not hold the edge's point"):
        layered(wavy_patch(), guide=leaning_wall(), each_edge="imax = guide")
    with pytest.raises(InvalidInput, match="no curve begins there"):
        layered(wavy_patch(), guide=lines_through([[0, 0, 0], [0, 0, 1]]), each_edge="imin = guide")
    with pytest.raises(InvalidInput, match="triangles, quads or lines"):
        layered(wavy_patch(), guide=mc.Mesh(np.zeros((1, 3)), {"vertex": [[0]]}), each_edge="imin = guide")
