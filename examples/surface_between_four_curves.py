"""A surface in space between four curves: a vault over a square, and a wall spacing at its springing.

Transfinite interpolation knows no plane: sides may be any curves in space that meet at their ends.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore.picture import picture


def main(folder="out"):
    t = np.linspace(0, np.pi, 33)
    arch = np.column_stack([-np.cos(t), np.zeros_like(t), np.sin(t)])
    rail = np.array([[0.0, 0, 0], [0, 2, 0]])
    grid, _ = mc.transfinite(
        arch, rail + [1, 0, 0], arch + [0, 2, 0], rail - [1, 0, 0], cells_j=24, spacing_south=0.02, spacing_north=0.02
    )
    picture(grid, Path(folder) / "surface.png", window=(900, 700))
    assert np.abs(np.hypot(grid.points[..., 0], grid.points[..., 2]) - 1).max() < 1e-12
    return grid.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
