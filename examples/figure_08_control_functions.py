"""The effect of control functions (survey, figure 8).

The Laplace grid of a channel spreads its lines evenly. An attractor draws lines near one of them, the boundary's
spacing is carried inside, and Steger and Sorenson's control makes right angles at the wall, at the first height asked.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore.picture import picture


def main(folder="out", cells_i=60, cells_j=30):
    sides = channel(cells_i, cells_j)
    even, _ = mc.elliptic(*sides, control="none")
    drawn, _ = mc.elliptic(*sides, control="none", attractors=[mc.Attractor(j=cells_j // 2, strength=0.25, reach=6)])
    carried, _ = mc.elliptic(*sides, spacing_south=0.004)
    upright, report = mc.elliptic(*sides, control="none", walls="south", first_height=0.004)
    for name, grid in (("laplace", even), ("attracted", drawn), ("carried_inside", carried), ("upright", upright)):
        picture(grid, Path(folder) / f"figure_08_{name}.png", window=(1000, 600))

    middle = cells_j // 2
    assert np.median(gaps(drawn, middle) / gaps(even, middle)) < 0.5
    assert gaps(even, 0).max() > 5 * gaps(carried, 0).max()
    assert (
        np.abs(gaps(upright, 0)[3:-3] / 0.004 - 1).max() < 0.05 and report.quality["error of wall angles (degree)"] < 1
    )
    return upright.n_cells


def gaps(grid, j):
    """Distances from line j to the next."""
    return np.linalg.norm(grid.points[:, j + 1, 0] - grid.points[:, j, 0], axis=1)


def channel(cells_i, cells_j):
    """South with a bump, east, north, west of a channel."""
    s, t = np.linspace(0, 2, cells_i + 1), np.linspace(0, 1, cells_j + 1)
    south = np.column_stack([s, 0.25 * np.exp(-(((s - 1) / 0.3) ** 2))])
    south[[0, -1], 1] = 0
    west = np.column_stack([0 * t, t])
    return south, west + [2, 0], np.column_stack([s, 0 * s + 1]), west


if __name__ == "__main__":
    main(*sys.argv[1:])
