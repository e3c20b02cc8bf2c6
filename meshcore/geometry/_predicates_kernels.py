"""Kernels of the exact predicates: orient2d, orient3d, incircle, insphere (Shewchuk 1997).

Each predicate is the sign of a determinant of differences of coordinates, found in three stages:

A. the determinant in doubles, right if it exceeds a static bound times its permanent;
B. the same in double-double arithmetic, right if it exceeds a far smaller bound, or if nothing was rounded;
C. the same in expansions, sums of doubles that do not overlap: exact.

Stage A is written out in each predicate. B and C are one routine each for all four determinants, which expands by
columns over all sets of rows: rare, small, and compiled once. Coordinates must be safe as `predicates.rescaled`
leaves them, or products may under- or overflow; then the answer may be wrong, but memory stays untouched.

References
----------
J. R. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric predicates", Discrete &
Computational Geometry 18 (1997).
M. Joldes, J.-M. Muller, V. Popescu, "Tight and rigorous error bounds for basic building blocks of double-word
arithmetic", ACM Trans. Math. Softw. 44 (2017).
"""

import math

import numpy as np

from .._numba import kernel
from ._machine_kernels import fma, sign_of_incircle, sign_of_insphere, sign_of_orient3d

EPSILON = 2.0**-53
# Stage A: |rounding error| <= bound * permanent, both as computed (Shewchuk, section 4.2 to 4.4, table 1 ff.:
# ccwerrboundA, o3derrboundA, iccerrboundA, isperrboundA).
ORIENT2D_BOUND = (3 + 16 * EPSILON) * EPSILON
ORIENT3D_BOUND = (7 + 56 * EPSILON) * EPSILON
INCIRCLE_BOUND = (10 + 96 * EPSILON) * EPSILON
INSPHERE_BOUND = (16 + 224 * EPSILON) * EPSILON
# Stage B: a product errs by at most 5 u^2, a sum by at most 3 u^2 + O(u^3) of its result, u = 2^-53 (Joldes et al.,
# algorithms 6 and 10). The longest path, insphere's, has a lift (one product, two sums), a 3 x 3 minor (two products,
# three sums), their product and three more sums: 4 * 5 + 8 * 3 = 44 units of u^2 of the permanent, and the permanent
# itself is computed to a few u. 256 u^2 = 2^-98 leaves a factor above five.
DOUBLE_DOUBLE_BOUND = 2.0**-98

# Places in the work array. First the permanents up to which the plain determinants of doubles are exact, since all
# coordinates are multiples of one quantum (`predicates.workspace`); zero if there is none. A permanent of zero is
# always exact: all products are zero then.
EXACT_ORIENT2D, EXACT_INCIRCLE, EXACT_ORIENT3D, EXACT_INSPHERE = 0, 1, 2, 3
# Entries of the matrix are (high, low), 4 columns a row; minors (high, low, permanent).
# The longest expansions: a difference has 2 terms, a 2 x 2 minor 2 * (2 * 2 * 2) = 16, a 3 x 3 minor
# 3 * (2 * 2 * 16) = 192, a lift 3 * (2 * 2 * 2) = 24, the whole 4 * (2 * 24 * 192) = 36864. These hold whatever the
# numbers are, even if they are not finite.
_ENTRIES = 4
_MINORS = _ENTRIES + 2 * 16
_ENTRY_LENGTHS = _MINORS + 3 * 16
_MINOR_LENGTHS = _ENTRY_LENGTHS + 16
_ENTRY_SIZE = 24
_ENTRY_EXPANSIONS = _MINOR_LENGTHS + 16
_MINOR_SIZE = 192
_MINOR_EXPANSIONS = _ENTRY_EXPANSIONS + 16 * _ENTRY_SIZE
_SCALED = _MINOR_EXPANSIONS + 16 * _MINOR_SIZE
_SUM_SIZE = 36864
_SUMS = _SCALED + 2 * _MINOR_SIZE
WORK_SIZE = _SUMS + 2 * _SUM_SIZE

_MEMBERS = np.array([bin(mask).count("1") for mask in range(16)])


# ---- exact operations on doubles


@kernel
def two_sum(a, b):
    """Sum and its rounding error (Shewchuk, theorem 7, due to Knuth)."""
    total = a + b
    b_part = total - a
    return total, (a - (total - b_part)) + (b - b_part)


@kernel
def fast_two_sum(a, b):
    """Sum and its rounding error for ``|a| >= |b|`` or a = 0 (theorem 6, due to Dekker)."""
    total = a + b
    return total, b - (total - a)


