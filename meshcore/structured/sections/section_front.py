"""Fronts that grids round a section start from: the section's points, clockwise, and its wake."""

from __future__ import annotations

import numpy as np

from ...errors import InvalidInput
from ...geometry.curves import arc_length, resampled
from ...geometry.section import Section
from ...sizing import cells_for_growth, geometric
from ...sizing.around_loop import respaced_loop
from ..limits import check_size

WAKE_BENDS = 0.5
"""Chords over which a wake turns from the trailing edge's bisector to the chord's direction."""
BASE_CELLS = 2
"""Cells on each half of a blunt base."""
_LEAST_SIZE = 1e-9
"""Of the chord: the smallest cell that may be asked for at an edge."""


def respaced_section(section: Section, around: int | None, leading: float | None, trailing: float | None) -> Section:
    """The section on other points, if asked: dense where it bends, cells of given sizes at its edges.

    Parameters
    ----------
    section : Section
        On its own points.
    around : int, optional
        Cells; by default as many as it has points.
    leading, trailing : float, optional
        Sizes of the cells at nose and trailing edge.
    """
    if around is None and leading is None and trailing is None:
        return section
    lower = section.lower if section.edge == "blunt" else None
    sizes = edge_sizes(section.loop, leading, trailing, lower)
    return Section.of(respaced_loop(section.loop, around or len(section.loop), sizes=sizes))


def edge_sizes(
    loop: np.ndarray, leading: float | None, trailing: float | None, lower: int | None = None
) -> list[tuple[float, float]]:
    """Places, as fractions of a loop that begins at its trailing edge, and sizes asked for there.

    Raises
    ------
    InvalidInput
        If a size is not between a billionth and a half of the chord.
    """
    length = arc_length(np.vstack([loop, loop[:1]]))
    away = np.linalg.norm(loop - loop[0], axis=1)
    nose, chord = int(np.argmax(away)), float(away.max())
    for name, size in (("leading_spacing", leading), ("trailing_spacing", trailing)):
        if size is not None and not _LEAST_SIZE * chord < size < 0.5 * chord:
            raise InvalidInput(
                f"is {size:.6g}; give a size between {_LEAST_SIZE * chord:.6g} and half the chord, {0.5 * chord:.6g}",
                parameter=name,
            )
    sizes = [] if leading is None else [(nose, leading)]
    if trailing is not None:
        sizes += [(at, trailing) for at in (0, lower) if at is not None]
    return [(float(length[at] / length[-1]), size) for at, size in sizes]


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
    section: Section, length: float, cells: int | None, first: float, growth: float, angle: float = 0.0
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
    first : float
        Size of the first cell.
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
    first = min(first, 0.2 * whole)
    check_size((cells or 0) + 1, 2, parameter="wake_cells")
    if cells is None:
        cells = max(2, cells_for_growth(first / whole, growth))
    spacing = geometric(cells, first=first / whole) if cells > 1 else np.array([0.0, 1.0])
    found = resampled(np.column_stack([line, 0 * x]), spacing)[:, :2]
    found[0], found[-1] = line[0], line[-1]
    return found
