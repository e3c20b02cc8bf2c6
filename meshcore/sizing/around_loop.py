"""Points around a closed loop in the plane: where it turns, where its corners are, and a new spacing by curvature."""

from __future__ import annotations

import numpy as np

from ..errors import InvalidInput
from ..geometry.curves import arc_length

SHARP = np.radians(60)
"""A turn that is a corner whatever stands beside it."""
NOTICEABLE = np.radians(30)
"""A turn that is a corner if the loop is nearly straight on one side of it."""
_BINS = 4096


def turning(loop: np.ndarray) -> np.ndarray:
    """Angle in radians by which a closed polyline turns at each of its points, positive to the left.

    Parameters
    ----------
    loop : (n, 2) float
        Points in order; the last is joined to the first.

    Returns
    -------
    (n,) float
        Between -pi and pi; for a simple counter-clockwise loop they add up to 2 pi.

    Examples
    --------
    >>> np.degrees(turning(np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])))
    array([90., 90., 90., 90.])
    """
    after = np.roll(loop, -1, axis=0) - loop
    before = np.roll(after, 1, axis=0)
    return np.arctan2(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0], (before * after).sum(axis=1))


def corners(turn: np.ndarray) -> np.ndarray:
    """Which points of a loop are corners rather than samples of a round: (n,) bool from its (n,) turning.

    Examples
    --------
    >>> corners(turning(np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])))
    array([ True,  True,  True,  True])
    """
    size = np.abs(turn)
    straighter = np.minimum(np.roll(size, 1), np.roll(size, -1))
    return (size > SHARP) | ((size > NOTICEABLE) & (size > 2.5 * straighter))


def smoothed_turning(fractions: np.ndarray, turn: np.ndarray, width: float) -> np.ndarray:
    """Density of turning over fractions of a loop's length, smoothed by a Gaussian.

    Parameters
    ----------
    fractions : (n,) float
        Where the points stand, from 0 up to less than 1.
    turn : (n,) float
        Weight of each point, such as its turning.
    width : float
        Standard deviation of the Gaussian, as a fraction of the loop.

    Returns
    -------
    (4096,) float
        Weight in each of equal bins centred on k / 4096, with the same sum as `turn`.

    Examples
    --------
    >>> density = smoothed_turning(np.array([0.0, 0.5]), np.array([1.0, 3.0]), 0.05)
    >>> print(density.sum().round(9))
    4.0
    """
    at = fractions * _BINS
    low = np.floor(at).astype(int)
    share = at - low
    density = np.zeros(_BINS)
    np.add.at(density, low % _BINS, turn * (1 - share))
    np.add.at(density, (low + 1) % _BINS, turn * share)
    frequency = np.fft.rfftfreq(_BINS, 1 / _BINS)
    return np.fft.irfft(np.fft.rfft(density) * np.exp(-0.5 * (2 * np.pi * width * frequency) ** 2), _BINS)


def accumulated(density: np.ndarray, fractions: np.ndarray) -> np.ndarray:
    """Share of a periodic density of `smoothed_turning` up to each fraction; it counts on beyond 0 and 1.

    Examples
    --------
    >>> accumulated(np.ones(4096), np.array([-0.25, 0.0, 0.5, 1.25]))
    array([-0.25,  0.  ,  0.5 ,  1.25])
    """
    steps = 0.5 * (density + np.roll(density, -1))
    total = np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()
    whole = np.floor(fractions)
    return whole + np.interp(fractions - whole, np.linspace(0, 1, _BINS + 1), total)


def respaced_loop(loop: np.ndarray, cells: int, *, bend: float = 0.5, width: float = 0.02) -> np.ndarray:
    """A closed loop with another number of points: dense where it bends, every corner and the first point kept.

    Between corners the new points lie on a cubic spline through the old ones.

    Parameters
    ----------
    loop : (n, 2) float
        Points in order; the last is joined to the first.
    cells : int
        Number of new points.
    bend : float
        Share of the points that follow the bending; the rest follow length.
    width : float
        Distance over which the spacing adjusts, as a fraction of the loop.

    Returns
    -------
    (cells, 2) float

    Raises
    ------
    InvalidInput
        If there are fewer cells than stretches between corners.

    Examples
    --------
    >>> respaced_loop(np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]]), 8).round(6)[:4]
    array([[0. , 0. ],
           [0.5, 0. ],
           [1. , 0. ],
           [1. , 0.5]])
    """
    turn = turning(loop)
    corner = corners(turn)
    stops = np.unique(np.append(np.flatnonzero(corner), 0))
    if cells < max(3, len(stops)):
        raise InvalidInput(
            f"{cells} cells are too few for a loop with {len(stops)} corners; give more", parameter="around"
        )
    closed = np.vstack([loop, loop[:1]])
    length = arc_length(closed)
    fractions = length / length[-1]
    density = smoothed_turning(fractions[:-1], np.abs(turn), width)
    density = bend * np.maximum(density, 0) / np.abs(turn).sum() + (1 - bend) / len(density)
    wanted = accumulated(density, np.append(fractions[stops], 1.0))
    fine = np.linspace(0, 1, 4 * _BINS + 1)
    share = accumulated(density, fine)
    share[-1] = 1.0
    counts = _shared_out(cells, np.diff(wanted))
    smooth = not corner.any()
    pieces = []
    for start, stop, count in zip(stops, np.append(stops[1:], len(loop)), counts, strict=True):
        level = np.interp([fractions[start], fractions[stop]], fine, share)
        at = np.interp(np.linspace(*level, count + 1)[:-1], share, fine) * length[-1]
        at[0] = length[start]
        pieces.append(_along(length[start : stop + 1], closed[start : stop + 1], at, periodic=smooth))
    return np.concatenate(pieces)


def _shared_out(cells: int, weights: np.ndarray) -> np.ndarray:
    """Whole numbers of at least 1 that add up to ``cells``, in proportion to ``weights`` (largest remainders)."""
    exact = (cells - len(weights)) * weights / weights.sum()
    counts = np.floor(exact).astype(int)
    counts[np.argsort(counts - exact, kind="stable")[: cells - len(weights) - counts.sum()]] += 1
    return counts + 1


def _along(length: np.ndarray, points: np.ndarray, at: np.ndarray, *, periodic: bool) -> np.ndarray:
    """Points at lengths ``at`` of a smooth stretch, the first being the stretch's first."""
    from scipy.interpolate import CubicSpline  # half a second, which not every start should take

    if len(points) < 4:
        new = np.column_stack([np.interp(at, length, x) for x in points.T])
    else:
        new = CubicSpline(length, points, bc_type="periodic" if periodic else "not-a-knot")(at)
    new[0] = points[0]
    return new
