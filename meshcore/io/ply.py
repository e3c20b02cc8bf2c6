"""Polygon File Format (.ply), text and binary: surfaces and edges, with one-number data on points and cells.

References
----------
G. Turk, "The PLY polygon file format", Stanford University (1994).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import quote, unquote

import numpy as np

from ..errors import InvalidInput
from ..mesh import Mesh, PolyhedralMesh
from .content import whole
from .fit import Holds, columns_of, warn_dropped
from .lines import Lines, rows_of
from .polyhedra import corner_tables
from .ragged import LINE, POLYGON, cells_by_kind
from .registry import register

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8",
}  # fmt: skip
_NAMES = {"i1": "char", "u1": "uchar", "i2": "short", "u2": "ushort", "i4": "int", "u4": "uint", "f4": "float",
          "f8": "double"}  # fmt: skip
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_CORNERS = ("vertex_indices", "vertex_index")


@dataclass
class _Property:
    name: str
    type: str
    count_type: str = ""  # of lists


@dataclass
class _Element:
    name: str
    count: int
    properties: list[_Property] = field(default_factory=list)


@dataclass
class _Table:
    """One element's values: plain properties as columns, each list as sizes and values one after the other."""

    columns: dict[str, np.ndarray] = field(default_factory=dict)
    lists: dict[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)


def read_ply(path: Path) -> Mesh:
    """Points, faces and edges."""
    data = path.read_bytes()
    order, elements, body = _header(data)
    tables = _text_tables(data[body:], elements) if not order else _binary_tables(data, body, order, elements)
    vertex = tables.get("vertex")
    if vertex is None or not {"x", "y", "z"} <= set(vertex.columns):
        raise InvalidInput("it has no points with x, y and z")
    points = np.column_stack([vertex.columns.pop(axis).astype(float) for axis in "xyz"])
    return _mesh(points, vertex.columns, tables)


def _header(data: bytes) -> tuple[str, list[_Element], int]:
    """Byte order ("" for text), elements, and where the values begin."""
    if not data.startswith(b"ply"):
        raise InvalidInput("it does not begin with 'ply'")
    end = data.find(b"end_header")
    body = data.find(b"\n", end) + 1
    if end < 0 or not body:
        raise InvalidInput("the header has no end ('end_header')")
    order, elements = None, []
    for k, line in enumerate(data[:end].decode("latin-1").replace("\r", "").split("\n"), 1):
        words = line.split()
        if not words or words[0] in ("ply", "comment", "obj_info"):
            continue
        if words[0] == "format" and len(words) > 1 and words[1] in _ORDERS:
            order = _ORDERS[words[1]]
        elif words[0] == "element" and len(words) == 3:
            elements.append(_Element(words[1], whole(words[2], k, "a count")))
        elif words[0] == "property" and elements and len(words) in (3, 5) and _known(words):
            name, kind = unquote(words[-1]), _TYPES[words[-2]]
            elements[-1].properties.append(_Property(name, kind, _TYPES[words[2]] if len(words) == 5 else ""))
        else:
            raise InvalidInput(f"line {k}: {line.strip()[:60]!r} is no line of a PLY header")
    if order is None:
        raise InvalidInput("the header does not tell the format")
    if min((e.count for e in elements), default=0) < 0:
        raise InvalidInput("the header has a negative count")
    return order, elements, body


def _known(words: list[str]) -> bool:
    types = words[1:-1] if len(words) == 3 else words[2:-1]
    plain = len(words) == 3 or (words[1] == "list" and _TYPES.get(words[2], "f")[0] in "iu")
    return plain and all(t in _TYPES for t in types)


def _short(element: _Element, held: int) -> InvalidInput:
    return InvalidInput(f"{element.count} of {element.name} are promised, but the file ends after {held}")


