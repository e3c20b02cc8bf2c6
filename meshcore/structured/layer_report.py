"""What reports tell of layers off a wall: heights, growth and skew, measured on the grid that was made."""

from __future__ import annotations

import numpy as np

from ..mesh import StructuredGrid
from ..quality import line_angle


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
    step = np.diff(points, axis=1)
    height = np.sqrt(np.einsum("ijk,ijk->ij", step, step))
    share = height[:, 0] / asked
    growth = height[:, 1:] / height[:, :-1]
    return {
        "first height": float(np.mean(asked)),
        "least first height / asked": float(share.min()),
        "largest first height / asked": float(share.max()),
        "largest growth": float(growth.max(initial=1.0)),
        "total height": float(height.sum(axis=1).mean()),
    }


def worst_skew(grid: StructuredGrid) -> dict[str, float]:
    """How far from right angles lines of a planar grid meet at worst, off its wall jmin and its outer boundary jmax.

    Examples
    --------
    >>> x, y = np.meshgrid(np.arange(3.0), np.arange(3.0), indexing="ij")
    >>> worst_skew(StructuredGrid(np.stack([x + y, y], axis=-1)))["worst skew of lines (degree)"]
    45.0
    """
    inside = (np.arange(grid.shape[1]) % max(grid.shape[1] - 1, 1) > 0)[None, :, None]
    return {"worst skew of lines (degree)": float(90 - line_angle(grid).min(initial=90.0, where=inside))}
