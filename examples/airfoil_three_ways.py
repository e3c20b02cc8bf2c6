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
    # The adapted mesh spends its triangles at the front: there they are far smaller than the mesh they came from.
    steep = np.abs(adapted.centroids[:, 0] - 0.55 - 0.15 * adapted.centroids[:, 1]) < 0.03
    steep &= (adapted.centroids[:, 1] > 0.15) & (adapted.centroids[:, 1] < 0.5)
    assert steep.sum() > 0.05 * (adapted.n_cells - triangles.n_cells)
    return adapted.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