@kernel
def two_product(a, b):
    """Product and its rounding error, which is a double."""
    product = a * b
    return product, fma(a, b, -product)


# ---- stage B: double-double numbers


@kernel
def _add(a, a_low, b, b_low):
    """Sum of two double-doubles and whether it was rounded (Joldes et al., algorithm 6: AccurateDWPlusDW)."""
    high, error = two_sum(a, b)
    low, low_error = two_sum(a_low, b_low)
    error, lost = two_sum(error, low)
    high, error = fast_two_sum(high, error)
    error, lost_too = two_sum(error, low_error)
    high, error = fast_two_sum(high, error)
    return high, error, lost != 0.0 or lost_too != 0.0


@kernel
def _multiply(a, a_low, b, b_low):
    """Product of two double-doubles and whether it may be rounded (algorithm 10: DWTimesDW1)."""
    high, error = two_product(a, b)
    rounded = (a_low != 0.0 or b_low != 0.0) and a != 0.0 and b != 0.0
    high, error = fast_two_sum(high, error + (a * b_low + a_low * b))
    return high, error, rounded


@kernel
def _lift_in_double_double(work, row, dimension, rounded):
    """Write the sum of the squares of a row after its last coordinate; return whether anything was rounded."""
    lift = 0.0
    lift_low = 0.0
    for column in range(dimension):
        at = _ENTRIES + 2 * (4 * row + column)
        square, square_low, rounded_1 = _multiply(work[at], work[at + 1], work[at], work[at + 1])
        lift, lift_low, rounded_2 = _add(lift, lift_low, square, square_low)
        rounded = rounded or rounded_1 or rounded_2
    at = _ENTRIES + 2 * (4 * row + dimension)
    work[at] = lift
    work[at + 1] = lift_low
    return rounded


@kernel
def _minor_in_double_double(work, rows, size):
    """Expand the minor of a set of rows (bits) by its last column; write it, return whether it was rounded."""
    column = _MEMBERS[rows] - 1
    high = 0.0
    low = 0.0
    permanent = 0.0
    rounded = False
    negative = column % 2 == 1
    for row in range(size):
        if rows >> row & 1:
            at = _ENTRIES + 2 * (4 * row + column)
            rest = _MINORS + 3 * (rows ^ (1 << row))
            product, product_low, rounded_1 = _multiply(work[at], work[at + 1], work[rest], work[rest + 1])
            if negative:
                product = -product
                product_low = -product_low
            high, low, rounded_2 = _add(high, low, product, product_low)
            permanent += abs(work[at]) * work[rest + 2]
            rounded = rounded or rounded_1 or rounded_2
            negative = not negative
    at = _MINORS + 3 * rows
    work[at] = high
    work[at + 1] = low
    work[at + 2] = permanent
    return rounded


# ---- stage C: expansions, at a place in the work array, of increasing magnitude, without zeros; zero is empty.
# All are strongly non-overlapping, which sums and scalings keep under round-to-even (Shewchuk, theorems 13 and 19).


@kernel
def _expansion_sum(work, e, e_length, f, f_length, h):
    """Write the sum of expansions e and f to h; return its length (FAST-EXPANSION-SUM, theorem 13)."""
    i = 0
    j = 0
    length = 0
    total = 0.0
    while i < e_length or j < f_length:
        if j == f_length or (i < e_length and abs(work[e + i]) < abs(work[f + j])):
            term = work[e + i]
            i += 1
        else:
            term = work[f + j]
            j += 1
        total, error = two_sum(total, term)
        # The first sum has no error, unless the numbers are not finite: then it must not lengthen the expansion.
        if error != 0.0 and i + j > 1:
            work[h + length] = error
            length += 1
    if total != 0.0:
        work[h + length] = total
        length += 1
    return length


@kernel
def _scaled_expansion(work, e, e_length, factor, h):
    """Write expansion e times a double to h; return its length (SCALE-EXPANSION, theorem 19)."""
    length = 0
    total = 0.0
    for i in range(e_length):
        product, product_low = two_product(work[e + i], factor)
        low, error = two_sum(total, product_low)
        if error != 0.0 and i > 0:
            work[h + length] = error
            length += 1
        total, error = fast_two_sum(product, low)
        if error != 0.0:
            work[h + length] = error
            length += 1
    if total != 0.0:
        work[h + length] = total
        length += 1
    return length


