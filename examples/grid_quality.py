"""Quality of a structured grid: what a flow solver's user looks at before starting it.

An O-grid around RAE 2822: the angle between its lines, skewness, aspect ratio, growth along the lines of both
directions, the Jacobian, and at the wall the height of the first cells and the angle of the lines that leave it. Each
is an array, a picture, and a line of the report; the first heights are what was asked for.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import gallery, quality
from meshcore.picture import histogram, picture

NEAR, TAIL = ((-0.35, -0.5), (1.35, 0.6)), ((0.97, -0.025), (1.04, 0.0275))
EVERYWHERE = ("line_angle", "equiangle_skew", "max_edge_ratio", "growth_i", "growth_j", "scaled_jacobian")
AT_THE_WALL = ("first_height_jmin", "face_angle_jmin")


def main(folder="out"):
    first = 1e-3
    grid, _ = mc.o_grid(gallery.airfoil("rae2822"), around=160, first_height=first, growth=1.15)
    path = Path(folder)
    for name in EVERYWHERE:
        picture(grid, path / f"grid_quality_{name}.png", scalars=name, zoom=NEAR)
    for name in AT_THE_WALL:
        picture(grid, path / f"grid_quality_{name}.png", scalars=name, zoom=TAIL)
    report = quality.report(grid, [*EVERYWHERE, *AT_THE_WALL])
    histogram(report, path / "grid_quality.png")
    heights = quality.first_height(grid, "jmin").ravel()
    assert np.abs(heights[3:-3] / first - 1).max() < 0.02  # at the sharp trailing edge lines lean to its bisector
    assert report.rows["growth_j"].outside == 0
    return grid.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
