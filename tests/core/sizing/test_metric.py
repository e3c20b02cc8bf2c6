"""Metrics: spacings and directions in and out, means, intersections, lengths."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.linalg import expm, logm

from meshcore import InvalidInput
from meshcore.gallery import triangulated_square
from meshcore.sizing.metric import interpolated, intersection, lengths, metric, metric_field, smallest_sizes, spacings


def random_metrics(seed, n=6, decades=(-3, 2)):
    rng = np.random.default_rng(seed)
    turns = np.linalg.qr(rng.normal(size=(n, 3, 3)))[0]
    sizes = 10 ** rng.uniform(*decades, (n, 3))
    return np.einsum("nxk,nk,nyk->nxy", turns, 1 / sizes**2, turns), np.sort(sizes, axis=1)


@given(st.integers(0, 10_000))
def test_spacings_are_those_that_the_metric_was_made_of(seed):
    rng = np.random.default_rng(seed)
    turns = np.linalg.qr(rng.normal(size=(5, 3, 3)))[0]
    size, stretching = 10 ** rng.uniform(-3, 1, 5), 10 ** rng.uniform(-2, 2, (5, 2))
    m = metric(size, stretching, turns[:, :2] * 7.0)
    assert np.allclose(np.sqrt(np.einsum("nx,nxy,ny->n", turns[:, 2], m, turns[:, 2])) * size, 1)
    for k in range(2):
        along = turns[:, k] * (stretching[:, k] * size)[:, None]
        assert np.allclose(lengths(np.zeros((5, 3)), along, m, m), 1)
    expected = np.sort(np.column_stack([size, stretching * size[:, None]]), axis=1)
    assert np.allclose(spacings(m)[0], expected)
    assert np.allclose(smallest_sizes(m), expected[:, 0])


@settings(max_examples=25)
@given(st.integers(0, 10_000), st.floats(0, 1))
def test_the_mean_is_that_of_logarithms(seed, share):
    m, _ = random_metrics(seed, 2, (-0.7, 0.7))
    mean = interpolated(m[None], np.array([[share, 1 - share]]))[0]
    exact = expm(share * logm(m[0]) + (1 - share) * logm(m[1]))
    assert np.allclose(mean, exact.real, rtol=1e-6, atol=1e-9 * np.abs(exact).max())


@given(st.integers(0, 10_000))
def test_the_intersection_asks_for_no_more_than_both(seed):
    first, _ = random_metrics(seed)
    second, _ = random_metrics(seed + 1)
    both = intersection(first, second)
    directions = np.random.default_rng(seed).normal(size=(6, 50, 3))
    measured = [np.einsum("nkx,nxy,nky->nk", directions, m, directions) for m in (first, second, both)]
    assert (measured[2] >= np.maximum(measured[0], measured[1]) * (1 - 1e-6)).all()
    assert np.allclose(intersection(first, first), first, rtol=1e-6, atol=1e-9 * np.abs(first).max())
    fine = first * 1e8
    assert np.allclose(intersection(first, fine), fine, rtol=1e-5, atol=1e-8 * np.abs(fine).max())


@given(st.floats(-3, 3), st.floats(-3, 3))
def test_lengths_integrate_geometric_sizes(low, high):
    a, b = 10**low, 10**high
    length = lengths(np.zeros((1, 3)), np.array([[2.0, 0, 0]]), metric(a), metric(b))[0]
    exact = quad(lambda t: 2 / (a ** (1 - t) * b**t), 0, 1, epsrel=1e-12)[0]
    assert length == pytest.approx(exact, rel=1e-8)


def test_a_field_keeps_metrics_at_points_and_positive_between():
    square = triangulated_square(4)
    m, _ = random_metrics(3, square.n_points)
    square = square.with_point_data(metric=m.reshape(-1, 9), h=np.full(square.n_points, 0.5))
    field = metric_field(square, "metric")
    assert np.allclose(field(square.points), m, rtol=1e-6, atol=1e-9 * np.abs(m).max())
    assert (np.linalg.eigvalsh(field(np.random.default_rng(0).uniform(-1, 2, (99, 3)) * [1, 1, 0])) > 0).all()
    assert np.allclose(metric_field(square, "h")(square.points), 4 * np.eye(3))


@pytest.mark.parametrize(
    "call, message",
    [
        (lambda: metric(0.0), "size: must be between"),
        (lambda: metric([1, np.nan]), "size: must be between 1e-100 and 1e"),
        (lambda: metric(1.0, -2.0, [1, 0, 0]), "stretching: must be between"),
        (lambda: metric(1.0, 2.0), "direction: a stretching needs"),
        (lambda: metric(1.0, 2.0, [0, 0, 0]), "longer than zero"),
        (lambda: metric(1.0, [[2.0, 3.0]], [[[1, 0, 0], [1, 1, 0]]]), "right angles"),
        (lambda: metric(1.0, [[2.0, 3.0]], [1, 0, 0]), r"needs shape \(n, 2, 3\)"),
        (lambda: spacings(np.zeros((1, 3, 3))), "not positive definite"),
        (lambda: spacings(np.array([[[1, 2, 0], [0, 1, 0], [0, 0, 1.0]]])), "not finite and symmetric"),
        (lambda: spacings(np.eye(2)[None]), r"needs shape \(n, 3, 3\)"),
        (lambda: metric_field(triangulated_square(), "m"), "no point array 'm'"),
    ],
)
def test_what_is_no_metric_is_refused(call, message):
    with pytest.raises(InvalidInput, match=message):
        call()
