"""Delaunay refinement: quality triangles for any planar straight-line graph."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np

from ..errors import InvalidInput
from ..geometry.plane import fitted_plane
from ..mesh import Mesh
from ..operation import Length, Param, Port, absolute, operation
from ..progress import Progress, advance, forwards, part_of, silent
from ..report import Result
from ..sizing.size_field import SizeField
from .assembly import assembled
from .boundary_lines import first_line, used_points
from .constrained import constrained
from .domain import collected_seeds, domain
from .front import Front
from .lattice import STEEPEST, filled
from .painted import sizing
from .planar_graph import planar_graph
from .refiner import Refiner


@operation("Delaunay Refinement", category="Unstructured")
def delaunay_refinement(
    boundary: Annotated[Mesh, Port("Closed loops of line cells, planar; loops inside are holes", cells=("line",))],
    background: Annotated[
        Mesh | None,
        Port("Triangles whose point array is the size wanted, over the boundary", cells=("triangle", "quad")),
    ] = None,
    seeds: Annotated[
        Mesh | None,
        Port('Points in holes; or in regions, by point arrays "tag", "max_area" and, not zero in holes, "hole"'),
    ] = None,
    *,
    min_angle: Annotated[
        float,
        Param(
            "Smallest angle of a triangle; 0 adds no points for shape, above 33 may not end",
            min=0,
            max=34,
            unit="degree",
        ),
    ] = 30.0,
    size: Annotated[Length | None, Param("Largest edge length; none by default")] = None,
    max_area: Annotated[float | None, Param("Largest area of a triangle; none by default", min=0)] = None,
    size_array: Annotated[
        str,
        Param("Point array of sizes, of the background or else of the boundary; empty for none", array=True),
    ] = "",
    gradation: Annotated[
        float | None,
        Param("Largest growth of the size per unit length, such as 0.2; no limit by default", min=0),
    ] = None,
    placement: Annotated[
        Literal["automatic", "off-centre", "circumcentre", "lattice", "front"],
        Param("Where new points go inside", advanced=True),
    ] = "automatic",
    smoothing: Annotated[
        int, Param("Rounds of smoothing at the end, which make small angles larger", min=0, soft_max=10)
    ] = 0,
    split_boundary: Annotated[
        bool, Param("Lines may get points; without, angles and sizes near them are what the lines allow", advanced=True)
    ] = True,
    crossings: Annotated[
        Literal["refuse", "split"], Param("What to do where lines cross: refuse, or split both", advanced=True)
    ] = "refuse",
    lines: Annotated[
        bool, Param("Give the pieces of the lines too, as line cells with their tags and numbers", advanced=True)
    ] = False,
    size_field: SizeField | None = None,
    holes: Any = None,
    regions: Any = None,
    progress: Progress = silent,
) -> Result:
    """Triangulate what closed loops of lines enclose, with no angle below a bound.

    Closed loops nest by the even-odd rule: outline, hole, island; a loop that shares lines with another is a second
    part beside it, not a hole. Lines that end inside an outline are kept as edges.
    All lines are kept, split where quality asks for it and ``split_boundary`` allows it; where lines meet at an angle
    below the bound, that angle stays.

    ::

        +---------------+
        |    outline    |
        |    +-----+    |      meshed between outline and hole, and in the island
        |    |hole |    |
        |    | /\\  |    |
        |    | \\/ island|
        |    +-----+    |
        +---------------+

    Parameters
    ----------
    boundary : Mesh
        "line" cells in the plane z = 0 or any other; lines may touch, overlap and repeat. "vertex" cells become points
        of the mesh. ``field_data`` "holes" and "regions" are used where the arguments are not given.
    background : Mesh, optional
        Triangles or quads in the plane, with the sizes at their points; see `meshcore.sizing.background_field`.
    seeds : Mesh, optional
        Points in holes. If it has point arrays "tag" or "max_area", its points mark regions with that tag and that
        largest area; those whose point array "hole" is not zero mark holes all the same.
    min_angle : float
        Smallest angle, in degrees. With 0 this is the constrained Delaunay triangulation, refined for size only.
    size : Length, optional
        No edge is longer.
    max_area : float, optional
        No triangle is larger; the square of the boundary's unit.
    size_array : str
        Point array of sizes: of the background, where an empty name takes the only array there is; without a background
        of the boundary, whose sizes are carried inwards, linear on the triangles between its own points.
    gradation : float, optional
        Sizes of the background, the boundary or the field grow no faster per unit length: 0.2 means triangles that are
        at most 1.2 times as large as their neighbours. With none of these given, the lengths of the boundary's lines
        are the sizes. A field is sampled at the boundary's points, at 128 places along the longer side, and about as
        densely as triangles will be small; where it is small in a spot between samples only, sizes jump there.
    placement : {"automatic", "off-centre", "circumcentre", "lattice", "front"}
        Where the point goes that removes a triangle: at its off-centre, near enough to the shortest edge to make a
        triangle with just the angle asked for, which takes fewer points; or at its circumcentre, the worst triangle
        first, as the survey has it: the one with the largest circle for what is wanted there. "lattice" first divides
        the lines evenly and fills the inside with equilateral triangles as large as ``size`` and ``max_area`` allow: a
        third less triangles, in less than half the time; for angles up to 31 degrees. "automatic" does that where
        limits and domain let it, and else takes off-centres.
        "front" divides the lines by the sizes along them and lets a front advance from there, which makes nearly
        equilateral triangles for sizes that vary too, a little smaller than limits allow; or, without limits, as large
        as the lines are long. Off-centres mend what is left.
    smoothing : int
        Rounds of guarded smoothing at the end, see `smoothed`: points inside move where that makes the smallest angle
        around them larger. Limits are then enforced once more.
    split_boundary : bool
        Whether lines may get points. If not, the boundary is kept as it is, bit by bit; triangles that its lines keep
        from being as asked are counted in a warning.
    crossings : {"refuse", "split"}
        Lines that cross are an error, or are split where they cross.
    lines : bool
        Whether the mesh has "line" cells too: the pieces of the lines, in the order and direction of the input, with
        ``cell_data["line"]``, the number of the input's cell, and ``cell_data["tag"]``, its tag.
    size_field : callable, optional
        Takes (m, 3) points, returns (m,) lengths: no edge is longer than the value at its triangle's centroid. See
        `meshcore.sizing.size_field.graded`.
    holes : (k, 2) float, optional
        A point in each hole; then all else within the outermost lines is meshed.
    regions : (k, 2), (k, 3) or (k, 4) float, optional
        A point in each region, its tag, and its largest area (not above 0: no limit). A loop with a region is meshed.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Result
        Counter-clockwise triangles; the boundary's points come first, unchanged. ``cell_data["region"]`` is the tag of
        the region, or without ``regions`` counts the parts from 1. `Report.counts` tells how many points were added.
        If not all triangles could be made as asked, ``converged`` is False and a warning says how many.

    Raises
    ------
    InvalidGeometry
        If the outline is open, lines cross, the boundary is not planar, or a seed lies on a line.
    InvalidInput
        If a lattice is asked for without a limit, with a size field, an angle above 31 degrees or lines that may not
        be split; if limits would make more than 50 million triangles, or sizes are missing or not positive and finite.

    References
    ----------
    Survey, sections 3.2.3 and 3.2.4. J. Ruppert, J. Algorithms 18 (1995); J. R. Shewchuk, Comput. Geom. 22 (2002);
    A. Uengoer, Comput. Geom. 42 (2009). S. Rebay, J. Comput. Phys. 106 (1993): the front.

    Examples
    --------
    >>> from meshcore.gallery import square_with_hole
    >>> mesh, report = delaunay_refinement(square_with_hole(), min_angle=30)
    >>> report.quality["smallest angle (degree)"] >= 30
    True
    """
    if not isinstance(boundary, Mesh):
        raise InvalidInput(f"needs a Mesh of line cells, got {type(boundary).__name__}", parameter="boundary")
    progress = forwards(progress)  # rounds of a size field and of crossings begin anew
    if max_area == 0:
        raise InvalidInput("must be greater than zero, got 0; leave it out for no limit", parameter="max_area")
    segments = boundary.get("line")
    used = used_points(boundary)
    corners = boundary.points.take(used, axis=0)
    plane = fitted_plane(corners, parameter="boundary")
    graph = planar_graph(plane.to_plane(boundary.points), segments, used, "boundary")
    graph.line += first_line(boundary)
    marks = collected_seeds(boundary, holes, regions, plane, seeds)
    mesh = constrained(
        graph, split_crossings=crossings == "split", parameter="boundary", progress=part_of(progress, 0.0, 0.2)
    )
    parts = domain(mesh, marks, np.inf if max_area is None else max_area)
    sizes = sizing(
        boundary, background, size_array, gradation, size_field, plane, mesh, parts, part_of(progress, 0.2, 1.0)
    )
    length = np.inf if size is None else absolute(size, float(np.linalg.norm(np.ptp(corners, axis=0))))
    lattice = None
    why_not = _no_lattice(min_angle, sizes is not None, split_boundary)
    if placement == "lattice" and why_not:
        raise InvalidInput(f"a lattice {why_not}; choose automatic", parameter="placement")
    if placement == "lattice" or (placement == "automatic" and not why_not):
        lattice = filled(mesh, parts, length, part_of(progress, 0.2, 0.5), worthwhile=placement == "automatic")
    if lattice is not None:
        mesh, parts = lattice.mesh, lattice.parts
    try:
        front = None
        if placement == "front":
            front = Front(
                mesh,
                parts,
                marks,
                np.inf if max_area is None else max_area,
                size=length,
                size_field=sizes,
                split_boundary=split_boundary,
                progress=part_of(progress, 0.2, 0.7),
            )
            mesh, parts = front.mesh, front.parts
        refiner = Refiner(
            mesh,
            parts,
            min_angle=min_angle,
            size=length,
            placement=placement,
            split_boundary=split_boundary,
            size_field=sizes,
            progress=part_of(progress, {"front": 0.7}.get(placement, 0.2) if lattice is None else 0.5, 0.9),
            is_filled=lattice is not None,
        )
        if front is not None:
            front.advance(refiner)
        refinement = refiner.run(smoothing)
    except InvalidInput as error:
        explained = error if sizes is None else sizes.explained(error)
        if explained is error:
            raise
        raise explained from error
    if lattice is not None:
        refinement.splits += lattice.on_lines
        refinement.insertions += lattice.inside
    advance(progress, 0.9, "writing the mesh")
    on_lines = refiner.on_lines() if lines else None
    return assembled(boundary, plane, mesh, parts, refinement, min_angle, split_boundary, on_lines)


def _no_lattice(min_angle: float, has_sizes: bool, split_boundary: bool) -> str:
    """Why a lattice is out of the question; empty if it is not."""
    if min_angle > STEEPEST:
        return f"is for angles up to {STEEPEST:g} degrees, got min_angle = {min_angle:g}"
    if has_sizes:
        return "has one size, but sizes vary"
    return "" if split_boundary else "divides lines, but split_boundary is off"
