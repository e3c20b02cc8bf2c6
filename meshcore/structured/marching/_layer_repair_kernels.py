"""Kernels that repair a layer whose cells fold at a few nodes: each node in turn goes to where its corners are better.

Rings and `held` are as in `_layer_kernels`. A corner's share is the sine of the cell's corner over that of the wall's
face there: slivers of the wall may stay slivers, but none of the layer's corners may become much flatter.
"""

import math

import numpy as np

from ..._numba import kernel
from ._layer_kernels import corner, held_vector

U = np.uint64
SOFT = 0.1  # share by which a corner is better that counts e times less
STEEPEST = 50.0  # largest exponent
STAY = 0.3  # cost of a node that has moved by the layer's height
STEP = 0.3  # first step along the gradient, in units of the least of height and spacing
SHORTER, TRIES = 0.4, 7  # of steps that make nothing better
NUDGE = 1e-3  # for differences, in the same units


@kernel(inline=True)
def line(below, above, i):
    """The line of node i from layer to layer, and its length."""
    x = above[U(i), 0] - below[U(i), 0]
    y = above[U(i), 1] - below[U(i), 1]
    z = above[U(i), 2] - below[U(i), 2]
    return x, y, z, math.sqrt(x * x + y * y + z * z)


@kernel(inline=True)
def share(wall, front, i, a, b, x, y, z, length):
    """The share of the corner at node i between a and b of a front, and the line (x, y, z)."""
    cx, cy, cz, uu, vv = corner(wall, i, a, b)
    size = math.sqrt((cx * cx + cy * cy + cz * cz) / (uu * vv))
    cx, cy, cz, uu, vv = corner(front, i, a, b)
    return (cx * x + cy * y + cz * z) / (length * math.sqrt(uu * vv) * size)


@kernel(inline=True)
def cost(shared):
    """What a corner counts: large if it is folded, nothing if it is like the wall's."""
    return math.exp(min(-shared / SOFT, STEEPEST))


@kernel
def worst_shares(first, last, wall, below, above, start, ring, opened, worst):
    """The least share of each node's corners on both layers; out in `worst`."""
    for i in range(first, last):
        begin = start[U(i)]
        count = start[U(i + 1)] - begin
        x, y, z, length = line(below, above, i)
        least = 1e300
        for k in range(count - opened[U(i)]):
            a = ring[U(begin + k)]
            b = ring[U(begin + (k + 1) % count)]
            least = min(least, share(wall, below, i, a, b, x, y, z, length))
            least = min(least, share(wall, above, i, a, b, x, y, z, length))
        worst[U(i)] = least


@kernel
def node_cost(i, wall, below, above, target, height, start, ring, opened):
    """The cost of all corners that node i has part in, and of its way from where it was to be."""
    way = 0.0
    for axis in range(3):
        way += (above[U(i), axis] - target[U(i), axis]) ** 2
    total = STAY * way / (height * height)
    begin = start[U(i)]
    count = start[U(i + 1)] - begin
    x, y, z, length = line(below, above, i)
    for k in range(count - opened[U(i)]):
        a = ring[U(begin + k)]
        b = ring[U(begin + (k + 1) % count)]
        total += cost(share(wall, below, i, a, b, x, y, z, length))
        total += cost(share(wall, above, i, a, b, x, y, z, length))
    for k in range(begin, begin + count):
        j = ring[U(k)]
        first = start[U(j)]
        size = start[U(j + 1)] - first
        x, y, z, length = line(below, above, j)
        for m in range(size - opened[U(j)]):
            a = ring[U(first + m)]
            b = ring[U(first + (m + 1) % size)]
            if a == i or b == i:
                total += cost(share(wall, above, j, a, b, x, y, z, length))
    return total


@kernel
def relax(nodes, wall, below, above, target, height, start, ring, opened, held, projectors, slope):
    """Move nodes of a layer one after the other down the slope of their cost, if that helps; returns how many did.

    Parameters
    ----------
    nodes : (m,) int
        Which may move, in this order.
    wall, below, above, target : (n, 3) float
        The surface, the layer below, this one, which is changed, and where it was to be.
    height : float
        Of the layer.
    slope : (3,) float
        Room.
    """
    moved = 0
    for i in nodes:
        scale = height
        for k in range(start[U(i)], start[U(i + 1)]):
            _x, _y, _z, length = line(above[U(i) : U(i + 1)], above[U(ring[U(k)]) : U(ring[U(k)] + 1)], 0)
            scale = min(scale, length)
        px, py, pz = above[U(i), 0], above[U(i), 1], above[U(i), 2]
        for axis in range(3):
            here = above[U(i), axis]
            above[U(i), axis] = here + NUDGE * scale
            more = node_cost(i, wall, below, above, target, height, start, ring, opened)
            above[U(i), axis] = here - NUDGE * scale
            slope[axis] = more - node_cost(i, wall, below, above, target, height, start, ring, opened)
            above[U(i), axis] = here
        gx, gy, gz = held_vector(held, projectors, i, slope[0], slope[1], slope[2])
        size = math.sqrt(gx * gx + gy * gy + gz * gz)
        if not 0 < size < 1e300:
            continue
        before = node_cost(i, wall, below, above, target, height, start, ring, opened)
        step = STEP * scale / size
        for _ in range(TRIES):
            above[U(i), 0], above[U(i), 1], above[U(i), 2] = px - step * gx, py - step * gy, pz - step * gz
            if node_cost(i, wall, below, above, target, height, start, ring, opened) < before:
                moved += 1
                break
            step *= SHORTER
        else:
            above[U(i), 0], above[U(i), 1], above[U(i), 2] = px, py, pz
    return moved
