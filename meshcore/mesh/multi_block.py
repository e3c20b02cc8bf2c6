"""MultiBlock: several structured grids that make one domain."""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import InvalidInput
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

    Raises
    ------
    InvalidInput
        If the names are not as many as the blocks, or one is used twice.

    Examples
    --------
    >>> import numpy as np
    >>> unit = StructuredGrid(np.stack(np.meshgrid([0, 1], [0, 1], indexing="ij"), axis=-1))
    >>> MultiBlock((unit, unit.with_points(unit.points + [1, 0, 0])))
    MultiBlock(block 0: 2 x 2, block 1: 2 x 2 points)
    """

    blocks: tuple[StructuredGrid, ...]
    names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "blocks", tuple(self.blocks))
        set_(self, "names", tuple(self.names) or tuple(f"block {k}" for k in range(len(self.blocks))))
        if not self.blocks:
            raise InvalidInput("needs at least one block", parameter="blocks")
        if len(self.names) != len(self.blocks) or len(set(self.names)) != len(self.names):
            raise InvalidInput(f"needs {len(self.blocks)} different names, got {self.names}", parameter="names")

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
