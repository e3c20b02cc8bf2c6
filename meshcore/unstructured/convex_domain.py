"""The convex domain that a Voronoi diagram fills: a box, or what a convex boundary encloses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import InvalidGeometry, InvalidInput
from ..mesh import Mesh
from ..operation import Length, Relative, absolute
from . import _voronoi_kernels as kernels

EPSILON = float(np.finfo(float).eps)


@dataclass(frozen=True, eq=False)
class ConvexDomain:
    """Where no plane's outside is: ``normals @ x <= offsets``.

    Attributes
    ----------
    normals : (k, d) float
        Unit normals, outward.
    offsets : (k,) float
        Distances of the planes from the origin along their normals.
    corners : (c, d) float
        Points whose hull the domain is.
    is_box : bool
        Whether the normals are plus and minus the axes, so that points can be put on the planes exactly.
    """

    normals: np.ndarray
    offsets: np.ndarray
    corners: np.ndarray
    is_box: bool

    @property
    def diagonal(self) -> float:
        """Length of the bounding box's diagonal."""
        return float(np.linalg.norm(np.ptp(self.corners, axis=0)))

    @property
    def tolerance(self) -> float:
        """What rounding can move a point by, in the domain's unit."""
        return 64 * EPSILON * self.diagonal + 8 * EPSILON * float(np.abs(self.corners).max())

    def beyond(self, points: np.ndarray) -> np.ndarray:
        """(n,) float: how far each point lies beyond the plane that it is farthest beyond; not positive inside."""
        middle = self.corners.mean(axis=0)
        radius = float((self.offsets - self.normals @ middle).min())
        reach = np.empty(len(points))
        kernels.beyond_planes(np.ascontiguousarray(points), self.normals, self.offsets, middle, radius, reach)
        return reach

    def outside(self, points: np.ndarray) -> np.ndarray:
        """(n,) bool: whether each point lies beyond a plane by more than rounding."""
        return self.beyond(points) > self.tolerance


def box(lower: np.ndarray, upper: np.ndarray) -> ConvexDomain:
    """The box between two corners."""
    lower, upper = np.asarray(lower, float), np.asarray(upper, float)
    axes = np.eye(len(lower))
    choices = np.stack(np.meshgrid(*[[0, 1]] * len(lower), indexing="ij"), axis=-1).reshape(-1, len(lower))
    return ConvexDomain(
        np.concatenate([-axes, axes]),
        np.concatenate([-lower, upper]),
        np.where(choices, upper, lower),
        True,
    )


def domain_of(
    points: np.ndarray, boundary: Mesh | None, margin: Length, given: tuple[float, ...], exponent: int = 0
) -> ConvexDomain:
    """The domain that a call asks for: a boundary, or else a box that is given, or else the points' box enlarged.

    The points were divided by ``2.0**exponent`` already, all else is here.

    Raises
    ------
    InvalidInput, InvalidGeometry
        If the boundary is not convex or not closed, or the box has no extent.
    """
    dimension = points.shape[1]
    if boundary is not None:
        if not isinstance(boundary, Mesh):
            raise InvalidInput(f"needs a Mesh, got {type(boundary).__name__}", parameter="boundary")
        boundary = boundary.with_points(np.ldexp(boundary.points, -exponent))
        return within_loop(boundary) if dimension == 2 else within_surface(boundary)
    if any(given):
        lower, upper, name = *np.split(np.ldexp(given, -exponent), 2), "box"
    else:
        lower, upper, name = points.min(axis=0), points.max(axis=0), "margin"
        diagonal = float(np.linalg.norm(upper - lower))
        wide = absolute(margin, diagonal) if isinstance(margin, Relative) else np.ldexp(float(margin), -exponent)
        lower, upper = lower - wide, upper + wide
    if not (upper > lower).all():
        cure = "give the lower corner first" if name == "box" else "the points leave none: give a margin as a length"
        ends = [np.ldexp(corner, exponent).tolist() for corner in (lower, upper)]
        raise InvalidInput(f"the box from {ends[0]} to {ends[1]} has no extent; {cure}", parameter=name)
    return box(lower, upper)


