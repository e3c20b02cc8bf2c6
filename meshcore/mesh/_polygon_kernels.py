"""Kernels on polygons in compressed rows: rows taken, nodes numbered anew, areas, volumes and centres of mass."""

import numpy as np

from .._numba import kernel

U = np.uint64


@kernel
def take_rows(offsets, nodes, rows, new_offsets, new_nodes):
    """Copy some rows; ``new_offsets`` are given."""
    for k in range(len(rows)):
        at = offsets[U(rows[U(k)])]
        for i in range(new_offsets[U(k)], new_offsets[U(k + 1)]):
            new_nodes[U(i)] = nodes[U(at)]
            at += 1


@kernel
def number_by_appearance(nodes, number, old):
    """Renumber nodes in place in the order in which they first appear; ``number`` begins as -1, ``old`` goes back."""
    count = 0
    for i in range(len(nodes)):
        node = nodes[U(i)]
        if number[U(node)] < 0:
            number[U(node)] = count
            old[U(count)] = node
            count += 1
        nodes[U(i)] = number[U(node)]
    return count


@kernel
def polygon_moments(points, offsets, nodes, planar, area, centre):
    """Area and centre of mass of each polygon, by a fan from its first node.

    Planar ones have the sign of their orientation; others are measured along their mean normal (M. E. Newell).
    """
    for row in range(len(area)):
        first = offsets[U(row)]
        last = offsets[U(row + 1)]
        a = nodes[U(first)]
        ax = points[a, 0]
        ay = points[a, 1]
        az = points[a, 2]
        nx = 0.0
        ny = 0.0
        nz = 1.0
        if not planar:
            nz = 0.0
            for i in range(first + 1, last - 1):
                b = nodes[U(i)]
                c = nodes[U(i + 1)]
                bx = points[b, 0] - ax
                by = points[b, 1] - ay
                bz = points[b, 2] - az
                cx = points[c, 0] - ax
                cy = points[c, 1] - ay
                cz = points[c, 2] - az
                nx += by * cz - bz * cy
                ny += bz * cx - bx * cz
                nz += bx * cy - by * cx
            length = (nx * nx + ny * ny + nz * nz) ** 0.5
            if length > 0.0:
                nx /= length
                ny /= length
                nz /= length
        total = 0.0
        mx = 0.0
        my = 0.0
        mz = 0.0
        sx = 0.0
        sy = 0.0
        sz = 0.0
        for i in range(first + 1, last):
            b = nodes[U(i)]
            bx = points[b, 0] - ax
            by = points[b, 1] - ay
            bz = points[b, 2] - az
            sx += bx
            sy += by
            sz += bz
            if i + 1 == last:
                break
            c = nodes[U(i + 1)]
            cx = points[c, 0] - ax
            cy = points[c, 1] - ay
            cz = points[c, 2] - az
            part = 0.5 * (nx * (by * cz - bz * cy) + ny * (bz * cx - bx * cz) + nz * (bx * cy - by * cx))
            total += part
            mx += part * (bx + cx)
            my += part * (by + cy)
            mz += part * (bz + cz)
        area[U(row)] = total
        share = 1.0 / (3.0 * total) if total > 0.0 else 0.0
        if total > 0.0 and abs(share) < np.inf:
            mx *= share
            my *= share
            mz *= share
        else:
            mx = sx / (last - first)
            my = sy / (last - first)
            mz = sz / (last - first)
        centre[U(row), 0] = ax + mx
        centre[U(row), 1] = ay + my
        centre[U(row), 2] = az + mz


@kernel
def polyhedron_moments(points, offsets, nodes, owner, neighbour, start, volume, moment, mean, count):
    """Add up volumes, first moments and corners of polyhedra about a corner of each, by the divergence theorem.

    ``start`` begins as -1 and becomes that corner; the others begin as zero.
    """
    for face in range(len(owner)):
        for side in range(2):
            cell = owner[U(face)] if side == 0 else neighbour[U(face)]
            if cell < 0:
                continue
            sign = 1.0 if side == 0 else -1.0
            first = offsets[U(face)]
            last = offsets[U(face + 1)]
            if start[U(cell)] < 0:
                start[U(cell)] = nodes[U(first)]
            o = start[U(cell)]
            a = nodes[U(first)]
            ax = points[a, 0] - points[o, 0]
            ay = points[a, 1] - points[o, 1]
            az = points[a, 2] - points[o, 2]
            for i in range(first, last):
                b = nodes[U(i)]
                bx = points[b, 0] - points[o, 0]
                by = points[b, 1] - points[o, 1]
                bz = points[b, 2] - points[o, 2]
                mean[U(cell), 0] += bx
                mean[U(cell), 1] += by
                mean[U(cell), 2] += bz
                count[U(cell)] += 1
                if i == first or i + 1 == last:
                    continue
                c = nodes[U(i + 1)]
                cx = points[c, 0] - points[o, 0]
                cy = points[c, 1] - points[o, 1]
                cz = points[c, 2] - points[o, 2]
                part = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
                part *= sign / 6.0
                volume[U(cell)] += part
                moment[U(cell), 0] += part * (ax + bx + cx)
                moment[U(cell), 1] += part * (ay + by + cy)
                moment[U(cell), 2] += part * (az + bz + cz)
