"""Elliptic grids of blocks without folds: other starts, weaker control, and few cells unfolded (survey 2.6)."""

from __future__ import annotations

import numpy as np

from ...progress import Progress, part_of, silent
from . import winslow_3d
from .barrier_3d import unfolded
from .block_problem import AskedOfBlock, solved
from .elliptic_problem import Found

_HALVINGS = 3  # of control functions that fold the grid
_MOST_MOVED = 0.5  # part of the points


def sound(
    points: np.ndarray, filled: np.ndarray, growth: np.ndarray | None, asked: AskedOfBlock, progress: Progress = silent
) -> Found:
    """The elliptic grid of a block, with few cells unfolded if the equations leave them folded.

    If cells are folded, another start may lead to another solution, and weaker control folds less. What had to be
    unfolded in most of its points is no elliptic grid any more, and is taken only if all else fails.

    Parameters
    ----------
    points : (ni, nj, nk, 3) float
        A right-handed block, whose boundary is kept and whose inside is the start.
    filled : (ni, nj, nk, 3) float
        Another start.
    growth : (3, ni, nj, nk) float, optional
        Control functions as logarithms of growth from cell to cell; by default Laplace.
    asked : AskedOfBlock
        What it shall be like.
    progress : Progress
        Called with fraction and message.

    Returns
    -------
    Found
        The best that was found; cells may still be folded.
    """
    starts = [points] if np.array_equal(points, filled) else [points, filled]
    tries = [(start, 1.0) for start in starts]
    tries += [(filled, 0.5**k) for k in range(1, _HALVINGS + 1) if growth is not None]
    best, least, unfolds = None, np.inf, True
    for number, (start, strength) in enumerate(tries):
        low, middle, high = (1 - 0.5**k for k in (number, number + 0.5, number + 1))
        scaled = None if growth is None else strength * growth
        found = solved(start, scaled, asked, part_of(progress, low, middle))
        left, moved = winslow_3d.count_folded(found.points), 0
        if left and unfolds:
            left, moved = _unfold(found, left, part_of(progress, middle, high))
            unfolds = not left  # else the boundary is at fault, and it will not be otherwise next time
        if strength < 1:
            found.warnings.insert(
                0, f"control acts with {strength:g} of its strength: with more of it cells would fold"
            )
        if left < least:
            best, least = found, left
        if not left and moved <= _MOST_MOVED * points[..., 0].size:
            return found
    return best


def _unfold(found: Found, folded: int, progress: Progress) -> tuple[int, int]:
    """Unfold what can be, and tell so; how many cells are still folded, and how many points were moved."""
    points = unfolded(found.points, progress=progress)
    left, moved = winslow_3d.count_folded(points), int((points != found.points).any(axis=-1).sum())
    found.points = points
    if left < folded:
        found.warnings.append(
            f"{folded - left} cells that the discrete equations leave folded were unfolded by moving {moved} points at "
            "and around them"
        )
    return left, moved
