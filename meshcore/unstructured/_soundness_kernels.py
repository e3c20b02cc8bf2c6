"""Kernel that says whether half-edges are a triangulation in which every segment is a chain of edges."""

from .._numba import kernel
from ._half_edge_kernels import CONSTRAINED, DEAD, U, next_edge, side_of

# What `flaw` answers: nothing is wrong, a triangle is turned over, two are not glued edge to edge, a segment is lost.
SOUND, TURNED, TORN, LOST = range(4)


@kernel(inline=True)
def is_twin(origin, twin, e, f, flags):
    """Whether f, the twin of e, is the same edge turned around, of a live triangle, and on a piece if e is.

    ``flags`` are those of the triangle of e. All is looked at, since a branch would take longer.
    """
    constrained = (flags >> (e & 3)) & 1
    return (
        (twin[U(f)] == e)
        & (origin[U(f)] == origin[U(next_edge(e))])
        & (origin[U(e)] == origin[U(next_edge(f))])
        & (origin[U(f | 3)] & (DEAD | 1 << (f & 3)) == constrained << (f & 3))
    )


@kernel
def follows_piece(xy, origin, piece_of, pieces, e, tolerance, leaving, entering):
    """Note where the edge e, on a piece, leaves and enters; whether it runs along it, and nothing has done so there.

    Vertices along a piece have the first entries of the lists, the ends of each piece, which others may share, one of
    their own behind these.
    """
    piece = int(piece_of[U(e)])
    p = int(pieces[U(piece), 0])
    q = int(pieces[U(piece), 1])
    u = int(origin[U(e)])
    v = int(origin[U(next_edge(e))])
    dx = xy[U(2 * q)] - xy[U(2 * p)]
    dy = xy[U(2 * q + 1)] - xy[U(2 * p + 1)]
    along = (xy[U(2 * v)] - xy[U(2 * u)]) * dx + (xy[U(2 * v + 1)] - xy[U(2 * u + 1)]) * dy
    if along < 0.0:
        u, v = v, u
    beside = (xy[U(2 * v)] - xy[U(2 * p)]) * dy - (xy[U(2 * v + 1)] - xy[U(2 * p + 1)]) * dx
    ends = len(leaving) - len(pieces) + piece
    start = ends if u == p else u
    end = ends if v == q else v
    fits = (
        along != 0.0
        and beside * beside <= tolerance * tolerance * (dx * dx + dy * dy)
        and leaving[U(start)] < 0
        and entering[U(end)] < 0
    )
    leaving[U(start)] = piece
    entering[U(end)] = piece
    return fits


@kernel
def flaw(xy, origin, twin, piece_of, n_triangles, pieces, wanted, tolerance, leaving, entering, work):
    """What is wrong with a triangulation: one of the answers above.

    It is sound if all finite triangles are positive, exactly; if each edge has a twin that is the edge turned around,
    or lies on a piece of a segment, where the neighbour was carved away; and if the edges on each piece that is
    ``wanted`` lead from its one end to the other, within the ``tolerance``: then one leaves from the one end and one
    enters the other, and in between as many leave each vertex as enter it, one, all in the same direction.

    ``leaving`` and ``entering`` have an entry for each vertex and one for each piece.
    """
    leaving[:] = -1
    entering[:] = -1
    for t in range(n_triangles):
        flags = int(origin[U(4 * t + 3)])
        if flags & DEAD:
            continue
        a, b, c = origin[U(4 * t)], origin[U(4 * t + 1)], origin[U(4 * t + 2)]
        if (a | b | c) >= 0 and not (
            side_of(
                xy[U(2 * a)], xy[U(2 * a + 1)], xy[U(2 * b)], xy[U(2 * b + 1)], xy[U(2 * c)], xy[U(2 * c + 1)], work
            )
            > 0.0
        ):
            return TURNED
        for e in range(4 * t, 4 * t + 3):
            f = int(twin[U(e)])
            if f >= 0 and not is_twin(origin, twin, e, f, flags):
                return TORN
            if f < 0 and (flags >> (e & 3)) & 1 == 0:
                return TORN
        if flags & CONSTRAINED:
            for e in range(4 * t, 4 * t + 3):
                f = int(twin[U(e)])
                if (flags >> (e & 3)) & 1 == 0 or (f >= 0 and f < e and piece_of[U(f)] == piece_of[U(e)]):
                    continue  # seen from the other side
                if not follows_piece(xy, origin, piece_of, pieces, e, tolerance, leaving, entering):
                    return LOST
    for i in range(len(leaving)):
        if leaving[U(i)] != entering[U(i)]:
            return LOST
    for piece in range(len(pieces)):
        if wanted[U(piece)] and leaving[U(len(leaving) - len(pieces) + piece)] < 0:
            return LOST
    return SOUND
