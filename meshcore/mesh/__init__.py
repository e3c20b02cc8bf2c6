"""Data only: Mesh, PolyhedralMesh, StructuredGrid, MultiBlock, and the topology derived from them."""

from .cells import BY_VTK, CELL_TYPES, CellType
from .mesh import Mesh
from .multi_block import MultiBlock
from .polyhedral_mesh import PolyhedralMesh
from .structured_grid import StructuredGrid
from .topology import Facets

__all__ = ["BY_VTK", "CELL_TYPES", "CellType", "Facets", "Mesh", "MultiBlock", "PolyhedralMesh", "StructuredGrid"]
