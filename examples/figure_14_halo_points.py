"""Halo points (survey, figure 14): one formula inside and on the cut.

An O-grid and a C-grid get points beyond their cuts (marked), copies of those on the other side. The halo of the O-grid
repeats its first lines; beyond the wake of the C-grid, where i and j run the other way, it is the wake's other side.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import gallery
from meshcore.geometry.curves import lines_through
from meshcore.picture import picture


def _drawn(path, points, width, axis=1):
    """Draw a grid at its cut, a line, with its halo beyond, whose points are marked; it comes first along an axis."""
    lines = np.moveaxis(points, axis, 1)
    own, halo, cut = lines[:, width:], lines[:, : width + 1], lines[:, width, 0]
    copies = mc.Mesh(lines[:, :width].reshape(-1, 3), {"vertex": np.arange(lines[:, :width].size // 3)[:, None]})
    blocks = mc.MultiBlock((mc.StructuredGrid(own), mc.StructuredGrid(halo)))
    picture(blocks, path, over=[lines_through(cut), copies])


def main(folder="out"):
    path = Path(folder)
    section = gallery.airfoil("rae2822", cells=64)
    ring, _ = mc.o_grid(section, radius=2, layers=12, first_height=0.02)
    wrapped, _ = mc.c_grid(section, radius=2, layers=12, first_height=0.02, wake_growth=1.3)
    around, beyond = mc.with_halo(ring, 2), mc.with_halo(wrapped, 2)
    assert (around.grid.points[:2, 2:-2] == ring.points[-3:-1]).all()
    wake, n = wrapped.cuts[0].points[1][0], wrapped.shape[0] - 1
    halo = beyond.grid.points[2 : wake + 3, :2]
    assert (halo[:, ::-1] == wrapped.points[n - np.arange(wake + 1), 1:3]).all()
    # Differences of what a halo holds are central on the cut, too: second order, as inside.
    x, y, _ = np.moveaxis(beyond.grid.points, -1, 0)
    value = x**2 - y
    across = 0.5 * (value[2 : wake + 3, 3] - value[2 : wake + 3, 1])
    back = 0.5 * (value[n + 2 - np.arange(wake + 1), 1] - value[n + 2 - np.arange(wake + 1), 3])
    assert np.abs(across - back).max() < 1e-14
    _drawn(path / "figure_14_wake_and_halo.png", beyond.grid.points[2 : wake + 3, :10], 2)
    _drawn(path / "figure_14_o_grid_and_halo.png", around.grid.points[:14, 2:10], 2, axis=0)
    return int(beyond.known.sum() + around.known.sum())


if __name__ == "__main__":
    main(*sys.argv[1:])
