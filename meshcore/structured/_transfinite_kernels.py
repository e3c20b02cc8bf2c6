"""Transfinite interpolation of a block from its six faces, slab by slab (survey 2.4.1).

The Boolean sum of linear projections, P_u + P_v + P_w - P_u P_v - P_v P_w - P_w P_u + P_u P_v P_w (Gordon and Hall
1973). Rows run along k; a slab is a range of i, and slabs can be filled by different threads.
"""

import numpy as np

from .._numba import kernel

NEWTON_STEPS = 20
CLOSE = 1e-14


@kernel
def fill_by_number(points, i_min, i_max, j_min, j_max, k_min, k_max, u, v, w, start, stop):
    """Fill points[start:stop] where the blending functions depend on the number of the layer alone.

    Points and faces have the coordinates of a row flat: points (ni, nj, 3 nk), faces (nj, 3 nk), (ni, 3 nk) and,
    across k, (ni, nj, 3). For one i the part that comes from the faces across j, less that of i, depends on k alone.
    """
    n_j, n_k = v.size, w.size
    low, high = np.empty(3 * n_k), np.empty(3 * n_k)
    at_start, slope = np.empty(3), np.empty(3)
    for i in range(start, stop):
        u1 = u[i]
        u0 = 1.0 - u1
        for m in range(3 * n_k):
            low[m] = j_min[i, m] - (u0 * i_min[0, m] + u1 * i_max[0, m])
            high[m] = j_max[i, m] - (u0 * i_min[n_j - 1, m] + u1 * i_max[n_j - 1, m])
        for j in range(n_j):
            v1 = v[j]
            v0 = 1.0 - v1
            row, west, east = points[i, j], i_min[j], i_max[j]
            for c in range(3):
                m = 3 * (n_k - 1) + c
                first = k_min[i, j, c] - (u0 * west[c] + u1 * east[c] + v0 * low[c] + v1 * high[c])
                last = k_max[i, j, c] - (u0 * west[m] + u1 * east[m] + v0 * low[m] + v1 * high[m])
                at_start[c] = first
                slope[c] = last - first
            a0, a1, a2 = at_start[0], at_start[1], at_start[2]
            b0, b1, b2 = slope[0], slope[1], slope[2]
            for k in range(n_k):
                m = np.uint64(3 * k)
                m1, m2 = m + np.uint64(1), m + np.uint64(2)
                t = w[k]
                row[m] = u0 * west[m] + u1 * east[m] + v0 * low[m] + v1 * high[m] + (a0 + b0 * t)
                row[m1] = u0 * west[m1] + u1 * east[m1] + v0 * low[m1] + v1 * high[m1] + (a1 + b1 * t)
                row[m2] = u0 * west[m2] + u1 * east[m2] + v0 * low[m2] + v1 * high[m2] + (a2 + b2 * t)


@kernel
def _bilinear(f, n, a, b):
    """The value at (a, b) of four edges' fractions at station n, in the order 00, 10, 01, 11, and its derivatives."""
    low = f[0, n] + a * (f[1, n] - f[0, n])
    high = f[2, n] + a * (f[3, n] - f[2, n])
    along_a = (1.0 - b) * (f[1, n] - f[0, n]) + b * (f[3, n] - f[2, n])
    return low + b * (high - low), along_a, high - low


@kernel
def fill_by_length(points, i_min, i_max, j_min, j_max, k_min, k_max, u_edges, v_edges, w_edges, start, stop):
    """Fill points[start:stop] where the blending functions come from the lengths of the twelve edges.

    Each of u, v, w is bilinear in the two others between the fractions of length on its four edges (Soni 1985),
    which three equations give by Newton's method, from their values at the point before.
    """
    n_j, n_k = v_edges.shape[1], w_edges.shape[1]
    converged = True
    for i in range(start, stop):
        for j in range(n_j):
            u = 0.25 * (u_edges[0, i] + u_edges[1, i] + u_edges[2, i] + u_edges[3, i])
            v = 0.25 * (v_edges[0, j] + v_edges[1, j] + v_edges[2, j] + v_edges[3, j])
            w = 0.0
            for k in range(n_k):
                for turn in range(NEWTON_STEPS):
                    fu, uv, uw = _bilinear(u_edges, i, v, w)
                    fv, vu, vw = _bilinear(v_edges, j, u, w)
                    fw, wu, wv = _bilinear(w_edges, k, u, v)
                    du, dv, dw = fu - u, fv - v, fw - w
                    if abs(du) + abs(dv) + abs(dw) < CLOSE:
                        break
                    # (1 -uv -uw; -vu 1 -vw; -wu -wv 1) x = d, by Cramer's rule
                    c00, c01, c02 = 1.0 - vw * wv, uv + uw * wv, uv * vw + uw
                    c10, c11, c12 = vu + vw * wu, 1.0 - uw * wu, vw + uw * vu
                    c20, c21, c22 = wu + wv * vu, wv + wu * uv, 1.0 - uv * vu
                    det = c00 - uv * c10 - uw * c20
                    u += (c00 * du + c01 * dv + c02 * dw) / det
                    v += (c10 * du + c11 * dv + c12 * dw) / det
                    w += (c20 * du + c21 * dv + c22 * dw) / det
                    if turn == NEWTON_STEPS - 1:
                        converged = False
                u0, v0, w0 = 1.0 - u, 1.0 - v, 1.0 - w
                for c in range(3):
                    faces = (
                        u0 * i_min[j, k, c]
                        + u * i_max[j, k, c]
                        + v0 * j_min[i, k, c]
                        + v * j_max[i, k, c]
                        + w0 * k_min[i, j, c]
                        + w * k_max[i, j, c]
                    )
                    edges = (
                        u0 * (v0 * i_min[0, k, c] + v * i_min[n_j - 1, k, c])
                        + u * (v0 * i_max[0, k, c] + v * i_max[n_j - 1, k, c])
                        + v0 * (w0 * j_min[i, 0, c] + w * j_min[i, n_k - 1, c])
                        + v * (w0 * j_max[i, 0, c] + w * j_max[i, n_k - 1, c])
                        + w0 * (u0 * i_min[j, 0, c] + u * i_max[j, 0, c])
                        + w * (u0 * i_min[j, n_k - 1, c] + u * i_max[j, n_k - 1, c])
                    )
                    corners = u0 * (
                        v0 * (w0 * i_min[0, 0, c] + w * i_min[0, n_k - 1, c])
                        + v * (w0 * i_min[n_j - 1, 0, c] + w * i_min[n_j - 1, n_k - 1, c])
                    ) + u * (
                        v0 * (w0 * i_max[0, 0, c] + w * i_max[0, n_k - 1, c])
                        + v * (w0 * i_max[n_j - 1, 0, c] + w * i_max[n_j - 1, n_k - 1, c])
                    )
                    points[i, j, k, c] = faces - edges + corners
    return converged
