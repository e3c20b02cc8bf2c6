"""Peak memory a point of Delaunay triangulation, each contestant in a fresh process; Linux only.

Counted is the highest resident size during the call less that just before it, so without the points that were given,
but with the mesh that is returned. ``python benchmarks/memory.py [--quick]``
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from _common import Target, arguments, in_own_process, print_heading, print_row, with_scipy, with_tetgen, with_triangle

import meshcore

TARGET = {2: Target(250, 125, at_most=True), 3: Target(700, 350, at_most=True)}
CONTESTANTS = {
    2: ("meshcore", "meshcore, 2 threads", "Triangle", "scipy"),
    3: ("meshcore", "meshcore, 2 threads", "TetGen", "scipy"),
}


def status(key: str) -> int:
    """Bytes that Linux notes of this process: VmRSS now, VmHWM at most."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(key + ":"):
            return 1024 * int(line.split()[1])
    raise OSError(f"/proc/self/status has no {key}")


def bytes_a_point(name: str, d: int, n: int) -> float:
    """Peak bytes a point, in this process."""
    engine = meshcore.delaunay_2d if d == 2 else meshcore.delaunay_3d
    run = {
        "meshcore": lambda p: engine(p, threads=1),
        "meshcore, 2 threads": lambda p: engine(p, threads=2),
        "Triangle": with_triangle,
        "TetGen": with_tetgen,
        "scipy": with_scipy,
    }[name]
    points = np.random.default_rng(n).random((n, d))
    run(points[:1000])  # compiles
    before = status("VmRSS")
    Path("/proc/self/clear_refs").write_text("5")  # the peak begins anew
    kept = run(points)
    peak = status("VmHWM")
    del kept
    return (peak - before) / n


def main() -> None:
    """Print the table."""
    options = arguments(__doc__)
    print_heading("Peak memory of Delaunay triangulation", "Bytes a point beside the points given; a process each.")
    print_row("space", "points", "contestant", "bytes a point", head=True)
    for d, names in CONTESTANTS.items():
        n = 50_000 if options.quick else 1_000_000
        for name in names:
            size = min(n, 100_000) if (name, d) == ("scipy", 3) else n
            found = in_own_process(bytes_a_point, name, d, size)
            text = str(found) if isinstance(found, Exception) else found
            print_row(f"{d}D", size, name, TARGET[d].verdict(found) if "meshcore" in name and text == found else text)


if __name__ == "__main__":
    main()
