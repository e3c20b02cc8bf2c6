"""Transfinite interpolation of a four-sided patch (survey 2.4.1)."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from ..errors import InvalidGeometry, InvalidInput
from ..geometry.curves import Curve, arc_length, is_closed, polyline, resampled, sharpest_corners
from ..mesh import StructuredGrid
from ..operation import Length, Param, Port, Relative, absolute, operation
from ..progress import Progress, advance, silent
from ..report import Report, Result

_SIDE = "line cells in one chain, or points in order"


@operation("Transfinite Interpolation", category="Structured", output="grid")
def transfinite(
    south: Annotated[Curve, Port(f"South side, or one closed loop in place of all four: {_SIDE}", cells=("line",))],
    east: Annotated[Curve | None, Port(f"East side: {_SIDE}", cells=("line",))] = None,
    north: Annotated[Curve | None, Port(f"North side: {_SIDE}", cells=("line",))] = None,
    west: Annotated[Curve | None, Port(f"West side: {_SIDE}", cells=("line",))] = None,
    *,
    cells_i: Annotated[
        int | None, Param("Cells along south and north; by default as their points are given", min=1, soft_max=500)
    ] = None,
    cells_j: Annotated[
        int | None, Param("Cells along west and east; by default as their points are given", min=1, soft_max=500)
    ] = None,
    corners: Annotated[
        tuple[int, int, int, int],
        Param("Points of a closed loop that are its corners; four times -1 finds them", min=-1, advanced=True),
    ] = (-1, -1, -1, -1),
    tolerance: Annotated[Length, Param("Largest gap between ends of sides that is closed", min=0, advanced=True)] = (
        Relative(1e-6)
    ),
    progress: Progress = silent,
) -> Result:
    """Fill a four-sided patch with a structured grid by transfinite interpolation.

    The four sides are kept exactly, point by point.

    ::

              north
        NW ----------> NE
         ^             ^
    west |   j         | east
         |   +-> i     |
        SW ----------> SE
              south

    Parameters
    ----------
    south, east, north, west : Mesh or (n, 3) float
        The sides, planar or in space, in any direction: they are turned so that they meet as drawn. With south
        alone, it must be a closed loop, which is cut at its corners.
    cells_i, cells_j : int, optional
        Cells along i and j. Left out, opposite sides must have as many points as each other.
    corners : tuple of four int
        Numbers of the loop's corner points, in order; all -1 picks the sharpest turns.
    tolerance : Length
        Ends of sides that are no farther apart than this are joined.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Result
        `StructuredGrid` of (ni, nj, 1) points, and the report.

    Raises
    ------
    InvalidInput
        If opposite sides differ in their number of points.
    InvalidGeometry
        If sides do not meet; the message names the gap.

    References
    ----------
    Survey, section 2.4.1. W. J. Gordon and C. A. Hall, "Construction of curvilinear co-ordinate systems and
    applications to mesh generation", Int. J. Numer. Meth. Engng. 7 (1973).

    Examples
    --------
    >>> import numpy as np
    >>> x = np.linspace(0, 1, 5)
    >>> south = np.column_stack([x, 0.1 * np.sin(np.pi * x)])
    >>> grid, report = transfinite(south, [[1, 0], [1, 1]], [[0, 1], [1, 1]], [[0, 0], [0, 1]], cells_i=4, cells_j=2)
    >>> grid
    StructuredGrid(5 x 3 points)
    """
    sides = _sides(south, east, north, west, corners, tolerance)
    south, east, north, west = _matched(sides, cells_i, cells_j)
    advance(progress, 0.5, "interpolating")
    grid = StructuredGrid(interpolated(south, east, north, west))
    counts = {"points": grid.n_points, "quads": grid.n_cells}
    return Result(grid, Report(counts=counts))


def interpolated(south: np.ndarray, east: np.ndarray, north: np.ndarray, west: np.ndarray) -> np.ndarray:
    """(ni, nj, 3) float: the Boolean sum P_s + P_t - P_s P_t of linear projections, with sides that meet exactly."""
    s = np.linspace(0, 1, len(south))[:, None, None]
    t = np.linspace(0, 1, len(west))[None, :, None]
    along_s = (1 - s) * west[None] + s * east[None]
    along_t = (1 - t) * south[:, None] + t * north[:, None]
    product = (1 - s) * ((1 - t) * south[0] + t * north[0]) + s * ((1 - t) * south[-1] + t * north[-1])
    points = along_s + along_t - product
    points[:, 0], points[:, -1], points[0], points[-1] = south, north, west, east  # to the last bit
    return points


def _sides(south, east, north, west, corners, tolerance) -> list[np.ndarray]:
    """The four sides, directed as drawn and meeting exactly."""
    given = {"south": south, "east": east, "north": north, "west": west}
    missing = [name for name, side in given.items() if side is None]
    if missing == ["east", "north", "west"]:
        return _cut(polyline(south, "south"), corners)
    if missing:
        raise InvalidInput("is missing; give all four sides, or one closed loop as south", parameter=missing[0])
    lines = {name: polyline(side, name) for name, side in given.items()}
    everything = np.concatenate(list(lines.values()))
    gap = absolute(tolerance, float(np.linalg.norm(np.ptp(everything, axis=0))))
    return _joined(lines, gap)


def _cut(loop: np.ndarray, corners: tuple[int, ...]) -> list[np.ndarray]:
    """Cut a closed loop at four corners into south, east, north, west."""
    if not is_closed(loop):
        raise InvalidGeometry(
            "is open; close the loop, or give all four sides", parameter="south", points=(0, len(loop) - 1)
        )
    n = len(loop) - 1
    at = sharpest_corners(loop) if set(corners) == {-1} else np.array(corners)
    if len(set(at.tolist())) != 4 or (at < 0).any() or (at >= n).any():
        raise InvalidInput(
            f"needs four different points between 0 and {n - 1}, got {tuple(corners)}", parameter="corners"
        )
    at = np.sort(at)
    stops = np.append(at[1:], at[0] + n)
    south, east, north, west = (loop[np.arange(a, b + 1) % n] for a, b in zip(at, stops, strict=True))
    return [south, east, north[::-1], west[::-1]]


def _joined(lines: dict[str, np.ndarray], gap: float) -> list[np.ndarray]:
    """Direct the sides as drawn and close gaps up to ``gap``; south keeps its direction if it can."""

    def distance(a: np.ndarray, b: np.ndarray) -> float:
        return float(np.linalg.norm(a - b))

    best: tuple[float, list[np.ndarray]] | None = None
    for turn in range(16):
        s, e, n, w = (line[::-1] if turn >> k & 1 else line for k, line in enumerate(lines.values()))
        gaps = [distance(s[0], w[0]), distance(s[-1], e[0]), distance(e[-1], n[-1]), distance(w[-1], n[0])]
        if best is None or max(gaps) < best[0]:
            best = (max(gaps), [s, e, n, w])
            worst = int(np.argmax(gaps))
    if best[0] > gap:
        corner = ("south and west", "south and east", "east and north", "west and north")[worst]
        raise InvalidGeometry(
            f"{corner} end {best[0]:.6g} apart; move their ends together, or raise tolerance above that",
            parameter=corner.split()[0],
        )
    south, east, north, west = (side.copy() for side in best[1])
    west[0], east[0], east[-1], west[-1] = south[0], south[-1], north[-1], north[0]
    return [south, east, north, west]


def _matched(sides: list[np.ndarray], cells_i: int | None, cells_j: int | None) -> list[np.ndarray]:
    """The sides with as many points as their opposites."""
    south, east, north, west = sides
    south, north = _matched_pair(south, north, cells_i, "south", "north", "cells_i")
    west, east = _matched_pair(west, east, cells_j, "west", "east", "cells_j")
    return [south, east, north, west]


def _matched_pair(a, b, cells, name_a, name_b, parameter) -> tuple[np.ndarray, np.ndarray]:
    if cells is None:
        if len(a) != len(b):
            raise InvalidInput(
                f"{name_a} has {len(a)} points, {name_b} {len(b)}; give {parameter} to resample both", parameter=name_b
            )
        return a, b
    return _with_cells(a, cells), _with_cells(b, cells)


def _with_cells(side: np.ndarray, cells: int) -> np.ndarray:
    """``side`` with a number of cells; its own relative spacing is stretched, not lost."""
    if len(side) == cells + 1:
        return side
    length = arc_length(side)
    spacing = np.interp(np.linspace(0, 1, cells + 1), np.linspace(0, 1, len(side)), length / length[-1])
    return resampled(side, spacing)
