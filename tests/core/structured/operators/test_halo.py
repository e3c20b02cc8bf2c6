"""Haloes: what stands beyond cuts, in any orientation."""

from dataclasses import replace

import numpy as np
import pytest

from meshcore import Cut, InvalidInput, MultiBlock, StructuredGrid, with_halo
from tests.core.mesh.test_structured_grid import box
from tests.cut_grids import c_shape, quarter_turned, ring


def numbered(grid: StructuredGrid) -> StructuredGrid:
    """With data that tell where points and cells are."""
    middle = grid.points
    for axis in range(3):
        if middle.shape[axis] > 1:
            lines = np.moveaxis(middle, axis, 0)
            middle = np.moveaxis(0.5 * (lines[1:] + lines[:-1]), 0, axis)
    return grid.with_point_data(x=grid.points).with_cell_data(x=middle)


def test_beyond_the_cut_of_a_ring_it_goes_on():
    halo = with_halo(numbered(ring(12, 4)), 3)
    again = ring(12, 4, start=-3)
    assert np.allclose(halo.grid.points[:13, 3:-3], again.points, atol=1e-14)
    assert np.array_equal(halo.grid.point_data["x"][:, 3:-3], halo.grid.points[:, 3:-3])
    assert halo.known[:, 3:-3].all() and not halo.known[:, :3].any()
    assert np.allclose(halo.grid.cell_data["x"][:3, 3:-3], numbered(again).cell_data["x"][:3])
    assert (halo.grid.points[halo.inside] == ring(12, 4).points).all()


def test_beyond_the_wake_of_a_c_grid_is_its_other_side():
    grid = numbered(c_shape(8, 12, 6))
    halo = with_halo(grid, 2)
    n = grid.shape[0] - 1
    below = halo.grid.points[2 : 2 + 9, 0:2]
    assert np.array_equal(below[:, ::-1], grid.points[n - np.arange(9), 1:3])
    assert halo.known[2 : 2 + 9, :2].all() and not halo.known[2 + 9 : n + 2 - 8, :2].any()
    cells = halo.grid.cell_data["x"][2 : 2 + 8, :2]
    assert np.array_equal(cells[:, ::-1], grid.cell_data["x"][n - 1 - np.arange(8), :2])


@pytest.mark.parametrize("turn", range(4))
def test_in_any_orientation_the_plane_goes_on(turn):
    blocks = quarter_turned(turn)
    blocks = MultiBlock(tuple(map(numbered, blocks.blocks)), cuts=blocks.cuts)
    for halo in with_halo(blocks, 2):
        known = halo.known_cells
        points = halo.grid.points
        steps = np.linalg.norm(np.diff(points, axis=0), axis=-1)
        assert np.allclose(steps, 1) and np.allclose(np.linalg.norm(np.diff(points, axis=1), axis=-1), 1)
        assert np.array_equal(halo.grid.point_data["x"][halo.known], points[halo.known])
        middles = 0.25 * (points[1:, 1:] + points[:-1, 1:] + points[1:, :-1] + points[:-1, :-1])
        assert np.array_equal(halo.grid.cell_data["x"][known], middles[known])
        assert known.sum() > halo.grid.cell_data["x"][halo.inside_cells].size / 3
    first, second = with_halo(blocks, 2)
    assert first.known.sum() == 5 * 4 + 2 * 4 and second.known.sum() == 4 * 4 + 2 * 4


def test_a_torus_of_three_periods_has_a_whole_halo_and_moves_it():
    grid = box(4, 5, 3)
    cuts = []
    for axis, n in enumerate((3, 4, 2)):
        last, first = [3, 4, 2], [0, 0, 0]
        last[axis], first[axis] = 0, n
        move = [0.0, 0.0, 0.0]
        move[axis] = float(n)
        cuts.append(Cut(((0, 0, 0), tuple(last)), (tuple(first), (3, 4, 2)), translation=tuple(move)))
    halo = with_halo(replace(grid, cuts=tuple(cuts)), 2)
    assert halo.known.all() and halo.known_cells.all()
    i, j, k = np.meshgrid(*(np.arange(-2.0, n + 2) for n in grid.shape), indexing="ij")
    assert np.array_equal(halo.grid.points, np.stack([i, j, k], axis=-1))


def test_a_sector_turned_into_itself_goes_round():
    angle, radius = np.meshgrid(np.radians([0, 30, 60, 90]), [1.0, 2.0, 3.0], indexing="ij")
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle], axis=-1)
    turn = ((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    cut = Cut(((0, 0, 0), (0, 2, 0)), ((3, 0, 0), (3, 2, 0)), rotation=turn)
    halo = with_halo(StructuredGrid(points, cuts=(cut,)), 1)
    assert np.allclose(halo.grid.points[0, 1:-1, 0], points[1] * [1, -1, 1])
    assert np.allclose(halo.grid.points[-1, 1:-1, 0], points[2] * [-1, 1, 1])


@pytest.mark.parametrize(("grid", "width"), [(None, 1), (ring(8, 2), 0), (ring(8, 2), 1.5)])
def test_what_has_no_halo(grid, width):
    with pytest.raises(InvalidInput):
        with_halo(grid, width)
