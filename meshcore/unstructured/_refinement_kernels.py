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
    is_constrained,
    next_edge,
    previous_edge,
    side_of,
)
from ._point_insertion_kernels import dig, fill, look_across, look_beside, walk
from ._splitting_kernels import split_place
from ._vertex_deletion_kernels import delete_vertex

# Places in the state shared by the kernels of this file, after those of the queue.
STATE_SIZE = QUEUE_STATE + 9
TRIANGLES, VERTICES, FREE, ENCROACHED, PENDING, GIVEN_UP, UNSPLIT, SPLITS, INSERTIONS = range(QUEUE_STATE, STATE_SIZE)
# Buckets: one per quarter octave of the squared shortest edge; above them one per block of the domain, for what is too
# large; and one for what is much too large, by this factor in edge and in area, squared, or more. So sizes become even
# first, and then one block after the other is finished while it is in the processor's cache, whose vertices and
# triangles then lie near each other in memory, too.
ANGLE_BUCKETS = 2048
BLOCKS = 32
BUCKETS = ANGLE_BUCKETS + BLOCKS * BLOCKS + 1
MUCH_TOO_LARGE = 16.0
# Places in ``limits``: squared cosine of the smallest angle; squared cosine of the lens; the off-centre's height per
# length of the shortest edge (0: circumcentres); the squared edge length of triangles yet to be judged, and whether
# that is the length for all; twice the largest area if it is the same in all faces, else -1; whether the worst triangle
# goes first (the survey's order); the lower left corner of the domain, and blocks per length.
COSINE2, LENS2, HEIGHT, EDGE2, ONE_EDGE, TWICE_AREA, WORST_FIRST, LEFT, BELOW, BLOCKS_PER_LENGTH = range(10)
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


@kernel(inline=True)
def is_unsplittable(origin, e):
    """1 if the piece that e lies on may not be split here."""
    return (origin[U(e | 3)] >> (4 + (e & 3))) & 1


