"""Whether cells are positively oriented: exactly in the plane and for tetrahedra, by corner Jacobians elsewhere."""

from __future__ import annotations

import numpy as np

from ..geometry import predicates
from ..mesh import CELL_TYPES, Mesh
from . import _triangle_kernels as kernels
from . import solid
from .vectors import corners as corners_of
from .vectors import cross, dot, squared

_UNIT = np.finfo(float).eps / 2


def positive(mesh: Mesh, plane: np.ndarray | None) -> np.ndarray:
    """(number of cells,) bool: whether each cell is positively oriented and not degenerate.

    Parameters
    ----------
    mesh : Mesh
        Curved kinds are judged by their corner nodes.
    plane : (n, 2) float or None
        The points in the coordinates of their plane, if they lie in one: then cells of dimension 2 must be
        counter-clockwise, quads convex too. Without it, cells of dimension 2 must have an area and no fold; but those
        beside volume cells are sides of these, which may be more bent than a surface may, and are not judged.

    Examples
    --------
    >>> mesh = Mesh([[0, 0], [1, 0], [0, 1]], {"triangle": [[0, 1, 2], [0, 2, 1], [0, 1, 1]]})
    >>> positive(mesh, mesh.points[:, :2])
    array([ True, False, False])
    """
    good = np.ones(mesh.n_cells, bool)
    solid_mesh = mesh.dimension == 3
    for kind, cells, where in mesh.blocks():
        corners = CELL_TYPES[kind].linear or kind
        cells = cells[:, : CELL_TYPES[corners].nodes]
        if corners == "line":
            good[where] = (mesh.points[cells[:, 0]] != mesh.points[cells[:, 1]]).any(axis=1)
        elif corners in ("triangle", "quad") and not solid_mesh:
            good[where] = _on_surface(mesh.points, cells) if plane is None else _in_plane(plane, cells)
        elif corners == "tetra":
            good[where] = determinant_sign(mesh.points, cells) > 0
        elif corners in solid.CORNERS:
            good[where] = solid.corner_jacobians(corners, corners_of(mesh.points, cells)).min(axis=1) > 0
    return good


def determinant_sign(points: np.ndarray, simplices: np.ndarray) -> np.ndarray:
    """(m,) int: exact sign of the area of triangles in the plane, or of the volume of tetrahedra.

    Parameters
    ----------
    points : (n, d) float
        d = 2 or 3.
    simplices : (m, d + 1) int
        Their nodes.

    References
    ----------
    The filter is stage A of J. R. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric
    predicates", Discrete Comput. Geom. 18 (1997); what it leaves open is settled by `geometry.predicates`. Most cells
    of a mesh are decided here, by whole arrays at a time.

    Examples
    --------
    >>> determinant_sign(np.array([[0.0, 0], [0.1, 0.1], [0.3, 0.3]]), np.array([[0, 1, 2]]))
    array([0])
    """
    if points.shape[1] == 2:
        sign = np.empty(len(simplices), np.int8)
        triangles = np.ascontiguousarray(simplices, dtype=np.int64)
        unsure = kernels.area_signs(np.ascontiguousarray(points), triangles, sign)
        if unsure:
            unsure = np.flatnonzero(sign == kernels.UNSURE)
            sign[unsure] = predicates.orient2d(*(points[nodes] for nodes in simplices[unsure].T))
        return sign.astype(int)
    with np.errstate(over="ignore", invalid="ignore"):  # infinite and nan values go to the exact stage
        value, bound = _volume_and_bound(points, simplices)
    sign = np.sign(value).astype(int)
    unsure = np.flatnonzero(~(np.abs(value) > bound))
    if len(unsure):
        sign[unsure] = predicates.orient3d(*(points[nodes] for nodes in simplices[unsure].T))
    return sign


def _volume_and_bound(points: np.ndarray, simplices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    x = corners_of(points, simplices)
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = ((x[:, k] - x[:, 0]).T for k in (1, 2, 3))
    terms = [(ax, by, cz, bz, cy), (bx, cy, az, cz, ay), (cx, ay, bz, az, by)]
    value = sum(u * (v * w - s * t) for u, v, w, s, t in terms)
    size = sum(np.abs(u) * (np.abs(v * w) + np.abs(s * t)) for u, v, w, s, t in terms)
    return value, (7 + 56 * _UNIT) * _UNIT * size


def _in_plane(plane: np.ndarray, cells: np.ndarray) -> np.ndarray:
    n = cells.shape[1]
    if n == 3:
        return determinant_sign(plane, cells) > 0
    return np.all([determinant_sign(plane, cells[:, [k - 1, k, (k + 1) % n]]) > 0 for k in range(n)], axis=0)


def _on_surface(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    x = corners_of(points, cells)
    if cells.shape[1] == 3:
        a, b = x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]
        # The cross product of parallel vectors is rounding only: of the order of the unit times both lengths.
        return squared(cross(a, b)) > (4 * _UNIT) ** 2 * squared(a) * squared(b)
    normal = cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1])
    corners = [cross(x[:, (k + 1) % 4] - x[:, k], x[:, k - 1] - x[:, k]) for k in range(4)]
    sound = np.array([dot(c, normal) > 0 for c in corners])
    # With an edge of no length, as beside a pole, a quad is a triangle: the two corners there are one.
    none = np.array([(x[:, (k + 1) % 4] == x[:, k]).all(axis=1) for k in range(4)])
    return (sound | ((none | np.roll(none, 1, axis=0)) & (none.sum(axis=0) == 1))).all(axis=0)
