"""MultiBlock: several structured grids that make one domain."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..errors import InvalidInput
from .cuts import Cut, checked_cuts, glued
from .mesh import Mesh
from .structured_grid import StructuredGrid


@dataclass(frozen=True, eq=False, repr=False)
class MultiBlock:
    """Named structured blocks.

    Parameters
    ----------
    blocks : tuple of StructuredGrid
        The blocks.
    names : tuple of str
        One name a block; "block 0", "block 1", ... by default.
    cuts : tuple of Cut
        Where blocks are joined to each other; those of a block with itself may stay with the block.

    Raises
    ------
    InvalidInput, InvalidGeometry
        If the names are not as many as the blocks, one is used twice, or the two sides of a cut are not at the same
        places.

    Examples
    --------
    >>> import numpy as np
    >>> unit = StructuredGrid(np.stack(np.meshgrid([0, 1], [0, 1], indexing="ij"), axis=-1))
    >>> MultiBlock((unit, unit.with_points(unit.points + [1, 0, 0])))
    MultiBlock(block 0: 2 x 2, block 1: 2 x 2 points)
    """

    blocks: tuple[StructuredGrid, ...]
    names: tuple[str, ...] = ()
    cuts: tuple[Cut, ...] = ()

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "blocks", tuple(self.blocks))
        set_(self, "names", tuple(self.names) or tuple(f"block {k}" for k in range(len(self.blocks))))
        if not self.blocks:
            raise InvalidInput("needs at least one block", parameter="blocks")
        if len(self.names) != len(self.blocks) or len(set(self.names)) != len(self.names):
            raise InvalidInput(f"needs {len(self.blocks)} different names, got {self.names}", parameter="names")
        set_(self, "cuts", checked_cuts(self.cuts, self.blocks))

    def __repr__(self) -> str:
        shapes = [b.shape[:2] if b.is_surface else b.shape for b in self.blocks]
        parts = [f"{n}: {' x '.join(map(str, s))}" for n, s in zip(self.names, shapes, strict=True)]
        return f"MultiBlock({', '.join(parts)} points)"

    @property
    def n_points(self) -> int:
        """Number of points of all blocks."""
        return sum(b.n_points for b in self.blocks)

    @property
    def n_cells(self) -> int:
        """Number of cells of all blocks."""
        return sum(b.n_cells for b in self.blocks)

    @property
    def joins(self) -> tuple[Cut, ...]:
        """All cuts: between blocks, and those that blocks have with themselves."""
        own = [replace(cut, block=k, partner_block=k) for k, block in enumerate(self.blocks) for cut in block.joins]
        return self.cuts + tuple(own)

    def numbers(self) -> list[np.ndarray]:
        """For each block, (ni, nj, nk) int: numbers of the points of all blocks, i running fastest in each.

        Copies of a point across cuts have the number of the first.
        """
        shapes = [block.shape for block in self.blocks]
        starts = np.cumsum([0] + [block.n_points for block in self.blocks])
        own = [
            start + np.arange(block.n_points).reshape(block.shape[::-1]).swapaxes(0, 2)
            for start, block in zip(starts, self.blocks, strict=False)
        ]
        in_order = np.concatenate([number.ravel() for number in own])  # by C-ordered numbers, as `glued` counts
        return [in_order[glue] for glue in glued(self.joins, shapes)]

    def to_mesh(self) -> Mesh:
        """The cells of all blocks as one `Mesh`, points on both sides of a cut being one; each block becomes a set.

        Data that not all blocks have are left out.
        """
        meshes = [replace(block, cuts=(), periodic=(False,) * 3).to_mesh() for block in self.blocks]
        kinds = dict.fromkeys(kind for mesh in meshes for kind in mesh.cells)
        if len(kinds) != 1:
            raise InvalidInput("has surfaces and volumes; give the ones or the others", parameter="blocks")
        kind = next(iter(kinds))
        first = np.concatenate([number.swapaxes(0, 2).ravel() for number in self.numbers()])
        starts = np.cumsum([0] + [b.n_points for b in self.blocks])
        cells = np.concatenate([mesh.cells[kind] + s for mesh, s in zip(meshes, starts, strict=False)])
        ends = np.cumsum([0] + [mesh.n_cells for mesh in meshes])
        return Mesh(
            np.concatenate([mesh.points for mesh in meshes]),
            {kind: first[cells]},
            _of_all([mesh.point_data for mesh in meshes]),
            _of_all([mesh.cell_data for mesh in meshes]),
            {name: np.arange(a, b) for name, a, b in zip(self.names, ends[:-1], ends[1:], strict=True)},
        ).compacted()


def _of_all(data: list[dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """The arrays that every block has, one block's after the other's."""
    names = [n for n in data[0] if all(n in d and d[n].shape[1:] == data[0][n].shape[1:] for d in data)]
    return {name: np.concatenate([d[name] for d in data]) for name in names}
