"""Multiply connected block (survey, figure 10): a body in a channel, made mappable to rectangles by cuts.

The domain between a cylinder and a box has a hole. Two cuts, ahead of the body and behind it, make it two blocks; each
cut knows its partner, its direction and its orientation, and the glued mesh has the hole and no crack.
"""

import sys
from pathlib import Path

import meshcore as mc
from meshcore import gallery
from meshcore.picture import picture


def main(folder="out"):
    path = Path(folder)
    blocks, _ = mc.h_grid(gallery.circle(48), radius=2, first_height=0.05, wake_growth=1.15)
    glued = blocks.to_mesh()
    picture(blocks.blocks[1], path / "figure_10_upper_block.png")
    picture(glued, path / "figure_10_glued.png", title="Two blocks, two cuts")
    assert [cut.transform for cut in blocks.cuts] == [(1, 2, 3), (1, 2, 3)]
    assert glued.n_points - len(glued.edges) + glued.n_cells == 0  # Euler's number of a disk with one hole
    sides = mc.with_named_sides(blocks)
    assert len(sides.sets["wall"]) == 48
    return blocks.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