@kernel(inline=True)
def push_encroached(e, origin, encroached, state):
    """Note a piece that is to be split; the caller has made room."""
    depth = state[ENCROACHED]
    encroached[U(2 * depth)] = e
    encroached[U(2 * depth + 1)] = origin[U(e)]
    state[ENCROACHED] = depth + 1


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
    cosine2 = limits[COSINE2]
    lens2 = limits[LENS2]
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
                    push_encroached(slot + k, origin, encroached, state)
    abx = bx - ax
    aby = by - ay
    bcx = cx - bx
    bcy = cy - by
    cax = ax - cx
    cay = ay - cy
    opposite_a = bcx * bcx + bcy * bcy
    opposite_b = cax * cax + cay * cay
    opposite_c = abx * abx + aby * aby
    shortest = min(opposite_a, opposite_b, opposite_c)
    longest = max(opposite_a, opposite_b, opposite_c)
    other = max(min(opposite_a, opposite_b), min(max(opposite_a, opposite_b), opposite_c))
    area = abx * cay - aby * cax  # minus twice the area
    limit = limits[TWICE_AREA]
    if limit < 0.0:
        limit = area_limit[U(face[U(t)])]
    longest2 = limits[EDGE2] if limits[ONE_EDGE] != 0.0 else edge_limit[U(t)]
    too_large = longest > longest2 or area * area > limit * limit
    poor = too_large
    if not poor:
        # Law of cosines at the corner between the two longer edges.
        numerator = longest + other - shortest
        poor = numerator > 0.0 and numerator * numerator > 4.0 * cosine2 * longest * other
        if poor:
            p, q = (b, c) if shortest == opposite_a else ((c, a) if shortest == opposite_b else (a, b))
            piece_p = int(stands_on[U(p)])
            piece_q = int(stands_on[U(q)])
            if piece_p >= 0 and piece_q >= 0 and piece_p != piece_q:
                poor = not is_between_neighbours(xy, pieces, p, q, piece_p, piece_q)
    if poor:
        bucket = BUCKETS - 1
        if limits[WORST_FIRST] != 0.0:  # by the squared circumradius over the one wanted, the largest first
            wanted = min(longest2 / 3.0, limit * TWICE_AREA_TO_RADIUS2)
            if cosine2 < 1.0:
                wanted = min(wanted, shortest / (4.0 * (1.0 - cosine2)))
            mantissa, exponent = math.frexp(longest * other * shortest / (4.0 * area * area * wanted))
            bucket = min(max(ANGLE_BUCKETS // 2 + 4 * exponent + int(8.0 * mantissa), 0), BUCKETS - 1)
        elif not too_large:
            mantissa, exponent = math.frexp(shortest)
            bucket = min(max(64 - 4 * exponent - int(8.0 * mantissa), 0), ANGLE_BUCKETS - 1)
        elif longest < MUCH_TOO_LARGE * longest2 and area * area < MUCH_TOO_LARGE * limit * limit:
            row = int((ay - limits[BELOW]) * limits[BLOCKS_PER_LENGTH])
            column = int((ax - limits[LEFT]) * limits[BLOCKS_PER_LENGTH])
            bucket = ANGLE_BUCKETS + BLOCKS * row + (BLOCKS - 1 - column if row & 1 else column)
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
def place(slot, xy, origin, longest2, height):
    """The piece to be split for a poor triangle, or -1, and where its point stands then."""
    a = int(origin[U(slot)])
    b = int(origin[U(slot + 1)])
    c = int(origin[U(slot + 2)])
    ax = xy[U(2 * a)]
    ay = xy[U(2 * a + 1)]
    bx = xy[U(2 * b)]
    by = xy[U(2 * b + 1)]
    cx = xy[U(2 * c)]
    cy = xy[U(2 * c + 1)]
    ab2 = (bx - ax) ** 2 + (by - ay) ** 2
    bc2 = (cx - bx) ** 2 + (cy - by) ** 2
    ca2 = (ax - cx) ** 2 + (ay - cy) ** 2
    if max(ab2, bc2, ca2) > longest2:
        # A long piece is split at once: its neighbours' circumcentres would only make it thinner first.
        e = slot if ab2 >= bc2 and ab2 >= ca2 else (slot + 1 if bc2 >= ca2 else slot + 2)
        if is_constrained(origin, e) and not is_unsplittable(origin, e):
            return e, 0.0, 0.0
    # Turn so that (a, b) is the shortest edge.
    if bc2 < ab2 and bc2 <= ca2:
        ax, bx, cx = bx, cx, ax
        ay, by, cy = by, cy, ay
    elif ca2 < ab2:
        ax, bx, cx = cx, ax, bx
        ay, by, cy = cy, ay, by
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
    return -1, ax + dx, ay + dy


@kernel
def mark_halves(n_ring, second_half, end, piece, origin, twin, piece_of, cavity):
    """Mark the halves of a piece after `fill`: they run from the new point to where the halves of the ring begin.

    With nothing behind the piece there is one half of a ring, ``second_half`` is -1, and it ends at the vertex ``end``.
    """
    first = 0
    while first < n_ring:
        last = second_half if first < second_half else n_ring
        begin = int(cavity[U(first)])
        finish = int(cavity[U(last - 1)])
        origin[U(begin + 3)] |= np.int32(4)
        piece_of[U(begin + 2)] = piece
        origin[U(finish + 3)] |= np.int32(2)
        piece_of[U(finish + 1)] = piece
        if second_half < 0:
            twin[U(begin + 2)] = -1
            twin[U(finish + 1)] = -1
            origin[U(finish + 1)] = end
        first = last


@kernel
def refine(
    xy, origin, twin, piece_of, stands_on, pieces, acute, face, edge_limit, area_limit, limits, queue, head, tail,
    encroached, free, cavity, stack, ring, ring_from, work, state, steps,
):  # fmt: skip
    """Do up to ``steps`` insertions or rejections; ``state`` tells where to go on."""
    lens2 = limits[LENS2]
    unjudged = limits[EDGE2]
    uniform = limits[ONE_EDGE] != 0.0
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
        piece = FREE_VERTEX
        qx = 0.0
        qy = 0.0
        if state[ENCROACHED] > 0:
            state[ENCROACHED] -= 1
            own = int(encroached[U(2 * state[ENCROACHED])])
            flags = int(origin[U(own | 3)])
            stale = origin[U(own)] != encroached[U(2 * state[ENCROACHED] + 1)]
            if flags & DEAD or stale or (flags >> (own & 3)) & 1 == 0 or is_unsplittable(origin, own):
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
            longest2 = unjudged if uniform else edge_limit[U(asked >> 2)]
            own, qx, qy = place(asked, xy, origin, longest2, limits[HEIGHT])
            splitting = own >= 0
            if not splitting:
                # Walk there from the triangle; a piece in the way, or under the point, is split instead.
                e, hit = walk(asked, qx, qy, xy, origin, twin, work)
                start = e & ~3
                if hit >= 0:
                    if is_unsplittable(origin, hit):
                        state[GIVEN_UP] += 1
                        continue
                    push_encroached(hit, origin, encroached, state)
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
        # Dig; a split does so on both sides of its piece, one after the other.
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
            depth = look_beside(own, 0, cavity, stack)
        else:
            depth = look_across(start, cavity, stack)
        n_cavity = 1
        n_ring = 0
        second_half = -1
        while True:
            n_cavity, n_ring = dig(
                depth, n_cavity, n_ring, qx, qy, xy, origin, twin, cavity, stack, ring, ring_from, work
            )
            if behind < 0 or second_half >= 0 or n_ring < 0:
                break
            second_half = n_ring
            depth = look_beside(behind, n_cavity, cavity, stack)
            n_cavity += 1
        if n_ring < 0:  # undo what this step took from the queues, so that it can be done again with larger buffers
            if asked >= 0:
                cavity[0] = asked
                pending = 1
            else:
                push_encroached(own, origin, encroached, state)
            state[PENDING] = pending
            return FULL
        if splitting:
            # The point is on the piece up to rounding only: each new triangle is tested before the old ones go.
            visible = n_ring >= n_cavity
            for k in range(n_ring):
                a = int(ring_from[U(k)])
                b = int(origin[U(next_edge(int(ring[U(k)])))])
                visible = visible and (
                    side_of(xy[U(2 * a)], xy[U(2 * a + 1)], xy[U(2 * b)], xy[U(2 * b + 1)], qx, qy, work) > 0.0
                )
            if not visible:
                state[UNSPLIT] += 1
                origin[U(own | 3)] |= np.int32(16 << (own & 3))
                if behind >= 0:
                    origin[U(behind | 3)] |= np.int32(16 << (behind & 3))
                if asked >= 0:
                    cavity[0] = asked
                    pending = 1
                continue
        else:
            rejected = False
            hopeless = False
            for k in range(n_ring):
                e = int(ring[U(k)])
                if is_constrained(origin, e):
                    a = int(ring_from[U(k)])
                    b = int(origin[U(next_edge(e))])
                    if sees_wide(xy[U(2 * a)], xy[U(2 * a + 1)], xy[U(2 * b)], xy[U(2 * b + 1)], qx, qy, lens2):
                        rejected = True
                        if is_unsplittable(origin, e):
                            hopeless = True
                        else:
                            push_encroached(e, origin, encroached, state)
            if hopeless:
                state[GIVEN_UP] += 1
                continue
            if rejected:
                cavity[0] = asked
                pending = 1
                continue
            if n_ring < n_cavity:
                return FAILED
        end = int(origin[U(own)]) if splitting else -1
        new = int(state[VERTICES])
        state[VERTICES] = new + 1
        xy[U(2 * new)] = qx
        xy[U(2 * new + 1)] = qy
        stands_on[U(new)] = piece
        for k in range(n_cavity, n_ring):
            if state[FREE] > 0:
                state[FREE] -= 1
                cavity[U(k)] = 4 * int(free[U(state[FREE])])
            else:
                cavity[U(k)] = 4 * state[TRIANGLES]
                state[TRIANGLES] += 1
        fill(new, n_ring, origin, twin, piece_of, face, cavity, stack, ring, ring_from)
        if splitting:
            mark_halves(n_ring, second_half, end, piece, origin, twin, piece_of, cavity)
            state[SPLITS] += 1
        else:
            state[INSERTIONS] += 1
        if not uniform:
            for k in range(n_ring):
                edge_limit[U(int(cavity[U(k)]) >> 2)] = unjudged
        pending = n_ring
    state[PENDING] = pending
    return MORE
