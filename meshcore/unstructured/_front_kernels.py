"""Kernels that place points by an advancing front inside a Delaunay triangulation.

A triangle is accepted if its circumradius is small for the length wanted there. Of the others, those next to an
accepted one or to a segment are active; the one that is largest for the length wanted goes first. Its point stands on
the bisector of the edge to the accepted side, where it makes a triangle of the wanted radius, but not beyond the centre
of the circle through the edge that touches the circumcircle (Rebay 1993, equations 2-4), so that the front
closes in good order where it meets itself.

References
----------
S. Rebay, "Efficient unstructured mesh generation by means of Delaunay triangulation and Bowyer-Watson algorithm",
J. Comput. Phys. 106 (1993). P. J. Frey, H. Borouchaki, P. L. George, "3D Delaunay mesh generation coupled with an
advancing-front approach", Comput. Methods Appl. Mech. Eng. 157 (1998).
"""

import math

import numpy as np

from .._numba import kernel
from ._bucket_queue_kernels import QUEUE_STATE, QUEUED, empty_queue, pop, push
from ._half_edge_kernels import DEAD, DONE, FULL, MORE, U, is_constrained, next_edge, previous_edge
from ._point_insertion_kernels import dig, fill, look_across, walk
from ._refinement_kernels import sees_wide

# Places in the state shared by the kernels of this file, after those of the queue.
TRIANGLES, VERTICES, FREE, PENDING, REJECTED = range(QUEUE_STATE, QUEUE_STATE + 5)
STATE_SIZE = QUEUE_STATE + 5
# Buckets by the squared ratio of radii, so many to the octave.
BUCKETS = 1024
PER_OCTAVE = 32
# Flag of triangles that are small enough; the kernels of this file set it, `forget` clears it.
ACCEPTED_TRIANGLE = 128
# What of `rules`: squared largest radius of an accepted triangle, per squared wanted length; squared least distance of
# a new point from old ones, likewise; growth of the length a unit of distance; squared cosine of the lens of a segment.
ACCEPTED, NEAREST, GROWTH, LENS = range(4)


@kernel(inline=True)
def excess(slot, xy, origin, wanted):
    """Squared circumradius of a triangle per squared length wanted there: a numerator and a denominator."""
    a = int(origin[U(slot)])
    b = int(origin[U(slot + 1)])
    c = int(origin[U(slot + 2)])
    ax = xy[U(2 * a)]
    ay = xy[U(2 * a + 1)]
    bx = xy[U(2 * b)] - ax
    by = xy[U(2 * b + 1)] - ay
    cx = xy[U(2 * c)] - ax
    cy = xy[U(2 * c + 1)] - ay
    edges2 = (bx * bx + by * by) * (cx * cx + cy * cy) * ((cx - bx) * (cx - bx) + (cy - by) * (cy - by))
    double_area = bx * cy - by * cx
    length = (wanted[U(a)] + wanted[U(b)] + wanted[U(c)]) / 3.0
    return edges2, (2.0 * double_area * length) ** 2


@kernel(inline=True)
def queue_if_large(slot, xy, origin, twin, wanted, accepted, queue, head, tail, state):
    """Queue a triangle that is not accepted; or, if it is, the one across its first edge."""
    radius2, length2 = excess(slot, xy, origin, wanted)
    if radius2 <= accepted * length2:
        origin[U(slot + 3)] |= np.int32(ACCEPTED_TRIANGLE)
        if is_constrained(origin, slot):
            return
        slot = int(twin[U(slot)]) & ~3
        if origin[U(slot + 3)] & ACCEPTED_TRIANGLE:
            return
        radius2, length2 = excess(slot, xy, origin, wanted)
        if radius2 <= accepted * length2:
            return
    bucket = BUCKETS - 1
    if radius2 < 1e30 * length2:
        mantissa, exponent = math.frexp(radius2 / (accepted * length2))
        bucket = min(max(PER_OCTAVE * (exponent - 1) + int(PER_OCTAVE * (2.0 * mantissa - 1.0)), 0), BUCKETS - 1)
    push(bucket, slot, twin[U(slot + 3)], queue, head, tail, state)


