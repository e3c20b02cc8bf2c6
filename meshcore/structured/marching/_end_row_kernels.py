"""Ends of planar marching fronts in the equations of a step: given, mirrored or free rows, and the lines beside."""

import math

from ..._numba import kernel
from ._marching_front_kernels import ALONG, HEIGHT, MIRROR, SPACING, SPLAY, TANGENT, TINY, WALL

LEANING = 12  # lines beside an end that lean like it, at least
CROWDING = 4.0  # times the way by which an end has left its normal, over which lines lean like it


@kernel
def given_row(k, x, y, lower, diagonal, upper, d):
    """Replace the equations of a point by a given displacement."""
    for c in range(4):
        lower[k, c], upper[k, c], diagonal[k, c] = 0.0, 0.0, 0.0
    diagonal[k, 0], diagonal[k, 3] = 1.0, 1.0
    d[k, 0], d[k, 1] = x, y


@kernel
def end_row(end, kind, direction, scratch, lower, diagonal, upper, d):
    """Put the condition of an open front's end into its equations."""
    k = 0 if end == 0 else d.shape[0] - 1
    outside, inside = (lower, upper) if end == 0 else (upper, lower)
    x, y = direction[0], direction[1]
    if kind == MIRROR:  # the ghost's displacement is the mirror image of the neighbour's
        r0, r1, r3 = 2 * x * x - 1, 2 * x * y, 2 * y * y - 1
        o0, o1, o2, o3 = outside[k, 0], outside[k, 1], outside[k, 2], outside[k, 3]
        inside[k, 0] += o0 * r0 + o1 * r1
        inside[k, 1] += o0 * r1 + o1 * r3
        inside[k, 2] += o2 * r0 + o3 * r1
        inside[k, 3] += o2 * r1 + o3 * r3
        return
    g = k + 2
    tx, ty, h = scratch[TANGENT, g], scratch[TANGENT + 1, g], scratch[HEIGHT, g]
    if kind == SPLAY:  # leaning outwards by the angle of cosine x and sine y
        out = -y if end == 0 else y
        given_row(k, h * (out * tx - x * ty), h * (out * ty + x * tx), lower, diagonal, upper, d)
    elif kind == ALONG:  # along a direction, as far as the neighbour
        given_row(k, 0.0, 0.0, lower, diagonal, upper, d)
        inside[k, 0], inside[k, 1], inside[k, 2], inside[k, 3] = -x * x, -x * y, -x * y, -y * y
    else:  # free: normal to the front, drawn towards what the neighbour does
        a = h / scratch[SPACING, g]
        given_row(k, -ty * h, tx * h, lower, diagonal, upper, d)
        diagonal[k, 0], diagonal[k, 3] = 1 + a, 1 + a
        inside[k, 0], inside[k, 3] = -a, -a


@kernel
def lean(end, x, y, r, scratch, d):
    """Let the lines beside an end lean like it, the less the farther they are, or they would run into each other.

    The farther the front has come the more lines lean, so that they crowd no more than like a root of the way: over
    four times the way by which the end has left its normal.
    """
    n = d.shape[0]
    k, ahead = (0, 1) if end == 0 else (n - 1, -1)
    h, tx, ty = scratch[HEIGHT, k + 2], scratch[TANGENT, k + 2], scratch[TANGENT + 1, k + 2]
    x, y = x + h * ty, y - h * tx
    away = math.sqrt((r[0, k + 2] - scratch[WALL, end]) ** 2 + (r[1, k + 2] - scratch[WALL + 1, end]) ** 2)
    wide = CROWDING * away * abs(x * tx + y * ty) / (h + TINY)
    width, lines = 0.0, 1
    while lines < n - 1 and (lines < LEANING or width < wide):
        width += scratch[SPACING, k + 2 + lines * ahead]
        lines += 1
    gone = 0.0
    for q in range(1, lines):
        gone += scratch[SPACING, k + 2 + q * ahead]
        share = (1 - min(1.0, gone / (width + TINY))) ** 2
        to = k + q * ahead
        d[to, 0] += share * x
        d[to, 1] += share * y


@kernel
def point_at(curve, length):
    """The point of a polyline (x, y, length) at a length; beyond its end on its straight continuation."""
    low, high = 0, curve.shape[0] - 1
    while high - low > 1:
        middle = (low + high) // 2
        if curve[middle, 2] <= length:
            low = middle
        else:
            high = middle
    share = (length - curve[low, 2]) / (curve[high, 2] - curve[low, 2])
    return (
        curve[low, 0] + share * (curve[high, 0] - curve[low, 0]),
        curve[low, 1] + share * (curve[high, 1] - curve[low, 1]),
    )