def _text_tables(body: bytes, elements: list[_Element]) -> dict[str, _Table]:
    if b"\0" in body:
        raise InvalidInput("its values are binary, and the header says text")
    lines = Lines.of("\n".join(body.decode("latin-1").splitlines()), comment="\0")
    tables, at = {}, 0
    for element in elements:
        held = lines[at : at + element.count]
        if len(held) < element.count:
            raise _short(element, len(held))
        at += element.count
        tables[element.name] = _text_table(element, held)
    return tables


def _text_table(element: _Element, lines: Lines) -> _Table:
    """Columns and lists; of each list the length comes first, which tells where the next property begins."""
    what = f"a line of {element.name}"
    begins = [np.zeros(len(lines), np.int64)]
    sizes: dict[str, np.ndarray] = {}
    for p in element.properties:
        words = np.ones(len(lines), np.int64)
        if p.count_type:
            sizes[p.name], _ = lines.ragged(words, what, first=begins[-1])
            if (sizes[p.name] < 0).any():
                raise InvalidInput(f"line {lines.numbers[np.argmin(sizes[p.name])]}: a list has a negative length")
            words = words + sizes[p.name]
        begins.append(begins[-1] + words)
    values, offsets = lines.ragged(begins[-1], what, real=True)
    table = _Table()
    for p, begin in zip(element.properties, begins, strict=False):
        at = offsets[:-1] + begin
        if p.count_type:
            size = sizes[p.name]
            place = np.arange(size.sum()) + np.repeat(at + 1 - (np.cumsum(size) - size), size)
            table.lists[p.name] = (size, _typed(values[place], p, element.name))
        else:
            table.columns[p.name] = _typed(values[at], p, element.name)
    return table


def _typed(values: np.ndarray, p: _Property, name: str) -> np.ndarray:
    """Text's numbers in the declared type; a whole number that does not fit is an error."""
    if p.type[0] in "iu":
        limit = np.iinfo(p.type)
        if not ((values >= limit.min) & (values <= limit.max) & (values == np.round(values))).all():
            raise InvalidInput(f"{p.name} of {name} holds numbers that are no {_NAMES[p.type]}")
    with np.errstate(over="ignore"):
        return values.astype(p.type)


def _binary_tables(data: bytes, at: int, order: str, elements: list[_Element]) -> dict[str, _Table]:
    tables = {}
    for element in elements:
        tables[element.name], at = _binary_table(data, at, order, element)
    return tables


def _binary_table(data: bytes, at: int, order: str, element: _Element) -> tuple[_Table, int]:
    table = _Table()
    if not element.count or not element.properties:
        for p in element.properties:
            empty = np.empty(0, p.type)
            if p.count_type:
                table.lists[p.name] = (np.empty(0, np.int64), empty)
            else:
                table.columns[p.name] = empty
        return table, at
    rows, at = _uniform_rows(data, at, order, element) or _mixed_rows(data, at, order, element)
    for p in element.properties:
        if not p.count_type:
            table.columns[p.name] = np.concatenate([r[p.name] for r in rows]).astype(p.type)
        else:
            sizes = np.concatenate([r["count of " + p.name] for r in rows]).astype(np.int64)
            table.lists[p.name] = (sizes, np.concatenate([r[p.name].ravel() for r in rows]).astype(p.type))
    return table, at


def _row_type(order: str, element: _Element, sizes: list[int]) -> np.dtype:
    fields: list[tuple] = []
    for p, size in zip(element.properties, sizes, strict=True):
        if p.count_type:
            fields += [("count of " + p.name, order + p.count_type), (p.name, order + p.type, (size,))]
        else:
            fields.append((p.name, order + p.type))
    return np.dtype(fields)


def _sizes_at(data: bytes, at: int, order: str, element: _Element, row: int) -> list[int]:
    """Lengths of the lists of the row that begins at a byte."""
    sizes = []
    for p in element.properties:
        n = 1
        if p.count_type:
            count = np.dtype(order + p.count_type)
            if at + count.itemsize > len(data):
                raise _short(element, row)
            n = int(np.frombuffer(data, count, 1, at)[0])
            at += count.itemsize
        sizes.append(n)
        if n < 0 or at + n * np.dtype(p.type).itemsize > len(data):
            raise _short(element, row)
        at += n * np.dtype(p.type).itemsize
    return sizes


