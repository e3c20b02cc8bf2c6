"""Grids round sections by the elliptic equations: walls held where they can be, layers that stay where they cannot."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ...errors import GenerationFailed, InvalidGeometry
from ...mesh import StructuredGrid
from ...progress import Progress
from ...report import Report
from ..folds import folded_cells, refuse_folds
from ..poisson.elliptic_problem import Asked, solved
from ..poisson.wall_control import ANGLE_WITHIN, HEIGHT_WITHIN, RESIDUAL_WITHIN, Wall
from .first_heights import with_first_heights
from .section_walls import first_heights, wall_of

ANGLES = "error of wall angles (degree)"
_HOPELESS = 0.02
"""Share of folded cells from which on they are not unfolded one by one."""
_HEIGHTS = 0.1
"""Error of first heights that is left to points moving along their lines."""
_DEEPER, _FEWEST = (1.0, 4.0), 8
"""Heights, in edges of the wall, of layers that stay where the wall cannot be held, and the fewest layers beyond."""


def smoothed(
    grid: StructuredGrid, wall: Wall | None, cure: str, progress: Progress
) -> tuple[StructuredGrid, Report | None, list[str]]:
    """A grid by the elliptic equations, its wall held if it can be.

    Parameters
    ----------
    grid : StructuredGrid
        The start.
    wall : Wall, optional
        It is held, after a first smoothing if the start has folded cells. If it cannot be held everywhere layers of the
        start stay, and what is beyond is smoothed: at the angles at which lines leave these layers, or, if those cannot
        be held, either, at any. If that folds cells, too, the start stays, or, if that is folded, the first smoothing,
        whose wall is free.
    cure : str
        What to do about folded cells.
    progress : Progress
        Called with fraction and message.

    Returns
    -------
    StructuredGrid
        The start if the equations fold it.
    Report or None
        None if it is the start.
    list of str
        What had to be done.
    """
    free = None
    if wall is None or folded_cells(grid.points[:, :, 0]).any():
        free = _solved(grid, [], progress, control="boundary spacing")
        if wall is None or free is None:
            return _or_start(grid, free, cure)
        lines = with_first_heights(free[0].points[:, :, 0], wall.first_height)
        grid = grid.with_points(lines[:, :, None])
    deeper, made = _deeper(grid), []
    for stay, left in [(0, False), *((stay, left) for left in (False, True) for stay in deeper)]:
        if (found := _held(grid, wall, stay, progress, free=left)) is not None:
            made.append(found)
            if found[0] == (0.0, False):
                break
    if made:
        return min(made, key=lambda found: found[0])[1:]
    found, report, warnings = _or_start(grid, free, cure)
    told = "angles and heights at the wall could not be held without folding cells; left free"
    return found, report, warnings if report is None else [told, *warnings]


def _or_start(
    grid: StructuredGrid, made: tuple[StructuredGrid, Report] | None, cure: str
) -> tuple[StructuredGrid, Report | None, list[str]]:
    """What the equations made, or the start, if that is not folded, too."""
    if made is not None:
        return *made, list(made[1].warnings)
    refuse_folds(grid, cure)  # or if its boundary crosses itself, of which only the section is the user's
    return grid, None, ["the elliptic equations folded cells; the grid stays as it was"]


def _deeper(grid: StructuredGrid) -> list[int]:
    """Numbers of layers after which the mean height is that of the wall's edges, and several times that."""
    points = grid.points[:, :, 0]
    edge = float(np.median(np.linalg.norm(np.diff(points[:, 0], axis=0), axis=-1)))
    height = np.linalg.norm(np.diff(points, axis=1), axis=-1).mean(axis=0).cumsum()
    layers = np.searchsorted(height, edge * np.array(_DEEPER)) + 1
    return [int(n) for n in np.unique(layers) if n <= len(height) - _FEWEST]


def _held(
    grid: StructuredGrid, wall: Wall, stay: int, progress: Progress, *, free: bool = False
) -> tuple[tuple[float, bool], StructuredGrid, Report, list[str]] | None:
    """What the wall misses, the grid smoothed beyond layers that stay, and its report; None if it folds.

    The last layer that stays is the wall there, and is held, or left ``free`` but for first heights. Missed is the
    share of first heights that are wrong, and whether the control has not converged.
    """
    limits = {"control": "grid spacing", "shares": (1.0,), "give_up": _HOPELESS}
    outside = grid if stay == 0 else replace(grid, points=grid.points[:, stay:], cuts=())
    own = wall if stay == 0 else wall_of(outside, np.ones(len(grid.points)))
    if (made := _solved(outside, [] if free else [own], progress, **limits)) is None:
        return None
    found, report = made
    lines = with_first_heights(found.points[:, :, 0], own.first_height)
    found = grid.with_points(np.concatenate([grid.points[:, :stay], lines[:, :, None]], axis=1))
    wrong = np.abs(first_heights(found, 0) / wall.first_height - 1) > HEIGHT_WITHIN
    if not free and not wrong.any():
        report = _with_heights_met(report)
    missed = float(wrong.mean()), not report.converged
    if stay == 0:
        return missed, found, report, list(report.warnings)
    told = f"the wall could not be held everywhere; {stay} layers on it stay as they were"
    warnings = [told, *(f"beyond them {text}" for text in report.warnings)]
    return missed, found, replace(report, quality={}), warnings  # whose quality is not the wall's


def _with_heights_met(report: Report) -> Report:
    """What is to be told of smoothing that came near to angles, but not to heights, which points on lines now have."""
    if report.converged or report.quality[ANGLES] >= ANGLE_WITHIN or report.residual >= RESIDUAL_WITHIN:
        return report
    warnings = [text for text in report.warnings if not text.startswith("walls not controlled")]
    return replace(report, converged=True, warnings=warnings)


def _solved(
    grid: StructuredGrid, walls: list[Wall], progress: Progress, **limits: Any
) -> tuple[StructuredGrid, Report] | None:
    """The elliptic grid and its report; None if it folds."""
    try:
        return solved(grid, Asked(walls=walls, height_aim=_HEIGHTS, **limits), progress)
    except (GenerationFailed, InvalidGeometry):
        return None
