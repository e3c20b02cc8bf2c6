"""Control functions of elliptic grids: from the boundary's spacing, from the user, and from what attracts lines.

All of them end as logarithms of growth from cell to cell, (2, ni, nj): see `winslow`. In the survey's notation (2.5.1)
the control function P of i is -2 tanh(theta / 2), in units of the index.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Union

import numpy as np

from ..errors import InvalidInput

ControlFunction = Union[np.ndarray, Callable[[np.ndarray, np.ndarray], np.ndarray]]
"""(ni, nj) values, or a function of (ni, nj) numbers i and j that returns them."""
LARGEST_GROWTH = 2.0
"""Cells that grow by more than exp(2) from one to the next are no grid that differences could be taken on."""


def from_boundary(points: np.ndarray, *, cyclic: bool = False) -> np.ndarray:
    """Growth that carries the boundary's spacing into the interior.

    On a side along i where lines leave it at right angles, the equations give P = -(ln |r_i| / |r_j|)_i, which counts
    the growth that the boundary's curvature brings by itself. (P. D. Thomas and J. F. Middlecoff, AIAA J. 18 (1980),
    also leave out |r_j|: straight lines leave a straight side.) |r_j| at the side is that of the given grid. Between
    opposite sides the growth is interpolated linearly. A cyclic grid has no sides along j: its growth along j is the
    mean of the given grid's own.

    Parameters
    ----------
    points : (ni, nj, 2) float
        A grid between the sides, such as by transfinite interpolation.
    cyclic : bool
        Whether the last row along i is the first.

    Returns
    -------
    (2, ni, nj) float

    Examples
    --------
    >>> x, y = np.meshgrid(np.arange(5.0), 2.0 ** np.arange(4), indexing="ij")
    >>> growth = from_boundary(np.stack([x, y], axis=-1))
    >>> bool(abs(growth[0]).max() < 1e-12), bool(abs(growth[1] - np.log(2)).max() < 1e-12)
    (True, True)
    """
    ni, nj = points.shape[:2]
    growth = np.empty((2, ni, nj))
    south, north = (_along_side(points[:, k], points[:, m], cyclic) for k, m in ((0, 1), (-1, -2)))
    growth[0] = _between(south, north, nj)
    if cyclic:
        growth[1] = np.mean([_along_side(points[i], points[i + 1], False) for i in range(ni - 1)], axis=0)
    else:
        west, east = (_along_side(points[k], points[m], False) for k, m in ((0, 1), (-1, -2)))
        growth[1] = _between(west, east, ni).T
    return np.clip(growth, -LARGEST_GROWTH, LARGEST_GROWTH)


def _along_side(side: np.ndarray, next_line: np.ndarray, closed: bool) -> np.ndarray:
    """(n,) growth along a side, less that of the distance to the next line."""
    step = np.linalg.norm(np.diff(side, axis=0), axis=1)
    away = np.log(np.maximum(np.linalg.norm(next_line - side, axis=1), 1e-300))
    if closed:
        step, away = np.concatenate([step[-1:], step, step[:1]]), np.concatenate([away[-2:-1], away, away[1:2]])
        return np.diff(np.log(step)) - 0.5 * (away[2:] - away[:-2])
    inside = np.diff(np.log(step)) - 0.5 * (away[2:] - away[:-2])
    return np.concatenate([inside[:1], inside, inside[-1:]]) if len(inside) else np.zeros(len(side))


def _between(first: np.ndarray, last: np.ndarray, lines: int) -> np.ndarray:
    """(n, lines) linear interpolation from one side to the opposite one."""
    share = np.linspace(0, 1, lines)
    return (1 - share) * first[:, None] + share * last[:, None]


def from_user(functions: Sequence[ControlFunction], shape: tuple[int, int]) -> np.ndarray:
    """Growth that stands for the user's control functions P and Q.

    Parameters
    ----------
    functions : two of (ni, nj) float, or callables
        P and Q of ``g22 (r_ii + P r_i) - 2 g12 r_ij + g11 (r_jj + Q r_j) = 0``; i and j count points.
    shape : tuple of two int
        Points along i and j.

    Returns
    -------
    (2, ni, nj) float

    Raises
    ------
    InvalidInput
        If there are not two, or their values are not finite, not of that shape, or not between -2 and 2.

    Examples
    --------
    >>> from_user((lambda i, j: 0.1 * (i - 1), np.full((3, 3), -0.2)), (3, 3))[:, 2, 1].round(4)
    array([-0.1001,  0.2007])
    """
    if len(functions) != 2:
        raise InvalidInput(f"needs P and Q, got {len(functions)} functions", parameter="control_functions")
    i, j = np.meshgrid(*(np.arange(n, dtype=float) for n in shape), indexing="ij")
    growth = np.empty((2, *shape))
    for name, function, into in zip("PQ", functions, growth, strict=True):
        values = np.asarray(function(i, j) if callable(function) else function, float)
        if values.shape not in (shape, ()):
            raise InvalidInput(f"{name} needs shape {shape}, got {values.shape}", parameter="control_functions")
        if not (np.abs(values) < 2).all():  # false for NaN
            worst = values.flat[np.argmax(np.where(np.isfinite(values), np.abs(values), np.inf))]
            raise InvalidInput(
                f"{name} must stay between -2 and 2, where lines would cross, got {worst:g}",
                parameter="control_functions",
            )
        into[:] = -2 * np.arctanh(0.5 * values)
    return growth


@dataclass(frozen=True)
class Attractor:
    """A grid line, or a grid point, that draws the lines around it near (Thompson, Thames and Mastin 1974).

    Parameters
    ----------
    i, j : float, optional
        Number of the line along j, of that along i, or both: the point where they meet.
    strength : float
        Logarithm of the growth from cell to cell that starts there; negative pushes lines away.
    reach : float
        Cells over which the growth falls to 1 / e.

    Raises
    ------
    InvalidInput
        If neither i nor j is given, or a number is out of range.

    Examples
    --------
    >>> Attractor(i=10, strength=0.2)
    Attractor(i=10, j=None, strength=0.2, reach=5.0)
    """

    i: float | None = None
    j: float | None = None
    strength: float = 0.1
    reach: float = 5.0

    def __post_init__(self) -> None:
        if self.i is None and self.j is None:
            raise InvalidInput("needs the number of a line: give i, j, or both", parameter="attractors")
        if not abs(self.strength) <= LARGEST_GROWTH:
            raise InvalidInput(
                f"strength must be between {-LARGEST_GROWTH:g} and {LARGEST_GROWTH:g}, got {self.strength}",
                parameter="attractors",
            )
        if not 0 < self.reach < np.inf:
            raise InvalidInput(f"reach must be a positive number of cells, got {self.reach}", parameter="attractors")


def from_attractors(attractors: Sequence[Attractor], shape: tuple[int, int]) -> np.ndarray:
    """Growth away from each attractor that falls off with the number of cells to it.

    Parameters
    ----------
    attractors : sequence of Attractor
        Lines and points.
    shape : tuple of two int
        Points along i and j.

    Returns
    -------
    (2, ni, nj) float

    Examples
    --------
    >>> from_attractors([Attractor(i=1, strength=0.5, reach=1)], (4, 2))[0, :, 0].round(3)
    array([-0.184,  0.   ,  0.184,  0.068])
    """
    indices = np.meshgrid(*(np.arange(n, dtype=float) for n in shape), indexing="ij")
    growth = np.zeros((2, *shape))
    for attractor in attractors:
        away = [0 * n if at is None else n - at for n, at in zip(indices, (attractor.i, attractor.j), strict=True)]
        fall = attractor.strength * np.exp(-np.hypot(*away) / attractor.reach)
        for direction in (0, 1):
            growth[direction] += np.sign(away[direction]) * fall
    return np.clip(growth, -LARGEST_GROWTH, LARGEST_GROWTH)
