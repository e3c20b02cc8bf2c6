"""The convex domain that a Voronoi diagram fills: a box, or what a convex boundary encloses."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..errors import InvalidGeometry, InvalidInput
from ..geometry.alternating_digital_tree import Tree
from ..mesh import Mesh
from ..operation import Length, Relative, absolute
from ..progress import Progress, advance, silent
from . import _voronoi_kernels as kernels

EPSILON = float(np.finfo(float).eps)
# Points between two looks at progress.
_CHUNK = 1 << 17


@dataclass(frozen=True, eq=False)
class ConvexDomain:
    """Where no plane's outside is: ``normals @ (x - middle) <= offsets``.

    Attributes
    ----------
    normals : (k, d) float
        Unit normals, outward.
    middle : (d,) float
        A point inside, so that far from the origin nothing cancels.
    offsets : (k,) float
        Distances of the planes from the middle along their normals.
    corners : (c, d) float
        Points whose hull the domain is.
    is_box : bool
        Whether the normals are plus and minus the axes, so that points can be put on the planes exactly.
    """

    normals: np.ndarray
    middle: np.ndarray
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

    @property
    def n_planes(self) -> int:
        """Number of planes."""
        return len(self.offsets)

    @cached_property
    def _tree(self) -> tuple[np.ndarray, Tree]:
        """The planes as rows of normal and offset, and a tree over them."""
        planes = np.column_stack([self.normals, self.offsets])
        return planes, Tree(planes, planes)

    def first_beyond(
        self,
        points: np.ndarray,
        *,
        after: np.ndarray | None = None,
        tolerance: float | None = None,
        progress: Progress = silent,
    ) -> np.ndarray:
        """(n,) int: the first plane that each point lies beyond by more than rounding, or else ``n_planes``.

        Only planes with greater numbers than those of ``after`` count, if it is given.
        """
        planes, tree = self._tree
        least = np.full(len(points), -1) if after is None else after
        tolerance = self.tolerance if tolerance is None else tolerance
        found = np.empty(len(points), np.int64)
        for start in range(0, len(points), _CHUNK):
            advance(progress, start / len(points), "clipping cells")
            part = slice(start, start + _CHUNK)
            kernels.first_beyond(
                points[part] - self.middle, least[part], planes[tree.order], tree.order, tree.right, tree.first,
                tree.bounds, self.offsets.min(), tolerance, found[part],
            )  # fmt: skip
        return found

    def crossings(self, inside: np.ndarray, outside: np.ndarray, plane: np.ndarray) -> np.ndarray:
        """(n, d) float: where edges leave the domain by planes; at their inner end if that is on the plane."""
        normals, offsets = self.normals[plane], self.offsets[plane]
        low, high = (np.einsum("ij,ij->i", normals, ends - self.middle) - offsets for ends in (inside, outside))
        share = np.divide(-low, high - low, out=np.zeros(len(low)), where=high > low)
        return inside + np.clip(share, 0.0, 1.0)[:, None] * (outside - inside)

    def put_on(self, points: np.ndarray) -> np.ndarray:
        """Points that rounding keeps off a plane of a box, put on it exactly."""
        for value in (self.corners.min(axis=0), self.corners.max(axis=0)) if self.is_box else ():
            points = np.where(np.abs(points - value) <= self.tolerance, value, points)
        return points


def box(lower: np.ndarray, upper: np.ndarray) -> ConvexDomain:
    """The box between two corners."""
    lower, upper = np.asarray(lower, float), np.asarray(upper, float)
    axes = np.eye(len(lower))
    middle = 0.5 * lower + 0.5 * upper
    choices = np.stack(np.meshgrid(*[[0, 1]] * len(lower), indexing="ij"), axis=-1).reshape(-1, len(lower))
    return ConvexDomain(
        np.concatenate([-axes, axes]),
        middle,
        np.concatenate([middle - lower, upper - middle]),
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
    offsets = np.einsum("ij,ij->i", start - middle, normals)
    # Sides in many pieces, such as the triangles of a box, are one plane. In random order few planes wait for each
    # other when cells are clipped.
    first = np.random.default_rng(0).permutation(_different(normals, offsets / diagonal))
    normals, start, offsets = normals[first], start[first], offsets[first]
    if offsets.min() <= 1e-12 * diagonal:
        raise InvalidGeometry(f"encloses nothing: {boundary!r}", parameter="boundary")
    domain = ConvexDomain(normals, middle, offsets, corners, False)
    beyond = domain.first_beyond(corners, tolerance=1e-9 * diagonal + domain.tolerance)
    dent = np.flatnonzero(beyond < domain.n_planes)
    if len(dent):
        plane, where = beyond[dent[0]], int(np.unique(faces)[dent[0]])
        high = normals[plane] @ (corners[dent[0]] - start[plane])
        raise InvalidGeometry(
            f"is not convex: point {where} lies {high:g} beyond the side through {start[plane].tolist()}; "
            "give a convex boundary, or a box",
            parameter="boundary",
            points=(where,),
        )
    return domain


def _different(normals: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """The first of each set of planes that are the same up to rounding."""
    _, first = np.unique(np.round(np.column_stack([normals, offsets]), 12) + 0.0, axis=0, return_index=True)
    return np.sort(first)
