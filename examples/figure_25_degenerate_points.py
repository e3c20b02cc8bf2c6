"""Degenerate points: four on one circle have two Delaunay triangulations (survey, figure 25).

A regular lattice is nothing but such points. Exact predicates make it a normal case: the triangulation of a square
of 20 by 20 lines is conforming, counts exactly its triangles, and each is a half of a lattice square.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import quality
from meshcore.picture import picture


def main(folder="out"):
    n = 20
    x, y = (v.ravel() / n for v in np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij"))
    number = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    steps = [(number[:-1], number[1:]), (number[:, :-1], number[:, 1:])]
    lines = np.concatenate([np.column_stack([a.ravel(), b.ravel()]) for a, b in steps])
    mesh, _ = mc.delaunay_refinement(mc.Mesh(np.column_stack([x, y]), {"line": lines}), min_angle=0)
    picture(mesh, Path(folder) / "figure_25.png", window=(800, 760))
    assert mesh.n_cells == 2 * n * n and mesh.n_points == (n + 1) ** 2
    assert np.abs(quality.measure(mesh, "area") - 0.5 / n**2).max() < 1e-15
    return mesh.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
