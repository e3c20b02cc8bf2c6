"""Spacings along a line: the demanded cells, monotone, and the laws that define them."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from meshcore.errors import InvalidInput
from meshcore.sizing import cells_for_growth, cosine, geometric, hyperbolic_tangent, uniform
from tests import naive

counts = st.integers(3, 200)
ends = st.floats(-9, math.log10(0.45)).map(lambda e: 10**e)


def assert_spacing(fractions, cells):
    assert fractions.shape == (cells + 1,)
    assert fractions[0] == 0 and fractions[-1] == 1
    assert (np.diff(fractions) > 0).all()


@given(counts, ends, ends)
def test_two_sided_has_both_end_cells_and_is_monotone(cells, first, last):
    s = hyperbolic_tangent(cells, first=first, last=last)
    assert_spacing(s, cells)
    assert s[1] == pytest.approx(first, rel=1e-10)
    assert 1 - s[-2] == pytest.approx(last, abs=1e-10)


@given(counts, ends, ends)
def test_two_sided_read_from_the_other_end_is_the_same_spacing(cells, first, last):
    s = hyperbolic_tangent(cells, first=first, last=last)
    mirrored = 1 - hyperbolic_tangent(cells, first=last, last=first)[::-1]
    assert np.abs(s - mirrored).max() < 1e-10


@given(
    st.integers(4, 60), st.floats(-3, math.log10(0.4)).map(lambda e: 10**e), st.floats(-3, -0.4).map(lambda e: 10**e)
)
def test_two_sided_equals_the_textbook_formula(cells, first, last):
    assert np.abs(hyperbolic_tangent(cells, first=first, last=last) - naive.vinokur(cells, first, last)).max() < 1e-7


@given(st.integers(3, 60), st.floats(1e-3, 0.9))
def test_one_sided_equals_the_textbook_formula(cells, first):
    assume(first < 0.99 / cells)
    assert np.abs(hyperbolic_tangent(cells, first=first) - naive.one_sided_tanh(cells, first)).max() < 1e-7


@given(counts, st.floats(-11, math.log10(0.97)).map(lambda e: 10**e))
def test_one_sided_is_monotone_both_ways(cells, first):
    s = hyperbolic_tangent(cells, first=first)
    assert_spacing(s, cells)
    assert s[1] == pytest.approx(first, rel=1e-10)
    steps = np.diff(s)
    growing = first * cells < 1
    assert (np.diff(steps) >= -1e-12).all() if growing else (np.diff(steps) <= 1e-12).all()
    assert np.abs(1 - hyperbolic_tangent(cells, last=first)[::-1] - s).max() < 1e-14


@given(counts, st.floats(-9, math.log10(0.9)).map(lambda e: 10**e))
def test_geometric_by_first_cell_grows_by_one_ratio(cells, first):
    try:
        s = geometric(cells, first=first)
    except InvalidInput:  # shrinking below what double precision resolves
        assert first * cells > 1
        return
    assert_spacing(s, cells)
    assert s[1] == pytest.approx(first, rel=1e-10)
    steps = np.diff(s)
    big = steps[1:] > 1e-5
    ratios = (steps[1:] / steps[:-1])[big & (steps[:-1] > 1e-5)]
    assert np.ptp(ratios) < 1e-9 if len(ratios) else True


@given(st.integers(1, 100), st.floats(0.8, 1.25))
def test_geometric_by_ratio(cells, ratio):
    s = geometric(cells, ratio=ratio)
    assert_spacing(s, cells)
    exact = np.cumsum([0.0] + [ratio**k for k in range(cells)])
    assert np.abs(s - exact / exact[-1]).max() < 1e-12
    assert np.abs(geometric(cells, first=s[1]) - s).max() < 1e-9


@given(ends, st.floats(1.01, 3))
def test_cells_for_growth_is_the_least_number(first, ratio):
    cells = cells_for_growth(first, ratio)
    total = sum(first * ratio**k for k in range(cells))
    assert total >= 1 - 1e-6
    assert sum(first * ratio**k for k in range(cells - 1)) < 1
    assert np.diff(geometric(cells, first=first))[:2][::-1] @ [1, -ratio] < 1e-9


@given(st.integers(1, 300))
def test_cosine_and_uniform(cells):
    for ends_ in ("both", "first", "last"):
        assert_spacing(cosine(cells, ends=ends_), cells)
    assert np.abs(cosine(cells) + cosine(cells)[::-1] - 1).max() < 1e-15
    assert np.abs(cosine(cells, ends="first") + cosine(cells, ends="last")[::-1] - 1).max() < 1e-15
    assert_spacing(uniform(cells), cells)
    assert np.ptp(np.diff(uniform(cells))) < 1e-15


def test_equal_cells_come_from_every_family():
    for n in (1, 2, 7):
        for s in (
            geometric(n, ratio=1),
            geometric(n, first=1 / n),
            hyperbolic_tangent(n),
            hyperbolic_tangent(n, first=1 / n),
            hyperbolic_tangent(n, first=1 / n, last=1 / n),
        ):
            assert np.abs(s - uniform(n)).max() < 1e-14


@pytest.mark.parametrize(
    ("call", "parameter"),
    [
        (lambda: uniform(0), "cells"),
        (lambda: uniform(2.5), "cells"),
        (lambda: uniform(float("nan")), "cells"),
        (lambda: cosine(4, ends="middle"), "ends"),
        (lambda: geometric(4), "ratio"),
        (lambda: geometric(4, ratio=1.1, first=0.1), "ratio"),
        (lambda: geometric(4, ratio=-1), "ratio"),
        (lambda: geometric(4, ratio=float("nan")), "ratio"),
        (lambda: geometric(400, ratio=10), "ratio"),
        (lambda: geometric(4, first=1.0), "first"),
        (lambda: geometric(4, first=0.0), "first"),
        (lambda: geometric(1, first=0.5), "first"),
        (lambda: geometric(100, first=0.9), "first"),
        (lambda: hyperbolic_tangent(4, first=0.6, last=0.5), "first"),
        (lambda: hyperbolic_tangent(2, first=0.3, last=0.3), "first"),
        (lambda: hyperbolic_tangent(4, first=float("inf")), "first"),
        (lambda: hyperbolic_tangent(4, first=0.1, last=-0.1), "last"),
        (lambda: hyperbolic_tangent(4, last=1e-20), "last"),
        (lambda: cells_for_growth(0.1, 1.0), "ratio"),
        (lambda: cells_for_growth(2.0, 1.1), "first"),
    ],
)
def test_impossible_demands_name_the_parameter(call, parameter):
    with pytest.raises(InvalidInput) as caught:
        call()
    assert caught.value.parameter == parameter
