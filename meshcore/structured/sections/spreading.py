"""Amounts of lines spread over their neighbours, farther the higher above the wall, so that no layer gets a kink.

An amount by which a single line differs may be whole within a height of the distance between lines. Higher up, layers
would kink there and fold. Green's function of ``c - w^2 c'' = a`` along the wall is ``exp(-|s| / w) / 2w``, so that c
is the mean of a over the width w. With w the height, layers moved by a factor exp(c) slope by no more than c at the
wall.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import solveh_banded

from ...geometry.curves import arc_length
from .lines_out import lengths_along

SPREADS = 0.0, 1.0, 2.0
"""Widths, in heights, to be tried in turn: lines of layers that share what they lack grow less evenly."""
WORSE, SOUND = 0.5, 0.25
"""Share of the worst scaled Jacobian that must be left if points move along their lines, and what is enough in any
case."""


def spread_with_height(amounts: np.ndarray, points: np.ndarray, spread: float = 1.0) -> np.ndarray:
    """Amounts at points of lines, each the mean over a width that grows with its height over the lines' first points.

    Parameters
    ----------
    amounts : (n, m) float
        For each level over the wall, to be spread along it.
    points : (n, m + 1, d) float
        Lines that leave the wall j = 0; if the last is the first their front is closed.
    spread : float
        The width, in heights.

    Returns
    -------
    (n, m) float
        Amounts of first points are those given.

    Examples
    --------
    >>> lines = np.stack(np.meshgrid(np.arange(5.0), [0.0, 0.1, 1.1], indexing="ij"), axis=-1)
    >>> spread_with_height(np.repeat([[0.0], [0], [1], [0], [0]], 2, axis=1), lines).round(2)
    array([[0.  , 0.13],
           [0.  , 0.2 ],
           [1.  , 0.47],
           [0.  , 0.2 ],
           [0.  , 0.13]])
    """
    n, levels = amounts.shape
    length = lengths_along(points)[:, 1:]
    width = spread * (length - length[:, :1])
    step = np.diff(arc_length(points[:, 0]))
    closed = bool((points[0] == points[-1]).all())
    if closed:  # once more round, half on each side
        turn = np.arange(-(n // 2), n - 1 + n // 2 + 1) % (n - 1)
        amounts, width, step = amounts[turn], width[turn], step[turn[:-1]]
    found = np.column_stack([_means(amounts[:, j], width[:, j], step) for j in range(levels)])
    return np.concatenate([found[n // 2 :][: n - 1], found[n // 2 : n // 2 + 1]]) if closed else found


def _means(amounts: np.ndarray, width: np.ndarray, step: np.ndarray) -> np.ndarray:
    """(n,) solution of c - w^2 c'' = a on points ``step`` apart, by finite volumes; nothing passes the ends."""
    if not width.any():
        return amounts
    volume = 0.5 * (np.append(step, 0.0) + np.append(0.0, step))
    flow = (0.5 * (width[1:] + width[:-1])) ** 2 / step
    banded = np.zeros((2, len(amounts)))
    banded[0] = volume + np.append(flow, 0.0) + np.append(0.0, flow)
    banded[1, :-1] = -flow
    return solveh_banded(banded, volume * amounts, lower=True, check_finite=False)
