"""Cells of a Voronoi diagram before they are clipped: rows of circumcentres around the sites."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from ..geometry import predicates
from ..mesh import polygons
from ..mesh.topology import connected
from . import _voronoi_kernels as kernels
from .clipping import Faces
from .convex_domain import ConvexDomain

GIVEN_UP = 1e-6
"""Relative error of a circumcentre in double-double arithmetic above which it is computed by fractions."""


def far_points(domain: ConvexDomain) -> np.ndarray:
    """(2 d, d) float: points so far around a domain that no place in it is nearer to one than to any site in it.

    They make every cell bounded. Their coordinates are few whole multiples of a power of two, on which exact
    predicates stay cheap.
    """
    lower, upper = domain.corners.min(axis=0), domain.corners.max(axis=0)
    reach = 2.0 ** np.ceil(np.log2(4 * domain.diagonal))
    middle = np.round(0.5 * (lower + upper) / (reach / 8)) * (reach / 8)
    axes = np.eye(len(lower))
    return middle + reach * np.concatenate([-axes, axes])


class Rows(NamedTuple):
    """Polygons in compressed rows on points of their own."""

    points: np.ndarray
    offsets: np.ndarray
    nodes: np.ndarray


def planar_cells(vertices: np.ndarray, triangles: np.ndarray, n_sites: int, tolerance: float) -> Faces:
    """The polygon of each site that has triangles; far points follow the sites among the vertices."""
    centres = np.empty((len(triangles), 2))
    kernels.circumcentres_2d(vertices, triangles, centres, predicates.workspace())
    offsets, star = _stars(triangles, len(vertices))
    offsets = offsets[: n_sites + 1]
    nodes = np.empty(offsets[-1], np.int64)
    kernels.polygons_around(triangles, offsets, star, n_sites, np.empty(len(vertices), np.int64), nodes)

    def too_small(sizes: np.ndarray) -> np.ndarray:
        return (sizes < 3) & (np.diff(offsets) > 0)

    rows = _welded(Rows(centres, offsets, nodes), tolerance, too_small)
    owner = np.flatnonzero(np.diff(rows.offsets))
    return Faces(
        rows.points, np.append(rows.offsets[owner], len(rows.nodes)), rows.nodes, owner, np.full(len(owner), -1)
    )


def spatial_cells(vertices: np.ndarray, tetrahedra: np.ndarray, n_sites: int, tolerance: float) -> Faces:
    """The faces of all sites' cells; far points follow the sites among the vertices, their cells are outside."""
    centres = circumcentres(vertices, tetrahedra)
    offsets, star = _stars(tetrahedra, len(vertices))
    most = 6 * len(tetrahedra)
    face_offsets, face_nodes = np.empty(most // 3 + 2, np.int64), np.empty(most, np.int64)
    owner, neighbour = np.empty(most // 3 + 1, np.int64), np.empty(most // 3 + 1, np.int64)
    buffer = np.empty((3, 3 * int(np.diff(offsets).max())), np.int64)
    index, after = np.full(len(vertices), -1), np.empty(len(vertices), np.int64)
    count = kernels.faces_around(
        tetrahedra, offsets, star, n_sites, index, after, buffer, face_offsets, face_nodes, owner, neighbour
    )
    face_offsets, owner, neighbour = face_offsets[: count + 1], owner[:count].copy(), neighbour[:count].copy()
    inner = neighbour >= 0

    def too_small(sizes: np.ndarray) -> np.ndarray:
        left = sizes >= 3
        faces = np.bincount(owner[left], minlength=n_sites) + np.bincount(neighbour[left & inner], minlength=n_sites)
        few = np.append(faces < 4, False)
        return few[owner] | few[neighbour]

    rows = _welded(Rows(centres, face_offsets, face_nodes[: face_offsets[-1]]), tolerance, too_small)
    left = np.flatnonzero(np.diff(rows.offsets) >= 3)
    return Faces(rows.points, *polygons.taken(rows.offsets, rows.nodes, left), owner[left], neighbour[left])


def _stars(cells: np.ndarray, n_vertices: int) -> tuple[np.ndarray, np.ndarray]:
    """Cells around each vertex as compressed rows, see `_voronoi_kernels.stars`."""
    offsets = np.concatenate([[0], np.cumsum(np.bincount(cells.ravel(), minlength=n_vertices))])
    star = np.empty(cells.size, np.int64)
    kernels.stars(cells, offsets, star)
    return offsets, star


def circumcentres(vertices: np.ndarray, tetrahedra: np.ndarray) -> np.ndarray:
    """(m, 3) float: circumcentres of tetrahedra in VTK's order; of slivers too, with nearly all their digits."""
    centres, error = np.empty((len(tetrahedra), 3)), np.empty(len(tetrahedra))
    kernels.circumcentres_3d(vertices, tetrahedra, centres, error, predicates.workspace())
    if (error > kernels.PRECISE).any():
        kernels.circumcentres_3d_precisely(vertices, tetrahedra, centres, error, np.empty((3, 4, 2)))
    for t in np.flatnonzero(~(error < GIVEN_UP)):
        centres[t] = exact_circumcentre(vertices[tetrahedra[t]])
    return centres


def exact_circumcentre(corners: np.ndarray) -> np.ndarray:
    """(3,) float: the circumcentre of a tetrahedron by Cramer's rule in fractions, rounded once.

    Examples
    --------
    >>> exact_circumcentre(np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0], [1, 1, 1e-30]], float))[:2]
    array([1., 1.])
    """
    first, *others = [[Fraction(x) for x in corner] for corner in corners.tolist()]
    rows = [[x - y for x, y in zip(corner, first, strict=True)] for corner in others]
    rows = [[*row, sum(x * x for x in row)] for row in rows]

    def determinant(p: int, q: int, s: int) -> Fraction:
        return sum(rows[k][p] * (rows[k - 2][q] * rows[k - 1][s] - rows[k - 2][s] * rows[k - 1][q]) for k in range(3))

    double = 2 * determinant(0, 1, 2)
    columns = [(3, 1, 2), (0, 3, 2), (0, 1, 3)]
    return np.array([float(x + determinant(*c) / double) for x, c in zip(first, columns, strict=True)])


def _welded(rows: Rows, tolerance: float, too_small: Callable[[np.ndarray], np.ndarray]) -> Rows:
    """The rows with points that an edge no longer than rounding joins made one, as those of sites on one circle.

    Rows that would fold or vanish by this keep their points; ``too_small`` tells by the rows' new sizes which are.
    """
    pairs = np.empty((1024, 2), np.int64)
    count = kernels.short_edges(rows.points, rows.offsets, rows.nodes, tolerance, pairs)
    if count > len(pairs):
        pairs = np.empty((count, 2), np.int64)
        kernels.short_edges(rows.points, rows.offsets, rows.nodes, tolerance, pairs)
    pairs = pairs[:count]
    offsets, nodes = np.empty_like(rows.offsets), np.empty_like(rows.nodes)
    faulty = np.empty(len(offsets) - 1, bool)
    while len(pairs):
        number = connected(pairs, len(rows.points))
        first = np.zeros(number.max() + 1, np.int64)
        first[number[::-1]] = np.arange(len(number))[::-1]
        seen = np.full(len(rows.points), -1)
        count = kernels.welded(rows.offsets, rows.nodes, first[number], seen, offsets, nodes, faulty)
        bad = faulty | too_small(np.diff(offsets))
        if not bad.any():
            return Rows(rows.points, offsets, nodes[:count])
        apart = np.zeros(len(rows.points), bool)
        apart[polygons.taken(rows.offsets, rows.nodes, np.flatnonzero(bad))[1]] = True
        kept = ~(apart[pairs[:, 0]] | apart[pairs[:, 1]])
        if kept.all():  # a fault that no weld made
            return rows
        pairs = pairs[kept]
    return rows
