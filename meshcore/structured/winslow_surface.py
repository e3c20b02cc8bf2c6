"""Elliptic grids on curved surfaces, in the surface's parameters (survey 2.6)."""

from __future__ import annotations

import numpy as np

from ..geometry.surfaces import SplineSurface, Surface
from ..progress import Progress, silent
from ..threads import Workers
from . import _winslow_surface_kernels as kernels
from .control_functions import from_boundary
from .multigrid import Level, Outcome, first_level, solve
from .transfer import Transfer, coarsened, growth_on_coarse

FIRST_CELLS = 32
"""Full multigrid begins on the coarsest grid with so many cells in each direction, or as many as there are."""
_NONE = np.zeros(0)


def solved(
    surface: Surface,
    parameters: np.ndarray,
    *,
    growth: np.ndarray | None = None,
    tolerance: float | None = None,
    most: int = 50,
    progress: Progress = silent,
) -> tuple[np.ndarray, Outcome]:
    """The elliptic grid on a surface with the boundary of a given one.

    The coordinates are harmonic on the surface itself (Laplace-Beltrami), so that the grid's points do not depend on
    how the surface is parameterised.

    Parameters
    ----------
    surface : Surface
        Where the points lie; (u, v) to points must be one to one, but for a boundary that is one point.
    parameters : (ni, nj, 2) float
        A start in (u, v), whose boundary is kept.
    growth : (2, ni, nj) float, optional
        Control functions along i and j, as logarithms of the growth from one cell to the next: theta makes cells along
        a straight line grow by exp(theta), with the control function -2 tanh(theta / 2) in index units. By default
        there are none: Laplace.
    tolerance : float, optional
        Residual to reach, as part of the start's; by default the grid is within a thousandth of the local spacing
        of the converged one.
    most : int
        Cycles that are done at most.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    parameters : (ni, nj, 2) float
    outcome : Outcome
        Folded cells are not looked for: the equations in their discrete form may have folded solutions.

    Examples
    --------
    >>> from meshcore.geometry.surfaces import ParametricSurface
    >>> cylinder = ParametricSurface(lambda u, v: np.stack([np.cos(u), np.sin(u), v], axis=-1))
    >>> start = np.stack(np.meshgrid(*[np.linspace(0, 1, 7)] * 2, indexing="ij"), axis=-1)
    >>> moved = start.copy()
    >>> moved[3, 3] = 0.6
    >>> parameters, outcome = solved(cylinder, moved, tolerance=1e-10)
    >>> bool(abs(parameters - start).max() < 1e-9)
    True
    """
    if min(parameters.shape[:2]) < 3:
        return parameters.copy(), Outcome([0.0], True, 0.0)
    with Workers(1) as workers:
        levels = _levels(surface, parameters, growth, workers)
        first = first_level(levels, FIRST_CELLS)
        outcome = solve(levels, first=first, tolerance=tolerance, most=most, workers=workers, progress=progress)
    new = parameters.copy()
    new[1:-1, 1:-1] = np.moveaxis(levels[0].x, 0, -1)[1:-1, 1:-1]
    return new, outcome


def smoothed(
    points: np.ndarray, *, controlled: bool = False, most: int = 50, progress: Progress = silent
) -> tuple[np.ndarray, Outcome]:
    """The elliptic grid on the bicubic surface through the points of a grid, with the same boundary.

    Parameters
    ----------
    points : (ni, nj, 3) float
        A grid in space, or in a plane.
    controlled : bool
        Whether the boundary's spacing is carried inside, or Laplace's equation evens it out.
    most : int
        Cycles that are done at most.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    points : (ni, nj, 3) float
        The boundary is kept to the last bit.
    outcome : Outcome
        Folded cells are not looked for.

    Raises
    ------
    InvalidInput, InvalidGeometry
        If there are less than 2 x 2 points, or lines of them coincide, so that they make no surface.

    Examples
    --------
    >>> x, y = np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 9), indexing="ij")
    >>> uneven = np.stack([x, y + 0.1 * np.sin(np.pi * x) * np.sin(2 * np.pi * y), 0 * x], axis=-1)
    >>> points, outcome = smoothed(uneven)
    >>> bool(abs(points[..., 1] - y).max() < 1e-3)
    True
    """
    surface = SplineSurface(points)
    growth = from_boundary(points) if controlled else None
    found, outcome = solved(surface, surface.parameters, growth=growth, most=most, progress=progress)
    new = np.array(points, float)
    inner = (slice(1, -1), slice(1, -1))
    new[inner] = surface.points(*np.moveaxis(found, -1, 0))[inner]
    return new, outcome


