"""The order in which points are inserted into a triangulation: along a Hilbert curve, equal points merged."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from ..progress import Progress, advance, silent
from . import _insertion_order_kernels as kernels

# With at least 2^4 cells of the curve a point few share a cell: then two passes of the sort do instead of three.
_SHORT_KEYS_UP_TO = 1 << (kernels.SHORT_KEY_BITS - 4)
_LONG_KEY_BITS = {2: 32, 3: 30}
_POINTS_IN_FIRST_ROUND = 1000
_POINTS_A_CHUNK = 1_000_000


@dataclass(frozen=True)
class InsertionOrder:
    """Different points in the order of their insertion.

    Attributes
    ----------
    rows : (k,) int32
        Row of each point among the caller's.
    coordinates : (dimension * k,) float
        x, y (, z) of each.
    merged : (d,) int64
        Rows that are left out, since another point is at the same place; ascending.
    kept : (d,) int64
        For each of them the row that stays: the lowest at its place.
    """

    rows: np.ndarray
    coordinates: np.ndarray
    merged: np.ndarray
    kept: np.ndarray


@functools.cache
def curve_table(dimension: int) -> np.ndarray:
    """(k,) int32: how a Hilbert curve turns, for the kernels; not to be written to."""
    table = np.empty(kernels.TABLE_SIZE, np.int32)
    kernels.fill_curve_table(dimension, table)
    return table


def insertion_order(points: np.ndarray, dimension: int, *, rounds: bool, progress: Progress = silent) -> InsertionOrder:
    """Order points along a Hilbert curve, so that each is inserted near the one before.

    The order depends on the coordinates and the rows only, not on the platform.

    Parameters
    ----------
    points : (n, 2) or (n, 3) float
        Finite, C-contiguous, safe for the predicates (`predicates.rescaled`); n below 2^31.
    dimension : int
        2 to look at x and y only, 3 for all.
    rounds : bool
        Whether the points are dealt at random into rounds of growing size, each along the curve (a biased randomised
        insertion order): slower for uniform points, but safe against bad ones.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    InsertionOrder

    References
    ----------
    N. Amenta, S. Choi, G. Rote, "Incremental constructions con BRIO", Proc. 19th Symp. Computational Geometry (2003).

    Examples
    --------
    >>> corners = np.array([[0.0, 0.0], [1.0, 1.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]])
    >>> found = insertion_order(corners, 2, rounds=False)
    >>> found.rows, found.merged, found.kept
    (array([0, 2, 1, 3], dtype=int32), array([4]), array([1]))
    """
    n = len(points)
    if n == 0:
        return InsertionOrder(np.empty(0, np.int32), np.empty(0), np.empty(0, np.int64), np.empty(0, np.int64))
    table = curve_table(dimension)
    key_bits = kernels.SHORT_KEY_BITS if n <= _SHORT_KEYS_UP_TO else _LONG_KEY_BITS[dimension]
    packed, other = np.empty((2, n), np.uint64)
    counts, box = np.empty(kernels.COUNTERS, np.int64), np.empty(4)
    kernels.number_rows(points, dimension, packed, box)
    for start in range(0, n, _POINTS_A_CHUNK):
        advance(progress, 0.5 * start / n, "sorting points")
        kernels.set_keys(points, dimension, box, table, key_bits, packed, start, min(n, start + _POINTS_A_CHUNK))
    stack = np.empty(2 * (n // kernels.LONG_RUN + 1), np.int32)
    n_merged = kernels.sort_and_merge(points, dimension, table, key_bits, packed, other, counts, box, stack)
    merged = kept = np.empty(0, np.int64)
    if n_merged:
        pairs = np.sort(other[:n_merged])
        merged, kept = (pairs >> np.uint64(32)).astype(np.int64), (pairs & np.uint64(0xFFFFFFFF)).astype(np.int64)
    advance(progress, 0.9, "sorting points")
    rows = np.empty(n - n_merged, np.int32)
    last_round = max(0, (n // _POINTS_IN_FIRST_ROUND).bit_length()) if rounds else 0
    coordinates = np.empty(dimension * len(rows))
    kernels.write_order(points, dimension, packed, last_round, np.empty(last_round + 2, np.int64), rows, coordinates)
    return InsertionOrder(rows, coordinates, merged, kept)
