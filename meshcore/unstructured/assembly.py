"""The mesh and the report of a refinement: used points numbered, the input's first."""

from __future__ import annotations

import numpy as np

from .. import quality
from ..geometry.plane import Plane
from ..mesh import Mesh
from ..quality.report import triangles_below
from ..report import Report, Result
from . import _assembly_kernels as kernels
from .boundary_lines import along_lines, with_lines
from .constrained import ConstrainedTriangulation
from .domain import Domain
from .refiner import Refinement


def assembled(
    boundary: Mesh,
    plane: Plane,
    triangulation: ConstrainedTriangulation,
    parts: Domain,
    refinement: Refinement,
    min_angle: float,
    split_boundary: bool,
    on_lines: tuple[np.ndarray, np.ndarray] | None = None,
) -> Result:
    """The mesh and its report.

    Parameters
    ----------
    boundary : Mesh
        The input, whose own points are handed out again bit by bit.
    plane : Plane
        Where it lies.
    triangulation : ConstrainedTriangulation
        What was refined.
    parts : Domain
        What of it is meshed.
    refinement : Refinement
        How that went.
    min_angle, split_boundary
        What was asked for.
    on_lines : (p, 2) int and (p,) int, optional
        Vertices of the edges on lines, and the piece of each; the mesh gets them as "line" cells.
    """
    number, kept, added = _numbered(triangulation, refinement)
    points = np.concatenate([boundary.points.take(kept, axis=0), plane.to_space(added)])
    triangles = np.empty(refinement.corners.shape, np.int64)
    kernels.renumber(refinement.corners, number, triangles)
    mesh = Mesh.unchecked(points, {"triangle": triangles}, {"region": refinement.tags})
    report = Report(
        counts={
            "points": mesh.n_points,
            "triangles": mesh.n_cells,
            "points added on lines": refinement.splits,
            "points added inside": refinement.insertions,
        },
        quality=quality.summary(mesh),
        converged=not (refinement.exhausted or refinement.poor),
        warnings=[*triangulation.graph.warnings, *parts.warnings],
    )
    _warn(report, mesh, refinement, min_angle, split_boundary)
    if on_lines is not None:
        ends, piece = on_lines
        ends, line = along_lines(triangulation.graph, refinement.xy, ends, triangulation.pieces[piece, 2])
        mesh = with_lines(mesh, boundary, number[ends], line)
    return Result(mesh, report)


def _numbered(triangulation: ConstrainedTriangulation, refinement: Refinement):
    """Number in the mesh of each vertex; the input points that are used, in order; (k, 2) places of those added."""
    order, source = triangulation.triangulation.order, triangulation.graph.source
    number, vertex_at = np.empty(len(refinement.xy), np.int32), np.empty(len(source), np.int32)
    kept = np.empty(len(source), np.int64)
    n_kept, n_added = kernels.number_corners(refinement.corners, order, source, vertex_at, number, kept)
    added = np.empty((n_added, 2))
    kernels.number_rest(np.ascontiguousarray(refinement.xy), n_kept, number, added)
    return number, kept[:n_kept], added


def _stopped(refinement: Refinement, min_angle: float) -> str:
    """What to say of a refinement that spent its budget of points."""
    return (
        f"refinement was stopped after {refinement.splits + refinement.insertions:,} points, since it may never "
        f"end; ask for less than min_angle = {min_angle:g}"
    )


def _warn(report: Report, mesh: Mesh, refinement: Refinement, min_angle: float, split_boundary: bool) -> None:
    """Say in the report what the user should know."""
    if refinement.exhausted:
        report.warnings.append(_stopped(refinement, min_angle))
    if refinement.poor:
        why = ", where coordinates cannot resolve smaller ones"
        if not split_boundary:
            why = " at lines that may not be split; give these more points, or allow split_boundary"
        report.warnings.append(
            f"{refinement.poor:,} triangles are not as asked" + ("" if refinement.exhausted else why)
        )
    if report.quality["smallest angle (degree)"] >= min_angle - 1e-6:
        return
    thin = triangles_below(mesh, min_angle - 1e-6) - refinement.poor
    if thin > 0:
        report.warnings.append(f"{thin:,} triangles at small angles of the input stay below min_angle")
