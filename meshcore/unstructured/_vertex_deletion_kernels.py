"""Kernels that take a vertex out of a constrained Delaunay triangulation: its star is filled anew, ear by ear.

References
----------
O. Devillers, "On deletion in Delaunay triangulations", IJCGA 12 (2002): there is always an ear with an empty circle.
"""

from .._numba import kernel
from ._half_edge_kernels import DEAD, U, circle_side, next_edge, previous_edge, side_of


@kernel
def _is_ear(xy, polygon, m, i, work):
    """Whether corners i to i + 2 of a polygon of m, the last of four words each, make a triangle with empty circle."""
    a = int(polygon[U(4 * i + 3)])
    b = int(polygon[U(4 * ((i + 1) % m) + 3)])
    c = int(polygon[U(4 * ((i + 2) % m) + 3)])
    ax, ay = xy[U(2 * a)], xy[U(2 * a + 1)]
    bx, by = xy[U(2 * b)], xy[U(2 * b + 1)]
    cx, cy = xy[U(2 * c)], xy[U(2 * c + 1)]
    if side_of(ax, ay, bx, by, cx, cy, work) <= 0.0:
        return False
    for k in range(3, m):
        q = int(polygon[U(4 * ((i + k) % m) + 3)])
        if circle_side(ax, ay, bx, by, cx, cy, xy[U(2 * q)], xy[U(2 * q + 1)], work) > 0.0:
            return False
    return True


@kernel
def _find_ears(xy, polygon, m, ears, work):
    """List the ears that cut a polygon up, each by its first corner in what is left; False if there are none."""
    count = 0
    while m >= 3:
        i = 0
        while i < m and not _is_ear(xy, polygon, m, i, work):
            i += 1
        if i == m:
            return False
        ears[U(count)] = i
        count += 1
        m -= 1
        for k in range((i + 1) % (m + 1), m):
            polygon[U(4 * k + 3)] = polygon[U(4 * k + 7)]
    return True


@kernel
def _glue(origin, twin, piece_of, polygon, k, e):
    """Join the half-edge e to what lies beyond edge k of the polygon, with its marks."""
    f = int(polygon[U(4 * k)])
    bits = int(polygon[U(4 * k + 1)])
    twin[U(e)] = f
    if f >= 0:
        twin[U(f)] = e
    origin[U(e | 3)] |= bits << (e & 3)
    if bits:
        piece_of[U(e)] = polygon[U(4 * k + 2)]


@kernel
def delete_vertex(opposite, xy, origin, twin, piece_of, free, n_free, cavity, polygon, ears, corners, work):
    """Delete the vertex, inside and on no segment, that is the apex over the half-edge ``opposite``.

    ``cavity`` gets the slots of the new triangles. The answers are how many these are, and the half-edge in the place
    of ``opposite``. Nothing is changed, and 0 answered, if buffers are too small, or if segments hide parts of the star
    from each other. Two slots go to the end of the free ones. The stamps grow.
    """
    first = previous_edge(opposite)
    e = first
    n = 0
    at = 0
    while True:
        if n + 8 > len(cavity):
            return 0, opposite
        g = next_edge(e)
        flags = int(origin[U(g | 3)])
        cavity[U(n)] = e & ~3
        corners[U(n)] = origin[U(g)]
        polygon[U(4 * n)] = twin[U(g)]
        polygon[U(4 * n + 1)] = ((flags >> (g & 3)) & 1) | (((flags >> (4 + (g & 3))) & 1) << 4)
        polygon[U(4 * n + 2)] = piece_of[U(g)]
        polygon[U(4 * n + 3)] = origin[U(g)]
        at = n if g == opposite else at
        n += 1
        e = int(twin[U(previous_edge(e))])
        if e == first:
            break
    if not _find_ears(xy, polygon, n, ears, work):
        return 0, opposite
    m = n
    for j in range(n - 2):
        i = int(ears[U(j)])
        i1 = (i + 1) % m
        slot = int(cavity[U(j)])
        origin[U(slot)] = corners[U(i)]
        origin[U(slot + 1)] = corners[U(i1)]
        origin[U(slot + 2)] = corners[U((i + 2) % m)]
        origin[U(slot + 3)] = 0
        twin[U(slot + 3)] += 1
        for k in range(3 if m == 3 else 2):
            _glue(origin, twin, piece_of, polygon, (i + k) % m, slot + k)
            if (i + k) % m == at:
                opposite = slot + k
                at = -1
        polygon[U(4 * i)] = slot + 2
        polygon[U(4 * i + 1)] = 0
        m -= 1
        if at > i1:
            at -= 1
        for k in range(i1, m):
            corners[U(k)] = corners[U(k + 1)]
            for word in range(3):
                polygon[U(4 * k + word)] = polygon[U(4 * k + 4 + word)]
    for j in range(n - 2, n):
        slot = int(cavity[U(j)])
        origin[U(slot + 3)] = DEAD
        twin[U(slot + 3)] += 1
        free[U(n_free + j - n + 2)] = slot >> 2
    return n - 2, opposite
