"""Structured grids as meshes whose sides are cells too: what flow solvers call markers, or boundary patches."""

from __future__ import annotations

from typing import Union

import numpy as np

from .mesh import Mesh
from .multi_block import MultiBlock
from .patches import patches
from .structured_grid import FACES, StructuredGrid


def with_named_sides(grid: Union[StructuredGrid, MultiBlock]) -> Mesh:
    """The glued mesh of a grid, with the cells of its sides, in one set for each name.

    Parameters
    ----------
    grid : StructuredGrid or MultiBlock
        Parts of sides that cuts join to others are no sides. Sides without names are in the set "boundary"; the two
        sides of a cut that moves points are sets of their own, as `patches` names them.

    Returns
    -------
    Mesh
        "quad" cells with "line" cells as sides, or "hexahedron" cells with "quad" cells. Sides have the cell data of
        the cells that they bound.

    Examples
    --------
    >>> x, y = np.meshgrid([0, 1, 3], [0, 1], indexing="ij")
    >>> grid = StructuredGrid(np.stack([x, y], axis=-1), names={"jmin": "wall"})
    >>> mesh = with_named_sides(grid)
    >>> mesh, {name: len(cells) for name, cells in mesh.sets.items()}
    (Mesh(6 points, 2 quad, 6 line), {'boundary': 4, 'wall': 2})
    """
    blocks = grid if isinstance(grid, MultiBlock) else MultiBlock((grid,))
    whole = blocks.to_mesh()
    numbers = blocks.numbers()
    used = np.unique(np.concatenate([number.ravel() for number in numbers]))
    owners = _cell_numbers(blocks)
    sides: dict[str, list[np.ndarray]] = {}
    bounded: dict[str, list[np.ndarray]] = {}
    for patch in patches(blocks, moved=True):
        axis, last = divmod(FACES.index(patch.face), 2)
        inside = [slice(low, high + 1) for low, high in zip(*patch.points, strict=True)]
        nodes = numbers[patch.block][tuple(inside)].squeeze(axis=axis)
        sides.setdefault(patch.name, []).append(np.searchsorted(used, _cells(nodes)))
        beside = [slice(low, max(high, low + 1)) for low, high in zip(*patch.points, strict=True)]
        beside[axis] = slice(-1, None) if last else slice(0, 1)
        bounded.setdefault(patch.name, []).append(owners[patch.block][tuple(beside)].ravel())
    if not sides:
        return whole
    cells = {name: np.concatenate(parts) for name, parts in sides.items()}
    owner = np.concatenate([np.arange(whole.n_cells), *(np.concatenate(parts) for parts in bounded.values())])
    kind = "line" if next(iter(cells.values())).shape[1] == 2 else "quad"
    count, sets = whole.n_cells, {}
    for name, rows in cells.items():
        sets[name] = np.arange(count, count + len(rows))
        count += len(rows)
    return Mesh(
        whole.points,
        {**whole.cells, kind: np.concatenate(list(cells.values()))},
        point_data=whole.point_data,
        cell_data={name: values[owner] for name, values in whole.cell_data.items()},
        sets=sets,
    )


def _cell_numbers(blocks: MultiBlock) -> list[np.ndarray]:
    """(ni - 1, nj - 1, nk - 1 or 1) int for each block: numbers of its cells in the glued mesh, i running fastest."""
    starts = np.cumsum([0] + [block.n_cells for block in blocks.blocks])
    shapes = [tuple(max(n - 1, 1) for n in block.shape) for block in blocks.blocks]
    return [
        start + np.arange(np.prod(shape)).reshape(shape[::-1]).swapaxes(0, 2)
        for start, shape in zip(starts, shapes, strict=False)
    ]


def _cells(nodes: np.ndarray) -> np.ndarray:
    """(k, 2) or (k, 4) int: lines or quads of a side's points (n, m)."""
    if nodes.shape[1] == 1:
        return np.column_stack([nodes[:-1, 0], nodes[1:, 0]])
    return np.stack([nodes[:-1, :-1], nodes[1:, :-1], nodes[1:, 1:], nodes[:-1, 1:]], axis=-1).reshape(-1, 4)
