"""Size fields graded from a curve."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshcore import InvalidInput, Mesh
from meshcore.gallery import circle
from meshcore.sizing.size_field import evaluated, graded


def distance_to_segments(points, curve):
    """Brute force: each point to each segment."""
    a, b = (curve.points[curve.get("line")[:, k]] for k in (0, 1))
    along = b - a
    found = []
    for p in points:
        share = np.clip(((p - a) * along).sum(axis=1) / (along**2).sum(axis=1), 0, 1)
        found.append(np.linalg.norm(p - a - share[:, None] * along, axis=1).min())
    return np.array(found)


@given(st.floats(0.01, 1.0), st.floats(1.05, 2.0), st.floats(1.0, 50.0))
def test_the_size_grows_with_the_distance(near, growth, far):
    curve = circle(7, radius=2.0)
    points = np.random.default_rng(5).uniform(-6, 6, (200, 3))
    exact = np.minimum(near + (growth - 1) * distance_to_segments(points, curve), far)
    sizes = graded(curve, near, growth, far)(points)
    assert (sizes <= exact + 1e-12).all()
    assert (sizes >= exact - (growth - 1) * near / 2).all()
    assert (sizes >= near).all()


def test_points_count_each_on_its_own():
    field = graded(np.array([[0.0, 0], [10, 0]]), 0.5, 1.5, 3.0)
    assert field(np.array([[0.0, 0, 0], [10, 1, 0], [5, 0, 0]])).tolist() == [0.5, 1.0, 3.0]


@pytest.mark.parametrize(
    "arguments, message",
    [
        ((0, 1.2, 1), "near: must be finite and greater"),
        ((0.1, 1.2, np.inf), "far: must be finite"),
        ((2, 1.2, 1), "must not exceed far"),
        ((0.1, 1.0, 1), "growth: must be above 1"),
        ((0.1, np.nan, 1), "growth: must be above 1"),
    ],
)
def test_bad_gradings_are_refused(arguments, message):
    with pytest.raises(InvalidInput, match=message):
        graded(circle(), *arguments)
    with pytest.raises(InvalidInput, match="at least one point"):
        graded(Mesh(np.empty((0, 3)), {}), 0.1, 1.2, 1)


def test_a_number_is_a_uniform_field():
    assert evaluated(lambda points: 0.5, np.zeros((3, 3))).tolist() == [0.5] * 3
