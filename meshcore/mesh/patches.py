"""Boundary patches of structured grids: what of their faces no cut joins to anything, as named ranges of points."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Union

import numpy as np

from .cuts import Cut, Index, Range, as_range, free_sides
from .multi_block import MultiBlock
from .structured_grid import FACES, StructuredGrid

UNNAMED = "boundary"
"""Name of all patches on faces without one."""


@dataclass(frozen=True)
class Patch:
    """A rectangle of points on a face of a block.

    Attributes
    ----------
    block : int
        Number of the block; 0 in a grid.
    face : str
        "imin", "imax", "jmin", "jmax", "kmin" or "kmax".
    points : two of (int, int, int)
        First and last point, both included, counted up.
    name : str
        The face's name, "boundary" if it has none.
    """

    block: int
    face: str
    points: Range
    name: str


def patches(grid: Union[StructuredGrid, MultiBlock], *, moved: bool = False) -> tuple[Patch, ...]:
    """The boundary of a grid or of blocks: faces without the parts that cuts join to others.

    Parameters
    ----------
    grid : StructuredGrid or MultiBlock
        Faces that are cut in part, as the wall of a C-grid, give what is left, in as many rectangles as it takes.
    moved : bool
        Also give the two sides of cuts that lead to moved or turned places, as solvers want them that know periodic
        boundaries by pairs of names. They are called as the cut, or "periodic", the partner's with " donor" behind,
        unless their faces have names.

    Returns
    -------
    tuple of Patch
        Block by block, face by face.

    Examples
    --------
    >>> x, y = np.meshgrid([0, 1, 3], [0, 1], indexing="ij")
    >>> grid = StructuredGrid(np.stack([x, y], axis=-1), names={"jmin": "wall"})
    >>> [(patch.face, patch.name) for patch in patches(grid)]
    [('imin', 'boundary'), ('imax', 'boundary'), ('jmin', 'wall'), ('jmax', 'boundary')]
    >>> patches(grid)[2].points
    ((0, 0, 0), (2, 0, 0))
    """
    blocks = grid if isinstance(grid, MultiBlock) else MultiBlock((grid,))
    found = []
    for block, axis, last, free in free_sides([b.shape for b in blocks.blocks], blocks.joins):
        face, shape = FACES[2 * axis + last], blocks.blocks[block].shape
        name = blocks.blocks[block].names.get(face) or UNNAMED
        found += [Patch(block, face, points, name) for points in _rectangles(free, shape, axis, last)]
    pairs = [cut for cut in blocks.joins if moved and cut.moves]
    names = _pair_names(pairs)
    for cut, name in zip(pairs, names, strict=True):
        found += [_side(cut, name, blocks), _side(cut.reversed(), f"{name} donor", blocks)]
    return tuple(sorted(found, key=lambda patch: (patch.block, FACES.index(patch.face), patch.points)))


def _pair_names(pairs: list[Cut]) -> list[str]:
    """A name for each cut that moves; those without, or with another's, are numbered."""
    names: list[str] = []
    for cut in pairs:
        plain = name = cut.name or "periodic"
        number = 1
        while name in names:
            number += 1
            name = f"{plain} {number}"
        names.append(name)
    return names


def _side(cut: Cut, name: str, blocks: MultiBlock) -> Patch:
    """The patch on this side of a cut."""
    block = blocks.blocks[cut.block]
    axis, side = cut.face(block.shape)
    face = FACES[2 * axis + (side > 0)]
    low, high = np.sort(cut.points, axis=0).tolist()
    return Patch(cut.block, face, (tuple(low), tuple(high)), block.names.get(face) or name)


def _rectangles(free: np.ndarray, shape: Index, axis: int, last: int) -> Iterator[Range]:
    """What is free of a side, in rectangles: rows as long as they go, deepened as far as they stay free."""
    rest = free.copy()
    others = [a for a in range(3) if a != axis]
    while rest.any():
        i, j = np.argwhere(rest)[0]
        width = _run(rest[i, j:])
        depth = _run(rest[i:, j : j + width].all(axis=1))
        rest[i : i + depth, j : j + width] = False
        low, high = [0, 0, 0], [0, 0, 0]
        low[axis] = high[axis] = last * (shape[axis] - 1)
        for a, first, count in zip(others, (i, j), (depth, width), strict=True):
            low[a], high[a] = int(first), min(int(first + count), shape[a] - 1)
        yield as_range((low, high), shape)


def _run(free: np.ndarray) -> int:
    """How many are True before the first False."""
    return len(free) if free.all() else int(np.argmin(free))
