"""The elliptic equations on a curved surface: their tangential part in the surface's parameters, and zebra lines.

Harmonic coordinates on a surface obey ``g^ij r_ij = 2 H n`` (Z. U. A. Warsi, "Numerical grid generation in arbitrary
surfaces through a second-order differential-geometric model", J. Comput. Phys. 64 (1986)): what is tangential of

    N = A (r_aa + P r_a) + B (r_bb + Q r_b) - 2 C r_ab,    A = g_22, B = g_11, C = g_12,

must vanish. N is taken from the points themselves, so that the solution does not depend on the parameters (u, v);
only the unknowns do.

What of N is tangential is told by the direction in which the rest points, and that is the grid's normal r_a x r_b, not
the surface's at the node: both are the same but for O(h^2), yet the surface's turns as the node moves. Where it turns
by much from one node to the next, as on top of a steep bump, that outweighs the neighbours' pull: the node is in
unstable balance there, and more so on coarse grids. The grid's normal, like all of N but -2 (A + B) r, depends on
the neighbours alone, who so hold the node wherever it is.

Arrays are flat, components one after another: points r (3 n), tangents t (S_u, then S_v: 6 n),
unknowns x, right sides f and control (2 n, the last may be empty); n = na nb, b fastest. In a cyclic grid the last row
along a is the first: it has no equations, and the caller makes it follow the first.
"""

from __future__ import annotations

import numpy as np

from ..._numba import kernel

U = np.uint64
TINY = 1e-300
LEAST_COSINE = 0.1
"""Where the grid's normal is nearer to the surface's tangents, in folded starts, it gives way to the surface's."""


@kernel
def neighbour_rows(a, shape, cyclic):
    """Offsets from a node in row a to those in the rows before and after it."""
    before = -shape[1]
    after = shape[1]
    if cyclic and a == 0:
        before = (shape[0] - 2) * shape[1]
    if cyclic and a == shape[0] - 2:
        after = -(shape[0] - 2) * shape[1]
    return before, after


@kernel
def cross(v, w):
    """The cross product of two vectors in space."""
    return v[1] * w[2] - v[2] * w[1], v[2] * w[0] - v[0] * w[2], v[0] * w[1] - v[1] * w[0]


@kernel
def dot(v, w):
    """The inner product of two vectors in space."""
    return v[0] * w[0] + v[1] * w[1] + v[2] * w[2]


@kernel
def vector(v, p, n):
    """The vector at node p."""
    return v[U(p)], v[U(p + n)], v[U(p + 2 * n)]


@kernel
def centred(r, p, q, n):
    """First difference across a node, from its neighbours p and q."""
    v = vector(r, p, n)
    w = vector(r, q, n)
    return 0.5 * (w[0] - v[0]), 0.5 * (w[1] - v[1]), 0.5 * (w[2] - v[2])


@kernel
def operator(r, o, before, after, weights, ra, rb):
    """One component of N, whose number at the node is o; ``weights`` are A, B, -2 C, A P and B Q."""
    twice = 2.0 * r[U(o)]
    raa = r[U(o + after)] - twice + r[U(o + before)]
    rbb = r[U(o + 1)] - twice + r[U(o - 1)]
    rab = 0.25 * (r[U(o + after + 1)] - r[U(o + after - 1)] - r[U(o + before + 1)] + r[U(o + before - 1)])
    return weights[0] * raa + weights[1] * rbb + weights[2] * rab + weights[3] * ra + weights[4] * rb


@kernel
def equation(r, t, f, control, p, n, before, after):
    """At node p: A, B, and the two components of the defect ``tangential part of N - f``."""
    ra = centred(r, p + before, p + after, n)
    rb = centred(r, p - 1, p + 1, n)
    A = dot(rb, rb)
    B = dot(ra, ra)
    C = dot(ra, rb)
    P = control[U(p)] if len(control) else 0.0
    Q = control[U(p + n)] if len(control) else 0.0
    weights = (A, B, -2.0 * C, A * P, B * Q)
    left = (
        operator(r, p, before, after, weights, ra[0], rb[0]),
        operator(r, p + n, before, after, weights, ra[1], rb[1]),
        operator(r, p + 2 * n, before, after, weights, ra[2], rb[2]),
    )
    tu = vector(t, p, n)
    tv = vector(t, p + 3 * n, n)
    s = cross(tu, tv)
    g = cross(ra, rb)
    both = dot(s, g)
    least = LEAST_COSINE * LEAST_COSINE * dot(s, s) * dot(g, g)
    lift = dot(left, s) * both / (max(both * both, least) + TINY)
    left = (left[0] - lift * g[0], left[1] - lift * g[1], left[2] - lift * g[2])
    left_u = dot(tu, left)
    left_v = dot(tv, left)
    uu = dot(tu, tu)
    uv = dot(tu, tv)
    vv = dot(tv, tv)
    area = uu * vv - uv * uv + TINY
    du = (vv * left_u - uv * left_v) / area
    dv = (uu * left_v - uv * left_u) / area
    return A, B, du - f[U(p)], dv - f[U(p + n)]


