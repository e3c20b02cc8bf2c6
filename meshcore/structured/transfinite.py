"""Transfinite interpolation of a four-sided patch (survey 2.4.1)."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np

from ..errors import InvalidGeometry, InvalidInput
from ..geometry.curves import Curve, arc_length, chains, is_closed, polyline, resampled, sharpest_corners
from ..mesh import Mesh, StructuredGrid
from ..operation import Length, Param, Port, Relative, absolute, operation
from ..progress import Progress, advance, silent
from ..quality import summary, validate
from ..report import Report, Result
from ..sizing import hyperbolic_tangent
from .folds import refuse_folds
from .limits import check_size

_SIDE = "line cells in one chain, or points in order"
_CURE = (
    "space the points of opposite sides alike, blend by arc length, move the corners, or split the patch where it folds"
)
Blending = Literal["arc length", "linear"]


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
    spacing_south: Annotated[Length | None, Param("Height of the cells at the south side", group="Spacing")] = None,
    spacing_east: Annotated[Length | None, Param("Width of the cells at the east side", group="Spacing")] = None,
    spacing_north: Annotated[Length | None, Param("Height of the cells at the north side", group="Spacing")] = None,
    spacing_west: Annotated[Length | None, Param("Width of the cells at the west side", group="Spacing")] = None,
    blending: Annotated[
        Blending, Param("Whether the sides' spacing reaches the interior, or counts of cells alone blend")
    ] = "arc length",
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

    The four sides are kept exactly, point by point. In the plane the cells come out counter-clockwise: sides that
    make a left-handed patch have their i reversed, and south stays at j = 0.

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
        Cells along i and j. Left out, opposite sides must have as many points as each other; of a closed loop, the
        side with fewer points is resampled.
    spacing_south, spacing_east, spacing_north, spacing_west : Length, optional
        Size of the cells that touch that side, measured along the two sides that end there; those are resampled
        by a hyperbolic tangent.
    blending : {"arc length", "linear"}
        Blending functions. "arc length" carries the spacing of the sides into the interior, as cells at a wall
        need; "linear" blends by the cells' numbers, the textbook's choice.
    corners : tuple of four int
        Numbers of the loop's corner points, in any order; all -1 picks the sharpest turns.
    tolerance : Length
        Ends of sides that are no farther apart than this are joined.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Result
        `StructuredGrid` of (ni, nj, 1) points whose faces are named after the sides, and the report.

    Raises
    ------
    InvalidInput
        If opposite sides differ in their number of points, or a spacing cannot be had.
    InvalidGeometry
        If sides do not meet, or have coincident points; the message names the gap or the points.
    GenerationFailed
        If the grid folds over itself or its sides (overspill); `cells` are the folded ones, `partial` the grid.

    References
    ----------
    Survey, section 2.4.1. W. J. Gordon and C. A. Hall, "Construction of curvilinear co-ordinate systems and
    applications to mesh generation", Int. J. Numer. Meth. Engng. 7 (1973). B. K. Soni, "Two- and three-dimensional
    grid generation for internal flow applications of computational fluid dynamics", AIAA 85-1526 (1985), for
    blending by arc length.

    Examples
    --------
    >>> import numpy as np
    >>> x = np.linspace(0, 1, 5)
    >>> south = np.column_stack([x, 0.1 * np.sin(np.pi * x)])
    >>> grid, report = transfinite(south, [[1, 0], [1, 1]], [[0, 1], [1, 1]], [[0, 0], [0, 1]], cells_i=4, cells_j=2)
    >>> grid
    StructuredGrid(5 x 3 points)
    """
    given = {"south": south, "east": east, "north": north, "west": west}
    spacings = {"south": spacing_south, "east": spacing_east, "north": spacing_north, "west": spacing_west}
    sides, names = _right_handed(*_sides(given, corners, tolerance))
    diagonal = float(np.linalg.norm(np.ptp(np.concatenate(sides), axis=0)))
    ends = [None if spacings[n] is None else absolute(spacings[n], diagonal) for n in names]
    n_i, n_j = (cells_i or max(map(len, sides[::2])) - 1) + 1, (cells_j or max(map(len, sides[1::2])) - 1) + 1
    check_size(n_i, n_j, parameter="cells_i" if n_i > n_j else "cells_j")
    sides = _matched(sides, names, cells_i, cells_j, ends, loop=east is None)
    advance(progress, 0.5, "interpolating")
    faces = dict(zip(("jmin", "imax", "jmax", "imin"), names, strict=True))
    grid = StructuredGrid(interpolated(*sides, blending=blending), names=faces)
    refuse_folds(grid, _CURE)
    validate(grid)
    counts = {"points": grid.n_points, "quads": grid.n_cells}
    return Result(grid, Report(counts=counts, quality=summary(grid)))


