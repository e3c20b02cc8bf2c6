"""Delaunay refinement beside Triangle: the same square with a hole, by angle, and by uniform size with a lattice.

``python benchmarks/delaunay_refinement.py [--quick] [--repeats 5] [--triangles 100000 1000000]``
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from _common import Target, arguments, of_turns, print_heading, print_row, taken_alternately

import meshcore
from meshcore.gallery import square_with_hole

SPEED = Target(1, 1.5)
SPEED_OF_LATTICE = Target(2.5)
COUNT = Target(1, at_most=True)
ANGLES = (20, 30, 33)


def with_triangle(boundary: meshcore.Mesh, min_angle: int, max_area: float) -> int:
    """Number of Triangle's triangles."""
    import triangle

    lines = {"vertices": boundary.points[:, :2], "segments": boundary.get("line"), "holes": [[0.5, 0.5]]}
    return len(triangle.triangulate(lines, f"pq{min_angle}a{max_area:.12f}Q")["triangles"])


def with_meshcore(boundary: meshcore.Mesh, min_angle: int, max_area: float, placement: str) -> Any:
    """Mesh and report of the public call."""
    return meshcore.delaunay_refinement(boundary, min_angle=min_angle, max_area=max_area, placement=placement)


def print_table(sizes: list[int], repeats: int, placement: str, angles: tuple[int, ...], speed: Target) -> None:
    """A row for each size and angle."""
    print_row("area for", "angle", "turns", "meshcore", "Triangle", "times as fast", "count / Triangle's",
              "smallest angle", head=True)  # fmt: skip
    for n in sizes:
        boundary = square_with_hole(50)
        max_area = (1 - np.pi / 16) / n / 0.62
        for angle in angles:
            times = taken_alternately(
                {
                    "meshcore": partial(with_meshcore, boundary, angle, max_area, placement),
                    "Triangle": partial(with_triangle, boundary, angle, max_area),
                },
                repeats,
            )
            mesh, report = times["meshcore"].result
            ours, theirs = times["meshcore"].seconds, times["Triangle"].seconds
            print_row(
                n, angle, of_turns(times.values()), ours, theirs, speed.verdict(theirs / ours),
                COUNT.verdict(mesh.n_cells / times["Triangle"].result),
                f"{report.quality['smallest angle (degree)']:.2f}",
            )  # fmt: skip


def main() -> None:
    """Print the tables."""
    options = arguments(__doc__, triangles=[100_000, 1_000_000])
    sizes = options.triangles or ([5_000] if options.quick else [100_000, 1_000_000])
    about = (
        "Processor seconds of the whole public call, checks and summary of quality included, beside Triangle's "
        'refinement alone; one thread each, alternately in one process, medians. "area for" is the number of '
        "triangles that the largest area was chosen for."
    )
    for placement in ("off-centre", "lattice"):  # compiles
        meshcore.delaunay_refinement(square_with_hole(), max_area=0.01, placement=placement)
    print_heading("Quality meshes in a square with a hole", about)
    print_table(sizes, options.repeats, "off-centre", ANGLES, SPEED)
    print_heading("Uniform size by lattice fill", about)
    print_table(sizes, options.repeats, "lattice", (20, 30), SPEED_OF_LATTICE)


if __name__ == "__main__":
    main()
