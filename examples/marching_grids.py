"""Marching grids (survey, section 2.7): hyperbolic round a section, out of a deep bay, and parabolic to a box.

The hyperbolic march keeps heights and right angles; in the bay, whose walls would meet before the layers are done, it
is drawn out by dissipation. The parabolic march ends on the box that it is given, exactly.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import gallery, quality
from meshcore.geometry.curves import lines_through
from meshcore.picture import picture


def bay(n=12):
    """Outline of a block with a bay twice as deep as wide, ``n`` lines a unit."""
    corners = np.array([[0, 0], [3, 0], [3, 3], [2, 3], [2, 1], [1, 1], [1, 3], [0, 3]], float)
    after = np.roll(corners, -1, axis=0)
    counts = np.round(n * np.linalg.norm(after - corners, axis=1)).astype(int)
    sides = [a + np.arange(m)[:, None] / m * (b - a) for a, b, m in zip(corners, after, counts, strict=True)]
    return lines_through(np.concatenate(sides), closed=True)


def main(folder="out"):
    path = Path(folder)
    section = gallery.airfoil("s1223", cells=250)
    round_section, report = mc.hyperbolic(section, first_height=1e-4, growth=1.2, distance=1.0)
    angle = quality.line_angle(round_section)[:, 1:-1]
    assert report.converged and angle.min() > 90 - 34.1  # a third less skew than Construct2D's 51.2 degrees
    picture(round_section, path / "marching_section.png", title="Hyperbolic grid")

    out_of_the_bay, report = mc.hyperbolic(bay(), first_height=0.01, growth=1.12, distance=3.0)
    assert report.converged and (quality.measure(out_of_the_bay, "scaled_jacobian") > 0).all()
    picture(out_of_the_bay, path / "marching_bay.png", zoom=((-0.5, -0.5), (3.5, 3.8)))

    box = np.array([[-1.0, -1], [2, -1], [2, 1], [-1, 1], [-1, -1]])
    to_the_box, report = mc.parabolic(section, box, first_height=1e-3, growth=1.2)
    outer = np.abs((to_the_box.points[:, -1, 0, :2] - [0.5, 0]) / [1.5, 1]).max(axis=1)
    assert report.converged and np.abs(outer - 1).max() < 1e-12
    picture(to_the_box, path / "marching_box.png", title="Parabolic grid")
    return round_section.n_cells + out_of_the_bay.n_cells + to_the_box.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
