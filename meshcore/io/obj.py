"""Wavefront OBJ: points, lines and faces; groups (g) and objects (o) are sets.

Texture coordinates, normals and materials are not read. A set's name with blanks is written with %20.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import quote, unquote

import numpy as np

from ..errors import InvalidInput
from ..mesh import Mesh, PolyhedralMesh
from .content import text_of
from .fit import SURFACE_CELLS, Holds, warn_dropped
from .lines import Lines, rows_of
from .polyhedra import corner_tables
from .ragged import POLY_LINE, POLY_VERTEX, POLYGON, cells_by_kind
from .registry import register

_ELEMENTS = {"p": (POLY_VERTEX, 1), "l": (POLY_LINE, 2), "f": (POLYGON, 3)}
_GROUPS = ("o", "g")
_BEYOND_POINT = re.compile(r"/\S*")  # numbers of a corner's texture and normal


def read_obj(path: Path) -> Mesh:
    """Points and cells of all objects and groups together, each of these a set."""
    lines = Lines.of(text_of(path).replace("\\\n", " "))
    keys = [text.split(None, 1)[0] for text in lines.texts]
    place: dict[str, list[int]] = {}
    for k, key in enumerate(keys):
        place.setdefault(key, []).append(k)
    if "v" not in place:
        raise InvalidInput("it holds no points (lines that begin with v)")
    points = np.array(place["v"])
    xyz = lines[points].table(3, "a point", first=1)
    cells = np.sort(np.array([k for key in _ELEMENTS for k in place.get(key, [])], np.int64))
    types, corners, offsets = _listed(lines[cells], [keys[k] for k in cells.tolist()], np.searchsorted(points, cells))
    kinds, origin = cells_by_kind(types, corners, offsets, xyz)
    named = sorted(k for key in _GROUPS for k in place.get(key, []))
    groups = _groups([lines[k] for k in named], np.searchsorted(cells, np.array(named, np.int64)), len(cells))
    return Mesh(xyz, kinds, sets={name: np.flatnonzero(np.isin(origin, members)) for name, members in groups.items()})


def _listed(lines: Lines, keys: list[str], known: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Types of elements, and their points from 0; ``known`` points stand before each in the file."""
    texts = [_BEYOND_POINT.sub("", text) if "/" in text else text for text in lines.texts]
    sizes = np.fromiter((len(text.split()) - 1 for text in texts), np.int64, len(texts))
    types, least = np.array([_ELEMENTS[key] for key in keys], np.int64).reshape(-1, 2).T
    if (sizes < least).any():
        bad = int(np.argmax(sizes < least))
        raise InvalidInput(
            f"line {lines.numbers[bad]}: {keys[bad]} needs at least {least[bad]} points, got {sizes[bad]}"
        )
    corners, offsets = Lines(texts, lines.numbers).ragged(sizes, "an element", first=1)
    # The file counts from 1, or from the last point backwards.
    row = np.repeat(np.arange(len(sizes)), sizes)
    at = np.where(corners > 0, corners - 1, known[row] + corners)
    if (wrong := (corners == 0) | (at < 0)).any():
        bad = int(np.argmax(wrong))
        line = lines.numbers[row[bad]]
        raise InvalidInput(f"line {line}: {corners[bad]} refers to no point; {known[row[bad]]} stand before it")
    return types, at, offsets


def _groups(lines: list[tuple[int, list[str]]], first: np.ndarray, count: int) -> dict[str, np.ndarray]:
    """Elements by the names of objects and groups; ``first`` are those that come behind each line that names some."""
    current: dict[str, list[str]] = {key: [] for key in _GROUPS}
    groups: dict[str, list[np.ndarray]] = {}
    for (_, (key, *words)), begin, end in zip(lines, first.tolist(), [*first[1:].tolist(), count], strict=False):
        names = [unquote(" ".join(words))] if key == "o" else [unquote(word) for word in words]
        current[key] = [name for name in names if name]
        if begin < end:
            for name in dict.fromkeys(current["o"] + current["g"]):
                groups.setdefault(name, []).append(np.arange(begin, end))
    return {name: np.concatenate(parts) for name, parts in groups.items()}


def write_obj(path: Path, mesh: Mesh | PolyhedralMesh) -> None:
    """Every digit of the points; a cell may be in several groups."""
    with open(path, "w", encoding="utf-8") as file:
        file.write("# written by meshcore\n" + rows_of(mesh.points, form="v %s %s %s"))
        if isinstance(mesh, PolyhedralMesh):
            for corners in corner_tables(mesh):
                file.write(_elements("f", corners))
        else:
            file.writelines(_grouped_cells(mesh))


def _elements(key: str, corners: np.ndarray) -> str:
    return rows_of(corners + 1, form=" ".join([key, *["%s"] * corners.shape[1]]))


def _grouped_cells(mesh: Mesh) -> Iterator[str]:
    """Runs of cells in the same groups, each behind a line that names these where they change."""
    warn_dropped("sets", [name for name, members in mesh.sets.items() if not len(members)], "OBJ has no empty groups")
    inside: dict[int, list[str]] = {}
    for name, members in mesh.sets.items():
        for k in np.unique(members).tolist():
            inside.setdefault(k, []).append(quote(name, safe="/:+,()=&"))
    current: list[str] = []
    for kind, cells, where in mesh.blocks():
        key = {"vertex": "p", "line": "l"}.get(kind, "f")
        groups = [inside.get(k, []) for k in range(where.start, where.stop)]
        begin = 0
        for names, run in itertools.groupby(groups):
            if names != current:
                current = names
                yield " ".join(["g", *names]) + "\n"
            end = begin + len(list(run))
            yield _elements(key, cells[begin:end])
            begin = end


register(
    "Wavefront OBJ",
    (".obj",),
    "surfaces and curves; groups are sets",
    Holds(cells=SURFACE_CELLS, polygons=True, sets=True),
    read=read_obj,
    write=write_obj,
)
