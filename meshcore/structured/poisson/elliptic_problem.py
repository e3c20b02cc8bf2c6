"""What an elliptic grid is asked to be, and the way to a checked grid in a plane: `elliptic` and its like."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from ...errors import GenerationFailed, InvalidGeometry, InvalidInput
from ...geometry.plane import fitted_plane
from ...mesh import StructuredGrid
from ...progress import Progress, silent
from ...quality import summary, validate
from ...report import Report, Result
from ...threads import Workers, available_threads
from ..algebraic.crossed_sides import refuse_crossed_sides
from ..folds import folded_cells, refuse_folds
from ..limits import check_extent
from .barrier import curable_cells, unfolded
from .biharmonic import biharmonic
from .control_functions import Attractor, ControlFunction, from_attractors, from_boundary, from_grid, from_user
from .wall_checks import NO_INSIDE, refuse_wall
from .wall_control import FEWEST_CELLS, HEIGHT_AIM, Wall, controlled, judged, measured
from .winslow import CUT, MOST_CYCLES, SIDES, Frame, levels_of, orientation, winslow

_CURE = (
    "move the grid's corners to where the boundary turns by less than 180 degrees, ask for less control, "
    "or give more cells"
)
SHARES = (1.0, 0.5, 0.25, 0.0)
"""Of control functions, as long as they fold the grid or do not converge."""
_ALIKE = 1e-6  # of the extent: how far periodic sides may differ
Equation = Literal["Poisson", "biharmonic"]
Control = Literal["none", "boundary spacing"]


@dataclass(frozen=True)
class Asked:
    """What an elliptic grid shall be like; see `elliptic` for the meaning of each.

    Attributes
    ----------
    equation : {"Poisson", "biharmonic"}
        What is solved; control functions are Poisson's.
    control : {"none", "boundary spacing", "grid spacing"}
        Control functions from the start's boundary, or from all of a start that needs little more than smoothing: with
        walls it is solved from there.
    height_aim : float
        Error of first heights at walls, as a share, that is worked for, and enough if it is more than `HEIGHT_WITHIN`.
    control_functions : P and Q, or None
        The user's control functions.
    attractors : sequence of Attractor
        Lines and points that draw others near.
    walls : sequence of Wall
        What is asked at sides.
    periodic : bool
        Whether the sides along j are one line, moved along, through which the grid runs on.
    residual : float or None
        Residual to reach.
    most_cycles : int
        Cycles after which to give up.
    threads : int or None
        How many may work.
    shares : sequence of float
        Of the control functions, tried in turn as long as cells stay folded or nothing converges.
    give_up : float
        Share of folded cells from which on neither less control nor unfolding is tried.
    """

    equation: Equation = "Poisson"
    control: Control | Literal["grid spacing"] = "none"
    height_aim: float = HEIGHT_AIM
    control_functions: Sequence[ControlFunction] | None = None
    attractors: Sequence[Attractor] = ()
    walls: Sequence[Wall] = ()
    periodic: bool = False
    residual: float | None = None
    most_cycles: int = MOST_CYCLES
    threads: int | None = None
    shares: Sequence[float] = SHARES
    give_up: float = 1.0

    def growth(self, points: np.ndarray, cyclic: bool) -> np.ndarray | None:
        """Logarithms of growth of all control functions together, or None for the Laplace equations."""
        if self.equation == "biharmonic":
            return None
        shape = points.shape[:2]
        parts = []
        if self.control == "boundary spacing":
            parts.append(from_boundary(points, cyclic=cyclic))
        if self.control == "grid spacing":
            parts.append(from_grid(points, cyclic=cyclic))
        if self.control_functions is not None:
            parts.append(from_user(self.control_functions, shape))
        if self.attractors:
            parts.append(from_attractors(self.attractors, shape))
        return sum(parts) if parts else None

    def transposed(self) -> Asked:
        """The same of a grid whose i and j change places."""
        functions = self.control_functions
        if functions is not None:
            turned = [(lambda i, j, f=f: f(j, i)) if callable(f) else np.asarray(f).T for f in functions]
            functions = turned[::-1]
        attractors = [replace(a, i=a.j, j=a.i) for a in self.attractors]
        names = dict(zip(SIDES, ("west", "north", "east", "south"), strict=True))
        walls = [replace(wall, side=names[wall.side]) for wall in self.walls]
        return replace(self, control_functions=functions, attractors=attractors, walls=walls)


@dataclass
class Found:
    """A grid as it came out.

    Attributes
    ----------
    points : (ni, nj, 2) or (ni, nj, 3) float
        The grid.
    history : list of float
        Residuals in units of the start's.
    converged : bool
        Whether what was asked for was reached.
    warnings : list of str
        What to tell the user.
    quality : dict of str to float
        Errors of angle and height at walls.
    stalled : bool
        Whether cycles no longer brought the grid nearer to a solution.
    """

    points: np.ndarray
    history: Sequence[float]
    converged: bool
    warnings: list[str] = field(default_factory=list)
    quality: dict[str, float] = field(default_factory=dict)
    stalled: bool = False


def solved(start: StructuredGrid, asked: Asked, progress: Progress = silent) -> Result:
    """The elliptic grid with the boundary of a planar one, checked."""
    spatial = start.points[:, :, 0]
    check_extent(start.flat(start.points), parameter="grid")
    plane = fitted_plane(start.flat(start.points), parameter="grid")  # which numbers points as hosts do
    flat = plane.to_plane(spatial.reshape(-1, 3)).reshape(*spatial.shape[:2], 2)
    if start.periodic[0] and start.periodic[1]:
        raise InvalidInput("is periodic along i and j, which no planar grid can be", parameter="grid")
    if folded_cells(spatial).any():
        refuse_crossed_sides(start)
    if is_left_handed(start):
        if is_left_handed(start.reversed_along_i()):
            raise InvalidGeometry("has no area within its boundary; move its sides apart", parameter="grid")
        raise InvalidGeometry("is left-handed: its cells run clockwise; reverse its i", parameter="grid")
    transposed = start.periodic[1]
    cuts = cuts_of(start, asked.periodic)
    if faces := [wall.side for wall in asked.walls if wall.side not in SIDES]:
        raise InvalidInput(f"{faces[0]} is a face of blocks; sides are {', '.join(SIDES)}", parameter="walls")
    if absent := [wall.side for wall in asked.walls if wall.side in cuts]:
        raise InvalidInput(f"{absent[0]} is where the periodic grid is cut, not a wall", parameter="walls")
    sliding = [wall.side for wall in asked.walls if wall.slides]
    for wall in asked.walls:
        refuse_wall(spatial, wall)
    if transposed:
        flat, asked = np.ascontiguousarray(flat.swapaxes(0, 1)), asked.transposed()
    if asked.periodic:
        _check_periodic(flat)
    found = _planar(flat, start.periodic[0] or transposed or asked.periodic, asked, progress)
    if not np.isfinite(found.points).all():
        raise GenerationFailed(f"the grid went astray while walls were controlled; {_CURE}", partial=start)
    points = found.points.swapaxes(0, 1) if transposed else found.points
    spatial = plane.to_space(points.reshape(-1, 2)).reshape(*points.shape[:2], 3)
    for side in (side for side in SIDES if side not in (*cuts, *sliding)):
        spatial[SIDES[side]] = start.points[:, :, 0][SIDES[side]]
    grid = start.with_points(spatial)
    refuse_folds(grid, _CURE)
    return reported(grid, found)


def reported(grid: StructuredGrid, found: Found) -> Result:
    """A grid without folds as the result of an operation, validated."""
    validate(grid)
    report = Report(
        counts={"points": grid.n_points, "quads": grid.n_cells},
        quality={**summary(grid), **found.quality},
        iterations=max(len(found.history) - 2, 0),
        residual=float(found.history[-1]),
        converged=found.converged,
        warnings=found.warnings,
        history=[float(value) for value in found.history],
    )
    return Result(grid, report)


def is_left_handed(grid: StructuredGrid) -> bool:
    """Whether the cells of a grid in the plane of x and y run clockwise; in other planes nobody can tell.

    Examples
    --------
    >>> x, y = np.meshgrid([0.0, 1, 2], [0.0, 1], indexing="ij")
    >>> grid = StructuredGrid(np.stack([x, y], axis=-1))
    >>> is_left_handed(grid), is_left_handed(grid.reversed_along_i())
    (False, True)
    """
    points = grid.points[:, :, 0]
    return bool(np.ptp(points[..., 2]) == 0 and orientation(points[..., :2]) < 0)


def cuts_of(grid: StructuredGrid, repeats: bool = False) -> tuple[str, ...]:
    """Sides that are no boundary, being where a periodic grid is cut.

    Parameters
    ----------
    grid : StructuredGrid
        A surface grid.
    repeats : bool
        Whether east is west moved along.

    Examples
    --------
    >>> cuts_of(StructuredGrid(np.zeros((4, 3, 2)), periodic=(False, True, False)))
    ('south', 'north')
    """
    return CUT if grid.periodic[0] or repeats else ("south", "north") if grid.periodic[1] else ()


def _check_periodic(points: np.ndarray) -> None:
    """Refuse sides along j of which one is not the other, moved along."""
    way = points[-1] - points[0]
    off = float(np.linalg.norm(way - way[0], axis=1).max())
    if off > _ALIKE * float(np.ptp(points, axis=(0, 1)).max()):
        raise InvalidInput(
            f"needs east to be west moved along, but their points differ from that by up to {off:.4g}",
            parameter="periodic",
        )


def _planar(points: np.ndarray, cyclic: bool, asked: Asked, progress: Progress) -> Found:
    """Solve and unfold; with less control as long as that leaves no sound grid."""
    growth = asked.growth(points, cyclic)
    sign = orientation(points)
    if min(points.shape[:2]) < 3:
        return without_inside(points, asked)
    for share in asked.shares if growth is not None else (1.0,):
        found = _once(points, None if growth is None else share * growth, cyclic, asked, progress)
        if not np.isfinite(found.points).all():
            break
        folded = curable_cells(found.points, sign, cyclic=cyclic)
        if folded.mean() > asked.give_up:
            break  # what is folded is refused
        if folded.any():
            found.points = unfolded(found.points, sign, cyclic=cyclic)
        if not (found.stalled or curable_cells(found.points, sign, cyclic=cyclic).any()):
            break
    if share < 1:
        found.warnings.append(f"control functions were too strong for a sound grid and were reduced to {share:.0%}")
    return found


def _once(points: np.ndarray, growth: np.ndarray | None, cyclic: bool, asked: Asked, progress: Progress) -> Found:
    if asked.equation == "biharmonic":
        grid = biharmonic(points, asked.walls, cyclic=cyclic)
        if not asked.walls:
            return Found(grid, (0.0,), True)
        r, sign = np.moveaxis(grid, -1, 0), orientation(grid)
        went = judged(asked.walls, [measured(r, wall.side, sign, cyclic) for wall in asked.walls])
        return Found(grid, (0.0,), went.converged, went.warnings, went.quality)
    if asked.walls:
        return _with_walls(points, growth, cyclic, asked, progress)
    solution = winslow(
        points,
        growth=growth,
        cyclic=cyclic,
        tolerance=asked.residual,
        most_cycles=asked.most_cycles,
        threads=asked.threads,
        progress=progress,
    )
    return as_found(solution.points, solution.history, solution.converged, solution.error, asked)


def without_inside(points: np.ndarray, asked: Asked) -> Found:
    """A grid whose points are all on its boundary."""
    return Found(points, [0.0], not asked.walls, [NO_INSIDE] if asked.walls else [])


def as_found(
    points: np.ndarray, history: Sequence[float], converged: bool, error: float, asked: Asked, start: int = 2
) -> Found:
    """What a solver made, with what to tell of it.

    Parameters
    ----------
    points, history, converged
        As in `Found`.
    error : float
        Estimated distance of a node from its place, in local spacings.
    asked : Asked
        Which says how many cycles there might be.
    start : int
        Entries of the history before the first cycle.
    """
    warnings, cycles = [], len(history) - start
    if not converged:
        warnings.append(
            f"not converged after {cycles} cycles: the residual is {history[-1]:.2g} of "
            f"the start's, and a node may be {error:.2g} of the local spacing from its place"
        )
    stalled = not converged and error > 1 and cycles < asked.most_cycles
    return Found(points, history, converged, warnings, stalled=stalled)


def _with_walls(points: np.ndarray, growth: np.ndarray | None, cyclic: bool, asked: Asked, progress: Progress) -> Found:
    frame = Frame.of(points)
    walls = [wall.scaled(1 / frame.size) for wall in asked.walls]
    if growth is None:
        growth = np.zeros((2, *points.shape[:2]))
    with Workers(asked.threads or available_threads()) as workers:
        levels = levels_of(frame.inside(points), cyclic, workers, FEWEST_CELLS)
        anew = asked.control != "grid spacing"
        went = controlled(levels, walls, growth, anew=anew, height_aim=asked.height_aim, progress=progress)
        free = [*(CUT if cyclic else ()), *(wall.side for wall in walls if wall.slides)]
        grid = frame.outside(levels.levels[0].points_without_ghosts, points, free)
    return Found(grid, went.history, went.converged, went.warnings, went.quality)
