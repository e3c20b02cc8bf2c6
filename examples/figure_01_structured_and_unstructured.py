"""Structured and unstructured mesh of one domain (survey, figure 1).

The same four curved sides, filled once by transfinite interpolation and once by Delaunay refinement. In the
structured grid every inner point has four neighbours, so none need be stored; in the unstructured mesh the number
varies, and cells are of one size however the sides run.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import gallery
from meshcore.geometry.curves import lines_through
from meshcore.picture import picture


def main(folder="out"):
    sides = gallery.wavy_sides(24, 12)
    grid, _ = mc.transfinite(*sides)
    south, east, north, west = sides
    loop = np.concatenate([south[:-1], east[:-1], north[:0:-1], west[:0:-1]])
    triangles, _ = mc.delaunay_refinement(lines_through(loop, closed=True), min_angle=30, size=0.12)
    picture(grid, Path(folder) / "figure_01_structured.png", window=(1000, 560))
    picture(triangles, Path(folder) / "figure_01_unstructured.png", window=(1000, 560))

    def inner_degrees(mesh):
        degree = np.bincount(mesh.edges.ravel(), minlength=mesh.n_points)
        return set(np.delete(degree, np.unique(mesh.boundary.get("line"))).tolist())

    assert inner_degrees(grid.to_mesh()) == {4}
    assert len(inner_degrees(triangles)) > 1
    return grid.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
