"""Kernels of a step's equations: the hyperbolic terms of layers on a graph of nodes, and their solution.

Rings and `held` are as in `_layer_kernels`. Sums are taken over blocks of nodes, so that they do not depend on who
shares the work.
"""

import math

import numpy as np

from ..._numba import kernel
from ._layer_kernels import corner, held_vector

U = np.uint64
BLOCK = 256
PRODUCT, HALF, SECOND, FULL = 0, 1, 2, 3  # phases of an iteration; rows of sums
SHARP = 0.5  # least cosine between a normal and its corners' from which equations count in whole


@kernel
def hyperbolic_terms(
    first, last, height, points, normal, start, ring, opened, held, projectors, free, across, own, flat, widening, right
):
    """Derivatives of the area vectors, how much the layer widens, and how the normals turn in a step.

    The equations (W. M. Chan, J. L. Steger, 1992, eq. 1) ask lines to be orthogonal to the layers, and cells to have
    the volume V: r_zeta = V A / |A|^2, with the area vector A = r_xi x r_eta. On a ring of any number of nodes it is
    the sum of its corners' u x v; weighted by 1 / (|u|^2 |v|^2) it has the direction of the front's normal n, see
    `normals`. Linearised in the displacements d of the nodes, with these weights kept, it changes by the sum of
    d_k x w_k, and the step h n by the sum of d_k x a_k less twice its part along n, where a = h w / (A . n): tilted
    faces turn the normal, widened ones have less height. Both are the real waves that the name of the method tells of.

    Parameters
    ----------
    height : float
        Height h of the step.
    points, normal : (n, 3) float
        The front and its normals.
    across : (k, 3) float
        The a of each neighbour; out. Nil at free edges, where nothing is known of the other side.
    own : (n, 3) float
        The same for the node itself; out.
    flat : (n,) float
        Least cosine between the node's normal and those of its corners, by which all terms are to be multiplied: at
        sharp edges derivatives tell little of a step that is longer than the edges; out.
    widening : (n,) float
        Part by which the area grows over a step h n of all nodes; out.
    right : (n, 3) float
        The turn of the step h n is added.
    """
    for i in range(first, last):
        begin = start[U(i)]
        count = start[U(i + 1)] - begin
        nx, ny, nz = normal[U(i), 0], normal[U(i), 1], normal[U(i), 2]
        for k in range(begin, begin + count):
            across[U(k), 0] = across[U(k), 1] = across[U(k), 2] = 0.0
        area, least = 0.0, 1.0
        for k in range(count - opened[U(i)]):
            one, two = begin + k, begin + (k + 1) % count
            a, b = ring[U(one)], ring[U(two)]
            cx, cy, cz, uu, vv = corner(points, i, a, b)
            w = 1.0 / (uu * vv)
            seen = cx * nx + cy * ny + cz * nz
            area += w * seen
            least = min(least, seen / math.sqrt(cx * cx + cy * cy + cz * cz))
            for axis in range(3):
                across[U(one), axis] += w * (points[U(b), axis] - points[U(i), axis])
                across[U(two), axis] -= w * (points[U(a), axis] - points[U(i), axis])
        scale = height / area if area > 0 and not free[U(i)] else 0.0
        flat[U(i)] = min(1.0, max(0.0, least / SHARP))
        ox, oy, oz, gx, gy, gz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(begin, begin + count):
            ax, ay, az = scale * across[U(k), 0], scale * across[U(k), 1], scale * across[U(k), 2]
            across[U(k), 0], across[U(k), 1], across[U(k), 2] = ax, ay, az
            ox, oy, oz = ox - ax, oy - ay, oz - az
            j = ring[U(k)]
            dx, dy, dz = normal[U(j), 0] - nx, normal[U(j), 1] - ny, normal[U(j), 2] - nz
            gx, gy, gz = gx + dy * az - dz * ay, gy + dz * ax - dx * az, gz + dx * ay - dy * ax
        own[U(i), 0], own[U(i), 1], own[U(i), 2] = ox, oy, oz
        along = gx * nx + gy * ny + gz * nz
        widening[U(i)] = along
        gx, gy, gz = held_vector(held, projectors, i, gx - along * nx, gy - along * ny, gz - along * nz)
        turn = height * flat[U(i)]
        right[U(i), 0] += turn * gx
        right[U(i), 1] += turn * gy
        right[U(i), 2] += turn * gz


