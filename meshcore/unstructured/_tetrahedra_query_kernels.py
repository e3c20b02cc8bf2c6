"""Kernels that ask a triangulation of space: star of a vertex, ring of an edge, edges and facets, walk along a segment.

The layout is that of `_tetrahedra_kernels`. A list that is too short is answered by -1: make it longer and ask again.
Cells that were seen are marked in ``marks`` (int32, one a cell, zero at first) by a number that stands in ``stamp[0]``
and is raised by each question: nothing is ever swept. A face of a cell is written ``cell << 4 | corners``, with one bit
for each of its corners: 15 is the cell itself, three bits are a facet, two an edge, one a vertex.
"""

import numpy as np

from .._numba import kernel
from ._tetrahedra_kernels import FACET_A, FACET_B, FACET_C, U, side

FULL_LIST, ABSENT = -1, -2


def _others():
    """For corners i and j the other two, so that (i, j, first, second) is an even permutation."""
    first = np.full(16, -1)
    second = np.full(16, -1)
    for k in range(4):
        around = (FACET_A[k], FACET_B[k], FACET_C[k])
        for n in range(3):
            first[4 * k + around[n]], second[4 * k + around[n]] = around[(n + 1) % 3], around[(n + 2) % 3]
    return first, second


OTHER_1, OTHER_2 = _others()


@kernel
def map_vertices(cells, n_cells, cell_of):
    """Note a cell of each vertex, -1 where it has none."""
    cell_of[:] = -1
    for t in range(n_cells):
        if cells[U(16 * t)] >= 0:
            for k in range(4):
                v = cells[U(16 * t + k)]
                if v >= 0:
                    cell_of[U(v)] = t


@kernel
def corner_of(cells, t, v):
    """Which corner of cell t is vertex v; 4 if none."""
    i = 16 * t
    if cells[U(i)] == v:
        return 0
    if cells[U(i + 1)] == v:
        return 1
    if cells[U(i + 2)] == v:
        return 2
    return 3 if cells[U(i + 3)] == v else 4


@kernel
def star(cells, start, v, marks, stamp, found):
    """Write the cells at vertex v, ghosts included, from one of them on; return how many."""
    stamp[0] += 1
    mark = stamp[0]
    found[0] = start
    marks[U(start)] = mark
    count = 1
    i = 0
    while i < count:
        t = int(found[U(i)])
        i += 1
        for k in range(4):
            beyond = int(cells[U(16 * t + 4 + k)]) >> 3
            if cells[U(16 * t + k)] != v and marks[U(beyond)] != mark:
                if count == len(found):
                    return FULL_LIST
                marks[U(beyond)] = mark
                found[U(count)] = beyond
                count += 1
    return count


@kernel
def find_face(cells, start, v, a, b, marks, stamp, found):
    """The face of vertices v, a and b (-1: of v and a) in a cell from v's cell ``start`` on, or `ABSENT`.

    A finite cell is preferred, a ghost never needed: each edge and facet of the hull has a cell behind it.
    """
    count = star(cells, start, v, marks, stamp, found)
    if count < 0:
        return FULL_LIST
    for i in range(count):
        t = int(found[U(i)])
        if cells[U(16 * t + 3)] >= 0:
            k = corner_of(cells, t, a)
            j = corner_of(cells, t, b) if b >= 0 else k
            if k < 4 and j < 4:
                return t << 4 | 1 << corner_of(cells, t, v) | 1 << k | 1 << j
    return ABSENT


@kernel
def ring(cells, start, p, q, found, link):
    """Write the cells round the edge from p to q, ghosts included, and the vertices opposite; return how many.

    The ring is counter-clockwise seen from q: cell ``found[i]`` has the positive corners p, q, ``link[i]`` and the
    next link. ``start`` is any cell at the edge.
    """
    t = start
    i = corner_of(cells, t, p)
    j = corner_of(cells, t, q)
    leaving = OTHER_1[4 * i + j]
    staying = OTHER_2[4 * i + j]
    count = 0
    while True:
        if count == min(len(found), len(link)):
            return FULL_LIST
        found[U(count)] = t
        link[U(count)] = cells[U(16 * t + leaving)]
        count += 1
        kept = cells[U(16 * t + staying)]
        word = int(cells[U(16 * t + 4 + leaving)])
        t = word >> 3
        if t == start:
            return count
        staying = word & 3
        leaving = corner_of(cells, t, kept)


@kernel
def segment_and_facet(points, a, b, p, q, r, work):
    """Where the line through a and b meets the facet p, q, r, none of them coplanar with it: exact.

    0 if it passes by, 7 if through the inside; an edge or corner is told by the bits 1, 2, 4 of its corners p, q, r.
    Whether the segment reaches the facet is told by the sides of a and b: they differ or one is zero.
    """
    corners = (p, q, r)
    face = 7
    left = right = False
    for k in range(3):
        turn = side(points, a, b, corners[k], corners[(k + 1) % 3], work)
        left |= turn > 0.0
        right |= turn < 0.0
        if turn == 0.0:  # on the edge from corner k, so without the corner after its end
            face &= ~(1 << (k + 2) % 3)
    return 0 if left and right else face


