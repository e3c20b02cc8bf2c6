"""A two-block boundary-fitted grid (survey, figure 2), with slopes that are continuous between the blocks.

A channel over a bump and under a bay, in two blocks, whose lines are drawn together where the blocks meet. Each is
interpolated on its own; what they share is the side between them, and the step of the grid lines across it. So no line
has a kink there, where blending by length alone leaves one of seven degrees.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore.picture import picture


def low(x):
    return 0.3 * np.exp(-(((x - 1.0) / 0.35) ** 2))


def high(x):
    return 1.2 + 0.3 * np.exp(-(((x - 3.0) / 0.4) ** 2))


def blocks(n, m, across=None):
    """The grids of both blocks; ``across`` is the step of the lines at their common side, if that is shared."""
    t = np.linspace(0, 1, m + 1)
    drawn = t + 0.1 * np.sin(2 * np.pi * t)
    columns = [
        np.column_stack([np.full(m + 1, x), (1 - s) * low(x) + s * high(x)]) for x, s in ((0, t), (2, drawn), (4, t))
    ]
    made = []
    for number, shared in enumerate(("east", "west")):
        x = 2 * number + np.linspace(0, 2, n + 1)
        sides = np.column_stack([x, low(x)]), columns[number + 1], np.column_stack([x, high(x)]), columns[number]
        if across is None:
            made.append(mc.transfinite(*sides).mesh)
        else:
            made.append(mc.transfinite(*sides, blending="cubic", slopes={shared: across}).mesh)
    return made


def kink(left, right):
    """The largest turn of a line where it crosses from one block to the other, in degrees."""
    before, after = (block.points[:, :, 0] for block in (left, right))
    a = 1.5 * before[-1] - 2 * before[-2] + 0.5 * before[-3]
    b = -1.5 * after[0] + 2 * after[1] - 0.5 * after[2]
    sine = np.linalg.norm(np.cross(a, b), axis=1)
    return float(np.degrees(np.arctan2(sine, (a * b).sum(axis=1))).max())


def main(folder="out"):
    n, m = 40, 24
    rough = blocks(n, m)
    before, after = (block.points[:, :, 0] for block in rough)
    smooth = blocks(n, m, across=0.5 * (after[1] - before[-2]))  # the mean of both blocks' own steps
    picture(mc.MultiBlock(tuple(rough)), Path(folder) / "figure_02_kinked.png", window=(1200, 520))
    picture(mc.MultiBlock(tuple(smooth)), Path(folder) / "figure_02_smooth.png", window=(1200, 520))
    assert (smooth[0].points[-1] == smooth[1].points[0]).all()
    assert kink(*rough) > 6 and kink(*smooth) < 0.5
    return sum(block.n_cells for block in smooth)


if __name__ == "__main__":
    main(*sys.argv[1:])
