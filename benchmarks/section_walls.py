"""Wall control as users get it, on airfoils and random sections: O-grid, then elliptic smoothing with a first height.

``python benchmarks/section_walls.py [--quick] [--number 1000] [--seed 1] [--airfoils FOLDER]``

Without a folder of ``.dat`` files the airfoils that meshcore ships are taken. Each section has its own points and, in
turn, 129, 257 and 513 around; first heights of 1e-3, 1e-4 and 1e-5 chords; ten chords; layers by a growth of 1.15.
"""

from __future__ import annotations

import statistics
import time
from collections import defaultdict
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from _common import Target, arguments, print_heading, print_row

from meshcore import MeshcoreError, gallery, io
from meshcore.geometry.curves import polyline
from meshcore.structured import elliptically_smoothed, o_grid
from tests.sections import random_sections

HEIGHTS = (1e-3, 1e-4, 1e-5)
AROUND = (None, 129, 257, 513)
SECONDS = Target(0.5, 0.1, at_most=True)


class Outcome(NamedTuple):
    """What became of a section: a word, largest errors of angle (degrees) and height (%), steps, seconds."""

    word: str
    angle: float = 0.0
    height: float = 0.0
    steps: int = 0
    seconds: float = 0.0


def controlled(section: np.ndarray, around: int | None, height: float) -> Outcome:
    """The grid round a section of chord 1 with right angles and the first height."""
    try:
        start, _ = o_grid(section, around=around, first_height=height, method="transfinite")
    except MeshcoreError as error:
        return Outcome(f"no O-grid: {type(error).__name__}")
    began = time.process_time()
    try:
        _, report = elliptically_smoothed(start, walls="south", first_height=height, threads=1)
    except MeshcoreError as error:
        return Outcome(f"{type(error).__name__}: {error}", seconds=time.process_time() - began)
    return Outcome(
        "met" if report.converged else "MISSED",
        report.quality["error of wall angles (degree)"],
        report.quality["error of first heights (%)"],
        report.iterations,
        time.process_time() - began,
    )


def airfoils(folder: str | None) -> Iterator[tuple[str, np.ndarray]]:
    """Names and closed loops."""
    if folder is None:
        yield from ((name, polyline(gallery.airfoil(name))[:, :2]) for name in gallery.airfoils())
    else:
        yield from ((path.stem, polyline(io.read(path))[:, :2]) for path in sorted(Path(folder).glob("*.dat")))


def table(runs: Iterable[tuple[str, str, np.ndarray, int | None, float]]) -> None:
    """A row for each kind: how many met what was asked, how exactly, how fast; and below, what did not."""
    found: dict[str, list[Outcome]] = defaultdict(list)
    failures = []
    for kind, name, section, around, height in runs:
        outcome = controlled(section, around, height)
        found[kind].append(outcome)
        if outcome.word != "met":
            failures.append(f"{kind} {name}, around {around}, height {height:g}: {outcome}")
    print_row("sections", "grids", "met", "no O-grid", "median, worst height %", "steps", "seconds", "most", head=True)
    for kind, outcomes in found.items():
        met = [outcome for outcome in outcomes if outcome.word == "met"]
        heights = [outcome.height for outcome in met] or [0.0]
        print_row(
            kind,
            len(outcomes),
            len(met),
            sum(outcome.word.startswith("no O-grid") for outcome in outcomes),
            f"{statistics.median(heights):.1f}, {max(heights):.1f}",
            f"{statistics.median(outcome.steps for outcome in outcomes):.0f}",
            f"{statistics.median(outcome.seconds for outcome in outcomes):.3f}",
            SECONDS.verdict(max(outcome.seconds for outcome in outcomes)),
        )
    print("\n" + "\n".join(failures))


def main() -> None:
    """Print the tables."""
    options = arguments(__doc__, number=[1000], seed=[1], airfoils=[""])
    controlled(next(iter(random_sections(1, 0)))[1], 40, 1e-2)  # compiles
    print_heading("Walls round airfoils", "Angles within a degree, heights within 5 %, but for the trailing edge.")
    named = list(airfoils((options.airfoils or [None])[0] or None))
    table((f"around {n}", name, loop, n, height) for n in AROUND for name, loop in named for height in HEIGHTS)
    number = (options.number or [30 if options.quick else 1000])[0]
    print_heading("Walls round random sections", "The same.")
    seed = (options.seed or [1])[0]
    drawn = enumerate(random_sections(number, seed))
    table(
        (kind, f"number {k} of seed {seed}", loop, AROUND[k // 9 % 4], HEIGHTS[k // 36 % 3])
        for k, (kind, loop) in drawn
    )


if __name__ == "__main__":
    main()
