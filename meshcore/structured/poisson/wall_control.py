"""Angle and first height of cells at walls, by control functions that are found while the grid is solved.

J. L. Steger, R. L. Sorenson, J. Comput. Phys. 33 (1979); R. L. Sorenson, NASA TM 81198 (1980), for the limits on what
the controls may be and how far they may move in a step. Both control functions are logarithms of growth here:

    theta_normal = t(s) exp(-b n)           makes cells grow from the wall: the first height
    theta_along  = u(s) exp(-a d(s, n))     makes lines lean along the wall: the angle

n counts cells from the wall; the distance d from the wall is in units of the first cell's larger side, so that lines
lean back within about a cell's width. After each cycle t and u move by a share of what their response promises.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ...errors import InvalidInput
from ...mesh.structured_grid import FACES
from ...progress import Progress, advance, silent
from .sliding import Slide
from .wall_outcome import Controlled
from .winslow import SIDES, full_multigrid, safe_cycle
from .winslow_levels import Levels

OPPOSITE = {"south": "north", "north": "south", "west": "east", "east": "west"}
ANGLE_WITHIN, HEIGHT_WITHIN, RESIDUAL_WITHIN = 1.0, 0.05, 1e-3
HEIGHT_AIM = 0.01  # what is worked for; `HEIGHT_WITHIN` is good enough where no more can be had
FEWEST_CELLS = (16, 24)
"""Cells that a direction keeps on all levels: coarser ones cannot hold a control function that falls off in a few."""
MOST_STEPS = 120
ROUNDING = 1e-14  # a residual that is none, in a grid of unit size
LEAN_REACH = 0.5  # a
RIPPLES = 0.5  # of what a lean that alternates from line to line would need: all of it overshoots beside corners
GROWTH_REACH = 5.0  # b times the cells from wall to wall
SHARE = 0.6  # of the promised step
FIRST_SHARE = 0.8  # of the height's first step, which has no limit of its own: a far smaller height is half the work
LARGEST_LEAN_STEP, LARGEST_HEIGHT_STEP, LARGEST_CONTROL = 0.4, 0.8, 1.5
# In the plane, what holds lines upright where an edge of the wall is fifty times as long as the next, as polygons with
# cut corners have them; sections in files have five times beside the nose. On a straight wall the ratio is exp(theta).
LARGEST_IN_PLANE = 8.0
# Lines must turn by the corner's angle within so many nodes beside a sharp corner or an end of a wall, and within so
# many first heights: neither angle nor height are judged there.
NEAR_CORNER, CORNER_REACH = 2, 2.0
# Steps without a gain of two per cent after which coarse corrections are damped, and after which is given up: beside
# blunt edges whole corrections may make the grid swing to and fro, whatever the controls.
SHORT_PATIENCE, PATIENCE, DAMPED = 8, 25, 0.5
SHARP = np.radians(60.0)  # of turning


@dataclass(frozen=True)
class Wall:
    """What is asked at one side of a planar grid, or at one face of a block.

    Parameters
    ----------
    side : str
        "south", "east", "north" or "west": j = 0, the last i, the last j, i = 0; of a block "imin", "imax", "jmin",
        "jmax", "kmin" or "kmax".
    first_height : float, (n,) or (n, m) float, optional
        Length of the first edge of the lines that leave the wall; left out, it is what it becomes.
    angle : float, (n,) or (2, n, m) float, optional
        Degrees from the wall's direction, in which i or j grows, to the line that leaves it; None for what it becomes.
        A line that leaves a face runs along ``normal + cot(angle[0]) a + cot(angle[1]) b``, where a and b are the
        directions in which the first and the second index of the face grow; one number is that to the first.
    slides : bool
        Whether the angle is reached by points that slide along the wall, between its ends, instead of lines that lean.
    lean_at_edges : bool
        Whether lines that leave a face of a block lean near its edges as those on the next faces do.

    Raises
    ------
    InvalidInput
        If there is no such side or face, or a height or an angle is impossible.

    Examples
    --------
    >>> Wall("south", first_height=1e-3)
    Wall(side='south', first_height=0.001, angle=90.0, slides=False, lean_at_edges=False)
    """

    side: str
    first_height: float | np.ndarray | None = None
    angle: float | np.ndarray | None = 90.0
    slides: bool = False
    lean_at_edges: bool = False

    def __post_init__(self) -> None:
        if self.side not in (*SIDES, *FACES):
            raise InvalidInput(
                f"{self.side!r} is no side; sides are {', '.join(SIDES)}, faces {', '.join(FACES)}", parameter="walls"
            )
        height, angle = (np.asarray(1.0 if v is None else v, float) for v in (self.first_height, self.angle))
        if not (np.isfinite(height) & (height > 0)).all():
            raise InvalidInput(
                f"the first height must be a positive number, got {self.first_height}", parameter="walls"
            )
        if not ((angle > 0) & (angle < 180)).all():
            raise InvalidInput(f"the angle must be between 0 and 180 degrees, got {self.angle}", parameter="walls")

    def scaled(self, factor: float) -> Wall:
        """The same of a grid whose lengths are multiplied."""
        return self if self.first_height is None else replace(self, first_height=factor * np.asarray(self.first_height))


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
        Whether the node is not close to an end of the side, or to a sharp corner; if all are, that are not on an end.
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
    ahead, behind, weight, _ = neighbouring_edges(wall, closed)
    tangent = weight * ahead + (1 - weight) * behind
    flat = np.hypot(*tangent) < 1e-6
    tangent[:, flat] = np.stack([-ahead[1], ahead[0]])[:, flat]
    return tangent / np.hypot(*tangent), sign * (1.0 if side in ("south", "east") else -1.0)


def neighbouring_edges(wall: np.ndarray, closed: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Unit edges after and before each node, the share of the one in the tangent, and the turn in radians.

    The tangent is that of the parabola through three nodes, at a sharp corner the bisector.
    """
    step = np.diff(wall, axis=1)
    after = np.concatenate([step, step[:, :1] if closed else step[:, -1:]], axis=1)
    before = np.concatenate([step[:, -1:] if closed else step[:, :1], step], axis=1)
    long_after, long_before = np.linalg.norm(after, axis=0), np.linalg.norm(before, axis=0)
    ahead, behind = after / long_after, before / long_before
    turn = np.abs(np.arctan2(ahead[1] * behind[0] - ahead[0] * behind[1], (ahead * behind).sum(axis=0)))
    return ahead, behind, np.where(turn > SHARP, 0.5, long_before / (long_after + long_before)), turn


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
    sharp = neighbouring_edges(wall, closed)[3] > SHARP
    counts = _away_from(sharp, np.concatenate([[0.0], np.cumsum(length)]), height, closed)
    if not counts.any():  # better judged too strictly than not at all
        counts[slice(None) if closed else slice(1, -1)] = True
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
        counts &= (nodes > NEAR_CORNER) & (way > CORNER_REACH * height)
    return counts


