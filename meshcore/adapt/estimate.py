"""Where to refine: indicators of a P1 field's error on triangles, and marking by share (survey 4.1)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import InvalidGeometry, InvalidInput
from ..mesh import Mesh
from .bisection import edges_of


def variation(mesh: Mesh, field: str | np.ndarray) -> np.ndarray:
    """How much a point field varies over each triangle: the largest difference between two of its corners.

    Parameters
    ----------
    mesh : Mesh
        With "triangle" cells; others are left out.
    field : str or (n,) or (n, k) float
        Name of a point array, or the values. Of vectors, the length of the difference is taken.

    Returns
    -------
    indicator : (m,) float
        One value per triangle, in the unit of the field.

    Raises
    ------
    InvalidInput
        If there are no triangles, no such array, or values are not numbers or not finite.

    References
    ----------
    Survey, section 4.1: indicators by the solution's gradient.

    Examples
    --------
    >>> mesh = Mesh([[0, 0], [1, 0], [1, 1], [0, 1]], {"triangle": [[0, 1, 2], [0, 2, 3]]})
    >>> variation(mesh, np.array([0.0, 5.0, 1.0, 0.0]))
    array([5., 1.])
    """
    triangles = triangles_of(mesh)
    at_corners = _point_values(mesh, field)[triangles]
    differences = at_corners - np.roll(at_corners, 1, axis=1)
    return np.linalg.norm(differences, axis=2).max(axis=1)


def gradient_jump(mesh: Mesh, field: str | np.ndarray) -> np.ndarray:
    """Kelly's error indicator of a piecewise linear field: the jumps of its slope across the edges of each triangle.

    With h_E the length of edge E and [du/dn] the jump of the slope across it, constant along it,

    .. math:: \\eta_T^2 = \\frac12 \\sum_{E \\subset \\partial T} h_E \\int_E [\\partial u / \\partial n]^2 ds.

    Edges of one triangle do not count, as under a natural boundary condition. On a surface in space the slopes are
    taken within each triangle, perpendicular to the edge. ``marked(indicator**2, fraction)`` is Doerfler's marking.

    Parameters
    ----------
    mesh : Mesh
        With "triangle" cells, planar or in space; others are left out.
    field : str or (n,) or (n, k) float
        Name of a point array, or the values. Of vectors, the squares of all components are summed.

    Returns
    -------
    indicator : (m,) float
        eta_T, one value per triangle, in the unit of the field.

    Raises
    ------
    InvalidInput
        If there are no triangles, no such array, or values are not numbers or not finite.
    InvalidGeometry
        If a triangle has no area.

    References
    ----------
    D. W. Kelly, J. P. de S. R. Gago, O. C. Zienkiewicz, I. Babuska, "A posteriori error analysis and adaptive
    processes in the finite element method", Int. J. Numer. Meth. Engng. 19 (1983). R. Verfuerth, "A posteriori error
    estimation techniques for finite element methods" (2013), section 1.4.

    Examples
    --------
    A field with a kink along the diagonal of a square, then one without:

    >>> mesh = Mesh([[0, 0], [1, 0], [1, 1], [0, 1]], {"triangle": [[0, 1, 2], [0, 2, 3]]})
    >>> gradient_jump(mesh, np.array([0.0, 1.0, 0.0, 1.0])).round(6)
    array([2.828427, 2.828427])
    >>> gradient_jump(mesh, mesh.points[:, 0])
    array([0., 0.])
    """
    triangles = triangles_of(mesh)
    values = _point_values(mesh, field)[triangles]
    corners = mesh.points[triangles]
    sides = np.roll(corners, 1, axis=1) - np.roll(corners, -1, axis=1)
    twice_area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    refuse(mesh, twice_area == 0)
    # Outward slope times length on edge i is -sum_j u_j e_i.e_j / (2 area): the gradient is u_j (n x e_j) / (2 area),
    # the outward normal times length e_i x n.
    stiffness = np.einsum("mik,mjk->mij", sides, sides) / twice_area[:, None, None]
    fluxes = -np.einsum("mij,mjk->mik", stiffness, values)
    edges = edges_of(triangles, mesh.n_points)
    n_edges = len(edges.keys)
    where = edges.of_triangle.ravel()
    jumps = np.zeros(n_edges)
    for component in fluxes.reshape(-1, fluxes.shape[2]).T:
        jumps += np.bincount(where, component, n_edges) ** 2
    jumps[np.diff(edges.starts) == 1] = 0.0
    return np.sqrt(0.5 * jumps[edges.of_triangle].sum(axis=1))


def marked(indicator: np.ndarray, fraction: float) -> np.ndarray:
    """The fewest cells that together hold a share of the indicator (Doerfler's marking, "fixed energy fraction").

    Parameters
    ----------
    indicator : (m,) float
        One value per cell, not negative. For an error estimate eta_T in a norm whose squares add up, give eta_T^2.
    fraction : float
        Share of the sum, from 0 (none) to 1 (all cells that hold any).

    Returns
    -------
    marks : (m,) bool
        True for the cells with the largest values; among equal ones the first.

    Raises
    ------
    InvalidInput
        If a value is negative or not finite, the shape is wrong, or the fraction is outside 0 to 1.

    References
    ----------
    W. Doerfler, "A convergent adaptive algorithm for Poisson's equation", SIAM J. Numer. Anal. 33 (1996).

    Examples
    --------
    >>> marked(np.array([1.0, 5.0, 0.0, 4.0]), 0.6)
    array([False,  True, False,  True])
    """
    indicator = checked_indicator(indicator)
    if not 0 <= fraction <= 1:
        raise InvalidInput(f"must be between 0 and 1, got {fraction!r}", parameter="fraction")
    marks = np.zeros(len(indicator), bool)
    largest = indicator.max(initial=0.0)
    if largest == 0 or fraction == 0:
        return marks
    order = np.argsort(-indicator, kind="stable")
    held = np.cumsum(indicator[order] / largest)
    enough = int(np.searchsorted(held, fraction * held[-1])) + 1
    marks[order[:enough]] = True
    return marks


def checked_indicator(indicator: Any) -> np.ndarray:
    """``indicator`` as (m,) float, or `InvalidInput` that names the first value at fault."""
    try:
        values = np.asarray(indicator, dtype=float)
    except (TypeError, ValueError):
        raise InvalidInput("needs numbers, one per cell", parameter="indicator") from None
    if values.ndim != 1:
        raise InvalidInput(f"needs one number per cell, got shape {values.shape}", parameter="indicator")
    bad = np.flatnonzero(~np.isfinite(values) | (values < 0))
    if len(bad):
        raise InvalidInput(
            f"cell {bad[0]} has {values[bad[0]]} ({len(bad)} such cells); give finite values that are not negative",
            parameter="indicator",
        )
    return values


def triangles_of(mesh: Mesh) -> np.ndarray:
    """(m, 3) int: the triangles, of which there must be some."""
    triangles = mesh.get("triangle")
    if not len(triangles):
        raise InvalidInput(f"has no triangles: {mesh!r}; triangulate it first", parameter="mesh")
    return triangles


def refuse(mesh: Mesh, degenerate: np.ndarray) -> None:
    """Raise `InvalidGeometry` if any triangle of (m,) bool is at fault."""
    bad = np.flatnonzero(degenerate)
    if len(bad):
        start = next(where.start for kind, _, where in mesh.blocks() if kind == "triangle")
        place = mesh.points[mesh.cells["triangle"][bad[0]]].mean(axis=0).tolist()
        raise InvalidGeometry(
            f"cell {start + bad[0]} at {place} has no area ({len(bad)} such triangles); remove or repair them",
            parameter="mesh",
            cells=start + bad,
        )


def _point_values(mesh: Mesh, field: str | np.ndarray) -> np.ndarray:
    """(n, k) float: values at points, by name or as given."""
    if isinstance(field, str):
        if field not in mesh.point_data:
            known = ", ".join(mesh.point_data) or "none"
            raise InvalidInput(f"there is no point array {field!r}; there are {known}", parameter="field")
        field = mesh.point_data[field]
    try:
        values = np.asarray(field, dtype=float)
    except (TypeError, ValueError):
        raise InvalidInput("needs numbers, one or more per point", parameter="field") from None
    if values.shape[:1] != (mesh.n_points,):
        raise InvalidInput(
            f"needs one value per point, that is {mesh.n_points}, got shape {values.shape}", parameter="field"
        )
    values = values.reshape(mesh.n_points, -1)
    bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
    if len(bad):
        raise InvalidInput(
            f"point {bad[0]} has {values[bad[0]].tolist()} ({len(bad)} such points); give finite values",
            parameter="field",
        )
    return values
