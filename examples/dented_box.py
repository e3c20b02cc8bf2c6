"""A dented box, filled by transfinite interpolation and by elliptic generation (survey, sections 2.4.1 and 2.6).

A bulb is pressed into the top of a box, on a neck a third as wide as itself. Interpolation between the faces spills
over its underside: thousands of cells are folded. So few cells reach round the bulb that the solution of the discrete
elliptic equations itself has hundreds of folded cells there. They are unfolded by a barrier on the patch around them,
and the grid has none.
"""

import sys
from pathlib import Path

import meshcore as mc
from meshcore import gallery, quality
from meshcore.picture import picture
from meshcore.structured.algebraic.blending import blended
from meshcore.structured.poisson.winslow_3d import count_folded, solved


def main(folder="out"):
    n = 24
    grid, report = mc.elliptic_volume(gallery.dented_box(n, depth=0.7, bulge=0.25))
    picture(grid, Path(folder) / "dented_box.png")
    picture(mc.StructuredGrid(grid.points[:, n // 2]), Path(folder) / "dented_box_inside.png")
    assert report.converged
    assert (quality.measure(grid, "scaled_jacobian") > 0).all()
    spilt = blended(grid.points, (0, 1, 2))  # interpolated between the faces
    picture(mc.StructuredGrid(spilt[:, n // 2]), Path(folder) / "dented_box_interpolated.png")
    assert count_folded(spilt) > 2000
    plain, outcome = solved(spilt)  # the equations alone
    picture(mc.StructuredGrid(plain[:, n // 2]), Path(folder) / "dented_box_equations_alone.png")
    assert outcome.converged
    assert count_folded(plain) > 300
    return grid.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
