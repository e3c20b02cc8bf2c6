"""Delaunay triangulation of points in the plane, as an operation."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from ..geometry import predicates
from ..mesh import Mesh
from ..operation import Port, operation
from ..progress import Progress, silent
from ..report import Report, Result
from .triangulation import canonical_cells, planar_points, triangulated

_MERGED_TO_NAME = 5


@operation("Delaunay 2D", category="Unstructured")
def delaunay_2d(
    points: Annotated[Mesh, Port("Points in the plane z = 0")],
    *,
    threads: int | None = None,
    progress: Progress = silent,
) -> Result:
    """Triangulate points in the plane so that no point lies inside the circle of a triangle.

    Signs are exact, so grids, collinear and cocircular points are no special cases. Where four or more points lie on
    one circle, the one of lowest number decides the diagonals: the result is unique, the same on every platform and
    for any number of threads.

    Parameters
    ----------
    points : Mesh, or (n, 2) or (n, 3) float
        z must be zero; cells are not looked at. Of points at one place the first is used; the others stay in the mesh,
        without triangles.
    threads : int, optional
        How many to use; without it as many as pay, up to the cores there are.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Result
        Counter-clockwise "triangle" cells on the points as given; they cover the convex hull. Their order, along a
        Hilbert curve, depends on the points only. The report warns of points that were merged.

    Raises
    ------
    InvalidInput
        If points are not in the plane z = 0, are too many, or too far apart in magnitude for exact arithmetic, or if
        ``threads`` is no positive number.
    InvalidGeometry
        If points are not finite, all lie on one line, or there are fewer than three.

    References
    ----------
    Survey, section 3.2.4. A. Bowyer, "Computing Dirichlet tessellations", Computer Journal 24 (1981).

    Examples
    --------
    >>> mesh, report = delaunay_2d([[0, 0], [1, 0], [0, 1], [1, 1], [0.5, 0.5]])
    >>> mesh
    Mesh(5 points, 4 triangle)
    """
    cloud = planar_points(points)
    triangulation = triangulated(predicates.rescaled(cloud)[0], progress, threads=threads)
    origin, slots, order = triangulation.origin, triangulation.n_triangles, triangulation.order
    merged, kept = triangulation.merged, triangulation.kept
    del triangulation  # frees coordinates and twins, before the cells ask for memory
    nothing = np.empty(0, np.int32)
    cells = canonical_cells(origin, slots, order, nothing, nothing)
    counts = {"points": len(cloud), "triangles": len(cells), "duplicates": len(merged)}
    report = Report(counts=counts, warnings=_merged_warning(merged, kept))
    return Result(Mesh.unchecked(cloud, {"triangle": cells}), report)


def _merged_warning(merged: np.ndarray, kept: np.ndarray) -> list[str]:
    """What was merged into what, in one sentence; nothing if nothing was."""
    if not len(merged):
        return []
    pairs = zip(merged[:_MERGED_TO_NAME], kept[:_MERGED_TO_NAME], strict=True)
    named = ", ".join(f"{a} at {b}" for a, b in pairs)
    more = ", ..." if len(merged) > _MERGED_TO_NAME else ""
    return [f"{len(merged):,} points lie where another does and have no triangles: {named}{more}"]