@dataclass
class WallAmplitudes:
    """The state of one wall's control, in a plane or on a surface: amplitudes t and u over its nodes."""

    wall: Wall
    closed: bool
    fall: float
    growth: np.ndarray
    lean: np.ndarray
    most: ClassVar[float] = LARGEST_CONTROL

    @classmethod
    def of(cls, wall: Wall, shape: tuple[int, ...], cyclic: bool, others: Sequence[Wall]) -> WallAmplitudes:
        """Amplitudes that do nothing yet, at a wall of a grid of (ni, nj) points that has others."""
        n, out = shape if wall.side in ("south", "north") else shape[::-1]
        reach = (out - 1) / (2 if OPPOSITE[wall.side] in [other.side for other in others] else 1)
        return cls(wall, cyclic and wall.side in ("south", "north"), GROWTH_REACH / reach, np.zeros(n), np.zeros(n))

    @property
    def leans(self) -> bool:
        """Whether the angle is made by these amplitudes."""
        return self.wall.angle is not None

    def step(self, have: Measured, *, first: bool) -> None:
        """Move the amplitudes against what is wrong."""
        if self.wall.first_height is not None:
            step = height_step(have.height, self.wall.first_height, first)
            self.growth = limited(self.growth + self.fall * step, self.most)
        if self.leans:
            self.lean = limited(self.lean + slender_lean_step(have, self.wall.angle, self.closed), self.most)
        if self.closed:
            self.growth[-1], self.lean[-1] = self.growth[0], self.lean[0]

    def add(self, theta: np.ndarray, have: Measured, distance: np.ndarray) -> None:
        """Add the control functions to (2, ni, nj) logarithms of growth; ``distance`` is that along lines."""
        along, normal = (0, 1) if self.wall.side in ("south", "north") else (1, 0)
        outwards = 1.0 if self.wall.side in ("south", "west") else -1.0
        view = from_wall(theta, self.wall.side)
        unit = np.maximum(have.spacing, have.height)[:, None]
        view[normal] += outwards * self.growth[:, None] * np.exp(-self.fall * np.arange(view.shape[2]))
        view[along] += self.lean[:, None] * np.exp(-LEAN_REACH * distance / unit)


