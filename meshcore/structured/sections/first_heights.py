"""First heights of a grid's lines made those that were asked for, by points that move along the lines they stand on.

Where lines go is what a method is chosen for; how far the first point stands from the wall is what the user asked.
Marches hold areas and the elliptic equations a balance, so that beside cusps and corners heights come out otherwise.
"""

from __future__ import annotations

import numpy as np

from ...mesh import StructuredGrid
from ...quality import summary
from ..folds import folded_cells
from .lines_out import lengths_along
from .spreading import SOUND, SPREADS, WORSE, spread_with_height

WITHIN = 0.01
"""Error of a first height from which on its line is corrected."""
_FADE = 0.02
"""Largest change of a line's growth from cell to cell, unless the line has too few cells for that."""
_FEWEST = 10
"""Cells that a correction is spread over, at least."""
_TRIES = 4


def worst_jacobian(points: np.ndarray) -> float:
    """The worst scaled Jacobian of a plane grid's (n, m, 3) points; 0 if cells are folded."""
    return 0.0 if folded_cells(points).any() else summary(StructuredGrid(points))["worst scaled jacobian"]


def with_first_heights(points: np.ndarray, heights: np.ndarray) -> np.ndarray:
    """The same lines with points on them that begin at the right heights; lines that would fold all the same stay.

    Parameters
    ----------
    points : (n, m, 3) float
        Lines that leave j = 0, in a plane.
    heights : (n,) float
        Lengths of their first cells.

    Returns
    -------
    (n, m, 3) float
        A line's points move by the factor that its first height lacks, less and less towards its end. If that folds
        cells, or makes them much worse, lines share what they lack with more of their neighbours the higher they are.

    Examples
    --------
    >>> lines = np.zeros((2, 40, 3))
    >>> lines[:, :, 1], lines[1, :, 0] = 1.1 ** np.arange(40) - 1, 1
    >>> with_first_heights(lines, np.array([0.1, 0.08]))[:, 1].round(12)
    array([[0.  , 0.1 , 0.  ],
           [1.  , 0.08, 0.  ]])
    """
    if points.shape[1] < 3:
        return points
    reached = np.linalg.norm(points[:, 1] - points[:, 0], axis=1)
    lacking = np.log(heights / reached)
    lacking[np.abs(lacking) < WITHIN] = 0.0
    if not lacking.any():
        return points
    least = min(WORSE * worst_jacobian(points), SOUND)
    for spread in SPREADS:
        moved = _moved(points, lacking, spread)
        if worst_jacobian(moved) > least:
            return moved
    for _ in range(_TRIES):
        unsound = folded_cells(moved).any(axis=1)
        if not unsound.any():
            return moved
        stays = np.zeros(len(points), bool)
        for k in (-1, 0, 1, 2):  # both lines of the cells, and their neighbours
            stays[np.clip(np.flatnonzero(unsound) + k, 0, len(points) - 1)] = True
        stays[[0, -1]] = stays[0] or stays[-1]  # the two sides of a cut
        lacking[stays] = 0.0
        moved = _moved(points, lacking, SPREADS[-1])
    return points


def _moved(points: np.ndarray, lacking: np.ndarray, spread: float) -> np.ndarray:
    """Points at distances along their lines that are multiplied by exp(lacking) first, by 1 at last."""
    cells = points.shape[1] - 1
    length = lengths_along(points)
    fade = np.clip(np.abs(lacking).max() / _FADE, min(_FEWEST, cells - 1), cells - 1)
    share = np.clip(1 - np.arange(cells) / fade, 0, 1)
    amounts = lacking[:, None] * share**2 * (3 - 2 * share)  # no kink, which splines would swing about
    if spread:
        amounts = spread_with_height(amounts, points, spread)
    wanted = np.column_stack([length[:, 0], length[:, 1:] * np.exp(amounts)])
    moved = points.copy()
    for i in np.flatnonzero(amounts.any(axis=1)):
        if (np.diff(wanted[i]) > 0).all():
            moved[i] = np.column_stack([np.interp(wanted[i], length[i], x) for x in points[i].T])
    return moved
