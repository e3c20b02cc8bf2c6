"""Gmsh's .msh: versions 2.2 and 4.1, text and binary, read; 2.2 written. Physical groups with names are sets.

Groups without names are ``cell_data["tag"]``. Data are double precision in the file, so whole numbers come back as
such; points or cells without a value get nan. meshio stops at element data over several kinds of cell and ends at the
first fault without a word of where, so the few sections that matter are read here.

References
----------
https://gmsh.info/doc/texinfo/gmsh.html#MSH-file-format
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..errors import InvalidInput
from ..mesh import CELL_TYPES, Mesh
from .fit import Holds
from .gmsh_writer import KINDS, node_order, write_msh
from .registry import register

_AHEAD = 4096  # elements that are looked at together, so that kinds that alternate do not cost the square of them


@dataclass
class _Found:
    """What the sections hold, points and cells still by their tags."""

    points: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))
    point_tags: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))
    blocks: list[tuple[str, np.ndarray, np.ndarray, np.ndarray]] = field(
        default_factory=list
    )  # kind, tags, group, rows
    names: dict[tuple[int, int], str] = field(default_factory=dict)
    entities: dict[tuple[int, int], int] = field(default_factory=dict)
    data: dict[str, list[tuple[str, np.ndarray, np.ndarray]]] = field(default_factory=dict)


class _Stream:
    """The numbers of one section, whether text or bytes."""

    def __init__(self, body: bytes, order: str, section: str):
        self.order, self.section, self.at = order, section, 0
        self.body = body if order else b""
        self.words = [] if order else body.decode("latin-1").split()

    def take(self, count: int, kind: str) -> np.ndarray:
        size = np.dtype(kind).itemsize
        held = (len(self.body) - self.at) // size if self.order else len(self.words) - self.at
        if count < 0 or count > held:
            raise InvalidInput(f"${self.section} promises {count} more values, but holds {max(held, 0)}")
        begin = self.at
        self.at += count * size if self.order else count
        if self.order:
            values = np.frombuffer(self.body, self.order + kind, count, begin)
        else:
            try:
                values = np.array(self.words[begin : self.at], float if kind == "f8" else np.int64)
            except (ValueError, OverflowError):
                raise InvalidInput(f"${self.section} holds words where numbers were expected") from None
        return values.astype(float if kind == "f8" else np.int64)

    def one(self, kind: str) -> int:
        return int(self.take(1, kind)[0])


def read_msh(path: Path) -> Mesh:
    """Any mesh; parametric coordinates, periodicity and partitions are not read."""
    data = path.read_bytes()
    head = re.match(
        rb"\s*(?:\$Comments.*?\$EndComments\s*)?\$MeshFormat\s+(\S+)\s+([01])\s+(\d+)[ \t]*\r?\n", data, re.S
    )
    if not head:
        raise InvalidInput("it does not begin with $MeshFormat")
    version = head.group(1).decode("latin-1")
    if version not in ("2", "2.0", "2.1", "2.2", "4.1"):
        raise InvalidInput(f"its version is {version[:20]}; let Gmsh save it as 2.2 or 4.1")
    order = ""
    if head.group(2) == b"1":
        order = "<" if data[head.end() : head.end() + 4] == b"\1\0\0\0" else ">"
    found = _Found()
    readers = _VERSION_4 if version == "4.1" else _VERSION_2
    for name, body in _sections(data, head.end()):
        if name == "PhysicalNames":
            found.names = _physical_names(body)
        elif name in readers:
            readers[name](_Stream(body, order, name), found)
        elif name in ("NodeData", "ElementData"):
            found.data.setdefault(name, []).append(_read_data(body, order, name))
    return _mesh(found)


def _sections(data: bytes, at: int) -> list[tuple[str, bytes]]:
    """Sections in order; one without its end means that the file is cut off."""
    found = []
    at = data.find(b"$EndMeshFormat", at) + len(b"$EndMeshFormat")
    if at < len(b"$EndMeshFormat"):
        raise InvalidInput("$MeshFormat has no end")
    while (start := data.find(b"$", at)) >= 0:
        line = re.match(rb"\$(\w+)[ \t]*\r?\n?", data[start : start + 80])
        if not line:
            raise InvalidInput(f"byte {start}: a section was expected")
        name = line.group(1).decode()
        end = data.find(b"$End" + line.group(1), start)
        if end < 0:
            raise InvalidInput(f"the section ${name} has no end, so the file is cut off")
        found.append((name, data[start + line.end() : end]))
        at = end + len(name) + 4
    if {"Nodes", "Elements"} - {name for name, _ in found}:
        raise InvalidInput("it lacks $Nodes or $Elements")
    return found


def _physical_names(body: bytes) -> dict[tuple[int, int], str]:
    rows = re.findall(r'^\s*(\d)\s+(-?\d{1,18})\s+"(.*)"\s*$', body.decode("utf-8", errors="replace"), re.M)
    return {(int(dimension), int(tag)): name for dimension, tag, name in rows}


def _kind(number: int) -> str:
    if number not in KINDS:
        raise InvalidInput(f"it has elements of Gmsh's type {number}, which a Mesh does not hold")
    return KINDS[number]


# ---- version 2


def _nodes_2(stream: _Stream, found: _Found) -> None:
    n = _count(stream)
    if not stream.order:
        rows = stream.take(4 * n, "f8").reshape(n, 4)
        found.point_tags, found.points = rows[:, 0].astype(np.int64), rows[:, 1:]
        return
    rows = _records(stream, n, [("tag", "i4"), ("x", "f8", 3)])
    found.point_tags, found.points = rows["tag"].astype(np.int64), rows["x"].astype(float)


def _count(stream: _Stream) -> int:
    """The count on a section's first line, which is text in binary files too."""
    if not stream.order:
        return stream.one("i8")
    line = re.match(rb"\s*(\d{1,18})[ \t]*\r?\n", stream.body)
    if not line:
        raise InvalidInput(f"${stream.section} does not begin with a count")
    stream.at = line.end()
    return int(line.group(1))


