"""Curves given by a parameter: splines through points, circular arcs, any function."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..errors import InvalidGeometry, InvalidInput
from .curves import arc_length


@dataclass(frozen=True, eq=False)
class ParametricCurve:
    """A curve as a function of a parameter.

    Parameters
    ----------
    function : callable
        Takes (m,) parameters, returns (m, 3) or (m, 2) points.
    start, stop : float
        First and last parameter.
    knots : (k,) float, optional
        Parameters between which the curve is smooth, from ``start`` to ``stop``.

    Raises
    ------
    InvalidInput
        If ``start`` and ``stop`` are not finite and in this order.

    Examples
    --------
    >>> helix = ParametricCurve(lambda t: np.column_stack([np.cos(t), np.sin(t), t]), 0.0, 2 * np.pi)
    >>> helix.points(np.array([0.0])), helix.is_closed
    (array([[1., 0., 0.]]), False)
    """

    function: Callable[[np.ndarray], np.ndarray]
    start: float
    stop: float
    knots: np.ndarray | None = None

    def __post_init__(self) -> None:
        if not (np.isfinite(self.start) and np.isfinite(self.stop) and self.start < self.stop):
            raise InvalidInput(f"needs start < stop, both finite, got {self.start} and {self.stop}", parameter="curve")

    def points(self, parameters: np.ndarray) -> np.ndarray:
        """(m, 3) float: points at parameters.

        Parameters
        ----------
        parameters : (m,) float
            From ``start`` to ``stop``.

        Raises
        ------
        InvalidInput
            If the function does not return points.
        InvalidGeometry
            If a point is not finite; it says at which parameter.
        """
        points = np.asarray(self.function(parameters), float)
        if points.shape not in ((len(parameters), 2), (len(parameters), 3)):
            raise InvalidInput(
                f"must return shape ({len(parameters)}, 3) or ({len(parameters)}, 2), got {points.shape}",
                parameter="curve",
            )
        bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
        if len(bad):
            raise InvalidGeometry(
                f"is {points[bad[0]].tolist()} at parameter {parameters[bad[0]]:g}", parameter="curve"
            )
        return np.column_stack([points, np.zeros((len(points), 3 - points.shape[1]))])

    @property
    def is_closed(self) -> bool:
        """Whether the curve ends where it begins, up to rounding."""
        ends = self.points(np.linspace(self.start, self.stop, 9))
        size = float(np.ptp(ends, axis=0).max())
        return bool(np.abs(ends[-1] - ends[0]).max() <= 1e-12 * max(size, float(np.abs(ends).max()) * 1e-3))


def arc(
    centre: np.ndarray, radius: float, start: float = 0.0, stop: float = 360.0, *, axes: np.ndarray | None = None
) -> ParametricCurve:
    """A circular arc; its parameter is the angle in degrees.

    Parameters
    ----------
    centre : (3,) or (2,) float
        Centre of the circle.
    radius : float
        Radius.
    start, stop : float
        Angles in degrees, counter-clockwise from the first axis.
    axes : (2, 3) float, optional
        Orthonormal axes of the arc's plane; by default x and y.

    Returns
    -------
    ParametricCurve

    Raises
    ------
    InvalidInput
        If the radius is not finite and greater than zero, or ``start`` is not below ``stop``.

    Examples
    --------
    >>> quarter = arc([0, 0], 2.0, 0, 90)
    >>> quarter.points(np.array([0.0, 90.0])).round(9) + 0.0
    array([[2., 0., 0.],
           [0., 2., 0.]])
    """
    if not np.isfinite(radius) or radius <= 0:
        raise InvalidInput(f"must be finite and greater than zero, got {radius}", parameter="radius")
    middle = np.zeros(3)
    middle[: len(centre)] = centre
    x, y = np.eye(3)[:2] if axes is None else np.asarray(axes, float)

    def points(angles: np.ndarray) -> np.ndarray:
        turn = np.radians(angles)[:, None]
        return middle + radius * (np.cos(turn) * x + np.sin(turn) * y)

    return ParametricCurve(points, float(start), float(stop))


def spline(points: np.ndarray, *, closed: bool = False) -> ParametricCurve:
    """A cubic spline through points; its parameter is the length of the polyline through them.

    Parameters
    ----------
    points : (n, 3) or (n, 2) float
        Points in order; those at the place of the one before are passed over.
    closed : bool
        Whether the curve goes on smoothly from the last point to the first.

    Returns
    -------
    ParametricCurve
        With two points a straight line, with three a parabola.

    Raises
    ------
    InvalidGeometry
        If there are fewer than two different points (three for a closed curve).

    Examples
    --------
    >>> wave = spline([[0, 0], [1, 1], [2, 0], [3, -1], [4, 0]])
    >>> wave.points(wave.knots)[:, 1].round(9)
    array([ 0.,  1.,  0., -1.,  0.])
    """
    from scipy.interpolate import CubicSpline  # half a second, which not every start should take

    points = np.asarray(points, float)
    points = np.vstack([points, points[:1]]) if closed else points
    points = points[np.append(True, (np.diff(points, axis=0) != 0).any(axis=1))]
    if len(points) < (4 if closed else 2):
        raise InvalidGeometry(
            f"needs at least {3 if closed else 2} different points, got {len(points) - closed}", parameter="points"
        )
    knots = arc_length(points)
    # Scaled to length 1: the spline's equations square lengths, and cube them.
    function = CubicSpline(knots / knots[-1], points, bc_type="periodic" if closed else "not-a-knot")
    return ParametricCurve(lambda at: function(at / knots[-1]), 0.0, float(knots[-1]), knots)
