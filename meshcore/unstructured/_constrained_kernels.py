"""Kernels that force segments into a Delaunay triangulation of the plane.

A segment is walked from one end through the triangles that it crosses. These leave a cavity on either side of it, which
is triangulated in one sweep along its outline and then made Delaunay by flips (Lawson). Outside the cavity nothing
changes: what was constrained Delaunay before stays so. Ties are broken as for points alone, so there is one constrained
Delaunay triangulation, and it depends on neither the order of the segments nor the sweep. Nothing is touched before the
walk has reached its end, so a segment that crosses another leaves no trace.

References
----------
C. L. Lawson, "Software for C1 surface interpolation", in Mathematical Software III (1977).
M. V. Anglada, "An improved incremental algorithm for constructing restricted Delaunay triangulations", Computers &
Graphics 21 (1997), for the cavity on either side.
G. T. Toussaint, D. Avis, "On a convex hull algorithm for polygons and its application to triangulation problems",
Pattern Recognition 15 (1982), for the sweep: each corner of a cavity sees the segment, along the edge that was crossed.
J. R. Shewchuk, B. C. Brown, "Fast segment insertion and incremental construction of constrained Delaunay
triangulations", Comput. Geom. 48 (2015), for cavities whose outline meets itself.
"""

import numpy as np

from .._numba import kernel
from ._half_edge_kernels import (
    DONE,
    FAILED,
    FULL,
    MORE,
    U,
    circle_side,
    circle_tie,
    flip,
    is_constrained,
    next_edge,
    previous_edge,
    set_constrained,
    side_of,
)

# Places in the state of `insert_segments`; the walk stands at FROM (-1: not begun) and aims at the vertex TO, which is
# the end of the segment, or its start where TURNED is odd.
SEGMENT, FROM, TO, TURNED, PIECES, CROSSED, DEPTH = 0, 1, 2, 3, 4, 5, 6
STATE_SIZE = 7
# What it answers beside `DONE`, `MORE`, `FULL` and `FAILED`.
FULL_CROSSINGS = 4
# An edge of the outline of a cavity: the corner where it ends, its half-edge inside, the one outside (or -1 - k for
# edge k of the same outline), and the piece on it or -1.
CORNER, INSIDE, OUTSIDE, PIECE = 0, 1, 2, 3
# A flag of triangles in the cavity.
IN_CAVITY = 1 << 15
# A vertex with more edges is better reached from the other end of the segment.
HUB = 48


@kernel
def on_segment(ax, ay, bx, by, qx, qy, tolerance):
    """Whether q lies between a and b, no farther than the tolerance from their line."""
    dx = bx - ax
    dy = by - ay
    length2 = dx * dx + dy * dy
    along = (qx - ax) * dx + (qy - ay) * dy
    across = dx * (qy - ay) - dy * (qx - ax)
    return 0.0 < along < length2 and across * across <= tolerance * tolerance * length2


@kernel
def prepare(xy, order, merged, kept, origin, twin, n_triangles, segments, vertex, ends, vertex_edge, piece_of):
    """Name segments by vertices, note one outgoing half-edge of each, clear flags, stamps and pieces.

    ``segments`` are pairs of points, ``vertex`` gets the vertex of each point. The answer is the largest magnitude of a
    coordinate.
    """
    for v in range(len(order)):
        vertex[U(order[U(v)])] = v
    for i in range(len(merged)):
        vertex[U(merged[U(i)])] = vertex[U(kept[U(i)])]
    for s in range(len(segments)):
        ends[U(s), U(0)] = vertex[U(segments[U(s), U(0)])]
        ends[U(s), U(1)] = vertex[U(segments[U(s), U(1)])]
    for t in range(n_triangles):
        origin[U(4 * t + 3)] = 0
        twin[U(4 * t + 3)] = 0
        for k in range(3):
            vertex_edge[origin[U(4 * t + k)]] = 4 * t + k
    piece_of[:] = -1
    largest = 0.0
    for i in range(2 * len(order)):
        largest = max(largest, abs(xy[U(i)]))
    return largest


