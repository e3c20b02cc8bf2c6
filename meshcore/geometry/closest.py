"""The closest points of a surface of triangles and quads, with normals that turn smoothly from facet to facet."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..errors import InvalidGeometry, InvalidInput
from ..mesh import Mesh, StructuredGrid, topology
from .alternating_digital_tree import Nearest

_SHARP = np.cos(np.radians(30))  # cosine of the angle between a facet and the normal at its corner
_ROUNDS = 8  # the error of each is the last one's times distance over radius of curvature
_ALIKE = 1e-9  # relative difference of diagonals that rounding may make


class Foot(NamedTuple):
    """Where points come to lie on a surface.

    Attributes
    ----------
    points : (m, 3) float
        The closest points of the facets.
    normals : (m, 3) float
        Unit normals there, interpolated from those at the facets' corners.
    distance : (m,) float
        How far the closest points are.
    lifts : (m, 3) float
        From there to the smooth surface that the facets stand for: one of second order through their corners, at right
        angles there with the normals. Nothing beside corners at which facets meet sharply.
    """

    points: np.ndarray
    normals: np.ndarray
    distance: np.ndarray
    lifts: np.ndarray


class FacetedSurface:
    """A surface of triangles in space, prepared to have points dropped on it.

    Facets are turned so that neighbours agree; which side of the whole is the front is that of its first facet. Points
    come to lie on the facets themselves; normals are those of the corners, means of the facets around them weighted by
    their angles, interpolated across each facet: so they turn without jumps, also over a sharp ridge.

    Parameters
    ----------
    mesh : Mesh or StructuredGrid
        Triangles and quads, open or closed. Quads count as two triangles, cut along the shorter diagonal. Facets
        without area are passed over.
    parameter : str
        What errors call the mesh.

    Raises
    ------
    InvalidInput
        If it is no mesh, or has no such cells; others are passed over.
    InvalidGeometry
        If no facet has an area, or the surface has one side only, as a Moebius strip.

    References
    ----------
    G. Thuermer, C. A. Wuethrich, "Computing vertex normals from polygonal facets", J. Graphics Tools 3 (1998).
    T. Boubekeur, M. Alexa, "Phong tessellation", ACM Trans. Graphics 27 (2008), for the lifts, with the weight 1/2 that
    meets the curvature.
    Survey, section 3.2.3, for the tree.

    Examples
    --------
    >>> roof = Mesh([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], {"quad": [[0, 1, 2, 3]]})
    >>> foot = FacetedSurface(roof).closest(np.array([[0.5, 1.0, 0.25], [3.0, 1.0, 0.0]]))
    >>> foot.points.tolist(), foot.distance.tolist()
    ([[0.5, 1.0, 0.0], [2.0, 1.0, 0.0]], [0.25, 1.0])
    """

    def __init__(self, mesh: Mesh | StructuredGrid, parameter: str = "surface"):
        if isinstance(mesh, StructuredGrid):
            mesh = mesh.to_mesh()
        if not isinstance(mesh, Mesh):
            raise InvalidInput(f"needs a Mesh or a StructuredGrid, got {type(mesh).__name__}", parameter=parameter)
        corners = np.concatenate([mesh.get("triangle"), _halves(mesh.points, mesh.get("quad"))])
        if not len(corners):
            raise InvalidInput(f"needs triangles or quads, got {mesh!r}", parameter=parameter)
        area = np.linalg.norm(_area_vectors(mesh.points[corners]), axis=1)
        corners = corners[area > 0]
        if not len(corners):
            raise InvalidGeometry(f"has {len(area)} facets, none of which has an area", parameter=parameter)
        self.corners = _agreeing(_merged(mesh.points, corners), corners, parameter)
        self.points = mesh.points
        self.normals = _corner_normals(_merged(mesh.points, self.corners), mesh.points[self.corners])
        self._smooth = _smooth_corners(_merged(mesh.points, self.corners), mesh.points[self.corners], self.normals)
        self._nearest = Nearest(mesh.points[self.corners])

    def closest(self, points: np.ndarray) -> Foot:
        """The closest point of the surface to each of (m, 3) finite points."""
        facet, weights, distance = self._nearest.query(points)
        corners, normals = self.points[self.corners[facet]], self.normals[facet]
        at = np.einsum("mk,mkq->mq", weights, corners)
        # Half the way to the mean of the points' projections on the tangent planes of the three corners.
        below = weights * self._smooth[facet] * np.einsum("mkq,mkq->mk", corners - at[:, None], normals)
        lifts = 0.5 * np.einsum("mk,mkq->mq", below, normals)
        return Foot(at, _unit(np.einsum("mk,mkq->mq", weights, normals)), distance, lifts)

    def dropped(self, points: np.ndarray) -> Foot:
        """Points of the surface from which (m, 3) points are seen along the smooth normal, found from the closest ones.

        The closest point of an edge serves a whole wedge of space, so that a sheet of points would collapse there; seen
        along normals that turn smoothly, the sheet only bends. The distance is still that of the closest point.
        """
        foot = self.closest(points)
        distance = foot.distance
        for _ in range(_ROUNDS):
            height = ((points - foot.points) * foot.normals).sum(axis=1)
            foot = self.closest(points - height[:, None] * foot.normals)
        return foot._replace(distance=distance)


def _halves(points: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Quads as triangles, whichever corner is first: cut along the shorter diagonal; of equal ones, at the lowest x."""
    one, other = (np.linalg.norm(points[quads[:, k]] - points[quads[:, k + 2]], axis=1) for k in (0, 1))
    lowest = _merged(points, quads).argmin(axis=1) % 2 if len(quads) else np.empty(0, int)
    alike = np.abs(one - other) <= _ALIKE * (one + other)
    turn = np.where(alike, lowest == 1, other < one)
    turned = np.where(turn[:, None], np.roll(quads, -1, axis=1), quads)
    return np.concatenate([turned[:, [0, 1, 2]], turned[:, [0, 2, 3]]])


