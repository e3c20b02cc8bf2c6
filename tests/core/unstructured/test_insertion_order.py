"""The order of insertion: a Hilbert curve, equal points merged, rounds that grow."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from meshcore.progress import Cancelled
from meshcore.unstructured import _insertion_order_kernels as kernels
from meshcore.unstructured.insertion_order import insertion_order
from tests import naive


def grid(cells, dimension):
    return np.stack(np.meshgrid(*[np.arange(float(cells))] * dimension, indexing="ij"), -1).reshape(-1, dimension)


@pytest.mark.parametrize("dimension, levels", [(2, 6), (3, 4)])
def test_the_curve_steps_from_cell_to_neighbour_and_fills_each_block_before_it_leaves(dimension, levels):
    cells = grid(2**levels, dimension)
    shuffled = cells[np.random.default_rng(1).permutation(len(cells))]
    visited = insertion_order(shuffled, dimension, rounds=False).coordinates.reshape(-1, dimension)
    assert (np.abs(np.diff(visited, axis=0)).sum(axis=1) == 1).all()
    for level in range(1, levels):
        block = [tuple(b) for b in (visited // 2**level).tolist()]
        assert len(list(itertools.groupby(block))) == len(set(block))


@settings(max_examples=100)
@given(
    st.sampled_from([2, 3]).flatmap(
        lambda d: arrays(
            np.float64, st.tuples(st.integers(0, 60), st.just(d)), elements=st.sampled_from([0.0, 1, -0.0, 2])
        )
    ),
    st.booleans(),
)
def test_equal_points_are_merged_into_the_lowest_row(points, rounds):
    found = insertion_order(points, points.shape[1], rounds=rounds)
    expected = naive.first_of_equal(points)
    assert sorted(found.rows.tolist()) == sorted(set(expected))
    assert dict(zip(found.merged.tolist(), found.kept.tolist(), strict=True)) == {
        row: first for row, first in enumerate(expected) if row != first
    }
    assert (found.merged[1:] > found.merged[:-1]).all()
    assert (found.coordinates.reshape(-1, points.shape[1]) == points[found.rows]).all()


@pytest.mark.parametrize("dimension", [2, 3])
def test_clumps_get_keys_of_their_own(dimension):
    rng = np.random.default_rng(2)
    centres = rng.random((20, 1, dimension))
    points = (centres + 1e-13 * rng.random((20, 3000, dimension))).reshape(-1, dimension)
    found = insertion_order(points, dimension, rounds=False)
    assert sorted([*found.rows.tolist(), *found.merged.tolist()]) == list(range(len(points)))
    clump = found.rows // 3000
    assert (np.diff(clump) != 0).sum() == 19
    steps = np.linalg.norm(np.diff(found.coordinates.reshape(-1, dimension), axis=0), axis=1)
    # Without keys of their own the mean step would be about half the clump.
    assert np.mean(steps[np.diff(clump) == 0]) < 1e-13 / 5


def test_points_that_halve_their_distance_again_and_again():
    distance = np.repeat(np.ldexp(1.0, -np.arange(200)), 30)
    points = np.column_stack([distance, distance * np.tile(np.arange(30) / 30, 200)])
    found = insertion_order(points, 2, rounds=False)
    assert sorted([*found.rows.tolist(), *found.merged.tolist()]) == list(range(len(points)))


def test_many_equal_points_take_linear_time():
    points = np.zeros((200_000, 2))
    points[150_000:] = 1.0
    found = insertion_order(points, 2, rounds=False)
    assert found.rows.tolist() == [0, 150_000]
    assert len(found.merged) == 199_998


def test_rounds_grow_and_follow_the_curve_and_the_hash():
    points = np.random.default_rng(3).random((20_000, 2))
    along = insertion_order(points, 2, rounds=False).rows
    dealt = insertion_order(points, 2, rounds=True).rows
    numbers = np.array([naive.insertion_round(row, 5) for row in range(len(points))])
    expected = np.concatenate([along[numbers[along] == k] for k in range(6)])
    assert dealt.tolist() == expected.tolist()
    assert (np.diff(np.bincount(numbers)) > -1000).all() and (numbers == 5).mean() == pytest.approx(0.5, abs=0.02)


def test_long_keys_agree_with_short_ones_in_the_large():
    points = np.random.default_rng(4).random((5000, 3))
    packed = np.arange(len(points), dtype=np.uint64)
    table = np.empty(kernels.TABLE_SIZE, np.int32)
    kernels.fill_curve_table(3, table)
    box = np.zeros(4)
    kernels.set_box(points, 3, packed, 0, len(points), box)
    kernels.set_keys(points, 3, box, table, 30, packed, 0, len(points))
    keys = packed >> np.uint64(32)
    assert keys.max() < 2**30
    other, counts = np.empty_like(packed), np.empty(kernels.COUNTERS, np.int64)
    kernels.sort_by_key(packed, other, 30, counts, 0, len(points))
    assert (packed >> np.uint64(32)).tolist() == np.sort(keys).tolist()
    steps = np.linalg.norm(np.diff(points[packed & np.uint64(2**32 - 1)], axis=0), axis=1)
    assert steps.mean() < 2 * 5000 ** (-1 / 3)


def test_cancelling_stops_the_sort():
    with pytest.raises(Cancelled):
        insertion_order(np.random.default_rng(5).random((100, 2)), 2, rounds=True, progress=lambda f, m: False)


@pytest.mark.parametrize("slope", [0.3, -0.3, 40.0, -1e9])
def test_a_line_is_fitted_by_plain_doubles_bit_by_bit(slope):
    """No library's sums and no fused products, which differ between platforms; and a steep line is no worse."""
    x = np.random.default_rng(6).normal(size=3000)
    points = np.column_stack([x, slope * x + 0.1])
    line = np.empty(5)
    kernels.fit_line(points, 1, line)
    assert line.tolist() == naive.fitted_line(points)
    assert line[4] / line[3] == pytest.approx(slope, rel=1e-12)
    assert np.hypot(line[3], line[4]) == pytest.approx(1.0, rel=1e-14)
