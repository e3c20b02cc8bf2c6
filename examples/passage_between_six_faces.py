"""A block between six faces: a passage that turns and widens, with cells for a boundary layer on four of its walls.

The faces are found in one closed surface of quads, as somebody models it in Blender, by its eight corners. Edges get
their points first, then faces, then the volume (survey, section 2.6). Blended by length, the walls' spacing reaches all
along them: the height of the wall cells varies by no more than the passage's own width, which is 30 % in its middle.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import gallery
from meshcore.picture import picture

HEIGHT = 0.01


def main(folder="out"):
    cage = gallery.twisted_cage(16, 12, 20)
    walls = {f"spacing_{side}": HEIGHT for side in ("imin", "imax", "jmin", "jmax")}
    grid, _ = mc.transfinite_volume(cage, cells_i=24, cells_j=20, **walls)
    picture(cage, Path(folder) / "passage_cage.png", window=(900, 800))
    picture(grid, Path(folder) / "passage.png", window=(900, 800))
    p = grid.points
    heights = [p[1] - p[0], p[-1] - p[-2], p[:, 1] - p[:, 0], p[:, -1] - p[:, -2]]
    heights = np.concatenate([np.linalg.norm(step, axis=-1).ravel() for step in heights])
    assert heights.min() > 0.99 * HEIGHT and heights.max() < 1.31 * HEIGHT
    return grid.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
