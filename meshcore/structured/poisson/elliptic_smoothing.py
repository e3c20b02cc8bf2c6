"""Surface grids, planar and curved, smoothed by the elliptic equations (survey 2.5.1, 2.6)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated, Union

import numpy as np

from ...errors import InvalidInput
from ...geometry.closest import FacetedSurface
from ...mesh import Mesh, StructuredGrid
from ...operation import Port, operation
from ...progress import Progress, silent
from ...report import Result
from ...threads import checked_threads
from ..algebraic.on_facets import put_on
from ..algebraic.quad_nets import grid_of
from ..algebraic.side_parameters import SurfacePort
from ..limits import check_extent
from .control_functions import Attractor, ControlFunction
from .elliptic_parameters import (
    ControlParam,
    FirstHeightParam,
    MaxCyclesParam,
    ResidualParam,
    SlidingParam,
    WallAngleParam,
    WallsParam,
    asked_walls,
    check_walls,
)
from .elliptic_problem import Asked, cuts_of, is_left_handed
from .elliptic_surface import solved
from .wall_control import Wall
from .winslow import MOST_CYCLES

_COINCIDENT = 1e-9  # of the extent: how far both sides of a cut may be apart


@operation("Elliptic Smoothing", category="Structured", output="grid")
def elliptically_smoothed(
    grid: Annotated[
        Union[Mesh, StructuredGrid],
        Port("A surface grid: quads in rows and columns, with four corners or around a hole", cells=("quad",)),
    ],
    surface: SurfacePort = None,
    *,
    # Not "boundary spacing": that is measured in the given grid, whose roughness it would keep.
    control: ControlParam = "none",
    walls: WallsParam = "none",
    first_height: FirstHeightParam = None,
    wall_angle: WallAngleParam = 90.0,
    sliding: SlidingParam = False,
    residual: ResidualParam = None,
    max_cycles: MaxCyclesParam = MOST_CYCLES,
    each_wall: Sequence[Wall] = (),
    control_functions: Sequence[ControlFunction] | None = None,
    attractors: Sequence[Attractor] = (),
    threads: int | None = None,
    progress: Progress = silent,
) -> Result:
    """Smooth a planar or curved structured grid by the elliptic equations; its boundary is kept, an O-grid's cut free.

    In a plane, folded cells are unfolded. A curved grid is smoothed on the bicubic surface through its points, or on a
    given one: its coordinates become harmonic on that (Laplace-Beltrami). South is the side j = 0, east the last i,
    north the last j, and west i = 0.

    Parameters
    ----------
    grid : StructuredGrid or Mesh
        A surface grid, in a plane possibly folded; on a curved one a side may be one point. Where its first and last
        points along i or j are the same, or `periodic` says so, it is closed and the cut is free. A mesh has "quad"
        cells in rows and columns: a patch whose i and j begin at the corner with the lowest number, i along the first
        quad's nodes, or a ring around which i runs. A left-handed planar grid is reversed along i, as `warnings` tell;
        sides are those of the result.
    surface : Mesh or StructuredGrid, optional
        Triangles or quads on which the points shall lie, such as a scan. The grid's points are put on it, its boundary,
        too, which is told if it lay off; then they stay on the facets, while the equations hold in the tangent planes
        of normals that turn smoothly. A sharp ridge is so rounded for the equations, not for the points.
    control : {"none", "boundary spacing"}
        Control functions from the given grid's spacing at its sides, or none.
    walls : {"none", "south", "east", "north", "west", "south and north", "west and east", "all"}
        Sides at which lines shall leave at an angle and the first cells have a height, as for `elliptic`.
    first_height : Length, optional
        Length of the first edge at walls.
    wall_angle : float
        Degrees from the wall's direction, in which i or j grows, to the lines that leave it.
    sliding : bool
        Whether the points of walls slide along them to make the angle, between their ends.
    residual : float, optional
        Residual to reach in units of the start's. Left out, cycles go on until each node is within about a thousandth
        of the local spacing from its converged place. Control at walls stops by angle and height instead.
    max_cycles : int
        Multigrid cycles after which to give up.
    each_wall : sequence of Wall
        Walls one by one, each with heights and angles of its own, in place of ``walls``.
    control_functions : two of (ni, nj) float or callables, optional
        P and Q, added to what ``control`` makes; see `elliptic`.
    attractors : sequence of Attractor
        Lines and points of the grid that draw others near, or push them away.
    threads : int, optional
        How many may work, by default all cores; the grid is the same for any number.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Result
        A grid of the same shape, names and data (of a mesh, its point data), and the report, as of `elliptic`.

    Raises
    ------
    InvalidInput
        If the grid has layers, or a control is impossible, such as sliding on a curved grid.
    InvalidGeometry
        If the quads of a mesh are not in rows and columns, or a surface has no facets, or one side only.
    GenerationFailed
        If cells stay folded; `cells` are the folded ones, `partial` the grid.

    References
    ----------
    Survey, sections 2.5.1 and 2.6. J. F. Thompson, Z. U. A. Warsi, C. W. Mastin, "Numerical Grid Generation" (1985),
    chapter VI. Z. U. A. Warsi, J. Comput. Phys. 64 (1986), for surfaces.

    Examples
    --------
    >>> from meshcore import gallery
    >>> from meshcore.structured import o_grid
    >>> rough, _ = o_grid(gallery.airfoil("naca0012", cells=64), radius=4, layers=24, first_height=0.02)
    >>> grid, report = elliptically_smoothed(rough, walls="south", first_height=0.02)
    >>> report.converged, report.quality["error of wall angles (degree)"] < 1
    (True, True)
    """
    given = _as_surface(grid)
    check_extent(given.flat(given.points), parameter="grid")
    start, warnings = _right_handed(_closed(given))
    check_walls(each_wall)
    if each_wall and walls != "none":
        raise InvalidInput("is given beside walls; give only one of them", parameter="each_wall")
    named = asked_walls(walls, first_height, wall_angle, sliding, diagonal=start.diagonal, cuts=cuts_of(start))
    asked = Asked(
        control=control,
        control_functions=control_functions,
        attractors=attractors,
        walls=named or each_wall,
        residual=residual,
        most_cycles=max_cycles,
        threads=checked_threads(threads),
    )
    faceted = None if surface is None else FacetedSurface(surface)
    if faceted is not None:
        start, told = put_on(faceted, start, _COINCIDENT * start.diagonal, "the grid's sides")
        warnings += told
    result = solved(start, asked, faceted, progress)
    result.report.warnings[:0] = warnings
    return result


def _as_surface(grid: Mesh | StructuredGrid) -> StructuredGrid:
    if isinstance(grid, Mesh):
        return grid_of(grid, "grid")
    if not isinstance(grid, StructuredGrid):
        raise InvalidInput(f"needs a StructuredGrid or a Mesh, got {type(grid).__name__}", parameter="grid")
    if not grid.is_surface:
        raise InvalidInput(f"needs one layer of points, got {grid.shape[2]}", parameter="grid")
    return grid


def _closed(grid: StructuredGrid) -> StructuredGrid:
    """The grid, periodic along an axis whose first and last points are the same: not every file can say so."""
    points = grid.points.copy()
    periodic = list(grid.periodic)
    for axis in range(2):
        lines = np.moveaxis(points, axis, 0)
        if len(lines) > 3 and np.abs(lines[-1] - lines[0]).max() <= _COINCIDENT * grid.diagonal:
            lines[-1] = lines[0]
            periodic[axis] = True
    return replace(grid, points=points, periodic=tuple(periodic))


def _right_handed(grid: StructuredGrid) -> tuple[StructuredGrid, list[str]]:
    """The grid, reversed if need be, and whether it was."""
    if not is_left_handed(grid):
        return grid, []
    return grid.reversed_along_i(), ["the grid was left-handed; its i is reversed: east and west have changed places"]
