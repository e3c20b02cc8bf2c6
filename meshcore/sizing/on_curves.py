"""Sizes at the points of a curve or boundary: as its lines are spaced, and as it bends."""

from __future__ import annotations

import numpy as np

from ..errors import InvalidInput
from ..geometry.curves import chains
from ..mesh import Mesh


def boundary_spacing(boundary: Mesh) -> np.ndarray:
    """The mean length of the edges at each point of a boundary: (n,) float.

    With `graded` it carries the spacing of a boundary into the domain. Points without edges get the largest value.

    Parameters
    ----------
    boundary : Mesh
        "line" cells in the plane, triangles and quads in space.

    Returns
    -------
    (n,) float

    Raises
    ------
    InvalidInput
        If there are no edges of any length.

    Examples
    --------
    >>> boundary_spacing(Mesh([[0, 0], [1, 0], [4, 0]], {"line": [[0, 1], [1, 2]]}))
    array([1., 2., 3.])
    """
    ends = boundary.edges
    along = boundary.points[ends[:, 1]] - boundary.points[ends[:, 0]]
    scale = float(np.abs(along).max(initial=0.0))
    if not scale:
        raise InvalidInput("has no lines of any length", parameter="boundary")
    length = scale * np.linalg.norm(along / scale, axis=1)
    real = length > 0
    ends, length = ends[real].ravel(), np.repeat(length[real], 2)
    count = np.bincount(ends, minlength=boundary.n_points)
    mean = np.divide(np.bincount(ends, length, minlength=boundary.n_points), np.maximum(count, 1))
    return np.where(count > 0, mean, mean.max())


def curvature_spacing(curve: Mesh, *, angle: float = 15.0, largest: float, corner_angle: float = 30.0) -> np.ndarray:
    """Sizes at the points of a curve with which each line of it turns by an angle: (n,) float.

    The radius of curvature at a point is the mean length of its two lines over the angle between them; the size is that
    radius times the angle wanted.

    Parameters
    ----------
    curve : Mesh
        "line" cells that resolve the curve.
    angle : float
        Degrees by which one line may turn against the next.
    largest : float
        Size that is not exceeded, as where the curve is straight.
    corner_angle : float
        Degrees; points where the curve turns by more are corners, not bends, and get ``largest``.

    Returns
    -------
    (n,) float

    Raises
    ------
    InvalidInput
        If ``angle`` or ``largest`` are not finite and greater than zero.

    References
    ----------
    Survey, section 3.2.3.

    Examples
    --------
    >>> from meshcore.gallery import circle
    >>> curvature_spacing(circle(64, radius=2.0), angle=18.0, largest=1.0)[:2].round(2)
    array([0.63, 0.63])
    """
    for name, value in (("angle", angle), ("largest", largest)):
        if not np.isfinite(value) or value <= 0:
            raise InvalidInput(f"must be finite and greater than zero, got {value}", parameter=name)
    sizes = np.full(curve.n_points, float(largest))
    for chain in chains(curve):
        points = curve.points[chain]
        closed = chain[0] == chain[-1]
        along = np.diff(points, axis=0)
        keep = np.flatnonzero(along.any(axis=1))
        chain, along = chain[:-1][keep], along[keep]
        before = np.roll(along, 1, axis=0)
        if not closed:
            chain, along, before = chain[1:], along[1:], before[1:]
        if not len(chain):
            continue
        scale = float(np.abs(along).max())
        lengths = [scale * np.linalg.norm(v / scale, axis=1) for v in (before, along)]
        units = [v / length[:, None] for v, length in zip((before, along), lengths, strict=True)]
        turn = np.arctan2(np.linalg.norm(np.cross(*units), axis=1), (units[0] * units[1]).sum(axis=1))
        bends = (turn > 0) & (turn <= np.radians(corner_angle))
        radius = 0.5 * (lengths[0] + lengths[1]) / np.where(bends, turn, 1.0)
        sizes[chain] = np.where(bends, np.minimum(np.radians(angle) * radius, largest), largest)
    return sizes
