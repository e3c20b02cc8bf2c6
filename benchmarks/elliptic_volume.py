"""The elliptic solver in space: time a point to given residuals, against interpolation of the same block.

``python benchmarks/elliptic_volume.py [--quick] [--repeats 5] [--points 33 65 129]``
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from _common import Target, arguments, print_heading, print_row, taken_alternately

from meshcore import quality
from meshcore.mesh import StructuredGrid
from meshcore.structured import elliptic_volume
from meshcore.structured.algebraic.blending import blended
from meshcore.structured.poisson.winslow_3d import count_folded, solved

ON_ONE = {1e-4: Target(1.5, at_most=True), 1e-8: Target(3.0, at_most=True)}
ON_TWO = {1e-4: Target(1.5, 0.75, at_most=True), 1e-8: Target(3.0, 1.5, at_most=True)}
DEFAULT = "default stop"


def passage(n: int, stretch: float = 0.0) -> np.ndarray:
    """(n, n, n, 3): twisted, curved passage with a bump, filled by interpolation; spacing by a tanh along j."""
    s = np.linspace(0, 1, n)
    v = s if stretch == 0 else 0.5 * (1 + np.tanh(stretch * (2 * s - 1)) / np.tanh(stretch))
    u, v, w = np.meshgrid(s, v, s, indexing="ij")
    p = (u - 0.5) * (1 + 0.3 * np.sin(np.pi * w))
    q = v - 0.5 + 0.15 * np.sin(2 * np.pi * u) * v
    turn = 1.2 * w
    x, y = p * np.cos(turn) - q * np.sin(turn), p * np.sin(turn) + q * np.cos(turn)
    return blended(np.stack([x + 0.4 * np.sin(2 * w), y, 2.5 * w + 0.2 * u * np.sin(3 * v)], axis=-1), (0, 1, 2))


def rows_of(n: int, stretch: float, repeats: int) -> None:
    """The rows of one passage: one and two threads, each goal."""
    start = passage(n, stretch)
    goals = {DEFAULT: None, "1e-4": 1e-4, "1e-8": 1e-8}

    def run(tolerance: float | None, threads: int) -> Callable[[], object]:
        return lambda: solved(start, tolerance=tolerance, threads=threads)

    contestants = {(name, threads): run(goal, threads) for name, goal in goals.items() for threads in (1, 2)}
    contestants["interpolation", 1] = lambda: blended(start, (0, 1, 2))
    times = taken_alternately(contestants, repeats)
    other = times["interpolation", 1].seconds
    for name, goal in goals.items():
        one, two = times[name, 1], times[name, 2]
        points, outcome = two.result
        assert outcome.converged
        assert (points == one.result[0]).all()
        wall, processor = (1e6 * seconds / n**3 for seconds in (two.wall_seconds, one.seconds))
        judged = goal in ON_ONE and n == 129 and stretch == 0
        print_row(
            f"{n}^3, stretch {stretch:g}",
            name,
            outcome.cycles - 1,
            f"{outcome.residuals[-1] / outcome.residuals[0]:.1e}",
            ON_ONE[goal].verdict(processor) if judged else processor,
            ON_TWO[goal].verdict(wall) if judged else wall,
            one.seconds / other,
            count_folded(points),
        )


def wall_rows(n: int, repeats: int) -> None:
    """Rows of the passage with walls whose first cells are a tenth and a hundredth of the others."""
    start = StructuredGrid(passage(n))
    cases = {(faces, height): height / n for faces in ("jmin", "j and k") for height in (0.1, 0.01)}

    def run(faces: str, height: float) -> Callable[[], object]:
        return lambda: elliptic_volume(
            start, walls=faces, first_height=height, faces="respaced", lean_at_edges=True, threads=1
        )

    times = taken_alternately({case: run(case[0], height) for case, height in cases.items()}, repeats)
    for (faces, height), taken in times.items():
        report = taken.result.report
        print_row(
            f"{n}^3, walls {faces}, height {height:g} of a cell",
            report.iterations,
            1e6 * taken.seconds / n**3,
            report.quality["error of wall angles (degree)"],
            report.quality["error of first heights (%)"],
            report.quality["points at walls as asked (%)"],
            "yes" if report.converged else "no",
        )


def main() -> None:
    """Print the table."""
    options = arguments(__doc__, points=[33, 65, 129])
    sizes = options.points or ([33] if options.quick else [33, 65, 129])
    solved(passage(33), threads=2)  # compiles
    print_heading(
        "Elliptic grids in space: a twisted passage from transfinite interpolation",
        "Microseconds a point: of the processor on one thread, on the wall on two; medians, alternately in one "
        "process. Residuals are parts of the start's; interpolation is numpy's Boolean sum of the same block.",
    )
    print_row("case", "goal", "cycles", "residual", "one thread", "two threads", "/ interpolation", "folded", head=True)
    for n in sizes:
        for stretch in (0.0, 2.5):
            rows_of(n, stretch, options.repeats)
    print_heading(
        "Walls in space: the passage, its faces respaced to fit",
        "Microseconds a point of the processor on one thread, the whole operation with respacing and checks. Errors "
        "are the largest where they are judged.",
    )
    print_row("case", "cycles", "us a point", "angle", "height (%)", "as asked (%)", "converged", head=True)
    for n in sizes[:2]:
        wall_rows(n, options.repeats)
    worst = quality.measure(StructuredGrid(solved(passage(33))[0]), "scaled_jacobian").min()
    print(f"\nLeast scaled Jacobian of the passage of 33^3 points: {worst:.3f}")


if __name__ == "__main__":
    main()
