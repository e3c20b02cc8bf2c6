"""Kernels of Delaunay triangulation in the plane: insertion with exact predicates, point location, canonical cells.

References
----------
A. Bowyer, "Computing Dirichlet tessellations", and D. F. Watson, "Computing the n-dimensional Delaunay tessellation",
Computer Journal 24 (1981). J. R. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric
predicates", Discrete Comput. Geom. 18 (1997), for the filters. C. Marot, J. Pellerin, J.-F. Remacle, "One machine, one
minute, three billion tetrahedra", Int. J. Numer. Meth. Engng 117 (2019), for the partition among threads.
"""

from .._numba import kernel
from ..geometry._predicates_kernels import ORIENT2D_BOUND
from ._half_edge_kernels import (
    CIRCLE_BOUND,
    DEAD,
    DONE,
    FULL,
    MORE,
    U,
    exact_side,
    next_edge,
    perturbed_circle_side,
    previous_edge,
    side_of,
)

# Places in the state of `insert_points`: the next entry of the list of points, the next free slot and the end of the
# free slots, the half-edge where walks start, how many points were put off, and the steps made so far.
NEXT, TRIANGLES, SLOT_END, START, DEFERRED, STEPS, STATE_SIZE = 0, 1, 2, 3, 4, 5, 6
# What `insert_points` answers beside `DONE`, `MORE` and `FULL`: all free slots are used.
NO_SLOTS = 4