def interpolated(
    south: np.ndarray, east: np.ndarray, north: np.ndarray, west: np.ndarray, *, blending: Blending = "linear"
) -> np.ndarray:
    """The Boolean sum P_s + P_t - P_s P_t of linear projections between sides that meet exactly.

    Parameters
    ----------
    south, north : (ni, 3) float
        Sides at j = 0 and at the last j, in the direction of i.
    east, west : (nj, 3) float
        Sides at the last i and at i = 0, in the direction of j.
    blending : {"linear", "arc length"}
        Whether s and t are the cells' numbers or the sides' lengths, see `transfinite`.

    Returns
    -------
    (ni, nj, 3) float
        Points whose outermost rows are the sides, to the last bit.

    Examples
    --------
    >>> x, y = np.array([0, 0.5, 1]), np.zeros(3)
    >>> south, west = np.column_stack([x, y, y]), np.column_stack([y, x, y])
    >>> interpolated(south, west + [1, 0, 0], south + [0, 1, 0], west)[1, 1]
    array([0.5, 0.5, 0. ])
    """
    if blending == "linear":
        s = np.linspace(0, 1, len(south))[:, None]
        t = np.linspace(0, 1, len(west))[None, :]
    else:
        s, t = _by_length(south, east, north, west)
    s, t = s[..., None], t[..., None]
    along_s = (1 - s) * west[None] + s * east[None]
    along_t = (1 - t) * south[:, None] + t * north[:, None]
    product = (1 - s) * ((1 - t) * south[0] + t * north[0]) + s * ((1 - t) * south[-1] + t * north[-1])
    points = along_s + along_t - product
    points[:, 0], points[:, -1], points[0], points[-1] = south, north, west, east  # to the last bit
    return points


def _by_length(south, east, north, west) -> tuple[np.ndarray, np.ndarray]:
    """(ni, nj) s and t whose lines are straight between the fractions of length on opposite sides.

    ``s = (1 - t) s_south + t s_north`` and ``t = (1 - s) t_west + s t_east`` (Soni 1985) are linear in each other.
    """
    s_south, s_north, t_west, t_east = (_fractions(side) for side in (south, north, west, east))
    s0, ds = s_south[:, None], (s_north - s_south)[:, None]
    t0, dt = t_west[None, :], (t_east - t_west)[None, :]
    across = 1 - ds * dt
    return (s0 + t0 * ds) / across, (t0 + s0 * dt) / across


def _fractions(side: np.ndarray) -> np.ndarray:
    length = arc_length(side)
    return length / length[-1]


def _sides(given: dict[str, Curve | None], corners, tolerance) -> list[np.ndarray]:
    """The four sides, directed as drawn and meeting exactly."""
    missing = [name for name, side in given.items() if side is None]
    if missing == ["east", "north", "west"]:
        return _cut(given["south"], corners)
    if missing:
        raise InvalidInput("is missing; give all four sides, or one closed loop as south", parameter=missing[0])
    lines = {name: polyline(side, name) for name, side in given.items()}
    everything = np.concatenate(list(lines.values()))
    gap = absolute(tolerance, float(np.linalg.norm(np.ptp(everything, axis=0))))
    return _joined(lines, gap)


