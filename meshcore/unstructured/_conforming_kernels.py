"""Kernel that splits pieces of segments until a constrained Delaunay triangulation is a Delaunay triangulation.

A piece is split where the two triangles beside it are not Delaunay, so that it stands only because it is a segment.
By Lee and Lin's lemma all triangles are Delaunay once no such piece is left. Such a piece has a vertex in its diametral
circle; so Ruppert's proof holds that splitting in the middle, and on concentric shells around acute corners, ends.

References
----------
J. Ruppert, "A Delaunay refinement algorithm for quality 2-dimensional mesh generation", J. Algorithms 18 (1995).
D. T. Lee, A. K. Lin, "Generalized Delaunay triangulation for planar graphs", Discrete Comput. Geom. 1 (1986).
"""

from .._numba import kernel
from ._half_edge_kernels import (
    DONE,
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
from ._splitting_kernels import split_place

# Places in the state of `conform`: the queue of half-edges is a ring from HEAD on, with WAITING entries; STUCK counts
# pieces that coordinates cannot resolve further.
TRIANGLES, VERTICES, HEAD, WAITING, DEPTH, STUCK = 0, 1, 2, 3, 4, 5
STATE_SIZE = 6


@kernel
def split_edge(origin, twin, piece_of, face, vertex_edge, e, m, slot):
    """Put vertex m on the edge e and its twin; two more triangles, from ``slot`` on."""
    f = int(twin[U(e)])
    e1 = next_edge(e)
    f1 = next_edge(f)
    u = origin[U(e)]
    w = origin[U(f)]
    first = 4 * slot
    second = first + 4
    for part in range(2):
        # The triangle of g = (s, t) with apex p becomes (s, m, p); the new one is (m, t, p).
        g, g1, new, t = (e, e1, first, w) if part == 0 else (f, f1, second, u)
        beyond = int(twin[U(g1)])
        p = origin[U(previous_edge(g))]
        origin[U(new)] = m
        origin[U(new + 1)] = t
        origin[U(new + 2)] = p
        origin[U(new + 3)] = 0
        twin[U(new + 3)] = 0
        origin[U(g1)] = m
        set_constrained(origin, new, 1)
        piece_of[U(new)] = piece_of[U(g)]
        set_constrained(origin, new + 1, is_constrained(origin, g1))
        piece_of[U(new + 1)] = piece_of[U(g1)]
        set_constrained(origin, g1, 0)
        twin[U(new + 1)] = beyond
        twin[U(beyond)] = new + 1
        twin[U(new + 2)] = g1
        twin[U(g1)] = new + 2
        face[U(new >> 2)] = face[U(g >> 2)]
        vertex_edge[U(t)] = new + 1
    vertex_edge[U(m)] = first
    twin[U(e)] = second
    twin[U(second)] = e
    twin[U(f)] = first
    twin[U(first)] = f


@kernel
def enqueue(queue, state, e):
    """Add a half-edge at the end of the queue."""
    queue[U((state[HEAD] + state[WAITING]) % len(queue))] = e
    state[WAITING] += 1


@kernel
def is_left(xy, a, b, q, work):
    """Whether vertex q is strictly left of the line from a to b."""
    return (
        side_of(xy[U(2 * a)], xy[U(2 * a + 1)], xy[U(2 * b)], xy[U(2 * b + 1)], xy[U(2 * q)], xy[U(2 * q + 1)], work)
        > 0
    )


@kernel
def conform(
    xy, origin, twin, piece_of, face, vertex_edge, pieces, acute, queue, stack, work, state, steps
):  # fmt: skip
    """Split pieces from the queue, and those that this affects, until about ``steps`` edges were looked at."""
    depth = int(state[DEPTH])
    done = 0
    while depth > 0 or state[WAITING] > 0:
        if done > steps:
            state[DEPTH] = depth
            return MORE
        done += 1
        splitting = depth == 0
        if splitting:
            if (
                2 * state[VERTICES] + 2 > len(xy)
                or 4 * state[TRIANGLES] + 8 > len(origin)
                or state[WAITING] + 8 >= len(queue)
            ):
                state[DEPTH] = depth
                return FULL
            e = int(queue[U(state[HEAD])])
            state[HEAD] = (state[HEAD] + 1) % len(queue)
            state[WAITING] -= 1
            if is_constrained(origin, e) == 0:
                continue  # flips have moved the piece, and noted where to
        else:
            if depth + 8 >= len(stack) or state[WAITING] + 8 >= len(queue):
                state[DEPTH] = depth
                return FULL
            depth -= 1
            e = int(stack[U(depth)])
            if is_constrained(origin, e):
                enqueue(queue, state, e)
                continue
        f = int(twin[U(e)])
        u = int(origin[U(e)])
        w = int(origin[U(f)])
        p = int(origin[U(previous_edge(e))])
        v = int(origin[U(previous_edge(f))])
        if (u | w | p | v) < 0:
            continue
        ux = xy[U(2 * u)]
        uy = xy[U(2 * u + 1)]
        wx = xy[U(2 * w)]
        wy = xy[U(2 * w + 1)]
        px = xy[U(2 * p)]
        py = xy[U(2 * p + 1)]
        vx = xy[U(2 * v)]
        vy = xy[U(2 * v + 1)]
        if not circle_side(ux, uy, wx, wy, px, py, vx, vy, work) > 0.0:
            continue
        if not splitting:
            flip(origin, twin, piece_of, vertex_edge, e)
            stack[U(depth)] = e
            stack[U(depth + 1)] = previous_edge(e)
            stack[U(depth + 2)] = f
            stack[U(depth + 3)] = previous_edge(f)
            depth += 4
            continue
        m = int(state[VERTICES])
        a = int(pieces[U(piece_of[U(e)]), 0])
        b = int(pieces[U(piece_of[U(e)]), 1])
        x, y = split_place(xy, u, w, a, b, acute[U(a)], acute[U(b)])
        xy[U(2 * m)] = x
        xy[U(2 * m + 1)] = y
        if not (
            is_left(xy, p, u, m, work) and is_left(xy, w, p, m, work)
            and is_left(xy, u, v, m, work) and is_left(xy, v, w, m, work)
        ):  # fmt: skip
            state[STUCK] += 1
            continue
        slot = int(state[TRIANGLES])
        split_edge(origin, twin, piece_of, face, vertex_edge, e, m, slot)
        state[VERTICES] = m + 1
        state[TRIANGLES] = slot + 2
        stack[0] = previous_edge(e)
        stack[1] = 4 * slot + 1
        stack[2] = previous_edge(f)
        stack[3] = 4 * slot + 5
        depth = 4
        enqueue(queue, state, e)
        enqueue(queue, state, 4 * slot)
    state[DEPTH] = 0
    return DONE
