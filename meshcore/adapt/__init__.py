"""Adaptivity: error estimates and refinement of existing meshes (survey 4.1)."""

from .estimate import gradient_jump, marked, variation
from .refinement import refined

__all__ = ["gradient_jump", "marked", "refined", "variation"]
