"""A curved grid smoothed on its own surface: a waisted tube, whose points had been shifted about (survey 2.6).

The grid is closed; its cut is free. Points stay on the bicubic surface through them: they still have the tube's radius.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import gallery, quality
from meshcore.picture import picture


def main(folder="out"):
    rough = gallery.rough_tube(64, 32)
    grid, report = mc.elliptically_smoothed(rough)
    for name, mesh in (("before", rough), ("after", grid)):
        picture(mesh, Path(folder) / f"curved_grid_{name}.png", window=(800, 900))
    assert report.converged
    x, y, z = grid.points.reshape(-1, 3).T
    assert np.abs(np.hypot(x, y) - 0.7 - 0.3 * np.cos(2 * np.pi * z / 3)).max() < 2e-3
    assert quality.measure(grid, "scaled_jacobian").min() > 0.95 > 0.8 > quality.measure(rough, "scaled_jacobian").min()
    return grid.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
