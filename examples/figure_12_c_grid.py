"""C-type grid around an airfoil (survey, figure 12).

One block runs from the outflow along the wake, clockwise round RAE 2822, and back: the two sides of the wake are one
line, a cut that the grid knows. Beyond it i and j change their directions; a halo holds the points of the other side,
so that the formula of the interior serves on the wake, too: there the Laplacian of x^2 + y^2 is 4, as anywhere.

Behind the blunt trailing edge of NACA 0012 the two sides of the wake are apart, and a second block stands between them.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import gallery
from meshcore.picture import picture
from meshcore.structured import Curvilinear


def main(folder="out"):
    grid, _ = mc.c_grid(gallery.airfoil("rae2822"), around=192, first_height=1e-3, trailing_spacing=0.005)
    path = Path(folder)
    picture(grid, path / "figure_12.png", title="C-grid")
    picture(grid, path / "figure_12_section.png", zoom=((-0.3, -0.6), (1.7, 0.6)))
    picture(grid, path / "figure_12_trailing_edge.png", zoom=((0.9, -0.08), (1.1, 0.06)))
    (wake,) = grid.cuts
    x, y, _ = np.moveaxis(grid.points, -1, 0)
    laplacian = Curvilinear(grid).laplacian(x**2 + y**2)
    on_wake = slice(3, wake.points[1][0] - 6)
    assert np.abs(laplacian[on_wake, 0] - 4).max() < 0.2
    blocks, _ = mc.c_grid(gallery.airfoil("naca0012"), around=192, first_height=1e-4, trailing_spacing=0.001)
    picture(blocks, path / "figure_12_blunt.png", zoom=((0.985, -0.009), (1.015, 0.009)))
    section, base = blocks.blocks
    corner = blocks.cuts[1].points[0][0]
    heights = [np.linalg.norm(section.points[corner, 1] - section.points[corner, 0])]
    heights += [np.linalg.norm(base.points[1, j] - base.points[1, j - 1]) for j in (-1, 1)]
    assert np.ptp(heights) < 0.02 * min(heights)  # of the cells on both sides of both cuts
    return grid.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