@kernel
def detach_cavity(origin, twin, piece_of, chain, low, high, cavity, n_cavity):
    """Complete the outline's rows: what lies outside each edge, and on it."""
    for k in range(n_cavity):
        origin[U(4 * int(cavity[U(k)]) + 3)] |= np.int32(IN_CAVITY)
    room = len(chain)
    for part in range(2):
        for i in range(0 if part == 0 else high, low if part == 0 else room):
            e = int(chain[U(i), INSIDE])
            f = int(twin[U(e)])
            chain[U(i), OUTSIDE] = f
            chain[U(i), PIECE] = piece_of[U(e)] if is_constrained(origin, e) else -1
            if origin[U(f | 3)] & IN_CAVITY:
                chain[U(i), OUTSIDE] = -1 - f
    # Where the outline meets itself, its two edges know each other by their numbers.
    for part in range(2):
        for i in range(0 if part == 0 else high, low if part == 0 else room):
            if chain[U(i), OUTSIDE] < 0:
                twin[U(int(chain[U(i), INSIDE]))] = i
    for part in range(2):
        for i in range(0 if part == 0 else high, low if part == 0 else room):
            f = -1 - int(chain[U(i), OUTSIDE])
            if f >= 0:
                chain[U(i), OUTSIDE] = -1 - twin[U(f)]


@kernel
def attach(origin, twin, piece_of, chain, e, other):
    """Join the new half-edge e to another, or to edge -1 - other of the outline; 1 if the edge is a new one."""
    if other >= 0:
        twin[U(e)] = other
        twin[U(other)] = e
        return 1
    i = -1 - other
    chain[U(i), INSIDE] = e
    if chain[U(i), PIECE] >= 0:
        set_constrained(origin, e, 1)
        piece_of[U(e)] = chain[U(i), PIECE]
    return 0


@kernel
def fill_side(
    xy, origin, twin, piece_of, vertex_edge, chain, start, low, high, cavity, used, sweep, stack, depth, work
):
    """Triangulate the part of the cavity left of the outline from ``start`` through rows low to high.

    A corner is cut off as soon as it is convex. Numbers of new edges go to the stack; the half-edge along the segment
    and the new depth are returned.
    """
    sweep[0, 0] = start
    n = 1
    for i in range(low, high):
        v = int(chain[U(i), CORNER])
        vx = xy[U(2 * v)]
        vy = xy[U(2 * v + 1)]
        code = -1 - i
        while n >= 2:
            p = int(sweep[U(n - 2), 0])
            q = int(sweep[U(n - 1), 0])
            if not side_of(xy[U(2 * p)], xy[U(2 * p + 1)], xy[U(2 * q)], xy[U(2 * q + 1)], vx, vy, work) > 0.0:
                break
            e = 4 * int(cavity[U(used)])
            used += 1
            origin[U(e)] = p
            origin[U(e + 1)] = q
            origin[U(e + 2)] = v
            origin[U(e + 3)] = 0
            vertex_edge[p] = e
            vertex_edge[q] = e + 1
            vertex_edge[v] = e + 2
            if attach(origin, twin, piece_of, chain, e, int(sweep[U(n - 1), 1])):
                stack[U(depth)] = e
                depth += 1
            if attach(origin, twin, piece_of, chain, e + 1, code):
                stack[U(depth)] = e + 1
                depth += 1
            code = e + 2
            n -= 1
        sweep[U(n), 0] = v
        sweep[U(n), 1] = code
        n += 1
    return sweep[1, 1] if n == 2 else -1, depth


@kernel
def legalise(xy, order, origin, twin, piece_of, vertex_edge, stack, depth, work):
    """Flip the edges on the stack, and what that touches, until all are Delaunay; what is left where it is full."""
    done = 0
    while depth > 0 and depth + 8 <= len(stack):
        done += 1
        depth -= 1
        e = int(stack[U(depth)])
        if is_constrained(origin, e):
            continue
        f = int(twin[U(e)])
        u = int(origin[U(e)])
        w = int(origin[U(f)])
        p = int(origin[U(previous_edge(e))])
        v = int(origin[U(previous_edge(f))])
        if (u | w | p | v) < 0:
            continue
        side = circle_side(
            xy[U(2 * u)],
            xy[U(2 * u + 1)],
            xy[U(2 * w)],
            xy[U(2 * w + 1)],
            xy[U(2 * p)],
            xy[U(2 * p + 1)],
            xy[U(2 * v)],
            xy[U(2 * v + 1)],
            work,
        )
        if side == 0.0:
            side = circle_tie(xy, order, u, w, p, v, work)
        if side > 0.0:
            flip(origin, twin, piece_of, vertex_edge, e)
            stack[U(depth)] = e
            stack[U(depth + 1)] = previous_edge(e)
            stack[U(depth + 2)] = f
            stack[U(depth + 3)] = previous_edge(f)
            depth += 4
    return depth, done


