"""Stencils along the lines of blocks with cuts, as sparse matrices that take ghost values from beyond them.

Values of all blocks stand in one vector. Beyond a cut a stencil takes the values of the partner, so that it is the one
of the interior; beyond a boundary, ghosts extrapolated as along a single block's lines. Values that belong to a
direction, such as fluxes through the faces i = const, are the partner's of the direction that i has there, with its
sign (blocks are of one hand): so the same difference formula holds on a cut as inside, whatever the orientation.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
import scipy.sparse

from ...mesh import Cut
from ...mesh.cuts import free_sides
from .halo import traced
from .stencils import Stencil, extrapolation

Where = Literal["points", "cells", "middles", "faces"]
"""Where values stand: middles of edges along, and faces across, the direction that they belong to."""


class JoinedLines:
    """The lines of blocks, running on through their cuts.

    Parameters
    ----------
    shapes : sequence of (int, int, int)
        Points of the blocks.
    cuts : sequence of Cut
        Cuts that do not move points.
    """

    def __init__(self, shapes: Sequence[Sequence[int]], cuts: Sequence[Cut]):
        self.shapes = [tuple(shape) for shape in shapes]
        self.cuts = tuple(cuts)
        self.flat = np.array(self.shapes[0]) == 1
        self.dimension = 2 if self.flat[2] else 3
        self._found: dict = {}

    def matrix(
        self, stencil: Stencil, axis: int, where: Where, component: int | None = None, odd: bool = False
    ) -> scipy.sparse.csr_matrix:
        """A stencil along one axis.

        Parameters
        ----------
        stencil : Stencil
            What it makes of values along a line.
        axis : int
            The direction of the lines.
        where : {"points", "cells", "middles", "faces"}
            Where the values stand.
        component : int, optional
            The direction that the values belong to. If given, the matrix takes the values of all directions, one after
            the other.
        odd : bool
            Whether they change their sign where that direction is counted backwards.
        """
        key = (stencil, axis, where, component, odd)
        if key not in self._found:
            rows = [self._of_block(b, *key) for b in range(len(self.shapes))]
            self._found[key] = scipy.sparse.csr_matrix(scipy.sparse.vstack(rows))
        return self._found[key]

    def size(self, where: Where, component: int) -> np.ndarray:
        """(blocks + 1,) int: where the values of each block begin, and their whole number."""
        counts = [int(np.prod(self._shape(b, where, component))) for b in range(len(self.shapes))]
        return np.concatenate([[0], np.cumsum(counts)])

    def _half(self, where: Where, component: int) -> np.ndarray:
        """(3,) int: 1 along the axes along which values stand between points."""
        own = np.arange(3) == component
        half = {"points": 0 * own, "cells": 0 * own + 1, "middles": 1 * own, "faces": 1 - own}[where]
        return np.where(self.flat, 0, half)

    def _shape(self, block: int, where: Where, component: int) -> np.ndarray:
        return np.array(self.shapes[block]) - self._half(where, component)

    def _of_block(self, block, stencil, axis, where, component, odd) -> scipy.sparse.csr_matrix:
        """Rows of one block."""
        own = axis if component is None else component
        shape, half = self._shape(block, where, own), self._half(where, own)
        before, after = -stencil.first, stencil.growth + stencil.first + len(stencil.weights) - 1
        wide = np.array(shape)
        wide[axis] += before + after
        index = np.stack(np.meshgrid(*map(np.arange, wide), indexing="ij"), axis=-1).reshape(-1, 3)
        index[:, axis] -= before
        rows, columns, weights = self._ghosts(block, index, half, axis, where, own, component is not None, odd, stencil)
        count = sum(self.size(where, c)[-1] for c in range(self.dimension)) if component is not None else None
        count = self.size(where, own)[-1] if count is None else count
        extended = scipy.sparse.csr_matrix((weights, (rows, columns)), shape=(len(index), count))
        number = np.moveaxis(np.arange(len(index)).reshape(wide), axis, 0)
        length = shape[axis] + stencil.growth
        result = 0
        for k, weight in enumerate(stencil.weights):
            if weight:
                result = result + weight * extended[np.moveaxis(number[k : k + length], 0, axis).ravel()]
        return result

    def _ghosts(self, block, index, half, axis, where, own, by_component, odd, stencil):
        """Rows, columns and weights of the values along lines and beyond their ends."""
        shape = self._shape(block, where, own)
        starts = np.concatenate([[0], np.cumsum([self.size(where, c)[-1] for c in range(self.dimension)])])
        first = starts[own] if by_component else 0
        found = traced(np.full(len(index), block), 2 * index + half, self.cuts, self.shapes)
        rows, columns, weights = [], [], []
        for other in range(len(self.shapes)):
            for to in range(self.dimension):
                heading = found.turn[:, to, own]
                here = np.flatnonzero(found.known & (found.block == other) & (heading != 0))
                if not len(here):
                    continue
                component = to if by_component else own
                place = found.place[here] // 2
                local = np.ravel_multi_index(tuple(place.T), tuple(self._shape(other, where, to)))
                rows.append(here)
                columns.append((starts[component] if by_component else 0) + self.size(where, to)[other] + local)
                weights.append(heading[here] if odd else np.ones(len(here)))
        beyond = np.flatnonzero(~found.known)
        for low in (True, False):
            some = beyond[(index[beyond, axis] < 0) == low]
            if len(some):
                far = -index[some, axis] if low else index[some, axis] - shape[axis] + 1
                table = extrapolation(int(far.max()), stencil.needed)
                for k in range(stencil.needed):
                    place = index[some].copy()
                    place[:, axis] = k if low else shape[axis] - 1 - k
                    local = np.ravel_multi_index(tuple(place.T), tuple(shape))
                    rows.append(some)
                    columns.append(first + self.size(where, own)[block] + local)
                    weights.append(table[far - 1, k])
        return np.concatenate(rows), np.concatenate(columns), np.concatenate(weights)


def on_boundary(shapes: Sequence[Sequence[int]], cuts: Sequence[Cut]) -> list[np.ndarray]:
    """For each block, (ni, nj, nk) bool: which points belong to a part of a side that no cut joins to anything."""
    marks = [np.zeros(shape, bool) for shape in shapes]
    for block, axis, last, free in free_sides(shapes, cuts):
        face = np.moveaxis(marks[block], axis, 0)[-last]
        for a, b in np.ndindex(2, 2):
            part = face[tuple(slice(s, s + n) for s, n in zip((a, b), free.shape, strict=True))]
            # Along a direction of one layer the other corner of a cell would be beyond it, and the part is empty.
            part |= free[: part.shape[0], : part.shape[1]]
    return marks
