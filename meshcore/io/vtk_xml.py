"""VTK's XML files (.vtu .vtp .vts .vtm), read and written without VTK.

VTK's own readers end the process on some damaged files, which a host must not suffer, and they are not there in
Blender. All encodings are read: text, base64, appended raw and base64, with zlib or lzma, 32 and 64 bit headers, both
byte orders, several pieces. Binary files are written as base64 with zlib, every bit kept.

References
----------
"The VTK User's Guide", Kitware; https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
"""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ..errors import InvalidInput
from ..mesh import Mesh, MultiBlock, StructuredGrid, polygons
from .fit import ALL_CELLS, SURFACE_CELLS, Holds
from .polyhedra import POLYHEDRON, face_streams
from .ragged import POLY_LINE, POLY_VERTEX, POLYGON, TRIANGLE_STRIP
from .registry import AnyMesh, register
from .vtk_data import GRID, MESH, DataSet, decoded, together, with_cuts
from .vtk_xml_arrays import XmlFile, whole_attribute
from .vtk_xml_writer import POLY_GROUPS, write_vtm, write_vtp, write_vts, write_vtu

_GROUP_TYPES = (POLY_VERTEX, POLY_LINE, POLYGON, TRIANGLE_STRIP)


def _data(file: XmlFile, parent: ElementTree.Element, tag: str, count: int | None) -> dict[str, np.ndarray]:
    found = {}
    section = parent.find(tag)
    for k, element in enumerate(section if section is not None else ()):
        if element.tag not in ("DataArray", "Array"):
            continue
        values = file.array(element)
        name = element.get("Name") or f"array {k}"
        if count is not None and len(values) != count:
            raise InvalidInput(f"the array {name!r} of {tag} has {len(values)} values, {count} were expected")
        found[name] = values
    return found


def _required(file: XmlFile, parent: ElementTree.Element, *tags: str) -> np.ndarray:
    """The array at a path of tags; the last may be ``DataArray`` or the Name of one."""
    section = parent.find(tags[0])
    if section is not None:
        for element in section.iter("DataArray"):
            if len(tags) == 1 or element.get("Name") == tags[1]:
                return file.array(element)
    raise InvalidInput(f"<{parent.tag}> has no {' '.join(tags)}")


def _points(file: XmlFile, piece: ElementTree.Element, count: int) -> np.ndarray:
    if count == 0 and piece.find("Points") is None:
        return np.empty((0, 3))
    points = _required(file, piece, "Points")
    if points.size == 0:
        points = np.empty((0, 3))
    if points.ndim != 2 or points.shape[1] != 3 or len(points) != count:
        raise InvalidInput(f"{count} points are promised, but there are {points.shape}")
    return points.astype(float)


def _unstructured(file: XmlFile, piece: ElementTree.Element) -> DataSet:
    n_points, n_cells = whole_attribute(piece, "NumberOfPoints"), whole_attribute(piece, "NumberOfCells")
    data = DataSet(MESH, _points(file, piece, n_points))
    if n_cells:
        data.types = _required(file, piece, "Cells", "types")
        data.connectivity = _required(file, piece, "Cells", "connectivity").astype(np.int64)
        offsets = _required(file, piece, "Cells", "offsets").astype(np.int64)
        data.offsets = np.concatenate([[0], offsets])
    if len(data.types) != n_cells:
        raise InvalidInput(f"{n_cells} cells are promised, but there are {len(data.types)}")
    data.point_data = _data(file, piece, "PointData", n_points)
    data.cell_data = _data(file, piece, "CellData", n_cells)
    data.whole_polygons = True
    if (data.types == POLYHEDRON).any():
        _add_faces(file, piece, data)
    return data


def _add_faces(file: XmlFile, piece: ElementTree.Element, data: DataSet) -> None:
    """The faces of polyhedra, as streams, or since VTK 9.4 as rows."""

    def array(name: str) -> np.ndarray:
        return _required(file, piece, "Cells", name).astype(np.int64)

    names = {element.get("Name") for element in piece.find("Cells") or ()}
    ends = array("faceoffsets" if "faces" in names else "polyhedron_offsets")
    if len(ends) != len(data.types):
        raise InvalidInput(f"{len(data.types)} cells are promised, but there are offsets of faces for {len(ends)}")
    if "faces" in names:
        # Each polyhedron's stream begins where the one before it ends; other cells have -1.
        data.faces = array("faces")
        data.face_starts = np.where(ends < 0, -1, np.maximum.accumulate(np.concatenate([[0], ends[:-1]])))
        return
    rows, nodes, used = np.append(0, array("face_offsets")), array("face_connectivity"), array("polyhedron_to_faces")
    counts = np.diff(ends, prepend=0)
    rising = (np.diff(rows) >= 0).all() and (counts >= 0).all() and rows[-1] <= len(nodes) and ends[-1] <= len(used)
    if not rising or (len(used) and not 0 <= used.min() <= used.max() < len(rows) - 1):
        raise InvalidInput("the faces of its polyhedra do not fit their offsets")
    data.faces, data.face_starts = face_streams(*polygons.taken(rows, nodes, used), counts)


