"""Points by an advancing front inside the Delaunay triangulation (survey, 3.2.4, [31]), beside off-centres.

RAE 2822 with sizes that grow from the section. Above, points that off-centres placed: quickest, and all angles above
30 degrees. Below, points that a front placed, smoothed by three rounds: "this method produces smoother grids".
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import gallery, quality
from meshcore.picture import picture
from meshcore.sizing.size_field import graded

BOX = np.array([[-0.25, -0.36], [1.25, 0.36]])


def near(mesh, offset):
    """The triangles in `BOX`, moved up by ``offset``, with their smallest angles."""
    inside = ((mesh.centroids[:, :2] > BOX[0]) & (mesh.centroids[:, :2] < BOX[1])).all(axis=1)
    part = mesh.selected(np.flatnonzero(inside)).compacted()
    return part.points + [0, offset, 0], part.cells["triangle"], quality.measure(part, "min_angle")


def main(folder="out"):
    domain = gallery.airfoil_in_far_field("rae2822", radius=8.0)
    field = graded(gallery.airfoil("rae2822"), near=0.018, growth=1.15, far=2.0)
    rough, _ = mc.delaunay_refinement(domain, size_field=field, placement="off-centre")
    even, report = mc.delaunay_refinement(domain, size_field=field, placement="front", smoothing=3)
    upper, lower = near(rough, 0.4), near(even, -0.4)
    both = mc.Mesh(
        np.concatenate([upper[0], lower[0]]), {"triangle": np.concatenate([upper[1], len(upper[0]) + lower[1]])}
    )
    path = Path(folder) / "advancing_front_points.png"
    picture(both, path, scalars=np.concatenate([upper[2], lower[2]]), window=(1300, 1300), title="smallest angle")

    def shape(mesh):
        return (1 / quality.measure(mesh, "radius_ratio")).mean()

    assert report.quality["smallest angle (degree)"] > 33
    assert shape(even) > 0.96 > 0.93 > shape(rough)
    return even.n_cells


if __name__ == "__main__":
    main(*sys.argv[1:])
