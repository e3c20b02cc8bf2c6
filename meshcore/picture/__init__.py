"""Pictures of meshes and of their quality, drawn off-screen by pyvista, with or without a display."""

from .of_mesh import picture
from .of_quality import histogram

__all__ = ["histogram", "picture"]
