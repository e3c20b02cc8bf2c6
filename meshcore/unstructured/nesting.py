"""Which faces of a planar graph are inside: closed loops nest by the even-odd rule."""

from __future__ import annotations

from collections import defaultdict, deque

import numpy as np

from ..mesh import topology

BRIDGE = -1


def nesting_levels(edges: np.ndarray, left: np.ndarray, right: np.ndarray, n_faces: int) -> np.ndarray:
    """How many closed loops lie around each face, modulo two.

    Each block of the graph (edges that share cycles) counts as one loop. If all its vertices have an even number of its
    edges it is a closed curve, which may cross itself, and each edge is a step from outside to inside. If not, it is
    an outline with partitions: only its outer edges are steps, its inner edges part what is inside.

    Parameters
    ----------
    edges : (m, 2) int
        Ends of the edges.
    left, right : (m,) int
        The faces on either side; face 0 is the outside.
    n_faces : int
        Number of faces.

    Returns
    -------
    (n_faces,) int
        0 outside and in holes, 1 inside.

    Examples
    --------
    A triangle within a triangle is a hole:

    >>> edges = np.array([[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3]])
    >>> nesting_levels(edges, np.array([1, 1, 1, 2, 2, 2]), np.array([0, 0, 0, 1, 1, 1]), 3)
    array([0, 1, 0])
    """
    block, is_even = _blocks(edges)
    is_step = (left != right) & (block >= 0)
    across: dict[int, list[tuple[int, int]]] = defaultdict(list)
    for f, g, b in sorted(set(zip(*(of[is_step].tolist() for of in (left, right, block)), strict=True))):
        across[f].append((g, b))
        across[g].append((f, b))
    level = np.full(n_faces, -1)
    level[0] = 0
    # A block is first met from the one face that surrounds it, since every way into it leads through that face.
    around: dict[int, int] = {}
    queue = deque([0])
    while queue:
        f = queue.popleft()
        for _, b in across[f]:
            around.setdefault(b, f)
        for g, b in across[f]:
            if level[g] < 0:
                level[g] = level[f] ^ int(is_even[b] or around[b] in (f, g))
                queue.append(g)
    return np.maximum(level, 0)


def _blocks(edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Number of the block of each edge, `BRIDGE` for edges on no cycle; and whether each block is even."""
    n = int(edges.max()) + 1
    component = topology.connected(edges, n)
    n_components = int(component.max()) + 1
    degree = np.bincount(edges.ravel(), minlength=n)
    even = np.ones(n_components, bool)
    even[component[degree % 2 == 1]] = False
    block = component[edges[:, 0]].copy()  # an even component needs no parting: parity is right for it as a whole
    rest = np.flatnonzero(~even[block])
    is_even = [True] * n_components
    if len(rest):
        for members in _biconnected(edges[rest]):
            if len(members) == 1:
                block[rest[members]] = BRIDGE
                continue
            block[rest[members]] = len(is_even)
            ends = edges[rest[members]].ravel()
            is_even.append(bool((np.bincount(ends) % 2 == 0).all()))
    return block, np.array(is_even)


def _biconnected(edges: np.ndarray) -> list[list[int]]:
    """Edges of each biconnected component (J. Hopcroft, R. Tarjan, CACM 16, 1973), without recursion."""
    incident: dict[int, list[tuple[int, int]]] = defaultdict(list)
    for number, (a, b) in enumerate(edges.tolist()):
        incident[a].append((b, number))
        incident[b].append((a, number))
    depth: dict[int, int] = {}
    lowest: dict[int, int] = {}
    found: list[list[int]] = []
    for root in incident:
        if root in depth:
            continue
        depth[root] = lowest[root] = 0
        path: list[int] = []  # edges of components not yet complete
        walk = [(root, -1, iter(incident[root]))]
        while walk:
            vertex, entered, rest = walk[-1]
            for other, number in rest:
                if number == entered:
                    continue
                if other not in depth:
                    depth[other] = lowest[other] = depth[vertex] + 1
                    path.append(number)
                    walk.append((other, number, iter(incident[other])))
                    break
                if depth[other] < depth[vertex]:
                    path.append(number)
                    lowest[vertex] = min(lowest[vertex], depth[other])
            else:
                walk.pop()
                if walk:
                    parent = walk[-1][0]
                    lowest[parent] = min(lowest[parent], lowest[vertex])
                    if lowest[vertex] >= depth[parent]:
                        members = [path.pop()]
                        while members[-1] != entered:
                            members.append(path.pop())
                        found.append(members)
    return found
