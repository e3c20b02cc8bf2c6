"""Measures between neighbouring cells: non-orthogonality and skewness as OpenFOAM defines them, jumps of size.

References
----------
OpenFOAM, ``primitiveMeshTools``: faceCentresAndAreas, cellCentresAndVols, faceOrthogonality, faceSkewness and
boundaryFaceSkewness, as reported by checkMesh. H. Jasak, "Error analysis and estimation for the finite volume method
with applications to fluid flows", PhD thesis, Imperial College (1996), section 3.6.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..mesh import CELL_TYPES, Mesh
from .measure_table import Measure
from .vectors import corners, cross, dot, length, quotient


class Geometry(NamedTuple):
    """Centres and sizes of the facets and of the cells of highest dimension.

    Attributes
    ----------
    facet_centres, facet_areas : (k, 3) float
        Middle, and area vector out of the owner; in the plane, the edge's outward normal as long as the edge.
    cell_centres : (number of cells, 3) float
        Centroids; nan for cells of lower dimension.
    cell_sizes : (number of cells,) float
        Volumes or areas; nan for cells of lower dimension.
    """

    facet_centres: np.ndarray
    facet_areas: np.ndarray
    cell_centres: np.ndarray
    cell_sizes: np.ndarray


def geometry(mesh: Mesh) -> Geometry:
    """Centres and sizes as OpenFOAM computes them.

    Examples
    --------
    >>> mesh = Mesh([[0, 0], [2, 0], [2, 1], [0, 1]], {"quad": [[0, 1, 2, 3]]})
    >>> geometry(mesh).cell_centres.tolist(), geometry(mesh).cell_sizes.tolist()
    ([[1.0, 0.5, 0.0]], [2.0])
    """
    return _solid_geometry(mesh) if mesh.dimension == 3 else _planar_geometry(mesh)


def _polygons(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centres and area vectors of (m, k, 3) polygons, as a fan of triangles around the mean of the corners."""
    if x.shape[1] == 3:
        return x.mean(axis=1), cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]) / 2
    middle = x.mean(axis=1)[:, None]
    after = np.roll(x, -1, axis=1)
    normals = cross(x - middle, after - middle) / 2
    weights = length(normals)
    centre = (weights[..., None] * (x + after + middle) / 3).sum(axis=1)
    total = weights.sum(axis=1)[:, None]
    return np.where(total > 0, quotient(centre, total, 0.0), middle[:, 0]), normals.sum(axis=1)


def _planar_geometry(mesh: Mesh) -> Geometry:
    centres, normals = np.full((mesh.n_cells, 3), np.nan), np.full((mesh.n_cells, 3), np.nan)
    for kind, cells, where in mesh.blocks():
        if CELL_TYPES[kind].dimension == 2 and len(cells):
            centres[where], normals[where] = _polygons(corners(mesh.points, cells[:, : len(CELL_TYPES[kind].edges)]))
    nodes, owner, neighbour, _ = mesh.facets
    ends = corners(mesh.points, nodes[:, :2])
    # On a curved surface the edge looks out along the mean of the two surface normals.
    upward = normals[owner] + np.where((neighbour >= 0)[:, None], normals[neighbour], 0.0)
    upward = quotient(upward, length(upward)[:, None], 0.0)
    return Geometry(ends.mean(axis=1), cross(ends[:, 1] - ends[:, 0], upward), centres, length(normals))


def _solid_geometry(mesh: Mesh) -> Geometry:
    nodes, owner, neighbour, _ = mesh.facets
    centres, areas = np.zeros((len(nodes), 3)), np.zeros((len(nodes), 3))
    count = (nodes >= 0).sum(axis=1)
    for k in (3, 4):
        rows = np.flatnonzero(count == k)
        if len(rows):
            centres[rows], areas[rows] = _polygons(corners(mesh.points, nodes[rows, :k]))
    inner = np.flatnonzero(neighbour >= 0)
    cell = np.concatenate([owner, neighbour[inner]])
    facet = np.concatenate([np.arange(len(owner)), inner])
    outward = np.concatenate([areas, -areas[inner]])

    def summed(values: np.ndarray) -> np.ndarray:
        return np.stack([np.bincount(cell, weights=v, minlength=mesh.n_cells) for v in values.T], axis=1)

    first = quotient(summed(centres[facet]), np.bincount(cell, minlength=mesh.n_cells)[:, None], np.nan)
    pyramids = dot(outward, centres[facet] - first[cell]) / 3
    weighted = summed(pyramids[:, None] * (0.75 * centres[facet] + 0.25 * first[cell]))
    volumes = summed(pyramids[:, None])[:, 0]
    solid = np.isfinite(first[:, 0])
    return Geometry(centres, areas, quotient(weighted, volumes[:, None], first), np.where(solid, volumes, np.nan))


