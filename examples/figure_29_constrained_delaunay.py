"""Edge swapping gives a constrained Delaunay triangulation (survey, figure 29), points on the lines a conforming one.

The rotor of figure 28: first all of its hull with the lost sides recovered; then what the outline encloses; then the
conforming triangulation, which is Delaunay and has points on the outline instead.
"""

import runpy
import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore.picture import picture

SHARED = runpy.run_path(str(Path(__file__).parent / "figure_28_boundary_not_respected.py"))


def corners_of(triangles):
    """Triangles as sets of points."""
    return [frozenset(t) for t in triangles.tolist()]


def main(folder="out"):
    outline = SHARED["rotor"]()
    plain, _ = mc.delaunay_2d(outline)
    hull, _ = mc.constrained_delaunay(outline, keep="hull", lines=True)
    inside, _ = mc.constrained_delaunay(outline, lines=True)
    conforming, report = mc.constrained_delaunay(outline, conforming=True, lines=True)
    before, after = corners_of(plain.get("triangle")), corners_of(hull.get("triangle"))
    swapped = [k for k, t in enumerate(after) if t not in set(before)]
    folder = Path(folder)
    picture(hull, folder / "figure_29.png", window=(900, 860))
    picture(inside, folder / "figure_29_inside.png", window=(900, 860))
    picture(conforming, folder / "figure_29_conforming.png", window=(900, 860))

    # Every line is an edge now, and only triangles that a lost line cut were changed.
    edges = SHARED["edges_of"](hull)
    assert all(tuple(np.sort(line)) in edges for line in outline.get("line"))
    lost = [line for line in outline.get("line") if tuple(np.sort(line)) not in SHARED["edges_of"](plain)]
    cut = {k for line in lost for k in SHARED["cut"](outline.points[:, :2], plain.get("triangle"), line)}
    assert {k for k, t in enumerate(before) if t not in set(after)} <= cut and len(swapped) == len(
        cut & set(range(len(before)))
    )
    # The conforming mesh is a part of the Delaunay triangulation of its points.
    again, _ = mc.delaunay_2d(conforming.points)
    assert set(corners_of(conforming.get("triangle"))) <= set(corners_of(again.get("triangle")))
    return report.counts["points added on lines"]


if __name__ == "__main__":
    main(*sys.argv[1:])
