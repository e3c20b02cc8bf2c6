"""Elliptic grids between four sides, in a plane, in space or on a surface (survey 2.5.1, 2.6)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated

from ...errors import GenerationFailed, InvalidInput
from ...geometry.closest import FacetedSurface
from ...geometry.curves import Curve
from ...mesh import StructuredGrid
from ...operation import Length, Param, Relative, absolute, operation
from ...progress import Progress, part_of, silent
from ...report import Result
from ...sizing import Spacing
from ...threads import checked_threads
from ..algebraic.on_facets import put_on
from ..algebraic.one_boundary import FOUND
from ..algebraic.side_parameters import (
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
from ..algebraic.sides import NAMES
from ..algebraic.transfinite import transfinite
from .control_functions import Attractor, ControlFunction
from .elliptic_parameters import (
    ControlParam,
    FirstHeightParam,
    MaxCyclesParam,
    ResidualParam,
    SlidingParam,
    WallAngleParam,
    Walls,
    WallsParam,
    asked_walls,
    sides_of,
)
from .elliptic_problem import Asked, Equation
from .elliptic_surface import solved
from .winslow import CUT, MOST_CYCLES

_TAKE_HEIGHTS = ("as given", "hyperbolic tangent", "hyperbolic sine", "poisson")  # at both ends


@operation("Elliptic Grid", category="Structured", output="grid")
def elliptic(
    south: SouthPort,
    east: EastPort = None,
    north: NorthPort = None,
    west: WestPort = None,
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
    equation: Annotated[
        Equation, Param("Poisson with control functions, or biharmonic: slopes at walls at once, folds more easily")
    ] = "Poisson",
    control: ControlParam = "boundary spacing",
    walls: WallsParam = "none",
    first_height: FirstHeightParam = None,
    wall_angle: WallAngleParam = 90.0,
    sliding: SlidingParam = False,
    periodic: Annotated[
        bool, Param("Whether east is west moved along, and the grid runs on through both, as between blades")
    ] = False,
    residual: ResidualParam = None,
    max_cycles: MaxCyclesParam = MOST_CYCLES,
    corners: CornersParam = FOUND,
    shift_corners: ShiftCornersParam = (0, 0, 0, 0),
    tolerance: ToleranceParam = Relative(1e-6),
    spacings: Mapping[str, Spacing] | None = None,
    control_functions: Sequence[ControlFunction] | None = None,
    attractors: Sequence[Attractor] = (),
    threads: int | None = None,
    progress: Progress = silent,
) -> Result:
    """Fill a four-sided patch, planar or on a curved surface, with a smooth grid by the elliptic equations.

    The transfinite grid between the sides, which are kept, is smoothed by the transformed Laplace or Poisson
    equations. Corners of the boundary do not reach inside, and where transfinite interpolation spills over the boundary
    this grid does not fold.

    ::

        Laplace: lines keep off a convex wall,        boundary spacing: they stay
        and close up in a concave corner              as near as at the sides

    Parameters
    ----------
    south, east, north, west : Mesh or (n, 3) float
        The sides, as for `transfinite`. South alone is a closed loop, or four chains. Between sides that do not lie in
        one plane the grid is harmonic on the bicubic surface through the points of transfinite interpolation, where
        nothing unfolds it.
    surface : Mesh or StructuredGrid, optional
        Triangles or quads on which the points shall lie, such as a scan. Sides that lie off it are put on it, as
        `warnings` tell. The points lie on the facets themselves; the equations are those of the smooth surface of
        second order that the facets stand for: what is tangential to it of ``g22 r_ii - 2 g12 r_ij + g11 r_jj``
        vanishes. A sharp ridge is so for the points, while the equations turn smoothly over the facets beside it.
    cells_i, cells_j : int, optional
        Cells along i and j. Left out, opposite sides must have as many points as each other.
    spacing_south, spacing_east, spacing_north, spacing_west : Length, optional
        Size of the cells that touch that side, measured along the two sides that end there.
    law_i, law_j : str
        Law of the points' spacing along i and j, as for `transfinite`.
    equation : {"Poisson", "biharmonic"}
        Poisson's equation with control functions, or the biharmonic one in the grid's coordinates, which takes angle
        and first height at walls as they are, at once; it may fold, and is for small grids.
    control : {"boundary spacing", "none"}
        Control functions from the boundary's spacing (Thomas and Middlecoff, with the boundary's curvature), or none.
    walls : {"none", "south", "east", "north", "west", "south and north", "west and east", "all"}
        Sides at which control functions are found, while the grid is solved, so that lines leave the wall at an angle
        and the first cells have a height (Steger and Sorenson); on a surface, in its tangent planes.
    first_height : Length, optional
        Length of the first edge at walls. Where cells are given, the two sides that end at a wall get it as their
        spacing there, unless another is asked for; sides that keep their points should have it.
    wall_angle : float
        Degrees from the wall's direction, in which i or j grows, to the lines that leave it.
    sliding : bool
        Whether the points of walls slide along them to make the angle (Neumann's condition), between their ends.
    periodic : bool
        Whether east is west moved along, as between the blades of a row: the grid runs on through both, whose points
        are free and stay alike.
    residual : float, optional
        Residual to reach in units of the start's. Left out, cycles go on until each node is within about a thousandth
        of the local spacing from its converged place. Control at walls stops by angle and height instead.
    max_cycles : int
        Multigrid cycles after which to give up.
    corners, shift_corners : tuple of four int
        Numbers of the loop's corner points, and how many points along it each is moved, as for `transfinite`.
    tolerance : Length
        Ends of sides that are no farther apart than this are joined.
    spacings : dict of str to Spacing, optional
        Laws of single sides by name, as for `transfinite`. From Python only.
    control_functions : two of (ni, nj) float or callables, optional
        P and Q of ``g22 (r_ii + P r_i) - 2 g12 r_ij + g11 (r_jj + Q r_j) = 0`` in units of the index, or functions of
        i and j; between -2 and 2. They are added to what ``control`` makes.
    attractors : sequence of Attractor
        Lines and points of the grid that draw others near, or push them away.
    threads : int, optional
        How many may work, by default all cores; the grid is the same for any number.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Result
        `StructuredGrid` of (ni, nj, 1) points whose faces are named after the sides, and the report, with the
        residual's history. Not converged, or control functions that had to be made smaller, are told in `warnings`.

    Raises
    ------
    InvalidInput
        If the sides do not fit each other, or a control is impossible, such as sliding on a curved patch.
    InvalidGeometry
        If sides do not meet, cross each other, or have coincident points; if a surface has no facets, or one side only.
    GenerationFailed
        If cells stay folded; `cells` are the folded ones, `partial` the grid.

    Notes
    -----
    Nonlinear multigrid (full approximation scheme) with alternating zebra line smoothing, started by full multigrid and
    sped up by Anderson mixing: work grows like the number of points. Cells that the discrete equations leave folded,
    at re-entrant corners, are unfolded by a barrier on the patch around them.

    References
    ----------
    Survey, sections 2.5.1 and 2.6. J. F. Thompson, Z. U. A. Warsi, C. W. Mastin, "Numerical Grid Generation" (1985),
    chapter VI. Z. U. A. Warsi, J. Comput. Phys. 64 (1986), for surfaces. P. D. Thomas, J. F. Middlecoff, AIAA J. 18
    (1980). J. L. Steger, R. L. Sorenson, J. Comput. Phys. 33 (1979).

    Examples
    --------
    >>> from meshcore import gallery
    >>> grid, report = elliptic(*gallery.wavy_sides(16, 8), control="none", residual=1e-8)
    >>> grid, report.converged, len(report.history) < 14
    (StructuredGrid(17 x 9 points), True, True)
    """
    ends = (spacing_south, spacing_east, spacing_north, spacing_west)
    asked_spacings = {f"spacing_{side}": one for side, one in zip(NAMES, ends, strict=True) if one is not None}
    across = {"south": (cells_j, law_j), "west": (cells_i, law_i)}
    at_walls = _end_spacings(walls, first_height, {**across, "north": across["south"], "east": across["west"]})
    given = {
        "cells_i": cells_i,
        "cells_j": cells_j,
        **(at_walls | asked_spacings),
        "law_i": law_i,
        "law_j": law_j,
        "spacings": spacings,
        "blending": "arc length",
        "corners": corners,
        "shift_corners": shift_corners,
        "tolerance": tolerance,
    }
    try:
        start, warnings = _transfinite_start(south, east, north, west, progress=part_of(progress, 0.0, 0.1), **given)
    except InvalidInput as error:
        if error.parameter in set(at_walls) - set(asked_spacings):  # the user gave no such thing
            raise InvalidInput(str(error).partition(": ")[2], parameter="first_height") from None
        raise
    faceted = None if surface is None else FacetedSurface(surface)
    if faceted is not None:
        start, told = put_on(faceted, start, absolute(tolerance, start.diagonal), "the sides")
        warnings += told
    given_walls = asked_walls(
        walls,
        first_height,
        wall_angle,
        sliding,
        diagonal=start.diagonal,
        places=_places(start),
        cuts=CUT if periodic else (),
    )
    asked = Asked(
        equation=equation,
        control=control,
        control_functions=control_functions,
        attractors=attractors,
        walls=given_walls,
        periodic=periodic,
        residual=residual,
        most_cycles=max_cycles,
        threads=checked_threads(threads),
    )
    result = solved(start, asked, faceted, part_of(progress, 0.1, 1.0))
    result.report.warnings[:0] = warnings
    return result


def _end_spacings(walls: Walls, height: Length | None, across: Mapping[str, tuple]) -> dict[str, Length]:
    """The first height as the spacing at walls, where the sides that end there get new points by a law that takes it.

    A wall whose neighbours have cells of another height at it cannot have that height up to its ends.
    """
    if height is None:
        return {}
    found = {}
    for side in sides_of(walls):
        cells, law = across[side]
        if cells is not None and law in _TAKE_HEIGHTS:
            found[f"spacing_{side}"] = height
    return found


def _transfinite_start(*sides: Curve | None, **given) -> tuple[StructuredGrid, list[str]]:
    """The transfinite grid between the sides, folded or not, and what was turned to make it."""
    try:
        grid, report = transfinite(*sides, **given)
    except GenerationFailed as failure:
        if failure.partial is None:
            raise
        return failure.partial, []
    return grid, report.warnings


def _places(grid: StructuredGrid) -> dict[str, str]:
    """Where the sides stand in a grid that had to be turned."""
    faces = {"jmin": "south", "imax": "east", "jmax": "north", "imin": "west"}
    return {name: faces[face] for face, name in grid.names.items()}