@kernel
def begin(
    first, last, n, lost, ratio, flat, widening, mean, normal, strength, right, solution, rest, shadow, direction, sums
):
    """Put the right side together, divide it by the diagonal, and begin with ``ratio`` times the last corrections.

    The heights lost are ``lost`` times what a node's area widens more than the mean. Sums as of `full_step`.
    """
    for block in range(first, last):
        largest, square = 0.0, 0.0
        for i in range(block * BLOCK, min(n, (block + 1) * BLOCK)):
            less = lost * flat[U(i)] * (widening[U(i)] - mean[U(i)])
            scale = 1.0 / (1.0 + strength[U(i)])
            for axis in range(3):
                value = scale * (right[U(i), axis] - less * normal[U(i), axis])
                solution[U(i), axis] = ratio * solution[U(i), axis] if ratio > 0 else 0.0
                rest[U(i), axis] = shadow[U(i), axis] = direction[U(i), axis] = value
                square += value * value
                largest = max(largest, abs(value))
        sums[0, U(block)], sums[1, U(block)] = square, largest


@kernel
def begin_near(first, last, n, image, rest, shadow, direction, sums):
    """Take what the first corrections solve, their `product`, off the rest."""
    for block in range(first, last):
        largest, square = 0.0, 0.0
        for i in range(block * BLOCK, min(n, (block + 1) * BLOCK)):
            for axis in range(3):
                value = rest[U(i), axis] - image[U(i), axis]
                rest[U(i), axis] = shadow[U(i), axis] = direction[U(i), axis] = value
                square += value * value
                largest = max(largest, abs(value))
        sums[0, U(block)], sums[1, U(block)] = square, largest


@kernel
def product(
    first, last, n, volume, start, ring, held, projectors, normal, across, own, flat, now, strength, shadow, x, y, sums
):
    """The equations' left side y of the corrections x, divided by the diagonal; sums: shadow . y, x . y, y . y.

    It is x - F x - e L x, with the hyperbolic terms F and the dissipation e times the Laplacian L. Of the change of
    area, ``volume`` = 1 takes away as much height as keeps the cell's volume, 0 keeps the height.
    """
    for block in range(first, last):
        one, two, three = 0.0, 0.0, 0.0
        for i in range(block * BLOCK, min(n, (block + 1) * BLOCK)):
            px, py, pz = x[U(i), 0], x[U(i), 1], x[U(i), 2]
            ax, ay, az = own[U(i), 0], own[U(i), 1], own[U(i), 2]
            gx, gy, gz = py * az - pz * ay, pz * ax - px * az, px * ay - py * ax
            lx, ly, lz = 0.0, 0.0, 0.0
            for k in range(start[U(i)], start[U(i + 1)]):
                j = ring[U(k)]
                dx, dy, dz = x[U(j), 0], x[U(j), 1], x[U(j), 2]
                ax, ay, az = across[U(k), 0], across[U(k), 1], across[U(k), 2]
                gx += dy * az - dz * ay
                gy += dz * ax - dx * az
                gz += dx * ay - dy * ax
                w = now[U(k)]
                lx, ly, lz = lx + w * dx, ly + w * dy, lz + w * dz
            nx, ny, nz = normal[U(i), 0], normal[U(i), 1], normal[U(i), 2]
            along = (1.0 + volume) * (gx * nx + gy * ny + gz * nz)
            e, f = strength[U(i)], flat[U(i)]
            gx, gy, gz = f * (gx - along * nx) + e * lx, f * (gy - along * ny) + e * ly, f * (gz - along * nz) + e * lz
            gx, gy, gz = held_vector(held, projectors, i, gx, gy, gz)
            scale = 1.0 / (1.0 + e)
            gx, gy, gz = px - scale * gx, py - scale * gy, pz - scale * gz
            y[U(i), 0], y[U(i), 1], y[U(i), 2] = gx, gy, gz
            one += shadow[U(i), 0] * gx + shadow[U(i), 1] * gy + shadow[U(i), 2] * gz
            two += px * gx + py * gy + pz * gz
            three += gx * gx + gy * gy + gz * gz
        sums[0, U(block)], sums[1, U(block)], sums[2, U(block)] = one, two, three


