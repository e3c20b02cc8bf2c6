"""Angle and first height of cells at walls, by control functions that are found while the grid is solved.

J. L. Steger, R. L. Sorenson, J. Comput. Phys. 33 (1979); R. L. Sorenson, NASA TM 81198 (1980), for the limits on what
the controls may be and how far they may move in a step. Both control functions are logarithms of growth here:

    theta_normal = t(s) exp(-b n)           makes cells grow from the wall: the first height
    theta_along  = u(s) exp(-a d(s, n))     makes lines lean along the wall: the angle

n counts cells from the wall; the distance d from the wall is in units of the first cell's larger side, so that lines
lean back within about a cell's width. After each cycle t and u move by a share of what their response promises.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import InvalidInput
from ..progress import Progress, advance, silent
from .sliding import Slide
from .winslow import SIDES, full_multigrid, safe_cycle
from .winslow_levels import Levels

OPPOSITE = {"south": "north", "north": "south", "west": "east", "east": "west"}
ANGLE_WITHIN, HEIGHT_WITHIN, RESIDUAL_WITHIN = 1.0, 0.05, 1e-3
FEWEST_CELLS = (16, 24)
"""Cells that a direction keeps on all levels: coarser ones cannot hold a control function that falls off in a few."""
MOST_STEPS = 120
_ROUNDING = 1e-14  # a residual that is none, in a grid of unit size
_LEAN_REACH = 0.5  # a
_GROWTH_REACH = 5.0  # b times the cells from wall to wall
_SHARE = 0.6  # of the promised step
_FIRST_SHARE = 0.8  # of the height's first step, which has no limit of its own: a far smaller height is half the work
_LARGEST_LEAN_STEP, _LARGEST_HEIGHT_STEP, _LARGEST_CONTROL = 0.4, 0.8, 1.5
# Lines must turn by the corner's angle within so many nodes beside a sharp corner or an end of a wall, and within so
# many first heights: neither angle nor height are judged there.
_NEAR_CORNER, _CORNER_REACH = 2, 2.0
_PATIENCE = 25  # steps without a gain of two per cent
_SHARP = np.radians(60.0)  # of turning


@dataclass(frozen=True)
class Wall:
    """What is asked at one side of a grid.

    Parameters
    ----------
    side : str
        "south", "east", "north" or "west": j = 0, the last i, the last j, i = 0.
    first_height : float or (n,) float, optional
        Length of the first edge of the lines that leave the wall; left out, it is what it becomes.
    angle : float or (n,) float, optional
        Degrees from the wall's direction, in which i or j grows, to the line that leaves it; None for what it becomes.
    slides : bool
        Whether the angle is reached by points that slide along the wall, between its ends, instead of lines that lean.

    Raises
    ------
    InvalidInput
        If there is no such side, or a height or an angle is impossible.

    Examples
    --------
    >>> Wall("south", first_height=1e-3)
    Wall(side='south', first_height=0.001, angle=90.0, slides=False)
    """

    side: str
    first_height: float | np.ndarray | None = None
    angle: float | np.ndarray | None = 90.0
    slides: bool = False

    def __post_init__(self) -> None:
        if self.side not in SIDES:
            raise InvalidInput(f"{self.side!r} is no side; sides are {', '.join(SIDES)}", parameter="walls")
        height, angle = (np.asarray(1.0 if v is None else v, float) for v in (self.first_height, self.angle))
        if not (np.isfinite(height) & (height > 0)).all():
            raise InvalidInput(
                f"the first height must be a positive number, got {self.first_height}", parameter="walls"
            )
        if not ((angle > 0) & (angle < 180)).all():
            raise InvalidInput(f"the angle must be between 0 and 180 degrees, got {self.angle}", parameter="walls")


@dataclass
class Measured:
    """What a wall has: arrays over the nodes of the side.

    Attributes
    ----------
    angle, height : (n,) float
        Degrees from the wall's direction to the line, and length of the line's first edge.
    spacing : (n,) float
        Mean length of the two edges of the wall at the node.
    counts : (n,) bool
        Whether the node is not close to an end of the side, or to a sharp corner.
    """

    angle: np.ndarray
    height: np.ndarray
    spacing: np.ndarray
    counts: np.ndarray


def from_wall(grid: np.ndarray, side: str) -> np.ndarray:
    """A view of (..., ni, nj) values as (..., along, outwards from the side).

    Examples
    --------
    >>> from_wall(np.arange(6).reshape(3, 2), "north")[:, 0]
    array([1, 3, 5])
    """
    flipped = {"south": grid, "north": grid[..., ::-1], "west": grid, "east": grid[..., ::-1, :]}[side]
    return flipped.swapaxes(-1, -2) if side in ("west", "east") else flipped


def tangents(wall: np.ndarray, side: str, sign: float, closed: bool) -> tuple[np.ndarray, float]:
    """(2, n) unit tangents along a side, and 1 if the grid lies to their left, else -1."""
    ahead, behind, weight, _ = _neighbouring_edges(wall, closed)
    tangent = weight * ahead + (1 - weight) * behind
    flat = np.hypot(*tangent) < 1e-6
    tangent[:, flat] = np.stack([-ahead[1], ahead[0]])[:, flat]
    return tangent / np.hypot(*tangent), sign * (1.0 if side in ("south", "east") else -1.0)


def _neighbouring_edges(wall: np.ndarray, closed: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Unit edges after and before each node, the share of the one in the tangent, and the turn in radians.

    The tangent is that of the parabola through three nodes, at a sharp corner the bisector.
    """
    step = np.diff(wall, axis=1)
    after = np.concatenate([step, step[:, :1] if closed else step[:, -1:]], axis=1)
    before = np.concatenate([step[:, -1:] if closed else step[:, :1], step], axis=1)
    long_after, long_before = np.linalg.norm(after, axis=0), np.linalg.norm(before, axis=0)
    ahead, behind = after / long_after, before / long_before
    turn = np.abs(np.arctan2(ahead[1] * behind[0] - ahead[0] * behind[1], (ahead * behind).sum(axis=0)))
    return ahead, behind, np.where(turn > _SHARP, 0.5, long_before / (long_after + long_before)), turn


