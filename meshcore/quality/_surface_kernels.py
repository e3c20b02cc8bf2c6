"""Corners of the quadrilaterals of a structured grid, in one pass over its points."""

import math

import numpy as np

from .._numba import kernel

U = np.uint64
# Products of eight lengths below this, or above its inverse, are left to the measures themselves.
TINY = 1e-280
# Sine of a corner's angle, seen along the cell's normal, up to which a corner may be flat but for rounding.
FLAT = 1e-12
# Places in what `summarise` finds.
SMALLEST_ANGLE, LARGEST_ANGLE, SUM_OF_RADIUS_RATIOS, WORST_JACOBIAN, SIDE, NORMAL_Z = range(6)
SUMMARY_SIZE = 6


@kernel
def _corner(ax, ay, az, bx, by, bz, nx, ny, nz):
    """Of the edges before and after a corner: square of their vector product, its part along n, scalar product."""
    x = ay * bz - az * by
    y = az * bx - ax * bz
    z = ax * by - ay * bx
    return x * x + y * y + z * z, x * nx + y * ny + z * nz, -(ax * bx + ay * by + az * bz)


@kernel
def summarise(points, found):
    """Reduce the measures min_angle, max_angle, radius_ratio and scaled_jacobian over all cells of (ni, nj, 3) points.

    Angles are ranked by their cotangents, so that only the two that win need an arc tangent. ``found[SIDE]`` is the
    least product of a cell's normal with the first's, not positive where cells look to different sides, and
    ``found[NORMAL_Z]`` the z of the first's. The answer is False, and nothing is found, if a corner is flat or turned
    over, or products under- or overflow.
    """
    steepest = -math.inf  # the largest cotangent belongs to the smallest angle; squares that keep their sign
    flattest = math.inf
    steepest_square, steepest_product, flattest_square, flattest_product = 0.0, 1.0, 0.0, 1.0
    total, lost = 0.0, 0.0
    worst2, side = math.inf, math.inf
    first_x, first_y, first_z = 0.0, 0.0, 0.0
    for i in range(points.shape[0] - 1):
        for j in range(points.shape[1] - 1):
            p = points[U(i), U(j)]
            q = points[U(i + 1), U(j)]
            r = points[U(i + 1), U(j + 1)]
            s = points[U(i), U(j + 1)]
            ax, ay, az = q[0] - p[0], q[1] - p[1], q[2] - p[2]
            bx, by, bz = r[0] - q[0], r[1] - q[1], r[2] - q[2]
            cx, cy, cz = s[0] - r[0], s[1] - r[1], s[2] - r[2]
            dx, dy, dz = p[0] - s[0], p[1] - s[1], p[2] - s[2]
            ux, uy, uz = r[0] - p[0], r[1] - p[1], r[2] - p[2]
            vx, vy, vz = s[0] - q[0], s[1] - q[1], s[2] - q[2]
            nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
            nn = nx * nx + ny * ny + nz * nz
            aa = ax * ax + ay * ay + az * az
            bb = bx * bx + by * by + bz * bz
            cc = cx * cx + cy * cy + cz * cz
            dd = dx * dx + dy * dy + dz * dz
            shortest, longest = min(aa, bb, cc, dd), max(aa, bb, cc, dd)
            if not (nn * shortest * shortest > TINY and nn * longest * longest < 1.0 / TINY):
                return False
            if i == 0 and j == 0:
                first_x, first_y, first_z = nx, ny, nz
            side = min(side, nx * first_x + ny * first_y + nz * first_z)
            least = math.inf
            for corner in range(4):
                if corner == 0:
                    square, area, product = _corner(dx, dy, dz, ax, ay, az, nx, ny, nz)
                    sides = dd * aa
                elif corner == 1:
                    square, area, product = _corner(ax, ay, az, bx, by, bz, nx, ny, nz)
                    sides = aa * bb
                elif corner == 2:
                    square, area, product = _corner(bx, by, bz, cx, cy, cz, nx, ny, nz)
                    sides = bb * cc
                else:
                    square, area, product = _corner(cx, cy, cz, dx, dy, dz, nx, ny, nz)
                    sides = cc * dd
                sine2 = area * area / (nn * sides)
                if not (area > 0.0 and sine2 > FLAT * FLAT):
                    return False
                worst2 = min(worst2, sine2)
                least = min(least, square)
                cotangent = product * abs(product) / square
                if cotangent > steepest:
                    steepest, steepest_square, steepest_product = cotangent, square, product
                if cotangent < flattest:
                    flattest, flattest_square, flattest_product = cotangent, square, product
            reach = max(longest, ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz)
            # A compensated sum (Kahan), as good as numpy's pairwise one.
            term = math.sqrt((aa + bb + cc + dd) * reach / (8.0 * least)) - lost
            longer = total + term
            lost = (longer - total) - term
            total = longer
    found[SMALLEST_ANGLE] = math.degrees(math.atan2(math.sqrt(steepest_square), steepest_product))
    found[LARGEST_ANGLE] = math.degrees(math.atan2(math.sqrt(flattest_square), flattest_product))
    found[SUM_OF_RADIUS_RATIOS] = total
    found[WORST_JACOBIAN] = math.sqrt(worst2)
    found[SIDE] = side
    found[NORMAL_Z] = first_z
    return True
