"""Surfaces by formulas and splines: points, tangents, bad input."""

import numpy as np
import pytest

from meshcore import InvalidGeometry, InvalidInput
from meshcore.geometry.surfaces import ParametricSurface, SplineSurface


def bowl(u, v):
    """A surface of second degree."""
    return np.stack([u, 2 * v, u * u - u * v], axis=-1)


def test_tangents_are_derivatives_up_to_the_rim():
    surface = ParametricSurface(bowl, (-1, 1), (0, 2))
    u, v = np.array([-1, 0.2, 1.0]), np.array([0, 1.1, 2.0])
    by_u, by_v = surface.tangents(u, v)
    # At the rim quotients are one-sided: right to first order in a step of 2e-5.
    np.testing.assert_allclose(by_u, np.stack([1 + 0 * u, 0 * u, 2 * u - v], axis=-1), atol=3e-5)
    np.testing.assert_allclose(by_u[1], [1, 0, 0.4 - 1.1], atol=1e-9)
    np.testing.assert_allclose(by_v, np.stack([0 * u, 2 + 0 * u, -u], axis=-1), atol=1e-9)


@pytest.mark.parametrize("shape", [(6, 5), (4, 4), (2, 7), (3, 2)])
def test_a_spline_goes_through_its_points_and_has_its_own_tangents(shape):
    u, v = np.meshgrid(*(np.linspace(0, 1, n) ** 1.3 for n in shape), indexing="ij")
    grid = bowl(u, v)
    surface = SplineSurface(grid)
    at = np.moveaxis(surface.parameters, -1, 0)
    np.testing.assert_allclose(surface.points(*at), grid, atol=1e-13)
    inside = 0.1 + 0.8 * at
    for tangent, step in zip(surface.tangents(*inside), np.eye(2)[:, :, None, None] * 1e-6, strict=True):
        quotient = (surface.points(*(inside + step)) - surface.points(*(inside - step))) / 2e-6
        np.testing.assert_allclose(tangent, quotient, atol=1e-8)


def test_bad_formulas_are_named():
    half = np.array([0.5])
    with pytest.raises(InvalidInput, match="lesser and a greater"):
        ParametricSurface(bowl, u=(1, 1))
    with pytest.raises(InvalidInput, match=r"must return shape \(1, 3\)"):
        ParametricSurface(lambda u, v: u).points(half, half)
    with pytest.raises(InvalidInput, match=r"u = 0\.5, v = 0\.5"):
        ParametricSurface(lambda u, v: np.full((*u.shape, 3), np.nan)).points(half, half)


def test_bad_grids_of_points_are_named():
    good = bowl(*np.meshgrid(np.linspace(0, 1, 4), np.linspace(0, 1, 5), indexing="ij"))
    with pytest.raises(InvalidInput, match=r"shape \(m, n, 3\)"):
        SplineSurface(good[0])
    with pytest.raises(InvalidInput, match=r"2 x 2 points"):
        SplineSurface(good[:1])
    bad = good.copy()
    bad[2, 3, 1] = np.nan
    with pytest.raises(InvalidGeometry, match=r"point \(2, 3\)"):
        SplineSurface(bad)
    bad = good.copy()
    bad[:, 2] = bad[:, 1]
    with pytest.raises(InvalidGeometry, match="lines 1 and 2"):
        SplineSurface(bad)