@kernel
def relax(r, t, x, f, control, shape, cyclic, axis, line):
    """Zebra lines along a (axis 0) or b (axis 1): every other line, then the rest. ``line`` is (4, longest) work.

    Points move in their tangent planes; the caller puts them back on the surface.
    """
    n = shape[0] * shape[1]
    ring = cyclic and axis == 0
    start = 0 if cyclic and axis == 1 else 1
    for colour in range(2):
        for k in range(start + colour, shape[1 - axis] - 1, 2):
            first = k if ring else (k + shape[1] if axis == 0 else k * shape[1] + 1)
            along = shape[1] if axis == 0 else 1
            count = shape[axis] - (1 if ring else 2)
            for l in range(count):
                p = first + l * along
                before, after = neighbour_rows(p // shape[1], shape, cyclic)
                A, B, du, dv = equation(r, t, f, control, p, n, before, after)
                strength = A if axis == 0 else B
                half = 0.5 * control[U(p + axis * n)] if len(control) else 0.0
                eliminate(line, l, count, ring, strength * (1.0 - half), 2.0 * (A + B), strength * (1.0 + half), du, dv)
            substitute(line, count, ring)
            for l in range(count):
                p = first + l * along
                du = line[1, l]
                dv = line[2, l]
                x[U(p)] += du
                x[U(p + n)] += dv
                for q in range(3):
                    r[U(p + q * n)] += t[U(p + q * n)] * du + t[U(p + (3 + q) * n)] * dv


@kernel
def eliminate(line, l, count, ring, low, middle, high, du, dv):
    """Row l of ``-low x[l-1] + middle x[l] - high x[l+1] = d``, l = 0..count-1, for two right sides (Thomas).

    Around a ring, x[count-1] is both the first row's neighbour and the last but one's: ``line[3]`` is how the others
    answer to it, and its own row is closed at once.
    """
    last = ring and l == count - 1
    ahead = line[0, l - 1] if l > 0 and not last else 0.0
    answer = 0.0
    if last:
        middle -= low * line[3, l - 1]
        du += low * line[1, l - 1]
        dv += low * line[2, l - 1]
        # x[0] is known once all rows between are substituted backwards.
        for k in range(l - 2, -1, -1):
            for q in range(1, 4):
                line[q, k] += line[0, k] * line[q, k + 1]
        middle -= high * line[3, 0]
        du += high * line[1, 0]
        dv += high * line[2, 0]
        line[0, l] = 0.0
        line[1, l] = du / (middle + TINY)
        line[2, l] = dv / (middle + TINY)
        line[3, l] = 0.0
        return
    if l > 0:
        du += low * line[1, l - 1]
        dv += low * line[2, l - 1]
        answer = low * line[3, l - 1]
    elif ring:
        answer = low
    if ring and l == count - 2:
        answer += high
        high = 0.0
    pivot = 1.0 / (middle + TINY - low * ahead)
    line[0, l] = high * pivot
    line[1, l] = du * pivot
    line[2, l] = dv * pivot
    line[3, l] = answer * pivot


@kernel
def substitute(line, count, ring):
    """The solutions, in ``line[1]`` and ``line[2]``."""
    if ring:
        for l in range(count - 1):
            line[1, l] += line[3, l] * line[1, count - 1]
            line[2, l] += line[3, l] * line[2, count - 1]
        return
    for l in range(count - 2, -1, -1):
        line[1, l] += line[0, l] * line[1, l + 1]
        line[2, l] += line[0, l] * line[2, l + 1]


@kernel
def defect(r, t, f, control, shape, cyclic, d):
    """``d = f - tangential part of N``; returns the sum of the squares of what point relaxation would move nodes."""
    n = shape[0] * shape[1]
    total = 0.0
    for a in range(0 if cyclic else 1, shape[0] - 1):
        before, after = neighbour_rows(a, shape, cyclic)
        for b in range(1, shape[1] - 1):
            p = a * shape[1] + b
            A, B, du, dv = equation(r, t, f, control, p, n, before, after)
            d[U(p)] = -du
            d[U(p + n)] = -dv
            scale = 1.0 / (2.0 * (A + B) + TINY)
            for q in range(3):
                total += (scale * (t[U(p + q * n)] * du + t[U(p + (3 + q) * n)] * dv)) ** 2
    return total
