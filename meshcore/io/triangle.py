"""Triangle's .poly, .node and .ele: planar boundaries with holes and regions, points, triangulations.

Boundary markers are ``tag``, attributes ``attribute 1``, ``attribute 2``, ... in the data of points and cells; holes
and regions (x, y, attribute, largest area) are ``field_data["holes"]`` (k, 2) and ``["regions"]`` (k, 4).
What the format has no words for, the names of attributes and sets, stands in comments that `read` understands.
A missing largest area reads as -1, Triangle's own sign for none.

References
----------
J. R. Shewchuk, "Triangle: a two-dimensional quality mesh generator", https://www.cs.cmu.edu/~quake/triangle.html
"""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np

from ..errors import InvalidInput
from ..mesh import Mesh
from .content import text_of, whole
from .fit import Holds, columns_of, sets_as_tags
from .lines import Lines, rows_of
from .registry import register

# Triangle's fourth node is opposite the first corner; VTK's is between the first and the second.
_TO_VTK = np.array([0, 1, 2, 5, 3, 4])
_FROM_VTK = np.array([0, 1, 2, 4, 5, 3])


class _Reader:
    """The lines of one file, taken section by section."""

    def __init__(self, path: Path):
        text = text_of(path)
        self.lines = Lines.of(text)
        self.at = 0
        named = re.search(r"^# meshcore (\{.*\})$", text, flags=re.MULTILINE)
        self.names: dict[str, list[str]] = _names(named.group(1)) if named else {}

    @property
    def done(self) -> bool:
        return self.at >= len(self.lines)

    def header(self, what: str, least: int) -> list[int]:
        """The whole numbers of a section's first line, filled with zeros to four."""
        if self.done:
            raise InvalidInput(f"the file ends before the {what}")
        line, words = self.lines[self.at]
        self.at += 1
        if len(words) < least:
            raise InvalidInput(f"line {line}: the header of the {what} needs {least} numbers, got {' '.join(words)!r}")
        values = [whole(word, line, f"a count of {what}") for word in words[:4]]
        if min(values) < 0:
            raise InvalidInput(f"line {line}: a count of {what} is negative")
        return values + [0] * (4 - len(values))

    def rows(self, count: int, what: str) -> Lines:
        found = self.lines[self.at : self.at + count]
        if len(found) < count:
            raise InvalidInput(f"{count} {what} are promised, but the file ends after {len(found)}")
        self.at += count
        return found


def _names(text: str) -> dict[str, list[str]]:
    try:
        names = json.loads(text)
    except ValueError:
        return {}
    valid = isinstance(names, dict) and all(isinstance(v, list) for v in names.values())
    return {key: [str(v) for v in values] for key, values in names.items()} if valid else {}


def _column(rows: Lines, k: int, what: str) -> np.ndarray:
    """Column ``k``: whole numbers if all are written so."""
    whole_numbers = rows.whole_or_none(1, first=k)
    return (rows.table(1, what, first=k) if whole_numbers is None else whole_numbers)[:, 0]


def _attributes(rows: Lines, first: int, count: int, names: list[str], what: str) -> dict[str, np.ndarray]:
    longest = max(range(len(rows)), key=lambda k: len(rows.texts[k]))
    line, words = rows[longest]
    if count > len(rows.texts[longest]):
        raise InvalidInput(f"{count} attributes are promised, but line {line}, the longest, has {len(words)} numbers")
    if len(names) != count:
        names = [f"attribute {k + 1}" for k in range(count)]
    return {name: _column(rows, first + k, what) for k, name in enumerate(names)}


def _points(reader: _Reader) -> tuple[np.ndarray, dict[str, np.ndarray], int]:
    """Coordinates, data, and the number of the first point."""
    count, dimension, attributes, markers = reader.header("points", 2)
    if dimension != 2:
        raise InvalidInput(f"the points have {dimension} coordinates; Triangle's have 2 (TetGen's are not read)")
    rows = reader.rows(count, "points")
    if not rows:
        return np.empty((0, 3)), {}, 0
    xy = rows.table(2, "a point, with its number,", first=1)
    number = _column(rows, 0, "a point")
    start = int(number[0] == 1)
    if (number != start + np.arange(count)).any():
        bad = int(np.argmax(number != start + np.arange(count)))
        raise InvalidInput(
            f"line {rows.numbers[bad]}: points are to be numbered in order, from 0 or 1; got {number[bad]}"
        )
    data = _attributes(rows, 3, attributes, reader.names.get("point_data", []), "a point")
    if markers:
        data["tag"] = _column(rows, 3 + attributes, "a point with its marker")
    bad = np.flatnonzero(~np.isfinite(xy).all(axis=1))
    if len(bad):
        raise InvalidInput(f"line {rows.numbers[bad[0]]}: the coordinates are {xy[bad[0]].tolist()}")
    return xy, data, start