@kernel
def _add_product(work, at, length, e, e_length, f, f_length, negative):
    """Add e times f, or take it away, to the sum at ``at``; return place and length of the new sum."""
    for j in range(f_length):
        factor = -work[f + j] if negative else work[f + j]
        scaled_length = _scaled_expansion(work, e, e_length, factor, _SCALED)
        other = 2 * _SUMS + _SUM_SIZE - at  # the two places for sums take turns
        length = _expansion_sum(work, at, length, _SCALED, scaled_length, other)
        at = other
    return at, length


@kernel
def _copy(work, at, length, to):
    for i in range(length):
        work[to + i] = work[at + i]


@kernel
def _entry_expansions(work, size, dimension):
    """Write the matrix as expansions; lifts are computed anew."""
    for row in range(size):
        for column in range(dimension):
            at = _ENTRIES + 2 * (4 * row + column)
            to = _ENTRY_EXPANSIONS + _ENTRY_SIZE * (4 * row + column)
            length = 0
            for term in (work[at + 1], work[at]):
                if term != 0.0:
                    work[to + length] = term
                    length += 1
            work[_ENTRY_LENGTHS + 4 * row + column] = length
        if size > dimension:
            at = _SUMS
            length = 0
            for column in range(dimension):
                e = _ENTRY_EXPANSIONS + _ENTRY_SIZE * (4 * row + column)
                e_length = int(work[_ENTRY_LENGTHS + 4 * row + column])
                at, length = _add_product(work, at, length, e, e_length, e, e_length, False)
            to = _ENTRY_EXPANSIONS + _ENTRY_SIZE * (4 * row + dimension)
            _copy(work, at, length, to)
            work[_ENTRY_LENGTHS + 4 * row + dimension] = length


@kernel
def _minor_expansion(work, rows, size):
    """Expand the minor of a set of rows (bits) by its last column; return place and length."""
    column = _MEMBERS[rows] - 1
    negative = column % 2 == 1
    at = _SUMS
    length = 0
    for row in range(size):
        if rows >> row & 1:
            rest = rows ^ (1 << row)
            minor = _MINOR_EXPANSIONS + _MINOR_SIZE * rest
            entry = _ENTRY_EXPANSIONS + _ENTRY_SIZE * (4 * row + column)
            minor_length = int(work[_MINOR_LENGTHS + rest])
            entry_length = int(work[_ENTRY_LENGTHS + 4 * row + column])
            at, length = _add_product(work, at, length, minor, minor_length, entry, entry_length, negative)
            negative = not negative
    return at, length


@kernel
def _exact_determinant(work, size, dimension):
    """Most significant term of the determinant, by stage C."""
    _entry_expansions(work, size, dimension)
    for row in range(size):  # minors of one row: entries of the first column
        work[_MINOR_LENGTHS + (1 << row)] = work[_ENTRY_LENGTHS + 4 * row]
        to = _MINOR_EXPANSIONS + _MINOR_SIZE * (1 << row)
        _copy(work, _ENTRY_EXPANSIONS + _ENTRY_SIZE * 4 * row, int(work[_ENTRY_LENGTHS + 4 * row]), to)
    at = _SUMS
    length = 0
    for rows in range(3, 1 << size):
        if _MEMBERS[rows] > 1:
            at, length = _minor_expansion(work, rows, size)
            if rows < (1 << size) - 1:
                _copy(work, at, length, _MINOR_EXPANSIONS + _MINOR_SIZE * rows)
                work[_MINOR_LENGTHS + rows] = length
    return work[at + length - 1] if length > 0 else 0.0


# ---- the determinants


@kernel
def _on_a_box(work, size, dimension):
    """Whether the points take at most two values along each axis: corners of a box are exactly cospherical.

    Then all entries of column c are zero or one value v_c, the lift is the sum of v_c times column c, and the
    determinant is zero, however the coordinates were rounded.
    """
    for column in range(dimension):
        value = 0.0
        value_low = 0.0
        for row in range(size):
            at = _ENTRIES + 2 * (4 * row + column)
            if work[at] != 0.0:
                if value != 0.0 and (work[at] != value or work[at + 1] != value_low):
                    return False
                value = work[at]
                value_low = work[at + 1]
    return True


@kernel
def _determinant_sign(work, size, dimension):
    """A number with the sign of the determinant of the ``size`` rows of differences in the work array.

    With ``size > dimension`` the last column is the lift, the sum of squares of the others.
    """
    rounded = False
    if size > dimension:
        if _on_a_box(work, size, dimension):
            return 0.0
        for row in range(size):
            rounded = _lift_in_double_double(work, row, dimension, rounded)
    work[_MINORS] = 1.0
    work[_MINORS + 1] = 0.0
    work[_MINORS + 2] = 1.0
    for rows in range(1, 1 << size):
        rounded = _minor_in_double_double(work, rows, size) or rounded
    at = _MINORS + 3 * ((1 << size) - 1)
    if not rounded or abs(work[at]) > DOUBLE_DOUBLE_BOUND * work[at + 2]:
        return work[at]
    return _exact_determinant(work, size, dimension)


