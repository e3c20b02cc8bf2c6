"""Where points stand on a section: dense where it bends, or on each side by a law of spacing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ...errors import InvalidInput
from ...geometry.curves import arc_length, corners, turning
from ...geometry.section import Section
from ...operation import Length, absolute
from ...sizing import Spacing
from ...sizing.around_loop import LoopSpline, respaced_loop
from ..limits import check_size

SIDES = ("upper", "lower")
_FINE = 8
"""Chords between two points of a side's spline, whose length and bending laws are told."""
_LEAST_SIZE = 1e-9
"""Of the chord: the smallest cell that may be asked for at an edge."""


@dataclass(frozen=True)
class Points:
    """What is asked of the points on a section; see `c_grid` for the meaning of each.

    Attributes
    ----------
    around : int or None
        Cells around it.
    leading, trailing : float or None
        Sizes of the cells at nose and trailing edge.
    law : str
        "as given", or a law of `Spacing` for both sides.
    spacings : dict of str to Spacing
        Laws of single sides, from the trailing edge to the nose.
    diagonal : float
        That relative lengths are relative to.
    """

    around: int | None
    leading: float | None
    trailing: float | None
    law: str = "as given"
    spacings: Mapping[str, Spacing] = field(default_factory=dict)
    diagonal: float = 1.0

    @classmethod
    def asked(
        cls,
        diagonal: float,
        around: int | None,
        leading: Length | None,
        trailing: Length | None,
        law: str,
        spacings: Mapping[str, Spacing] | None,
    ) -> Points:
        """From what the user gives.

        Raises
        ------
        InvalidInput
            If there are too many cells, or spacings are of what is no side, or are no spacings.
        """
        if around is not None:
            check_size(around + 1, 2, parameter="around")
        for name, spacing in (spacings or {}).items():
            if name not in SIDES or not isinstance(spacing, Spacing):
                raise InvalidInput(
                    f'needs a Spacing for "upper" or "lower", got {type(spacing).__name__} for {name!r}',
                    parameter="spacings",
                )
        sizes = (None if x is None else absolute(x, diagonal) for x in (leading, trailing))
        return cls(around, *sizes, law, dict(spacings or {}), diagonal)

    @property
    def by_law(self) -> bool:
        """Whether there is a law for a side."""
        return self.law != "as given" or bool(self.spacings)

    @property
    def given(self) -> bool:
        """Whether the section's own points are to stay."""
        return not self.by_law and self.around is None and self.leading is None and self.trailing is None

    def on(self, loop: np.ndarray, lower: int | None = None) -> np.ndarray:
        """(m, 2) float: a loop (n, 2) that begins at its trailing edge, on the points asked for, corners kept.

        ``lower`` is the number of the lower corner of a blunt edge, if it has one.

        Raises
        ------
        InvalidInput
            If sizes or numbers of cells do not fit, or a law cannot have them.
        """
        sizes = _edge_sizes(loop, self.leading, self.trailing, lower)
        if self.given:
            return loop
        if not self.by_law:
            return respaced_loop(loop, self.around or len(loop), sizes=sizes)
        return self._spaced(loop, len(loop) if lower is None else lower)

    def _spaced(self, loop: np.ndarray, lower: int) -> np.ndarray:
        """The loop with the points of both sides by their laws; those of a base stay."""
        nose, corner = nose_of(loop), corners(turning(loop))
        stops = np.unique(np.append(np.flatnonzero(corner), 0))
        spline = LoopSpline(loop, stops, closed=not corner.any())
        at, cells = spline.fractions, self._cells(nose, lower, len(loop))
        rows = {"upper": np.arange(nose + 1), "lower": np.arange(lower, nose - 1, -1)}
        stand = {name: np.abs(at[row] - at[row[0]]) * spline.length for name, row in rows.items()}
        found = {}
        for name, row in rows.items():
            fine = np.interp(np.arange(_FINE * (len(row) - 1) + 1) / _FINE, np.arange(len(row)), at[row])
            side = spline.at(np.where(fine < 1, fine, 0.0))
            share = self._fractions(name, side, cells[name], stand[name], stand["upper"])
            found[name] = at[row[0]] + share * (at[nose] - at[row[0]])
            found[name][-1] = at[nose]
            inner = row[1:-1]
            _keep(found[name], at[inner[corner[inner]]])
        places = np.concatenate([found["upper"][:-1], found["lower"][::-1], at[lower + 1 : -1]])
        return spline.at(places[: cells["all"]])

    def _cells(self, nose: int, lower: int, whole: int) -> dict[str, int]:
        """Cells of both sides, as many as their own points make, or half of those asked for."""
        base = whole - lower
        if self.around is None:
            return {"upper": nose, "lower": lower - nose, "all": whole}
        if self.around - base < 4:
            raise InvalidInput(
                f"{self.around} cells are too few for two sides; give at least {base + 4}", parameter="around"
            )
        half = (self.around - base) // 2
        return {"upper": self.around - base - half, "lower": half, "all": self.around}

    def _fractions(self, name: str, side: np.ndarray, cells: int, own: np.ndarray, upper: np.ndarray) -> np.ndarray:
        """Of a side's length from the trailing edge to the nose, by its law.

        ``own`` and ``upper`` are lengths at which its own points stand, and those of the upper side.
        """
        source = own if self.law == "as given" else upper
        try:
            spacing = self.spacings.get(name) or self._law(np.column_stack([source, 0 * source]))
            return spacing.fractions(cells, side, diagonal=self.diagonal)
        except InvalidInput as error:
            ends = {"first": "trailing_spacing", "last": "leading_spacing"}
            parameter = "spacings" if name in self.spacings else ends.get(error.parameter, "law_i")
            text = str(error).partition(": ")[2].replace("and last are", "and leading_spacing are")
            raise InvalidInput(text, parameter=parameter) from None

    def _law(self, source: np.ndarray) -> Spacing:
        """The law of a side that has none of its own; ``source`` is what is copied if neither is one asked for."""
        ends = {"first": self.trailing, "last": self.leading}
        if self.law == "copied":
            return Spacing("copied", source=source, **ends)
        if self.law != "as given":
            return Spacing(self.law, **ends)
        if self.trailing is None and self.leading is None:
            return Spacing("copied", source=source)
        return Spacing("hyperbolic tangent", **ends)


