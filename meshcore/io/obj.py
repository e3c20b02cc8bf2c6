"""Wavefront OBJ: points, lines and faces; groups (g) and objects (o) are sets.

Texture coordinates, normals and materials are not read. A set's name with blanks is written with %20.
"""

from __future__ import annotations

from pathlib import Path
from urllib.parse import quote, unquote

import numpy as np

from ..errors import InvalidInput
from ..mesh import Mesh, PolyhedralMesh
from .content import exact, floats, numbered, text_of, whole
from .fit import SURFACE_CELLS, Holds, warn_dropped
from .polyhedra import polygon_lists
from .ragged import POLY_LINE, POLY_VERTEX, POLYGON, cells_by_kind
from .registry import register

_ELEMENTS = {"p": (POLY_VERTEX, 1), "l": (POLY_LINE, 2), "f": (POLYGON, 3)}
_IGNORED = {"vt", "vn", "vp", "s", "usemtl", "mtllib", "usemap", "maplib", "cstype", "deg", "lod", "shadow_obj"}


def read_obj(path: Path) -> Mesh:
    """Points and cells of all objects and groups together, each of these a set."""
    points: list[list[float]] = []
    types: list[int] = []
    corners: list[int] = []
    sizes: list[int] = []
    groups: dict[str, list[int]] = {}
    current: dict[str, list[str]] = {"o": [], "g": []}
    known = 0
    for line, (key, *words) in numbered(text_of(path).replace("\\\n", " ")):
        if key == "v":
            if len(words) < 3:
                raise InvalidInput(f"line {line}: a point needs three coordinates, got {' '.join(words)!r}")
            points.append(floats(words[:3], line))
        elif key in _ELEMENTS:
            vtk_type, least = _ELEMENTS[key]
            if len(words) < least:
                raise InvalidInput(f"line {line}: {key} needs at least {least} points, got {len(words)}")
            for name in dict.fromkeys(current["o"] + current["g"]):
                groups.setdefault(name, []).append(len(types))
            corners += [_point(word, line, len(points)) for word in words]
            types.append(vtk_type)
            sizes.append(len(words))
        elif key in current:
            names = [unquote(" ".join(words))] if key == "o" else [unquote(word) for word in words]
            current[key] = [name for name in names if name]
        known += key == "v" or key in _ELEMENTS or key in _IGNORED or key in current
    if not points or not known:
        raise InvalidInput("it holds no points (lines that begin with v)")
    offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    xyz = np.array(points)
    cells, origin = cells_by_kind(np.array(types, np.int64), np.array(corners, np.int64), offsets, xyz)
    sets = {name: np.flatnonzero(np.isin(origin, members)) for name, members in groups.items()}
    return Mesh(xyz, cells, sets=sets)


def _point(word: str, line: int, n_points: int) -> int:
    """Number of a point, from 0; the file counts from 1, or from the last point backwards."""
    k = whole(word.split("/")[0], line, "the number of a point")
    at = k - 1 if k > 0 else n_points + k
    if k == 0 or at < 0:
        raise InvalidInput(f"line {line}: {word!r} refers to no point; {n_points} stand before it")
    return at


def write_obj(path: Path, mesh: Mesh | PolyhedralMesh) -> None:
    """Every digit of the points; a cell may be in several groups."""
    lines = ["# written by meshcore", *(f"v {exact(x)} {exact(y)} {exact(z)}" for x, y, z in mesh.points.tolist())]
    if isinstance(mesh, PolyhedralMesh):
        lines += [" ".join(["f", *(str(node + 1) for node in nodes)]) for nodes in polygon_lists(mesh)]
    else:
        lines += _grouped_cells(mesh)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _grouped_cells(mesh: Mesh) -> list[str]:
    """A line a cell, and one wherever the groups that cells are in change."""
    warn_dropped("sets", [name for name, members in mesh.sets.items() if not len(members)], "OBJ has no empty groups")
    inside: list[list[str]] = [[] for _ in range(mesh.n_cells)]
    for name, members in mesh.sets.items():
        for k in np.unique(members).tolist():
            inside[k].append(quote(name, safe="/:+,()=&"))
    lines: list[str] = []
    current: list[str] = []
    number = 0
    for kind, cells, _ in mesh.blocks():
        key = {"vertex": "p", "line": "l"}.get(kind, "f")
        for nodes in (cells + 1).tolist():
            if inside[number] != current:
                current = inside[number]
                lines.append(" ".join(["g", *current]))
            lines.append(" ".join([key, *map(str, nodes)]))
            number += 1
    return lines


register(
    "Wavefront OBJ",
    (".obj",),
    "surfaces and curves; groups are sets",
    Holds(cells=SURFACE_CELLS, polygons=True, sets=True),
    read=read_obj,
    write=write_obj,
)
