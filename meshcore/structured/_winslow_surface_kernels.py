"""The elliptic equations on a curved surface: their tangential part in the surface's parameters, and zebra lines.

Harmonic coordinates on a surface obey ``g^ij r_ij = 2 H n`` (Z. U. A. Warsi, "Numerical grid generation in arbitrary
surfaces through a second-order differential-geometric model", J. Comput. Phys. 64 (1986)): what is tangential of

    N = A (r_aa + P r_a) + B (r_bb + Q r_b) - 2 C r_ab,    A = g_22, B = g_11, C = g_12,

must vanish. N is taken from the points themselves, so that the solution does not depend on the parameters (u, v);
only the unknowns do. Arrays are flat, components one after another: points r (3 n), tangents t (S_u, then S_v: 6 n),
unknowns x, right sides f and control (2 n, the last may be empty); n = na nb, b fastest. In a cyclic grid the last row
along a is the first: it has no equations, and the caller makes it follow the first.
"""

from __future__ import annotations

import numpy as np

from .._numba import kernel

U = np.uint64
TINY = 1e-300


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
def equation(r, t, f, control, p, n, before, after):
    """At node p: A, B, and the two components of the defect ``tangential part of N - f``."""
    A = B = C = 0.0
    for q in range(3):
        o = p + q * n
        ra = 0.5 * (r[U(o + after)] - r[U(o + before)])
        rb = 0.5 * (r[U(o + 1)] - r[U(o - 1)])
        A += rb * rb
        B += ra * ra
        C += ra * rb
    left_u = left_v = uu = uv = vv = 0.0
    for q in range(3):
        o = p + q * n
        twice = 2.0 * r[U(o)]
        left = (
            A * (r[U(o + after)] - twice + r[U(o + before)])
            + B * (r[U(o + 1)] - twice + r[U(o - 1)])
            - 0.5 * C * (r[U(o + after + 1)] - r[U(o + after - 1)] - r[U(o + before + 1)] + r[U(o + before - 1)])
        )
        if len(control):
            left += 0.5 * A * control[U(p)] * (r[U(o + after)] - r[U(o + before)])
            left += 0.5 * B * control[U(p + n)] * (r[U(o + 1)] - r[U(o - 1)])
        tu = t[U(o)]
        tv = t[U(o + 3 * n)]
        left_u += tu * left
        left_v += tv * left
        uu += tu * tu
        uv += tu * tv
        vv += tv * tv
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
