"""Overspill: cells of a surface grid that are folded, flat or turned over (survey 2.4.1, figure 6)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..errors import GenerationFailed
from ..mesh import StructuredGrid, topology
from ..mesh.extent import extents
from ..quality.block import is_sound
from .poisson.control_functions import poles

FLAT = 1e-12
"""Sine of a corner's angle below which the corner counts as flat: round-off of coordinates near 1."""
_HAIR = 1e-6  # degrees that rounding may make of a straight angle
CREASE = -0.5
"""Cosine between neighbouring cells' normals below which one of the two is taken to be turned over."""


def folded_cells(points: np.ndarray) -> np.ndarray:
    """Which cells of a surface grid are folded.

    In a plane, of any attitude, a cell is sound if its Jacobian is positive at all four corners. In space there is
    no outside to compare with: a cell is folded if a corner's normal points against the cell's; creases of more than
    120 degrees cut the surface into parts, and those that face against the largest part are turned over. At a side that
    is one point cells are triangles, of which the corner there is not judged.

    Parameters
    ----------
    points : (ni, nj, 3) float
        The grid's points.

    Returns
    -------
    (ni - 1, nj - 1) bool

    Examples
    --------
    >>> x, y = np.meshgrid([0.0, 1, 2], [0.0, 1], indexing="ij")
    >>> points = np.stack([x, y, 0 * x], axis=-1)
    >>> points[1, 0, 0] = 2.5
    >>> folded_cells(points)
    array([[False],
           [ True]])
    """
    normal = _plane_normal(points, _area(points))
    return _folded_in_space(points) if normal is None else _folded_in_plane(points, normal)


def refuse_folds(grid: StructuredGrid, cure: str, folded: np.ndarray | None = None) -> None:
    """Raise `GenerationFailed`, with cells and grid, if a surface grid has folded cells, which may be known already."""
    if folded is None and not extents(grid.points).all() and is_sound(grid):  # in a plane across an axis
        return
    folded = folded_cells(grid.points[:, :, 0]) if folded is None else folded
    if not folded.any():
        return
    i, j = np.argwhere(folded)[0]
    x, y, z = grid.points[i, j, 0]
    raise GenerationFailed(
        f"{folded.sum()} of {folded.size} cells are folded or flat, the first at i = {i}, j = {j} "
        f"near ({x:.6g}, {y:.6g}, {z:.6g}); {_at_corner(grid, folded)}{cure}",
        cells=np.flatnonzero(folded.ravel(order="F")),
        partial=grid,
    )


def _at_corner(grid: StructuredGrid, folded: np.ndarray) -> str:
    """Which corner of the grid has an angle that makes its cell folded whatever stands inside, if one has."""
    points, worst, text = grid.points[:, :, 0], 180.0 - _HAIR, ""
    if any(grid.periodic):
        return text
    normal = _area(points)
    for i, j in ((0, 0), (-1, 0), (-1, -1), (0, -1)):
        along_i, along_j = points[1 if i == 0 else -2, j] - points[i, j], points[i, 1 if j == 0 else -2] - points[i, j]
        turn = float(np.cross(along_i, along_j) @ normal) * (1 if i == j else -1)
        angle = np.degrees(np.arctan2(turn, float(along_i @ along_j) * np.linalg.norm(normal))) % 360
        if folded[i, j] and angle >= worst:
            faces = ("jmin", "south") if j == 0 else ("jmax", "north"), ("imin", "west") if i == 0 else ("imax", "east")
            names = " and ".join(grid.names.get(face, side) for face, side in faces)
            x, y, z = points[i, j]
            worst = angle
            text = (
                f"at the corner of {names}, ({x:.6g}, {y:.6g}, {z:.6g}), the boundary makes an angle of {angle:.0f} "
                "degrees inside the grid, where no cell can be sound: blocks have to be split there; "
            )
    return text


def around(values: np.ndarray) -> np.ndarray:
    """(2 (ni + nj) - 4, ...) values of a grid's points once round its boundary, from jmin on.

    Examples
    --------
    >>> around(np.array([[0, 3], [1, 4], [2, 5]])).tolist()
    [0, 1, 2, 5, 4, 3]
    """
    return np.concatenate([values[:-1, 0], values[-1, :-1], values[:0:-1, -1], values[0, :0:-1]])


def _area(points: np.ndarray) -> np.ndarray:
    """The area vector of a grid's boundary."""
    loop = around(points)
    return 0.5 * np.cross(loop, np.roll(loop, -1, axis=0)).sum(axis=0)


