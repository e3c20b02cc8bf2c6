"""O-type grid around an airfoil (survey, figure 11).

One block is wrapped around RAE 2822: i runs around the section, j outwards, and the cut leaves the trailing edge
along its bisector. The lines leave the wall at right angles, and no cell is folded even at the trailing edge.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import gallery, quality
from meshcore.picture import picture


def main(folder="out"):
    grid, _ = mc.o_grid(gallery.airfoil("rae2822"), around=192, first_height=1e-4)
    path = Path(folder)
    picture(grid, path / "figure_11.png", title="O-grid")
    picture(grid, path / "figure_11_section.png", zoom=((-0.3, -0.5), (1.3, 0.5)))
    picture(grid, path / "figure_11_trailing_edge.png", zoom=((0.93, -0.04), (1.05, 0.05)))
    assert (quality.measure(grid, "scaled_jacobian") > 0).all()
    heights = np.linalg.norm(grid.points[:, 1, 0] - grid.points[:, 0, 0], axis=1)
    assert np.ptp(heights) < 1e-9
    return grid.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
