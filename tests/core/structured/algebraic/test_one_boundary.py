"""A patch's boundary in one piece: corners marked, found and moved; four chains in any order and direction."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import meshcore as mc
from meshcore import gallery
from meshcore.errors import InvalidGeometry, InvalidInput
from meshcore.geometry.curves import lines_through
from meshcore.mesh import Mesh
from meshcore.structured.algebraic.one_boundary import FOUND, cut_loop, four_chains

WAVY = tuple(np.round(side, 9) for side in gallery.wavy_sides(12, 7))


def corners_of(grid):
    """The four corner points of a grid, as a set."""
    return {tuple(np.round(grid.points[i, j, 0], 9) + 0.0) for i in (0, -1) for j in (0, -1)}


def on_circle(numbers, n=24):
    return {tuple(np.round(gallery.circle(n).points[k % n], 9) + 0.0) for k in numbers}


def apart(order, backwards, gap=0.0):
    """The wavy sides as one mesh of four chains that share no points."""
    sides = [WAVY[k][::-1] if back else WAVY[k] for k, back in zip(order, backwards, strict=True)]
    sides = [side + gap * np.array([k % 2, 0, 0]) for k, side in enumerate(sides)]
    starts = np.cumsum([0] + [len(side) for side in sides])
    lines = [np.column_stack([np.arange(a, b - 1), np.arange(a + 1, b)]) for a, b in pairwise(starts)]
    return Mesh(np.concatenate(sides), {"line": np.concatenate(lines)})


@given(st.permutations(range(4)), st.tuples(*[st.booleans()] * 4))
def test_four_chains_in_one_mesh_are_four_sides(order, backwards):
    named, _ = mc.transfinite(*WAVY)
    grid, report = mc.transfinite(apart(order, backwards))
    assert not report.warnings  # nobody said which side is which, or how it runs
    a, b = (np.unique(g.points.round(9).reshape(-1, 3), axis=0) for g in (named, grid))
    assert np.array_equal(a, b)
    first = {tuple(p) for p in grid.points[:, 0, 0].round(9) + 0.0}
    assert first == {tuple(p) for p in WAVY[order[0]] + 0.0}  # the first chain is south


def test_four_chains_that_nearly_meet_are_joined_within_tolerance():
    grid, _ = mc.elliptic(apart(range(4), [False] * 4, gap=1e-3), tolerance=2e-3)
    assert grid.shape == (13, 8, 1)
    with pytest.raises(InvalidGeometry, match=r"apart at .*; move their ends together"):
        mc.elliptic(apart(range(4), [False] * 4, gap=1e-3))


def test_other_numbers_of_chains_are_refused():
    chains = apart(range(4), [False] * 4, gap=0.1)
    three = Mesh(chains.points, {"line": chains.get("line")[: 12 + 7 + 12]}).compacted()
    with pytest.raises(InvalidGeometry, match=r"one closed loop or four chains.*got 3"):
        mc.transfinite(three)
    assert four_chains(three) is None and four_chains(gallery.square(3)) is None


@pytest.mark.parametrize("operation", [mc.transfinite, mc.elliptic])
def test_corners_that_were_found_can_be_moved(operation):
    grid, _ = operation(gallery.circle(24), cells_i=6, cells_j=6)
    assert corners_of(grid) == on_circle({0, 6, 12, 18})
    moved, _ = operation(gallery.circle(24), shift_corners=(-2, 0, 1, 0), cells_i=6, cells_j=6)
    assert corners_of(moved) == on_circle({22, 6, 13, 18})
    given, _ = operation(gallery.circle(24), corners=(1, 7, 12, 18), shift_corners=(-1, -1, 1, 0), cells_i=6, cells_j=6)
    assert corners_of(given) == on_circle({0, 6, 13, 18})


@pytest.mark.parametrize("shifts", [(6, 0, 0, 0), (0, 0, 0, 6), (-6, 0, 0, 0), (0, 7, 0, 0), (0, 0, 0, 10**9)])
def test_corners_that_would_meet_or_pass_each_other_are_refused(shifts):
    with pytest.raises(InvalidInput, match="0, 6, 12, 18 of 24") as caught:
        cut_loop(gallery.circle(24), FOUND, shifts)
    assert caught.value.parameter == "shift_corners"


def test_vertex_cells_mark_corners():
    circle = gallery.circle(24)
    marked = Mesh(circle.points, {**circle.cells, "vertex": [[2], [9], [14], [20]]})
    assert corners_of(mc.transfinite(marked, cells_i=6, cells_j=6).mesh) == on_circle({2, 9, 14, 20})
    five = Mesh(circle.points, {**circle.cells, "vertex": [[2], [9], [14], [20], [21]]})
    assert corners_of(mc.transfinite(five, cells_i=6, cells_j=6).mesh) == on_circle({0, 6, 12, 18})


def test_tags_of_lines_mark_corners():
    loop = lines_through(gallery.circle(24).points, closed=True)
    shuffle = np.random.default_rng(3).permutation(24)
    tag = np.repeat([5, 6, 5, 7], [3, 7, 6, 8])  # corners at 0, 3, 10, 16
    lines = loop.get("line")[shuffle]
    lines[::2] = lines[::2, ::-1]
    tagged = Mesh(loop.points, {"line": lines}, cell_data={"tag": tag[shuffle], "height": np.linspace(0, 1, 24)})
    assert corners_of(mc.transfinite(tagged, cells_i=6, cells_j=6).mesh) == on_circle({0, 3, 10, 16})


@pytest.mark.parametrize("as_lines", [True, False])
def test_a_loop_that_is_closed_within_tolerance_is_closed(as_lines):
    angle = np.linspace(0, 2 * np.pi, 25)  # whose last point is 2e-16 off its first
    points = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    assert (points[0] != points[-1]).any()
    curve = lines_through(points) if as_lines else points
    grid, _ = mc.elliptic(curve, cells_i=6, cells_j=6)
    assert corners_of(grid) == on_circle({0, 6, 12, 18})
    with pytest.raises(InvalidGeometry, match="is open"):
        mc.elliptic(curve, cells_i=6, cells_j=6, tolerance=0)


def test_pieces_of_a_loop_that_touch_within_tolerance_are_joined():
    n = 24
    points = np.concatenate([gallery.circle(n).points, gallery.circle(n).points[:2] + 1e-9])
    lines = [(k, k + 1) for k in range(n - 1)] + [(n - 1, n)]  # closed by a double of point 0
    pieces = Mesh(points, {"line": [line for line in lines if line != (11, 12)] + [(11, n + 1)]})
    pieces = pieces.with_points(np.concatenate([points[:-1], points[12:13] - 1e-9]))
    assert corners_of(mc.transfinite(pieces, cells_i=6, cells_j=6).mesh) == on_circle({0, 6, 12, 18})


@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize(("moved", "name"), [("west", "south"), ("east", "south"), ("north", "east")])
def test_a_gap_is_told_with_its_place_and_point(moved, name, backwards):
    sides = dict(zip(("south", "east", "north", "west"), WAVY, strict=True))
    sides[moved] = sides[moved] + [0.2, 0, 0] if moved != "north" else sides[moved] + [0, 0.2, 0]
    if backwards:
        sides = {key: side[::-1] for key, side in sides.items()}
    shuffled = lines_through(sides[name])
    order = np.random.default_rng(2).permutation(shuffled.n_points)
    mesh = Mesh(shuffled.points[order], {"line": np.argsort(order)[shuffled.get("line")]})
    with pytest.raises(InvalidGeometry, match=r"0\.2 apart at ") as caught:
        mc.transfinite(**{**sides, name: mesh})
    assert caught.value.parameter == name
    (point,) = caught.value.points
    ends = {tuple(sides[name][0]), tuple(sides[name][-1])}
    assert tuple(mesh.points[point]) in ends
    x, y, _ = mesh.points[point]
    assert f"({x:.6g}, {y:.6g}, 0)" in str(caught.value)
