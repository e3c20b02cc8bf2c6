"""Unstructured meshes: Delaunay triangulation and refinement."""

from .constrained_delaunay import constrained_delaunay
from .delaunay import delaunay_2d
from .refinement import delaunay_refinement

__all__ = ["constrained_delaunay", "delaunay_2d", "delaunay_refinement"]
