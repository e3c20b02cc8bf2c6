"""Volumes that the faces of a grid's cells sweep while its points move: the geometric conservation law, discretely."""

from __future__ import annotations

import numpy as np

from ...quality.vectors import cross, dot


def swept_volumes(before: np.ndarray, after: np.ndarray, normal: np.ndarray | None = None) -> tuple[np.ndarray, ...]:
    """For each direction, what each face sweeps while its corners move on straight lines.

    Each is the volume of the cell that has the face before and after as two of its sides; neighbouring faces share
    the other sides, so that sums over a cell give its growth to round-off, whatever the movement.

    Parameters
    ----------
    before, after : (ni, nj, nk, 3) float
        The points of a grid; nk = 1 in a plane.
    normal : (3,) float, optional
        Of the plane, if the grid lies in one.

    Returns
    -------
    tuple of float arrays
        Of the shapes of the faces; positive where a face moves towards larger indices of a right-handed grid.

    Examples
    --------
    >>> x, y = np.meshgrid([0.0, 1, 2], [0.0, 1], indexing="ij")
    >>> before = np.stack([x, y, 0 * x], axis=-1)[:, :, None]
    >>> along_i, along_j = swept_volumes(before, before + [0.5, 0.25, 0], np.array([0, 0, 1.0]))
    >>> along_i.ravel().tolist(), along_j.ravel().tolist()
    ([0.5, 0.5, 0.5], [0.25, 0.25, 0.25, 0.25])
    """
    found = []
    for i in range(3 if normal is None else 2):
        # Time takes the place of the direction that the faces look along.
        path = np.stack([np.moveaxis(before, i, 0), np.moveaxis(after, i, 0)], axis=i + 1)
        swept = _volumes(path) if normal is None else _areas(path, normal)
        found.append(np.ascontiguousarray(np.moveaxis(swept.squeeze(i + 1), 0, i)))
    return tuple(found)


def _areas(points: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Areas of the quadrilaterals of (n, a, b, 1, 3) points, along a and b."""
    return dot(_patch(points, 1, 2)[1], normal)


def _volumes(points: np.ndarray) -> np.ndarray:
    """Volumes of the hexahedra, under the trilinear map, of (n, a, b, c, 3) points."""
    total = 0.0
    for axis, b, c in ((1, 2, 3), (2, 3, 1), (3, 1, 2)):
        middle, area = _patch(points, b, c)
        total = total + np.diff(dot(middle, area), axis=axis) / 3
    return total


def _patch(points: np.ndarray, b: int, c: int) -> tuple[np.ndarray, np.ndarray]:
    """Mean point and area vector of bilinear patches between lines along two axes."""

    def corner(at_b: slice, at_c: slice) -> np.ndarray:
        index = [slice(None)] * points.ndim
        index[b], index[c] = at_b, at_c
        return points[tuple(index)]

    start, stop = slice(None, -1), slice(1, None)
    p, q, r, s = corner(start, start), corner(stop, start), corner(stop, stop), corner(start, stop)
    return 0.25 * (p + q + r + s), 0.5 * cross(r - p, s - q)
