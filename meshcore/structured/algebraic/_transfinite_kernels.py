"""Transfinite interpolation of a block from its six faces, slab by slab (survey 2.4.1).

The Boolean sum of linear projections, P_u + P_v + P_w - P_u P_v - P_v P_w - P_w P_u + P_u P_v P_w (Gordon and Hall
1973). Rows run along k; a slab is a range of i, and slabs can be filled by different threads.
"""

import numpy as np

from ..._numba import kernel

NEWTON_STEPS = 20
CLOSE = 1e-14


@kernel
def _missing(face, west, east, low, high, u, v, m):
    """What a face across k has more than the faces across i and j give at the end m of a row."""
    return face - ((1.0 - u) * west[m] + u * east[m] + (1.0 - v) * low[m] + v * high[m])


@kernel
def fill_by_number(points, i_min, i_max, j_min, j_max, k_min, k_max, u, v, w, work, start, stop):
    """Fill points[start:stop] where the blending functions depend on the number of the layer alone.

    Points and faces have the coordinates of a row flat: points (ni, nj, 3 nk), faces (nj, 3 nk), (ni, 3 nk) and,
    across k, (ni, nj, 3). For one i the part that comes from the faces across j, less that of i, depends on k alone; it
    stands in ``work`` (2, 3 nk).
    """
    n_j, n_k = v.size, w.size
    low, high = work[0], work[1]
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
            n = 3 * (n_k - 1)
            a0 = _missing(k_min[i, j, 0], west, east, low, high, u1, v1, 0)
            a1 = _missing(k_min[i, j, 1], west, east, low, high, u1, v1, 1)
            a2 = _missing(k_min[i, j, 2], west, east, low, high, u1, v1, 2)
            b0 = _missing(k_max[i, j, 0], west, east, low, high, u1, v1, n) - a0
            b1 = _missing(k_max[i, j, 1], west, east, low, high, u1, v1, n + 1) - a1
            b2 = _missing(k_max[i, j, 2], west, east, low, high, u1, v1, n + 2) - a2
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
def fill_by_length(points, faces, rows, u_edges, v_edges, w_edges, work, start, stop):
    """Fill points[start:stop] where the blending functions come from the lengths of the twelve edges.

    Each of u, v, w is bilinear in the two others between the fractions of length on its four edges (Soni 1985), which
    stand in the order 00, 10, 01, 11 of the two others. Components have rows of their own here, so that a processor
    takes several points at once: the faces across i are (nj, 3, nk), those across j (ni, 3, nk), in ``rows``; those
    across k (ni, nj, 3), in ``faces``. ``work`` is (6, 3, nk). False if the parameters were not found.
    """
    i_min, i_max, j_min, j_max = rows
    k_min, k_max = faces
    n_j, n_k = v_edges.shape[1], w_edges.shape[1]
    last = n_k - 1
    u, v, w = work[0, 0], work[0, 1], work[0, 2]
    along, bend, low, rise, row = work[1], work[2], work[3], work[4], work[5]
    found = True
    for c in range(3):
        for k in range(n_k):
            along[c, k] = i_max[0, c, k] - i_min[0, c, k]
            bend[c, k] = i_max[n_j - 1, c, k] - i_min[n_j - 1, c, k] - along[c, k]
    for i in range(start, stop):
        # What the faces across j add to those across i: low + v rise - u (along + v bend).
        for c in range(3):
            for k in range(n_k):
                low[c, k] = j_min[i, c, k] - i_min[0, c, k]
                rise[c, k] = j_max[i, c, k] - i_min[n_j - 1, c, k] - low[c, k]
        for j in range(n_j):
            for k in range(n_k):
                w[k] = w_edges[0, k]
            found &= _row_parameters(u_edges, v_edges, w_edges, i, j, u, v, w)
            west, east = i_min[j], i_max[j]
            for c in range(3):
                # What those across k add is bilinear in u and v at both ends of the row: a there, and b more.
                a0 = k_min[i, j, c] - west[c, 0] - low[c, 0]
                b0 = k_max[i, j, c] - west[c, last] - low[c, last] - a0
                a1 = along[c, 0] - (east[c, 0] - west[c, 0])
                b1 = along[c, last] - (east[c, last] - west[c, last]) - a1
                a = (a0, a1, -rise[c, 0], bend[c, 0])
                b = (b0, b1, rise[c, 0] - rise[c, last], bend[c, last] - bend[c, 0])
                _fill_component(row[c], west[c], east[c], low[c], rise[c], along[c], bend[c], a, b, u, v, w)
            target = points[i, j]
            for k in range(n_k):
                target[k, 0], target[k, 1], target[k, 2] = row[0, k], row[1, k], row[2, k]
    return found


@kernel
def _fill_component(row, west, east, low, rise, along, bend, a, b, u, v, w):
    """One component of a row along k, see `fill_by_length`."""
    a0, a1, a2, a3 = a
    b0, b1, b2, b3 = b
    for k in range(row.size):
        x, y = u[k], v[k]
        xy = x * y
        sides = west[k] + x * (east[k] - west[k]) + low[k] + y * rise[k] - x * (along[k] + y * bend[k])
        ends = a0 + a1 * x + a2 * y + a3 * xy + w[k] * (b0 + b1 * x + b2 * y + b3 * xy)
        row[k] = sides + ends
