"""Kernels shared by all planar triangulations: the half-edge layout, its flags, flips, faces and export.

Layout
------
Half-edge ``e = 4 t + k`` (k = 0, 1, 2) runs from ``origin[e]`` to ``origin[next_edge(e)]``, counter-clockwise around
triangle t; ``twin[e]`` is the same edge seen from the neighbour, or -1 where the neighbour was carved away. The
infinite vertex is -1: a triangle with it is a ghost beyond an edge of the convex hull. The fourth word of each record
is used too, so that a triangle's data lie in one cache line: ``origin[4 t + 3]`` holds the flags below,
``twin[4 t + 3]`` a stamp that grows with every reuse of the slot, so that a stale queue entry is known as such.
Subscripts are cast to unsigned, which spares numba's test for negative ones.
"""

import numpy as np

from .._numba import kernel
from ..geometry._predicates_kernels import INCIRCLE_BOUND, ORIENT2D_BOUND, incircle_exact, orient2d_exact

# Flags: bit k marks half-edge k as constrained, bit 3 the triangle as dead, bit 4 + k half-edge k as unsplittable.
CONSTRAINED = 7
DEAD = 8

# What a kernel that works in steps answers: finished, call again, a buffer must grow first, impossible state.
DONE, MORE, FULL, FAILED = 0, 1, 2, 3

U = np.uint64

# A little above the bound for the permanent itself, for the rounding of what stands in its place.
CIRCLE_BOUND = INCIRCLE_BOUND * (1 + 2.0**-40)


@kernel(inline=True)
def next_edge(e):
    """The half-edge after e in its triangle."""
    return e - 2 if (e & 3) == 2 else e + 1


@kernel(inline=True)
def previous_edge(e):
    """The half-edge before e in its triangle."""
    return e + 2 if (e & 3) == 0 else e - 1


@kernel(inline=True)
def is_constrained(origin, e):
    """1 if e lies on a segment."""
    return (origin[U(e | 3)] >> (e & 3)) & 1


@kernel(inline=True)
def side_of(ax, ay, bx, by, qx, qy, work):
    """Positive if q is left of the line from a to b, negative if right, zero if on it; exact."""
    left = (ax - qx) * (by - qy)
    right = (ay - qy) * (bx - qx)
    det = left - right
    if abs(det) > ORIENT2D_BOUND * (abs(left) + abs(right)):
        return det
    return orient2d_exact(ax, ay, bx, by, qx, qy, work)


@kernel(inline=True)
def circle_side(ax, ay, bx, by, cx, cy, qx, qy, work):
    """Positive if q is inside the circle of counter-clockwise a, b, c, negative if outside, zero if on it; exact."""
    adx = ax - qx
    ady = ay - qy
    bdx = bx - qx
    bdy = by - qy
    cdx = cx - qx
    cdy = cy - qy
    bc = bdx * cdy
    cb = cdx * bdy
    ca = cdx * ady
    ac = adx * cdy
    ab = adx * bdy
    ba = bdx * ady
    al = adx * adx + ady * ady
    bl = bdx * bdx + bdy * bdy
    cl = cdx * cdx + cdy * cdy
    det = al * (bc - cb) + bl * (ca - ac) + cl * (ab - ba)
    # At least the permanent: |bx cy| + |cx by| <= |b| |c| <= (bl + cl) / 2 by Cauchy and Schwarz, and so on.
    if abs(det) > CIRCLE_BOUND * (al * bl + cl * (al + bl)):
        return det
    return incircle_exact(ax, ay, bx, by, cx, cy, qx, qy, work)


@kernel
def exact_side(xy, a, b, q, work):
    """`side_of` for vertices, where its filter has failed."""
    return orient2d_exact(
        xy[U(2 * a)], xy[U(2 * a + 1)], xy[U(2 * b)], xy[U(2 * b + 1)], xy[U(2 * q)], xy[U(2 * q + 1)], work
    )


@kernel
def circle_tie(xy, order, a, b, c, q, work):
    """Whether vertex q counts as inside (1) or outside (-1) the circle through a, b, c that it lies on.

    Vertex v is lifted to |v|^2 + eps^(order[v] + 1), eps smaller than anything, so that the lowest number decides. The
    determinant is linear in the lifts; the coefficient of each is the orientation of the three others, which is never
    zero on a circle (Edelsbrunner and Muecke 1990; Devillers and Teillaud 2011). The answer depends on the points and
    their numbers only, not on the order of insertion.
    """
    i = order[U(a)]
    j = order[U(b)]
    k = order[U(c)]
    lowest = min(i, j, k)
    if order[U(q)] < lowest:
        return -1.0
    if i == lowest:
        u, v = b, c
    elif j == lowest:
        u, v = c, a
    else:
        u, v = a, b
    return side_of(xy[U(2 * u)], xy[U(2 * u + 1)], xy[U(2 * v)], xy[U(2 * v + 1)], xy[U(2 * q)], xy[U(2 * q + 1)], work)


