"""Fronts of planar marching grids: their ghosts at ends and cuts, their frame of tangents, and the test for folds.

A front is a (2, n + 4) array with two ghosts at either end: its point k stands at k + 2. Ghosts are copies across the
cut of a closed front, mirror images at a plane of symmetry, and on the end's straight continuation elsewhere.
"""

import math

from ..._numba import kernel

CLOSED, FREE, MIRROR, ALONG, ON_CURVE, SPLAY = range(6)
TINY = 1e-300
CORNER = 0.5  # turn (radians) from which on a point is a corner, whose normal is the bisector
# Rows of the scratch array, of n + 4 columns; those of vectors, SPARE and WALL (its ends) are the first of 2, 4, 2.
SPACING, TURN, HEIGHT, BEFORE, AFTER, TURNED, BOOST, ASKED, CORNERS, LEAD = range(10)
TANGENT, START, BEST, PIN, TOWARDS, SPARE, WALL, FIRST_SPACING, ROWS = 10, 12, 14, 16, 18, 20, 24, 26, 27


@kernel
def ghosts(r, kind, frame):
    """Fill the ghosts of a front: row 0 of ``kind`` and ``frame`` is the first end, row 1 the last."""
    n = r.shape[1] - 4
    for end in range(2):
        a, step = (2, 1) if end == 0 else (n + 1, -1)
        for k in range(1, 3):
            to = a - k * step
            if kind[end] == CLOSED:
                source = to + n if end == 0 else to - n
                r[0, to] = r[0, source]
                r[1, to] = r[1, source]
            elif kind[end] == MIRROR:  # across the line through the end along ``frame``
                x, y = r[0, a + k * step] - r[0, a], r[1, a + k * step] - r[1, a]
                along = 2 * (x * frame[end, 0] + y * frame[end, 1])
                r[0, to] = r[0, a] - x + along * frame[end, 0]
                r[1, to] = r[1, a] - y + along * frame[end, 1]
            else:
                r[0, to] = 2 * r[0, a] - r[0, a + k * step]
                r[1, to] = 2 * r[1, a] - r[1, a + k * step]


@kernel
def frame_of(r, t, s, turn):
    """Unit tangents, spacing and turning of a front with its ghosts: at all its points and one beyond.

    On smooth fronts the tangent is that of the parabola through three points; at corners it halves the angle, so that
    the metric does not vanish at a sharp edge (Chan and Steger's correction at convex corners).
    """
    n = r.shape[1]
    for k in range(1, n - 1):
        bx, by = r[0, k] - r[0, k - 1], r[1, k] - r[1, k - 1]
        ax, ay = r[0, k + 1] - r[0, k], r[1, k + 1] - r[1, k]
        b, a = math.sqrt(bx * bx + by * by) + TINY, math.sqrt(ax * ax + ay * ay) + TINY
        bx, by, ax, ay = bx / b, by / b, ax / a, ay / a
        cross, dot = bx * ay - by * ax, bx * ax + by * ay
        angle = math.atan2(cross, dot)
        share = min(1.0, abs(angle) / CORNER)  # 0 on a straight front, 1 at corners
        wb = share + (1 - share) * 2 * a / (a + b)
        wa = share + (1 - share) * 2 * b / (a + b)
        x, y = wb * bx + wa * ax, wb * by + wa * ay
        size = math.sqrt(x * x + y * y)
        if size > 1e-6:
            t[0, k], t[1, k] = x / size, y / size
        else:  # a cusp: the front turns back upon itself
            t[0, k], t[1, k] = by, -bx
            if cross > 0:
                t[0, k], t[1, k] = -by, bx
        s[k] = 0.5 * (a + b)
        turn[k] = angle


@kernel
def fill(values, kind):
    """Ghosts of a scalar along a front: copies across the cut, or mirrored at ends."""
    n = values.size - 4
    for end in range(2):
        a, step = (2, 1) if end == 0 else (n + 1, -1)
        for k in range(1, 3):
            to = a - k * step
            if kind[end] == CLOSED:
                values[to] = values[to + n if end == 0 else to - n]
            else:
                values[to] = values[a + k * step]


@kernel
def smoothed(values, other, kind, passes):
    """``values`` (with two ghosts at either end) after so many passes of (1, 2, 1) / 4, in place."""
    n = values.size
    for _ in range(passes):
        fill(values, kind)
        for k in range(1, n - 1):
            other[k] = 0.25 * (values[k - 1] + 2 * values[k] + values[k + 1])
        for k in range(1, n - 1):
            values[k] = other[k]
    fill(values, kind)


@kernel
def means(s, turn, closed):
    """Mean spacing and turning along a front; the ends of an open one count half."""
    n = s.size - 4
    length, angle = 0.0, 0.0
    for k in range(2, n + 2):
        share = 0.5 if not closed and (k == 2 or k == n + 1) else 1.0
        length += share * s[k]
        angle += share * turn[k]
    count = n if closed else n - 1
    return length / count, angle / count


@kernel
def copy(source, target):
    """Copy one front to another."""
    for c in range(2):
        for k in range(source.shape[1]):
            target[c, k] = source[c, k]


@kernel
def worst_corner(r, d, closed, bad):
    """The least sine of a corner's angle of the cells between a front and r + d, and where; each cell's in ``bad``."""
    n = d.shape[0]
    worst = 1.0
    place = -1
    for k in range(n if closed else n - 1):
        q = k + 1 if k + 1 < n else 0
        ax, ay, bx, by = r[0, k + 2], r[1, k + 2], r[0, q + 2], r[1, q + 2]
        ux, uy = bx - ax, by - ay
        lx, ly, rx, ry = d[k, 0], d[k, 1], d[q, 0], d[q, 1]
        vx, vy = ux + rx - lx, uy + ry - ly
        u, v = math.sqrt(ux * ux + uy * uy), math.sqrt(vx * vx + vy * vy)
        left, right = math.sqrt(lx * lx + ly * ly), math.sqrt(rx * rx + ry * ry)
        least = min(
            min((ux * ly - uy * lx) / (u * left + TINY), (ux * ry - uy * rx) / (u * right + TINY)),
            min((vx * ly - vy * lx) / (v * left + TINY), (vx * ry - vy * rx) / (v * right + TINY)),
        )
        bad[k + 2] = least
        if not least >= worst:
            worst = least
            place = k
    return worst, place
