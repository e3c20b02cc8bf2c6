"""Kernels that find the cell of a triangulation of space in which a place lies, of several the lowest-numbered.

The layout of the cells is that of `_tetrahedra_kernels`, their numbers are those of `_tetrahedra_export_kernels`.
"""

import numpy as np

from .._numba import kernel
from ..geometry._predicates_kernels import orient3d
from ._tetrahedra_export_kernels import number_of
from ._tetrahedra_kernels import FACET_A, FACET_B, FACET_C, U


@kernel
def _side_of_facet(points, cells, t, k, x, y, z, work):
    """Exact side of a place: positive if it lies on the inner side of facet k of cell t, zero in its plane."""
    a = 4 * np.int64(cells[U(16 * t + FACET_A[U(k)])])
    b = 4 * np.int64(cells[U(16 * t + FACET_B[U(k)])])
    c = 4 * np.int64(cells[U(16 * t + FACET_C[U(k)])])
    return orient3d(
        x, y, z, points[U(a)], points[U(a + 1)], points[U(a + 2)], points[U(b)], points[U(b + 1)], points[U(b + 2)],
        points[U(c)], points[U(c + 1)], points[U(c + 2)], work,
    )  # fmt: skip


@kernel
def _walk(points, cells, t, x, y, z, work):
    """The finite cell that holds a place, or a ghost beyond whose facet it lies, by a walk from cell t."""
    came_by = -1
    while cells[U(16 * t + 3)] >= 0:
        k = 0
        while k < 4 and (k == came_by or not _side_of_facet(points, cells, t, k, x, y, z, work) < 0.0):
            k += 1
        if k == 4:
            break
        word = np.int64(cells[U(16 * t + 4 + k)])
        t = word >> 3
        came_by = word & 3
    return t


@kernel
def locate(points, cells, queries, order, start, hint, rank, starts, corners, marks, found, numbers, work):
    """Write the lowest number of the cells that hold each of some places, or -1 where none does.

    Parameters
    ----------
    queries : (k, 3) float
        Places, in the ``order`` in which they are looked for from ``start`` on; the first from a live cell ``hint``.
    marks : (number of cells,) int32
        Zero at first; a cell that was seen gets the place's number plus one.
    found : (m,) int32
        Scratch: the cells that hold a place, many if it is a vertex.
    numbers : (k,) int64
        Receives the numbers.

    Returns
    -------
    int
        How many places are done: fewer than there are if ``found`` was too short.
    """
    t = np.int64(hint)
    for i in range(start, len(order)):
        query = order[i]
        x, y, z = queries[query, 0], queries[query, 1], queries[query, 2]
        if cells[U(16 * t + 3)] < 0:
            t = np.int64(cells[U(16 * t + 7)]) >> 3
        t = _walk(points, cells, t, x, y, z, work)
        numbers[query] = -1
        if cells[U(16 * t + 3)] < 0:
            continue
        numbers[query] = number_of(cells, t, rank, starts, corners)
        marks[U(t)] = query + 1
        found[0] = t
        count = 1
        done = 0
        while done < count:
            s = np.int64(found[U(done)])
            done += 1
            for k in range(4):
                beyond = np.int64(cells[U(16 * s + 4 + k)]) >> 3
                if cells[U(16 * beyond + 3)] < 0 or marks[U(beyond)] == query + 1:
                    continue
                if _side_of_facet(points, cells, s, k, x, y, z, work) == 0.0:
                    if count == len(found):
                        return i
                    marks[U(beyond)] = query + 1
                    found[U(count)] = beyond
                    count += 1
                    numbers[query] = min(numbers[query], number_of(cells, beyond, rank, starts, corners))
    return len(order)
