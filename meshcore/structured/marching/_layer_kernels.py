"""Kernels of layers marched from a surface, whose nodes know their neighbours all around, in order.

The ring of node i is ``ring[start[i]:start[i + 1]]``, counter-clockwise seen from outside. Two neighbours in a row are
a corner of a face; an open ring, on the surface's edge, has no corner between its last and its first neighbour.
``held[i]`` is -1 or the row of `projectors` onto the plane or line in which node i may move.
"""

import math

import numpy as np

from ..._numba import kernel

U = np.uint64
SEEN = 0.5  # sine above all faces around that lines have, if any line does
ENOUGH = 0.999  # of that
ALIKE = 1e-6  # sines that do not differ
ROUNDS = 40  # of search for such a line, and twice as many for the best one if there is none
CONVEX = 0.05  # part of the dissipation that is left where the front widens
FAR = 0.1  # the same for the part that grows with the distance from the wall
FADE = 0.8  # of dissipation from a node to its neighbours, each step, near the wall
WIDTH = 0.7  # spacings in the distance from the wall, over which it fades far from it
COMPRESSED, BENT = 4.0, 4.0  # spacing lost, and mean bend of the ring, at which dissipation is whole: a quarter


@kernel(inline=True)
def corner(points, i, a, b):
    """Cross product of the edges from i to a and b, and their lengths squared."""
    ux = points[U(a), 0] - points[U(i), 0]
    uy = points[U(a), 1] - points[U(i), 1]
    uz = points[U(a), 2] - points[U(i), 2]
    vx = points[U(b), 0] - points[U(i), 0]
    vy = points[U(b), 1] - points[U(i), 1]
    vz = points[U(b), 2] - points[U(i), 2]
    uu = ux * ux + uy * uy + uz * uz
    vv = vx * vx + vy * vy + vz * vz
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx, uu, vv


@kernel(inline=True)
def held_vector(held, projectors, i, x, y, z):
    """A vector at node i as the boundary lets it be."""
    row = held[U(i)]
    if row < 0:
        return x, y, z
    p = projectors[row]
    return (
        p[0, 0] * x + p[0, 1] * y + p[0, 2] * z,
        p[1, 0] * x + p[1, 1] * y + p[1, 2] * z,
        p[2, 0] * x + p[2, 1] * y + p[2, 2] * z,
    )


@kernel
def lowest(points, start, ring, opened, i, x, y, z):
    """The cosine of a unit vector to the corner at node i that it sees least, and this corner's unit normal.

    Of several that it sees alike it is the normal of all of them, lest symmetric corners get lines that are not.
    """
    begin = start[U(i)]
    count = start[U(i + 1)] - begin
    least, wx, wy, wz = 2.0, 0.0, 0.0, 0.0
    for k in range(count - opened[U(i)]):
        a = ring[U(begin + k)]
        b = ring[U(begin + (k + 1) % count)]
        cx, cy, cz, _uu, _vv = corner(points, i, a, b)
        size = math.sqrt(cx * cx + cy * cy + cz * cz)
        if size > 0:
            cosine = (cx * x + cy * y + cz * z) / size
            if cosine < least - ALIKE:
                wx, wy, wz = 0.0, 0.0, 0.0
            if cosine < least + ALIKE:
                wx, wy, wz = wx + cx / size, wy + cy / size, wz + cz / size
                least = min(least, cosine)
    size = math.sqrt(wx * wx + wy * wy + wz * wz)
    if size > 0:
        wx, wy, wz = wx / size, wy / size, wz / size
    return least, wx, wy, wz


@kernel
def normals(first, last, points, start, ring, opened, held, projectors, seen, normal):
    """Unit normals at nodes: the corners' normals weighted by sine over the product of the edges' lengths.

    On a sphere they are radial whatever the mesh is (N. Max, "Weights for computing vertex normals from facet
    normals", J. Graphics Tools 4, 1999). One that is less than ``seen`` above a face, by its sine, is put just that far
    above the face that it sees least, again and again (S. Kaczmarz, 1937), so that it turns no more than it must. If it
    does not come above all of them so, it is turned towards them by ever less (the rule of the perceptron), which ends
    near the line that sees all faces best; the best of these is taken.
    """
    for i in range(first, last):
        begin = start[U(i)]
        count = start[U(i + 1)] - begin
        x, y, z = 0.0, 0.0, 0.0
        for k in range(count - opened[U(i)]):
            a = ring[U(begin + k)]
            b = ring[U(begin + (k + 1) % count)]
            cx, cy, cz, uu, vv = corner(points, i, a, b)
            scale = 1.0 / (uu * vv)
            x += cx * scale
            y += cy * scale
            z += cz * scale
        x, y, z = held_vector(held, projectors, i, x, y, z)
        size = math.sqrt(x * x + y * y + z * z)
        if size > 0:
            x, y, z = x / size, y / size, z / size
        least, wx, wy, wz = lowest(points, start, ring, opened, i, x, y, z)
        if least < seen:
            best, bx, by, bz = least, x, y, z
            for k in range(3 * ROUNDS):
                more = seen - least if k < ROUNDS else 1.0 / (1 + k - ROUNDS)
                x, y, z = held_vector(held, projectors, i, x + more * wx, y + more * wy, z + more * wz)
                size = math.sqrt(x * x + y * y + z * z)
                if size == 0:
                    break
                x, y, z = x / size, y / size, z / size
                least, wx, wy, wz = lowest(points, start, ring, opened, i, x, y, z)
                if least > best:
                    best, bx, by, bz = least, x, y, z
                if k < ROUNDS and least >= ENOUGH * seen:
                    break
            x, y, z = bx, by, bz
        normal[U(i), 0] = x
        normal[U(i), 1] = y
        normal[U(i), 2] = z


