"""Planes in space."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshcore import InvalidGeometry
from meshcore.geometry.plane import fitted_plane

CORNERS = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0], [1, 0.5, 0]], float)


@given(st.integers(0, 10_000), st.floats(-6, 6))
def test_tilted_planes_are_found(seed, exponent):
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    points = 10**exponent * (CORNERS @ turn.T + rng.normal(size=3))
    plane = fitted_plane(points)
    scale = np.abs(points).max()
    assert np.abs(plane.axes @ plane.axes.T - np.eye(2)).max() < 1e-14
    assert abs(abs(plane.normal @ turn[:, 2]) - 1) < 1e-12
    assert plane.normal[np.abs(plane.normal).argmax()] > 0
    assert np.abs(plane.to_space(plane.to_plane(points)) - points).max() < 1e-14 * scale
    flat = plane.to_plane(points)
    assert np.allclose(np.linalg.norm(flat[1:] - flat[0], axis=1), np.linalg.norm(points[1:] - points[0], axis=1))


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_constant_coordinate_is_dropped_to_the_bit(axis):
    points = np.random.default_rng(5).normal(size=(50, 3))
    points[:, axis] = 1 / 3
    plane = fitted_plane(points)
    assert (plane.to_space(plane.to_plane(points)) == points).all()
    assert plane.normal.tolist() == np.eye(3)[axis].tolist()


def test_non_planar_points_are_refused_with_the_deviation():
    points = CORNERS.copy()
    points[:, 2] = 0.1 * points[:, 0]
    points[4, 2] += 0.01
    with pytest.raises(
        InvalidGeometry, match=r"point 4 is 0\.0079\d+ off the best plane, 2\.2\d+e-06 is allowed"
    ) as caught:
        fitted_plane(points)
    assert 4 in caught.value.points
    assert fitted_plane(points, tolerance=0.01).deviations(points).max() < 0.01


def test_points_on_a_line_and_no_points_have_a_plane():
    line = np.outer(np.arange(5.0), [1.0, 2.0, 3.0])
    assert np.abs(fitted_plane(line).deviations(line)).max() < 1e-14
    assert fitted_plane(np.empty((0, 3))).normal.tolist() == [0, 0, 1]
