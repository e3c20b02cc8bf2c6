"""The twelve edges of a block: put into their places, given their points, and spanned by faces (survey 2.6)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations, product

import numpy as np

from ...errors import InvalidGeometry, InvalidInput
from ...geometry.curves import arc_length, resampled
from ...operation import Length, absolute
from ...sizing import Spacing, copied
from ..limits import check_size
from .blending import Patch
from .block_faces import AXES, PLACES, BlockFaces, across, end
from .quad_nets import along_axes
from .sides import fractions_of

Edges = dict[tuple[int, int, int], np.ndarray]
"""By axis and the ends of the two others (in order): points in the direction of the axis."""


def arranged(curves: Sequence[np.ndarray], gap: float, parameter: str) -> Edges:
    """Twelve curves in any order and direction as the edges of a block.

    i, j and k begin in the corner with the least x + y + z and run along x, y and z, as nearly as can be.

    Raises
    ------
    InvalidGeometry
        If they are not the edges of a block: twelve, that meet by threes in eight corners.
    """
    ends = np.array([[curve[0], curve[-1]] for curve in curves]).reshape(-1, 3)
    number = np.full(len(ends), -1)
    corners: list[np.ndarray] = []
    for k, point in enumerate(ends):
        if number[k] < 0:
            number[(number < 0) & (np.linalg.norm(ends - point, axis=1) <= gap)] = len(corners)
            corners.append(point)
    pairs = [tuple(pair) for pair in number.reshape(-1, 2).tolist()]
    meeting = np.bincount(number, minlength=8)
    if len(curves) != 12 or len(corners) != 8 or (meeting != 3).any() or any(a == b for a, b in pairs):
        raise InvalidGeometry(
            f"needs the twelve edges of a block, which meet by threes in eight corners; there are {len(curves)} "
            f"with {len(corners)} different ends",
            parameter=parameter,
        )
    beside = {c: [b if a == c else a for a, b in pairs if c in (a, b)] for c in range(8)}
    start = min(range(8), key=lambda c: (float(corners[c].sum()), c))
    leaving = [_away(curves, pairs, start, other) for other in beside[start]]
    axes = [beside[start][a] for a in along_axes(np.array(leaving))]
    at = {(0, 0, 0): start}
    for axis, corner in enumerate(axes):
        at[tuple(int(a == axis) for a in range(3))] = corner
    for one, two in combinations(range(3), 2):
        shared = (set(beside[axes[one]]) & set(beside[axes[two]])) - {start}
        if len(shared) != 1:
            raise InvalidGeometry("meet in eight corners, but not as the edges of a block do", parameter=parameter)
        at[tuple(int(a in (one, two)) for a in range(3))] = shared.pop()
    at[1, 1, 1] = next(iter(set(range(8)) - set(at.values())))
    found: Edges = {}
    for axis, a, b in product(range(3), (0, 1), (0, 1)):
        low, high = ([*(a, b)[:axis], side, *(a, b)[axis:]] for side in (0, 1))
        first, last = at[tuple(low)], at[tuple(high)]
        k = next((k for k, pair in enumerate(pairs) if set(pair) == {first, last}), None)
        if k is None:
            raise InvalidGeometry("meet in eight corners, but not as the edges of a block do", parameter=parameter)
        line = (curves[k] if pairs[k][0] == first else curves[k][::-1]).copy()
        line[0], line[-1] = corners[first], corners[last]
        found[axis, a, b] = line
    return found


def _away(curves, pairs, start: int, other: int) -> np.ndarray:
    """From a corner to the other end of the edge there."""
    k = next(k for k, pair in enumerate(pairs) if set(pair) == {start, other})
    line = curves[k] if pairs[k][0] == start else curves[k][::-1]
    return line[-1] - line[0]


@dataclass(frozen=True)
class Asked:
    """What the user asks of the points on the edges.

    Attributes
    ----------
    cells : tuple of three int or None
        Numbers of cells along i, j, k.
    law : str
        "as given", or a law of `Spacing`.
    ends : dict of str to Length or None
        By the user's name of a face, the size of the cells that touch it.
    diagonal : float
        What relative lengths are relative to.
    spacings : dict of str to Spacing
        By the user's name of an axis ("i", "j" or "k"), a spacing of its edges in place of law and ends, from the face
        named "min".
    """

    cells: tuple[int | None, int | None, int | None]
    law: str
    ends: Mapping[str, Length | None]
    diagonal: float
    spacings: Mapping[str, Spacing] = field(default_factory=dict)

    def check_size(self, edges: Edges) -> None:
        """Refuse what would fill the memory."""
        counts = [max(len(line) for key, line in edges.items() if key[0] == axis) for axis in range(3)]
        shape = [count if asked is None else asked + 1 for asked, count in zip(self.cells, counts, strict=True)]
        check_size(*shape, parameter=f"cells_{AXES[int(np.argmax(shape))]}")

    def fractions(self, edges: Edges, names: Mapping[str, str]) -> Edges | None:
        """Fractions of length of the points on each edge; None if all edges keep theirs."""
        found, changed = {}, False
        for axis in range(3):
            places = end(axis, 0), end(axis, 1)
            keys = [key for key in edges if key[0] == axis]
            count = self.cells[axis] or max(len(edges[key]) for key in keys) - 1
            spacing = self.along([names[place] for place in places])
            for key in keys:
                line = edges[key]
                keeps = spacing is None and len(line) == count + 1
                changed |= not keeps
                if keeps:
                    found[key] = fractions_of(line)
                elif spacing is None:
                    found[key] = copied(count, line)
                else:
                    found[key] = self.spaced(spacing, count, line, [names[place] for place in places])
        return found if changed else None

    def along(self, names: Sequence[str]) -> Spacing | None:
        """The spacing of the edges between two faces of these names; None if they keep theirs."""
        if names[0][0] in self.spacings:
            return self.spacings[names[0][0]]
        first, last = (self.ends[name] for name in names)
        if self.law == "as given" and first is None and last is None:
            return None
        try:
            return Spacing("hyperbolic tangent" if self.law == "as given" else self.law, first=first, last=last)
        except InvalidInput as error:
            name = names[error.parameter == "last"]
            raise InvalidInput(str(error).partition(": ")[2], parameter=f"spacing_{name}") from None

    def spaced(self, spacing: Spacing, count: int, line: np.ndarray, names: Sequence[str]) -> np.ndarray:
        """Fractions of an edge's length at which its points are to be."""
        own = names[0][0] in self.spacings
        backwards = own and names[0].endswith("max")
        try:
            found = spacing.fractions(count, line[::-1] if backwards else line, diagonal=self.diagonal)
            return 1 - found[::-1] if backwards else found
        except InvalidInput as error:
            if own:
                raise InvalidInput(f"{error}; change it or the number of cells", parameter="spacings") from None
            if error.parameter not in ("first", "last"):
                raise
            size = absolute(getattr(spacing, error.parameter), self.diagonal)
            raise InvalidInput(
                f"{size:.6g} does not fit an edge of length {arc_length(line)[-1]:.6g} with {count} cells: {error}; "
                "change it or the number of cells",
                parameter=f"spacing_{names[error.parameter == 'last']}",
            ) from None


