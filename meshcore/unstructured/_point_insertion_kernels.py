"""Kernels that put one point into a constrained Delaunay triangulation in place: walk, dig the cavity, fill it.

Between digging and filling the caller looks at the cavity and may give the point up; nothing has been changed then.

References
----------
A. Bowyer, Computer Journal 24 (1981); D. F. Watson, ibid. P. L. George, H. Borouchaki, "Delaunay Triangulation and
Meshing" (1998), section 2.5: cavities that stop at constrained edges.
"""

from .._numba import kernel
from ._half_edge_kernels import U, circle_side, is_constrained, next_edge, previous_edge, side_of


@kernel(inline=True)
def walk(start, qx, qy, xy, origin, twin, work):
    """Go from a triangle to the one that holds q; the half-edge last entered, and the segment in the way or under q.

    Without such a segment the second answer is -1.
    """
    e = start
    entered = -1
    while True:
        crossing = -1
        hit = -1
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
            return e, hit
        if is_constrained(origin, crossing):
            return e, crossing
        entered = int(twin[U(crossing)])
        e = entered


@kernel(inline=True)
def look_across(start, cavity, stack):
    """Begin a cavity with one triangle, for `dig`: the depth of the stack."""
    cavity[0] = start
    stack[0] = start + 2
    stack[1] = start + 1
    stack[2] = start
    return 3


@kernel(inline=True)
def look_beside(own, n_cavity, cavity, stack):
    """Add the triangle left of ``own`` to a cavity, which `dig` does not cross: the depth of the stack."""
    cavity[U(n_cavity)] = own & ~3
    stack[0] = previous_edge(own)
    stack[1] = next_edge(own)
    return 2


@kernel
def dig(depth, n_cavity, n_ring, qx, qy, xy, origin, twin, cavity, stack, ring, ring_from, work):
    """Gather the triangles whose circles hold q, as far as it sees them; their number, and that of the ring's edges.

    Depth first over edges that are no segments, which meets the ring counter-clockwise; ``stack`` holds those to begin
    with. ``cavity`` gets the slots, ``ring`` the edges around them, seen from inside, ``ring_from`` their origins, all
    behind what they have already. The second answer is -1 if the buffers are too small.
    """
    room = len(ring) - 8
    while depth > 0:
        depth -= 1
        e = int(stack[U(depth)])
        a = int(origin[U(e)])
        f = -1
        if is_constrained(origin, e) == 0:
            f = int(twin[U(e)])
            b = int(origin[U(f)])
            c = int(origin[U(previous_edge(f))])
            side = circle_side(
                xy[U(2 * b)], xy[U(2 * b + 1)], xy[U(2 * a)], xy[U(2 * a + 1)], xy[U(2 * c)], xy[U(2 * c + 1)],
                qx, qy, work,
            )  # fmt: skip
            if side <= 0.0:
                f = -1
        if f >= 0:
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
            return n_cavity, -1
    return n_cavity, n_ring


@kernel(inline=True)
def fill(new, n_ring, origin, twin, piece_of, face, cavity, stack, ring, ring_from):
    """Replace a cavity that `dig` found by triangles from its ring to the vertex ``new``.

    ``cavity`` has a slot for each, those of the old triangles first. The stamps grow.
    """
    for k in range(n_ring):  # what the ring's edges carry, before slots are written over
        e = int(ring[U(k)])
        flags = int(origin[U(e | 3)])
        stack[U(4 * k)] = twin[U(e)]
        stack[U(4 * k + 1)] = ((flags >> (e & 3)) & 1) | (((flags >> (4 + (e & 3))) & 1) << 4)
        stack[U(4 * k + 2)] = piece_of[U(e)]
        stack[U(4 * k + 3)] = face[U(e >> 2)]
    slot = int(cavity[0])
    before = int(cavity[U(n_ring - 1)])
    for k in range(n_ring):
        after_k = k + 1 if k + 1 < n_ring else 0
        after = int(cavity[U(after_k)])
        origin[U(slot)] = ring_from[U(k)]
        origin[U(slot + 1)] = ring_from[U(after_k)]
        origin[U(slot + 2)] = new
        origin[U(slot + 3)] = stack[U(4 * k + 1)]
        f = int(stack[U(4 * k)])
        twin[U(slot)] = f
        if f >= 0:
            twin[U(f)] = slot
        piece_of[U(slot)] = stack[U(4 * k + 2)]
        twin[U(slot + 1)] = after + 2
        twin[U(slot + 2)] = before + 1
        twin[U(slot + 3)] += 1
        face[U(slot >> 2)] = stack[U(4 * k + 3)]
        before = slot
        slot = after
