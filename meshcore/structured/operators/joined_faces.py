"""Cells and faces of blocks in one vector each: taken from the user and given back, one flux for both sides of a cut.

Values stand on half steps along some axes: cells along all, the faces i = const along all but i, points along none.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ...errors import InvalidInput
from ...mesh import Cut, MultiBlock, StructuredGrid
from ...mesh.cuts import free_sides
from .stencils import Stencil


class JoinedFaces:
    """The cells and faces of a grid or of blocks.

    Of blocks, and of a grid with cuts, values of all stand one after the other in arrays of shape (n, 1, 1, ...).

    Parameters
    ----------
    grid : StructuredGrid or MultiBlock
        The user's.
    flat : bool
        Whether it has cuts or blocks.
    """

    def __init__(self, grid: StructuredGrid | MultiBlock, flat: bool):
        self.several, self.flat = isinstance(grid, MultiBlock), flat
        blocks = grid.blocks if isinstance(grid, MultiBlock) else (grid,)
        self.shapes = [np.array(block.shape) for block in blocks]
        self.cuts: tuple[Cut, ...] = tuple(grid.joins)
        self.open_axes = self.shapes[0] > 1
        self.axes = np.flatnonzero(self.open_axes).tolist()

    def half(self, *axes: int) -> np.ndarray:
        """(3,) int: 1 along these axes, if values there stand between points."""
        return np.isin(np.arange(3), axes).astype(int)

    def cells(self) -> np.ndarray:
        """(3,) int: half steps of cells."""
        return self.half(*self.axes)

    def faces(self, i: int) -> np.ndarray:
        """(3,) int: half steps of the faces i = const."""
        return self.half(*[axis for axis in self.axes if axis != i])

    def sizes(self, half: np.ndarray) -> list[tuple[int, ...]]:
        """For each block, the shape of values that stand on these half steps."""
        return [tuple((shape - half).tolist()) for shape in self.shapes]

    def parts(self, values: np.ndarray, half: np.ndarray) -> list[np.ndarray]:
        """The arrays of the blocks, views of one of all."""
        sizes = self.sizes(half)
        if not self.flat:
            return [values]
        ends = np.cumsum([int(np.prod(size)) for size in sizes])[:-1]
        return [
            part.reshape(*size, *values.shape[3:]) for part, size in zip(np.split(values, ends), sizes, strict=True)
        ]

    def joined(self, parts: Sequence[np.ndarray]) -> np.ndarray:
        """One array of all, of those of the blocks."""
        if not self.flat:
            return parts[0]
        return np.concatenate([part.reshape(-1, 1, 1, *part.shape[3:]) for part in parts])

    def given(self, values: np.ndarray, half: np.ndarray) -> Any:
        """Values as the user has them: an array of the grid, a list of those of blocks."""
        parts = self.parts(values, half)
        return parts if self.several else parts[0]

    def taken(self, values: Any, half: np.ndarray, name: str, check: Callable[..., np.ndarray]) -> np.ndarray:
        """The user's values as one array, each block's checked against its shape."""
        sizes = self.sizes(half)
        if not self.several:
            return self.joined([check(values, sizes[0], name)])
        if not isinstance(values, (list, tuple)) and np.ndim(values) == 0:
            values = [values] * len(sizes)
        if not isinstance(values, (list, tuple)) or len(values) != len(sizes):
            raise InvalidInput(f"needs a list of {len(sizes)} arrays, one a block", parameter=name)
        return self.joined(
            [check(part, size, f"{name}[{k}]") for k, (part, size) in enumerate(zip(values, sizes, strict=True))]
        )

    def within(self, stencil: Stencil, values: np.ndarray, axis: int, half: np.ndarray) -> np.ndarray:
        """A stencil that needs no values beyond the blocks, along one axis."""
        return self.joined([stencil.along(part, axis) for part in self.parts(values, half)])

    def shared(self, fluxes: Sequence[np.ndarray]) -> tuple[np.ndarray, ...]:
        """Fluxes through the faces of each direction, with one value on both sides of a cut: the mean of theirs.

        They differ in round-off, and at the ends of cuts, where neighbours along the cut are other faces.
        """
        if not self.flat:
            return tuple(fluxes)
        found = tuple(np.array(flux) for flux in fluxes)
        parts = [self.parts(flux, self.faces(i)) for i, flux in enumerate(found)]
        for cut in self.cuts:
            axis, here = self._of_side(cut)
            other, there = self._of_side(cut.reversed(), cut)
            sign = np.sign(cut.transform[axis])
            one, two = parts[axis][cut.block], parts[other][cut.partner_block]
            mean = 0.5 * (one[here] + sign * two[there])
            one[here], two[there] = mean, sign * mean
        return found

    def boundary(self) -> tuple[np.ndarray, ...]:
        """For each direction, whether a face is one of the boundary: no cut joins it to anything."""
        marks = [[np.zeros(size, bool) for size in self.sizes(self.faces(i))] for i in self.axes]
        for block, axis, last, free in free_sides(self.shapes, self.cuts):
            np.moveaxis(marks[axis][block], axis, 0)[-last] = free
        return tuple(self.joined(mark) for mark in marks)

    def _of_side(self, cut: Cut, order: Cut | None = None) -> tuple[int, tuple[np.ndarray, ...]]:
        """The direction of a cut's faces and their numbers in their block, in the order of the same or another side."""
        first = order or cut
        axis = first.face(self.shapes[first.block])[0]
        low, high = np.sort(first.points, axis=0)
        along = [
            np.arange(a, b) if self.open_axes[k] and k != axis else np.arange(a, b + 1)
            for k, (a, b) in enumerate(zip(low, high, strict=True))
        ]
        place = np.stack(np.meshgrid(*along, indexing="ij"), axis=-1).reshape(-1, 3)
        if order is None:
            return axis, tuple(place.T)
        place = order.across(2 * place + self.faces(axis), step=2)
        return cut.face(self.shapes[cut.block])[0], tuple(place.T // 2)
