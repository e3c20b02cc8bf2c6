"""Splines without wiggles."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshcore.geometry.spline import ShapeSpline


def sign_changes(points, closed=False):
    edge = np.diff(points, axis=0)
    if closed:
        edge = np.vstack([edge, edge[:1]])
    cross = edge[:-1, 0] * edge[1:, 1] - edge[:-1, 1] * edge[1:, 0]
    size = np.linalg.norm(edge[:-1], axis=1) * np.linalg.norm(edge[1:], axis=1)
    sign = np.sign(np.where(np.abs(cross) < 1e-9 * size, 0, cross))
    sign = sign[sign != 0]
    return int((sign[1:] != sign[:-1]).sum())


@given(st.integers(0, 10**6), st.integers(3, 12), st.floats(0.0, 1.0))
@settings(max_examples=200, deadline=None)
def test_the_curvature_changes_sign_no_oftener_than_the_points_turn(seed, n, noise):
    rng = np.random.default_rng(seed)
    heading = np.cumsum(noise * rng.uniform(-1, 1, n))
    steps = (rng.random(n) ** 3 + 1e-2)[:, None] * np.column_stack([np.cos(heading), np.sin(heading)])
    points = np.vstack([[0, 0], np.cumsum(steps, axis=0)])
    fine = ShapeSpline(points)
    at = np.concatenate([np.linspace(a, b, 41)[:-1] for a, b in zip(fine.length[:-1], fine.length[1:], strict=True)])
    assert sign_changes(fine(at)) <= sign_changes(points)


def test_on_a_fine_circle_it_is_the_cubic_spline():
    errors = []
    for n in (16, 32):
        angle = np.linspace(0, 2 * np.pi, n + 1)
        points = np.column_stack([np.cos(angle), np.sin(angle)])
        points[-1] = points[0]
        spline = ShapeSpline(points, closed=True)
        fine = spline(np.linspace(0, spline.length[-1], 1000))
        errors.append(np.abs(np.hypot(*fine.T) - 1).max())
        assert np.array_equal(spline(spline.length[:-1]), points[:-1])
    assert errors[0] / errors[1] == pytest.approx(16, rel=0.25)  # of fourth order


def test_a_coarse_nose_does_not_overshoot():
    # An eight-point section: the plain cubic spline swings out on its flat rear.
    points = np.array(
        [[1, 0], [0.7, 0.01], [0.4, 0.02], [0.05, 0.06], [0, 0], [0.05, -0.06], [0.5, -0.03], [1, 0]], float
    )
    spline = ShapeSpline(points)
    fine = spline(np.linspace(0, spline.length[-1], 2000))
    assert sign_changes(fine) <= sign_changes(points)
    assert fine[:, 0].max() <= 1 and np.abs(fine[:, 1]).max() < 0.1


def test_two_and_three_points():
    assert np.allclose(ShapeSpline(np.array([[0.0, 0], [2, 2]]))(np.array([np.sqrt(2)])), [[1, 1]])
    three = ShapeSpline(np.array([[0.0, 0], [1, 1], [2, 0]]))
    assert three(np.array([0.0, three.length[1], three.length[2]])).tolist() == [[0, 0], [1, 1], [2, 0]]
