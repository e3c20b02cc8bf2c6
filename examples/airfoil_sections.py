"""Three sections in O-grids: cambered, supercritical, and blunt at the trailing edge.

Nothing is tuned by section: the rays are chosen by the grid's own soundness. The strongly cambered S1223, whose
underside is a bay, and NACA 0012, whose trailing edge is open, come out without a bad cell too.
"""

import sys
from pathlib import Path

import meshcore as mc
from meshcore import gallery, quality
from meshcore.picture import picture


def main(folder="out"):
    worst = []
    for name in gallery.airfoils():
        grid, _ = mc.o_grid(gallery.airfoil(name), around=160)
        path = Path(folder) / f"section_{name}.png"
        picture(grid, path, zoom=((-0.2, -0.4), (1.2, 0.6)), scalars="scaled_jacobian", window=(1000, 720), title=name)
        worst.append(quality.measure(grid, "scaled_jacobian").min())
    assert min(worst) > 0.03
    return len(worst)


if __name__ == "__main__":
    main(*sys.argv[1:])
