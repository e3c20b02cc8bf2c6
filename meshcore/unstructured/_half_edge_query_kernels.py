"""Kernels that ask a planar triangulation: star of a vertex, edges and triangles by vertices, walk along a segment;
the faces beside segments and at places.

The layout is that of `_half_edge_kernels`; triangles may have been carved away. A list that is too short is answered
by -1: make it longer and ask again. A face of a triangle is written ``triangle << 3 | corners``, with one bit for each
of its corners: 7 is the triangle itself, two bits are an edge, one a vertex.
"""

from .._numba import kernel
from ._half_edge_kernels import DEAD, U, is_constrained, next_edge, previous_edge, side_of

FULL_LIST, ABSENT = -1, -2
# What `faces_at` answers for places beyond all triangles.
BEYOND = -1


@kernel
def map_edges(origin, n_triangles, vertex_edge):
    """Note a half-edge that starts at each vertex, -1 where there is none; flags and stamps stay as they are."""
    vertex_edge[:] = -1
    for t in range(n_triangles):
        if origin[U(4 * t + 3)] & DEAD == 0:
            for k in range(3):
                v = origin[U(4 * t + k)]
                if v >= 0:
                    vertex_edge[U(v)] = 4 * t + k


@kernel
def star(origin, twin, start, found):
    """Write the half-edges from the vertex where ``start`` begins, counter-clockwise; return how many.

    One for each triangle there, ghosts included. Where some were carved away, those on the same side as ``start`` of
    the gaps, the clockwise end first.
    """
    e = start
    while True:
        before = int(twin[U(e)])
        if before < 0:
            break
        e = next_edge(before)
        if e == start:
            break
    first = e
    count = 0
    while True:
        if count == len(found):
            return FULL_LIST
        found[U(count)] = e
        count += 1
        e = int(twin[U(previous_edge(e))])
        if e < 0 or e == first:
            return count


@kernel
def find_face(origin, twin, start, a, b, found):
    """The face of the vertex where ``start`` begins, a and b (-1: of that and a), or `ABSENT`; never in a ghost."""
    count = star(origin, twin, start, found)
    if count < 0:
        return FULL_LIST
    for i in range(count):
        e = int(found[U(i)])
        after, before = next_edge(e), previous_edge(e)
        x, y = origin[U(after)], origin[U(before)]
        if x < 0 or y < 0:
            continue
        at_v, at_x, at_y = 1 << (e & 3), 1 << (after & 3), 1 << (before & 3)
        if b >= 0:
            if (x == a and y == b) or (x == b and y == a):
                return e >> 2 << 3 | 7
        elif x == a:
            return e >> 2 << 3 | at_v | at_x
        elif y == a:
            return e >> 2 << 3 | at_v | at_y
    return ABSENT


@kernel
def _left_of(xy, u, v, q, work):
    """Sign of ``orient2d`` of three vertices."""
    return side_of(
        xy[U(2 * u)], xy[U(2 * u + 1)], xy[U(2 * v)], xy[U(2 * v + 1)], xy[U(2 * q)], xy[U(2 * q + 1)], work
    )  # fmt: skip


@kernel
def _entered(xy, origin, e, b, work):
    """The edge or triangle that a line towards b enters from the vertex where e begins, in e's triangle; 0 if none."""
    after, before = next_edge(e), previous_edge(e)
    v, x, y = int(origin[U(e)]), int(origin[U(after)]), int(origin[U(before)])
    if x < 0 or y < 0:
        return 0
    past_x = _left_of(xy, v, x, b, work)
    past_y = _left_of(xy, y, v, b, work)
    if past_x < 0.0 or past_y < 0.0:
        return 0
    face = e >> 2 << 3 | 7
    if past_x == 0.0:
        face ^= 1 << (before & 3)
    if past_y == 0.0:
        face ^= 1 << (after & 3)
    return face


