"""delaunay_2d of uniform random points beside Triangle, scipy (Qhull) and Gmsh: seconds, medians, ratios, targets.

``python benchmarks/delaunay_2d.py [--quick] [--repeats 5] [--points 100000 1000000]``
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
    with_triangle,
)

import meshcore

# The targets stand for a million points; at fewer they are printed all the same.
AGAINST_TRIANGLE = Target(3.5, 5)
AGAINST_SCIPY = Target(25, 40)


def main() -> None:
    """Print the table."""
    options = arguments(__doc__, points=[100_000, 1_000_000])
    sizes = options.points or ([20_000] if options.quick else [100_000, 1_000_000])
    print_heading(
        "Delaunay triangulation of uniform points in the plane",
        "Processor seconds, one thread each, alternately in one process; medians of as many turns as said.",
    )
    print_row(
        "points", "turns", "meshcore", "Triangle", "scipy", "Gmsh", "against Triangle", "against scipy", head=True
    )
    meshcore.delaunay_2d(np.random.default_rng(0).random((1000, 2)), threads=1)  # compiles
    for n in sizes:
        points = np.random.default_rng(n).random((n, 2))
        contestants = {
            "meshcore": lambda p=points: meshcore.delaunay_2d(p, threads=1).mesh.n_cells,
            "Triangle": lambda p=points: with_triangle(p),
            "scipy": lambda p=points: with_scipy(p),
        }
        if is_installed("gmsh"):
            contestants["Gmsh"] = lambda p=points: with_gmsh(p)
        few = {"scipy": 3, "Gmsh": 3} if n > 300_000 else {}
        times = taken_alternately(contestants, options.repeats, few)
        assert times["meshcore"].result == times["Triangle"].result, "not as many triangles as Triangle"
        ours = times["meshcore"].seconds
        print_row(
            n,
            of_turns(times.values()),
            *(times[name].seconds if name in times else "-" for name in ("meshcore", "Triangle", "scipy", "Gmsh")),
            AGAINST_TRIANGLE.verdict(times["Triangle"].seconds / ours),
            AGAINST_SCIPY.verdict(times["scipy"].seconds / ours),
        )


if __name__ == "__main__":
    main()
