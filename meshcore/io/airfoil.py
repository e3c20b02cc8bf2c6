"""Airfoil coordinates (.dat), in Selig's and in Lednicer's layout.

Selig's file runs around the section, from the trailing edge over the upper side to the nose and back below::

    RAE 2822            <- title
    1.000000  0.000000  <- trailing edge
    0.999398  0.000128
    ...

Lednicer's has two blocks from nose to trailing edge, upper and lower side, and often a line with their lengths before.
Whichever it is, `read` gives one closed loop of line cells, counter-clockwise from the trailing edge; the title is
``field_data["title"]``. An open trailing edge is closed by a line.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ..errors import InvalidInput
from ..geometry.curves import is_closed, lines_through, polyline
from ..mesh import Mesh
from .content import exact, number, text_of
from .fit import Holds
from .registry import register

_COMMENT = re.compile(r"\s*(#|!|%|//).*|^\s*;.*")
_SEPARATOR = re.compile(r"[\s,;]+")


def read_airfoil(path: Path) -> Mesh:
    """A section as one closed loop of line cells, counter-clockwise from its trailing edge."""
    title, rows = _rows(text_of(path))
    points = np.array([row[1:] for row in rows])
    if len(points) < 3:
        raise InvalidInput(f"it holds {len(points)} coordinates, a section needs at least three")
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise InvalidInput(f"line {rows[bad[0]][0]}: the coordinates are {points[bad[0]].tolist()}")
    return _titled(_loop(points, rows), title)


def _titled(points: np.ndarray, title: str) -> Mesh:
    loop = lines_through(points, closed=True)
    return Mesh(loop.points, loop.cells, field_data={"title": np.array([title])})


def _rows(text: str) -> tuple[str, list[tuple[int, float, float]]]:
    """The title, and the coordinates with their line numbers; a counts line is checked and left out."""
    titles: list[str] = []
    rows: list[tuple[int, float, float]] = []
    for k, line in enumerate(_without_remarks(text.split("\n")), 1):
        bare, values = _values(line)
        if len(values) >= 2 and values[0] is not None and values[1] is not None:
            if len(values) > 2 and values[2] not in (None, 0.0):
                if not rows and len(values) == 4:  # MSES names the extent of its grid below the title
                    continue
                raise InvalidInput(f"line {k}: {bare!r} has {len(values)} numbers, x and y were expected")
            rows.append((k, values[0], values[1]))
        elif rows and values and values[0] is not None:
            raise InvalidInput(f"line {k}: {bare!r} is half a line, x and y were expected")
        elif not rows and line.strip():
            titles.append(line.strip().lstrip("#!%;/ "))
    if not rows:
        raise InvalidInput("it holds no lines of two numbers, x and y")
    return next((t for t in titles if t), ""), _without_counts(rows, has_title=bool(titles))


def _values(line: str) -> tuple[str, list[float | None]]:
    """A line without what is marked as a comment, and the numbers in it; None for other words."""
    bare = _COMMENT.sub("", line).strip(" \t,;")
    return bare, [number(word) for word in _SEPARATOR.split(bare)] if bare else []


def _without_remarks(lines: list[str]) -> list[str]:
    """The lines up to prose that stands, by itself, below the last coordinates: numbers in it are none of these."""
    values = [_values(line)[1] for line in lines]
    last = max((k for k, row in enumerate(values) if len(row) >= 2 and None not in row), default=len(lines))
    end = next((k for k in range(last + 1, len(lines)) if not values[k] or values[k][0] is None), len(lines))
    return lines[:end] if any(None in row for row in values[end:]) else lines


def _without_counts(rows: list[tuple[int, float, float]], *, has_title: bool) -> list[tuple[int, float, float]]:
    """The coordinates alone: a first row that gives the lengths of two blocks, or is a title of two numbers, goes."""
    line, a, b = rows[0]
    rest = np.array([row[1:] for row in rows[1:]]).reshape(-1, 2)
    if len(rest) < 3 or not np.isfinite(rest).all():
        return rows
    reach = np.abs(rest).max()
    if a == int(a) and b == int(b) and min(a, b) >= 2 and max(a, b) > 1.5 * reach:
        if a + b == len(rest):
            return rows[1:]
        if has_title:
            raise InvalidInput(f"line {line}: it promises {a:g} and {b:g} coordinates, but there are {len(rest)}")
        return _without_counts(rows[1:], has_title=True)  # a title such as "4412 64"
    return rows


def _loop(points: np.ndarray, rows: list[tuple[int, float, float]]) -> np.ndarray:
    """(n, 2) float: different points once round, counter-clockwise from the trailing edge."""
    x = points[:, 0]
    chord = float(np.ptp(x))
    if (np.abs(points) == 999).all(axis=1).any():
        raise InvalidInput("it holds several elements (999 999 stands between them); put each into a file of its own")
    if chord == 0:
        raise InvalidInput("all points have the same x, so there is no chord")
    starts_at_nose = x[0] < x.min() + 0.5 * chord
    split = _second_block(x, chord)
    if split:
        first, second = points[:split], points[split:]
        points = np.concatenate([first[::-1], second] if starts_at_nose else [first, second[::-1]])
    elif starts_at_nose:
        points = np.roll(points, -int(np.argmax(x)), axis=0)
    different = np.ones(len(points), bool)
    different[1:] = (points[1:] != points[:-1]).any(axis=1)
    points = points[different]
    if len(points) > 1 and (points[0] == points[-1]).all():
        points = points[:-1]
    elif abs(points[-1, 0] - points[0, 0]) > 0.25 * chord:
        raise InvalidInput(
            f"line {rows[-1][0]}: the section begins at x = {points[0, 0]:g} and ends at x = {points[-1, 0]:g}, so a "
            "part of it is missing"
        )
    return _counter_clockwise(points)


def _second_block(x: np.ndarray, chord: float) -> int:
    """Where a second block begins: a jump over half the chord between two blocks that each span half of it; or 0."""
    step = np.diff(x)
    for k in np.argsort(-np.abs(step), kind="stable")[:4]:
        first, second = x[: k + 1], x[k + 1 :]
        same_way = (first[-1] - first[0]) * (second[-1] - second[0]) > 0
        if (
            abs(step[k]) > 0.5 * chord
            and same_way
            and min(len(first), len(second)) >= 2
            and min(np.ptp(first), np.ptp(second)) > 0.5 * chord
        ):
            return int(k) + 1
    return 0


def _counter_clockwise(points: np.ndarray) -> np.ndarray:
    if len(points) < 3:
        raise InvalidInput(f"it holds {len(points)} different points, a section needs at least three")
    relative = points - points[0]
    after = np.roll(relative, -1, axis=0)
    twice_area = float((relative[:, 0] * after[:, 1] - relative[:, 1] * after[:, 0]).sum())
    if abs(twice_area) <= 1e-12 * float(np.ptp(points, axis=0).max()) ** 2:
        raise InvalidInput("the section has no area")
    return points if twice_area > 0 else np.roll(points[::-1], 1, axis=0)


def write_airfoil(path: Path, mesh: Mesh, *, title: str = "") -> None:
    """Selig's layout, every digit; the first point is repeated at the end where the trailing edge is sharp."""
    points = polyline(mesh, "mesh")[:, :2]
    if is_closed(np.asarray(points)):
        points = points[:-1]
    x = points[:, 0]
    chord = float(np.ptp(x))
    if chord == 0:
        raise InvalidInput("has no extent along x, so it is no section", parameter="mesh")
    if x[0] < x.max() - 0.01 * chord:
        points = np.roll(points, -int(np.argmax(x)), axis=0)
    points = _counter_clockwise(points)
    if abs(points[-1, 0] - points[0, 0]) > 0.001 * chord:
        points = np.concatenate([points, points[:1]])
    name = title or " ".join(str(t) for t in np.atleast_1d(mesh.field_data.get("title", ""))) or path.stem
    lines = [" ".join(name.split()), *(f"{exact(a)} {exact(b)}" for a, b in points)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


register(
    "airfoil coordinates",
    (".dat",),
    "a section as one closed loop of lines; Selig's and Lednicer's layouts read, Selig's written",
    Holds(cells=("line",), field_data=("title",), planar=True),
    read=read_airfoil,
    write=write_airfoil,
)
