"""Cuts: where sides of structured blocks are one line or surface in space, and how indices run on through it.

They are the 1-to-1 interfaces of CGNS: a range of points on a face, the range of the same points on the partner's face,
and a transform of the indices, which holds for points beyond the face too. So a point at j = -1 stands, across the cut
of a C-grid, at j = +1 of the partner.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InvalidGeometry, InvalidInput
from .topology import connected

if TYPE_CHECKING:
    from .structured_grid import StructuredGrid

Index = tuple[int, int, int]
Range = tuple[Index, Index]
COINCIDENT = 1e-9
"""Of the grid's extent: how far apart the two copies of a point on a cut may be."""


def as_index(numbers: ArrayLike) -> Index:
    """Three whole numbers of any kind as a tuple of int."""
    i, j, k = np.asarray(numbers).tolist()
    return int(i), int(j), int(k)


def as_range(points: ArrayLike, shape: Sequence[int]) -> Range:
    """First and last of two points of a block of this shape, or `InvalidInput`."""
    corners = np.asarray(points)
    if (corners < 0).any() or (corners >= shape).any():
        raise InvalidInput(f"the points {corners.tolist()} are beyond a block of {tuple(shape)} points")
    return as_index(corners[0]), as_index(corners[1])


@dataclass(frozen=True)
class Cut:
    """A range of points on a face of a block that are the points of another range, of the same or another block.

    ::

        C-grid:   j ^ |  |  |  wall  |  |  | ^ j       points=((0, 0, 0), (3, 0, 0)),
                    +--+--+--'     '--+--+--+          partner=((n, 0, 0), (n - 3, 0, 0)),
                    0 ---> i = 3  n - 3 ---> n         transform=(-1, -2, 3)

    Parameters
    ----------
    points : two of (int, int, int)
        First and last point of the range on this side, both included; they lie on one face.
    partner : two of (int, int, int)
        The places of the same two points on the partner's face.
    transform : (int, int, int)
        For i, j, k of this side, the partner's axis (1, 2, 3) along which it runs there, negative if backwards:
        ``partner[0] + T (index - points[0])``. Across the face it leads from outside this block into the partner.
    block, partner_block : int
        Numbers of the blocks in a `MultiBlock`; 0 in a grid.
    rotation : (3, 3) float, optional
        For sides that repeat: a point of this side, turned by it and moved, is the partner's.
    translation : (3,) float, optional
        What is added after the rotation.
    name : str
        Such as "wake".

    Raises
    ------
    InvalidInput
        If ranges and transform contradict each other.

    References
    ----------
    Survey, section 2.8.1 (figures 12 and 14). The CGNS standard interface data structures, "1-to-1 interface".

    Examples
    --------
    >>> cut = Cut(((0, 0, 0), (3, 0, 0)), ((9, 0, 0), (6, 0, 0)), (-1, -2, 3))
    >>> cut.across([[1, -1, 0]]).tolist()
    [[8, 1, 0]]
    """

    points: Range
    partner: Range
    transform: Index = (1, 2, 3)
    block: int = 0
    partner_block: int = 0
    rotation: tuple[tuple[float, ...], ...] | None = None
    translation: tuple[float, ...] | None = None
    name: str = ""

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        for name in ("points", "partner"):
            set_(self, name, tuple(_triple(p, name) for p in _pair(getattr(self, name), name)))
        set_(self, "transform", _triple(self.transform, "transform"))
        if sorted(map(abs, self.transform)) != [1, 2, 3]:
            raise InvalidInput(f"is {self.transform}; give 1, 2, 3 in any order and sign", parameter="transform")
        led = tuple(self.across([self.points[1]])[0].tolist())
        if led != self.partner[1]:
            raise InvalidInput(
                f"ends at {self.partner[1]}, but the transform leads {self.points[1]} to {led}; the two ranges "
                "need the same shape",
                parameter="partner",
            )
        if self.rotation is not None:
            set_(self, "rotation", tuple(tuple(map(float, row)) for row in self.rotation))
            turn = np.array(self.rotation)
            if turn.shape != (3, 3) or np.abs(turn @ turn.T - np.eye(3)).max() > 1e-9:
                raise InvalidInput("needs an orthogonal (3, 3) matrix", parameter="rotation")
        if self.translation is not None:
            set_(self, "translation", tuple(map(float, self.translation)))
            if len(self.translation) != 3 or not np.isfinite(self.translation).all():
                raise InvalidInput("needs three finite numbers", parameter="translation")

    @cached_property
    def matrix(self) -> np.ndarray:
        """(3, 3) int: steps along this side's axes (columns) as steps along the partner's."""
        matrix = np.zeros((3, 3), np.int64)
        for axis, to in enumerate(self.transform):
            matrix[abs(to) - 1, axis] = np.sign(to)
        return matrix

    def across(self, index: np.ndarray, step: int = 1) -> np.ndarray:
        """(m, 3) int: the places in the partner of (m, 3) places of this side.

        ``step`` 2 counts in half steps, in which the middle of a cell is an odd number.
        """
        return step * np.array(self.partner[0]) + (np.asarray(index) - step * np.array(self.points[0])) @ self.matrix.T

    @property
    def moves(self) -> bool:
        """Whether the partner's points are elsewhere: turned or moved."""
        return self.rotation is not None or self.translation is not None

    def moved(self, points: np.ndarray, *, back: bool = False) -> np.ndarray:
        """(..., 3) points of this side where the partner has them, or back."""
        turn = np.eye(3) if self.rotation is None else np.array(self.rotation)
        shift = np.zeros(3) if self.translation is None else np.array(self.translation)
        return (points - shift) @ turn if back else points @ turn.T + shift

    def reversed(self) -> Cut:
        """The same cut seen from its partner."""
        inverse = np.argmax(np.abs(self.matrix), axis=1)
        signs = self.matrix[np.arange(3), inverse]
        turn, shift = self.rotation, self.translation
        if turn is not None:
            turn = tuple(map(tuple, np.array(turn).T.tolist()))
        if shift is not None:
            back = np.array(shift) if turn is None else np.array(turn) @ np.array(shift)
            shift = tuple((-back).tolist())
        return replace(
            self,
            points=self.partner,
            partner=self.points,
            transform=tuple((signs * (inverse + 1)).tolist()),
            block=self.partner_block,
            partner_block=self.block,
            rotation=turn,
            translation=shift,
        )

    def counted_back(self, axis: int, last: int) -> Cut:
        """The same cut of a block with itself when an axis, whose last point has this number, is counted backwards."""

        def place(at: Index) -> Index:
            return as_index([last - n if a == axis else n for a, n in enumerate(at)])

        transform = tuple(-to if (a == axis) != (abs(to) - 1 == axis) else to for a, to in enumerate(self.transform))
        return replace(
            self, points=tuple(map(place, self.points)), partner=tuple(map(place, self.partner)), transform=transform
        )

    def places(self) -> np.ndarray:
        """(m, 3) int: the points of the range on this side, i running slowest."""
        axes = [np.arange(min(a, b), max(a, b) + 1) for a, b in zip(*self.points, strict=True)]
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)

    def face(self, shape: Sequence[int]) -> tuple[int, int]:
        """The axis across which the cut lies in a block of this shape, and -1 for its first or 1 for its last face."""
        for axis, (first, last) in enumerate(zip(*self.points, strict=True)):
            if shape[axis] > 1 and first == last and first in (0, shape[axis] - 1):
                return axis, -1 if first == 0 else 1
        raise InvalidInput(f"{self.points[0]} to {self.points[1]} lies on no face of the block", parameter="cuts")

    def as_data(self) -> dict[str, Any]:
        """What makes it again: ``Cut(**data)``, of numbers and text only."""
        return {key: value for key, value in asdict(self).items() if value is not None}


