"""Object File Format (.off): points and faces; colours and normals are not read."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ..errors import InvalidInput
from ..mesh import Mesh, PolyhedralMesh
from .content import exact, numbered, table, text_of, whole
from .fit import Holds
from .polyhedra import polygon_lists
from .ragged import LINE, POLYGON, VERTEX, cells_by_kind
from .registry import register


def read_off(path: Path) -> Mesh:
    """Faces of any number of corners; those of one and two corners are vertices and lines."""
    lines = numbered(text_of(path))
    first, words = lines[0]
    if not re.fullmatch(r"(ST)?C?N?OFF", words[0]):
        raise InvalidInput(f"line {first}: it begins with {words[0]!r}, OFF was expected")
    lines = ([(first, words[1:])] if len(words) > 1 else []) + lines[1:]
    if not lines or len(lines[0][1]) < 2:
        raise InvalidInput(f"line {first + 1}: the numbers of points and faces were expected")
    line, words = lines[0]
    n_points, n_faces = (whole(word, line, "a count") for word in words[:2])
    if min(n_points, n_faces) < 0 or len(lines) < 1 + n_points + n_faces:
        raise InvalidInput(
            f"line {line}: {n_points} points and {n_faces} faces are promised, but {len(lines) - 1} lines follow"
        )
    points = table(lines[1 : 1 + n_points], 3, "a point")
    sizes, corners = [], []
    for line, words in lines[1 + n_points : 1 + n_points + n_faces]:
        size = whole(words[0], line, "the number of a face's corners")
        if size < 1 or len(words) < 1 + size:
            raise InvalidInput(f"line {line}: a face of {size} corners lists {len(words) - 1}")
        sizes.append(size)
        corners += [whole(word, line, "the number of a point") for word in words[1 : 1 + size]]
    types = [{1: VERTEX, 2: LINE}.get(size, POLYGON) for size in sizes]
    offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    cells, _ = cells_by_kind(np.array(types, np.int64), np.array(corners, np.int64), offsets, points)
    return Mesh(points, cells)


def write_off(path: Path, mesh: Mesh | PolyhedralMesh) -> None:
    """Every digit of the points."""
    lines = ["OFF", f"{mesh.n_points} {mesh.n_cells} 0"]
    lines += [f"{exact(x)} {exact(y)} {exact(z)}" for x, y, z in mesh.points.tolist()]
    if isinstance(mesh, PolyhedralMesh):
        faces = polygon_lists(mesh)
    else:
        faces = [nodes for cells in mesh.cells.values() for nodes in cells.tolist()]
    lines += [" ".join([str(len(nodes)), *map(str, nodes)]) for nodes in faces]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


register(
    "OFF",
    (".off",),
    "surfaces",
    Holds(cells=("triangle", "quad"), polygons=True),
    read=read_off,
    write=write_off,
)
