"""O-, C- and H-grids round any section by every method: what became of them, skew, growth, first heights, seconds.

``python benchmarks/topologies.py [--quick] [--number 100] [--seed 1] [--airfoils FOLDER] [--every 1] [--sweep OC]``

Without a folder of ``.dat`` files the airfoils that meshcore ships are taken, on their own points. No parameter is
touched in the first table; random sections come with default parameters, then with random first heights, y+, numbers of
points, and far fields. Skew: the departure from 90 degrees of the angle between lines at points, the wall left out.
Growth: of the layers' mean heights, the median against the layer farthest from it; far fields that a march has to meet
ask for other heights. A grid "fell back" if its report tells that another method took the place of the one asked for.
"""

from __future__ import annotations

import statistics
import time
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from _common import Target, arguments, print_heading, print_row

from meshcore import MeshcoreError, gallery, io
from meshcore.geometry.curves import polyline
from meshcore.mesh import StructuredGrid
from meshcore.quality import line_angle
from meshcore.structured import c_grid, h_grid, o_grid
from meshcore.structured.folds import folded_cells
from tests.bodies import random_bodies
from tests.sections import random_sections

METHODS = ("transfinite", "elliptic", "hyperbolic", "parabolic")
GROWTH = Target(2.0, 0.5, at_most=True)
NONE = Target(0, at_most=True)
HEIGHTS = (1e-3, 1e-4, 1e-5, 1e-6)
AROUND = (None, 128, 256)
"""Cells round an airfoil; None for its own points."""
MAKERS = {"O": o_grid, "C": c_grid, "H": h_grid}


class Outcome(NamedTuple):
    """What became of a section: a word, and of a grid its figures."""

    word: str
    message: str = ""
    skew: float = 90.0
    jacobian: float = 0.0
    lowest: float = 1.0
    highest: float = 1.0
    growth: float = 0.0
    seconds: float = 0.0
    converged: bool = True


def made(topology: str, section: Any, method: str, **options: Any) -> Outcome:
    """A grid, and what it is like."""
    began = time.process_time()
    try:
        grid, report = MAKERS[topology](section, method=method, **options)
    except MeshcoreError as error:
        return Outcome("refused", f"{type(error).__name__}: {error}", seconds=time.process_time() - began)
    seconds = time.process_time() - began
    blocks = [grid] if isinstance(grid, StructuredGrid) else list(grid.blocks)
    if any(folded_cells(block.points[:, :, 0]).any() for block in blocks):
        return Outcome("FOLDED", "; ".join(report.warnings), seconds=seconds)
    fell = [w for w in report.warnings if "took" in w or "held without" in w or "stays as" in w]
    skew = max(float(90 - line_angle(block)[:, 1:-1].min()) for block in blocks)
    jacobian = report.quality["worst scaled jacobian"]
    lowest, highest, growth = _heights(blocks[topology == "H"], report)  # of an H-grid, above the section
    told = "fell back" if fell else "made", "; ".join(report.warnings)
    return Outcome(*told, skew, jacobian, lowest, highest, growth, seconds, report.converged)


def _heights(grid: StructuredGrid, report: Any) -> tuple[float, float, float]:
    """Least and largest first height of what was asked for, and by how much mean heights grow unevenly (%)."""
    wake = report.counts.get("wake", 0)
    lines = grid.points[report.counts.get("ahead", wake) : len(grid.points) - wake, :, 0]
    steps = np.linalg.norm(np.diff(lines, axis=1), axis=-1)
    asked = report.quality["first height"]
    growth = 0.0
    if steps.shape[1] > 2:
        mean = steps.mean(axis=0)
        ratio = mean[1:] / mean[:-1]
        growth = 100 * float(np.abs(ratio / np.median(ratio) - 1).max())
    return float(steps[:, 0].min() / asked), float(steps[:, 0].max() / asked), growth


def airfoils(folder: str | None) -> Iterator[tuple[str, np.ndarray]]:
    """Names and closed loops."""
    if folder is None:
        yield from ((name, polyline(gallery.airfoil(name))[:, :2]) for name in gallery.airfoils())
    else:
        yield from ((path.stem, io.read(path)) for path in sorted(Path(folder).glob("*.dat")))


def each_airfoil(named: Iterable[tuple[str, Any]]) -> None:
    """A row for each airfoil, topology and method."""
    print_row(
        "airfoil", "grid", "method", "outcome", "worst skew", "scaled Jacobian", "first heights", "growth (%)",
        "converged", "s", head=True,
    )  # fmt: skip
    for name, section in named:
        for topology in MAKERS:
            for method in METHODS:
                o = made(topology, section, method)
                print_row(
                    name, topology, method, o.word, f"{o.skew:.1f}", f"{o.jacobian:.3f}",
                    f"{o.lowest:.3f}, {o.highest:.3f}", GROWTH.verdict(o.growth), "yes" if o.converged else "NO",
                    f"{o.seconds:.2f}",
                )  # fmt: skip
                if o.message:
                    print(f"    {o.message}")


