"""Fronts that are about to meet across a bay: where, and how hard they must be drawn out of it.

Hyperbolic equations are local: one wall of a bay does not see the other coming (survey 2.7.1: grid lines overlap and
volumes become negative). Here pairs of points that face each other are looked for at all scales, in n log n work.
"""

import math

from .._numba import kernel

TINY = 1e-300
LAYERS_AHEAD = 16.0  # layers of the present height until two fronts meet, from which on they are drawn out of the bay
DRAW = 0.25  # dissipation a layer for a window of one point to either side
FACING = 0.5  # cosine between normals and the line across, from which on heights shrink
SLOW = 5.0  # layers until fronts meet, from which on heights shrink
SLOWEST = 0.02


@kernel
def collisions(r, t, turned, h, closed, strength, shrink, spare, spare2):
    """Dissipation against fronts that are about to meet, and by how much heights shrink, at each point.

    A pair of points, m before and m behind a third, faces each other across a bay if their normals point at each other
    and the front turns left between them; heights over the gap tell how many layers are left until they meet. The
    window's points then need a dissipation like m^2, to be drawn out of the bay in a few layers: diffusion along the
    index takes m points in a time of m^2. Windows double from level to level, and hand what they found to the two
    halves of theirs.
    """
    n = h.size - 4
    m = 1
    while 4 * m <= n:
        m *= 2
    for k in range(n + 4):
        spare[k] = 0.0
        spare2[k] = 1.0
    while m >= 1:
        for k in range(2, n + 2):
            a, b = k - m, k + m
            wrap = 0.0
            if closed:
                if a < 2:
                    a += n
                    wrap = turned[n + 1] + 0.0
                if b >= n + 2:
                    b -= n
                    wrap = turned[n + 1] + 0.0
            elif a < 2 or b >= n + 2:
                continue
            x, y = r[0, b] - r[0, a], r[1, b] - r[1, a]
            one = -t[1, a] * x + t[0, a] * y
            other = t[1, b] * x - t[0, b] * y
            if one > 0 and other > 0 and turned[b] - turned[a] + wrap > 0:
                left = (x * x + y * y) / (one * h[a] + other * h[b] + TINY)
                if left < LAYERS_AHEAD:
                    urgency = min(LAYERS_AHEAD / left - 1, 4.0)
                    spare[k] = max(spare[k], DRAW * m * m * urgency)
                    gap = math.sqrt(x * x + y * y) + TINY
                    facing = min(1.0, max(0.0, (min(one, other) / gap - FACING) / (1 - FACING)))
                    slower = max(SLOWEST, min(1.0, left / SLOW))
                    spare2[k] = min(spare2[k], 1 - facing * (1 - slower))
        half = m // 2
        for k in range(2, n + 2):
            strength[k] = spare[k]
            shrink[k] = spare2[k]
        if half:
            for k in range(2, n + 2):
                if spare[k] > 0 or spare2[k] < 1:
                    for to in (k - half, k + half):
                        if closed:
                            to = to + n if to < 2 else to - n if to >= n + 2 else to
                        elif to < 2 or to >= n + 2:
                            continue
                        strength[to] = max(strength[to], spare[k])
                        shrink[to] = min(shrink[to], spare2[k])
            for k in range(2, n + 2):
                spare[k] = strength[k]
                spare2[k] = shrink[k]
        m = half
