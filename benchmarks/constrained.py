"""Constrained Delaunay triangulation beside Triangle: coasts, spirals, combs, hubs, short and long segments.

Both get the same points and segments, and mesh the same: what the outline encloses, or the convex hull. meshcore's time
is that of the whole public call, checks of input and mesh included; "edges" is what remains without these.

``python benchmarks/constrained.py [--quick] [--repeats 5] [--lines 100000 1000000]``
"""

from __future__ import annotations

import numpy as np
import triangle
from _common import arguments, print_heading, print_row, taken_alternately

import meshcore
import meshcore.gallery
from meshcore.unstructured.constrained import constrained
from meshcore.unstructured.planar_graph import planar_graph


def closed(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A closed polygon: its points and the segments around it."""
    n = np.arange(len(points))
    return points, np.column_stack([n, (n + 1) % len(points)])


def coast(n: int, random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A coast line by random displacement of midpoints, the displacement shrinking with the distance."""
    radius = np.array([1.0, 1.0, 1.0])
    while len(radius) < n:
        middle = (radius + np.roll(radius, -1)) / 2
        middle += 0.6 / len(radius) * random.standard_normal(len(radius))
        radius = np.column_stack([radius, middle]).ravel()
    angle = 2 * np.pi * np.arange(len(radius)) / len(radius)
    return closed(np.column_stack([np.cos(angle), np.sin(angle)]) * radius[:, None])


def spiral(n: int, random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A band of sixty windings, far narrower than their distance."""
    share = np.linspace(0, 1, n // 2)
    angle, radius = 120 * np.pi * share, 0.1 + share
    sides = [np.column_stack([r * np.cos(angle), r * np.sin(angle)]) for r in (radius, radius + 0.004)]
    return closed(np.concatenate([sides[0], sides[1][::-1]]))


def comb(n: int, random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A comb with gaps a thousand times deeper than wide."""
    corner = np.arange(n // 4 * 4)
    top = np.column_stack([(corner + 1) // 2 / 2, np.where(corner // 2 % 2, 1.0, 500.0)])
    return closed(np.concatenate([top, [[top[-1, 0], 0], [0, 0]]])[::-1])


def short_segments(n: int, random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A segment in each cell of a grid."""
    side = int(np.sqrt(n))
    cell = np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 1, 2)
    points = (cell + 0.98 * random.random((side * side, 2, 2))).reshape(-1, 2)
    return points, np.arange(len(points)).reshape(-1, 2)


def long_segments(n: int, random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Parallel segments across all of n random points, one for fifty of these."""
    y = np.arange(n // 50) / (n // 50)
    ends = np.concatenate([np.column_stack([0 * y, y]), np.column_stack([0 * y + 1, y + 0.2])])
    inside = random.random((n, 2)) * [0.98, 1] + [0.01, 0.1]
    return np.concatenate([ends, inside]), np.arange(2 * len(y)).reshape(2, -1).T


def hub(n: int, random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Segments from one point to all others around it."""
    angle = 2 * np.pi * np.arange(n) / n
    rim = np.column_stack([np.cos(angle), np.sin(angle)]) * (1 + 0.3 * random.random((n, 1)))
    return np.concatenate([[[0, 0]], rim]), np.column_stack([np.zeros(n, int), 1 + np.arange(n)])


CASES = {
    "coast": (coast, "inside"),
    "spiral": (spiral, "inside"),
    "comb": (comb, "inside"),
    "short segments": (short_segments, "hull"),
    "long segments": (long_segments, "hull"),
    "hub": (hub, "hull"),
}
# Triangle looks at each segment of a hub for each other one: hours for a million.
SLOW = {"hub": 20_000}


def row(name: str, n: int, repeats: int) -> None:
    """One row of the table."""
    make, keep = CASES[name]
    points, segments = make(min(n, SLOW.get(name, n)), np.random.default_rng(1))
    boundary = meshcore.Mesh(points, {"line": segments, "vertex": np.arange(len(points))[:, None]})
    switches = "pQ" if keep == "inside" else "pcQ"

    def edges():
        graph = planar_graph(points, segments, np.arange(len(points)), "boundary")
        return constrained(graph, split_crossings=False, parameter="boundary", progress=meshcore.silent)

    times = taken_alternately(
        {
            "mesh": lambda: meshcore.constrained_delaunay(boundary, keep=keep).mesh.n_cells,
            "edges": edges,
            "Triangle": lambda: len(
                triangle.triangulate({"vertices": points, "segments": segments}, switches)["triangles"]
            ),
        },
        repeats,
    )
    mesh, ours, theirs = (times[key].seconds for key in ("mesh", "edges", "Triangle"))
    count = times["mesh"].result
    same = "same" if count == times["Triangle"].result else f"{times['Triangle'].result:,} by Triangle"
    print_row(name, len(points), len(segments), f"{count:,}, {same}", mesh, ours, theirs, theirs / mesh, theirs / ours)


def main() -> None:
    """Print the table."""
    options = arguments(__doc__, lines=[100_000, 1_000_000])
    sizes = options.lines or ([10_000] if options.quick else [100_000, 1_000_000])
    meshcore.constrained_delaunay(meshcore.gallery.square_with_hole())  # compiles
    print_heading("Constrained Delaunay", f"Processor seconds, medians of {options.repeats}, in turns with Triangle.")
    print_row("case", "points", "segments", "triangles", "mesh", "edges", "Triangle", "T/mesh", "T/edges", head=True)
    for n in sizes:
        for name in CASES:
            row(name, n, options.repeats)


if __name__ == "__main__":
    main()