@kernel
def _set_entry(work, row, column, a, b):
    """Write the exact difference ``a - b``."""
    high, low = two_sum(a, -b)
    work[_ENTRIES + 2 * (4 * row + column)] = high
    work[_ENTRIES + 2 * (4 * row + column) + 1] = low


# ---- the range and the grid of coordinates


@kernel
def magnitudes(numbers, found):
    """Write the smallest and the largest magnitude but zero (infinity and 0 without any); return if all are finite."""
    smallest = np.inf
    largest = 0.0
    finite = True
    for x in numbers:
        magnitude = abs(x)
        finite = finite and magnitude < np.inf  # false for NaN, too
        largest = max(largest, magnitude)
        smallest = min(smallest, magnitude if magnitude > 0.0 else np.inf)
    found[0] = smallest
    found[1] = largest
    return finite


@kernel
def quantum(numbers, largest, smallest):
    """The largest power of two, not above ``largest``, that divides all numbers; 0 if it is below ``smallest``.

    Both limits are powers of two.
    """
    inverse = 1.0 / largest
    for x in numbers:
        while x * inverse != np.floor(x * inverse):
            inverse *= 2.0
            if inverse * smallest > 1.0:
                return 0.0
    return 1.0 / inverse


# ---- stage B written out, in pairs: a double and what it lacks, which need not be normalised
#
# A number X is a pair x, x' with |x'| <= c u P and |x + x' - X| <= d u^2 P, P the permanent: X with all signs positive.
# By the operations below, up to terms of higher order (c_1 <= c_2 in a sum),
#
#     difference of doubles   c = 1                       d = 0
#     sum                     c = c_2 + 1                 d = max(d_1, d_2) + 2 c_2 + 1
#     product                 c = c_1 + c_2 + 1           d = d_1 + d_2 + c_1 c_2 + c_1 + 2 c_2 + 2
#
# which for orient3d, as it is written here, gives d = 56, for incircle 96 and for insphere 258. Half of the bound's
# 512 is left for the rounding of the permanent.
PAIR_BOUND = 2.0**-97


@kernel
def _difference(a, b):
    """``a - b``, exactly."""
    return two_sum(a, -b)


@kernel
def _sum(x, y):
    """``x + y``."""
    high, error = two_sum(x[0], y[0])
    return high, error + (x[1] + y[1])


@kernel
def _product(x, y):
    """``x y``."""
    high = x[0] * y[0]
    return high, fma(x[0], y[1], fma(x[1], y[0], fma(x[0], y[0], -high)))


@kernel
def _minus(x):
    """``-x``."""
    return -x[0], -x[1]


@kernel
def _cross(a, b, c, d):
    """``a b - c d``."""
    return _sum(_product(a, b), _minus(_product(c, d)))


@kernel
def _dot(x, y, z, a, b, c):
    """``a x + b y + c z``."""
    return _sum(_sum(_product(x, a), _product(y, b)), _product(z, c))


@kernel
def _orient3d_of_pairs(ax, ay, az, bx, by, bz, cx, cy, cz):
    """The determinant of three differences."""
    bc = _cross(bx, cy, by, cx)
    ca = _cross(cx, ay, cy, ax)
    ab = _cross(ax, by, ay, bx)
    determinant = _dot(az, bz, cz, bc, ca, ab)
    return determinant[0] + determinant[1]


@kernel
def _incircle_of_pairs(ax, ay, bx, by, cx, cy):
    """The determinant of three differences and their squares."""
    a_lift = _sum(_product(ax, ax), _product(ay, ay))
    b_lift = _sum(_product(bx, bx), _product(by, by))
    c_lift = _sum(_product(cx, cx), _product(cy, cy))
    bc = _cross(bx, cy, by, cx)
    ca = _cross(cx, ay, cy, ax)
    ab = _cross(ax, by, ay, bx)
    determinant = _dot(a_lift, b_lift, c_lift, bc, ca, ab)
    return determinant[0] + determinant[1]


