"""Sizes at the points of curves: spacing and curvature."""

import numpy as np
import pytest

from meshcore import InvalidInput, Mesh, discretised, gallery
from meshcore.geometry.curves import lines_through
from meshcore.geometry.parametric import ParametricCurve
from meshcore.sizing.on_curves import boundary_spacing, curvature_spacing
from meshcore.sizing.size_field import graded


def test_spacing_of_lines_and_of_surfaces():
    assert np.allclose(boundary_spacing(gallery.square(4)), 0.25)
    surface = Mesh([[0, 0, 0], [3, 0, 0], [0, 4, 0], [9, 9, 9]], {"triangle": [[0, 1, 2]]})
    assert boundary_spacing(surface).tolist() == [3.5, 4, 4.5, 4.5]
    tiny = gallery.square(4)
    assert np.allclose(boundary_spacing(tiny.with_points(1e-200 * tiny.points)) / 1e-200, 0.25)
    with pytest.raises(InvalidInput, match="no lines of any length"):
        boundary_spacing(Mesh([[0, 0], [0, 0]], {"line": [[0, 1]]}))


def test_a_boundary_carries_its_spacing_into_the_domain():
    boundary = gallery.joined(gallery.square(4), gallery.circle(40, radius=0.1, centre=(0.5, 0.5)))
    field = graded(boundary, boundary_spacing(boundary), 1.3, 1.0)
    spacing = 0.2 * np.sin(np.pi / 40)
    assert np.allclose(
        field(np.array([[0.5, 0.6, 0], [0.0, 0.1, 0], [0.5, 0.7, 0]])), [spacing, 0.25, spacing + 0.03], rtol=1e-3
    )


def test_the_curvature_of_an_ellipse_is_found_with_second_order():
    errors = []
    for n in (50, 100, 200):
        t = 2 * np.pi * np.arange(n) / n
        curve = lines_through(np.column_stack([3 * np.cos(t), np.sin(t)]), closed=True)
        radius = (9 * np.sin(t) ** 2 + np.cos(t) ** 2) ** 1.5 / 3
        errors.append(np.abs(curvature_spacing(curve, angle=10, largest=99) / (np.radians(10) * radius) - 1).max())
    assert np.log2(np.array(errors[:-1]) / errors[1:]).min() > 1.8


def test_lines_divided_by_curvature_turn_by_the_angle():
    bow = ParametricCurve(lambda t: np.column_stack([t, 0.3 * np.cosh(t / 0.3)]), -1, 1)
    fine = discretised(bow, size=0.005)[0]
    fine = fine.with_point_data(h=curvature_spacing(fine, angle=8, largest=10))
    coarse = discretised(fine, size_array="h")[0]
    points = coarse.points[np.argsort(coarse.points[:, 0])]
    along = np.diff(points[:, :2], axis=0)
    turn = np.degrees(np.abs(np.diff(np.arctan2(along[:, 1], along[:, 0]))))
    assert turn.max() < 9 and turn[2:-2].min() > 7.2


def test_corners_ends_and_straight_lines_have_the_largest_size():
    assert (curvature_spacing(gallery.square(3), largest=0.7) == 0.7).all()
    line = lines_through([[0, 0], [1, 0], [1, 0], [2, 0.1], [3, 0.4]])
    sizes = curvature_spacing(line, largest=5.0)
    assert sizes[[0, 1, 4]].tolist() == [5, 5, 5] and (sizes[[2, 3]] < 5).all()
    with pytest.raises(InvalidInput, match="angle: must be finite"):
        curvature_spacing(line, angle=0, largest=1)
    with pytest.raises(InvalidInput, match="largest: must be finite"):
        curvature_spacing(line, largest=np.inf)
