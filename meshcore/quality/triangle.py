"""Verdict's measures of triangles, by their names and definitions in the Verdict manual.

References
----------
C. J. Stimpson, C. D. Ernst, P. Knupp, P. P. Pebay and D. Thompson, "The Verdict library reference manual",
SAND2007-2853P (2007), chapter 4.
"""

from __future__ import annotations

import numpy as np

from .measure_table import Measure, relative_size
from .vectors import chosen, cross, dot, length, quotient, squared


def edges(x: np.ndarray) -> np.ndarray:
    """(m, 3, 3) float: the vectors 0 to 1, 1 to 2, 2 to 0."""
    return chosen(x, (1, 2, 0)) - x


def doubled_area(x: np.ndarray) -> np.ndarray:
    """(m,) float: twice the area, without sign."""
    return length(cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]))


def _angle(x: np.ndarray, reduce: str) -> np.ndarray:
    """(m,) float: the angle whose edges have the largest ("max") or smallest ("min") scalar product, in degrees.

    At each corner the sine's side is twice the area, so the scalar products alone rank the angles. Verdict's arc
    cosine loses half of the digits near 0 and 180 degrees, this does not.
    """
    e = edges(x)
    products = 0.0 - dot(e, chosen(e, (2, 0, 1)))  # not -0.0, which would make the angle 180
    return np.degrees(np.arctan2(doubled_area(x), getattr(products, reduce)(axis=1)))


def area(x: np.ndarray) -> np.ndarray:
    """Area."""
    return doubled_area(x) / 2


def aspect_ratio(x: np.ndarray) -> np.ndarray:
    """Longest edge over 2 sqrt(3) times the radius of the inscribed circle; 1 is equilateral."""
    sides = length(edges(x))
    return quotient(sides.max(axis=1) * sides.sum(axis=1), 2 * np.sqrt(3) * doubled_area(x), np.inf)


def radius_ratio(x: np.ndarray) -> np.ndarray:
    """Radius of the circumscribed over twice that of the inscribed circle; 1 is equilateral."""
    sides = length(edges(x))
    return quotient(sides.prod(axis=1) * sides.sum(axis=1), 4 * doubled_area(x) ** 2, np.inf)


def aspect_frobenius(x: np.ndarray) -> np.ndarray:
    """Sum of squared edges over 4 sqrt(3) times the area; 1 is equilateral."""
    return quotient(squared(edges(x)).sum(axis=1), 2 * np.sqrt(3) * doubled_area(x), np.inf)


def condition(x: np.ndarray) -> np.ndarray:
    """Condition number of the map from the equilateral triangle, halved; 1 is equilateral.

    The same number as `aspect_frobenius`: |a|^2 + |b|^2 - a.b is half of the sum of the squared edges.
    """
    return aspect_frobenius(x)


def distortion(x: np.ndarray) -> np.ndarray:
    """Least Jacobian over the mean Jacobian: 1, since the map onto a straight triangle is linear."""
    return np.ones(len(x))


def max_angle(x: np.ndarray) -> np.ndarray:
    """Largest inner angle in degrees; 0 with an edge without length."""
    return _angle(x, "min")


def min_angle(x: np.ndarray) -> np.ndarray:
    """Smallest inner angle in degrees; 0 with an edge without length."""
    return _angle(x, "max")


def scaled_jacobian(x: np.ndarray) -> np.ndarray:
    """Twice the area over the largest product of two edges, times 2 / sqrt(3); 1 is equilateral."""
    sides = length(edges(x))
    product = (sides * chosen(sides, (1, 2, 0))).max(axis=1)
    return quotient(2 / np.sqrt(3) * doubled_area(x), product, 0.0)


def shape(x: np.ndarray) -> np.ndarray:
    """1 over `condition`: 1 is equilateral, 0 has no area."""
    return 1 / condition(x)


def relative_size_squared(x: np.ndarray) -> np.ndarray:
    """min(s, 1 / s)^2, with s the area over the mean area of the mesh's triangles."""
    return relative_size(area(x))


def shape_and_size(x: np.ndarray) -> np.ndarray:
    """`shape` times `relative_size_squared`."""
    return shape(x) * relative_size_squared(x)


MEASURES = {
    "area": Measure(area, (0, np.inf), "area"),
    "aspect_frobenius": Measure(aspect_frobenius, (1, 1.3)),
    "aspect_ratio": Measure(aspect_ratio, (1, 1.3)),
    "condition": Measure(condition, (1, 1.3)),
    "distortion": Measure(distortion, (0.5, 1)),
    "max_angle": Measure(max_angle, (60, 90), "degree"),
    "min_angle": Measure(min_angle, (30, 60), "degree"),
    "radius_ratio": Measure(radius_ratio, (1, 3)),
    "relative_size_squared": Measure(relative_size_squared, (0.25, 1)),
    "scaled_jacobian": Measure(scaled_jacobian, (0.5, 2 / np.sqrt(3))),
    "shape": Measure(shape, (0.25, 1)),
    "shape_and_size": Measure(shape_and_size, (0.25, 1)),
}