def _corner_edges(points: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """For each of a cell's four corners, the edges to the next and to the previous one."""
    quad = [points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]]
    edges = [quad[(k + 1) % 4] - quad[k] for k in range(4)]
    for k in range(4):
        yield edges[k], -edges[k - 1]


def _folded_in_plane(points: np.ndarray, normal: np.ndarray) -> np.ndarray:
    first = np.cross(np.eye(3)[np.argmin(np.abs(normal))], normal)
    axes = np.array([first, np.cross(normal, first)]) / np.linalg.norm(first)
    cross, size = corner_products((points - points[0, 0]) @ axes.T)
    return beside_poles(cross <= FLAT * size, points).any(axis=0)


def corner_products(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two (4, ni - 1, nj - 1): cross product and product of lengths of the edges at cells' corners; planar points.

    Examples
    --------
    >>> cross, size = corner_products(np.array([[[0.0, 0], [0, 1]], [[2, 0], [2, 1]]]))
    >>> (cross / size).ravel()
    array([1., 1., 1., 1.])
    """
    cross, size = np.empty((2, 4, len(points) - 1, points.shape[1] - 1))
    for corner, (edge, back) in enumerate(_corner_edges(points)):
        cross[corner] = edge[..., 0] * back[..., 1] - edge[..., 1] * back[..., 0]
        size[corner] = np.hypot(edge[..., 0], edge[..., 1]) * np.hypot(back[..., 0], back[..., 1])
    return cross, size


def beside_poles(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(4, ni - 1, nj - 1) bool of cells' corners, without those at sides of the grid that are one point.

    Examples
    --------
    >>> fan = np.stack(np.meshgrid([0.0, 1], [0.0, 1, 2], indexing="ij"), axis=-1)
    >>> fan[:, 0] = 0.5
    >>> beside_poles(np.ones((4, 1, 2), bool), fan).sum(axis=0)
    array([[2, 4]])
    """
    at = {(1, 0): ((0, 1), np.s_[:, 0]), (0, -1): ((1, 2), np.s_[-1])}
    at |= {(1, -1): ((2, 3), np.s_[:, -1]), (0, 0): ((3, 0), np.s_[0])}
    for pole in poles(points):
        for corner in at[pole][0]:
            corners[corner][at[pole][1]] = False
    return corners


def _plane_normal(points: np.ndarray, area: np.ndarray) -> np.ndarray | None:
    """Unit normal of the plane that holds all points, or None; its side is that of the boundary's area vector."""
    if (points[..., 2] == points[0, 0, 2]).all():
        return np.array([0.0, 0.0, 1.0 if area[2] >= 0 else -1.0])
    extent = float(np.linalg.norm(extents(points)))
    size = float(np.linalg.norm(area))
    if size <= 1e-9 * extent**2:
        return None
    normal = area / size
    return normal if np.abs((points - points[0, 0]) @ normal).max() <= 1e-9 * extent else None


def _folded_in_space(points: np.ndarray) -> np.ndarray:
    pairs = list(_corner_edges(points))
    corners = np.stack([np.cross(edge, back) for edge, back in pairs])
    sizes = np.stack([np.linalg.norm(edge, axis=-1) * np.linalg.norm(back, axis=-1) for edge, back in pairs])
    normal = corners.sum(axis=0)
    length = np.linalg.norm(normal, axis=-1)
    folded = beside_poles((corners * normal).sum(axis=-1) <= FLAT * sizes * length, points).any(axis=0)
    unit = normal / np.where(length > 0, length, 1.0)[..., None]
    along_i = (unit[1:] * unit[:-1]).sum(axis=-1) >= CREASE
    along_j = (unit[:, 1:] * unit[:, :-1]).sum(axis=-1) >= CREASE
    if along_i.all() and along_j.all():
        return folded
    number = np.arange(folded.size).reshape(folded.shape)
    start = np.concatenate([number[:-1][along_i], number[:, :-1][along_j]])
    stop = np.concatenate([number[1:][along_i], number[:, 1:][along_j]])
    part = topology.connected(np.column_stack([start, stop]), folded.size).reshape(folded.shape)
    area = np.column_stack([np.bincount(part.ravel(), weights=x.ravel()) for x in np.moveaxis(normal, -1, 0)])
    largest = area[np.argmax(np.bincount(part.ravel(), weights=length.ravel()))]
    return folded | (area @ largest < 0)[part]
