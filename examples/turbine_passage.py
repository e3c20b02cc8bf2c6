"""A turbine-like passage with twisted faces, filled by elliptic generation in space (survey, section 2.6).

The passage between two blades of a row turns by 70 degrees from the hub to the tip. Its walls have a crease where the
blades begin and end. Transfinite interpolation carries the creases through the whole passage; in the elliptic grid they
fade away a few cells from the walls (survey, section 2.5.1). No hexahedron of it is folded.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import gallery, quality
from meshcore.picture import picture


def main(folder="out"):
    start = gallery.turbine_passage()
    grid, report = mc.elliptic_volume(start, faces="smoothed")
    ni, _, nk = grid.shape
    for name, block in (("transfinite", start), ("elliptic", grid)):
        layers = [mc.StructuredGrid(block.points[:, :, k]) for k in (0, nk // 2, nk - 1)]
        picture(mc.MultiBlock(tuple(layers)), Path(folder) / f"turbine_passage_{name}.png")
    picture(grid, Path(folder) / "turbine_passage.png")
    assert report.converged
    assert (quality.measure(grid, "scaled_jacobian") > 0).all()
    middle = np.s_[ni // 2, :, nk // 2]
    assert crease(grid.points[middle]) < 0.5 * crease(start.points[middle])
    return grid.n_cells


def crease(line):
    """The sharpest turn of a line between neighbouring edges, in radians."""
    edges = np.diff(line, axis=0)
    edges /= np.linalg.norm(edges, axis=1, keepdims=True)
    return np.arccos(np.clip((edges[1:] * edges[:-1]).sum(axis=1), -1, 1)).max()


if __name__ == "__main__":
    main(*sys.argv[1:])
