"""Neutral map files (.nmf), beside PLOT3D's grids: which ranges of faces are joined, and what the others are called.

::

    # Type          B1 F1  S1  E1  S2  E2  B2 F2  S1  E1  S2  E2  Swap
    'far field'      1  6   1   1   1 163
    ONE_TO_ONE       1  5   1   1   1  46   1  5   1   1 163 118  FALSE   # wake

Faces 1 to 6 are kmin, kmax, imin, imax, jmin, jmax; S1, E1 and S2, E2 are the first and last points, counted from 1,
along the axes that follow the face's own in the order i, j, k, i, j; Swap: the first here is the second there.
What stands behind # is the name of a block or of a join.

References
----------
NASA Langley GEOLAB, "Neutral map file format".
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Union

import numpy as np

from ..errors import InvalidInput
from ..mesh import Cut, MultiBlock, Patch, StructuredGrid, patches
from ..mesh.cuts import Range, as_index, as_range
from ..mesh.structured_grid import FACES
from .content import text_of, whole
from .fit import warn_dropped

SUFFIX = ".nmf"
_JOIN = "ONE_TO_ONE"
_ORDER = ("kmin", "kmax", "imin", "imax", "jmin", "jmax")
_HEADING = "# Type  B1 F1  S1 E1  S2 E2  B2 F2  S1 E1  S2 E2  Swap"
_TOKEN = re.compile(r"'[^']*'|\"[^\"]*\"|#.*|[^\s#,]+")


def write_map(path: Path, grid: Union[StructuredGrid, MultiBlock]) -> None:
    """The boundary and the cuts of a grid or blocks; cuts that move points are written as two boundaries."""
    blocks = grid if isinstance(grid, MultiBlock) else MultiBlock((grid,))
    shapes = [block.shape for block in blocks.blocks]
    lines = ["# Neutral map file", str(len(shapes))]
    for number, (shape, name) in enumerate(zip(shapes, blocks.names, strict=True)):
        lines.append(" ".join(map(str, (number + 1, *shape))) + (f" # {name}" if name != f"block {number}" else ""))
    lines.append(_HEADING)
    for patch in patches(blocks, moved=True):
        lines.append(f"{_quoted(patch.name)} {patch.block + 1} {_side(patch.face, patch.points)}")
    still = [cut for cut in blocks.joins if not cut.moves]
    for cut in still:
        faces = [_face_of(side, shapes) for side in (cut, cut.reversed())]
        swap = str(_swapped(faces, cut.transform)).upper()
        here, there = _side(faces[0], cut.points), _side(faces[1], cut.partner)
        words = [_JOIN, cut.block + 1, here, cut.partner_block + 1, there, swap, *(["#", cut.name] if cut.name else [])]
        lines.append(" ".join(map(str, words)))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    moved = [cut.name or f"{cut.points} of block {cut.block}" for cut in blocks.joins if cut.moves]
    warn_dropped("cuts", moved, "a neutral map knows no moved sides; their two sides are boundaries in it")


def _quoted(name: str) -> str:
    """The name between quotes; where it has both kinds, those within become single ones."""
    name = " ".join(name.replace("\0", "").split())
    if "'" not in name:
        return f"'{name}'"
    within = name.replace('"', "'")
    return f'"{within}"'


def _face_of(cut: Cut, shapes: Sequence[tuple[int, int, int]]) -> str:
    axis, side = cut.face(shapes[cut.block])
    return FACES[2 * axis + (side > 0)]


def _axes(face: str) -> tuple[int, int, int]:
    """The axis across a face, and the primary and secondary axes along it."""
    axis = "ijk".index(face[0])
    return axis, (axis + 1) % 3, (axis + 2) % 3


def _side(face: str, points: Range) -> str:
    """Face number, and where the range begins and ends along the two axes."""
    _, first, second = _axes(face)
    ends = [points[end][axis] + 1 for axis in (first, second) for end in (0, 1)]
    return " ".join(map(str, (_ORDER.index(face) + 1, *ends)))


def _swapped(faces: Sequence[str], transform: Sequence[int]) -> bool:
    return abs(transform[_axes(faces[0])[1]]) - 1 != _axes(faces[1])[1]


# ---- reading


def read_map(path: Path, shapes: Sequence[tuple[int, int, int]]) -> tuple[list[str], list[Patch], list[Cut]]:
    """What a map tells of blocks of these shapes: their names, boundaries and joins.

    Raises
    ------
    InvalidInput
        If it belongs to other blocks, or a line of it says what cannot be.
    """
    rows = [(line, words) for line, text in enumerate(text_of(path).split("\n"), 1) if (words := _TOKEN.findall(text))]
    rows = [(line, words) for line, words in rows if not words[0].startswith("#")]
    if not rows:
        raise InvalidInput("it is empty")
    count = whole(rows[0][1][0], rows[0][0], "a number of blocks")
    if count != len(shapes) or len(rows) <= count:
        raise InvalidInput(f"it is for {count} blocks, the grid has {len(shapes)}")
    names = []
    for shape, (line, words) in zip(shapes, rows[1 : 1 + count], strict=True):
        names.append(_comment(words) or f"block {len(names)}")
        sizes = tuple(whole(word, line, "a size") for word in words[1:4])
        if sizes != tuple(shape):
            raise InvalidInput(f"line {line}: it is for a block of {sizes} points, the grid has {tuple(shape)}")
    names = names if len(set(names)) == count else [f"block {k}" for k in range(count)]
    boundaries, cuts = [], []
    for line, words in rows[1 + count :]:
        name = _comment(words)
        try:
            if len(words) >= 13:
                cuts.append(_cut(words, line, shapes, name))
            elif len(words) >= 7 and not _is_join(words[0]):
                block, face, points = _range(words[1:7], line, shapes)
                boundaries.append(Patch(block, face, points, _unquoted(words[0])))
            else:
                raise InvalidInput(f"{len(words)} columns; 7 make a boundary, 14 a join")
        except InvalidInput as error:
            raise InvalidInput(f"line {line}: {str(error).removeprefix(f'line {line}: ')}") from None
    return names, boundaries, cuts


def _comment(words: list[str]) -> str:
    """What stands behind #, which is taken off."""
    return words.pop().lstrip("# ").strip() if words[-1].startswith("#") else ""


