"""Delaunay triangulation: no point inside any triangle's circumcircle (survey, figure 23).

A square with a round hole, triangulated so that no angle is below 30 degrees. The property that defines a Delaunay
triangulation is checked for every triangle and every point that it can see.
"""

import sys
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

import meshcore as mc
from meshcore import gallery
from meshcore.picture import picture


def main(folder="out"):
    mesh, _ = mc.delaunay_refinement(gallery.square_with_hole(8), min_angle=30, size=0.1)
    picture(mesh, Path(folder) / "figure_23.png", scalars="min_angle", window=(900, 760))
    a, b, c = (mesh.points[mesh.get("triangle")[:, k], :2] for k in range(3))
    ab, ac = b - a, c - a
    double = 2 * (ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0])
    x = (ac[:, 1] * (ab**2).sum(1) - ab[:, 1] * (ac**2).sum(1)) / double
    y = (ab[:, 0] * (ac**2).sum(1) - ac[:, 0] * (ab**2).sum(1)) / double
    nearest, _ = cKDTree(mesh.points[:, :2]).query(a + np.column_stack([x, y]))
    assert (nearest > np.hypot(x, y) * (1 - 1e-9)).all()
    return mesh.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
