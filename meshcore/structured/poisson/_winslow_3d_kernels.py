"""The transformed Laplace and Poisson equations in space: their stencil, zebra lines over it, and what is measured.

The equations (survey 2.5.1) times J^2, in index units with central differences::

    A (r_aa + P r_a) + B (r_bb + Q r_b) + C (r_cc + R r_c) + 2 (D r_ab + E r_ac + F r_bc) = f

A to F are the cofactors of g_ij (J. F. Thompson, Z. U. A. Warsi, C. W. Mastin, "Numerical Grid Generation", 1985,
equation VI.22). Arrays are flat and hold three components of n = na nb nc numbers each, c fastest. The right side f
is zero on the finest grid. `control` holds P, Q, R likewise, or is empty; `kept`, n bytes or none, tells which nodes
are no unknowns: their equations are nothing, which makes their corrections zero.

Machine code works on several nodes at once: equations are set up for `NODES` neighbours along c, and `LINES` lines are
solved side by side. Either way a node has `FIELDS` numbers in rows of that length: A, B, C, the three components of the
defect, and the control along the line.
"""

from __future__ import annotations

import math

import numpy as np

from ..._numba import kernel

U = np.uint64
FIELDS = 7
LINES = 64
NODES = 2 * LINES
_STEP = FIELDS * LINES
_DEFECT = U(3 * LINES)
_LAST = U(6 * LINES)
# Keeps the quotient 0 / 0 of a spot where all points coincide at zero.
TINY = 1e-300


@kernel(inline=True)
def _difference(x, p, sa, sb, A, B, C, D, E, F):
    """The left side without control for the component that begins at p."""
    one = U(1)
    twice = x[p] + x[p]
    return (
        A * (x[p + sa] - twice + x[p - sa])
        + B * (x[p + sb] - twice + x[p - sb])
        + C * (x[p + one] - twice + x[p - one])
        + 0.5
        * (
            D * (x[p + sa + sb] - x[p + sa - sb] - x[p - sa + sb] + x[p - sa - sb])
            + E * (x[p + sa + one] - x[p + sa - one] - x[p - sa + one] + x[p - sa - one])
            + F * (x[p + sb + one] - x[p + sb - one] - x[p - sb + one] + x[p - sb - one])
        )
    )


@kernel(inline=True)
def _equation(x, f, p, n, sa, sb, row, t):
    """Coefficients and defect of the equations at node p, into column t of the rows."""
    one = U(1)
    q = p + n
    r = q + n
    ax = 0.5 * (x[p + sa] - x[p - sa])
    ay = 0.5 * (x[q + sa] - x[q - sa])
    az = 0.5 * (x[r + sa] - x[r - sa])
    bx = 0.5 * (x[p + sb] - x[p - sb])
    by = 0.5 * (x[q + sb] - x[q - sb])
    bz = 0.5 * (x[r + sb] - x[r - sb])
    cx = 0.5 * (x[p + one] - x[p - one])
    cy = 0.5 * (x[q + one] - x[q - one])
    cz = 0.5 * (x[r + one] - x[r - one])
    aa = ax * ax + ay * ay + az * az
    bb = bx * bx + by * by + bz * bz
    cc = cx * cx + cy * cy + cz * cz
    ab = ax * bx + ay * by + az * bz
    ac = ax * cx + ay * cy + az * cz
    bc = bx * cx + by * cy + bz * cz
    A = bb * cc - bc * bc
    B = aa * cc - ac * ac
    C = aa * bb - ab * ab
    D = ac * bc - ab * cc
    E = ab * bc - ac * bb
    F = ab * ac - bc * aa
    row[t] = A
    row[t + U(NODES)] = B
    row[t + U(2 * NODES)] = C
    row[t + U(3 * NODES)] = _difference(x, p, sa, sb, A, B, C, D, E, F) - f[p]
    row[t + U(4 * NODES)] = _difference(x, q, sa, sb, A, B, C, D, E, F) - f[q]
    row[t + U(5 * NODES)] = _difference(x, r, sa, sb, A, B, C, D, E, F) - f[r]
    row[t + U(6 * NODES)] = 0.0


@kernel
def equations(x, f, control, kept, at, m, n, sa, sb, axis, row):
    """The equations at m nodes in a row along c, from ``at`` on; ``axis`` is that of the line to be solved."""
    p, n, sa, sb = U(at), U(n), U(sa), U(sb)
    for t in range(m):
        _equation(x, f, p + U(t), n, sa, sb, row, U(t))
    if len(control):
        for direction in range(3):
            s = sa if direction == 0 else sb if direction == 1 else U(1)
            for t in range(m):
                rate = control[p + U(t) + U(direction) * n]
                factor = 0.5 * rate * row[U(direction * NODES + t)]
                for q in range(3):
                    node = p + U(t) + U(q) * n
                    row[U((3 + q) * NODES + t)] += factor * (x[node + s] - x[node - s])
                if direction == axis:
                    row[U(6 * NODES + t)] = rate
    if len(kept):
        for t in range(m):
            if kept[p + U(t)]:
                for field in range(FIELDS):
                    row[U(field * NODES + t)] = 0.0


