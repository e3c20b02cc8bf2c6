"""Winslow's functional with a regularised barrier, and its gradient: what `barrier` minimises on a patch."""

import math

from ..._numba import kernel
from ._descent_kernels import ENOUGH, FLAT, SHORTENINGS, find_way, remember

HUGE = 1e300


@kernel
def functional(r, along_i, along_j, sign, delta, gradient):
    """Sum over corners of cells of (|e_i|^2 + |e_j|^2) / h(J), its gradient, and the least J.

    Edges e are measured in units of ``along_i`` and ``along_j``, so that stretched cells may stay so. J is the area
    that a corner spans; h(J) = (J + sqrt(J^2 + 4 delta^2)) / 2 stays positive: V. A. Garanzha, Comput. Math. Math.
    Phys. 40 (2000); J. M. Escobar et al., Comput. Methods Appl. Mech. Engrg. 192 (2003), equation (8).
    """
    gradient[:] = 0.0
    total, least = 0.0, HUGE
    for i in range(r.shape[1] - 1):
        for j in range(r.shape[2] - 1):
            u, v = 1.0 / along_i[i], 1.0 / along_j[j]
            for corner in range(4):
                at_i, at_j = i + (corner & 1), j + (corner >> 1)
                if (at_i == 0 or at_i == r.shape[1] - 1) and (at_j == 0 or at_j == r.shape[2] - 1):
                    continue  # all of its points are fixed
                to_i, to_j = i + 1 - (corner & 1), j + 1 - (corner >> 1)
                ax, ay = u * (r[0, to_i, at_j] - r[0, at_i, at_j]), u * (r[1, to_i, at_j] - r[1, at_i, at_j])
                bx, by = v * (r[0, at_i, to_j] - r[0, at_i, at_j]), v * (r[1, at_i, to_j] - r[1, at_i, at_j])
                side = sign * (1 - 2 * (corner & 1)) * (1 - 2 * (corner >> 1))
                area = side * (ax * by - ay * bx)
                least = min(least, area)
                root = math.sqrt(area * area + 4 * delta * delta)
                barrier = 0.5 * (area + root) if area > 0 else 2 * delta * delta / (root - area)
                if not barrier > 0:
                    return HUGE, least
                size = ax * ax + ay * ay + bx * bx + by * by
                total += size / barrier
                slope = -side * size / (barrier * root)  # d(size / h) / dJ = -size h' / h^2, and h' = h / root
                dax, day = u * (2 * ax / barrier + slope * by), u * (2 * ay / barrier - slope * bx)
                dbx, dby = v * (2 * bx / barrier - slope * ay), v * (2 * by / barrier + slope * ax)
                gradient[0, to_i, at_j] += dax
                gradient[1, to_i, at_j] += day
                gradient[0, at_i, to_j] += dbx
                gradient[1, at_i, to_j] += dby
                gradient[0, at_i, at_j] -= dax + dbx
                gradient[1, at_i, at_j] -= day + dby
    return total, least


@kernel
def slope_inside(r, along_i, along_j, sign, delta, scale, gradient, slope):
    """`functional`, and its gradient by the points inside in units of ``scale``."""
    value, least = functional(r, along_i, along_j, sign, delta, gradient)
    k = 0
    for x in range(2):
        for i in range(1, r.shape[1] - 1):
            for j in range(1, r.shape[2] - 1):
                slope[k] = gradient[x, i, j] * scale[i - 1, j - 1]
                k += 1
    return value, least


@kernel
def move_inside(r, way, step, scale):
    """Move the points inside by ``step`` times ``way``, in units of ``scale``."""
    k = 0
    for x in range(2):
        for i in range(1, r.shape[1] - 1):
            for j in range(1, r.shape[2] - 1):
                r[x, i, j] += step * way[k] * scale[i - 1, j - 1]
                k += 1


@kernel
def minimise(r, along_i, along_j, sign, delta, scale, gradient, vectors, steps, changes, shares, most):
    """Limited-memory BFGS with back-tracking, on the points inside; returns the least J.

    ``vectors`` is room for slope, new slope and way, the rest for what `_descent_kernels` remembers.
    """
    slope, new_slope, way = vectors[0], vectors[1], vectors[2]
    value, least = slope_inside(r, along_i, along_j, sign, delta, scale, gradient, slope)
    known = 0
    for _ in range(most):
        descent = find_way(slope, steps, changes, known, shares, way)
        if not descent < 0:
            return least
        length, moved = 1.0, 0.0
        for _ in range(SHORTENINGS):
            move_inside(r, way, moved - length, scale)
            moved = length
            new_value, least = slope_inside(r, along_i, along_j, sign, delta, scale, gradient, new_slope)
            if new_value <= value + ENOUGH * length * descent:
                break
            length *= 0.5
        else:
            move_inside(r, way, moved, scale)
            return slope_inside(r, along_i, along_j, sign, delta, scale, gradient, slope)[1]
        known = remember(length, way, slope, new_slope, steps, changes, known)
        if value - new_value <= FLAT * value:
            return least
        value = new_value
    return least