@kernel
def half_step(first, last, n, alpha, image, shadow, rest, sums):
    """Take the first half of an iteration off the rest; sums: shadow . rest and the largest rest."""
    for block in range(first, last):
        total, largest = 0.0, 0.0
        for i in range(block * BLOCK, min(n, (block + 1) * BLOCK)):
            for axis in range(3):
                value = rest[U(i), axis] - alpha * image[U(i), axis]
                rest[U(i), axis] = value
                total += shadow[U(i), axis] * value
                largest = max(largest, abs(value))
        sums[0, U(block)], sums[1, U(block)] = total, largest


@kernel
def full_step(first, last, n, alpha, omega, beta, image, second, direction, rest, solution, sums):
    """Add both halves of an iteration to the solution; the rest and the direction after it; sums: the largest rest."""
    for block in range(first, last):
        largest = 0.0
        for i in range(block * BLOCK, min(n, (block + 1) * BLOCK)):
            for axis in range(3):
                p, s = direction[U(i), axis], rest[U(i), axis]
                solution[U(i), axis] += alpha * p + omega * s
                value = s - omega * second[U(i), axis]
                rest[U(i), axis] = value
                direction[U(i), axis] = value + beta * (p - omega * image[U(i), axis])
                largest = max(largest, abs(value))
        sums[1, U(block)] = largest


@kernel
def total_of(values):
    """Their sum."""
    total = 0.0
    for value in values:
        total += value
    return total


@kernel
def largest_of(values):
    """The largest of them."""
    largest = values[0]
    for value in values:
        largest = max(largest, value)
    return largest


@kernel
def iterate(
    first, last, n, phase, until, enough, volume, start, ring, held, projectors, normal, across, own, flat, now,
    strength, shadow, direction, rest, image, second, solution, lengths, sums,
):  # fmt: skip
    """Phases of BiCGStab from ``phase`` on, on blocks ``first`` to ``last``; returns the phase at which it is solved.

    An iteration has four, each of which needs the one before on all blocks: whoever has all of them can do all phases
    at one go. Everyone adds up the blocks' sums, so that the step lengths are the same for all.

    Parameters
    ----------
    enough : float
        Rest that need not be solved.
    lengths : (iterations + 1, 2) float
        shadow . rest at the begin of each iteration, the first of which is given, and its alpha.
    sums : (4, 3, blocks) float
        Of the last product, half step, second product and full step.
    """
    for k in range(phase, until):
        m, what = k // 4, k % 4
        if what == PRODUCT:
            if not largest_of(sums[FULL, 1]) > enough:
                return k
            product(
                first, last, n, volume, start, ring, held, projectors, normal, across, own, flat, now, strength,
                shadow, direction, image, sums[PRODUCT],
            )  # fmt: skip
        elif what == HALF:
            along = total_of(sums[PRODUCT, 0])
            alpha = lengths[m, 0] / along if along != 0 else 0.0
            lengths[m, 1] = alpha
            half_step(first, last, n, alpha, image, shadow, rest, sums[HALF])
        elif what == SECOND:
            if largest_of(sums[HALF, 1]) > enough:
                product(
                    first, last, n, volume, start, ring, held, projectors, normal, across, own, flat, now, strength,
                    shadow, rest, second, sums[SECOND],
                )  # fmt: skip
        else:
            rho, alpha, omega, beta = lengths[m, 0], lengths[m, 1], 0.0, 0.0
            if largest_of(sums[HALF, 1]) > enough:
                square = total_of(sums[SECOND, 2])
                omega = total_of(sums[SECOND, 1]) / square if square != 0 else 0.0
                lengths[m + 1, 0] = total_of(sums[HALF, 0]) - omega * total_of(sums[SECOND, 0])
                beta = lengths[m + 1, 0] / rho * alpha / omega if rho != 0 and omega != 0 else 0.0
            full_step(first, last, n, alpha, omega, beta, image, second, direction, rest, solution, sums[FULL])
    return until