def closing(shape: Sequence[int], axis: int) -> Cut:
    """The cut of a block whose last points along an axis repeat its first.

    Examples
    --------
    >>> closing((5, 3, 1), 0).points, closing((5, 3, 1), 0).partner
    (((0, 0, 0), (0, 2, 0)), ((4, 0, 0), (4, 2, 0)))
    """
    end = [n - 1 for n in shape]
    first, last = list(end), [0, 0, 0]
    first[axis], last[axis] = 0, end[axis]
    return Cut(((0, 0, 0), tuple(first)), (tuple(last), tuple(end)))


def checked_cuts(cuts: Sequence[Cut], blocks: Sequence[StructuredGrid]) -> tuple[Cut, ...]:
    """The cuts, if they fit the blocks.

    Raises
    ------
    InvalidInput, InvalidGeometry
        If one is out of range, lies on no face, leads out of its partner, or its points are not the partner's.
    """
    cuts = tuple(cuts)
    for number, cut in enumerate(cuts):
        if not isinstance(cut, Cut):
            raise InvalidInput(f"number {number} is {type(cut).__name__}, not a Cut", parameter="cuts")
        try:
            for side in (cut, cut.reversed()):
                _check_side(side, blocks)
            _check_places(cut, blocks)
        except InvalidGeometry:
            raise
        except InvalidInput as error:
            raise InvalidInput(f"number {number}: {error}", parameter="cuts") from None
    return cuts