@kernel
def queue_all(xy, origin, twin, wanted, accepted, queue, head, tail, state):
    """Empty the queues and look at every live triangle anew; there must be room for one entry each."""
    empty_queue(head, state)
    state[PENDING] = 0
    for t in range(state[TRIANGLES]):
        if origin[U(4 * t + 3)] & DEAD == 0:
            queue_if_large(4 * t, xy, origin, twin, wanted, accepted, queue, head, tail, state)


@kernel
def forget(origin, n_triangles):
    """Clear the flags of this file."""
    for t in range(n_triangles):
        origin[U(4 * t + 3)] &= np.int32(~ACCEPTED_TRIANGLE)


@kernel
def length_at(start, qx, qy, ground_xy, ground_origin, ground_twin, ground_length):
    """The length at q, interpolated linearly on the background; and the background's triangle.

    A walk without exact signs: it must only end, in the right triangle or beside it.
    """
    slot = start
    entered = -1
    for _ in range(10_000):
        a = int(ground_origin[U(slot)])
        b = int(ground_origin[U(slot + 1)])
        c = int(ground_origin[U(slot + 2)])
        ax = ground_xy[U(2 * a)] - qx
        ay = ground_xy[U(2 * a + 1)] - qy
        bx = ground_xy[U(2 * b)] - qx
        by = ground_xy[U(2 * b + 1)] - qy
        cx = ground_xy[U(2 * c)] - qx
        cy = ground_xy[U(2 * c + 1)] - qy
        at_c = ax * by - ay * bx
        at_a = bx * cy - by * cx
        at_b = cx * ay - cy * ax
        out = -1
        if at_c < 0.0 and slot != entered:
            out = slot
        if at_a < 0.0 and slot + 1 != entered and (out < 0 or at_a < at_c):
            out = slot + 1
        if at_b < 0.0 and slot + 2 != entered and (out < 0 or at_b < min(at_a, at_c)):
            out = slot + 2
        f = -1
        if out >= 0:
            f = int(ground_twin[U(out)])
        if f < 0:
            at_a = max(at_a, 0.0)
            at_b = max(at_b, 0.0)
            at_c = max(at_c, 0.0)
            length = at_a * ground_length[U(a)] + at_b * ground_length[U(b)] + at_c * ground_length[U(c)]
            return length / (at_a + at_b + at_c), slot
        entered = f
        slot = f & ~3
    return ground_length[U(ground_origin[U(slot)])], slot


@kernel(inline=True)
def place(slot, xy, origin, twin, wanted):
    """Where the point of a large triangle stands, and its base edge; -1 if no side of it is accepted."""
    base = -1
    best = math.inf
    for k in range(3):
        e = slot + k
        if is_constrained(origin, e) == 0 and origin[U(int(twin[U(e)]) | 3)] & ACCEPTED_TRIANGLE == 0:
            continue
        a = int(origin[U(e)])
        b = int(origin[U(next_edge(e))])
        length2 = (xy[U(2 * b)] - xy[U(2 * a)]) ** 2 + (xy[U(2 * b + 1)] - xy[U(2 * a + 1)]) ** 2
        length = 0.5 * (wanted[U(a)] + wanted[U(b)])
        misfit = abs(length2 / (length * length) - 1.0)
        if misfit < best:
            best = misfit
            base = e
    if base < 0:
        return base, 0.0, 0.0
    a = int(origin[U(base)])
    b = int(origin[U(next_edge(base))])
    c = int(origin[U(previous_edge(base))])
    ax = xy[U(2 * a)]
    ay = xy[U(2 * a + 1)]
    ux = xy[U(2 * b)] - ax
    uy = xy[U(2 * b + 1)] - ay
    vx = xy[U(2 * c)] - ax
    vy = xy[U(2 * c + 1)] - ay
    u2 = ux * ux + uy * uy
    # Half the base, and the height of the circumcentre above it.
    edge = math.sqrt(u2)
    half = 0.5 * edge
    height = 0.5 * (vx * (vx - ux) + vy * (vy - uy)) * edge / (ux * vy - uy * vx)
    radius = max(0.5 * (wanted[U(a)] + wanted[U(b)]) / math.sqrt(3.0), half)
    if height > 0.0:
        radius = min(radius, (half * half + height * height) / (2.0 * height))
    above = (radius + math.sqrt(max(radius * radius - half * half, 0.0))) / edge
    return base, ax + 0.5 * ux - above * uy, ay + 0.5 * uy + above * ux


