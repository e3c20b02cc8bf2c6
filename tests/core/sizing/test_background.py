"""Size fields on a background mesh, and the limit of their gradation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshcore import InvalidInput, Mesh
from meshcore.gallery import circle, triangulated_square
from meshcore.sizing.background import background_field
from meshcore.sizing.gradation import limited, limited_field
from meshcore.sizing.size_field import constant, graded, smallest
from tests import naive


def test_a_linear_field_is_kept_and_outside_the_nearest_counts():
    mesh = triangulated_square(5)
    field = background_field(mesh, 2 + mesh.points[:, 0] - mesh.points[:, 1])
    points = np.column_stack([np.random.default_rng(0).uniform(-1, 2, (500, 2)), np.zeros(500)])
    nearest = np.clip(points, 0, 1)
    assert np.abs(field(points) - (2 + nearest[:, 0] - nearest[:, 1])).max() < 1e-14


def test_interpolation_converges_with_second_order():
    points = np.column_stack([np.random.default_rng(1).random((2000, 2)), np.zeros(2000)])

    def size(at):
        return 2 + np.sin(3 * at[:, 0]) * np.cos(2 * at[:, 1])

    errors = []
    for n in (8, 16, 32, 64):
        mesh = triangulated_square(n)
        errors.append(np.abs(background_field(mesh, size(mesh.points))(points) - size(points)).max())
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert rates.min() > 1.85


def test_a_background_in_space():
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    mesh = Mesh(corners, {"tetra": [[0, 1, 2, 3]]}, {"h": 1 + corners.sum(axis=1)})
    points = np.array([[0.1, 0.2, 0.3], [1, 1, 1], [-1, -1, -1], [0.2, 0.2, -5]])
    assert np.allclose(background_field(mesh, "h")(points), [1.6, 2, 1, 1.4])


@given(st.integers(0, 10_000), st.floats(0.01, 3))
def test_limited_sizes_are_those_of_sweeps_over_all_edges(seed, gradation):
    rng = np.random.default_rng(seed)
    mesh = triangulated_square(4)
    mesh = mesh.with_points(mesh.points + np.append(rng.uniform(-0.05, 0.05, (25, 2)), np.zeros((25, 1)), axis=1))
    sizes = 10 ** rng.uniform(-3, 1, 25)
    found = limited(mesh, sizes, gradation)
    length = np.linalg.norm(np.diff(mesh.points[mesh.edges], axis=1)[:, 0], axis=1)
    assert np.allclose(found, naive.limited(mesh.edges, length, sizes, gradation), rtol=1e-13)
    assert (found <= sizes).all() and (found[sizes.argmin()] == sizes.min()).all()
    growth = np.abs(np.diff(found[mesh.edges], axis=1)[:, 0])
    assert (growth <= gradation * length * (1 + 1e-12)).all()
    assert (limited(mesh, found, gradation) == found).all()


@pytest.mark.parametrize("scale", [1e-200, 1.0, 1e200])
def test_gradation_does_not_depend_on_the_unit(scale):
    mesh = triangulated_square(6)
    sizes = np.random.default_rng(3).uniform(0.01, 1, mesh.n_points)
    scaled = limited(mesh.with_points(scale * mesh.points), scale * sizes, 0.3)
    assert np.allclose(scaled / scale, limited(mesh, sizes, 0.3), rtol=1e-12)


def test_a_field_is_limited_and_kept_where_the_background_misses_it():
    mesh = triangulated_square(10)
    spike = smallest(constant(0.5), graded(np.array([[0.512, 0.487, 0]]), 0.001, 1.5, 0.5))
    field = limited_field(spike, mesh, 0.2)
    points = np.column_stack([np.random.default_rng(1).random((500, 2)), np.zeros(500)])
    away = np.linalg.norm(points - [0.512, 0.487, 0], axis=1)
    assert (field(points) <= np.minimum(spike(points), 0.02 + 0.5 * 0.15 + 0.25 * away)).all()
    assert field(np.array([[0.512, 0.487, 0]]))[0] == 0.001
    kept = limited_field(constant(0.3), mesh, 0.2)(points)
    assert np.allclose(kept, 0.3)


@pytest.mark.parametrize(
    "sizes, gradation, message",
    [
        ("h", 0.2, "no point array 'h'"),
        (np.ones(3), 0.2, r"needs one size a point, that is shape \(25,\)"),
        (np.zeros(25), 0.2, r"the size is 0 at point 0, \(0, 0, 0\) \(25 points in all\)"),
        (np.ones(25), 0, "gradation: must be finite and greater"),
        (np.ones(25), np.inf, "gradation: must be finite and greater"),
        (lambda p: -p[:, 0] - 1, 0.2, "sizes: is -1 at"),
        ([["a"]], 0.2, "needs a number for each point"),
    ],
)
def test_bad_sizes_and_gradations_are_refused(sizes, gradation, message):
    with pytest.raises(InvalidInput, match=message):
        limited(triangulated_square(), sizes, gradation)


def test_sizes_of_points_without_cells_do_not_matter():
    mesh = Mesh([[0, 0], [1, 0], [5, 5]], {"line": [[0, 1]]}, {"h": [1.0, 9.0, np.nan]})
    assert limited(mesh, "h", 0.5)[:2].tolist() == [1.0, 1.5]


def test_sources_of_all_kinds():
    surface = Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], {"quad": [[0, 1, 2, 3]]})
    field = graded(surface, 0.1, 1.5, 2.0, radius=0.2)
    heights = np.array([0, 0.1, 0.2, 1.2, 9.0])
    points = np.column_stack([np.full((5, 2), 0.3), heights])
    assert np.allclose(field(points), [0.1, 0.1, 0.1, 0.6, 2.0])
    curve = Mesh([[0, 0], [1, 0]], {"line": [[0, 1]]})
    along = graded(curve, np.array([0.1, 0.3]), 1.5, 2.0)
    assert np.allclose(along(np.array([[0.5, 0, 0], [1, 0, 0], [0.25, 1, 0]])), [0.2, 0.3, 0.65])
    cube_like = Mesh(np.random.default_rng(0).normal(size=(4, 3)), {"tetra": [[0, 1, 2, 3]]})
    assert graded(cube_like, 0.1, 1.5, 2.0)(cube_like.points[:1])[0] == pytest.approx(0.1)
    with pytest.raises(InvalidInput, match="radius: must be finite and not negative"):
        graded(circle(), 0.1, 1.2, 1, radius=-1)
    with pytest.raises(InvalidInput, match="near: needs one size, or one for each of 2 points"):
        graded(curve, np.ones(3), 1.2, 1)
    with pytest.raises(InvalidInput, match="near: must be finite and greater than zero, got nan"):
        graded(curve, np.array([1, np.nan]), 1.2, 1)


def test_the_smallest_of_fields():
    field = smallest(constant(0.5), lambda p: 0.1 + p[:, 0], lambda p: 0.3)
    assert field(np.array([[0.0, 0, 0], [0.1, 0, 0], [9, 0, 0]])).tolist() == [0.1, 0.2, 0.3]
    with pytest.raises(InvalidInput, match="at least one"):
        smallest()
    with pytest.raises(InvalidInput, match="fields: is 0 at"):
        smallest(constant(1), lambda p: p[:, 0])(np.zeros((1, 3)))
    with pytest.raises(InvalidInput, match="size: must be finite"):
        constant(0)
