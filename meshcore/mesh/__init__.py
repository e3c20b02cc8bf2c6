"""Data only: Mesh, PolyhedralMesh, StructuredGrid, MultiBlock, and the topology derived from them."""

from .cells import BY_VTK, CELL_TYPES, CellType
from .cuts import Cut
from .degenerate import Degenerate, degenerate
from .mesh import Mesh
from .multi_block import MultiBlock
from .named_sides import with_named_sides
from .patches import Patch, patches
from .polyhedral_mesh import PolyhedralMesh
from .structured_grid import StructuredGrid
from .topology import Facets

__all__ = [
    "BY_VTK",
    "CELL_TYPES",
    "CellType",
    "Cut",
    "Degenerate",
    "Facets",
    "Mesh",
    "MultiBlock",
    "Patch",
    "PolyhedralMesh",
    "StructuredGrid",
    "degenerate",
    "patches",
    "with_named_sides",
]
