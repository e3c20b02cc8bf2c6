"""Laws of spacing beyond the hyperbolic tangent, and `Spacing`, the value that holds them."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshcore import Relative, gallery
from meshcore.errors import InvalidGeometry, InvalidInput
from meshcore.geometry.curves import arc_length, resampled
from meshcore.sizing import Spacing, by_curvature, copied, geometric, hyperbolic_sine, poisson, uniform
from meshcore.sizing.law import LAWS, WITH_ENDS

LINE = np.array([[0.0, 0, 0], [2, 0, 0]])
counts = st.integers(3, 200)
ends = st.floats(-9, math.log10(0.45)).map(lambda e: 10**e)


def assert_spacing(fractions, cells):
    assert fractions.shape == (cells + 1,)
    assert fractions[0] == 0 and fractions[-1] == 1
    assert (np.diff(fractions) > 0).all()


@given(st.integers(2, 200), st.floats(-9, 0).map(lambda e: 10**e))
def test_one_sided_sine_is_vinokurs(cells, share):
    first = share * 0.999 / cells
    s = hyperbolic_sine(cells, first=first)
    assert_spacing(s, cells)
    # sinh(d t) / sinh(d) obeys s(t + h) + s(t - h) = 2 cosh(d h) s(t).
    ratio = (s[2:] + s[:-2]) / s[1:-1]
    assert np.ptp(ratio) < 1e-6 * ratio.max()
    assert s[1] == first
    assert np.abs(1 - hyperbolic_sine(cells, last=first)[::-1] - s).max() < 1e-14


@given(st.integers(4, 200), st.floats(0.3, 3), st.floats(0.3, 3))
def test_two_sided_sine_has_both_ends_and_a_cosine_for_its_slope(cells, first, last):
    first, last = first / cells, last / cells
    try:
        s = hyperbolic_sine(cells, first=first, last=last)
    except InvalidInput as error:
        assert error.parameter == "first"
        return
    assert_spacing(s, cells)
    assert s[1] == first and 1 - s[-2] == pytest.approx(last, rel=1e-12)
    h = np.diff(s)
    # The cells, too, obey h(t + 1) + h(t - 1) = 2 cosh(d / n) h(t), or with cos: one number for all.
    ratio = (h[2:] + h[:-2]) / h[1:-1]
    assert np.ptp(ratio) < 1e-6 * ratio.max()


@given(counts, ends, ends)
def test_two_sided_poisson_has_both_ends_and_a_linear_log_growth(cells, first, last):
    try:
        s = poisson(cells, first=first, last=last)
    except InvalidInput as error:  # cells between the ends below what double precision resolves
        assert "below" in str(error) and (first + last) * cells > 2
        return
    assert_spacing(s, cells)
    assert s[1] == first and 1 - s[-2] == pytest.approx(last, abs=1e-15)
    if min(first, last) > 1e-4 and np.diff(s).min() > 1e-4:
        assert np.abs(np.diff(np.log(np.diff(s)), n=3)).max(initial=0) < 1e-6


@given(st.integers(2, 60), st.integers(0, 10**6))
def test_poisson_solves_its_difference_equation(cells, seed):
    control = np.random.default_rng(seed).uniform(-0.5, 0.5, cells - 1)
    s = poisson(cells, control=control)
    assert_spacing(s, cells)
    residual = s[2:] - 2 * s[1:-1] + s[:-2] + control * (s[2:] - s[:-2]) / 2
    assert np.abs(residual).max() < 1e-14


def test_poisson_converges_to_the_differential_equation():
    """With constant p on [0, 1] the solution is (1 - exp(-p t)) / (1 - exp(-p)); the order is the second."""
    p, errors = 3.0, []
    for cells in (20, 40, 80):
        t = np.arange(cells + 1) / cells
        exact = np.expm1(-p * t) / np.expm1(-p)
        errors.append(np.abs(poisson(cells, control=np.full(cells - 1, p / cells)) - exact).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.05)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2, abs=0.05)


@given(st.integers(2, 100), st.floats(0.8, 1.25))
def test_geometric_by_its_last_cell(cells, ratio):
    s = geometric(cells, ratio=ratio)
    assert np.abs(geometric(cells, last=s[1]) - (1 - s[::-1])).max() < 1e-9
    assert np.abs(poisson(cells, first=s[1]) - s).max() < 1e-9


def test_curvature_draws_points_to_bends_and_leaves_circles_even():
    t = np.linspace(0, np.pi, 400)
    arc = np.column_stack([np.cos(t), np.sin(t)])
    steps = np.diff(by_curvature(20, arc))
    assert np.ptp(steps) < 0.02 * steps.mean()
    x = np.linspace(-3, 3, 2001)
    bump = np.column_stack([x, np.exp(-((x / 0.2) ** 2))])
    s = by_curvature(60, bump, bend=0.7)
    assert_spacing(s, 60)
    new = resampled(np.column_stack([bump, 0 * x]), s)
    even = resampled(np.column_stack([bump, 0 * x]), uniform(60))

    def deviation(points):
        return np.abs(np.interp(x, points[:, 0], points[:, 1]) - bump[:, 1]).max()

    assert deviation(new) < 0.5 * deviation(even)
    assert np.abs(1 - s[::-1] - s).max() < 1e-6


def test_more_bend_means_smaller_cells_there():
    corner = np.array([[0.0, 0], [1, 0], [1, 1]])
    least = [np.diff(by_curvature(30, corner, bend=bend)).min() for bend in (0, 0.3, 0.6, 0.9)]
    assert least == sorted(least, reverse=True) and least[0] == pytest.approx(1 / 30)
    assert np.abs(by_curvature(7, LINE) - uniform(7)).max() == 0


@given(st.integers(2, 40), st.integers(1, 80))
def test_a_copied_spacing_is_the_curves_own(points, cells):
    s = geometric(points, ratio=1.1)
    curve = resampled(LINE, s)
    assert np.abs(copied(points, curve) - s).max() < 1e-14
    assert_spacing(copied(cells, curve), cells)
    steps = np.diff(copied(cells, curve))
    assert (np.diff(steps) > -1e-9).all()  # still growing


@pytest.mark.parametrize("law", LAWS)
def test_every_law_gives_fractions_on_any_curve(law):
    source = resampled(LINE, geometric(5, ratio=1.3)) if law == "copied" else None
    for curve in (LINE, gallery.wavy_sides()[0], gallery.wavy_sides()[1][:, :2]):
        assert_spacing(Spacing(law, source=source).fractions(11, curve), 11)


@pytest.mark.parametrize("law", WITH_ENDS)
def test_lengths_are_absolute_or_relative(law):
    curve = gallery.wavy_sides()[0]
    length = arc_length(curve)[-1]
    assert Spacing(law, first=0.1).fractions(12, curve)[1] == pytest.approx(0.1 / length)
    assert 1 - Spacing(law, last=Relative(0.05)).fractions(12, curve)[-2] == pytest.approx(0.1 / length, rel=0.02)
    s = Spacing(law, last=Relative(0.05)).fractions(12, curve, diagonal=4.0)
    assert 1 - s[-2] == pytest.approx(0.2 / length)
    if law != "geometric":
        s = Spacing(law, first=0.15, last=0.2).fractions(12, curve)
        assert s[1] == pytest.approx(0.15 / length) and 1 - s[-2] == pytest.approx(0.2 / length)


def test_a_spacing_is_a_value():
    assert Spacing("cosine") == Spacing("cosine") != Spacing("cosine", ends="first")
    with pytest.raises(AttributeError):
        Spacing("cosine").law = "uniform"


@pytest.mark.parametrize(
    ("call", "parameter"),
    [
        (lambda: hyperbolic_sine(10, first=0.5), "first"),
        (lambda: hyperbolic_sine(10, last=0.5), "last"),
        (lambda: hyperbolic_sine(10, first=0.01, last=0.01), "first"),
        (lambda: hyperbolic_sine(10, first=0.6, last=0.4), "first"),
        (lambda: hyperbolic_sine(2, first=0.6, last=0.5), "first"),
        (lambda: hyperbolic_sine(4, first=float("nan")), "first"),
        (lambda: hyperbolic_sine(4, first=0.1, last=0.0), "last"),
        (lambda: poisson(4, control=[0, 0]), "control"),
        (lambda: poisson(4, control=["a", 0, 0]), "control"),
        (lambda: poisson(4, control=[0, 2.0, 0]), "control"),
        (lambda: poisson(4, control=[0, float("nan"), 0]), "control"),
        (lambda: poisson(200, control=[1.5] * 199), "control"),
        (lambda: poisson(4, control=[0, 0, 0], first=0.1), "control"),
        (lambda: poisson(4, first=0.5, last=0.5), "first"),
        (lambda: poisson(500, first=0.4, last=0.4), "first"),
        (lambda: geometric(4, first=0.1, last=0.1), "ratio"),
        (lambda: geometric(100, last=0.9), "last"),
        (lambda: by_curvature(4, LINE, bend=1.0), "bend"),
        (lambda: by_curvature(4, LINE, width=0.0), "width"),
        (lambda: copied(4, np.array([[0, 0], [1, 0], [1, 0], [2, 0]])), "curve"),
        (lambda: Spacing("magic"), "law"),
        (lambda: Spacing("copied"), "source"),
        (lambda: Spacing("uniform", first=0.1), "first"),
        (lambda: Spacing("cosine", last=0.1), "last"),
        (lambda: Spacing("poisson", ratio=1.2), "ratio"),
        (lambda: Spacing("geometric", control=(0.0,)), "control"),
        (lambda: Spacing("geometric", first=0.1, last=0.2), "first"),
        (lambda: Spacing("geometric", first=3.0).fractions(4, LINE), "first"),
    ],
)
def test_impossible_demands_name_the_parameter(call, parameter):
    with pytest.raises(InvalidInput) as caught:
        call()
    assert caught.value.parameter == parameter


def test_a_curve_without_length_is_refused():
    with pytest.raises(InvalidGeometry):
        Spacing("curvature").fractions(4, np.zeros((3, 3)))
