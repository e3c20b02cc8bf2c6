"""Object File Format (.off): points and faces; colours and normals are not read."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ..errors import InvalidInput
from ..mesh import Mesh, PolyhedralMesh
from .content import text_of, whole
from .fit import Holds
from .lines import Lines, rows_of
from .polyhedra import corner_tables
from .ragged import LINE, POLYGON, VERTEX, cells_by_kind
from .registry import register


def read_off(path: Path) -> Mesh:
    """Faces of any number of corners; those of one and two corners are vertices and lines."""
    lines = Lines.of(text_of(path))
    first, words = lines[0]
    if not re.fullmatch(r"(ST)?C?N?OFF", words[0]):
        raise InvalidInput(f"line {first}: it begins with {words[0]!r}, OFF was expected")
    counts, at = words[1:], 1
    if not counts and len(lines) > 1:
        (first, counts), at = lines[1], 2
    if len(counts) < 2:
        raise InvalidInput(f"line {first}: the numbers of points and faces were expected")
    n_points, n_faces = (whole(word, first, "a count") for word in counts[:2])
    if min(n_points, n_faces) < 0 or len(lines) < at + n_points + n_faces:
        raise InvalidInput(
            f"line {first}: {n_points} points and {n_faces} faces are promised, but {len(lines) - at} lines follow"
        )
    points = lines[at : at + n_points].table(3, "a point")
    faces = lines[at + n_points : at + n_points + n_faces]
    sizes = faces.whole(1, "a face")[:, 0]
    if (sizes < 1).any():
        bad = int(np.argmax(sizes < 1))
        raise InvalidInput(f"line {faces.numbers[bad]}: a face has {sizes[bad]} corners")
    corners, offsets = faces.ragged(sizes, "a face", first=1)
    types = np.where(sizes == 1, VERTEX, np.where(sizes == 2, LINE, POLYGON))
    cells, _ = cells_by_kind(types, corners, offsets, points)
    return Mesh(points, cells)


def write_off(path: Path, mesh: Mesh | PolyhedralMesh) -> None:
    """Every digit of the points."""
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"OFF\n{mesh.n_points} {mesh.n_cells} 0\n{rows_of(mesh.points)}")
        for faces in corner_tables(mesh):
            file.write(rows_of(np.full(len(faces), faces.shape[1]), faces))


register(
    "OFF",
    (".off",),
    "surfaces",
    Holds(cells=("triangle", "quad"), polygons=True),
    read=read_off,
    write=write_off,
)
