"""Kernels that hand a triangulation out: which vertices are used, their numbers in the mesh, the cells by these."""

from .._numba import kernel
from ._half_edge_kernels import U

UNUSED, USED = -1, -2


@kernel
def mark_corners(corners, number):
    """Set the number of each vertex with a triangle from `UNUSED` to `USED`; return how many there are."""
    count = 0
    for t in range(len(corners)):
        for k in range(3):
            v = corners[U(t), U(k)]
            if number[U(v)] == UNUSED:
                number[U(v)] = USED
                count += 1
    return count


@kernel
def number_rest(xy, first, number, places):
    """Number the vertices that are `USED` from ``first`` on, and write their places."""
    count = 0
    for v in range(len(number)):
        if number[U(v)] == USED:
            number[U(v)] = first + count
            places[U(count), U(0)] = xy[U(v), U(0)]
            places[U(count), U(1)] = xy[U(v), U(1)]
            count += 1


@kernel
def renumber(corners, number, cells):
    """Write triangles by the numbers of their corners."""
    for t in range(len(corners)):
        for k in range(3):
            cells[U(t), U(k)] = number[U(corners[U(t), U(k)])]