def _cut(curve: Curve, corners: tuple[int, ...]) -> list[np.ndarray]:
    """Cut a closed loop at four corners into south, east, north, west."""
    loop = polyline(curve, "south")
    n = len(loop) - 1
    # Points are numbered as the user numbers them: in a mesh, not in the order of the chain.
    number = chains(curve)[0] if isinstance(curve, Mesh) and len(curve.get("line")) else np.arange(n + 1)
    if not is_closed(loop):
        raise InvalidGeometry(
            "is open; close the loop, or give all four sides", parameter="south", points=number[[0, -1]]
        )
    if set(corners) == {-1}:
        at = sharpest_corners(loop)
    else:
        at = np.flatnonzero(np.isin(number[:-1], corners))
    if len(at) != 4:
        raise InvalidInput(f"needs four different points of the loop, got {tuple(corners)}", parameter="corners")
    stops = np.append(at[1:], at[0] + n)
    south, east, north, west = (loop[np.arange(a, b + 1) % n] for a, b in zip(at, stops, strict=True))
    return [south, east, north[::-1], west[::-1]]


def _right_handed(south, east, north, west) -> tuple[list[np.ndarray], list[str]]:
    """The sides and their names; in a plane of constant z, with i reversed if they run clockwise."""
    sides = [south, east, north, west]
    loop = np.concatenate([south[:-1], east[:-1], north[:0:-1], west[:0:-1]])
    x, y, z = loop.T
    clockwise = (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() < 0
    if clockwise and (z == z[0]).all():
        return [south[::-1], west, north[::-1], east], ["south", "west", "north", "east"]
    return sides, ["south", "east", "north", "west"]


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


def _matched(sides, names, cells_i, cells_j, ends, *, loop: bool) -> list[np.ndarray]:
    """The sides with as many points as their opposites, and with the spacings that were asked for at their ends."""
    south, east, north, west = sides
    if loop:  # its corners were found, not given, so nobody can know how many points each side has
        cells_i = cells_i or max(len(south), len(north)) - 1
        cells_j = cells_j or max(len(west), len(east)) - 1
    near_south, near_east, near_north, near_west = ends
    at_i = {"first": near_west, "last": near_east}
    at_j = {"first": near_south, "last": near_north}
    south, north = _matched_pair(south, north, cells_i, (names[0], names[2], "cells_i"), at_i, (names[3], names[1]))
    west, east = _matched_pair(west, east, cells_j, (names[3], names[1], "cells_j"), at_j, (names[0], names[2]))
    sides = [south, east, north, west]
    for name, side in zip(names, sides, strict=True):
        repeated = np.flatnonzero((side[1:] == side[:-1]).all(axis=1))
        if len(repeated):
            raise InvalidGeometry(
                f"points {repeated[0]} and {repeated[0] + 1} coincide; remove one, or resample by cells_i and cells_j",
                parameter=name,
                points=repeated,
            )
    return sides


def _matched_pair(a, b, cells, names, ends, end_names) -> tuple[np.ndarray, np.ndarray]:
    """Two opposite sides resampled to ``cells``, and with ``ends`` at the two sides called ``end_names``."""
    name_a, name_b, parameter = names
    if cells is None:
        if len(a) != len(b):
            raise InvalidInput(
                f"{name_a} has {len(a)} points, {name_b} {len(b)}; give {parameter} to resample both", parameter=name_b
            )
        cells = len(a) - 1
    if any(end is not None for end in ends.values()):
        return _clustered(a, cells, ends, end_names), _clustered(b, cells, ends, end_names)
    return _with_cells(a, cells), _with_cells(b, cells)


def _with_cells(side: np.ndarray, cells: int) -> np.ndarray:
    """``side`` with a number of cells; its own relative spacing is stretched, not lost."""
    if len(side) == cells + 1:
        return side
    spacing = np.interp(np.linspace(0, 1, cells + 1), np.linspace(0, 1, len(side)), _fractions(side))
    return resampled(side, spacing)


def _clustered(side: np.ndarray, cells: int, ends: dict[str, float | None], end_names) -> np.ndarray:
    """``side`` resampled to ``cells`` with the given first and last cell."""
    length = arc_length(side)[-1]
    fractions = {end: None if size is None else size / length for end, size in ends.items()}
    try:
        return resampled(side, hyperbolic_tangent(cells, **fractions))
    except InvalidInput as error:
        name = end_names[0 if error.parameter == "first" else 1]
        size = ends[error.parameter]
        raise InvalidInput(
            f"{size:.6g} does not fit a side of length {length:.6g} with {cells} cells: {error}; "
            "change it or the number of cells",
            parameter=f"spacing_{name}",
        ) from None