@kernel
def _insphere_of_pairs(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz):
    """The determinant of four differences and their squares."""
    aw, bw = _dot(ax, ay, az, ax, ay, az), _dot(bx, by, bz, bx, by, bz)
    cw, dw = _dot(cx, cy, cz, cx, cy, cz), _dot(dx, dy, dz, dx, dy, dz)
    # Minors of the columns x and y, z and lift.
    ab, abw = _cross(ax, by, ay, bx), _cross(az, bw, bz, aw)
    bc, bcw = _cross(bx, cy, by, cx), _cross(bz, cw, cz, bw)
    ca, caw = _cross(cx, ay, cy, ax), _cross(cz, aw, az, cw)
    # 3 x 3 minors, which are the cofactors of d.
    x = _dot(ay, by, cy, bcw, caw, abw)
    y = _dot(ax, bx, cx, bcw, caw, abw)
    z = _dot(aw, bw, cw, bc, ca, ab)
    w = _dot(az, bz, cz, bc, ca, ab)
    determinant = _sum(_dot(_minus(dx), dy, _minus(dz), x, y, z), _product(dw, w))
    return determinant[0] + determinant[1]


# ---- the sign of a determinant of differences that are integers, but for a power of two: exact
#
# On grids and on lines up to rounding most determinants that stage B cannot tell are zero, or products of rounding
# errors. Differences that are multiples of one power of two become integers up to 2^60 and a low part; then integers of
# five words are several times faster than expansions.

_INTEGER_BITS = 60


@kernel
def _as_integer(x, scale):
    """A difference as an integer, and 0 if it is one, else 1."""
    high, low = x[0] * scale, x[1] * scale
    return np.int64(high) + np.int64(low), 0 if high == np.floor(high) and low == np.floor(low) else 1


@kernel
def _integer_scale(largest):
    """The power of two that brings the largest difference below 2^60."""
    _, exponent = math.frexp(largest)
    return math.ldexp(1.0, _INTEGER_BITS - exponent)


@kernel
def _largest(x, y, z):
    """The largest magnitude."""
    return max(abs(x[0]), abs(y[0]), abs(z[0]))


@kernel
def _orient3d_of_integers(ax, ay, az, bx, by, bz, cx, cy, cz):
    """The sign of the determinant of three differences; NaN if they are no integers."""
    scale = _integer_scale(max(_largest(ax, ay, az), _largest(bx, by, bz), _largest(cx, cy, cz)))
    ax, rest_1 = _as_integer(ax, scale)
    ay, rest_2 = _as_integer(ay, scale)
    az, rest_3 = _as_integer(az, scale)
    bx, rest_4 = _as_integer(bx, scale)
    by, rest_5 = _as_integer(by, scale)
    bz, rest_6 = _as_integer(bz, scale)
    cx, rest_7 = _as_integer(cx, scale)
    cy, rest_8 = _as_integer(cy, scale)
    cz, rest_9 = _as_integer(cz, scale)
    if rest_1 + rest_2 + rest_3 + rest_4 + rest_5 + rest_6 + rest_7 + rest_8 + rest_9 > 0:
        return math.nan
    return np.float64(sign_of_orient3d(ax, ay, az, bx, by, bz, cx, cy, cz))


@kernel
def _have_one_value(x, y, z):
    """Whether those of three differences that are not zero are equal."""
    value = x if x[0] != 0.0 else (y if y[0] != 0.0 else z)
    return (y[0] == 0.0 or (y[0] == value[0] and y[1] == value[1])) and (
        z[0] == 0.0 or (z[0] == value[0] and z[1] == value[1])
    )


@kernel
def _incircle_of_integers(ax, ay, bx, by, cx, cy):
    """The same for a determinant with squares, in the plane."""
    scale = _integer_scale(max(_largest(ax, ay, bx), _largest(by, cx, cy)))
    ax, rest_1 = _as_integer(ax, scale)
    ay, rest_2 = _as_integer(ay, scale)
    bx, rest_3 = _as_integer(bx, scale)
    by, rest_4 = _as_integer(by, scale)
    cx, rest_5 = _as_integer(cx, scale)
    cy, rest_6 = _as_integer(cy, scale)
    if rest_1 + rest_2 + rest_3 + rest_4 + rest_5 + rest_6 > 0:
        return math.nan
    return np.float64(sign_of_incircle(ax, ay, bx, by, cx, cy))


