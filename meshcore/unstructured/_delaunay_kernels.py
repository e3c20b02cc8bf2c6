"""Kernels of Delaunay triangulation in the plane: Hilbert order, and insertion point by point with exact predicates.

References
----------
A. Bowyer, "Computing Dirichlet tessellations", and D. F. Watson, "Computing the n-dimensional Delaunay tessellation",
Computer Journal 24 (1981). J. R. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric
predicates", Discrete Comput. Geom. 18 (1997), for the filters. J. Skilling, AIP Conf. Proc. 707 (2004), for the keys.
"""

from .._numba import kernel
from ._half_edge_kernels import DONE, FULL, MORE, U, circle_side, next_edge, previous_edge, side_of

# Places in the state of `insert_points`.
POINT, TRIANGLES, START = 0, 1, 2


@kernel
def hilbert_keys(xy, n, bits, keys):
    """Place of each point along the Hilbert curve on a grid of 2^bits cells a side."""
    low_x = xy[0]
    high_x = low_x
    low_y = xy[1]
    high_y = low_y
    for i in range(n):
        low_x = min(low_x, xy[2 * i])
        high_x = max(high_x, xy[2 * i])
        low_y = min(low_y, xy[2 * i + 1])
        high_y = max(high_y, xy[2 * i + 1])
    side = max(high_x - low_x, high_y - low_y)
    top = (1 << bits) - 1
    scale = top / side if side > 0.0 else 0.0
    for i in range(n):
        x = int((xy[2 * i] - low_x) * scale)
        y = int((xy[2 * i + 1] - low_y) * scale)
        key = 0
        bit = 1 << (bits - 1)
        while bit > 0:
            right = 1 if x & bit else 0
            upper = 1 if y & bit else 0
            key = (key << 2) | ((3 * right) ^ upper)
            if upper == 0:  # turn the quadrant as the curve is turned in it
                if right == 1:
                    x = ~x & top
                    y = ~y & top
                x, y = y, x
            bit >>= 1
        keys[i] = key


@kernel
def insert_points(xy, n, origin, twin, work, stack, ring, ring_from, cavity, duplicate, state, steps):
    """Insert up to ``steps`` points by Bowyer-Watson; ``state`` tells where to go on.

    Points 0, 1, 2 must not be collinear. A triangle is in conflict if the point is strictly inside its circle, a ghost
    if the point is strictly beyond its hull edge or on the open edge; with exact signs the cavity is then star-shaped
    for any input. ``duplicate[p]`` becomes the earlier point at the same place.
    """
    room = len(stack) - 8
    p = int(state[POINT])
    count = int(state[TRIANGLES])
    start = int(state[START])
    last = min(n, p + steps)
    status = DONE if last == n else MORE
    while p < last:
        qx = xy[U(2 * p)]
        qy = xy[U(2 * p + 1)]
        # Locate: walk from the triangle made last; points come in Hilbert order, so it is near.
        e = start
        a = int(origin[U(e)])
        b = int(origin[U(next_edge(e))])
        ax = xy[U(2 * a)]
        ay = xy[U(2 * a + 1)]
        bx = xy[U(2 * b)]
        by = xy[U(2 * b + 1)]
        if side_of(ax, ay, bx, by, qx, qy, work) < 0.0:
            e = int(twin[U(e)])
            ax, bx = bx, ax
            ay, by = by, ay
        same = -1
        while True:
            # The point is left of or on (a, b); look at (b, c), then at (c, a).
            c = int(origin[U(previous_edge(e))])
            if c < 0:
                break
            cx = xy[U(2 * c)]
            cy = xy[U(2 * c + 1)]
            if side_of(bx, by, cx, cy, qx, qy, work) < 0.0:
                e = int(twin[U(next_edge(e))])
                ax = cx
                ay = cy
                continue
            if side_of(cx, cy, ax, ay, qx, qy, work) < 0.0:
                e = int(twin[U(previous_edge(e))])
                bx = cx
                by = cy
                continue
            if ax == qx and ay == qy:
                same = e
            elif bx == qx and by == qy:
                same = next_edge(e)
            elif cx == qx and cy == qy:
                same = previous_edge(e)
            break
        if same >= 0:
            duplicate[U(p)] = origin[U(same)]
            p += 1
            continue
        # Dig: depth first, which meets the edges of the cavity in counter-clockwise order.
        first = e & ~3
        cavity[0] = first
        n_cavity = 1
        stack[0] = first + 2
        stack[1] = first + 1
        stack[2] = first
        depth = 3
        n_ring = 0
        full = False
        while depth > 0:
            depth -= 1
            e = int(stack[U(depth)])
            f = int(twin[U(e)])
            f1 = next_edge(f)
            f2 = previous_edge(f)
            a = int(origin[U(f)])
            b = int(origin[U(f1)])
            c = int(origin[U(f2)])
            if (a | b | c) >= 0:
                ax = xy[U(2 * a)]
                ay = xy[U(2 * a + 1)]
                bx = xy[U(2 * b)]
                by = xy[U(2 * b + 1)]
                conflict = circle_side(ax, ay, bx, by, xy[U(2 * c)], xy[U(2 * c + 1)], qx, qy, work) > 0.0
            else:
                if c < 0:
                    i, j = a, b
                elif a < 0:
                    i, j = b, c
                else:
                    i, j = c, a
                ax = xy[U(2 * i)]
                ay = xy[U(2 * i + 1)]
                bx = xy[U(2 * j)]
                by = xy[U(2 * j + 1)]
                det = side_of(ax, ay, bx, by, qx, qy, work)
                conflict = det > 0.0
                if det == 0.0:
                    if ax != bx:
                        conflict = (ax < qx < bx) or (bx < qx < ax)
                    else:
                        conflict = (ay < qy < by) or (by < qy < ay)
            if conflict:
                cavity[U(n_cavity)] = f & ~3
                n_cavity += 1
                stack[U(depth)] = f2
                stack[U(depth + 1)] = f1
                depth += 2
            else:
                ring[U(n_ring)] = f
                ring_from[U(n_ring)] = origin[U(e)]
                n_ring += 1
            if n_ring >= room or depth >= room or n_cavity >= room:
                full = True
                break
        if full:
            status = FULL
            break
        # Fill: one triangle a ring edge; two more than were dug.
        cavity[U(n_cavity)] = 4 * count
        cavity[U(n_cavity + 1)] = 4 * count + 4
        count += 2
        slot = int(cavity[0])
        before = int(cavity[U(n_ring - 1)])
        for k in range(n_ring):
            after_k = k + 1 if k + 1 < n_ring else 0
            after = int(cavity[U(after_k)])
            a = int(ring_from[U(k)])
            b = int(ring_from[U(after_k)])
            f = int(ring[U(k)])
            origin[U(slot)] = a
            origin[U(slot + 1)] = b
            origin[U(slot + 2)] = p
            twin[U(slot)] = f
            twin[U(f)] = slot
            twin[U(slot + 1)] = after + 2
            twin[U(slot + 2)] = before + 1
            if (a | b) >= 0:
                start = slot
            before = slot
            slot = after
        p += 1
    state[POINT] = p
    state[TRIANGLES] = count
    state[START] = start
    return status
