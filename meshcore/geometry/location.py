"""Where points lie in a mesh: the cell that holds each, and the weights of its corners."""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import numpy as np

from ..errors import InvalidGeometry, InvalidInput
from ..mesh import Mesh
from . import _alternating_digital_tree_kernels as kernels
from . import _predicates_kernels as predicates_kernels
from .alternating_digital_tree import Nearest, Tree, near_each_other
from .plane import fitted_plane
from .predicates import workspace

# Coordinates are scaled to below 2 to the first power; what is then below 2 to the second counts as zero. Their last
# bits stay above `predicates.LOWEST_BIT`, so all decisions are exact.
_HIGHEST_BIT = 100
_SMALLEST_BIT = -160


class Location(NamedTuple):
    """Where points lie in a mesh.

    Attributes
    ----------
    cell : (m,) int
        Number of the cell among all cells of the mesh; -1 outside.
    barycentric : (m, k) float
        Weights of the cell's three or four corners, in their order: not negative, with the sum 1; nan outside.
    """

    cell: np.ndarray
    barycentric: np.ndarray


def locate(mesh: Mesh, points: np.ndarray, *, nearest: bool = False) -> Location:
    """Find the cell that holds each point, and its barycentric coordinates there.

    The cells are found in an alternating digital tree, and all decisions are exact: in a conforming mesh a point of
    the domain is never lost between two cells. A point on an edge or a corner gets the first of its cells, by number.
    To ask the same mesh many times, keep a `Locator`.

    Parameters
    ----------
    mesh : Mesh
        Triangles in a plane, or tetrahedra; cells without area or volume hold nothing.
    points : (m, 2) or (m, 3) float
        Where to look. Points off the plane of a planar mesh count as their projections.
    nearest : bool
        Give points outside the cell that is nearest, and the weights of the point of it that is nearest.

    Returns
    -------
    Location
        ``cell``, (m,) int, is -1 outside; ``barycentric`` is (m, 3) or (m, 4) float, nan outside.

    Raises
    ------
    InvalidInput
        If the mesh has cells of other kinds, or points are not an array of two or three columns.
    InvalidGeometry
        If points are not finite, or triangles do not lie in one plane.

    References
    ----------
    Survey, section 3.2.3. J. Bonet, J. Peraire, "An alternating digital tree (ADT) algorithm for 3D geometric
    searching and intersection problems", Int. J. Numer. Meth. Engng 31 (1991).

    Examples
    --------
    >>> from meshcore.gallery import triangulated_square
    >>> cell, barycentric = locate(triangulated_square(1), [[0.75, 0.5], [2.0, 0.0]])
    >>> cell
    array([ 0, -1])
    >>> barycentric[0]
    array([0.25, 0.25, 0.5 ])
    """
    if isinstance(mesh, Mesh) and len(mesh.get("quad")):
        raise InvalidInput(
            f"has {len(mesh.get('quad'))} quad cells, in which a point has no barycentric coordinates; "
            "split them into triangles",
            parameter="mesh",
        )
    return Locator(mesh).locate(points, nearest=nearest)


