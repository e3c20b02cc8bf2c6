"""Cuts as data: checked, crossed, glued, turned round."""

from dataclasses import replace

import numpy as np
import pytest

from meshcore import Cut, InvalidGeometry, InvalidInput, MultiBlock, StructuredGrid, degenerate
from meshcore.io.vtk_data import decoded, encoded
from tests.core.mesh.test_structured_grid import box
from tests.cut_grids import c_shape, quarter_turned, ring


def test_index_beyond_the_wake_is_above_it_on_the_other_side():
    grid = c_shape(6, 10, 4)
    (cut,) = grid.cuts
    n = grid.shape[0] - 1
    assert cut.across([[2, -1, 0]]).tolist() == [[n - 2, 1, 0]]
    assert cut.reversed().across(cut.across([[2, -1, 0]])).tolist() == [[2, -1, 0]]


def test_the_wake_is_no_crack():
    grid = c_shape(6, 10, 4)
    mesh = grid.to_mesh()
    assert mesh.n_points == grid.n_points - 7  # 6 cells of wake, and the trailing edge
    assert mesh.boundary.n_cells == 22 + 10 + 2 * 4  # the outer side, the circle, and the two ends


@pytest.mark.parametrize("turn", range(4))
def test_blocks_are_glued_in_any_orientation(turn):
    blocks = quarter_turned(turn)
    mesh = blocks.to_mesh()
    assert mesh.n_points == blocks.n_points - 4 and mesh.n_cells == blocks.n_cells
    assert mesh.boundary.n_cells == 2 * (7 + 3)
    assert {name: len(cells) for name, cells in mesh.sets.items()} == {"block 0": 12, "block 1": 9}


def test_reversed_twice_is_the_same_also_when_it_moves():
    turn = ((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    cut = Cut(((0, 0, 0), (0, 3, 2)), ((4, 1, 3), (1, 1, 1)), (2, -1, -3), 0, 1, turn, (1.0, 2.0, 3.0))
    again = cut.reversed().reversed()
    assert again.points == cut.points and again.transform == cut.transform and again.block == cut.block
    x = np.array([0.3, 0.4, 0.5])
    assert np.allclose(again.moved(x), cut.moved(x)) and np.allclose(cut.reversed().moved(cut.moved(x)), x)


def test_counted_from_the_other_end_the_cut_holds():
    grid = c_shape(6, 10, 4).reversed_along_i()
    assert len(grid.cuts) == 1 and grid.to_mesh().n_points == grid.n_points - 7


@pytest.mark.parametrize(
    ("change", "error", "text"),
    [
        ({"transform": (1, 1, 3)}, InvalidInput, "any order"),
        ({"transform": (1, -2, 3)}, InvalidInput, "leads"),
        ({"partner": ((22, 0, 0), (15, 0, 0))}, InvalidInput, "same shape"),
        ({"points": ((0, 0, 0), (60, 0, 0)), "partner": ((22, 0, 0), (-38, 0, 0))}, InvalidInput, "no point of block"),
        ({"points": ((0, 1, 0), (6, 1, 0))}, InvalidInput, "no face"),
        ({"transform": (-1, 2, 3)}, InvalidInput, "leads from outside"),
        ({"partner": ((21, 0, 0), (15, 0, 0))}, InvalidGeometry, "from its partner"),
        ({"partner_block": 3}, InvalidInput, "no block 3"),
        ({"rotation": ((1, 0, 0), (0, 2, 0), (0, 0, 1))}, InvalidInput, "orthogonal"),
        ({"points": 4}, InvalidInput, "first and the last"),
    ],
)
def test_cuts_that_do_not_fit_are_refused(change, error, text):
    grid = c_shape(6, 10, 4)
    (cut,) = grid.cuts
    if change.get("partner") == ((21, 0, 0), (15, 0, 0)):
        change = {**change, "points": ((0, 0, 0), (6, 0, 0))}
    with pytest.raises(error, match=text):
        replace(grid, cuts=(replace(cut, **change),))


def test_periodic_sides_may_be_moved_along():
    grid = box(4, 3, 1)
    cut = Cut(((0, 0, 0), (0, 2, 0)), ((3, 0, 0), (3, 2, 0)), translation=(3.0, 0.0, 0.0))
    assert replace(grid, cuts=(cut,)).to_mesh().n_points == grid.n_points
    with pytest.raises(InvalidGeometry, match="from its partner"):
        replace(grid, cuts=(replace(cut, translation=(2.0, 0.0, 0.0)),))


def test_cuts_stand_in_files_and_go_when_they_no_longer_hold():
    grid = c_shape(6, 10, 4)
    assert decoded(encoded(grid)).cuts == grid.cuts
    data = encoded(grid)
    data.points = data.points * [1, 1, 1] + np.arange(len(data.points))[:, None]
    with pytest.warns(UserWarning, match="cuts"):
        assert decoded(data).cuts == ()


def test_collapsed_sides_edges_and_flat_corners_are_found():
    assert degenerate(ring(12, 4)) == ()
    disk = StructuredGrid(np.concatenate([np.zeros((13, 1, 1, 3)), ring(12, 4).points], axis=1))
    assert next((d.place, d.kind) for d in degenerate(disk)) == ("jmin", "point")
    cube = box(3, 4, 5).points.copy()
    cube[:, 0, 0] = cube[0, 0, 0]
    assert [(d.place, d.kind) for d in degenerate(StructuredGrid(cube))] == [("jmin kmin", "point")]
    wedge = box(3, 4, 5).points.copy()
    wedge[0, :, :, 1] = 0.0
    assert [(d.place, d.kind) for d in degenerate(StructuredGrid(wedge))] == [("imin", "line")]
    flat = StructuredGrid(np.array([[[0, 0], [-1, 0], [-1, -1]], [[1, 0], [0.5, -0.5], [0, -1]]], float))
    assert ("imin jmin", "straight") in [(d.place, d.kind) for d in degenerate(flat)]
    assert isinstance(MultiBlock((flat,)).joins, tuple)
