"""Layers marched off surfaces: points a second, cost by size, bodies with corners of all kinds, surfaces at random.

``python benchmarks/hyperbolic_volume.py [--quick] [--repeats 5] [--surfaces 1000]``

Sizes are refined in all three directions, so that cells keep their shapes. The sphere is pyHyp's example: six patches
of 33 x 33 points, 73 layers of points, first height 1e-4, march 10.
"""

from __future__ import annotations

import math
import time
from dataclasses import replace
from functools import partial

import numpy as np
from _common import Target, arguments, print_heading, print_row, taken_alternately

import meshcore as mc
from meshcore import gallery, quality
from meshcore.errors import GenerationFailed
from meshcore.structured.marching.front_graph import FrontGraph
from meshcore.structured.marching.layer_marching import first_normals, marched
from meshcore.structured.marching.layer_surface import read_surface
from meshcore.structured.marching.marching_parameters import asked_heights
from tests.named_sides import solid
from tests.surfaces import random_surfaces

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


def edge_of_60_degrees(sizes: list[int]) -> None:
    """The hardest edge of the table below, refined in all directions: is it whole, and what does a point cost?"""
    print_heading("An edge of 60 degrees", "March 5, layers as fine as the surface; marching alone, processor seconds.")
    print_row("cells a side", "points", "layers", "worst corner (degree)", "residual", "us a point", "cost", head=True)
    smallest = None
    for n in sizes:
        graph = read_surface(body("60 degrees", n)).graph
        heights = asked_heights(0.0096 / n, 1.2, 6 * n, 5.0, None, diagonal=1.0)
        times = taken_alternately({"march": partial(marched, graph, heights, threads=1)}, 1)["march"]
        layers, outcome = times.result
        cost = times.seconds / (layers.size // 3)
        smallest = smallest or cost
        print_row(
            n,
            layers.size // 3,
            Target(6 * n).verdict(len(layers) - 1),
            math.degrees(math.asin(outcome.worst)),
            outcome.residual,
            1e6 * cost,
            EVEN.verdict(cost / smallest),
        )


def held(graph: FrontGraph, layers: np.ndarray, heights: np.ndarray) -> tuple[float, float]:
    """how well layers hold the equations: mean degrees off the normals, and part of the heights along them."""
    degrees, parts = [], []
    for below, above, height in zip(layers[:-1], layers[1:], heights, strict=False):
        way = above - below
        along = np.einsum("ij,ij->i", way, first_normals(replace(graph, points=0.5 * (above + below))))
        degrees.append(np.degrees(np.arccos(np.clip(along / np.linalg.norm(way, axis=1), -1, 1))))
        parts.append(np.abs(along / height - 1))
    return float(np.mean(degrees)), float(np.mean(parts))


def corners(n: int) -> None:
    """Bodies with corners: folded cells, layers that were made, quality."""
    print_heading(
        "Layers of bodies with corners",
        "First height 1e-4, march 5, 60 layers; the whole call on two threads. Residuals of the equations are means "
        "over all nodes: angle between line and front's normal, and height over what was asked, less one. "
        "Microseconds are of the processor, all threads together.",
    )
    print_row(
        "corner", "points", "layers", "folded cells", "worst corner (degree)", "angle off (degree)", "height off",
        "us a point", "million points/s", head=True,
    )  # fmt: skip
    for corner in ("cube", "90 degrees", "three edges", "60 degrees", "wing tip"):
        surface = body(corner, n)
        asked = {"first_height": 1e-4, "layers": 60, "distance": 5.0}
        mc.hyperbolic_volume(surface, **asked, threads=2)
        begun = time.process_time()
        mesh, report = mc.hyperbolic_volume(surface, **asked, threads=2)
        seconds = time.process_time() - begun
        folded = int((quality.measure(solid(mesh), "jacobian") <= 0).sum())
        graph = read_surface(surface).graph
        layers = mesh.points.reshape(-1, *graph.points.shape)
        angle, height = held(graph, layers, asked_heights(1e-4, 1.15, 60, 5.0, None, diagonal=1.0))
        print_row(
            corner,
            mesh.n_points,
            Target(60).verdict(report.counts["layers"]),
            Target(0, at_most=True).verdict(folded),
            report.quality["worst corner (degree)"],
            angle,
            height,
            1e6 * seconds / mesh.n_points,
            SPEED.verdict(mesh.n_points / report.seconds / 1e6),
        )


def surfaces(number: int) -> None:
    """Surfaces at random, of which many have no layers far out: none may fold, and all that stop say where."""
    print_heading("Surfaces at random", "First heights of 1e-4 to 1e-2 of the diagonal, marched half of it to thrice.")
    names = ("surfaces", "all layers", "stopped, told", "no layer, told", "folded", "untold", "layers made", "seconds")
    print_row("kind", *names, head=True)
    rows: dict[str, list[float]] = {}
    for k, (kind, surface) in enumerate(random_surfaces(number, 7)):
        rng = np.random.default_rng([7, k, 1])
        asked = int(rng.integers(15, 45))
        first, distance = mc.Relative(10 ** rng.uniform(-4, -2)), mc.Relative(rng.uniform(0.5, 3))
        row = rows.setdefault(kind, [0.0] * len(names))
        begun = time.process_time()
        row[0] += 1
        try:
            made, report = mc.hyperbolic_volume(surface, first_height=first, layers=asked, distance=distance, threads=1)
        except GenerationFailed as error:
            row[3 if error.points is not None else 5] += 1
            continue
        finally:
            row[7] += time.process_time() - begun
        count = report.counts["layers"]
        told = any("stopped after" in text for text in report.warnings)
        row[1 if count == asked else 2 if told else 5] += 1
        blocks = made.blocks if isinstance(made, mc.MultiBlock) else (made,)
        row[4] += any(quality.validate(block, raise_=False) for block in blocks)
        row[6] += count / asked
    for kind, row in rows.items():
        *counts, folded, untold, part, seconds = row
        none = Target(0, at_most=True)
        print_row(kind, *map(int, counts), none.verdict(folded), none.verdict(untold), part / row[0], seconds / row[0])


def main() -> None:
    """Print the tables."""
    options = arguments(__doc__, surfaces=[400])
    marched(read_surface(body("cube", 2)).graph, [0.1], threads=1)  # kernels are compiled
    speed(options.repeats, 500_000 if options.quick else 10_000_000)
    edge_of_60_degrees([8, 16] if options.quick else [8, 16, 32])
    corners(6 if options.quick else 10)
    surfaces(40 if options.quick else (options.surfaces or [400])[0])


if __name__ == "__main__":
    main()
