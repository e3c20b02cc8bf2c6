"""Lines of a section's file told apart: its title, coordinates in blocks, lengths of blocks, remarks behind them.

A line of two numbers, or of three of which the last is 0, is a point; words may follow it. Other lines are text, which
may stand anywhere, but a line among the points that lacks one of its numbers is an error. Where no number of the file
has a point, a comma is the decimal one.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np

from ..errors import InvalidInput
from .content import number
from .fit import warn_dropped

_COMMENT = re.compile(r"\s*(#|!|%|//).*|^\s*;.*")
_SEPARATOR = re.compile(r"[\s,;]+")
_COMMA = re.compile(r"\s*[-+]?\d*,\d+([eEdD][-+]?\d+)?(\s*;\s*|\s+)[-+]?\d*,\d+([eEdD][-+]?\d+)?[\s;]*")
_DECIMAL = re.compile(r"(?<=\d),(?=\d)|(?<![\d,]),(?=\d)")
_NUMBERS = re.compile(r"[-+,;\d\seEdD]+")
_LIKE = re.compile(r"[-+.,()OolIeEdD\d]*\d[-+.,()OolIeEdD\d]*")
_MINUS = str.maketrans("\N{MINUS SIGN}\N{EN DASH}", "--")
_BRACKETS = str.maketrans("()", "  ")  # round ordinates of blunt edges in tables of the NACA
_SPECIAL = frozenset("#!%/,;()")
_SHOWN = 60
_EXTENT = 4  # numbers that tell how far the grid reaches, which MSES wants below the title


@dataclass(frozen=True)
class Rows:
    """The coordinates of a file.

    Parameters
    ----------
    title : str
        The first line of text before them, or "".
    points : (n, 2) float
        Finite.
    lines : (n,) int
        The line of each, from 1.
    begins : (k,) int
        Where blocks begin between which there is text or a blank line.
    first : int
        The length of the first of two blocks, if the file tells; else 0.
    """

    title: str
    points: np.ndarray
    lines: np.ndarray
    begins: np.ndarray
    first: int


@dataclass
class _Reader:
    """What was read so far."""

    titles: list[str] = field(default_factory=list)
    points: list[tuple[float, float]] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)
    begins: list[tuple[int, str]] = field(default_factory=list)  # of a block, and what stands before it
    gap: str = "blank"  # what stands between the last point and this line: "", "blank" or "text"
    doubtful: list[tuple[int, str, str]] = field(default_factory=list)  # behind text: points or remarks

    def take(self, k: int, line: str) -> None:
        """One line of the file."""
        if line.isspace() or not line:
            self.gap = self.gap or "blank"
            return
        words = _words(line)
        kind = _kind(words)
        if not self.doubtful and (kind == "point" or (kind == "noted" and self.gap != "text")):
            self._append(k, words)
        elif not self.points and kind in ("half", "more", "text"):
            if kind == "more" and len(words) != _EXTENT:
                raise InvalidInput(_complaint(k, line, kind))
            self.titles.append(line.strip().lstrip("#!%;/ ") if kind != "more" else "")
            self.gap = "text"
        elif kind == "text":
            self.gap = "text"
        elif self.gap:
            follows = bool(self.doubtful) and self.doubtful[-1][:2] == (k - 1, "point")
            self.doubtful.append((k, kind, line))
            if follows and kind == "point":
                self._settle()
        else:
            raise InvalidInput(_complaint(k, line, kind))

    def _settle(self) -> None:
        """Two points in a row are coordinates, so that doubtful lines before them were no remarks."""
        for k, kind, line in self.doubtful:
            if kind in ("half", "more"):
                raise InvalidInput(_complaint(k, line, kind))
            self._append(k, _words(line))
        self.doubtful = []

    def _append(self, k: int, words: list[str]) -> None:
        if self.gap:
            self.begins.append((len(self.points), self.gap))
            self.gap = ""
        self.points.append((number(words[0]), number(words[1])))
        self.lines.append(k)

    def end(self) -> None:
        """Leave out remarks behind the coordinates, and tell those that have nothing but numbers."""
        if not self.points:
            self._settle()
        if not self.points:
            raise InvalidInput("it holds no lines of two numbers, x and y")
        bare = [k for k, _, line in self.doubtful if None not in map(number, _SEPARATOR.split(line.strip()))]
        if self.gap != "text" and len(bare) == len(self.doubtful):  # nothing but numbers: a list that was cut off
            self._settle()
        last, before = self.begins[-1]
        if last == len(self.points) - 1 > 0 and before == "text" and len(self.begins) > 1:
            bare = [self.lines.pop(), *bare]
            self.points.pop()
            self.begins.pop()
        warn_dropped("what stands in", [f"line {k}" for k in bare], "it is a remark behind the coordinates")


def _words(line: str) -> list[str]:
    words = line.split()
    if len(words) == 2 and not _SPECIAL.intersection(line):
        return words
    bare = _COMMENT.sub("", line).translate(_BRACKETS).strip(" \t,;")
    return _SEPARATOR.split(bare) if bare else []


def _kind(words: list[str]) -> str:
    """What a line is: a "point", a point "noted" with words, "more" or "half" of one, or "text"."""
    values = [number(word) for word in words[:3]]
    if len(words) < 2 or values[0] is None or values[1] is None:
        if len(words) == 2 and set(words[1]) == {"."}:
            return "text"  # tables of the NACA leave ordinates open so
        like = len(words) == 2 and all(_LIKE.fullmatch(word) for word in words)
        return "half" if words and (values[0] is not None or like) else "text"
    if len(words) == 2 or (len(words) == 3 and values[2] == 0.0):
        return "point"
    return "noted" if values[2] is None else "more"


def _complaint(k: int, line: str, kind: str) -> str:
    words = line.strip()
    words = words if len(words) <= _SHOWN else words[:_SHOWN] + "..."
    if kind == "half":
        return f"line {k}: {words!r} is half a line, x and y were expected"
    return f"line {k}: {words!r} has more than two numbers, x and y were expected"


def rows_of_section(text: str) -> Rows:
    """The title and the coordinates; a line that tells the lengths of two blocks is checked and left out.

    Examples
    --------
    >>> rows = rows_of_section("wedge\\n2. 2.\\n\\n0 0\\n1 0.1\\n\\n0 0\\n1 -0.1\\nmade by hand")
    >>> rows.title, len(rows.points), rows.begins.tolist(), rows.first
    ('wedge', 4, [0, 2], 2)
    """
    reader = _Reader()
    lines = (text if text.isascii() else text.translate(_MINUS)).split("\n")
    for k, line in enumerate(_with_decimal_points(lines) if "," in text else lines, 1):
        reader.take(k, line)
    reader.end()
    title = next((t for t in reader.titles if t), "")
    begins = np.array([k for k, _ in reader.begins])
    rows = Rows(title, np.array(reader.points), np.array(reader.lines), begins, 0)
    rows = _without_counts(rows, has_title=bool(reader.titles))
    bad = np.flatnonzero(~np.isfinite(rows.points).all(axis=1))
    if len(bad):
        raise InvalidInput(f"line {rows.lines[bad[0]]}: the coordinates are {rows.points[bad[0]].tolist()}")
    return rows


def _with_decimal_points(lines: list[str]) -> list[str]:
    """The lines; where most of them are pairs of numbers with decimal commas, numbers get points for these."""
    pairs = sum(bool(_COMMA.fullmatch(line)) for line in lines)
    if 2 * pairs <= sum(bool(line.strip()) for line in lines):
        return lines
    return [_DECIMAL.sub(".", line) if _NUMBERS.fullmatch(line) else line for line in lines]


def _without_counts(rows: Rows, *, has_title: bool) -> Rows:
    """The coordinates alone: a first row that gives the lengths of two blocks, or is a title of two numbers, goes."""
    (a, b), rest = rows.points[0], rows.points[1:]
    if len(rest) < 3 or not np.isfinite(rows.points).all():
        return rows
    if a != int(a) or b != int(b) or min(a, b) < 2 or max(a, b) <= 1.5 * np.abs(rest).max():
        return rows
    begins = np.unique(np.maximum(rows.begins - 1, 0))
    without = Rows(rows.title, rest, rows.lines[1:], begins, int(a) if a + b == len(rest) else 0)
    if without.first:
        return without
    if has_title or a + b < 2 * len(rest):
        raise InvalidInput(f"line {rows.lines[0]}: it promises {a:g} and {b:g} coordinates, but there are {len(rest)}")
    return _without_counts(without, has_title=True)  # a title such as "4412 64"
