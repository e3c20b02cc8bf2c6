"""Kernel that finds where a surface of triangles passes through itself."""

import numpy as np

from ..._numba import kernel

U = np.uint64
DEPTH = 64


@kernel
def _pierces(points, a, b, one, two, three):
    """Whether the segment from a to b passes through the triangle (T. Moeller, B. Trumbore, 1997)."""
    ox, oy, oz = points[U(a), 0], points[U(a), 1], points[U(a), 2]
    dx, dy, dz = points[U(b), 0] - ox, points[U(b), 1] - oy, points[U(b), 2] - oz
    px, py, pz = points[U(one), 0], points[U(one), 1], points[U(one), 2]
    ux, uy, uz = points[U(two), 0] - px, points[U(two), 1] - py, points[U(two), 2] - pz
    vx, vy, vz = points[U(three), 0] - px, points[U(three), 1] - py, points[U(three), 2] - pz
    hx, hy, hz = dy * vz - dz * vy, dz * vx - dx * vz, dx * vy - dy * vx
    determinant = ux * hx + uy * hy + uz * hz
    if determinant == 0:
        return False
    sx, sy, sz = ox - px, oy - py, oz - pz
    u = (sx * hx + sy * hy + sz * hz) / determinant
    if u < 0 or u > 1:
        return False
    qx, qy, qz = sy * uz - sz * uy, sz * ux - sx * uz, sx * uy - sy * ux
    v = (dx * qx + dy * qy + dz * qz) / determinant
    if v < 0 or u + v > 1:
        return False
    t = (vx * qx + vy * qy + vz * qz) / determinant
    return 0 <= t <= 1


@kernel
def crossings(first, last, points, edges, triangles, order, right, begin, bounds, stack, crossed):
    """Mark the edges that pass through a triangle with which they share no node.

    Parameters
    ----------
    edges : (m, 2) int
        Of which `first` to `last` are looked at.
    triangles : (t, 3) int
    order, right, begin, bounds
        The alternating digital tree of the triangles' boxes, see its `build`.
    stack : (DEPTH,) int
        Room.
    crossed : (m,) int
        The triangle, or -1; out.
    """
    for e in range(first, last):
        a, b = edges[U(e), 0], edges[U(e), 1]
        crossed[U(e)] = -1
        stack[0] = 0
        waiting = 1
        while waiting > 0 and crossed[U(e)] < 0:
            waiting -= 1
            node = stack[waiting]
            apart = False
            for k in range(3):
                low = min(points[U(a), k], points[U(b), k])
                high = max(points[U(a), k], points[U(b), k])
                apart |= low > bounds[U(6 * node + 3 + k)] or high < bounds[U(6 * node + k)]
            if apart:
                continue
            if right[U(node)] > 0:
                stack[waiting] = right[U(node)]
                stack[waiting + 1] = node + 1
                waiting += 2
                continue
            for item in range(begin[U(node)], begin[U(node)] - right[U(node)]):
                t = order[U(item)]
                one, two, three = triangles[U(t), 0], triangles[U(t), 1], triangles[U(t), 2]
                if a in (one, two, three) or b in (one, two, three):
                    continue
                if _pierces(points, a, b, one, two, three):
                    crossed[U(e)] = t
                    break