@kernel
def ring_weights(first, last, points, normal, start, ring, opened, free, weight):
    """Mean value coordinates of each node in its ring, seen along its normal, of sum one.

    They are positive where the normal sees all faces, and the weighted mean of the ring lies on the normal's line:
    smoothing with them leaves the surface's spacing as it is (M. S. Floater, "Mean value coordinates", 2003). On a
    plane of symmetry the mirrored half of the ring is met by projection. On a free edge of the surface only the two
    neighbours along it count.
    """
    for i in range(first, last):
        begin = start[U(i)]
        count = start[U(i + 1)] - begin
        nx, ny, nz = normal[U(i), 0], normal[U(i), 1], normal[U(i), 2]
        for k in range(count):
            weight[U(begin + k)] = 0.0
        for k in range(count - opened[U(i)]):
            one = begin + k
            two = begin + (k + 1) % count
            a = ring[U(one)]
            b = ring[U(two)]
            ux = points[U(a), 0] - points[U(i), 0]
            uy = points[U(a), 1] - points[U(i), 1]
            uz = points[U(a), 2] - points[U(i), 2]
            vx = points[U(b), 0] - points[U(i), 0]
            vy = points[U(b), 1] - points[U(i), 1]
            vz = points[U(b), 2] - points[U(i), 2]
            height = ux * nx + uy * ny + uz * nz
            ux, uy, uz = ux - height * nx, uy - height * ny, uz - height * nz
            height = vx * nx + vy * ny + vz * nz
            vx, vy, vz = vx - height * nx, vy - height * ny, vz - height * nz
            u = math.sqrt(ux * ux + uy * uy + uz * uz)
            v = math.sqrt(vx * vx + vy * vy + vz * vz)
            area = nx * (uy * vz - uz * vy) + ny * (uz * vx - ux * vz) + nz * (ux * vy - uy * vx)
            if u * v > 0 and area > 0:
                # tan(angle / 2) = (1 - cos) / sin
                half = (u * v - (ux * vx + uy * vy + uz * vz)) / area
                weight[U(one)] += half / u
                weight[U(two)] += half / v
        total = 0.0
        for k in range(count):
            if free[U(i)] and 0 < k < count - 1:
                weight[U(begin + k)] = 0.0
            total += weight[U(begin + k)]
        for k in range(count):
            if total > 0:
                weight[U(begin + k)] /= total