def measured(r: np.ndarray, side: str, sign: float, cyclic: bool) -> Measured:
    """Angle, height and spacing at a side of a (2, ni, nj) grid whose cells' areas have the given sign."""
    view = from_wall(r, side)
    wall, edge = view[..., 0], view[..., 1] - view[..., 0]
    closed = cyclic and side in ("south", "north")
    tangent, facing = tangents(wall, side, sign, closed)
    along = (edge * tangent).sum(axis=0)
    out = facing * (edge[1] * tangent[0] - edge[0] * tangent[1])
    height, length = np.hypot(*edge), np.linalg.norm(np.diff(wall, axis=1), axis=0)
    first, last = (length[-1:], length[:1]) if closed else (length[:1], length[-1:])
    spacing = 0.5 * (np.concatenate([length, last]) + np.concatenate([first, length]))
    sharp = _neighbouring_edges(wall, closed)[3] > _SHARP
    counts = _away_from(sharp, np.concatenate([[0.0], np.cumsum(length)]), height, closed)
    return Measured(np.degrees(np.arctan2(out, along)), height, spacing, counts)


def _away_from(sharp: np.ndarray, length: np.ndarray, height: np.ndarray, closed: bool) -> np.ndarray:
    """(n,) bool: nodes that are not close to a sharp corner or to an end, where another side begins."""
    number = np.arange(len(sharp))
    counts = ~sharp
    corners = np.flatnonzero(sharp)
    for corner in corners if closed else [0, *corners, len(sharp) - 1]:
        nodes, way = np.abs(number - corner), np.abs(length - length[corner])
        if closed:
            nodes, way = np.minimum(nodes, len(sharp) - 1 - nodes), np.minimum(way, length[-1] - way)
        counts &= (nodes > _NEAR_CORNER) & (way > _CORNER_REACH * height)
    return counts


