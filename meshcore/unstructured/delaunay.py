"""Delaunay triangulation of points in the plane."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import InvalidInput
from ..geometry import predicates
from ..mesh import Mesh
from ..progress import Progress, silent
from .triangulation import triangulated


def delaunay_2d(points: Any, *, progress: Progress = silent) -> Mesh:
    """Triangulate points in the plane so that no point lies inside the circle of a triangle.

    Signs are exact, so grids, collinear and cocircular points are no special cases.

    Parameters
    ----------
    points : (n, 2) or (n, 3) float, or Mesh
        z must be zero. Of points at one place the first is used; the others, without triangles, stay in the mesh.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Mesh
        Counter-clockwise "triangle" cells on the points as given; they cover the convex hull.

    Raises
    ------
    InvalidInput
        If points are not in the plane z = 0.
    InvalidGeometry
        If all points lie on one line, or there are fewer than three.

    References
    ----------
    Survey, section 3.2.4. A. Bowyer, "Computing Dirichlet tessellations", Computer Journal 24 (1981).

    Examples
    --------
    >>> delaunay_2d([[0, 0], [1, 0], [0, 1], [1, 1], [0.5, 0.5]])
    Mesh(5 points, 4 triangle)
    """
    cloud = points if isinstance(points, Mesh) else Mesh(points, {})
    if not cloud.is_planar:
        high = float(np.abs(cloud.points[:, 2]).max())
        raise InvalidInput(f"needs points in the plane z = 0, but z reaches {high:g}", parameter="points")
    # Complex numbers sort by x, then by y.
    _, first = np.unique((cloud.points[:, :2] + 0.0).view(np.complex128).ravel(), return_index=True)
    different = cloud.points[first, :2]
    scaled, _ = predicates.rescaled(different)
    triangulation = triangulated(scaled, progress)
    corners, _ = triangulation.live()
    return Mesh(cloud.points, {"triangle": first[triangulation.order[corners]]})
