"""SU2 meshes (.su2), in the plane and in space; markers are sets of boundary cells.

Cells of the domain come first, then the boundary's, marker by marker. Boundary cells in no set cannot be written
but as the marker "unnamed". SU2 takes blanks, commas, brackets and the like in names for the end of them, so these are
written as underscores: "far field" is the marker "far_field".

References
----------
https://su2code.github.io/docs_v7/Mesh-File/
"""

from __future__ import annotations

import re
from collections.abc import Collection
from pathlib import Path

import numpy as np

from ..errors import InvalidInput
from ..mesh import BY_VTK, CELL_TYPES, Mesh
from .content import exact, numbered, table, text_of, whole
from .fit import Holds, warn_dropped
from .ragged import cells_by_kind
from .registry import register

_KINDS = ("line", "triangle", "quad", "tetra", "hexahedron", "wedge", "pyramid")
_UNNAMED = "unnamed"
Lines = list[tuple[int, list[str]]]


def read_su2(path: Path) -> Mesh:
    """Domain and markers."""
    lines = numbered(text_of(path).replace("=", " = "), comment="%")
    dimension, elements, points, markers = 0, None, None, []
    at = 0
    while at < len(lines):
        line, words = lines[at]
        at += 1
        if len(words) < 3 or words[1] != "=":
            raise InvalidInput(f"line {line}: {' '.join(words)[:40]!r} is no KEY= value")
        key = words[0].upper()
        if key == "NZONE" and words[2] != "1":
            raise InvalidInput(f"line {line}: it has {words[2]} zones; split it into one file a zone")
        if key == "NDIME":
            dimension = whole(words[2], line, "a dimension")
            if dimension not in (2, 3):
                raise InvalidInput(f"line {line}: the dimension is {dimension}, 2 or 3 was expected")
        elif key == "NELEM":
            elements, at = _rows(lines, at, line, words[2], "elements")
        elif key == "NPOIN":
            points, at = _rows(lines, at, line, words[2], "points")
        elif key == "MARKER_TAG":
            name = " ".join(words[2:])
            if at >= len(lines) or lines[at][1][0].upper() != "MARKER_ELEMS" or len(lines[at][1]) < 3:
                raise InvalidInput(f"line {line}: the marker {name!r} needs MARKER_ELEMS= behind it")
            rows, at = _rows(lines, at + 1, *_count(lines[at]), "elements of a marker")
            markers.append((name, rows))
            while at < len(lines) and lines[at][1][0].upper() == "SEND_TO":
                at += 1
    if not dimension or elements is None or points is None:
        raise InvalidInput("it lacks NDIME=, NELEM= or NPOIN=")
    return _mesh(table(points, dimension, "a point"), elements, markers)


def _count(row: tuple[int, list[str]]) -> tuple[int, str]:
    return row[0], row[1][2]


def _rows(lines: Lines, at: int, line: int, count: str, what: str) -> tuple[Lines, int]:
    n = whole(count, line, f"a number of {what}")
    if n < 0 or at + n > len(lines):
        raise InvalidInput(f"line {line}: {n} {what} are promised, but {len(lines) - at} lines follow")
    return lines[at : at + n], at + n


def _mesh(points: np.ndarray, elements: Lines, markers: list[tuple[str, Lines]]) -> Mesh:
    types, sizes, corners = [], [], []
    for line, words in elements + [row for _, rows in markers for row in rows]:
        number = whole(words[0], line, "a type of element")
        if number == 1:  # a vertex ends a marker for periodic or parallel runs; a Mesh has it too
            size = 1
        elif number in BY_VTK and BY_VTK[number].name in _KINDS:
            size = BY_VTK[number].nodes
        else:
            raise InvalidInput(f"line {line}: {number} is no type of element of SU2")
        if len(words) < 1 + size:
            raise InvalidInput(f"line {line}: an element of type {number} needs {size} points, got {len(words) - 1}")
        types.append(number)
        sizes.append(size)
        corners += [whole(word, line, "the number of a point") for word in words[1 : 1 + size]]
    offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    xyz = points if points.shape[1] == 3 else np.column_stack([points, np.zeros(len(points))])
    cells, origin = cells_by_kind(np.array(types, np.int64), np.array(corners, np.int64), offsets, xyz)
    sets: dict[str, list[int]] = {}
    begin = len(elements)
    for name, rows in markers:
        sets.setdefault(name, []).extend(np.flatnonzero((origin >= begin) & (origin < begin + len(rows))).tolist())
        begin += len(rows)
    return Mesh(xyz, cells, sets={name: np.array(members, np.int64) for name, members in sets.items()})


def write_su2(path: Path, mesh: Mesh) -> None:
    """Cells of the highest dimension as the domain, those one lower as markers."""
    dimension = mesh.dimension
    flat = dimension < 3 and mesh.is_planar
    if dimension not in (2, 3) or (dimension == 2 and not flat):
        raise InvalidInput("has no domain: SU2 needs triangles or quads with z = 0, or volume cells", parameter="mesh")
    kinds = [(kind, cells, where) for kind, cells, where in mesh.blocks()]
    if low := [kind for kind, _, _ in kinds if CELL_TYPES[kind].dimension < dimension - 1]:
        raise InvalidInput(f"has {low[0]} cells, which are no boundary of the domain", parameter="mesh")
    rows: list[str] = [""] * mesh.n_cells
    is_domain = np.zeros(mesh.n_cells, bool)
    for kind, cells, where in kinds:
        is_domain[where] = CELL_TYPES[kind].dimension == dimension
        text = str(CELL_TYPES[kind].vtk)
        rows[where] = [" ".join([text, *map(str, nodes)]) for nodes in cells.tolist()]
    domain = np.flatnonzero(is_domain).tolist()
    lines = [f"NDIME= {2 if flat else 3}", f"NELEM= {len(domain)}"]
    lines += [f"{rows[k]} {n}" for n, k in enumerate(domain)]
    lines.append(f"NPOIN= {mesh.n_points}")
    columns = mesh.points[:, :2] if flat else mesh.points
    lines += [" ".join([*map(exact, p), str(k)]) for k, p in enumerate(columns.tolist())]
    markers = _markers(mesh, is_domain)
    lines.append(f"NMARK= {len(markers)}")
    for name, members in markers.items():
        lines += [f"MARKER_TAG= {name}", f"MARKER_ELEMS= {len(members)}", *(rows[k] for k in members)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _markers(mesh: Mesh, is_domain: np.ndarray) -> dict[str, list[int]]:
    """Each boundary cell in one marker."""
    free, markers, dropped = ~is_domain, {}, []
    for name, members in mesh.sets.items():
        if is_domain[members].any() or not free[members].all():
            dropped.append(name)
            continue
        markers[_tag(name, markers)] = np.unique(members).tolist()
        free[members] = False
    warn_dropped("sets", dropped, "a marker of SU2 holds boundary cells that no other marker has")
    if free.any():
        markers[_tag(_UNNAMED, markers)] = np.flatnonzero(free).tolist()
    return markers


def _tag(name: str, taken: Collection[str]) -> str:
    """A name that SU2's mesh and configuration files hold, and that is not taken."""
    tag = plain = re.sub(r"[^\w.+-]+", "_", name.strip()) or _UNNAMED
    number = 1
    while tag in taken:
        number += 1
        tag = f"{plain}_{number}"
    return tag


register(
    "SU2",
    (".su2",),
    "planar and volume meshes; sets of boundary cells, and named sides of structured grids, are markers",
    Holds(cells=_KINDS, sets=True, sides=True),
    read=read_su2,
    write=write_su2,
)
