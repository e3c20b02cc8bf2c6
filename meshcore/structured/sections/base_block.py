"""The block behind a blunt trailing edge: between the two sides of the wake, from the base to the outflow.

The front of the grid then runs straight on from the section's corners along the wake, instead of round the base, and no
line has to lean: where a wake begins in the middle of a base, cells at its concave corner cannot be better than 45
degrees. Blocks of this kind are what multi-block generators put behind blunt edges (survey 2.8.2).
"""

from __future__ import annotations

import numpy as np

from ...errors import GenerationFailed
from ...geometry.curves import arc_length
from ...geometry.section import Section
from ...mesh import Cut, MultiBlock, StructuredGrid
from ...quality import summary, validate
from ...report import Report, Result
from ...sizing import cells_for_growth, hyperbolic_tangent
from ..folds import refuse_folds

_TURNS = 2.0
"""Widths of the base over which lines across the wake turn from the base's direction to that of the outflow."""
_FEWEST_GRADED = 6
"""First heights in a base from which on its cells grow towards its middle."""


def cells_across(width: float, height: float, growth: float) -> int:
    """Cells across a base, of which the outermost have a height, growing towards the middle.

    Examples
    --------
    >>> cells_across(0.0025, 1e-3, 1.2), cells_across(0.0025, 1e-5, 1.2)
    (2, 36)
    """
    if height * _FEWEST_GRADED > width:
        return max(2, round(width / height))
    return 2 * cells_for_growth(2 * height / width, growth)


def wake_sides(section: Section, line: np.ndarray, wider: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(cells + 1, 2) points of the wake's lower and upper side, from the corners of a blunt base downstream.

    Parameters
    ----------
    section : Section
        With a blunt trailing edge.
    line : (cells + 1, 2) float
        The wake, from the middle of the base.
    wider : (cells + 1,) float
        By how much the sides are farther apart than at the base.
    """
    half = 0.5 * (section.loop[0] - section.loop[section.lower])
    forward = section.direction
    across = 0.5 * (section.base + wider[:, None]) * np.array([-forward[1], forward[0]])
    share = np.exp(-arc_length(line) / (_TURNS * section.base))[:, None]
    offset = share * half + (1 - share) * across
    lower, upper = line - offset, line + offset
    lower[0], upper[0] = section.loop[section.lower], section.loop[0]
    return lower, upper


def base_points(lower: np.ndarray, upper: np.ndarray, heights: np.ndarray, across: int) -> np.ndarray:
    """(cells + 1, across + 1, 2) points of the block, i from the base downstream, j from the lower side to the upper.

    Parameters
    ----------
    lower, upper : (cells + 1, 2) float
        Sides of the wake, from the corners of the base on, whose own points are left out.
    heights : (cells + 1,) float
        Heights of the cells beside the wake, which those at both sides of the block are to have.
    across : int
        Cells from side to side.
    """
    width = np.linalg.norm(upper - lower, axis=1)
    first = np.broadcast_to(heights / width, width.shape)
    shares = np.array([_across(across, f) for f in first])
    points = lower[:, None] + shares[..., None] * (upper - lower)[:, None]
    points[:, 0], points[:, -1] = lower, upper
    return points


def _across(cells: int, first: float) -> np.ndarray:
    """(cells + 1,) fractions from 0 to 1, whose first and last steps are as given, as far as they fit."""
    if cells == 2 or first * cells > 0.999:
        return np.linspace(0, 1, cells + 1)
    return hyperbolic_tangent(cells, first=first, last=first)


def with_base(result: Result, base: np.ndarray, cure: str) -> Result:
    """The C-grid of a result and its base block, joined by the two sides of the wake.

    Parameters
    ----------
    result : Result
        Of the C-grid, whose wake has as many cells as the block, and its report, which is completed.
    base : (cells + 1, across + 1, 3) float
        Points of the block.
    cure : str
        What to do about folded cells.

    Raises
    ------
    GenerationFailed
        If cells of the block are folded.
    """
    grid, report = result
    wake, across, n = len(base) - 1, base.shape[1] - 1, grid.shape[0] - 1
    base = base.copy()
    base[:, 0], base[:, -1] = grid.points[wake::-1, 0, 0], grid.points[n - wake :, 0, 0]  # to the last bit
    block = StructuredGrid(base, names={"imin": "wall", "imax": "outflow"})
    try:
        refuse_folds(block, cure)
    except GenerationFailed as error:
        raise GenerationFailed(f"behind the blunt edge: {error}", cells=error.cells, partial=block) from None
    cuts = (
        Cut(((0, 0, 0), (wake, 0, 0)), ((wake, 0, 0), (0, 0, 0)), (-1, -2, 3), 0, 1, name="lower wake"),
        Cut(((n - wake, 0, 0), (n, 0, 0)), ((0, across, 0), (wake, across, 0)), (1, 2, 3), 0, 1, name="upper wake"),
    )
    blocks = MultiBlock((grid, block), ("section", "base"), cuts)
    validate(block)
    counts = {**report.counts, "points": blocks.n_points, "quads": blocks.n_cells, "across the base": across}
    quality = {**report.quality, **summary(blocks.to_mesh())}
    told = {key: value for key, value in vars(report).items() if key not in ("counts", "quality")}
    return Result(blocks, Report(counts=counts, quality=quality, **told))
