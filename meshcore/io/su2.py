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
from ..mesh import CELL_TYPES, Mesh
from .content import text_of, whole
from .fit import Holds, warn_dropped
from .lines import Lines, rows_of
from .ragged import cells_by_kind
from .registry import register

_KINDS = ("line", "triangle", "quad", "tetra", "hexahedron", "wedge", "pyramid")
_SIZES = {1: 1, **{CELL_TYPES[kind].vtk: CELL_TYPES[kind].nodes for kind in _KINDS}}
"""Points of each type of element; a vertex, type 1, ends a marker for periodic or parallel runs, and a Mesh has it."""
_UNNAMED = "unnamed"


def read_su2(path: Path) -> Mesh:
    """Domain and markers."""
    lines = Lines.of(text_of(path).replace("=", " = "), comment="%")
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
            found, at = _rows(lines, at + 1, *_count(lines[at]), "elements of a marker")
            markers.append((name, found))
            while at < len(lines) and lines[at][1][0].upper() == "SEND_TO":
                at += 1
    if not dimension or elements is None or points is None:
        raise InvalidInput("it lacks NDIME=, NELEM= or NPOIN=")
    return _mesh(points.table(dimension, "a point"), elements, markers)


def _count(row: tuple[int, list[str]]) -> tuple[int, str]:
    return row[0], row[1][2]


def _rows(lines: Lines, at: int, line: int, count: str, what: str) -> tuple[Lines, int]:
    n = whole(count, line, f"a number of {what}")
    if n < 0 or at + n > len(lines):
        raise InvalidInput(f"line {line}: {n} {what} are promised, but {len(lines) - at} lines follow")
    return lines[at : at + n], at + n


def _mesh(points: np.ndarray, elements: Lines, markers: list[tuple[str, Lines]]) -> Mesh:
    parts = [_elements(part) for part in (elements, *(part for _, part in markers))]
    types, corners = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    offsets = np.concatenate([[0], np.cumsum(_size_of(types))]).astype(np.int64)
    xyz = points if points.shape[1] == 3 else np.column_stack([points, np.zeros(len(points))])
    cells, origin = cells_by_kind(types, corners, offsets, xyz)
    sets: dict[str, list[np.ndarray]] = {}
    begin = len(elements)
    for name, part in markers:
        members = np.flatnonzero((origin >= begin) & (origin < begin + len(part)))
        sets.setdefault(name, []).append(members)
        begin += len(part)
    return Mesh(xyz, cells, sets={name: np.concatenate(members) for name, members in sets.items()})


def _elements(lines: Lines) -> tuple[np.ndarray, np.ndarray]:
    """VTK's types of elements, which are SU2's too, and the points of one after the other."""
    types = lines.whole(1, "an element")[:, 0]
    known = np.isin(types, list(_SIZES))
    if not known.all():
        odd = int(np.argmin(known))
        raise InvalidInput(f"line {lines.numbers[odd]}: {types[odd]} is no type of element of SU2")
    return types, lines.ragged(_size_of(types), "an element", first=1)[0]


def _size_of(types: np.ndarray) -> np.ndarray:
    sizes = np.zeros(max(_SIZES) + 1, np.int64)
    sizes[list(_SIZES)] = list(_SIZES.values())
    return sizes[types]


def write_su2(path: Path, mesh: Mesh) -> None:
    """Cells of the highest dimension as the domain, those one lower as markers."""
    dimension = mesh.dimension
    flat = dimension < 3 and mesh.is_planar
    if dimension not in (2, 3) or (dimension == 2 and not flat):
        raise InvalidInput("has no domain: SU2 needs triangles or quads with z = 0, or volume cells", parameter="mesh")
    if low := [kind for kind in mesh.cells if CELL_TYPES[kind].dimension < dimension - 1]:
        raise InvalidInput(f"has {low[0]} cells, which are no boundary of the domain", parameter="mesh")
    is_domain = np.concatenate(
        [np.full(len(cells), CELL_TYPES[kind].dimension == dimension) for kind, cells, _ in mesh.blocks()]
    )
    number = np.cumsum(is_domain) - 1
    columns = mesh.points[:, :2] if flat else mesh.points
    markers = _markers(mesh, is_domain)
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"NDIME= {2 if flat else 3}\nNELEM= {is_domain.sum()}\n")
        for kind, cells, where in mesh.blocks():
            if CELL_TYPES[kind].dimension == dimension:
                file.write(rows_of(np.full(len(cells), CELL_TYPES[kind].vtk), cells, number[where]))
        file.write(f"NPOIN= {mesh.n_points}\n")
        file.write(rows_of(columns, np.arange(mesh.n_points)))
        file.write(f"NMARK= {len(markers)}\n")
        for name, members in markers.items():
            file.write(f"MARKER_TAG= {name}\nMARKER_ELEMS= {len(members)}\n")
            for kind, cells, where in mesh.blocks():
                some = cells[members[(members >= where.start) & (members < where.stop)] - where.start]
                file.write(rows_of(np.full(len(some), CELL_TYPES[kind].vtk), some))


def _markers(mesh: Mesh, is_domain: np.ndarray) -> dict[str, np.ndarray]:
    """Each boundary cell in one marker."""
    free, markers, dropped = ~is_domain, {}, []
    for name, members in mesh.sets.items():
        if is_domain[members].any() or not free[members].all():
            dropped.append(name)
            continue
        markers[_tag(name, markers)] = np.unique(members)
        free[members] = False
    warn_dropped("sets", dropped, "a marker of SU2 holds boundary cells that no other marker has")
    if free.any():
        markers[_tag(_UNNAMED, markers)] = np.flatnonzero(free)
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
