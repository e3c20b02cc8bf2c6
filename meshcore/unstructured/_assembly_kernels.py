"""Kernels over whole triangulations: how many triangles limits will make; used vertices numbered, cells by these."""

import math

from .._numba import kernel
from ._half_edge_kernels import CONSTRAINED, DEAD, U, is_constrained, next_edge, previous_edge

UNUSED, USED = -1, -2
# A triangle is a needle if its longest edge is so many times as long as its shortest.
_NEEDLE = 8.0
# Triangles between two lines that are near each other, per length over width, for each of the two needles there.
_PER_SQUARE = 0.5


@kernel
def areas_kept(xy, origin, n_triangles, face, keep, area_limit):
    """The area of the faces that are kept, and the sum of the shares of the limits, both of them twice the area."""
    total = 0.0
    shares = 0.0
    for t in range(n_triangles):
        a = origin[U(4 * t)]
        b = origin[U(4 * t + 1)]
        c = origin[U(4 * t + 2)]
        f = face[U(t)]
        if (a | b | c) >= 0 and keep[U(f)]:
            ax = xy[U(2 * a)]
            ay = xy[U(2 * a + 1)]
            area = (xy[U(2 * b)] - ax) * (xy[U(2 * c + 1)] - ay) - (xy[U(2 * b + 1)] - ay) * (xy[U(2 * c)] - ax)
            total += area
            shares += area / area_limit[U(f)]
    return total, shares


@kernel
def common_limit(area_limit, keep):
    """The limit of the faces that are kept if they have but one, else -1."""
    found = -1.0
    for f in range(len(keep)):
        if keep[U(f)]:
            if found >= 0.0 and area_limit[U(f)] != found:
                return -1.0
            found = area_limit[U(f)]
    return found


@kernel
def sharp_end(xy, origin, e):
    """For a needle with the longest edge e, up to rounding, whether its tip is where e starts (0) or ends (1); else -1.

    The second answer is the longer of its other edges, the third the length of e, the fourth the height over it.
    """
    after = next_edge(e)
    before = previous_edge(e)
    a = origin[U(e)]
    b = origin[U(after)]
    c = origin[U(before)]
    ux = xy[U(2 * b)] - xy[U(2 * a)]
    uy = xy[U(2 * b + 1)] - xy[U(2 * a + 1)]
    vx = xy[U(2 * c)] - xy[U(2 * a)]
    vy = xy[U(2 * c + 1)] - xy[U(2 * a + 1)]
    whole = math.sqrt(ux * ux + uy * uy)
    to_a = math.sqrt(vx * vx + vy * vy)
    to_b = math.sqrt((vx - ux) ** 2 + (vy - uy) ** 2)
    if (1.0 + 1e-9) * whole < max(to_a, to_b) or whole < _NEEDLE * min(to_a, to_b):
        return -1, e, whole, 0.0
    height = (ux * vy - uy * vx) / whole
    return (0, before, whole, height) if to_a > to_b else (1, after, whole, height)


@kernel
def narrow_parts(xy, origin, twin, n_triangles):
    """Triangles that an angle will make between lines near each other; the least width there, and the length of it.

    Such a part shows as two needles side by side, tip to tail, each with a line along its other long edge: the width
    is then the same all along. Needles that spread from a small feature get fewer points, of growing distances.
    """
    total = 0.0
    width = math.inf
    length = 0.0
    for t in range(n_triangles):
        flags = origin[U(4 * t + 3)]
        if flags & DEAD or flags & CONSTRAINED == 0:
            continue
        for e in range(4 * t, 4 * t + 3):
            f = int(twin[U(e)])
            if f < 0 or is_constrained(origin, e):
                continue
            tip, along, whole, height = sharp_end(xy, origin, e)
            if tip < 0 or not is_constrained(origin, along):
                continue
            other_tip, along, _, other = sharp_end(xy, origin, f)
            if other_tip == tip and is_constrained(origin, along):
                height = max(height, other)
                total += _PER_SQUARE * whole / height
                if height < width:
                    width = height
                    length = whole
    return total, width, length


@kernel
def number_corners(corners, order, source, vertex_at, number, kept):
    """Number the vertices with a triangle that stand for input points, in the order of these; mark others as `USED`.

    ``order`` is the point of the graph under each vertex that refinement has not added, ``source`` the input point
    that this is, ascending, but -1 for points without. ``vertex_at`` is as long as ``source``. ``kept`` gets the input
    points. The answers are how many these are, and how many vertices others.
    """
    number[:] = UNUSED
    vertex_at[:] = UNUSED
    used = 0
    for t in range(len(corners)):
        for k in range(3):
            v = corners[U(t), U(k)]
            if number[U(v)] == UNUSED:
                number[U(v)] = USED
                used += 1
    for v in range(len(order)):
        if number[U(v)] == USED:
            vertex_at[U(order[U(v)])] = v
    count = 0
    for p in range(len(source)):
        v = vertex_at[U(p)]
        if v >= 0 and source[U(p)] >= 0:
            number[U(v)] = count
            kept[U(count)] = source[U(p)]
            count += 1
    return count, used - count


@kernel
def number_rest(xy, first, number, places):
    """Number the vertices that are `USED` from ``first`` on, and write their places."""
    count = 0
    for v in range(len(number)):
        if number[U(v)] == USED:
            number[U(v)] = first + count
            places[U(count), U(0)] = xy[U(v), U(0)]
            places[U(count), U(1)] = xy[U(v), U(1)]
            count += 1


@kernel
def renumber(corners, number, cells):
    """Write triangles by the numbers of their corners."""
    for t in range(len(corners)):
        for k in range(3):
            cells[U(t), U(k)] = number[U(corners[U(t), U(k)])]
