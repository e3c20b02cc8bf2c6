"""Opposite faces of a block that are alike: the one is the other moved or turned, and the grid runs on through both.

Along such a direction arrays have one layer more, a ghost: layer 0 is the image of layer n under the inverse motion,
and layer n + 1 that of layer 1, so that layers 1 to n are unknown, as in the plane (`winslow_levels`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ...errors import InvalidInput
from ...mesh.extent import extents
from ...threads import Workers
from ..algebraic.block_faces import AXES, end
from .transfer import Line, Table, Transfer

ALIKE = 1e-6
"""Part of the block's extent by which points of faces may differ from images of each other."""
FEWEST_ALIKE = 0.1
"""Part of the points of two faces that must be alike, if the others are walls."""
# What tells the motion: both faces as a whole, or three rows at an end of theirs, as up- and downstream of blades.
_PARTS = (np.s_[:], np.s_[:3], np.s_[-3:], np.s_[:, :3], np.s_[:, -3:])


@dataclass(frozen=True, eq=False)
class Motion:
    """A rotation about some axis, then a translation.

    Parameters
    ----------
    turn : (3, 3) float
        Proper orthogonal matrix.
    way : (3,) float
        Translation.

    Examples
    --------
    >>> quarter = Motion(np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]), np.array([0.0, 0, 2]))
    >>> quarter.moved(np.array([1.0, 0, 0])), quarter.inverse.moved(np.array([0.0, 1, 2]))
    (array([0., 1., 2.]), array([1., 0., 0.]))
    """

    turn: np.ndarray = field(default_factory=lambda: np.eye(3))
    way: np.ndarray = field(default_factory=lambda: np.zeros(3))

    @classmethod
    def between(cls, first: np.ndarray, last: np.ndarray) -> Motion:
        """The motion that brings (n, 3) points nearest to others (W. Kabsch, Acta Cryst. A32, 1976).

        A translation alone, or none, is preferred if it does as well.
        """
        extent = float(np.ptp(np.concatenate([first, last]), axis=0).max())
        way = (last - first).mean(axis=0)
        if np.abs(last - first - way).max() <= ALIKE * extent:
            return cls(way=way if np.abs(way).max() > ALIKE * extent else np.zeros(3))
        middle, other = first.mean(axis=0), last.mean(axis=0)
        u, _, v = np.linalg.svd((first - middle).T @ (last - other))
        turn = (u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ v))]) @ v).T
        return cls(turn, other - turn @ middle)

    @property
    def is_turn(self) -> bool:
        """Whether it is no mere translation."""
        return bool((self.turn != np.eye(3)).any())

    @property
    def is_none(self) -> bool:
        """Whether nothing moves: the faces of O-type blocks coincide."""
        return not self.is_turn and not self.way.any()

    @property
    def inverse(self) -> Motion:
        """What takes it back."""
        return Motion(self.turn.T, -self.turn.T @ self.way)

    def moved(self, points: np.ndarray) -> np.ndarray:
        """Images of (..., 3) points."""
        return self.turned(points) + self.way

    def turned(self, vectors: np.ndarray) -> np.ndarray:
        """Images of (..., 3) differences of points."""
        if not self.is_turn:
            return vectors
        # Not a matrix product, which may round otherwise for other numbers of points.
        return sum(vectors[..., q, None] * self.turn[:, q] for q in range(3))

    def scaled(self, centre: np.ndarray, size: float) -> Motion:
        """The same motion in coordinates ``(x - centre) / size``."""
        return Motion(self.turn, (self.turned(centre) + self.way - centre) / size)


