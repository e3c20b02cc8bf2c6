"""Voronoi diagrams of points in the plane and in space, clipped to a box or to a convex boundary."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from ..errors import InvalidInput
from ..mesh import Mesh, PolyhedralMesh, polygons
from ..operation import Length, Param, Port, Relative, operation
from ..progress import Progress, advance, part_of, silent
from ..report import Report, Result
from . import voronoi_cells
from .clipping import clipped
from .convex_domain import ConvexDomain, domain_of
from .delaunay import delaunay_2d
from .delaunay_3d import delaunay_3d

SAFE_EXPONENT = 200
"""Coordinates beyond two to this power, or all below its inverse, are scaled by a power of two."""


@operation("Voronoi Cells 2D", category="Unstructured", output="polyhedra")
def voronoi_2d(
    points: Annotated[Mesh, Port("Sites: points in the plane z = 0; their cells do not matter")],
    boundary: Annotated[
        Mesh | None, Port("Convex closed loop of lines that the cells fill; without it a box", cells=("line",))
    ] = None,
    *,
    margin: Annotated[Length, Param("Distance of the box from the points' bounding box", min=0)] = Relative(0.1),
    box: Annotated[
        tuple[float, float, float, float],
        Param("Lower and upper corner of the box (x y x y); all zero takes the margin", advanced=True),
    ] = (0.0, 0.0, 0.0, 0.0),
    progress: Progress = silent,
) -> Result:
    """Divide the plane among points: each cell is what is nearer to its site than to any other.

    The cells are convex polygons, the dual of the Delaunay triangulation, clipped to a box or a convex boundary, which
    they fill without gap or overlap: neighbours share their corners, and areas add up. Grids, circles and points on a
    line are no special cases; where several corners coincide, because sites lie on one circle, they are one point.

    ::

        +-----+-------+
        |  o  |   o   |      o  sites
        +--.--+-.-----+      .  circumcentres of Delaunay triangles
        |   o  \\|  o   |
        +-------+------+

    Parameters
    ----------
    points : Mesh or (n, 2) or (n, 3) float
        Sites, in any unit. Of sites at one place the first has the cell; sites outside the domain have none.
    boundary : Mesh, optional
        Lines of one convex closed loop in the plane z = 0.
    margin : Length
        Without a boundary, how far the box reaches beyond the points' bounding box, as a length or a share of its
        diagonal.
    box : tuple of four float
        Without a boundary, the box itself: x and y of its lower, then of its upper corner. All zero: as `margin` says.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Result
        `PolyhedralMesh` of counter-clockwise polygons in the order of their sites, ``cell_data["site"]`` the row of
        each in ``points``. Counts: points, cells, duplicates (sites at the place of an earlier one), outside,
        lost (sites on the domain's edge up to rounding, which leaves their cells nothing).

    Raises
    ------
    InvalidInput
        If there is no site within the domain, the box has no extent, or coordinates are not finite or not planar.
    InvalidGeometry
        If the boundary is not closed or not convex.

    References
    ----------
    Survey, section 3.2.4, figure 23. G. Voronoi, "Nouvelles applications des parametres continus a la theorie des
    formes quadratiques", J. reine angew. Math. 134 (1908). F. Aurenhammer, "Voronoi diagrams", ACM Computing Surveys
    23 (1991).

    Examples
    --------
    >>> mesh, report = voronoi_2d([[0, 0], [1, 0], [0, 1], [1, 1]], box=(-1, -1, 2, 2))
    >>> mesh
    PolyhedralMesh(9 points, 4 polygons)
    >>> mesh.volumes.tolist()
    [2.25, 2.25, 2.25, 2.25]
    """
    return _diagram(points, boundary, margin, box, 2, progress)


@operation("Voronoi Cells 3D", category="Unstructured", output="polyhedra")
def voronoi_3d(
    points: Annotated[Mesh, Port("Sites: points in space; their cells do not matter")],
    boundary: Annotated[
        Mesh | None,
        Port("Convex closed surface that the cells fill; without it a box", cells=("triangle", "quad")),
    ] = None,
    *,
    margin: Annotated[Length, Param("Distance of the box from the points' bounding box", min=0)] = Relative(0.1),
    box: Annotated[
        tuple[float, float, float, float, float, float],
        Param("Lower and upper corner of the box (x y z x y z); all zero takes the margin", advanced=True),
    ] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    progress: Progress = silent,
) -> Result:
    """Divide space among points: each cell is what is nearer to its site than to any other.

    The cells are convex polyhedra, the dual of the Delaunay triangulation, clipped to a box or a convex boundary, which
    they fill without gap or overlap: two neighbours share one face, and volumes add up. Lattices, spheres, points in a
    plane or on a line are no special cases.

    Parameters
    ----------
    points : Mesh or (n, 3) float
        Sites, in any unit. Of sites at one place the first has the cell; sites outside the domain have none.
    boundary : Mesh, optional
        Triangles and quads of one convex closed surface, such as a box, a dome or a crystal.
    margin : Length
        Without a boundary, how far the box reaches beyond the points' bounding box, as a length or a share of its
        diagonal.
    box : tuple of six float
        Without a boundary, the box itself: x, y and z of its lower, then of its upper corner. All zero: as `margin`
        says.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Result
        `PolyhedralMesh` of polyhedra in the order of their sites, ``cell_data["site"]`` the row of each in
        ``points``. Counts: points, faces, cells, duplicates (sites at the place of an earlier one), outside,
        lost (sites on the domain's edge up to rounding, which leaves their cells nothing).

    Raises
    ------
    InvalidInput
        If there is no site within the domain, the box has no extent, or coordinates are not finite.
    InvalidGeometry
        If the boundary is not closed or not convex.

    References
    ----------
    Survey, section 3.2.4. F. Aurenhammer, "Voronoi diagrams", ACM Computing Surveys 23 (1991).

    Examples
    --------
    >>> mesh, report = voronoi_3d([[0, 0, 0], [2, 0, 0]], box=(-1, -1, -1, 3, 1, 1))
    >>> mesh
    PolyhedralMesh(12 points, 11 faces, 2 polyhedra)
    >>> mesh.volumes.round(12).tolist(), mesh.neighbours.tolist()
    ([8.0, 8.0], [[0, 1]])
    """
    return _diagram(points, boundary, margin, box, 3, progress)


def _diagram(
    points: Any, boundary: Mesh | None, margin: Length, box: tuple[float, ...], dimension: int, progress: Progress
) -> Result:
    """Both operations: sites within the domain, their Delaunay triangulation with far points, its dual, clipped."""
    cloud = points if isinstance(points, Mesh) else Mesh(points, {})
    if dimension == 2 and not cloud.is_planar:
        high = float(np.abs(cloud.points[:, 2]).max())
        raise InvalidInput(f"needs points in the plane z = 0, but z reaches {high:g}", parameter="points")
    if not cloud.n_points:
        raise InvalidInput("needs at least one point, got none", parameter="points")
    exponent = _exponent(cloud, boundary, box if any(box) or isinstance(margin, Relative) else (margin,))
    xyz = np.ldexp(cloud.points[:, :dimension], -exponent)
    domain = domain_of(xyz, boundary, margin, box, exponent)
    rows = np.flatnonzero(domain.first_beyond(xyz) == domain.n_planes)
    if not len(rows):
        raise InvalidInput(f"none of the {len(xyz)} points is within the domain; enlarge it", parameter="points")
    make = _planar if dimension == 2 else _spatial
    mesh, has_cell, duplicates = make(np.ascontiguousarray(xyz[rows]), domain, progress)
    mesh = mesh.with_points(np.ldexp(mesh.points, exponent)).with_cell_data(site=rows[has_cell])
    advance(progress, 1.0, "done")
    return Result(mesh, _report(mesh, len(xyz), len(rows), duplicates))


def _exponent(cloud: Mesh, boundary: Any, lengths: tuple[float, ...]) -> int:
    """The power of two that coordinates are divided by, so that their squares are safe; zero for all but extremes."""
    most = max([float(np.abs(cloud.points).max()), *map(abs, lengths)])
    if isinstance(boundary, Mesh) and boundary.n_points:
        most = max(most, float(np.abs(boundary.points).max()))
    exponent = int(np.frexp(most)[1])
    return 0 if abs(exponent) <= SAFE_EXPONENT else exponent


def _report(mesh: PolyhedralMesh, given: int, within: int, duplicates: int) -> Report:
    counts = {"points": mesh.n_points}
    if mesh.dimension == 3:
        counts["faces"] = mesh.n_faces
    lost = within - duplicates - mesh.n_cells
    counts |= {"cells": mesh.n_cells, "duplicates": duplicates, "outside": given - within, "lost": lost}
    report = Report(counts=counts)
    if counts["duplicates"]:
        report.warnings.append(f"{counts['duplicates']} sites are at the place of an earlier one and have no cell")
    if lost:
        report.warnings.append(
            f"{lost} sites are on the domain's edge up to rounding, which leaves their cells nothing"
        )
    if counts["outside"]:
        report.warnings.append(f"{counts['outside']} points are outside the domain and have no cell")
    return report


def _planar(sites: np.ndarray, domain: ConvexDomain, progress: Progress) -> tuple[PolyhedralMesh, np.ndarray, int]:
    """The diagram in the plane, which sites have a cell, and how many are at the place of an earlier one."""
    vertices = np.concatenate([sites, voronoi_cells.far_points(domain)])
    triangulation, report = delaunay_2d(vertices, progress=part_of(progress, 0.0, 0.6))
    advance(progress, 0.6, "joining circumcentres")
    cells = voronoi_cells.planar_cells(vertices, triangulation.get("triangle"), len(sites), domain.tolerance)
    cells = clipped(cells, domain, part_of(progress, 0.8, 1.0))
    number, nodes = polygons.numbered(cells.nodes, len(cells.points))
    return PolyhedralMesh(cells.points[number], cells.offsets, nodes), cells.owner, report.counts["duplicates"]


def _spatial(sites: np.ndarray, domain: ConvexDomain, progress: Progress) -> tuple[PolyhedralMesh, np.ndarray, int]:
    """The diagram in space, which sites have a cell, and how many are at the place of an earlier one."""
    vertices = np.concatenate([sites, voronoi_cells.far_points(domain)])
    triangulation, report = delaunay_3d(vertices, progress=part_of(progress, 0.0, 0.5))
    advance(progress, 0.5, "joining circumcentres")
    faces = voronoi_cells.spatial_cells(vertices, triangulation.get("tetra"), len(sites), domain.tolerance)
    faces = clipped(faces, domain, part_of(progress, 0.8, 1.0))
    has_cell = np.unique(np.concatenate([faces.owner, faces.neighbour[faces.neighbour >= 0]]))
    cell = np.full(len(sites) + 1, -1)
    cell[has_cell] = np.arange(len(has_cell))
    number, nodes = polygons.numbered(faces.nodes, len(faces.points))
    mesh = PolyhedralMesh(faces.points[number], faces.offsets, nodes, cell[faces.owner], cell[faces.neighbour])
    return mesh, has_cell, report.counts["duplicates"]
