"""Cuts of layers marched from grids and blocks: those of the surface, and those between its periodic edges."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...errors import InvalidGeometry
from ...mesh import Cut, MultiBlock, StructuredGrid
from ..poisson.periodic_faces import Motion
from .layer_surface import LayerSurface
from .periodic_edges import EdgePair


class _BlockSide(NamedTuple):
    """A side of a block: its nodes in order, the axes along and across, and whether it is the last across."""

    nodes: np.ndarray
    block: int
    along: int
    across: int
    last: bool

    def place(self, shape: Sequence[int], at: int) -> tuple[int, int, int]:
        """Indices of one of its points."""
        index = [0, 0, 0]
        index[self.along] = at
        index[self.across] = shape[self.across] - 1 if self.last else 0
        i, j, k = index
        return i, j, k


def with_cuts(
    ready: LayerSurface, pairs: Sequence[EdgePair], result: StructuredGrid | MultiBlock
) -> tuple[StructuredGrid | MultiBlock, list[str]]:
    """Layers with the cuts of the surface and of its periodic edges, and what could not be recorded.

    Parameters
    ----------
    ready : LayerSurface
        The surface.
    pairs : sequence of EdgePair
        Its periodic edges.
    result : StructuredGrid or MultiBlock
        Its layers.
    """
    surface = ready.source if isinstance(ready.source, MultiBlock) else MultiBlock((ready.source,))
    own = [replace(cut, block=k, partner_block=k) for k, block in enumerate(surface.blocks) for cut in block.cuts]
    found, warnings = [*surface.cuts, *own], []
    sides = list(_sides(surface, ready.number))
    known = [*surface.joins, *(cut.reversed() for cut in surface.joins)]
    found += [cut for cut in _joined(sides, surface) if not any(_overlap(cut, other) for other in known)]
    for pair in pairs:
        cuts, missing = _cuts_of(pair, sides, surface)
        found += [cut for cut in cuts if not any(_overlap(cut, other) for other in known)]
        if missing:
            warnings.append(
                f"{missing} of the {len(pair.first) - 1} cells along a periodic edge belong to sides of blocks that go "
                "on beyond it; no cut is recorded there"
            )
    layers = (result if isinstance(result, StructuredGrid) else result.blocks[0]).cell_shape[2]
    kept = []
    for cut in found:
        through = _through_layers(cut, surface, layers, ready.reversed)
        try:
            replace(result, cuts=(through,))
            kept.append(through)
        except InvalidGeometry as error:
            warnings.append(f"a cut is not recorded, since its sides are not quite alike: {error}")
    return replace(result, cuts=tuple(kept)), warnings


def _sides(surface: MultiBlock, number: np.ndarray) -> Iterator[_BlockSide]:
    start = 0
    for k, block in enumerate(surface.blocks):
        grid = number[start : start + block.n_points].reshape(block.shape[:2])
        start += block.n_points
        for last in (False, True):
            yield _BlockSide(grid[-1 if last else 0], k, 1, 0, last)
            yield _BlockSide(grid[:, -1 if last else 0], k, 0, 1, last)


def _joined(sides: Sequence[_BlockSide], surface: MultiBlock) -> Iterator[Cut]:
    """Cuts between whole sides that have the same nodes, each once."""
    first: dict[tuple[int, ...], _BlockSide] = {}
    for side in sides:
        nodes = tuple(side.nodes.tolist())
        if len(set(nodes)) < len(nodes):
            continue
        for key in (nodes, nodes[::-1]):
            if key in first:
                yield _cut(first.pop(key), side, key != nodes, None, surface)
                break
        else:
            first[nodes] = side


def _overlap(cut: Cut, other: Cut) -> bool:
    """Whether two cuts have points of a side of a block in common, more than one."""
    if cut.block != other.block:
        return False
    low = np.maximum(np.min(cut.points, axis=0), np.min(other.points, axis=0))
    high = np.minimum(np.max(cut.points, axis=0), np.max(other.points, axis=0))
    return bool((low <= high).all() and (low < high).any())


def _cuts_of(pair: EdgePair, sides: Sequence[_BlockSide], surface: MultiBlock) -> tuple[list[Cut], int]:
    """The cuts between whole sides of blocks at a pair of edges, and how many cells along it have none."""
    image = dict(zip(pair.first.tolist(), pair.last.tolist(), strict=True))
    cuts, covered = [], 0
    for side in sides:
        images = [image.get(node, -1) for node in side.nodes.tolist()]
        if min(images) < 0:
            continue
        for other in sides:
            nodes = other.nodes.tolist()
            if nodes in (images, images[::-1]) and (other.block, other.across, other.last) != side[1:2] + side[3:]:
                cuts.append(_cut(side, other, nodes != images, pair, surface))
                covered += len(nodes) - 1
                break
    return cuts, len(pair.first) - 1 - covered


def _cut(side: _BlockSide, other: _BlockSide, backwards: bool, pair: EdgePair | None, surface: MultiBlock) -> Cut:
    here, there = surface.blocks[side.block].shape, surface.blocks[other.block].shape
    end = len(side.nodes) - 1
    transform = [0, 0, 3]
    transform[side.along] = (-1 if backwards else 1) * (other.along + 1)
    transform[side.across] = (-1 if side.last == other.last else 1) * (other.across + 1)
    i, j, k = transform
    motion = Motion() if pair is None else pair.motion
    return Cut(
        (side.place(here, 0), side.place(here, end)),
        (other.place(there, end if backwards else 0), other.place(there, 0 if backwards else end)),
        (i, j, k),
        side.block,
        other.block,
        rotation=tuple(map(tuple, motion.turn.tolist())) if motion.is_turn else None,
        translation=tuple(motion.way.tolist()) if motion.way.any() else None,
        name="" if pair is None else "periodic",
    )


def _through_layers(cut: Cut, surface: MultiBlock, layers: int, turned: bool) -> Cut:
    """A cut of the surface as one of its layers, whose blocks may be counted backwards along i."""

    def place(at: tuple[int, int, int], block: int, k: int) -> tuple[int, int, int]:
        return (surface.blocks[block].shape[0] - 1 - at[0] if turned else at[0], at[1], k)

    signs = [-1 if turned and (axis == 0) != (abs(to) == 1) else 1 for axis, to in enumerate(cut.transform[:2])]
    return replace(
        cut,
        points=(place(cut.points[0], cut.block, 0), place(cut.points[1], cut.block, layers)),
        partner=(place(cut.partner[0], cut.partner_block, 0), place(cut.partner[1], cut.partner_block, layers)),
        transform=(signs[0] * cut.transform[0], signs[1] * cut.transform[1], 3),
    )
