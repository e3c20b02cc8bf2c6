"""Surfaces in space as functions of two parameters: by a formula, or by a spline through a grid of points."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import RectBivariateSpline

from ..errors import InvalidGeometry, InvalidInput

STEP = 1e-5
"""Part of a parameter's range over which a formula's tangents are taken."""

_OVERLAP = 24
"""Rows by which a cyclic spline overlaps itself: what its ends do falls off by 0.27 a row, to nothing in this many."""


class Surface(ABC):
    """A surface S(u, v) over the rectangle ``low`` <= (u, v) <= ``high``."""

    @property
    @abstractmethod
    def low(self) -> np.ndarray:
        """(2,) least parameters."""

    @property
    @abstractmethod
    def high(self) -> np.ndarray:
        """(2,) greatest parameters."""

    @abstractmethod
    def points(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(..., 3) points at parameters of any equal shape."""

    @abstractmethod
    def tangents(self, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(..., 3) derivatives of the points by u, and by v."""


@dataclass(frozen=True)
class ParametricSurface(Surface):
    """A surface by a formula.

    Parameters
    ----------
    function : callable
        ``function(u, v)`` takes arrays of equal shape and returns (..., 3) points.
    u, v : tuple of two float
        Ranges of the parameters.

    Raises
    ------
    InvalidInput
        If a range is empty, or the function returns another shape or numbers that are not finite.

    Examples
    --------
    >>> roof = ParametricSurface(lambda u, v: np.stack([u, v, 1 - u * u], axis=-1), u=(-1, 1))
    >>> roof.points(np.array([0.5]), np.array([0.25]))
    array([[0.5 , 0.25, 0.75]])
    """

    function: Callable[[np.ndarray, np.ndarray], np.ndarray]
    u: tuple[float, float] = (0.0, 1.0)
    v: tuple[float, float] = (0.0, 1.0)

    def __post_init__(self) -> None:
        for name, (low, high) in (("u", self.u), ("v", self.v)):
            if not -np.inf < low < high < np.inf:
                raise InvalidInput(f"needs a lesser and a greater number, got {(low, high)}", parameter=name)

    @property
    def low(self) -> np.ndarray:
        """(2,) least parameters."""
        return np.array([self.u[0], self.v[0]], float)

    @property
    def high(self) -> np.ndarray:
        """(2,) greatest parameters."""
        return np.array([self.u[1], self.v[1]], float)

    def points(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(..., 3) points at parameters of any equal shape."""
        points = np.asarray(self.function(u, v), float)
        if points.shape != (*np.shape(u), 3):
            raise InvalidInput(f"must return shape {(*np.shape(u), 3)}, got {points.shape}", parameter="function")
        bad = np.argwhere(~np.isfinite(points).all(axis=-1))
        if len(bad):
            at = tuple(bad[0])
            raise InvalidInput(f"is {points[at].tolist()} at u = {u[at]:.6g}, v = {v[at]:.6g}", parameter="function")
        return points

    def tangents(self, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(..., 3) derivatives by u and by v: quotients of differences that stay within the ranges."""
        step_u, step_v = STEP * (self.high - self.low)
        less, more = np.maximum(u - step_u, self.u[0]), np.minimum(u + step_u, self.u[1])
        by_u = (self.points(more, v) - self.points(less, v)) / (more - less)[..., None]
        less, more = np.maximum(v - step_v, self.v[0]), np.minimum(v + step_v, self.v[1])
        return by_u, (self.points(u, more) - self.points(u, less)) / (more - less)[..., None]


@dataclass(frozen=True, eq=False)
class SplineSurface(Surface):
    """The bicubic spline through a grid of points.

    Parameters
    ----------
    grid : (m, n, 3) float
        Points, two or more along each direction. Parameters run from 0 to 1 as the lengths of the lines do on average.
    cyclic : bool
        Whether the last row of points is the first, through which the surface runs on smoothly; u has no end then.

    Raises
    ------
    InvalidInput, InvalidGeometry
        If the shape is another, points are not finite, or all neighbours across some line coincide.

    Examples
    --------
    >>> x, y = np.meshgrid(np.linspace(0, 2, 6), np.linspace(0, 1, 5), indexing="ij")
    >>> surface = SplineSurface(np.stack([x, y, x * y], axis=-1))
    >>> surface.points(np.array([0.5]), np.array([0.5])).round(12)
    array([[1. , 0.5, 0.5]])
    """

    grid: np.ndarray
    cyclic: bool = False

    def __post_init__(self) -> None:
        grid = np.ascontiguousarray(self.grid, float)
        if grid.ndim != 3 or grid.shape[2] != 3 or min(grid.shape[:2]) < 2:
            raise InvalidInput(f"needs shape (m, n, 3) of 2 x 2 points or more, got {grid.shape}", parameter="grid")
        bad = np.argwhere(~np.isfinite(grid).all(axis=-1))
        if len(bad):
            raise InvalidGeometry(f"point {tuple(bad[0].tolist())} is {grid[tuple(bad[0])].tolist()}", parameter="grid")
        object.__setattr__(self, "grid", grid)
        for axis in (0, 1):
            zero = np.flatnonzero(np.diff(self._knots[axis]) <= 0)
            if len(zero):
                raise InvalidGeometry(
                    f"all points of lines {zero[0]} and {zero[0] + 1} along direction {1 - axis} coincide; remove one",
                    parameter="grid",
                )

    @property
    def low(self) -> np.ndarray:
        """(2,) least parameters."""
        return np.array([-np.inf if self.cyclic else 0.0, 0.0])

    @property
    def high(self) -> np.ndarray:
        """(2,) greatest parameters."""
        return np.array([np.inf if self.cyclic else 1.0, 1.0])

    @cached_property
    def _knots(self) -> tuple[np.ndarray, np.ndarray]:
        knots = []
        for axis in (0, 1):
            steps = np.linalg.norm(np.diff(self.grid, axis=axis), axis=-1).mean(axis=1 - axis)
            length = np.concatenate([[0.0], np.cumsum(steps)])
            knots.append(length / (length[-1] or 1.0))
        return knots[0], knots[1]

    @cached_property
    def _splines(self) -> list[RectBivariateSpline]:
        knots, grid = list(self._knots), self.grid
        if self.cyclic:
            row = np.arange(-_OVERLAP, len(grid) + _OVERLAP)
            turn, row = np.divmod(row, len(grid) - 1)
            knots[0], grid = knots[0][row] + turn, grid[row]
        for axis in np.flatnonzero(np.array(grid.shape[:2]) == 2):  # scipy derives from the second degree on only
            knots[axis] = np.array([0, 0.5, 1])
            grid = np.insert(grid, 1, grid.mean(axis=axis), axis=axis)
        degree = [min(3, n - 1) for n in grid.shape[:2]]
        return [RectBivariateSpline(*knots, grid[..., q], kx=degree[0], ky=degree[1]) for q in range(3)]

    @property
    def parameters(self) -> np.ndarray:
        """(m, n, 2) parameters of the grid's own points."""
        return np.stack(np.meshgrid(*self._knots, indexing="ij"), axis=-1)

    def points(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(..., 3) points at parameters of any equal shape."""
        u = self._within(u)
        return np.stack([spline.ev(u, v) for spline in self._splines], axis=-1)

    def tangents(self, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(..., 3) derivatives of the points by u, and by v."""
        u = self._within(u)
        by_u = np.stack([spline.ev(u, v, dx=1) for spline in self._splines], axis=-1)
        return by_u, np.stack([spline.ev(u, v, dy=1) for spline in self._splines], axis=-1)

    def _within(self, u: np.ndarray) -> np.ndarray:
        return u - np.floor(u) if self.cyclic else u
