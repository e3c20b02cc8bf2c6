"""Surface grids put on surfaces of facets, such as scans, and checked there."""

from __future__ import annotations

import numpy as np

from ...geometry.closest import FacetedSurface
from ...mesh import StructuredGrid
from ..folds import refuse_folds
from ..poisson.surface_levels import folded_against

CURE = (
    "move the grid's corners to where the boundary turns by less than 180 degrees, ask for less control, give more "
    "cells, or split the patch where the surface has a sharp ridge"
)
_OFF = 0.4
"""Distance of the middle of a cell or edge from a surface of facets, in its size, that is told: half across a wall."""


def folded_on(surface: FacetedSurface, points: np.ndarray) -> np.ndarray:
    """(ni - 1, nj - 1) bool: folded cells of (ni, nj, 3) points on a surface, seen from the side that shows most.

    Examples
    --------
    >>> from meshcore import Mesh
    >>> roof = FacetedSurface(Mesh([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], {"quad": [[0, 1, 2, 3]]}))
    >>> x, y = np.meshgrid([0.0, 1, 2], [0.0, 1], indexing="ij")
    >>> folded_on(roof, np.stack([x, y, 0 * x], axis=-1)).ravel()
    array([False, False])
    """
    normals = surface.closest(points.reshape(-1, 3)).normals
    return min((folded_against(points, sign * normals) for sign in (1, -1)), key=np.count_nonzero)


def checked_on(surface: FacetedSurface, grid: StructuredGrid, cure: str) -> list[str]:
    """What to tell of a grid on a surface of facets: cells that bridge a gap or a ridge.

    Parameters
    ----------
    surface : FacetedSurface
        On which the grid's points lie.
    grid : StructuredGrid
        A surface grid.
    cure : str
        What can be done about folds.

    Raises
    ------
    GenerationFailed
        If cells are folded, seen from the surface; `cells` are these, `partial` the grid.
    """
    points = grid.points[:, :, 0]
    refuse_folds(grid, cure, folded_on(surface, points))
    middle, off = _off(surface, points)
    if not off.any():
        return []
    i, j = np.argwhere(off)[0]
    x, y, z = middle[i, j]
    return [
        f"{off.sum()} cells leave the surface by more than {_OFF:g} of their size, the first at i = {i}, j = {j} near "
        f"({x:.6g}, {y:.6g}, {z:.6g}): they cut off a sharp ridge or cross from one sheet to another; give more cells, "
        "or split the patch there"
    ]


def _off(surface: FacetedSurface, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The cells' middles; and which cells leave a surface, there or in the middle of an edge: long ones may by that."""
    middle = 0.25 * (points[:-1, :-1] + points[1:, :-1] + points[1:, 1:] + points[:-1, 1:])
    diagonals = points[1:, 1:] - points[:-1, :-1], points[1:, :-1] - points[:-1, 1:]
    off = _away(surface, middle, np.maximum(*(np.linalg.norm(diagonal, axis=-1) for diagonal in diagonals)))
    along, across = (
        _away(surface, 0.5 * (low + high), np.linalg.norm(high - low, axis=-1))
        for low, high in ((points[:-1], points[1:]), (points[:, :-1], points[:, 1:]))
    )
    return middle, off | along[:, 1:] | along[:, :-1] | across[1:] | across[:-1]


def _away(surface: FacetedSurface, points: np.ndarray, size: np.ndarray) -> np.ndarray:
    return surface.closest(points.reshape(-1, 3)).distance.reshape(size.shape) > _OFF * size


def put_on(surface: FacetedSurface, grid: StructuredGrid, gap: float, what: str) -> tuple[StructuredGrid, list[str]]:
    """A grid with all points on a surface of facets, and a warning if its sides were farther away than a gap.

    Examples
    --------
    >>> from meshcore import Mesh
    >>> roof = FacetedSurface(Mesh([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], {"quad": [[0, 1, 2, 3]]}))
    >>> x, y = np.meshgrid([0.0, 1, 2], [0.0, 1], indexing="ij")
    >>> put_on(roof, StructuredGrid(np.stack([x, y, 0.25 + 0 * x], axis=-1)), 0.0, "the sides")[1]
    ['the sides lay up to 0.25 off the surface and were put on it']
    """
    points = grid.points.reshape(-1, 3)
    foot = surface.dropped(points)
    new = foot.points.reshape(grid.points.shape)
    away = foot.distance.reshape(grid.shape[:2])
    far = max(away[0].max(), away[-1].max(), away[:, 0].max(), away[:, -1].max())
    told = [f"{what} lay up to {far:.4g} off the surface and were put on it"] if far > gap else []
    return grid.with_points(new), told