def non_orthogonality(mesh: Mesh) -> np.ndarray:
    """Angle between a facet's normal and the line through the centres of its two cells.

    Parameters
    ----------
    mesh : Mesh
        Of cells in the plane, on a surface or in space.

    Returns
    -------
    (k,) float
        Degrees, for each of ``mesh.facets``; nan on the boundary. OpenFOAM warns beyond 70 degrees.

    Examples
    --------
    >>> points = [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 2]]
    >>> mesh = Mesh(points, {"quad": [[0, 1, 4, 3], [1, 2, 5, 4]]})
    >>> np.nanmax(non_orthogonality(mesh)).round(3)
    np.float64(14.744)
    """
    _, areas, centres, _ = geometry(mesh)
    _, owner, neighbour, _ = mesh.facets
    d = centres[neighbour] - centres[owner]
    # From sine and cosine, where OpenFOAM's arc cosine loses half of the digits near 0.
    angle = np.degrees(np.arctan2(length(cross(d, areas)), dot(d, areas)))
    return np.where(neighbour >= 0, angle, np.nan)


def face_skewness(mesh: Mesh) -> np.ndarray:
    """Distance from a facet's middle to where the line through the centres of its cells meets it, over its size.

    On the boundary the line runs along the normal from the owner's centre.

    Parameters
    ----------
    mesh : Mesh
        Of cells in the plane, on a surface or in space.

    Returns
    -------
    (k,) float
        For each of ``mesh.facets``. OpenFOAM warns beyond 4.

    Examples
    --------
    >>> points = [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]]
    >>> face_skewness(Mesh(points, {"quad": [[0, 1, 4, 3], [1, 2, 5, 4]]})).max()
    np.float64(0.0)
    """
    middles, areas, centres, _ = geometry(mesh)
    nodes, owner, neighbour, _ = mesh.facets
    inner = neighbour >= 0
    to_face = middles - centres[owner]
    normal = quotient(areas, length(areas)[:, None], 0.0)
    along = np.where(inner[:, None], centres[neighbour] - centres[owner], normal * dot(normal, to_face)[:, None])
    offset = to_face - quotient(dot(areas, to_face), dot(areas, along), 0.0)[:, None] * along
    size = length(offset)
    direction = quotient(offset, size[:, None], 0.0)
    reach = np.where(inner, 0.2, 0.4) * length(along)
    for k in range(nodes.shape[1]):
        there = np.abs(dot(direction, mesh.points[nodes[:, k]] - middles))
        reach = np.maximum(reach, np.where(nodes[:, k] >= 0, there, 0.0))
    return quotient(size, reach, 0.0)


def size_jump(mesh: Mesh) -> np.ndarray:
    """Larger over smaller volume, or area, of the two cells at each facet.

    Parameters
    ----------
    mesh : Mesh
        Of cells in the plane, on a surface or in space.

    Returns
    -------
    (k,) float
        For each of ``mesh.facets``; nan on the boundary, infinite beside a cell that is inverted or has no size.

    Examples
    --------
    >>> points = [[0, 0], [1, 0], [4, 0], [0, 1], [1, 1], [4, 1]]
    >>> np.nanmax(size_jump(Mesh(points, {"quad": [[0, 1, 4, 3], [1, 2, 5, 4]]})))
    np.float64(3.0)
    """
    return _jump(mesh, geometry(mesh).cell_sizes)


def edge_jump(mesh: Mesh) -> np.ndarray:
    """Larger over smaller mean edge length of the two cells at each facet.

    Parameters
    ----------
    mesh : Mesh
        Of cells in the plane, on a surface or in space.

    Returns
    -------
    (k,) float
        For each of ``mesh.facets``; nan on the boundary.

    Examples
    --------
    >>> points = [[0, 0], [1, 0], [4, 0], [0, 1], [1, 1], [4, 1]]
    >>> np.nanmax(edge_jump(Mesh(points, {"quad": [[0, 1, 4, 3], [1, 2, 5, 4]]})))
    np.float64(2.0)
    """
    mean = np.full(mesh.n_cells, np.nan)
    for kind, cells, where in mesh.blocks():
        if CELL_TYPES[kind].edges:
            ends = np.array(CELL_TYPES[kind].edges).T
            mean[where] = length(mesh.points[cells[:, ends[1]]] - mesh.points[cells[:, ends[0]]]).mean(axis=1)
    return _jump(mesh, mean)


def _jump(mesh: Mesh, sizes: np.ndarray) -> np.ndarray:
    _, owner, neighbour, _ = mesh.facets
    a, b = sizes[owner], sizes[neighbour]
    ratio = np.where(np.minimum(a, b) > 0, quotient(np.maximum(a, b), np.minimum(a, b), np.inf), np.inf)
    return np.where(neighbour >= 0, ratio, np.nan)


def per_cell(mesh: Mesh, values: np.ndarray, worst: np.ufunc = np.fmax) -> np.ndarray:
    """(number of cells,) float: the worst of the values of a cell's facets; nan where none is defined."""
    _, owner, neighbour, _ = mesh.facets
    found = np.full(mesh.n_cells, np.nan)
    for cells in (owner, neighbour):
        use = cells >= 0
        worst.at(found, cells[use], values[use])
    return found


MEASURES = {
    "edge_jump": Measure(edge_jump, (1, 1.5)),
    "face_skewness": Measure(face_skewness, (0, 4)),
    "non_orthogonality": Measure(non_orthogonality, (0, 70), "degree"),
    "size_jump": Measure(size_jump, (1, 3)),
}
"""Measures of facets, whose function takes the mesh; the ranges of jumps are a rule of thumb."""