@kernel
def first_triangle(xy, origin, twin, work):
    """Write the counter-clockwise triangle of the first two vertices and the first that is not on their line.

    Three ghosts are around it. The answer is that vertex; 0 if all are on the line, then nothing is written.
    """
    for v in range(2, len(xy) // 2):
        side = side_of(xy[U(0)], xy[U(1)], xy[U(2)], xy[U(3)], xy[U(2 * v)], xy[U(2 * v + 1)], work)
        if side != 0.0:
            corners = (0, 1, v) if side > 0.0 else (1, 0, v)
            for k in range(3):
                after, before = (k + 1) % 3, (k + 2) % 3
                ghost = 4 * (k + 1)
                origin[U(k)] = corners[k]
                twin[U(k)] = ghost
                origin[U(ghost)] = corners[after]
                origin[U(ghost + 1)] = corners[k]
                origin[U(ghost + 2)] = -1
                twin[U(ghost)] = k
                twin[U(ghost + 1)] = 4 * (before + 1) + 2
                twin[U(ghost + 2)] = 4 * (after + 1) + 1
            return v
    return 0


@kernel
def list_in_rounds(n, third, coarse, fine, todo):
    """List the vertices below n but 0, 1 and ``third``: every so many, of the others every so many, then the rest.

    ``fine`` divides ``coarse``. The answer is how many are in the first round.
    """
    count = 0
    for v in range(0, n, coarse):
        if v > 1 and v != third:
            todo[U(count)] = v
            count += 1
    first = count
    for v in range(0, n, fine):
        if v % coarse != 0 and v > 1 and v != third:
            todo[U(count)] = v
            count += 1
    for v in range(2, n):
        if v % fine != 0 and v != third:
            todo[U(count)] = v
            count += 1
    return first


@kernel
def insert_points(
    xy, order, origin, twin, todo, low, high, work, stack, ring, ring_from, cavity, state, steps
):  # fmt: skip
    """Insert the vertices that ``todo`` lists by Bowyer-Watson, until about ``steps`` triangles were looked at.

    A triangle is in conflict if the vertex is inside its circle, ties broken by `perturbed_circle_side`; a ghost if it
    is strictly beyond the hull edge or on the open edge. With exact signs the cavity is then star-shaped for any input.

    Only triangles whose corners are all in ``low <= vertex < high`` are touched (the infinite vertex is -1). A vertex
    that needs others is put off: the front of ``todo`` is overwritten by those. A triangle with corners of two owners
    is changed by none, and of a record each word is written by one owner, so threads may work on disjoint ranges.
    A vertex at the place of another, v, is put off, too, and gets the number ~v in ``order``.

    In one piece although long: the coordinates stay in registers, and each part is compiled once.
    """
    room = len(cavity) - 8
    entry = int(state[NEXT])
    count = int(state[TRIANGLES])
    start = int(state[START])
    deferred = int(state[DEFERRED])
    spent = 0
    status = DONE
    while entry < len(todo):
        if spent > steps:
            status = MORE
            break
        if count + 2 > state[SLOT_END]:
            status = NO_SLOTS
            break
        p = int(todo[U(entry)])
        qx = xy[U(2 * p)]
        qy = xy[U(2 * p + 1)]
        # Locate: walk from the triangle made last; points come along a curve, so it is near.
        e = start
        a = int(origin[U(e)])
        b = int(origin[U(next_edge(e))])
        adx = xy[U(2 * a)] - qx
        ady = xy[U(2 * a + 1)] - qy
        bdx = xy[U(2 * b)] - qx
        bdy = xy[U(2 * b + 1)] - qy
        if side_of(xy[U(2 * a)], xy[U(2 * a + 1)], xy[U(2 * b)], xy[U(2 * b + 1)], qx, qy, work) < 0.0:
            e = int(twin[U(e)])
            adx, bdx = bdx, adx
            ady, bdy = bdy, ady
        owned = True
        same = -1
        while True:
            # The point is left of or on (a, b). Both other edges are looked at without a branch between them, which
            # could not be predicted.
            spent += 1
            c = int(origin[U(previous_edge(e))])
            if c < low or c >= high:
                owned = False
                break
            if c < 0:
                break
            cdx = xy[U(2 * c)] - qx
            cdy = xy[U(2 * c + 1)] - qy
            left = bdx * cdy
            right = bdy * cdx
            beyond_bc = left - right
            if abs(beyond_bc) <= ORIENT2D_BOUND * (abs(left) + abs(right)):
                beyond_bc = exact_side(xy, int(origin[U(next_edge(e))]), c, p, work)
            left = cdx * ady
            right = cdy * adx
            beyond_ca = left - right
            if abs(beyond_ca) <= ORIENT2D_BOUND * (abs(left) + abs(right)):
                beyond_ca = exact_side(xy, c, int(origin[U(e)]), p, work)
            across_bc = int(twin[U(next_edge(e))])
            across_ca = int(twin[U(previous_edge(e))])
            if min(beyond_bc, beyond_ca) >= 0.0:
                if adx == 0.0 and ady == 0.0:
                    same = int(origin[U(e)])
                elif bdx == 0.0 and bdy == 0.0:
                    same = int(origin[U(next_edge(e))])
                elif cdx == 0.0 and cdy == 0.0:
                    same = c
                break
            first = beyond_bc < 0.0
            e = across_bc if first else across_ca
            adx = cdx if first else adx
            ady = cdy if first else ady
            bdx = bdx if first else cdx
            bdy = bdy if first else cdy
        if same >= 0 or not owned:
            todo[U(deferred)] = p
            deferred += 1
            if same >= 0:
                order[U(p)] = ~same
            else:  # the next walk goes on from here, in the triangle before the one that others own
                start = int(twin[U(e)])
            entry += 1
            continue
        # Dig: depth first, which meets the edges of the cavity in counter-clockwise order.
        slot = e & ~3
        cavity[0] = slot
        n_cavity = 1
        stack[0] = slot + 2
        stack[1] = slot + 1
        stack[2] = slot
        depth = 3
        n_ring = 0
        while depth > 0:
            depth -= 1
            f = int(twin[U(int(stack[U(depth)]))])
            f1 = next_edge(f)
            f2 = previous_edge(f)
            a = int(origin[U(f)])
            b = int(origin[U(f1)])
            c = int(origin[U(f2)])
            if (a | b | c) >= 0:
                # The filter of `circle_side`, with one call for all that may come after it.
                adx = xy[U(2 * a)] - qx
                ady = xy[U(2 * a + 1)] - qy
                bdx = xy[U(2 * b)] - qx
                bdy = xy[U(2 * b + 1)] - qy
                cdx = xy[U(2 * c)] - qx
                cdy = xy[U(2 * c + 1)] - qy
                al = adx * adx + ady * ady
                bl = bdx * bdx + bdy * bdy
                cl = cdx * cdx + cdy * cdy
                side = (
                    al * (bdx * cdy - cdx * bdy) + bl * (cdx * ady - adx * cdy) + cl * (adx * bdy - bdx * ady)
                )  # fmt: skip
                if abs(side) <= CIRCLE_BOUND * (al * bl + cl * (al + bl)):
                    side = perturbed_circle_side(xy, order, a, b, c, p, work)
                conflict = side > 0.0
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
                side = side_of(ax, ay, bx, by, qx, qy, work)
                conflict = side > 0.0
                if side == 0.0:
                    if ax != bx:
                        conflict = (ax < qx < bx) or (bx < qx < ax)
                    else:
                        conflict = (ay < qy < by) or (by < qy < ay)
            if conflict:
                # Of the corners only c can belong to another: a and b are corners of a triangle already dug.
                if c < low or c >= high:
                    owned = False
                    break
                if n_cavity >= room:
                    status = FULL
                    break
                cavity[U(n_cavity)] = f & ~3
                n_cavity += 1
                stack[U(depth)] = f2
                stack[U(depth + 1)] = f1
                depth += 2
            else:
                ring[U(n_ring)] = f
                ring_from[U(n_ring)] = b
                n_ring += 1
        if status == FULL:
            break
        spent += n_ring
        entry += 1
        if not owned:
            todo[U(deferred)] = p
            deferred += 1
            continue
        # Fill: one triangle a ring edge; two more than were dug.
        slot = 4 * count
        count += 2
        cavity[U(n_cavity)] = slot
        cavity[U(n_cavity + 1)] = slot + 4
        slot = int(cavity[0])
        before = int(cavity[U(n_ring - 1)])
        a = int(ring_from[0])
        for k in range(n_ring):
            after_k = k + 1 if k + 1 < n_ring else 0
            after = int(cavity[U(after_k)])
            b = int(ring_from[U(after_k)])
            f = int(ring[U(k)])
            origin[U(slot)] = a
            origin[U(slot + 1)] = b
            origin[U(slot + 2)] = p
            twin[U(slot)] = f
            twin[U(f)] = slot
            twin[U(slot + 1)] = after + 2
            twin[U(slot + 2)] = before + 1
            start = slot if (a | b) >= 0 else start
            before = slot
            slot = after
            a = b
    state[NEXT] = entry
    state[TRIANGLES] = count
    state[START] = start
    state[DEFERRED] = deferred
    state[STEPS] += spent
    return status


@kernel
def locate_points(xy, origin, twin, queries, rows, start, cell, found, weights, work):
    """The cell that holds each query, and its barycentric coordinates there, written at the query's row.

    ``cell`` numbers the slots as `canonical_cells` does; ``found`` is -1 outside, where weights are left alone. Of the
    cells that a query on an edge or a vertex belongs to it is the lowest, so that the answer does not depend on the
    walk. ``weights`` refer to the corners of the canonical cell.
    """
    for i in range(len(rows)):
        row = int(rows[U(i)])
        qx = queries[U(2 * i)]
        qy = queries[U(2 * i + 1)]
        e = start
        a = int(origin[U(e)])
        b = int(origin[U(next_edge(e))])
        if side_of(xy[U(2 * a)], xy[U(2 * a + 1)], xy[U(2 * b)], xy[U(2 * b + 1)], qx, qy, work) < 0.0:
            e = int(twin[U(e)])
        inside = True
        while inside:
            a = int(origin[U(e)])
            b = int(origin[U(next_edge(e))])
            c = int(origin[U(previous_edge(e))])
            if c < 0:
                inside = False
            elif side_of(xy[U(2 * b)], xy[U(2 * b + 1)], xy[U(2 * c)], xy[U(2 * c + 1)], qx, qy, work) < 0.0:
                e = int(twin[U(next_edge(e))])
            elif side_of(xy[U(2 * c)], xy[U(2 * c + 1)], xy[U(2 * a)], xy[U(2 * a + 1)], qx, qy, work) < 0.0:
                e = int(twin[U(previous_edge(e))])
            else:
                break
        start = e if inside else int(twin[U(e)])
        if not inside:
            found[U(row)] = -1
            continue
        # Which edges is it on? If one, look across it; if two, look around their common corner.
        best = e >> 2
        on = -1
        zeros = 0
        for _ in range(3):
            a = int(origin[U(e)])
            b = int(origin[U(next_edge(e))])
            if side_of(xy[U(2 * a)], xy[U(2 * a + 1)], xy[U(2 * b)], xy[U(2 * b + 1)], qx, qy, work) == 0.0:
                zeros += 1
                on = e
                if xy[U(2 * a)] == qx and xy[U(2 * a + 1)] == qy:
                    zeros = 3
                    break
            e = next_edge(e)
        if zeros == 1:
            other = int(twin[U(on)]) >> 2
            if cell[U(other)] >= 0 and cell[U(other)] < cell[U(best)]:
                best = other
        elif zeros > 1:
            # Around the vertex a, where ``on`` starts.
            e = on
            while True:
                other = e >> 2
                if cell[U(other)] >= 0 and cell[U(other)] < cell[U(best)]:
                    best = other
                e = int(twin[U(previous_edge(e))])
                if e == on:
                    break
        found[U(row)] = cell[U(best)] >> 2
        turn = cell[U(best)] & 3
        total = 0.0
        for k in range(3):
            a = int(origin[U(4 * best + (k + turn + 1) % 3)])
            b = int(origin[U(4 * best + (k + turn + 2) % 3)])
            area = side_of(xy[U(2 * a)], xy[U(2 * a + 1)], xy[U(2 * b)], xy[U(2 * b + 1)], qx, qy, work)
            weights[U(3 * row + k)] = area
            total += area
        for k in range(3):
            weights[U(3 * row + k)] = weights[U(3 * row + k)] / total + 0.0  # no negative zeros


@kernel
def canonical_cells(origin, n_triangles, place, order, counts, cells, cell):
    """Write the finite triangles in an order that depends on nothing but the set of them; return how many.

    Corners are turned so that the one of lowest place, in ``place`` or, if that is empty, by its number, comes first.
    Triangles go by the places of the first and then of the second corner, which no other triangle shares: a sort by
    counting, and one inside each bucket. Corners are written as ``order`` names them. ``cell``, if it is not empty,
    gets for each slot -1, or 4 times the number of its triangle plus the number of the corner that was turned to the
    front.
    """
    ranked = len(place) > 0
    numbered = len(cell) > 0
    cell[:] = -1
    counts[:] = 0
    for t in range(n_triangles):
        a = int(origin[U(4 * t)])
        b = int(origin[U(4 * t + 1)])
        c = int(origin[U(4 * t + 2)])
        if (a | b | c) >= 0 and origin[U(4 * t + 3)] & DEAD == 0:
            if ranked:
                lowest = min(place[U(a)], place[U(b)], place[U(c)])
            else:
                lowest = min(a, b, c)
            counts[U(lowest + 1)] += 1
    for k in range(1, len(counts)):
        counts[U(k)] += counts[U(k - 1)]
    # The last entry is the number of all; from here on counts[k] runs from the start of bucket k to its end.
    total = int(counts[U(len(counts) - 1)])
    for t in range(n_triangles):
        a = int(origin[U(4 * t)])
        b = int(origin[U(4 * t + 1)])
        c = int(origin[U(4 * t + 2)])
        if (a | b | c) < 0 or origin[U(4 * t + 3)] & DEAD != 0:
            continue
        pa, pb, pc = a, b, c
        if ranked:
            pa = int(place[U(a)])
            pb = int(place[U(b)])
            pc = int(place[U(c)])
        lowest = min(pa, pb, pc)
        turn = 0
        if lowest == pb:
            a, b, c = b, c, a
            pb = pc
            turn = 1
        elif lowest == pc:
            a, b, c = c, a, b
            pb = pa
            turn = 2
        # The slot and the second corner's place stand in the upper halves of two words meanwhile.
        at = int(counts[U(lowest)])
        counts[U(lowest)] = at + 1
        cells[U(at), 0] = ((4 * t + turn) << 32) | a
        cells[U(at), 1] = b
        cells[U(at), 2] = (pb << 32) | c
    first = 0
    for k in range(len(counts) - 1):
        last = int(counts[U(k)])
        # Shell's sort, which for the usual bucket of two is insertion; the hub of a fan may have millions.
        gap = 1
        while 9 * gap < last - first:
            gap = 3 * gap + 1
        while gap > 0:
            for i in range(first + gap, last):
                a = cells[U(i), 0]
                b = cells[U(i), 1]
                c = cells[U(i), 2]
                j = i - gap
                while j >= first and cells[U(j), 2] >> 32 > c >> 32:
                    cells[U(j + gap), 0] = cells[U(j), 0]
                    cells[U(j + gap), 1] = cells[U(j), 1]
                    cells[U(j + gap), 2] = cells[U(j), 2]
                    j -= gap
                cells[U(j + gap), 0] = a
                cells[U(j + gap), 1] = b
                cells[U(j + gap), 2] = c
            gap //= 3
        for i in range(first, last):
            if numbered:
                slot = cells[U(i), 0] >> 32
                cell[U(slot >> 2)] = 4 * i + (slot & 3)
            cells[U(i), 0] = order[U(cells[U(i), 0] & 0xFFFFFFFF)]
            cells[U(i), 1] = order[U(cells[U(i), 1])]
            cells[U(i), 2] = order[U(cells[U(i), 2] & 0xFFFFFFFF)]
        first = last
    return total
