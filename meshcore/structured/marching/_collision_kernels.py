"""Fronts that are about to meet across a bay: where, and how hard they must be drawn out of it.

Hyperbolic equations are local: one wall of a bay does not see the other coming (survey 2.7.1: grid lines overlap and
volumes become negative). Here pairs of points that face each other are looked for: everywhere in windows of sizes that
grow by a seventh or so, in n log n work, and where the front has a bay, whose mouth may be a few points wide and fall
between two sizes, among all pairs of at most 512 points.
"""

import math

from ..._numba import kernel

TINY = 1e-300
LAYERS_AHEAD = 16.0  # layers of the present height until two fronts meet, from which on they are drawn out of the bay
DRAW = 0.25  # dissipation a layer for a window of one point to either side
FACING = 0.5  # cosine between normals and the line across, from which on heights shrink
SLOW = 5.0  # layers until fronts meet, from which on heights shrink
SLOWEST = 0.02
BAY = 1.0  # left turn (radians) of a front from which on it has a bay
MOST = 512  # points of a front that are compared with each other


@kernel
def collisions(r, t, turned, h, closed, strength, shrink, scratch):
    """Dissipation against fronts that are about to meet, and by how much heights shrink, at each point.

    Windows of m points before and m behind a point are looked at for m = 5, 6, 7, 8 times the powers of two, and for 1,
    2 and 4; from the largest on, each hands what was found to windows of half its size, in it and a quarter beyond it,
    and so in the end to its points. ``turned`` is how far the front has turned to the left up to each point;
    ``scratch`` has four rows.
    """
    n = h.size - 4
    found, slower = scratch[0], scratch[1]
    for k in range(n + 4):
        strength[k], shrink[k] = 0.0, 1.0
    for first in range(5, 9):
        m = first
        while 4 * m < n:
            m *= 2
        for k in range(n + 4):
            found[k], slower[k] = 0.0, 1.0
        any_found = False
        while m >= (1 if first == 8 else 5):
            if 2 * m < n:
                any_found |= look_across(m, r, t, turned, h, closed, found, slower)
                if any_found:
                    hand_down(max(1, 3 * m // 4), closed, scratch)
            m //= 2
        if any_found:
            for k in range(2, n + 2):
                strength[k], shrink[k] = max(strength[k], found[k]), min(shrink[k], slower[k])
    if deepest_bay(turned, closed) > BAY:
        across_bays(r, t, turned, h, closed, strength, shrink)
    closing_edges(r, t, h, closed, strength)


@kernel
def look_across(m, r, t, turned, h, closed, strength, shrink):
    """Look at each window of m points to either side: do its ends face each other, and how soon do they meet?

    They do if their normals point at each other and the front turns left between them; the gap over the heights tells
    how many layers are left. The window's points then need a dissipation like m^2, to be drawn out of the bay in a few
    layers: diffusion along the index takes m points in a time of m^2.
    """
    n = h.size - 4
    any_found = False
    for k in range(2, n + 2):
        a, b, wrap = k - m, k + m, 0.0
        if closed:
            if a < 2:
                a, wrap = a + n, turned[n + 1]
            elif b >= n + 2:
                b, wrap = b - n, turned[n + 1]
        elif a < 2 or b >= n + 2:
            continue
        if turned[b] - turned[a] + wrap > 0:
            left, facing = layers_left(a, b, r, t, h)
            if left < LAYERS_AHEAD:
                any_found = True
                strength[k] = max(strength[k], drawing(m, left))
                shrink[k] = min(shrink[k], slowing(left, facing))
    return any_found


@kernel(inline=True)
def layers_left(a, b, r, t, h):
    """Layers until two points meet, many if they do not face each other; the least cosine of normal and line across."""
    x, y = r[0, b] - r[0, a], r[1, b] - r[1, a]
    square, near = x * x + y * y, LAYERS_AHEAD * (h[a] + h[b])
    if square >= near * near:
        return LAYERS_AHEAD, 0.0
    one, other = t[0, a] * y - t[1, a] * x, t[1, b] * x - t[0, b] * y
    if not (one > 0 and other > 0):
        return LAYERS_AHEAD, 0.0
    return square / (one * h[a] + other * h[b] + TINY), min(one, other) / (math.sqrt(square) + TINY)


@kernel(inline=True)
def drawing(m, left):
    """Dissipation of windows of m points to either side, whose ends meet in so many layers."""
    return DRAW * m * m * min(LAYERS_AHEAD / left - 1, 4.0)


@kernel(inline=True)
def slowing(left, facing):
    """The share that is left of heights."""
    straight = min(1.0, max(0.0, (facing - FACING) / (1 - FACING)))
    return 1 - straight * (1 - max(SLOWEST, min(1.0, left / SLOW)))


@kernel
def deepest_bay(turned, closed):
    """Radians by which a part of the front turns to the left, at most."""
    n = turned.size - 4
    least, most = turned[2], 0.0
    for k in range(2 * n if closed else n):
        at = turned[k + 2] if k < n else turned[k - n + 2] + turned[n + 1]
        least = min(least, at)
        most = max(most, at - least)
    return most


@kernel
def across_bays(r, t, turned, h, closed, strength, shrink):
    """Compare points with all others across a bay, give what is needed to those between and half as far beyond."""
    n = h.size - 4
    stride = (n + MOST - 1) // MOST
    for a in range(2, n + 2, stride):
        soonest, away, facing = LAYERS_AHEAD, 0, 0.0
        for ahead in range(2 * stride, n if closed else n + 2 - a, stride):
            b, wrap = a + ahead, 0.0
            if b >= n + 2:
                b, wrap = b - n, turned[n + 1]
            if turned[b] - turned[a] + wrap > BAY:
                left, straight = layers_left(a, b, r, t, h)
                if left < soonest:
                    soonest, away, facing = left, ahead, straight
        if away > 0:
            needed, slower = drawing(0.5 * away, soonest), slowing(soonest, facing)
            for at in range(a - away // 4, a + away + away // 4 + 1):
                k = at
                if closed:
                    k = at + n if at < 2 else at - n if at >= n + 2 else at
                if 2 <= k < n + 2:
                    strength[k], shrink[k] = max(strength[k], needed), min(shrink[k], slower)


@kernel
def hand_down(away, closed, scratch):
    """Give what windows found, rows 0 and 1, to those that are ``away`` points before and behind, too."""
    found, slower, below, slower_below = scratch[0], scratch[1], scratch[2], scratch[3]
    n = found.size - 4
    for k in range(2, n + 2):
        below[k], slower_below[k] = found[k], slower[k]
    for k in range(2, n + 2):
        if found[k] > 0:
            for to in (k - away, k + away):
                if closed:
                    to = to + n if to < 2 else to - n if to >= n + 2 else to
                elif to < 2 or to >= n + 2:
                    continue
                below[to], slower_below[to] = max(below[to], found[k]), min(slower_below[to], slower[k])
    for k in range(2, n + 2):
        found[k], slower[k] = below[k], slower_below[k]


@kernel
def closing_edges(r, t, h, closed, strength):
    """Dissipation at both ends of edges that are about to vanish, as the lines that leave them run together."""
    n = h.size - 4
    for a in range(2, n + 2 if closed else n + 1):
        b = a + 1 if a < n + 1 else 2
        x, y = r[0, b] - r[0, a], r[1, b] - r[1, a]
        closing = x * (h[b] * t[1, b] - h[a] * t[1, a]) - y * (h[b] * t[0, b] - h[a] * t[0, a])
        if closing > 0:
            left = (x * x + y * y) / closing
            if left < LAYERS_AHEAD:
                needed = DRAW * min(LAYERS_AHEAD / left - 1, 4.0)
                strength[a], strength[b] = max(strength[a], needed), max(strength[b], needed)
