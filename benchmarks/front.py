"""The advancing front beside Gmsh's Frontal-Delaunay: seconds, angles and shapes, before and after smoothing.

``python benchmarks/front.py [--quick] [--repeats 5] [--triangles 100000 1000000]``

Gmsh takes about a minute for a million triangles, so that it has three turns there.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from _common import GmshModel, Target, arguments, of_turns, print_heading, print_row, taken_alternately

import meshcore
from meshcore import quality
from meshcore.gallery import square_with_hole

FASTER = Target(15, 30)
SHAPE = Target(0.99, 0.997)
ANGLE = Target(35, 38)
# What the front aims at, per largest edge allowed.
SHARE = 0.68
ROUNDS = 3


def quality_of(points: np.ndarray, triangles: np.ndarray) -> tuple[float, float]:
    """Smallest angle, and mean of twice the inscribed over the circumscribed radius."""
    mesh = meshcore.Mesh(points, {"triangle": triangles})
    smallest = float(quality.measure(mesh, "min_angle").min())
    return smallest, float((1 / quality.measure(mesh, "radius_ratio")).mean())


def compared(n: int, repeats: int) -> None:
    """The rows of about ``n`` triangles."""
    boundary = square_with_hole(16)
    length = float(np.sqrt((1 - np.pi / 16) / (n * np.sqrt(3) / 4)))

    def front(smoothing: int) -> Any:
        return meshcore.delaunay_refinement(boundary, size=length / SHARE, placement="front", smoothing=smoothing)

    with GmshModel(boundary, length, 6) as gmsh_mesh:
        contestants = {
            "meshcore": lambda: front(0),
            f"meshcore, {ROUNDS} rounds of smoothing": lambda: front(ROUNDS),
            "Gmsh": gmsh_mesh,
        }
        times = taken_alternately(contestants, repeats, {"Gmsh": min(3, repeats)} if n > 300_000 else {})
    theirs = times["Gmsh"]
    for name, taken in times.items():
        mesh = taken.result if name == "Gmsh" else (taken.result[0].points, taken.result[0].cells["triangle"])
        angle, shape = quality_of(*mesh)
        ratio = (theirs.seconds / len(theirs.result[1])) / (taken.seconds / len(mesh[1]))
        smoothed = "smoothing" in name
        print_row(
            name,
            of_turns([taken]),
            len(mesh[1]),
            taken.seconds,
            FASTER.verdict(ratio) if name != "Gmsh" else "1",
            SHAPE.verdict(shape) if name != "Gmsh" else f"{shape:.4f}",
            ANGLE.verdict(angle) if smoothed else f"{angle:.1f}",
        )


def main() -> None:
    """Print the tables."""
    options = arguments(__doc__, triangles=[100_000, 1_000_000])
    sizes = options.triangles or ([10_000] if options.quick else [100_000, 1_000_000])
    meshcore.delaunay_refinement(square_with_hole(), size=0.2, placement="front", smoothing=1)  # compiles
    print_heading(
        "Advancing front in a square with a hole",
        "Whole public call, checks and summary included, against Gmsh's generation alone, both on one thread: "
        "processor seconds a triangle, alternately in one process, medians.",
    )
    print_row("", "turns", "triangles", "seconds", "faster than Gmsh", "mean radius ratio", "smallest angle", head=True)
    for n in sizes:
        compared(n, options.repeats)


if __name__ == "__main__":
    main()
