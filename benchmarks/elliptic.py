"""Elliptic grids: work a point by size, distance to point relaxation, and control of walls round airfoils.

``python benchmarks/elliptic.py [--quick] [--repeats 5] [--points 129 257 513 1025 2049] [--airfoils FOLDER]``

Without a folder of ``.dat`` files the airfoils that meshcore ships are taken.
"""

from __future__ import annotations

import statistics
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
from _common import Target, arguments, in_own_process, print_heading, print_row, taken_alternately
from scipy.interpolate import CubicSpline

from meshcore import gallery, io
from meshcore._numba import kernel
from meshcore.geometry.curves import polyline
from meshcore.sizing import geometric
from meshcore.structured.algebraic.transfinite import interpolated
from meshcore.structured.poisson.barrier import unfolded, weak_cells
from meshcore.structured.poisson.wall_control import FEWEST_CELLS, Wall, controlled, measured
from meshcore.structured.poisson.winslow import CUT, Frame, levels_of, orientation, winslow
from meshcore.threads import Workers

TOLERANCE = 1e-8
LINEAR = Target(2.5, 1.5, at_most=True)
CONVERGED = Target(2.5, 1.0, at_most=True)
NEAR = Target(0.7, 0.3, at_most=True)
RELAXATION = Target(30, 100)
WALL_SECONDS = Target(0.5, 0.1, at_most=True)
ASPECT = 1000.0
SECTIONS = ("naca0012", "s1223")
HEIGHTS = (1e-3, 1e-5)


class Case(NamedTuple):
    """A start for the solver."""

    points: np.ndarray
    cyclic: bool = False


def wavy_square(n: int) -> Case:
    """A unit square with waves on all sides."""
    s = np.linspace(0, 1, n)
    wave = 0.15 * np.sin(2 * np.pi * s)
    south, north = np.column_stack([s, wave]), np.column_stack([s, 1 + 0.15 * np.sin(3 * np.pi * s)])
    return Case(_between(south, np.column_stack([1 + wave, s]), north, np.column_stack([-wave, s]), "linear"))


def channel(n: int) -> Case:
    """A channel with a bump, whose cells at the wall are a thousand times as long as high."""
    s = np.linspace(0, 2, n)
    t = geometric(n - 1, first=s[1] / ASPECT)
    south = np.column_stack([s, 0.1 * np.exp(-(((s - 1) / 0.2) ** 2))])
    low = south[0, 1]
    west = np.column_stack([0 * t, low + t * (1 - low)])
    return Case(_between(south, west + [2, 0], np.column_stack([s, 0 * s + 1]), west, "arc length"))


def annulus(section: np.ndarray, around: int, out: int, first: float, radius: float = 10.0) -> Case:
    """Straight rays from a section to a circle of ``radius`` chords, both clockwise from the trailing edge."""
    loop = around_section(section, around)
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(loop, axis=0), axis=1))])
    angle = -2 * np.pi * (0.8 * np.linspace(0, 1, len(loop)) + 0.2 * length / length[-1])
    circle = np.column_stack([0.5 + radius * np.cos(angle), radius * np.sin(angle)])
    circle[-1] = circle[0]
    t = geometric(out, first=first / radius)[None, :, None]
    return Case((1 - t) * loop[:, None] + t * circle[:, None], True)


