"""Haloes: copies of the points and cells beyond cuts, so that one formula holds inside and on them (figure 14)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...errors import InvalidInput
from ...mesh import Cut, MultiBlock, StructuredGrid

_MOST_CROSSINGS = 8
"""Cuts that are crossed from a block to a place of its halo: a corner of a volume crosses three."""


class Traced(NamedTuple):
    """Where places outside blocks are found inside.

    Attributes
    ----------
    block : (m,) int
        The block that holds the place.
    place : (m, 3) int
        The place in it, in half steps: points are even, middles of cells odd.
    turn : (m, 3, 3) int
        Steps along the first block's axes (columns) as steps along the last one's.
    route : list of (Cut, (k,) int)
        The cuts in the order crossed, and which places cross them.
    known : (m,) bool
        Whether the place was found; the others are beyond a boundary.
    """

    block: np.ndarray
    place: np.ndarray
    turn: np.ndarray
    route: list[tuple[Cut, np.ndarray]]
    known: np.ndarray


def traced(block: np.ndarray, place: np.ndarray, cuts: Sequence[Cut], shapes: Sequence[Sequence[int]]) -> Traced:
    """Follow places outside blocks through cuts until they are inside one.

    Parameters
    ----------
    block : (m,) int
        Numbers of blocks.
    place : (m, 3) int
        Places in half steps, inside or outside the blocks; the cells of a surface are at k = 0 as its points are.
    cuts : sequence of Cut
        Each is crossed from either side.
    shapes : sequence of (int, int, int)
        Points of the blocks.

    Returns
    -------
    Traced
    """
    block, place = np.array(block), np.array(place)
    turn = np.broadcast_to(np.eye(3, dtype=np.int64), (len(place), 3, 3)).copy()
    last = 2 * (np.array(shapes) - 1)
    sides = [side for cut in cuts for side in (cut, cut.reversed())]
    faces = [side.face(shapes[side.block]) for side in sides]
    route: list[tuple[Cut, np.ndarray]] = []
    for _ in range(_MOST_CROSSINGS):
        moved = np.zeros(len(block), bool)
        for side, (axis, end) in zip(sides, faces, strict=True):
            beyond = place[:, axis] < 0 if end < 0 else place[:, axis] > last[side.block, axis]
            low, high = np.sort(2 * np.array(side.points), axis=0)
            others = [other for other in range(3) if other != axis]
            nearest = np.clip(place[:, others], 0, last[side.block][others])  # in corners, too, the range leads on
            over = ((nearest >= low[others]) & (nearest <= high[others])).all(axis=1)
            here = np.flatnonzero((block == side.block) & beyond & over & ~moved)
            if len(here):
                place[here] = side.across(place[here], step=2)
                block[here] = side.partner_block
                turn[here] = side.matrix @ turn[here]
                moved[here] = True
                route.append((side, here))
        if not moved.any():
            break
    known = ((place >= 0) & (place <= last[block])).all(axis=1)
    return Traced(block, place, turn, route, known)


@dataclass(frozen=True, eq=False)
class Halo:
    """A block with its halo.

    Attributes
    ----------
    grid : StructuredGrid
        The block, larger by ``width`` points on each side; the two sides of a surface have none along k. Its data are
        those of the neighbours, too.
    inside : tuple of three slices
        The block's own points in it.
    known, known_cells : (ni, nj, nk) bool
        Points and cells that are the block's own or another's. The rest, beyond boundaries, are extrapolated along the
        lines: points linearly, data of points and cells as constants.
    """

    grid: StructuredGrid
    inside: tuple[slice, slice, slice]
    known: np.ndarray
    known_cells: np.ndarray

    @property
    def inside_cells(self) -> tuple[slice, slice, slice]:
        """The block's own cells."""
        sides = zip(self.inside, self.grid.shape, strict=True)
        i, j, k = (side if n == 1 else slice(side.start, side.stop - 1) for side, n in sides)
        return i, j, k