def _poly(file: XmlFile, piece: ElementTree.Element) -> DataSet:
    n_points = whole_attribute(piece, "NumberOfPoints")
    data = DataSet(MESH, _points(file, piece, n_points))
    types, connectivity, offsets = [], [], [np.zeros(1, np.int64)]
    for tag, vtk_type in zip(POLY_GROUPS, _GROUP_TYPES, strict=True):
        count = whole_attribute(piece, f"NumberOf{tag}", 0)
        if not count:
            continue
        ends = _required(file, piece, tag, "offsets").astype(np.int64)
        if len(ends) != count:
            raise InvalidInput(f"{count} {tag} are promised, but there are {len(ends)}")
        types.append(np.full(count, vtk_type))
        connectivity.append(_required(file, piece, tag, "connectivity").astype(np.int64)[: ends[-1]])
        offsets.append(offsets[-1][-1] + ends)
    data.types = np.concatenate([np.empty(0, np.int64), *types])
    data.connectivity = np.concatenate([np.empty(0, np.int64), *connectivity])
    data.offsets = np.concatenate(offsets)
    data.point_data = _data(file, piece, "PointData", n_points)
    data.cell_data = _data(file, piece, "CellData", len(data.types))
    return data


def _structured(file: XmlFile, piece: ElementTree.Element) -> DataSet:
    words = piece.get("Extent", "").split()
    try:
        extent = np.array([int(word) for word in words], np.int64).reshape(3, 2)
    except (ValueError, OverflowError):
        raise InvalidInput(f"the extent {' '.join(words)!r} is no six whole numbers") from None
    size = [int(high) - int(low) + 1 for low, high in extent]
    if min(size) < 1:
        raise InvalidInput(f"the extent {' '.join(words)!r} is empty")
    count = size[0] * size[1] * size[2]
    cells = int(np.prod([max(n - 1, 1) for n in size], dtype=object))
    data = DataSet(GRID, _points(file, piece, count), dimensions=(size[0], size[1], size[2]))
    data.point_data = _data(file, piece, "PointData", count)
    data.cell_data = _data(file, piece, "CellData", cells)
    return data


_PIECES = {"UnstructuredGrid": _unstructured, "PolyData": _poly, "StructuredGrid": _structured}


def read_vtk_xml(path: Path) -> AnyMesh:
    """A mesh or grid; several pieces of a mesh become one, of a grid blocks."""
    file = XmlFile(path)
    if file.kind == "vtkMultiBlockDataSet":
        return _read_blocks(path, file)
    if file.kind not in _PIECES:
        raise InvalidInput(f"it holds {file.kind or 'nothing named'}; {', '.join(_PIECES)} and blocks of them are read")
    body = file.root.find(file.kind)
    if body is None:
        raise InvalidInput(f"it has no <{file.kind}>")
    pieces = [_PIECES[file.kind](file, piece) for piece in body.findall("Piece")]
    if not pieces:
        raise InvalidInput(f"<{file.kind}> has no <Piece>")
    fields = _data(file, body, "FieldData", None)
    for piece in pieces:
        piece.field_data = fields
    if len(pieces) == 1:
        return decoded(pieces[0])
    return together({f"piece {k}": decoded(piece) for k, piece in enumerate(pieces)})


def _read_blocks(path: Path, file: XmlFile) -> AnyMesh:
    parts: dict[str, Mesh | StructuredGrid] = {}
    folder = path.parent.resolve()

    def follow(parent: ElementTree.Element, prefix: str) -> None:
        for k, element in enumerate(parent):
            name = prefix + (element.get("name") or f"block {element.get('index', k)}")
            if element.tag in ("Block", "Piece"):
                follow(element, name + "/")
            elif element.tag == "DataSet" and element.get("file"):
                target = (folder / element.get("file", "")).resolve()
                if not target.is_file():
                    raise InvalidInput(f"its block {name!r} is in {element.get('file')}, which is not there")
                if target == path.resolve() or target.suffix.lower() == ".vtm":
                    raise InvalidInput(f"its block {name!r} is a .vtm again")
                found = read_vtk_xml(target)
                blocks = {name: found}
                if isinstance(found, MultiBlock):
                    blocks = {f"{name}/{n}": block for n, block in zip(found.names, found.blocks, strict=True)}
                parts.update({n if n not in parts else f"{n} {len(parts)}": b for n, b in blocks.items()})

    body = file.root.find("vtkMultiBlockDataSet")
    follow(body if body is not None else file.root, "")
    if not parts:
        raise InvalidInput("it has no blocks")
    found = together(parts)
    return with_cuts(found, _data(file, file.root, "FieldData", None)) if isinstance(found, MultiBlock) else found


_EVERYTHING = {"point_data": True, "cell_data": True, "field_data": True, "sets": True}
register(
    "VTK unstructured",
    (".vtu",),
    "any mesh, of polygons and polyhedra too, with all its data",
    Holds(cells=ALL_CELLS, polygons=True, polyhedra=True, **_EVERYTHING),
    read=read_vtk_xml,
    write=write_vtu,
)
register(
    "VTK surface",
    (".vtp",),
    "points, curves and surfaces with all their data",
    Holds(cells=SURFACE_CELLS, polygons=True, **_EVERYTHING),
    read=read_vtk_xml,
    write=write_vtp,
)
register(
    "VTK structured",
    (".vts",),
    "one structured grid with all its data",
    Holds(blocks=1, **_EVERYTHING),
    read=read_vtk_xml,
    write=write_vts,
)
register(
    "VTK blocks",
    (".vtm",),
    "several structured grids; blocks of other kinds are read as one mesh",
    Holds(blocks=2, **_EVERYTHING),
    read=read_vtk_xml,
    write=write_vtm,
)
