"""Structured grids whose cells are all sound: told, and summed up, without a mesh of their cells."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..mesh import StructuredGrid
from . import _block_kernels as kernels
from . import _surface_kernels as surface_kernels

_EXTREME = 1e75
"""Coordinates and their inverse beyond which products of nine of them would over- or underflow."""


def is_sound(grid: Any) -> bool:
    """Whether all cells of a structured grid are surely positively oriented, by one pass over its points.

    False for other things, and where there is doubt: a corner is flat but for rounding, numbers are extreme, or cells
    of a surface look to different sides, as they may on a curved one. Those are for the measures of a mesh of its
    cells, which tell more, and take many times as long.

    Examples
    --------
    >>> x, y = np.meshgrid([0.0, 1, 2], [0.0, 1], indexing="ij")
    >>> grid = StructuredGrid(np.stack([x, y], axis=-1))
    >>> is_sound(grid), is_sound(grid.reversed_along_i())
    (True, False)
    """
    if not isinstance(grid, StructuredGrid):
        return False
    if not grid.is_surface:
        return kernels.least_determinant(grid.points) > _EXTREME**-3 and grid.diagonal < _EXTREME ** (1 / 3)
    found = _pass_over_surface(grid)
    # The plane z = 0 has an upper side, any other is seen from the side that its cells look to.
    turned_over = found is not None and found[surface_kernels.NORMAL_Z] < 0 and not grid.points[..., 2].any()
    return found is not None and bool(found[surface_kernels.SIDE] > 0) and not turned_over


def sound_summary(grid: Any) -> dict[str, float] | None:
    """What `summary` says of a structured grid, by one pass over its points.

    None for other things, and where a corner is flat or turned over, or numbers are extreme.

    Examples
    --------
    >>> x, y, z = np.meshgrid([0.0, 1], [0.0, 1], [0.0, 1], indexing="ij")
    >>> sound_summary(StructuredGrid(np.stack([x, y, z], axis=-1)))
    {'mean shape': 1.0, 'worst scaled jacobian': 1.0}
    """
    if not isinstance(grid, StructuredGrid):
        return None
    return _of_surface(grid) if grid.is_surface else _of_volume(grid)


def _of_volume(grid: StructuredGrid) -> dict[str, float] | None:
    found = np.zeros(3)
    kernels.summarise(grid.points, np.empty((3, 4, 3)), found)
    least, worst, shapes = (float(value) for value in found)
    if not least > _EXTREME**-3 or not grid.diagonal < _EXTREME ** (1 / 3) or not np.isfinite(found).all():
        return None
    return {"mean shape": shapes / grid.n_cells, "worst scaled jacobian": worst}


def _of_surface(grid: StructuredGrid) -> dict[str, float] | None:
    found = _pass_over_surface(grid)
    if found is None:
        return None
    return {
        "smallest angle (degree)": float(found[surface_kernels.SMALLEST_ANGLE]),
        "largest angle (degree)": float(found[surface_kernels.LARGEST_ANGLE]),
        "mean radius ratio": float(found[surface_kernels.SUM_OF_RADIUS_RATIOS]) / grid.n_cells,
        "worst scaled jacobian": float(found[surface_kernels.WORST_JACOBIAN]),
    }


def _pass_over_surface(grid: StructuredGrid) -> np.ndarray | None:
    found = np.zeros(surface_kernels.SUMMARY_SIZE)
    return found if surface_kernels.summarise(grid.points[:, :, 0], found) else None
