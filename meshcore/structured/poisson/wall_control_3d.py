"""Angle and first height of cells at faces of a block, by control functions that are found while it is solved.

As in the plane (`wall_control`, where the papers stand), with two leans instead of one: a face has a control function
across it, for the height, and one along each of its lines, so that lines come to leave it along its normal.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...progress import Progress, advance, silent
from ..algebraic.block_faces import across
from .face_measures import Closed, FaceMeasures, axis_of, from_face, measured
from .multigrid import COARSEST_SWEEPS, GROWTH, Level, Outcome, cycle, first_level, full_multigrid
from .sliding_faces import FaceSlide
from .wall_control import (
    ANGLE_WITHIN,
    GROWTH_REACH,
    HEIGHT_WITHIN,
    LEAN_REACH,
    MOST_STEPS,
    PATIENCE,
    RESIDUAL_WITHIN,
    ROUNDING,
    Wall,
    height_step,
    lean_step,
    limited,
    what_is_asked,
)
from .wall_outcome import Controlled
from .winslow_3d import FIRST_CELLS, set_growth

LEAST_CELLS = 16
"""Cells that a direction keeps on all levels: coarser ones cannot hold a control function that falls off in a few."""
LARGEST_IN_SPACE = 2.5
"""Where faces meet at acute angles, as in twisted blocks, lines turn too far for Sorenson's limit of 1.5."""
_NEGLIGIBLE = 40.0  # of exp(-x)


class _Control:
    """The state of one wall's control: amplitudes t across and u along it, over its nodes."""

    def __init__(self, wall: Wall, level: Level, facing_another: bool, start: FaceMeasures):
        shape, closed = level.nodes.shape[1:], _runs_on(level, wall)
        self._is_wall = level.ghosts.wall(wall.side)
        self.wall, self._axis = wall, axis_of(wall.side)
        self._along = across(wall.side)
        nodes = tuple(shape[axis] for axis in self._along)
        cells = shape[self._axis] - 1
        self._fall = GROWTH_REACH / (cells / 2 if facing_another else cells)
        self._growth, self._lean = np.zeros(nodes), np.zeros((2, *nodes))
        self._outwards = -1.0 if wall.side.endswith("max") else 1.0
        self._angle = None if wall.angle is None else _both(wall.angle)
        self._slide: FaceSlide | None = None
        if self._angle is not None and wall.lean_at_edges:
            self._angle = start.eased(self._angle, tuple(closed[axis] for axis in self._along))

    def step(self, x: np.ndarray, found: FaceMeasures, *, first: bool) -> None:
        """Move the amplitudes, or the points of the face of the block x, against what is wrong."""
        if self.wall.first_height is not None:
            step = height_step(found.height, self.wall.first_height, first)
            self._growth = limited(self._growth + self._fall * step, LARGEST_IN_SPACE)
        if self._angle is not None and self.wall.slides:
            lines = from_face(x, self.wall.side)
            self._slide = self._slide or FaceSlide(lines[..., 0])
            self._slide.step(lines, found, self._angle)
        elif self._angle is not None:
            self._lean = limited(self._lean + lean_step(found.angle, self._angle), LARGEST_IN_SPACE)
        if self._is_wall is not None:
            self._growth, self._lean = self._growth * self._is_wall, self._lean * self._is_wall

    def add(self, theta: np.ndarray, x: np.ndarray, found: FaceMeasures) -> None:
        """Add the control functions to (3, ni, nj, nk) logarithms of growth of the block x of that shape."""
        view = from_face(theta[self._axis], self.wall.side)
        view += self._outwards * self._growth[..., None] * np.exp(-self._fall * np.arange(view.shape[-1]))
        if self._angle is None or self.wall.slides:
            return
        lines = from_face(x, self.wall.side)
        distance = np.zeros(lines.shape[1:])
        np.cumsum(np.linalg.norm(np.diff(lines, axis=-1), axis=0), axis=-1, out=distance[..., 1:])
        for axis, lean, spacing in zip(self._along, self._lean, found.spacing, strict=True):
            unit = np.maximum(spacing, found.height)[..., None]
            from_face(theta[axis], self.wall.side)[...] += lean[..., None] * _falling(LEAN_REACH * distance / unit)

    def wrong(self, found: FaceMeasures) -> np.ndarray:
        """(2, n) errors of angle (degrees) and of height (relative) at the n nodes that count."""
        wrong = np.zeros((2, *found.height.shape))
        if self._angle is not None:
            wrong[0] = found.off(self._angle)
        if self.wall.first_height is not None:
            wrong[1] = np.abs(found.height / self.wall.first_height - 1)
        return wrong[:, found.counts]


def _both(angle: float | np.ndarray) -> np.ndarray:
    """(2, 1, 1) or (2, na, nb) degrees from a face's first and second direction; one number is that from the first."""
    angle = np.asarray(angle, float)
    if angle.ndim == 0:
        angle = np.array([angle, 90.0])
    return angle.reshape(2, 1, 1) if angle.ndim == 1 else angle


def _falling(x: np.ndarray) -> np.ndarray:
    """exp(-x), which is not worked out where it is nothing."""
    return np.exp(-x, out=np.zeros(x.shape), where=x < _NEGLIGIBLE)


