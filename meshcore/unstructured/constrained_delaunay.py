"""Constrained and conforming Delaunay triangulation of any planar straight-line graph."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np

from ..errors import InvalidInput
from ..geometry.plane import Plane, fitted_plane
from ..mesh import Mesh
from ..operation import Param, Port, operation
from ..progress import Progress, advance, forwards, part_of, silent
from ..report import Result
from .assembly import assembled
from .boundary_lines import edges_on_lines, first_line, used_points
from .conforming import conform
from .constrained import ConstrainedTriangulation, constrained
from .domain import Domain, collected_seeds, domain
from .planar_graph import planar_graph
from .refiner import Refinement
from .soundness import check


@operation("Constrained Delaunay", category="Unstructured")
def constrained_delaunay(
    boundary: Annotated[Mesh, Port("Lines in a plane, which become edges of the mesh", cells=("line",))],
    seeds: Annotated[
        Mesh | None,
        Port('Points in holes; or in regions, by point arrays "tag", "max_area" and, not zero in holes, "hole"'),
    ] = None,
    *,
    conforming: Annotated[
        bool, Param("Put points on lines until every triangle is Delaunay; without, no point is added")
    ] = False,
    keep: Annotated[
        Literal["inside", "hull"], Param("Mesh what closed loops enclose, or the whole convex hull of the lines")
    ] = "inside",
    crossings: Annotated[
        Literal["refuse", "split"], Param("What to do where lines cross: refuse, or split both")
    ] = "refuse",
    lines: Annotated[
        bool, Param("Give the pieces of the lines too, as line cells with their tags and numbers")
    ] = False,
    holes: Any = None,
    regions: Any = None,
    progress: Progress = silent,
) -> Result:
    """Triangulate a planar straight-line graph with all of its lines as edges.

    No point that can be seen past the lines from a triangle lies inside its circle; of all triangulations with these
    edges, this one has the largest smallest angle.

    ::

        +-----------------+        +-----------------+
        |   ____________  |        |\\ _/__________ / |
        |         |       |   ->   | \\/ \\  | /  _/ / |
        |         |       |        | / __\\ |/_/   /  |
        +-----------------+        +-----------------+

    Parameters
    ----------
    boundary : Mesh
        "line" cells in the plane z = 0 or any other; they may touch, overlap, repeat, end anywhere, and enclose one
        another. "vertex" cells become points of the mesh. Points that no cell uses are left out. ``field_data``
        "holes" and "regions" are used where the arguments are not given.
    seeds : Mesh, optional
        Points in holes. If it has point arrays "tag" or "max_area", its points mark regions with that tag (areas are
        for refinement); those whose point array "hole" is not zero mark holes all the same.
    conforming : bool
        Split lines until no point at all lies inside the circle of a triangle: the mesh is then a part of the Delaunay
        triangulation of its points. Splitting ends at any angle between lines, with few points.
    keep : {"inside", "hull"}
        "inside" meshes what closed loops enclose by the even-odd rule: outline, hole, island; a loop that shares lines
        with another is a second part beside it. "hull" meshes all of the convex hull, but for holes that are given.
    crossings : {"refuse", "split"}
        Lines that cross are an error, or get a point where they cross.
    lines : bool
        Whether the mesh has "line" cells too: the pieces of the lines, in the order and direction of the input.
    holes : (k, 2) or (k, 3) float, optional
        A point in each hole; then all else within the outermost lines is meshed.
    regions : (k, 2), (k, 3) or (k, 4) float, optional
        A point in each region and its tag; by default the parts are counted from 1. A loop with a region is meshed.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Result
        Counter-clockwise triangles; the boundary's points come first, unchanged. ``cell_data["region"]`` is the tag of
        the region; 0 in the hull outside all loops. With ``lines``, ``cell_data["line"]`` is the number of the input's
        cell under each piece and -1 for triangles, ``cell_data["tag"]`` the tag of that cell and 0 for triangles.

    Raises
    ------
    InvalidGeometry
        If lines cross, nothing is enclosed, all points lie on one line, the boundary is not planar, or a hole or region
        lies on a line; `points` and `cells` tell where.
    InvalidInput
        If coordinates are too large or too small, or holes and regions are not rows of numbers.

    References
    ----------
    Survey, section 3.2.4. D. T. Lee, A. K. Lin, "Generalized Delaunay triangulation for planar graphs", Discrete
    Comput. Geom. 1 (1986). L. P. Chew, "Constrained Delaunay triangulations", Algorithmica 4 (1989).

    Examples
    --------
    >>> from meshcore.gallery import joined, square
    >>> wall = Mesh([[0.2, 0.4], [0.7, 0.6]], {"line": [[0, 1]]})
    >>> mesh, report = constrained_delaunay(joined(square(), wall), lines=True)
    >>> mesh
    Mesh(6 points, 6 triangle, 5 line)
    """
    if not isinstance(boundary, Mesh):
        raise InvalidInput(f"needs a Mesh of line cells, got {type(boundary).__name__}", parameter="boundary")
    progress = forwards(progress)  # rounds of crossings begin anew
    segments = boundary.get("line")
    used = used_points(boundary)
    plane = fitted_plane(boundary.points.take(used, axis=0), parameter="boundary")
    graph = planar_graph(plane.to_plane(boundary.points), segments, used, "boundary", may_lack_lines=keep == "hull")
    graph.line += first_line(boundary)
    marks = collected_seeds(boundary, holes, regions, plane, seeds)
    triangulation = constrained(
        graph, split_crossings=crossings == "split", parameter="boundary", progress=part_of(progress, 0.0, 0.7)
    )
    parts = domain(triangulation, marks, np.inf, keep_hull=keep == "hull")
    left, added = conform(triangulation, part_of(progress, 0.7, 0.8)) if conforming else (0, 0)
    advance(progress, 0.8, "checking the mesh")
    mesh, report = _result(boundary, plane, triangulation, parts, lines, added)
    if left:
        report.converged = False
        report.warnings.append(f"{left:,} pieces of lines are not Delaunay edges: lines are too near each other")
    return Result(mesh, report)


def _result(
    boundary: Mesh, plane: Plane, triangulation: ConstrainedTriangulation, parts: Domain, lines: bool, added: int
) -> Result:
    """The mesh of the faces that are kept, checked, and its report."""
    half_edges = triangulation.triangulation
    corners, slots = half_edges.live()
    check(triangulation, len(half_edges.xy) // 2, parts.keep)
    face = triangulation.face[slots]
    corners, slots, face = (array[parts.keep[face]] for array in (corners, slots, face))
    xy = np.ldexp(half_edges.xy.reshape(-1, 2), -triangulation.exponent)
    as_it_is = Refinement(corners, parts.tag[face], xy, splits=added, insertions=0, poor=0, exhausted=False)
    on_lines = None
    if lines:
        on_lines = edges_on_lines(half_edges.origin, half_edges.twin, triangulation.piece_of, slots)
    result = assembled(boundary, plane, triangulation, parts, as_it_is, 0.0, True, on_lines)
    del result.report.counts["points added inside"]
    result.report.counts["points added at crossings"] = int((triangulation.graph.source < 0).sum())
    return result
