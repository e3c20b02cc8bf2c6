"""The six faces of a block: found, put into their places, turned, given their points, and joined at their edges."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np

from ...errors import InvalidGeometry, InvalidInput
from .blending import crossing
from .sides import fractions_of

PLACES = ("imin", "imax", "jmin", "jmax", "kmin", "kmax")
AXES = "ijk"
_TURNS = [(swap, a, b) for swap, a, b in product((False, True), repeat=3)]


def end(axis: int, side: int) -> str:
    """Name of the face at the start (0) or end (1) of an axis."""
    return PLACES[2 * axis + side]


def across(place: str) -> tuple[int, int]:
    """The two axes along a face, in the order of its first two indices."""
    first, second = (a for a in range(3) if AXES[a] != place[0])
    return first, second


@dataclass(frozen=True, eq=False)
class BlockFaces:
    """Six faces that meet at their edges.

    Attributes
    ----------
    faces : dict of str to (n, m, 3) float
        By place; "imin" has indices (j, k), "jmin" (i, k), "kmin" (i, j), and so have those opposite.
    names : dict of str to str
        By place, the name under which the user gave the face.
    gap : float
        How far apart edges may be that are joined.
    warnings : list of str
        What was turned.
    """

    faces: dict[str, np.ndarray]
    names: dict[str, str]
    gap: float
    warnings: list[str] = field(default_factory=list)

    @classmethod
    def arranged(cls, given: Mapping[str, np.ndarray], gap: float, *, told: bool = True) -> BlockFaces:
        """Six faces of any direction, and in any order as long as each meets its four neighbours at the corners.

        Parameters
        ----------
        given : dict of str to (n, m, 3) float
            By place as the user sees it.
        gap : float
            Largest distance of corners that are one.
        told : bool
            Whether the faces' rows have a meaning for the user, who is then told which were turned.
        """
        corner = _corners(given, gap)
        place_of, warnings = _places(given, corner)
        faces, names = {}, {}
        at = {
            bits: next(iter(set.intersection(*(set(corner[place_of[end(a, b)]].flat) for a, b in enumerate(bits)))))
            for bits in product((0, 1), repeat=3)
        }
        for place, name in place_of.items():
            normal, side = AXES.index(place[0]), int(place.endswith("max"))
            first, second = across(place)
            wanted = np.empty((2, 2), int)
            for p, q in product((0, 1), repeat=2):
                bits = [0, 0, 0]
                bits[normal], bits[first], bits[second] = side, p, q
                wanted[p, q] = at[tuple(bits)]
            turn = next(t for t in _TURNS if (_turned(corner[name], t) == wanted).all())
            faces[place], names[place] = _turned(given[name], turn), name
            if told and turn != (False, False, False):
                warnings.append(f"{name} was turned: {_words(turn)}")
        return cls(faces, names, gap, warnings)

    @property
    def volume(self) -> float:
        """Enclosed volume, negative if the faces are left-handed."""
        total = 0.0
        middle = self.faces["imin"][0, 0]
        for place, face in self.faces.items():
            p = face - middle
            normal = 0.5 * np.cross(p[1:, 1:] - p[:-1, :-1], p[:-1, 1:] - p[1:, :-1])
            centre = 0.25 * (p[1:, 1:] + p[:-1, :-1] + p[:-1, 1:] + p[1:, :-1])
            outward = place in ("imax", "jmin", "kmax")
            total += (1 if outward else -1) * float((centre * normal).sum()) / 3
        return total

    def right_handed(self) -> BlockFaces:
        """The same, with i reversed if the faces are left-handed."""
        if self.volume >= 0:
            return self
        faces = {
            place: face if place[0] == "i" else np.ascontiguousarray(face[::-1]) for place, face in self.faces.items()
        }
        faces["imin"], faces["imax"] = faces["imax"], faces["imin"]
        names = {**self.names, "imin": self.names["imax"], "imax": self.names["imin"]}
        warnings = [*self.warnings, "the faces make a left-handed block: i was reversed"]
        return BlockFaces(faces, names, self.gap, warnings)

    def edge(self, axis: int, first: int, second: int, face: int = 0) -> np.ndarray:
        """(n, 3) float: the edge along an axis at an end of each of the two others, as one of its two faces has it."""
        others = [a for a in range(3) if a != axis]
        sides = [first, second]
        rows = self.faces[end(others[1 - face], sides[1 - face])]
        index = 0 if sides[face] == 0 else -1
        # Along the face run the axis and the other one, in the order of the axes.
        return rows[:, index] if axis < others[face] else rows[index]

    @property
    def edges(self) -> dict[tuple[int, int, int], np.ndarray]:
        """The twelve edges, by axis and the ends of the two others, as one of their two faces has them."""
        return {key: self.edge(*key) for key in product(range(3), (0, 1), (0, 1))}

    def refuse_unequal(self, cells: tuple[int | None, int | None, int | None]) -> None:
        """Raise `InvalidInput` if edges have unequal numbers of points along an axis without a number of cells."""
        for axis, asked in enumerate(cells):
            if asked is not None:
                continue
            place = next(p for p in PLACES if axis in across(p))
            counts = {p: self.faces[p].shape[across(p).index(axis)] for p in PLACES if axis in across(p)}
            other = next((p for p in counts if counts[p] != counts[place]), None)
            if other is not None:
                raise InvalidInput(
                    f"{self.names[place]} has {counts[place]} points along {AXES[axis]}, {self.names[other]} "
                    f"{counts[other]}; give cells_{AXES[axis]} to resample both",
                    parameter=self.names[other],
                )

    def resampled(self, fractions: Mapping[tuple[int, int, int], np.ndarray]) -> BlockFaces:
        """Faces whose points stand at fractions of the lengths of their edges, by axis and ends of the two others."""
        faces = {}
        for place, face in self.faces.items():
            normal, side = AXES.index(place[0]), int(place.endswith("max"))
            first, second = across(place)
            along = []
            for axis, other, edges in (
                (first, second, (face[:, 0], face[:, -1])),
                (second, first, (face[0], face[-1])),
            ):
                for bit, line in enumerate(edges):
                    ends = {normal: side, other: bit}
                    wanted = fractions[(axis, *(ends[a] for a in sorted(ends)))]
                    along.append(np.interp(wanted, fractions_of(line), np.linspace(0, 1, len(line))))
            faces[place] = _bilinear(face, *crossing(*along))
        return replace(self, faces=faces)

    def joined(self) -> BlockFaces:
        """The faces with equal points at their common edges.

        Raises
        ------
        InvalidGeometry
            If two faces are farther apart than the gap that is closed.
        """
        faces = {place: face.copy() for place, face in self.faces.items()}
        done = replace(self, faces=faces)
        for axis, a, b in product(range(3), (0, 1), (0, 1)):
            one, two = done.edge(axis, a, b, 0), done.edge(axis, a, b, 1)
            apart = float(np.linalg.norm(one - two, axis=1).max())
            others = [x for x in range(3) if x != axis]
            pair = [self.names[end(others[0], a)], self.names[end(others[1], b)]]
            if apart > self.gap:
                raise InvalidGeometry(
                    f"{pair[0]} and {pair[1]} are {apart:.6g} apart at their common edge; "
                    "move them together, or raise tolerance above that",
                    parameter=pair[0],
                )
            two[:] = one
        return done


def _corners(given: Mapping[str, np.ndarray], gap: float) -> dict[str, np.ndarray]:
    """(2, 2) int by name: the corners of the faces, numbered from 0 to 7."""
    points = np.concatenate([face[:: len(face) - 1, :: face.shape[1] - 1].reshape(4, 3) for face in given.values()])
    number = np.full(24, -1)
    apart = np.linalg.norm(points[:, None] - points[None], axis=-1)
    count = 0
    for k in range(24):
        if number[k] < 0:
            number[(number < 0) & (apart[k] <= gap)] = count
            count += 1
    names = list(given)
    sizes = np.bincount(number)
    if count == 8 and (sizes == 3).all():
        return {name: number[4 * f : 4 * f + 4].reshape(2, 2) for f, name in enumerate(names)}
    # Of a sound block each corner has two others in its place; tell the one that is farthest from that.
    third = np.sort(apart + np.where(np.arange(24)[:, None] // 4 == np.arange(24) // 4, np.inf, 0), axis=1)[:, 1]
    k = int(np.argmax(third))
    if third[k] > gap:
        raise InvalidGeometry(
            f"a corner at ({points[k][0]:.6g}, {points[k][1]:.6g}, {points[k][2]:.6g}) is {third[k]:.6g} away from "
            "those of the faces beside it; move them together, or raise tolerance above that",
            parameter=names[k // 4],
        )
    raise InvalidGeometry(
        f"the faces have {count} different corners; a block has eight, of three faces each, and no edge without length",
        parameter=names[0],
    )


def _places(given: Mapping[str, np.ndarray], corner: Mapping[str, np.ndarray]) -> tuple[dict[str, str], list[str]]:
    """By place, the name of the face that belongs there: as named, if faces named opposite are."""

    def opposite(one: str, two: str) -> bool:
        return not set(corner[one].flat) & set(corner[two].flat)

    if all(opposite(end(axis, 0), end(axis, 1)) for axis in range(3)):
        return {place: place for place in PLACES}, []
    left, found = list(given), {}
    for axis in range(3):
        one = left.pop(0)
        two = next((name for name in left if opposite(one, name)), None)
        if two is None:
            raise InvalidGeometry("is opposite no other face; give the six faces of one block", parameter=one)
        left.remove(two)
        found[end(axis, 0)], found[end(axis, 1)] = one, two
    moved = ", ".join(f"{name} is {place}" for place, name in found.items() if name != place)
    return found, [f"faces named opposite are not, so they were put into other places: {moved}"]


def _turned(face: np.ndarray, turn: tuple[bool, bool, bool]) -> np.ndarray:
    swap, first, second = turn
    face = face.swapaxes(0, 1) if swap else face
    return np.ascontiguousarray(face[:: -1 if first else 1, :: -1 if second else 1])


def _words(turn: tuple[bool, bool, bool]) -> str:
    said = ("rows and columns exchanged", "first index reversed", "second index reversed")
    return ", ".join(text for text, done in zip(said, turn, strict=True) if done)


def _bilinear(face: np.ndarray, s: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Points of a face at fractions (n, m) of its numbers of rows and columns."""
    n, m = len(face) - 1, face.shape[1] - 1
    a, b = np.clip(s, 0, 1) * n, np.clip(t, 0, 1) * m
    i, j = np.minimum(a.astype(int), n - 1), np.minimum(b.astype(int), m - 1)
    a, b = (a - i)[..., None], (b - j)[..., None]
    low = (1 - a) * face[i, j] + a * face[i + 1, j]
    high = (1 - a) * face[i, j + 1] + a * face[i + 1, j + 1]
    return (1 - b) * low + b * high