@kernel
def eliminate(v, place, m, axis):
    """One step forward of the Thomas algorithm for m lines: node at ``place``, after the one before it."""
    o = U(place)
    before = U(place - _STEP)
    along = U(axis) * U(LINES)
    for t in range(m):
        k = o + U(t)
        j = before + U(t)
        strength = v[k + along]
        half = 0.5 * v[k + _LAST]
        low = strength * (1.0 - half)
        pivot = 1.0 / (2.0 * (v[k] + v[k + U(LINES)] + v[k + U(2 * LINES)]) + TINY - low * v[j + _LAST])
        v[k + _LAST] = strength * (1.0 + half) * pivot
        v[k + _DEFECT] = (v[k + _DEFECT] + low * v[j + _DEFECT]) * pivot
        v[k + U(4 * LINES)] = (v[k + U(4 * LINES)] + low * v[j + U(4 * LINES)]) * pivot
        v[k + U(5 * LINES)] = (v[k + U(5 * LINES)] + low * v[j + U(5 * LINES)]) * pivot


@kernel
def substitute(x, v, count, m, at, n, along, aside):
    """The way back of the Thomas algorithm: corrections of ``count`` nodes of m lines, added to x."""
    for l in range(count, 0, -1):
        o = U(l * _STEP)
        after = U((l + 1) * _STEP)
        for q in range(3):
            row = U(3 + q) * U(LINES)
            if l < count:
                for t in range(m):
                    v[o + row + U(t)] += v[o + _LAST + U(t)] * v[after + row + U(t)]
            node = U(at + l * along + q * n)
            for t in range(m):
                x[node + U(aside) * U(t)] += v[o + row + U(t)]