def _records(stream: _Stream, n: int, fields: list[tuple]) -> np.ndarray:
    row = np.dtype(fields).newbyteorder(stream.order)
    if stream.at + n * row.itemsize > len(stream.body):
        raise InvalidInput(f"${stream.section} promises {n} rows, but ends before")
    rows = np.frombuffer(stream.body, row, n, stream.at)
    stream.at += n * row.itemsize
    return rows


def _elements_2(stream: _Stream, found: _Found) -> None:
    n = _count(stream)
    if stream.order:
        while n > 0:
            number, some, tags = stream.take(3, "i4").tolist()
            kind = _kind(number)
            if not 0 < some <= n or tags < 0:
                raise InvalidInput("$Elements counts its blocks wrongly")
            width = 1 + tags + CELL_TYPES[kind].nodes
            rows = stream.take(some * width, "i4").reshape(some, width)
            group = rows[:, 1] if tags else np.zeros(some, np.int64)
            found.blocks.append((kind, rows[:, 0], group, rows[:, 1 + tags :]))
            n -= some
        return
    numbers = stream.take(len(stream.words) - 1, "i8")
    while n > 0:  # runs of elements of one kind with as many tags, which are written alike
        _, number, tags = numbers[:3].tolist() if len(numbers) > 2 else (0, 0, 0)
        kind = _kind(number)
        width = 3 + max(tags, 0) + CELL_TYPES[kind].nodes
        ahead = min(n, _AHEAD, len(numbers) // width)
        if not ahead or tags < 0:
            raise InvalidInput("$Elements ends within an element, or counts its tags wrongly")
        table = numbers[: ahead * width].reshape(ahead, width)
        other = (table[:, 1] != number) | (table[:, 2] != tags)
        table = table[: int(np.argmax(other)) if other.any() else ahead]
        group = table[:, 3] if tags else np.zeros(len(table), np.int64)
        found.blocks.append((kind, table[:, 0], group, table[:, 3 + tags :]))
        numbers, n = numbers[table.size :], n - len(table)


# ---- version 4.1


def _entities_4(stream: _Stream, found: _Found) -> None:
    counts = stream.take(4, "u8").tolist()
    for dimension, count in enumerate(counts):
        if count > max(len(stream.body), len(stream.words)):
            raise InvalidInput(f"$Entities promises {count} of dimension {dimension}")
        for _ in range(count):
            tag = stream.one("i4")
            stream.take(6 if dimension else 3, "f8")
            groups = stream.take(stream.one("u8"), "i4")
            if len(groups):
                found.entities[dimension, tag] = abs(int(groups[0]))
            if dimension:
                stream.take(stream.one("u8"), "i4")


def _nodes_4(stream: _Stream, found: _Found) -> None:
    blocks, total, _, _ = stream.take(4, "u8").tolist()
    tags, points = [np.empty(0, np.int64)], [np.empty((0, 3))]
    for _ in range(min(blocks, max(len(stream.body), len(stream.words)))):
        dimension, _, parametric = stream.take(3, "i4").tolist()
        n = stream.one("u8")
        tags.append(stream.take(n, "u8"))
        width = 3 + (max(dimension, 0) if parametric else 0)
        points.append(stream.take(width * n, "f8").reshape(n, width)[:, :3])
    found.point_tags, found.points = np.concatenate(tags), np.concatenate(points)
    if len(found.points) != total:
        raise InvalidInput(f"$Nodes promises {total} points, but holds {len(found.points)}")


def _elements_4(stream: _Stream, found: _Found) -> None:
    blocks, total, _, _ = stream.take(4, "u8").tolist()
    held = 0
    for _ in range(min(blocks, max(len(stream.body), len(stream.words)))):
        dimension, entity, number = stream.take(3, "i4").tolist()
        kind, n = _kind(number), stream.one("u8")
        width = 1 + CELL_TYPES[kind].nodes
        rows = stream.take(width * n, "u8").reshape(n, width)
        group = np.full(n, found.entities.get((dimension, entity), 0))
        found.blocks.append((kind, rows[:, 0], group, rows[:, 1:]))
        held += n
    if held != total:
        raise InvalidInput(f"$Elements promises {total} cells, but holds {held}")


_VERSION_2 = {"Nodes": _nodes_2, "Elements": _elements_2}
_VERSION_4 = {"Entities": _entities_4, "Nodes": _nodes_4, "Elements": _elements_4}


# ---- both


def _read_data(body: bytes, order: str, section: str) -> tuple[str, np.ndarray, np.ndarray]:
    """Name, tags and values of one $NodeData or $ElementData."""
    at, heads = 0, []
    for _ in range(3):  # text tags, real tags, whole-number tags, each after their count
        line, at = _line(body, at, section)
        try:
            count = int(line)
        except ValueError:
            raise InvalidInput(f"${section}: {line[:40]!r} is no count") from None
        if not 0 <= count <= len(body):
            raise InvalidInput(f"${section} promises {count} tags")
        rows = []
        for _ in range(count):
            line, at = _line(body, at, section)
            rows.append(line)
        heads.append(rows)
    try:
        columns, n = int(heads[2][1]), int(heads[2][2])
    except (ValueError, IndexError):
        raise InvalidInput(f"${section} lacks its numbers of components and values") from None
    if columns < 1 or n < 0 or columns * n > len(body):
        raise InvalidInput(f"${section} promises {n} rows of {columns}, more than it holds")
    stream = _Stream(body[at:], order, section)
    name = heads[0][0].strip().strip('"') if heads[0] else section
    if order:
        rows = _records(stream, n, [("tag", "i4"), ("value", "f8", (columns,))])
        return name, rows["tag"].astype(np.int64), rows["value"].astype(float)
    table = stream.take(n * (1 + columns), "f8").reshape(n, 1 + columns)
    return name, table[:, 0].astype(np.int64), table[:, 1:]


def _line(body: bytes, at: int, section: str) -> tuple[str, int]:
    end = body.find(b"\n", at)
    if end < 0:
        raise InvalidInput(f"${section} is cut off")
    return body[at:end].decode("utf-8", errors="replace").strip(), end + 1


def _numbers(tags: np.ndarray, wanted: np.ndarray, what: str) -> np.ndarray:
    """Where each wanted tag stands among the tags."""
    if not wanted.size:
        return np.zeros(wanted.shape, np.int64)
    if len(tags) and (np.diff(tags) == 1).all():  # as a rule they count up
        found = np.clip(wanted - tags[0], 0, len(tags) - 1)
    else:
        order = np.argsort(tags, kind="stable")
        place = np.minimum(np.searchsorted(tags[order], wanted), max(len(tags) - 1, 0))
        found = order[place] if len(tags) else np.zeros(wanted.shape, np.int64)
    bad = np.argwhere(tags[found] != wanted) if len(tags) else np.argwhere(np.ones(wanted.shape))
    if len(bad):
        raise InvalidInput(f"{what} {wanted[tuple(bad[0])]} is referred to, but is not there")
    return found


def _mesh(found: _Found) -> Mesh:
    kinds = dict.fromkeys(block[0] for block in found.blocks)
    blocks = [block for kind in kinds for block in found.blocks if block[0] == kind]
    cells = {
        kind: _numbers(found.point_tags, np.concatenate([b[3] for b in blocks if b[0] == kind]), "point")[
            :, node_order(kind)
        ]
        for kind in kinds
    }
    empty = np.empty(0, np.int64)
    tags = np.concatenate([empty, *(b[1] for b in blocks)])
    group = np.concatenate([empty, *(b[2] for b in blocks)])
    dimension = np.concatenate([empty, *(np.full(len(b[1]), CELL_TYPES[b[0]].dimension) for b in blocks)])
    sets: dict[str, np.ndarray] = {}
    named = np.zeros(len(group), bool)
    for (d, tag), name in found.names.items():
        inside = (group == tag) & (dimension == d)
        named |= inside
        sets[name] = np.union1d(sets.get(name, empty), np.flatnonzero(inside))
    cell_data = _filled(found.data.get("ElementData", []), tags, "cell")
    if (group[~named] != 0).any():
        cell_data["tag"] = group
    point_data = _filled(found.data.get("NodeData", []), found.point_tags, "point")
    return Mesh(found.points, cells, point_data, cell_data, sets)


def _filled(data: list[tuple[str, np.ndarray, np.ndarray]], tags: np.ndarray, what: str) -> dict[str, np.ndarray]:
    arrays = {}
    for name, at, values in data:
        whole = np.full((len(tags), values.shape[1]), np.nan)
        whole[_numbers(tags, at, what)] = values
        arrays[name] = whole[:, 0] if values.shape[1] == 1 else whole
    return arrays


register(
    "Gmsh mesh",
    (".msh",),
    "any mesh; physical groups are sets; versions 2.2 and 4.1 read, 2.2 written",
    Holds(cells=tuple(KINDS.values()), point_data=True, cell_data=True, sets=True),
    read=read_msh,
    write=write_msh,
)
