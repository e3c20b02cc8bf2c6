"""Points on which triangulators slow down or fail: grids, circles, spheres, clumps, lines up to rounding, lattices.

Time a point relative to uniform points, as many, and against Triangle and TetGen on the same points. Each set has a
process of its own, in which all contestants take turns: a peer that crashes costs only its row.

``python benchmarks/degenerate_points.py [--quick] [--repeats 5]``
"""

from __future__ import annotations

import numpy as np
from _common import (
    Target,
    arguments,
    in_own_process,
    of_turns,
    print_heading,
    print_row,
    taken_alternately,
    with_tetgen,
    with_triangle,
)

import meshcore
from tests import point_sets

RELATIVE_TO_UNIFORM = Target(3, 1.5, at_most=True)
AGAINST_PEER = Target(1)
SETS = {
    2: {
        "integer_grid": 1_000_000, "shuffled_grid": 1_000_000, "linspace_grid": 1_000_000, "rotated_grid": 1_000_000,
        "hexagonal_lattice": 1_000_000, "octahedra": 500_000, "sphere": 200_000, "clumps": 1_000_000,
        "slanted_line": 100_000, "duplicates": 1_000_000, "stretched": 200_000, "tiny": 200_000, "huge": 200_000,
        "offset": 200_000,
    },
    3: {
        "integer_grid": 1_000_000, "shuffled_grid": 1_000_000, "linspace_grid": 1_000_000, "rotated_grid": 1_000_000,
        "hexagonal_lattice": 1_000_000, "octahedra": 200_000, "sphere": 100_000, "clumps": 100_000,
        "slanted_line": 20_000, "duplicates": 200_000, "stretched": 100_000, "tiny": 100_000, "huge": 100_000,
        "offset": 100_000,
    },
}  # fmt: skip


def measured(d: int, name: str, n: int, repeats: int, with_peer: bool) -> tuple[int, str, dict[str, float]]:
    """Points, turns and median seconds of each contestant, in this process; TetGen has two turns on a million."""
    engine = meshcore.delaunay_2d if d == 2 else meshcore.delaunay_3d
    peer = with_triangle if d == 2 else with_tetgen
    rng = np.random.default_rng(1)
    points = point_sets.PLANE[name](n, d, rng)
    uniform = rng.random(points.shape)
    engine(uniform[:1000], threads=1)  # compiles
    contestants = {
        "meshcore": lambda: engine(points, threads=1).mesh.n_cells,
        "uniform": lambda: engine(uniform, threads=1).mesh.n_cells,
    }
    if with_peer:
        contestants["peer"] = lambda: peer(points)
    times = taken_alternately(contestants, repeats, {"peer": 2} if d == 3 and n > 300_000 else {})
    return len(points), of_turns(times.values()), {name: t.seconds for name, t in times.items()}


def main() -> None:
    """Print a table for the plane and one for space."""
    options = arguments(__doc__)
    for d, peer in ((2, "Triangle"), (3, "TetGen")):
        print_heading(
            f"Degenerate points in {'the plane' if d == 2 else 'space'}",
            f"Processor seconds, one thread, medians of as many turns as said; each row in one process, in turns with "
            f"uniform points, as many, and with {peer}.",
        )
        print_row(
            "points of",
            "number",
            "turns",
            "meshcore",
            "us a point",
            "relative to uniform",
            peer,
            f"{peer} / meshcore",
            head=True,
        )
        for name, n in SETS[d].items():
            n = min(n, 5000) if options.quick else n
            found = in_own_process(measured, d, name, n, options.repeats, True)
            fault = ""
            if isinstance(found, Exception):
                fault = str(found)
                found = in_own_process(measured, d, name, n, options.repeats, False)
            if isinstance(found, Exception):
                print_row(name, n, "-", f"FAILED: {found}", "-", "-", "-", "-")
                continue
            number, turns, seconds = found
            ours = seconds["meshcore"]
            print_row(
                name,
                number,
                turns,
                ours,
                ours / number * 1e6,
                RELATIVE_TO_UNIFORM.verdict(ours / seconds["uniform"]),
                seconds.get("peer", fault),
                AGAINST_PEER.verdict(seconds["peer"] / ours) if "peer" in seconds else "-",
            )


if __name__ == "__main__":
    main()
