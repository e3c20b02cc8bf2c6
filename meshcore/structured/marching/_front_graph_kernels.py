"""Kernels that put a surface's faces into order: turned alike, and the ring of neighbours round each node."""

import numpy as np

from ..._numba import kernel

U = np.uint64


@kernel
def turn_alike(start, beside, agree, turned, part, stack):
    """Flood over the faces from neighbour to neighbour; returns a face that cannot be turned alike with all, or -1.

    Parameters
    ----------
    start, beside, agree : int
        For each face its neighbours, by offsets, and whether both are turned alike as given.
    turned : (m,) int
        1 where a face must be turned; out.
    part : (m,) int
        Number of the connected part; -1 at first.
    stack : (m,) int
        Room to work in.
    """
    parts = 0
    for seed in range(len(part)):
        if part[U(seed)] >= 0:
            continue
        part[U(seed)], turned[U(seed)], stack[0], top = parts, 0, seed, 1
        while top:
            top -= 1
            face = stack[U(top)]
            for k in range(start[U(face)], start[U(face + 1)]):
                other = beside[U(k)]
                wanted = turned[U(face)] ^ (1 - agree[U(k)])
                if part[U(other)] < 0:
                    part[U(other)], turned[U(other)], stack[U(top)] = parts, wanted, other
                    top += 1
                elif turned[U(other)] != wanted:
                    return other
        parts += 1
    return -1


@kernel
def rings(start, after, before, ring_start, ring, opened):
    """Put the corners of faces at each node into a ring; returns a node whose faces make no single fan, or -1.

    Parameters
    ----------
    start : (n + 1,) int
        Offsets of each node's corners.
    after, before : (k,) int
        The neighbours after and before the node in each corner's face; `before` follows `after` in the ring. They are
        reordered.
    ring_start, ring : int
        The rings; out.
    opened : (n,) int
        1 where the ring is open; out.
    """
    filled = 0
    for i in range(len(start) - 1):
        ring_start[U(i)] = filled
        low, high = start[U(i)], start[U(i + 1)]
        if low == high:
            return i
        first = low
        opened[U(i)] = 0
        for k in range(low, high):  # an open fan begins where no corner ends
            found = False
            for m in range(low, high):
                found |= before[U(m)] == after[U(k)]
            if not found:
                first = k
                opened[U(i)] = 1
        for k in range(low, high):
            after[U(k)], after[U(first)] = after[U(first)], after[U(k)]
            before[U(k)], before[U(first)] = before[U(first)], before[U(k)]
            ring[U(filled)] = after[U(k)]
            filled += 1
            first = -1
            for m in range(k + 1, high):
                if after[U(m)] == before[U(k)]:
                    first = m
            if first < 0:
                if k != high - 1:
                    return i
                break
        if opened[U(i)]:
            ring[U(filled)] = before[U(high - 1)]
            filled += 1
        elif before[U(high - 1)] != ring[U(ring_start[U(i)])]:
            return i
    ring_start[U(len(start) - 1)] = filled
    return -1
