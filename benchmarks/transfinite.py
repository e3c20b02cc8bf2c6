"""Transfinite interpolation of a block between its six faces, against a plain numpy copy of the same array.

A copy is the limit: each point is written once, and that is what memory allows. ``points.copy()`` fetches new memory as
the interpolation does; ``numpy.copyto`` into memory that is there is faster, and no fair contestant, but told.

``python benchmarks/transfinite.py [--quick] [--cells 255] [--repeats 7]``
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import product

import numpy as np
from _common import Target, arguments, of_turns, print_heading, print_row, taken_alternately

from meshcore.structured.algebraic.block_faces import PLACES
from meshcore.structured.algebraic.transfinite_volume import interpolated_volume

CELLS = [127, 255]
ONE, TWO = Target(6, at_most=True), Target(6, 2, at_most=True)


def passage(n: int) -> np.ndarray:
    """(n, n, n, 3) points of a twisted passage with curved walls."""
    t = np.linspace(0, 1, n)
    u, v, w = np.meshgrid(t, t, t, indexing="ij")
    return np.stack([u + 0.05 * np.sin(3 * v), v + 0.05 * np.sin(3 * w), 1.5 * w + 0.05 * np.sin(3 * u)], axis=-1)


def contestants(n: int) -> dict[str, Callable[[], None]]:
    """What takes turns for n^3 points; nothing is kept between turns."""
    points, there = passage(n), np.empty((n, n, n, 3))
    sides = (points[0], points[-1], points[:, 0], points[:, -1], points[:, :, 0], points[:, :, -1])
    faces = {place: side.copy() for place, side in zip(PLACES, sides, strict=True)}

    def interpolate(blending: str, threads: int) -> None:
        interpolated_volume(faces, blending=blending, threads=threads)

    runs: dict[str, Callable[[], None]] = {
        "copy": lambda: len(points.copy()),
        "copy into memory that is there": partial(np.copyto, there, points),
    }
    for blending, threads in product(("linear", "arc length"), (1, 2)):
        name = f"{blending}, {threads} thread{'s' * (threads > 1)}"
        runs[name] = partial(interpolate, blending, threads)
    return runs


def main() -> None:
    """Print a table for each size."""
    options = arguments(__doc__, cells=CELLS)
    for blending in ("linear", "arc length"):  # compiles
        cube = passage(4)
        sides = (cube[0], cube[-1], cube[:, 0], cube[:, -1], cube[:, :, 0], cube[:, :, -1])
        interpolated_volume(dict(zip(PLACES, sides, strict=True)), blending=blending)
    for cells in options.cells or ([63] if options.quick else CELLS):
        found = taken_alternately(contestants(cells + 1), options.repeats)
        copy = found["copy"]
        print_heading(
            f"{cells + 1}^3 points between six faces",
            f"Median of {of_turns(found.values())}; the ratio is to the copy that fetches memory, of the processor's "
            "seconds for one thread and of those on the wall for two.",
        )
        print_row("", "processor", "wall", "ns a point", "ratio to a copy", head=True)
        for name, times in found.items():
            two = name.endswith("threads")
            ratio = times.wall_seconds / copy.wall_seconds if two else times.seconds / copy.seconds
            target = {"linear, 1 thread": ONE, "linear, 2 threads": TWO}.get(name)
            shown = target.verdict(ratio) if target else ratio
            seconds = times.wall_seconds if two else times.seconds
            print_row(name, times.seconds, times.wall_seconds, seconds / (cells + 1) ** 3 * 1e9, shown)


if __name__ == "__main__":
    main()
