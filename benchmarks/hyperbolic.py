"""Hyperbolic grids: worst skew round airfoils, growth, random sections, seconds, work a point, an elliptic iteration.

``python benchmarks/hyperbolic.py [--quick] [--repeats 5] [--airfoils FOLDER] [--sections 400]``

Without a folder of ``.dat`` files the airfoils that meshcore ships are taken. Skew is the departure from 90 degrees of
the angle between lines at points, by differences over the neighbours, the wall left out, but where it stands beside
Construct2D's: there it is theirs, of the smallest corner of any cell, on fronts and layers like theirs.
"""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
from _common import Target, arguments, print_claim, print_heading, print_row, taken_alternately
from _construct2d import AROUND, KNOWN, WAKE, marched_alike, skew
from _construct2d import LAYERS as LEVELS

import meshcore as mc
from meshcore import gallery, io
from meshcore.geometry.curves import polyline
from meshcore.mesh import StructuredGrid
from meshcore.quality import line_angle
from meshcore.sizing.around_loop import respaced_loop
from meshcore.structured.marching import parabolic_march
from meshcore.structured.marching.hyperbolic_march import Marched, marched
from meshcore.structured.marching.layer_heights import layer_heights
from meshcore.structured.poisson.winslow import winslow

LAYERS, REACH, FIRST = 100, 15.0, 1e-5
GROWTH = Target(2.0, 0.5, at_most=True)
SECONDS = Target(0.15, 0.03, at_most=True)
SAME_WORK = Target(1.3, at_most=True)
POINTS, HEIGHTS = (None, 101, 250, 401, 801), (1e-3, 1e-4, 1e-5, 1e-6)


def clockwise(section, cells: int | None = None) -> np.ndarray:
    """(n, 2) points of a section as it is given, or resampled."""
    loop = polyline(section)[:-1, :2]
    return np.ascontiguousarray((loop if cells is None else respaced_loop(loop, cells))[::-1])


def heights(first: float) -> np.ndarray:
    """Of the grids of the tables."""
    return layer_heights(first, 3.0, layers=LAYERS, distance=REACH)


def worst_skew(result: Marched) -> float:
    """Degrees."""
    ring = np.concatenate([result.points, result.points[:1]])
    grid = StructuredGrid(np.concatenate([ring, 0 * ring[..., :1]], axis=2), periodic=(True, False, False))
    return float(90 - line_angle(grid)[:, 1:-1].min())


def growth_error(result: Marched, asked: np.ndarray) -> tuple[float, float]:
    """Percent by which growth departs from what was asked: of the layers' mean heights, and at the worst point."""
    steps = np.linalg.norm(np.diff(result.points, axis=1), axis=2)
    ratio = asked[1:] / asked[:-1]
    mean = steps.mean(axis=0)
    return (
        100 * float(np.abs(mean[1:] / mean[:-1] / ratio - 1).max()),
        100 * float(np.abs(steps[:, 1:] / steps[:, :-1] / ratio - 1).max()),
    )


def airfoils(sections: dict) -> None:
    """The tables of skew and of growth, and of all airfoils with default parameters."""
    print_heading(
        f"Airfoils, 250 points, {LAYERS} layers to {REACH:.0f} chords, first height {FIRST:g}",
        "Growth: of each layer's mean height over the last's, and at the worst point, against what was asked.",
    )
    print_row("section", "worst skew (degree)", "as in the file", "growth, mean (%)", "worst point (%)", head=True)
    for name, section in sections.items():
        result = marched(clockwise(section, 250), heights(FIRST), closed=True)
        coarse = marched(clockwise(section), heights(FIRST), closed=True)
        mean, worst = growth_error(result, heights(FIRST))
        print_row(name, worst_skew(result), worst_skew(coarse), GROWTH.verdict(mean), worst)
    tried = [(s, n, f) for s in sections.values() for n in POINTS for f in HEIGHTS]
    whole = sum(marched(clockwise(s, n), heights(f), closed=True).stop is None for s, n, f in tried)
    verdict = Target(len(tried)).verdict(whole)
    print(f"\nWhole grids of {POINTS} points and first heights {HEIGHTS}, no parameter touched: {verdict}")


