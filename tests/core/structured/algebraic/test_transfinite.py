"""Transfinite interpolation: sides kept, exact on what it is exact for, blind to naming, honest about overspill."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import meshcore as mc
from meshcore import gallery
from meshcore.errors import Cancelled, GenerationFailed, InvalidGeometry, InvalidInput
from meshcore.geometry.curves import arc_length, lines_through
from meshcore.sizing import geometric
from meshcore.structured.algebraic.transfinite import interpolated
from meshcore.structured.folds import folded_cells
from tests import naive

WAVY = tuple(np.round(side, 9) for side in gallery.wavy_sides(12, 7))  # rounded, so that corners meet exactly


def on_patch(patch, s, t):
    """South, east, north, west of ``patch(s, t)`` at fractions s and t."""

    def side(u, v):
        return np.array([patch(a, b) for a, b in np.broadcast(u, v)])

    return side(s, 0.0), side(1.0, t), side(s, 1.0), side(0.0, t)


def bilinear(corners):
    a, b, c, d = np.asarray(corners, float)
    return lambda s, t: (1 - s) * (1 - t) * a + s * (1 - t) * b + s * t * c + (1 - s) * t * d


def as_set(points):
    """Points in an order that does not depend on their numbering."""
    flat = np.round(points.reshape(-1, 3), 9) + 0.0
    return flat[np.lexsort(flat.T)]


@pytest.mark.parametrize("blending", ["arc length", "linear"])
def test_sides_are_reproduced_to_the_bit(blending):
    grid, _ = mc.transfinite(*WAVY, blending=blending)
    south, east, north, west = WAVY
    for face, side in ((grid.points[:, 0], south), (grid.points[-1], east), (grid.points[:, -1], north)):
        assert (face[:, 0] == side).all()
    assert (grid.points[0, :, 0] == west).all()


@pytest.mark.parametrize("blending", ["arc length", "linear"])
def test_equals_the_formula_point_by_point(blending):
    rng = np.random.default_rng(8)
    sides = [side + 0.02 * rng.random(side.shape) for side in WAVY]
    sides[1][0], sides[1][-1], sides[3][0], sides[3][-1] = sides[0][-1], sides[2][-1], sides[0][0], sides[2][0]
    if blending == "linear":
        s, t = np.meshgrid(np.linspace(0, 1, 13), np.linspace(0, 1, 8), indexing="ij")
    else:
        s, t = naive.crossing_of_lengths(*sides)
    assert np.abs(interpolated(*sides, blending=blending) - naive.coons(*sides, s, t)).max() < 1e-13


@given(st.integers(2, 9), st.integers(2, 9), st.floats(0.5, 2), st.floats(0.5, 2), st.integers(0, 10**6))
def test_bilinear_patches_are_exact_at_any_spacing(n, m, ratio_s, ratio_t, seed):
    corners = np.array([[0, 0, 0], [3, 0, 1], [3, 2, 0], [0, 2, 2]]) + np.random.default_rng(seed).random((4, 3)) * 0.5
    s, t = geometric(n, ratio=ratio_s), geometric(m, ratio=ratio_t)
    patch = bilinear(corners)
    exact = np.array([[patch(a, b) for b in t] for a in s])
    grid, _ = mc.transfinite(*on_patch(patch, s, t))
    assert np.abs(grid.points[:, :, 0] - exact).max() < 1e-12


def test_coons_patches_are_exact_with_linear_blending():
    """A patch that is linear in s between any west and east is its own Coons patch."""

    def patch(s, t):
        west = np.array([0.2 * np.sin(3 * t), t, t**2])
        east = np.array([2 + t**3, 1.5 * t, np.cos(t)])
        return (1 - s) * west + s * east

    s, t = np.linspace(0, 1, 9), np.linspace(0, 1, 6)
    exact = np.array([[patch(a, b) for b in t] for a in s])
    assert np.abs(interpolated(*on_patch(patch, s, t)) - exact).max() < 1e-14


@pytest.mark.parametrize("blending", ["arc length", "linear"])
def test_cyclic_naming_and_reversal_give_the_same_points(blending):
    south, east, north, west = WAVY
    first = as_set(mc.transfinite(south, east, north, west, blending=blending).mesh.points)
    others = [(east, north, west, south), (north, west, south, east), (west, south, east, north)]
    others += [(north, east, south, west), (south[::-1], east, north[::-1], west[::-1])]
    for sides in others:
        grid, _ = mc.transfinite(*sides, blending=blending)
        assert np.abs(as_set(grid.points) - first).max() < 2e-9
        assert (naive.cross_areas(grid.points[:, :, 0]) > 0).all()


@given(st.floats(0, 2 * np.pi), st.floats(1e-3, 1e3), st.floats(-5, 5))
def test_moves_with_the_sides(angle, scale, shift):
    c, s = np.cos(angle), np.sin(angle)
    turn = scale * np.array([[c, -s, 0], [0.6 * s, 0.6 * c, -0.8], [0.8 * s, 0.8 * c, 0.6]])
    grid, _ = mc.transfinite(*WAVY)
    moved, _ = mc.transfinite(*(side @ turn.T + shift for side in WAVY))
    assert np.abs(moved.points - (grid.points @ turn.T + shift)).max() < 1e-11 * max(scale, 1)


def test_a_left_handed_patch_is_turned_and_keeps_its_names():
    south, east, north, west = WAVY
    mirror = np.array([-1.0, 1, 1])
    grid, _ = mc.transfinite(south * mirror, east * mirror, north * mirror, west * mirror)
    assert (naive.cross_areas(grid.points[:, :, 0]) > 0).all()
    assert grid.names == {"jmin": "south", "imax": "west", "jmax": "north", "imin": "east"}
    assert (grid.points[:, 0, 0] == (south * mirror)[::-1]).all()
    assert (grid.points[0, :, 0] == east * mirror).all()


def test_line_cells_in_any_order_are_sides_too():
    meshes = []
    for k, side in enumerate(WAVY):
        mesh = lines_through(side)
        order = np.random.default_rng(k).permutation(len(side))
        lines = np.argsort(order)[mesh.get("line")][::-1]
        meshes.append(mc.Mesh(side[order], {"line": lines}))
    assert (mc.transfinite(*meshes).mesh.points == mc.transfinite(*WAVY).mesh.points).all()


def test_a_closed_loop_is_cut_at_its_corners():
    loop = gallery.square(6)
    grid, _ = mc.transfinite(loop)
    assert grid.shape == (7, 7, 1)
    x, y = np.meshgrid(np.arange(7) / 6, np.arange(7) / 6, indexing="ij")
    assert np.abs(as_set(grid.points) - as_set(np.stack([x, y, 0 * x], axis=-1))).max() < 1e-12


def test_corners_are_numbered_as_in_the_users_mesh():
    loop = gallery.circle(24)
    order = np.random.default_rng(3).permutation(24)
    shuffled = mc.Mesh(loop.points[order], {"line": np.argsort(order)[loop.get("line")]})
    wanted = [1, 6, 13, 18]
    grid, _ = mc.transfinite(shuffled, corners=tuple(np.argsort(order)[wanted].tolist()))
    found = as_set(grid.points[[0, -1, -1, 0], [0, 0, -1, -1]])
    assert (found == as_set(loop.points[wanted])).all()


def test_a_loop_with_unequal_sides_is_resampled():
    grid, _ = mc.transfinite(gallery.circle(25), corners=(0, 5, 12, 18))
    assert grid.cell_shape == (6, 7, 1)


@given(st.integers(4, 40), st.floats(-5, -2), st.floats(-5, -2))
def test_spacing_reaches_all_along_the_wall(cells, south_exponent, north_exponent):
    first, last = 10**south_exponent, 10**north_exponent
    grid, _ = mc.transfinite(*WAVY, cells_j=cells, spacing_south=first, spacing_north=last)
    steps = np.linalg.norm(np.diff(grid.points[:, :, 0], axis=1), axis=-1)
    assert steps[0, 0] == pytest.approx(first, rel=1e-6) and steps[-1, 0] == pytest.approx(first, rel=1e-6)
    # Between the ends of the wall the height follows the patch's own height, which varies by a quarter.
    assert (steps[:, 0] < 1.3 * first).all() and (steps[:, 0] > 0.7 * first).all()
    assert (steps[:, -1] < 1.3 * last).all() and (steps[:, -1] > 0.7 * last).all()


def test_spacing_follows_its_side_when_the_patch_is_turned():
    mirror = np.array([-1.0, 1, 1])
    grid, _ = mc.transfinite(*(side * mirror for side in WAVY), cells_i=20, spacing_west=0.01)
    assert {v: k for k, v in grid.names.items()}["west"] == "imax"
    assert np.linalg.norm(grid.points[-1, 0, 0] - grid.points[-2, 0, 0]) == pytest.approx(0.01, rel=1e-3)


def test_linear_blending_of_a_wall_spacing_spills_over_and_arc_length_does_not():
    sides = [np.column_stack([x, 0.2 * np.sin(np.pi * x), 0 * x]) for x in [np.linspace(0, 1, 21)]]
    up = geometric(16, first=1e-4)
    west = np.column_stack([0 * up, up, 0 * up])
    sides += [west + [1, 0, 0], np.column_stack([sides[0][:, 0], np.ones(21), np.zeros(21)]), west]
    assert (naive.cross_areas(mc.transfinite(*sides).mesh.points[:, :, 0]) > 0).all()
    with pytest.raises(GenerationFailed, match="folded") as caught:
        mc.transfinite(*sides, blending="linear")
    partial = caught.value.partial
    bad = (naive.cross_areas(partial.points[:, :, 0]) <= 0).any(axis=-1)
    assert bad.any() and set(caught.value.cells) == set(np.flatnonzero(bad.ravel(order="F")))


def test_cells_are_resampled_without_losing_the_sides_own_spacing():
    south, east, north, west = WAVY
    grid, _ = mc.transfinite(south, east, north, west, cells_i=24, cells_j=14)
    assert grid.cell_shape == (24, 14, 1)
    assert (grid.points[[0, -1, -1, 0], [0, 0, -1, -1], 0] == [south[0], south[-1], north[-1], north[0]]).all()
    stretched = np.column_stack([np.linspace(0, 1, 12) ** 2, np.zeros(12), np.zeros(12)])
    finer, _ = mc.transfinite(stretched, [[1, 0], [1, 1]], stretched + [0, 1, 0], [[0, 0], [0, 1]], cells_i=33)
    steps = np.diff(arc_length(finer.points[:, 0, 0]))
    assert (np.diff(steps) > -1e-12).all() and steps[-1] > 5 * steps[0]


def test_a_patch_in_space():
    t = np.linspace(0, np.pi, 13)
    arch = np.column_stack([np.cos(t), 0 * t, np.sin(t)])
    y = np.linspace(0, 2, 5)
    rail = np.column_stack([0 * y, y, 0 * y])
    grid, _ = mc.transfinite(arch, rail + [-1, 0, 0], arch + [0, 2, 0], rail + [1, 0, 0])
    assert np.abs(np.hypot(grid.points[..., 0], grid.points[..., 2]) - 1).max() < 1e-12


def test_folds_are_found_in_a_tilted_plane_and_in_space():
    x, y = np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 9), indexing="ij")
    flat = np.stack([x, y, 0 * x], axis=-1)
    folded = flat.copy()
    folded[3:6, 4, 0] += 0.3
    expected = (naive.cross_areas(folded) <= 0).any(axis=-1)
    tilt = np.linalg.qr(np.random.default_rng(11).random((3, 3)))[0]
    assert not folded_cells(flat @ tilt).any()
    assert (folded_cells(folded) == expected).all() and expected.any()
    assert (folded_cells(folded @ tilt) == expected).all()
    sheet = flat + np.stack([0 * x, 0 * x, 0.2 * np.sin(3 * x) * y], axis=-1)
    assert not folded_cells(sheet).any()
    turned = sheet[np.r_[0:4, 6, 5, 4, 7, 8]]  # three rows in the wrong order: the sheet runs back on itself
    assert folded_cells(turned).all(axis=1).tolist() == [False] * 4 + [True] * 2 + [False] * 2
    assert folded_cells(turned).sum() == 16


def side(*points):
    return np.array(points, float)


UNIT = (side((0, 0), (1, 0)), side((1, 0), (1, 1)), side((0, 1), (1, 1)), side((0, 0), (0, 1)))


@pytest.mark.parametrize(
    ("sides", "keywords", "error", "words"),
    [
        ((UNIT[0], UNIT[1], UNIT[2]), {}, InvalidInput, "west: is missing"),
        ((UNIT[0],), {}, InvalidGeometry, "open"),
        ((*UNIT[:3], side((0, 0), (0, 0.5), (0, 1))), {}, InvalidInput, "cells_j"),
        ((*UNIT[:3], side((0, 0), (0, 0.9))), {}, InvalidGeometry, "west and north end 0.1 apart"),
        ((UNIT[0] + 5, *UNIT[1:]), {}, InvalidGeometry, "apart"),
        ((side((0, 0), (float("nan"), 0)), *UNIT[1:]), {}, InvalidGeometry, "finite"),
        ((side((0, 0), (0, 0)), *UNIT[1:]), {}, InvalidGeometry, "two different points"),
        ((side((0, 0)), *UNIT[1:]), {}, InvalidGeometry, "two different points"),
        ((np.empty((0, 3)), *UNIT[1:]), {}, InvalidGeometry, "two different points"),
        ((np.zeros((3, 4)), *UNIT[1:]), {}, InvalidInput, "shape"),
        (("south", *UNIT[1:]), {}, InvalidInput, "numbers"),
        (
            (side((0, 0), (0.5, 0), (0.5, 0), (1, 0)), *UNIT[1:]),
            {"cells_i": 3},
            InvalidGeometry,
            "coincide",
        ),
        (UNIT, {"cells_i": 0}, InvalidInput, "cells_i: must be at least 1"),
        (UNIT, {"cells_j": 4, "spacing_south": 3.0}, InvalidInput, "spacing_south: 3 does not fit"),
        (UNIT, {"cells_j": 4, "spacing_south": 0.6, "spacing_north": 0.5}, InvalidInput, "spacing_south"),
        (UNIT, {"cells_i": 4, "spacing_east": 1e-14}, InvalidInput, "spacing_east"),
        (UNIT, {"blending": "quintic"}, InvalidInput, "blending"),
        ((UNIT[0] * 1e200, *UNIT[1:]), {}, InvalidGeometry, "south: has an extent of 1e[+]200; scale it"),
        (tuple(s * 1e-200 for s in UNIT), {}, InvalidGeometry, "has an extent of 1e-200; scale it"),
        ((gallery.square(4),), {"corners": (0, 1, 2, 99)}, InvalidInput, "corners"),
        ((gallery.square(4),), {"corners": (0, 0, 4, 8)}, InvalidInput, "corners"),
        ((gallery.joined(gallery.square(), gallery.circle(8)),), {}, InvalidGeometry, "one closed loop or four chains"),
        (  # a bow tie: south and north cross
            (side((0, 0), (1, 1)), side((1, 1), (1, 0)), side((0, 1), (1, 0)), side((0, 0), (0, 1))),
            {"cells_i": 6, "cells_j": 6},
            InvalidGeometry,
            "south: crosses north near .0.5, 0.5, 0.; move the sides apart",
        ),
    ],
)
def test_bad_sides_get_a_clear_error(sides, keywords, error, words):
    with pytest.raises(error, match=words):
        mc.transfinite(*sides, **keywords)


def test_a_gap_within_tolerance_is_closed():
    west = side((1e-4, 0), (0, 0.9999))
    grid, _ = mc.transfinite(*UNIT[:3], west, tolerance=0.001)
    assert (grid.points[0, :, 0, :2] == [[0, 0], [0, 1]]).all()
    with pytest.raises(InvalidGeometry):
        mc.transfinite(*UNIT[:3], west)


def test_no_tolerance_asks_for_equal_ends():
    grid, _ = mc.transfinite(*UNIT, cells_i=3, cells_j=2, tolerance=0)
    assert grid.cell_shape == (3, 2, 1)
    with pytest.raises(InvalidGeometry, match="apart"):
        mc.transfinite(*UNIT[:3], side((0, 0), (0, 1 + 1e-15)), cells_i=3, cells_j=2, tolerance=0)


def test_overspill_of_an_l_shape_is_found():
    """The survey's figure 6: the re-entrant corner pulls the grid out of the domain."""
    with pytest.raises(GenerationFailed, match="folded") as caught:
        mc.transfinite(gallery.l_shape(8), corners=(0, 16, 32, 48))
    assert caught.value.cells and isinstance(caught.value.partial, mc.StructuredGrid)


