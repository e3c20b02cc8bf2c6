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

from pathlib import Path

import numpy as np

from ..errors import InvalidInput
from ..geometry.curves import is_closed, lines_through, polyline
from ..mesh import Mesh
from .airfoil_rows import Rows, rows_of_section
from .content import exact, text_of
from .fit import Holds
from .registry import register


def read_airfoil(path: Path) -> Mesh:
    """A section as one closed loop of line cells, counter-clockwise from its trailing edge."""
    rows = rows_of_section(text_of(path))
    if len(rows.points) < 3:
        raise InvalidInput(f"it holds {len(rows.points)} coordinates, a section needs at least three")
    loop = lines_through(_loop(rows), closed=True)
    return Mesh(loop.points, loop.cells, field_data={"title": np.array([rows.title])})


def _loop(rows: Rows) -> np.ndarray:
    """(n, 2) float: different points once round, counter-clockwise from the trailing edge."""
    points = rows.points
    x = points[:, 0]
    chord = float(np.ptp(x))
    if chord == 0:
        raise InvalidInput("all points have the same x, so there is no chord")
    _check_is_one(rows)
    starts_at_nose = x[0] < x.min() + 0.5 * chord
    split = rows.first if rows.first and _same_way(x[: rows.first], x[rows.first :]) else _second_block(x, chord)
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
            f"line {rows.lines[-1]}: the section begins at x = {points[0, 0]:g} and ends at x = {points[-1, 0]:g}, so "
            "a part of it is missing"
        )
    return _counter_clockwise(points)


def _check_is_one(rows: Rows) -> None:
    """`InvalidInput` if the file holds several elements: a separator, blocks that each run round, a second start."""
    points, lines = rows.points, rows.lines
    between = (np.abs(points) == 999).all(axis=1)
    blocks = np.split(points, rows.begins[1:])
    whole = np.flatnonzero([_runs_round(block) for block in blocks])
    again = np.flatnonzero((points[3:-3] == points[0]).all(axis=1)) + 3
    again = again[[_runs_round(points[: k + 1]) and _runs_round(points[k + 1 :]) for k in again.tolist()]]
    if between.any():
        where, what = lines[between][0], "999 999 stands between them"
    elif len(whole) > 1:
        where, what = lines[rows.begins[whole[1]]], "a second one begins there"
    elif len(again):
        where, what = lines[again[0] + 1], "the first one is closed before it"
    else:
        return
    raise InvalidInput(f"line {where}: it holds several elements ({what}); put each into a file of its own")


def _runs_round(points: np.ndarray) -> bool:
    """Whether points go from the rear to the front and back."""
    if len(points) < 3:
        return False
    x = points[:, 0]
    ends, span = x[[0, -1]], float(np.ptp(x))
    return bool(ends.min() > x.min() + 0.5 * span and abs(ends[0] - ends[1]) < 0.25 * span)


def _same_way(first: np.ndarray, second: np.ndarray) -> bool:
    return (first[-1] - first[0]) * (second[-1] - second[0]) > 0


def _second_block(x: np.ndarray, chord: float) -> int:
    """Where a second block begins: a jump over half the chord between two blocks that each span half of it; or 0."""
    step = np.diff(x)
    for k in np.argsort(-np.abs(step), kind="stable")[:4]:
        first, second = x[: k + 1], x[k + 1 :]
        if (
            abs(step[k]) > 0.5 * chord
            and _same_way(first, second)
            and min(len(first), len(second)) >= 2
            and min(np.ptp(first), np.ptp(second)) > 0.5 * chord
        ):
            return int(k) + 1
    return 0


def _counter_clockwise(points: np.ndarray) -> np.ndarray:
    if len(points) < 3:
        raise InvalidInput(f"it holds {len(points)} different points, a section needs at least three")
    relative = (points - points[0]) / float(np.ptp(points, axis=0).max())  # squares of large numbers are none
    after = np.roll(relative, -1, axis=0)
    twice_area = float((relative[:, 0] * after[:, 1] - relative[:, 1] * after[:, 0]).sum())
    if abs(twice_area) <= 1e-12:
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
