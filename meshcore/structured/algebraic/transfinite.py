"""Transfinite interpolation of a four-sided patch (survey 2.4.1)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any, Union

import numpy as np

from ...errors import InvalidInput
from ...geometry.closest import FacetedSurface
from ...geometry.curves import Curve
from ...mesh import Mesh, StructuredGrid
from ...operation import Param, Port, Relative, operation
from ...progress import Progress, advance, silent
from ...quality import summary, validate
from ...report import Report, Result
from ...sizing import Spacing
from ..folds import folded_cells, refuse_folds
from ..limits import check_size
from ..poisson.winslow_surface import draped
from .blending import Blending, Patch, interpolated
from .crossed_sides import refuse_crossed_sides
from .interior_lines import fitted_lines, fitted_sides, read_lines
from .on_facets import checked_on, folded_on, put_on
from .one_boundary import FOUND
from .overspill import Cure, cured
from .side_parameters import (
    CellsIParam,
    CellsJParam,
    CornersParam,
    EastPort,
    LawIParam,
    LawJParam,
    NorthPort,
    ShiftCornersParam,
    SouthPort,
    SpacingEastParam,
    SpacingNorthParam,
    SpacingSouthParam,
    SpacingWestParam,
    SurfacePort,
    ToleranceParam,
    WestPort,
)
from .sides import NAMES, Asked, Sides

__all__ = ["interpolated", "transfinite"]

_CURE = (
    "space the points of opposite sides alike, blend by arc length, ask for a cure, give lines inside, move the "
    "corners, or split the patch where it folds"
)


@operation("Transfinite Interpolation", category="Structured", output="grid")
def transfinite(
    south: SouthPort,
    east: EastPort = None,
    north: NorthPort = None,
    west: WestPort = None,
    lines: Annotated[
        Union[Mesh, Sequence[Curve], None],
        Port(
            "Chains of line cells inside, from side to opposite side, to become grid lines", cells=("line",), named=True
        ),
    ] = None,
    surface: SurfacePort = None,
    *,
    cells_i: CellsIParam = None,
    cells_j: CellsJParam = None,
    spacing_south: SpacingSouthParam = None,
    spacing_east: SpacingEastParam = None,
    spacing_north: SpacingNorthParam = None,
    spacing_west: SpacingWestParam = None,
    law_i: LawIParam = "as given",
    law_j: LawJParam = "as given",
    blending: Annotated[
        Blending,
        Param("By the sides' lengths, by counts of cells, or smooth and at right angles with the sides"),
    ] = "arc length",
    cure: Annotated[Cure, Param("What may be done about folded cells (overspill)")] = "none",
    corners: CornersParam = FOUND,
    shift_corners: ShiftCornersParam = (0, 0, 0, 0),
    tolerance: ToleranceParam = Relative(1e-6),
    spacings: Mapping[str, Spacing] | None = None,
    slopes: Mapping[str, np.ndarray] | None = None,
    progress: Progress = silent,
) -> Result:
    """Fill a four-sided patch with a structured grid by transfinite interpolation.

    The four sides are kept exactly, point by point, and so are lines inside. In the plane the cells come out
    counter-clockwise: sides that make a left-handed patch have their i reversed, and south stays at j = 0.

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
        The sides, planar or in space, in any direction: they are turned so that they meet as drawn. South alone is
        a closed loop, which is cut at its corners, or a mesh of four chains in any order, of which the first is south.
    lines : Mesh or sequence of Mesh or (n, 3) float, optional
        Coordinate lines inside, in any order and number, each from a side to the opposite one; those of different
        directions must cross. A mesh has one line a chain. They are resampled unless they have as many points as
        the sides beside them; where `cells_i` or `cells_j` is given, points of the sides are moved to their ends.
    surface : Mesh or StructuredGrid, optional
        Triangles or quads on which the points shall lie, such as a scan: each point goes to the closest one. Sides that
        lie farther off than `tolerance` are told.
    cells_i, cells_j : int, optional
        Cells along i and j. Left out, opposite sides must have as many points as each other; of a closed loop, the
        side with fewer points is resampled.
    spacing_south, spacing_east, spacing_north, spacing_west : Length, optional
        Size of the cells that touch that side, measured along the two sides that end there; those are resampled
        by the law of that direction.
    law_i, law_j : str
        Law of the points' spacing along i and j, see `Spacing`. "as given" keeps the sides' own, or is a hyperbolic
        tangent where a size at an end is asked for; "copied" gives north the spacing of south, or east that of west.
    blending : {"arc length", "linear", "cubic"}
        Blending functions. "arc length" carries the spacing of the sides into the interior, as cells at a wall
        need; "linear" blends by the cells' numbers, the textbook's choice. "cubic" is smooth across lines inside
        (cardinal splines by arc length) and leaves the sides at right angles, or with given `slopes`.
    cure : {"none", "sides", "lines", "smoothing", "automatic"}
        What may be done where the grid folds: move the points along the sides, add lines inside, smooth it by the
        Laplace equations (in a plane or on a surface, and without lines or slopes given), or all in turn. The report
        tells what.
    corners : tuple of four int
        Numbers of the loop's corner points, in any order; all -1 picks those that the mesh marks by "vertex" cells or
        by whole-number data of its lines, such as tags, that change there; without four marks, the sharpest turns.
    shift_corners : tuple of four int
        How many points along the loop each corner is moved, in the order in which they come along it.
    tolerance : Length
        Ends of sides that are no farther apart than this are joined; lines may miss sides and each other by it.
    spacings : dict of str to Spacing, optional
        Laws of single sides by name, in the direction in which they are drawn. From Python only.
    slopes : dict of str to (n, 3) float, optional
        For "cubic" blending: by the name of a side, for each of its points the step to the next line across it, in
        the direction of i or j as drawn. Blocks that share a side and its slopes join smoothly. Sides without slopes
        are left free. From Python only.
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
        If sides do not meet, cross in their plane, or have coincident points; the message names the gap or the place.
        If a line inside does not connect opposite sides, or does not cross another.
    GenerationFailed
        If the grid folds over itself or its sides (overspill); `cells` are the folded ones, `partial` the grid.

    References
    ----------
    Survey, section 2.4.1. W. J. Gordon and C. A. Hall, "Construction of curvilinear co-ordinate systems and
    applications to mesh generation", Int. J. Numer. Meth. Engng. 7 (1973). B. K. Soni, "Two- and three-dimensional
    grid generation for internal flow applications of computational fluid dynamics", AIAA 85-1526 (1985), for
    blending by arc length. W. J. Gordon, "Blending-function methods of bivariate and multivariate interpolation and
    approximation", SIAM J. Numer. Anal. 8 (1971), for lines inside.

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
    ends = {"south": spacing_south, "east": spacing_east, "north": spacing_north, "west": spacing_west}
    sides = Sides.read(given, corners, tolerance, shift_corners)
    for name, spacing in _named(spacings, "spacings").items():
        if not isinstance(spacing, Spacing):
            raise InvalidInput(f"of {name} needs a Spacing, got {spacing!r}", parameter="spacings")
    asked = Asked(cells_i, cells_j, law_i, law_j, ends, spacings or {})
    n_i, n_j = (cells + 1 for cells in asked.cells(sides))
    check_size(n_i, n_j, parameter="cells_i" if n_i > n_j else "cells_j")
    fractions = asked.fractions(sides)
    inside = [] if lines is None else read_lines(lines, sides)
    free = {"i": cells_i is not None or sides.loop, "j": cells_j is not None or sides.loop}
    fractions, inside = fitted_sides(sides, fractions, inside, free)
    sides = sides.resampled(fractions)
    sides.refuse_repeats()
    advance(progress, 0.3, "interpolating")
    known = fitted_lines(inside, sides)
    patch = Patch(**sides.lines, lines_i=known["i"], lines_j=known["j"], blending=blending)
    if blending == "cubic" and slopes is not None:
        patch = replace(patch, slopes=_placed(slopes, sides))
    elif slopes is not None:
        raise InvalidInput('are matched by blending="cubic" only', parameter="slopes")
    points = patch.points()
    faces = {face: sides.names[place] for face, place in zip(("jmin", "imax", "jmax", "imin"), NAMES, strict=True)}
    done = []
    if folded_cells(points).any():
        refuse_crossed_sides(StructuredGrid(points), faces, given)
        if cure != "none":
            advance(progress, 0.5, "curing overspill")
            patch, points, done = cured(patch, points, cure)
    grid = StructuredGrid(points, names=faces)
    if surface is None:
        refuse_folds(grid, _insufficient(done))
    else:
        smooths = cure in ("smoothing", "automatic") and not inside and slopes is None
        grid = _on_surface(grid, FacetedSurface(surface), sides.gap, smooths, done)
    validate(grid)
    counts = {"points": grid.n_points, "quads": grid.n_cells}
    return Result(grid, Report(counts=counts, quality=summary(grid), warnings=sides.warnings + done))


