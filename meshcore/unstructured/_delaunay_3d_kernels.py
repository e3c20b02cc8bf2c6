"""Kernels of Delaunay insertion in space (Bowyer 1981, Watson 1981), as a whole or step by step.

A point is put in by a walk to the cell that holds it, by digging (the cells in conflict are marked and the facets
around them listed), and by filling (the cells between the point and those facets take their place). All three are
sections of one kernel, `insert_points`: numba counts references to arrays around each call, and between inlined
functions with loops as well, which would cost half as much again as the work. Other kernels ask it for a single step
of a single point: `DIG`, then look at the cavity, change or refuse it, then `FILL` or `leave`, which leaves no trace.

The layout of the cells, and why signs are right, stands in `_tetrahedra_kernels`.

A thread's lists
----------------
cavity   (size,) cells of the cavity
facets   (8 size,) of each facet around it: word of the neighbour beyond, three corners (as places in ``corners``, the
         infinite vertex last), new cell, region, facet id
corners  (size,) vertices around the cavity
offsets  (4 size,) their coordinates relative to the point, and the squared length
place    (n + threads,) for each vertex its place in ``corners``, valid if that place names the vertex; the infinite
         vertex has an own entry for each thread
edges    (64 * 64,) twins of the new cells' inner facets by the two places of an edge, for cavities of up to 64
         vertices
table    (48 size,) an open-addressed hash of the same, for larger ones

References
----------
C. Marot, J. Pellerin, J.-F. Remacle, "One machine, one minute, three billion tetrahedra", Int. J. Numer. Methods
Eng. 117 (2019).
A. Bowyer, Computer Journal 24 (1981) 162; D. F. Watson, Computer Journal 24 (1981) 167.
"""

import numpy as np

from .._numba import kernel
from ._prefetch_kernels import prefetch
from ._tetrahedra_kernels import (
    CONSTRAINED,
    DONE,
    END,
    FACET_A,
    FACET_B,
    FACET_C,
    FAILED,
    FREE,
    FULL_CAVITY,
    FULL_CELLS,
    HINT,
    MORE,
    NEXT,
    SIDE_LIMIT,
    SPHERE_LIMIT,
    U,
    conflict,
    is_own,
    marked,
    plane_of,
    side,
    sphere_of,
)

# More counters of ``state``: place in the list of points to insert, how many were put off; statistics: steps of walks,
# tests for conflict, cells removed; of the cavity at hand: cells, facets, corners.
POINT, PUT_OFF, STEPS, TESTS, REMOVED, N_CAVITY, N_FACETS, N_CORNERS = 4, 5, 6, 7, 8, 9, 10, 11
STATE_SIZE = 16

SMALL = 64  # vertices around a cavity whose edges fit the matrix of twins
ANY = -1  # the part of a thread that may touch every cell

# What `insert_points` is asked to do.
INSERT, LOCATE, DIG, FILL = 0, 1, 2, 3


@kernel
def leave(cells, cavity, n_cavity):
    """Take the marks of a cavity away: as if nothing had been dug."""
    for j in range(n_cavity):
        i = U(16 * np.int64(cavity[U(j)]))
        cells[i] = marked(cells[i])


@kernel
def is_star_shaped(points, q, facets, n_facets, corners, work):
    """Whether vertex q sees all facets of a cavity from inside: always so without constraints."""
    for j in range(n_facets):
        a = np.int64(corners[U(facets[U(8 * j + 1)])])
        b = np.int64(corners[U(facets[U(8 * j + 2)])])
        c = np.int64(corners[U(facets[U(8 * j + 3)])])
        if c >= 0 and not side(points, q, a, b, c, work) > 0.0:
            return False
    return True


@kernel
def link_by_table(cells, facets, n_facets, n_corners, table):
    """Link the inner facets of a large cavity's new cells, edge by edge, in an open-addressed hash table.

    The table holds an edge's key, then the facet's word; it must have room for 4 times 3 ``n_facets`` entries.
    """
    size = 16
    while size < 12 * n_facets:
        size *= 2
    mask = size - 1
    for i in range(size):
        table[U(2 * i)] = -1
    for j in range(n_facets):
        s = np.int64(facets[U(8 * j + 4)])
        for k in range(3):
            start = np.int64(facets[U(8 * j + 1 + (k + 1) % 3)])
            stop = np.int64(facets[U(8 * j + 1 + (k + 2) % 3)])
            low, high = min(start, stop), max(start, stop)
            key = low * n_corners + high
            at = (key * 0x9E3779B97F4A7C1 >> 20) & mask
            while table[U(2 * at)] >= 0 and table[U(2 * at)] != key:
                at = (at + 1) & mask
            word = s << 3 | (k + 1)
            if table[U(2 * at)] < 0:
                table[U(2 * at)] = key
                table[U(2 * at + 1)] = word
            else:
                other = table[U(2 * at + 1)]
                cells[U(16 * s + 5 + k)] = other
                cells[U(16 * (other >> 3) + 4 + (other & 3))] = word