@kernel
def perturbed_circle_side(xy, order, a, b, c, q, work):
    """`circle_side` for vertices, where its filter has failed; never zero: ties are broken by `circle_tie`."""
    side = incircle_exact(
        xy[U(2 * a)], xy[U(2 * a + 1)], xy[U(2 * b)], xy[U(2 * b + 1)], xy[U(2 * c)], xy[U(2 * c + 1)],
        xy[U(2 * q)], xy[U(2 * q + 1)], work,
    )  # fmt: skip
    return side if side != 0.0 else circle_tie(xy, order, a, b, c, q, work)


@kernel
def set_constrained(origin, e, value):
    """Set or clear the mark of one half-edge."""
    if value:
        origin[U(e | 3)] |= np.int32(1 << (e & 3))
    else:
        origin[U(e | 3)] &= np.int32(~(1 << (e & 3)))


@kernel
def flip(origin, twin, piece_of, vertex_edge, e):
    """Turn the edge e = (u, w) of triangles (u, w, p) and (w, u, v) into (v, p).

    Afterwards e runs u -> v, next_edge(e) is v -> p, twin e runs w -> p and its next is p -> v.
    """
    f = int(twin[U(e)])
    e1 = next_edge(e)
    e2 = previous_edge(e)
    f1 = next_edge(f)
    f2 = previous_edge(f)
    p = origin[U(e2)]
    v = origin[U(f2)]
    beyond_e = int(twin[U(f1)])
    beyond_f = int(twin[U(e1)])
    mark_e = is_constrained(origin, f1)
    mark_f = is_constrained(origin, e1)
    piece_e = piece_of[U(f1)]
    piece_f = piece_of[U(e1)]
    origin[U(e1)] = v
    origin[U(f1)] = p
    twin[U(e)] = beyond_e
    if beyond_e >= 0:
        twin[U(beyond_e)] = e
    twin[U(f)] = beyond_f
    if beyond_f >= 0:
        twin[U(beyond_f)] = f
    twin[U(e1)] = f1
    twin[U(f1)] = e1
    set_constrained(origin, e, mark_e)
    set_constrained(origin, f, mark_f)
    set_constrained(origin, e1, 0)
    set_constrained(origin, f1, 0)
    piece_of[U(e)] = piece_e
    piece_of[U(f)] = piece_f
    # The infinite vertex -1 has its entry in the last place, by numpy's own meaning of -1.
    vertex_edge[origin[U(e)]] = e
    vertex_edge[origin[U(f)]] = f
    vertex_edge[p] = e2
    vertex_edge[v] = f2


@kernel
def label_faces(origin, twin, n_triangles, face, stack):
    """Number the parts of the plane that segments separate; ghosts, and all that joins them, are face 0."""
    count = 0
    for t in range(n_triangles):
        face[U(t)] = -1
    for round_ in range(2):
        for first in range(n_triangles):
            if face[U(first)] >= 0:
                continue
            e = 4 * first
            ghost = origin[U(e)] < 0 or origin[U(e + 1)] < 0 or origin[U(e + 2)] < 0
            if round_ == 0 and not ghost:
                continue
            face[U(first)] = count
            stack[0] = first
            depth = 1
            while depth > 0:
                depth -= 1
                t = int(stack[U(depth)])
                for k in range(3):
                    other = int(twin[U(4 * t + k)]) >> 2
                    if face[U(other)] < 0 and is_constrained(origin, 4 * t + k) == 0:
                        face[U(other)] = count
                        stack[U(depth)] = other
                        depth += 1
            count += 1
    return count


@kernel
def carve(origin, twin, n_triangles, face, keep, free):
    """Kill the triangles of faces that are not kept; fill the list of free slots and return its length."""
    n_free = 0
    for t in range(n_triangles):
        e = 4 * t
        twin[U(e + 3)] = 0
        if keep[U(face[U(t)])]:
            continue
        origin[U(e + 3)] |= np.int32(DEAD)
        free[U(n_free)] = t
        n_free += 1
    for t in range(n_triangles):
        if keep[U(face[U(t)])]:
            for k in range(3):
                if not keep[U(face[U(int(twin[U(4 * t + k)]) >> 2)])]:
                    twin[U(4 * t + k)] = -1
    return n_free


@kernel
def live_triangles(origin, n_triangles, corners, slots):
    """Corners and slots of the triangles that are neither dead nor ghosts; return how many."""
    count = 0
    for t in range(n_triangles):
        a = origin[U(4 * t)]
        b = origin[U(4 * t + 1)]
        c = origin[U(4 * t + 2)]
        if (a | b | c) >= 0 and (origin[U(4 * t + 3)] & DEAD) == 0:
            corners[U(count), 0] = a
            corners[U(count), 1] = b
            corners[U(count), 2] = c
            slots[U(count)] = t
            count += 1
    return count
