"""Kernel of the gradation limit: sizes lowered along edges until none grows too fast."""

import numpy as np

from .._numba import kernel


@kernel
def _lower(heap, place, sizes, at):
    """Move the vertex at a place of the heap up until its parent is not larger."""
    vertex = heap[at]
    while at > 0:
        parent = (at - 1) // 2
        if sizes[heap[parent]] <= sizes[vertex]:
            break
        heap[at] = heap[parent]
        place[heap[at]] = at
        at = parent
    heap[at] = vertex
    place[vertex] = at


@kernel
def _raise(heap, place, sizes, count, at):
    """Move the vertex at a place of the heap down until its children are not smaller."""
    vertex = heap[at]
    while True:
        child = 2 * at + 1
        if child >= count:
            break
        if child + 1 < count and sizes[heap[child + 1]] < sizes[heap[child]]:
            child += 1
        if sizes[vertex] <= sizes[heap[child]]:
            break
        heap[at] = heap[child]
        place[heap[at]] = at
        at = child
    heap[at] = vertex
    place[vertex] = at


@kernel(allocates=True)
def limit(start, neighbour, length, gradation, sizes):
    """Lower sizes until along each edge they differ by at most ``gradation`` times its length.

    Vertices are settled from the smallest size upwards, as in Dijkstra's method: a settled size can no longer be
    lowered, since all others are larger and sizes only grow along edges. So each edge is looked at twice, and the
    result is the largest field below the given one that keeps the limit (Borouchaki, Hecht & Frey 1998, section 3,
    whose sweeps over the edges end in the same field).

    ``neighbour`` and ``length`` list the edges at vertex v from ``start[v]`` to ``start[v + 1]``.
    """
    n = len(sizes)
    heap = np.arange(n)
    place = np.arange(n)
    for at in range(n // 2 - 1, -1, -1):
        _raise(heap, place, sizes, n, at)
    for count in range(n - 1, -1, -1):
        vertex = heap[0]
        place[vertex] = -1
        if count > 0:
            heap[0] = heap[count]
            _raise(heap, place, sizes, count, 0)
        for edge in range(start[vertex], start[vertex + 1]):
            other = neighbour[edge]
            most = sizes[vertex] + gradation * length[edge]
            if place[other] >= 0 and most < sizes[other]:
                sizes[other] = most
                _lower(heap, place, sizes, place[other])
