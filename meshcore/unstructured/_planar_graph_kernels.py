"""Kernels that make line cells a clean graph: points that are used, places along a direction, lines by number."""

import math

from .._numba import kernel
from ._half_edge_kernels import U


@kernel
def list_used(lines, vertices, used):
    """List the points that lines and vertices use, ascending; ``used``, one number a point, starts as zeros."""
    for cells in (lines, vertices):
        for i in range(len(cells)):
            for k in range(cells.shape[1]):
                used[U(cells[U(i), U(k)])] = 1
    count = 0
    for p in range(len(used)):
        if used[U(p)]:
            used[U(count)] = p
            count += 1
    return count


@kernel
def project(points, x, y, places):
    """Write the place of each point along the direction (x, y); return the largest magnitude of a coordinate."""
    largest = 0.0
    for i in range(len(points)):
        px = points[U(i), U(0)]
        py = points[U(i), U(1)]
        places[U(i)] = px * x + py * y
        largest = max(largest, abs(px), abs(py))
    return largest


@kernel
def least_gap(ordered):
    """The least difference between numbers that are in order; infinite if there are fewer than two."""
    gap = math.inf
    for i in range(1, len(ordered)):
        gap = min(gap, ordered[U(i)] - ordered[U(i - 1)])
    return gap


@kernel
def number_lines(lines, at, count, segments, real, keys):
    """Write the lines that have a length by the numbers of their points, below ``count``; return how many.

    ``real`` gets the number of each among the lines, ``keys`` a number that only lines between the same points share.
    """
    m = 0
    for i in range(len(lines)):
        a = at[U(lines[U(i), U(0)])]
        b = at[U(lines[U(i), U(1)])]
        if a != b:
            segments[U(m), U(0)] = a
            segments[U(m), U(1)] = b
            real[U(m)] = i
            keys[U(m)] = min(a, b) * count + max(a, b)
            m += 1
    return m


@kernel
def clear_tiny(points, nothing):
    """Make coordinates below ``nothing`` zero."""
    for i in range(len(points)):
        for k in range(2):
            if abs(points[U(i), U(k)]) < nothing:
                points[U(i), U(k)] = 0.0
