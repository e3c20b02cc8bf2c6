"""Kernels of Voronoi diagrams: circumcentres, and the cells around the vertices of a Delaunay triangulation.

Cells are read off the stars of the sites, so that nothing but the corners of triangles and tetrahedra is needed. The
sites come first among the vertices, the far points that enclose them last; every site is inside the hull.

References
----------
J. R. Shewchuk, "Lecture notes on geometric robustness" (2013), section 3.10, for the circumcentres.
"""

import numpy as np

from .._numba import kernel
from ..geometry._alternating_digital_tree_kernels import STACK
from ..geometry._predicates_kernels import _add, _multiply, orient2d, orient3d, two_sum
from ._half_edge_kernels import U

EPSILON = 2.0**-53
PRECISE = 1e-13
"""Relative error of a circumcentre above which it is computed with more digits."""


@kernel
def circumcentres_2d(points, corners, centres, work):
    """Write the circumcentre of each triangle.

    From the corner at the largest angle, the numerators do not cancel; the denominator is exact up to its last bit.
    """
    for t in range(len(corners)):
        a = corners[U(t), 0]
        b = corners[U(t), 1]
        c = corners[U(t), 2]
        ab = (points[b, 0] - points[a, 0]) ** 2 + (points[b, 1] - points[a, 1]) ** 2
        bc = (points[c, 0] - points[b, 0]) ** 2 + (points[c, 1] - points[b, 1]) ** 2
        ca = (points[a, 0] - points[c, 0]) ** 2 + (points[a, 1] - points[c, 1]) ** 2
        if ca > bc and ca >= ab:
            a, b, c = b, c, a
        elif ab > bc and ab > ca:
            a, b, c = c, a, b
        ax = points[a, 0]
        ay = points[a, 1]
        bx = points[b, 0] - ax
        by = points[b, 1] - ay
        cx = points[c, 0] - ax
        cy = points[c, 1] - ay
        det = bx * cy - by * cx
        if abs(det) < 1e-5 * (abs(bx * cy) + abs(by * cx)):
            det = orient2d(ax, ay, points[b, 0], points[b, 1], points[c, 0], points[c, 1], work)
        half = 0.5 / det
        bb = bx * bx + by * by
        cc = cx * cx + cy * cy
        centres[t, 0] = ax + half * (bb * cy - cc * by)
        centres[t, 1] = ay + half * (cc * bx - bb * cx)


@kernel
def circumcentres_3d(points, corners, centres, error, work):
    """Write the circumcentre of each tetrahedron, and a bound of its error, relative to the circumradius.

    The denominator is exact up to its last bit. The numerators cancel in slivers, which the bound tells.
    """
    for t in range(len(corners)):
        a = corners[U(t), 0]
        b = corners[U(t), 1]
        c = corners[U(t), 2]
        d = corners[U(t), 3]
        bx = points[b, 0] - points[a, 0]
        by = points[b, 1] - points[a, 1]
        bz = points[b, 2] - points[a, 2]
        cx = points[c, 0] - points[a, 0]
        cy = points[c, 1] - points[a, 1]
        cz = points[c, 2] - points[a, 2]
        dx = points[d, 0] - points[a, 0]
        dy = points[d, 1] - points[a, 1]
        dz = points[d, 2] - points[a, 2]
        bb = bx * bx + by * by + bz * bz
        cc = cx * cx + cy * cy + cz * cz
        dd = dx * dx + dy * dy + dz * dz
        cdx = cy * dz - cz * dy
        cdy = cz * dx - cx * dz
        cdz = cx * dy - cy * dx
        dbx = dy * bz - dz * by
        dby = dz * bx - dx * bz
        dbz = dx * by - dy * bx
        bcx = by * cz - bz * cy
        bcy = bz * cx - bx * cz
        bcz = bx * cy - by * cx
        det = bx * cdx + by * cdy + bz * cdz
        size = (bb * cc * dd) ** 0.5
        if abs(det) < 1e-5 * size:
            # The cells are in VTK's order, where this determinant is positive.
            det = orient3d(
                points[a, 0], points[a, 1], points[a, 2], points[b, 0], points[b, 1], points[b, 2],
                points[c, 0], points[c, 1], points[c, 2], points[d, 0], points[d, 1], points[d, 2], work,
            )  # fmt: skip
        half = 0.5 / det
        x = half * (bb * cdx + cc * dbx + dd * bcx)
        y = half * (bb * cdy + cc * dby + dd * bcy)
        z = half * (bb * cdz + cc * dbz + dd * bcz)
        centres[t, 0] = points[a, 0] + x
        centres[t, 1] = points[a, 1] + y
        centres[t, 2] = points[a, 2] + z
        # Each numerator is a sum of products whose sizes are at most |b|^2 |c| |d| and so on.
        terms = (bb**0.5 + cc**0.5 + dd**0.5) * size
        error[t] = 16.0 * EPSILON * abs(half) * terms / max((x * x + y * y + z * z) ** 0.5, 1e-300)


