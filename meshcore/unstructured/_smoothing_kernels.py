"""Kernels of guarded smoothing: a vertex moves only if the smallest angle around it grows; then flips to Delaunay.

Of a triangle the squared sine of the smallest angle is compared: with edges a <= b <= c it is (2 area / (b c))^2. The
smallest angle of a star is a quasiconcave function of its centre (Amenta, Bern, Eppstein), so a local search finds
the best place. Flips to Delaunay never make the smallest angle of a quadrilateral smaller (Lawson), so neither part of
a round can make the mesh's smallest angle smaller.

References
----------
L. A. Freitag, "On combining Laplacian and optimization-based mesh smoothing techniques", AMD-220 (1997).
N. Amenta, M. Bern, D. Eppstein, "Optimal point placement for mesh smoothing", J. Algorithms 30 (1999).
C. L. Lawson, "Software for C1 surface interpolation", Mathematical Software III (1977).
"""

import math

from .._numba import kernel
from ._half_edge_kernels import (
    DEAD,
    DONE,
    FULL,
    MORE,
    U,
    circle_side,
    flip,
    is_constrained,
    next_edge,
    previous_edge,
    side_of,
)

# Vertices with more neighbours than this stay where they are; a Delaunay mesh of quality has none.
MOST_NEIGHBOURS = 60
# Places in the state of `flip_to_delaunay`.
TRIANGLE, DEPTH, FLIPS = 0, 1, 2
# The local search: first step as a share of the distance to the nearest neighbour, and how often it is halved.
FIRST_STEP = 0.25
HALVINGS = 5


@kernel
def link(origin, twin, n_triangles, edge_limit, fixed, reach2, vertex_edge):
    """Note one half-edge from each vertex, fix vertices on segments and borders, and how far neighbours may be.

    ``edge_limit`` holds the squared longest edge allowed in each triangle; with none, edges may grow.
    """
    for t in range(n_triangles):
        if origin[U(4 * t + 3)] & DEAD:
            continue
        for k in range(3):
            e = 4 * t + k
            a = int(origin[U(e)])
            vertex_edge[U(a)] = e
            if is_constrained(origin, e) or twin[U(e)] < 0:
                fixed[U(a)] = 1
                fixed[U(int(origin[U(next_edge(e))]))] = 1
            if len(edge_limit):
                reach2[U(a)] = min(reach2[U(a)], edge_limit[U(t)])


@kernel
def worst_angle(px, py, ring, n, reach2, most_area):
    """Squared sine of the smallest angle in the star of p; negative if p does not see the ring, or a limit is passed.

    ``reach2`` limits the squared distance from p to the ring, ``most_area`` twice the area of a triangle.
    """
    worst = 1.0
    ax = ring[U(2 * n - 2)] - px
    ay = ring[U(2 * n - 1)] - py
    a2 = ax * ax + ay * ay
    for k in range(n):
        bx = ring[U(2 * k)] - px
        by = ring[U(2 * k + 1)] - py
        b2 = bx * bx + by * by
        area = ax * by - ay * bx
        if not area > 0.0 or area > most_area or b2 > reach2:
            return -1.0
        c2 = (bx - ax) * (bx - ax) + (by - ay) * (by - ay)
        # The two longer edges.
        product = max(a2, b2) * max(min(a2, b2), c2)
        worst = min(worst, area * area / product)
        ax = bx
        ay = by
        a2 = b2
    return worst


