"""Sides of grids as cells with names: markers of SU2, without the cuts."""

import numpy as np

import meshcore as mc
from meshcore import gallery
from tests.core.mesh.test_structured_grid import box
from tests.core.mesh.test_topology import enclosed_volume


def test_the_wake_is_no_side_and_all_others_are(tmp_path):
    grid, _ = mc.c_grid(gallery.airfoil("rae2822"), radius=3)
    mesh = mc.with_named_sides(grid)
    wake, n = grid.cuts[0].points[1][0], grid.cell_shape[0]
    layers = grid.cell_shape[1]
    assert {k: len(v) for k, v in mesh.sets.items()} == {"outflow": 2 * layers, "wall": n - 2 * wake, "far field": n}
    assert len(mesh.get("line")) == grid.to_mesh().boundary.n_cells
    mc.io.write(tmp_path / "c.su2", grid)
    again = mc.io.read(tmp_path / "c.su2")
    assert {k: len(v) for k, v in again.sets.items()} == {k.replace(" ", "_"): len(v) for k, v in mesh.sets.items()}
    assert np.array_equal(np.sort(again.points, axis=0), np.sort(mesh.points, axis=0))


def test_of_a_ring_only_two_sides_are_left():
    grid, _ = mc.o_grid(gallery.circle(24), radius=3, layers=8)
    assert {k: len(v) for k, v in mc.with_named_sides(grid).sets.items()} == {"wall": 24, "far field": 24}


def test_the_sides_of_a_volume_close_it():
    from dataclasses import replace

    mesh = mc.with_named_sides(replace(box(4, 3, 5), names={"imin": "in", "imax": "out"}))
    assert {k: len(v) for k, v in mesh.sets.items()} == {"in": 8, "out": 8, "boundary": 2 * 12 + 2 * 6}
    assert enclosed_volume(mc.Mesh(mesh.points, {"hexahedron": mesh.get("hexahedron")}).boundary) > 0


def test_blocks_are_glued_with_their_sides(tmp_path):
    blocks, _ = mc.h_grid(gallery.airfoil("naca0012"), radius=3, first_height=0.005)
    mc.io.write(tmp_path / "h.su2", blocks)
    mesh = mc.io.read(tmp_path / "h.su2")
    assert set(mesh.sets) == {"wall", "far_field", "inflow", "outflow"} and mesh.n_points == blocks.to_mesh().n_points


def test_sides_have_the_data_of_the_cells_that_they_bound():
    grid, _ = mc.c_grid(gallery.airfoil("rae2822"), radius=3)
    blocks, _ = mc.h_grid(gallery.airfoil("naca0012"), radius=3, first_height=0.005)
    for given in (grid, blocks, box(4, 3, 5)):
        own = given.blocks if isinstance(given, mc.MultiBlock) else (given,)
        rng = np.random.default_rng(0)
        own = tuple(block.with_cell_data(a=rng.random(block.cell_shape)) for block in own)
        mesh = mc.with_named_sides(mc.MultiBlock(own, given.names, given.cuts) if len(own) > 1 else own[0])
        kinds = list(mesh.cells)
        assert len(kinds) == 2
        inner, sides = (mesh.cells[kind].tolist() for kind in kinds)
        value = mesh.cell_data["a"]
        with_point: dict[int, set[int]] = {}
        for k, nodes in enumerate(inner):
            for node in nodes:
                with_point.setdefault(node, set()).add(k)
        for k, nodes in enumerate(sides, len(inner)):
            (owner,) = set.intersection(*(with_point[node] for node in nodes))
            assert value[k] == value[owner]