def around_section(loop: np.ndarray, around: int) -> np.ndarray:
    """A closed section's points by splines, closer together at both edges; a blunt trailing edge is closed first."""
    behind = loop[:, 0].max() - 1e-4
    if loop[-1, 0] > behind and loop[0, 0] > behind:
        side = np.where(np.arange(len(loop)) <= np.argmin(loop[:, 0]), -0.5, 0.5)
        loop = loop + (side * np.clip(loop[:, 0], 0, 1) ** 2)[:, None] * (loop[0] - loop[-1])
        loop[0] = loop[-1] = 0.5 * (loop[0] + loop[-1])
    else:
        loop = np.vstack([loop, loop[:1]])
    loop = loop[::-1]
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(loop, axis=0), axis=1))])
    nose = length[np.argmin(loop[:, 0])]
    u = np.linspace(0, 1, around // 2 + 1)
    fractions = 0.4 * (1 - np.cos(np.pi * u)) + 0.2 * u
    points = CubicSpline(length, loop)(np.concatenate([nose * fractions, nose + (length[-1] - nose) * fractions[1:]]))
    points[0] = points[-1] = loop[0]
    return points


def cases(n: int) -> dict[str, Case]:
    """The starts of the table, of n x n points."""
    sections = {name: polyline(gallery.airfoil(name))[:-1, :2] for name in SECTIONS}
    return {
        "wavy square": wavy_square(n),
        f"channel, aspect {ASPECT:.0f}": channel(n),
        "annulus round naca0012, 1e-5": annulus(sections["naca0012"], n - 1, n - 1, 1e-5),
        "annulus round s1223, 1e-3": annulus(sections["s1223"], n - 1, n - 1, 1e-3),
    }


def _between(south, east, north, west, blending) -> np.ndarray:
    spatial = [np.column_stack([side, 0 * side[:, 0]]) for side in (south, east, north, west)]
    return interpolated(*spatial, blending=blending)[..., :2]


# ---- work a point


def growth_of_work(sizes: list[int], repeats: int) -> None:
    """The table of microseconds a point."""
    spent: dict[str, list[float]] = {}
    for n in sizes:
        for name, case in cases(n).items():
            turns = max(1, min(repeats, 8_000_000 // n**2))
            contestants = {
                "near": lambda c=case: winslow(c.points, cyclic=c.cyclic, threads=1),
                "converged": lambda c=case: winslow(c.points, cyclic=c.cyclic, tolerance=TOLERANCE, threads=1),
                "near, two": lambda c=case: winslow(c.points, cyclic=c.cyclic, threads=2),
                "converged, two": lambda c=case: winslow(c.points, cyclic=c.cyclic, tolerance=TOLERANCE, threads=2),
            }
            times = taken_alternately(contestants, turns)
            near, converged = times["near"].result, times["converged"].result
            each = {key: 1e6 / n**2 * (t.wall_seconds if "two" in key else t.seconds) for key, t in times.items()}
            spent.setdefault(name, []).append(each["converged"])
            sign = orientation(case.points)
            mended = unfolded(converged.points, sign, cyclic=case.cyclic)
            folds = " / ".join(str(weak_cells(points, sign).sum()) for points in (converged.points, mended))
            print_row(
                name,
                n,
                turns,
                f"{len(near.history) - 2}, {len(converged.history) - 2}",
                NEAR.verdict(each["near"]),
                f"{each['near, two']:.2f}",
                CONVERGED.verdict(each["converged"]),
                f"{each['converged, two']:.2f}",
                folds,
            )
            assert near.converged and converged.converged
            assert np.array_equal(converged.points, times["converged, two"].result.points)
    print_heading("Growth of the time a point from the smallest to the largest of these sizes")
    print_row("case", "largest over smallest", head=True)
    for name, each in spent.items():
        print_row(name, LINEAR.verdict(max(each) / min(each)))


# ---- point relaxation


@kernel
def sweeps(r, factor, number):
    """Successive over-relaxation, point by point, of the Winslow equations on (2, ni, nj) coordinates."""
    for _ in range(number):
        for i in range(1, r.shape[1] - 1):
            for j in range(1, r.shape[2] - 1):
                xi, yi = 0.5 * (r[0, i + 1, j] - r[0, i - 1, j]), 0.5 * (r[1, i + 1, j] - r[1, i - 1, j])
                xj, yj = 0.5 * (r[0, i, j + 1] - r[0, i, j - 1]), 0.5 * (r[1, i, j + 1] - r[1, i, j - 1])
                a, b, g = xj * xj + yj * yj, 0.5 * (xi * xj + yi * yj), xi * xi + yi * yi
                for x in range(2):
                    mixed = r[x, i + 1, j + 1] - r[x, i + 1, j - 1] - r[x, i - 1, j + 1] + r[x, i - 1, j - 1]
                    new = a * (r[x, i + 1, j] + r[x, i - 1, j]) + g * (r[x, i, j + 1] + r[x, i, j - 1]) - b * mixed
                    r[x, i, j] += factor * (new / (2 * (a + g)) - r[x, i, j])


class Relaxed(NamedTuple):
    """How far relaxation came in the time it had: processor seconds, residual, and seconds for each further order.

    The last is infinite if it diverged or stood still.
    """

    seconds: float
    residual: float
    an_order: float


def relaxed(points: np.ndarray, factor: float, tolerance: float, seconds: float) -> Relaxed:
    """Relax for so many seconds, or until the residual is reached."""
    frame = Frame.of(points)
    with Workers(1) as workers:
        finest = levels_of(frame.inside(points), False, workers).levels[0]
        scale = finest.residual()
        start, residuals, stops = time.process_time(), [1.0], [0.0]
        while residuals[-1] > tolerance and stops[-1] < seconds:
            sweeps(finest.r, factor, 50)
            stops.append(time.process_time() - start)
            residuals.append(finest.residual() / scale)
            if not residuals[-1] < 10:
                return Relaxed(stops[-1], residuals[-1], np.inf)
    half = len(stops) // 2  # the rate of the first half is not yet the asymptotic one
    orders = np.log10(residuals[half] / residuals[-1])
    return Relaxed(stops[-1], residuals[-1], (stops[-1] - stops[half]) / orders if orders > 0 else np.inf)


def against_relaxation(n: int, seconds: float) -> None:
    """The row of one size: the largest factor that does not diverge, among the usual ones.

    Twice measured against the same residual: that which relaxation reached in its time, to which both are measured, and
    1e-8, to which relaxation is carried on by the rate of the second half of its time.
    """
    case = wavy_square(n)
    best = 2 / (1 + np.sin(np.pi / (n - 1)))
    for factor in (best, 1.99, 1.95, 1.9, 1.8, 1.5, 1.0):
        theirs = relaxed(case.points, factor, TOLERANCE, seconds)
        if theirs.residual < 1 and np.isfinite(theirs.an_order):
            break
    ours = [_seconds_to(case, tolerance) for tolerance in (theirs.residual, TOLERANCE)]
    whole = theirs.seconds + theirs.an_order * max(np.log10(theirs.residual / TOLERANCE), 0)
    print_row(
        n,
        f"{factor:.4f}",
        f"{theirs.residual:.1e}",
        theirs.seconds,
        ours[0],
        RELAXATION.verdict(theirs.seconds / ours[0]),
        f"{theirs.an_order:.1f}",
        whole,
        ours[1],
        f"{whole / ours[1]:.0f}",
    )


def _seconds_to(case: Case, tolerance: float) -> float:
    """Processor seconds of the solver on one thread."""
    start = time.process_time()
    winslow(case.points, tolerance=tolerance, threads=1)
    return time.process_time() - start


# ---- walls


def sections(folder: str | None) -> dict[str, np.ndarray]:
    """Closed sections by name."""
    if folder is None:
        return {name: polyline(gallery.airfoil(name))[:-1, :2] for name in gallery.airfoils()}
    paths = sorted(Path(folder).glob("*.dat"))
    return {path.stem: polyline(io.read(path))[:-1, :2] for path in paths}


class Walled(NamedTuple):
    """A controlled grid and how it went."""

    points: np.ndarray
    steps: int
    converged: bool


def with_wall(case: Case, height: float, threads: int) -> Walled:
    """The grid with right angles and the first height at the wall."""
    frame = Frame.of(case.points)
    growth = np.zeros((2, *case.points.shape[:2]))
    with Workers(threads) as workers:
        levels = levels_of(frame.inside(case.points), True, workers, FEWEST_CELLS)
        went = controlled(levels, [Wall("south", height / frame.size)], growth)
        points = frame.outside(levels.levels[0].points_without_ghosts, case.points, CUT)
    points = unfolded(points, orientation(case.points), cyclic=True)
    return Walled(points, len(went.history) - 2, went.converged)


def walls(folder: str | None, repeats: int) -> None:
    """The table of airfoils."""
    seconds = []
    for height in HEIGHTS:
        for name, section in sections(folder).items():
            case = annulus(section, 256, 96, 2e-3)
            runs = {str(k): lambda c=case, h=height, k=k: with_wall(c, h, k) for k in (1, 2)}
            times = taken_alternately(runs, repeats)
            found = times["1"].result
            sign = orientation(case.points)
            have = measured(np.ascontiguousarray(np.moveaxis(found.points, -1, 0)), "south", sign, True)
            counted = np.s_[3:-3]  # without the trailing edge and two nodes on either side
            angle = np.abs(have.angle - 90)[counted].max()
            off = 100 * np.abs(have.height / height - 1)[counted].max()
            one, other = found.points[1:, 1:] - found.points[:-1, :-1], found.points[:-1, 1:] - found.points[1:, :-1]
            areas = sign * (one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0])
            seconds.append(times["1"].seconds)
            print_row(
                f"{name}, {height:.0e}",
                found.steps,
                f"{angle:.2f} {'met' if angle < 1 else 'MISSED'}",
                f"{off:.1f} {'met' if off < 5 else 'MISSED'}",
                int((areas <= 0).sum()),
                int(weak_cells(found.points, sign, 0.0).sum()),
                WALL_SECONDS.verdict(times["1"].seconds),
                f"{times['2'].wall_seconds:.2f}",
            )
    print(f"\nMedian {statistics.median(seconds):.2f} s, most {max(seconds):.2f} s.")


class Stars(NamedTuple):
    """Grids of random stars that each means leaves folded, those not converged, and the worst of the equations."""

    transfinite: int
    elliptic: int
    unfolded: int
    not_converged: int
    most_cells: int
    farthest: int
    least_area: float


def stars(number: int, n: int) -> None:
    """What the discrete equations do on random star-shaped boundaries."""
    found = in_own_process(count_stars, number, n)
    print_row(number, n, *found[:4], found.most_cells, found.farthest, f"{found.least_area:.2f}")


def count_stars(number: int, n: int) -> Stars:
    """Fold so many stars of n cells a side."""
    rng = np.random.default_rng(1987)
    spilt = folded = left = strained = most = farthest = 0
    least = 1.0
    for _ in range(number):
        start = _between(*star(rng, n), "linear")
        solution = winslow(start, threads=1)
        areas = cell_areas(solution.points)
        bad = np.argwhere(areas <= 0)
        spilt += bool((cell_areas(start) <= 0).any())
        folded += len(bad) > 0
        left += bool((cell_areas(unfolded(solution.points, 1.0)) <= 0).any())
        strained += not solution.converged
        most = max(most, len(bad))
        farthest = max(farthest, int(np.minimum(bad, n - 1 - bad).min(axis=1).max(initial=-1)) + 1)
        least = min(least, float(areas.min() / areas.mean()))
    return Stars(spilt, folded, left, strained, most, farthest, least)


def star(rng: np.random.Generator, n: int) -> tuple[np.ndarray, ...]:
    """South, east, north and west of a star-shaped boundary of eight random waves."""
    angle = np.linspace(0, 2 * np.pi, 4 * n + 1)[:-1] + rng.uniform(0, 2 * np.pi)
    bumps = sum(0.5 / k * (rng.normal() * np.cos(k * angle) + rng.normal() * np.sin(k * angle)) for k in range(1, 9))
    radius = np.exp(np.clip(bumps, -1.5, 1.5))
    loop = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    loop = np.vstack([loop, loop[:1]])
    return loop[: n + 1], loop[n : 2 * n + 1], loop[2 * n : 3 * n + 1][::-1], loop[3 * n :][::-1]


def cell_areas(grid: np.ndarray) -> np.ndarray:
    """(ni - 1, nj - 1) areas of a planar grid's cells."""
    one, other = grid[1:, 1:] - grid[:-1, :-1], grid[:-1, 1:] - grid[1:, :-1]
    return 0.5 * (one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0])


def main() -> None:
    """Print the tables."""
    options = arguments(__doc__, points=[129, 257, 513, 1025, 2049], airfoils=[""])
    sizes = options.points or ([129, 257] if options.quick else [129, 257, 513, 1025, 2049])
    for case in cases(33).values():  # compiles
        winslow(case.points, cyclic=case.cyclic, tolerance=TOLERANCE)
    print_heading(
        "Winslow equations from the transfinite grid",
        "Microseconds a point: of the processor with one thread, of the wall with two. Near: within a thousandth of "
        "the local spacing, the default; converged: to 1e-8 of the start's residual. Folds: cells with a corner that "
        "is not convex, of the equations' solution and after the barrier that operations end in. Behind a sharp or "
        "cusped trailing edge the equations' own cut leaves the edge at more than 180 degrees to one side: there such "
        "cells are no fault of the solver, and stay however far it converges.",
    )
    print_row(
        "case",
        "points a side",
        "turns",
        "cycles",
        "near",
        "two threads",
        "converged",
        "two threads",
        "folds",
        head=True,
    )
    growth_of_work(sizes, options.repeats)
    print_heading(
        "Against point relaxation with the largest stable factor",
        "Processor seconds: measured to the residual that relaxation reached in the time it was given; and to 1e-8, "
        "where it is extrapolated by the seconds that an order of the residual took in the second half of its time.",
    )
    print_row(
        "points a side",
        "factor",
        "residual reached",
        "relaxation",
        "meshcore",
        "times faster",
        "seconds an order",
        "to 1e-8, extrapolated",
        "meshcore",
        "times faster",
        head=True,
    )
    relaxed(wavy_square(33).points, 1.0, 0.1, 1.0)
    against_relaxation(257 if options.quick else 1025, 5.0 if options.quick else 60.0)
    print_heading(
        "Angle and first height round airfoils",
        "257 x 97 points, ten chords; largest errors but for the trailing edge and two nodes on either side of it.",
    )
    print_row("airfoil", "steps", "angle", "height, %", "folded", "not convex", "seconds", "two threads", head=True)
    walls((options.airfoils or [None])[0] or None, options.repeats)
    print_heading(
        "Random stars",
        "Grids with a cell of no area, of transfinite interpolation and of the Laplace equations. The worst: most such "
        "cells of one elliptic grid, how many cells from the boundary they reach, and the least area, in mean areas. "
        "They stand beside points where the boundary turns inwards by 50 to 90 degrees from one cell to the next.",
    )
    worst = ("most cells", "within", "least area")
    print_row("stars", "cells a side", "transfinite", "elliptic", "barrier", "not converged", *worst, head=True)
    for n in (16, 32):
        stars(200 if options.quick else 10_000, n)


if __name__ == "__main__":
    main()
