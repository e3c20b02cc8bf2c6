"""meshcore: structured, unstructured and adaptive mesh generation."""

__version__ = "0.1.0"

from . import adapt, io, quality
from .adapt import refined
from .errors import Cancelled, GenerationFailed, InvalidGeometry, InvalidInput, MeshcoreError, MissingLibrary
from .geometry.location import locate
from .mesh import (
    Cut,
    Degenerate,
    Mesh,
    MultiBlock,
    Patch,
    PolyhedralMesh,
    StructuredGrid,
    degenerate,
    patches,
    with_named_sides,
)
from .operation import Length, Relative, operations
from .progress import Progress, silent
from .report import Report, Result
from .sizing import Spacing, discretised
from .structured import (
    Attractor,
    Wall,
    c_grid,
    elliptic,
    elliptic_volume,
    elliptically_smoothed,
    h_grid,
    hyperbolic,
    hyperbolic_volume,
    o_grid,
    parabolic,
    transfinite,
    transfinite_volume,
    with_halo,
)
from .unstructured import (
    Tetrahedralization,
    Triangulation,
    constrained_delaunay,
    delaunay_2d,
    delaunay_3d,
    delaunay_refinement,
    smoothed,
    voronoi_2d,
    voronoi_3d,
)

__all__ = [
    "Attractor",
    "Cancelled",
    "Cut",
    "Degenerate",
    "GenerationFailed",
    "InvalidGeometry",
    "InvalidInput",
    "Length",
    "Mesh",
    "MeshcoreError",
    "MissingLibrary",
    "MultiBlock",
    "Patch",
    "PolyhedralMesh",
    "Progress",
    "Relative",
    "Report",
    "Result",
    "Spacing",
    "StructuredGrid",
    "Tetrahedralization",
    "Triangulation",
    "Wall",
    "adapt",
    "c_grid",
    "constrained_delaunay",
    "degenerate",
    "delaunay_2d",
    "delaunay_3d",
    "delaunay_refinement",
    "discretised",
    "elliptic",
    "elliptic_volume",
    "elliptically_smoothed",
    "h_grid",
    "hyperbolic",
    "hyperbolic_volume",
    "io",
    "locate",
    "o_grid",
    "operations",
    "parabolic",
    "patches",
    "quality",
    "refined",
    "silent",
    "smoothed",
    "transfinite",
    "transfinite_volume",
    "voronoi_2d",
    "voronoi_3d",
    "with_halo",
    "with_named_sides",
]