@dataclass(frozen=True, eq=False)
class Pair:
    """Two opposite faces that are alike.

    Attributes
    ----------
    axis : int
        Across which they lie.
    motion : Motion
        From the first face to the last.
    kept : (na, nb) bool, optional
        Where the faces are not alike, and beside it: walls, such as blades, whose points stay.
    """

    axis: int
    motion: Motion
    kept: np.ndarray | None = None

    @classmethod
    def found(cls, points: np.ndarray, axis: int) -> Pair:
        """The pair across an axis of a (ni, nj, nk, 3) block.

        Raises
        ------
        InvalidInput
            If the faces are not alike, or there are fewer than three cells between them.
        """
        names = f"{end(axis, 0)} and {end(axis, 1)}"
        if points.shape[axis] < 4:
            raise InvalidInput(
                f"needs three cells or more between {names}, got {points.shape[axis] - 1}", parameter="periodic"
            )
        first, last = (points.take(layer, axis) for layer in (0, -1))
        tolerance = ALIKE * float(extents(points).max())
        motions = [Motion.between(first[part].reshape(-1, 3), last[part].reshape(-1, 3)) for part in _PARTS]
        off = [np.abs(motion.moved(first) - last).max(axis=-1) for motion in motions]
        best = int(np.argmax([(distance <= tolerance).sum() for distance in off]))
        alike = off[best] <= tolerance
        if alike.mean() < FEWEST_ALIKE:
            raise InvalidInput(
                f"needs {names} to be alike, the one moved or turned, but however it is moved, points differ by up to "
                f"{off[0].max():.4g}",
                parameter="periodic",
            )
        if alike.all():
            return cls(axis, motions[best])
        return cls(axis, Motion.between(first[alike], last[alike]), _widened(~alike))

    @property
    def told(self) -> str:
        """What users are told of faces that are walls in part."""
        walls, whole = int(self.kept.sum()), self.kept.size
        return (
            f"{end(self.axis, 0)} and {end(self.axis, 1)} are alike but for walls, whose points stay: "
            f"{walls:,} of {whole:,}"
        )

    def scaled(self, centre: np.ndarray, size: float) -> Pair:
        """The same in coordinates ``(x - centre) / size``."""
        return Pair(self.axis, self.motion.scaled(centre, size), self.kept)

    def close(self, points: np.ndarray, boundary: np.ndarray, free: tuple[slice, ...]) -> None:
        """Make the last face of (ni, nj, nk, 3) points the image of the first where they are ``free``; others stay."""
        at = [s for axis, s in enumerate(free) if axis != self.axis]
        lines, given = (np.moveaxis(values, self.axis, 0) for values in (points, boundary))
        lines[(-1, *at)] = self.motion.moved(lines[(0, *at)])
        if self.kept is not None:
            for layer in (0, -1):
                lines[layer][self.kept] = given[layer][self.kept]

    def coarsened(self, transfer: Transfer) -> Pair:
        """The same of a coarser grid."""
        if self.kept is None:
            return self
        share = self.kept.astype(float)
        for place, axis in enumerate(axis for axis in range(3) if axis != self.axis):
            index, weight = transfer.lines[axis].to_coarse
            index, weight = index[: transfer.lines[axis].coarse + 1], weight[: transfer.lines[axis].coarse + 1]
            rows = np.moveaxis(share, place, 0)
            share = np.moveaxis((rows[index] * weight[:, :, None]).sum(axis=1), 0, place)
        return Pair(self.axis, self.motion, share >= 0.5)


def _widened(kept: np.ndarray) -> np.ndarray:
    """With the nodes beside them: the edges of blades, where both faces meet the cut."""
    wide = kept.copy()
    for axis in (0, 1):
        rows, more = np.moveaxis(kept, axis, 0), np.moveaxis(wide, axis, 0)
        more[1:] |= rows[:-1]
        more[:-1] |= rows[1:]
    return wide


def pairs_of(points: np.ndarray, axes: Sequence[int], given: Sequence[bool] = (False,) * 3) -> list[Pair]:
    """Pairs across the axes that are asked for, ``given`` by the grid, or whose faces coincide.

    Parameters
    ----------
    points : (ni, nj, nk, 3) float
        A block.
    axes : sequence of int
        Where faces shall be alike.
    given : three bool
        Where the block says that it is periodic.
    """
    extent = float(extents(points).max())
    pairs = []
    for axis in range(3):
        lines = np.moveaxis(points, axis, 0)
        coincide = len(lines) > 3 and np.abs(lines[-1] - lines[0]).max() <= 1e-9 * extent
        if axis in axes or given[axis] or (coincide and np.abs(lines[1] - lines[0]).max() > 1e-9 * extent):
            pairs.append(Pair.found(points, axis))
    return pairs


def averaged_at_cuts(values: np.ndarray, pairs: Sequence[Pair]) -> np.ndarray:
    """(m, ni, nj, nk) numbers that are the same on both faces of each pair: the mean of what they were."""
    values = values.copy()
    for pair in pairs:
        rows = np.moveaxis(values, 1 + pair.axis, 0)
        mean = 0.5 * (rows[0] + rows[-1])
        for row in (rows[0], rows[-1]):
            row[...] = mean if pair.kept is None else np.where(pair.kept, row, mean)
    return values


def asked_axes(periodic: str) -> tuple[int, ...]:
    """Numbers of the directions in words like "i and k"; none for "none".

    Examples
    --------
    >>> asked_axes("i and k"), asked_axes("none")
    ((0, 2), ())
    """
    return () if periodic == "none" else tuple(AXES.index(name) for name in periodic.split(" and "))


class CyclicLine(Line):
    """Both grids of a direction that runs on; tables have a row for the ghost, too.

    Ghosts of points and of defects are set by `Ghosts` afterwards; those of numbers are averaged like their image.
    """

    @property
    def to_fine(self) -> Table:
        """Linear interpolation from coarse to fine; nothing for the ghost."""
        return _with_row(super().to_fine)

    @property
    def to_coarse(self) -> Table:
        """Linear interpolation from fine to coarse; nothing for the ghost."""
        return _with_row(super().to_coarse)

    @property
    def averages(self) -> Table:
        """Means under hats as wide as coarse cells, of which that of the cut reaches over it."""
        ratio = self.fine / self.coarse
        at = np.arange(1, self.coarse + 1) * ratio
        index = np.rint(at).astype(np.int64)[:, None] + np.arange(-2, 3)
        weight = np.maximum(0.0, 1 - np.abs(index - at[:, None]) / ratio)
        weight /= weight.sum(axis=1, keepdims=True)
        order = [-1, *range(self.coarse), 0]
        return np.clip(index, 0, self.fine + 1)[order], weight[order]


