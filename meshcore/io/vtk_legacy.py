"""VTK's legacy files (.vtk), text and binary, of versions 1 to 5.1: meshes, surfaces and structured grids.

Written are version 3.0 files, which everything reads, with all data as field arrays and every bit kept.

References
----------
https://docs.vtk.org/en/latest/vtk_file_formats/vtk_legacy_file_format.html
"""

from __future__ import annotations

from pathlib import Path
from urllib.parse import unquote

import numpy as np

from ..errors import InvalidInput
from ..mesh import Mesh, StructuredGrid
from .content import whole
from .fit import ALL_CELLS, Holds
from .ragged import POLY_LINE, POLY_VERTEX, POLYGON, TRIANGLE_STRIP
from .registry import register
from .vtk_data import GRID, MESH, DataSet, decoded
from .vtk_legacy_writer import write_vtk

_TYPES = {
    "bit": "u1", "unsigned_char": "u1", "char": "i1", "signed_char": "i1", "unsigned_short": "u2", "short": "i2",
    "unsigned_int": "u4", "int": "i4", "unsigned_long": "u8", "long": "i8", "vtkidtype": "i4", "float": "f4",
    "double": "f8", "vtktypeint8": "i1", "vtktypeuint8": "u1", "vtktypeint16": "i2", "vtktypeuint16": "u2",
    "vtktypeint32": "i4", "vtktypeuint32": "u4", "vtktypeint64": "i8", "vtktypeuint64": "u8", "long_long": "i8",
    "unsigned_long_long": "u8", "vtktypefloat32": "f4", "vtktypefloat64": "f8",
}  # fmt: skip
_POLY = {"VERTICES": POLY_VERTEX, "LINES": POLY_LINE, "POLYGONS": POLYGON, "TRIANGLE_STRIPS": TRIANGLE_STRIP}
_COLUMNS = {
    "VECTORS": 3,
    "NORMALS": 3,
    "TENSORS": 9,
    "TENSORS6": 6,
    "GLOBAL_IDS": 1,
    "PEDIGREE_IDS": 1,
    "EDGE_FLAGS": 1,
}
_DATA_SETS = ("UNSTRUCTURED_GRID", "POLYDATA", "STRUCTURED_GRID", "RECTILINEAR_GRID", "STRUCTURED_POINTS")