@kernel
def advance_front(
    xy, origin, twin, piece_of, face, wanted, limit_of_face, near, ground_xy, ground_origin, ground_twin, ground_length,
    queue, head, tail, free, cavity, stack, ring, ring_from, work, rules, state, steps,
):  # fmt: skip
    """Do up to ``steps`` insertions or rejections; ``state`` tells where to go on."""
    accepted = rules[ACCEPTED]
    pending = int(state[PENDING])
    for _ in range(steps):
        if (
            state[VERTICES] + 4 >= len(wanted)
            or 4 * state[TRIANGLES] + 64 >= len(origin)
            or 4 * (state[QUEUED] + pending + 8) >= len(queue)
        ):
            state[PENDING] = pending
            return FULL
        for k in range(pending):
            queue_if_large(int(cavity[U(k)]), xy, origin, twin, wanted, accepted, queue, head, tail, state)
        pending = 0
        entry = pop(queue, head, state)
        if entry < 0:
            state[PENDING] = 0
            return DONE
        asked = int(queue[U(entry)])
        if queue[U(entry + 1)] != twin[U(asked + 3)] or origin[U(asked + 3)] & DEAD:
            continue
        base, qx, qy = place(asked, xy, origin, twin, wanted)
        if base < 0:
            continue
        e, hit = walk(asked, qx, qy, xy, origin, twin, work)
        if hit >= 0:
            state[REJECTED] += 1
            continue
        depth = look_across(e & ~3, cavity, stack)
        n_cavity, n_ring = dig(depth, 1, 0, qx, qy, xy, origin, twin, cavity, stack, ring, ring_from, work)
        if n_ring < 0:
            cavity[0] = asked
            state[PENDING] = 1
            return FULL
        a = int(origin[U(base)])
        b = int(origin[U(next_edge(base))])
        length = min(
            wanted[U(a)] + rules[GROWTH] * math.sqrt((qx - xy[U(2 * a)]) ** 2 + (qy - xy[U(2 * a + 1)]) ** 2),
            wanted[U(b)] + rules[GROWTH] * math.sqrt((qx - xy[U(2 * b)]) ** 2 + (qy - xy[U(2 * b + 1)]) ** 2),
            limit_of_face[U(face[U(e >> 2)])],
        )
        ground = -1
        if len(ground_length):
            there, ground = length_at(near[U(a)], qx, qy, ground_xy, ground_origin, ground_twin, ground_length)
            length = min(length, there)
        nearest2 = rules[NEAREST] * length * length
        rejected = False
        for k in range(n_ring):
            a = int(ring_from[U(k)])
            if (xy[U(2 * a)] - qx) ** 2 + (xy[U(2 * a + 1)] - qy) ** 2 < nearest2:
                rejected = True
                break
            e = int(ring[U(k)])
            if is_constrained(origin, e):
                b = int(origin[U(next_edge(e))])
                if sees_wide(xy[U(2 * a)], xy[U(2 * a + 1)], xy[U(2 * b)], xy[U(2 * b + 1)], qx, qy, rules[LENS]):
                    rejected = True
                    break
        if rejected:
            state[REJECTED] += 1
            continue
        new = int(state[VERTICES])
        state[VERTICES] = new + 1
        xy[U(2 * new)] = qx
        xy[U(2 * new + 1)] = qy
        wanted[U(new)] = length
        near[U(new)] = ground
        for k in range(n_cavity, n_ring):
            if state[FREE] > 0:
                state[FREE] -= 1
                cavity[U(k)] = 4 * int(free[U(state[FREE])])
            else:
                cavity[U(k)] = 4 * state[TRIANGLES]
                state[TRIANGLES] += 1
        fill(new, n_ring, origin, twin, piece_of, face, cavity, stack, ring, ring_from)
        pending = n_ring
    state[PENDING] = pending
    return MORE
