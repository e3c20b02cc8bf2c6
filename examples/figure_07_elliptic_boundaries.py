"""Elliptic grid generation: parts of the boundary are equipotential surfaces (survey, figure 7).

Between two circles that do not share their centre, the lines around are lines of constant potential, whatever points
the circles have: circles again, those of Apollonius, known exactly. The grid finds them.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore.picture import picture

CENTRE, RADIUS = 0.3, 0.35


def main(folder="out", around=160, layers=80):
    angle = -np.linspace(0, 2 * np.pi, around + 1)
    uneven = angle + 0.3 * np.sin(angle)
    outer = np.column_stack([np.cos(angle), np.sin(angle)])
    inner = np.column_stack([CENTRE + RADIUS * np.cos(uneven), RADIUS * np.sin(uneven)])
    inner[-1], outer[-1] = inner[0], outer[0]
    t = np.linspace(0, 1, layers + 1)[None, :, None]
    straight = mc.StructuredGrid((1 - t) * inner[:, None] + t * outer[:, None], periodic=(True, False, False))
    grid, report = mc.elliptically_smoothed(straight)
    picture(grid, Path(folder) / "figure_07.png", window=(900, 900))
    off = np.abs(potential(grid.points[:, :, 0]) - np.arange(layers + 1) / layers).max()
    assert report.converged and off < 2e-4
    return grid.n_cells


def potential(points):
    """Laplace's solution that is 0 on the inner circle and 1 on the outer one, the unit circle."""
    total = (
        1 + CENTRE**2 - RADIUS**2
    ) / CENTRE  # of the two points that are inverse in both circles; their product is 1
    near = 0.5 * (total - np.sqrt(total**2 - 4))
    z = points[..., 0] + 1j * points[..., 1]
    value, low, high = (np.log(np.abs((w - near) / (1 - near * w))) for w in (z, CENTRE + RADIUS, 1.0 + 0j))
    return (value - low) / (high - low)


if __name__ == "__main__":
    main(*sys.argv[1:])
