"""What the grid of a block is asked to be at its faces, and the way from there to its points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...errors import InvalidInput
from ...mesh.structured_grid import FACES
from ...progress import Progress, silent
from ...threads import Workers, available_threads
from ..algebraic.block_faces import across
from . import winslow_3d
from .elliptic_problem import Found
from .face_measures import axis_of
from .periodic_faces import Pair, averaged_at_cuts
from .wall_checks import NO_INSIDE, refuse_heights
from .wall_control import Wall
from .wall_control_3d import LEAST_CELLS, controlled


@dataclass(frozen=True)
class AskedOfBlock:
    """What the grid of a block shall be like at its faces, and how it is solved.

    Attributes
    ----------
    walls : sequence of Wall
        What is asked at faces.
    pairs : sequence of Pair
        Faces through which the grid runs on.
    residual : float or None
        Residual to reach.
    most_cycles : int
        Cycles after which to give up.
    threads : int or None
        How many may work.
    """

    walls: Sequence[Wall] = ()
    pairs: Sequence[Pair] = ()
    residual: float | None = None
    most_cycles: int = 60
    threads: int | None = None

    def check(self, points: np.ndarray) -> None:
        """Refuse what no (ni, nj, nk, 3) block can have.

        Raises
        ------
        InvalidInput
            If a wall is no face, is named twice, has values of another shape, or heights as long as its lines.
        """
        names = [wall.side for wall in self.walls]
        for wall in self.walls:
            if wall.side not in FACES:
                raise InvalidInput(
                    f"{wall.side} is no face of a block; faces are {', '.join(FACES)}", parameter="walls"
                )
            if names.count(wall.side) > 1:
                raise InvalidInput(f"{wall.side} is named twice; give one wall for each face", parameter="walls")
            cut = next((pair for pair in self.pairs if pair.axis == axis_of(wall.side)), None)
            if cut is not None and cut.kept is None:
                raise InvalidInput(f"{wall.side} is where the block runs on, not a wall", parameter="walls")
            if cut is not None and wall.slides:
                raise InvalidInput(f"{wall.side} is a wall in part only, which cannot slide", parameter="sliding")
            _check_wall(points, wall)


def _check_wall(points: np.ndarray, wall: Wall) -> None:
    shape = tuple(points.shape[axis] for axis in across(wall.side))
    height = np.asarray(0.0 if wall.first_height is None else wall.first_height)
    angle = np.asarray(90.0 if wall.angle is None else wall.angle)
    if height.shape not in ((), shape):
        raise InvalidInput(
            f"the first heights of {wall.side} need shape {shape}, got {height.shape}", parameter="walls"
        )
    if angle.shape not in ((), (2,), (2, *shape)):
        raise InvalidInput(f"angles of {wall.side} need shape {(2, *shape)}, got {angle.shape}", parameter="walls")
    refuse_heights(np.moveaxis(points, axis_of(wall.side), 0), wall)


def solved(points: np.ndarray, growth: np.ndarray | None, asked: AskedOfBlock, progress: Progress = silent) -> Found:
    """The elliptic grid with the boundary of a given one, which starts from its inside.

    Parameters
    ----------
    points : (ni, nj, nk, 3) float
        A right-handed block.
    growth : (3, ni, nj, nk) float, optional
        Control functions as logarithms of growth from cell to cell; by default Laplace.
    asked : AskedOfBlock
        What it shall be like.
    progress : Progress
        Called with fraction and message.
    """
    if growth is not None:
        growth = averaged_at_cuts(growth, asked.pairs)
    if asked.walls and min(points.shape[:3]) >= 3:
        return _with_walls(points, growth, asked, progress)
    smooth, outcome = winslow_3d.solved(
        points,
        growth=growth,
        tolerance=asked.residual,
        most=asked.most_cycles,
        pairs=asked.pairs,
        threads=asked.threads,
        progress=progress,
    )
    warnings = [NO_INSIDE] if asked.walls else []
    if not outcome.converged:
        warnings.append(
            f"stopped after {outcome.cycles} cycles, an estimated {outcome.error:.2g} spacings from the converged "
            "grid; allow more cycles or a larger residual"
        )
    history = np.array(outcome.residuals) / (outcome.residuals[0] or 1.0)
    return Found(smooth, history.tolist(), outcome.converged and not asked.walls, warnings)


def _with_walls(points: np.ndarray, growth: np.ndarray | None, asked: AskedOfBlock, progress: Progress) -> Found:
    frame = winslow_3d.BlockFrame.of(points)
    walls = [wall.scaled(1 / frame.size) for wall in asked.walls]
    if growth is None:
        growth = np.zeros((3, *points.shape[:3]))
    with Workers(asked.threads or available_threads()) as workers:
        levels = winslow_3d.levels_of(
            frame.inside(points), growth, workers, pairs=frame.pairs(asked.pairs), least=LEAST_CELLS
        )
        went = controlled(levels, walls, growth, progress=progress)
    slid = [wall.side for wall in walls if wall.slides]
    new = frame.outside(levels[0].nodes, points, asked.pairs, slid)
    return Found(new, went.history, went.converged, went.warnings, went.quality)