def beside_construct2d(sections: dict) -> None:
    """The table of skew as Construct2D measures it, on fronts and layers like its own."""
    print_heading(
        "Worst skew as Construct2D measures it, with its defaults: 250 points, 100 levels to 15 chords, y+ 0.9",
        "O-grids with a rounded base round blunt sections, C-grids round sharp ones. Half the front's sharpest turn\n"
        "is the skew of the cell there, whatever the march does.",
    )
    print_row(
        "section", "front", "worst skew (degree)", "half the sharpest turn", "C-grid on points of its own", head=True
    )
    for name, section in sections.items():
        grid, blunt, turn = marched_alike(polyline(section)[:, :2])
        worst, known = skew(grid), KNOWN.get(name)
        told = Target(known, round(2 * known / 3, 1), at_most=True).verdict(worst) if known else f"{worst:.3g}"
        own = max(map(skew, own_points(section)))
        own = Target(known, round(2 * known / 3, 1), at_most=True).verdict(own) if known else f"{own:.3g}"
        print_row(name, "O" if blunt else "C", told, turn / 2, own)


def own_points(section: mc.Mesh) -> list[np.ndarray]:
    """Blocks (ni, nj, 2) of a C-grid with as many points and layers, which stand where `c_grid` puts them."""
    grid, _ = mc.c_grid(
        section, method="hyperbolic", around=AROUND, layers=LEVELS, radius=REACH, y_plus=0.9, wake_cells=WAKE
    )
    return [block.points[:, :, 0, :2] for block in (grid.blocks if isinstance(grid, mc.MultiBlock) else [grid])]


def random_sections(count: int) -> None:
    """How many of a random lot of closed sections get all of their layers."""
    print_heading(f"{count} random sections each, 80 layers to ten times their size, no parameter touched")
    print_row("kind", "whole", "worst skew, median", "largest", head=True)
    for name, make in (("four-digit airfoils", four_digits), ("blobs", blob), ("polygons with spikes", spiky)):
        rng, skews, whole = np.random.default_rng(7), [], 0
        for _ in range(count):
            front = make(rng, int(rng.choice([60, 120, 250])))
            size = float(np.linalg.norm(np.ptp(front, axis=0)))
            first = size * 10 ** rng.uniform(-5, -2.3)
            result = marched(front, layer_heights(first, 3.0, layers=80, distance=10 * size), closed=True)
            whole += result.stop is None
            skews.append(worst_skew(result) if result.points.shape[1] > 3 else 90.0)
        print_row(name, Target(count).verdict(whole), float(np.median(skews)), max(skews))


def four_digits(rng: np.random.Generator, n: int) -> np.ndarray:
    """A clockwise NACA section with any camber and thickness, its edge sharp or blunt."""
    camber, place, thick = rng.uniform(0, 0.1), rng.uniform(0.2, 0.7), rng.uniform(0.04, 0.3)
    x = 0.5 * (1 - np.cos(np.linspace(0, np.pi, n // 2)))
    last = rng.choice([0.1015, 0.1036])
    half = 5 * thick * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - last * x**4)
    line = np.where(x < place, camber / place**2 * (2 * place - x) * x, 0.0)
    line = np.where(x < place, line, camber / (1 - place) ** 2 * (1 - 2 * place + (2 * place - x) * x))
    upper, lower = np.column_stack([x, line + half]), np.column_stack([x, line - half])
    loop = np.concatenate([upper, lower[-1:0:-1]])
    return loop[np.linalg.norm(np.roll(loop, 1, axis=0) - loop, axis=1) > 1e-6]


def blob(rng: np.random.Generator, n: int) -> np.ndarray:
    """A clockwise smooth body with bays."""
    angle = -2 * np.pi * np.arange(n) / n
    waves = sum(rng.normal() / m * np.cos(m * angle + rng.uniform(0, 7)) for m in range(1, 12))
    radius = np.maximum(1 + 0.4 * waves, 0.15)
    return radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])


