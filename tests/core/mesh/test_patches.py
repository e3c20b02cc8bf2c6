"""Boundary patches: faces without what cuts join, as ranges of points."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import meshcore as mc
from meshcore import Cut
from tests.core.mesh.test_structured_grid import box
from tests.cut_grids import c_shape, h_shape, on_a_step, quarter_turned, ring


def cells_of(patch: mc.Patch) -> int:
    return int(np.prod([max(high - low, 1) for low, high in zip(*patch.points, strict=True)]))


def boundary_cells(grid: mc.StructuredGrid | mc.MultiBlock) -> int:
    return sum(map(cells_of, mc.patches(grid)))


@pytest.mark.parametrize(
    "grid",
    [ring(12, 3), c_shape(4, 10, 3), h_shape(3), quarter_turned(1), box(4, 3, 5), box(4, 3, 1), on_a_step()],
    ids=["o", "c", "h", "turned", "volume", "plane", "step"],
)
def test_patches_are_the_boundary_of_the_glued_mesh(grid):
    assert boundary_cells(grid) == grid.to_mesh().boundary.n_cells
    blocks = grid.blocks if isinstance(grid, mc.MultiBlock) else [grid]
    for patch in mc.patches(grid):
        axis, last = "ijk".index(patch.face[0]), patch.face.endswith("max")
        assert patch.points[0][axis] == patch.points[1][axis] == last * (blocks[patch.block].shape[axis] - 1)


def test_a_hole_in_a_face_leaves_four_rectangles():
    step = [patch for patch in mc.patches(on_a_step()) if patch.name == "step"]
    assert sum(map(cells_of, step)) == 5 * 6 - 2 * 3 and len(step) == 4
    sides = mc.with_named_sides(on_a_step())
    assert {name: len(cells) for name, cells in sides.sets.items()} == {
        "floor": 30,
        "step": 24,
        "roof": 6,
        "boundary": 2 * 2 * (5 + 6) + 2 * 2 * (2 + 3),
    }


def test_the_wall_of_a_c_grid_is_what_the_wake_leaves():
    grid = replace(c_shape(4, 10, 3), names={"jmin": "wall", "jmax": "far field"})
    found = {(patch.face, patch.name): patch.points for patch in mc.patches(grid)}
    assert found["jmin", "wall"] == ((4, 0, 0), (14, 0, 0))
    assert found["imin", "boundary"] == ((0, 0, 0), (0, 3, 0))
    assert len(found) == 4


def test_sides_that_repeat_are_patches_only_for_those_who_ask():
    grid = box(4, 3, 1)
    width = grid.points[-1, 0, 0, 0] - grid.points[0, 0, 0, 0]
    cut = Cut(((0, 0, 0), (0, 2, 0)), ((3, 0, 0), (3, 2, 0)), translation=(width, 0, 0), name="pitch")
    grid = replace(grid, cuts=(cut,))
    assert Counter(patch.name for patch in mc.patches(grid)) == {"boundary": 2}
    asked = {patch.face: patch.name for patch in mc.patches(grid, moved=True)}
    assert asked == {"imin": "pitch", "imax": "pitch donor", "jmin": "boundary", "jmax": "boundary"}
    named = replace(grid, names={"imin": "low", "imax": "high"})
    assert {patch.face: patch.name for patch in mc.patches(named, moved=True)}["imax"] == "high"
    mesh = mc.with_named_sides(grid)
    assert {name: len(cells) for name, cells in mesh.sets.items()} == {"pitch": 2, "pitch donor": 2, "boundary": 6}


@given(st.lists(st.tuples(*[st.integers(0, 6)] * 4), max_size=4))
def test_any_holes_are_left_out_and_the_rest_is_covered_once(holes):
    from meshcore.mesh.patches import _rectangles

    free = np.ones((6, 5), bool)
    for i, j, di, dj in holes:
        free[i : i + di, j : j + dj] = False
    covered = np.zeros((6, 5), int)
    for (i, j, k), (i_end, j_end, k_end) in _rectangles(free, (7, 6, 4), 2, 1):
        assert k == k_end == 3
        covered[i:i_end, j:j_end] += 1
    assert np.array_equal(covered, free)
