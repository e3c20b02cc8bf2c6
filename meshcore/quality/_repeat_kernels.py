"""Kernels that find what is there twice: points at one place, by a hash table; points that no cell uses."""

import numpy as np

from .._numba import kernel

U = np.uint64
_MIX = np.uint64(0x9E3779B97F4A7C15)
_MINUS_ZERO = np.uint64(1 << 63)
_ZERO = np.uint64(0)


@kernel
def repeated_points(bits, shift, table, repeated):
    """Mark points whose coordinates, as 64-bit patterns, stand more than once; return how many repeat earlier ones.

    ``table``, filled with -1, has 2^(64 - shift) places, at least twice as many as there are points; collisions go to
    the next place. The hash is Fibonacci's (Knuth, The Art of Computer Programming 3, section 6.4).
    """
    last = U(len(table) - 1)
    count = 0
    for i in range(len(bits)):
        x = bits[U(i), U(0)]
        y = bits[U(i), U(1)]
        z = bits[U(i), U(2)]
        x = _ZERO if x == _MINUS_ZERO else x
        y = _ZERO if y == _MINUS_ZERO else y
        z = _ZERO if z == _MINUS_ZERO else z
        key = (x * _MIX) ^ (x >> U(29))
        key = ((key ^ y) * _MIX) ^ (y >> U(31))
        key = ((key ^ z) * _MIX) ^ (key >> U(32))
        at = (key * _MIX) >> U(shift)
        while table[at] >= 0:
            j = table[at]
            u = bits[U(j), U(0)]
            v = bits[U(j), U(1)]
            w = bits[U(j), U(2)]
            u = _ZERO if u == _MINUS_ZERO else u
            v = _ZERO if v == _MINUS_ZERO else v
            w = _ZERO if w == _MINUS_ZERO else w
            if u == x and v == y and w == z:
                count += 1
                repeated[U(i)] = True
                repeated[U(j)] = True
                break
            at = (at + U(1)) & last
        if table[at] < 0:
            table[at] = i
    return count


@kernel
def mark_used(cells, used):
    """Mark the points of cells."""
    for t in range(cells.shape[0]):
        for k in range(cells.shape[1]):
            used[U(cells[U(t), U(k)])] = True


@kernel
def cells_along(cells, corners, n, starts, wanted, owner, first):
    """For each wanted directed edge, key ``n from + to`` in increasing order, write a cell that runs along it.

    ``starts`` marks the points that wanted edges leave from, so that few cells need a search.
    """
    for t in range(len(cells)):
        before = cells[U(t), U(corners - 1)]
        for k in range(corners):
            here = cells[U(t), U(k)]
            if starts[U(before)]:
                key = n * before + here
                low = 0
                high = len(wanted)
                while low < high:
                    middle = (low + high) >> 1
                    if wanted[U(middle)] < key:
                        low = middle + 1
                    else:
                        high = middle
                if low < len(wanted) and wanted[U(low)] == key:
                    owner[U(low)] = first + t
            before = here
