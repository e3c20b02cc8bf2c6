"""RAE 2822 in a far field: triangulated, wrapped in an O-block, and adapted to a shock (the main job).

This is what `meshcore demo` and `make demo` run: three meshes, their pictures with a close-up, and their quality.
"""

import sys

import numpy as np

from meshcore import demo, io, quality


def main(folder="out"):
    print(demo.run(folder))
    triangles, adapted = (io.read(f"{folder}/{name}.vtu") for name in ("triangulation", "adapted"))
    assert quality.measure(triangles, "min_angle").min() > demo.ANGLE - 0.01
    assert (quality.measure(io.read(f"{folder}/o_grid.vts"), "scaled_jacobian") > 0).all()

    def area_at_front(mesh):
        """Median area of the triangles that the middle of the front runs through."""
        x, y, _ = mesh.centroids.T
        on_front = (np.abs(x - 0.55 - 0.15 * y) < 0.01) & (y > 0.1) & (y < 0.35)
        return np.median(quality.measure(mesh, "area")[on_front])

    assert area_at_front(adapted) < 0.1 * area_at_front(triangles)
    return adapted.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
