"""Unstructured meshes: Delaunay triangulation and refinement."""
