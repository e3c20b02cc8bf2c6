"""Kernels that force segments into a Delaunay triangulation by flips.

A segment is walked from its first end; edges across it are flipped where their quadrilateral is strictly convex, until
none crosses; then the edges that were touched are flipped to Delaunay again (Lawson), segments excepted.

References
----------
S. W. Sloan, "A fast algorithm for generating constrained Delaunay triangulations", Computers & Structures 47 (1993).
"""

from .._numba import kernel
from ._half_edge_kernels import (
    DONE,
    FAILED,
    FULL,
    MORE,
    U,
    circle_side,
    flip,
    is_constrained,
    next_edge,
    previous_edge,
    set_constrained,
    side_of,
)

# Places in the state of `insert_segments`; the walk stands at FROM (-1: not begun) and aims at the vertex GOAL.
SEGMENT, FROM, GOAL, PIECES, CROSSED, DEPTH = 0, 1, 2, 3, 4, 5


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
def map_vertices(origin, twin, n_triangles, vertex_edge):
    """Clear flags and stamps, and note one outgoing half-edge of each vertex."""
    for t in range(n_triangles):
        origin[U(4 * t + 3)] = 0
        twin[U(4 * t + 3)] = 0
        for k in range(3):
            vertex_edge[origin[U(4 * t + k)]] = 4 * t + k


@kernel
def insert_segments(
    xy, origin, twin, piece_of, vertex_edge, segments, pieces, crossed, stack, work, tolerance, state, steps
):
    """Insert segments until about ``steps`` edges were looked at; ``state`` tells where to go on.

    A vertex on a segment, up to the tolerance, splits it; each part becomes a row (from, to, segment) of ``pieces``,
    unless an earlier piece lies there. A segment that crosses an earlier one is left out and noted in ``crossed``.
    """
    s = int(state[SEGMENT])
    a = int(state[FROM])
    goal = int(state[GOAL])
    depth = int(state[DEPTH])
    done = 0
    status = DONE
    while s < len(segments):
        b = int(segments[U(s), 1])
        if a < 0:
            a = int(segments[U(s), 0])
            goal = b
        # Phase 1: make the edges from a to b, one vertex on the way after the other.
        while a != b:
            if done > steps:
                status = MORE
                break
            if state[PIECES] >= len(pieces) or state[CROSSED] >= len(crossed):
                status = FULL
                break
            ax = xy[U(2 * a)]
            ay = xy[U(2 * a + 1)]
            gx = xy[U(2 * goal)]
            gy = xy[U(2 * goal + 1)]
            # The star of a: is there an edge along the segment, else which edge does the segment cross?
            e = int(vertex_edge[a])
            first = e
            along = -1
            across = -1
            while True:
                done += 1
                u = int(origin[U(next_edge(e))])
                w = int(origin[U(previous_edge(e))])
                if u == goal or (u >= 0 and on_segment(ax, ay, gx, gy, xy[U(2 * u)], xy[U(2 * u + 1)], tolerance)):
                    along = e
                    break
                if (
                    u >= 0
                    and w >= 0
                    and side_of(ax, ay, gx, gy, xy[U(2 * u)], xy[U(2 * u + 1)], work) < 0.0
                    and side_of(ax, ay, gx, gy, xy[U(2 * w)], xy[U(2 * w + 1)], work) > 0.0
                ):
                    across = next_edge(e)
                e = int(twin[U(previous_edge(e))])
                if e == first:
                    break
            if along >= 0:
                u = int(origin[U(next_edge(along))])
                if is_constrained(origin, along) == 0:
                    f = int(twin[U(along)])
                    set_constrained(origin, along, 1)
                    set_constrained(origin, f, 1)
                    count = state[PIECES]
                    piece_of[U(along)] = count
                    piece_of[U(f)] = count
                    pieces[U(count), 0] = a
                    pieces[U(count), 1] = u
                    pieces[U(count), 2] = s
                    state[PIECES] = count + 1
                a = u
                goal = b
                continue
            if across < 0:
                status = FAILED
                break
            # Walk along the segment and flip what can be flipped.
            cur = across
            while True:
                done += 1
                if depth + 8 > len(stack):
                    status = FULL
                    break
                if is_constrained(origin, cur):
                    crossed[U(state[CROSSED])] = s
                    state[CROSSED] += 1
                    a = b
                    goal = b
                    break
                f = int(twin[U(cur)])
                u = int(origin[U(cur)])
                w = int(origin[U(f)])
                p = int(origin[U(previous_edge(cur))])
                v = int(origin[U(previous_edge(f))])
                ux = xy[U(2 * u)]
                uy = xy[U(2 * u + 1)]
                wx = xy[U(2 * w)]
                wy = xy[U(2 * w + 1)]
                px = xy[U(2 * p)]
                py = xy[U(2 * p + 1)]
                vx = xy[U(2 * v)]
                vy = xy[U(2 * v + 1)]
                reached = v == goal
                if not reached and on_segment(ax, ay, gx, gy, vx, vy, tolerance):
                    goal = v
                    reached = True
                v_is_right = not reached and side_of(ax, ay, gx, gy, vx, vy, work) < 0.0
                convex = side_of(px, py, ux, uy, vx, vy, work) > 0.0 and side_of(vx, vy, wx, wy, px, py, work) > 0.0
                if convex:
                    flip(origin, twin, piece_of, vertex_edge, cur)
                    stack[U(depth)] = cur
                    stack[U(depth + 1)] = previous_edge(cur)
                    stack[U(depth + 2)] = f
                    stack[U(depth + 3)] = previous_edge(f)
                    stack[U(depth + 4)] = next_edge(cur)
                    depth += 5
                if reached:
                    break
                if v_is_right:
                    cur = previous_edge(f)
                elif not convex:
                    cur = next_edge(f)
            if status != DONE:
                break
        if status != DONE:
            break
        # Phase 2: Lawson's flips.
        while depth > 0:
            if depth + 8 > len(stack):
                status = FULL
                break
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
            if u < 0 or w < 0 or p < 0 or v < 0:
                continue
            if (
                circle_side(
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
                > 0.0
            ):
                flip(origin, twin, piece_of, vertex_edge, e)
                stack[U(depth)] = e
                stack[U(depth + 1)] = previous_edge(e)
                stack[U(depth + 2)] = f
                stack[U(depth + 3)] = previous_edge(f)
                depth += 4
        if status != DONE:
            break
        s += 1
        a = -1
    state[SEGMENT] = s
    state[FROM] = a
    state[GOAL] = goal
    state[DEPTH] = depth
    return status
