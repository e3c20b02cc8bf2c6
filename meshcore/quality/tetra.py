"""Verdict's measures of tetrahedra, by their names and definitions in the Verdict manual, chapter 6.

Three answers differ from Verdict's code on purpose, and follow the manual. For the smallest angle, the code turns
two of the four normals it compares inward, so that it takes 180 degrees less the dihedral angle at edges 0-2 and
1-3. For the collapse ratio, it exchanges edges 1-2 and 1-3, so that the heights over faces 0-1-2 and 0-1-3 are
divided by an edge that is not theirs. And the scaled Jacobian of a tetrahedron shrunk to a point is 0 here, where
Verdict answers its largest number, which would be its best.
"""

from __future__ import annotations

import numpy as np

from .measure_table import Measure, relative_size
from .vectors import chosen, cross, dot, length, quotient, side_by_side, squared, triple

_EDGES = np.array([(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)])
_FACES = np.array([(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)])
_OPPOSITE = ((2, 3), (1, 3), (1, 2), (0, 3), (0, 2), (0, 1))  # of each edge


def edges(x: np.ndarray) -> np.ndarray:
    """(m, 6, 3) float: the vectors 0-1, 0-2, 0-3, 1-2, 1-3, 2-3."""
    return chosen(x, _EDGES[:, 1]) - chosen(x, _EDGES[:, 0])


def jacobian(x: np.ndarray) -> np.ndarray:
    """Determinant of the edges from the first corner: six times the volume."""
    return triple(*(x[:, k] - x[:, 0] for k in (1, 2, 3)))


def volume(x: np.ndarray) -> np.ndarray:
    """Volume; negative if inverted."""
    return jacobian(x) / 6


def _doubled_areas(x: np.ndarray) -> np.ndarray:
    """(m, 4) float: twice the areas of the faces."""
    a, b, c = (chosen(x, nodes) for nodes in _FACES.T)
    return length(cross(b - a, c - a))


def dihedral_angles(x: np.ndarray) -> np.ndarray:
    """(m, 6) float: angle in degrees between the faces at each edge; 0 where a face has no area.

    From sine and cosine: Verdict's arc cosine loses half of the digits near 0 and 180 degrees.
    """
    e = edges(x)
    angles = []
    for k, (i, j) in enumerate(_OPPOSITE):
        origin = x[:, _EDGES[k, 0]]
        a, b = cross(e[:, k], x[:, i] - origin), cross(e[:, k], x[:, j] - origin)
        angles.append(np.arctan2(length(cross(a, b)), dot(a, b) + 0.0))  # -0.0 would be 180 degrees
    return np.degrees(side_by_side(angles))


def aspect_frobenius(x: np.ndarray) -> np.ndarray:
    """Frobenius condition number of the map from the regular tetrahedron; 1 is regular."""
    u, v, w = (x[:, k] - x[:, 0] for k in (1, 2, 3))
    top = 1.5 * (squared(u) + squared(v) + squared(w)) - dot(u, v) - dot(u, w) - dot(v, w)
    return quotient(top, 3 * np.cbrt(2 * jacobian(x) ** 2), np.inf)


def aspect_gamma(x: np.ndarray) -> np.ndarray:
    """Cube of the root mean square edge over 6 sqrt(2) times the volume; 1 is regular."""
    mean = np.sqrt(squared(edges(x)).mean(axis=1))
    return quotient(mean**3, 6 * np.sqrt(2) * np.abs(volume(x)), np.inf)


def aspect_ratio(x: np.ndarray) -> np.ndarray:
    """Longest edge over 2 sqrt(6) times the radius of the inscribed sphere; 1 is regular."""
    longest = length(edges(x)).max(axis=1)
    return quotient(longest * _doubled_areas(x).sum(axis=1), 2 * np.sqrt(6) * np.abs(jacobian(x)), np.inf)