class _Control(WallAmplitudes):
    """Of a wall in a plane, along which points may slide instead of leaning lines."""

    most = LARGEST_IN_PLANE
    slide: Slide | None = None

    @property
    def leans(self) -> bool:
        return super().leans and self.slide is None

    def distance(self, r: np.ndarray) -> np.ndarray:
        """(n, m) distance of nodes from the wall along lines."""
        lines = from_wall(r, self.wall.side)
        away = np.zeros(lines.shape[1:])
        np.cumsum(np.hypot(*np.diff(lines, axis=2)), axis=1, out=away[:, 1:])
        return away


def judged(walls: Sequence[Wall], found: Sequence[Measured]) -> Controlled:
    """How far walls are from what was asked, where they count."""
    angles, heights = [0.0], [0.0]
    for wall, have in zip(walls, found, strict=True):
        if wall.angle is not None:
            angles.append(float(np.abs(have.angle - wall.angle)[have.counts].max()))
        if wall.first_height is not None:
            heights.append(float(np.abs(have.height / wall.first_height - 1)[have.counts].max()))
    angle, height = max(angles), max(heights)
    share = float(np.concatenate([have.counts for have in found]).mean())
    converged = angle < ANGLE_WITHIN and height < HEIGHT_WITHIN
    return Controlled((), angle, height, converged, judged=share, asked=what_is_asked(walls))


def what_is_asked(walls: Sequence[Wall]) -> tuple[bool, bool]:
    """Whether some wall asks for an angle, and whether some asks for a first height."""
    return any(wall.angle is not None for wall in walls), any(wall.first_height is not None for wall in walls)


def height_step(height: np.ndarray, wanted: float | np.ndarray, first: bool) -> np.ndarray:
    """By how much the logarithm of growth of all cells together is to change, for heights that are wrong."""
    wrong = np.log(height / wanted)
    return FIRST_SHARE * wrong if first else SHARE * np.clip(wrong, -LARGEST_HEIGHT_STEP, LARGEST_HEIGHT_STEP)


def lean_step(angle: np.ndarray, wanted: float | np.ndarray) -> np.ndarray:
    """By how much the amplitude of a lean is to change, for angles in degrees that are wrong."""
    return SHARE * LEAN_REACH * np.clip(_tangent(wanted - angle), -LARGEST_LEAN_STEP, LARGEST_LEAN_STEP)


def slender_lean_step(have: Measured, wanted: float | np.ndarray, closed: bool) -> np.ndarray:
    """The same for lines that may be higher than they are apart.

    A lean ``p exp(-d / l)`` that varies along the wall as exp(iks) turns lines that are ``spacing`` apart by
    ``p / (spacing (1 / l + |k|))``, or if they are longer than the wave by ``p / (spacing height k^2)``: they lean the
    more, the higher they are, where all of them do, and the less where each leans against the next.
    """
    ratio, wrong = have.height / have.spacing, _tangent(wanted - have.angle)
    ends = (wrong[-2:-1], wrong[1:2]) if closed else (wrong[:1], wrong[-1:])
    around = np.concatenate([ends[0], wrong, ends[1]])
    wave = RIPPLES * ratio * (wrong - 0.5 * (around[2:] + around[:-2]))
    alone = lean_step(have.angle, wanted) / np.maximum(ratio, 1.0)
    return alone + SHARE * LEAN_REACH * np.clip(wave, -LARGEST_LEAN_STEP, LARGEST_LEAN_STEP)


