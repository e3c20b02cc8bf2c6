"""Points at circumcentres, until all angles lie between 30 and 120 degrees (survey, 3.2.4, point generation).

A hexagon with a square hole, refined to a smallest angle of 30 degrees: with it no angle can exceed 120 degrees, as
the survey promises. The histogram shows how the angles lie.
"""

import sys
from pathlib import Path

import meshcore as mc
from meshcore import gallery, quality
from meshcore.picture import histogram, picture


def main(folder="out"):
    hole = mc.Mesh(gallery.square().points * 0.5 - [0.25, 0.25, 0], gallery.square().cells)
    domain = gallery.joined(gallery.circle(6), hole)
    mesh, _ = mc.delaunay_refinement(domain, min_angle=30, size=0.15)
    path = Path(folder)
    picture(mesh, path / "circumcentre_refinement.png", scalars="min_angle", window=(900, 760))
    angles = quality.report(mesh, ["min_angle", "max_angle"])
    histogram(angles, path / "circumcentre_refinement_angles.png", window=(1000, 460))
    assert angles.rows["min_angle"].minimum >= 30 and angles.rows["max_angle"].maximum <= 120
    return mesh.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
