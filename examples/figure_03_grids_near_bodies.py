"""Grids near bodies, as overset grids begin with (survey, figure 3, left part).

Each body has a boundary-fitted grid of its own, which need not match the others: an airfoil and its flap are marched
off by the hyperbolic equations. The cells of each cover what lies between the body and the outermost front, once.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import Mesh, gallery, quality
from meshcore.geometry.curves import polyline
from meshcore.picture import picture


def enclosed(ring):
    """Area inside a closed ring of points, clockwise ones negative."""
    x, y = ring[:, 0], ring[:, 1]
    return 0.5 * float((x[:-1] * y[1:] - x[1:] * y[:-1]).sum())


def flap():
    """A smaller section behind the first, turned downwards."""
    angle = np.radians(-25)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return 0.35 * polyline(gallery.airfoil("naca0012", cells=120))[:, :2] @ turn.T + [1.02, -0.05]


def main(folder="out"):
    grids = []
    for body in (gallery.airfoil("rae2822", cells=180), flap()):
        grid, report = mc.hyperbolic(body, first_height=1e-3, growth=1.15, distance=0.15)
        assert report.converged and (quality.measure(grid, "scaled_jacobian") > 0).all()
        areas = quality.measure(grid, "area")
        wall, outer = grid.points[:, 0, 0], grid.points[:, -1, 0]
        assert abs(areas.sum() / (enclosed(wall) - enclosed(outer)) - 1) < 1e-12
        grids.append(grid.to_mesh())
    first, second = grids
    quads = np.concatenate([first.cells["quad"], second.cells["quad"] + first.n_points])
    both = Mesh(np.concatenate([first.points, second.points]), {"quad": quads})
    picture(both, Path(folder) / "figure_03.png", title="Grids near bodies")
    picture(both, Path(folder) / "figure_03_gap.png", zoom=((0.85, -0.25), (1.25, 0.15)))
    return both.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
