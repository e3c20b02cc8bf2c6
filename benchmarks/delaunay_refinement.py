"""Delaunay refinement beside Triangle: the same square with a hole, in one process, alternately; medians and ratios.

``python benchmarks/delaunay_refinement.py [triangles ...]``. "mesh" is all that a call does, quality checks included;
"refine" ends where Triangle's work ends.
"""

from __future__ import annotations

import sys
import time
from statistics import median

import numpy as np
import triangle

import meshcore
from meshcore.gallery import square_with_hole
from meshcore.unstructured import refiner

REPEATS = 3


def timed(function):
    """Result and seconds of a call."""
    start = time.perf_counter()
    result = function()
    return result, time.perf_counter() - start


def compare(n: int, min_angle: int) -> str:
    """One line of the table: about ``n`` triangles at one smallest angle."""
    boundary = square_with_hole(50)
    max_area = (1 - np.pi / 16) / n / 0.62
    lines = {"vertices": boundary.points[:, :2], "segments": boundary.get("line"), "holes": [[0.5, 0.5]]}
    ends: list[float] = []
    run = refiner.Refiner.run

    def noted(self):
        refinement = run(self)
        ends.append(time.perf_counter())
        return refinement

    refiner.Refiner.run = noted
    try:
        whole, refine, theirs = [], [], []
        for _ in range(REPEATS):
            start = time.perf_counter()
            (mesh, report), seconds = timed(
                lambda: meshcore.delaunay_refinement(boundary, min_angle=min_angle, max_area=max_area)
            )
            whole.append(seconds)
            refine.append(ends[-1] - start)
            peer, seconds = timed(lambda: triangle.triangulate(lines, f"pq{min_angle}a{max_area:.12f}Q"))
            theirs.append(seconds)
    finally:
        refiner.Refiner.run = run
    count = len(peer["triangles"])
    return (
        f"{n:>9,} {min_angle:>6} {median(whole):>8.3f} {median(refine):>8.3f} {median(theirs):>9.3f} "
        f"{median(theirs) / median(whole):>7.2f} {median(theirs) / median(refine):>9.2f} "
        f"{mesh.n_cells / count:>10.3f} {report.quality['smallest angle (degree)']:>9.2f}"
    )


def main() -> None:
    """Print the table."""
    sizes = [int(float(text)) for text in sys.argv[1:]] or [100_000, 1_000_000]
    meshcore.delaunay_refinement(square_with_hole(), max_area=0.01)  # compiles
    print("triangles  angle   mesh s refine s Triangle s  T/mesh  T/refine  our count  our angle")
    for n in sizes:
        for min_angle in (20, 30, 33):
            print(compare(n, min_angle), flush=True)


if __name__ == "__main__":
    main()
