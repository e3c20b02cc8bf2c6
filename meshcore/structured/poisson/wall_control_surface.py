"""Angle and first height of cells at walls of grids on curved surfaces, by control functions found while solving.

As in the plane, with the limits of `wall_control`: for each wall, the strip of cells along it is laid in a plane, with
the angles that edges make in the tangent planes of the surface, and measured there.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...progress import Progress, advance, silent
from .multigrid import GROWTH, ROUNDING, Outcome, cycle, first_level, full_multigrid
from .surface_levels import OnSurface, set_growth
from .wall_control import (
    ANGLE_WITHIN,
    HEIGHT_WITHIN,
    MOST_STEPS,
    PATIENCE,
    RESIDUAL_WITHIN,
    Measured,
    Wall,
    WallAmplitudes,
    from_wall,
    judged,
    limited,
    measured,
)
from .wall_outcome import Controlled

FEWEST_CELLS = 16
"""Cells that a direction keeps on all levels: coarser ones cannot hold a control function that falls off in a few."""
_OVERLAP = 8  # nodes that a closed wall is developed beyond its ends
_SWEEPS = 3  # of lines both ways: with control functions that move, two let cycles swing around waists
_MORE, _LESS, _LEAST = 1.2, 0.5, 0.1  # factors of the part of corrections that is taken, and how little that may be


def developed(points: np.ndarray, normals: np.ndarray, side: str, closed: bool = False) -> np.ndarray:
    """The strip of a grid along a side, laid in a plane, the wall's direction kept and the grid to its left.

    Lengths of the wall's edges and of the first edges of lines are kept, and angles between them as the tangent planes
    have them; farther nodes stand on straight lines, at their distance along the line.

    Parameters
    ----------
    points : (ni, nj, 3) float
        A grid on a surface.
    normals : (ni, nj, 3) float
        The surface's normals, of either sign.
    side : str
        "south", "east", "north" or "west".
    closed : bool
        Whether the side's last node is its first; the strip then overlaps itself by 8 nodes at both ends.

    Returns
    -------
    (2, n, m) float
        Along the side, and away from it.

    Examples
    --------
    >>> angle, height = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 2, 3), indexing="ij")
    >>> normals = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1)
    >>> cylinder = 10 * normals + height[..., None] * [0, 0, 1]
    >>> developed(cylinder, normals, "south")[:, -1, -1].round(2)
    array([9.97, 2.  ])
    """
    rows = np.moveaxis(from_wall(np.moveaxis(points, -1, 0), side), 0, -1)
    normal = np.moveaxis(from_wall(np.moveaxis(normals, -1, 0), side), 0, -1)[:, 0]
    if closed:
        around = np.arange(-_OVERLAP, len(rows) + _OVERLAP) % (len(rows) - 1)
        rows, normal = rows[around], normal[around]
    ahead = np.diff(rows[:, 0], axis=0)
    ahead = np.concatenate([ahead, ahead[-1:]])
    edge = rows[:, 1] - rows[:, 0]
    if (np.cross(normal, ahead) * edge).sum() < 0:
        normal = -normal
    turn = _angle(normal[1:-1], ahead[:-2], ahead[1:-1])
    heading = np.concatenate([[0.0], np.cumsum(turn)])
    heading = np.concatenate([heading, heading[-1:]])
    step = np.linalg.norm(ahead[:-1], axis=1)
    wall = np.zeros((2, len(rows)))
    wall[:, 1:] = np.cumsum(step * np.stack([np.cos(heading[:-1]), np.sin(heading[:-1])]), axis=1)
    leaving = heading + _angle(normal, ahead, edge)
    away = np.zeros(rows.shape[:2])
    np.cumsum(np.linalg.norm(np.diff(rows, axis=1), axis=-1), axis=1, out=away[:, 1:])
    return wall[:, :, None] + away * np.stack([np.cos(leaving), np.sin(leaving)])[:, :, None]


def _angle(normal: np.ndarray, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Signed angles between vectors, seen against the normals."""
    across = (normal * np.cross(one, other)).sum(axis=-1)
    along = (one * other).sum(axis=-1) - (one * normal).sum(axis=-1) * (other * normal).sum(axis=-1)
    return np.arctan2(across, along)


class _Control(WallAmplitudes):
    """Of a wall on a surface, which is measured in a plane that the surface beside it is laid out in."""

    def found(self, points: np.ndarray, normals: np.ndarray) -> tuple[Measured, np.ndarray]:
        """What the wall has, and the distances of nodes from it along lines."""
        flat = developed(points, normals, self.wall.side, self.closed)
        have = measured(flat, "south", 1.0, False)
        distance = np.linalg.norm(flat - flat[:, :, :1], axis=0)
        if self.closed:
            inner = slice(_OVERLAP, -_OVERLAP)
            have = Measured(have.angle[inner], have.height[inner], have.spacing[inner], have.counts[inner])
            distance = distance[inner]
        return have, distance


def controlled(
    levels: list[OnSurface], walls: list[Wall], growth: np.ndarray, *, progress: Progress = silent
) -> Controlled:
    """Solve on the finest of ``levels`` with control functions ``growth`` and those that the walls come to need."""
    finest, outcome = levels[0], Outcome()
    for level in levels:
        level.sweeps = _SWEEPS
    unit = max(finest.residual(), ROUNDING / RESIDUAL_WITHIN)
    set_growth(levels, growth)
    full_multigrid(levels, first_level(levels, 2 * FEWEST_CELLS), outcome)
    controls = [_Control.of(wall, growth.shape[1:], finest.cyclic, walls) for wall in walls]
    cycles = _Cycles(levels, outcome)
    residuals, worst = [unit, finest.residual()], []
    for step in range(MOST_STEPS):
        points, normals = finest.points_and_normals()
        found = [control.found(points, normals) for control in controls]
        went = judged(walls, [have for have, _ in found])
        converged = went.converged and residuals[-1] < RESIDUAL_WITHIN * unit
        worst.append(went.angle / ANGLE_WITHIN + went.height / HEIGHT_WITHIN)
        if converged or (len(worst) > PATIENCE and min(worst[-PATIENCE:]) > 0.98 * min(worst[:-PATIENCE])):
            break
        theta = growth.copy()
        for control, (have, distance) in zip(controls, found, strict=True):
            control.step(have, first=step == 0)
            control.add(theta, have, distance)
        set_growth(levels, limited(theta))
        if step == 0:  # where the start solves the equations there is nothing to measure by but this
            unit = residuals[0] = max(unit, finest.residual())
        residuals.append(cycles.once())
        advance(progress, step / MOST_STEPS, f"angle within {went.angle:.2g} degrees, height within {went.height:.1%}")
    return replace(went, history=tuple(residual / unit for residual in residuals), converged=converged)


class _Cycles:
    """Cycles that take a smaller part of coarse corrections while these make matters worse, and more again later."""

    def __init__(self, levels: list[OnSurface], outcome: Outcome):
        self._levels, self._outcome, self._part = levels, outcome, 1.0

    def once(self) -> float:
        """A cycle, or relaxation alone where it would make matters much worse; the residual."""
        finest = self._levels[0]
        before, residual = finest.x.copy(), finest.residual()
        cycle(self._levels, 0, self._outcome, self._part)
        reached = finest.residual()
        self._part = min(1.0, _MORE * self._part) if reached < residual else max(_LEAST, _LESS * self._part)
        if not reached <= GROWTH * residual:
            finest.x[...] = before
            for sweep in range(2):
                finest.smooth(back=bool(sweep % 2))
            reached = finest.residual()
        return reached
