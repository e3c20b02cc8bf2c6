"""Size fields: how long an edge may be, as a function of place."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..errors import InvalidInput
from ..geometry.curves import Curve
from ..mesh import Mesh

SizeField = Callable[[np.ndarray], np.ndarray]
"""``size_field(points)`` takes (m, 3) points and returns (m,) largest edge lengths, greater than zero."""

_MAX_SAMPLES = 2_000_000


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
    try:
        sizes = np.asarray(size_field(points), dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InvalidInput(f"failed on an (m, 3) array of points: {error}", parameter=parameter) from error
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


def graded(curve_or_points: Curve, near: float, growth: float, far: float) -> SizeField:
    """A size that is ``near`` at a curve and grows with the distance from it, up to ``far``.

    ::

        size                     ______ far
          |                 ____/
          |            ____/    slope = growth - 1
          |  near ____/
          +-----------------------------> distance

    Neighbouring triangles of sizes h and growth * h stand h apart, so the size grows by ``growth - 1`` a unit length.

    Parameters
    ----------
    curve_or_points : Mesh or (n, 3) float
        Line cells, whose whole length counts; or points, each on its own.
    near : float
        Edge length at the curve.
    growth : float
        Ratio of the sizes of neighbouring triangles, above 1; 1.1 to 1.3 is usual.
    far : float
        Edge length that is not exceeded.

    Returns
    -------
    SizeField
        Called with (m, 3) points.

    Raises
    ------
    InvalidInput
        If sizes are not positive, ``near`` exceeds ``far``, or ``growth`` is not above 1.

    Examples
    --------
    >>> field = graded(np.array([[0.0, 0, 0]]), near=0.1, growth=1.5, far=1.0)
    >>> field(np.array([[0.0, 0, 0], [1, 0, 0], [100, 0, 0]]))
    array([0.1, 0.6, 1. ])
    """
    for name, value in (("near", near), ("far", far)):
        if not np.isfinite(value) or value <= 0:
            raise InvalidInput(f"must be finite and greater than zero, got {value}", parameter=name)
    if near > far:
        raise InvalidInput(f"must not exceed far = {far:g}, got {near:g}", parameter="near")
    if not np.isfinite(growth) or growth <= 1:
        raise InvalidInput(f"must be above 1, got {growth}; 1.2 is usual", parameter="growth")
    samples, gap = _samples(curve_or_points, near)
    from scipy.spatial import cKDTree  # a third of a second, which not every start should take

    tree = cKDTree(samples)

    def field(points: np.ndarray) -> np.ndarray:
        distance, _ = tree.query(np.asarray(points, float).reshape(-1, 3))
        # A point of the curve is at most half a gap from a sample: the error stays on the side of smaller sizes.
        return np.minimum(near + (growth - 1) * np.maximum(distance - gap / 2, 0.0), far)

    return field


def _samples(curve: Any, near: float) -> tuple[np.ndarray, float]:
    """Points so dense on the lines that gaps are at most half of ``near``, and the largest gap."""
    mesh = curve if isinstance(curve, Mesh) else Mesh(curve, {})
    if not mesh.n_points:
        raise InvalidInput("needs at least one point, got none", parameter="curve_or_points")
    lines = mesh.get("line")
    if not len(lines):
        return mesh.points, 0.0
    start, stop = mesh.points[lines[:, 0]], mesh.points[lines[:, 1]]
    length = np.linalg.norm(stop - start, axis=1)
    gap = max(near / 2, float(length.sum()) / _MAX_SAMPLES)
    parts = np.maximum(np.ceil(length / gap), 1).astype(np.int64)
    line = np.repeat(np.arange(len(lines)), parts)
    step = np.arange(len(line)) - np.repeat(np.cumsum(parts) - parts, parts)
    share = (step / parts[line])[:, None]
    inner = start[line] + share * (stop - start)[line]
    return np.concatenate([inner, stop]), float((length / parts).max())
