"""Measures along the lines of quadrilaterals, hexahedra and prism layers: growth from cell to cell, and at the walls.

They hold for structured grids and for any mesh of such cells: a line runs from a facet of a cell to the opposite one.
"""

from __future__ import annotations

import numpy as np

from ..mesh import CELL_TYPES, Mesh
from .measure_table import Measure
from .neighbours import geometry
from .vectors import dot, length, quotient


def _opposite(kind: str) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
    """Facets of a kind that have an opposite one, with the nodes of that where the edges from theirs end."""
    edges, facets = CELL_TYPES[kind].edges, CELL_TYPES[kind].facets
    neighbours = {node: {b if a == node else a for a, b in edges if node in (a, b)} for edge in edges for node in edge}
    found = []
    for facet in facets:
        away = [neighbours[node] - set(facet) for node in facet]
        ends = tuple(node for nodes in away for node in nodes)
        if len(ends) == len(facet) and any(set(ends) == set(other) for other in facets):
            found.append((facet, ends))
    return found


KINDS = tuple(kind for kind in ("quad", "hexahedron", "wedge", "pyramid", "tetra", "triangle") if _opposite(kind))
"""Kinds of cell that lines run through."""


def _across(mesh: Mesh, nodes: np.ndarray, cell: np.ndarray) -> np.ndarray:
    """(k, n) int: for the nodes of facets, those at the other ends of the edges that leave them in a cell, or -1."""
    ordered = np.sort(nodes, axis=1)
    found = np.full(nodes.shape, -1)
    for kind, cells, where in mesh.blocks():
        kind = CELL_TYPES[kind].linear or kind
        rows = np.flatnonzero((cell >= where.start) & (cell < where.stop))
        if kind not in KINDS or not len(rows) or CELL_TYPES[kind].dimension != mesh.dimension:
            continue
        own = cells[cell[rows] - where.start]
        for facet, away in _opposite(kind):
            padded = np.full((len(rows), nodes.shape[1]), -1)
            padded[:, : len(facet)] = own[:, facet]
            same = (np.sort(padded, axis=1) == ordered[rows]).all(axis=1)
            here = rows[same]
            for local, end in zip(facet, away, strict=True):
                at = nodes[here] == own[same, local][:, None]
                found[here] = np.where(at, own[same, end][:, None], found[here])
    return found


def _edges(mesh: Mesh, rows: np.ndarray, cell: np.ndarray) -> np.ndarray:
    """(k, n, 3) float: the edges that leave some facets in a cell of each; nan where there is none."""
    nodes = mesh.facets.nodes[rows][:, : 2 if mesh.dimension == 2 else 4]
    ends = _across(mesh, nodes, cell[rows])
    return np.where((ends >= 0)[..., None], mesh.points[ends] - mesh.points[nodes], np.nan)


def _of_all(mesh: Mesh, rows: np.ndarray, values: np.ndarray) -> np.ndarray:
    """(k,) float: values of some facets among all, others nan."""
    found = np.full(len(mesh.facets.owner), np.nan)
    found[rows] = values
    return found


def line_growth(mesh: Mesh) -> np.ndarray:
    """Longer over shorter of the two edges that follow each other along a line, through a facet.

    Parameters
    ----------
    mesh : Mesh
        Of cells in the plane, on a surface or in space.

    Returns
    -------
    (k,) float
        For each of ``mesh.facets`` the largest of the lines through it; nan on the boundary and between cells without
        lines, infinite beside an edge without length.

    Examples
    --------
    >>> points = [[0, 0], [1, 0], [4, 0], [0, 1], [1, 1], [4, 1]]
    >>> np.nanmax(line_growth(Mesh(points, {"quad": [[0, 1, 4, 3], [1, 2, 5, 4]]})))
    np.float64(3.0)
    """
    _, owner, neighbour, _ = mesh.facets
    rows = np.flatnonzero(neighbour >= 0)
    before, after = (length(_edges(mesh, rows, cell)) for cell in (owner, neighbour))
    ratio = quotient(np.fmax(before, after), np.minimum(before, after), np.inf)
    of_lines = np.where(np.isnan(before) | np.isnan(after), np.nan, ratio)
    return _of_all(mesh, rows, np.fmax.reduce(of_lines, axis=1))


def _heights_and_lengths(mesh: Mesh) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The facets of the boundary, and how far the edges that leave them reach along their normals, and in all."""
    _, owner, neighbour, _ = mesh.facets
    rows = np.flatnonzero(neighbour < 0)
    areas = geometry(mesh).facet_areas[rows]
    inward = -quotient(areas, length(areas)[:, None], 0.0)
    edges = _edges(mesh, rows, owner)
    return rows, dot(edges, inward[:, None]), length(edges)


def wall_height(mesh: Mesh) -> np.ndarray:
    """Distance of the first points from the boundary: the least of a facet's edges that lead inside.

    Parameters
    ----------
    mesh : Mesh
        Of cells in the plane, on a surface or in space.

    Returns
    -------
    (k,) float
        For each of ``mesh.facets``; nan inside and at cells without lines.

    Examples
    --------
    >>> mesh = Mesh([[0, 0], [2, 0], [3, 1], [1, 1]], {"quad": [[0, 1, 2, 3]]})
    >>> bool(np.isclose(wall_height(mesh)[(mesh.facets.nodes[:, :2] == [0, 1]).all(axis=1)], 1.0).all())
    True
    """
    rows, heights, _ = _heights_and_lengths(mesh)
    return _of_all(mesh, rows, np.fmin.reduce(heights, axis=1))


def wall_angle(mesh: Mesh) -> np.ndarray:
    """Angle between the boundary and the lines that leave it: the least of a facet's edges that lead inside.

    Parameters
    ----------
    mesh : Mesh
        Of cells in the plane, on a surface or in space.

    Returns
    -------
    (k,) float
        Degrees, 90 for lines along the normal, for each of ``mesh.facets``; nan inside and at cells without lines.

    Examples
    --------
    >>> mesh = Mesh([[0, 0], [2, 0], [3, 1], [1, 1]], {"quad": [[0, 1, 2, 3]]})
    >>> wall_angle(mesh).round(9).tolist()
    [45.0, 45.0, 45.0, 45.0]
    """
    rows, heights, lengths = _heights_and_lengths(mesh)
    sine = np.clip(quotient(heights, lengths, 0.0), -1, 1)
    angles = np.where(np.isnan(heights), np.nan, np.degrees(np.arcsin(sine)))
    return _of_all(mesh, rows, np.fmin.reduce(angles, axis=1))


MEASURES = {
    "line_growth": Measure(line_growth, (1, 1.3)),
    "wall_angle": Measure(wall_angle, (45, 90), "degree"),
    "wall_height": Measure(wall_height, (0, np.inf), "length"),
}
"""Measures of facets, whose function takes the mesh; 45 degrees are the survey's limit of skewness (section 2.2)."""
