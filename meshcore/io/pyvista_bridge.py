"""Meshes to pyvista's data sets and back: for pictures, for filters, for anyone who plots."""

from __future__ import annotations

import html
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InvalidInput, MissingLibrary
from ..mesh import Mesh, MultiBlock, PolyhedralMesh, StructuredGrid
from .polyhedra import POLYHEDRON
from .ragged import LINE, POLY_LINE, POLY_VERTEX, POLYGON, TRIANGLE_STRIP
from .vtk_data import GRID, MESH, DataSet, decoded, encoded, together
from .vtk_xml import read_vtk_xml

if TYPE_CHECKING:
    import pyvista


def _pyvista(purpose: str) -> Any:
    try:
        import pyvista
    except ImportError:
        raise MissingLibrary("pyvista", purpose) from None
    return pyvista


def to_pyvista(mesh: Mesh | PolyhedralMesh | StructuredGrid | MultiBlock) -> pyvista.DataSet | pyvista.MultiBlock:
    """A mesh as pyvista's UnstructuredGrid, StructuredGrid or MultiBlock, with all its data.

    Sets become cell arrays "set:NAME" of 0 and 1. Empty arrays of the whole mesh are left out, since pyvista
    cannot hold them; tensors become rows of nine.

    Parameters
    ----------
    mesh : Mesh, PolyhedralMesh, StructuredGrid or MultiBlock
        Left as it is; nothing is shared.

    Raises
    ------
    InvalidInput
        If ``mesh`` is something else, or holds data that VTK does not know.
    MissingLibrary
        Without pyvista.

    Examples
    --------
    >>> square = Mesh([[0, 0], [1, 0], [1, 1], [0, 1]], {"quad": [[0, 1, 2, 3]]})
    >>> to_pyvista(square).n_cells
    1
    """
    pyvista = _pyvista("to_pyvista")
    if isinstance(mesh, MultiBlock):
        return pyvista.MultiBlock({name: to_pyvista(b) for name, b in zip(mesh.names, mesh.blocks, strict=True)})
    if not isinstance(mesh, (Mesh, PolyhedralMesh, StructuredGrid)):
        raise InvalidInput(
            f"needs a Mesh, StructuredGrid or MultiBlock, got {type(mesh).__name__}"
            + ("; pass result.mesh" if hasattr(mesh, "report") else ""),
            parameter="mesh",
        )
    data = encoded(mesh)
    if data.kind == GRID:
        target = pyvista.StructuredGrid()
        target.points = data.points.copy()
        target.dimensions = data.dimensions
    else:
        listed, offsets = data.connectivity, data.offsets
        if len(data.faces):  # polyhedra are listed by their streams of faces
            listed, offsets = data.faces, np.append(data.face_starts, len(data.faces))
        legacy = np.insert(listed, offsets[:-1], np.diff(offsets))
        target = pyvista.UnstructuredGrid(legacy, data.types, data.points.copy())
    for into, arrays in (
        (target.point_data, data.point_data),
        (target.cell_data, data.cell_data),
        (target.field_data, {k: v for k, v in data.field_data.items() if v.size}),
    ):
        for name, values in arrays.items():
            into[name] = _ascii(values) if values.dtype.kind == "U" else values.copy()
    return target


def _ascii(values: np.ndarray) -> np.ndarray:
    """Text with characters beyond ASCII, which pyvista refuses, as ``&#228;``."""
    return np.array([text.encode("ascii", "xmlcharrefreplace").decode() for text in values.ravel()]).reshape(
        values.shape
    )


