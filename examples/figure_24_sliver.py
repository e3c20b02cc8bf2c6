"""A sliver: a flat tetrahedron that the Delaunay property does not forbid (survey, figure 24).

Four points near the equator of a sphere, by turns a little above and below it, and a point over each pole. The sphere
through the four is empty, so they make a Delaunay tetrahedron. Its edges are of about one length and its sphere is
small, yet it has next to no volume, and dihedral angles near 0 and 180 degrees.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import gallery, quality
from meshcore.picture import picture


def main(folder="out"):
    angle = np.pi / 2 * np.arange(4)
    height = 0.04 * np.array([1, -1, 1, -1])
    ring = np.column_stack([np.cos(angle), np.sin(angle), height])
    points = np.concatenate([ring, [[0, 0, 1.6], [0, 0, -1.6]]])
    mesh, _ = mc.delaunay_3d(points)
    slivers = np.flatnonzero((mesh.get("tetra") < 4).all(axis=1))
    assert len(slivers) == 1
    sliver = mesh.selected(slivers)

    radius = np.linalg.norm(ring[0])  # the sphere is about the origin, by symmetry
    circle = gallery.circle(120, radius=radius)
    turns = [np.eye(3), np.eye(3)[[0, 2, 1]], np.eye(3)[[2, 1, 0]]]
    sphere = [mc.Mesh(circle.points @ turn, circle.cells) for turn in turns]
    picture(sliver.boundary, Path(folder) / "figure_24.png", window=(900, 760), over=[gallery.joined(*sphere)])

    edges = sliver.points[sliver.edges]
    shortest = np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1).min()
    assert (np.linalg.norm(points[4:], axis=1) > radius).all()  # the sphere is empty
    assert radius / shortest < 0.72  # as good as that of a regular tetrahedron, 0.61, says
    assert quality.measure(sliver, "volume")[0] < 0.06 and quality.measure(sliver, "min_angle")[0] < 10
    return len(slivers)


if __name__ == "__main__":
    main(*sys.argv[1:])
