"""Bowyer-Watson: a point added to a Delaunay triangulation (survey, figure 27).

The triangles whose circles contain the new point are deleted, and the point is joined to the edges of the hole that
they leave. Nothing else changes: that is checked by triangulating all points with and without the new one.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import gallery
from meshcore.geometry import predicates
from meshcore.picture import picture


def circle_through(corners):
    """Centre and radius of the circle through three points."""
    a, b, c = corners
    centre = np.linalg.solve(2 * np.array([b - a, c - a]), [b @ b - a @ a, c @ c - a @ a])
    return tuple(centre), float(np.linalg.norm(centre - a))


def main(folder="out"):
    old = np.random.default_rng(11).random((30, 2))
    new = np.array([0.47, 0.52])
    before, _ = mc.delaunay_2d(old)
    after, _ = mc.delaunay_2d(np.concatenate([old, [new]]))
    corners = old[before.get("triangle")]
    dug = np.flatnonzero(predicates.incircle(corners[:, 0], corners[:, 1], corners[:, 2], new) > 0)
    star = np.flatnonzero((after.get("triangle") == len(old)).any(axis=1))

    circles = []
    for k in dug:
        centre, radius = circle_through(corners[k])
        circles.append(gallery.circle(96, radius=radius, centre=centre))
    point = mc.Mesh(new[None], {"vertex": [[0]]})
    folder = Path(folder)
    over = [gallery.joined(*circles), point]
    picture(before, folder / "figure_27_circles.png", window=(800, 760), marked=dug, over=over)
    picture(after, folder / "figure_27_result.png", window=(800, 760), marked=star, over=[point])

    def as_sets(cells):
        return {frozenset(cell) for cell in cells.tolist()}

    kept = as_sets(np.delete(before.get("triangle"), dug, axis=0))
    assert kept | as_sets(after.get("triangle")[star]) == as_sets(after.get("triangle"))
    assert len(dug) > 3 and len(star) == len(dug) + 2
    return len(dug)


if __name__ == "__main__":
    main(*sys.argv[1:])
