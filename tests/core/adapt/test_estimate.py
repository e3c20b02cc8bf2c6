"""Error indicators and marking against their definitions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshcore import Mesh, gallery
from meshcore.adapt import gradient_jump, marked, variation
from meshcore.errors import InvalidGeometry, InvalidInput
from tests import naive


def bumpy(n=4, seed=8):
    """Triangles of a square, points moved at random, with a random field."""
    rng = np.random.default_rng(seed)
    mesh = gallery.triangulated_square(n)
    points = mesh.points[:, :2] + rng.uniform(-0.2, 0.2, (mesh.n_points, 2)) / n
    return Mesh(points, {"line": mesh.boundary.cells["line"], "triangle": mesh.cells["triangle"]}), rng


def test_variation_is_the_largest_difference():
    mesh, rng = bumpy()
    values = rng.normal(size=mesh.n_points)
    expected = [np.ptp(values[t]) for t in mesh.cells["triangle"]]
    np.testing.assert_allclose(variation(mesh, values), expected)
    np.testing.assert_allclose(variation(mesh.with_point_data(u=values), "u"), expected)


def test_variation_of_a_vector_does_not_turn_with_it():
    mesh, rng = bumpy()
    values = rng.normal(size=(mesh.n_points, 2))
    turned = values @ np.array([[0.6, 0.8], [-0.8, 0.6]])
    np.testing.assert_allclose(variation(mesh, values), variation(mesh, turned))
    np.testing.assert_allclose(variation(mesh, values[:, :1] * [1, 0]), variation(mesh, values[:, 0]))


@pytest.mark.parametrize("seed", range(5))
def test_gradient_jump_is_its_definition(seed):
    mesh, rng = bumpy(seed=seed)
    values = rng.normal(size=mesh.n_points)
    expected = naive.gradient_jump(mesh.points, mesh.cells["triangle"], values)
    np.testing.assert_allclose(gradient_jump(mesh, values), expected, rtol=1e-10)


def test_gradient_jump_of_a_linear_field_is_zero():
    mesh, _ = bumpy(8)
    assert gradient_jump(mesh, mesh.points @ [3.0, -2.0, 0.0] + 5).max() < 1e-12


def test_gradient_jump_does_not_turn_with_the_mesh():
    """In space as in the plane; of a vector, the squares of its components."""
    mesh, rng = bumpy()
    values = rng.normal(size=(mesh.n_points, 2))
    rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))
    expected = np.hypot(gradient_jump(mesh, values[:, 0]), gradient_jump(mesh, values[:, 1]))
    np.testing.assert_allclose(gradient_jump(mesh, values), expected)
    np.testing.assert_allclose(gradient_jump(mesh.with_points(mesh.points @ rotation), values), expected)


def test_a_fold_is_no_jump():
    """Across the fold of a roof, a field linear in the length along it bends with the surface, and has no jump."""
    roof = Mesh([[0, 0, 0], [0, 1, 0], [1, 0, 1], [-1, 0, 1]], {"triangle": [[0, 2, 1], [0, 1, 3]]})
    along = np.array([0, 0, np.sqrt(2), -np.sqrt(2)])
    assert gradient_jump(roof, along).max() < 1e-15
    assert gradient_jump(roof, np.abs(along)).min() > 1


@settings(deadline=None, max_examples=200)
@given(st.lists(st.floats(0, 1e6), min_size=1, max_size=40), st.floats(0.01, 1))
def test_marked_is_the_smallest_set_that_holds_its_share(values, fraction):
    values = np.array(values)
    marks = marked(values, fraction)
    if not values.any():
        assert not marks.any()
        return
    total = values.sum()
    assert values[marks].sum() >= fraction * total * (1 - 1e-12)
    assert values[marks].sum() - values[marks].min() <= fraction * total * (1 + 1e-12)
    if not marks.all():
        assert values[marks].min() >= values[~marks].max()


def test_marked_takes_the_first_of_equals():
    assert marked(np.ones(10), 0.3).tolist() == [True] * 3 + [False] * 7
    assert not marked(np.ones(4), 0.0).any()
    assert marked(np.array([0.0, 1.0, 0.0]), 1.0).tolist() == [False, True, False]
    assert marked(np.array([1e308] * 4), 0.5).sum() == 2
    assert marked(np.empty(0), 0.5).shape == (0,)


@pytest.mark.parametrize(
    ("values", "fraction", "message"),
    [
        ([1.0, np.nan], 0.5, "cell 1 has nan"),
        ([1.0, -1.0], 0.5, "cell 1 has -1"),
        ([[1.0]], 0.5, "needs one number per cell"),
        ("a", 0.5, "needs numbers"),
        ([1.0], 2, "fraction: must be between 0 and 1"),
        ([1.0], float("nan"), "fraction: must be between 0 and 1"),
    ],
)
def test_marked_refuses(values, fraction, message):
    with pytest.raises(InvalidInput, match=message):
        marked(values, fraction)


@pytest.mark.parametrize("estimate", [variation, gradient_jump])
def test_estimates_refuse(estimate):
    mesh = gallery.triangulated_square(2)
    with pytest.raises(InvalidInput, match="no point array 'u'; there are front"):
        estimate(mesh, "u")
    with pytest.raises(InvalidInput, match="one value per point, that is 9"):
        estimate(mesh, np.ones(8))
    with pytest.raises(InvalidInput, match="point 0 has"):
        estimate(mesh, np.full(9, np.inf))
    with pytest.raises(InvalidInput, match="needs numbers"):
        estimate(mesh, ["x"] * 9)
    with pytest.raises(InvalidInput, match="has no triangles"):
        estimate(gallery.square(), np.ones(4))


def test_gradient_jump_refuses_triangles_without_area():
    mesh = Mesh([[0, 0], [1, 0], [2, 0], [0, 1]], {"triangle": [[0, 1, 3], [0, 1, 2]]})
    with pytest.raises(InvalidGeometry, match=r"cell 1 at .* has no area") as caught:
        gradient_jump(mesh, np.ones(4))
    assert caught.value.cells == (1,)
