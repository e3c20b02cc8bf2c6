"""Planes in space: the plane of a nearly planar loop, and coordinates in it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from ..errors import InvalidGeometry


@dataclass(frozen=True, eq=False)
class Plane:
    """A plane with an orthonormal frame.

    Parameters
    ----------
    origin : (3,) float
        A point of the plane.
    axes : (2, 3) float
        Unit vectors along its own x and y; their cross product is the normal.

    Examples
    --------
    >>> plane = fitted_plane([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
    >>> plane.to_plane([[0.5, 0.25, 1]])
    array([[0.5 , 0.25]])
    >>> plane.to_space([[0.5, 0.25]])
    array([[0.5 , 0.25, 1.  ]])
    """

    origin: np.ndarray
    axes: np.ndarray

    @property
    def normal(self) -> np.ndarray:
        """(3,) float: unit normal."""
        return np.cross(*self.axes)

    @cached_property
    def _kept_axes(self) -> tuple[int, int] | None:
        """The two coordinates that the plane's own are, where the frame only drops one."""
        first, second = self.axes.argmax(axis=1).tolist()
        only_drops = self.axes[0, first] == self.axes[1, second] == 1 and not self.origin[[first, second]].any()
        return (first, second) if only_drops else None

    def to_plane(self, points: np.ndarray) -> np.ndarray:
        """(n, 2) float: points of space in the plane's own coordinates, to the last bit where the frame allows."""
        points = np.asarray(points, float)
        if (kept := self._kept_axes) is not None:
            planar = np.empty((len(points), 2))
            planar[:, 0], planar[:, 1] = points[:, kept[0]], points[:, kept[1]]
            return planar
        return (points - self.origin) @ self.axes.T

    def to_space(self, points: np.ndarray) -> np.ndarray:
        """(n, 3) float: points of the plane in space."""
        points = np.asarray(points, float)
        if (kept := self._kept_axes) is not None:
            spatial = np.empty((len(points), 3))
            for axis in range(3):  # four times faster than by rows
                spatial[:, axis] = self.origin[axis]
            for column, axis in enumerate(kept):
                spatial[:, axis] = points[:, column]
            return spatial
        return self.origin + points @ self.axes

    def deviations(self, points: np.ndarray) -> np.ndarray:
        """(n,) float: signed distances of points from the plane."""
        return (np.asarray(points, float) - self.origin) @ self.normal


# The right-handed pair of coordinates that remains when one is constant; of several the first here counts.
_REMAINING = {2: (0, 1), 1: (2, 0), 0: (1, 2)}


def fitted_plane(points: np.ndarray, *, tolerance: float = 1e-6, parameter: str = "points") -> Plane:
    """The plane that points lie in, up to a tolerance.

    Where a coordinate is the same for all points, the frame is the other two axes and nothing is rounded; else it is
    the plane of least squares, its normal turned so that its largest component is positive (of equal ones, the last).

    Parameters
    ----------
    points : (n, 3) float
        Points in space.
    tolerance : float
        Largest distance from the plane, as a share of the bounding box's diagonal.
    parameter : str
        Name of the input, for the message.

    Returns
    -------
    Plane

    Raises
    ------
    InvalidGeometry
        If a point is farther from the plane than the tolerance; it names the largest deviation.

    Examples
    --------
    >>> fitted_plane([[0, 0, 0], [1, 0, 1], [1, 1, 1], [0, 1, 0]]).normal.round(6).tolist()
    [-0.707107, 0.0, 0.707107]
    """
    points = np.asarray(points, float).reshape(-1, 3)
    if not len(points):
        return Plane(np.zeros(3), np.eye(3)[:2])
    for axis, (first, second) in _REMAINING.items():
        if (points[:, axis] == points[0, axis]).all():
            return _plane_across(axis, first, second, float(points[0, axis]) + 0.0)  # no negative zero
    spread = np.ptp(points, axis=0)
    scale = float(spread.max())
    centre = points.min(axis=0) / 2 + points.max(axis=0) / 2
    relative = (points - centre) / scale
    mean = relative.mean(axis=0)
    _, vectors = np.linalg.eigh((relative - mean).T @ (relative - mean))
    normal, first = _turned(vectors[:, 0]), _turned(vectors[:, 2])
    plane = Plane(centre + scale * mean, np.array([first, np.cross(normal, first)]))
    distance = np.abs(plane.deviations(points))
    allowed = tolerance * float(np.linalg.norm(spread / scale)) * scale
    if distance.max() > allowed:
        far = np.flatnonzero(distance > allowed)
        raise InvalidGeometry(
            f"is not planar: point {distance.argmax()} is {distance.max():.4g} off the best plane, "
            f"{allowed:.4g} is allowed; flatten it first",
            parameter=parameter,
            points=far,
        )
    return plane


def seen_upright(plane: Plane) -> Plane:
    """A plane that stands upright, with its y up and its x to the right, which is along the space's x, or else y.

    A frame that is right-handed about a coordinate, as that of `fitted_plane` is, shows what lies in the plane of x and
    z with z to the right and x up, so that an airfoil's upper side would be below. Planes that rather lie stay.

    Examples
    --------
    >>> seen_upright(fitted_plane([[0, 0, 0], [1, 0, 0], [1, 0, 1]])).axes
    array([[1., 0., 0.],
           [0., 0., 1.]])
    """
    normal = plane.normal
    if abs(normal[2]) > 0.5:
        return plane
    right = np.array([-normal[1], normal[0], 0.0])
    right = right * np.sign(right[np.abs(right).argmax()]) / np.linalg.norm(right) + 0.0  # no negative zeros
    up = np.array([0.0, 0.0, 1.0]) - normal[2] * normal
    return Plane(plane.origin, np.array([right, up / np.linalg.norm(up)]))


@lru_cache(maxsize=64)
def _plane_across(axis: int, first: int, second: int, value: float) -> Plane:
    """The plane in which one coordinate has a value; the two others are its own."""
    origin, axes = np.zeros(3), np.zeros((2, 3))
    origin[axis] = value
    axes[0, first] = axes[1, second] = 1
    origin.flags.writeable = axes.flags.writeable = False  # many callers share them
    return Plane(origin, axes)


def _turned(vector: np.ndarray) -> np.ndarray:
    """A vector or its opposite: the last of its largest components, up to rounding, is positive."""
    size = np.abs(vector)
    return vector * np.copysign(1.0, vector[np.flatnonzero(size > size.max() - 1e-9)[-1]])
