"""Kernels of edges: a mesh's directed edges sorted in linear time, those of one cell only, and chains along lines."""

import math

import numpy as np

from .._numba import kernel

U = np.uint64
# Longer rows than this are left to the caller's sort: a hub with many edges would take the square of their number.
SHORT = 32


@kernel
def count_edges(cells, corners, start):
    """Add the number of directed edges at each smaller point to ``start[point + 1]``."""
    for t in range(len(cells)):
        before = cells[U(t), U(corners - 1)]
        for k in range(corners):
            here = cells[U(t), U(k)]
            start[U(min(before, here) + 1)] += 1
            before = here


@kernel
def fill_edges(cells, corners, n, place, keys):
    """Write the key ``2 (n smaller + larger) + turned`` of each edge behind those of its smaller point."""
    for t in range(len(cells)):
        before = cells[U(t), U(corners - 1)]
        for k in range(corners):
            here = cells[U(t), U(k)]
            smaller = min(before, here)
            at = place[U(smaller)]
            place[U(smaller)] = at + 1
            keys[U(at)] = 2 * (n * smaller + max(before, here)) + (1 if before > here else 0)
            before = here


@kernel
def sort_rows(start, keys, long_rows):
    """Sort each point's keys by insertion; return how many rows are too long for it, and list them."""
    n_long = 0
    for v in range(len(start) - 1):
        first = start[U(v)]
        last = start[U(v + 1)]
        if last - first > SHORT:
            long_rows[U(n_long)] = v
            n_long += 1
            continue
        for i in range(first + 1, last):
            key = keys[U(i)]
            j = i
            while j > first and keys[U(j - 1)] > key:
                keys[U(j)] = keys[U(j - 1)]
                j -= 1
            keys[U(j)] = key
    return n_long


@kernel
def unmatched_edges(keys, n, edges):
    """Write the ends of edges of one cell only, as the cell runs along them, while there is room; count them all."""
    count = 0
    i = 0
    while i < len(keys):
        key = keys[U(i)] >> 1
        j = i + 1
        while j < len(keys) and keys[U(j)] >> 1 == key:
            j += 1
        if j == i + 1:
            if count < len(edges):
                smaller = key // n
                larger = key - n * smaller
                turned = keys[U(i)] & 1
                edges[U(count), U(0)] = larger if turned else smaller
                edges[U(count), U(1)] = smaller if turned else larger
            count += 1
        i = j
    return count


@kernel
def neighbours_of_points(edges, n, start, neighbour):
    """For each point the points that edges (sorted keys as `fill_edges` writes them) join it to, by rows."""
    smaller = 0
    before = -1
    for i in range(len(edges)):
        key = edges[U(i)] >> 1
        if key == before:
            continue
        before = key
        while key >= n * (smaller + 1):  # cheaper than a division
            smaller += 1
        start[U(smaller + 1)] += 1
        start[U(key - n * smaller + 1)] += 1
    for v in range(n):
        start[U(v + 1)] += start[U(v)]
    smaller = 0
    before = -1
    for i in range(len(edges)):
        key = edges[U(i)] >> 1
        if key == before:
            continue
        before = key
        while key >= n * (smaller + 1):
            smaller += 1
        larger = key - n * smaller
        # The rows' starts serve as places to write and are put back below.
        neighbour[U(start[U(smaller)])] = larger
        start[U(smaller)] += 1
        neighbour[U(start[U(larger)])] = smaller
        start[U(larger)] += 1
    for v in range(n, 0, -1):
        start[U(v)] = start[U(v - 1)]
    start[0] = 0


@kernel
def follow_lines(points, start, neighbour, lines, tolerance, done):
    """Tell for each line whether a chain of edges leads straight from its first to its second point.

    At each point the edge is taken that leads on by the least within the tolerance.
    """
    for k in range(len(lines)):
        here = lines[U(k), U(0)]
        goal = lines[U(k), U(1)]
        ox = points[U(here), U(0)]
        oy = points[U(here), U(1)]
        oz = points[U(here), U(2)]
        dx = points[U(goal), U(0)] - ox
        dy = points[U(goal), U(1)] - oy
        dz = points[U(goal), U(2)] - oz
        size = math.sqrt(dx * dx + dy * dy + dz * dz)
        if not size > 0.0:
            continue
        dx /= size
        dy /= size
        dz /= size
        now = 0.0
        while here != goal:
            following = -1
            nearest = math.inf
            for i in range(start[U(here)], start[U(here + 1)]):
                to = neighbour[U(i)]
                x = points[U(to), U(0)] - ox
                y = points[U(to), U(1)] - oy
                z = points[U(to), U(2)] - oz
                along = x * dx + y * dy + z * dz
                if now < along <= size + tolerance and along < nearest:
                    x -= along * dx
                    y -= along * dy
                    z -= along * dz
                    if math.sqrt(x * x + y * y + z * z) <= tolerance:
                        nearest = along
                        following = to
            if following < 0:
                break
            here = following
            now = nearest
        done[U(k)] = here == goal
