"""Levels of a grid moved along its lines, so that layers grow evenly from the first heights that were asked for.

The elliptic equations and marches onto a far field decide where lines run; how heights follow each other is theirs only
roughly. New levels on the same lines are other control functions of the same equations: with eta' = f(xi, eta) the
lines xi = const, of which ``P = Laplace xi`` is the control function, stay as they are (J. F. Thompson, Z. U. A. Warsi,
C. W. Mastin, "Numerical Grid Generation" (1985), chapter VI). Near the section each line is geometric by itself; away
from it f becomes the same for all lines, so that levels cross them as the solution's do.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.interpolate import CubicSpline

from ...errors import InvalidInput
from ...sizing import geometric
from .lines_out import lengths_along
from .spreading import spread_with_height

_PASSES, _GAIN = 12, 0.8
"""Corrections at most, as long as each leaves no more than this share of the error."""
_NEAR = 1e-4
"""Relative error of heights over the section that is near enough."""


def respaced(
    points: np.ndarray, heights: np.ndarray, judged: slice = slice(None), spread: float = 0.0
) -> np.ndarray | None:
    """The grid with first heights as given, and layers whose mean heights grow by one factor.

    Parameters
    ----------
    points : (n, layers + 1, 2) float
        A sound grid; its first and last levels stay. Lines are taken as cubic splines.
    heights : (n,) float
        Of the first cells.
    judged : slice
        Lines of which the mean heights are taken, such as those from the section.
    spread : float
        Width, in heights over the section, over which layers share what lines lack, so that none has a kink.

    Returns
    -------
    (n, layers + 1, 2) float or None
        None if heights do not fit.

    Examples
    --------
    >>> lines = np.stack(np.meshgrid([0.0, 1.0, 2.0], [0.0, 1.2, 3.0], indexing="ij"), axis=-1)
    >>> respaced(lines, np.ones(3))[0, :, 1].round(4)
    array([0., 1., 3.])
    """
    layers = points.shape[1] - 1
    if layers < 2:
        return points
    line = _splines(points)
    start = np.broadcast_to(np.arange(1.0, layers + 1), (len(points), layers))
    whole = lengths_along(points)[:, -1]
    try:
        own = whole[:, None] * np.array([geometric(layers, first=share)[1:] for share in heights / whole])
        first, mean = heights[judged].mean(), whole[judged].mean()
        wanted = mean * geometric(layers, first=first / mean)[1:]
    except InvalidInput:
        return None
    t = _placed(line, start, lambda lengths: lengths[judged].mean(axis=0)[None], wanted[None])
    evenly = line(t)
    common = lengths_along(evenly)[:, 1:]
    share = np.arange(1, layers + 1) / layers
    share = share**2 * (3 - 2 * share)
    blended = (1 - share) * own + share * common
    if spread:
        blended = common * np.exp(spread_with_height(np.log(blended / common), evenly, spread))
    blended *= wanted / blended[judged].mean(axis=0)
    if (np.diff(blended, axis=1) <= 0).any():
        return None
    found = line(_placed(line, t, lambda lengths: lengths, blended))
    found[:, -1] = points[:, -1]
    return found


def _placed(
    line: Callable[[np.ndarray], np.ndarray],
    t: np.ndarray,
    measure: Callable[[np.ndarray], np.ndarray],
    wanted: np.ndarray,
) -> np.ndarray:
    """Places (n, layers) on lines at which ``measure`` of the lengths up to there is as wanted, at least nearly.

    ``wanted`` (m, layers) has a row for each line, or one for all; the last places stay.
    """
    best, found = np.inf, t
    for _ in range(_PASSES):
        reached = measure(lengths_along(line(t))[:, 1:])
        off = float(np.abs(reached / wanted - 1).max())
        if not off < _GAIN * best:
            break
        best, found = off, t
        if off < _NEAR:
            break
        moved = _moved(t, np.log(reached), np.log(wanted))
        t = np.concatenate([moved[:, :-1], t[:, -1:]], axis=1)
    return found


def _moved(t: np.ndarray, reached: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Places on lines where logarithms (m, layers) of lengths are those wanted, between those reached."""
    number = np.arange(t.shape[1], dtype=float)
    at = np.array([np.interp(x, xp, number) for x, xp in zip(wanted, reached, strict=True)])
    before = np.minimum(at.astype(int), t.shape[1] - 2)
    share, logarithm = at - before, np.log(t)
    low, high = (np.take_along_axis(logarithm, np.broadcast_to(k, t.shape), axis=1) for k in (before, before + 1))
    return np.exp((1 - share) * low + share * high + np.minimum(wanted - reached[:, :1], 0))


def _splines(points: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Lines as cubic splines over the numbers of their points: from (n, m) places on them to (n, m, 2) points."""
    layers, number = points.shape[1] - 1, np.arange(len(points))[:, None]
    pieces = CubicSpline(np.arange(layers + 1), points, axis=1).c  # (4, layers, n, 2)

    def line(t: np.ndarray) -> np.ndarray:
        piece = np.minimum(t.astype(int), layers - 1)
        c, x = pieces[:, piece, number], (t - piece)[..., None]
        return ((c[0] * x + c[1]) * x + c[2]) * x + c[3]

    start = points[:, :1]
    return lambda t: np.concatenate([start, line(t)], axis=1)
