"""Size fields: how long an edge may be, as a function of place."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..errors import InvalidInput
from ..geometry.alternating_digital_tree import Nearest
from ..mesh import Mesh

SizeField = Callable[[np.ndarray], np.ndarray]
"""``size_field(points)`` takes (m, 3) points and returns (m,) largest edge lengths, greater than zero."""


def answered(size_field: SizeField, points: np.ndarray, parameter: str = "size_field") -> np.ndarray:
    """The numbers that a field returns at (m, 3) points, of any shape.

    Raises
    ------
    InvalidInput
        If it fails, or returns no numbers.

    Examples
    --------
    >>> answered(lambda p: [1, 2], np.zeros((2, 3)))
    array([1., 2.])
    """
    try:
        answer = np.asarray(size_field(points))
        if answer.dtype.kind == "c":
            raise TypeError("it returned complex numbers")
        return answer.astype(np.float64, copy=False)
    except (TypeError, ValueError) as error:
        raise InvalidInput(f"failed on an (m, 3) array of points: {error}", parameter=parameter) from error


def evaluated(size_field: SizeField, points: np.ndarray, parameter: str = "size_field") -> np.ndarray:
    """(m,) float: a size field at (m, 3) points, checked.

    Raises
    ------
    InvalidInput
        If it does not return one number a point, or a size is not finite or not greater than zero.

    Examples
    --------
    >>> evaluated(lambda p: 0.1 + p[:, 0], np.zeros((2, 3)))
    array([0.1, 0.1])
    """
    sizes = answered(size_field, points, parameter)
    if sizes.ndim == 0:
        sizes = np.full(len(points), float(sizes))
    if sizes.shape != (len(points),):
        raise InvalidInput(
            f"must return shape ({len(points)},), one size a point, got {sizes.shape}", parameter=parameter
        )
    bad = np.flatnonzero(~np.isfinite(sizes) | (sizes <= 0))
    if len(bad):
        place = ", ".join(f"{x:.6g}" for x in points[bad[0]])
        raise InvalidInput(
            f"is {sizes[bad[0]]:g} at ({place}); sizes must be finite and greater than zero", parameter=parameter
        )
    return sizes


def constant(size: float) -> SizeField:
    """The same size everywhere.

    Parameters
    ----------
    size : float
        Edge length.

    Returns
    -------
    SizeField
        Called with (m, 3) points.

    Raises
    ------
    InvalidInput
        If the size is not finite or not greater than zero.

    Examples
    --------
    >>> constant(0.5)(np.zeros((2, 3)))
    array([0.5, 0.5])
    """
    size = _positive("size", size)
    return lambda points: np.full(len(points), size)


def smallest(*fields: SizeField) -> SizeField:
    """The smallest of several size fields at each place.

    Parameters
    ----------
    *fields : callable
        Each takes (m, 3) points and returns (m,) sizes.

    Returns
    -------
    SizeField
        Called with (m, 3) points.

    Raises
    ------
    InvalidInput
        If there is none.

    Examples
    --------
    >>> field = smallest(constant(0.5), lambda points: points[:, 0])
    >>> field(np.array([[0.1, 0.0, 0.0], [3.0, 0.0, 0.0]]))
    array([0.1, 0.5])
    """
    if not fields:
        raise InvalidInput("needs at least one size field, got none", parameter="fields")

    def field(points: np.ndarray) -> np.ndarray:
        sizes = evaluated(fields[0], points, "fields")
        for other in fields[1:]:
            sizes = np.minimum(sizes, evaluated(other, points, "fields"))
        return sizes

    return field


def graded(
    curve_or_points: Mesh | np.ndarray, near: float | np.ndarray, growth: float, far: float, *, radius: float = 0.0
) -> SizeField:
    """A source: a size that is ``near`` at points, curves or surfaces and grows with the distance, up to ``far``.

    ::

        size                           ______ far
          |                       ____/
          |                  ____/    slope = growth - 1
          |  near __________/
          +---------------------------------> distance
                  <-radius->

    Neighbouring triangles of sizes h and growth * h stand h apart, so the size grows by ``growth - 1`` a unit length.

    Parameters
    ----------
    curve_or_points : Mesh or (n, 3) float
        Triangles and quads, whose whole area counts; line cells, whose whole length does; or points, each on its own.
        A boundary is given as a whole.
    near : float or (n,) float
        Edge length at the source; one for each of its points, linear between them, or one for all.
    growth : float
        Ratio of the sizes of neighbouring triangles, above 1; 1.1 to 1.3 is usual.
    far : float
        Edge length that is not exceeded.
    radius : float
        Distance up to which the size stays ``near``.

    Returns
    -------
    SizeField
        Called with (m, 3) points.

    Raises
    ------
    InvalidInput
        If sizes are not positive, ``near`` exceeds ``far``, ``growth`` is not above 1, or ``radius`` is negative.

    References
    ----------
    Survey, section 3.2.3.

    Examples
    --------
    >>> field = graded(np.array([[0.0, 0, 0]]), near=0.1, growth=1.5, far=1.0)
    >>> field(np.array([[0.0, 0, 0], [1, 0, 0], [100, 0, 0]]))
    array([0.1, 0.6, 1. ])
    """
    far = _positive("far", far)
    mesh = curve_or_points if isinstance(curve_or_points, Mesh) else Mesh(curve_or_points, {})
    near = np.broadcast_to(_positive("near", near), (mesh.n_points,)) if np.ndim(near) == 0 else near
    near = np.asarray(near, float)
    if near.shape != (mesh.n_points,):
        raise InvalidInput(f"needs one size, or one for each of {mesh.n_points} points", parameter="near")
    if len(near):
        _positive("near", float(near[np.argmin(np.where(np.isfinite(near), near, -np.inf))]))
        if near.max() > far:
            raise InvalidInput(f"must not exceed far = {far:g}, got {near.max():g}", parameter="near")
    if not np.isfinite(growth) or growth <= 1:
        raise InvalidInput(f"must be above 1, got {growth}; 1.2 is usual", parameter="growth")
    if not np.isfinite(radius) or radius < 0:
        raise InvalidInput(f"must be finite and not negative, got {radius}", parameter="radius")
    parts = [(corners, Nearest(mesh.points[corners])) for corners in _simplices(mesh)]

    def field(points: np.ndarray) -> np.ndarray:
        points = np.asarray(points, float).reshape(-1, 3)
        sizes = np.full(len(points), far)
        for corners, nearest in parts:
            item, weights, distance = nearest.query(points)
            at = (near[corners[item]] * weights).sum(axis=1)
            sizes = np.minimum(sizes, at + (growth - 1) * np.maximum(distance - radius, 0.0))
        return sizes

    return field


def _positive(name: str, value: float) -> float:
    if not np.isfinite(value) or value <= 0:
        raise InvalidInput(f"must be finite and greater than zero, got {value}", parameter=name)
    return float(value)


def _simplices(mesh: Mesh) -> list[np.ndarray]:
    """The surfaces and the lines of a mesh, or else its points: (m, 3), (m, 2) or (m, 1) int."""
    if not mesh.n_points:
        raise InvalidInput("needs at least one point, got none", parameter="curve_or_points")
    solid = mesh.boundary if mesh.dimension == 3 else mesh
    quads = solid.get("quad")
    found = [np.concatenate([solid.get("triangle"), quads[:, :3], quads[:, [0, 2, 3]]]), mesh.get("line")]
    found = [corners for corners in found if len(corners)]
    return found or [np.arange(mesh.n_points)[:, None]]
