"""The few cells that the discrete elliptic equations leave folded, unfolded by a barrier on the patch around them."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import binary_dilation, label

from . import _barrier_kernels as kernels
from .winslow import Frame

_MARGINS = (1, 2, 4, 8)  # cells around the folded ones that may move; more if fewer do not help
_HALVINGS = 24
_GAIN, _IDLE = 0.01, 3  # of the worst corner; after so many halvings without that nothing unfolds a patch
_ITERATIONS = 150
_WINDOW = 8  # steps that the minimiser remembers
_SOUND = 1e-6  # sine of a corner below which its cell belongs to the patch


def weak_cells(points: np.ndarray, sign: float, sine: float = _SOUND) -> np.ndarray:
    """(ni - 1, nj - 1) bool: cells with a corner that is turned over or flat.

    Parameters
    ----------
    points : (ni, nj, 2) float
        A planar grid.
    sign : float
        1 if i, j are right-handed, else -1.
    sine : float
        Sine of the angle at a corner from which on it is sound.

    Examples
    --------
    >>> x, y = np.meshgrid([0.0, 1, 2], [0.0, 1], indexing="ij")
    >>> points = np.stack([x, y], axis=-1)
    >>> points[1, 0, 0] = 2.5
    >>> weak_cells(points, 1.0)
    array([[False],
           [ True]])
    """
    return _weak_corners(points, sign, sine).any(axis=(0, 1))


def _weak_corners(points: np.ndarray, sign: float, sine: float = _SOUND) -> np.ndarray:
    """(2, 2, ni - 1, nj - 1) bool: the corners of cells at their first and last i, and at their first and last j."""
    along_i, along_j = np.diff(points, axis=0), np.diff(points, axis=1)
    weak = np.empty((2, 2, len(along_i), along_j.shape[1]), bool)
    for at_i, rows in enumerate((slice(None, -1), slice(1, None))):
        for at_j, columns in enumerate((slice(None, -1), slice(1, None))):
            (ax, ay), (bx, by) = np.moveaxis(along_i[:, columns], -1, 0), np.moveaxis(along_j[rows], -1, 0)
            weak[at_i, at_j] = ~(sign * (ax * by - ay * bx) > sine * np.hypot(ax, ay) * np.hypot(bx, by))
    return weak


def curable_cells(points: np.ndarray, sign: float, *, cyclic: bool = False) -> np.ndarray:
    """Weak cells, but for those that are weak only at a corner of the grid, whose three points are all fixed.

    Parameters
    ----------
    points, sign, cyclic
        As for `unfolded`.

    Returns
    -------
    (ni - 1, nj - 1) bool

    Examples
    --------
    >>> x, y = np.meshgrid([0.0, 1, 2], [0.0, 1, 2], indexing="ij")
    >>> points = np.stack([x, y], axis=-1)
    >>> points[0, 0] = 0.8
    >>> int(weak_cells(points, 1.0).sum()), int(curable_cells(points, 1.0).sum())
    (1, 0)
    """
    weak = _weak_corners(points, sign)
    if not cyclic:
        for at_i in (0, -1):
            for at_j in (0, -1):
                weak[at_i, at_j, at_i, at_j] = False
    return weak.any(axis=(0, 1))


def unfolded(points: np.ndarray, sign: float, *, cyclic: bool = False) -> np.ndarray:
    """A planar grid with its folded cells made convex, by moving the points around them and no others.

    What cannot be unfolded is left as it is: a cell at a corner of the grid where the boundary turns by 180 degrees or
    more, for instance.

    Parameters
    ----------
    points : (ni, nj, 2) float
        A grid with few folded cells. Its boundary stays.
    sign : float
        1 if i, j are right-handed, else -1.
    cyclic : bool
        Whether the last row along i is the first, possibly moved along.

    Returns
    -------
    (ni, nj, 2) float

    Examples
    --------
    >>> x, y = np.meshgrid(np.arange(5.0), np.arange(5.0), indexing="ij")
    >>> points = np.stack([x, y], axis=-1)
    >>> points[2, 2] += 1.5
    >>> int(weak_cells(points, 1.0).sum()), int(weak_cells(unfolded(points, 1.0), 1.0).sum())
    (3, 0)
    """
    weak = curable_cells(points, sign, cyclic=cyclic)
    if not weak.any():
        return points
    turn = _quiet_row(weak) if cyclic else 0
    rows = np.concatenate([np.roll(np.arange(len(points) - 1), -turn), [turn]]) if turn else np.arange(len(points))
    turned = points[rows]
    way = points[-1] - points[0] if cyclic else np.zeros_like(points[0])
    turned[len(points) - 1 - turn :] += way if turn else 0.0
    for margin in _MARGINS:
        weak = curable_cells(turned, sign, cyclic=cyclic)
        if not weak.any():
            break
        patches, number = label(binary_dilation(weak, np.ones((3, 3)), iterations=margin))
        for patch in range(1, number + 1):
            i, j = np.nonzero(patches == patch)
            window = np.s_[i.min() : i.max() + 2, j.min() : j.max() + 2]
            turned[window] = _without_folds(turned[window], sign)
    if not turn:
        return turned
    turned[len(points) - 1 - turn :] -= way
    result = points.copy()
    result[rows] = turned
    result[-1] = result[0] + way
    return result


def _quiet_row(weak: np.ndarray) -> int:
    """The row of a cyclic grid that is farthest from any folded cell: where best to cut it."""
    n = len(weak)
    rows = np.flatnonzero(weak.any(axis=1))
    away = np.abs(np.arange(n)[:, None] - rows[None, :])
    return int(np.minimum(away, n - away).min(axis=1).argmax())


def _without_folds(points: np.ndarray, sign: float) -> np.ndarray:
    """Minimise the functional inside a patch, at first with a soft barrier; the patch as it was if that fails."""
    if min(points.shape[:2]) < 3:
        return points
    frame = Frame.of(points)
    r = frame.inside(points)
    along_i = np.linalg.norm(np.diff(r, axis=1), axis=0).mean(axis=1)
    along_j = np.linalg.norm(np.diff(r, axis=2), axis=0).mean(axis=0)
    scale = np.minimum(np.minimum(along_i[1:], along_i[:-1])[:, None], np.minimum(along_j[1:], along_j[:-1])[None, :])
    room = [np.zeros((n, 2 * scale.size)) for n in (3, _WINDOW, _WINDOW)]
    room = [np.zeros_like(r), *room, np.zeros(_WINDOW)]
    least = kernels.functional(r, along_i, along_j, sign, 1.0, room[0])[1]
    delta = max(0.5, -least)  # a sound corner spans about 1 in these units
    worst, idle = least, 0
    for _ in range(_HALVINGS):
        least = kernels.minimise(r, along_i, along_j, sign, delta, scale, *room, _ITERATIONS)
        if least > 0:
            return frame.outside(r, points)
        idle = idle + 1 if least < worst + _GAIN * abs(worst) else 0
        if idle == _IDLE:
            break
        worst = max(worst, least)
        delta *= 0.5
    return points
