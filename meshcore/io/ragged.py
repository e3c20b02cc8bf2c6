"""Cells as files list them (any number of corners, kinds mixed) turned into the kinds of a Mesh."""

from __future__ import annotations

import warnings

import numpy as np

from ..errors import InvalidGeometry, InvalidInput
from ..mesh import BY_VTK, CELL_TYPES
from .fit import FormatWarning

VERTEX, POLY_VERTEX, LINE, POLY_LINE, TRIANGLE_STRIP, POLYGON, PIXEL, VOXEL = 1, 2, 3, 4, 6, 7, 8, 11

# VTK counts the corners of pixels and voxels along the axes, not around the cell.
_AXIS_ORDER = {PIXEL: ("quad", (0, 1, 3, 2)), VOXEL: ("hexahedron", (0, 1, 3, 2, 4, 5, 7, 6))}


def cells_by_kind(
    types: np.ndarray, connectivity: np.ndarray, offsets: np.ndarray, points: np.ndarray
) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Cells listed one after the other, as blocks of one kind each.

    Polygons of three and four corners become triangles and quads. Those with more are cut into triangles, with a
    `FormatWarning`; polylines, strips and groups of vertices are taken apart.

    Parameters
    ----------
    types : (m,) int
        VTK's number of each cell's type.
    connectivity : (k,) int
        Points of all cells, one cell after the other.
    offsets : (m + 1,) int
        Where each cell begins in ``connectivity``, and where the last one ends.
    points : (n, 3) float
        Coordinates.

    Returns
    -------
    cells : dict of str to (m, k) int
        Cells by kind; kinds stand in the order in which they first appear.
    origin : (number of cells,) int
        Number of the listed cell that each cell was made of, to carry cell data along.

    Raises
    ------
    InvalidInput
        If a type has no counterpart in a `Mesh`, or its number of corners is wrong.
    InvalidGeometry
        If a cell refers to a point that does not exist.

    Examples
    --------
    >>> points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    >>> cells, origin = cells_by_kind(np.array([POLY_LINE]), np.array([0, 1, 2]), np.array([0, 3]), points)
    >>> cells["line"].tolist(), origin.tolist()
    ([[0, 1], [1, 2]], [0, 0])
    """
    types = np.asarray(types, np.int64)
    connectivity = np.asarray(connectivity, np.int64)
    offsets = np.asarray(offsets, np.int64)
    _check(types, connectivity, offsets, len(points))
    found: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
    for vtk_type in np.unique(types):
        where = np.flatnonzero(types == vtk_type)
        sizes = offsets[where + 1] - offsets[where]
        for size in np.unique(sizes):
            some = where[sizes == size]
            rows = connectivity[offsets[some][:, None] + np.arange(size)]
            for kind, cells, origin in _split(int(vtk_type), int(size), rows, some, points):
                if len(cells):
                    found.setdefault(kind, []).append((cells, origin))
    return _in_order(found)


def _check(types: np.ndarray, connectivity: np.ndarray, offsets: np.ndarray, n_points: int) -> None:
    if len(offsets) != len(types) + 1 or (np.diff(offsets) < 0).any() or offsets[0] < 0:
        raise InvalidInput("the list of where each cell begins does not fit the cells")
    if offsets[-1] > len(connectivity):
        raise InvalidInput(f"cells need {offsets[-1]} corners, but only {len(connectivity)} are listed")
    bad = np.flatnonzero((connectivity < 0) | (connectivity >= n_points))
    if len(bad):
        cell = int(np.searchsorted(offsets, bad[0], side="right")) - 1
        raise InvalidGeometry(
            f"cell {cell} refers to point {connectivity[bad[0]]}, but points go from 0 to {n_points - 1}", cells=(cell,)
        )


def _in_order(found: dict) -> tuple[dict[str, np.ndarray], np.ndarray]:
    cells, origins = {}, []
    for kind in sorted(found, key=lambda k: min(int(origin.min()) for _, origin in found[k])):
        origin = np.concatenate([o for _, o in found[kind]])
        order = np.argsort(origin, kind="stable")
        cells[kind] = np.concatenate([c for c, _ in found[kind]])[order]
        origins.append(origin[order])
    return cells, np.concatenate(origins) if origins else np.empty(0, np.int64)


def _split(vtk_type: int, size: int, rows: np.ndarray, origin: np.ndarray, points: np.ndarray) -> list[tuple]:
    """Cells of one type and one size as [(kind, cells, origin)]."""
    if vtk_type in _AXIS_ORDER:
        kind, order = _AXIS_ORDER[vtk_type]
        _check_size(kind, size, CELL_TYPES[kind].nodes)
        return [(kind, rows[:, order], origin)]
    if vtk_type in BY_VTK:
        kind = BY_VTK[vtk_type].name
        _check_size(kind, size, CELL_TYPES[kind].nodes)
        return [(kind, rows, origin)]
    if vtk_type == POLYGON:
        return _split_polygons(size, rows, origin, points)
    if vtk_type in (POLY_VERTEX, POLY_LINE, TRIANGLE_STRIP):
        kind, width = {POLY_VERTEX: ("vertex", 1), POLY_LINE: ("line", 2), TRIANGLE_STRIP: ("triangle", 3)}[vtk_type]
        if size < width:
            raise InvalidInput(f"cell {origin[0]} has {size} corners, a {kind} needs {width}")
        windows = np.lib.stride_tricks.sliding_window_view(rows, width, axis=1).copy()
        if kind == "triangle":  # every second triangle of a strip is turned over
            windows[:, 1::2] = windows[:, 1::2][:, :, [1, 0, 2]]
        return [(kind, windows.reshape(-1, width), np.repeat(origin, size - width + 1))]
    if vtk_type == 0:
        raise InvalidInput(f"cell {origin[0]} is empty (VTK type 0); remove it")
    raise InvalidInput(
        f"cell {origin[0]} is of VTK type {vtk_type}, which a Mesh does not hold; split it into simpler cells first"
    )


def _check_size(kind: str, size: int, nodes: int) -> None:
    if size != nodes:
        raise InvalidInput(f"a {kind} has {nodes} nodes, the file lists one with {size}")


def _split_polygons(size: int, rows: np.ndarray, origin: np.ndarray, points: np.ndarray) -> list[tuple]:
    if size < 3:
        raise InvalidInput(f"polygon {origin[0]} has {size} corners, it needs at least three")
    if size <= 4:
        return [("triangle" if size == 3 else "quad", rows, origin)]
    warnings.warn(
        f"{len(rows)} polygons with {size} corners were cut into triangles: a Mesh holds triangles and quads",
        FormatWarning,
        stacklevel=2,
    )
    cells = np.concatenate([polygon_triangles(points[row])[None] for row in rows])
    cells = np.take_along_axis(rows, cells.reshape(len(rows), -1), axis=1).reshape(-1, 3)
    return [("triangle", cells, np.repeat(origin, size - 2))]


def polygon_triangles(corners: np.ndarray) -> np.ndarray:
    """(n - 2, 3) int: a polygon, convex or not, cut into triangles by clipping ears.

    Parameters
    ----------
    corners : (n, 3) float
        Corners in order; a polygon that is not quite flat is seen along its mean normal (Newell's).

    References
    ----------
    G. H. Meisters, "Polygons have ears", Amer. Math. Monthly 82 (1975).

    Examples
    --------
    >>> polygon_triangles(np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [1, 0.2, 0], [0, 1, 0]], float)).tolist()
    [[1, 2, 3], [0, 1, 3], [0, 3, 4]]
    """
    flat = _flattened(corners)
    left = list(range(len(flat)))
    triangles = []
    while len(left) > 3:
        ear = next((k for k in range(len(left)) if _is_ear(flat, left, k)), None)
        if ear is None:  # self-intersecting or without area: any cut is as good as another
            ear = 0
        triangles.append([left[ear - 1], left[ear], left[(ear + 1) % len(left)]])
        del left[ear]
    return np.array([*triangles, left])


def _flattened(corners: np.ndarray) -> np.ndarray:
    """(n, 2) float: corners seen along their mean normal, counter-clockwise."""
    relative = corners - corners.mean(axis=0)
    normal = np.cross(relative, np.roll(relative, -1, axis=0)).sum(axis=0)
    drop = int(np.argmax(np.abs(normal)))
    flat = relative[:, [(drop + 1) % 3, (drop + 2) % 3]]
    return flat if normal[drop] >= 0 else flat * [-1, 1]


def _cross(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def _is_ear(flat: np.ndarray, left: list[int], k: int) -> bool:
    """Whether the corner turns left and no other corner lies in the triangle that it would cut off."""
    before, at, after = left[k - 1], left[k], left[(k + 1) % len(left)]
    a, b, c = flat[before], flat[at], flat[after]
    if _cross(a, b, c) <= 0:
        return False
    others = [flat[p] for p in left if p not in (before, at, after)]
    return not any(_cross(a, b, p) >= 0 and _cross(b, c, p) >= 0 and _cross(c, a, p) >= 0 for p in others)
