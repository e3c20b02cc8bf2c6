"""Summaries and reports of a mesh's quality."""

from __future__ import annotations

import numpy as np

from ..mesh import CELL_TYPES, Mesh, StructuredGrid
from .measures import measure


def summary(mesh: Mesh | StructuredGrid) -> dict[str, float]:
    """What a generator's report says of quality, by the largest dimension of the cells.

    Parameters
    ----------
    mesh : Mesh or StructuredGrid
        Cells of lower dimension are left out.

    Returns
    -------
    dict of str to float
        In the plane and on surfaces: smallest and largest angle, mean radius ratio (1 is best), worst scaled
        Jacobian (1 is best, negative is inverted). In space: smallest dihedral angle of tetrahedra, mean shape and
        worst scaled Jacobian. Empty without such cells.

    Examples
    --------
    >>> from meshcore import gallery
    >>> {name: round(value, 3) for name, value in summary(gallery.triangulated_square(2)).items()}
    {'smallest angle (degree)': 45.0, 'largest angle (degree)': 90.0, 'mean radius ratio': 1.207, \
'worst scaled jacobian': 0.816}
    """
    if isinstance(mesh, StructuredGrid):
        mesh = mesh.to_mesh()
    if mesh.dimension < 2:
        return {}
    planar = (
        ("smallest angle (degree)", "min_angle", np.min),
        ("largest angle (degree)", "max_angle", np.max),
        ("mean radius ratio", "radius_ratio", np.mean),
        ("worst scaled jacobian", "scaled_jacobian", np.min),
    )
    solid = (
        ("smallest dihedral angle (degree)", "min_angle", np.min),
        ("mean shape", "shape", np.mean),
        ("worst scaled jacobian", "scaled_jacobian", np.min),
    )
    highest = {kind: cells for kind, cells in mesh.cells.items() if CELL_TYPES[kind].dimension == mesh.dimension}
    top = Mesh(mesh.points, highest)
    values = {label: (measure(top, name), reduce) for label, name, reduce in (planar if mesh.dimension == 2 else solid)}
    found = {label: (v[~np.isnan(v)], reduce) for label, (v, reduce) in values.items()}
    return {label: float(reduce(v)) for label, (v, reduce) in found.items() if len(v)}
