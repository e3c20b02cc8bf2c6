"""The elliptic equations on a curved surface: their tangential part in the surface's parameters, and zebra lines.

Harmonic coordinates on a surface obey ``g^ij r_ij = 2 H n`` (Z. U. A. Warsi, "Numerical grid generation in arbitrary
surfaces through a second-order differential-geometric model", J. Comput. Phys. 64 (1986)): what is tangential of

    N = A (r_aa + P r_a) + B (r_bb + Q r_b) - 2 C r_ab,    A = g_22, B = g_11, C = g_12,

must vanish. N is taken from the points themselves, so that the solution does not depend on the parameters (u, v);
only the unknowns do. Arrays are flat, components one after another: points r (3 n), tangents t (S_u, then S_v: 6 n),
unknowns x, right sides f and control (2 n, the last may be empty); n = na nb, b fastest.
"""

from __future__ import annotations

import numpy as np

from .._numba import kernel

U = np.uint64
TINY = 1e-300


@kernel
def equation(r, t, f, control, p, n, s):
    """At node p: A, B, and the two components of the defect ``tangential part of N - f``."""
    A = B = C = 0.0
    for q in range(3):
        o = p + q * n
        ra = 0.5 * (r[U(o + s)] - r[U(o - s)])
        rb = 0.5 * (r[U(o + 1)] - r[U(o - 1)])
        A += rb * rb
        B += ra * ra
        C += ra * rb
    left_u = left_v = uu = uv = vv = 0.0
    for q in range(3):
        o = p + q * n
        twice = 2.0 * r[U(o)]
        left = (
            A * (r[U(o + s)] - twice + r[U(o - s)])
            + B * (r[U(o + 1)] - twice + r[U(o - 1)])
            - 0.5 * C * (r[U(o + s + 1)] - r[U(o + s - 1)] - r[U(o - s + 1)] + r[U(o - s - 1)])
        )
        if len(control):
            left += 0.5 * A * control[U(p)] * (r[U(o + s)] - r[U(o - s)])
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
def relax(r, t, x, f, control, shape, axis, line):
    """Zebra lines along a (axis 0) or b (axis 1): every other line, then the rest. ``line`` is (4, longest) work.

    Points move in their tangent planes; the caller puts them back on the surface.
    """
    n = shape[0] * shape[1]
    s = shape[1]
    along = s if axis == 0 else 1
    across = 1 if axis == 0 else s
    count = shape[axis] - 2
    line[:, 0] = 0.0
    for colour in range(2):
        for k in range(1 + colour, shape[1 - axis] - 1, 2):
            for l in range(1, count + 1):
                p = k * across + l * along
                A, B, du, dv = equation(r, t, f, control, p, n, s)
                strength = A if axis == 0 else B
                half = 0.5 * control[U(p + axis * n)] if len(control) else 0.0
                low = strength * (1.0 - half)
                pivot = 1.0 / (2.0 * (A + B) + TINY - low * line[0, l - 1])
                line[0, l] = strength * (1.0 + half) * pivot
                line[1, l] = (du + low * line[1, l - 1]) * pivot
                line[2, l] = (dv + low * line[2, l - 1]) * pivot
            du = dv = 0.0
            for l in range(count, 0, -1):
                p = k * across + l * along
                du = line[1, l] + line[0, l] * du
                dv = line[2, l] + line[0, l] * dv
                x[U(p)] += du
                x[U(p + n)] += dv
                for q in range(3):
                    r[U(p + q * n)] += t[U(p + q * n)] * du + t[U(p + (3 + q) * n)] * dv


@kernel
def defect(r, t, f, control, shape, d):
    """``d = f - tangential part of N``; returns the sum of the squares of what point relaxation would move nodes."""
    n = shape[0] * shape[1]
    s = shape[1]
    total = 0.0
    for a in range(1, shape[0] - 1):
        for b in range(1, shape[1] - 1):
            p = a * s + b
            A, B, du, dv = equation(r, t, f, control, p, n, s)
            d[U(p)] = -du
            d[U(p + n)] = -dv
            scale = 1.0 / (2.0 * (A + B) + TINY)
            for q in range(3):
                total += (scale * (t[U(p + q * n)] * du + t[U(p + (3 + q) * n)] * dv)) ** 2
    return total
