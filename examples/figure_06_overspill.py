"""Overspill: transfinite interpolation that leaves its domain (survey, figure 6).

In a domain with a re-entrant corner the mapping is not one to one, and the grid spills over its sides. meshcore
refuses such a grid; the error carries it, with the folded cells, drawn red. Cut in two at the corner, the same
domain is meshed without a fold.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import gallery
from meshcore.picture import picture


def main(folder="out"):
    n = 12
    loop = gallery.l_shape(n)
    try:
        mc.transfinite(loop, corners=(0, 2 * n, 4 * n, 6 * n))
        raise AssertionError("the fold was not seen")
    except mc.GenerationFailed as failure:
        spilt, folded = failure.partial, failure.cells
    picture(spilt, Path(folder) / "figure_06_overspill.png", marked=folded, window=(800, 700))
    # The cure: a constraint line from the re-entrant corner to the opposite one makes two sound patches.

    def straight(start, stop):
        t = np.linspace(0, 1, n + 1)[:, None]
        return (1 - t) * start + t * stop

    a, b, c, d = np.array([[0, 0], [2, 0], [2, 1], [1, 1]], float)
    sides = straight(a, b), straight(b, c), straight(d, c), straight(a, d)
    low, _ = mc.transfinite(*sides)
    high, _ = mc.transfinite(*(side[:, ::-1] for side in sides))
    picture(mc.MultiBlock((low, high)), Path(folder) / "figure_06_cured.png", window=(800, 700))

    def area(grid):
        a, b, c, d = corners(grid.points[:, :, 0])
        return 0.5 * np.cross(c - a, d - b)[..., 2].sum()

    assert abs(area(low) + area(high) - 3) < 1e-12
    assert len(folded) > 0
    return len(folded)


def corners(p):
    """The four corners of each cell."""
    return p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]


if __name__ == "__main__":
    main(*sys.argv[1:])
