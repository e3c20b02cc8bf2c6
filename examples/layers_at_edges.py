"""Layers off an open surface, whose edges are told one by one what to do (survey, section 2.7.1).

A sector of a hub is marched alone, its two sides being each other turned: three of its copies fit without a seam. Its
foot stays on the wall next to it, which is conical, and its other end leans outwards. Or it ends on a casing: layers
are marched half of the way, and then turn to it.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import gallery, quality
from meshcore.picture import picture

PARTS = 10


def turned(points, times):
    """A copy of the sector's points."""
    a = 2 * np.pi * times / PARTS
    return points @ np.array([[np.cos(a), np.sin(a), 0], [-np.sin(a), np.cos(a), 0], [0, 0, 1]])


def together(sheets):
    """Layers of points as the quads of one mesh."""
    grids = [mc.StructuredGrid(sheet) for sheet in sheets]
    return mc.MultiBlock(tuple(grids)).to_mesh()


def casing(radius=1.7):
    """A cylinder about the hub, longer than that."""
    turn, z = np.meshgrid(np.linspace(0, 2 * np.pi, 721), np.linspace(-1, 2, 4), indexing="ij")
    return mc.StructuredGrid(np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=-1))


def main(folder="out"):
    folder = Path(folder)
    hub, report = mc.hyperbolic_volume(
        gallery.hub_sector(parts=PARTS),
        gallery.conical_wall(240, 4),
        first_height=5e-3,
        layers=20,
        distance=0.6,
        each_edge="imin = periodic, imax = periodic, jmin = guide, jmax = splay 15",
    )
    seen_along_the_axis = hub.points[:, 8] * [1, 1, 0]
    picture(together([turned(seen_along_the_axis, k) for k in range(3)]), folder / "layers_at_edges_periodic.png")
    sides = [hub.points[:, :, 0], hub.points[0], hub.points[:, 0]]
    picture(together(sides), folder / "layers_at_edges_guide.png")
    passage, told = mc.hyperbolic_volume(
        gallery.hub_sector(parts=PARTS),
        gallery.conical_wall(240, 4),
        casing(),
        first_height=5e-3,
        layers=24,
        each_edge="imin = periodic, imax = periodic, jmin = guide, jmax = constant z",
    )
    sides = [passage.points[:, :, 0], passage.points[0], passage.points[:, 0]]
    picture(together(sides), folder / "layers_at_edges_casing.png")
    across = passage.points[:, 8] * [1, 1, 0]
    picture(together([turned(across, k) for k in range(3)]), folder / "layers_at_edges_casing_across.png")
    assert told.converged and np.abs(np.hypot(*passage.points[:, :, -1, :2].reshape(-1, 2).T) - 1.7).max() < 1e-4
    (cut,) = hub.cuts
    foot = hub.points[:, 0]
    assert report.converged and (quality.measure(hub, "scaled_jacobian") > 0).all()
    assert np.abs(cut.moved(hub.points[0]) - hub.points[-1]).max() < 1e-12
    assert np.abs(foot[..., 2] - 0.4 * (1 - np.hypot(foot[..., 0], foot[..., 1]))).max() < 1e-3
    return hub.n_cells + passage.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