def spiky(rng: np.random.Generator, n: int) -> np.ndarray:
    """A clockwise star-shaped polygon with corners at any distance."""
    count = int(rng.integers(4, 14))
    angle = -2 * np.pi * (np.arange(count) + rng.uniform(-0.3, 0.3, count)) / count
    corners = rng.uniform(0.3, 1, count)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    after = np.roll(corners, -1, axis=0)
    length = np.linalg.norm(after - corners, axis=1)
    parts = np.maximum(1, np.round(n * length / length.sum()).astype(int))
    shares = [np.arange(m)[:, None] / m for m in parts]
    return np.concatenate([a + s * (b - a) for a, b, s in zip(corners, after, shares, strict=True)])


def seconds(repeats: int) -> None:
    """The table of seconds, beside one elliptic iteration on the same points."""
    print_heading("401 x 101 points round rae2822, warm; processor seconds")
    section = gallery.airfoil("rae2822", cells=400)
    front = clockwise(section)
    grid = marched(front, heights(FIRST), closed=True).points
    ring = np.ascontiguousarray(np.concatenate([grid, grid[:1]]))
    outer, shares = grid[:, -1], np.concatenate([[0.0], np.cumsum(heights(FIRST))]) / REACH
    shares[-1] = 1.0
    contestants = {
        "the operation, with its checks and report": lambda: mc.hyperbolic(
            section, first_height=FIRST, layers=LAYERS, distance=REACH
        ),
        "the march": lambda: marched(front, heights(FIRST), closed=True),
        "the parabolic march": lambda: parabolic_march.marched(front, outer, shares, closed=True),
        "elliptic": lambda: winslow(ring, cyclic=True, threads=1),
    }
    times = taken_alternately(contestants, repeats)
    print_row("what", "seconds", head=True)
    for name in list(contestants)[:3]:
        print_row(name, SECONDS.verdict(times[name].seconds))
    cycles = max(1, len(times["elliptic"].result.history) - 1)
    cycle = times["elliptic"].seconds / cycles
    print_row(f"one of {cycles} multigrid cycles of the elliptic solver", cycle)
    print_claim(
        "hyperbolic methods take about the same time as one iteration of an elliptic grid generator.",
        f"the march takes {times['the march'].seconds / cycle:.2f} of one multigrid cycle on the same points, "
        f"the parabolic one {times['the parabolic march'].seconds / cycle:.2f}.",
    )


def work_a_point(sizes: list[int], repeats: int) -> None:
    """The table of microseconds a point."""
    print_heading("Work a point round naca0012: a tenth as many layers as points around")
    print_row("points", "around", "layers", "microseconds a point", "over the first", head=True)
    first = None
    for size in sizes:
        around = int(np.sqrt(10 * size))
        front = clockwise(gallery.airfoil("naca0012"), around)
        asked = layer_heights(1e-4, 3.0, layers=around // 10, distance=REACH)
        run = functools.partial(marched, front, asked, closed=True)
        spent = taken_alternately({"march": run}, max(1, min(repeats, 4_000_000 // size)))["march"].seconds
        each = 1e6 * spent / (around * len(asked))
        first = first or each
        print_row(around * len(asked), around, len(asked), each, SAME_WORK.verdict(each / first))


def main() -> None:
    """All tables."""
    options = arguments(__doc__, sizes=[100_000, 1_000_000, 10_000_000], sections=[400], airfoils=[""])
    names = gallery.airfoils()
    sections = {name: gallery.airfoil(name) for name in names}
    if options.airfoils:
        sections = {path.stem: io.read(path) for path in sorted(Path(options.airfoils[0]).glob("*.dat"))}
    marched(clockwise(gallery.airfoil("naca0012")), heights(1e-3), closed=True)  # compiles
    airfoils(sections)
    beside_construct2d(sections)
    random_sections((options.sections or [20 if options.quick else 400])[0])
    seconds(options.repeats)
    work_a_point(
        options.sizes or ([10_000, 100_000] if options.quick else [100_000, 1_000_000, 10_000_000]), options.repeats
    )


if __name__ == "__main__":
    main()
