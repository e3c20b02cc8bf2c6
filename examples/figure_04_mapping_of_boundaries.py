"""Mapping of boundaries: the unit square and the domain it is mapped to (survey, figure 4).

A grid of the computational square, coloured by s, and the same cells in the physical domain. The mapping must be
one to one and must take sides to sides; that holds to the last bit for the points of the sides.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import gallery
from meshcore.picture import picture


def main(folder="out"):
    s, t = np.meshgrid(np.linspace(0, 1, 25), np.linspace(0, 1, 13), indexing="ij")
    computational = mc.StructuredGrid(np.stack([s, t], axis=-1), point_data={"s": s[..., None]})
    sides = [np.round(side, 12) for side in gallery.wavy_sides(24, 12)]
    physical, _ = mc.transfinite(*sides)
    physical = physical.with_point_data(s=s[..., None])
    picture(computational, Path(folder) / "figure_04_computational.png", scalars="s", window=(800, 600))
    picture(physical, Path(folder) / "figure_04_physical.png", scalars="s", window=(1000, 560))
    south, east, north, west = sides
    for face, side in ((np.s_[:, 0], south), (np.s_[-1], east), (np.s_[:, -1], north), (np.s_[0], west)):
        assert (physical.points[:, :, 0][face] == side).all()
    return physical.n_points


if __name__ == "__main__":
    main(*sys.argv[1:])
