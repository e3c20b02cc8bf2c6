"""Writing VTK's XML files (.vtu .vtp .vts .vtm), as text, or as base64 packed by zlib."""

from __future__ import annotations

import base64
import re
import sys
import zlib
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from ..errors import InvalidInput
from ..mesh import Mesh, MultiBlock, PolyhedralMesh, StructuredGrid
from .vtk_data import DataSet, encoded, encoded_cuts
from .vtk_xml_arrays import TYPE_NAMES

POLY_GROUPS = ("Verts", "Lines", "Polys", "Strips")
_BLOCK = 1 << 20


def _element(name: str, values: np.ndarray, binary: bool) -> str:
    """One DataArray."""
    head = f"Name={quoteattr(name)}"
    if values.dtype.kind == "U":
        content = b"".join(text.encode() + b"\0" for text in values.ravel().tolist())
        head = f'<Array type="String" {head} NumberOfTuples="{values.size}"'
        body, end = np.frombuffer(content, np.int8), "Array"
    else:
        columns = values.shape[1] if values.ndim > 1 else 1
        kind = TYPE_NAMES[values.dtype.str[1:]]
        head = f'<DataArray type="{kind}" {head} NumberOfComponents="{columns}" NumberOfTuples="{len(values)}"'
        body, end = values, "DataArray"
    if binary:
        return f'{head} format="binary">{_packed(body)}</{end}>\n'
    flat = body.ravel()
    # Numbers of both precisions are written as the shortest text that reads back as the same.
    words = [repr(v) if isinstance(v, float) else str(v) for v in flat.tolist()] if flat.dtype != np.float32 else [
        str(v) for v in flat
    ]  # fmt: skip
    return f'{head} format="ascii">{" ".join(words)}</{end}>\n'


def _packed(values: np.ndarray) -> str:
    content = np.ascontiguousarray(values).tobytes()
    blocks = [content[k : k + _BLOCK] for k in range(0, len(content), _BLOCK)]
    packed = [zlib.compress(block, 6) for block in blocks]
    last = len(content) % _BLOCK
    header = np.array([len(blocks), _BLOCK, last, *map(len, packed)], np.uint64).tobytes()
    return (base64.b64encode(header) + base64.b64encode(b"".join(packed))).decode()


def _section(tag: str, arrays: dict[str, np.ndarray], binary: bool) -> str:
    return f"<{tag}>\n{''.join(_element(name, v, binary) for name, v in arrays.items())}</{tag}>\n"


def _document(kind: str, body: str) -> str:
    order = "LittleEndian" if sys.byteorder == "little" else "BigEndian"
    return (
        f'<?xml version="1.0" encoding="utf-8"?>\n<VTKFile type="{kind}" version="1.0" byte_order="{order}" '
        f'header_type="UInt64" compressor="vtkZLibDataCompressor">\n{body}</VTKFile>\n'
    )


def _piece(kind: str, attributes: str, data: DataSet, body: str, binary: bool, whole: str = "") -> str:
    """A file of one piece: fields of the whole, data, points, and the cells in ``body``."""
    fields = _section("FieldData", data.field_data, binary) if data.field_data else ""
    return _document(
        kind,
        f"<{kind}{whole}>\n{fields}<Piece {attributes}>\n"
        + _section("PointData", data.point_data, binary)
        + _section("CellData", data.cell_data, binary)
        + _section("Points", {"Points": data.points}, binary)
        + f"{body}</Piece>\n</{kind}>\n",
    )


def _save(path: Path, text: str) -> None:
    # Names may hold characters that no XML can: say so before anything is written.
    if re.search("[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]", text):
        raise InvalidInput("has a name with control characters, which XML cannot hold", parameter="mesh")
    path.write_text(text, encoding="utf-8", newline="\n")