def _uniform_rows(data: bytes, at: int, order: str, element: _Element) -> tuple[list[np.ndarray], int] | None:
    """All rows at once, if their lists are all as long as the first's."""
    sizes = _sizes_at(data, at, order, element, 0)
    row = _row_type(order, element, sizes)
    if at + row.itemsize * element.count > len(data):
        if any(p.count_type for p in element.properties):
            return None
        raise _short(element, (len(data) - at) // row.itemsize)
    rows = np.frombuffer(data, row, element.count, at)
    for p, size in zip(element.properties, sizes, strict=True):
        if p.count_type and (rows["count of " + p.name] != size).any():
            return None
    return [rows], at + row.itemsize * element.count


def _mixed_rows(data: bytes, at: int, order: str, element: _Element) -> tuple[list[np.ndarray], int]:
    rows = []
    for k in range(element.count):
        row = _row_type(order, element, _sizes_at(data, at, order, element, k))
        rows.append(np.frombuffer(data, row, 1, at))
        at += row.itemsize
    return rows, at


def _mesh(points: np.ndarray, point_data: dict[str, np.ndarray], tables: dict[str, _Table]) -> Mesh:
    """Faces and edges, in the order of the file, as cells with their data."""
    types, sizes, corners, data = [np.empty(0, np.int64)], [np.empty(0, np.int64)], [np.empty(0, np.int64)], []
    for name, table in tables.items():
        if name == "face":
            listed = next((table.lists[c] for c in _CORNERS if c in table.lists), None)
            if listed is None:
                raise InvalidInput("its faces do not list their corners (vertex_indices)")
            types.append(np.full(len(listed[0]), POLYGON))
            sizes.append(listed[0])
            corners.append(listed[1].astype(np.int64))
        elif name == "edge" and {"vertex1", "vertex2"} <= set(table.columns):
            ends = [table.columns.pop(end).astype(np.int64) for end in ("vertex1", "vertex2")]
            types.append(np.full(len(ends[0]), LINE))
            sizes.append(np.full(len(ends[0]), 2))
            corners.append(np.column_stack(ends).ravel())
        else:
            continue
        if len(sizes[-1]):
            data.append(table.columns)
    offsets = np.concatenate([[0], np.cumsum(np.concatenate(sizes))]).astype(np.int64)
    cells, origin = cells_by_kind(np.concatenate(types), np.concatenate(corners), offsets, points)
    names = dict.fromkeys(name for columns in data for name in columns)
    common = [name for name in names if all(name in columns for columns in data)]
    warn_dropped("cell data", [n for n in names if n not in common], "faces and edges do not both have them")
    cell_data = {name: np.concatenate([columns[name] for columns in data])[origin] for name in common}
    return Mesh(points, cells, point_data, cell_data)


def write_ply(path: Path, mesh: Mesh | PolyhedralMesh, *, binary: bool = True) -> None:
    """Points in double precision, faces and edges in the order of the mesh's kinds."""
    point_data = _storable(mesh.point_data, "point data", ("x", "y", "z"))
    cell_data = _storable(mesh.cell_data, "cell data", (*_CORNERS, "vertex1", "vertex2"))
    points = {**{axis: mesh.points[:, k] for k, axis in enumerate("xyz")}, **point_data}
    parts = [("vertex", [_rows(points, None)])]
    if isinstance(mesh, PolyhedralMesh):
        _write(path, [*parts, ("face", _polygon_rows(mesh, cell_data))], binary)
        return
    faces = [(c, where) for kind, c, where in mesh.blocks() if kind != "line"]
    edges = [(c, where) for kind, c, where in mesh.blocks() if kind == "line"]
    lines_first = next(iter(mesh.cells), "") == "line"
    if len(mesh.points) > 2**31 - 1:
        raise InvalidInput("has more points than PLY can number", parameter="mesh")
    faces_part = ("face", [_rows({k: v[where] for k, v in cell_data.items()}, c) for c, where in faces])
    ends = [({"vertex1": c[:, 0].astype("i4"), "vertex2": c[:, 1].astype("i4")}, where) for c, where in edges]
    edges_part = ("edge", [_rows({**e, **{k: v[w] for k, v in cell_data.items()}}, None) for e, w in ends])
    parts += [edges_part, faces_part] if lines_first else [faces_part, edges_part]
    _write(path, [(name, rows) for name, rows in parts if rows], binary)


def _storable(data: dict[str, np.ndarray], what: str, taken: tuple[str, ...]) -> dict[str, np.ndarray]:
    """Columns of types that PLY has; whole numbers of 64 bits if they fit into 32."""
    kept, large = {}, []
    for name, values in columns_of(data, what, "PLY").items():
        if values.dtype.kind == "b":
            values = values.astype("u1")
        elif values.dtype == np.float16:
            values = values.astype("f4")
        elif values.dtype.itemsize > 4 and values.dtype.kind in "iu":
            if values.size and (values.min() < -(2**31) or values.max() >= 2**31):
                large.append(name)
                continue
            values = values.astype("i4")
        kept[name] = values.astype("f8") if values.dtype.itemsize > 8 else values
    warn_dropped(what, large, "PLY has no whole numbers of 64 bits")
    warn_dropped(what, [name for name in kept if name in taken], "PLY uses the name itself")
    return {name: values for name, values in kept.items() if name not in taken}


def _rows(columns: dict[str, np.ndarray], corners: np.ndarray | None) -> np.ndarray:
    """One record a row; a list of corners comes first, after its length."""
    fields = [(name, values.dtype.newbyteorder("<")) for name, values in columns.items()]
    if corners is not None:
        fields = [("count", "u1"), (_CORNERS[0], "<i4", (corners.shape[1],)), *fields]
    count = len(corners) if corners is not None else len(next(iter(columns.values())))
    rows = np.zeros(count, np.dtype(fields))
    for name, values in columns.items():
        rows[name] = values
    if corners is not None:
        rows["count"], rows[_CORNERS[0]] = corners.shape[1], corners
    return rows


def _polygon_rows(mesh: PolyhedralMesh, columns: dict[str, np.ndarray]) -> list[np.ndarray]:
    """Records of faces in their order; those with as many corners that follow each other in one array."""
    tables = corner_tables(mesh) or [np.empty((0, 3), np.int64)]
    if (most := max(corners.shape[1] for corners in tables)) > 255:
        raise InvalidInput(f"has a polygon of {most} corners, PLY counts to 255; write .vtu", parameter="mesh")
    found, first = [], 0
    for corners in tables:
        last = first + len(corners)
        found.append(_rows({name: values[first:last] for name, values in columns.items()}, corners))
        first = last
    return found


def _write(path: Path, parts: list[tuple[str, list[np.ndarray]]], binary: bool) -> None:
    header = ["ply", f"format {'binary_little_endian' if binary else 'ascii'} 1.0", "comment written by meshcore"]
    for name, rows in parts:
        header.append(f"element {name} {sum(len(r) for r in rows)}")
        for key in rows[0].dtype.names:
            if key == _CORNERS[0] and name == "face":
                header.append(f"property list uchar int {key}")
            elif not (key == "count" and _CORNERS[0] in rows[0].dtype.names):
                header.append(f"property {_NAMES[rows[0].dtype[key].str[1:]]} {quote(key, safe='')}")
    header.append("end_header\n")
    with open(path, "wb") as file:
        file.write("\n".join(header).encode())
        for _, parts_of_one in parts:
            for records in parts_of_one:
                file.write(records.tobytes() if binary else _text(records))


def _text(records: np.ndarray) -> bytes:
    return rows_of(*(records[name] for name in records.dtype.names)).encode()


register(
    "PLY",
    (".ply",),
    "surfaces and edges, text or binary, with one-number data",
    Holds(cells=("line", "triangle", "quad"), polygons=True, point_data=True, cell_data=True),
    read=read_ply,
    write=write_ply,
)
