"""The operation that smooths grids: what it reads, its cuts, its sides."""

import json
from dataclasses import replace

import numpy as np
import pytest

import meshcore as mc
from meshcore import Wall, gallery, io
from meshcore.cli import main
from meshcore.errors import InvalidGeometry, InvalidInput
from meshcore.structured.algebraic.quad_nets import grid_of
from meshcore.structured.poisson.barrier import weak_cells
from tests.core.structured.poisson.test_winslow import wavy


def planar(grid):
    return grid.points[:, :, 0, :2]


def rough_ring():
    return grid_of(gallery.rough_ring(), "grid")


def open_ring():
    """The ring as other programs write it: its cut is there twice, and nobody says that it is one."""
    return replace(rough_ring(), periodic=(False, False, False))


def folded():
    points = wavy(20, 16, 0.05)
    points[1:-1, 1:-1] += 0.1 * np.sin(40 * points[1:-1, 1:-1, ::-1])
    grid = mc.StructuredGrid(points, names={"jmin": "floor", "imin": "inflow"})
    assert weak_cells(planar(grid), 1.0).any()
    return grid.with_point_data(number=np.arange(grid.n_points).reshape(grid.shape))


def test_folds_go_and_names_data_and_boundary_stay():
    rough = folded()
    grid, report = mc.elliptically_smoothed(rough)
    assert report.converged and report.operation == "Elliptic Smoothing" and not report.warnings
    assert not weak_cells(planar(grid), 1.0).any()
    assert grid.names == rough.names and np.array_equal(grid.point_data["number"], rough.point_data["number"])
    for side in (np.s_[0], np.s_[-1], np.s_[:, 0], np.s_[:, -1]):
        assert np.array_equal(grid.points[side], rough.points[side])


def test_a_mesh_of_a_grid_is_the_grid():
    rough = folded()
    grid, _ = mc.elliptically_smoothed(rough)
    again, _ = mc.elliptically_smoothed(rough.to_mesh())
    assert np.array_equal(again.points, grid.points)
    assert np.array_equal(again.point_data["number"], rough.point_data["number"])


def test_the_cut_is_free_however_a_ring_is_given():
    ring = rough_ring()
    grid, report = mc.elliptically_smoothed(ring, residual=1e-10)
    assert report.converged and grid.periodic == (True, False, False)
    assert (grid.points[0] == grid.points[-1]).all() and (grid.points[:, [0, -1]] == ring.points[:, [0, -1]]).all()
    turned = np.roll(grid.points[:-1], -1, axis=0)
    for given in (open_ring(), gallery.rough_ring(), open_ring().to_mesh()):
        again = mc.elliptically_smoothed(given, residual=1e-10).mesh
        assert again.periodic == grid.periodic and np.array_equal(again.points, grid.points)
    # Where a ring is cut does not matter: the cut is a line like any other.
    moved = np.roll(ring.points[:-1], -1, axis=0)
    moved = mc.StructuredGrid(np.concatenate([moved, moved[:1]]))
    assert np.abs(mc.elliptically_smoothed(moved, residual=1e-10).mesh.points[:-1] - turned).max() < 1e-7


def test_a_ring_becomes_the_annulus_that_is_known():
    """Points spread evenly on two circles: r grows geometrically, for ln r and the angle are harmonic."""
    mesh, _ = mc.elliptically_smoothed(gallery.rough_ring(96, 32), residual=1e-10)
    radius = np.linalg.norm(planar(mesh), axis=-1)
    assert np.abs(radius / 3 ** (np.arange(33) / 32) - 1).max() < 2e-3


def test_quads_in_any_order_make_a_ring_or_a_patch():
    rng = np.random.default_rng(3)
    for mesh in (gallery.rough_ring(8, 3), folded().to_mesh()):
        quads = mesh.get("quad")
        number = rng.permutation(mesh.n_points)
        quads = np.array([np.roll(quad, k) for quad, k in zip(quads, rng.integers(4, size=len(quads)), strict=True)])
        points = np.empty_like(mesh.points)
        points[number] = mesh.points
        shuffled = mc.Mesh(points, {"quad": rng.permutation(number[quads])})
        grid = grid_of(shuffled, "grid")
        assert sorted(grid.cell_shape[:2]) == sorted(grid_of(mesh, "grid").cell_shape[:2])
        cells = {tuple(sorted(map(tuple, cell))) for cell in points[shuffled.get("quad")].tolist()}
        found = grid.to_mesh()
        assert {tuple(sorted(map(tuple, cell))) for cell in found.points[found.get("quad")].tolist()} == cells
        assert (mc.quality.measure(found, "jacobian") > 0).mean() > 0.5


def test_walls_by_name_are_walls_one_by_one():
    rough, _ = mc.o_grid(gallery.airfoil("naca0012", cells=64), radius=4, layers=24, first_height=0.02)
    one, report = mc.elliptically_smoothed(rough, walls="south", first_height=0.02, wall_angle=85.0)
    other, _ = mc.elliptically_smoothed(rough, each_wall=[Wall("south", 0.02, 85.0)])
    assert report.converged and np.array_equal(one.points, other.points)
    both = [mc.elliptically_smoothed(rough, walls=walls).mesh.points for walls in ("all", "south and north")]
    assert np.array_equal(*both)  # the cut is no wall
    for wrong in ({"walls": "west"}, {"each_wall": [Wall("east")]}):
        with pytest.raises(InvalidInput, match="is where the periodic grid is cut"):
            mc.elliptically_smoothed(rough, **wrong)
    with pytest.raises(InvalidInput, match="give only one of them"):
        mc.elliptically_smoothed(rough, walls="south", each_wall=[Wall("north")])
    with pytest.raises(InvalidInput, match="but no walls"):
        mc.elliptically_smoothed(rough, first_height=0.1)


