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
def _row_parameters(u_edges, v_edges, w_edges, i, j, u, v, w):
    """Blending values along k at (i, j); False if Newton's method does not converge.

    At a given w, u and v are linear in each other and known at once. What remains is one equation for w, solved
    for the whole row at once; w comes as a first guess.
    """
    n_k = w.size
    u00, u01 = u_edges[0, i], u_edges[2, i] - u_edges[0, i]
    u10, u11 = u_edges[1, i] - u00, u_edges[3, i] - u_edges[2, i] - (u_edges[1, i] - u00)
    v00, v01 = v_edges[0, j], v_edges[2, j] - v_edges[0, j]
    v10, v11 = v_edges[1, j] - v00, v_edges[3, j] - v_edges[2, j] - (v_edges[1, j] - v00)
    for _ in range(NEWTON_STEPS):
        far = 0
        for k in range(n_k):
            t = w[k]
            # u = a + b v and v = c + d u, with their derivatives along w
            a, b = u00 + u01 * t, u10 + u11 * t
            c, d = v00 + v01 * t, v10 + v11 * t
            scale = 1.0 / (1.0 - b * d)
            shrink = (u11 * d + b * v11) * scale
            x, y = (a + b * c) * scale, (c + a * d) * scale
            dx = (u01 + u11 * c + b * v01) * scale + x * shrink
            dy = (v01 + u01 * d + a * v11) * scale + y * shrink
            p, q = w_edges[1, k] - w_edges[0, k], w_edges[2, k] - w_edges[0, k]
            r = w_edges[3, k] - w_edges[2, k] - p
            step = w_edges[0, k] + p * x + q * y + r * x * y - t
            step = step / (1.0 - (p + r * y) * dx - (q + r * x) * dy)
            u[k], v[k], w[k] = x + dx * step, y + dy * step, t + step
            far += not abs(step) < CLOSE
        if far == 0:
            return True
    return False


@kernel
def fill_by_length(points, faces, rows, u_edges, v_edges, w_edges, start, stop):
    """Fill points[start:stop] where the blending functions come from the lengths of the twelve edges.

    Each of u, v, w is bilinear in the two others between the fractions of length on its four edges (Soni 1985), which
    stand in the order 00, 10, 01, 11 of the two others. Components have rows of their own here, so that a processor
    takes several points at once: the faces across i are (nj, 3, nk), those across j (ni, 3, nk), in ``rows``; those
    across k (ni, nj, 3), in ``faces``. False if the parameters were not found.
    """
    i_min, i_max, j_min, j_max = rows
    k_min, k_max = faces
    n_j, n_k = v_edges.shape[1], w_edges.shape[1]
    last = n_k - 1
    u, v, w = np.empty(n_k), np.empty(n_k), np.empty(n_k)
    along, bend = i_max[0] - i_min[0], i_max[n_j - 1] - i_min[n_j - 1] - (i_max[0] - i_min[0])
    alpha, beta, row = np.empty(4), np.empty(4), np.empty((3, n_k))
    found = True
    for i in range(start, stop):
        # What the faces across j add to those across i: low + v rise - u (along + v bend).
        low = j_min[i] - i_min[0]
        rise = j_max[i] - i_min[n_j - 1] - low
        for j in range(n_j):
            w[:] = w_edges[0]
            found &= _row_parameters(u_edges, v_edges, w_edges, i, j, u, v, w)
            west, east = i_min[j], i_max[j]
            for c in range(3):
                # What those across k add is bilinear in u and v at both ends of the row: alpha there, and beta more.
                for k, face, terms in ((0, k_min, alpha), (last, k_max, beta)):
                    terms[0] = face[i, j, c] - west[c, k] - low[c, k]
                    terms[1] = along[c, k] - (east[c, k] - west[c, k])
                    terms[2] = -rise[c, k]
                    terms[3] = bend[c, k]
                for n in range(4):
                    beta[n] -= alpha[n]
                _fill_component(row[c], west[c], east[c], low[c], rise[c], along[c], bend[c], alpha, beta, u, v, w)
            target = points[i, j]
            for k in range(n_k):
                target[k, 0], target[k, 1], target[k, 2] = row[0, k], row[1, k], row[2, k]
    return found


@kernel
def _fill_component(row, west, east, low, rise, along, bend, alpha, beta, u, v, w):
    """One component of a row along k, see `fill_by_length`."""
    a0, a1, a2, a3 = alpha[0], alpha[1], alpha[2], alpha[3]
    b0, b1, b2, b3 = beta[0], beta[1], beta[2], beta[3]
    for k in range(row.size):
        x, y = u[k], v[k]
        xy = x * y
        sides = west[k] + x * (east[k] - west[k]) + low[k] + y * rise[k] - x * (along[k] + y * bend[k])
        ends = a0 + a1 * x + a2 * y + a3 * xy + w[k] * (b0 + b1 * x + b2 * y + b3 * xy)
        row[k] = sides + ends
