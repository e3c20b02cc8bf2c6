"""Cost against the number of uniform points, and the exponent of a power law through it.

``python benchmarks/scaling.py [--quick] [--repeats 5]``
"""

from __future__ import annotations

from functools import partial

import numpy as np
from _common import Target, arguments, print_claim, print_heading, print_row, taken_alternately

import meshcore

EXPONENT = Target(1.1, 1.03, at_most=True)
PLANE = (10_000, 30_000, 100_000, 300_000, 1_000_000, 3_000_000, 10_000_000)
SPACE = (10_000, 30_000, 100_000, 300_000, 1_000_000, 3_000_000)


def cells(engine, points: np.ndarray) -> int:
    """How many cells the triangulation has."""
    return engine(points, threads=1).mesh.n_cells


def main() -> None:
    """Print a table and an exponent for the plane and for space."""
    options = arguments(__doc__)
    for d, sizes in ((2, PLANE), (3, SPACE)):
        engine = meshcore.delaunay_2d if d == 2 else meshcore.delaunay_3d
        sizes = sizes[:3] if options.quick else sizes
        clouds = {n: np.random.default_rng(n).random((n, d)) for n in sizes}
        engine(clouds[sizes[0]], threads=1)  # compiles
        times = taken_alternately(
            {n: partial(cells, engine, points) for n, points in clouds.items()},
            options.repeats,
            {n: 3 for n in sizes if n > 1_000_000},
        )
        print_heading(f"Cost against N in {'the plane' if d == 2 else 'space'}", "Processor seconds, one thread.")
        print_row("points", "turns", "seconds", "us a point", "cells", head=True)
        for n, found in times.items():
            print_row(n, found.turns, found.seconds, found.seconds / n * 1e6, found.result)
        seconds = [found.seconds for found in times.values()]
        exponent = float(np.polyfit(np.log(sizes), np.log(seconds), 1)[0])
        print(f"\nExponent by least squares: {EXPONENT.verdict(exponent)}")
        print_claim(
            "worst case N^2, but near O(N) has been reported; random order of insertion avoids the worst case "
            "(section 3.2.4, Performance)",
            f"N^{exponent:.3f} from {sizes[0]:,} to {sizes[-1]:,} points, inserted in a biased random order "
            "along a Hilbert curve",
        )


if __name__ == "__main__":
    main()