@kernel
def relax_across(x, f, control, kept, shape, axis, parity, first, stop, row, v):
    """Zebra lines along a (axis 0) or b (axis 1) in the slices ``1 + parity + 2 k`` of the other, k in first..stop.

    In c, c = 1, 3, ... come before 2, 4, ..., in strips of `NODES`, while their nodes are in the cache. Equations are
    set up at all nodes of a strip and every other is taken: neighbours in memory are dealt with much faster.
    """
    n = shape[0] * shape[1] * shape[2]
    sa = shape[1] * shape[2]
    sb = shape[2]
    along = sa if axis == 0 else sb
    across = sb if axis == 0 else sa
    count = shape[axis] - 2
    v[:_STEP] = 0.0
    for k in range(first, stop):
        for start in range(1, shape[2] - 1, NODES):
            for c in range(start, min(start + 2, shape[2] - 1)):
                m = min(LINES, (shape[2] - c) // 2)
                at = (1 + parity + 2 * k) * across + c
                for l in range(1, count + 1):
                    equations(x, f, control, kept, at + l * along, 2 * m - 1, n, sa, sb, axis, row)
                    for field in range(FIELDS):
                        o = U(l * _STEP + field * LINES)
                        for t in range(m):
                            v[o + U(t)] = row[U(field * NODES) + U(2) * U(t)]
                    eliminate(v, l * _STEP, m, axis)
                substitute(x, v, count, m, at, n, along, 2)


@kernel
def relax_along(x, f, control, kept, shape, parity, first, stop, row, v):
    """Zebra lines along c in the slices ``a = 1 + parity + 2 k``, k in first..stop, alternate in b."""
    n = shape[0] * shape[1] * shape[2]
    sa = shape[1] * shape[2]
    sb = shape[2]
    count = shape[2] - 2
    v[:_STEP] = 0.0
    for k in range(first, stop):
        for start in range(1, shape[1] - 1, 2 * LINES):
            for b in range(start, min(start + 2, shape[1] - 1)):
                m = min(LINES, (shape[1] - b) // 2)
                at = (1 + parity + 2 * k) * sa + b * sb
                for t in range(m):
                    for c in range(1, shape[2] - 1, NODES):
                        length = min(NODES, shape[2] - 1 - c)
                        equations(x, f, control, kept, at + 2 * t * sb + c, length, n, sa, sb, 2, row)
                        for s in range(length):
                            for field in range(FIELDS):
                                v[U((c + s) * _STEP + field * LINES + t)] = row[U(field * NODES + s)]
                for l in range(1, count + 1):
                    eliminate(v, l * _STEP, m, 2)
                substitute(x, v, count, m, at, n, 1, 2 * sb)


@kernel
def defect(x, f, control, kept, shape, first, stop, row, r, squares):
    """``r = f - N(x)`` in the slices a of first..stop, if r is not empty, and what point relaxation would move there.

    ``squares[a]`` gets the sum of the squared lengths by which Jacobi's step moves the nodes of slice a.
    """
    n = shape[0] * shape[1] * shape[2]
    sa = shape[1] * shape[2]
    sb = shape[2]
    for a in range(first, stop):
        total = 0.0
        for b in range(1, shape[1] - 1):
            for c in range(1, shape[2] - 1, NODES):
                m = min(NODES, shape[2] - 1 - c)
                at = a * sa + b * sb + c
                equations(x, f, control, kept, at, m, n, sa, sb, -1, row)
                for t in range(m):
                    o = U(t)
                    dx = row[o + U(3 * NODES)]
                    dy = row[o + U(4 * NODES)]
                    dz = row[o + U(5 * NODES)]
                    scale = 1.0 / (2.0 * (row[o] + row[o + U(NODES)] + row[o + U(2 * NODES)]) + TINY)
                    total += (dx * dx + dy * dy + dz * dz) * scale * scale
                if len(r):
                    for q in range(3):
                        for t in range(m):
                            r[U(at + q * n + t)] = -row[U((3 + q) * NODES + t)]
        squares[a] = total


@kernel
def couplings(x, f, control, kept, shape, first, stop, row, shares):
    """``shares[a, d]``: sum over slice a of the part that direction d has in A + B + C."""
    n = shape[0] * shape[1] * shape[2]
    sa = shape[1] * shape[2]
    sb = shape[2]
    for a in range(first, stop):
        for b in range(1, shape[1] - 1):
            for c in range(1, shape[2] - 1, NODES):
                m = min(NODES, shape[2] - 1 - c)
                equations(x, f, control, kept, a * sa + b * sb + c, m, n, sa, sb, -1, row)
                for t in range(m):
                    whole = row[U(t)] + row[U(NODES + t)] + row[U(2 * NODES + t)] + TINY
                    for d in range(3):
                        shares[a, d] += row[U(d * NODES + t)] / whole


@kernel(inline=True)
def _triple(x, n, o, a, b, c):
    """Determinant of the edges from o to a, b, c."""
    ax = x[a] - x[o]
    ay = x[a + n] - x[o + n]
    az = x[a + U(2) * n] - x[o + U(2) * n]
    bx = x[b] - x[o]
    by = x[b + n] - x[o + n]
    bz = x[b + U(2) * n] - x[o + U(2) * n]
    cx = x[c] - x[o]
    cy = x[c + n] - x[o + n]
    cz = x[c + U(2) * n] - x[o + U(2) * n]
    return ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)


@kernel
def count_folded(x, shape, sign, first, stop, folded):
    """``folded[a]``: cells of layer a, in first..stop, with a corner whose Jacobian times ``sign`` is not positive."""
    n = U(shape[0] * shape[1] * shape[2])
    sa = U(shape[1] * shape[2])
    sb = U(shape[2])
    for a in range(first, stop):
        bad = 0
        for b in range(shape[1] - 1):
            for c in range(shape[2] - 1):
                p = U(a) * sa + U(b) * sb + U(c)
                q = p + U(1)
                least = sign * _triple(x, n, p, p + sa, p + sb, q)
                least = min(least, sign * _triple(x, n, p + sa, p + sa + sb, p, q + sa))
                least = min(least, sign * _triple(x, n, p + sb, p, p + sa + sb, q + sb))
                least = min(least, sign * _triple(x, n, p + sa + sb, p + sb, p + sa, q + sa + sb))
                least = min(least, sign * _triple(x, n, q, q + sb, q + sa, p))
                least = min(least, sign * _triple(x, n, q + sa, q, q + sa + sb, p + sa))
                least = min(least, sign * _triple(x, n, q + sb, q + sa + sb, q, p + sb))
                least = min(least, sign * _triple(x, n, q + sa + sb, q + sa, q + sb, p + sa + sb))
                bad += 0 if least > 0.0 else 1
        folded[a] = bad


@kernel
def largest_move(x, before, shape, first, stop, moves):
    """``moves[a]``: the largest move of a node of slice a since ``before``, per its smallest distance to neighbours."""
    n = shape[0] * shape[1] * shape[2]
    sa = shape[1] * shape[2]
    sb = shape[2]
    for a in range(first, stop):
        most = 0.0
        for b in range(1, shape[1] - 1):
            for c in range(1, shape[2] - 1):
                p = a * sa + b * sb + c
                aa = bb = cc = moved = 0.0
                for q in range(3):
                    node = U(p + q * n)
                    aa += 0.25 * (x[node + U(sa)] - x[node - U(sa)]) ** 2
                    bb += 0.25 * (x[node + U(sb)] - x[node - U(sb)]) ** 2
                    cc += 0.25 * (x[node + U(1)] - x[node - U(1)]) ** 2
                    moved += (x[node] - before[node]) ** 2
                most = max(most, moved / (min(aa, bb, cc) + TINY))
        moves[a] = math.sqrt(most)
