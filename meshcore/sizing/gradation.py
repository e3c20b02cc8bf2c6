"""Gradation: how fast sizes may grow from one place to the next."""

from __future__ import annotations

import numpy as np

from ..errors import InvalidInput
from ..mesh import Mesh
from . import _gradation_kernels as kernels
from .background import background_field, checked_sizes
from .size_field import SizeField, evaluated


def limited(mesh: Mesh, sizes: str | np.ndarray | SizeField, gradation: float) -> np.ndarray:
    """Sizes lowered where they grow too fast along an edge of a background mesh.

    Along each edge of length l the sizes at its ends come to differ by at most ``gradation * l``. Of all sizes that
    keep to this and are nowhere above the given ones, these are the largest. Neighbouring triangles of sizes h and
    growth * h stand h apart: a growth from one triangle to the next of 1.2 is a gradation of 0.2.

    Parameters
    ----------
    mesh : Mesh
        Cells of any kind.
    sizes : str, (n,) float or callable
        Name of a point array, a size for each point, or a size field, which is asked at the points.
    gradation : float
        Largest growth of the size per unit length; 0.1 to 0.5 is usual.

    Returns
    -------
    (n,) float
        A size for each point; points without cells keep theirs.

    Raises
    ------
    InvalidInput
        If a size is not finite or not greater than zero, or ``gradation`` is not.

    References
    ----------
    Survey, section 3.2.3. H. Borouchaki, F. Hecht, P. J. Frey, "Mesh gradation control", Int. J. Numer. Meth. Engng 43
    (1998).

    Examples
    --------
    >>> curve = Mesh([[0, 0], [1, 0], [2, 0], [3, 0]], {"line": [[0, 1], [1, 2], [2, 3]]})
    >>> limited(curve, np.array([0.1, 9.0, 9.0, 0.5]), 0.5)
    array([0.1, 0.6, 1. , 0.5])
    """
    gradation = checked_gradation(gradation)
    sizes = evaluated(sizes, mesh.points, "sizes") if callable(sizes) else checked_sizes(mesh, sizes, "sizes")
    edges = mesh.edges
    along = mesh.points[edges[:, 1]] - mesh.points[edges[:, 0]]
    scale = float(np.abs(along).max(initial=0.0)) or 1.0  # squares of lengths below 1e-154 would underflow
    length = scale * np.linalg.norm(along / scale, axis=1)
    ends = np.concatenate([edges[:, 0], edges[:, 1]])
    order = np.argsort(ends, kind="stable")
    start = np.concatenate([[0], np.cumsum(np.bincount(ends, minlength=mesh.n_points))])
    neighbour = np.concatenate([edges[:, 1], edges[:, 0]])[order]
    result = sizes.copy()
    kernels.limit(start, neighbour, np.tile(length, 2)[order], gradation, result)
    return result


def limited_field(size_field: SizeField, background: Mesh, gradation: float) -> SizeField:
    """A size field that grows no faster than ``gradation``, as far as a background mesh resolves it.

    It is the smaller of the field itself and of its `limited` values at the background's points, interpolated.

    Parameters
    ----------
    size_field : callable
        Takes (m, 3) points, returns (m,) sizes.
    background : Mesh
        Triangles in a plane or tetrahedra, at least as fine as the details of the field.
    gradation : float
        Largest growth of the size per unit length along the background's edges.

    Returns
    -------
    SizeField
        Called with (m, 3) points.

    Raises
    ------
    InvalidInput
        If sizes are not finite and greater than zero, or ``gradation`` is not.

    Examples
    --------
    >>> from meshcore.gallery import triangulated_square
    >>> step = lambda points: np.where(points[:, 0] < 0.5, 0.01, 1.0)
    >>> field = limited_field(step, triangulated_square(20), 0.2)
    >>> field(np.array([[0.0, 0.5, 0.0], [0.95, 0.5, 0.0]])).round(6)
    array([0.01, 0.11])
    """
    slow = background_field(background, limited(background, size_field, gradation))
    return lambda points: np.minimum(evaluated(size_field, points), slow(points))


def checked_gradation(gradation: float) -> float:
    """A gradation as a float.

    Raises
    ------
    InvalidInput
        If it is not finite and greater than zero.

    Examples
    --------
    >>> checked_gradation(0.2)
    0.2
    """
    if not np.isfinite(gradation) or gradation <= 0:
        raise InvalidInput(
            f"must be finite and greater than zero, got {gradation}; 0.2 is usual", parameter="gradation"
        )
    return float(gradation)
