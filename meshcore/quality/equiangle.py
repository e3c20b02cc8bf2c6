"""Verdict's equiangle skew: how far the angles of a cell, or of its faces, are from those of the regular polygon."""

from __future__ import annotations

from functools import partial

import numpy as np

from ..mesh import CELL_TYPES
from . import quad, tetra, triangle
from .measure_table import Measure
from .vectors import chosen

_POLYGONS = {3: (60.0, triangle.MEASURES), 4: (90.0, quad.MEASURES)}
"""Corners -> angle of the regular polygon, and the measures of the polygon."""
_DIHEDRAL = np.degrees(np.arccos(1 / 3))


def equiangle_skew(kind: str, x: np.ndarray) -> np.ndarray:
    """Largest departure of a face's angle from the regular one, over the largest possible; 0 is regular, 1 flat.

    Of tetrahedra the dihedral angles count, too.

    Parameters
    ----------
    kind : str
        Kind of cell.
    x : (m, k, 3) float
        Corners of the cells.

    Examples
    --------
    >>> square = [[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    >>> equiangle_skew("quad", np.array([square])).tolist()
    [0.0]
    """
    cell = CELL_TYPES[kind]
    faces = cell.facets if cell.dimension == 3 else (tuple(range(cell.nodes)),)
    skew = np.zeros(len(x))
    for face in faces:
        right, measures = _POLYGONS[len(face)]
        polygon = chosen(x, face)
        smallest, largest = (measures[name].function(polygon) for name in ("min_angle", "max_angle"))
        skew = np.maximum(skew, _departure(smallest, largest, right))
    if kind == "tetra":
        angles = tetra.dihedral_angles(x)
        skew = np.maximum(skew, _departure(angles.min(axis=1), angles.max(axis=1), _DIHEDRAL))
    return skew


def _departure(smallest: np.ndarray, largest: np.ndarray, regular: float) -> np.ndarray:
    return np.maximum((regular - smallest) / regular, (largest - regular) / (180 - regular))


def measure_of(kind: str) -> Measure:
    """The measure for one kind of cell, with the survey's limit of skewness, 45 of 90 degrees (section 2.2).

    Examples
    --------
    >>> measure_of("quad").acceptable
    (0, 0.5)
    """
    return Measure(partial(equiangle_skew, kind), (0, 0.5))