@kernel
def insert_points(
    points, rows, cells, planes, region, facet_id, cell_of, todo, put_off, fate, part_of, part, infinite_slot,
    cavity, facets, corners, offsets, place, edges, table, work, limits, state, step, chunk,
):  # fmt: skip
    """Insert the vertices of ``todo`` from ``state[POINT]`` on, at most ``chunk`` of them; or do a step of that.

    Parameters
    ----------
    part : int
        `ANY`, or the part of the points all finite corners of a touched cell must be of, by ``part_of``; then points
        that need other cells are written to ``put_off``.
    fate : (number of vertices,) int32
        Receives for each point of ``todo`` the vertex that is at its place already, or stays as it is. With step
        `LOCATE` it receives the cell that holds the point, or a ghost beyond whose facet it lies.
    step : int
        `INSERT`, `LOCATE`, `DIG` (one point: its cavity stays marked and listed, its numbers of cells, facets and
        corners stand in ``state``), `FILL` (that cavity, for the same point).

    Returns
    -------
    int
        `DONE`, `MORE` after a chunk; `FULL_CELLS` or `FULL_CAVITY`: let the buffer grow and call again; `FAILED` if
        the walk found no way, which cannot happen in a Delaunay triangulation (Edelsbrunner 1990).

    Notes
    -----
    Constrained facets are never passed by a cavity; it may then not be star-shaped (`is_star_shaped`).
    """
    side_limit = limits[SIDE_LIMIT]
    sphere_limit = limits[SPHERE_LIMIT]
    most_facets = len(cavity) - 16
    most_steps = len(cells) >> 4
    n = len(todo)
    stop = min(n, state[POINT] + chunk)
    hint = state[HINT]
    n_cavity = state[N_CAVITY]
    n_facets = state[N_FACETS]
    n_corners = state[N_CORNERS]
    walked = 0
    tested = 0
    removed = 0
    status = DONE
    for i in range(state[POINT], stop):
        q = np.int64(todo[U(i)])
        qx, qy, qz = points[U(4 * q)], points[U(4 * q + 1)], points[U(4 * q + 2)]
        if step != FILL:
            # ---- walk, through facets that part the point from the cell; the facet opposite to corner 0, the point
            # that was inserted last, comes last, so that the walk first turns round that point, towards the new one
            t = hint
            if cells[U(16 * t + 3)] < 0:
                t = np.int64(cells[U(16 * t + 7)]) >> 3
            came_by = -1
            steps = 0
            inside = part < 0 or is_own(cells, part_of, part, t)
            while inside:
                o = np.int64(cells[U(16 * t)])
                a = np.int64(cells[U(16 * t + 1)])
                b = np.int64(cells[U(16 * t + 2)])
                c = np.int64(cells[U(16 * t + 3)])
                if c < 0:
                    break
                ox, oy, oz = points[U(4 * o)] - qx, points[U(4 * o + 1)] - qy, points[U(4 * o + 2)] - qz
                ax, ay, az = points[U(4 * a)] - qx, points[U(4 * a + 1)] - qy, points[U(4 * a + 2)] - qz
                bx, by, bz = points[U(4 * b)] - qx, points[U(4 * b + 1)] - qy, points[U(4 * b + 2)] - qz
                cx, cy, cz = points[U(4 * c)] - qx, points[U(4 * c + 1)] - qy, points[U(4 * c + 2)] - qz
                leave_by = -1
                if came_by != 1:
                    turn = bx * (oy * cz - oz * cy) + by * (oz * cx - ox * cz) + bz * (ox * cy - oy * cx)
                    if abs(turn) <= side_limit:
                        turn = side(points, q, b, o, c, work)
                    if turn < 0.0:
                        leave_by = 1
                if leave_by < 0 and came_by != 2:
                    turn = ox * (ay * cz - az * cy) + oy * (az * cx - ax * cz) + oz * (ax * cy - ay * cx)
                    if abs(turn) <= side_limit:
                        turn = side(points, q, o, a, c, work)
                    if turn < 0.0:
                        leave_by = 2
                if leave_by < 0 and came_by != 3:
                    turn = ox * (by * az - bz * ay) + oy * (bz * ax - bx * az) + oz * (bx * ay - by * ax)
                    if abs(turn) <= side_limit:
                        turn = side(points, q, o, b, a, work)
                    if turn < 0.0:
                        leave_by = 3
                if leave_by < 0 and came_by != 0:
                    turn = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
                    if abs(turn) <= side_limit:
                        turn = side(points, q, a, b, c, work)
                    if turn < 0.0:
                        leave_by = 0
                if leave_by < 0:
                    break
                word = np.int64(cells[U(16 * t + 4 + leave_by)])
                t = word >> 3
                came_by = word & 3
                steps += 1
                inside = (part < 0 or is_own(cells, part_of, part, t)) and steps <= most_steps
            walked += steps
            if not inside:
                if part < 0:
                    status = FAILED
                    break
                put_off[U(state[PUT_OFF])] = q
                state[PUT_OFF] += 1
                state[POINT] = i + 1
                continue
            if step == LOCATE:
                fate[U(q)] = t
                hint = t
                state[POINT] = i + 1
                continue
            same = -1
            for k in range(4):
                v = np.int64(cells[U(16 * t + k)])
                if v >= 0 and points[U(4 * v)] == qx and points[U(4 * v + 1)] == qy and points[U(4 * v + 2)] == qz:
                    same = v
            if same >= 0:
                fate[U(q)] = same
                state[POINT] = i + 1
                continue
            # ---- dig, breadth first
            cavity[0] = t
            cells[U(16 * t)] = marked(cells[U(16 * t)])
            n_cavity = 1
            n_facets = 0
            n_corners = 0
            head = 0
            while head < n_cavity and status == DONE:
                t = np.int64(cavity[U(head)])
                head += 1
                for k in range(4):
                    word = np.int64(cells[U(16 * t + 4 + k)])
                    other = word >> 3
                    base = np.int64(cells[U(16 * other)])
                    if word & CONSTRAINED == 0:
                        if base < 0:
                            continue
                        tested += 1
                        x, y, z = qx - points[U(4 * base)], qy - points[U(4 * base + 1)], qz - points[U(4 * base + 2)]
                        j = 8 * other
                        value = (
                            planes[U(j + 4)] * x + planes[U(j + 5)] * y + planes[U(j + 6)] * z
                            + planes[U(j + 7)] * (x * x + y * y + z * z)
                        )  # fmt: skip
                        if abs(value) <= sphere_limit * (abs(x) + abs(y) + abs(z)):
                            value = conflict(points, rows, cells, planes, other, q, work, limits)
                        if value < 0.0:
                            if part >= 0 and not is_own(cells, part_of, part, other):
                                status = MORE
                                break
                            cavity[U(n_cavity)] = other
                            n_cavity += 1
                            for j in range(4, 8):
                                prefetch(cells, 16 * (np.int64(cells[U(16 * other + j)]) >> 3))
                            cells[U(16 * other)] = marked(base)
                            continue
                    facets[U(8 * n_facets)] = word
                    for j in range(3):
                        if j == 0:
                            v = np.int64(cells[U(16 * t + FACET_A[U(k)])])
                        elif j == 1:
                            v = np.int64(cells[U(16 * t + FACET_B[U(k)])])
                        else:
                            v = np.int64(cells[U(16 * t + FACET_C[U(k)])])
                        if v < -1:
                            v = marked(v)
                        slot = v if v >= 0 else infinite_slot
                        at = np.int64(place[U(slot)])
                        if at >= n_corners or corners[U(at)] != v:
                            at = n_corners
                            n_corners += 1
                            corners[U(at)] = v
                            place[U(slot)] = at
                            if v >= 0:
                                x, y, z = points[U(4 * v)] - qx, points[U(4 * v + 1)] - qy, points[U(4 * v + 2)] - qz
                                offsets[U(4 * at)], offsets[U(4 * at + 1)], offsets[U(4 * at + 2)] = x, y, z
                                offsets[U(4 * at + 3)] = x * x + y * y + z * z
                        facets[U(8 * n_facets + 1 + j)] = at
                    if len(region) > 0:
                        facets[U(8 * n_facets + 5)] = region[U(t)]
                    if len(facet_id) > 0:
                        facets[U(8 * n_facets + 6)] = facet_id[U(4 * t + k)]
                    n_facets += 1
                if n_facets >= most_facets or n_cavity >= most_facets or n_corners >= most_facets:
                    status = FULL_CAVITY
            if status == DONE and state[NEXT] + n_facets > state[END]:
                status = FULL_CELLS
            if status != DONE:
                leave(cells, cavity, n_cavity)
                if status != MORE:
                    break
                status = DONE
                put_off[U(state[PUT_OFF])] = q
                state[PUT_OFF] += 1
                state[POINT] = i + 1
                continue
            if step == DIG:
                state[N_CAVITY] = n_cavity
                state[N_FACETS] = n_facets
                state[N_CORNERS] = n_corners
                break
        # ---- fill
        removed += n_cavity
        free = state[FREE]
        unused = state[NEXT]
        small = n_corners <= SMALL
        for j in range(n_facets):
            if j < n_cavity:
                s = np.int64(cavity[U(j)])
            elif free >= 0:
                s = free
                free = np.int64(cells[U(16 * s + 4)])
            else:
                s = unused
                unused += 1
            word = np.int64(facets[U(8 * j)])
            a_at = np.int64(facets[U(8 * j + 1)])
            b_at = np.int64(facets[U(8 * j + 2)])
            c_at = np.int64(facets[U(8 * j + 3)])
            facets[U(8 * j + 4)] = s
            c = np.int64(corners[U(c_at)])
            cells[U(16 * s)] = q
            cells[U(16 * s + 1)] = corners[U(a_at)]
            cells[U(16 * s + 2)] = corners[U(b_at)]
            cells[U(16 * s + 3)] = c
            cells[U(16 * s + 4)] = word
            cells[U(16 * (word >> 3) + 4 + (word & 3))] = s << 3 | (word & CONSTRAINED)
            if small:
                edges[U(b_at * SMALL + c_at)] = s << 3 | 1
                edges[U(c_at * SMALL + a_at)] = s << 3 | 2
                edges[U(a_at * SMALL + b_at)] = s << 3 | 3
            ax, ay, az = offsets[U(4 * a_at)], offsets[U(4 * a_at + 1)], offsets[U(4 * a_at + 2)]
            bx, by, bz = offsets[U(4 * b_at)], offsets[U(4 * b_at + 1)], offsets[U(4 * b_at + 2)]
            if c < 0:
                x, y, z, w = plane_of(ax, ay, az, bx, by, bz)
            else:
                cx, cy, cz = offsets[U(4 * c_at)], offsets[U(4 * c_at + 1)], offsets[U(4 * c_at + 2)]
                aw, bw, cw = offsets[U(4 * a_at + 3)], offsets[U(4 * b_at + 3)], offsets[U(4 * c_at + 3)]
                x, y, z, w = sphere_of(ax, ay, az, aw, bx, by, bz, bw, cx, cy, cz, cw)
                hint = s
            planes[U(8 * s + 4)], planes[U(8 * s + 5)], planes[U(8 * s + 6)], planes[U(8 * s + 7)] = x, y, z, w
            if len(region) > 0:
                region[U(s)] = facets[U(8 * j + 5)]
            if len(facet_id) > 0:
                facet_id[U(4 * s)] = facets[U(8 * j + 6)]
                facet_id[U(4 * s + 1)] = facet_id[U(4 * s + 2)] = facet_id[U(4 * s + 3)] = 0
            if len(cell_of) > 0:
                for k in range(4):
                    v = np.int64(cells[U(16 * s + k)])
                    if v >= 0:
                        cell_of[U(v)] = s
        if small:
            for j in range(n_facets):
                a_at = np.int64(facets[U(8 * j + 1)])
                b_at = np.int64(facets[U(8 * j + 2)])
                c_at = np.int64(facets[U(8 * j + 3)])
                s = np.int64(facets[U(8 * j + 4)])
                cells[U(16 * s + 5)] = edges[U(c_at * SMALL + b_at)]
                cells[U(16 * s + 6)] = edges[U(a_at * SMALL + c_at)]
                cells[U(16 * s + 7)] = edges[U(b_at * SMALL + a_at)]
        else:
            link_by_table(cells, facets, n_facets, n_corners, table)
        for j in range(n_facets, n_cavity):
            s = np.int64(cavity[U(j)])
            cells[U(16 * s)] = -1
            cells[U(16 * s + 4)] = free
            free = s
        state[FREE] = free
        state[NEXT] = unused
        state[POINT] = i + 1
    state[HINT] = hint
    state[STEPS] += walked
    state[TESTS] += tested
    state[REMOVED] += removed
    if status == DONE and step != DIG and state[POINT] < n:
        return MORE
    return status