@kernel
def attach_outline(twin, chain, low, high):
    """Join the new half-edges along the outline of a cavity to what lies outside it."""
    for part in range(2):
        for i in range(0 if part == 0 else high, low if part == 0 else len(chain)):
            e = int(chain[U(i), INSIDE])
            f = int(chain[U(i), OUTSIDE])
            if f < 0:
                f = int(chain[U(-1 - f), INSIDE])
            twin[U(e)] = f
            twin[U(f)] = e


@kernel
def insert_segments(
    xy, order, origin, twin, piece_of, vertex_edge, segments, pieces, crossed, places, chain, cavity, sweep, stack,
    work, tolerance, state, steps,
):  # fmt: skip
    """Insert segments until about ``steps`` edges were looked at; ``state`` tells where to go on.

    A vertex on a segment, up to the tolerance, splits it; each part becomes a row (from, to, segment) of ``pieces``,
    unless an earlier piece lies there. A segment that crosses earlier ones is left out there, and each pair of
    segments is noted in ``crossed``, some twice, and where they cross in ``places``. If these are full, the answer is
    `FULL_CROSSINGS`; if ``pieces``, or else the buffers after ``places`` are, it is `FULL`: they are to grow.
    """
    s = int(state[SEGMENT])
    a = int(state[FROM])
    b = int(state[TO])
    turned = int(state[TURNED])
    depth = int(state[DEPTH])
    room = len(chain)
    done = 0
    aim = -1  # a vertex on the segment that is nearer than b
    status = DONE
    while s < len(segments):
        if depth > 0:
            depth, flips = legalise(xy, order, origin, twin, piece_of, vertex_edge, stack, depth, work)
            done += flips
            if depth > 0:
                status = FULL
                break
        if a < 0:
            a = int(segments[U(s), 0])
            b = int(segments[U(s), 1])
            turned = 0
        if a == b:
            s += 1
            a = -1
            continue
        if done > steps:
            status = MORE
            break
        if state[PIECES] >= len(pieces):
            status = FULL
            break
        # The star of a: is there an edge along the segment, else which edge does the segment cross?
        ax = xy[U(2 * a)]
        ay = xy[U(2 * a + 1)]
        goal = b if aim < 0 else aim
        bx = xy[U(2 * goal)]
        by = xy[U(2 * goal + 1)]
        e = int(vertex_edge[a])
        first = e
        along = -1
        across = -1
        looked = 0
        side_u = 0.0
        while True:
            u = int(origin[U(next_edge(e))])
            if u == goal:
                along = e
                break
            w = int(origin[U(previous_edge(e))])
            if u >= 0 and on_segment(ax, ay, bx, by, xy[U(2 * u)], xy[U(2 * u + 1)], tolerance):
                along = e
                break
            side_w = 0.0
            if w >= 0:
                side_w = side_of(ax, ay, bx, by, xy[U(2 * w)], xy[U(2 * w + 1)], work)
            if side_w > 0.0 and u >= 0:
                if looked == 0:
                    side_u = side_of(ax, ay, bx, by, xy[U(2 * u)], xy[U(2 * u + 1)], work)
                if side_u < 0.0:
                    across = e
            side_u = side_w
            looked += 1
            e = int(twin[U(previous_edge(e))])
            if e == first or (looked == HUB and turned < 2):
                break
        done += looked
        if along < 0 and e != first:  # a hub: begin at the other end, and if that is one too, look at all its edges
            a, b = b, a
            turned = 3
            aim = -1
            continue
        if along >= 0:
            goal = int(origin[U(next_edge(along))])
        elif across < 0:
            status = FAILED
            break
        else:
            # Walk to the goal, and note the outline on either side: rows 0 to low right of the segment, counter-
            # clockwise; rows high to the end left of it, so that they too are counter-clockwise when read upwards.
            before = state[CROSSED]
            cavity[0] = across >> 2
            n_cavity = 1
            chain[0, INSIDE] = across
            low = 0
            high = room - 1
            chain[U(high), CORNER] = a
            chain[U(high), INSIDE] = previous_edge(across)
            e = next_edge(across)
            nearer = -1
            while True:
                if low + 3 > high or n_cavity + 1 >= len(cavity):
                    status = FULL
                    break
                if state[CROSSED] >= len(crossed):
                    status = FULL_CROSSINGS
                    break
                u = int(origin[U(e)])
                w = int(origin[U(next_edge(e))])
                if is_constrained(origin, e):
                    ux = xy[U(2 * u)]
                    uy = xy[U(2 * u + 1)]
                    wx = xy[U(2 * w)]
                    wy = xy[U(2 * w + 1)]
                    right = side_of(ax, ay, bx, by, ux, uy, work)
                    share = right / (right - side_of(ax, ay, bx, by, wx, wy, work))
                    count = state[CROSSED]
                    crossed[U(count), 0] = s
                    crossed[U(count), 1] = pieces[U(piece_of[U(e)]), 2]
                    places[U(count), 0] = ux + share * (wx - ux)
                    places[U(count), 1] = uy + share * (wy - uy)
                    state[CROSSED] = count + 1
                f = int(twin[U(e)])
                v = int(origin[U(previous_edge(f))])
                cavity[U(n_cavity)] = f >> 2
                n_cavity += 1
                if v == goal:
                    chain[U(low), CORNER] = u
                    chain[U(low + 1), CORNER] = goal
                    chain[U(low + 1), INSIDE] = next_edge(f)
                    low += 2
                    high -= 1
                    chain[U(high), CORNER] = w
                    chain[U(high), INSIDE] = previous_edge(f)
                    break
                vx = xy[U(2 * v)]
                vy = xy[U(2 * v + 1)]
                if on_segment(ax, ay, bx, by, vx, vy, tolerance):
                    nearer = v
                    break
                side = side_of(ax, ay, bx, by, vx, vy, work)
                if side < 0.0:
                    chain[U(low), CORNER] = u
                    low += 1
                    chain[U(low), INSIDE] = next_edge(f)
                    e = previous_edge(f)
                elif side > 0.0:
                    high -= 1
                    chain[U(high), CORNER] = w
                    chain[U(high), INSIDE] = previous_edge(f)
                    e = next_edge(f)
                else:
                    status = FAILED
                    break
            if status != DONE:
                state[CROSSED] = before  # the walk begins anew, and may then lead by another vertex
                break
            if nearer >= 0:
                state[CROSSED] = before
                aim = nearer  # the line to it is another one, by rounding: begin anew
                continue
            done += n_cavity
            if state[CROSSED] > before:
                a = goal
                aim = -1
                continue
            if depth + 2 * n_cavity + 8 > len(stack) or n_cavity + 8 > len(sweep):
                status = FULL
                break
            if n_cavity == 2:
                e = next_edge(across)
                flip(origin, twin, piece_of, vertex_edge, e)
                along = next_edge(e)
                if origin[U(along)] != a:
                    along = int(twin[U(along)])
            else:
                detach_cavity(origin, twin, piece_of, chain, low, high, cavity, n_cavity)
                inner_right, depth = fill_side(
                    xy, origin, twin, piece_of, vertex_edge, chain, a, 0, low, cavity, 0, sweep, stack, depth, work
                )
                inner_left, depth = fill_side(
                    xy, origin, twin, piece_of, vertex_edge, chain, goal, high, room, cavity, low - 1, sweep, stack,
                    depth, work,
                )  # fmt: skip
                if inner_right < 0 or inner_left < 0:
                    status = FAILED
                    break
                attach_outline(twin, chain, low, high)
                twin[U(inner_left)] = inner_right
                twin[U(inner_right)] = inner_left
                along = inner_left
        if is_constrained(origin, along) == 0:
            f = int(twin[U(along)])
            set_constrained(origin, along, 1)
            set_constrained(origin, f, 1)
            count = state[PIECES]
            piece_of[U(along)] = count
            piece_of[U(f)] = count
            pieces[U(count), 0] = goal if turned & 1 else a
            pieces[U(count), 1] = a if turned & 1 else goal
            pieces[U(count), 2] = s
            state[PIECES] = count + 1
        a = goal
        aim = -1
    state[SEGMENT] = s
    state[FROM] = a
    state[TO] = b
    state[TURNED] = turned
    state[DEPTH] = depth
    return status
