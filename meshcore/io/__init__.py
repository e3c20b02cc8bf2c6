"""Reading and writing, one module per format."""

from . import airfoil, cgns, gmsh, medit, obj, off, plot3d, ply, stl, su2, triangle, vtk_legacy, vtk_xml  # noqa: F401 (register)
from .fit import FormatWarning
from .pyvista_bridge import from_pyvista, to_pyvista
from .registry import Format, FormatRow, formats, read, write

__all__ = ["Format", "FormatRow", "FormatWarning", "formats", "from_pyvista", "read", "to_pyvista", "write"]
