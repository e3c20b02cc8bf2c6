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
from .content import exact, floats
from .fit import FormatWarning, Holds
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


def _text_corners(text: str) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    corners: list[list[float]] = []
    solids: dict[str, list[int]] = {}
    name, facet, inside = "", 0, False
    for k, line in enumerate(text.splitlines(), 1):
        words = line.split()
        key = words[0].lower() if words else ""
        if key == "solid":
            name, inside = " ".join(words[1:]) or f"solid {len(solids)}", True
            solids.setdefault(name, [])
        elif key == "vertex":
            if len(words) < 4:
                raise InvalidInput(f"line {k}: a corner needs three coordinates, got {line.strip()!r}")
            corners.append(floats(words[1:4], k))
        elif key == "endfacet":
            if len(corners) != facet + 3:
                raise InvalidInput(f"line {k}: a facet has {len(corners) - facet} corners, it needs three")
            facet = len(corners)
            solids[name].append(facet // 3 - 1)
        elif key == "endsolid":
            inside = False
        elif key and key not in ("facet", "outer", "endloop"):
            raise InvalidInput(f"line {k}: {line.strip()[:40]!r} is no part of an STL file")
    if inside or len(corners) != facet:
        raise InvalidInput("the file ends before 'endsolid'")
    return np.array(corners).reshape(-1, 3), {n: np.array(v, np.int64) for n, v in solids.items()}


def write_stl(path: Path, mesh: Mesh, *, binary: bool = True) -> None:
    """Triangles with their unit normals; without area the normal is zero."""
    corners = mesh.points[mesh.get("triangle")]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0)
    if binary:
        _write_binary(path, corners, normals)
        return
    lines = ["solid meshcore"]
    for normal, triangle in zip(normals.tolist(), corners.tolist(), strict=True):
        lines += [f"facet normal {' '.join(map(exact, normal))}", "outer loop"]
        lines += [f"vertex {' '.join(map(exact, corner))}" for corner in triangle]
        lines += ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid meshcore"]) + "\n", encoding="utf-8")


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
