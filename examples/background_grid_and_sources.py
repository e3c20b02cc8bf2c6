"""Sizes from a background grid and from sources (survey, 3.2.3): one large triangle, an aerofoil, its wake, a point.

The background grid is one triangle around the whole domain, with large sizes at its corners. Sources lower them: at the
section itself, along the line of its wake, and within a radius of a point upstream. No edge is longer than the smallest
of all these asks for. The far field's circle is divided by the same sizes first.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import gallery
from meshcore.geometry.curves import lines_through
from meshcore.geometry.parametric import arc
from meshcore.picture import picture
from meshcore.sizing import background_field, graded, smallest


def main(folder="out"):
    section = gallery.airfoil("rae2822", cells=120)
    corners = np.array([[-9.0, -5.0], [9.0, -5.0], [0.0, 11.0]])
    large = mc.Mesh(corners, {"triangle": [[0, 1, 2]]}, {"size": np.array([0.3, 0.8, 0.5])})
    wake = lines_through([[1.0, 0.0], [2.6, -0.12]])
    field = smallest(
        background_field(large, "size"),
        graded(section, near=0.02, growth=1.25, far=1.0),
        graded(wake, near=np.array([0.02, 0.08]), growth=1.2, far=1.0),
        graded(np.array([[-1.2, 0.5, 0.0]]), near=0.04, growth=1.3, far=1.0, radius=0.25),
    )
    far_field, _ = mc.discretised(arc([0.5, 0.0], 3.0), size_field=field)
    mesh, report = mc.delaunay_refinement(gallery.joined(far_field, section), size_field=field, min_angle=28)
    path = Path(folder) / "background_grid_and_sources.png"
    wanted = field(mesh.centroids)
    picture(mesh.with_cell_data(size=wanted), path, scalars="size", window=(1100, 1000))
    sides = mesh.points[mesh.cells["triangle"]]
    longest = np.linalg.norm(sides - np.roll(sides, 1, axis=1), axis=2).max(axis=1)
    assert report.converged and (longest <= wanted * (1 + 1e-9)).all()
    return mesh.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
