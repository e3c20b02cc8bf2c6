"""Adaptivity: error estimates and refinement of existing meshes."""
