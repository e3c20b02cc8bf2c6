"""Degenerate points in space: the six corners of an octahedron lie on one sphere (survey, figure 26).

Any of its three diagonals may be the one that four tetrahedra share, and choices made one tetrahedron at a time may
contradict each other. Decided by the numbers of the points they cannot: the mesh is valid and fills the octahedron,
alone and in a lattice of octahedra that touch, where two thirds of all holes are tetrahedra.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import quality
from meshcore.picture import picture


def exploded(mesh, shrink):
    """Each tetrahedron on its own, moved away from the middle."""
    cells = mesh.get("tetra")
    corners = mesh.points[cells]
    away = shrink * (corners.mean(axis=1, keepdims=True) - mesh.points.mean(axis=0))
    return mc.Mesh((corners + away).reshape(-1, 3), {"tetra": np.arange(cells.size).reshape(-1, 4)})


def main(folder="out"):
    corners = np.concatenate([np.eye(3), -np.eye(3)])
    mesh, _ = mc.delaunay_3d(corners)
    picture(exploded(mesh, 0.5).boundary, Path(folder) / "figure_26.png", window=(900, 760))
    assert mesh.n_cells == 4 and quality.validate(mesh) == []
    shared = set.intersection(*[set(cell) for cell in mesh.get("tetra").tolist()])
    assert len(shared) == 2 and np.allclose(corners[list(shared)].sum(axis=0), 0)  # they meet at one diagonal
    assert abs(quality.measure(mesh, "volume").sum() - 4 / 3) < 1e-15

    cube = np.stack(np.meshgrid(*[np.arange(5.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    shifts = ([0, 0, 0], [0.5, 0.5, 0], [0.5, 0, 0.5], [0, 0.5, 0.5])
    lattice, _ = mc.delaunay_3d(np.concatenate([cube + shift for shift in shifts]))
    assert quality.validate(lattice) == []
    return mesh.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
