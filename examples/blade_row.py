"""A passage of a row of blades with walls at the blades and the hub, which runs on up- and downstream (survey, 2.6).

Lines leave the hub and the blades at right angles, where these do not meet at acute ones, and the first cells have the
same height everywhere, as boundary layers need (survey, section 2.5.1, Steger and Sorenson). Up- and downstream of the
blades the passage has no walls: its two faces are each other's image, turned about the axis of the row. Their points
are free and stay alike to the last bit.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import gallery
from meshcore.picture import picture

HEIGHT = 0.004


def main(folder="out"):
    start = gallery.blade_row()
    walls = [mc.Wall(face, HEIGHT, lean_at_edges=True) for face in ("imin", "imax", "kmin")]
    grid, report = mc.elliptic_volume(start, periodic="i", each_wall=walls, faces="respaced")
    points = grid.points
    surfaces = [points[:, :, 0], points[0], points[:, :, points.shape[2] // 2], points[:, -1]]
    picture(mc.MultiBlock(tuple(mc.StructuredGrid(s) for s in surfaces)), Path(folder) / "blade_row.png")
    neighbours = [turned(points, number) for number in range(3)]
    layer = [mc.StructuredGrid(p[:, :, points.shape[2] // 2]) for p in neighbours]
    picture(mc.MultiBlock(tuple(layer)), Path(folder) / "blade_row_three_passages.png")
    upstream = np.s_[1:17, 1:-1]
    np.testing.assert_allclose(points[-1][upstream], turned(points, 1)[0][upstream], atol=1e-12)
    for first, second in ((points[0], points[1]), (points[-1], points[-2])):
        on_blade = np.linalg.norm(second - first, axis=-1)[23:38, 4:-4]
        assert abs(on_blade / HEIGHT - 1).max() < 0.05
    assert report.quality["points at walls as asked (%)"] > 90
    return grid.n_cells


def turned(points, number, blades=11):
    """The passage so many blades further."""
    angle = 2 * np.pi * number / blades
    return points @ np.array([[np.cos(angle), np.sin(angle), 0], [-np.sin(angle), np.cos(angle), 0], [0, 0, 1]])


if __name__ == "__main__":
    main(*sys.argv[1:])