def controlled(
    levels: Sequence[Level],
    walls: Sequence[Wall],
    growth: np.ndarray,
    *,
    sign: float = 1.0,
    most_steps: int = MOST_STEPS,
    angle_within: float = ANGLE_WITHIN,
    height_within: float = HEIGHT_WITHIN,
    progress: Progress = silent,
) -> Controlled:
    """Solve on the finest of ``levels`` with control functions ``growth`` and those that the walls come to need.

    Parameters
    ----------
    levels : sequence of Level
        Of `winslow_3d.levels_of`; the finest holds the start and gets the grid.
    walls : sequence of Wall
        What is asked at faces, in the lengths of the levels.
    growth : (3, ni, nj, nk) float
        Logarithms of growth from cell to cell.
    sign : float
        1 if the block is right-handed, else -1.
    most_steps : int
        Steps after which to give up; each is a cycle.
    angle_within, height_within : float
        Degrees and part of the height that may be wrong.
    progress : Progress
        Told after each step.
    """
    levels = list(levels)
    finest, outcome = levels[0], Outcome()
    unit = max(finest.residual(), ROUNDING / RESIDUAL_WITHIN)
    set_growth(levels, growth)
    full_multigrid(levels, first_level(levels, FIRST_CELLS), outcome)
    faces = [wall.side for wall in walls]
    start = [_measured(finest, wall, sign) for wall in walls]
    controls = [
        _Control(wall, finest, _opposite(wall.side) in faces, found) for wall, found in zip(walls, start, strict=True)
    ]
    residuals, worst, best = [unit, finest.residual()], [], None
    for step in range(most_steps):
        found = [_measured(finest, wall, sign) for wall in walls]
        went = _judged(controls, found, angle_within, height_within)
        settled = residuals[-1] < RESIDUAL_WITHIN * unit
        if settled and went.converged:
            break
        # What is wrong where it is worst, and how many nodes are wrong: a crease may keep a few for ever.
        worst.append((went.angle / angle_within + went.height / height_within) * (1.01 - went.good))
        if settled and worst[-1] == min(worst):
            best = went, finest.x.copy()
        if len(worst) > PATIENCE and min(worst[-PATIENCE:]) > 0.98 * min(worst[:-PATIENCE]):
            break
        theta = growth.copy()
        for control, have in zip(controls, found, strict=True):
            control.step(finest.nodes, have, first=step == 0)
            control.add(theta, finest.nodes, have)
        set_growth(levels, limited(theta, LARGEST_IN_SPACE))
        if step == 0:  # where the start solves the equations, as in a box, there is nothing to measure by but this
            unit = max(unit, finest.residual())
        _safe_cycle(levels, outcome)
        residuals.append(finest.residual())
        advance(progress, step / most_steps, f"angle within {went.angle:.2g} degrees, height within {went.height:.1%}")
    else:
        settled = False
    if not (settled and went.converged) and best is not None:
        went, finest.x[...] = best
    history = tuple(residual / unit for residual in residuals)
    return replace(went, history=history, converged=settled and went.converged)


def _runs_on(level: Level, wall: Wall) -> Closed:
    """Along which directions a wall has no edges; where its points slide, they stay at cuts, too."""
    return (False, False, False) if wall.slides else level.ghosts.whole


def _measured(level: Level, wall: Wall, sign: float) -> FaceMeasures:
    """What a wall has; ghosts are of use only where it runs on."""
    closed = _runs_on(level, wall)
    at = tuple(slice(None, n + runs) for n, runs in zip(level.nodes.shape[1:], closed, strict=True))
    return measured(level.x[(slice(None), *at)], wall.side, sign, closed, level.ghosts.wall(wall.side))


def _judged(
    controls: Sequence[_Control], found: Sequence[FaceMeasures], angle_within: float, height_within: float
) -> Controlled:
    """How far walls are from what was asked, where they count."""
    wrong = np.concatenate([control.wrong(have) for control, have in zip(controls, found, strict=True)], axis=1)
    angle, height = (float(worst) for worst in wrong.max(axis=1, initial=0.0))
    good = (wrong[0] < angle_within) & (wrong[1] < height_within)
    share = float(np.concatenate([have.counts.ravel() for have in found]).mean())
    asked = what_is_asked([control.wall for control in controls])
    return Controlled((), angle, height, bool(good.all()), float(good.mean()) if len(good) else 1.0, share, asked)


def _opposite(face: str) -> str:
    return face[0] + ("min" if face.endswith("max") else "max")


def _safe_cycle(levels: list[Level], outcome: Outcome) -> None:
    """A cycle; where it would make matters worse, with shorter corrections or none."""
    finest = levels[0]
    before, residual, step = finest.x.copy(), finest.residual(), 1.0
    for _ in range(3):
        cycle(levels, 0, outcome, step)
        if finest.residual() <= GROWTH * residual:  # false for NaN
            return
        finest.x[...] = before
        step *= 0.4
    for sweep in range(COARSEST_SWEEPS):
        finest.smooth(back=bool(sweep % 2))
