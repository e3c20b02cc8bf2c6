"""Levels of a grid moved along its lines, so that layers grow evenly from the first heights that were asked for.

The elliptic equations and marches onto a far field decide where lines run; how heights follow each other is theirs only
roughly. New levels on the same lines are other control functions of the same equations: with eta' = f(xi, eta) the
lines xi = const, of which ``P = Laplace xi`` is the control function, stay as they are (J. F. Thompson, Z. U. A. Warsi,
C. W. Mastin, "Numerical Grid Generation" (1985), chapter VI). Away from the section f is the same for all lines, so
that levels stay across them.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.interpolate import CubicSpline

from ...errors import InvalidInput
from ...sizing import geometric

_PASSES = 12
_NEAR = 1e-4
"""Relative error of mean heights, and of first ones, that is near enough."""
_FADE = 10.0
"""Layers over which what a line's first height needs of its own fades."""
_MOST = 3.0
"""Factor by which a line's first height is changed at most at a time."""


def respaced(points: np.ndarray, heights: np.ndarray, judged: slice = slice(None)) -> np.ndarray | None:
    """The grid with first heights as given, and layers whose mean heights grow by one factor.

    Parameters
    ----------
    points : (n, layers + 1, 2) float
        A sound grid; its first and last levels stay. Lines are taken as cubic splines.
    heights : (n,) float
        Of the first cells.
    judged : slice
        Lines of which the mean heights are taken, such as those from the section.

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
    t = np.broadcast_to(np.arange(layers + 1.0), points.shape[:2]).copy()
    number = np.arange(layers)
    fade = np.exp(-number / _FADE) * (1 - number / (layers - 1))
    best, found = np.inf, None
    for _ in range(_PASSES):
        wrong = heights / _steps(line(t))[:, 0]
        wrong = np.where(np.abs(wrong - 1) < _NEAR, 1.0, wrong)
        t[:, 1:] *= np.clip(wrong, 1 / _MOST, _MOST)[:, None] ** fade
        mean = _steps(line(t))[judged].mean(axis=0)
        try:
            shares = geometric(layers, first=heights[judged].mean() / mean.sum())[1:]
        except InvalidInput:
            return None
        reached = np.cumsum(mean) / mean.sum()
        off = max(np.abs(wrong - 1).max(), np.abs(reached / shares - 1).max())
        if off < best:
            best, found = off, line(t)
        if off < _NEAR:
            break
        t[:, 1:] = _moved(t[:, 1:], np.log(reached), np.log(shares))
        t[:, -1] = layers
    found[:, 0], found[:, -1] = points[:, 0], points[:, -1]
    return found


def _splines(points: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Lines as cubic splines over the numbers of their points: from (n, m) places on them to (n, m, 2) points."""
    layers, number = points.shape[1] - 1, np.arange(len(points))[:, None]
    pieces = CubicSpline(np.arange(layers + 1), points, axis=1).c  # (4, layers, n, 2)

    def line(t: np.ndarray) -> np.ndarray:
        piece = np.minimum(t.astype(int), layers - 1)
        c, x = pieces[:, piece, number], (t - piece)[..., None]
        return ((c[0] * x + c[1]) * x + c[2]) * x + c[3]

    return line


def _steps(points: np.ndarray) -> np.ndarray:
    return np.linalg.norm(np.diff(points, axis=1), axis=-1)


def _moved(t: np.ndarray, reached: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Places (n, layers) on lines where logarithms of mean heights are those wanted, between those reached."""
    at = np.interp(wanted, reached, np.arange(len(reached)))
    before = np.minimum(at.astype(int), len(reached) - 2)
    share, logarithm = at - before, np.log(t)
    moved = (1 - share) * logarithm[:, before] + share * logarithm[:, before + 1]
    return np.exp(moved + np.minimum(wanted - reached[0], 0))
