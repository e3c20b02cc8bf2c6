"""Elliptic grids on curved surfaces, checked: on that through a grid's own points, or on one of facets (survey 2.6)."""

from __future__ import annotations

import numpy as np

from ...errors import InvalidGeometry, InvalidInput
from ...geometry.closest import FacetedSurface
from ...geometry.plane import fitted_plane
from ...geometry.surfaces import SplineSurface
from ...mesh import StructuredGrid
from ...progress import Progress, silent
from ...report import Result
from ..algebraic.on_facets import CURE, checked_on, folded_on
from ..folds import folded_cells, refuse_folds
from . import elliptic_problem
from .control_functions import from_poles, poles
from .elliptic_problem import SHARES, Asked, Found, as_found, reported, without_inside
from .wall_checks import refuse_wall
from .wall_control import ANGLE_WITHIN, HEIGHT_WITHIN
from .winslow import CUT
from .winslow_surface import draped, on_own_surface, smoothed, walled

_CURE = (
    "a grid cannot be unfolded on the surface through its own points; move its corners to where the boundary turns by "
    "less than 180 degrees, ask for less control, or give the surface on which it lies"
)


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
    if cyclic and len(poles(points)) == 2:
        warnings.append("the grid has two poles and no other boundary: the line of its cut is kept, else it might turn")
        cyclic = False
    found = _curved(points, cyclic, asked, surface, progress)
    grid = start.with_points(found.points.swapaxes(0, 1) if transposed else found.points)
    found.warnings[:0] = warnings
    if surface is None:
        refuse_folds(grid, _CURE)
    else:
        found.warnings += checked_on(surface, grid, CURE)
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
        (
            "sliding",
            any(wall.slides for wall in asked.walls),
            "points slide along walls of planar grids only; leave it out",
        ),
        ("periodic", asked.periodic, "passages that repeat are planar; close the grid around an axis instead"),
    ):
        if given:
            raise InvalidInput(f"{what}, or flatten the grid", parameter=parameter)


def _curved(
    points: np.ndarray, cyclic: bool, asked: Asked, surface: FacetedSurface | None, progress: Progress
) -> Found:
    """Solve; with less control as long as that leaves no sound grid."""
    if min(points.shape[:2]) < 3:
        return without_inside(points, asked)
    _refuse_walls(points, cyclic, asked)
    controls = asked.growth(points, cyclic)
    # Control from the boundary's spacing knows of poles by itself.
    around_poles = None if asked.control == "boundary spacing" else from_poles(points)
    for share in SHARES if controls is not None else (1.0,):
        parts = [part for part in (None if controls is None else share * controls, around_poles) if part is not None]
        found = _once(points, sum(parts) if parts else None, cyclic, asked, surface, progress)
        folded = folded_cells(found.points) if surface is None else folded_on(surface, found.points)
        if not (found.stalled or folded.any()):
            break
    if share < 1:
        found.warnings.append(f"control functions were too strong for a sound grid and were reduced to {share:.0%}")
    if around_poles is not None:
        found.warnings.append("a side is one point: a control function spreads the lines around it evenly")
    return found


def _once(points, growth, cyclic: bool, asked: Asked, surface: FacetedSurface | None, progress: Progress) -> Found:
    if asked.walls:
        return _with_walls(points, growth, cyclic, asked, surface, progress)
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


def _refuse_walls(points: np.ndarray, cyclic: bool, asked: Asked) -> None:
    """Refuse walls where there is nothing that lines could leave."""
    ends = {"south": (1, 0), "east": (0, -1), "north": (1, -1), "west": (0, 0)}
    for wall in asked.walls:
        if cyclic and wall.side in CUT:
            raise InvalidInput(f"{wall.side} is where the closed grid is cut, not a wall", parameter="walls")
        if ends[wall.side] in poles(points):
            raise InvalidInput(f"{wall.side} is one point, at which lines make no angle", parameter="walls")
        refuse_wall(points, wall)


def _with_walls(points, growth, cyclic: bool, asked: Asked, surface: FacetedSurface | None, progress) -> Found:
    if surface is not None:
        new, went = walled(surface, points, list(asked.walls), growth, cyclic=cyclic, progress=progress)
    else:
        own = SplineSurface(points, cyclic=cyclic)
        found, went = walled(own, own.parameters, list(asked.walls), growth, cyclic=cyclic, progress=progress)
        new = on_own_surface(own, found, points, cyclic)
    warnings = went.warnings
    if warnings and went.angle < ANGLE_WITHIN and went.height < HEIGHT_WITHIN:
        warnings = [
            f"walls are as asked, but the grid inside is not settled after {len(went.history) - 2} steps: the residual "
            f"is {went.history[-1]:.2g} of the start's"
        ]
    return Found(new, went.history, went.converged, warnings, went.quality)