@kernel
def stars(corners, offsets, star):
    """Fill the rows of the cells around each vertex: cell times number of corners, plus the vertex's corner."""
    m, size = corners.shape
    for t in range(m):
        for k in range(size):
            v = corners[U(t), U(k)]
            star[U(offsets[U(v)])] = size * t + k
            offsets[U(v)] += 1
    for v in range(len(offsets) - 1, 0, -1):
        offsets[U(v)] = offsets[U(v - 1)]
    offsets[0] = 0


@kernel
def polygons_around(corners, offsets, star, n_sites, after, nodes):
    """Write the triangles around each site counter-clockwise, the first one at its neighbour of least number."""
    for v in range(n_sites):
        first = -1
        for i in range(offsets[U(v)], offsets[U(v + 1)]):
            s = star[U(i)]
            k = s % 3
            b = corners[U(s // 3), U(k + 1 if k < 2 else 0)]
            after[U(b)] = s
            if first < 0 or b < first:
                first = b
        for i in range(offsets[U(v)], offsets[U(v + 1)]):
            s = after[U(first)]
            k = s % 3
            nodes[U(i)] = s // 3
            first = corners[U(s // 3), U(k - 1 if k > 0 else 2)]


@kernel
def faces_around(corners, offsets, star, n_sites, index, after, buffer, face_offsets, face_nodes, owner, neighbour):
    """Write the ring of tetrahedra around each edge of a site with a vertex of greater number; return how many.

    Along the edge from the site the ring turns by the right-hand rule: its polygon looks out of the site's cell.
    ``index`` and ``after`` have a place for each vertex, -1 in ``index``; ``buffer`` (3, k) one for each corner of the
    largest star.
    """
    count = 0
    n_nodes = 0
    face_offsets[0] = 0
    for v in range(n_sites):
        # The link of v: its triangles (x, y, z), seen from outside; around x the ring goes from y to z.
        n_link = 0
        for i in range(offsets[U(v)], offsets[U(v + 1)]):
            t = star[U(i)] // 4
            k = star[U(i)] % 4
            for j in range(4):
                x = corners[U(t), U(j)]
                if j != k and index[U(x)] < 0:
                    index[U(x)] = n_link
                    buffer[0, U(n_link)] = x
                    buffer[1, U(n_link)] = 0
                    n_link += 1
                if j != k:
                    buffer[1, U(index[U(x)])] += 1
        start = 0
        for i in range(n_link):
            size = buffer[1, U(i)]
            buffer[1, U(i)] = start
            start += size
        for i in range(offsets[U(v)], offsets[U(v + 1)]):
            t = star[U(i)] // 4
            k = star[U(i)] % 4
            for j in range(4):
                if j != k:
                    place = index[U(corners[U(t), U(j)])]
                    buffer[2, U(buffer[1, U(place)])] = 4 * star[U(i)] + j
                    buffer[1, U(place)] += 1
        start = 0
        for i in range(n_link):
            x = buffer[0, U(i)]
            index[U(x)] = -1
            end = buffer[1, U(i)]
            if x > v:
                least = -1
                for e in range(start, end):
                    s = buffer[2, U(e)]
                    y, _z = _ring_step(corners, s)
                    after[U(y)] = s
                    if least < 0 or y < least:
                        least = y
                y = least
                for _ in range(start, end):
                    s = after[U(y)]
                    face_nodes[U(n_nodes)] = s // 16
                    n_nodes += 1
                    _, y = _ring_step(corners, s)
                owner[U(count)] = v
                neighbour[U(count)] = x if x < n_sites else -1
                count += 1
                face_offsets[U(count)] = n_nodes
            start = end
    return count


@kernel(inline=True)
def _ring_step(corners, s):
    """The two corners y, z of tetrahedron s // 16 that make (v, x, y, z) positive, v and x its corners k and j."""
    t = s // 16
    k = (s // 4) % 4
    j = s % 4
    # The other two corners, in the order of an even permutation (k, j, y, z).
    y = 0
    while y in (k, j):
        y += 1
    z = 6 - k - j - y
    swaps = (k > j) + (k > y) + (k > z) + (j > y) + (j > z) + (y > z)
    if swaps % 2 == 1:
        y, z = z, y
    return corners[U(t), U(y)], corners[U(t), U(z)]


@kernel
def welded(offsets, nodes, number, seen, new_offsets, new_nodes, faulty):
    """Rows with their nodes renumbered and repeats in a row left out; mark rows with the same node at two places.

    ``seen`` has a place for each node, all -1. Returns how many nodes are left; a row may have fewer than three.
    """
    count = 0
    new_offsets[0] = 0
    for row in range(len(offsets) - 1):
        first = count
        for i in range(offsets[U(row)], offsets[U(row + 1)]):
            node = number[U(nodes[U(i)])]
            if count == first or new_nodes[U(count - 1)] != node:
                new_nodes[U(count)] = node
                count += 1
        while count > first + 1 and new_nodes[U(count - 1)] == new_nodes[U(first)]:
            count -= 1
        faulty[U(row)] = False
        for i in range(first, count):
            if seen[U(new_nodes[U(i)])] == row:
                faulty[U(row)] = True
            seen[U(new_nodes[U(i)])] = row
        new_offsets[U(row + 1)] = count
    return count


@kernel
def loops(after, offsets, order):
    """Write the cycles of a permutation as rows, each from its least member on; return how many rows."""
    done = 0
    count = 0
    for first in range(len(after)):
        if after[U(first)] < 0:
            continue
        k = first
        while after[U(k)] >= 0:
            order[U(done)] = k
            done += 1
            step = after[U(k)]
            after[U(k)] = -1 - step
            k = step
        count += 1
        offsets[U(count)] = done
    return count


@kernel
def circumcentres_3d_precisely(points, corners, centres, error, matrix):
    """The same in double-double arithmetic for those whose error is above `PRECISE`; the bound becomes the new one.

    ``matrix`` (3, 4, 2) is scratch: differences to the first corner and their squares. Cramer's rule.
    """
    for t in range(len(corners)):
        if error[U(t)] <= PRECISE:
            continue
        a = corners[U(t), 0]
        size = 1.0
        longest = 0.0
        for row in range(3):
            b = corners[U(t), U(row + 1)]
            square = 0.0
            square_low = 0.0
            for axis in range(3):
                high, low = two_sum(points[b, axis], -points[a, axis])
                matrix[row, axis, 0] = high
                matrix[row, axis, 1] = low
                high, low, _ = _multiply(high, low, high, low)
                square, square_low, _ = _add(square, square_low, high, low)
            matrix[row, 3, 0] = square
            matrix[row, 3, 1] = square_low
            size *= square**0.5
            longest = max(longest, square**0.5)
        det = _determinant(matrix, 0, 1, 2)
        half = 0.5 / det
        x = half * _determinant(matrix, 3, 1, 2)
        y = half * _determinant(matrix, 0, 3, 2)
        z = half * _determinant(matrix, 0, 1, 3)
        centres[t, 0] = points[a, 0] + x
        centres[t, 1] = points[a, 1] + y
        centres[t, 2] = points[a, 2] + z
        radius = max((x * x + y * y + z * z) ** 0.5, 1e-300)
        error[t] = 2.0**-98 * size * abs(half) * (1.0 + 3.0 * longest / radius)


@kernel
def _determinant(matrix, p, q, s):
    """Determinant of three columns of a (3, 4, 2) matrix of double-doubles."""
    total = 0.0
    total_low = 0.0
    for row in range(3):
        i = (row + 1) % 3
        j = (row + 2) % 3
        one, one_low, _ = _multiply(matrix[i, q, 0], matrix[i, q, 1], matrix[j, s, 0], matrix[j, s, 1])
        two, two_low, _ = _multiply(matrix[i, s, 0], matrix[i, s, 1], matrix[j, q, 0], matrix[j, q, 1])
        minor, minor_low, _ = _add(one, one_low, -two, -two_low)
        term, term_low, _ = _multiply(matrix[row, p, 0], matrix[row, p, 1], minor, minor_low)
        total, total_low, _ = _add(total, total_low, term, term_low)
    return total


@kernel(allocates=True)
def first_beyond(points, after, planes, order, right, first, bounds, radius, tolerance, found):
    """For each point the first plane, by number above ``after``, that it lies beyond by more than the tolerance.

    Where there is none, the number of planes. ``planes`` are rows of normal and distance from the origin, in the order
    of the leaves of a tree over them; nothing within ``radius`` of the origin is beyond any. How far a point lies
    beyond the planes of a node at most follows from the node's bounds, summed up as for a plane, so that rounding,
    which is monotone, cannot make it less.
    """
    n_planes = len(order)
    dimension = points.shape[1]
    size = 2 * dimension + 2
    stack = np.empty(STACK, np.int64)
    for i in range(len(points)):
        found[U(i)] = n_planes
        square = 0.0
        for axis in range(dimension):
            square += points[U(i), U(axis)] ** 2
        if square < radius * radius:
            continue
        stack[0] = 0
        waiting = 1
        while waiting > 0:
            waiting -= 1
            node = stack[U(waiting)]
            b = size * node
            most = -bounds[U(b + dimension)]
            for axis in range(dimension):
                x = points[U(i), U(axis)]
                most += max(bounds[U(b + axis)] * x, bounds[U(b + dimension + 1 + axis)] * x)
            if most <= tolerance:
                continue
            if right[U(node)] > 0:
                stack[U(waiting)] = right[U(node)]
                stack[U(waiting + 1)] = node + 1
                waiting += 2
                continue
            for item in range(first[U(node)], first[U(node)] - right[U(node)]):
                plane = order[U(item)]
                if plane <= after[U(i)] or plane >= found[U(i)]:
                    continue
                height = -planes[U(item), U(dimension)]
                for axis in range(dimension):
                    height += planes[U(item), U(axis)] * points[U(i), U(axis)]
                if height > tolerance:
                    found[U(i)] = plane


@kernel
def short_edges(points, offsets, nodes, longest, pairs):
    """Write the edges of rows that are at most so long, the smaller node first; return how many there are.

    What ``pairs`` has no room for is only counted.
    """
    count = 0
    dimension = points.shape[1]
    for row in range(len(offsets) - 1):
        last = offsets[U(row + 1)] - 1
        for i in range(offsets[U(row)], last + 1):
            a = nodes[U(i)]
            b = nodes[U(i + 1 if i < last else offsets[U(row)])]
            if a >= b:
                continue
            square = 0.0
            for axis in range(dimension):
                square += (points[a, axis] - points[b, axis]) ** 2
            if square <= longest * longest:
                if count < len(pairs):
                    pairs[U(count), 0] = a
                    pairs[U(count), 1] = b
                count += 1
    return count