@kernel
def present_weights(i, points, start, ring, opened, weight, spacing, ratio, now):
    """Weights of a node's ring on the front, and the least ratio of its spacing there to that on the wall.

    The wall's weights, less in directions that have widened more than the narrowest one: there the front may keep
    what it has become, while narrowed directions are drawn back to the wall's proportions. Directions are those of a
    neighbour and the one opposite.
    """
    begin = start[U(i)]
    count = start[U(i + 1)] - begin
    for k in range(begin, begin + count):
        j = ring[U(k)]
        dx = points[U(j), 0] - points[U(i), 0]
        dy = points[U(j), 1] - points[U(i), 1]
        dz = points[U(j), 2] - points[U(i), 2]
        ratio[U(k)] = math.sqrt(dx * dx + dy * dy + dz * dz) / spacing[U(k)]
    least = 1e300
    for k in range(count):
        r = ratio[U(begin + k)]
        if opened[U(i)] == 0:
            one = ratio[U(begin + (k + count // 2) % count)]
            two = ratio[U(begin + (k + (count + 1) // 2) % count)]
            r = 0.5 * r + 0.25 * (one + two)
        now[U(begin + k)] = r
        least = min(least, r)
    total = 0.0
    for k in range(begin, begin + count):
        now[U(k)] = weight[U(k)] * least / now[U(k)]
        total += now[U(k)]
    for k in range(begin, begin + count):
        if total > 0:
            now[U(k)] /= total
    return least


@kernel
def narrowing(first, last, points, ahead, start, ring, opened, narrow):
    """Least area of each node's corners ahead, seen along those on the front, in units of these."""
    for i in range(first, last):
        begin = start[U(i)]
        count = start[U(i + 1)] - begin
        least = 1.0
        for k in range(count - opened[U(i)]):
            a = ring[U(begin + k)]
            b = ring[U(begin + (k + 1) % count)]
            cx, cy, cz, _uu, _vv = corner(ahead, i, a, b)
            dx, dy, dz, _uu, _vv = corner(points, i, a, b)
            least = min(least, (cx * dx + cy * dy + cz * dz) / (dx * dx + dy * dy + dz * dz))
        narrow[U(i)] = least


@kernel
def dissipation(
    first, last, height, total, base, growing, ahead, normal, start, ring, opened, held, projectors, free,
    weight, spacing, ratio, now, zone, new_zone, strength, right,
):  # fmt: skip
    """Strength of dissipation at each node, and the displacement that it asks for, of the right side.

    As by Chan and Steger it is proportional to the height over the spacing, and whole where the front is concave or
    has narrowed, next to nothing where it widens (their sensors of angle and of grid convergence). A second part
    grows with the distance from the wall over the spacing: only so do corners look alike at all distances, rounded
    by a radius in proportion to the distance, as the front's points must spread over ever more cells of the wall. For
    the same reason it reaches ever more cells from where it is whole.

    Parameters
    ----------
    height, total : float
        Height of the step, and distance from the wall after it.
    base, growing : float
        Coefficients of both parts.
    ahead : (n, 3) float
        The front, offset along its normals by the height.
    weight, spacing, ratio, now : (k,) float
        Weights and spacings on the wall; room; weights now (out).
    zone, new_zone : (n,) float
        Part of the dissipation that acted in the last step, and in this one (out).
    strength : (n,) float
        The dissipation e; out.
    right : (n, 3) float
        Dissipation times the Laplacian of `ahead`; out. On a free edge its part along the edge; where the front is
        convex its part along the front.
    """
    for i in range(first, last):
        begin = start[U(i)]
        end = start[U(i + 1)]
        least = present_weights(i, ahead, start, ring, opened, weight, spacing, ratio, now)
        px, py, pz = ahead[U(i), 0], ahead[U(i), 1], ahead[U(i), 2]
        x, y, z, inverse, longest, around = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(begin, end):
            j = ring[U(k)]
            dx, dy, dz = ahead[U(j), 0] - px, ahead[U(j), 1] - py, ahead[U(j), 2] - pz
            x += now[U(k)] * dx
            y += now[U(k)] * dy
            z += now[U(k)] * dz
            length = math.sqrt(dx * dx + dy * dy + dz * dz)
            inverse += 1.0 / length
            longest = max(longest, length)
            around = max(around, zone[U(j)])
        inverse /= end - begin
        x, y, z = held_vector(held, projectors, i, x, y, z)
        nx, ny, nz = normal[U(i), 0], normal[U(i), 1], normal[U(i), 2]
        up = x * nx + y * ny + z * nz
        fade = max(FADE, 1 - WIDTH / (inverse * total))
        part = min(1.0, max(0.0, COMPRESSED * (1 - least), BENT * up * inverse, fade * around))
        new_zone[U(i)] = part
        far = part * inverse + FAR * (1 - part) / longest
        e = height * inverse * (base * max(part, CONVEX) + growing * total * far)
        if free[U(i)]:
            one, two = ring[U(begin)], ring[U(end - 1)]
            tx, ty, tz = (
                ahead[U(two), 0] - ahead[U(one), 0],
                ahead[U(two), 1] - ahead[U(one), 1],
                ahead[U(two), 2] - ahead[U(one), 2],
            )
            size = tx * tx + ty * ty + tz * tz
            along = (x * tx + y * ty + z * tz) / size if size > 0 else 0.0
            x, y, z = along * tx, along * ty, along * tz
        elif up < 0:
            x, y, z = x - up * nx, y - up * ny, z - up * nz
        strength[U(i)] = e
        right[U(i), 0] = e * x
        right[U(i), 1] = e * y
        right[U(i), 2] = e * z


@kernel
def corner_volumes(first, last, least_height, below, above, start, ring, opened, worst):
    """Least sine of the corners at each node of the cells between two layers; all positive if and only if none folds.

    At a node's corner the volume is the area vector of the two edges, times the edge to the other layer: with both
    layers these are the eight corners of hexahedra and the six of wedges. Where a node has moved by less than a height
    the front is stuck, as in the middle of a cavity: -1.
    """
    for i in range(first, last):
        begin = start[U(i)]
        count = start[U(i + 1)] - begin
        x = above[U(i), 0] - below[U(i), 0]
        y = above[U(i), 1] - below[U(i), 1]
        z = above[U(i), 2] - below[U(i), 2]
        length = math.sqrt(x * x + y * y + z * z)
        least = 1.0
        for k in range(count - opened[U(i)]):
            a = ring[U(begin + k)]
            b = ring[U(begin + (k + 1) % count)]
            cx, cy, cz, uu, vv = corner(below, i, a, b)
            least = min(least, (cx * x + cy * y + cz * z) / (length * math.sqrt(uu * vv)))
            cx, cy, cz, uu, vv = corner(above, i, a, b)
            least = min(least, (cx * x + cy * y + cz * z) / (length * math.sqrt(uu * vv)))
        worst[U(i)] = least if least == least and length >= least_height else -1.0