@kernel
def _insphere_of_integers(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz, largest):
    """The same for a determinant with squares."""
    scale = _integer_scale(largest)
    ax, rest_1 = _as_integer(ax, scale)
    ay, rest_2 = _as_integer(ay, scale)
    az, rest_3 = _as_integer(az, scale)
    bx, rest_4 = _as_integer(bx, scale)
    by, rest_5 = _as_integer(by, scale)
    bz, rest_6 = _as_integer(bz, scale)
    cx, rest_7 = _as_integer(cx, scale)
    cy, rest_8 = _as_integer(cy, scale)
    cz, rest_9 = _as_integer(cz, scale)
    dx, rest_10 = _as_integer(dx, scale)
    dy, rest_11 = _as_integer(dy, scale)
    dz, rest_12 = _as_integer(dz, scale)
    if rest_1 + rest_2 + rest_3 + rest_4 + rest_5 + rest_6 > 0:
        return math.nan
    if rest_7 + rest_8 + rest_9 + rest_10 + rest_11 + rest_12 > 0:
        return math.nan
    return np.float64(sign_of_insphere(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz))


# ---- the predicates


@kernel
def orient2d_exact(ax, ay, bx, by, cx, cy, work):
    """`orient2d` where stage A fails: by the quantum, by one exact subtraction, or by stages B and C."""
    acx, acy, bcx, bcy = ax - cx, ay - cy, bx - cx, by - cy
    left = acx * bcy
    right = acy * bcx
    if abs(left) + abs(right) <= work[EXACT_ORIENT2D]:
        return left - right
    if two_sum(ax, -cx)[1] == two_sum(ay, -cy)[1] == two_sum(bx, -cx)[1] == two_sum(by, -cy)[1] == 0.0:
        # The differences are exact. Rounding is monotonic, so different products of doubles are in their true order.
        left, left_low = two_product(acx, bcy)
        right, right_low = two_product(acy, bcx)
        return left - right if left != right else left_low - right_low
    _set_entry(work, 0, 0, ax, cx)
    _set_entry(work, 0, 1, ay, cy)
    _set_entry(work, 1, 0, bx, cx)
    _set_entry(work, 1, 1, by, cy)
    return _determinant_sign(work, 2, 2)


@kernel
def orient2d(ax, ay, bx, by, cx, cy, work):
    """Positive if a, b, c are counter-clockwise, negative if clockwise, zero if collinear."""
    left = (ax - cx) * (by - cy)
    right = (ay - cy) * (bx - cx)
    determinant = left - right
    if abs(determinant) > ORIENT2D_BOUND * (abs(left) + abs(right)):
        return determinant
    return orient2d_exact(ax, ay, bx, by, cx, cy, work)


@kernel
def incircle_exact(ax, ay, bx, by, cx, cy, dx, dy, work):
    """`incircle` where stage A fails: by the quantum, by stage B in pairs, in integers, or by stages B and C."""
    adx, ady = ax - dx, ay - dy
    bdx, bdy = bx - dx, by - dy
    cdx, cdy = cx - dx, cy - dy
    bc, cb = bdx * cdy, cdx * bdy
    ca, ac = cdx * ady, adx * cdy
    ab, ba = adx * bdy, bdx * ady
    a_lift = adx * adx + ady * ady
    b_lift = bdx * bdx + bdy * bdy
    c_lift = cdx * cdx + cdy * cdy
    permanent = (abs(bc) + abs(cb)) * a_lift + (abs(ca) + abs(ac)) * b_lift + (abs(ab) + abs(ba)) * c_lift
    if permanent <= work[EXACT_INCIRCLE]:
        return a_lift * (bc - cb) + b_lift * (ca - ac) + c_lift * (ab - ba)
    rows = (
        _difference(ax, dx), _difference(ay, dy), _difference(bx, dx), _difference(by, dy),
        _difference(cx, dx), _difference(cy, dy),
    )  # fmt: skip
    determinant = _incircle_of_pairs(*rows)
    if abs(determinant) > PAIR_BOUND * permanent:
        return determinant
    if _have_one_value(rows[0], rows[2], rows[4]) and _have_one_value(rows[1], rows[3], rows[5]):
        return 0.0  # corners of a rectangle, see `_on_a_box`
    determinant = _incircle_of_integers(*rows)
    if not math.isnan(determinant):
        return determinant
    _set_entry(work, 0, 0, ax, dx)
    _set_entry(work, 0, 1, ay, dy)
    _set_entry(work, 1, 0, bx, dx)
    _set_entry(work, 1, 1, by, dy)
    _set_entry(work, 2, 0, cx, dx)
    _set_entry(work, 2, 1, cy, dy)
    return _determinant_sign(work, 3, 2)


