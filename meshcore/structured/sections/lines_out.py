"""Where points stand on lines that leave a section: a first height there, and constant growth along the line."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...errors import InvalidInput
from ...sizing import cells_for_growth, geometric
from ...sizing.end_cells import SMALLEST
from ..limits import check_size

_PASSES = 12
_FINE = 300


def geometric_lines(
    line: Callable[[np.ndarray], np.ndarray],
    heights: np.ndarray,
    layers: int | None,
    growth: float,
) -> tuple[np.ndarray, float]:
    """Parameters of the points, and the largest growth.

    Parameters
    ----------
    line : callable
        Takes parameters (n, m), from 0 at the section to 1, to points (n, m, 2) of n lines.
    heights : (n,) float
        First steps along the lines.
    layers : int, optional
        Cells along each line; by default as many as growth needs on the line that needs most.
    growth : float
        Largest growth, if `layers` is left out.

    Returns
    -------
    t : (n, layers + 1) float
        The parameters, whose points are at geometric distances from each other.
    ratio : float
        The largest growth of a line's cells.

    Raises
    ------
    InvalidInput
        If the heights do not fit the layers.
    """
    n = len(heights)
    fine = np.concatenate([[0.0], np.geomspace(1e-3 * _smallest(line, heights), 1.0, _FINE)])
    t = np.broadcast_to(fine, (n, len(fine)))
    length = lengths_along(line(t))
    check_heights(heights, length[:, -1])
    first = heights / length[:, -1]
    if layers is None:
        layers = cells_for_growth(float(first.min()), growth)
    check_size(n, layers + 1, parameter="layers")
    try:
        fractions = np.array([geometric(layers, first=f) for f in first])
    except InvalidInput as error:
        raise InvalidInput(
            f"{heights.max():.6g} does not fit {layers} layers over {length[:, -1].min():.6g}: {error}",
            parameter="first_height",
        ) from None
    t = _moved(t, length, fractions)
    for _ in range(_PASSES):  # lengths along the lines are those of the cells' own edges
        length = lengths_along(line(t))
        if np.abs(np.diff(length / length[:, -1:]) / np.diff(fractions) - 1).max() < 1e-9:
            break
        t = _moved(t, length, fractions)
    steps = np.diff(fractions, axis=1)
    return t, float((steps[:, 1:] / steps[:, :-1]).max()) if layers > 1 else 1.0


def check_heights(heights: np.ndarray, lengths: np.ndarray) -> None:
    """Refuse first heights that do not fit lines, or are lost on them.

    Examples
    --------
    >>> check_heights(np.array([1e-6]), np.array([10.0]))
    >>> check_heights(np.array([3.0]), np.array([2.0]))
    Traceback (most recent call last):
    ...
    meshcore.errors.InvalidInput: first_height: is 3, but the far field is only 2 away; make it smaller
    """
    share = heights / lengths
    long, short = int(np.argmax(share)), int(np.argmin(share))
    if share[long] > 0.999:
        raise InvalidInput(
            f"is {heights[long]:.6g}, but the far field is only {lengths[long]:.6g} away; make it smaller",
            parameter="first_height",
        )
    if share[short] < SMALLEST:
        raise InvalidInput(
            f"is {heights[short]:.6g}, which is lost on a line of {lengths[short]:.6g} to the far field; make it "
            "larger, or the far field smaller",
            parameter="first_height",
        )


def _smallest(line: Callable[[np.ndarray], np.ndarray], heights: np.ndarray) -> float:
    """The least parameter of a first height, roughly."""
    probe = np.full((len(heights), 2), 1e-6)
    probe[:, 0] = 0.0
    speed = lengths_along(line(probe))[:, -1] / 1e-6
    return float(np.clip((heights / speed).min(), 1e-14, 0.1))


def lengths_along(points: np.ndarray) -> np.ndarray:
    """(n, m) float: lengths of lines (n, m, d) up to each of their points."""
    steps = np.linalg.norm(np.diff(points, axis=1), axis=-1)
    return np.concatenate([np.zeros((len(points), 1)), np.cumsum(steps, axis=1)], axis=1)


def _moved(t: np.ndarray, length: np.ndarray, fractions: np.ndarray) -> np.ndarray:
    """Parameters at fractions of the lengths, linearly between those given."""
    found = np.array([np.interp(f * s[-1], s, own) for f, s, own in zip(fractions, length, t, strict=True)])
    found[:, 0], found[:, -1] = 0.0, 1.0
    return found
