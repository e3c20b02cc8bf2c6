"""What reports tell of layers off a wall: heights, growth and skew, measured on the grid that was made."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..mesh import StructuredGrid
from ..quality import line_angle

_BLOCK = 20_000
"""Points that are looked at together: what is worked out of them stays in caches, however large the grid."""


def layers_told(points: np.ndarray, asked: float | np.ndarray) -> dict[str, float]:
    """Heights and growth of layers, along the lines that leave a wall.

    Parameters
    ----------
    points : (n, layers + 1, d) float
        Points of each line, from the wall out.
    asked : float or (n,) float
        First heights asked for; of those that differ from line to line the mean is told.

    Returns
    -------
    dict of str
        For `Report.quality`. Growth is the largest of any line, the total height the mean of all.

    Examples
    --------
    >>> lines = np.array([[[0.0, 0], [0, 1], [0, 3]], [[1.0, 0], [1, 1], [1, 3]]])
    >>> told = layers_told(lines, 2.0)
    >>> told["least first height / asked"], told["largest growth"], told["total height"]
    (0.5, 2.0, 3.0)
    """
    first, total, growth = np.empty(len(points)), np.empty(len(points)), 1.0
    for lines in _blocks(points):
        step = np.diff(points[lines], axis=1)
        height = np.sqrt(np.einsum("ijk,ijk->ij", step, step))
        first[lines], total[lines] = height[:, 0], height.sum(axis=1)
        growth = (height[:, 1:] / height[:, :-1]).max(initial=growth)
    share = first / asked
    return {
        "first height": float(np.mean(asked)),
        "least first height / asked": float(share.min()),
        "largest first height / asked": float(share.max()),
        "largest growth": float(growth),
        "total height": float(total.mean()),
    }


def worst_skew(grid: StructuredGrid) -> dict[str, float]:
    """How far from right angles lines of a planar grid meet at worst, off its wall jmin and its outer boundary jmax.

    Examples
    --------
    >>> x, y = np.meshgrid(np.arange(3.0), np.arange(3.0), indexing="ij")
    >>> worst_skew(StructuredGrid(np.stack([x + y, y], axis=-1)))["worst skew of lines (degree)"]
    45.0
    """
    n, inside = len(grid.points), (np.arange(grid.shape[1]) % max(grid.shape[1] - 1, 1) > 0)[None, :, None]
    least = 90.0
    for lines in _blocks(grid.points):
        around = np.arange(lines.start - 1, lines.stop + 1)
        around = around % (n - 1) if grid.periodic[0] else around[(around >= 0) & (around < n)]
        angle = line_angle(StructuredGrid(grid.points[around], periodic=(False, grid.periodic[1], False)))
        begin = 1 if grid.periodic[0] or lines.start else 0
        least = angle[begin : begin + lines.stop - lines.start].min(initial=least, where=inside)
    return {"worst skew of lines (degree)": float(90 - least)}


def _blocks(points: np.ndarray) -> Iterator[slice]:
    """Slices of the lines of a grid, of some `_BLOCK` points each."""
    wide = max(1, _BLOCK // points.shape[1])
    return (slice(first, min(first + wide, len(points))) for first in range(0, len(points), wide))
