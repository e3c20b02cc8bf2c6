"""Elliptic grids on curved surfaces, checked: on that through a grid's own points, or on one of facets (survey 2.6)."""

from __future__ import annotations

import numpy as np

from ..errors import InvalidGeometry, InvalidInput
from ..geometry.closest import FacetedSurface
from ..geometry.plane import fitted_plane
from ..mesh import StructuredGrid
from ..progress import Progress, silent
from ..report import Result
from . import elliptic_problem
from .control_functions import from_poles
from .elliptic_problem import SHARES, Asked, Found, as_found, reported
from .folds import folded_cells, refuse_folds
from .surface_levels import folded_against
from .winslow_surface import draped, smoothed

_CURE = (
    "a grid cannot be unfolded on the surface through its own points; move its corners to where the boundary turns by "
    "less than 180 degrees, ask for less control, or give the surface on which it lies"
)
_CURE_ON_FACETS = (
    "move the grid's corners to where the boundary turns by less than 180 degrees, ask for less control, give more "
    "cells, or split the patch where the surface has a sharp ridge"
)
_OFF = 0.4
"""Distance of a cell's middle from a surface of facets, in cell sizes, from which on it is told: half across a wall."""


def solved(
    start: StructuredGrid, asked: Asked, surface: FacetedSurface | None = None, progress: Progress = silent
) -> Result:
    """The elliptic grid with the boundary of a given one: in its plane, or on its own or a given surface; checked.

    Parameters
    ----------
    start : StructuredGrid
        A surface grid; with a surface given, its points lie on it.
    asked : Asked
        What it shall be like.
    surface : FacetedSurface, optional
        On which the points stay.
    progress : Progress, optional
        Called with fraction and message.
    """
    if surface is None and _is_planar(start):
        return elliptic_problem.solved(start, asked, progress)
    _refuse_what_is_planar(asked)
    points, cyclic = start.points[:, :, 0], start.periodic[0]
    warnings = []
    transposed = start.periodic[1] and not cyclic
    if start.periodic[0] and start.periodic[1]:
        warnings.append("the grid is closed both ways: its line j = 0 is kept, else nothing would hold it")
    if transposed:
        points, asked, cyclic = np.ascontiguousarray(points.swapaxes(0, 1)), asked.transposed(), True
    found = _curved(points, cyclic, asked, surface, progress)
    grid = start.with_points(found.points.swapaxes(0, 1) if transposed else found.points)
    found.warnings[:0] = warnings
    if surface is None:
        refuse_folds(grid, _CURE)
    else:
        found.warnings += checked_on(surface, grid, _CURE_ON_FACETS)
    return reported(grid, found)


def _is_planar(grid: StructuredGrid) -> bool:
    try:
        fitted_plane(grid.points)
    except InvalidGeometry:
        return False
    return True


def _refuse_what_is_planar(asked: Asked) -> None:
    for parameter, given, what in (
        ("equation", asked.equation != "Poisson", 'the biharmonic equation is for planar grids; choose "Poisson"'),
        ("walls", bool(asked.walls), "angles and heights at walls are controlled in planar grids only; leave them out"),
        ("periodic", asked.periodic, "passages that repeat are planar; close the grid around an axis instead"),
    ):
        if given:
            raise InvalidInput(f"{what}, or flatten the grid", parameter=parameter)


def _curved(
    points: np.ndarray, cyclic: bool, asked: Asked, surface: FacetedSurface | None, progress: Progress
) -> Found:
    """Solve; with less control as long as that leaves no sound grid."""
    if min(points.shape[:2]) < 3:
        return Found(points, [0.0], True)
    controls = asked.growth(points, cyclic)
    # Control from the boundary's spacing knows of poles by itself.
    poles = None if asked.control == "boundary spacing" else from_poles(points)
    for share in SHARES if controls is not None else (1.0,):
        parts = [part for part in (None if controls is None else share * controls, poles) if part is not None]
        found = _once(points, sum(parts) if parts else None, cyclic, asked, surface, progress)
        folded = folded_cells(found.points) if surface is None else _folded_on(surface, found.points)
        if not (found.stalled or folded.any()):
            break
    if share < 1:
        found.warnings.append(f"control functions were too strong for a sound grid and were reduced to {share:.0%}")
    if poles is not None:
        found.warnings.append("a side is one point: a control function spreads the lines around it evenly")
    return found


def _once(points, growth, cyclic: bool, asked: Asked, surface: FacetedSurface | None, progress: Progress) -> Found:
    how = {
        "growth": growth,
        "cyclic": cyclic,
        "tolerance": asked.residual,
        "most": asked.most_cycles,
        "progress": progress,
    }
    new, outcome = smoothed(points, **how) if surface is None else draped(surface, points, **how)
    history = [residual / (outcome.residuals[0] or 1.0) for residual in outcome.residuals]
    return as_found(new, history, outcome.converged, outcome.error, asked)


def _folded_on(surface: FacetedSurface, points: np.ndarray) -> np.ndarray:
    """(ni - 1, nj - 1) bool: folded cells of a grid on a surface, seen from the side that shows most of it."""
    normals = surface.closest(points.reshape(-1, 3)).normals
    return min((folded_against(points, sign * normals) for sign in (1, -1)), key=np.count_nonzero)


def checked_on(surface: FacetedSurface, grid: StructuredGrid, cure: str) -> list[str]:
    """What to tell of a grid on a surface of facets: cells that bridge a gap or a ridge.

    Raises
    ------
    GenerationFailed
        If cells are folded, seen from the surface; `cells` are these, `partial` the grid.
    """
    points = grid.points[:, :, 0]
    refuse_folds(grid, cure, _folded_on(surface, points))
    middle = 0.25 * (points[:-1, :-1] + points[1:, :-1] + points[1:, 1:] + points[:-1, 1:])
    diagonals = points[1:, 1:] - points[:-1, :-1], points[1:, :-1] - points[:-1, 1:]
    size = np.maximum(*(np.linalg.norm(diagonal, axis=-1) for diagonal in diagonals))
    off = surface.closest(middle.reshape(-1, 3)).distance.reshape(size.shape) > _OFF * size
    if not off.any():
        return []
    i, j = np.argwhere(off)[0]
    x, y, z = middle[i, j]
    return [
        f"{off.sum()} cells leave the surface by more than {_OFF:g} of their size, the first at i = {i}, j = {j} near "
        f"({x:.6g}, {y:.6g}, {z:.6g}): they cut off a sharp ridge or cross from one sheet to another; give more cells, "
        "or split the patch there"
    ]


def put_on(surface: FacetedSurface, grid: StructuredGrid, gap: float, what: str) -> tuple[StructuredGrid, list[str]]:
    """A grid with all points on a surface of facets, and a warning if its sides were farther away than a gap."""
    points = grid.points.reshape(-1, 3)
    foot = surface.closest(points)
    new = foot.points.reshape(grid.points.shape)
    away = foot.distance.reshape(grid.shape[:2])
    far = max(away[0].max(), away[-1].max(), away[:, 0].max(), away[:, -1].max())
    told = [f"{what} lay up to {far:.4g} off the surface and were put on it"] if far > gap else []
    return grid.with_points(new), told
