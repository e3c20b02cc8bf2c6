"""Degenerate points (survey, figure 9): corners of the block that are none of the domain, and the other way round.

A sector of a disk is a block one side of which is collapsed to a point; a quarter of a disk mapped from a square has a
corner in the middle of its arc, where two lines of the grid go straight on. Both are found and told.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore.picture import picture


def main(folder="out"):
    path = Path(folder)
    radius, angle = np.meshgrid(np.linspace(0, 1, 13), np.linspace(0, np.pi / 2, 17), indexing="ij")
    sector = mc.StructuredGrid(np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1))
    s = np.linspace(0, 1, 17)
    arc = np.pi / 4 * s
    grid, _ = mc.transfinite(
        np.column_stack([s, 0 * s]),
        np.column_stack([np.cos(arc), np.sin(arc)]),
        np.column_stack([np.sin(arc), np.cos(arc)]),
        np.column_stack([0 * s, s]),
    )
    picture(sector, path / "figure_09_side_to_point.png")
    picture(grid, path / "figure_09_corner_on_arc.png")
    (point,) = mc.degenerate(sector)
    assert (point.place, point.kind) == ("imin", "point")
    (corner,) = mc.degenerate(grid.with_points(_straightened(grid.points)))
    assert (corner.place, corner.kind) == ("imax jmax", "straight")
    return sector.n_cells + grid.n_cells


def _straightened(points):
    """The grid with its last corner exactly on the chord between its neighbours, where an arc of many points goes."""
    points = points.copy()
    points[-1, -1] = 0.5 * (points[-2, -1] + points[-1, -2])
    return points


if __name__ == "__main__":
    main(*sys.argv[1:])