def glued(cuts: Sequence[Cut], shapes: Sequence[Sequence[int]]) -> tuple[np.ndarray, ...]:
    """For each block, numbers of the points of all blocks, C-ordered, where copies across cuts have the first's number.

    Sides that are moved or turned into each other stay apart.

    Examples
    --------
    >>> glued([closing((3, 2, 1), 0)], [(3, 2, 1)])[0].ravel().tolist()
    [0, 1, 2, 3, 0, 1]
    """
    sizes = [int(np.prod(shape)) for shape in shapes]
    starts = np.concatenate([[0], np.cumsum(sizes)])
    pairs = [
        starts[[cut.block, cut.partner_block]]
        + np.column_stack(
            [
                np.ravel_multi_index(tuple(cut.places().T), tuple(shapes[cut.block])),
                np.ravel_multi_index(tuple(cut.across(cut.places()).T), tuple(shapes[cut.partner_block])),
            ]
        )
        for cut in cuts
        if not cut.moves
    ]
    number = np.arange(starts[-1])
    if pairs:
        points, local = np.unique(np.concatenate(pairs), return_inverse=True)
        part = connected(local.reshape(-1, 2), len(points))
        _, first = np.unique(part, return_index=True)
        number[points] = points[first[part]]
    return tuple(
        number[start : start + size].reshape(shape) for start, size, shape in zip(starts, sizes, shapes, strict=False)
    )


def free_sides(shapes: Sequence[Sequence[int]], cuts: Sequence[Cut]) -> Iterator[tuple[int, int, int, np.ndarray]]:
    """The sides of blocks, and what of them no cut joins to anything.

    Yields
    ------
    block, axis, last : int
        The block, the axis across which the side lies, and 0 for its first or 1 for its last points.
    free : (n, m) bool
        For each cell of the side, in the order of the other two axes, one layer where there is one point.

    Examples
    --------
    >>> [(axis, last, bool(free.any())) for _, axis, last, free in free_sides([(3, 2, 1)], [closing((3, 2, 1), 0)])]
    [(0, 0, False), (0, 1, False), (1, 0, True), (1, 1, True)]
    """
    sides = [side for cut in cuts for side in (cut, cut.reversed())]
    for block, shape in enumerate(shapes):
        for axis in [a for a in range(3) if shape[a] > 1]:
            for last in (0, 1):
                free = np.ones([max(n - 1, 1) for a, n in enumerate(shape) if a != axis], bool)
                for side in sides:
                    if side.block == block and side.face(shape) == (axis, 2 * last - 1):
                        low, high = np.delete(np.sort(side.points, axis=0), axis, axis=1)
                        free[tuple(slice(a, max(b, a + 1)) for a, b in zip(low, high, strict=True))] = False
                yield block, axis, last, free


def _check_side(cut: Cut, blocks: Sequence[StructuredGrid]) -> None:
    """Raise if the range is not on a face of its block, or what lies beyond it is not inside the partner."""
    for number in (cut.block, cut.partner_block):
        if not 0 <= number < len(blocks):
            raise InvalidInput(f"there is no block {number}")
    shape, other = blocks[cut.block].shape, blocks[cut.partner_block].shape
    for place in cut.points:
        if not all(0 <= p < n for p, n in zip(place, shape, strict=True)):
            raise InvalidInput(f"{place} is no point of block {cut.block}, which has {shape}")
    axis, side = cut.face(shape)
    beyond = np.array(cut.points[0])
    beyond[axis] += side
    led = cut.across([beyond])[0]
    if not ((led >= 0) & (led < other)).all():
        raise InvalidInput(
            f"its transform {cut.transform} leads from outside block {cut.block} to outside block {cut.partner_block}; "
            "turn the sign of the axis across the cut"
        )


def _check_places(cut: Cut, blocks: Sequence[StructuredGrid]) -> None:
    """Raise if points of the two sides are not the same."""
    here, there = blocks[cut.block], blocks[cut.partner_block]
    place = cut.places()
    apart = cut.moved(here.points[tuple(place.T)]) - there.points[tuple(cut.across(place).T)]
    away = np.linalg.norm(apart, axis=1)
    allowed = COINCIDENT * max(here.diagonal, there.diagonal)
    if away.max() > allowed:
        worst = int(np.argmax(away))
        raise InvalidGeometry(
            f"point {tuple(place[worst].tolist())} of block {cut.block} is {away[worst]:.4g} from its partner "
            f"{tuple(cut.across(place[worst : worst + 1])[0].tolist())} in block {cut.partner_block}; "
            f"{allowed:.4g} is allowed",
            parameter="cuts",
            points=np.ravel_multi_index(tuple(place[away > allowed].T), here.shape, order="F"),
        )


def _pair(value: Any, name: str) -> Sequence:
    if not isinstance(value, (tuple, list, np.ndarray)) or len(value) != 2:
        raise InvalidInput("needs the first and the last point", parameter=name)
    return value


def _triple(value: Any, name: str) -> Index:
    try:
        triple = tuple(int(v) for v in value)
        same = all(a == b for a, b in zip(triple, value, strict=True))
    except (TypeError, ValueError):
        triple, same = (), False
    if len(triple) != 3 or not same:
        raise InvalidInput(f"needs three whole numbers, got {value!r}", parameter=name)
    return triple
