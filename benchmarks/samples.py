"""The planar graphs that the triangle package ships, refined beside Triangle: angle reached, triangles, time.

Samples without segments (spiral, dots, greenland, ell) get the outline of their own triangles, or of their convex hull.

``python benchmarks/samples.py [--quick] [--repeats 5] [--angles 20 28 33]``
"""

from __future__ import annotations

import statistics
import time
from typing import Any

import numpy as np
import triangle
from _common import arguments, print_heading, print_row

import meshcore
from meshcore import quality

NAMES = [
    "A", "face", "la", "double_hex", "double_hex2", "double_hex3", "box", "bbox.1", "dots", "ell", "square_circle_hole",
    "spiral", "greenland", "diamond_02_00009",
]  # fmt: skip
CALLS_A_TURN = 20


def sample(name: str) -> dict[str, Any]:
    """Vertices, segments and holes of a sample, in Triangle's own form."""
    data = triangle.get_data(name)
    given = {key: np.asarray(data[key]) for key in ("vertices", "segments", "holes", "regions") if key in data}
    if "segments" in given:
        return given
    corners = data.get("triangles")
    if corners is None:
        corners = triangle.triangulate({"vertices": given["vertices"]}, "Q")["triangles"]
    outline = meshcore.Mesh(given["vertices"], {"triangle": np.asarray(corners, np.int64)}).boundary
    return {"vertices": given["vertices"], "segments": outline.get("line")}


def timed(function: Any) -> tuple[Any, float]:
    """The result of a call and its processor seconds."""
    start = time.process_time()
    result = function()
    return result, time.process_time() - start


def row(name: str, angle: int, repeats: int) -> None:
    """One row of the table: a sample at an angle."""
    given = sample(name)
    vertex = np.arange(len(given["vertices"]))[:, None]
    boundary = meshcore.Mesh(given["vertices"], {"line": given["segments"], "vertex": vertex})
    seeds = {key: given[key] for key in ("holes",) if key in given}
    triangles = {key: value for key, value in given.items() if key != "regions"}
    try:
        meshcore.delaunay_refinement(boundary, min_angle=angle, **seeds)
    except (
        meshcore.MeshcoreError
    ) as error:  # such as box, whose outline is open: without its -c, Triangle makes nothing of it either
        print_row(name, angle, f"refused: {error}", *[""] * 8)
        return
    ours, theirs = [], []
    calls = CALLS_A_TURN if len(vertex) < 1000 else 1
    for _ in range(repeats):
        for _ in range(calls):
            mesh, seconds = timed(lambda: meshcore.delaunay_refinement(boundary, min_angle=angle, **seeds).mesh)
            ours.append(seconds)
        for _ in range(calls):
            peer, seconds = timed(lambda: triangle.triangulate(triangles, f"pq{angle}Q"))
            theirs.append(seconds)
    valid = "yes" if not quality.validate(mesh, raise_=False) else "NO"
    other = meshcore.Mesh(peer["vertices"], {"triangle": peer["triangles"]})
    reached = quality.measure(mesh, "min_angle"), quality.measure(other, "min_angle")
    # What the input's own angles force stays: beside the smallest angle stands how many triangles are below the bound.
    below = [int((found < angle - 1e-6).sum()) for found in reached]
    print_row(
        name, angle, valid, mesh.n_cells, other.n_cells, mesh.n_cells / other.n_cells,
        f"{reached[0].min():.2f} ({below[0]})", f"{reached[1].min():.2f} ({below[1]})",
        1e3 * statistics.median(ours), 1e3 * statistics.median(theirs),
        statistics.median(theirs) / statistics.median(ours),
    )  # fmt: skip


def main() -> None:
    """Print the table."""
    options = arguments(__doc__, angles=[20, 28, 33])
    meshcore.delaunay_refinement(meshcore.Mesh([[0, 0], [1, 0], [0, 1]], {"line": [[0, 1], [1, 2], [2, 0]]}))
    print_heading(
        "Samples of the triangle package",
        "The smallest angle, and in brackets how many triangles the input's own small angles keep below the bound.",
    )
    print_row(
        "sample", "degrees", "valid", "triangles", "Triangle's", "ratio", "angle", "Triangle's", "ms", "Triangle's ms",
        "T/ours", head=True,
    )  # fmt: skip
    for name in NAMES:
        for angle in options.angles or [20, 28, 33]:
            row(name, angle, options.repeats)


if __name__ == "__main__":
    main()
