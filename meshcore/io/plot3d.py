"""PLOT3D grids: text, Fortran's unformatted and plain binary, one block or many, in the plane or in space.

The file does not say which of these it is. Each reading that is possible is tried against the file's length, and the
one that fits to the last byte (or number) is taken. ``iblank`` is kept as point data.

Names of blocks and faces, periodic directions and cuts stand in a neutral map file beside it, `neutral_map`.

References
----------
P. G. Buning and P. P. Walatka, "PLOT3D user's manual", NASA TM-101067 (1990).
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..errors import InvalidInput
from ..mesh import Mesh, MultiBlock, StructuredGrid
from ..mesh.patches import UNNAMED
from .bounded import bounded
from .content import floats, number
from .fit import Holds, warn_dropped
from .lines import rows_of, wrapped
from .neutral_map import SUFFIX, read_map, write_map
from .registry import AnyMesh, register
from .vtk_data import GRID, DataSet, decoded, together

IBLANK = "iblank"
_REPEATED = re.compile(r"(\d+)\*(\S+)")  # Fortran's list-directed output writes 3*0.0
_MOST_BLOCKS = 1_000_000


@dataclass(frozen=True)
class _Layout:
    """How the numbers of a file are to be read."""

    sizes: tuple[tuple[int, ...], ...]  # points along each axis, block by block
    start: int  # where the first block begins
    iblank: bool
    real: str = ""  # type of a coordinate in binary files

    @property
    def dimension(self) -> int:
        return len(self.sizes[0])

    def count(self, k: int) -> int:
        n = 1
        for size in self.sizes[k]:
            n *= size
        return n


def read_plot3d(path: Path) -> AnyMesh:
    """One block as a grid, several as a `MultiBlock`; with names and cuts where a neutral map lies beside the file."""
    data = path.read_bytes()
    blocks = _from_text(data) if _is_text(data) else (_from_records(data) or _from_stream(data))
    if blocks is None:
        raise InvalidInput(
            f"its {len(data)} bytes fit no PLOT3D layout (text, unformatted or plain binary; one or many blocks; plane "
            "or space; with or without iblank), so it is cut off or something else"
        )
    grids = {f"block {k}": decoded(block) for k, block in enumerate(blocks)}
    plain = next(iter(grids.values())) if len(grids) == 1 else together(grids)
    beside = path.with_suffix(SUFFIX)
    if isinstance(plain, Mesh) or not beside.is_file():
        return plain
    blocks = list(grids.values())
    try:
        names, patches, cuts = read_map(beside, [block.shape for block in blocks])
    except (InvalidInput, OSError) as error:
        warn_dropped("the neutral map", [beside.name], f"it does not fit: {error}")
        return plain
    named = [replace(patch, name="") if patch.name == UNNAMED else patch for patch in patches]
    return bounded(blocks, names, named, cuts)


def _is_text(data: bytes) -> bool:
    return not set(data[:4096]) - set(b"0123456789+-.eEdD*, \t\r\n")


def _data_set(sizes: tuple[int, ...], values: list[np.ndarray], iblank: np.ndarray | None) -> DataSet:
    """One block of its coordinates, i running fastest."""
    xyz = [np.asarray(v, float) for v in values] + [np.zeros(len(values[0]))] * (3 - len(values))
    points = np.column_stack(xyz)
    if not np.isfinite(points).all():
        raise InvalidInput(f"point {np.flatnonzero(~np.isfinite(points).all(axis=1))[0]} of a block is not finite")
    ni, nj, nk = (*sizes, 1)[:3]
    point_data = {} if iblank is None else {IBLANK: iblank.astype(np.int64)}
    return DataSet(GRID, points, dimensions=(ni, nj, nk), point_data=point_data)


# ---- text


def _from_text(data: bytes) -> list[DataSet]:
    words = data.decode("ascii", errors="replace").replace(",", " ").split()
    if b"*" in data:
        words = _repeated(words, 64 * len(data))
    heading = [int(word) if word.lstrip("+").isdigit() and len(word) < 12 else -1 for word in words[:64]]
    heading += [-1] * (64 - len(heading))
    if 64 < 1 + 3 * max(heading[0], 0) <= len(words):
        heading = [int(word) if word.lstrip("+").isdigit() and len(word) < 12 else -1 for word in words]
    for sizes, start in _headings(heading):
        for iblank in (False, True):
            layout = _Layout(sizes, start, iblank)
            width = layout.dimension + iblank
            if start + width * sum(layout.count(k) for k in range(len(sizes))) == len(words):
                return _text_blocks(words, layout)
    raise InvalidInput(
        f"its {len(words)} numbers fit no PLOT3D layout; the first are {' '.join(words[:6])}"
        + ("" if all(number(w) is not None for w in words[:6]) else ", not all of them numbers")
    )


def _repeated(words: list[str], most: int) -> list[str]:
    """Words with those such as 3*0.0 written out."""
    found: list[str] = []
    for word in words:
        repeated = _REPEATED.fullmatch(word) if "*" in word else None
        if not repeated:
            found.append(word)
        elif int(repeated.group(1)) > most:
            raise InvalidInput(f"{word!r} repeats a number more often than a file of this length can mean")
        else:
            found += [repeated.group(2)] * int(repeated.group(1))
    return found


def _text_blocks(words: list[str], layout: _Layout) -> list[DataSet]:
    blocks, at = [], layout.start
    for k, sizes in enumerate(layout.sizes):
        n = layout.count(k)
        values = []
        for _ in range(layout.dimension + layout.iblank):
            try:
                values.append(np.array(words[at : at + n], float))
            except ValueError:
                values.append(np.array(floats(words[at : at + n], 0)))
            at += n
        iblank = values.pop() if layout.iblank else None
        blocks.append(_data_set(sizes, values, iblank))
    return blocks


def _headings(numbers: list[int]) -> Iterator[tuple[tuple[tuple[int, ...], ...], int]]:
    """Sizes of blocks that a file's first whole numbers may mean, and how many numbers that takes."""
    for many, dimension in itertools.product((True, False), (3, 2)):
        count = numbers[0] if many else 1
        stop = many + count * dimension
        if not 0 < count <= _MOST_BLOCKS or stop > len(numbers):
            continue
        flat = numbers[int(many) : stop]
        if min(flat) < 1:
            continue
        yield tuple(tuple(flat[k : k + dimension]) for k in range(0, len(flat), dimension)), stop


