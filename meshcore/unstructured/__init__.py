"""Unstructured meshes: Delaunay triangulation and refinement."""

from .delaunay import delaunay_2d
from .refinement import delaunay_refinement

__all__ = ["delaunay_2d", "delaunay_refinement"]
