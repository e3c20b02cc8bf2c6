"""Transfinite interpolation between four sides (survey, figure 5).

A channel over a bump, with cells a thousandth of its height at the wall. Blending by arc length carries the wall's
spacing along the whole bump: the height of the wall cells varies by no more than the channel's own height does.
Then with a coordinate line inside, "to control the grid density", such as one along a shear layer; it is kept to the
last bit.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore.picture import picture


def main(folder="out"):
    x = np.linspace(0, 3, 73)
    south = np.column_stack([x, 0.25 * np.exp(-(((x - 1.5) / 0.35) ** 2))])
    north = np.column_stack([x, np.ones_like(x)])
    east, west = np.array([[3, 0], [3, 1.0]]), np.array([[0, 0], [0, 1.0]])
    south[[0, -1], 1] = 0.0
    grid, _ = mc.transfinite(south, east, north, west, cells_j=32, spacing_south=0.001)
    picture(grid, Path(folder) / "figure_05.png", window=(1200, 520))
    picture(grid, Path(folder) / "figure_05_wall.png", window=(1200, 520), zoom=((1.2, 0.15), (1.8, 0.35)))
    layer = np.column_stack([x, 0.4 + 0.12 * np.exp(-(((x - 1.6) / 0.5) ** 2))])
    inside, _ = mc.transfinite(south, east, north, west, [layer], cells_i=72, cells_j=32, blending="cubic", slopes={})
    picture(inside, Path(folder) / "figure_05_line_inside.png", window=(1200, 520))
    row = int(np.argmin(np.abs(inside.points[0, :, 0, 1] - layer[0, 1])))
    assert (inside.points[:, row, 0, :2] == layer).all()
    heights = np.linalg.norm(grid.points[:, 1, 0] - grid.points[:, 0, 0], axis=1)
    assert heights.min() > 0.0007 and heights.max() < 0.0011
    return grid.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
