"""Block tridiagonal systems of 2 x 2 blocks, cyclic ones too, by elimination without pivoting."""

from ..._numba import kernel


@kernel
def solve(lower, diagonal, upper, right, closed, fill_in):
    """Solve a block tridiagonal system of 2 x 2 blocks, cyclic if ``closed``; the answer replaces ``right`` (n, 2).

    ``lower`` and ``upper`` are (n, 4), ``diagonal`` (n, 4). The cyclic system is condensed to its last unknown, whose
    columns ride along in ``fill_in`` (n, 4).
    """
    n = diagonal.shape[0]
    m = n - 1 if closed else n
    for k in range(m):
        if closed:
            f0, f1, f2, f3 = 0.0, 0.0, 0.0, 0.0
            if k == 0:
                f0, f1, f2, f3 = lower[0, 0], lower[0, 1], lower[0, 2], lower[0, 3]
            if k == m - 1:
                f0, f1, f2, f3 = f0 + upper[k, 0], f1 + upper[k, 1], f2 + upper[k, 2], f3 + upper[k, 3]
        d0, d1, d2, d3 = diagonal[k, 0], diagonal[k, 1], diagonal[k, 2], diagonal[k, 3]
        x, y = right[k, 0], right[k, 1]
        if k > 0:
            l0, l1, l2, l3 = lower[k, 0], lower[k, 1], lower[k, 2], lower[k, 3]
            u0, u1, u2, u3 = upper[k - 1, 0], upper[k - 1, 1], upper[k - 1, 2], upper[k - 1, 3]
            d0 -= l0 * u0 + l1 * u2
            d1 -= l0 * u1 + l1 * u3
            d2 -= l2 * u0 + l3 * u2
            d3 -= l2 * u1 + l3 * u3
            x -= l0 * right[k - 1, 0] + l1 * right[k - 1, 1]
            y -= l2 * right[k - 1, 0] + l3 * right[k - 1, 1]
            if closed:
                e0, e1, e2, e3 = fill_in[k - 1, 0], fill_in[k - 1, 1], fill_in[k - 1, 2], fill_in[k - 1, 3]
                f0 -= l0 * e0 + l1 * e2
                f1 -= l0 * e1 + l1 * e3
                f2 -= l2 * e0 + l3 * e2
                f3 -= l2 * e1 + l3 * e3
        scale = 1.0 / (d0 * d3 - d1 * d2)
        i0, i1, i2, i3 = d3 * scale, -d1 * scale, -d2 * scale, d0 * scale
        right[k, 0], right[k, 1] = i0 * x + i1 * y, i2 * x + i3 * y
        if k < m - 1:
            u0, u1, u2, u3 = upper[k, 0], upper[k, 1], upper[k, 2], upper[k, 3]
            upper[k, 0], upper[k, 1] = i0 * u0 + i1 * u2, i0 * u1 + i1 * u3
            upper[k, 2], upper[k, 3] = i2 * u0 + i3 * u2, i2 * u1 + i3 * u3
        if closed:
            fill_in[k, 0], fill_in[k, 1] = i0 * f0 + i1 * f2, i0 * f1 + i1 * f3
            fill_in[k, 2], fill_in[k, 3] = i2 * f0 + i3 * f2, i2 * f1 + i3 * f3
    for k in range(m - 2, -1, -1):
        u0, u1, u2, u3 = upper[k, 0], upper[k, 1], upper[k, 2], upper[k, 3]
        x, y = right[k + 1, 0], right[k + 1, 1]
        right[k, 0] -= u0 * x + u1 * y
        right[k, 1] -= u2 * x + u3 * y
        if closed:
            e0, e1, e2, e3 = fill_in[k + 1, 0], fill_in[k + 1, 1], fill_in[k + 1, 2], fill_in[k + 1, 3]
            fill_in[k, 0] -= u0 * e0 + u1 * e2
            fill_in[k, 1] -= u0 * e1 + u1 * e3
            fill_in[k, 2] -= u2 * e0 + u3 * e2
            fill_in[k, 3] -= u2 * e1 + u3 * e3
    if closed:
        d0, d1, d2, d3 = diagonal[m, 0], diagonal[m, 1], diagonal[m, 2], diagonal[m, 3]
        x, y = right[m, 0], right[m, 1]
        for side in range(2):
            k = m - 1 if side == 0 else 0
            l0, l1, l2, l3 = lower[m, 0], lower[m, 1], lower[m, 2], lower[m, 3]
            if side == 1:
                l0, l1, l2, l3 = upper[m, 0], upper[m, 1], upper[m, 2], upper[m, 3]
            e0, e1, e2, e3 = fill_in[k, 0], fill_in[k, 1], fill_in[k, 2], fill_in[k, 3]
            d0 -= l0 * e0 + l1 * e2
            d1 -= l0 * e1 + l1 * e3
            d2 -= l2 * e0 + l3 * e2
            d3 -= l2 * e1 + l3 * e3
            x -= l0 * right[k, 0] + l1 * right[k, 1]
            y -= l2 * right[k, 0] + l3 * right[k, 1]
        scale = 1.0 / (d0 * d3 - d1 * d2)
        x, y = (d3 * x - d1 * y) * scale, (d0 * y - d2 * x) * scale
        right[m, 0], right[m, 1] = x, y
        for k in range(m):
            right[k, 0] -= fill_in[k, 0] * x + fill_in[k, 1] * y
            right[k, 1] -= fill_in[k, 2] * x + fill_in[k, 3] * y
