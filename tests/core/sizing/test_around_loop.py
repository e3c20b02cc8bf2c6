"""Turning, corners and new spacing of closed loops."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshcore import gallery
from meshcore.errors import InvalidInput
from meshcore.geometry.curves import corners, polyline, turning
from meshcore.sizing.around_loop import _shared_out, accumulated, respaced_loop, smoothed_turning

SECTIONS = {name: polyline(gallery.airfoil(name))[:-1, :2] for name in gallery.airfoils()}


def area(loop):
    x, y = loop.T
    return 0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum()


@pytest.mark.parametrize("loop", SECTIONS.values(), ids=SECTIONS)
def test_the_whole_turning_is_one_round(loop):
    assert turning(loop).sum() == pytest.approx(2 * np.pi, abs=1e-12)
    assert turning(loop[::-1]).sum() == pytest.approx(-2 * np.pi, abs=1e-12)


@pytest.mark.parametrize(("name", "count"), [("rae2822", 1), ("s1223", 1), ("naca0012", 2)])
def test_corners_of_airfoils_are_those_of_the_trailing_edge(name, count):
    loop = SECTIONS[name]
    found = loop[corners(turning(loop))]
    assert len(found) == count and (found[:, 0] > 0.999).all()


def test_a_coarse_round_has_no_corners_and_a_polygon_has_them_all():
    round_ = gallery.circle(9).points[:, :2]
    assert not corners(turning(round_)).any()
    square = gallery.square(5).points[:, :2]
    assert np.flatnonzero(corners(turning(square))).tolist() == [0, 5, 10, 15]
    assert corners(turning(gallery.l_shape(4).points[:, :2])).sum() == 6


@given(st.integers(0, 10**6), st.floats(0.002, 0.2))
def test_smoothing_keeps_the_sum_and_spreads_as_a_gaussian(seed, width):
    rng = np.random.default_rng(seed)
    at, weight = np.sort(rng.random(12)), rng.normal(size=12)
    assert smoothed_turning(at, weight, width).sum() == pytest.approx(weight.sum(), abs=1e-9)
    one = smoothed_turning(np.array([0.5]), np.array([1.0]), min(width, 0.05))
    place = np.arange(4096) / 4096 - 0.5
    assert np.sqrt((one * place**2).sum()) == pytest.approx(min(width, 0.05), rel=1e-3)


def test_accumulated_counts_on_around_the_loop():
    density = 1 + np.sin(2 * np.pi * np.arange(4096) / 4096)
    at = np.linspace(-1.5, 2.5, 41)
    exact = at - (np.cos(2 * np.pi * at) - 1) / (2 * np.pi)
    assert np.abs(accumulated(density, at) - exact).max() < 1e-6


@pytest.mark.parametrize("loop", SECTIONS.values(), ids=SECTIONS)
@pytest.mark.parametrize("cells", [40, 131, 400])
def test_respaced_airfoils_keep_corners_shape_and_smoothness(loop, cells):
    new = respaced_loop(loop, cells)
    assert new.shape == (cells, 2) and (new[0] == loop[0]).all()
    kept = loop[corners(turning(loop))]
    assert {tuple(p) for p in kept} <= {tuple(p) for p in new}
    if cells >= 131:
        assert area(new) == pytest.approx(area(loop), rel=5e-3)
        # No old point is farther from the new loop than the sag of the old one's own lines.
        nearest = np.min(np.linalg.norm(new[:, None] - loop[None], axis=-1), axis=1)
        step = np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1).max()
        assert nearest.max() < 0.6 * step
    steps = np.linalg.norm(np.roll(new, -1, axis=0) - new, axis=1)
    turn = np.abs(turning(new))
    round_ = ~corners(turning(new))
    assert np.degrees(turn[round_]).max() < 60 * 40 / cells + 10
    if cells == 400 and len(kept) == 1:
        ratio = steps[1:] / steps[:-1]
        assert max(ratio.max(), 1 / ratio.min()) < 1.35


@given(st.integers(4, 90))
def test_a_square_keeps_its_corners_and_straight_sides(cells):
    square = gallery.square(3).points[:, :2]
    new = respaced_loop(square, cells)
    assert len(new) == cells
    assert {(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)} <= {tuple(p) for p in new.round(12)}
    assert area(new) == pytest.approx(1, abs=1e-12)
    steps = np.linalg.norm(np.roll(new, -1, axis=0) - new, axis=1)
    assert steps.min() > 0


def test_a_round_loop_lies_on_its_circle():
    new = respaced_loop(gallery.circle(24).points[:, :2], 100)
    assert np.abs(np.hypot(*new.T) - 1).max() < 1e-4


def test_too_few_cells():
    with pytest.raises(InvalidInput, match="4 corners"):
        respaced_loop(gallery.square(2).points[:, :2], 3)


@pytest.mark.parametrize("name", gallery.airfoils())
def test_cells_have_the_sizes_asked_at_the_edges_and_grow_from_there(name):
    loop = SECTIONS[name]
    nose = int(np.argmax(np.linalg.norm(loop - loop[0], axis=1)))
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1))])
    new = respaced_loop(loop, 240, sizes=[(0.0, 0.001), (length[nose] / length[-1], 0.002)])
    steps = np.linalg.norm(np.roll(new, -1, axis=0) - new, axis=1)
    at_nose = int(np.argmin(np.linalg.norm(new - loop[nose], axis=1)))
    beside = steps[[0, -1]]  # the other side may be a blunt base
    assert beside[np.argmin(np.abs(beside - 0.001))] == pytest.approx(0.001, rel=0.005)
    assert steps[[at_nose - 1, at_nose]].mean() == pytest.approx(0.002, rel=0.01)
    ratio = steps[1:60] / steps[:59]
    assert ratio.max() < 1.35 and len(new) == 240


def test_too_few_cells_for_the_sizes():
    with pytest.raises(InvalidInput, match=r"around: 40 cells are too few for the spacing at the edges; give \d+"):
        respaced_loop(SECTIONS["rae2822"], 40, sizes=[(0.0, 1e-6)])


@given(st.lists(st.floats(1e-6, 1), min_size=1, max_size=7), st.integers(0, 300))
def test_stretches_share_cells_in_equal_proportions(weights, more):
    """No cell that changes its stretch brings the two stretches' weights a cell closer (Huntington's test)."""
    weights = np.array(weights)
    counts = _shared_out(len(weights) + more, weights)
    assert counts.sum() == len(weights) + more and counts.min() >= 1

    def factor(a, b, of_a, of_b):
        return max(a / of_a, b / of_b) / min(a / of_a, b / of_b)

    for give, take in itertools.permutations(range(len(weights)), 2):
        if counts[give] > 1:
            now = factor(weights[give], weights[take], counts[give], counts[take])
            then = factor(weights[give], weights[take], counts[give] - 1, counts[take] + 1)
            assert now <= then * (1 + 1e-9)


@pytest.mark.parametrize("cells", [150, 200, 250, 300, 400, 600])
def test_cells_of_a_blunt_edge_are_like_their_neighbours(cells):
    """Lines that leave its corners along the bisector are the more skew the more the cells beside it differ."""
    new = respaced_loop(SECTIONS["naca0012"], cells)
    steps = np.linalg.norm(np.roll(new, -1, axis=0) - new, axis=1)
    edge = np.flatnonzero(corners(turning(new)))
    assert len(edge) == 2
    for corner in edge:
        assert 1 / 1.45 < steps[corner] / steps[corner - 1] < 1.45


def growth_between_corners(loop, new):
    """The largest ratio of neighbouring cells that do not meet at a corner of the loop."""
    kept = {tuple(p) for p in loop[np.append(np.flatnonzero(corners(turning(loop))), 0)]}
    steps = np.linalg.norm(np.roll(new, -1, axis=0) - new, axis=1)
    ratio = steps / np.roll(steps, 1)
    return max(max(r, 1 / r) for p, r in zip(new, ratio, strict=True) if tuple(p) not in kept)


@pytest.mark.parametrize("growth", [1.1, 1.2, 1.3])
@pytest.mark.parametrize("cells", [100, 200, 400])
@pytest.mark.parametrize("loop", SECTIONS.values(), ids=SECTIONS)
def test_cells_grow_by_no_more_than_asked(loop, cells, growth):
    coarse = loop[::5]  # whose points turn by 30 degrees and more, as sections in old files do
    for points in (loop, coarse):
        found = growth_between_corners(points, respaced_loop(points, cells, growth=growth))
        assert found < 1 + 1.2 * (growth - 1)  # was 1.4, and 2 to 7 on coarse points; the rest is rounding of counts


def test_cells_are_no_longer_between_points_where_the_spline_bends_much():
    thin = np.array([[1, 0], [0.5, 0.05], [0.1, 0.04], [0, 0.01], [0.01, -0.01], [0.1, -0.03], [0.5, -0.03]], float)
    assert growth_between_corners(thin, respaced_loop(thin, 150)) < 1.25


def test_a_coarse_round_bends_along_its_edges():
    turn = np.degrees(np.abs(turning(respaced_loop(gallery.circle(12).points[:, :2], 60))))
    assert np.ptp(turn) < 1.5 and turn.mean() == pytest.approx(6)


def test_tiny_cells_where_the_loop_begins_need_no_more_cells_than_they_grow_by():
    loop = SECTIONS["rae2822"]
    new = respaced_loop(loop, 260, sizes=[(0.0, 1e-8)])  # was refused: both ends of the loop are one place
    steps = np.linalg.norm(np.roll(new, -1, axis=0) - new, axis=1)
    assert steps[[0, -1]] == pytest.approx(1e-8, rel=0.02)
    assert growth_between_corners(loop, new) < 1.24
