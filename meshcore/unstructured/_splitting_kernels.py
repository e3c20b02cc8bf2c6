"""Kernels that say where a piece of a segment is split: in its middle, or at round distances from an acute corner.

References
----------
J. Ruppert, "A Delaunay refinement algorithm for quality 2-dimensional mesh generation", J. Algorithms 18 (1995),
section 7: concentric shells.
"""

import math

from .._numba import kernel
from ._half_edge_kernels import CONSTRAINED, DEAD, U, is_constrained, next_edge, previous_edge

# The cosine of 60 degrees, and a little more: angles of 60 degrees up to rounding are not acute.
_HALF = 0.5 + 1e-15


@kernel
def roundest(low, high):
    """The multiple of the largest power of two that lies between two positive numbers."""
    _, exponent = math.frexp(high)
    step = math.ldexp(0.5, exponent)
    while math.floor(high / step) * step < low:
        step *= 0.5
    return math.floor(high / step) * step


@kernel
def split_distance(x, y):
    """Where to split what lies between distances x and y from an acute vertex: a round number near the middle.

    Round numbers generalise the concentric shells: lines around the vertex get their points at equal distances all
    along, not only at the innermost, so that points on one line do not call for ever more points on its neighbour.
    """
    return roundest(x + 0.3 * (y - x), y - 0.3 * (y - x))


@kernel
def split_place(xy, a, b, p, q, acute_p, acute_q):
    """Coordinates of the point that splits the part from a to b of the piece from p to q."""
    ax = xy[U(2 * a)]
    ay = xy[U(2 * a + 1)]
    bx = xy[U(2 * b)]
    by = xy[U(2 * b + 1)]
    if not (acute_p or acute_q):
        return ax + 0.5 * (bx - ax), ay + 0.5 * (by - ay)
    px = xy[U(2 * p)]
    py = xy[U(2 * p + 1)]
    qx = xy[U(2 * q)]
    qy = xy[U(2 * q + 1)]
    length = math.sqrt((qx - px) ** 2 + (qy - py) ** 2)
    near = math.sqrt((ax - px) ** 2 + (ay - py) ** 2)
    far = math.sqrt((bx - px) ** 2 + (by - py) ** 2)
    if acute_p and acute_q:
        # The first split parts the piece between its ends; each half is measured from its own.
        acute_p = 0.5 * (near + far) < split_distance(0.0, length)
    if not acute_p:
        px, py, qx, qy = qx, qy, px, py
        near = math.sqrt((ax - px) ** 2 + (ay - py) ** 2)
        far = math.sqrt((bx - px) ** 2 + (by - py) ** 2)
    share = split_distance(min(near, far), max(near, far)) / length
    return px + share * (qx - px), py + share * (qy - py)


@kernel
def mark_acute(xy, origin, twin, n_triangles, acute):
    """Write 1 for vertices where two pieces meet at less than 60 degrees in live triangles, 0 for others."""
    acute[:] = 0
    for t in range(n_triangles):
        if origin[U(4 * t + 3)] & DEAD or origin[U(4 * t + 3)] & CONSTRAINED == 0:
            continue
        for start in range(4 * t, 4 * t + 3):
            v = int(origin[U(start)])
            w = int(origin[U(next_edge(start))])
            if is_constrained(origin, start) == 0 or acute[U(v)]:
                continue
            ux = xy[U(2 * w)] - xy[U(2 * v)]
            uy = xy[U(2 * w + 1)] - xy[U(2 * v + 1)]
            # Counter-clockwise to the next piece, within half a turn and within what is meshed.
            e = start
            while True:
                g = previous_edge(e)
                x = int(origin[U(g)])
                if x < 0:
                    break
                vx = xy[U(2 * x)] - xy[U(2 * v)]
                vy = xy[U(2 * x + 1)] - xy[U(2 * v + 1)]
                if ux * vy - uy * vx <= 0.0:
                    break
                if is_constrained(origin, g):
                    if ux * vx + uy * vy > _HALF * math.sqrt(ux * ux + uy * uy) * math.sqrt(vx * vx + vy * vy):
                        acute[U(v)] = 1
                    break
                e = int(twin[U(g)])


@kernel
def mark_ends(pieces, others, ends, stands_on):
    """Write the one number for vertices where pieces end, the other for the rest."""
    stands_on[:] = others
    for p in range(len(pieces)):
        stands_on[U(pieces[U(p), U(0)])] = ends
        stands_on[U(pieces[U(p), U(1)])] = ends
