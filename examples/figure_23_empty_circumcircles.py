"""A Delaunay triangulation and its dual, the Voronoi diagram (survey, figure 23).

Two dozen points, the cells of what is nearest to each, the triangles that join neighbours, and some of the circles
through their corners. No point is inside of any circle, the centres of the circles are the corners of the cells, and
two cells are neighbours only where an edge joins their points.
"""

import sys
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

import meshcore as mc
from meshcore import gallery
from meshcore.picture import picture


def circles(mesh):
    """Centres and radii of the circles through the corners of triangles."""
    a, b, c = (mesh.points[mesh.get("triangle")[:, k], :2] for k in range(3))
    ab, ac = b - a, c - a
    double = 2 * (ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0])
    x = (ac[:, 1] * (ab**2).sum(1) - ab[:, 1] * (ac**2).sum(1)) / double
    y = (ab[:, 0] * (ac**2).sum(1) - ac[:, 0] * (ab**2).sum(1)) / double
    return a + np.column_stack([x, y]), np.hypot(x, y)


def main(folder="out"):
    sites = np.random.default_rng(5).random((24, 2))
    triangles, _ = mc.delaunay_2d(sites)
    cells, _ = mc.voronoi_2d(sites, box=(-0.1, -0.1, 1.1, 1.1))
    centres, radii = circles(triangles)

    inner = np.flatnonzero((np.abs(centres - 0.5) + radii[:, None] < 0.6).all(axis=1))
    drawn = [gallery.circle(96, radius=radii[k], centre=tuple(centres[k])) for k in inner[:: max(1, len(inner) // 6)]]
    points = mc.Mesh(sites, {"vertex": np.arange(len(sites))[:, None]})
    over = [gallery.joined(*drawn), points, mc.Mesh(triangles.points, {"line": triangles.edges})]
    picture(cells, Path(folder) / "figure_23.png", window=(900, 860), over=over)

    nearest, _ = cKDTree(sites).query(centres)
    assert (nearest > radii * (1 - 1e-9)).all()
    within = (np.abs(centres - 0.5) < 0.6).all(axis=1)
    apart, _ = cKDTree(cells.points[:, :2]).query(centres[within])
    assert apart.max() < 1e-12
    assert {tuple(pair) for pair in cells.neighbours.tolist()} <= {tuple(edge) for edge in triangles.edges.tolist()}
    return cells.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
