"""Verdict's measures of wedges. The manual of 2007 has the volume alone; the others are defined in Verdict's code.

Verdict norms its measures by rounded constants (1.16477; 0.433013 / 0.866025), here they are exact: aspect and
condition differ by 3.4e-6, distortion by 1.2e-6 of their values. Where an edge has no length, the scaled Jacobian is
0 or less, where Verdict's depends on the order of its comparisons with nan. The acceptable ranges are those of
hexahedra.
"""

from __future__ import annotations

import numpy as np

from . import solid, tetra
from .measure_table import Measure
from .vectors import chosen, quotient

_KIND = "wedge"
_IDEAL = np.sqrt(3) / 2  # determinant at the corners of the right prism of unit edges
_IDEAL_ASPECT = 4 / (3 * np.cbrt(1.5))  # aspect Frobenius of the tetrahedra at its corners


def volume(x: np.ndarray) -> np.ndarray:
    """Volume; negative if inverted."""
    return solid.volume(_KIND, x)


def max_aspect_frobenius(x: np.ndarray) -> np.ndarray:
    """Largest aspect Frobenius of the tetrahedra at the corners over that of the ideal wedge, 1 at least."""
    aspects = [tetra.aspect_frobenius(chosen(x, corner)) for corner in solid.CORNERS[_KIND]]
    return np.maximum(np.maximum.reduce(aspects) / _IDEAL_ASPECT, 1.0)


def distortion(x: np.ndarray) -> np.ndarray:
    """Least corner determinant over twice the volume; 1 is a prism."""
    return quotient(jacobian(x), 2 * volume(x), np.inf)


def jacobian(x: np.ndarray) -> np.ndarray:
    """Least determinant at the corners."""
    return solid.corner_jacobians(_KIND, x).min(axis=1)


def scaled_jacobian(x: np.ndarray) -> np.ndarray:
    """Least corner determinant over the product of its edges, times 2 / sqrt(3); 1 is the ideal wedge."""
    return solid.scaled(solid.frames(_KIND, x)).min(axis=1) / _IDEAL


def shape(x: np.ndarray) -> np.ndarray:
    """Least mean ratio of the corners: 1 is the ideal wedge, 0 has a folded corner."""
    return np.minimum(solid.mean_ratio(solid.frames(_KIND, x), _IDEAL).min(axis=1), 1.0)


MEASURES = {
    "condition": Measure(max_aspect_frobenius, (1, 4)),
    "distortion": Measure(distortion, (0.5, 1)),
    "jacobian": Measure(jacobian, (0, np.inf), "volume"),
    "max_aspect_frobenius": Measure(max_aspect_frobenius, (1, 3)),
    "scaled_jacobian": Measure(scaled_jacobian, (0.5, 2 / np.sqrt(3))),
    "shape": Measure(shape, (0.3, 1)),
    "volume": Measure(volume, (0, np.inf), "volume"),
}
