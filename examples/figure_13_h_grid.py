"""H-type grids (survey, figure 13): with a slab inside, with a slab reduced to a slit, and round an airfoil.

Two blocks, above and below, are joined by cuts ahead of the section and behind it. Glued, each is one grid with one
hole, or, for the slit (its points are marked), with a crack whose two sides have points of their own.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import gallery
from meshcore.geometry.curves import lines_through
from meshcore.picture import picture

SLAB = np.array([[0, 0], [1, 0], [1, 0.2], [0, 0.2], [0, 0.0]])
SLIT = np.column_stack([np.linspace(0, 1, 17), np.zeros(17)])


def main(folder="out"):
    path, cells = Path(folder), 0
    for name, section, keywords in (
        ("slab", SLAB, {"around": 48}),
        ("slit", SLIT, {}),
        ("airfoil", gallery.airfoil("naca0012"), {"around": 80}),
    ):
        blocks, _ = mc.h_grid(section, radius=1.5, first_height=0.02, wake_growth=1.3, **keywords)
        glued = blocks.to_mesh()
        wall = section if isinstance(section, mc.Mesh) else lines_through(np.pad(section, ((0, 0), (0, 1))))
        seen = [wall, mc.Mesh(wall.points, {"vertex": np.arange(len(SLIT))[:, None]})] if section is SLIT else [wall]
        picture(blocks, path / f"figure_13_{name}.png", title="H-grid", over=seen)
        # Euler's number of a disk with a hole, which a crack is, too: points - edges + cells = 0.
        assert glued.n_points - len(glued.edges) + glued.n_cells == 0
        cells += blocks.n_cells
    return cells


if __name__ == "__main__":
    main(*sys.argv[1:])
