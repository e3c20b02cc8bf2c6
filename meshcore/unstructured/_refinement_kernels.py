"""Kernels of quality refinement: queues of poor triangles, encroached pieces, and the insertion of one point a step.

The method is Ruppert's with Chew's lenses, Uengoer's off-centres, and Triangle's treatment of small input angles:

- a triangle is poor if it is too large, or if its smallest angle is too small; too large goes first, first in, first
  out, then too thin, the one with the shortest edge first;
- a piece of a segment is encroached by a point that sees it under more than 180 degrees minus twice the smallest angle
  (a lens inside the diametral circle); nothing is inserted that encroaches, the piece is split instead;
- before a piece is split, points that refinement has put into its diametral circle are taken out again: they are there
  for triangles that the split makes anew (Chew's second algorithm), but not near acute corners, as in Triangle;
- pieces that end at an acute input vertex are split at round distances from it, so that neighbours around the vertex
  agree (concentric shells, carried on along the whole piece);
- a thin triangle whose shortest edge joins two segments at equal distance from their common end stays: the input's own
  angle is to blame, and splitting would never end.

Whether a point is taken is decided before anything is changed, so a rejection leaves no trace.

References
----------
J. Ruppert, "A Delaunay refinement algorithm for quality 2-dimensional mesh generation", J. Algorithms 18 (1995).
L. P. Chew, "Guaranteed-quality mesh generation for curved surfaces", 9th ACM Symp. Comput. Geom. (1993).
J. R. Shewchuk, "Delaunay refinement algorithms for triangular mesh generation", Comput. Geom. 22 (2002).
G. L. Miller, S. E. Pav, N. J. Walkington, "When and why Delaunay refinement algorithms work", IJCGA 15 (2005).
A. Uengoer, "Off-centers: a new type of Steiner points", Comput. Geom. 42 (2009).
"""

import math

import numpy as np

from .._numba import kernel
from ._bucket_queue_kernels import QUEUE_STATE, QUEUED, empty_queue, pop, push
from ._half_edge_kernels import (
    CONSTRAINED,
    DEAD,
    DONE,
    FAILED,
    FULL,
    MORE,
    U,
    circle_side,
    is_constrained,
    next_edge,
    previous_edge,
    side_of,
)
from ._splitting_kernels import split_place
from ._vertex_deletion_kernels import delete_vertex

# Places in the state shared by the kernels of this file, after those of the queue.
STATE_SIZE = QUEUE_STATE + 9
TRIANGLES, VERTICES, FREE, ENCROACHED, PENDING, GIVEN_UP, UNSPLIT, SPLITS, INSERTIONS = range(QUEUE_STATE, STATE_SIZE)
# Queues: one for size, and one per quarter octave of the squared shortest edge.
BUCKETS = 2048
# Squared circumradius of an equilateral triangle, per twice its area.
TWICE_AREA_TO_RADIUS2 = 2.0 / (3.0 * math.sqrt(3.0))
# What a vertex stands on: nothing, an input vertex, else the piece of a segment.
FREE_VERTEX = -1
INPUT_VERTEX = -2


@kernel(inline=True)
def sees_wide(ax, ay, bx, by, qx, qy, lens2):
    """Whether q sees a and b under an angle whose cosine is at most -sqrt(lens2)."""
    ux = ax - qx
    uy = ay - qy
    vx = bx - qx
    vy = by - qy
    dot = ux * vx + uy * vy
    return dot < 0.0 and dot * dot >= lens2 * (ux * ux + uy * uy) * (vx * vx + vy * vy)


