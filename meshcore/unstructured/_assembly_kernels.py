"""Kernels over whole triangulations: how many triangles limits will make; used vertices numbered, cells by these."""

from .._numba import kernel
from ._half_edge_kernels import U

UNUSED, USED = -1, -2


@kernel
def areas_kept(xy, origin, n_triangles, face, keep, area_limit):
    """The area of the faces that are kept, and the sum of the shares of the limits, both of them twice the area."""
    total = 0.0
    shares = 0.0
    for t in range(n_triangles):
        a = origin[U(4 * t)]
        b = origin[U(4 * t + 1)]
        c = origin[U(4 * t + 2)]
        f = face[U(t)]
        if (a | b | c) >= 0 and keep[U(f)]:
            ax = xy[U(2 * a)]
            ay = xy[U(2 * a + 1)]
            area = (xy[U(2 * b)] - ax) * (xy[U(2 * c + 1)] - ay) - (xy[U(2 * b + 1)] - ay) * (xy[U(2 * c)] - ax)
            total += area
            shares += area / area_limit[U(f)]
    return total, shares


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