def _tangent(angle: np.ndarray) -> np.ndarray:
    """Of an angle in degrees, which is large at most."""
    return np.tan(np.clip(np.radians(angle), -1.2, 1.2))


def limited(amplitude: np.ndarray, most: float = LARGEST_CONTROL) -> np.ndarray:
    """Control functions within Sorenson's limits."""
    return np.clip(amplitude, -most, most)


def controlled(
    levels: Levels,
    walls: list[Wall],
    growth: np.ndarray,
    *,
    most_steps: int = MOST_STEPS,
    anew: bool = True,
    height_aim: float = HEIGHT_AIM,
    progress: Progress = silent,
) -> Controlled:
    """Solve on the finest of ``levels`` with control functions ``growth`` and those that the walls come to need.

    The finest level's grid is improved as it is, unless it is to be found ``anew`` from the coarser ones. Where heights
    cannot be had within ``height_aim`` `HEIGHT_WITHIN` will do.
    """
    finest = levels.levels[0]
    unit = max(finest.residual(), ROUNDING / RESIDUAL_WITHIN)
    levels.set_growth(growth)
    if anew:
        full_multigrid(levels, 2)
    controls = _controls(levels, walls)
    residuals, worst = [unit, finest.residual()], []
    best, damping = (np.inf, None, None), 1.0
    for step in range(most_steps + 1):
        r = finest.points_without_ghosts
        found = [measured(r, control.wall.side, levels.sign, finest.cyclic) for control in controls]
        went = judged(walls, found)
        angle, height = went.angle, went.height
        settled = angle < ANGLE_WITHIN and residuals[-1] < RESIDUAL_WITHIN * unit
        worst.append(angle / ANGLE_WITHIN + height / height_aim)
        if settled and height < max(HEIGHT_WITHIN, height_aim) and worst[-1] < best[0]:
            best = worst[-1], went, r.copy()
        if damping == 1 and _stalled(worst, SHORT_PATIENCE):
            damping, worst = DAMPED, worst[-1:]
        if (settled and height < height_aim) or _stalled(worst, PATIENCE) or step == most_steps:
            break
        theta = growth.copy()
        for control, have in zip(controls, found, strict=True):
            control.step(have, first=step == 0)
            control.add(theta, have, control.distance(r))
            if control.slide is not None:
                control.slide.step(from_wall(r, control.wall.side), have, control.wall.angle, control.closed)
        finest.wrap()
        levels.set_growth(limited(theta, LARGEST_IN_PLANE))
        if step == 0:  # where the start solves the equations, as in a box, there is nothing to measure by but this
            unit = max(unit, finest.residual())
        safe_cycle(levels, damping=damping)
        residuals.append(finest.residual())
        if not np.isfinite(residuals[-1]):  # astray, from where no step leads back
            break
        advance(progress, step / most_steps, f"angle within {angle:.2g} degrees, height within {height:.1%}")
    history = tuple(residual / unit for residual in residuals)
    if best[1] is None:
        return replace(went, history=history, converged=False)
    finest.put(best[2])
    return replace(best[1], history=history, converged=True)


def _stalled(worst: list[float], patience: int) -> bool:
    """Whether the last steps gained nothing."""
    return len(worst) > patience and min(worst[-patience:]) > 0.98 * min(worst[:-patience])


def _controls(levels: Levels, walls: list[Wall]) -> list[_Control]:
    """A control of each wall, that does nothing yet."""
    finest = levels.levels[0]
    points = finest.points_without_ghosts
    controls = [_Control.of(wall, points.shape[1:], finest.cyclic, walls) for wall in walls]
    for control in controls:
        if control.wall.slides:
            control.slide = Slide(from_wall(points, control.wall.side)[..., 0])
    return controls