def checked_spacings(spacings: Mapping[str, Spacing] | None) -> dict[str, Spacing]:
    """Spacings by axis, or `InvalidInput` if they are of what is no axis, or are no spacings.

    Examples
    --------
    >>> checked_spacings({"i": 0.1})
    Traceback (most recent call last):
    ...
    meshcore.errors.InvalidInput: spacings: needs a Spacing for "i", "j" or "k", got float for 'i'
    """
    if not isinstance(spacings, (Mapping, type(None))):
        raise InvalidInput(f'needs a dict by "i", "j" and "k", got {type(spacings).__name__}', parameter="spacings")
    for axis, spacing in (spacings or {}).items():
        if axis not in tuple(AXES) or not isinstance(spacing, Spacing):
            raise InvalidInput(
                f'needs a Spacing for "i", "j" or "k", got {type(spacing).__name__} for {axis!r}', parameter="spacings"
            )
    return dict(spacings or {})


def refuse_unequal(edges: Edges, cells: tuple[int | None, int | None, int | None], parameter: str) -> None:
    """Raise `InvalidInput` if parallel edges have unequal numbers of points, and no number of cells is given."""
    for axis in range(3):
        counts = sorted({len(line) for key, line in edges.items() if key[0] == axis})
        if len(counts) > 1 and cells[axis] is None:
            raise InvalidInput(
                f"has {counts[0]} and {counts[-1]} points on edges along {AXES[axis]}; "
                f"give cells_{AXES[axis]} to resample them",
                parameter=parameter,
            )


def spanned(edges: Edges, fractions: Edges | None, blending: str, gap: float) -> BlockFaces:
    """Faces by transfinite interpolation between edges, which get points at fractions of their lengths first."""
    lines = edges if fractions is None else {key: resampled(line, fractions[key]) for key, line in edges.items()}
    faces = {}
    for place in PLACES:
        normal, side = AXES.index(place[0]), int(place.endswith("max"))
        first, second = across(place)
        at = {}
        for axis, other, names in ((first, second, ("south", "north")), (second, first, ("west", "east"))):
            for bit, name in enumerate(names):
                ends = {normal: side, other: bit}
                at[name] = lines[(axis, *(ends[a] for a in sorted(ends)))]
        faces[place] = Patch(**at, blending=blending).points()
    return BlockFaces(faces, {place: place for place in PLACES}, gap)
