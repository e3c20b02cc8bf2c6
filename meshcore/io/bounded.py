"""Blocks, and what a file tells of their faces, put together: names of faces, periodic directions, cuts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Union

import numpy as np

from ..errors import InvalidInput
from ..mesh import Cut, MultiBlock, Patch, StructuredGrid
from ..mesh.cuts import closing
from .fit import warn_dropped


def bounded(
    blocks: Sequence[StructuredGrid], names: Sequence[str], patches: Iterable[Patch], cuts: Iterable[Cut]
) -> Union[StructuredGrid, MultiBlock]:
    """One block as a grid, several as a `MultiBlock`, with the names and cuts that a file gives them.

    A cut that closes a direction of a block makes it periodic, others of a block with itself stay with it. What does
    not fit, and all but the largest of several names for one face, is left out with a `FormatWarning`.

    Parameters
    ----------
    blocks : sequence of StructuredGrid
        Points and data.
    names : sequence of str
        One a block.
    patches : iterable of Patch
        Those called "" name nothing.
    cuts : iterable of Cut
        Each join once.
    """
    blocks = [replace(b, names=faces) for b, faces in zip(blocks, _face_names(len(blocks), patches), strict=True)]
    between: list[Cut] = []
    for cut in cuts:
        try:
            if cut.block != cut.partner_block or not 0 <= cut.block < len(blocks):
                MultiBlock(tuple(blocks), cuts=(cut,))
                between.append(cut)
            else:
                blocks[cut.block] = _joined_to_itself(blocks[cut.block], replace(cut, block=0, partner_block=0))
        except InvalidInput as error:
            warn_dropped("the cut", [cut.name or f"{cut.points} of block {cut.block}"], str(error))
    if len(blocks) == 1:
        return blocks[0]
    return MultiBlock(tuple(blocks), tuple(names), tuple(between))


def _face_names(count: int, patches: Iterable[Patch]) -> list[dict[str, str]]:
    """For each block, the names of its faces."""
    sizes: dict[tuple[int, str], dict[str, int]] = {}
    for patch in patches:
        if patch.name:
            low, high = np.array(patch.points)
            face = sizes.setdefault((patch.block, patch.face), {})
            face[patch.name] = face.get(patch.name, 0) + int(np.prod(np.maximum(np.abs(high - low), 1)))
    named: list[dict[str, str]] = [{} for _ in range(count)]
    for (block, face), found in sizes.items():
        largest = max(found, key=lambda name: found[name])
        named[block][face] = largest
        others = [name for name in found if name != largest]
        warn_dropped("the names", others, f"{face} of block {block} is called {largest!r}, and a face has one name")
    return named


def _joined_to_itself(block: StructuredGrid, cut: Cut) -> StructuredGrid:
    for axis in [a for a in range(3) if block.shape[a] > 1]:
        plain = closing(block.shape, axis)
        if not cut.moves and cut.transform == (1, 2, 3) and _same_sides(cut, plain):
            checked = replace(block, cuts=(*block.cuts, plain))  # its points must repeat
            periodic = tuple(flag or a == axis for a, flag in enumerate(block.periodic))
            return replace(checked, cuts=block.cuts, periodic=periodic)
    return replace(block, cuts=(*block.cuts, cut))


def _same_sides(cut: Cut, other: Cut) -> bool:
    """Whether two cuts of a block with itself, both counted alike across, join the same two ranges."""

    def ranges(cut: Cut) -> set[tuple]:
        return {tuple(map(tuple, np.sort(ends, axis=0).tolist())) for ends in (cut.points, cut.partner)}

    return ranges(cut) == ranges(other)