def from_pyvista(data: Any) -> Mesh | PolyhedralMesh | StructuredGrid | MultiBlock:
    """A pyvista data set as a Mesh, PolyhedralMesh, StructuredGrid or MultiBlock.

    PolyData and UnstructuredGrid become a `Mesh`; StructuredGrid, RectilinearGrid and ImageData a `StructuredGrid`
    (a single row of points becomes line cells). A MultiBlock of structured grids becomes a `MultiBlock`, any other
    one `Mesh` with a set for each block. An UnstructuredGrid of polyhedra, or of polygons alone, becomes a
    `PolyhedralMesh`; elsewhere polygons with more than four corners are cut into triangles.

    Raises
    ------
    InvalidInput
        If it is something else, or has cells that a `Mesh` does not hold.
    MissingLibrary
        Without pyvista.

    Examples
    --------
    >>> import pyvista
    >>> from_pyvista(pyvista.Plane(i_resolution=2, j_resolution=1))
    Mesh(6 points, 2 quad)
    """
    pyvista = _pyvista("from_pyvista")
    if isinstance(data, pyvista.MultiBlock):
        return together(_named_parts(data))
    if isinstance(data, (pyvista.ImageData, pyvista.RectilinearGrid)):
        data = data.cast_to_structured_grid()
    if isinstance(data, pyvista.StructuredGrid):
        layout = DataSet(GRID, _array(data.points), dimensions=tuple(data.dimensions))
    elif isinstance(data, pyvista.UnstructuredGrid) and (data.celltypes == POLYHEDRON).any():
        return _through_a_file(data)
    elif isinstance(data, pyvista.UnstructuredGrid):
        layout = DataSet(MESH, _array(data.points))
        # pyvista 0.48 renamed `offset`.
        offsets = data.cell_offsets if hasattr(data, "cell_offsets") else data.offset
        layout.types, layout.offsets = _array(data.celltypes), _array(offsets)
        layout.connectivity = _array(data.cell_connectivity)
        layout.whole_polygons = True
    elif isinstance(data, pyvista.PolyData):
        layout = _poly_data(data)
    else:
        raise InvalidInput(f"needs a pyvista data set, got {type(data).__name__}", parameter="data")
    layout.point_data = {name: _array(data.point_data[name]) for name in data.point_data.keys()}  # noqa: SIM118
    layout.cell_data = {name: _array(data.cell_data[name]) for name in data.cell_data.keys()}  # noqa: SIM118
    layout.field_data = {name: _array(data.field_data[name]) for name in data.field_data.keys()}  # noqa: SIM118
    return decoded(layout)


def _through_a_file(data: pyvista.UnstructuredGrid) -> PolyhedralMesh:
    """Polyhedra, whose faces VTK hands out in a way that changes with its version, by a file of the grid."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "polyhedra.vtu"
        data.save(path)
        return read_vtk_xml(path)


def _array(values: Any) -> np.ndarray:
    """A plain copy, so that nothing keeps VTK's memory alive."""
    values = np.array(values)
    if values.dtype.kind == "U" and any("&#" in text for text in values.ravel()):
        values = np.array([html.unescape(text) for text in values.ravel()]).reshape(values.shape)
    return values


def _named_parts(blocks: pyvista.MultiBlock, prefix: str = "") -> dict[str, Any]:
    parts: dict[str, Any] = {}
    for k, block in enumerate(blocks):
        if block is None:
            continue
        name = prefix + (blocks.get_block_name(k) or f"block {k}")
        if hasattr(block, "get_block_name"):
            parts.update(_named_parts(block, name + "/"))
        else:
            parts[name if name not in parts else f"{name} {k}"] = from_pyvista(block)
    return parts


def _poly_data(data: pyvista.PolyData) -> DataSet:
    """Vertices, lines, polygons and strips, the order in which VTK counts the cells of PolyData."""
    layout = DataSet(MESH, _array(data.points))
    types, corners, sizes = [], [], []
    groups = ((POLY_VERTEX, data.verts), (POLY_LINE, data.lines), (POLYGON, data.faces), (TRIANGLE_STRIP, data.strips))
    for vtk_type, padded in groups:
        padded = _array(padded).tolist()
        at = 0
        while at < len(padded):
            size = padded[at]
            corners += padded[at + 1 : at + 1 + size]
            sizes.append(size)
            types.append(LINE if vtk_type == POLY_LINE and size == 2 else vtk_type)
            at += size + 1
    layout.types = np.array(types, np.int64)
    layout.connectivity = np.array(corners, np.int64)
    layout.offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    return layout