class Locator:
    """A mesh prepared for many searches: see `locate`.

    Parameters
    ----------
    mesh : Mesh
        Triangles and quads in a plane, or tetrahedra. Quads count as two triangles, cut from their first corner.
    parameter : str
        What errors call the mesh.

    Raises
    ------
    InvalidInput
        If there are no such cells, or others beside them.
    InvalidGeometry
        If triangles do not lie in one plane, or no cell has an area or a volume.

    Examples
    --------
    >>> from meshcore.gallery import triangulated_square
    >>> square = triangulated_square(8)
    >>> locator = Locator(square)
    >>> bool((locator.locate(square.centroids).cell == range(square.n_cells)).all())
    True
    >>> locator.interpolated(square.points[:, 0], [[0.3, 0.2, 0.0], [9.0, 0.2, 0.0]])
    array([0.3, 1. ])
    """

    def __init__(self, mesh: Mesh, parameter: str = "mesh"):
        self.mesh = mesh
        corners, self._cell = simplices(mesh, parameter)
        self.dimension = corners.shape[1] - 1
        used = np.zeros(mesh.n_points, bool)
        used[corners] = True
        self.plane = fitted_plane(mesh.points[used], parameter=parameter) if self.dimension == 2 else None
        flat = self._flat(mesh.points)
        self._exponent = _HIGHEST_BIT - int(np.frexp(np.abs(flat[used]).max())[1])
        xyz = self._scaled(flat)[corners]
        signs = np.empty(len(xyz), np.int8)
        orient = predicates_kernels.orient2d_signs if self.dimension == 2 else predicates_kernels.orient3d_signs
        orient(xyz.reshape(len(xyz), -1), signs, workspace())
        solid = np.flatnonzero(signs)
        if not len(solid):
            size = "an area" if self.dimension == 2 else "a volume"
            raise InvalidGeometry(f"has {len(corners)} cells, none of which has {size}", parameter=parameter)
        self.corners = corners[solid]
        self._cell = self._cell[solid]
        # Kernels want positive cells: the last two corners of others are exchanged, and later their weights.
        self._turned = signs[solid] < 0
        xyz = xyz[solid]
        xyz[self._turned, -2:] = xyz[self._turned, :-3:-1]
        columns = xyz.transpose(1, 0, 2)
        self._tree = Tree(functools.reduce(np.minimum, columns), functools.reduce(np.maximum, columns))
        self._xyz = np.ascontiguousarray(xyz[self._tree.order]).ravel()
        self._outline: tuple[Nearest, np.ndarray, np.ndarray] | None = None

    def _flat(self, points: np.ndarray) -> np.ndarray:
        return points if self.plane is None else self.plane.to_plane(points)

    def _scaled(self, flat: np.ndarray) -> np.ndarray:
        with np.errstate(over="ignore"):  # far outside
            scaled = np.ldexp(flat, self._exponent)
        scaled[np.abs(scaled) < 2.0**_SMALLEST_BIT] = 0.0
        return scaled

    def locate(self, points: np.ndarray, *, nearest: bool = False) -> Location:
        """Cell and barycentric coordinates of each point, as `meshcore.locate` gives them.

        Parameters
        ----------
        points : (m, 2) or (m, 3) float
            Where to look.
        nearest : bool
            Whether points outside get the nearest cell.
        """
        simplex, weights = self._found(points, nearest)
        cell = np.where(simplex >= 0, self._cell[simplex], -1)
        return Location(cell, weights)

    def interpolated(self, values: np.ndarray, points: np.ndarray) -> np.ndarray:
        """(m, ...) float: values at the mesh's points, linear between them, and outside that of the nearest place.

        Parameters
        ----------
        values : (n, ...) float
            One for each point of the mesh.
        points : (m, 2) or (m, 3) float
            Where they are wanted.
        """
        simplex, weights = self._found(points, nearest=True)
        at_corners = np.asarray(values, float)[self.corners[simplex]]
        return np.einsum("mk...,mk->m...", at_corners, weights)

    def _found(self, points: np.ndarray, nearest: bool) -> tuple[np.ndarray, np.ndarray]:
        """Simplex of each point and the weights of its corners."""
        points = checked_points(points)
        flat = self._scaled(self._flat(points))
        simplex = np.full(len(points), -1, np.int64)
        weights = np.full((len(points), self.dimension + 1), np.nan)
        find = kernels.find_triangles if self.dimension == 2 else kernels.find_tetrahedra
        tree = self._tree
        find(
            flat.ravel(), near_each_other(flat), 0, len(flat), self._xyz, tree.order, tree.right, tree.first,
            tree.bounds, workspace(), simplex, weights,
        )  # fmt: skip
        turned = np.flatnonzero((simplex >= 0) & self._turned[simplex])
        weights[turned, -2:] = weights[turned, :-3:-1]
        outside = np.flatnonzero(simplex < 0)
        if nearest and len(outside):
            self._move_to_outline(points, outside, simplex, weights)
        return simplex, weights

    def _move_to_outline(
        self, points: np.ndarray, outside: np.ndarray, simplex: np.ndarray, weights: np.ndarray
    ) -> None:
        """Give points outside the nearest place on the boundary of the mesh."""
        if self._outline is None:
            facets, owner, place = outer_facets(self.corners)
            flat = self._flat(self.mesh.points)
            flat = np.column_stack([flat, np.zeros((len(flat), 3 - flat.shape[1]))])
            self._outline = Nearest(flat[facets]), owner, place
        found, owner, place = self._outline
        flat = self._flat(points[outside])
        flat = np.column_stack([flat, np.zeros((len(flat), 3 - flat.shape[1]))])
        facet, share, _ = found.query(flat)
        simplex[outside] = owner[facet]
        weights[outside] = 0.0
        weights[outside[:, None], place[facet]] = share


