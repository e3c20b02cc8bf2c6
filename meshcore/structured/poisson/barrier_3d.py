"""Cells of a block that the discrete elliptic equations leave folded, unfolded by a barrier on the patch around them.

In the plane `barrier` minimises Winslow's functional with a barrier in place of the area. In space Winslow's
functional, |adj J|^2 / det J, does not keep cells from collapsing into needles, and left grids folded which the shape
of cells unfolds: their mean ratio is optimised, which in the plane is the same functional.

V. A. Garanzha, Comput. Math. Math. Phys. 40 (2000); J. M. Escobar et al., Comput. Methods Appl. Mech. Engrg. 192
(2003); P. M. Knupp, "Algebraic mesh quality metrics for unstructured initial meshes", Finite Elem. Anal. Des. 39
(2003).
"""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.ndimage import binary_dilation, find_objects, label

from ...mesh.extent import bounds
from ...progress import Progress, advance, part_of, silent
from . import _barrier_3d_kernels as kernels
from .descent import minimised

_MARGINS = (1, 2, 4, 8)  # cells around the folded ones that may move; more if fewer do not help
_SOUND = 1e-6  # scaled Jacobian below which a cell belongs to a patch
_ITERATIONS = 100  # of the minimiser with one barrier: with 40, bulbs on thin necks stay folded
_ROUNDS = 60  # barriers that are tried; less if so many of them become so little steeper
_IN_VAIN, _SLOW = 4, 0.5
_SOFT = 0.1  # part of the least determinant that the barrier's width is not made smaller than


def weak_cells(points: np.ndarray) -> np.ndarray:
    """(ni - 1, nj - 1, nk - 1) bool: cells with a corner that is turned over or flat, and has a point to be moved.

    Parameters
    ----------
    points : (ni, nj, nk, 3) float
        A right-handed block.

    Examples
    --------
    >>> points = np.stack(np.meshgrid(*[np.arange(4.0)] * 3, indexing="ij"), axis=-1)
    >>> points[1, 1, 1] = 2.5
    >>> int(weak_cells(points).sum())
    7
    """
    r = np.ascontiguousarray(np.moveaxis(points, -1, 0))
    weak = np.zeros(tuple(n - 1 for n in r.shape[1:]), bool)
    kernels.weak_cells(r, np.ones((3, max(r.shape[1:]))), _SOUND, np.empty((6, 4, 3)), weak)
    return weak


def unfolded(points: np.ndarray, *, progress: Progress = silent) -> np.ndarray:
    """A block with its folded cells unfolded, by moving the points around them and no others.

    What cannot be unfolded is left as it is.

    Parameters
    ----------
    points : (ni, nj, nk, 3) float
        A right-handed block with few folded cells. Its boundary stays.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    (ni, nj, nk, 3) float

    Examples
    --------
    >>> points = np.stack(np.meshgrid(*[np.arange(6.0)] * 3, indexing="ij"), axis=-1)
    >>> points[2, 2, 2] += 1.2
    >>> int(weak_cells(points).sum()), int(weak_cells(unfolded(points)).sum())
    (7, 0)
    """
    points = points.copy()
    tried = set()
    for number, margin in enumerate(_MARGINS):
        weak = weak_cells(points)
        if not weak.any():
            break
        windows = _windows(weak, margin)
        for k, window in enumerate(windows):
            key = tuple((part.start, part.stop) for part in window)
            if key not in tried and min(points[window].shape[:3]) > 2:
                tried.add(key)
                span = [(number + at / len(windows)) / len(_MARGINS) for at in (k, k + 1)]
                points[window] = _Patch(points[window]).unfolded(part_of(progress, *span))
    return points


def _windows(weak: np.ndarray, margin: int) -> list[tuple[slice, ...]]:
    """The points of the boxes around connected weak cells with a margin of cells."""
    patches, _ = label(binary_dilation(weak, np.ones((3, 3, 3)), iterations=margin))
    return [tuple(slice(part.start, part.stop + 1) for part in box) for box in find_objects(patches)]


class _Patch:
    """The points of a window, of which those inside move in units of the cells' sizes at them."""

    def __init__(self, points: np.ndarray):
        self._points = points
        self._low, high = bounds(points)
        self._size = float((high - self._low).max()) or 1.0
        self._r = np.ascontiguousarray(np.moveaxis((points - self._low) / self._size, -1, 0))
        lengths = [np.linalg.norm(np.diff(self._r, axis=1 + d), axis=0) for d in range(3)]
        along = [length.mean(axis=tuple({0, 1, 2} - {d})) for d, length in enumerate(lengths)]
        self._along = [np.maximum(length, 1e-9 * length.max()) for length in along]
        self._scale = np.min(np.meshgrid(*[np.minimum(a[1:], a[:-1]) for a in self._along], indexing="ij"), axis=0)
        self._inner = self._r[:, 1:-1, 1:-1, 1:-1]
        self._start = self._inner.copy()
        self._gradient, self._work = np.empty_like(self._r), np.empty((6, 4, 3))
        self._least = 0.0

    def _value(self, delta: float, moves: np.ndarray, slope: np.ndarray) -> float:
        """The functional and its slope after (3 n,) moves; keeps the least determinant of a corner."""
        self._inner[...] = self._start + self._scale * moves.reshape(self._start.shape)
        value, self._least = kernels.functional(self._r, *self._along, delta, self._work, self._gradient)
        np.multiply(self._scale, self._gradient[:, 1:-1, 1:-1, 1:-1], out=slope.reshape(self._start.shape))
        return value

    def unfolded(self, progress: Progress) -> np.ndarray:
        """The points, unfolded under ever steeper barriers and then smoothed; as they were if that fails."""
        moves, slope = np.zeros((2, self._start.size))
        self._value(1.0, moves, slope)
        widths = [max(0.5, -self._least)]  # a sound corner spans about 1 in these units
        for number in range(_ROUNDS):
            advance(progress, number / _ROUNDS, "unfolding cells")
            moves = minimised(partial(self._value, widths[-1]), moves, most=_ITERATIONS)
            if self._least > 0:
                break
            widths.append(max(0.5 * widths[-1], -_SOFT * self._least))
            if len(widths) > _IN_VAIN and widths[-1] > _SLOW * widths[-1 - _IN_VAIN]:
                return self._points
        else:
            return self._points
        minimised(partial(self._value, 0.5 * widths[-1]), moves, most=_ITERATIONS)
        if not self._least > 0:
            self._value(1.0, moves, slope)
        found = self._points.copy()
        found[1:-1, 1:-1, 1:-1] = self._low + self._size * np.moveaxis(self._inner, 0, -1)
        return found
