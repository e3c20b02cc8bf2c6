"""What quality is asked of: a mesh, or a structured grid as the mesh of its cells."""

from __future__ import annotations

from typing import Any

from ..errors import InvalidInput
from ..mesh import Mesh, MultiBlock, StructuredGrid


def as_mesh(given: Any) -> Mesh:
    """The mesh itself, or a grid's cells.

    Raises
    ------
    InvalidInput
        If it is neither, as None or a `MultiBlock`.

    Examples
    --------
    >>> from meshcore import gallery
    >>> as_mesh(gallery.triangulated_square(1))
    Mesh(4 points, 2 triangle)
    """
    if isinstance(given, StructuredGrid):
        return given.to_mesh()
    if not isinstance(given, Mesh):
        several = "; give one of its blocks" if isinstance(given, MultiBlock) else ""
        raise InvalidInput(f"needs a Mesh or StructuredGrid, got {type(given).__name__}{several}", parameter="mesh")
    return given
