"""Degenerate points: four on one circle have two Delaunay triangulations (survey, figure 25).

Either diagonal of a square leaves no point inside of a circle. meshcore decides by the numbers of the points, as if the
one of lowest number were a little farther away: the result is unique, wherever the square stands and however it is
turned. A regular lattice is nothing but such points; its triangulation is conforming, counts exactly its triangles,
and each is a half of a lattice square.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import gallery, quality
from meshcore.geometry import predicates
from meshcore.picture import picture


def main(folder="out"):
    corners = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]], float)
    both = [[[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]]]
    for triangles in both:
        (a, b, c), (other,) = corners[triangles[0]], np.delete(corners, triangles[0], axis=0)
        assert predicates.incircle(a, b, c, other) == 0
    shifts = np.array([[0, 0], [2.6, 0], [5.2, 0]])
    chosen, _ = mc.delaunay_2d(corners)
    three = [np.array(both[0]), np.array(both[1]), chosen.get("triangle")]
    drawn = mc.Mesh(
        np.concatenate([corners + shift for shift in shifts]),
        {"triangle": np.concatenate([cells + 4 * k for k, cells in enumerate(three)])},
    )
    circles = gallery.joined(*[gallery.circle(96, centre=tuple(shift)) for shift in shifts])
    lowest = mc.Mesh(corners[:1] + shifts[2], {"vertex": [[0]]})
    picture(drawn, Path(folder) / "figure_25.png", window=(1400, 520), over=[circles, lowest])
    for turn in range(4):  # point 0 is never at the diagonal
        cells = mc.delaunay_2d(np.roll(corners, turn, axis=0) + [3, 5]).mesh.get("triangle")
        assert sorted(np.sort(cells, axis=1).tolist()) == [[0, 1, 3], [1, 2, 3]]

    n = 20
    x, y = (v.ravel() / n for v in np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij"))
    mesh, _ = mc.delaunay_2d(np.column_stack([x, y]))
    picture(mesh, Path(folder) / "figure_25_lattice.png", window=(800, 760))
    assert mesh.n_cells == 2 * n * n and quality.validate(mesh) == []
    assert np.abs(quality.measure(mesh, "area") - 0.5 / n**2).max() < 1e-15
    return mesh.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