@kernel
def walk_segment(xy, origin, twin, vertex_edge, a, b, found, faces, work):
    """Write the faces whose insides the segment between vertices a and b meets, in order; return how many.

    Exact: triangles, edges and vertices on the way are each met once, by turns one that the segment runs inside and
    one that it crosses; the first and last begin and end at a and b. -1 if a list is too short, -2 if the segment
    leaves the mesh.
    """
    at = int(vertex_edge[U(a)])  # the half-edge from the vertex that was reached, or the one crossed, seen from beyond
    in_vertex = True
    count = 0
    while at >= 0:
        if count + 2 > len(faces):
            return FULL_LIST
        if in_vertex:
            n = star(origin, twin, at, found)
            if n < 0:
                return FULL_LIST
            within = 0
            for j in range(n):
                at = int(found[U(j)])
                within = _entered(xy, origin, at, b, work)
                if within != 0:
                    break
            if within == 0:
                return ABSENT
            after, before = next_edge(at), previous_edge(at)
            x, y = origin[U(after)], origin[U(before)]
            faces[U(count)] = within
            count += 1
            rest = within ^ 1 << (at & 3)
            if (x == b and rest >> (after & 3) & 1) or (y == b and rest >> (before & 3) & 1):
                return count
            faces[U(count)] = rest
            count += 1
            in_vertex = within & 7 != 7
            if in_vertex:  # along the edge to its other end
                at = after if rest >> (after & 3) & 1 else before
            else:
                at = int(twin[U(after)])
            continue
        after, before = next_edge(at), previous_edge(at)
        w = int(origin[U(before)])
        if w < 0:
            return ABSENT
        t = at >> 2 << 3
        faces[U(count)] = t | 7
        count += 1
        if w == b:
            return count
        # The edge comes with its triangle on the left: where the line comes in, its beginning is left of the line.
        turn = _left_of(xy, a, b, w, work)
        if turn == 0.0:
            faces[U(count)] = t | 1 << (before & 3)
            at = before
            in_vertex = True
        else:
            leaving = after if turn > 0.0 else before
            faces[U(count)] = t | 1 << (leaving & 3) | 1 << (next_edge(leaving) & 3)
            at = int(twin[U(leaving)])
        count += 1
    return ABSENT


@kernel
def faces_at(xy, origin, n_triangles, face, places, found, work):
    """Write the face in which each place lies, or `BEYOND`; exact. Places are few: all triangles are seen.

    A place between two triangles, at no segment, is in the face of both. The answer is the number of the first place on
    a segment, where the kernel stops; as many as there are if none is.
    """
    for i in range(len(places)):
        x = places[U(i), U(0)]
        y = places[U(i), U(1)]
        found[U(i)] = BEYOND
        for t in range(n_triangles):
            a, b, c = origin[U(4 * t)], origin[U(4 * t + 1)], origin[U(4 * t + 2)]
            if (a | b | c) < 0 or origin[U(4 * t + 3)] & DEAD:
                continue
            ax, ay = xy[U(2 * a)], xy[U(2 * a + 1)]
            bx, by = xy[U(2 * b)], xy[U(2 * b + 1)]
            cx, cy = xy[U(2 * c)], xy[U(2 * c + 1)]
            if x < min(ax, bx, cx) or x > max(ax, bx, cx) or y < min(ay, by, cy) or y > max(ay, by, cy):
                continue
            past_a = side_of(ax, ay, bx, by, x, y, work)
            past_b = side_of(bx, by, cx, cy, x, y, work)
            past_c = side_of(cx, cy, ax, ay, x, y, work)
            if past_a < 0.0 or past_b < 0.0 or past_c < 0.0:
                continue
            on_segment = (
                (past_a == 0.0 and is_constrained(origin, 4 * t))
                or (past_b == 0.0 and is_constrained(origin, 4 * t + 1))
                or (past_c == 0.0 and is_constrained(origin, 4 * t + 2))
            )
            if on_segment:
                return i
            found[U(i)] = face[U(t)]
    return len(places)


@kernel
def faces_beside(origin, n_triangles, piece_of, pieces, face, sides):
    """Write the face left of each undivided piece to the first row of ``sides``, the one right of it to the second."""
    for t in range(n_triangles):
        for e in range(4 * t, 4 * t + 3):
            if is_constrained(origin, e):
                piece = piece_of[U(e)]
                sides[U(origin[U(e)] != pieces[U(piece), U(0)]), U(piece)] = face[U(t)]


@kernel
def first_lines(sides, pieces, line, keep, first):
    """Write the first input line beside each face, as `faces_beside` tells; -1 for faces without.

    ``line`` is the input line under each segment. The answers are how many faces but the outer one are kept, and how
    many pieces have no face that is kept beside them.
    """
    kept = 0
    for f in range(1, len(keep)):
        kept += keep[U(f)]
    first[:] = -1
    outside = 0
    for p in range(len(pieces)):
        number = line[U(pieces[U(p), U(2)])]
        for side in range(2):
            f = sides[U(side), U(p)]
            if first[U(f)] < 0 or number < first[U(f)]:
                first[U(f)] = number
        if not (keep[U(sides[U(0), U(p)])] or keep[U(sides[U(1), U(p)])]):
            outside += 1
    return kept, outside
