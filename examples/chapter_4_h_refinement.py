"""h-refinement: cells are divided where the error is (survey, 4.1).

A field with a steep front along a circle is sampled on a coarse mesh. Eight times, the triangles that hold half of
the error of linear interpolation are divided, and their neighbours as far as conformity asks. The error falls much
faster than under uniform refinement with as many triangles.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import gallery, quality
from meshcore.picture import picture


def front(points):
    return np.tanh(20 * (np.hypot(points[:, 0], points[:, 1]) - 0.7))


def errors(mesh):
    """Of each triangle, the integral of the deviation at its centre."""
    triangles = mesh.get("triangle")
    at_centre = front(mesh.points[triangles].mean(axis=1)) - front(mesh.points)[triangles].mean(axis=1)
    return np.abs(at_centre) * quality.measure(mesh, "area")


def main(folder="out"):
    mesh = gallery.triangulated_square(8)
    for _ in range(8):
        mesh, _ = mc.refined(mesh.with_cell_data(error=errors(mesh)), indicator="error", fraction=0.5)
    mesh = mesh.with_point_data(front=front(mesh.points))
    picture(mesh, Path(folder) / "h_refinement.png", scalars="front", window=(900, 760))
    uniform = gallery.triangulated_square(round(np.sqrt(mesh.n_cells / 2)))
    assert errors(mesh).sum() < 0.3 * errors(uniform).sum()
    assert quality.measure(mesh, "min_angle").min() > 44.9  # newest-vertex bisection of right triangles keeps them
    return mesh.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