@dataclass
class _Control:
    """The state of one wall's control: amplitudes t and u over its nodes."""

    wall: Wall
    closed: bool
    fall: float
    growth: np.ndarray
    lean: np.ndarray
    slide: Slide | None = None

    def step(self, found: Measured, *, first: bool) -> None:
        """Move the amplitudes against what is wrong."""
        if self.wall.first_height is not None:
            wrong = np.log(found.height / self.wall.first_height)
            step = (
                _FIRST_SHARE * wrong if first else _SHARE * np.clip(wrong, -_LARGEST_HEIGHT_STEP, _LARGEST_HEIGHT_STEP)
            )
            self.growth = _limited(self.growth + self.fall * step)
        if self.wall.angle is not None and self.slide is None:
            wrong = np.tan(np.clip(np.radians(self.wall.angle - found.angle), -1.2, 1.2))
            wrong = np.clip(wrong, -_LARGEST_LEAN_STEP, _LARGEST_LEAN_STEP)
            self.lean = _limited(self.lean + _SHARE * _LEAN_REACH * wrong)
        if self.closed:
            self.growth[-1], self.lean[-1] = self.growth[0], self.lean[0]

    def add(self, theta: np.ndarray, r: np.ndarray, unit: np.ndarray) -> None:
        """Add the control functions to (2, ni, nj) logarithms of growth."""
        side = self.wall.side
        along, normal = (0, 1) if side in ("south", "north") else (1, 0)
        outwards = 1.0 if side in ("south", "west") else -1.0
        view = from_wall(theta, side)
        lines = from_wall(r, side)
        distance = np.zeros(lines.shape[1:])
        np.cumsum(np.hypot(*np.diff(lines, axis=2)), axis=1, out=distance[:, 1:])
        view[normal] += outwards * self.growth[:, None] * np.exp(-self.fall * np.arange(lines.shape[2]))
        view[along] += self.lean[:, None] * np.exp(-_LEAN_REACH * distance / unit[:, None])

    def excess(self, found: Measured) -> tuple[float, float]:
        """Largest error of angle (degrees) and of height (relative) where they count."""
        angle = height = 0.0
        if found.counts.any():
            if self.wall.angle is not None:
                angle = float(np.abs(found.angle - self.wall.angle)[found.counts].max())
            if self.wall.first_height is not None:
                height = float(np.abs(found.height / self.wall.first_height - 1)[found.counts].max())
        return angle, height


def _limited(amplitude: np.ndarray) -> np.ndarray:
    return np.clip(amplitude, -_LARGEST_CONTROL, _LARGEST_CONTROL)


@dataclass(frozen=True)
class Controlled:
    """How the control of walls went.

    Attributes
    ----------
    history : tuple of float
        Residuals, in units of the start's.
    angle, height : float
        Largest errors where they count: degrees, and a share of the height.
    converged : bool
        Whether all of these are small enough.
    """

    history: tuple[float, ...]
    angle: float
    height: float
    converged: bool


def controlled(
    levels: Levels,
    walls: list[Wall],
    growth: np.ndarray,
    *,
    most_steps: int = MOST_STEPS,
    angle_within: float = ANGLE_WITHIN,
    height_within: float = HEIGHT_WITHIN,
    progress: Progress = silent,
) -> Controlled:
    """Solve on the finest of ``levels`` with control functions ``growth`` and those that the walls come to need."""
    finest = levels.levels[0]
    unit = max(finest.residual(), _ROUNDING / RESIDUAL_WITHIN)
    levels.set_growth(growth)
    full_multigrid(levels, 2)
    ni, nj = growth.shape[1:]
    controls = []
    for wall in walls:
        closed = finest.cyclic and wall.side in ("south", "north")
        n, out = (ni, nj) if wall.side in ("south", "north") else (nj, ni)
        opposite = OPPOSITE[wall.side]
        reach = (out - 1) / (2 if opposite in [other.side for other in walls] else 1)
        slide = Slide(from_wall(finest.points_without_ghosts, wall.side)[..., 0]) if wall.slides else None
        controls.append(_Control(wall, closed, _GROWTH_REACH / reach, np.zeros(n), np.zeros(n), slide))
    residuals, worst = [unit, finest.residual()], []
    for step in range(most_steps):
        r = finest.points_without_ghosts
        found = [measured(r, control.wall.side, levels.sign, finest.cyclic) for control in controls]
        angle, height = np.max([c.excess(f) for c, f in zip(controls, found, strict=True)], axis=0)
        converged = bool(angle < angle_within and height < height_within and residuals[-1] < RESIDUAL_WITHIN * unit)
        if converged:
            break
        worst.append(angle / angle_within + height / height_within)
        if len(worst) > _PATIENCE and min(worst[-_PATIENCE:]) > 0.98 * min(worst[:-_PATIENCE]):
            break
        theta = growth.copy()
        for control, have in zip(controls, found, strict=True):
            control.step(have, first=step == 0)
            control.add(theta, r, np.maximum(have.spacing, have.height))
            if control.slide is not None:
                control.slide.step(from_wall(r, control.wall.side), have, control.wall.angle, control.closed)
        finest.wrap()
        levels.set_growth(_limited(theta))
        if step == 0:  # where the start solves the equations, as in a box, there is nothing to measure by but this
            unit = max(unit, finest.residual())
        safe_cycle(levels)
        residuals.append(finest.residual())
        advance(progress, step / most_steps, f"angle within {angle:.2g} degrees, height within {height:.1%}")
    return Controlled(tuple(residual / unit for residual in residuals), angle, height, converged)