def _refer(rows: Lines, columns: int, start: int, n_points: int, what: str) -> np.ndarray:
    """(m, columns) int: points of cells, from 0."""
    nodes = rows.whole(columns, what, first=1) - start
    bad = np.flatnonzero(((nodes < 0) | (nodes >= n_points)).any(axis=1))
    if len(bad):
        raise InvalidInput(
            f"line {rows.numbers[bad[0]]}: {what} refers to points {(nodes[bad[0]] + start).tolist()}, but they go "
            f"from {start} to {n_points - 1 + start}"
        )
    return nodes


def _companion(path: Path, suffix: str) -> Path:
    """The file of the same name with another extension, in lower or upper case."""
    for candidate in (path.with_suffix(suffix), path.with_suffix(suffix.upper())):
        if candidate.exists():
            return candidate
    raise InvalidInput(f"it needs {path.with_suffix(suffix).name} beside it, which is not there")


def read_poly(path: Path) -> Mesh:
    """A planar boundary: line cells, with holes and regions in ``field_data``."""
    reader = _Reader(path)
    points, point_data, start = _points(reader)
    if not len(points):
        nodes = _Reader(_companion(path, ".node"))
        points, point_data, start = _points(nodes)
    count, markers, *_ = reader.header("segments", 1)
    rows = reader.rows(count, "segments")
    lines = _refer(rows, 2, start, len(points), "a segment") if rows else np.empty((0, 2), np.int64)
    cell_data, sets = {}, {}
    if markers:
        tags = _column(rows, 3, "a segment with its marker")
        if names := reader.names.get("sets"):
            sets = {name: np.flatnonzero(tags == k) for k, name in enumerate(names, 1)}
        else:
            cell_data["tag"] = tags
    return Mesh(points, {"line": lines}, point_data, cell_data, sets, _holes_and_regions(reader))


def _holes_and_regions(reader: _Reader) -> dict[str, np.ndarray]:
    found: dict[str, np.ndarray] = {}
    count = 0 if reader.done else reader.header("holes", 1)[0]
    if count:
        rows = reader.rows(count, "holes")
        found["holes"] = rows.table(2, "a hole", first=1)
    count = 0 if reader.done else reader.header("regions", 1)[0]
    if count:
        rows = reader.rows(count, "regions")
        # With one number behind the place, it is the attribute if areas are not asked for: the area is left open.
        texts = [text + " -1" if len(text.split()) == 4 else text for text in rows.texts]
        found["regions"] = Lines(texts, rows.numbers).table(4, "a region", first=1)
    for name, values in found.items():
        if not np.isfinite(values).all():
            raise InvalidInput(f"the {name} have coordinates that are not finite")
    return found


def read_node(path: Path) -> Mesh:
    """Points; with the triangles of the .ele file beside, if there is one."""
    if path.with_suffix(".ele").exists():
        return _triangulation(path, path.with_suffix(".ele"))
    points, data, _ = _points(_Reader(path))
    return Mesh(points, {"vertex": np.arange(len(points))[:, None]}, data)


def read_ele(path: Path) -> Mesh:
    """A triangulation, on the points of the .node file beside."""
    return _triangulation(_companion(path, ".node"), path)


def _triangulation(node: Path, ele: Path) -> Mesh:
    points, point_data, start = _points(_Reader(node))
    reader = _Reader(ele)
    count, corners, attributes, _ = reader.header("triangles", 2)
    if corners not in (3, 6):
        raise InvalidInput(f"{ele.name} has cells of {corners} nodes, triangles of 3 or 6 were expected")
    rows = reader.rows(count, "triangles")
    cells = _refer(rows, corners, start, len(points), "a triangle") if rows else np.empty((0, corners), np.int64)
    kind = "triangle" if corners == 3 else "triangle6"
    if corners == 6:
        cells = cells[:, _TO_VTK]
    names = reader.names.get("cell_data", [])
    data = _attributes(rows, 1 + corners, attributes, names, "a triangle") if rows else {}
    return Mesh(points, {kind: cells}, point_data, data)