def respaced_section(section: Section, asked: Points) -> Section:
    """The section on the points asked for."""
    if asked.given:
        return section
    return Section.of(asked.on(section.loop, section.lower if section.edge == "blunt" else None))


def nose_of(loop: np.ndarray) -> int:
    """Number of the point that is farthest from the first one."""
    return int(np.argmax(np.linalg.norm(loop - loop[0], axis=1)))


def _edge_sizes(
    loop: np.ndarray, leading: float | None, trailing: float | None, lower: int | None = None
) -> list[tuple[float, float]]:
    """Places, as fractions of a loop that begins at its trailing edge, and sizes asked for there.

    Raises
    ------
    InvalidInput
        If a size is not between a billionth and a half of the chord.
    """
    length = arc_length(np.vstack([loop, loop[:1]]))
    nose = nose_of(loop)
    chord = float(np.linalg.norm(loop[nose] - loop[0]))
    for name, size in (("leading_spacing", leading), ("trailing_spacing", trailing)):
        if size is not None and not _LEAST_SIZE * chord < size < 0.5 * chord:
            raise InvalidInput(
                f"is {size:.6g}; give a size between {_LEAST_SIZE * chord:.6g} and half the chord, {0.5 * chord:.6g}",
                parameter=name,
            )
    sizes = [] if leading is None else [(nose, leading)]
    if trailing is not None:
        sizes += [(at, trailing) for at in (0, lower) if at is not None]
    return [(float(length[at] / length[-1]), size) for at, size in sizes]


def _keep(places: np.ndarray, held: np.ndarray) -> None:
    """Move the nearest of points between two ends onto each place that is held, in place.

    Raises
    ------
    InvalidInput
        If there are fewer points than places.
    """
    if not len(held):
        return
    nearest = np.array([int(np.argmin(np.abs(places - place))) for place in held])
    nearest = np.clip(nearest, 1, max(len(places) - 2, 1))
    if len(places) < 3 or len(np.unique(nearest)) < len(nearest):
        raise InvalidInput(
            f"{len(places) - 1} cells are too few for a side with {len(held)} corners; give more", parameter="around"
        )
    places[nearest] = held