def _insufficient(done: list[str]) -> str:
    """What else can be done about folds."""
    return f"{'; '.join(done)}, which did not suffice; {_CURE}" if done else _CURE


def _on_surface(
    grid: StructuredGrid, surface: FacetedSurface, gap: float, smooths: bool, done: list[str]
) -> StructuredGrid:
    """The grid put on a surface and, if need and leave be, smoothed there; what was done is told."""
    grid, told = put_on(surface, grid, gap, "the sides")
    if smooths and folded_on(surface, grid.points[:, :, 0]).any():
        grid = grid.with_points(draped(surface, grid.points[:, :, 0])[0])
        done.append("overspill: the grid was smoothed on the surface by the Laplace equations")
    done += told + checked_on(surface, grid, _insufficient(done))
    return grid


def _named(values: Mapping[str, Any] | None, parameter: str) -> Mapping[str, Any]:
    if values is not None and not isinstance(values, Mapping):
        raise InvalidInput(f"needs a dict with one for each side by name, got {values!r}", parameter=parameter)
    unknown = set(values or {}) - set(NAMES)
    if unknown:
        raise InvalidInput(f"{sorted(unknown)[0]!r} is no side; sides are {', '.join(NAMES)}", parameter=parameter)
    return values or {}


def _placed(slopes: Mapping[str, np.ndarray], sides: Sides) -> dict[str, np.ndarray]:
    """Slopes by the place where their side now is, in the direction of the new i and j."""
    placed = {}
    for place, name in sides.names.items():
        if name not in _named(slopes, "slopes"):
            continue
        try:
            slope = Mesh(slopes[name], {}).points
        except InvalidInput as error:
            raise InvalidInput(f"of {name}: {error}", parameter="slopes") from None
        if slope.shape != sides.lines[place].shape:
            raise InvalidInput(
                f"of {name} has {len(slope)} vectors for {len(sides.lines[place])} points", parameter="slopes"
            )
        if sides.turned:
            slope = slope[::-1] if place in ("south", "north") else -slope
        placed[place] = slope
    return placed