class _Cursor:
    """A place in the file: keywords are taken by line, numbers as text or as bytes."""

    def __init__(self, data: bytes):
        if not data.startswith(b"# vtk DataFile"):
            raise InvalidInput("it does not begin with '# vtk DataFile'")
        self.data, self.at = data, 0
        for _ in range(2):
            self.line()
        form = self.line().strip().upper()
        if form not in ("ASCII", "BINARY"):
            raise InvalidInput(f"line 3 says {form[:20]!r}, ASCII or BINARY was expected")
        self.binary = form == "BINARY"

    @property
    def line_number(self) -> int:
        return self.data.count(b"\n", 0, self.at)

    def line(self) -> str:
        end = self.data.find(b"\n", self.at)
        end = len(self.data) if end < 0 else end
        found, self.at = self.data[self.at : end], end + 1
        return found.decode("utf-8", errors="replace").rstrip("\r")

    def words(self) -> list[str]:
        """The words of the next line that has any, without metadata; none at the end."""
        while self.at < len(self.data):
            words = self.line().split()
            if words and words[0] == "METADATA":
                while self.at < len(self.data) and self.line().strip():
                    pass
            elif words:
                return words
        return []

    def whole(self, words: list[str], k: int, what: str) -> int:
        if k >= len(words):
            raise InvalidInput(f"line {self.line_number}: {' '.join(words)!r} lacks {what}")
        n = whole(words[k], self.line_number, what)
        if n < 0:
            raise InvalidInput(f"line {self.line_number}: {what} is {n}")
        return n

    def type(self, words: list[str], k: int) -> str:
        name = words[k].lower() if k < len(words) else ""
        if name not in _TYPES and name != "string":
            raise InvalidInput(f"line {self.line_number}: {name!r} is no type of VTK's")
        return name

    def numbers(self, count: int, type_name: str, what: str) -> np.ndarray:
        """``count`` values of a type."""
        dtype = np.dtype(_TYPES[type_name])
        size = -(-count // 8) if type_name == "bit" else count * dtype.itemsize
        if not self.binary:
            return self._text_numbers(count, dtype, what)
        if self.at + size > len(self.data):
            raise InvalidInput(f"{count} values of {what} are promised, but the file ends before")
        content = self.data[self.at : self.at + size]
        self.at += size
        if self.data[self.at : self.at + 1] == b"\n":
            self.at += 1
        if type_name == "bit":
            return np.unpackbits(np.frombuffer(content, np.uint8))[:count]
        return np.frombuffer(content, dtype.newbyteorder(">")).astype(dtype)

    def _text_numbers(self, count: int, dtype: np.dtype, what: str) -> np.ndarray:
        if count > len(self.data):
            raise InvalidInput(f"{count} values of {what} are promised, but the file ends before")
        words: list[str] = []
        first = self.line_number + 1
        while len(words) < count and self.at < len(self.data):
            words += self.line().split()
        if len(words) != count:
            raise InvalidInput(f"from line {first}: {count} values of {what} are promised, but there are {len(words)}")
        try:
            with np.errstate(over="ignore"):
                if dtype.kind == "f":
                    return np.array(words, np.float64).astype(dtype)
                return np.array([int(word) for word in words], dtype)
        except (ValueError, OverflowError):
            raise InvalidInput(f"from line {first}: the values of {what} are not all numbers of their type") from None

    def strings(self, count: int, what: str) -> np.ndarray:
        found = []
        for _ in range(count):
            if self.at >= len(self.data):
                raise InvalidInput(f"{count} values of {what} are promised, but the file ends before")
            found.append(unquote(self._binary_string() if self.binary else self.line()))
        if self.binary and self.data[self.at : self.at + 1] == b"\n":
            self.at += 1
        return np.array(found, dtype=str)

    def _binary_string(self) -> str:
        """The two highest bits of the first byte tell the width of the length: 8, 4, 2 or 1 bytes."""
        width = (8, 4, 2, 1)[self.data[self.at] >> 6]
        head = self.data[self.at : self.at + width]
        size = int.from_bytes(head, "big") & ((1 << (8 * width - 2)) - 1)
        start = self.at + width
        if start + size > len(self.data):
            raise InvalidInput("a text is cut off")
        self.at = start + size
        return self.data[start : self.at].decode("utf-8", errors="replace")


def read_vtk(path: Path) -> Mesh | StructuredGrid:
    """A mesh, or a structured grid."""
    cursor = _Cursor(path.read_bytes())
    words, fields = cursor.words(), {}
    while words and words[0].upper() == "FIELD":
        fields.update(_field(cursor, words))
        words = cursor.words()
    if len(words) < 2 or words[0].upper() != "DATASET" or words[1].upper() not in _DATA_SETS:
        raise InvalidInput(f"line {cursor.line_number}: {' '.join(words)[:60]!r}; DATASET of a known kind was expected")
    return decoded(_Body(cursor, words[1].upper(), fields).read())


class _Body:
    """What follows DATASET: geometry, then data of points and cells."""

    def __init__(self, cursor: _Cursor, kind: str, fields: dict[str, np.ndarray]):
        self.cursor, self.kind = cursor, kind
        structured = kind not in ("UNSTRUCTURED_GRID", "POLYDATA")
        self.data = DataSet(GRID if structured else MESH, np.empty((0, 3)), field_data=fields)
        self.target: dict[str, np.ndarray] = fields
        self.count = -1
        self.axes: dict[str, np.ndarray] = {}
        self.groups: list[tuple[int, np.ndarray, np.ndarray]] = []
        self.types: np.ndarray | None = None

    def read(self) -> DataSet:
        while words := self.cursor.words():
            key = words[0].upper()
            if key in ("POINT_DATA", "CELL_DATA"):
                self.count = self.cursor.whole(words, 1, "a number of values")
                self.target = self.data.point_data if key == "POINT_DATA" else self.data.cell_data
            elif key == "FIELD":
                self.target.update(_field(self.cursor, words))
            elif self.count < 0:
                self._geometry(key, words)
            else:
                self._attribute(key, words)
        self._finish()
        return self.data

    def _geometry(self, key: str, words: list[str]) -> None:
        cursor = self.cursor
        if key == "POINTS":
            n = cursor.whole(words, 1, "a number of points")
            self.data.points = cursor.numbers(3 * n, cursor.type(words, 2), "POINTS").reshape(-1, 3).astype(float)
        elif key == "DIMENSIONS":
            sizes = [cursor.whole(words, k, "a number of points") for k in (1, 2, 3)]
            self.data.dimensions = (sizes[0], sizes[1], sizes[2])
        elif key in ("X_COORDINATES", "Y_COORDINATES", "Z_COORDINATES"):
            n = cursor.whole(words, 1, "a number of coordinates")
            self.axes[key[0]] = cursor.numbers(n, cursor.type(words, 2), key).astype(float)
        elif key in ("ORIGIN", "SPACING", "ASPECT_RATIO"):
            try:
                self.axes["ORIGIN" if key == "ORIGIN" else "SPACING"] = np.array(words[1:4], float).reshape(3)
            except ValueError:
                raise InvalidInput(f"line {cursor.line_number}: {key} needs three numbers") from None
        elif key == "CELLS" or key in _POLY:
            self.groups.append((_POLY.get(key, -1), *self._cells(words, key)))
        elif key == "CELL_TYPES":
            n = cursor.whole(words, 1, "a number of cells")
            self.types = cursor.numbers(n, "int", "CELL_TYPES")
        else:
            raise InvalidInput(f"line {cursor.line_number}: {' '.join(words)[:60]!r} is no keyword of {self.kind}")

    def _cells(self, words: list[str], key: str) -> tuple[np.ndarray, np.ndarray]:
        """Corners and offsets; version 5.1 lists them apart, older ones put each cell's size before its corners."""
        cursor = self.cursor
        n, size = cursor.whole(words, 1, "a number of cells"), cursor.whole(words, 2, "a number of values")
        before = cursor.at
        head = cursor.words()
        if len(head) == 2 and head[0].upper() == "OFFSETS":
            offsets = cursor.numbers(n, cursor.type(head, 1), key).astype(np.int64)
            head = cursor.words()
            if len(head) != 2 or head[0].upper() != "CONNECTIVITY":
                raise InvalidInput(f"line {cursor.line_number}: CONNECTIVITY was expected behind OFFSETS")
            return cursor.numbers(size, cursor.type(head, 1), key).astype(np.int64), offsets
        cursor.at = before
        padded = cursor.numbers(size, "int", key).astype(np.int64)
        heads, sizes, at, left = [], [], 0, n
        while left:
            width = int(padded[at]) + 1 if at < size else 0
            count = _alike(padded, at, width, left) if width > 0 else 0
            if not count or at + count * width > size:
                raise InvalidInput(f"the {n} cells of {key} do not fit their {size} numbers")
            heads.append(at + width * np.arange(count))
            sizes.append(np.full(count, width - 1))
            at, left = at + count * width, left - count
        offsets = np.concatenate([[0], np.cumsum(np.concatenate([[], *sizes]))]).astype(np.int64)
        corners = np.delete(padded[:at], np.concatenate([[], *heads]).astype(np.int64))
        return corners, offsets

    def _attribute(self, key: str, words: list[str]) -> None:
        cursor = self.cursor
        if key == "LOOKUP_TABLE":
            n = 4 * cursor.whole(words, 2, "a number of colours")
            cursor.numbers(n, "unsigned_char" if cursor.binary else "float", key)
            return
        name = unquote(words[1]) if len(words) > 1 else key
        if key == "COLOR_SCALARS":
            columns, type_name = cursor.whole(words, 2, "a number of colours"), "float"
            type_name = "unsigned_char" if cursor.binary else "float"
        elif key == "TEXTURE_COORDINATES":
            columns, type_name = cursor.whole(words, 2, "a number of coordinates"), cursor.type(words, 3)
        elif key == "SCALARS":
            type_name = cursor.type(words, 2)
            columns = cursor.whole(words, 3, "a number of components") if len(words) > 3 else 1
            before = cursor.at
            if (head := cursor.words()) and head[0].upper() != "LOOKUP_TABLE":
                cursor.at = before
        elif key in _COLUMNS:
            columns, type_name = _COLUMNS[key], cursor.type(words, 2)
        else:
            raise InvalidInput(f"line {cursor.line_number}: {' '.join(words)[:60]!r} is no keyword of data")
        self.target[name] = _array(cursor, self.count, columns, type_name, name)

    def _finish(self) -> None:
        data = self.data
        if self.kind == "STRUCTURED_POINTS":
            origin, spacing = self.axes.get("ORIGIN", np.zeros(3)), self.axes.get("SPACING", np.ones(3))
            if max(data.dimensions) > 1_000_000_000 or np.prod([float(n) for n in data.dimensions]) > 5e8:
                raise InvalidInput(f"a grid of {data.dimensions} points is too large to be meant")
            self.axes = {a: origin[k] + spacing[k] * np.arange(data.dimensions[k]) for k, a in enumerate("XYZ")}
        if self.kind in ("STRUCTURED_POINTS", "RECTILINEAR_GRID"):
            if not {"X", "Y", "Z"} <= set(self.axes) or tuple(len(self.axes[a]) for a in "XYZ") != data.dimensions:
                raise InvalidInput("its coordinates do not fit its DIMENSIONS")
            z, y, x = np.meshgrid(self.axes["Z"], self.axes["Y"], self.axes["X"], indexing="ij")
            data.points = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
        if data.kind == MESH:
            self._join_groups()
        for name, values, count in [
            *((n, v, len(data.points)) for n, v in data.point_data.items()),
            *((n, v, len(data.types)) for n, v in data.cell_data.items() if data.kind == MESH),
        ]:
            if len(values) != count:
                raise InvalidInput(f"the array {name!r} has {len(values)} values, {count} were expected")

    def _join_groups(self) -> None:
        data = self.data
        data.whole_polygons = self.kind == "UNSTRUCTURED_GRID"
        types, corners, offsets = [np.empty(0, np.int64)], [np.empty(0, np.int64)], [np.zeros(1, np.int64)]
        for vtk_type, connectivity, ends in self.groups:
            n = max(len(ends) - 1, 0)
            if vtk_type < 0 and (self.types is None or len(self.types) != n):
                raise InvalidInput(f"{n} CELLS have {0 if self.types is None else len(self.types)} CELL_TYPES")
            types.append(self.types if vtk_type < 0 else np.full(n, vtk_type))
            offsets.append(ends[1:] + sum(len(c) for c in corners))
            corners.append(connectivity)
        data.types, data.connectivity, data.offsets = map(np.concatenate, (types, corners, offsets))
        # A polyhedron is listed by its stream of faces, which begins where its corners would.
        data.faces, data.face_starts = data.connectivity, data.offsets[:-1]


def _field(cursor: _Cursor, words: list[str]) -> dict[str, np.ndarray]:
    found = {}
    for _ in range(cursor.whole(words, 2, "a number of arrays")):
        head = cursor.words()
        if not head:
            raise InvalidInput("the file ends within FIELD")
        columns, rows = cursor.whole(head, 1, "a number of components"), cursor.whole(head, 2, "a number of rows")
        found[unquote(head[0])] = _array(cursor, rows, columns, cursor.type(head, 3), head[0])
    return found


def _array(cursor: _Cursor, rows: int, columns: int, type_name: str, name: str) -> np.ndarray:
    if type_name == "string":
        values = cursor.strings(rows * columns, name)
    else:
        values = cursor.numbers(rows * columns, type_name, name)
    return values.reshape(rows, columns) if columns != 1 else values


def _alike(padded: np.ndarray, at: int, width: int, most: int) -> int:
    """How many cells in a row have as many corners as the one at ``at``, which takes ``width`` numbers."""
    count = 1
    while count < most:  # twice as many at a time, so that kinds in turns cost little
        ahead = padded[at + count * width : at + 2 * count * width : width][: most - count]
        other = np.flatnonzero(ahead != width - 1)
        if len(other) or not len(ahead):
            return count + (int(other[0]) if len(other) else 0)
        count += len(ahead)
    return count


register(
    "legacy VTK",
    (".vtk",),
    "any mesh, or one structured grid, with all its data",
    Holds(
        cells=ALL_CELLS,
        blocks=1,
        polygons=True,
        polyhedra=True,
        point_data=True,
        cell_data=True,
        field_data=True,
        sets=True,
    ),
    read=read_vtk,
    write=write_vtk,
)
