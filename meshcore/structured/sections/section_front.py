"""Fronts that grids round a section start from: the section's points, clockwise, and its wake."""

from __future__ import annotations

import numpy as np

from ...errors import InvalidInput
from ...geometry.curves import arc_length, resampled
from ...geometry.section import Section
from ...sizing import cells_for_ends, cells_for_growth, geometric, hyperbolic_tangent
from ..limits import check_size

WAKE_BENDS = 0.5
"""Chords over which a wake turns from the trailing edge's bisector to the chord's direction."""
BASE_CELLS = 2
"""Cells on each half of a blunt base."""


def clockwise_front(section: Section) -> tuple[np.ndarray, int]:
    """(n, 2) points from the trailing edge clockwise back to it, and cells on each half of its base.

    A blunt edge begins and ends in the middle of its base.
    """
    loop = section.loop
    if section.edge != "blunt":
        return np.vstack([loop[:1], loop[:0:-1], loop[:1]]), 0
    step = np.linspace(0, 1, BASE_CELLS + 1)[:-1, None]
    lower, upper, tail = loop[section.lower], loop[0], section.tail
    down, up = tail + step * (lower - tail), tail + step * (upper - tail)
    return np.vstack([down, loop[section.lower :: -1], up[::-1]]), BASE_CELLS


def corner_front(section: Section) -> np.ndarray:
    """(n, 2) points from the lower corner of a blunt base clockwise to the upper one."""
    return section.loop[section.lower :: -1]


def wake_line(
    section: Section,
    length: float,
    cells: int | None,
    ends: tuple[float, float | None],
    growth: float,
    angle: float = 0.0,
) -> np.ndarray:
    """(cells + 1, 2) points from the trailing edge downstream, along its bisector first, then along a given direction.

    Parameters
    ----------
    section : Section
        Whose wake it is.
    length : float
        How far it reaches along the chord's direction.
    cells : int, optional
        Cells; by default as many as growth needs.
    ends : (float, float or None)
        Sizes of the first and of the last cell; that of the last is free if it is None.
    growth : float
        Largest growth of the cells, if `cells` is left out.
    angle : float
        Degrees from the chord's direction to that of the wake's end, counter-clockwise.
    """
    forward, last = section.direction, np.radians(angle)
    begin = np.arctan2(*np.array([[-forward[1], forward[0]], forward]) @ section.bisector)
    s = np.concatenate([[0.0], np.geomspace(1e-4, 1.0, 2000)]) * 1.2 * length / np.cos(last)
    heading = last + (begin - last) * np.exp(-s / (WAKE_BENDS * section.chord))
    steps = np.diff(s) * np.cos(0.5 * (heading[1:] + heading[:-1]))
    drift = np.diff(s) * np.sin(0.5 * (heading[1:] + heading[:-1]))
    x = np.concatenate([[0.0], np.cumsum(steps)])
    y = np.concatenate([[0.0], np.cumsum(drift)])
    keep = x < length
    x, y = np.append(x[keep], length), np.append(y[keep], np.interp(length, x, y))
    side = np.array([-forward[1], forward[0]])
    line = section.tail + x[:, None] * forward + y[:, None] * side
    whole = arc_length(line)[-1]
    check_size((cells or 0) + 1, 2, parameter="wake_cells")
    spacing = _along_wake(cells, min(ends[0] / whole, 0.2), ends[1] and ends[1] / whole, growth)
    found = resampled(np.column_stack([line, 0 * x]), spacing)[:, :2]
    found[0], found[-1] = line[0], line[-1]
    return found


def _along_wake(cells: int | None, first: float, last: float | None, growth: float) -> np.ndarray:
    """(cells + 1,) float: fractions of a wake's length, by constant growth or onto a last cell."""
    if cells == 1 and last is None:
        return np.array([0.0, 1.0])
    if last is None:
        return geometric(cells or max(2, cells_for_growth(first, growth)), first=first)
    cells = cells or cells_for_ends(first, last, growth)
    try:
        return hyperbolic_tangent(cells, first=first, last=last)
    except InvalidInput as error:
        raise InvalidInput(
            f"{cells} do not fit a first one of {first:.6g} and a last one of {last:.6g} of the wake's length: {error}",
            parameter="wake_cells",
        ) from None
