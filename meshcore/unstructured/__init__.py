"""Unstructured meshes: Delaunay triangulation and refinement, Voronoi diagrams."""

from .constrained_delaunay import constrained_delaunay
from .delaunay import delaunay_2d
from .delaunay_3d import delaunay_3d
from .refinement import delaunay_refinement
from .smoothing import smoothed
from .tetrahedralization import Tetrahedralization
from .triangulation import Triangulation
from .voronoi import voronoi_2d, voronoi_3d

__all__ = [
    "Tetrahedralization",
    "Triangulation",
    "constrained_delaunay",
    "delaunay_2d",
    "delaunay_3d",
    "delaunay_refinement",
    "smoothed",
    "voronoi_2d",
    "voronoi_3d",
]