def collapse_ratio(x: np.ndarray) -> np.ndarray:
    """Least height of a corner over the longest edge of the opposite face; negative if inverted."""
    longest = [chosen(length(edges(x)), used).max(axis=1) for used in ((0, 1, 3), (0, 2, 4), (1, 2, 5), (3, 4, 5))]
    return quotient(jacobian(x)[:, None], _doubled_areas(x) * side_by_side(longest), np.inf).min(axis=1)


def condition(x: np.ndarray) -> np.ndarray:
    """Condition number of the map from the regular tetrahedron over 3; 1 is regular, negative if inverted."""
    u, v, w = (x[:, k] - x[:, 0] for k in (1, 2, 3))
    a, b, c = u, (2 * v - u) / np.sqrt(3), (3 * w - v - u) / np.sqrt(6)
    size = squared(a) + squared(b) + squared(c)
    adjoint = squared(cross(a, b)) + squared(cross(b, c)) + squared(cross(a, c))
    return quotient(np.sqrt(size * adjoint), 3 * triple(a, b, c), np.inf)


def distortion(x: np.ndarray) -> np.ndarray:
    """Least Jacobian over the mean Jacobian: 1, since the map onto a straight tetrahedron is linear."""
    return np.ones(len(x))


def min_angle(x: np.ndarray) -> np.ndarray:
    """Smallest dihedral angle in degrees."""
    return dihedral_angles(x).min(axis=1)


def radius_ratio(x: np.ndarray) -> np.ndarray:
    """Radius of the circumscribed over three times that of the inscribed sphere; 1 is regular."""
    u, v, w = (x[:, k] - x[:, 0] for k in (1, 2, 3))
    centre = squared(w)[:, None] * cross(u, v) + squared(v)[:, None] * cross(w, u) + squared(u)[:, None] * cross(v, w)
    return quotient(length(centre) * _doubled_areas(x).sum(axis=1), 6 * jacobian(x) ** 2, np.inf)


def relative_size_squared(x: np.ndarray) -> np.ndarray:
    """min(s, 1 / s)^2, with s the volume over the mean volume of the tetrahedra; 0 if inverted or if the mean is."""
    return relative_size(volume(x))


def scaled_jacobian(x: np.ndarray) -> np.ndarray:
    """sqrt(2) times the Jacobian over the largest product of the three edges at a corner; 1 is regular."""
    e = length(edges(x))
    at_corners = side_by_side([chosen(e, used).prod(axis=1) for used in ((0, 1, 2), (0, 3, 4), (1, 3, 5), (2, 4, 5))])
    return quotient(np.sqrt(2) * jacobian(x), at_corners.max(axis=1), 0.0)


def shape(x: np.ndarray) -> np.ndarray:
    """1 over `aspect_frobenius`; 0 if inverted or flat."""
    return np.where(jacobian(x) > 0, 1 / aspect_frobenius(x), 0.0)


def shape_and_size(x: np.ndarray) -> np.ndarray:
    """`shape` times `relative_size_squared`."""
    return shape(x) * relative_size_squared(x)


MEASURES = {
    "aspect_frobenius": Measure(aspect_frobenius, (1, 1.3)),
    "aspect_gamma": Measure(aspect_gamma, (1, 3)),
    "aspect_ratio": Measure(aspect_ratio, (1, 3)),
    "collapse_ratio": Measure(collapse_ratio, (0.1, np.inf)),
    "condition": Measure(condition, (1, 3)),
    "distortion": Measure(distortion, (0.5, 1)),
    "jacobian": Measure(jacobian, (0, np.inf), "volume"),
    "min_angle": Measure(min_angle, (40, np.degrees(np.arccos(1 / 3))), "degree"),
    "radius_ratio": Measure(radius_ratio, (1, 3)),
    "relative_size_squared": Measure(relative_size_squared, (0.3, 1)),
    "scaled_jacobian": Measure(scaled_jacobian, (0.5, 1)),
    "shape": Measure(shape, (0.3, 1)),
    "shape_and_size": Measure(shape_and_size, (0.2, 1)),
    "volume": Measure(volume, (0, np.inf), "volume"),
}
