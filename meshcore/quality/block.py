"""Structured volumes whose cells are all sound: told, and summed up, without a mesh of their cells."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..mesh import StructuredGrid
from . import _block_kernels as kernels

_EXTREME = 1e75
"""Coordinates and their inverse beyond which products of nine of them would over- or underflow."""


def sound_summary(grid: Any) -> dict[str, float] | None:
    """Mean shape and worst scaled Jacobian of a structured volume, by one pass over its points.

    None for other things, and where a corner's determinant is not positive or numbers are extreme: those are for
    the measures of a mesh of its cells, which tell more, and take a hundred times as long.

    Examples
    --------
    >>> x, y, z = np.meshgrid([0.0, 1], [0.0, 1], [0.0, 1], indexing="ij")
    >>> sound_summary(StructuredGrid(np.stack([x, y, z], axis=-1)))
    {'mean shape': 1.0, 'worst scaled jacobian': 1.0}
    """
    if not isinstance(grid, StructuredGrid) or grid.is_surface:
        return None
    found = np.zeros(3)
    kernels.summarise(grid.points, np.empty((3, 4, 3)), found)
    least, worst, shapes = (float(value) for value in found)
    if not least > _EXTREME**-3 or not grid.diagonal < _EXTREME ** (1 / 3) or not np.isfinite(found).all():
        return None
    return {"mean shape": shapes / grid.n_cells, "worst scaled jacobian": worst}