def within_loop(boundary: Mesh) -> ConvexDomain:
    """What a convex closed loop of lines in the plane z = 0 encloses."""
    lines = _cells(boundary, ("line",))["line"]
    if not boundary.is_planar:
        raise InvalidGeometry("needs lines in the plane z = 0", parameter="boundary")
    ends = np.bincount(lines.ravel(), minlength=boundary.n_points)
    if (ends[lines] != 2).any():
        wrong = np.flatnonzero((ends != 2) & (ends > 0))
        raise InvalidGeometry(
            f"needs one closed loop; {ends[wrong[0]]} lines meet at point {wrong[0]}, two should",
            parameter="boundary",
            points=wrong,
        )
    points = boundary.points[:, :2]
    along = points[lines[:, 1]] - points[lines[:, 0]]
    return _convex(boundary, points, lines, np.column_stack([along[:, 1], -along[:, 0]]))


def within_surface(boundary: Mesh) -> ConvexDomain:
    """What a convex closed surface of triangles and quads encloses."""
    kinds = _cells(boundary, ("triangle", "quad"))
    surface = Mesh(boundary.points, kinds)
    if (surface.facets.shared != 2).any():
        edge = surface.facets.nodes[surface.facets.shared != 2][0, :2]
        raise InvalidGeometry(
            f"needs a closed surface; the edge between points {edge.tolist()} does not lie between two faces",
            parameter="boundary",
            points=edge,
        )
    quads = kinds.get("quad", np.empty((0, 4), np.int64))
    parts = [kinds.get("triangle", np.empty((0, 3), np.int64)), quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]
    faces = np.concatenate(parts)
    a, b, c = (boundary.points[faces[:, k]] for k in range(3))
    return _convex(boundary, boundary.points, faces, np.cross(b - a, c - a))


def _cells(boundary: Mesh, kinds: tuple[str, ...]) -> dict[str, np.ndarray]:
    """The boundary's cells of some kinds, at least one."""
    found = {kind: boundary.cells[kind] for kind in kinds if len(boundary.get(kind))}
    if not found:
        raise InvalidInput(f"needs {' or '.join(kinds)} cells, got {boundary!r}", parameter="boundary")
    return found


def _convex(boundary: Mesh, points: np.ndarray, faces: np.ndarray, normals: np.ndarray) -> ConvexDomain:
    """The domain behind all faces, whichever way they look; refuses a boundary that is not convex."""
    corners = points[np.unique(faces)]
    diagonal = float(np.linalg.norm(np.ptp(corners, axis=0)))
    lengths = np.linalg.norm(normals, axis=1)
    kept = lengths > 1e-14 * diagonal ** (points.shape[1] - 1)
    if not kept.any():
        raise InvalidGeometry(f"encloses nothing: {boundary!r}", parameter="boundary")
    normals = normals[kept] / lengths[kept, None]
    start = points[faces[kept, 0]]
    middle = corners.mean(axis=0)
    normals[np.einsum("ij,ij->i", start - middle, normals) < 0] *= -1
    # Sides in many pieces, such as the triangles of a box, are one plane.
    first = _different(normals, np.einsum("ij,ij->i", start - middle, normals) / diagonal)
    normals, start = normals[first], start[first]
    offsets = np.einsum("ij,ij->i", start, normals)
    for normal, offset, at in zip(normals, offsets, start, strict=True):
        high = points[np.unique(faces)] @ normal - offset
        if high.max() > 1e-9 * diagonal:
            where = int(np.unique(faces)[high.argmax()])
            raise InvalidGeometry(
                f"is not convex: point {where} lies {high.max():g} beyond the side through {at.tolist()}; "
                "give a convex boundary, or a box",
                parameter="boundary",
                points=(where,),
            )
    if (offsets - normals @ middle).min() <= 1e-12 * diagonal:
        raise InvalidGeometry(f"encloses nothing: {boundary!r}", parameter="boundary")
    return ConvexDomain(normals, offsets, corners, False)


def _different(normals: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """The first of each set of planes that are the same up to rounding."""
    _, first = np.unique(np.round(np.column_stack([normals, offsets]), 12) + 0.0, axis=0, return_index=True)
    return np.sort(first)