@kernel
def is_between_neighbours(xy, pieces, p, q, piece_p, piece_q):
    """Whether p and q stand on two pieces with a common end and equally far from it."""
    end = -1
    if pieces[U(piece_p), 0] == pieces[U(piece_q), 0] or pieces[U(piece_p), 0] == pieces[U(piece_q), 1]:
        end = int(pieces[U(piece_p), 0])
    elif pieces[U(piece_p), 1] == pieces[U(piece_q), 0] or pieces[U(piece_p), 1] == pieces[U(piece_q), 1]:
        end = int(pieces[U(piece_p), 1])
    if end < 0:
        return False
    x = xy[U(2 * end)]
    y = xy[U(2 * end + 1)]
    to_p = (xy[U(2 * p)] - x) ** 2 + (xy[U(2 * p + 1)] - y) ** 2
    to_q = (xy[U(2 * q)] - x) ** 2 + (xy[U(2 * q + 1)] - y) ** 2
    return 0.999 * to_q < to_p < 1.001 * to_q


@kernel(inline=True)
def queue_if_poor(
    t, xy, origin, twin, stands_on, pieces, face, edge_limit, area_limit, limits, queue, head, tail, encroached, state
):
    """Queue triangle t if it is poor, and its encroached pieces; the caller has made room."""
    cosine2 = limits[0]
    lens2 = limits[1]
    slot = 4 * t
    flags = int(origin[U(slot + 3)])
    a = int(origin[U(slot)])
    b = int(origin[U(slot + 1)])
    c = int(origin[U(slot + 2)])
    ax = xy[U(2 * a)]
    ay = xy[U(2 * a + 1)]
    bx = xy[U(2 * b)]
    by = xy[U(2 * b + 1)]
    cx = xy[U(2 * c)]
    cy = xy[U(2 * c + 1)]
    if flags & CONSTRAINED:
        for k in range(3):
            if (flags >> k) & 1 and (flags >> (4 + k)) & 1 == 0:
                ux, uy = (ax, ay) if k == 0 else ((bx, by) if k == 1 else (cx, cy))
                vx, vy = (bx, by) if k == 0 else ((cx, cy) if k == 1 else (ax, ay))
                wx, wy = (cx, cy) if k == 0 else ((ax, ay) if k == 1 else (bx, by))
                if sees_wide(ux, uy, vx, vy, wx, wy, lens2):
                    depth = state[ENCROACHED]
                    encroached[U(2 * depth)] = slot + k
                    encroached[U(2 * depth + 1)] = origin[U(slot + k)]
                    state[ENCROACHED] = depth + 1
    abx = bx - ax
    aby = by - ay
    bcx = cx - bx
    bcy = cy - by
    cax = ax - cx
    cay = ay - cy
    opposite_a = bcx * bcx + bcy * bcy
    opposite_b = cax * cax + cay * cay
    opposite_c = abx * abx + aby * aby
    if opposite_a <= opposite_b and opposite_a <= opposite_c:
        shortest, longest, other, p, q = opposite_a, opposite_b, opposite_c, b, c
    elif opposite_b <= opposite_c:
        shortest, longest, other, p, q = opposite_b, opposite_a, opposite_c, c, a
    else:
        shortest, longest, other, p, q = opposite_c, opposite_a, opposite_b, a, b
    area = abx * cay - aby * cax  # minus twice the area
    limit = limits[5]
    if limit < 0.0:
        limit = area_limit[U(face[U(t)])]
    longest2 = limits[3] if limits[4] != 0.0 else edge_limit[U(t)]
    too_large = max(longest, other) > longest2 or area * area > limit * limit
    poor = too_large
    if not poor:
        # Law of cosines at the corner between the two longer edges.
        numerator = longest + other - shortest
        poor = numerator > 0.0 and numerator * numerator > 4.0 * cosine2 * longest * other
        if poor:
            piece_p = int(stands_on[U(p)])
            piece_q = int(stands_on[U(q)])
            if piece_p >= 0 and piece_q >= 0 and piece_p != piece_q:
                poor = not is_between_neighbours(xy, pieces, p, q, piece_p, piece_q)
    if poor:
        bucket = BUCKETS - 1
        if limits[6] != 0.0:  # by the squared circumradius over the one wanted, the largest first
            wanted = min(longest2 / 3.0, limit * TWICE_AREA_TO_RADIUS2)
            if cosine2 < 1.0:
                wanted = min(wanted, shortest / (4.0 * (1.0 - cosine2)))
            mantissa, exponent = math.frexp(longest * other * shortest / (4.0 * area * area * wanted))
            bucket = min(max(BUCKETS // 2 + 4 * exponent + int(8.0 * mantissa), 0), BUCKETS - 1)
        elif not too_large:
            mantissa, exponent = math.frexp(shortest)
            bucket = min(max(64 - 4 * exponent - int(8.0 * mantissa), 0), BUCKETS - 2)
        push(bucket, slot, twin[U(slot + 3)], queue, head, tail, state)


@kernel
def queue_all(
    xy, origin, twin, stands_on, pieces, face, edge_limit, area_limit, limits, queue, head, tail, encroached, state
):
    """Empty the queues and look at every live triangle anew; there must be room for one entry each."""
    empty_queue(head, state)
    state[ENCROACHED] = 0
    state[PENDING] = 0
    for t in range(state[TRIANGLES]):
        if origin[U(4 * t + 3)] & DEAD == 0:
            queue_if_poor(
                t, xy, origin, twin, stands_on, pieces, face, edge_limit, area_limit, limits, queue, head, tail,
                encroached, state,
            )  # fmt: skip


@kernel
def refine(
    xy, origin, twin, piece_of, stands_on, pieces, acute, face, edge_limit, area_limit, limits, queue, head, tail,
    encroached, free, cavity, stack, ring, ring_from, work, state, steps,
):  # fmt: skip
    """Do up to ``steps`` insertions or rejections; ``state`` tells where to go on.

    ``limits`` holds the squared cosine of the smallest angle, the squared cosine of the lens, the off-centre's height
    per length of the shortest edge (0: circumcentres), the edge length of triangles yet to be judged, squared, whether
    that is the length for all, twice the largest area if it is the same in all faces, else -1, and whether the worst
    triangle goes first (the survey's order).
    """
    lens2 = limits[1]
    height = limits[2]
    unjudged = limits[3]
    uniform = limits[4] != 0.0
    room = len(ring) - 8
    pending = int(state[PENDING])
    for _ in range(steps):
        # Judge the triangles that the last step made, or the one it put back.
        if (
            state[VERTICES] + 4 >= len(stands_on)
            or 4 * state[TRIANGLES] + 64 >= len(origin)
            or 4 * (state[QUEUED] + pending + 8) >= len(queue)
            or 2 * (state[ENCROACHED] + 3 * pending + len(ring)) >= len(encroached)
        ):
            state[PENDING] = pending
            return FULL
        for k in range(pending):
            t = int(cavity[U(k)]) >> 2
            queue_if_poor(
                t, xy, origin, twin, stands_on, pieces, face, edge_limit, area_limit, limits,
                queue, head, tail, encroached, state,
            )  # fmt: skip
        pending = 0
        splitting = False
        own = -1
        behind = -1
        asked = -1
        start = -1
        qx = 0.0
        qy = 0.0
        piece = -1
        if state[ENCROACHED] > 0:
            state[ENCROACHED] -= 1
            own = int(encroached[U(2 * state[ENCROACHED])])
            flags = int(origin[U(own | 3)])
            stale = origin[U(own)] != encroached[U(2 * state[ENCROACHED] + 1)]
            if flags & DEAD or stale or (flags >> (own & 3)) & 1 == 0 or (flags >> (4 + (own & 3))) & 1:
                continue
            splitting = True
        else:
            entry = pop(queue, head, state)
            if entry < 0:
                state[PENDING] = 0
                return DONE
            asked = int(queue[U(entry)])
            if queue[U(entry + 1)] != twin[U(asked + 3)] or origin[U(asked + 3)] & DEAD:
                continue
            a = int(origin[U(asked)])
            b = int(origin[U(asked + 1)])
            c = int(origin[U(asked + 2)])
            ax = xy[U(2 * a)]
            ay = xy[U(2 * a + 1)]
            bx = xy[U(2 * b)]
            by = xy[U(2 * b + 1)]
            cx = xy[U(2 * c)]
            cy = xy[U(2 * c + 1)]
            ab2 = (bx - ax) ** 2 + (by - ay) ** 2
            bc2 = (cx - bx) ** 2 + (cy - by) ** 2
            ca2 = (ax - cx) ** 2 + (ay - cy) ** 2
            if max(ab2, bc2, ca2) > (unjudged if uniform else edge_limit[U(asked >> 2)]):
                # A long piece is split at once: its neighbours' circumcentres would only make it thinner first.
                e = asked if ab2 >= bc2 and ab2 >= ca2 else (asked + 1 if bc2 >= ca2 else asked + 2)
                if is_constrained(origin, e) and (origin[U(asked + 3)] >> (4 + (e & 3))) & 1 == 0:
                    own = e
                    splitting = True
            if not splitting:
                # Turn so that (a, b) is the shortest edge.
                e = asked
                if bc2 < ab2 and bc2 <= ca2:
                    ax, bx, cx = bx, cx, ax
                    ay, by, cy = by, cy, ay
                    e = asked + 1
                elif ca2 < ab2:
                    ax, bx, cx = cx, ax, bx
                    ay, by, cy = cy, ay, by
                    e = asked + 2
                # Circumcentre, relative to a.
                ux = bx - ax
                uy = by - ay
                vx = cx - ax
                vy = cy - ay
                u2 = ux * ux + uy * uy
                v2 = vx * vx + vy * vy
                half = 0.5 / (ux * vy - uy * vx)
                dx = (vy * u2 - uy * v2) * half
                dy = (ux * v2 - vx * u2) * half
                if height > 0.0:
                    mx = dx - 0.5 * ux
                    my = dy - 0.5 * uy
                    if height * height * u2 < mx * mx + my * my:
                        dx = 0.5 * ux - height * uy
                        dy = 0.5 * uy + height * ux
                qx = ax + dx
                qy = ay + dy
                # Walk there from the triangle; a piece in the way, or under the point, is split instead.
                hit = -1
                entered = -1
                while True:
                    crossing = -1
                    for k in range(3):
                        g = (e & ~3) + k
                        if g == entered:
                            continue
                        a = int(origin[U(g)])
                        b = int(origin[U(next_edge(g))])
                        side = side_of(xy[U(2 * a)], xy[U(2 * a + 1)], xy[U(2 * b)], xy[U(2 * b + 1)], qx, qy, work)
                        if side < 0.0:
                            crossing = g
                            break
                        if side == 0.0 and is_constrained(origin, g):
                            hit = g
                    if crossing < 0:
                        break
                    hit = -1
                    if is_constrained(origin, crossing):
                        hit = crossing
                        break
                    entered = int(twin[U(crossing)])
                    e = entered
                start = e & ~3
                if hit >= 0:
                    if (origin[U(hit | 3)] >> (4 + (hit & 3))) & 1:
                        state[GIVEN_UP] += 1
                        continue
                    encroached[U(2 * state[ENCROACHED])] = hit
                    encroached[U(2 * state[ENCROACHED] + 1)] = origin[U(hit)]
                    state[ENCROACHED] += 1
                    cavity[0] = asked
                    pending = 1
                    continue
                known = not (math.isfinite(qx) and math.isfinite(qy))
                for k in range(3):
                    a = int(origin[U(start + k)])
                    known = known or (xy[U(2 * a)] == qx and xy[U(2 * a + 1)] == qy)
                if known:
                    state[GIVEN_UP] += 1
                    continue
        if splitting:
            a = int(origin[U(own)])
            b = int(origin[U(next_edge(own))])
            piece = int(piece_of[U(own)])
            p = int(pieces[U(piece), 0])
            q = int(pieces[U(piece), 1])
            if acute[U(p)] == 0 and acute[U(q)] == 0:
                # Points inside that encroach go first, those of the input stay: the split will do without them (Chew).
                e = -1
                for side_of_own in range(2):
                    f = own if side_of_own == 0 else int(twin[U(own)])
                    if e < 0 and f >= 0:
                        c = int(origin[U(previous_edge(f))])
                        if c >= len(acute) and stands_on[U(c)] == FREE_VERTEX:
                            dot = (xy[U(2 * a)] - xy[U(2 * c)]) * (xy[U(2 * b)] - xy[U(2 * c)])
                            dot += (xy[U(2 * a + 1)] - xy[U(2 * c + 1)]) * (xy[U(2 * b + 1)] - xy[U(2 * c + 1)])
                            if dot < 0.0:
                                e = f
                if e >= 0:
                    pending, f = delete_vertex(
                        e, xy, origin, twin, piece_of, free, state[FREE], cavity, stack, ring, ring_from, work
                    )
                    if pending > 0:
                        own = f if e == own else own
                        encroached[U(2 * state[ENCROACHED])] = own
                        encroached[U(2 * state[ENCROACHED] + 1)] = origin[U(own)]
                        state[ENCROACHED] += 1
                        state[FREE] += 2
                        state[INSERTIONS] -= 1
                        if not uniform:
                            for k in range(pending):
                                edge_limit[U(int(cavity[U(k)]) >> 2)] = unjudged
                        continue
            qx, qy = split_place(xy, a, b, p, q, acute[U(p)] != 0, acute[U(q)] != 0)
            behind = int(twin[U(own)])
            start = own & ~3
        # Dig: depth first over edges that are no segments, which meets the cavity's edges counter-clockwise; a split
        # digs on both sides of its piece, one after the other.
        cavity[0] = start
        n_cavity = 1
        n_ring = 0
        second_half = -1
        rejected = False
        hopeless = False
        full = False
        if splitting:
            stack[0] = previous_edge(own)
            stack[1] = next_edge(own)
            depth = 2
        else:
            stack[0] = start + 2
            stack[1] = start + 1
            stack[2] = start
            depth = 3
        while True:
            while depth > 0:
                depth -= 1
                e = int(stack[U(depth)])
                a = int(origin[U(e)])
                b = int(origin[U(next_edge(e))])
                f = e
                conflict = False
                if is_constrained(origin, e):
                    if not splitting and sees_wide(
                        xy[U(2 * a)], xy[U(2 * a + 1)], xy[U(2 * b)], xy[U(2 * b + 1)], qx, qy, lens2
                    ):
                        rejected = True
                        if (origin[U(e | 3)] >> (4 + (e & 3))) & 1:
                            hopeless = True
                        else:
                            encroached[U(2 * state[ENCROACHED])] = e
                            encroached[U(2 * state[ENCROACHED] + 1)] = a
                            state[ENCROACHED] += 1
                else:
                    f = int(twin[U(e)])
                    c = int(origin[U(previous_edge(f))])
                    conflict = (
                        circle_side(
                            xy[U(2 * b)],
                            xy[U(2 * b + 1)],
                            xy[U(2 * a)],
                            xy[U(2 * a + 1)],
                            xy[U(2 * c)],
                            xy[U(2 * c + 1)],
                            qx,
                            qy,
                            work,
                        )
                        > 0.0
                    )
                if conflict:
                    cavity[U(n_cavity)] = f & ~3
                    n_cavity += 1
                    stack[U(depth)] = previous_edge(f)
                    stack[U(depth + 1)] = next_edge(f)
                    depth += 2
                else:
                    ring[U(n_ring)] = e
                    ring_from[U(n_ring)] = a
                    n_ring += 1
                if n_ring >= room or depth >= room or n_cavity >= room:
                    full = True
                    break
            if splitting and second_half < 0 and behind >= 0 and not full:
                second_half = n_ring
                cavity[U(n_cavity)] = behind & ~3
                n_cavity += 1
                stack[0] = previous_edge(behind)
                stack[1] = next_edge(behind)
                depth = 2
                continue
            break
        if full:  # undo what this step took from the queues, so that it can be done again with larger buffers
            if splitting:
                encroached[U(2 * state[ENCROACHED])] = own
                encroached[U(2 * state[ENCROACHED] + 1)] = origin[U(own)]
                state[ENCROACHED] += 1
            else:
                cavity[0] = asked
                pending = 1
            state[PENDING] = pending
            return FULL
        if rejected:
            if hopeless:
                state[GIVEN_UP] += 1
            else:
                cavity[0] = asked
                pending = 1
            continue
        if splitting:
            # The point is on the piece up to rounding only: each new triangle is tested before the old ones go.
            visible = True
            for k in range(n_ring):
                a = int(ring_from[U(k)])
                b = int(origin[U(next_edge(int(ring[U(k)])))])
                if side_of(xy[U(2 * a)], xy[U(2 * a + 1)], xy[U(2 * b)], xy[U(2 * b + 1)], qx, qy, work) <= 0.0:
                    visible = False
                    break
            if not visible or n_ring < n_cavity:
                state[UNSPLIT] += 1
                origin[U(own | 3)] |= np.int32(16 << (own & 3))
                if behind >= 0:
                    origin[U(behind | 3)] |= np.int32(16 << (behind & 3))
                if asked >= 0:
                    cavity[0] = asked
                    pending = 1
                continue
        elif n_ring < n_cavity:
            return FAILED
        face_before = face[U(start >> 2)]
        face_behind = face[U(behind >> 2)] if splitting and behind >= 0 else face_before
        # Fill. What the ring's edges carry is saved before slots are written over: twin, flags, piece.
        end = int(origin[U(own)]) if splitting else -1
        new = int(state[VERTICES])
        state[VERTICES] = new + 1
        xy[U(2 * new)] = qx
        xy[U(2 * new + 1)] = qy
        stands_on[U(new)] = piece if splitting else FREE_VERTEX
        for k in range(n_ring):
            e = int(ring[U(k)])
            flags = int(origin[U(e | 3)])
            bits = ((flags >> (e & 3)) & 1) | (((flags >> (4 + (e & 3))) & 1) << 4)
            stack[U(4 * k)] = twin[U(e)]
            stack[U(4 * k + 1)] = bits
            if bits:
                stack[U(4 * k + 2)] = piece_of[U(e)]
        for k in range(n_cavity, n_ring):
            if state[FREE] > 0:
                state[FREE] -= 1
                cavity[U(k)] = 4 * free[U(state[FREE])]
            else:
                cavity[U(k)] = 4 * state[TRIANGLES]
                state[TRIANGLES] += 1
        closed = not splitting or behind >= 0
        before = int(cavity[U(n_ring - 1)])
        for k in range(n_ring):
            slot = int(cavity[U(k)])
            after_k = k + 1 if k + 1 < n_ring else 0
            after = int(cavity[U(after_k)])
            origin[U(slot)] = ring_from[U(k)]
            origin[U(slot + 1)] = ring_from[U(after_k)] if closed or k + 1 < n_ring else end
            origin[U(slot + 2)] = new
            f = int(stack[U(4 * k)])
            flags = int(stack[U(4 * k + 1)])
            twin[U(slot)] = f
            if f >= 0:
                twin[U(f)] = slot
            if flags:
                piece_of[U(slot)] = stack[U(4 * k + 2)]
            twin[U(slot + 1)] = after + 2
            twin[U(slot + 2)] = before + 1
            if splitting:
                # The two halves of the piece leave the new point where the halves of the ring begin and end.
                if k == 0 or k == second_half:
                    flags |= 4
                    piece_of[U(slot + 2)] = piece
                    if not closed:
                        twin[U(slot + 2)] = -1
                if k == n_ring - 1 or k == second_half - 1:
                    flags |= 2
                    piece_of[U(slot + 1)] = piece
                    if not closed:
                        twin[U(slot + 1)] = -1
            origin[U(slot + 3)] = flags
            twin[U(slot + 3)] += 1
            if splitting or k >= n_cavity:
                face[U(slot >> 2)] = face_before if second_half < 0 or k < second_half else face_behind
            if not uniform:
                edge_limit[U(slot >> 2)] = unjudged
            before = slot
        pending = n_ring
        if splitting:
            state[SPLITS] += 1
        else:
            state[INSERTIONS] += 1
    state[PENDING] = pending
    return MORE
