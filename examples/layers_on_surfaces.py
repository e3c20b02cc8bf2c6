"""Layers marched off surfaces: a wing's tip, a notched body, and a ball of triangles (survey, section 2.7.1).

One call each, without a parameter but heights. Lines leave the surfaces at right angles; in the notch of 60 degrees,
where they would cross, they are drawn out along its middle. No cell is folded.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import gallery, quality
from meshcore.picture import picture


def notched(n=8):
    """A body with an inner corner of 60 degrees."""
    filled = np.ones((2 * n, 2 * n, n), bool)
    filled[n:, n:] = False
    mesh = gallery.bricks(filled, size=1 / n)
    return mesh.with_points(mesh.points @ np.array([[1, 0, 0], [0.5, np.sqrt(0.75), 0], [0, 0, 1]]))


def sheet(mesh, axis, place):
    """The faces of cells that lie in a plane across an axis, put at its origin."""
    nodes = mesh.facets.nodes
    quads = nodes[(nodes >= 0).all(axis=1)]
    inside = (np.abs(mesh.points[quads][:, :, axis] - place) < 1e-6).all(axis=1)
    return mc.Mesh(mesh.points * (1 - np.eye(3)[axis]), {"quad": quads[inside]}).compacted()


def main(folder="out"):
    folder = Path(folder)
    wing, report = mc.hyperbolic_volume(gallery.wing_tip(32, 20, 4), first_height=1e-3, layers=24, distance=0.4)
    picture(wing, folder / "layers_wing_tip.png")
    notch, _ = mc.hyperbolic_volume(notched(), first_height=5e-3, layers=25, distance=1.2)
    picture(sheet(notch, 2, 0.5), folder / "layers_notch.png")
    ball, _ = mc.hyperbolic_volume(gallery.bumpy_ball(900, bump=0.25), first_height=5e-3, layers=16)
    picture(ball, folder / "layers_ball.png")
    assert report.converged
    for mesh in (wing, notch, ball):
        assert quality.summary(mesh)["worst scaled jacobian"] > 0
    sides = {name: len(faces) for name, faces in wing.sets.items()}  # what a flow solver asks for
    assert sides == {"wall": 1536, "outer": 1536, "zmin": 64 * 24}
    return wing.n_cells + notch.n_cells + ball.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
