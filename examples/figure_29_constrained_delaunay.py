"""A boundary that Delaunay triangulation does not respect, and one that does (survey, figures 28 and 29).

The points of three thin walls that nearly touch are triangulated alone, whereby triangles reach through a wall, and
again with the walls as constraints: then each of them is an edge of the mesh.
"""

import sys
from pathlib import Path

import numpy as np
from scipy.spatial import Delaunay

import meshcore as mc
from meshcore import gallery
from meshcore.picture import picture


def main(folder="out"):
    ends = [[0.05, 0.5], [0.95, 0.52], [0.5, 0.53], [0.5, 0.9], [0.4, 0.49], [0.4, 0.1]]
    walls = mc.Mesh(ends, {"line": [[0, 1], [2, 3], [4, 5]]})
    domain = gallery.joined(gallery.square(4), walls)
    free = mc.Mesh(domain.points, {"triangle": Delaunay(domain.points[:, :2]).simplices.astype(int)})
    constrained, _ = mc.delaunay_refinement(domain, min_angle=0)
    picture(free, Path(folder) / "figure_28.png", window=(800, 760))
    picture(constrained, Path(folder) / "figure_29.png", window=(800, 760))

    def lost(mesh):
        edges = {frozenset(map(tuple, mesh.points[edge].round(12))) for edge in mesh.edges}
        return sum(frozenset(map(tuple, domain.points[line].round(12))) not in edges for line in domain.get("line"))

    assert lost(free) > 0 and lost(constrained) == 0
    assert np.array_equal(constrained.bounds, domain.bounds)
    return lost(free)


if __name__ == "__main__":
    main(*sys.argv[1:])
