"""Mesh generators as filters on a pymeshlab MeshSet.

    import pymeshlab, meshlab_filters
    ms = pymeshlab.MeshSet()
    ms.load_new_mesh("outline.ply")
    result = meshlab_filters.delaunay_refinement(ms, min_angle=30, size=pymeshlab.PercentageValue(5))
    meshlab_filters.write(result, "mesh.vtu")

There is a function for each operation of meshcore; the current layer is its input, and a new layer its result.
`install` binds them as methods of MeshSet. Not on the command line of MeshLab itself, which has no Python:
``python -m meshlab_filters IN OUT --filter NAME`` stands in for it.
"""

from .binding import (
    ALL,
    filter_list,
    install,
    parameter_list,
    print_filter_list,
    print_filter_parameter_list,
    uninstall,
)
from .conversion import to_boundary, to_mesh
from .files import apply_script, load, save, write
from .filters import FilterResult

globals().update(ALL)

__all__ = [
    "FilterResult",
    "apply_script",
    "filter_list",
    "install",
    "load",
    "parameter_list",
    "print_filter_list",
    "print_filter_parameter_list",
    "save",
    "to_boundary",
    "to_mesh",
    "uninstall",
    "write",
]
__all__ += list(ALL)
