"""What holds for every triangulation of a planar graph, checked exactly or as strongly as rounding allows."""

from fractions import Fraction

import numpy as np

from tests import naive


def triangles(mesh):
    return mesh.cells["triangle"].tolist()


def assert_is_triangulation(mesh):
    """Counter-clockwise, conforming, no orphans, no two points at one place."""
    points, cells = mesh.points[:, :2].tolist(), triangles(mesh)
    assert all(naive.side(*(points[k] for k in cell)) > 0 for cell in cells)
    directed = [edge for a, b, c in cells for edge in ((a, b), (b, c), (c, a))]
    assert len(set(directed)) == len(directed)
    assert {k for cell in cells for k in cell} == set(range(mesh.n_points))
    assert len({tuple(p) for p in points}) == mesh.n_points


def area(mesh):
    """The exact sum of the triangles' areas."""
    points = mesh.points[:, :2].tolist()
    return sum(naive.side(*(points[k] for k in cell)) for cell in triangles(mesh)) / 2


def shoelace(loop):
    """The exact area of a polygon."""
    loop = [(Fraction(x), Fraction(y)) for x, y in loop]
    after = [*loop[1:], loop[0]]
    return abs(sum(a * d - b * c for (a, b), (c, d) in zip(loop, after, strict=True))) / 2


def euler(mesh):
    """Points - edges + triangles: parts minus holes."""
    return mesh.n_points - len(mesh.edges) + mesh.n_cells


def lines_as_edges(mesh, boundary, tolerance=1e-12):
    """For each line of the boundary the mesh edges that lie on it; asserts that they cover it end to end."""
    points = mesh.points
    edges = {tuple(e) for e in mesh.edges.tolist()}
    scale = np.abs(points).max()
    chains = []
    for a, b in boundary.points[boundary.get("line")]:
        along = b - a
        length = np.linalg.norm(along)
        if length <= 1e-14 * scale:
            chains.append([])
            continue
        share = (points - a) @ along / length**2
        distance = np.linalg.norm(points - a - share[:, None] * along, axis=1)
        on = np.flatnonzero((distance <= tolerance * scale) & (share > -1e-12) & (share < 1 + 1e-12))
        on = on[np.argsort(share[on])]
        assert share[on[0]] * length <= tolerance * scale, "the start of a line is no point of the mesh"
        assert (1 - share[on[-1]]) * length <= tolerance * scale, "the end of a line is no point of the mesh"
        chain = [tuple(sorted(e)) for e in zip(on[:-1].tolist(), on[1:].tolist(), strict=True)]
        assert set(chain) <= edges, "a line is no chain of edges"
        chains.append(chain)
    return chains


def assert_constrained_delaunay(mesh, boundary):
    """No visible point inside a circle, lines kept."""
    barriers = [edge for chain in lines_as_edges(mesh, boundary) for edge in chain]
    assert naive.not_locally_delaunay(mesh.points[:, :2].tolist(), triangles(mesh), barriers) == []


def angles(mesh):
    """(m, 3) float: degrees at the corners."""
    p = mesh.points[mesh.cells["triangle"]]
    found = []
    for k in range(3):
        u, v = p[:, (k + 1) % 3] - p[:, k], p[:, (k + 2) % 3] - p[:, k]
        cross = np.linalg.norm(np.cross(u, v), axis=1)
        found.append(np.degrees(np.arctan2(cross, (u * v).sum(axis=1))))
    return np.column_stack(found)


def longest_edges(mesh):
    """(m,) float."""
    p = mesh.points[mesh.cells["triangle"]]
    return np.linalg.norm(p - np.roll(p, 1, axis=1), axis=2).max(axis=1)