def _comment(**names: list[str]) -> str:
    names = {key: values for key, values in names.items() if values}
    return f"# meshcore {json.dumps(names)}\n" if names else ""


def _node_text(mesh: Mesh) -> tuple[str, list[str]]:
    """The section of points, and the names of its attributes."""
    data = columns_of(mesh.point_data, "point data", "Triangle")
    tag = data.get("tag")
    has_marker = tag is not None and tag.dtype.kind in "biu"
    columns = {key: v for key, v in data.items() if key != "tag" or not has_marker}
    ordered = [*columns.values(), *([tag] if has_marker else [])]
    head = f"{mesh.n_points} 2 {len(columns)} {int(has_marker)}\n"
    return head + rows_of(_count(mesh.points), mesh.points[:, :2], *ordered), list(columns)


def _count(values: np.ndarray) -> np.ndarray:
    """Numbers of rows, from 1."""
    return np.arange(len(values)) + 1


def write_poly(path: Path, mesh: Mesh) -> None:
    """Points, segments, holes and regions in one file, counted from 1."""
    nodes, names = _node_text(mesh)
    tags, sets = sets_as_tags(mesh, "Triangle")
    lines, holes, regions = mesh.get("line") + 1, _field(mesh, "holes", 2), _field(mesh, "regions", 4)
    parts = [
        _comment(point_data=names, sets=sets),
        nodes,
        f"{len(lines)} {int(tags is not None)}\n",
        rows_of(_count(lines), lines, *([] if tags is None else [tags])),
        *(f"{len(places)}\n{rows_of(_count(places), places)}" for places in (holes, regions)),
    ]
    path.write_text("".join(parts), encoding="utf-8")


def _field(mesh: Mesh, name: str, columns: int) -> np.ndarray:
    values = np.asarray(mesh.field_data.get(name, np.empty((0, columns))))
    if values.size == 0:
        return np.empty((0, columns))
    if values.ndim != 2 or values.shape[1] != columns:
        raise InvalidInput(f"needs shape (k, {columns}), got {values.shape}", parameter=f"field_data[{name!r}]")
    return values.astype(float)


def write_node(path: Path, mesh: Mesh) -> None:
    """The points alone, counted from 1."""
    nodes, names = _node_text(mesh)
    path.write_text(_comment(point_data=names) + nodes, encoding="utf-8")


def write_ele(path: Path, mesh: Mesh) -> None:
    """The triangles, and their points in a .node file beside."""
    kinds = list(mesh.cells)
    if len(kinds) > 1:
        raise InvalidInput(f"has {' and '.join(kinds)} cells; a .ele file holds one kind", parameter="mesh")
    kind = kinds[0] if kinds else "triangle"
    cells = mesh.get(kind)[:, _FROM_VTK] if kind == "triangle6" else mesh.get(kind)
    data = columns_of(mesh.cell_data, "cell data", "Triangle")
    head = f"{_comment(cell_data=list(data))}{len(cells)} {cells.shape[1]} {len(data)}\n"
    path.write_text(head + rows_of(_count(cells), cells + 1, *data.values()), encoding="utf-8")
    write_node(path.with_suffix(".node"), mesh)


register(
    "Triangle boundary",
    (".poly",),
    "planar lines with markers, holes and regions",
    Holds(
        cells=("line",), point_data=True, cell_data=("tag",), sets=True, field_data=("holes", "regions"), planar=True
    ),
    read=read_poly,
    write=write_poly,
)
register(
    "Triangle mesh",
    (".ele",),
    "planar triangles of 3 or 6 nodes, points in a .node file beside",
    Holds(cells=("triangle", "triangle6"), point_data=True, cell_data=True, planar=True),
    read=read_ele,
    write=write_ele,
)
register(
    "Triangle points",
    (".node",),
    "planar points; read with the .ele file beside if there is one",
    Holds(cells=("vertex",), point_data=True, planar=True),
    read=read_node,
    write=write_node,
)