def test_points_slide_along_a_wall():
    rough = folded()
    grid, _ = mc.elliptically_smoothed(rough, walls="south", sliding=True)
    other, _ = mc.elliptically_smoothed(rough, each_wall=[Wall("south", slides=True)])
    assert np.array_equal(grid.points, other.points)
    assert np.abs(planar(grid)[1:-1, 0] - planar(rough)[1:-1, 0]).max() > 1e-4
    assert np.array_equal(planar(grid)[[0, -1]], planar(rough)[[0, -1]])


def test_a_left_handed_grid_is_reversed_and_that_is_told():
    rough = folded()
    grid, report = mc.elliptically_smoothed(rough.reversed_along_i())
    assert "east and west have changed places" in report.warnings[0]
    assert np.array_equal(grid.points, mc.elliptically_smoothed(rough).mesh.points)
    assert grid.names == rough.names and np.array_equal(grid.point_data["number"], rough.point_data["number"])


def test_what_is_no_grid_is_refused():
    quads = mc.StructuredGrid(wavy(5, 4, 0.0)).to_mesh()
    with pytest.raises(InvalidGeometry, match="quads alone"):
        mc.elliptically_smoothed(gallery.triangulated_square())
    for lost in ([0], [7], [5, 6]):
        kept = mc.Mesh(quads.points, {"quad": np.delete(quads.get("quad"), lost, axis=0)}).compacted()
        with pytest.raises(InvalidGeometry, match=r"four corners|rows and columns"):
            mc.elliptically_smoothed(kept)
    ring = gallery.rough_ring(8, 3)
    with pytest.raises(InvalidGeometry, match="rows and columns"):
        kept = mc.Mesh(ring.points, {"quad": np.delete(ring.get("quad"), 11, axis=0)})
        mc.elliptically_smoothed(kept)
    both = np.concatenate([ring.get("quad"), ring.get("quad") + ring.n_points])
    two = mc.Mesh(np.concatenate([ring.points, ring.points + 9]), {"quad": both})
    with pytest.raises(InvalidGeometry, match="rows and columns"):
        mc.elliptically_smoothed(two)
    with pytest.raises(InvalidInput, match="needs a StructuredGrid or a Mesh, got list"):
        mc.elliptically_smoothed([[0, 0, 0]])
    with pytest.raises(InvalidGeometry, match="four corners"):
        mc.elliptically_smoothed(gallery.dented_box(4))


@pytest.mark.parametrize("make", [rough_ring, open_ring])
def test_the_command_line_smooths_a_file(tmp_path, capsys, make):
    given, made = tmp_path / "rough.vts", tmp_path / "smooth.vts"
    io.write(given, make())
    assert main(["elliptically-smoothed", str(given), "-o", str(made), "--walls", "south", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["converged"]
    found = io.read(made)
    expected = mc.elliptically_smoothed(rough_ring(), walls="south").mesh
    assert found.periodic == (True, False, False) and np.array_equal(found.points, expected.points)


def unit(ni, nj):
    return np.stack(np.meshgrid(np.linspace(0, 1, ni), np.linspace(0, 1, nj), [0.0], indexing="ij"), axis=-1)


@pytest.mark.parametrize(
    ("points", "keywords", "error", "text"),
    [
        (1e300 * unit(4, 4), {}, InvalidGeometry, r"grid: has an extent of 1e\+300; scale it"),
        (1e-200 * unit(4, 4), {}, InvalidGeometry, "grid: has an extent of 1e-200; scale it"),
        (
            unit(5, 5) * np.r_[0.0, np.ones(4)][None, :, None, None] ** [1, 0, 0],
            {"walls": "south"},
            InvalidGeometry,
            "two points at",
        ),
        (unit(5, 5), {"each_wall": ["south"]}, InvalidInput, "each_wall: needs walls in a list"),
        (unit(5, 5), {"each_wall": 3}, InvalidInput, "each_wall: needs walls in a list"),
        (
            unit(5, 5),
            {"each_wall": [Wall("south", first_height=[0.1, 0.1])]},
            InvalidInput,
            "south has 5 points, but its first height",
        ),
        (unit(5, 5), {"control_functions": "xy"}, InvalidInput, "control_functions: needs a tuple of arrays"),
        (unit(5, 5), {"control_functions": (1j, 0)}, InvalidInput, "control_functions: P needs real numbers, got 1j"),
        (unit(5, 5), {"control_functions": (lambda i, j: "a", 0)}, InvalidInput, "P needs real numbers"),
    ],
)
def test_impossible_grids_and_walls_are_refused(points, keywords, error, text):
    with pytest.raises(error, match=text):
        mc.elliptically_smoothed(mc.StructuredGrid(points), **keywords)
