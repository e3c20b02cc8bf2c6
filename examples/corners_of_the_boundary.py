"""Corners of the boundary: Laplace's equations smooth them away inside, transfinite interpolation carries them on.

Both grids of a channel whose floor has a kink of 60 degrees. How much the lines above it turn at the kink is measured,
line by line: with interpolation the turn fades in proportion to the height only, with Laplace's equations it is a small
part of that a few cells off the floor (survey, section 2.5).
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore.picture import picture


def main(folder="out", cells=32):
    x = np.linspace(-1, 1, 2 * cells + 1)
    floor = np.column_stack([x, np.maximum(0, 0.25 - np.tan(np.radians(30)) * np.abs(x)), 0 * x])
    side = np.linspace(0, 1, cells + 1)
    west = np.column_stack([-np.ones_like(side), side, 0 * side])
    sides = floor, west + [2, 0, 0], np.column_stack([x, np.ones_like(x), 0 * x]), west
    interpolated, _ = mc.transfinite(*sides)
    smooth, report = mc.elliptic(*sides, control="none", residual=1e-8)
    for name, grid in (("transfinite", interpolated), ("laplace", smooth)):
        picture(grid, Path(folder) / f"corners_{name}.png", window=(1100, 600))
    kept, faded = turns(interpolated, cells), turns(smooth, cells)
    assert report.converged and abs(kept[0] - 60) < 1e-9 and abs(faded[0] - 60) < 1e-9
    middle = cells // 2
    assert kept[middle] > 25  # half of the height, half of the corner
    assert faded[cells // 8] < 0.25 * kept[cells // 8] and faded[middle] < 0.1 * kept[middle]
    return smooth.n_cells


def turns(grid, at):
    """(nj,) float: by how many degrees each line along the floor turns where i = ``at``."""
    points = grid.points[:, :, 0, :2]
    before, after = (points[at] - points[at - 1]) @ [1, 1j], (points[at + 1] - points[at]) @ [1, 1j]
    return np.abs(np.degrees(np.angle(after / before)))


if __name__ == "__main__":
    main(*sys.argv[1:])