def sweep(named: Iterable[tuple[str, Any]], topologies: str) -> None:
    """A row for each airfoil, topology and method: what is worst over numbers of points and first heights."""
    print_row(
        "airfoil", "grid", "method", "grids", "refused", "FOLDED", "fell back", "not converged", "skew, median, worst",
        "least Jacobian", "first heights", "growth (%)", "s, median", head=True,
    )  # fmt: skip
    for name, section in named:
        for topology in topologies:
            for method in METHODS:
                all_of = [
                    made(topology, section, method, first_height=height, **({"around": n} if n else {}))
                    for n in AROUND
                    for height in HEIGHTS
                ]
                words = Counter(o.word for o in all_of)
                good = [o for o in all_of if o.word in ("made", "fell back")] or [Outcome("none")]
                print_row(
                    name, topology, method, len(all_of), NONE.verdict(words["refused"]), NONE.verdict(words["FOLDED"]),
                    words["fell back"], NONE.verdict(sum(not o.converged for o in good)),
                    f"{statistics.median(o.skew for o in good):.1f}, {max(o.skew for o in good):.1f}",
                    f"{min(o.jacobian for o in good):.3f}",
                    f"{min(o.lowest for o in good):.3f}, {max(o.highest for o in good):.3f}",
                    GROWTH.verdict(max(o.growth for o in good)),
                    f"{statistics.median(o.seconds for o in all_of):.2f}",
                )  # fmt: skip
                for message in {o.message for o in all_of if o.message}:
                    print(f"    {message}")


def options_of(rng: np.random.Generator) -> dict[str, Any]:
    """Random parameters such as users try."""
    options: dict[str, Any] = {}
    if rng.random() < 0.3:
        options["y_plus"] = float(rng.choice([0.5, 1.0, 30.0]))
        options["reynolds"] = float(10 ** rng.uniform(5, 7))
    else:
        options["first_height"] = float(10.0 ** -rng.integers(3, 7))
    if rng.random() < 0.5:
        options["around"] = int(rng.choice([60, 120, 250]))
    if rng.random() < 0.3:
        options["far_field"] = "box"
    return options


def table(runs: Iterable[tuple[str, str, str, np.ndarray, dict[str, Any]]], every: bool) -> None:
    """A row for each topology and method; below, what was refused or folded, most frequent first."""
    found: dict[tuple[str, str], list[Outcome]] = defaultdict(list)
    told: Counter[str] = Counter()
    for label, topology, method, section, options in runs:
        o = made(topology, section, method, **options)
        found[topology, method].append(o)
        kind = label.split(",")[0] if every else ""
        if o.word != "made":
            told[f"{topology} {method} {kind}: {o.word}: {o.message[:120]}"] += 1
            if every:
                print(f"    {topology} {method} {label} {options}: {o.word} {o.jacobian:.3f} {o.message}", flush=True)
        elif every and (o.jacobian < 0.03 or o.lowest < 0.7 or o.highest > 1.4):
            print(
                f"    {topology} {method} {label} {options}: heights {o.lowest:.2f} {o.highest:.2f} "
                f"jacobian {o.jacobian:.3f} {o.message}",
                flush=True,
            )
    print_row(
        "grid", "method", "sections", "refused", "FOLDED", "fell back", "skew, median, worst", "least Jacobian",
        "heights 5 % off", "least, largest", "s, median", "most", head=True,
    )  # fmt: skip
    for (topology, method), all_of in found.items():
        good = [o for o in all_of if o.word in ("made", "fell back")] or [Outcome("none")]
        words = Counter(o.word for o in all_of)
        print_row(
            topology, method, len(all_of), NONE.verdict(words["refused"]), NONE.verdict(words["FOLDED"]),
            words["fell back"],
            f"{statistics.median(o.skew for o in good):.0f}, {max(o.skew for o in good):.0f}",
            f"{min(o.jacobian for o in good):.3f}",
            sum(o.lowest < 0.95 or o.highest > 1.05 for o in good),
            f"{min(o.lowest for o in good):.2f}, {max(o.highest for o in good):.2f}",
            f"{statistics.median(o.seconds for o in all_of):.2f}", f"{max(o.seconds for o in all_of):.2f}",
        )  # fmt: skip
    for message, count in told.most_common(25):
        print(f"    {count} x {message}")


def runs(number: int, seed: int, touched: bool) -> Iterator[tuple[str, str, str, np.ndarray, dict[str, Any]]]:
    """Random sections in every grid by every method."""
    half = number // 2
    drawn = [*random_sections(half, seed), *random_bodies(number - half, seed)]
    for k, (kind, loop) in enumerate(drawn):
        options = options_of(np.random.default_rng([seed, k, 7])) if touched else {}
        for topology in MAKERS:
            mine = {name: value for name, value in options.items() if topology != "H" or name != "far_field"}
            for method in METHODS:
                yield f"{kind}, {k}", topology, method, loop, mine


def main() -> None:
    """Print the tables."""
    options = arguments(__doc__, number=[100], seed=[1], airfoils=[""], every=[0], sweep=[""])
    circle = polyline(gallery.circle(24))[:, :2]
    for method in METHODS:
        made("O", circle, method, layers=8)  # compiles
    every = bool((options.every or [0])[0])
    folder = (options.airfoils or [None])[0] or None
    if topologies := (options.sweep or [""])[0]:
        print_heading("Airfoils, first heights from 1e-3 to 1e-6, their own points and 128 and 256 cells around")
        return sweep(airfoils(folder), topologies)
    number, seed = (options.number or [10 if options.quick else 100])[0], (options.seed or [1])[0]
    if folder != "-":
        print_heading("Airfoils, no parameter touched")
        each_airfoil(airfoils(folder))
    print_heading(f"{number} random sections, no parameter touched")
    table(runs(number, seed, False), every)
    print_heading(f"{number} random sections, random parameters")
    table(runs(number, seed, True), every)


if __name__ == "__main__":
    main()