# ---- Fortran's unformatted files: each record stands between two copies of its length


def _from_records(data: bytes) -> list[DataSet] | None:
    for order, width in itertools.product("<>", (4, 8)):
        records = _records(data, np.dtype(f"{order}i{width}"))
        if records and (blocks := _record_blocks(records, order)):
            return blocks
    return None


def _records(data: bytes, marker: np.dtype) -> list[bytes] | None:
    found, at, width = [], 0, marker.itemsize
    while at < len(data):
        if at + width > len(data):
            return None
        size = int(np.frombuffer(data, marker, 1, at)[0])
        end = at + width + size
        if size < 0 or end + width > len(data) or data[at : at + width] != data[end : end + width]:
            return None
        found.append(data[at + width : end])
        at = end + width
    return found


def _record_blocks(records: list[bytes], order: str) -> list[DataSet] | None:
    many = len(records[0]) == 4
    heading = records[0] + records[1] if many and len(records) > 1 else records[0]
    if len(heading) % 4:
        return None
    numbers = np.frombuffer(heading, order + "i4").tolist()
    for sizes, stop in _headings(numbers):
        if stop != len(numbers) or len(records) != 1 + many + len(sizes):
            continue
        for real, iblank in itertools.product(("f8", "f4"), (False, True)):
            layout = _Layout(sizes, 0, iblank, order + real)
            width = layout.dimension * int(real[1]) + 4 * iblank
            parts = records[1 + many :]
            if all(len(part) == width * layout.count(k) for k, part in enumerate(parts)):
                return [_binary_block(part, 0, layout, k)[0] for k, part in enumerate(parts)]
    return None


def _binary_block(data: bytes, at: int, layout: _Layout, k: int) -> tuple[DataSet, int]:
    """Block ``k``, and where the next one begins."""
    real, n = np.dtype(layout.real), layout.count(k)
    values = []
    for _ in range(layout.dimension):
        values.append(np.frombuffer(data, real, n, at))
        at += n * real.itemsize
    iblank = None
    if layout.iblank:
        iblank = np.frombuffer(data, layout.real[0] + "i4", n, at)
        at += 4 * n
    return _data_set(layout.sizes[k], values, iblank), at


# ---- plain binary files


