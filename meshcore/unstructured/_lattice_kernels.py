"""Kernels of the lattice fill: sites of a triangular lattice, blocked near lines, taken between lines row by row."""

import math

from .._numba import kernel
from ._half_edge_kernels import U


@kernel
def block_sites(places, clear, x0, y0, h, dy, columns, blocked):
    """Block the sites nearer than ``clear`` to one of the ``places``.

    Site (row, column) stands at x0 + (column + (row odd) / 2) h, y0 + row dy.
    """
    rows = len(blocked) // columns
    for k in range(len(places)):
        x = places[U(k), U(0)]
        y = places[U(k), U(1)]
        for row in range(max(math.ceil((y - clear - y0) / dy), 0), min(int((y + clear - y0) / dy) + 1, rows)):
            away = y0 + row * dy - y
            half2 = clear * clear - away * away
            if half2 <= 0.0:
                continue
            half = math.sqrt(half2)
            left = x0 + 0.5 * h * (row & 1)
            first = max(math.ceil((x - half - left) / h), 0)
            for column in range(first, min(math.floor((x + half - left) / h) + 1, columns)):
                blocked[U(row * columns + column)] = 1


@kernel
def count_crossings(ends, y0, dy, start):
    """Add the number of segments that cross each row to ``start[row + 1]``; a segment owns its lower end."""
    rows = len(start) - 1
    for s in range(len(ends)):
        low = min(ends[U(s), U(1)], ends[U(s), U(3)])
        high = max(ends[U(s), U(1)], ends[U(s), U(3)])
        for row in range(max(math.ceil((low - y0) / dy), 0), min(math.ceil((high - y0) / dy), rows)):
            start[U(row + 1)] += 1


@kernel
def fill_crossings(ends, y0, dy, place, x):
    """Write where segments cross each row, behind one another."""
    rows = len(place)
    for s in range(len(ends)):
        ax = ends[U(s), U(0)]
        ay = ends[U(s), U(1)]
        bx = ends[U(s), U(2)]
        by = ends[U(s), U(3)]
        low = min(ay, by)
        high = max(ay, by)
        for row in range(max(math.ceil((low - y0) / dy), 0), min(math.ceil((high - y0) / dy), rows)):
            at = place[U(row)]
            place[U(row)] = at + 1
            x[U(at)] = ax + (y0 + row * dy - ay) / (by - ay) * (bx - ax)


@kernel
def take_sites(start, x, x0, y0, h, dy, columns, blocked, shake, points):
    """Write the free sites between the first and second, third and fourth ... crossing of each row; return how many.

    The crossings of each row are in ascending order.
    Sites are moved by up to ``shake`` in each direction, at random but always alike: no four of them then lie on a
    circle but for rounding, so that exact arithmetic is seldom called for.
    """
    count = 0
    for row in range(len(start) - 1):
        first = start[U(row)]
        last = start[U(row + 1)]
        y = y0 + row * dy
        left = x0 + 0.5 * h * (row & 1)
        for i in range(first, last - 1, 2):
            begin = max(math.ceil((x[U(i)] - left) / h), 0)
            for column in range(begin, min(math.floor((x[U(i + 1)] - left) / h) + 1, columns)):
                site = row * columns + column
                if blocked[U(site)]:
                    continue
                # A linear congruential step (Knuth, The Art of Computer Programming 2, section 3.3.4).
                random = (site * 6364136223846793005 + 1442695040888963407) >> 20
                points[U(count), U(0)] = left + column * h + shake * ((random & 0xFFFF) / 32768.0 - 1.0)
                points[U(count), U(1)] = y + shake * (((random >> 16) & 0xFFFF) / 32768.0 - 1.0)
                count += 1
    return count
