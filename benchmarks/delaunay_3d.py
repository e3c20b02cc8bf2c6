"""delaunay_3d of uniform random points beside TetGen (meshpy), scipy (Qhull) and Gmsh, by one thread and by two.

``python benchmarks/delaunay_3d.py [--quick] [--repeats 5] [--points 100000 1000000]``
"""

from __future__ import annotations

import numpy as np
from _common import (
    Target,
    arguments,
    is_installed,
    of_turns,
    print_heading,
    print_row,
    taken_alternately,
    with_gmsh,
    with_scipy,
    with_tetgen,
)

import meshcore

SMALL, LARGE = 100_000, 1_000_000
AGAINST_TETGEN = {SMALL: Target(2.5, 4), LARGE: Target(1.8, 3)}
TWO_THREADS = {SMALL: Target(2.5, 4), LARGE: Target(2.5, 4)}
AGAINST_SCIPY = Target(10, 20)


def main() -> None:
    """Print both tables."""
    options = arguments(__doc__, points=[SMALL, LARGE])
    sizes = options.points or ([10_000] if options.quick else [SMALL, LARGE])
    meshcore.delaunay_3d(np.random.default_rng(0).random((1000, 3)), threads=1)  # compiles
    lines = [measured(n, options.repeats) for n in sizes]
    print_heading(
        "Delaunay triangulation of uniform points in space",
        "Processor seconds, one thread each, alternately in one process; medians of as many turns as said. "
        "TetGen is without copying to and from Python, the call by meshpy with copying the points, one by one.",
    )
    print_row(
        "points", "turns", "meshcore", "TetGen", "scipy", "Gmsh", "against TetGen", "against the call", "against scipy",
        head=True,
    )  # fmt: skip
    for n, times in zip(sizes, lines, strict=True):
        ours = times["one thread"].seconds
        names = ("one thread", "TetGen", "scipy", "Gmsh")
        print_row(
            n,
            of_turns(times.values()),
            *(times[name].seconds if name in times else "-" for name in names),
            target(AGAINST_TETGEN, n).verdict(times["TetGen"].seconds / ours),
            target(AGAINST_TETGEN, n).verdict((times["TetGen"].seconds + times["TetGen"].result.copying) / ours),
            AGAINST_SCIPY.verdict(times["scipy"].seconds / ours) if "scipy" in times else "-",
        )
    print_heading("The same on two threads", "Seconds on the wall, since processor seconds add up over threads.")
    print_row("points", "turns", "one thread", "two threads", "TetGen", "speed-up", "against TetGen", head=True)
    for n, times in zip(sizes, lines, strict=True):
        one, two, peer = (times[name].wall_seconds for name in ("one thread", "two threads", "TetGen"))
        print_row(n, times["TetGen"].turns, one, two, peer, one / two, target(TWO_THREADS, n).verdict(peer / two))


def target(targets: dict[int, Target], n: int) -> Target:
    """That of the nearest size."""
    return targets[LARGE if n > 300_000 else SMALL]


def measured(n: int, repeats: int) -> dict:
    """Times of all contestants on n points; scipy would take minutes beyond 3e5."""
    points = np.random.default_rng(n).random((n, 3))
    contestants = {
        "one thread": lambda: meshcore.delaunay_3d(points, threads=1).mesh.n_cells,
        "two threads": lambda: meshcore.delaunay_3d(points, threads=2).mesh.n_cells,
        "TetGen": lambda: with_tetgen(points),
    }
    if n <= 300_000:
        contestants["scipy"] = lambda: with_scipy(points)
    if is_installed("gmsh"):
        contestants["Gmsh"] = lambda: with_gmsh(points)
    times = taken_alternately(contestants, repeats, {"Gmsh": 2} if n > 300_000 else {"scipy": 3, "Gmsh": 3})
    assert times["one thread"].result == times["two threads"].result == times["TetGen"].result.cells
    return times


if __name__ == "__main__":
    main()
