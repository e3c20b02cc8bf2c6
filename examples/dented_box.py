"""A dented box, filled by transfinite interpolation and by elliptic generation (survey, sections 2.4.1 and 2.6).

A bulb is pressed into the top of a box, with a neck narrower than itself. Interpolation between the faces spills over
its underside: more than a thousand cells are folded. The elliptic grid with the same boundary has no folded cell.
"""

import sys
from pathlib import Path

import meshcore as mc
from meshcore import gallery, quality
from meshcore.picture import picture
from meshcore.structured.blending import blended


def main(folder="out"):
    n = 32
    cage = gallery.dented_box(n, depth=0.6, bulge=0.1)
    grid, report = mc.elliptic_volume(cage)
    picture(grid, Path(folder) / "dented_box.png")
    picture(mc.StructuredGrid(grid.points[:, n // 2]), Path(folder) / "dented_box_inside.png")
    assert report.converged
    assert (quality.measure(grid, "scaled_jacobian") > 0).all()
    spilt = blended(grid.points, (0, 1, 2))  # interpolated between the faces
    picture(mc.StructuredGrid(spilt[:, n // 2]), Path(folder) / "dented_box_interpolated.png")
    assert (quality.measure(mc.StructuredGrid(spilt), "scaled_jacobian") <= 0).sum() > 1000
    return grid.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
