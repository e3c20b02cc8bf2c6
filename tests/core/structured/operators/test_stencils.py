"""Stencils along lines: exact for polynomials up to the ends, closed lines, and the same as matrices."""

import numpy as np
import pytest

from meshcore.structured.operators.stencils import DIFFERENCE, SLOPE, STENCILS

EVERY = [(order, name) for order in STENCILS for name in STENCILS[order]._fields]
OF_MEANS = ("face", "face_derivative")
OF_MIDDLES = ("derivative_of_middles",)
AT_MIDDLES = ("middle", "middle_derivative")


def case(name, n, power):
    """The values that a stencil is given of x^power on n cells, and what it should make of them."""
    points, middles = np.arange(n + 1.0), np.arange(n) + 0.5
    at = middles if name in AT_MIDDLES else points
    value = at**power
    slope = power * at ** max(power - 1, 0)
    primitive = points ** (power + 1) / (power + 1)
    means = np.diff(primitive)
    given = means if name in OF_MEANS else middles**power if name in OF_MIDDLES else points**power
    return given, {"mean": means}.get(name, slope if "derivative" in name else value)


@pytest.mark.parametrize("order, name", EVERY)
def test_exact_for_polynomials_below_the_order_up_to_the_ends(order, name):
    stencil = getattr(STENCILS[order], name)
    for power in range(order):
        given, expected = case(name, 9, power)
        np.testing.assert_allclose(stencil.along(given, 0), expected, rtol=1e-9, atol=1e-9 * 9**power)


@pytest.mark.parametrize("order, name", EVERY)
def test_not_exact_beyond_the_order(order, name):
    """Of x^(order + 1), whose derivative is of the order that the stencils miss, or of x^order for values."""
    stencil = getattr(STENCILS[order], name)
    given, expected = case(name, 9, order + 1 if "derivative" in name else order)
    assert np.abs(stencil.along(given, 0) - expected).max() > 1e-3


@pytest.mark.parametrize("period", [0, 9])
@pytest.mark.parametrize("stencil", [getattr(STENCILS[o], name) for o, name in EVERY] + [DIFFERENCE, SLOPE])
def test_a_stencil_is_its_matrix(stencil, period):
    values = np.random.default_rng(3).random(9 + (stencil.growth < 1))
    if stencil.growth == 0 and not period:
        values = values[:-1]
    if period and len(values) > period:
        values[-1] = values[0]
    found = stencil.along(values, 0, period)
    assert len(found) == len(values) + stencil.growth
    np.testing.assert_allclose(stencil.matrix(len(values), period) @ values, found, atol=1e-12)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_any_axis_of_vectors(axis):
    values = np.random.default_rng(4).random((8, 9, 10, 3))
    stencil = STENCILS[4].derivative
    found = stencil.along(values, axis)
    matrix = stencil.matrix(values.shape[axis]).toarray()
    np.testing.assert_allclose(found, np.moveaxis(np.tensordot(matrix, values, (1, axis)), 0, axis), atol=1e-12)
    assert found.flags.c_contiguous


@pytest.mark.parametrize("order", STENCILS)
def test_derivatives_of_derivatives_keep_the_order_at_the_ends(order):
    """The reason for smooth ghosts: with the usual one-sided formulas the second one falls to the order less one."""
    errors, sizes = [], (40, 60, 80, 120)
    for n in sizes:
        x = np.linspace(0, 1, n + 1)
        twice = STENCILS[order].derivative.along(STENCILS[order].derivative.along(np.exp(x), 0), 0) * n**2
        errors.append(np.abs(twice - np.exp(x)).max())
    assert -np.polyfit(np.log(sizes), np.log(errors), 1)[0] > order - 0.3
