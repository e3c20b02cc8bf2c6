"""Overspill, and its cure (survey, figure 6): points moved along the sides, and constraint lines inside.

In a domain with a re-entrant corner the mapping is not one to one, and the grid spills over its sides. meshcore
refuses such a grid; the error carries it, with the folded cells, drawn red. Asked to, it cures it as the survey says:
"by re-parameterising the boundaries, or adding constraint lines".
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
    corners = (0, 2 * n, 3 * n, 6 * n)  # the re-entrant corner is no corner of the grid: it lies on the north side
    try:
        mc.transfinite(loop, corners=corners)
        raise AssertionError("the fold was not seen")
    except mc.GenerationFailed as failure:
        spilt, folded = failure.partial, failure.cells
    picture(spilt, Path(folder) / "figure_06_overspill.png", marked=folded, window=(800, 700))
    for cure in ("lines", "automatic"):
        grid, report = mc.transfinite(loop, corners=corners, cure=cure)
        picture(grid, Path(folder) / f"figure_06_{cure}.png", window=(800, 700))
        assert report.warnings and jacobians(grid.points[:, :, 0]).min() > 0
    line = mc.transfinite(loop, corners=corners, cure="lines").mesh.points[:, :, 0]
    assert abs(0.5 * jacobians(line)[..., ::2].sum() - 3) < 1e-12  # inside the outline, and all of it
    return len(folded)


def jacobians(p):
    """(ni - 1, nj - 1, 4): the Jacobian at each corner of each cell."""
    quad = np.stack([p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]])
    edge = np.roll(quad, -1, axis=0) - quad
    return np.moveaxis(np.cross(edge, -np.roll(edge, 1, axis=0))[..., 2], 0, -1)


if __name__ == "__main__":
    main(*sys.argv[1:])
