"""STL, text and binary: triangles without connectivity, so equal corners become one point when read.

Binary STL has single precision; ``binary=False`` writes every digit. Points that no triangle uses are not held.
The solids of a text file are sets, if there are several.
"""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np

from ..errors import InvalidInput
from ..mesh import Mesh
from .fit import FormatWarning, Holds
from .lines import Lines, rows_of
from .registry import register

_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("extra", "<u2")])
_HEADER = 84


def read_stl(path: Path) -> Mesh:
    """Triangles, told apart by content: a binary file's length follows from its count."""
    data = path.read_bytes()
    count = int.from_bytes(data[80:_HEADER], "little") if len(data) >= _HEADER else -1
    if len(data) == _HEADER + _RECORD.itemsize * count:
        corners = np.frombuffer(data, _RECORD, offset=_HEADER)["corners"].astype(float).reshape(-1, 3)
        solids = {}
    elif data.lstrip().lower().startswith(b"solid") and b"\0" not in data:
        corners, solids = _text_corners(data.decode("utf-8", errors="replace"))
    elif count >= 0 and not data.lstrip().lower().startswith(b"solid"):
        held = max(len(data) - _HEADER, 0) // _RECORD.itemsize
        raise InvalidInput(f"{count} triangles are promised, but there is room for {held}")
    else:
        raise InvalidInput(f"it is neither text nor binary STL ({len(data)} bytes)")
    bad = np.flatnonzero(~np.isfinite(corners).all(axis=1))
    if len(bad):
        raise InvalidInput(f"triangle {bad[0] // 3} has a corner at {corners[bad[0]].tolist()}")
    points, cells = _merged(corners)
    return Mesh(points, {"triangle": cells}, sets=solids if len(solids) > 1 else {})


def _merged(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Equal corners as one point, in the order of their first appearance."""
    if not len(corners):
        return np.empty((0, 3)), np.empty((0, 3), np.int64)
    corners = corners + 0.0  # -0.0 and 0.0 are one place
    _, first, inverse = np.unique(corners, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    place = np.empty(len(order), np.int64)
    place[order] = np.arange(len(order))
    return corners[first[order]], place[inverse.reshape(-1)].reshape(-1, 3)


_PARTS = {key: k for k, key in enumerate(("solid", "facet", "outer", "vertex", "endloop", "endfacet", "endsolid"))}


def _text_corners(text: str) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Corners, three a triangle, and the triangles of each solid."""
    lines = Lines.of("\n".join(text.splitlines()), comment="\0")
    part = np.array([_PARTS.get(words.split(None, 1)[0].lower(), -1) for words in lines.texts], np.int64)
    if (part < 0).any():
        line, words = lines[int(np.argmin(part))]
        raise InvalidInput(f"line {line}: {' '.join(words)[:40]!r} is no part of an STL file")
    solid, vertex, endfacet, endsolid = (
        np.flatnonzero(part == _PARTS[key]) for key in ("solid", "vertex", "endfacet", "endsolid")
    )
    corners = lines[vertex].table(3, "a corner", first=1)
    held = np.diff(np.searchsorted(vertex, endfacet), prepend=0)
    if (held != 3).any():
        bad = int(np.argmax(held != 3))
        line = lines.numbers[endfacet[bad]]
        raise InvalidInput(f"line {line}: a facet has {held[bad]} corners, it needs three")
    if len(corners) != 3 * len(endfacet) or len(endsolid) < 1 or endsolid[-1] < solid[-1]:
        raise InvalidInput("the file ends before 'endsolid'")
    solids: dict[str, list[np.ndarray]] = {}
    ends = np.searchsorted(endfacet, np.append(solid, len(lines)))
    for k, line in enumerate(solid.tolist()):
        name = " ".join(lines[line][1][1:]) or f"solid {len(solids)}"
        solids.setdefault(name, []).append(np.arange(ends[k], ends[k + 1]))
    return corners, {name: np.concatenate(parts) for name, parts in solids.items()}


def write_stl(path: Path, mesh: Mesh, *, binary: bool = True) -> None:
    """Triangles with their unit normals; without area the normal is zero."""
    corners = mesh.points[mesh.get("triangle")]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0)
    if binary:
        _write_binary(path, corners, normals)
        return
    facet = "facet normal %s %s %s\nouter loop\n" + "vertex %s %s %s\n" * 3 + "endloop\nendfacet"
    text = rows_of(normals, corners.reshape(-1, 9), form=facet)
    path.write_text(f"solid meshcore\n{text}endsolid meshcore\n", encoding="utf-8")


def _write_binary(path: Path, corners: np.ndarray, normals: np.ndarray) -> None:
    records = np.zeros(len(corners), _RECORD)
    if corners.size and np.abs(corners).max() > np.finfo(np.float32).max:
        raise InvalidInput("has coordinates beyond single precision; write with binary=False", parameter="mesh")
    records["normal"], records["corners"] = normals, corners
    if (records["corners"] != corners).any():
        warnings.warn(
            "coordinates were rounded to binary STL's single precision; binary=False keeps every digit",
            FormatWarning,
            stacklevel=2,
        )
    header = b"binary STL written by meshcore".ljust(80)
    path.write_bytes(header + len(records).to_bytes(4, "little") + records.tobytes())


register(
    "STL",
    (".stl",),
    "triangles, text or binary",
    Holds(cells=("triangle",)),
    read=read_stl,
    write=write_stl,
)