def _merged(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Corners by numbers that points at one place share: files of triangles repeat them, and so do cuts."""
    _, number = np.unique(points + 0.0, axis=0, return_inverse=True)  # no negative zeros
    return number.reshape(-1)[corners]


def _area_vectors(x: np.ndarray) -> np.ndarray:
    return np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])


def _unit(vectors: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0, length, 1.0)


def _agreeing(number: np.ndarray, corners: np.ndarray, parameter: str) -> np.ndarray:
    """The corners of triangles, turned so that two which share an edge run along it in opposite directions.

    Each triangle stands twice in a graph, as it is and turned; where two agree as they are they are joined so, and also
    when both are turned. A surface with two sides falls apart into one part for each side.
    """
    m = len(corners)
    edge = number[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    forward = edge[:, 0] < edge[:, 1]
    key = topology.edge_keys(edge, int(number.max()) + 1)
    order = np.argsort(key, kind="stable")
    at = np.flatnonzero(np.diff(key[order]) == 0)
    one, two = order[at], order[at + 1]
    count = np.unique(key[order], return_counts=True)[1]
    many = np.repeat(count > 2, count)[at]  # edges of three facets or more say nothing about which sides agree
    one, two = one[~many], two[~many]
    same = forward[one] == forward[two]
    a, b = one // 3, two // 3
    pairs = np.concatenate([np.column_stack([a, b + m * same]), np.column_stack([a + m, b + m * ~same])])
    part = topology.connected(pairs, 2 * m)
    if (part[:m] == part[m:]).any():
        raise InvalidGeometry(
            "has one side only, as a Moebius strip; cut it open, or leave out facets that the grid does not touch",
            parameter=parameter,
        )
    turned = part[:m] > part[m:]
    return topology.turned("triangle", corners, turned)


def _corner_normals(number: np.ndarray, x: np.ndarray) -> np.ndarray:
    """(m, 3, 3) float: for each corner of each triangle the unit normal of the surface at its point."""
    facet = _unit(_area_vectors(x))
    ahead, behind = _unit(np.roll(x, -1, axis=1) - x), _unit(np.roll(x, 1, axis=1) - x)
    angle = np.arccos(np.clip((ahead * behind).sum(axis=-1), -1, 1))
    weighted = angle[..., None] * facet[:, None, :]
    size = int(number.max()) + 1
    total = np.column_stack([np.bincount(number.ravel(), weighted[..., q].ravel(), size) for q in range(3)])
    # Where facets lie back to back, as at the edge of a folded sheet, each keeps its own.
    lost = np.linalg.norm(total, axis=1) < 1e-9
    normals = _unit(total)[number]
    return np.where(lost[number][..., None], facet[:, None, :], normals)


def _smooth_corners(number: np.ndarray, x: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """(m, 3) float: 1 for corners around which all facets look nearly the way of the normal there, else 0."""
    sharp = (normals * _unit(_area_vectors(x))[:, None]).sum(axis=-1) < _SHARP
    there = np.bincount(number[sharp], minlength=int(number.max()) + 1)
    return (there[number] == 0).astype(float)
