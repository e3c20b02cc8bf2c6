"""Kernels that write tetrahedra in a canonical order, which depends on the set of cells only, in linear time.

A cell's corners are ranked by their place along the Hilbert curve. The corner of highest rank comes first, of the
others the lowest, and the cell stays positive. Cells are sorted by their first corner, as buckets, then by the second
and third: two cells never share an oriented facet, so this is an order. Most cells are made along the curve, too, so
that the writes to the buckets stay near each other.
"""

import numpy as np

from .._numba import kernel
from ._tetrahedra_kernels import U

_LARGE_BUCKET = 40


@kernel(inline=True)
def canonical(cells, rank, t):
    """The ranks of the corners of cell t in canonical order."""
    a, b, c, d = (
        np.int64(cells[U(16 * t)]),
        np.int64(cells[U(16 * t + 1)]),
        np.int64(cells[U(16 * t + 2)]),
        np.int64(cells[U(16 * t + 3)]),
    )
    if len(rank) > 0:
        a, b, c, d = np.int64(rank[U(a)]), np.int64(rank[U(b)]), np.int64(rank[U(c)]), np.int64(rank[U(d)])
    # Swapping two pairs keeps the orientation, and so does rotating three.
    if a < b or a < c or a < d:
        if b > c and b > d:
            a, b, c, d = b, a, d, c
        elif c > d:
            a, b, c, d = c, d, a, b
        else:
            a, b, c, d = d, c, b, a
    if c < b and c < d:
        b, c, d = c, d, b
    elif d < b:
        b, c, d = d, b, c
    return a, b, c, d


@kernel
def count_cells(cells, n_cells, rank, starts):
    """Write where the bucket of each first corner starts; return the number of finite cells."""
    starts[:] = 0
    for t in range(n_cells):
        if cells[U(16 * t)] >= 0 and cells[U(16 * t + 3)] >= 0:
            a, _, _, _ = canonical(cells, rank, t)
            starts[U(a + 1)] += 1
    for k in range(1, len(starts)):
        starts[U(k)] += starts[U(k - 1)]
    return starts[len(starts) - 1]


@kernel
def fill_buckets(cells, n_cells, rank, starts, corners):
    """Write the canonical corners, four a cell, into their buckets; afterwards each start is the end of its bucket."""
    for t in range(n_cells):
        if cells[U(16 * t)] >= 0 and cells[U(16 * t + 3)] >= 0:
            a, b, c, d = canonical(cells, rank, t)
            at = 4 * np.int64(starts[U(a)])
            starts[U(a)] += 1
            corners[U(at)], corners[U(at + 1)], corners[U(at + 2)], corners[U(at + 3)] = a, b, c, d


@kernel
def sort_buckets(starts, corners, first, last):
    """Sort the cells of some buckets, whose ends are in ``starts``, by their second and third corner.

    Shell's sort with the gaps 3 k + 1, which for the usual bucket of a few cells is insertion; a vertex may have
    millions.
    """
    for bucket in range(first, last):
        low = np.int64(starts[U(bucket - 1)]) if bucket > 0 else 0
        high = np.int64(starts[U(bucket)])
        gap = 1
        while high - low > _LARGE_BUCKET and 9 * gap < high - low:
            gap = 3 * gap + 1
        while gap > 0:
            for i in range(low + gap, high):
                b, c, d = corners[U(4 * i + 1)], corners[U(4 * i + 2)], corners[U(4 * i + 3)]
                j = i - gap
                while j >= low:
                    second = corners[U(4 * j + 1)]
                    if second < b or (second == b and corners[U(4 * j + 2)] < c):
                        break
                    for k in range(1, 4):
                        corners[U(4 * (j + gap) + k)] = corners[U(4 * j + k)]
                    j -= gap
                at = 4 * (j + gap)
                corners[U(at + 1)], corners[U(at + 2)], corners[U(at + 3)] = b, c, d
            gap //= 3


@kernel
def write_rows(corners, row_of_rank, rows, first, last):
    """Write the caller's rows of some cells' corners."""
    for i in range(4 * first, 4 * last):
        rows[U(i)] = row_of_rank[U(corners[U(i)])]


@kernel
def number_of(cells, t, rank, starts, corners):
    """The canonical number of a finite cell."""
    a, b, c, _ = canonical(cells, rank, t)
    low = np.int64(starts[U(a - 1)]) if a > 0 else 0
    high = np.int64(starts[U(a)])
    while low < high:
        middle = (low + high) // 2
        second = corners[U(4 * middle + 1)]
        if second < b or (second == b and corners[U(4 * middle + 2)] < c):
            low = middle + 1
        else:
            high = middle
    return low
