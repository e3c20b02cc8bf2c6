"""The four sides of a patch: read, turned so that they meet as drawn, joined, and given their points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import permutations, product

import numpy as np

from ...errors import InvalidGeometry, InvalidInput
from ...geometry.curves import Curve, arc_length, chains, polyline, resampled
from ...mesh import Mesh
from ...operation import Length, absolute
from ...sizing import Spacing, copied
from ..limits import check_extent
from .one_boundary import cut_loop, four_chains, joined_ends

NAMES = ("south", "east", "north", "west")


@dataclass(frozen=True, eq=False)
class Sides:
    """Four polylines that meet at their ends, right-handed where they lie in a plane of constant z.

    Attributes
    ----------
    lines : dict of str to (n, 3) float
        By the place that the side now has: south and north run along i, west and east along j.
    names : dict of str to str
        By place, the name under which the user gave it: in a patch that had to be turned, "west" stands in the east.
    gap : float
        How far apart ends may be that are joined.
    loop : bool
        Whether the sides were cut from a loop, so that nobody can know how many points each has.
    named : bool
        Whether the user named the sides, and wants to know what was turned.
    warnings : list of str
        What was turned.
    """

    lines: dict[str, np.ndarray]
    names: dict[str, str]
    gap: float
    loop: bool = False
    named: bool = True
    warnings: list[str] = field(default_factory=list)

    @property
    def diagonal(self) -> float:
        """Length of the bounding box's diagonal."""
        return float(np.linalg.norm(np.ptp(np.concatenate(list(self.lines.values())), axis=0)))

    @property
    def turned(self) -> bool:
        """Whether i was reversed."""
        return self.names["west"] != "west"

    @classmethod
    def read(
        cls,
        given: Mapping[str, Curve | None],
        corners: tuple[int, ...],
        tolerance: Length,
        shift_corners: tuple[int, ...] = (0, 0, 0, 0),
    ) -> Sides:
        """The sides as the user gave them: all four, or as south alone one closed loop, or four chains."""
        named = True
        missing = [name for name, side in given.items() if side is None]
        names = dict(zip(NAMES, NAMES, strict=True))
        if missing == ["east", "north", "west"]:
            apart = four_chains(given["south"])
            if apart is None:
                return cls._of_loop(given["south"], corners, tolerance, shift_corners)
            given, missing = dict(zip(NAMES, apart, strict=True)), []
            named = False
        if missing:
            raise InvalidInput("is missing; give all four sides, or one closed loop as south", parameter=missing[0])
        read = {name: polyline(side, name) for name, side in given.items()}
        for name, line in read.items():
            check_extent(line, parameter=name)
        extent = check_extent(np.concatenate(list(read.values())), parameter="south")
        gap = absolute(tolerance, extent)
        numbers = {name: _numbers(side) for name, side in given.items()} if named else {}
        lines, reversed_ = _joined(read, gap, numbers)
        warnings = [f"{name} ran the other way and was reversed" for name in reversed_ if named]
        return cls(lines, names, gap, named=named, warnings=warnings)._right_handed()

    @classmethod
    def _of_loop(cls, curve: Curve, corners: tuple[int, ...], tolerance: Length, shifts: tuple[int, ...]) -> Sides:
        """The sides that a loop, closed or within tolerance of it, is cut into."""
        mesh = curve if isinstance(curve, Mesh) else Mesh(curve, {})
        used = mesh.points[np.unique(mesh.get("line"))] if len(mesh.get("line")) else polyline(mesh, "south")
        gap = absolute(tolerance, check_extent(used, parameter="south"))
        lines = dict(zip(NAMES, cut_loop(joined_ends(mesh, gap), corners, shifts), strict=True))
        return cls(lines, dict(zip(NAMES, NAMES, strict=True)), gap, loop=True, named=False)._right_handed()

    def _right_handed(self) -> Sides:
        """The same; in a plane of constant z, with i reversed if the sides run clockwise."""
        south, east, north, west = (self.lines[name] for name in NAMES)
        x, y, z = np.concatenate([south[:-1], east[:-1], north[:0:-1], west[:0:-1]]).T
        clockwise = (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() < 0
        if not clockwise or not (z == z[0]).all():
            return self
        lines = dict(zip(NAMES, (south[::-1], west, north[::-1], east), strict=True))
        names = dict(zip(NAMES, ("south", "west", "north", "east"), strict=True))
        warnings = ["the sides run clockwise: i was reversed, and runs from east to west"] if self.named else []
        return replace(self, lines=lines, names=names, warnings=self.warnings + warnings)

    def refuse_repeats(self) -> None:
        """Raise `InvalidGeometry` if neighbouring points of a side coincide."""
        for place, side in self.lines.items():
            repeated = np.flatnonzero((side[1:] == side[:-1]).all(axis=1))
            if len(repeated):
                raise InvalidGeometry(
                    f"points {repeated[0]} and {repeated[0] + 1} coincide; "
                    "remove one, or resample by cells_i and cells_j",
                    parameter=self.names[place],
                    points=repeated,
                )

    def resampled(self, fractions: Mapping[str, np.ndarray | None]) -> Sides:
        """The sides with points at fractions of their lengths, or as they are where those are None."""
        lines = {
            place: line if fractions[place] is None else resampled(line, fractions[place])
            for place, line in self.lines.items()
        }
        return replace(self, lines=lines)


def fractions_of(side: np.ndarray) -> np.ndarray:
    """(n,) float: fraction of a polyline's length up to each point."""
    length = arc_length(side)
    return length / length[-1]


@dataclass(frozen=True)
class Asked:
    """What the user asks of the points on the sides.

    Attributes
    ----------
    cells_i, cells_j : int or None
        Numbers of cells.
    law_i, law_j : str
        "as given", or a law of `Spacing` for the sides along i and along j.
    ends : dict of str to Length or None
        By the user's name of a side, the length of the cells that touch it.
    spacings : dict of str to Spacing
        By the user's name of a side, its own law, in the direction in which it is drawn.
    """

    cells_i: int | None
    cells_j: int | None
    law_i: str
    law_j: str
    ends: Mapping[str, Length | None]
    spacings: Mapping[str, Spacing]

    def cells(self, sides: Sides) -> tuple[int, int]:
        """Cells along i and j, at least; what the sides do not agree on is found out by `fractions`."""
        lines = sides.lines
        along_i = self.cells_i or max(len(lines["south"]), len(lines["north"])) - 1
        return along_i, self.cells_j or max(len(lines["west"]), len(lines["east"])) - 1

    def fractions(self, sides: Sides) -> dict[str, np.ndarray | None]:
        """By place, fractions of length at which a side gets its points; None where it keeps its own."""
        found: dict[str, np.ndarray | None] = {}
        for pair, between, law, given, parameter in (
            (("south", "north"), ("west", "east"), self.law_i, self.cells_i, "cells_i"),
            (("west", "east"), ("south", "north"), self.law_j, self.cells_j, "cells_j"),
        ):
            names = tuple(sides.names[place] for place in pair)
            counts = [len(sides.lines[place]) - 1 for place in pair]
            if given is None and counts[0] != counts[1] and not sides.loop:
                raise InvalidInput(
                    f"{names[0]} has {counts[0] + 1} points, {names[1]} {counts[1] + 1}; "
                    f"give {parameter} to resample both",
                    parameter=names[1],
                )
            cells = given or max(counts)
            for place in pair:
                spacing = self._spacing(sides, pair, between, place, law)
                found[place] = self._along(sides, place, cells, spacing, between)
        return found

    def _spacing(self, sides: Sides, pair, between, place: str, law: str) -> Spacing | None:
        """The law of one side, in the direction in which it now runs; None if it keeps its own spacing."""
        if sides.names[place] in self.spacings:
            return self.spacings[sides.names[place]]
        first, last = (self.ends[sides.names[end]] for end in between)
        if law == "copied":
            source = next(p for p in pair if sides.names[p] in ("south", "west"))
            return Spacing("copied", source=sides.lines[source])
        if law != "as given" or first is not None or last is not None:
            try:
                return Spacing("hyperbolic tangent" if law == "as given" else law, first=first, last=last)
            except InvalidInput as error:
                name = sides.names[between[error.parameter == "last"]]
                raise InvalidInput(str(error).partition(": ")[2], parameter=f"spacing_{name}") from None
        return None

    def _along(self, sides: Sides, place: str, cells: int, spacing: Spacing | None, between) -> np.ndarray | None:
        line = sides.lines[place]
        if spacing is None:
            return None if len(line) == cells + 1 else copied(cells, _distinct(line))
        name = sides.names[place]
        backwards = name in self.spacings and sides.turned and place in ("south", "north")
        try:
            found = spacing.fractions(cells, line[::-1] if backwards else line, diagonal=sides.diagonal)
        except InvalidInput as error:
            raise self._misfit(error, spacing, sides, line, cells, name, between) from None
        return 1 - found[::-1] if backwards else found

    def _misfit(self, error, spacing, sides, line, cells, name, between) -> InvalidInput:
        """An error of a law, told of the parameter that the user gave."""
        if name in self.spacings or error.parameter not in ("first", "last"):
            return InvalidInput(f"{error}; change it or the number of cells", parameter=name)
        end = sides.names[between[error.parameter == "last"]]
        size = absolute(getattr(spacing, error.parameter), sides.diagonal)
        return InvalidInput(
            f"{size:.6g} does not fit a side of length {arc_length(line)[-1]:.6g} with {cells} cells: {error}; "
            "change it or the number of cells",
            parameter=f"spacing_{end}",
        )


def _distinct(line: np.ndarray) -> np.ndarray:
    """A polyline without points that repeat the one before."""
    return line[np.append(True, (line[1:] != line[:-1]).any(axis=1))]


def _numbers(curve: Curve) -> np.ndarray:
    """The numbers of a curve's points, in order."""
    if isinstance(curve, Mesh) and len(curve.get("line")):
        return chains(curve)[0]
    return np.arange(curve.n_points if isinstance(curve, Mesh) else len(curve))


def _joined(
    lines: dict[str, np.ndarray], gap: float, numbers: Mapping[str, np.ndarray]
) -> tuple[dict[str, np.ndarray], list[str]]:
    """Direct the sides as drawn and close gaps up to ``gap``; also names of the reversed ones, as few as may be.

    By the numbers of their points errors tell where.
    """
    best, apart = _directed(tuple(lines.values()))
    if apart.max() > gap:
        name, end, other = (("south", 0, "west"), ("south", -1, "east"), ("east", -1, "north"), ("west", -1, "north"))[
            int(np.argmax(apart))
        ]
        end = -1 - end if best[NAMES.index(name)] else end
        x, y, z = lines[name][end]
        raise InvalidGeometry(
            f"{name} and {other} end {apart.max():.6g} apart at ({x:.6g}, {y:.6g}, {z:.6g}); "
            + (_fitting_order(lines, gap) or "move their ends together, or raise tolerance above that"),
            parameter=name,
            points=numbers[name][[end]] if name in numbers else (),
        )
    south, east, north, west = (
        (ln[::-1] if back else ln).copy() for back, ln in zip(best, lines.values(), strict=True)
    )
    west[0], east[0], east[-1], west[-1] = south[0], south[-1], north[-1], north[0]
    reversed_ = [name for back, name in zip(best, lines, strict=True) if back]
    return dict(zip(NAMES, (south, east, north, west), strict=True)), reversed_


def _directed(lines: Sequence[np.ndarray]) -> tuple[tuple[bool, ...], np.ndarray]:
    """Which of south, east, north, west are to be reversed so that they meet best, and the gaps that are left."""

    def gaps(turn: tuple[bool, ...]) -> np.ndarray:
        s, e, n, w = (line[::-1] if back else line for back, line in zip(turn, lines, strict=True))
        pairs = ((s[0], w[0]), (s[-1], e[0]), (e[-1], n[-1]), (w[-1], n[0]))
        return np.array([np.linalg.norm(a - b) for a, b in pairs])

    # South first is not reversed, and of equal gaps the first is taken.
    best = min(sorted(product((False, True), repeat=4), key=sum), key=lambda turn: gaps(turn).max())
    return best, gaps(best)


def _fitting_order(lines: dict[str, np.ndarray], gap: float) -> str:
    """What to do if the sides meet in another order than that given; else nothing."""
    for rest in permutations(NAMES[1:]):
        order = (NAMES[0], *rest)
        if _directed([lines[name] for name in order])[1].max() <= gap:
            return f"they meet in another order: give {', '.join(order)} as south, east, north, west"
    return ""
