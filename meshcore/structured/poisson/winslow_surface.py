"""Elliptic grids on curved surfaces: with parameters, through a grid's points, or of facets (survey 2.6)."""

from __future__ import annotations

import numpy as np

from ...geometry.closest import FacetedSurface
from ...geometry.surfaces import SplineSurface, Surface
from ...progress import Progress, silent
from ...threads import Workers
from .control_functions import from_boundary
from .multigrid import Outcome, first_level, solve
from .surface_levels import levels_on
from .wall_control import Wall
from .wall_control_surface import FEWEST_CELLS, controlled
from .wall_outcome import Controlled

FIRST_CELLS = 32
"""Full multigrid begins on the coarsest grid with so many cells in each direction, or as many as there are."""


def solved(
    surface: Surface,
    parameters: np.ndarray,
    *,
    growth: np.ndarray | None = None,
    cyclic: bool = False,
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
    cyclic : bool
        Whether the grid's last row is its first, on a surface on which u + 1 is u: the points of both are free.
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
    return _solved(surface, parameters, growth, cyclic, tolerance, most, progress)


def draped(
    surface: FacetedSurface,
    points: np.ndarray,
    *,
    growth: np.ndarray | None = None,
    cyclic: bool = False,
    tolerance: float | None = None,
    most: int = 50,
    progress: Progress = silent,
) -> tuple[np.ndarray, Outcome]:
    """The elliptic grid on a surface of facets with the boundary of a given one.

    In the discrete equations g^ij r_ij, what is tangential to the surface's smooth normals vanishes, while the points
    lie on the facets. So the grid is harmonic on the surface that the facets stand for, as near as they come to it.

    Parameters
    ----------
    surface : FacetedSurface
        Where the points lie.
    points : (ni, nj, 3) float
        A start near the surface, whose boundary is kept as it is.
    growth, cyclic, tolerance, most, progress
        As for `solved`.

    Returns
    -------
    points : (ni, nj, 3) float
    outcome : Outcome
        Folded cells are not looked for.

    Examples
    --------
    >>> from meshcore.gallery import triangulated_square
    >>> start = np.stack(np.meshgrid(*[np.linspace(0, 1, 7)] * 2, [0.0], indexing="ij"), axis=-1)[:, :, 0]
    >>> moved = start.copy()
    >>> moved[3, 3] = 0.6
    >>> points, outcome = draped(FacetedSurface(triangulated_square()), moved, tolerance=1e-10)
    >>> bool(abs(points - start).max() < 1e-9)
    True
    """
    return _solved(surface, points, growth, cyclic, tolerance, most, progress)


def _solved(surface, start, growth, cyclic, tolerance, most, progress) -> tuple[np.ndarray, Outcome]:
    """(ni, nj, m) unknowns from a start in them; the boundary's are kept."""
    if min(start.shape[:2]) < 3:
        return start.copy(), Outcome([0.0], True, 0.0)
    with Workers(1) as workers:
        levels = levels_on(surface, np.ascontiguousarray(np.moveaxis(start, -1, 0)), growth, cyclic, workers)
        first = first_level(levels, FIRST_CELLS)
        outcome = solve(levels, first=first, tolerance=tolerance, most=most, workers=workers, progress=progress)
        levels[0].settle()
    return _with_boundary(start, levels[0].x, cyclic), outcome


def walled(
    surface: Surface | FacetedSurface,
    start: np.ndarray,
    walls: list[Wall],
    growth: np.ndarray | None = None,
    *,
    cyclic: bool = False,
    progress: Progress = silent,
) -> tuple[np.ndarray, Controlled]:
    """The elliptic grid on a surface whose lines leave walls at given angles, and whose cells there have given heights.

    Parameters
    ----------
    surface : Surface or FacetedSurface
        Where the points lie.
    start : (ni, nj, 2) or (ni, nj, 3) float
        Parameters of a surface that has them, or points near facets; the boundary is kept.
    walls : list of Wall
        What is asked, none of which slides.
    growth : (2, ni, nj) float, optional
        Control functions to which those of the walls are added.
    cyclic, progress
        As for `solved`.

    Returns
    -------
    (ni, nj, 2) or (ni, nj, 3) float
        Parameters or points.
    went : Controlled
        Errors of angles and heights.
    """
    growth = np.zeros((2, *start.shape[:2])) if growth is None else growth
    with Workers(1) as workers:
        x = np.ascontiguousarray(np.moveaxis(start, -1, 0))
        levels = levels_on(surface, x, growth, cyclic, workers, FEWEST_CELLS)
        went = controlled(levels, walls, growth, progress=progress)
        levels[0].settle()
    return _with_boundary(start, levels[0].x, cyclic), went


def _with_boundary(start: np.ndarray, x: np.ndarray, cyclic: bool) -> np.ndarray:
    """(ni, nj, m) of x inside, and on the boundary of the start."""
    new = start.copy()
    inner = np.s_[:, 1:-1] if cyclic else np.s_[1:-1, 1:-1]
    new[inner] = np.moveaxis(x, 0, -1)[inner]
    return new


def smoothed(
    points: np.ndarray,
    *,
    controlled: bool = False,
    growth: np.ndarray | None = None,
    cyclic: bool = False,
    tolerance: float | None = None,
    most: int = 50,
    progress: Progress = silent,
) -> tuple[np.ndarray, Outcome]:
    """The elliptic grid on the bicubic surface through the points of a grid, with the same boundary.

    Parameters
    ----------
    points : (ni, nj, 3) float
        A grid in space, or in a plane.
    controlled : bool
        Whether the boundary's spacing is carried inside, or Laplace's equation evens it out.
    growth : (2, ni, nj) float, optional
        Control functions in place of these, as for `solved`.
    cyclic : bool
        Whether the last row is the first: the surface runs on through it, and its points are free.
    tolerance, most, progress
        As for `solved`.

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
    surface = SplineSurface(points, cyclic=cyclic)
    if controlled and growth is None:
        growth = from_boundary(points, cyclic=cyclic)
    found, outcome = solved(
        surface,
        surface.parameters,
        growth=growth,
        cyclic=cyclic,
        tolerance=tolerance,
        most=most,
        progress=progress,
    )
    return on_own_surface(surface, found, points, cyclic), outcome


def on_own_surface(surface: SplineSurface, parameters: np.ndarray, points: np.ndarray, cyclic: bool) -> np.ndarray:
    """(ni, nj, 3) points at parameters; those of the boundary are as they were, to the last bit."""
    new = _with_boundary(
        np.array(points, float), np.moveaxis(surface.points(*np.moveaxis(parameters, -1, 0)), -1, 0), cyclic
    )
    if cyclic:
        new[-1] = new[0]
    return new