@kernel
def incircle(ax, ay, bx, by, cx, cy, dx, dy, work):
    """Positive if d is inside the circle of counter-clockwise a, b, c, negative if outside, zero if on it."""
    adx, ady = ax - dx, ay - dy
    bdx, bdy = bx - dx, by - dy
    cdx, cdy = cx - dx, cy - dy
    bc, cb = bdx * cdy, cdx * bdy
    ca, ac = cdx * ady, adx * cdy
    ab, ba = adx * bdy, bdx * ady
    a_lift = adx * adx + ady * ady
    b_lift = bdx * bdx + bdy * bdy
    c_lift = cdx * cdx + cdy * cdy
    determinant = a_lift * (bc - cb) + b_lift * (ca - ac) + c_lift * (ab - ba)
    permanent = (abs(bc) + abs(cb)) * a_lift + (abs(ca) + abs(ac)) * b_lift + (abs(ab) + abs(ba)) * c_lift
    if abs(determinant) > INCIRCLE_BOUND * permanent:
        return determinant
    return incircle_exact(ax, ay, bx, by, cx, cy, dx, dy, work)


@kernel
def orient3d_exact(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz, work):
    """`orient3d` where stage A fails: by the quantum, by stage B in pairs, in integers, or by stages B and C."""
    adx, ady, adz = ax - dx, ay - dy, az - dz
    bdx, bdy, bdz = bx - dx, by - dy, bz - dz
    cdx, cdy, cdz = cx - dx, cy - dy, cz - dz
    bc, cb = bdx * cdy, cdx * bdy
    ca, ac = cdx * ady, adx * cdy
    ab, ba = adx * bdy, bdx * ady
    permanent = (abs(bc) + abs(cb)) * abs(adz) + (abs(ca) + abs(ac)) * abs(bdz) + (abs(ab) + abs(ba)) * abs(cdz)
    if permanent <= work[EXACT_ORIENT3D]:
        return -(adz * (bc - cb) + bdz * (ca - ac) + cdz * (ab - ba))
    rows = (
        _difference(ax, dx), _difference(ay, dy), _difference(az, dz),
        _difference(bx, dx), _difference(by, dy), _difference(bz, dz),
        _difference(cx, dx), _difference(cy, dy), _difference(cz, dz),
    )  # fmt: skip
    determinant = _orient3d_of_pairs(*rows)
    if abs(determinant) > PAIR_BOUND * permanent:
        return -determinant
    determinant = _orient3d_of_integers(*rows)
    if not math.isnan(determinant):
        return -determinant
    _set_entry(work, 0, 0, ax, dx)
    _set_entry(work, 0, 1, ay, dy)
    _set_entry(work, 0, 2, az, dz)
    _set_entry(work, 1, 0, bx, dx)
    _set_entry(work, 1, 1, by, dy)
    _set_entry(work, 1, 2, bz, dz)
    _set_entry(work, 2, 0, cx, dx)
    _set_entry(work, 2, 1, cy, dy)
    _set_entry(work, 2, 2, cz, dz)
    return -_determinant_sign(work, 3, 3)


@kernel
def orient3d(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz, work):
    """Positive if a, b, c, d is a tetrahedron in VTK's order, negative if inverted, zero if coplanar.

    d is then on the side to which the right-hand normal of a, b, c points: the opposite of Shewchuk's sign.
    """
    adx, ady, adz = ax - dx, ay - dy, az - dz
    bdx, bdy, bdz = bx - dx, by - dy, bz - dz
    cdx, cdy, cdz = cx - dx, cy - dy, cz - dz
    bc, cb = bdx * cdy, cdx * bdy
    ca, ac = cdx * ady, adx * cdy
    ab, ba = adx * bdy, bdx * ady
    determinant = adz * (bc - cb) + bdz * (ca - ac) + cdz * (ab - ba)
    permanent = (abs(bc) + abs(cb)) * abs(adz) + (abs(ca) + abs(ac)) * abs(bdz) + (abs(ab) + abs(ba)) * abs(cdz)
    if abs(determinant) > ORIENT3D_BOUND * permanent:
        return -determinant
    return orient3d_exact(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz, work)