@kernel
def smooth(
    xy,
    origin,
    twin,
    face,
    vertex_edge,
    fixed,
    restless,
    moved,
    reach2,
    area_limit,
    poor,
    good,
    ring,
    around,
    work,
    first,
    last,
):
    """Move free, restless vertices from ``first`` to ``last`` where that makes their smallest angle larger; how many.

    Each goes to the mean of its neighbours (survey, 3.2.6) if that is better; where the squared sine stays below
    ``poor``, a local search over eight directions with halved steps goes on from the better place. Stars above
    ``good`` are left alone. ``reach2`` holds the squared longest edge that each vertex may have, ``area_limit`` twice
    the largest area in each face; empty means any.
    A vertex that moved makes itself and its neighbours restless; one that was looked at rests.
    """
    count = 0
    for v in range(first, last):
        if restless[U(v)] == 0 or fixed[U(v)] or vertex_edge[U(v)] < 0:
            continue
        restless[U(v)] = 0
        px = xy[U(2 * v)]
        py = xy[U(2 * v + 1)]
        n = 0
        sx = 0.0
        sy = 0.0
        nearest2 = math.inf
        first_edge = int(vertex_edge[U(v)])
        e = first_edge
        while n < MOST_NEIGHBOURS:
            a = int(origin[U(next_edge(e))])
            ax = xy[U(2 * a)]
            ay = xy[U(2 * a + 1)]
            around[U(n)] = a
            ring[U(2 * n)] = ax
            ring[U(2 * n + 1)] = ay
            sx += ax - px
            sy += ay - py
            nearest2 = min(nearest2, (ax - px) ** 2 + (ay - py) ** 2)
            n += 1
            e = int(twin[U(previous_edge(e))])
            if e == first_edge:
                break
        if e != first_edge:
            continue
        limit2 = reach2[U(v)] if len(reach2) else math.inf
        most_area = area_limit[U(face[U(first_edge >> 2)])] if len(area_limit) else math.inf
        old = worst_angle(px, py, ring, n, math.inf, math.inf)
        if old > good:
            continue
        best = old
        bx = px
        by = py
        x = px + sx / n
        y = py + sy / n
        here = worst_angle(x, y, ring, n, limit2, most_area)
        if here > best:
            best = here
            bx = x
            by = y
        if best < poor:
            step = FIRST_STEP * math.sqrt(nearest2)
            for _ in range(HALVINGS):
                better = True
                tries = 0
                while better and tries < 4:
                    better = False
                    tries += 1
                    cx = bx
                    cy = by
                    for k in range(9):
                        x = cx + step * (k % 3 - 1)
                        y = cy + step * (k // 3 - 1)
                        here = worst_angle(x, y, ring, n, limit2, most_area)
                        if here > best:
                            best = here
                            bx = x
                            by = y
                            better = True
                step *= 0.5
        if best <= old:
            continue
        # The sign of each area, exactly.
        visible = True
        ax = ring[U(2 * n - 2)]
        ay = ring[U(2 * n - 1)]
        for k in range(n):
            x = ring[U(2 * k)]
            y = ring[U(2 * k + 1)]
            visible = visible and side_of(ax, ay, x, y, bx, by, work) > 0.0
            ax = x
            ay = y
        if visible:
            xy[U(2 * v)] = bx
            xy[U(2 * v + 1)] = by
            moved[U(v)] = 1
            restless[U(v)] = 1
            for k in range(n):
                restless[U(around[U(k)])] = 1
            count += 1
    return count


@kernel
def flip_to_delaunay(xy, origin, twin, piece_of, vertex_edge, n_triangles, moved, restless, stack, work, state, steps):
    """Flip edges of triangles with moved vertices until each is locally Delaunay; ``state`` tells where to go on.

    Segments stay. Vertices of flipped triangles get restless.
    """
    t = int(state[TRIANGLE])
    depth = int(state[DEPTH])
    status = DONE
    done = 0
    while t < n_triangles or depth > 0:
        if done >= steps:
            status = MORE
            break
        if depth + 8 > len(stack):
            status = FULL
            break
        done += 1
        if depth == 0:
            a = int(origin[U(4 * t)])
            b = int(origin[U(4 * t + 1)])
            c = int(origin[U(4 * t + 2)])
            if origin[U(4 * t + 3)] & DEAD == 0 and (moved[U(a)] | moved[U(b)] | moved[U(c)]):
                stack[0] = 4 * t
                stack[1] = 4 * t + 1
                stack[2] = 4 * t + 2
                depth = 3
            t += 1
            continue
        depth -= 1
        e = int(stack[U(depth)])
        f = int(twin[U(e)])
        if f < 0 or is_constrained(origin, e):
            continue
        a = int(origin[U(e)])
        b = int(origin[U(f)])
        c = int(origin[U(previous_edge(e))])
        d = int(origin[U(previous_edge(f))])
        inside = circle_side(
            xy[U(2 * a)], xy[U(2 * a + 1)], xy[U(2 * b)], xy[U(2 * b + 1)], xy[U(2 * c)], xy[U(2 * c + 1)],
            xy[U(2 * d)], xy[U(2 * d + 1)], work,
        )  # fmt: skip
        if inside > 0.0:
            flip(origin, twin, piece_of, vertex_edge, e)
            state[FLIPS] += 1
            restless[U(a)] = 1
            restless[U(b)] = 1
            restless[U(c)] = 1
            restless[U(d)] = 1
            stack[U(depth)] = e
            stack[U(depth + 1)] = previous_edge(e)
            stack[U(depth + 2)] = f
            stack[U(depth + 3)] = previous_edge(f)
            depth += 4
    state[TRIANGLE] = t
    state[DEPTH] = depth
    return status