class _Patch(Level):
    """One grid on the surface: x and f of shape (2, ni, nj), and the points and tangents that belong to x."""

    def __init__(self, surface: Surface, size: float, x: np.ndarray, growth: np.ndarray, sign: float):
        self.x = np.ascontiguousarray(x)
        self.f = np.zeros_like(self.x)
        self._surface, self._size, self._sign = surface, size, sign
        self._control = -2 * np.tanh(growth.reshape(-1) / 2)
        self._shape = self.x.shape[1:]
        self._defect = np.zeros_like(self.x)
        self._line = np.empty((3, max(self._shape)))

    def _evaluated(self) -> tuple[np.ndarray, np.ndarray]:
        """Flat points and tangents at x, which is kept on the surface."""
        for q in (0, 1):
            np.clip(self.x[q], self._surface.low[q], self._surface.high[q], out=self.x[q])
        points = self._surface.points(*self.x) / self._size
        tangents = np.concatenate(self._surface.tangents(*self.x), axis=-1) / self._size
        return (np.moveaxis(a, -1, 0).ravel() for a in (points, tangents))  # type: ignore[return-value]

    def smooth(self, *, back: bool) -> None:
        """Zebra lines along i and j, or in the reverse order."""
        for axis in (1, 0) if back else (0, 1):
            r, t = self._evaluated()
            kernels.relax(r, t, self.x.reshape(-1), self.f.reshape(-1), self._control, self._shape, axis, self._line)

    def defect(self) -> np.ndarray:
        """f - N(x), zero on the boundary; the array is used again by the next call."""
        self._squares()
        return self._defect

    def residual(self) -> float:
        """Root mean square of the lengths by which point relaxation would move the nodes."""
        return float(np.sqrt(self._squares() / np.prod([n - 2 for n in self._shape])))

    def _squares(self) -> float:
        r, t = self._evaluated()
        return kernels.defect(r, t, self.f.reshape(-1), self._control, self._shape, self._defect.reshape(-1))

    def folded(self) -> int:
        """Cells with a corner whose angle in the parameters is zero or has the wrong sign."""
        return int((self._sign * corner_areas(np.moveaxis(self.x, 0, -1)) <= 0).any(axis=0).sum())

    def largest_move(self, before: np.ndarray) -> float:
        """Largest move of a node since ``before``, in local spacings."""
        new, old = (self._surface.points(*x) for x in (self.x, np.ascontiguousarray(before)))
        spacing = np.minimum(*(np.linalg.norm(np.gradient(new, axis=axis), axis=-1) for axis in (0, 1)))
        moved = np.linalg.norm(new - old, axis=-1)
        return float((moved / np.maximum(spacing, kernels.TINY))[1:-1, 1:-1].max())


def corner_areas(plane: np.ndarray) -> np.ndarray:
    """(4, ni - 1, nj - 1) twice the signed areas of the triangles at the corners of the cells of a planar grid.

    Examples
    --------
    >>> corner_areas(np.array([[[0, 0], [0, 2]], [[1, 0], [1, 2.0]]])).ravel()
    array([2., 2., 2., 2.])
    """
    quad = [plane[:-1, :-1], plane[1:, :-1], plane[1:, 1:], plane[:-1, 1:]]
    edges = [quad[(k + 1) % 4] - quad[k] for k in range(4)]
    return np.stack(
        [edges[k - 1][..., 0] * edges[k][..., 1] - edges[k - 1][..., 1] * edges[k][..., 0] for k in range(4)]
    )


def _levels(surface: Surface, parameters: np.ndarray, growth: np.ndarray | None, workers: Workers) -> list[Level]:
    """The grid and ever coarser ones, down to where no direction can be coarsened."""
    x = np.ascontiguousarray(np.moveaxis(parameters, -1, 0))
    theta = np.empty((2, 0, 0)) if growth is None else growth
    size = float(np.ptp(surface.points(*x).reshape(-1, 3), axis=0).max()) or 1.0
    sign = 1.0 if corner_areas(parameters).sum() >= 0 else -1.0
    levels: list[Level] = [_Patch(surface, size, x, theta, sign)]
    while lines := coarsened(levels[-1].x.shape[1:]):
        transfer = levels[-1].transfer = Transfer(lines, workers)
        theta = theta if growth is None else growth_on_coarse(transfer, theta)
        levels.append(_Patch(surface, size, transfer.sampled(levels[-1].x), theta, sign))
    return levels
