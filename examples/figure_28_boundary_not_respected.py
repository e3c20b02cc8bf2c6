"""Delaunay triangulation does not respect a boundary (survey, figure 28).

The points of a rotor's outline are triangulated: edges reach from blade to blade across the gaps, and sides of blades
are no edges. The outline is drawn over the mesh.
"""

import sys
from pathlib import Path

import numpy as np

import meshcore as mc
from meshcore import gallery
from meshcore.geometry import predicates
from meshcore.geometry.curves import lines_through
from meshcore.picture import picture


def rotor(blades=9, hub=12):
    """A rotor of slanted blades, each near the next one, and a round hole; ``cell_data["tag"]`` 1 and 2."""
    angle = 2 * np.pi * np.arange(blades) / blades
    corners = [(0.0, 0.45), (1.0, 1.0), (1.12, 1.0), (0.35, 0.45)]
    outline = [[r * np.cos(a + s), r * np.sin(a + s)] for a in angle for s, r in corners]
    return gallery.joined(lines_through(outline, closed=True), gallery.circle(hub, radius=0.25))


def edges_of(mesh):
    """The edges of the triangles as pairs of points."""
    return set(map(tuple, mc.Mesh(mesh.points, {"triangle": mesh.get("triangle")}).edges.tolist()))


def cut(points, triangles, line):
    """Triangles that a line enters, by exact signs."""
    a, b = points[line]
    hit = np.zeros(len(triangles), bool)
    for u, v in ((0, 1), (1, 2), (2, 0)):
        c, d = points[triangles[:, u]], points[triangles[:, v]]
        apart = predicates.orient2d(a, b, c) * predicates.orient2d(a, b, d)
        hit |= (apart < 0) & (predicates.orient2d(c, d, a) * predicates.orient2d(c, d, b) < 0)
    return np.flatnonzero(hit)


def main(folder="out"):
    outline = rotor()
    mesh, _ = mc.delaunay_2d(outline)
    edges, triangles = edges_of(mesh), mesh.get("triangle")
    lost = [line for line in outline.get("line") if tuple(np.sort(line)) not in edges]
    across = [cut(outline.points[:, :2], triangles, line) for line in lost]
    shown = mc.Mesh(mesh.points, {"triangle": triangles, "line": outline.get("line")})
    picture(shown, Path(folder) / "figure_28.png", window=(900, 860))
    # A line is lost exactly where edges cross it.
    assert lost and all(len(found) >= 2 for found in across)
    kept = [line for line in outline.get("line") if tuple(np.sort(line)) in edges]
    assert not any(len(cut(outline.points[:, :2], triangles, line)) for line in kept)
    return len(lost)


if __name__ == "__main__":
    main(*sys.argv[1:])