@kernel
def insphere_exact(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz, ex, ey, ez, work):
    """`insphere` where stage A fails: by stage B in pairs, in integers, or by stages B and C."""
    rows = (
        _difference(ax, ex), _difference(ay, ey), _difference(az, ez),
        _difference(bx, ex), _difference(by, ey), _difference(bz, ez),
        _difference(cx, ex), _difference(cy, ey), _difference(cz, ez),
        _difference(dx, ex), _difference(dy, ey), _difference(dz, ez),
    )  # fmt: skip
    largest = max(_largest(rows[0], rows[1], rows[2]), _largest(rows[3], rows[4], rows[5]))
    largest = max(largest, _largest(rows[6], rows[7], rows[8]), _largest(rows[9], rows[10], rows[11]))
    determinant = _insphere_of_pairs(*rows)
    # The permanent has 24 terms with three squares each.
    if abs(determinant) > PAIR_BOUND * 72.0 * (largest * largest) * (largest * largest) * largest:
        return -determinant
    determinant = _insphere_of_integers(*rows, largest)
    if not math.isnan(determinant):
        return -determinant
    _set_entry(work, 0, 0, ax, ex)
    _set_entry(work, 0, 1, ay, ey)
    _set_entry(work, 0, 2, az, ez)
    _set_entry(work, 1, 0, bx, ex)
    _set_entry(work, 1, 1, by, ey)
    _set_entry(work, 1, 2, bz, ez)
    _set_entry(work, 2, 0, cx, ex)
    _set_entry(work, 2, 1, cy, ey)
    _set_entry(work, 2, 2, cz, ez)
    _set_entry(work, 3, 0, dx, ex)
    _set_entry(work, 3, 1, dy, ey)
    _set_entry(work, 3, 2, dz, ez)
    return -_determinant_sign(work, 4, 3)


@kernel
def insphere(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz, ex, ey, ez, work):
    """Positive if e is inside the sphere of the positive tetrahedron a, b, c, d, negative if outside, zero if on it."""
    aex, aey, aez = ax - ex, ay - ey, az - ez
    bex, bey, bez = bx - ex, by - ey, bz - ez
    cex, cey, cez = cx - ex, cy - ey, cz - ez
    dex, dey, dez = dx - ex, dy - ey, dz - ez
    ab_1, ab_2 = aex * bey, bex * aey
    bc_1, bc_2 = bex * cey, cex * bey
    cd_1, cd_2 = cex * dey, dex * cey
    da_1, da_2 = dex * aey, aex * dey
    ac_1, ac_2 = aex * cey, cex * aey
    bd_1, bd_2 = bex * dey, dex * bey
    ab, bc, cd, da, ac, bd = ab_1 - ab_2, bc_1 - bc_2, cd_1 - cd_2, da_1 - da_2, ac_1 - ac_2, bd_1 - bd_2
    abc = aez * bc - bez * ac + cez * ab
    bcd = bez * cd - cez * bd + dez * bc
    cda = cez * da + dez * ac + aez * cd
    dab = dez * ab + aez * bd + bez * da
    a_lift = aex * aex + aey * aey + aez * aez
    b_lift = bex * bex + bey * bey + bez * bez
    c_lift = cex * cex + cey * cey + cez * cez
    d_lift = dex * dex + dey * dey + dez * dez
    determinant = (d_lift * abc - c_lift * dab) + (b_lift * cda - a_lift * bcd)
    # The same with every sign positive.
    ab, bc, cd = abs(ab_1) + abs(ab_2), abs(bc_1) + abs(bc_2), abs(cd_1) + abs(cd_2)
    da, ac, bd = abs(da_1) + abs(da_2), abs(ac_1) + abs(ac_2), abs(bd_1) + abs(bd_2)
    aez, bez, cez, dez = abs(aez), abs(bez), abs(cez), abs(dez)
    permanent = (
        (cd * bez + bd * cez + bc * dez) * a_lift
        + (da * cez + ac * dez + cd * aez) * b_lift
        + (ab * dez + bd * aez + da * bez) * c_lift
        + (bc * aez + ac * bez + ab * cez) * d_lift
    )
    if abs(determinant) > INSPHERE_BOUND * permanent:
        return -determinant
    return insphere_exact(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz, ex, ey, ez, work)


# ---- over arrays: one row of coordinates a test


@kernel
def orient2d_signs(rows, signs, work):
    """Write the sign of `orient2d` of each row of 6 coordinates."""
    for i in range(len(rows)):
        p = rows[i]
        signs[i] = np.sign(orient2d(p[0], p[1], p[2], p[3], p[4], p[5], work))


@kernel
def incircle_signs(rows, signs, work):
    """Write the sign of `incircle` of each row of 8 coordinates."""
    for i in range(len(rows)):
        p = rows[i]
        signs[i] = np.sign(incircle(p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], work))


@kernel
def orient3d_signs(rows, signs, work):
    """Write the sign of `orient3d` of each row of 12 coordinates."""
    for i in range(len(rows)):
        p = rows[i]
        signs[i] = np.sign(orient3d(p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11], work))


@kernel
def insphere_signs(rows, signs, work):
    """Write the sign of `insphere` of each row of 15 coordinates."""
    for i in range(len(rows)):
        p = rows[i]
        signs[i] = np.sign(
            insphere(
                p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11], p[12], p[13], p[14], work
            )
        )
