"""Elliptic grids in space: the transformed Laplace and Poisson equations, solved by multigrid (survey 2.5.1, 2.6)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ...mesh.extent import extents
from ...progress import Progress, silent
from ...threads import Workers, available_threads
from . import _winslow_3d_kernels as kernels
from .multigrid import Level, Outcome, first_level, solve
from .periodic_faces import Ghosts, Pair
from .transfer import LEAST_CELLS, NUMBERS_A_THREAD, coarsened, coarser, growth_on_coarse

WEAK = 0.3
"""A direction whose coupling is less than this part of the strongest is not coarsened yet."""
FIRST_CELLS = 16
"""Full multigrid begins on the coarsest grid with so many cells in each direction, or as many as there are."""
_NONE = np.zeros(0)


def solved(
    points: np.ndarray,
    *,
    growth: np.ndarray | None = None,
    tolerance: float | None = None,
    most: int = 50,
    pairs: Sequence[Pair] = (),
    threads: int | None = None,
    progress: Progress = silent,
) -> tuple[np.ndarray, Outcome]:
    """The elliptic grid with the boundary of a given one.

    Parameters
    ----------
    points : (ni, nj, nk, 3) float
        A start, whose boundary is kept to the last bit.
    growth : (3, ni, nj, nk) float, optional
        Control functions along i, j and k, as logarithms of the growth from one cell to the next: theta makes cells
        along a straight line grow by exp(theta), with the control function -2 tanh(theta / 2) in index units. By
        default there are none: Laplace.
    tolerance : float, optional
        Residual to reach, as part of the start's; by default the grid is within a thousandth of the local spacing
        of the converged one.
    most : int
        Cycles that are done at most.
    pairs : sequence of Pair
        Faces through which the grid runs on; their points are free, but for those on other faces.
    threads : int, optional
        By default as many as there are cores; the grid does not depend on it.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    points : (ni, nj, nk, 3) float
    outcome : Outcome
        Folded cells are not looked for: the equations in their discrete form may have folded solutions.

    Examples
    --------
    >>> box = np.stack(np.meshgrid(*[np.linspace(0, 1, 5)] * 3, indexing="ij"), axis=-1)
    >>> dented = box.copy()
    >>> dented[2, 2, 2] = 0.6
    >>> points, outcome = solved(dented, tolerance=1e-10)
    >>> bool(abs(points - box).max() < 1e-9)
    True
    """
    if min(points.shape[:3]) < 3:
        return points.copy(), Outcome([0.0], True, 0.0)
    frame = BlockFrame.of(points)
    with Workers(threads or available_threads()) as workers:
        levels = levels_of(frame.inside(points), growth, workers, pairs=frame.pairs(pairs))
        outcome = solve(
            levels,
            first=first_level(levels, FIRST_CELLS),
            tolerance=tolerance,
            most=most,
            workers=workers,
            progress=progress,
        )
    return frame.outside(levels[0].nodes, points, pairs), outcome


@dataclass(frozen=True)
class BlockFrame:
    """The coordinates that are worked in: near 1, as (3, ni, nj, nk).

    Parameters
    ----------
    centre : (3,) float
        What is the origin there.
    size : float
        What is 1 there.
    """

    centre: np.ndarray
    size: float

    @classmethod
    def of(cls, points: np.ndarray) -> BlockFrame:
        """The frame that suits a block."""
        return cls(points.reshape(-1, 3).mean(axis=0), float(extents(points).max()) or 1.0)

    def inside(self, points: np.ndarray) -> np.ndarray:
        """(3, ni, nj, nk) from (ni, nj, nk, 3)."""
        return np.ascontiguousarray(np.moveaxis((points - self.centre) / self.size, -1, 0))

    def pairs(self, pairs: Sequence[Pair]) -> list[Pair]:
        """Faces that are alike, in these coordinates."""
        return [pair.scaled(self.centre, self.size) for pair in pairs]

    def outside(
        self, inside: np.ndarray, boundary: np.ndarray, pairs: Sequence[Pair] = (), slid: Sequence[str] = ()
    ) -> np.ndarray:
        """(ni, nj, nk, 3) from (3, ni, nj, nk); points of the boundary are kept, but for those of pairs and ``slid``.

        The last face of each pair is the image of the first to the last bit.
        """
        points = self.centre + self.size * np.moveaxis(inside, 0, -1)
        axes = [pair.axis for pair in pairs]
        free = tuple(slice(None) if axis in axes else slice(1, -1) for axis in range(3))
        new = boundary.copy()
        new[free] = points[free]
        for pair in pairs:
            pair.close(new, boundary, free)
        for face in slid:
            layer = 0 if face.endswith("min") else -1
            at = tuple(layer if name == face[0] else slice(1, -1) for name in "ijk")
            new[at] = points[at]
        return new


def count_folded(points: np.ndarray, sign: float = 1.0) -> int:
    """Number of cells of a block with a corner whose Jacobian, times ``sign``, is not positive.

    Examples
    --------
    >>> box = np.stack(np.meshgrid(*[np.arange(3.0)] * 3, indexing="ij"), axis=-1)
    >>> count_folded(box), count_folded(box[::-1])
    (0, 8)
    """
    return _count(np.ascontiguousarray(np.moveaxis(points, -1, 0)), sign)


def is_left_handed(points: np.ndarray) -> bool:
    """Whether most cells of a block are left-handed.

    Examples
    --------
    >>> box = np.stack(np.meshgrid(*[np.arange(3.0)] * 3, indexing="ij"), axis=-1)
    >>> is_left_handed(box), is_left_handed(box[::-1])
    (False, True)
    """
    return count_folded(points, -1.0) < count_folded(points)


def _count(x: np.ndarray, sign: float) -> int:
    folded = np.zeros(x.shape[1] - 1, np.int64)
    kernels.count_folded(x.reshape(-1), x.shape[1:], sign, 0, len(folded), folded)
    return int(folded.sum())


class _Space(Level):
    """One grid of a block: x and f of shape (3, ni, nj, nk), with ghosts where it runs on."""

    def __init__(self, x: np.ndarray, growth: np.ndarray, sign: float, workers: Workers, ghosts: Ghosts):
        self.x = np.ascontiguousarray(x)
        self.ghosts, self._kept = ghosts, ghosts.kept(self.x.shape[1:])
        ghosts.wrap(self.x)
        # Not zeros, here and below: they do not come in large pages, and first writes to small ones cost.
        self.f = np.full(self.x.shape, 0.0)
        self.transfer = None
        self._defect: np.ndarray | None = None
        self._sign, self._workers = sign, workers
        self._shape = self.x.shape[1:]
        self.set_growth(growth)

    @property
    def nodes(self) -> np.ndarray:
        """(3, ni, nj, nk) points without ghosts."""
        return self.ghosts.without(self.x)

    def set_growth(self, growth: np.ndarray) -> None:
        """Set the control functions, (3, ni, nj, nk) logarithms of growth with ghosts; no numbers for Laplace."""
        control = -2 * np.tanh(growth.reshape(-1) / 2)
        self._flat = self.x.reshape(-1), self.f.reshape(-1), control, self._kept, self._shape

    def smooth(self, *, back: bool) -> None:
        """Zebra lines along i, j and k, or in the reverse order."""
        self.ghosts.wrap(self.x)
        for axis in (2, 1, 0) if back else (0, 1, 2):
            slices = self._shape[1 if axis == 0 else 0] - 2
            for parity in (1, 0) if back else (0, 1):
                self._run(partial(self._relax, axis, parity), 0, (slices - parity + 1) // 2)
                self.ghosts.wrap(self.x)

    def _relax(self, axis: int, parity: int, first: int, stop: int) -> None:
        lines = np.empty(self._shape[axis] * kernels.FIELDS * kernels.LINES)
        if axis == 2:
            kernels.relax_along(*self._flat, parity, first, stop, _row(), lines)
        else:
            kernels.relax_across(*self._flat, axis, parity, first, stop, _row(), lines)

    def defect(self) -> np.ndarray:
        """f - N(x), zero on the boundary; the array is used again by the next call."""
        if self._defect is None:
            self._defect = np.full(self.x.shape, 0.0)
        self._squares(self._defect.reshape(-1))
        self.ghosts.wrap_vectors(self._defect)
        return self._defect

    def residual(self) -> float:
        """Root mean square of the lengths by which point relaxation would move the nodes."""
        interior = np.prod([n - 2 for n in self._shape])
        return float(np.sqrt(self._squares(_NONE).sum() / interior))

    def _squares(self, defect: np.ndarray) -> np.ndarray:
        squares = np.zeros(self._shape[0])
        self.ghosts.wrap(self.x)
        self._run(
            lambda first, stop: kernels.defect(*self._flat, first, stop, _row(), defect, squares), 1, self._shape[0] - 1
        )
        return squares

    def folded(self) -> int:
        """Cells with a corner whose Jacobian is zero or has the wrong sign."""
        folded = np.zeros(self._shape[0], np.int64)
        x, shape = self._flat[0], self._shape
        self._run(lambda first, stop: kernels.count_folded(x, shape, self._sign, first, stop, folded), 0, shape[0] - 1)
        return int(folded.sum())

    def largest_move(self, before: np.ndarray) -> float:
        """Largest move of a node since ``before``, in local spacings."""
        moves = np.zeros(self._shape[0])
        x, shape, old = self._flat[0], self._shape, before.reshape(-1)
        self._run(lambda first, stop: kernels.largest_move(x, old, shape, first, stop, moves), 1, shape[0] - 1)
        return float(moves.max())

    def couplings(self) -> np.ndarray:
        """(3,) how strongly the equations couple nodes along each direction, summed over all nodes."""
        shares = np.zeros((self._shape[0], 3))
        kernels.couplings(*self._flat, 1, self._shape[0] - 1, _row(), shares)
        return shares.sum(axis=0)

    def _run(self, work, start: int, stop: int) -> None:
        self._workers.run(work, start, stop, most=self.x.size // NUMBERS_A_THREAD)


def _row() -> np.ndarray:
    return np.empty(kernels.FIELDS * kernels.NODES)


def levels_of(
    x: np.ndarray,
    growth: np.ndarray | None,
    workers: Workers,
    *,
    pairs: Sequence[Pair] = (),
    least: int = LEAST_CELLS,
) -> list[Level]:
    """The grid (3, ni, nj, nk) and ever coarser ones, down to where no direction can be coarsened to ``least`` cells.

    Where cells are needles, zebra lines do not smooth what changes along them: such a direction waits until the others
    are as coarse (semi-coarsening).
    """
    ghosts = Ghosts(pairs)
    theta = np.empty((3, 0, 0, 0)) if growth is None else ghosts.added(growth)
    sign = -1.0 if _count(x, -1.0) < _count(x, 1.0) else 1.0
    finest = _Space(ghosts.added(x), theta, sign, workers, ghosts)
    levels: list[Level] = [finest]
    strength = finest.couplings()
    while True:
        shape = ghosts.nodes(levels[-1].x.shape[1:])
        lines = coarsened(shape, _strong(shape, strength, least), least)
        if not lines:
            return levels
        transfer = levels[-1].transfer = ghosts.transfer(lines, workers)
        ghosts = ghosts.coarsened(transfer)
        theta = theta if growth is None else growth_on_coarse(transfer, theta)
        levels.append(_Space(transfer.sampled(levels[-1].x), theta, sign, workers, ghosts))
        strength = strength / [4.0 if line.coarse < line.fine else 1.0 for line in lines]


def set_growth(levels: Sequence[Level], growth: np.ndarray) -> None:
    """Set the control functions of all levels from (3, ni, nj, nk) logarithms of growth on the finest."""
    growth = levels[0].ghosts.added(growth)
    for level in levels:
        level.set_growth(growth)
        if level.transfer is not None:
            growth = growth_on_coarse(level.transfer, growth)


def _strong(shape: tuple[int, ...], strength: np.ndarray, least: int) -> np.ndarray:
    """(3,) bool: directions whose coupling is not weak beside that of others that can be coarsened."""
    can = np.array([coarser(n - 1, least) < n - 1 for n in shape])
    return can & (strength >= WEAK * strength[can].max(initial=0.0))
