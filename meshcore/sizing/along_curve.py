"""Spacings that a curve itself gives: dense where it bends, or as the points of another curve stand."""

from __future__ import annotations

import numpy as np

from ..errors import InvalidInput
from ..geometry.curves import Curve, arc_length, polyline
from .around_loop import accumulated, smoothed_turning
from .end_cells import count, number, pinned


def by_curvature(cells: int, curve: Curve, *, bend: float = 0.5, width: float = 0.02) -> np.ndarray:
    """Cells that are small where a curve bends.

    Parameters
    ----------
    cells : int
        Number of cells.
    curve : Mesh or (n, 3) float
        The curve.
    bend : float
        Share of the cells that follow the turning of the curve; the rest follow its length.
    width : float
        Distance over which the spacing adjusts, as a fraction of the curve.

    Returns
    -------
    (cells + 1,) float
        Fractions from 0 to 1, increasing.

    Raises
    ------
    InvalidInput
        If `bend` is not at least 0 and less than 1, or `width` is not greater than 0.

    Examples
    --------
    >>> hairpin = [[0, 0], [5, 0], [5.2, 0.1], [5.2, 0.3], [5, 0.4], [0, 0.4]]
    >>> np.diff(by_curvature(5, np.array(hairpin))).round(2)
    array([0.4 , 0.09, 0.03, 0.09, 0.4 ])
    """
    cells = count(cells)
    if not 0 <= number(bend, "bend") < 1:
        raise InvalidInput(f"must be at least 0 and less than 1, got {bend:g}", parameter="bend")
    if number(width, "width") <= 0:
        raise InvalidInput(f"must be greater than 0, got {width:g}", parameter="width")
    points = polyline(curve)
    points = points[np.append(True, (points[1:] != points[:-1]).any(axis=1))]
    turn = _turning(points)
    if not turn.any():
        return pinned(np.arange(cells + 1) / cells, None, None)
    length = arc_length(points)
    # There and back again the curve is a loop, and its own mirror image at either end, as smoothing wants it.
    half = 0.5 * length / length[-1]
    density = smoothed_turning(np.append(half, 1 - half) % 1.0, np.append(turn, turn), 0.5 * width)
    density = bend * np.maximum(density, 0) / density.sum() + (1 - bend) / len(density)
    fine = np.linspace(0, 1, 8 * len(density) + 1)
    share = 2 * accumulated(density, 0.5 * fine)
    return pinned(np.interp(np.arange(cells + 1) / cells, share, fine), None, None)


def _turning(points: np.ndarray) -> np.ndarray:
    """(n,) float: angle in radians by which a polyline turns at each point; none at its ends."""
    along = np.diff(points, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    turn = np.zeros(len(points))
    turn[1:-1] = np.arctan2(np.linalg.norm(np.cross(along[:-1], along[1:]), axis=1), (along[:-1] * along[1:]).sum(1))
    return turn


def copied(cells: int, curve: Curve) -> np.ndarray:
    """Cells as the points of a curve stand, stretched smoothly to another number of them.

    Parameters
    ----------
    cells : int
        Number of cells.
    curve : Mesh or (n, 3) float
        The curve whose spacing is taken.

    Returns
    -------
    (cells + 1,) float
        Fractions from 0 to 1, increasing.

    Raises
    ------
    InvalidInput
        If points of the curve coincide with their neighbours.

    Examples
    --------
    >>> copied(2, np.array([[0, 0], [1, 0], [4, 0]]))
    array([0.  , 0.25, 1.  ])
    """
    from scipy.interpolate import PchipInterpolator  # half a second, which not every start should take

    cells = count(cells)
    length = arc_length(polyline(curve))
    repeated = np.flatnonzero(np.diff(length) <= 0)
    if len(repeated):
        raise InvalidInput(f"points {repeated[0]} and {repeated[0] + 1} coincide; remove one", parameter="curve")
    fractions = length / length[-1]
    if len(fractions) == cells + 1:
        return pinned(fractions, None, None)
    at = np.arange(cells + 1) / cells
    return pinned(PchipInterpolator(np.linspace(0, 1, len(fractions)), fractions)(at), None, None)
