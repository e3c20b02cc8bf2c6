"""Polylines: order, length, resampling, corners."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshcore import InvalidGeometry, InvalidInput, Mesh, gallery
from meshcore.geometry import curves


@given(st.integers(3, 30), st.booleans(), st.randoms(use_true_random=False))
def test_a_shuffled_chain_is_put_in_order(n, closed, random):
    lines = [[k, k + 1] for k in range(n - 1)] + [[n - 1, 0]] * closed
    lines = [line[:: random.choice([1, -1])] for line in lines]
    random.shuffle(lines)
    points = np.random.default_rng(n).random((n, 3))
    (chain,) = curves.chains(Mesh(points, {"line": lines}))
    assert len(chain) == n + closed and (chain[0] == chain[-1]) == closed
    step = np.diff(chain) % n
    assert set(step.tolist()) in ({1}, {n - 1})


@given(st.lists(st.tuples(st.integers(0, 7), st.integers(0, 7)), min_size=1, max_size=20))
def test_chains_use_each_line_once_whatever_the_graph(lines):
    mesh = Mesh(np.random.default_rng(0).random((8, 3)), {"line": lines})
    used = [tuple(sorted(pair)) for chain in curves.chains(mesh) for pair in pairwise(chain)]
    assert sorted((int(a), int(b)) for a, b in used) == sorted(tuple(sorted(line)) for line in lines)


def test_chains_end_at_branches():
    star = Mesh([[0, 0], [1, 0], [0, 1], [-1, 0], [2, 0]], {"line": [[0, 1], [0, 2], [3, 0], [1, 4]]})
    assert sorted(len(chain) for chain in curves.chains(star)) == [2, 2, 3]


def test_a_polyline_is_one_piece():
    two = Mesh([[0, 0], [1, 0], [5, 0], [6, 0]], {"line": [[0, 1], [2, 3]]})
    with pytest.raises(InvalidGeometry, match="chain of line cells, got 2, of which 2 closed; give one alone"):
        curves.polyline(gallery.square_with_hole())
    with pytest.raises(InvalidGeometry, match="south: needs one chain of line cells, got 2; join its ends") as caught:
        curves.polyline(two, "south")
    assert caught.value.points == (0, 1, 2, 3)


@pytest.mark.parametrize("points", [[], [[1, 2]], [[1, 2], [1, 2]]])
def test_a_polyline_has_two_different_points(points):
    with pytest.raises(InvalidGeometry, match="two different points"):
        curves.polyline(points)


def test_arrays_are_taken_in_order():
    assert curves.polyline([[0, 0], [2, 1]]).tolist() == [[0, 0, 0], [2, 1, 0]]


@given(st.lists(st.tuples(st.floats(-5, 5), st.floats(-5, 5)), min_size=2, max_size=12), st.integers(1, 40))
def test_resampling_keeps_ends_and_stays_on_the_curve(points, n):
    points = np.column_stack([points, np.zeros(len(points))])
    if not np.ptp(points, axis=0).any():
        return
    new = curves.resampled(points, np.linspace(0, 1, n + 1))
    assert (new[0] == points[0]).all() and (new[-1] == points[-1]).all()
    a, d = points[:-1], np.diff(points, axis=0)
    for p in new:
        t = np.clip(((p - a) * d).sum(1) / np.maximum((d * d).sum(1), 1e-300), 0, 1)
        assert np.linalg.norm(a + t[:, None] * d - p, axis=1).min() < 1e-9
    assert curves.arc_length(new)[-1] <= curves.arc_length(points)[-1] * (1 + 1e-12)


@pytest.mark.parametrize("scale", [1e-300, 1e-170, 1.0, 1e170])
def test_length_of_tiny_and_huge_curves(scale):
    points = scale * np.array([[0.0, 0, 0], [3, 4, 0], [3, 4, 12]])
    assert curves.arc_length(points) / scale == pytest.approx([0, 5, 17], rel=1e-15)


def test_corners_of_a_rectangle_however_it_is_divided():
    loop = curves.polyline(gallery.square(7).transformed(np.diag([3.0, 1, 1, 1])))
    assert curves.sharpest_corners(loop).tolist() == [0, 7, 14, 21]


def test_a_smooth_loop_gets_corners_evenly():
    loop = curves.polyline(gallery.circle(400))
    assert np.diff(curves.sharpest_corners(loop)).tolist() == [100, 100, 100]


def test_the_sharpest_corner_wins_over_a_blunt_one_beside_it():
    angle = np.linspace(0, 2 * np.pi, 101)[:-1]
    points = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    points[50] *= 2  # a spike between two blunt neighbours
    assert 50 in curves.sharpest_corners(np.concatenate([points, points[:1]]))


@pytest.mark.parametrize("twice", range(8))
def test_duplicate_points_neither_make_nor_hide_a_corner(twice):
    square = curves.polyline(gallery.square(2))
    loop = np.insert(square, twice, square[twice], axis=0)
    assert [loop[k].tolist() for k in curves.sharpest_corners(loop)] == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]


def test_open_or_tiny_loops_have_no_four_corners():
    with pytest.raises(InvalidInput, match="closed loop"):
        curves.sharpest_corners(np.eye(3))
    with pytest.raises(InvalidInput, match="at least 4 points, got 3"):
        curves.sharpest_corners(np.concatenate([np.eye(3), np.eye(3)[:1]]))


@pytest.mark.parametrize("n", [8, 12, 24, 32, 36, 400])
def test_polygons_of_equal_sides_get_corners_evenly_whatever_rounding_says(n):
    for angle in np.random.default_rng(n).random(5):
        turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
        ring = gallery.circle(n).points @ turn.T
        found = curves.sharpest_corners(np.concatenate([ring, ring[:1]]))
        assert np.diff(found, append=found[0] + n).tolist() == [n // 4] * 4


@pytest.mark.parametrize("per_corner", [2, 3, 5, 12])
def test_a_rounded_corner_counts_as_one(per_corner):
    angle = np.linspace(0, np.pi / 2, per_corner)
    arcs = [
        0.2 * np.column_stack([np.cos(angle + turn), np.sin(angle + turn), 0 * angle]) + middle
        for turn, middle in zip(
            np.arange(4) * np.pi / 2, [(0.8, 1.8, 0), (-0.8, 1.8, 0), (-0.8, -1.8, 0), (0.8, -1.8, 0)], strict=True
        )
    ]
    ring = np.concatenate(arcs)
    found = curves.sharpest_corners(np.concatenate([ring, ring[:1]]))
    assert (found // per_corner).tolist() == [0, 1, 2, 3]
    if per_corner % 2:
        assert (found % per_corner).tolist() == [per_corner // 2] * 4  # its middle


def test_corners_that_point_inwards_do_not_count():
    ring = np.array([[0, 0, 0], [4, 0, 0], [4, 1, 0], [1, 1, 0], [0.5, 3, 0], [0, 3, 0]], float)  # 3 points inwards
    for way in (1, -1):
        loop = np.concatenate([ring, ring[:1]])[::way]
        corners = loop[curves.sharpest_corners(loop)]
        assert [1, 1, 0] not in corners.tolist()
