"""Unstructured meshes: Delaunay triangulation and refinement."""

from .constrained_delaunay import constrained_delaunay
from .delaunay import delaunay_2d
from .delaunay_3d import delaunay_3d
from .refinement import delaunay_refinement
from .tetrahedralization import Tetrahedralization
from .triangulation import Triangulation

__all__ = [
    "Tetrahedralization",
    "Triangulation",
    "constrained_delaunay",
    "delaunay_2d",
    "delaunay_3d",
    "delaunay_refinement",
]
