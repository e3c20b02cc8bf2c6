"""Writing VTK's legacy files (.vtk), text and binary: version 3.0, with all data as field arrays and every bit kept."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import quote

import numpy as np

from ..errors import InvalidInput
from ..mesh import Mesh, PolyhedralMesh, StructuredGrid
from .lines import wrapped
from .vtk_data import GRID, MESH, encoded

_NAMES = {"u1": "unsigned_char", "i1": "char", "u2": "unsigned_short", "i2": "short", "u4": "unsigned_int", "i4": "int",
          "u8": "vtktypeuint64", "i8": "vtktypeint64", "f4": "float", "f8": "double"}  # fmt: skip


def write_vtk(path: Path, mesh: Mesh | PolyhedralMesh | StructuredGrid, *, binary: bool = True) -> None:
    """A mesh as an unstructured grid, a structured grid as such."""
    data = encoded(mesh)
    if len(data.points) >= 2**31:
        raise InvalidInput("has more points than legacy VTK can number; write .vtu", parameter="mesh")
    out = _Writer(binary)
    kind = "STRUCTURED_GRID" if data.kind == GRID else "UNSTRUCTURED_GRID"
    out.line(f"# vtk DataFile Version 3.0\nwritten by meshcore\n{'BINARY' if binary else 'ASCII'}\nDATASET {kind}")
    out.fields("FieldData", data.field_data)
    if data.kind == GRID:
        out.line("DIMENSIONS " + " ".join(map(str, data.dimensions)))
    out.line(f"POINTS {len(data.points)} double")
    out.values(data.points)
    if data.kind == MESH:
        listed, offsets = (
            (data.faces, np.append(data.face_starts, len(data.faces)))
            if len(data.faces)
            else (data.connectivity, data.offsets)
        )  # a polyhedron is listed by its stream of faces
        padded = np.insert(listed, offsets[:-1], np.diff(offsets)).astype(np.int32)
        out.line(f"CELLS {len(data.types)} {len(padded)}")
        out.values(padded)
        out.line(f"CELL_TYPES {len(data.types)}")
        out.values(data.types.astype(np.int32))
    cells = len(data.types) if data.kind == MESH else int(np.prod([max(n - 1, 1) for n in data.dimensions]))
    for key, count, arrays in (("POINT_DATA", len(data.points), data.point_data), ("CELL_DATA", cells, data.cell_data)):
        if arrays:
            out.line(f"{key} {count}")
            out.fields("FieldData", arrays)
    path.write_bytes(b"".join(out.parts))


class _Writer:
    def __init__(self, binary: bool):
        self.binary, self.parts = binary, []

    def line(self, text: str) -> None:
        self.parts.append(text.encode() + b"\n")

    def values(self, values: np.ndarray) -> None:
        if values.dtype.kind == "U":
            self._strings(values)
        elif self.binary:
            self.parts.append(values.astype(values.dtype.newbyteorder(">")).tobytes() + b"\n")
        else:
            self.line(wrapped(values.ravel(), 9).rstrip("\n"))

    def _strings(self, values: np.ndarray) -> None:
        for text in values.ravel().tolist():
            encoded_text = quote(text).encode()
            if not self.binary:
                self.parts.append(encoded_text + b"\n")
            else:
                width, mark = next((w, m) for w, m in ((1, 3), (2, 2), (4, 1)) if len(encoded_text) < 1 << (8 * w - 2))
                head = (len(encoded_text) | mark << (8 * width - 2)).to_bytes(width, "big")
                self.parts.append(head + encoded_text)
        self.parts.append(b"\n")

    def fields(self, name: str, arrays: dict[str, np.ndarray]) -> None:
        if not arrays:
            return
        self.line(f"FIELD {name} {len(arrays)}")
        for key, values in arrays.items():
            kind = "string" if values.dtype.kind == "U" else _NAMES[values.dtype.str[1:]]
            columns = values.shape[1] if values.ndim > 1 else 1
            self.line(f"{quote(key, safe='') or '%20'} {columns} {len(values)} {kind}")
            self.values(values)
