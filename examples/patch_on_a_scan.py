"""Patches on a scanned surface: a bumpy torus of triangles, four curves on it, transfinite and elliptic (survey 2.6).

The transfinite patch is dropped on the triangles; the elliptic one is harmonic on the surface, and knows its curvature:
cells keep their right angles across the bumps. All points of both lie on the triangles.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import gallery, quality
from meshcore.geometry.closest import FacetedSurface
from meshcore.picture import picture


def main(folder="out"):
    scan, sides = gallery.bumpy_torus(), gallery.sides_on_torus(48, 40)
    surface = FacetedSurface(scan)
    grids = {
        "transfinite": mc.transfinite(*sides, surface=scan).mesh,
        "elliptic": mc.elliptic(*sides, surface=scan, control="none").mesh,
    }
    skewness = {}
    for name, grid in grids.items():
        assert surface.closest(grid.points.reshape(-1, 3)).distance.max() < 1e-12
        skewness[name] = quality.measure(grid, "skew").mean()
        picture(shown(scan, grid, surface), Path(folder) / f"patch_on_a_scan_{name}.png", scalars="patch")
    assert skewness["elliptic"] < skewness["transfinite"]
    return grids["elliptic"].n_cells


def shown(scan, grid, surface):
    """Both in one mesh, the grid a little above the scan."""
    patch = grid.to_mesh()
    normals = surface.closest(patch.points).normals
    outwards = np.sign((normals * (patch.points - [2, 2, 0])).sum())
    points = np.concatenate([scan.points, patch.points + 0.02 * outwards * normals])
    cells = {"triangle": scan.get("triangle"), "quad": patch.get("quad") + scan.n_points}
    part = np.repeat([0.0, 1.0], [scan.n_cells, patch.n_cells])
    return mc.Mesh(points * [-1, -1, 1], cells, cell_data={"patch": part})  # turned to the eye


if __name__ == "__main__":
    main(*sys.argv[1:])