def test_stops_when_told():
    with pytest.raises(Cancelled):
        mc.transfinite(*WAVY, progress=lambda fraction, message: False)


@pytest.mark.parametrize("cells", [(10**9, 1), (1, 10**9), (10**5, 10**4)])
def test_grids_too_large_for_the_memory(cells):
    with pytest.raises(InvalidInput, match=r"cells_[ij]: would make .* points; at most"):
        mc.transfinite(gallery.circle(40), cells_i=cells[0], cells_j=cells[1])


@pytest.mark.parametrize("keywords", [{"spacings": {"south": 3}}, {"spacings": []}, {"slopes": 3, "blending": "cubic"}])
def test_spacings_and_slopes_of_other_kinds_are_refused(keywords):
    with pytest.raises(InvalidInput, match=next(iter(keywords))):
        mc.transfinite(*WAVY, **keywords)


@pytest.mark.parametrize("order", [(0, 2, 1, 3), (0, 1, 3, 2), (1, 0, 2, 3)])
def test_sides_in_the_wrong_order_are_told_the_right_one(order):
    sides = gallery.wavy_sides(8, 6)
    with pytest.raises(InvalidGeometry, match="they meet in another order") as caught:
        mc.transfinite(*(sides[k] for k in order))
    right = re.search("give (.*) as south", str(caught.value))[1].split(", ")
    asked = dict(zip(("south", "east", "north", "west"), (sides[k] for k in order), strict=True))
    grid, _ = mc.transfinite(*(asked[name] for name in right))
    assert grid.n_cells == 48
