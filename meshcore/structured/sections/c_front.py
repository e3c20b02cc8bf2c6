"""The inner boundary of a C-grid: one side of the wake, the section, and the other side of the wake."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...errors import InvalidInput
from ...geometry.curves import arc_length
from ...geometry.section import Section
from ..limits import check_size
from .base_block import cells_across, wake_sides
from .section_front import clockwise_front, corner_front, wake_line
from .unwrapped import Unwrapped, unwrapped


@dataclass(frozen=True)
class Wake:
    """What is asked of a wake; see `c_grid` for the meaning of each. Lengths are absolute."""

    length: float
    cells: int | None
    growth: float
    spacing: float | None
    last: float | None
    height: float | None
    angle: float

    def checked(self, reach: float) -> Wake:
        """The same, if spacing and height fit a far field at ``reach``.

        Raises
        ------
        InvalidInput
            If one is no positive number below half the room there is.
        """
        room = {"wake_spacing": (self.spacing, self.length), "wake_height": (self.height, reach)}
        room |= {"outflow_spacing": (self.last, self.length)}
        for name, (value, whole) in room.items():
            if value is not None and not 0 < value < 0.5 * whole:
                raise InvalidInput(f"is {value:.6g}; give less than half of {whole:.6g}", parameter=name)
        return self


@dataclass(frozen=True)
class Front:
    """The inner boundary of a C-grid, in its plane and unwrapped.

    Attributes
    ----------
    points : (n, 2) float
        From the wake's end below the section clockwise to that above it.
    wake : int
        Cells of the wake.
    end : (2,) float
        The end of the wake's middle line.
    heights : (n,) float
        What the first cells are to be like.
    sides : two of (wake + 1, 2) float
        Lower and upper side of the wake, downstream.
    across : int
        Cells of the block between them; 0 if they are one line.
    opened : Unwrapped
        The front in the half plane.
    """

    points: np.ndarray
    wake: int
    end: np.ndarray
    heights: np.ndarray
    sides: tuple[np.ndarray, np.ndarray]
    across: int
    opened: Unwrapped


def front_of(section: Section, asked: Wake, height: float, growth: float, *, block: bool) -> Front:
    """The front of a section.

    Parameters
    ----------
    section : Section
        On the points that the grid shall have.
    asked : Wake
        What the wake is to be like.
    height : float
        First height at the section.
    growth : float
        By which cells behind a base may grow towards its middle.
    block : bool
        Whether a block stands behind a blunt edge; otherwise the front goes round the base.
    """
    block = block and section.edge == "blunt"
    around, base = (corner_front(section), 0) if block else clockwise_front(section)
    ends = np.linalg.norm(np.diff(around[[0, 1, -2, -1]], axis=0)[::2], axis=1)
    spacing = float(ends.mean()) if asked.spacing is None else asked.spacing
    line = wake_line(section, asked.length, asked.cells, (spacing, asked.last), asked.growth, asked.angle)
    wake = len(line) - 1
    length = arc_length(line) / arc_length(line)[-1]
    along = height + ((asked.height or height) - height) * length
    across = cells_across(section.base, height, growth) if block else 0
    check_size(wake + 1, across + 1, parameter="first_height")
    lower, upper = wake_sides(section, line, across * np.maximum(along - height, 0)) if block else (line, line)
    points = np.vstack([lower[:0:-1], around, upper[1:]])
    heights = np.concatenate([along[:0:-1], np.full(len(around), height), along[1:]])
    opened = unwrapped(points, wake, section.focus, section.tail - section.nose, base)
    return Front(points, wake, line[-1], heights, (lower, upper), across, opened)
