"""A boundary that Delaunay triangulation does not respect, and one that does (survey, figures 28 and 29).

The points of two slender walls are triangulated alone, whereby triangles cut through the walls, and again with the
walls as constraints: then each of their lines is an edge of the mesh.
"""

import sys
from pathlib import Path

import numpy as np
from scipy.spatial import Delaunay

import meshcore as mc
from meshcore import gallery
from meshcore.picture import picture


def main(folder="out"):
    walls = mc.Mesh([[0.1, 0.45], [0.9, 0.48], [0.9, 0.52], [0.1, 0.55]], {"line": [[0, 1], [2, 3]]})
    domain = gallery.joined(gallery.square(4), walls)
    free = mc.Mesh(domain.points, {"triangle": Delaunay(domain.points[:, :2]).simplices.astype(int)})
    constrained, _ = mc.delaunay_refinement(domain, min_angle=0)
    picture(free, Path(folder) / "figure_28.png", window=(800, 760))
    picture(constrained, Path(folder) / "figure_29.png", window=(800, 760))

    def lost(mesh):
        edges = {frozenset(map(tuple, mesh.points[edge].round(12))) for edge in mesh.edges}
        return sum(frozenset(map(tuple, domain.points[line].round(12))) not in edges for line in domain.get("line"))

    assert lost(free) > 0 and lost(constrained) == 0
    assert np.isclose(np.ptp(constrained.points, axis=0)[:2], 1).all()
    return lost(free)


if __name__ == "__main__":
    main(*sys.argv[1:])