def _unquoted(word: str) -> str:
    return word[1:-1] if word[0] in "'\"" and word[-1] == word[0] else word


def _is_join(word: str) -> bool:
    return _unquoted(word).upper().replace("-", "_") == _JOIN


def _range(words: list[str], line: int, shapes: Sequence[tuple[int, int, int]]) -> tuple[int, str, Range]:
    block, face, *ends = (whole(word, line, "a column") for word in words)
    if not 1 <= block <= len(shapes) or not 1 <= face <= 6:
        raise InvalidInput(f"there is no face {face} of block {block}")
    shape, name = shapes[block - 1], _ORDER[face - 1]
    axis, first, second = _axes(name)
    corners = np.zeros((2, 3), int)
    corners[:, axis] = shape[axis] - 1 if name.endswith("max") else 0
    corners[:, first], corners[:, second] = np.array(ends[:2]) - 1, np.array(ends[2:]) - 1
    return block - 1, name, as_range(corners, shape)


def _cut(words: list[str], line: int, shapes: Sequence[tuple[int, int, int]], name: str) -> Cut:
    """A join; the transform is told by which way each range runs and by Swap."""
    block, face, points = _range(words[1:7], line, shapes)
    partner_block, partner_face, partner = _range(words[7:13], line, shapes)
    swap = len(words) > 13 and words[13].strip("'\"").upper().strip(".") in ("TRUE", "T")
    here, there = _axes(face), _axes(partner_face)
    transform = [0, 0, 0]
    # Beyond a face lies the partner's inside: the axes across are counted alike if one face is a first, one a last.
    transform[here[0]] = (there[0] + 1) * (1 if face[1:] != partner_face[1:] else -1)
    along = there[:0:-1] if swap else there[1:]
    for axis, other in zip(here[1:], along, strict=True):
        runs = (points[1][axis] - points[0][axis]) * (partner[1][other] - partner[0][other])
        transform[axis] = (other + 1) * (-1 if runs < 0 else 1)
    return Cut(points, partner, as_index(transform), block, partner_block, name=name)
