"""How every grid round a section ends: smoothed if asked, checked, and reported."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...mesh import StructuredGrid
from ...progress import Progress, advance
from ...quality import summary, validate
from ...report import Report, Result
from ..folds import corner_products, refuse_folds
from ..layer_report import layers_told, worst_skew
from .first_heights import WITHIN, with_first_heights, worst_jacobian
from .respacing import respaced
from .section_smoothing import ANGLES, smoothed
from .section_walls import first_heights, wall_of
from .spreading import SPREADS

_WORSE = 0.5
"""Share of the worst scaled Jacobian that must be left if layers are respaced."""


def finished(
    grid: StructuredGrid,
    method: str,
    kept: np.ndarray | None,
    past: int,
    cure: str,
    counts: dict[str, int],
    told: dict[str, float],
    warnings: list[str],
    progress: Progress,
    heights: np.ndarray | None = None,
) -> Result:
    """The grid, smoothed and its layers respaced if the method says so, and its report.

    Parameters
    ----------
    grid : StructuredGrid
        The transfinite grid, whose first heights are those wanted.
    method : str
        It is smoothed if this is "elliptic", and then, or if it is "parabolic", its layers made to grow evenly.
    kept : (ni,) float, optional
        How far, from 0 to 1, smoothing keeps the angles of the lines at its wall, instead of making them right.
    past : int
        Layers that stay as they are, the last of which is smoothing's wall.
    cure : str
        What to do about folded cells.
    counts, told : dict
        For the report.
    warnings : list of str
        What has been changed so far.
    progress : Progress
        Called with fraction and message.
    heights : (ni,) float, optional
        First heights; by default the one that is ``told``.

    Raises
    ------
    GenerationFailed
        If cells are folded; `cells` and `partial` show where.
    """
    history: dict = {"converged": False} if method == "elliptic" else {}
    wanted = np.full(grid.shape[0], told["first height"]) if heights is None else heights
    if past:
        wanted = first_heights(grid, past)
    if method == "elliptic":
        outside = replace(grid, points=grid.points[:, past:], cuts=() if past else grid.cuts)
        outside, report, more = smoothed(outside, wall_of(outside, kept), cure, progress)
        grid = replace(grid, points=np.concatenate([grid.points[:, :past], outside.points], axis=1))
    if method != "transfinite":  # whose lines have their points by that very law
        grid = _evenly_growing(grid, wanted, past, counts.get("wake", 0))
    if past == 0 or method == "elliptic":
        lines = with_first_heights(grid.points[:, past:, 0], wanted)
        grid = grid.with_points(np.concatenate([grid.points[:, :past], lines[:, :, None]], axis=1))
    if method == "elliptic":
        beyond = f"beyond the {past} layers that round the blunt edge: " if past else ""
        warnings = warnings + [beyond + text for text in more]
        if report is not None:
            if (angles := report.quality.get(ANGLES)) is not None and not past:
                told = {**told, ANGLES: angles}  # heights are told below, as they are in the end
            history = {"iterations": report.iterations, "residual": report.residual, "converged": report.converged}
            history["history"] = report.history
    advance(progress, 0.95, "checking the grid")
    refuse_folds(grid, cure)
    validate(grid)
    counts = {"points": grid.n_points, "quads": grid.n_cells, **counts}
    lines = layers_told(_of_walls(grid, counts.get("wake", 0)), told["first height"])
    told = {**told, **lines, **worst_skew(grid)}
    return Result(grid, Report(counts=counts, quality={**summary(grid), **told}, warnings=warnings, **history))


def _evenly_growing(grid: StructuredGrid, heights: np.ndarray, past: int, wake: int) -> StructuredGrid:
    """The grid with its layers beyond the first ``past`` respaced, unless that makes cells much worse or heights."""
    lines = grid.points[:, past:, 0]
    worst, off = _figures(grid, heights, past)
    for spread in SPREADS:
        found = respaced(lines, heights, slice(wake, len(lines) - wake), spread)
        if found is None:
            continue
        if grid.periodic[0]:
            found[-1] = found[0]
        even = grid.with_points(np.concatenate([grid.points[:, :past], found[:, :, None]], axis=1))
        reached = _figures(even, heights, past)
        if reached[0] > _WORSE * worst and reached[1] <= max(off, WITHIN):
            return even
    return grid


def _figures(grid: StructuredGrid, heights: np.ndarray, past: int) -> tuple[float, float]:
    """The worst scaled Jacobian, 0 if cells are folded, and the largest relative error of first heights."""
    off = float(np.abs(first_heights(grid, past) / heights - 1).max())
    return worst_jacobian(grid.points[:, :, 0]), off


def _of_walls(grid: StructuredGrid, wake: int) -> np.ndarray:
    """(n, nj, 3) float: the lines that leave the wall; ``wake`` points at both ends of i stand before none."""
    return grid.points[wake : len(grid.points) - wake, :, 0]


def scaled_jacobians(points: np.ndarray) -> np.ndarray:
    """(ni - 1, nj - 1) least sine of a corner's angle, of each cell of planar points (ni, nj, 2).

    Examples
    --------
    >>> scaled_jacobians(np.array([[[0.0, 0], [0, 1]], [[1, 0], [1, 1]]]))
    array([[1.]])
    """
    cross, size = corner_products(points)
    return (cross / np.maximum(size, 1e-300)).min(axis=0)  # points that are one make flat cells