@kernel
def _entered(points, cells, t, face, b, work):
    """The face of cell t that a line from inside one of its faces towards b enters, as bits; 0 if none."""
    entered = 15
    for k in range(4):
        if face >> k & 1 == 0:
            i = 16 * t
            corners = (
                b if k == 0 else int(cells[U(i)]),
                b if k == 1 else int(cells[U(i + 1)]),
                b if k == 2 else int(cells[U(i + 2)]),
                b if k == 3 else int(cells[U(i + 3)]),
            )
            turn = side(points, corners[0], corners[1], corners[2], corners[3], work)
            if turn < 0.0:
                return 0
            if turn == 0.0:
                entered ^= 1 << k
    return entered


@kernel
def lowest_corner(face):
    """The number of the lowest bit."""
    if face & 1:
        return 0
    if face & 2:
        return 1
    return 2 if face & 4 else 3


@kernel
def _left(points, cells, t, within, face, a, b, work):
    """By which face of cell t the line from a to b leaves the inside of ``within``, where it came by ``face``; bits.

    Sides of the line are signs of orient3d(a, b, u, v): equal ones on both ends of an edge's neighbours tell which
    facet is crossed, zero that the edge itself is.
    """
    rest = within ^ face
    further = face & (face - 1)
    if further == 0:
        return rest  # from a corner: what is opposite
    i = 16 * t
    furthest = further & (further - 1)
    p = lowest_corner(face)
    q = lowest_corner(further)
    s = lowest_corner(rest)
    vs = int(cells[U(i + s)])
    # Edges (first, second) whose sides are asked. Each call of an exact predicate is compiled anew, hence the loop.
    u, v, w = FACET_A[s], FACET_B[s], FACET_C[s]
    first = (vs, vs, vs)
    second = (int(cells[U(i + u)]), int(cells[U(i + v)]), int(cells[U(i + w)]))
    if within != 15:  # in a facet, whose edges are seen from the corner off its plane
        off = int(cells[U(i + lowest_corner(15 ^ within))])
        first = (vs, int(cells[U(i + p)]), vs)
        second = (off, off, off)
    elif furthest == 0:
        first = (vs, int(cells[U(i + q)]), vs)
        second = (int(cells[U(i + lowest_corner(rest & (rest - 1)))]), vs, vs)
    at_0, at_1, at_2 = 0.0, 0.0, 0.0
    for k in range(2 if furthest == 0 else 3):
        at = side(points, a, b, first[k], second[k], work)
        if k == 0:
            at_0 = at
        elif k == 1:
            at_1 = at
        else:
            at_2 = at
    if furthest == 0:  # from an edge, perhaps right to what is opposite, else past it on the side of q or of p
        if at_0 == 0.0:
            return rest
        return rest | 1 << (q if (at_0 > 0.0) == (at_1 > 0.0) else p)
    # From a facet (u, v, w) through the cell. Corner s and the facet are in positive order, so the line, which comes
    # in, has orient3d(a, b, u, v) < 0: it leaves by (u, v, s) if u lies on one side of its plane through s, v on the
    # other, as said here.
    for _ in range(2):
        if at_0 <= 0.0 and at_1 >= 0.0:
            break
        u, v, w = v, w, u
        at_0, at_1, at_2 = at_1, at_2, at_0
    return rest | (1 << u if at_1 > 0.0 else 0) | (1 << v if at_0 < 0.0 else 0)


@kernel
def walk_segment(points, cells, cell_of, a, b, marks, stamp, found, link, faces, work):
    """Write the faces whose insides the segment between vertices a and b meets, in order; return how many.

    Exact: cells, facets, edges and vertices on the way are each met once, by turns one that the segment runs inside
    and one that it crosses; the first and last begin and end at a and b. -1 if a list is too short, -2 if a wall, where
    cells are missing, is in the way.
    """
    t = int(cell_of[U(a)])
    face = 1 << corner_of(cells, t, a)
    count = 0
    while True:
        i = 16 * t
        corner = lowest_corner(face)
        further = face & (face - 1)
        p = int(cells[U(i + corner)])
        q, r = p, p
        if further == 0:
            n = star(cells, t, p, marks, stamp, found)
        else:
            q = int(cells[U(i + lowest_corner(further))])
            furthest = further & (further - 1)
            if furthest == 0:
                n = ring(cells, t, p, q, found, link)
            else:
                r = int(cells[U(i + lowest_corner(furthest))])
                found[0] = int(cells[U(i + 4 + lowest_corner(15 ^ face))]) >> 3
                n = 1
        if n < 0 or count + 2 > len(faces):
            return FULL_LIST
        within = 0
        for j in range(n):
            t = int(found[U(j)])
            if cells[U(16 * t)] >= 0 and cells[U(16 * t + 3)] >= 0:
                face = 1 << corner_of(cells, t, p) | 1 << corner_of(cells, t, q) | 1 << corner_of(cells, t, r)
                within = _entered(points, cells, t, face, b, work)
                if within != 0:
                    break
        if within == 0:
            return ABSENT
        faces[U(count)] = t << 4 | within
        count += 1
        k = corner_of(cells, t, b)
        if k < 4 and within >> k & 1 == 1:
            return count
        face = _left(points, cells, t, within, face, a, b, work)
        faces[U(count)] = t << 4 | face
        count += 1