def checked_points(points: Any, parameter: str = "points") -> np.ndarray:
    """(m, 3) float: points as given, checked; planar ones get z = 0.

    Raises
    ------
    InvalidInput
        If they are not numbers in two or three columns.
    InvalidGeometry
        If one is not finite.

    Examples
    --------
    >>> checked_points([[1, 2]])
    array([[1., 2., 0.]])
    """
    try:
        given = np.asarray(points)
        points = given.astype(np.float64, copy=False) if given.dtype.kind != "c" else None
    except (TypeError, ValueError):
        points = None
    if points is None:
        raise InvalidInput("needs real numbers, as an (m, 3) array", parameter=parameter)
    if points.size == 0:
        return np.empty((0, 3))
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise InvalidInput(f"needs shape (m, 2) or (m, 3), got {points.shape}", parameter=parameter)
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise InvalidGeometry(
            f"point {bad[0]} is {points[bad[0]].tolist()}; remove or repair it", parameter=parameter, points=bad
        )
    return np.column_stack([points, np.zeros((len(points), 3 - points.shape[1]))])


def simplices(mesh: Mesh, parameter: str = "mesh") -> tuple[np.ndarray, np.ndarray]:
    """(m, 3) or (m, 4) int corners of a mesh's triangles or tetrahedra, and (m,) int the cell that each is part of.

    Quads are cut in two from their first corner; "line" and "vertex" cells are passed over.

    Raises
    ------
    InvalidInput
        If what is given is no mesh, or has cells that are no simplices.

    Examples
    --------
    >>> simplices(Mesh([[0, 0], [1, 0], [1, 1], [0, 1]], {"quad": [[0, 1, 2, 3]]}))[0]
    array([[0, 1, 2],
           [0, 2, 3]])
    """
    if not isinstance(mesh, Mesh):
        raise InvalidInput(f"needs a Mesh, got {type(mesh).__name__}", parameter=parameter)
    known = (
        {"tetra": [[0, 1, 2, 3]]} if mesh.dimension == 3 else {"triangle": [[0, 1, 2]], "quad": [[0, 1, 2], [0, 2, 3]]}
    )
    parts, numbers = [], []
    for kind, cells, where in mesh.blocks():
        if kind in known:
            parts.append(cells[:, known[kind]].reshape(-1, len(known[kind][0])))
            numbers.append(np.repeat(np.arange(where.start, where.stop), len(known[kind])))
        elif (
            kind not in ("line", "vertex") and len(cells) and not (mesh.dimension == 3 and kind in ("triangle", "quad"))
        ):
            raise InvalidInput(
                f"has {len(cells)} {kind} cells; only triangles and tetrahedra are searched, so split them",
                parameter=parameter,
            )
    if not sum(map(len, parts)):
        raise InvalidInput("has neither triangles nor tetrahedra; give a mesh of them", parameter=parameter)
    return np.concatenate(parts), np.concatenate(numbers)


def outer_facets(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Edges of triangles, or faces of tetrahedra, that belong to one of them only.

    Parameters
    ----------
    corners : (m, 3) or (m, 4) int
        Triangles or tetrahedra.

    Returns
    -------
    facets : (k, 2) or (k, 3) int
        Their points.
    owner : (k,) int
        The one that has each.
    place : (k, 2) or (k, 3) int
        Which corners of it they are.

    Examples
    --------
    >>> outer_facets(np.array([[0, 1, 2], [0, 2, 3]]))[0].tolist()
    [[0, 1], [1, 2], [0, 3], [2, 3]]
    """
    size = corners.shape[1]
    place = np.array([[k for k in range(size) if k != left_out] for left_out in range(size)][::-1])
    facets = corners[:, place].reshape(-1, size - 1)
    key = np.sort(facets, axis=1)
    order = np.lexsort(key.T)
    key = key[order]
    same = (key[1:] == key[:-1]).all(axis=1)
    alone = np.sort(order[~(np.append(same, False) | np.append(False, same))])
    return facets[alone], alone // size, place[alone % size]
