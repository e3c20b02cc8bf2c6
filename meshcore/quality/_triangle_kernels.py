"""Kernels of triangles: a summary of their shapes in one pass, and the signs of their areas by the first filter."""

import math

import numpy as np

from .._numba import kernel

U = np.uint64
# Rounding unit, and the bound of the first stage of orient2d (Shewchuk 1997, ccwerrboundA).
_UNIT = 2.0**-53
_BOUND = (3 + 16 * _UNIT) * _UNIT
# Answer of `area_signs` where the filter does not decide.
UNSURE = 2
# Squares below this, or above its inverse, are left to the measures themselves.
TINY = 1e-280
# Places in what `summarise` finds.
SMALLEST_ANGLE, LARGEST_ANGLE, SUM_OF_RADIUS_RATIOS, WORST_JACOBIAN = range(4)
SUMMARY_SIZE = 4


@kernel
def summarise(points, cells, found):
    """Reduce the measures min_angle, max_angle, radius_ratio and scaled_jacobian over all triangles in one pass.

    Angles are ranked by their cotangents, so that only the two that win need an arc tangent. The answer is False, and
    nothing is found, if a triangle has no area or products under- or overflow.
    """
    steepest = -math.inf  # the largest cotangent belongs to the smallest angle
    flattest = math.inf
    steepest_area = 0.0
    steepest_product = 1.0
    flattest_area = 0.0
    flattest_product = 1.0
    total = 0.0
    lost = 0.0
    worst2 = math.inf
    for t in range(len(cells)):
        a = cells[U(t), U(0)]
        b = cells[U(t), U(1)]
        c = cells[U(t), U(2)]
        ax = points[U(a), U(0)]
        ay = points[U(a), U(1)]
        az = points[U(a), U(2)]
        ux = points[U(b), U(0)] - ax
        uy = points[U(b), U(1)] - ay
        uz = points[U(b), U(2)] - az
        vx = points[U(c), U(0)] - ax
        vy = points[U(c), U(1)] - ay
        vz = points[U(c), U(2)] - az
        wx = vx - ux
        wy = vy - uy
        wz = vz - uz
        nx = uy * vz - uz * vy
        ny = uz * vx - ux * vz
        nz = ux * vy - uy * vx
        area2 = nx * nx + ny * ny + nz * nz  # the square of twice the area
        area = math.sqrt(area2)
        at_a = ux * vx + uy * vy + uz * vz
        at_b = -(ux * wx + uy * wy + uz * wz)
        at_c = vx * wx + vy * wy + vz * wz
        uu = ux * ux + uy * uy + uz * uz
        vv = vx * vx + vy * vy + vz * vz
        ww = wx * wx + wy * wy + wz * wz
        high = max(at_a, at_b, at_c)
        low = min(at_a, at_b, at_c)
        product2 = uu * vv * ww / min(uu, vv, ww)
        if not (area2 > TINY and TINY < product2 < 1.0 / TINY):
            return False
        inverse = 1.0 / area
        cotangent = high * inverse
        if cotangent > steepest:
            steepest = cotangent
            steepest_area = area
            steepest_product = high
        cotangent = low * inverse
        if cotangent < flattest:
            flattest = cotangent
            flattest_area = area
            flattest_product = low
        u = math.sqrt(uu)
        v = math.sqrt(vv)
        w = math.sqrt(ww)
        # A compensated sum (Kahan), as good as numpy's pairwise one.
        term = (u * v * w) * (u + v + w) * (inverse * inverse) - lost
        longer = total + term
        lost = (longer - total) - term
        total = longer
        worst2 = min(worst2, area2 / product2)
    found[SMALLEST_ANGLE] = math.degrees(math.atan2(steepest_area, steepest_product))
    found[LARGEST_ANGLE] = math.degrees(math.atan2(flattest_area, flattest_product))
    found[SUM_OF_RADIUS_RATIOS] = 0.25 * total
    found[WORST_JACOBIAN] = 2.0 / math.sqrt(3.0) * math.sqrt(worst2)
    return True


@kernel
def area_signs(plane, cells, signs):
    """Write 1, -1 or `UNSURE` for each triangle; return how many are unsure.

    The filter is stage A of J. R. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric
    predicates", Discrete Comput. Geom. 18 (1997).
    """
    unsure = 0
    for t in range(len(cells)):
        a = cells[U(t), U(0)]
        b = cells[U(t), U(1)]
        c = cells[U(t), U(2)]
        cx = plane[U(c), U(0)]
        cy = plane[U(c), U(1)]
        left = (plane[U(a), U(0)] - cx) * (plane[U(b), U(1)] - cy)
        right = (plane[U(a), U(1)] - cy) * (plane[U(b), U(0)] - cx)
        value = left - right
        bound = _BOUND * (abs(left) + abs(right))
        if value > bound:
            signs[U(t)] = 1
        elif -value > bound:
            signs[U(t)] = -1
        else:
            signs[U(t)] = UNSURE
            unsure += 1
    return unsure


@kernel
def count_below(points, cells, cotangent):
    """How many triangles have an angle whose cotangent is above this one."""
    count = 0
    for t in range(len(cells)):
        a = cells[U(t), U(0)]
        b = cells[U(t), U(1)]
        c = cells[U(t), U(2)]
        ux = points[U(b), U(0)] - points[U(a), U(0)]
        uy = points[U(b), U(1)] - points[U(a), U(1)]
        uz = points[U(b), U(2)] - points[U(a), U(2)]
        vx = points[U(c), U(0)] - points[U(a), U(0)]
        vy = points[U(c), U(1)] - points[U(a), U(1)]
        vz = points[U(c), U(2)] - points[U(a), U(2)]
        nx = uy * vz - uz * vy
        ny = uz * vx - ux * vz
        nz = ux * vy - uy * vx
        uv = ux * vx + uy * vy + uz * vz
        at_b = ux * ux + uy * uy + uz * uz - uv
        at_c = vx * vx + vy * vy + vz * vz - uv
        if max(uv, at_b, at_c) > cotangent * math.sqrt(nx * nx + ny * ny + nz * nz):
            count += 1
    return count
