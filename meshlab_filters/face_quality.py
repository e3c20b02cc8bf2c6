"""Filters that measure the current layer: quality into its face scalars, and selection of bad faces."""

from __future__ import annotations

import contextlib
import itertools

import numpy as np
import pymeshlab

from meshcore import InvalidInput, quality
from meshcore.quality.measures import lookup

from . import conversion
from .filters import check_mesh_set, meshlab_errors


def _values(ms: pymeshlab.MeshSet, measure: str) -> tuple[np.ndarray, np.ndarray]:
    """The measure of each polygon of the current layer, spread over its faces, and whether it is out of range."""
    check_mesh_set(ms)
    layer = conversion.layer_of(ms, None)
    mesh = conversion.to_mesh(layer)
    if mesh.dimension < 2:
        raise InvalidInput(f"the layer {layer.label()!r} has no faces to measure", parameter="ms")
    values = quality.measure(mesh, measure)
    bad = np.zeros(mesh.n_cells, bool)
    for kind, _, where in mesh.blocks():
        known = lookup(kind, measure)
        if known:
            low, high = known.acceptable
            bad[where] = (values[where] < low - 1e-9) | (values[where] > high + 1e-9)
    cell = _cell_of_faces(layer, mesh)
    return values[cell], bad[cell]


def _cell_of_faces(layer: pymeshlab.Mesh, mesh) -> np.ndarray:
    """(number of faces,) int: the cell of ``mesh`` that each triangle of the layer belongs to."""
    triangles = layer.face_matrix()
    if list(mesh.cells) == ["triangle"]:
        return np.arange(len(triangles))
    corners = {}
    for kind, cells, where in mesh.blocks():
        for offset, cell in enumerate(cells.tolist()):
            for k in range(len(cell) if kind == "quad" else 1):
                three = frozenset(cell) if kind == "triangle" else frozenset(cell) - {cell[k]}
                corners[three] = where.start + offset
    return np.array([corners[frozenset(t)] for t in triangles.tolist()])


def compute_quality_per_face(ms: pymeshlab.MeshSet, *, measure: str = "scaled_jacobian") -> dict[str, float]:
    """Compute a quality measure of the current layer into its face scalars.

    Parameters
    ----------
    ms : pymeshlab.MeshSet
        Its current layer is measured; faces of one polygon get the polygon's value.
    measure : str
        One of ``meshcore.quality.measures()``. Faces of a kind without it get 0, infinite values 1e30; MeshLab keeps
        what its own filters compute in single precision.

    Returns
    -------
    dict
        Minimum, mean and maximum, and how many faces are outside the acceptable range.

    Raises
    ------
    pymeshlab.PyMeshLabException
        If there is no such measure, or the layer has no faces.
    """
    with meshlab_errors("compute_quality_per_face"):
        values, bad = _values(ms, measure)
    shown = np.nan_to_num(values, nan=0.0, posinf=1e30, neginf=-1e30)
    ms.compute_scalar_by_function_per_face(q=_attached(ms, measure, shown))
    known = values[~np.isnan(values)]
    numbers = (known.min(), known.mean(), known.max()) if len(known) else (np.nan,) * 3
    return {**dict(zip(("min", "mean", "max"), map(float, numbers), strict=True)), "outside": int(bad.sum())}


def select_faces_by_quality(
    ms: pymeshlab.MeshSet,
    *,
    measure: str = "scaled_jacobian",
    minimum: float | None = None,
    maximum: float | None = None,
) -> dict[str, int]:
    """Select the faces of the current layer whose quality is bad.

    Parameters
    ----------
    ms : pymeshlab.MeshSet
        Its current layer is measured.
    measure : str
        One of ``meshcore.quality.measures()``.
    minimum, maximum : float, optional
        Faces below or above are selected; without either, those outside the measure's acceptable range.

    Returns
    -------
    dict
        How many faces are selected.

    Raises
    ------
    pymeshlab.PyMeshLabException
        If there is no such measure, or the layer has no faces.
    """
    with meshlab_errors("select_faces_by_quality"):
        values, bad = _values(ms, measure)
        for name, limit in (("minimum", minimum), ("maximum", maximum)):
            if limit is not None and not isinstance(limit, (int, float)):
                raise InvalidInput(f"needs a number, got {limit!r}", parameter=name)
    if minimum is not None or maximum is not None:
        low, high = (-np.inf if minimum is None else minimum), (np.inf if maximum is None else maximum)
        bad = (values < low) | (values > high)
    name = _attached(ms, f"bad_{measure}", bad.astype(float))
    ms.compute_selection_by_condition_per_face(condselect=f"{name} > 0.5")
    return {"selected": int(ms.current_mesh().selected_face_number())}


def _attached(ms: pymeshlab.MeshSet, name: str, values: np.ndarray) -> str:
    """Attach values to the current layer's faces and return the attribute's name.

    MeshLab's own filters, which alone can set face scalars and selection, read attributes by name. An attribute can
    neither be changed nor removed, so the name gets a number if it is taken.
    """
    for number in itertools.count(1):
        free = name if number == 1 else f"{name}_{number}"
        with contextlib.suppress(pymeshlab.PyMeshLabException):
            ms.current_mesh().add_face_custom_scalar_attribute(values, free)
            return free


FILTERS = {f.__name__: f for f in (compute_quality_per_face, select_faces_by_quality)}
"""The filters of this file, by name."""