def write_vtu(path: Path, mesh: Mesh | PolyhedralMesh, *, binary: bool = True) -> None:
    """Any mesh."""
    data = encoded(mesh)
    cells = {"connectivity": data.connectivity, "offsets": data.offsets[1:], "types": data.types}
    if len(data.faces):
        cells["faces"] = data.faces
        cells["faceoffsets"] = np.append(data.face_starts[1:], len(data.faces))
    attributes = f'NumberOfPoints="{len(data.points)}" NumberOfCells="{len(data.types)}"'
    _save(path, _piece("UnstructuredGrid", attributes, data, _section("Cells", cells, binary), binary))


def write_vtp(path: Path, mesh: Mesh | PolyhedralMesh, *, binary: bool = True) -> None:
    """Vertices, lines, triangles and quads; VTK stores them in this order, so a mesh in another is sorted."""
    if isinstance(mesh, PolyhedralMesh):
        polys = {"connectivity": mesh.face_nodes, "offsets": mesh.face_offsets[1:]}
        attributes = f'NumberOfPoints="{mesh.n_points}" NumberOfPolys="{mesh.n_cells}"'
        _save(path, _piece("PolyData", attributes, encoded(mesh), _section("Polys", polys, binary), binary))
        return
    rank = {"vertex": 0, "line": 1, "triangle": 2, "quad": 2}
    groups = {"vertex": "Verts", "line": "Lines", "triangle": "Polys", "quad": "Polys"}
    kinds = sorted(mesh.cells, key=lambda kind: rank[kind])
    spans = {kind: np.arange(where.start, where.stop) for kind, _, where in mesh.blocks()}
    order = np.concatenate([np.empty(0, np.int64), *(spans[kind] for kind in kinds)])
    data = encoded(mesh)
    data.cell_data = {name: values[order] for name, values in data.cell_data.items()}
    body, attributes = "", f'NumberOfPoints="{mesh.n_points}"'
    for tag in POLY_GROUPS:
        rows = [mesh.cells[kind] for kind in kinds if groups[kind] == tag]
        sizes = np.concatenate([np.empty(0, np.int64), *(np.full(len(c), c.shape[1]) for c in rows)])
        connectivity = np.concatenate([np.empty(0, np.int64), *(c.ravel() for c in rows)])
        body += _section(tag, {"connectivity": connectivity, "offsets": np.cumsum(sizes)}, binary)
        attributes += f' NumberOf{tag}="{len(sizes)}"'
    _save(path, _piece("PolyData", attributes, data, body, binary))


def write_vts(path: Path, grid: StructuredGrid, *, binary: bool = True) -> None:
    """One structured grid."""
    extent = " ".join(f"0 {n - 1}" for n in grid.shape)
    data = encoded(grid)
    _save(path, _piece("StructuredGrid", f'Extent="{extent}"', data, "", binary, f' WholeExtent="{extent}"'))


def write_vtm(path: Path, grid: StructuredGrid | MultiBlock, *, binary: bool = True) -> None:
    """An index with the cuts between blocks, and each block as a .vts file in a folder of the index's name."""
    blocks = grid if isinstance(grid, MultiBlock) else MultiBlock((grid,))
    folder = path.with_suffix("")
    folder.mkdir()
    lines = []
    for k, (name, block) in enumerate(zip(blocks.names, blocks.blocks, strict=True)):
        write_vts(folder / f"{folder.name}_{k}.vts", block, binary=binary)
        file = f"{folder.name}/{folder.name}_{k}.vts"
        lines.append(f'<DataSet index="{k}" name={quoteattr(name)} file={quoteattr(file)}/>\n')
    body = f"<vtkMultiBlockDataSet>\n{''.join(lines)}</vtkMultiBlockDataSet>\n"
    if cuts := encoded_cuts(blocks.cuts):
        body += _section("FieldData", cuts, binary)  # beside the blocks, since among them VTK takes it for a fault
    _save(path, _document("vtkMultiBlockDataSet", body))
