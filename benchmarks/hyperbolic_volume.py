"""Layers marched off surfaces: points a second, cost by size, and bodies with corners of all kinds.

``python benchmarks/hyperbolic_volume.py [--quick] [--repeats 5]``

Sizes are refined in all three directions, so that cells keep their shapes. The sphere is pyHyp's example: six patches
of 33 x 33 points, 73 layers of points, first height 1e-4, march 10.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from _common import Target, arguments, print_heading, print_row, taken_alternately

import meshcore as mc
from meshcore import gallery, quality
from meshcore.structured.marching.layer_marching import marched
from meshcore.structured.marching.layer_surface import read_surface
from meshcore.structured.marching.marching_parameters import asked_heights

SPEED = Target(0.5, 1.0)  # million points a second; the aim is meant for two threads
EVEN = Target(1.3, at_most=True)


def body(corner: str, n: int) -> mc.Mesh:
    """A block of bricks with concave edges, or a wing's half with its tip."""
    if corner == "wing tip":
        return gallery.wing_tip(4 * n, 3 * n, 4)
    filled = np.ones((2 * n, 2 * n, 2 * n), bool)
    if corner in ("90 degrees", "60 degrees"):
        filled[n:, n:] = False
    elif corner == "three edges":
        filled[n:, n:, n:] = False
    mesh = gallery.bricks(filled, size=1 / n)
    if corner == "60 degrees":
        mesh = mesh.with_points(mesh.points @ np.array([[1, 0, 0], [0.5, np.sqrt(0.75), 0], [0, 0, 1]]))
    return mesh


def speed(repeats: int, largest: int) -> None:
    """The sphere, marching alone and the whole call, and the cost a point over sizes."""
    print_heading(
        "Layers of a sphere of six patches",
        "Marching alone; microseconds a point of the processor on one thread, points a second on the wall on two.",
    )
    print_row("grid", "points", "us a point", "million points/s", "cost over the smallest's", head=True)
    sizes = [(21, 46), (33, 73), (65, 145), (91, 199)]
    smallest = None
    for n, layers in [size for size in sizes if 6 * size[0] ** 2 * size[1] <= largest]:
        blocks = gallery.six_patches(n)
        graph = read_surface(blocks).graph
        heights = asked_heights(1e-4 * 72 / (layers - 1), 1.2, layers - 1, 10.0, None, diagonal=1.0)
        contestants = {threads: partial(marched, graph, heights, threads=threads) for threads in (1, 2)}
        times = taken_alternately(contestants, repeats)
        points = layers * len(graph.points)
        cost = times[1].seconds / points
        smallest = smallest or cost
        print_row(
            f"6 x {n} x {n} x {layers}",
            points,
            1e6 * cost,
            SPEED.verdict(points / times[2].wall_seconds / 1e6),
            EVEN.verdict(cost / smallest),
        )


def corners(n: int) -> None:
    """Bodies with corners: folded cells, layers that were made, quality."""
    print_heading("Layers of bodies with corners", "First height 1e-4, march 5, 60 layers; the whole call.")
    print_row("corner", "points", "layers", "folded cells", "worst corner (degree)", "million points/s", head=True)
    for corner in ("cube", "90 degrees", "three edges", "60 degrees", "wing tip"):
        surface = body(corner, n)
        asked = {"first_height": 1e-4, "layers": 60, "distance": 5.0}
        mc.hyperbolic_volume(surface, **asked)
        mesh, report = mc.hyperbolic_volume(surface, **asked)
        folded = int((quality.measure(mesh, "jacobian") <= 0).sum())
        print_row(
            corner,
            mesh.n_points,
            Target(60).verdict(report.counts["layers"]),
            Target(0, at_most=True).verdict(folded),
            report.quality["worst corner (degree)"],
            mesh.n_points / report.seconds / 1e6,
        )


def main() -> None:
    """Print the tables."""
    options = arguments(__doc__)
    speed(options.repeats, 500_000 if options.quick else 10_000_000)
    corners(6 if options.quick else 10)


if __name__ == "__main__":
    main()