def _with_row(table: Table) -> Table:
    index, weight = (np.concatenate([values, np.zeros((1, 2), values.dtype)]) for values in table)
    return index, weight


class Ghosts:
    """The ghost layers of (3, ni, nj, nk) arrays of a block, for all of its pairs.

    Parameters
    ----------
    pairs : sequence of Pair
        In the arrays' coordinates.
    """

    def __init__(self, pairs: Sequence[Pair] = ()):
        self.pairs = tuple(pairs)
        self.closed = tuple(any(pair.axis == axis for pair in pairs) for axis in range(3))

    @property
    def whole(self) -> tuple[bool, bool, bool]:
        """Along which directions the block runs on everywhere."""
        i, j, k = (any(p.axis == axis and p.kept is None for p in self.pairs) for axis in range(3))
        return i, j, k

    def nodes(self, shape: Sequence[int]) -> tuple[int, ...]:
        """How many nodes there are along each direction without ghosts."""
        return tuple(n - closed for n, closed in zip(shape, self.closed, strict=True))

    def without(self, values: np.ndarray) -> np.ndarray:
        """A view of (m, ni, nj, nk) values without ghosts."""
        return values[(slice(None), *(slice(None, n) for n in self.nodes(values.shape[1:])))]

    def added(self, values: np.ndarray) -> np.ndarray:
        """(m, ni, nj, nk) values with room for ghosts, which for numbers are right: the image of the second layer."""
        for pair in self.pairs:
            rows = np.moveaxis(values, 1 + pair.axis, 0)
            values = np.moveaxis(np.concatenate([rows, rows[1:2]]), 0, 1 + pair.axis)
        return values

    def wrap(self, x: np.ndarray) -> None:
        """Set the ghosts of points, and the first layer from the last."""
        for pair in self.pairs:
            rows = np.moveaxis(x, (1 + pair.axis, 0), (0, -1))
            image = pair.motion.inverse.moved(rows[-2])
            rows[0] = image if pair.kept is None else np.where(self._over(pair)[..., None], rows[0], image)
            rows[-1] = pair.motion.moved(rows[1])

    def wrap_vectors(self, d: np.ndarray) -> None:
        """Set the ghosts of vectors, such as defects."""
        for pair in self.pairs:
            rows = np.moveaxis(d, (1 + pair.axis, 0), (0, -1))
            rows[0], rows[-1] = pair.motion.inverse.turned(rows[-2]), pair.motion.turned(rows[1])

    def kept(self, shape: Sequence[int]) -> np.ndarray:
        """Flat bytes that tell which nodes of arrays of that shape are no unknowns though on a cut; or none."""
        if all(pair.kept is None for pair in self.pairs):
            return np.zeros(0, np.uint8)
        kept = np.zeros(shape, np.uint8)
        for pair in self.pairs:
            if pair.kept is not None:
                np.moveaxis(kept, pair.axis, 0)[-2] |= self._over(pair)
        return kept.reshape(-1)

    def wall(self, face: str) -> np.ndarray | None:
        """(na, nb) bool: which nodes of a face are a wall, if not all are."""
        return next((pair.kept for pair in self.pairs if pair.axis == AXES.index(face[0])), None)

    def _over(self, pair: Pair) -> np.ndarray:
        """A pair's kept nodes, with ghosts where other directions run on."""
        along = [axis for axis in range(3) if axis != pair.axis]
        return np.pad(pair.kept, [(0, int(self.closed[axis])) for axis in along], mode="edge")

    def transfer(self, lines: Sequence[Line], workers: Workers) -> Transfer:
        """Transfer to a coarser grid, along those lines without ghosts."""
        lines = tuple(
            CyclicLine(line.fine, line.coarse) if closed else line
            for line, closed in zip(lines, self.closed, strict=True)
        )
        kept = [(pair.axis, self._over(pair)) for pair in self.pairs if pair.kept is not None]
        return _KeepingTransfer(lines, workers, kept) if kept else Transfer(lines, workers)

    def coarsened(self, transfer: Transfer) -> Ghosts:
        """Those of a coarser grid."""
        return Ghosts([pair.coarsened(transfer) for pair in self.pairs])


@dataclass(frozen=True)
class _KeepingTransfer(Transfer):
    """Transfer that leaves nodes alone which are kept on the layers of a cut."""

    kept: Sequence[tuple[int, np.ndarray]] = ()

    def add(self, coarse: np.ndarray, factor: float, fine: np.ndarray) -> None:
        """Add ``factor`` times the values that are interpolated from (m, *coarse shape) to ``fine``."""
        layers = [np.moveaxis(fine, 1 + axis, 0)[layer] for axis, _ in self.kept for layer in (0, -2)]
        before = [layer.copy() for layer in layers]
        super().add(coarse, factor, fine)
        for number, (layer, values) in enumerate(zip(layers, before, strict=True)):
            kept = self.kept[number // 2][1]
            layer[:, kept] = values[:, kept]
