"""Kernels that tell which faces of a planar graph are inside: blocks of edges, and levels of faces from outside in.

References
----------
J. Hopcroft, R. Tarjan, "Algorithm 447: efficient algorithms for graph manipulation", CACM 16 (1973).
"""

from .._numba import kernel
from ._half_edge_kernels import U

BRIDGE = -1
# Rows of the numbers that `find_blocks` needs for each vertex.
START, AT, DEPTH, LOWEST, ENTERED, WALK, PARITY = range(7)
VERTEX_ROWS = 7


@kernel
def _close_block(edges, members, number, block, parity):
    """Number the edges of a block; return whether all its vertices have an even number of them."""
    for i in range(len(members)):
        e = members[U(i)]
        block[U(e)] = number
        parity[U(edges[U(e), U(0)])] ^= 1
        parity[U(edges[U(e), U(1)])] ^= 1
    even = True
    for i in range(len(members)):
        for end in range(2):
            v = edges[U(members[U(i)]), U(end)]
            even = even and parity[U(v)] == 0
    for i in range(len(members)):
        parity[U(edges[U(members[U(i)]), U(0)])] = 0
        parity[U(edges[U(members[U(i)]), U(1)])] = 0
    return even


@kernel
def find_blocks(edges, of_vertex, incident, path, block, is_even):
    """Number the block of each edge, `BRIDGE` for edges on no cycle, and whether blocks are even; return how many.

    Blocks are the biconnected components, found in one search in depth. ``edges`` are pairs of vertices, the first two
    of each row; ``of_vertex`` is (`VERTEX_ROWS`, n + 1), ``incident`` twice as long as there are edges.
    """
    start, at, depth, lowest = of_vertex[START], of_vertex[AT], of_vertex[DEPTH], of_vertex[LOWEST]
    entered, walk = of_vertex[ENTERED], of_vertex[WALK]
    n = len(start) - 1
    of_vertex[:] = 0
    for e in range(len(edges)):
        start[U(edges[U(e), U(0)] + 1)] += 1
        start[U(edges[U(e), U(1)] + 1)] += 1
    for v in range(n):
        start[U(v + 1)] += start[U(v)]
        at[U(v)] = start[U(v)]
    for e in range(len(edges)):
        for end in range(2):
            v = edges[U(e), U(end)]
            incident[U(at[U(v)])] = e
            at[U(v)] += 1
    for v in range(n):
        at[U(v)] = start[U(v)]
        depth[U(v)] = -1
    count = 0
    n_path = 0
    for root in range(n):
        if depth[U(root)] >= 0:
            continue
        depth[U(root)] = 0
        entered[U(root)] = -1
        walk[0] = root
        height = 1
        while height > 0:
            v = walk[U(height - 1)]
            if at[U(v)] < start[U(v + 1)]:
                e = incident[U(at[U(v)])]
                at[U(v)] += 1
                w = edges[U(e), U(0)] + edges[U(e), U(1)] - v
                if e == entered[U(v)]:
                    continue
                if depth[U(w)] < 0:
                    depth[U(w)] = depth[U(v)] + 1
                    lowest[U(w)] = depth[U(w)]
                    entered[U(w)] = e
                    walk[U(height)] = w
                    height += 1
                elif depth[U(w)] < depth[U(v)]:
                    lowest[U(v)] = min(lowest[U(v)], depth[U(w)])
                else:
                    continue
                path[U(n_path)] = e
                n_path += 1
                continue
            height -= 1
            if height == 0:
                continue
            before = walk[U(height - 1)]
            lowest[U(before)] = min(lowest[U(before)], lowest[U(v)])
            if lowest[U(v)] >= depth[U(before)]:
                first = n_path - 1
                while path[U(first)] != entered[U(v)]:
                    first -= 1
                if first == n_path - 1:
                    block[U(path[U(first)])] = BRIDGE
                else:
                    is_even[U(count)] = _close_block(edges, path[first:n_path], count, block, of_vertex[PARITY])
                    count += 1
                n_path = first
    return count


@kernel
def set_levels(sides, block, is_even, start, across, around, queue, level):
    """Write for each face how many closed loops are around it, modulo two.

    ``sides`` are the faces left and right of each edge. ``start``, one longer than there are faces, ``across``, twice
    as long as there are edges, ``around``, one for each block, and ``queue``, one for each face, are scratch.
    """
    n = len(level)
    start[:] = 0
    for e in range(len(block)):
        if sides[U(0), U(e)] != sides[U(1), U(e)] and block[U(e)] != BRIDGE:
            start[U(sides[U(0), U(e)])] += 1
            start[U(sides[U(1), U(e)])] += 1
    for f in range(n):
        start[U(f + 1)] += start[U(f)]
    # From the ends of the lists to their beginnings.
    for e in range(len(block)):
        if sides[U(0), U(e)] != sides[U(1), U(e)] and block[U(e)] != BRIDGE:
            for side in range(2):
                f = sides[U(side), U(e)]
                start[U(f)] -= 1
                across[U(start[U(f)])] = e
    around[:] = -1
    level[:] = -1
    level[0] = 0
    queue[0] = 0
    waiting = 1
    taken = 0
    while taken < waiting:
        f = queue[U(taken)]
        taken += 1
        # A block is first met from the one face that surrounds it, since every way into it leads through that face.
        for i in range(start[U(f)], start[U(f + 1)]):
            b = block[U(across[U(i)])]
            if around[U(b)] < 0:
                around[U(b)] = f
        for i in range(start[U(f)], start[U(f + 1)]):
            e = across[U(i)]
            b = block[U(e)]
            g = sides[U(0), U(e)] + sides[U(1), U(e)] - f
            if level[U(g)] < 0:
                is_step = is_even[U(b)] or around[U(b)] == f or around[U(b)] == g
                level[U(g)] = level[U(f)] ^ (1 if is_step else 0)
                queue[U(waiting)] = g
                waiting += 1
    for f in range(n):
        level[U(f)] = max(level[U(f)], 0)
