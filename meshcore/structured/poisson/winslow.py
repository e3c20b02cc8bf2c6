"""Planar elliptic grids: the transformed Laplace and Poisson equations, solved by nonlinear multigrid (survey 2.5.1).

A grid is started by full multigrid: solved on a coarse level, interpolated and improved on each finer one. Cycles then
go on until the grid is near enough to the converged one, sped up by Anderson mixing.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from ...progress import Progress, advance, silent
from ...threads import Workers, available_threads
from .multigrid import CLOSE, DAMPED, Anderson
from .winslow_levels import FEWEST_CELLS, Levels

MOST_CYCLES = 60
SIDES = {"south": np.s_[:, 0], "east": np.s_[-1], "north": np.s_[:, -1], "west": np.s_[0]}
"""The four sides of a grid, in the order in which they follow each other."""
CUT = ("west", "east")
"""Sides that are no boundary where a grid is cyclic."""
_FEWEST_CELLS_TO_START = 32
_CYCLES_AT_THE_START, _ENOUGH_AT_THE_START = 6, 3e-3  # or until the residual has fallen so far
# A cycle after which the residual is so many times as large is taken back.
_GROWTH = 1.5
_DEPTH = 4  # earlier cycles that the acceleration looks back on
_MIXED_FROM = 2  # cycle from which it does, where grids need only be close
_PATIENCE = 6  # cycles without a smaller residual after which steps become more careful
# Shares of coarse corrections and of smoothing's steps that are made in turn: smoothing with coefficients that change
# while lines are solved can go to and fro between a few grids for ever.
_CARE = ((1.0, 1.0), (DAMPED, 1.0), (DAMPED, 0.5))


@dataclass(frozen=True)
class Solution:
    """A grid that solves the discrete Winslow equations, or nearly.

    Attributes
    ----------
    points : (ni, nj, 2) float
        The grid; its boundary is that of the start, to the last bit.
    history : tuple of float
        Residual at the start and after each cycle, in units of the given grid's.
    error : float
        Estimate of the largest distance of a node from its converged place, in units of the shortest edge there.
    converged : bool
        Whether what was asked for was reached.
    """

    points: np.ndarray
    history: tuple[float, ...]
    error: float
    converged: bool


def smoothed_grid(points: np.ndarray, *, cyclic: bool = False, threads: int | None = None) -> np.ndarray:
    """The Laplace grid with the boundary of a planar grid, from which the solver starts.

    Parameters
    ----------
    points : (ni, nj, 2) float
        A grid, possibly folded.
    cyclic : bool
        Whether the last row along i is the first, as in an O-grid.
    threads : int, optional
        How many may work; the result is the same for any number.

    Returns
    -------
    (ni, nj, 2) float
        Smooth points with the same boundary, to the last bit.

    Examples
    --------
    >>> x, y = np.meshgrid(np.linspace(0, 1, 5) ** 2, np.linspace(0, 1, 4), indexing="ij")
    >>> x[:, 0] = x[:, -1] = np.linspace(0, 1, 5)
    >>> smoothed_grid(np.stack([x, y], axis=-1))[1:4, 1, 0].round(6)
    array([0.25, 0.5 , 0.75])
    """
    return winslow(points, cyclic=cyclic, threads=threads).points


def winslow(
    points: np.ndarray,
    *,
    growth: np.ndarray | None = None,
    cyclic: bool = False,
    tolerance: float | None = None,
    most_cycles: int = MOST_CYCLES,
    threads: int | None = None,
    progress: Progress = silent,
) -> Solution:
    """Solve the Winslow equations with the boundary of a planar grid, starting from its interior.

    Parameters
    ----------
    points : (ni, nj, 2) float
        The start, for instance by transfinite interpolation; it may be folded.
    growth : (2, ni, nj) float, optional
        Control functions along i and j, as logarithms of the growth from one cell to the next: theta makes cells along
        a straight line grow by exp(theta), with the control function phi = -2 tanh(theta / 2). Left out: Laplace.
    cyclic : bool
        Whether the last row along i is the first, as in an O-grid.
    tolerance : float, optional
        Residual to reach, in units of the start's. Left out, cycles go on until each node is within a thousandth of the
        shortest edge at it from its converged place, as far as can be told from how cycles converge.
    most_cycles : int
        Cycles after which to give up.
    threads : int, optional
        How many may work; the result is the same for any number.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Solution

    Examples
    --------
    >>> t = np.linspace(0, np.pi / 2, 9)[:, None]
    >>> r = np.geomspace(1, 2, 5)
    >>> start = np.stack([r * np.cos(t), r * np.sin(t)], axis=-1)[::-1]
    >>> start[1:-1, 1:-1] += 0.05
    >>> solution = winslow(start, tolerance=1e-10)
    >>> radii = np.linalg.norm(solution.points, axis=-1)
    >>> bool(abs(radii - r).max() < 0.01), solution.converged
    (True, True)
    """
    if min(points.shape[:2]) < 3:
        return Solution(points.copy(), (0.0,), 0.0, True)
    with Workers(threads or available_threads()) as workers:
        frame = Frame.of(points)
        levels = levels_of(frame.inside(points), cyclic, workers)
        if growth is not None:
            levels.set_growth(growth)
        finest = levels.levels[0]
        scale = finest.residual()
        if scale < 1e-14:  # the start solves the equations, up to rounding
            return Solution(points.copy(), (1.0,), 0.0, True)
        residual = full_multigrid(levels)
        if not np.isfinite(residual):  # coarse levels led astray
            finest.put(frame.inside(points))
            residual = scale
        history = [1.0, residual / scale]
        error, converged = _converge(levels, scale, history, tolerance, most_cycles, progress)
        found = frame.outside(finest.points_without_ghosts, points, CUT if cyclic else ())
        return Solution(found, tuple(history), error, converged)


@dataclass(frozen=True)
class Frame:
    """The coordinates that are worked in: near 1, as (2, ni, nj).

    Parameters
    ----------
    origin : (2,) float
        What is the origin there.
    size : float
        What is 1 there, a power of two.
    """

    origin: np.ndarray
    size: float

    @classmethod
    def of(cls, points: np.ndarray) -> Frame:
        """The frame that suits a grid, whose boundary tells how far it reaches."""
        loop = boundary_loop(points)
        low, high = loop.min(axis=0), loop.max(axis=0)
        return cls(low / 2 + high / 2, float(np.exp2(np.ceil(np.log2((high - low).max())))))

    def inside(self, points: np.ndarray) -> np.ndarray:
        """(2, ni, nj) from (ni, nj, 2)."""
        return np.ascontiguousarray(np.moveaxis((points - self.origin) / self.size, -1, 0))

    def outside(self, inside: np.ndarray, boundary: np.ndarray, free: Collection[str] = ()) -> np.ndarray:
        """(ni, nj, 2) from (2, ni, nj); but for the ``free`` sides, the outermost points are those of ``boundary``."""
        points = np.moveaxis(inside, 0, -1) * self.size + self.origin
        for side, line in SIDES.items():
            if side not in free:
                points[line] = boundary[line]
        return points


def orientation(points: np.ndarray) -> float:
    """1 if i, j of a planar (ni, nj, 2) grid are right-handed, else -1: its boundary tells, folds inside do not matter.

    Examples
    --------
    >>> x, y = np.meshgrid([0.0, 1, 2], [0.0, 1], indexing="ij")
    >>> orientation(np.stack([x, y], axis=-1)), orientation(np.stack([y, x], axis=-1))
    (1.0, -1.0)
    """
    loop = boundary_loop(points)
    x, y = (loop - loop[0]).T
    return 1.0 if (x[:-1] * y[1:] - y[:-1] * x[1:]).sum() > 0 else -1.0


def boundary_loop(points: np.ndarray) -> np.ndarray:
    """(n, 2) points once round the boundary of a (ni, nj, 2) grid, along i first; the last is the first.

    Examples
    --------
    >>> x, y = np.meshgrid([0.0, 1], [0.0, 1], indexing="ij")
    >>> boundary_loop(np.stack([x, y], axis=-1)).tolist()
    [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]]
    """
    return np.concatenate([points[:-1, 0], points[-1, :-1], points[:0:-1, -1], points[0, ::-1]])


def levels_of(r: np.ndarray, cyclic: bool, workers: Workers, fewest: tuple[int, int] = FEWEST_CELLS) -> Levels:
    """`Levels` of a grid, with its (2, ni, nj) coordinates put on the finest."""
    turn = ((r[:, 1] - r[:, 0]) * (r[:, -1] - r[:, -2])).sum(axis=0)
    levels = Levels(
        (r.shape[1] - 1, r.shape[2] - 1),
        cyclic=cyclic,
        sharp=bool(min(turn[0], turn[-1]) < 0),
        shift=r[:, -1, 0] - r[:, 0, 0],
        sign=orientation(np.moveaxis(r, 0, -1)),
        workers=workers,
        fewest=fewest,
    )
    levels.levels[0].put(r)
    return levels


def full_multigrid(levels: Levels, cycles: int = 1) -> float:
    """Improve the grid of the finest level by ``cycles`` on each level, from a coarse one upwards: its residual.

    What a level hands on is the difference between its solution and the start as it samples it.
    """
    start = 0
    while start < len(levels.tables) and min(levels.levels[start + 1].cells) >= _FEWEST_CELLS_TO_START:
        levels.sample(start)
        start += 1
    samples = {number: levels.levels[number].r.copy() for number in range(1, start + 1)}
    for number in range(start, -1, -1):
        level = levels.levels[number]
        level.f[:] = 0
        if number < start:
            levels.correct(number, samples.pop(number + 1))
        first = level.residual() if number == start else 0.0
        for _ in range(cycles if number < start else _CYCLES_AT_THE_START):
            residual = safe_cycle(levels, number)
            if residual < _ENOUGH_AT_THE_START * first:
                break
    return residual


def safe_cycle(levels: Levels, number: int = 0, damping: float = 1.0) -> float:
    """A cycle from level ``number``; where it would make matters worse, with shorter corrections or none: residual."""
    level = levels.levels[number]
    before, residual = level.r.copy(), level.residual()
    for _ in range(4):
        levels.cycle(number, damping)
        reached = level.residual()
        if reached <= _GROWTH * residual:  # false for NaN
            return reached
        level.r[:] = before
        damping *= 0.4
    for _ in range(5):
        level.smooth()
    return level.residual()


def _converge(
    levels: Levels,
    scale: float,
    history: list[float],
    tolerance: float | None,
    most_cycles: int,
    progress: Progress,
) -> tuple[float, bool]:
    """Cycles until the residual, or the estimate of the error, is small enough: that estimate, whether it is.

    Residuals join the ``history``.
    """
    finest = levels.levels[0]
    rates, error = Rates(), np.inf
    before, mixing = finest.r.copy(), None
    care, best_at = 0, 0
    for cycle in range(1, most_cycles + 1):
        levels.cycle(damping=_CARE[care][0])
        residual = finest.residual() / scale
        if not residual <= _GROWTH * history[-1]:
            finest.r[:] = before
            mixing = None
            safe_cycle(levels)
            residual = finest.residual() / scale
            if not np.isfinite(residual):  # cells without size, which no sweep can mend
                finest.r[:] = before
                return np.inf, False
        history.append(residual)
        error = rates.error(finest.largest_move(before), mixed=mixing is not None and mixing.active)
        if error <= CLOSE if tolerance is None else residual <= tolerance:
            return error, True
        best_at = best_at if residual >= min(history[:-1]) else cycle
        if cycle - best_at > _PATIENCE:
            care, best_at, mixing = care + 1, cycle, None
            if care == len(_CARE):
                break
            levels.set_step(_CARE[care][1])
        advance(progress, cycle / most_cycles, f"residual {residual:.1e}")
        if tolerance is not None or cycle >= _MIXED_FROM:
            mixing = mixing or Anderson(finest.r.size, levels.workers, _DEPTH, np.float32)
            _mix(levels, before, mixing)
        before[:] = finest.r
    return error, False


def _mix(levels: Levels, before: np.ndarray, mixing: Anderson) -> None:
    """Improve what a cycle made of ``before`` by what earlier ones did, unless that folds further cells."""
    finest = levels.levels[0]
    folds = finest.folds(levels.sign)
    mixing.accelerate(before.reshape(-1), finest.r.reshape(-1))
    if finest.folds(levels.sign) > folds:
        finest.r[:] = mixing.last.reshape(finest.r.shape)
        mixing.forget()


class Rates:
    """Estimates how far a grid is from the converged one, by how the moves of cycles shrink.

    A cycle that contracts errors by ``rate`` and moves a node by ``move`` leaves ``move * rate / (1 - rate)``. Moves
    tell the rate as long as nothing but cycles makes them: after mixing they shrink faster than a cycle contracts.

    Examples
    --------
    >>> rates = Rates()
    >>> rates.error(1.0), rates.error(0.25), rates.error(0.02, mixed=True)
    (1.0, 0.08333333333333333, 0.006666666666666667)
    """

    def __init__(self) -> None:
        self._last, self._rate = np.inf, 0.5

    def error(self, move: float, *, mixed: bool = False) -> float:
        """The estimate after a cycle whose largest move is given, and whether it began from a mixture."""
        if np.isfinite(self._last):
            self._rate = min(max(move / self._last, self._rate if mixed else 0.1), 0.9)
        self._last = move
        return move * self._rate / (1 - self._rate)