def with_halo(grid: StructuredGrid | MultiBlock, width: int = 1) -> Halo | tuple[Halo, ...]:
    """Surround blocks with the points and cells on the other side of their cuts and periodic sides.

    Parameters
    ----------
    grid : StructuredGrid or MultiBlock
        With `cuts`, in any relative orientation, and `periodic` directions.
    width : int
        Layers of the halo.

    Returns
    -------
    Halo, or a tuple of one a block

    Raises
    ------
    InvalidInput
        If the width is not positive.

    Notes
    -----
    Points beyond a cut with a rotation or translation are moved beside the block; data are copied as they are, so that
    vectors across a rotation must be turned by the user. In corners of two cuts, the first leads.

    References
    ----------
    Survey, section 2.8.1 (figure 14).

    Examples
    --------
    >>> from meshcore import gallery, o_grid
    >>> grid, _ = o_grid(gallery.circle(24), radius=3, layers=8)
    >>> halo = with_halo(grid, 2)
    >>> halo.grid, bool((halo.grid.points[1, 2:-2] == grid.points[-2]).all())
    (StructuredGrid(29 x 13 points), True)
    """
    if not isinstance(width, (int, np.integer)) or width < 1:
        raise InvalidInput(f"is {width!r}; give a whole number of layers, 1 or more", parameter="width")
    if not isinstance(grid, (StructuredGrid, MultiBlock)):
        raise InvalidInput(f"needs a StructuredGrid or a MultiBlock, got {type(grid).__name__}", parameter="grid")
    blocks = grid.blocks if isinstance(grid, MultiBlock) else (grid,)
    haloes = tuple(_haloed(blocks, number, grid.joins, int(width)) for number in range(len(blocks)))
    return haloes if isinstance(grid, MultiBlock) else haloes[0]


class _Around(NamedTuple):
    """The halo's places of points (half = 0) or cells (half = 1) of one block, and where they come from."""

    pads: list[tuple[int, int]]
    at: np.ndarray  # (m, 3) places in the larger array that were found
    found: Traced
    known: np.ndarray  # of the larger array

    @classmethod
    def of(cls, number: int, half: int, width: int, cuts: Sequence[Cut], shapes: Sequence[Sequence[int]]) -> _Around:
        shape = np.array(shapes[number])
        flat = shape == 1
        pads = np.where(flat, 0, width)
        size = np.where(flat, 1, shape - half) + 2 * pads
        known = np.zeros(size, bool)
        known[tuple(slice(p, n - p) for p, n in zip(pads, size, strict=True))] = True
        at = np.argwhere(~known)
        place = 2 * (at - pads) + np.where(flat, 0, half)
        found = traced(np.full(len(at), number), place, cuts, shapes)
        known[tuple(at[found.known].T)] = True
        return cls([(int(p), int(p)) for p in pads], at, found, known)

    def filled(self, larger: np.ndarray, arrays: Sequence[np.ndarray]) -> np.ndarray:
        """The larger array with the values of the blocks' arrays where they were found."""
        for number, values in enumerate(arrays):
            here = self.found.known & (self.found.block == number)
            larger[tuple(self.at[here].T)] = values[tuple(self.found.place[here].T // 2)]
        return larger

    def data(self, name: str, of: Sequence[dict[str, np.ndarray]], number: int) -> np.ndarray:
        values = of[number][name]
        if missing := [k for k, data in enumerate(of) if name not in data or data[name].shape[3:] != values.shape[3:]]:
            raise InvalidInput(f"has no data {name!r} in block {missing[0]}; give it to all or none", parameter="grid")
        larger = np.pad(values, [*self.pads, *[(0, 0)] * (values.ndim - 3)], mode="edge")
        return self.filled(larger, [data[name] for data in of])


def _haloed(blocks: Sequence[StructuredGrid], number: int, cuts: Sequence[Cut], width: int) -> Halo:
    block, shapes = blocks[number], [b.shape for b in blocks]
    nodes, cells = (_Around.of(number, half, width, cuts, shapes) for half in (0, 1))
    points = nodes.filled(_straight_on(block.points, nodes.pads), [b.points for b in blocks])
    for cut, crossing in reversed(nodes.found.route):
        if cut.moves:
            where = tuple(nodes.at[crossing[nodes.found.known[crossing]]].T)
            points[where] = cut.moved(points[where], back=True)
    grid = StructuredGrid(
        points,
        {name: nodes.data(name, [b.point_data for b in blocks], number) for name in block.point_data},
        {name: cells.data(name, [b.cell_data for b in blocks], number) for name in block.cell_data},
    )
    inside = tuple(slice(p, p + n) for (p, _), n in zip(nodes.pads, block.shape, strict=True))
    return Halo(grid, inside, nodes.known, cells.known)


def _straight_on(points: np.ndarray, pads: list[tuple[int, int]]) -> np.ndarray:
    """Points with more before and after them, that go straight on in equal steps."""
    for axis, (width, _) in enumerate(pads):
        if width:
            lines = np.moveaxis(points, axis, 0)
            step = np.arange(width, 0, -1).reshape(-1, 1, 1, 1)
            before = lines[0] - step * (lines[1] - lines[0])
            after = lines[-1] + step[::-1] * (lines[-1] - lines[-2])
            points = np.moveaxis(np.concatenate([before, lines, after]), 0, axis)
    return np.array(points)
