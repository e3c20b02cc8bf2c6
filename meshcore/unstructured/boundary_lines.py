"""The lines of a planar boundary and what becomes of them: pieces that are edges of the mesh, with tag and origin."""

from __future__ import annotations

import numpy as np

from ..mesh import Mesh
from . import _planar_graph_kernels as kernels
from .planar_graph import PlanarGraph


def first_line(boundary: Mesh) -> int:
    """The number of the first "line" cell among all cells of a boundary."""
    kinds = list(boundary.cells)
    return sum(len(boundary.cells[kind]) for kind in kinds[: kinds.index("line")]) if "line" in kinds else 0


def used_points(boundary: Mesh) -> np.ndarray:
    """(k,) int: the points of a boundary that its "line" and "vertex" cells use, ascending."""
    used = np.zeros(boundary.n_points, np.int64)
    return used[: kernels.list_used(boundary.get("line"), boundary.get("vertex"), used)]


def edges_on_lines(
    origin: np.ndarray, twin: np.ndarray, piece_of: np.ndarray, slots: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Edges of a mesh that lie on lines, each once.

    Parameters
    ----------
    origin, twin : (4 * capacity,) int32
        Half-edges, as `_half_edge_kernels` lays them out.
    piece_of : (4 * capacity,) int32
        Piece under each constrained half-edge.
    slots : (m,) int
        Triangles of the mesh.

    Returns
    -------
    ends : (p, 2) int
        Vertices.
    piece : (p,) int
        The piece that each edge is part of.
    """
    flags = origin[4 * slots.astype(np.int64) + 3]
    half_edge = np.concatenate([4 * slots[(flags >> k) & 1 == 1].astype(np.int64) + k for k in range(3)])
    other = twin[half_edge]
    in_mesh = np.zeros(len(origin) // 4, bool)
    in_mesh[slots] = True
    half_edge = half_edge[(other < half_edge) | ~in_mesh[other >> 2]]
    following = half_edge + np.where(half_edge & 3 == 2, -2, 1)
    return np.column_stack([origin[half_edge], origin[following]]).astype(np.int64), piece_of[half_edge]


def along_lines(
    graph: PlanarGraph, xy: np.ndarray, ends: np.ndarray, segment: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Edges on lines in the order and direction of the input lines, and the number of the line of each.

    Parameters
    ----------
    graph : PlanarGraph
        The lines.
    xy : (n, 2) float
        Coordinates of the vertices, in the scale of the graph.
    ends : (p, 2) int
        Vertices of the edges.
    segment : (p,) int
        The segment of the graph that each edge is part of.
    """
    start, stop = graph.points[graph.segments[segment]].transpose(1, 0, 2)
    scale = np.abs(graph.points).max()
    along = (stop - start) / scale
    place = np.einsum("pij,pj->pi", (xy[ends] - start[:, None]) / scale, along)
    ends = np.where(place[:, :1] > place[:, 1:], ends[:, ::-1], ends)
    # Segments that one line was split into stand in its order.
    order = np.lexsort((place.min(axis=1), segment, graph.line[segment]))
    return ends[order], graph.line[segment[order]]


def with_lines(mesh: Mesh, boundary: Mesh, ends: np.ndarray, line: np.ndarray) -> Mesh:
    """A mesh of triangles with the pieces of its boundary's lines as "line" cells.

    Parameters
    ----------
    mesh : Mesh
        "triangle" cells.
    boundary : Mesh
        Whose lines were meshed.
    ends : (p, 2) int
        Points of the mesh at the ends of each piece.
    line : (p,) int
        Number of the boundary's cell that each piece is part of.

    Returns
    -------
    Mesh
        ``cell_data["line"]`` is that number, -1 for triangles. ``cell_data["tag"]``, if the boundary has one, is the
        tag of that cell, 0 for triangles. Other cell data are 0 for lines.

    Examples
    --------
    >>> half = Mesh([[0, 0], [1, 0], [1, 1]], {"triangle": [[0, 1, 2]]})
    >>> outline = Mesh([[0, 0], [1, 0], [1, 1]], {"line": [[0, 1], [1, 2], [2, 0]]}, cell_data={"tag": [7, 8, 9]})
    >>> with_lines(half, outline, np.array([[1, 2]]), np.array([1])).cell_data["tag"].tolist()
    [0, 8]
    """
    n = len(mesh.get("triangle"))
    data = {
        name: np.concatenate([v, np.zeros((len(line), *v.shape[1:]), v.dtype)]) for name, v in mesh.cell_data.items()
    }
    data["line"] = np.concatenate([np.full(n, -1), line])
    if "tag" in boundary.cell_data:
        tag = boundary.cell_data["tag"]
        data["tag"] = np.concatenate([np.zeros((n, *tag.shape[1:]), tag.dtype), tag[line]])
    return Mesh(mesh.points, {"triangle": mesh.get("triangle"), "line": ends}, mesh.point_data, data)
