"""Delaunay triangulation of points in space."""

from __future__ import annotations

from typing import Annotated

from ..mesh import Mesh
from ..operation import Port, operation
from ..progress import Progress, silent
from ..report import Report, Result
from .tetrahedralization import Tetrahedralization


@operation("Delaunay 3D", category="Unstructured")
def delaunay_3d(
    points: Annotated[Mesh, Port("Points in space; cells are not looked at")],
    *,
    threads: int | None = None,
    progress: Progress = silent,
) -> Result:
    """Fill the convex hull of points in space with tetrahedra, none of whose spheres has a point inside.

    Signs are exact, so grids, points on a sphere and repeated points are no special cases. Where more than four points
    lie on an empty sphere, their numbers decide: the result is unique and does not depend on threads or platform.

    Parameters
    ----------
    points : Mesh or (n, 3) float
        At least four that do not lie in one plane. Of points at one place the first is used; the others, without
        tetrahedra, stay in the mesh.
    threads : int, optional
        How many threads share the work; all available cores if not given and there are many points.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Result
        "tetra" cells on the points as given.

    Raises
    ------
    InvalidInput
        If the points have a wrong shape, or coordinates too far apart in magnitude (more than about 1e109).
    InvalidGeometry
        If a coordinate is not finite, or all points lie in one plane.

    References
    ----------
    Survey, section 3.2.4. A. Bowyer, "Computing Dirichlet tessellations", Computer Journal 24 (1981). D. F. Watson,
    "Computing the n-dimensional Delaunay tessellation", ibid. C. Marot, J. Pellerin, J.-F. Remacle, "One machine, one
    minute, three billion tetrahedra", Int. J. Numer. Methods Eng. 117 (2019).

    Examples
    --------
    >>> mesh, report = delaunay_3d([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]])
    >>> mesh
    Mesh(5 points, 2 tetra)
    >>> report.counts
    {'points': 5, 'tetrahedra': 2, 'duplicates': 0}
    """
    triangulation = Tetrahedralization.from_points(points, threads=threads, progress=progress)
    merged, kept = triangulation.merged, triangulation.kept
    mesh = triangulation._into_mesh()
    report = Report(counts={"points": mesh.n_points, "tetrahedra": mesh.n_cells, "duplicates": len(merged)})
    if len(merged):
        shown = ", ".join(f"{a} on {b}" for a, b in zip(merged[:5].tolist(), kept[:5].tolist(), strict=True))
        rest = ", ..." if len(merged) > 5 else ""
        report.warnings.append(f"{len(merged)} points at the place of others got no tetrahedra: {shown}{rest}")
    return Result(mesh, report)