def _from_stream(data: bytes) -> list[DataSet] | None:
    for order in "<>":
        first = np.frombuffer(data[:4], order + "i4") if len(data) >= 12 else np.zeros(1)
        longest = min(len(data) // 4, max(4, 1 + 3 * int(first[0])))
        numbers = np.frombuffer(data, order + "i4", longest).tolist() if 0 < first[0] <= _MOST_BLOCKS else []
        for sizes, stop in _headings(numbers) if numbers else ():
            for real, iblank in itertools.product(("f8", "f4"), (False, True)):
                layout = _Layout(sizes, 4 * stop, iblank, order + real)
                width = layout.dimension * int(real[1]) + 4 * iblank
                total = layout.start + width * sum(layout.count(k) for k in range(len(sizes)))
                if total == len(data) and (blocks := _plausible_blocks(data, layout)):
                    return blocks
    return None


def _plausible_blocks(data: bytes, layout: _Layout) -> list[DataSet] | None:
    """The blocks, unless their numbers look like another type's bytes."""
    blocks, at = [], layout.start
    for k in range(len(layout.sizes)):
        n, real = layout.count(k), np.dtype(layout.real)
        values = np.frombuffer(data, real, n * layout.dimension, at)
        size = np.abs(values[(values != 0) & np.isfinite(values)])
        if size.size and (size.max() > 1e30 or np.median(size) < 1e-30):
            return None
        block, at = _binary_block(data, at, layout, k)
        blocks.append(block)
    return blocks


# ---- writing


def write_plot3d(
    path: Path,
    grid: StructuredGrid | MultiBlock,
    *,
    binary: bool = True,
    record_markers: bool = True,
    planar: bool = False,
    boundaries: bool = True,
) -> None:
    """Double precision; one grid without a number of blocks, several with it.

    Parameters
    ----------
    path : Path
        The file to write.
    grid : StructuredGrid or MultiBlock
        One grid, or several.
    binary : bool
        Binary, or text with every digit.
    record_markers : bool
        Fortran's unformatted records, or plain binary.
    planar : bool
        Two sizes and coordinates a block; the grids must be surfaces with z = 0.
    boundaries : bool
        Also write the neutral map file, of the same name with ".nmf".
    """
    blocks = grid.blocks if isinstance(grid, MultiBlock) else (grid,)
    dimension = 2 if planar else 3
    if planar and any(not b.is_surface or b.points[..., 2].any() for b in blocks):
        raise InvalidInput("the grids must be surfaces with z = 0", parameter="planar")
    blanked = any(IBLANK in b.point_data for b in blocks)
    heading = [np.array([n for b in blocks for n in b.shape[:dimension]], np.int32)]
    if isinstance(grid, MultiBlock):
        heading.insert(0, np.array([len(blocks)], np.int32))
    bodies = [_body(b, dimension, blanked) for b in blocks]
    if boundaries:
        write_map(path.with_suffix(SUFFIX), grid)
    if not binary:
        _write_text(path, heading, bodies)
        return
    with open(path, "wb") as file:
        for arrays in [*([h] for h in heading), *bodies]:
            content = b"".join(a.tobytes() for a in arrays)
            if record_markers and len(content) >= 2**31:
                raise InvalidInput("has a block of over 2 GB, too large for a record; use record_markers=False")
            marker = np.int32(len(content)).tobytes() if record_markers else b""
            file.write(marker + content + marker)


def _body(block: StructuredGrid, dimension: int, blanked: bool) -> list[np.ndarray]:
    xyz = block.flat(block.points)
    arrays = [np.ascontiguousarray(xyz[:, k]) for k in range(dimension)]
    if blanked:
        iblank = block.point_data.get(IBLANK, np.ones(block.shape, np.int32))
        if iblank.ndim != 3 or iblank.dtype.kind not in "iub":
            raise InvalidInput("needs one whole number a point", parameter=f"point_data[{IBLANK!r}]")
        arrays.append(block.flat(iblank).astype(np.int32))
    return arrays


def _write_text(path: Path, heading: list[np.ndarray], bodies: list[list[np.ndarray]]) -> None:
    parts = [rows_of(numbers[None]) for numbers in heading]
    parts += [wrapped(values, 6) for body in bodies for values in body]
    path.write_text("".join(parts), encoding="ascii")


register(
    "PLOT3D",
    (".xyz", ".p3d", ".x", ".g"),
    "structured grids: text, unformatted or plain binary, with iblank; names and cuts in a neutral map file beside; "
    "options binary, record_markers, planar, boundaries",
    Holds(blocks=2, point_data=(IBLANK,), sides=True),
    read=read_plot3d,
    write=write_plot3d,
)
