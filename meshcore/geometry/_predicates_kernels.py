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
SPLITTER = 2.0**27 + 1

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
    """Product and its rounding error (theorems 17 and 18, due to Veltkamp and Dekker)."""
    product = a * b
    c = SPLITTER * a
    a_high = c - (c - a)
    a_low = a - a_high
    c = SPLITTER * b
    b_high = c - (c - b)
    b_low = b - b_high
    return product, a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low)


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


# ---- stage B without the tails of differences: points near each other have exact differences (Sterbenz)


@kernel
def _sum(a, a_low, b, b_low):
    """Sum of two double-doubles to 3 u^2 (|a| + |b|): two roundings of at most u (u |a| + u |b|) in the low parts."""
    high, error = two_sum(a, b)
    return fast_two_sum(high, error + (a_low + b_low))


@kernel
def _times(a, a_low, b):
    """Product of a double-double and a double to 3 u^2 (Joldes et al., algorithm 7)."""
    high, error = two_product(a, b)
    return fast_two_sum(high, error + a_low * b)


@kernel
def _product(a, a_low, b, b_low):
    """Product of two double-doubles to 7 u^2 (Joldes et al., algorithm 10)."""
    high, error = two_product(a, b)
    return fast_two_sum(high, error + (a * b_low + a_low * b))


@kernel
def _cross(a, b, c, d):
    """``a b - c d`` to 3 u^2."""
    one, one_low = two_product(a, b)
    other, other_low = two_product(c, d)
    return _sum(one, one_low, -other, -other_low)


@kernel
def _square(x, y, z):
    """``x^2 + y^2 + z^2`` to 6 u^2."""
    one, one_low = two_product(x, x)
    other, other_low = two_product(y, y)
    one, one_low = _sum(one, one_low, other, other_low)
    other, other_low = two_product(z, z)
    return _sum(one, one_low, other, other_low)


@kernel
def _dot(x, y, z, a, a_low, b, b_low, c, c_low):
    """``a x + b y + c z`` for double-doubles a, b, c."""
    one, one_low = _times(a, a_low, x)
    other, other_low = _times(b, b_low, y)
    one, one_low = _sum(one, one_low, other, other_low)
    other, other_low = _times(c, c_low, z)
    return _sum(one, one_low, other, other_low)


@kernel
def _orient3d_of_edges(ax, ay, az, bx, by, bz, cx, cy, cz):
    """The determinant of three exact differences, to about 12 u^2 of its permanent."""
    bc, bc_low = _cross(bx, cy, by, cx)
    ca, ca_low = _cross(cx, ay, cy, ax)
    ab, ab_low = _cross(ax, by, ay, bx)
    determinant, _ = _dot(az, bz, cz, bc, bc_low, ca, ca_low, ab, ab_low)
    return determinant


@kernel
def _insphere_of_edges(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz):
    """The determinant of four exact differences and their squares, to about 40 u^2 of its permanent."""
    aw, aw_low = _square(ax, ay, az)
    bw, bw_low = _square(bx, by, bz)
    cw, cw_low = _square(cx, cy, cz)
    dw, dw_low = _square(dx, dy, dz)
    ab, ab_low = _cross(ax, by, ay, bx)
    bc, bc_low = _cross(bx, cy, by, cx)
    ca, ca_low = _cross(cx, ay, cy, ax)
    # Minors of the columns z and lift.
    abw, abw_low = _sum(*_times(bw, bw_low, az), *_times(aw, aw_low, -bz))
    bcw, bcw_low = _sum(*_times(cw, cw_low, bz), *_times(bw, bw_low, -cz))
    caw, caw_low = _sum(*_times(aw, aw_low, cz), *_times(cw, cw_low, -az))
    # 3 x 3 minors, which are the cofactors of d.
    x, x_low = _dot(ay, by, cy, bcw, bcw_low, caw, caw_low, abw, abw_low)
    y, y_low = _dot(ax, bx, cx, bcw, bcw_low, caw, caw_low, abw, abw_low)
    w, w_low = _dot(az, bz, cz, bc, bc_low, ca, ca_low, ab, ab_low)
    z, z_low = _sum(*_product(aw, aw_low, bc, bc_low), *_product(bw, bw_low, ca, ca_low))
    z, z_low = _sum(z, z_low, *_product(cw, cw_low, ab, ab_low))
    determinant, low = _dot(-dx, dy, -dz, x, x_low, y, y_low, z, z_low)
    determinant, low = _sum(determinant, low, *_product(dw, dw_low, w, w_low))
    return determinant


# ---- the proof that a determinant of exact differences is zero, by residues: on grids it often is
#
# Differences that are multiples of one power of two become integers below 2^56. If stage B left a determinant of degree
# d and P terms below its bound, the integer determinant is below 2^-98 P 2^(56 d): 2^189 for insphere (P = 72, d = 5),
# 2^73 for orient3d (P = 6, d = 3). It is zero if its residues are, to moduli without a common factor whose product is
# larger: 2^64, which is what machine integers do by themselves, and 2^k - 1 for k = 31, 30, 29, 23, 19 (together
# above 2^195; gcd(2^i - 1, 2^j - 1) = 2^gcd(i, j) - 1), where 2^k = 1: the upper bits are added to the lower k.

_INTEGER_BITS = 56
_MODULI = np.array([31, 30, 29, 23, 19], np.uint64)
_U = np.uint64
_ONE = np.uint64(1)


@kernel
def _folded(x, k):
    """x modulo 2^k - 1, not quite reduced: at most 2^k + 2 for x below 2^(2 k + 2)."""
    x = (x & ((_ONE << k) - _ONE)) + (x >> k)
    return (x & ((_ONE << k) - _ONE)) + (x >> k)


@kernel
def _residue(x, k):
    """The residue of an integer below 2^57 in magnitude."""
    modulus = (_ONE << k) - _ONE
    return _folded(_folded(_U(x + np.int64(modulus << (_U(58) - k))), k), k)


@kernel
def _cross_residue(a, b, c, d, k):
    """``a b - c d``; the multiple of the modulus that is added keeps it positive."""
    modulus = (_ONE << k) - _ONE
    return _folded(_folded(a * b, k) + (_U(4) * modulus - _folded(c * d, k)), k)


@kernel
def _dot_residue(x, y, z, a, b, c, k):
    """``a x + b y + c z``."""
    return _folded(_folded(a * x, k) + _folded(b * y, k) + _folded(c * z, k), k)


@kernel
def _determinant3(ax, ay, az, bx, by, bz, cx, cy, cz):
    """Modulo 2^64, for integers."""
    return az * (bx * cy - by * cx) + bz * (cx * ay - cy * ax) + cz * (ax * by - ay * bx)


@kernel
def _determinant3_residue(ax, ay, az, bx, by, bz, cx, cy, cz, k):
    """Modulo 2^k - 1, for residues."""
    bc = _cross_residue(bx, cy, by, cx, k)
    ca = _cross_residue(cx, ay, cy, ax, k)
    ab = _cross_residue(ax, by, ay, bx, k)
    return _dot_residue(az, bz, cz, bc, ca, ab, k)


@kernel
def _square_times(x, y, z, factor, k):
    """``(x^2 + y^2 + z^2) factor``."""
    return _folded(_dot_residue(x, y, z, x, y, z, k) * factor, k)


@kernel
def _as_integer(x, scale):
    """A difference as an integer, and 0 if it is one, else 1."""
    scaled = x * scale
    return np.int64(scaled), 0 if scaled == np.floor(scaled) else 1


@kernel
def _integer_scale(largest):
    """The power of two that brings the largest difference below 2^56."""
    _, exponent = math.frexp(largest)
    return math.ldexp(1.0, _INTEGER_BITS - exponent)


@kernel
def _orient3d_is_zero(ax, ay, az, bx, by, bz, cx, cy, cz):
    """Whether a determinant of exact differences that stage B could not tell from zero is zero; False if unknown."""
    largest = max(max(abs(ax), abs(ay), abs(az)), max(abs(bx), abs(by), abs(bz)), max(abs(cx), abs(cy), abs(cz)))
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
    if rest_1 + rest_2 + rest_3 + rest_4 + rest_5 + rest_6 + rest_7 + rest_8 + rest_9 > 0:
        return False
    if _determinant3(ax, ay, az, bx, by, bz, cx, cy, cz) != 0:
        return False
    k = _MODULI[0]
    found = _determinant3_residue(
        _residue(ax, k), _residue(ay, k), _residue(az, k), _residue(bx, k), _residue(by, k), _residue(bz, k),
        _residue(cx, k), _residue(cy, k), _residue(cz, k), k,
    )  # fmt: skip
    return found % ((_ONE << k) - _ONE) == 0


@kernel
def _insphere_is_zero(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz, largest):
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
        return False
    if rest_7 + rest_8 + rest_9 + rest_10 + rest_11 + rest_12 > 0:
        return False
    determinant = (
        (dx * dx + dy * dy + dz * dz) * _determinant3(ax, ay, az, bx, by, bz, cx, cy, cz)
        - (cx * cx + cy * cy + cz * cz) * _determinant3(ax, ay, az, bx, by, bz, dx, dy, dz)
        + (bx * bx + by * by + bz * bz) * _determinant3(ax, ay, az, cx, cy, cz, dx, dy, dz)
        - (ax * ax + ay * ay + az * az) * _determinant3(bx, by, bz, cx, cy, cz, dx, dy, dz)
    )
    if determinant != 0:
        return False
    for k in _MODULI:
        modulus = (_ONE << k) - _ONE
        px, py, pz = _residue(ax, k), _residue(ay, k), _residue(az, k)
        qx, qy, qz = _residue(bx, k), _residue(by, k), _residue(bz, k)
        rx, ry, rz = _residue(cx, k), _residue(cy, k), _residue(cz, k)
        sx, sy, sz = _residue(dx, k), _residue(dy, k), _residue(dz, k)
        without_a = _square_times(px, py, pz, _determinant3_residue(qx, qy, qz, rx, ry, rz, sx, sy, sz, k), k)
        without_b = _square_times(qx, qy, qz, _determinant3_residue(px, py, pz, rx, ry, rz, sx, sy, sz, k), k)
        without_c = _square_times(rx, ry, rz, _determinant3_residue(px, py, pz, qx, qy, qz, sx, sy, sz, k), k)
        without_d = _square_times(sx, sy, sz, _determinant3_residue(px, py, pz, qx, qy, qz, rx, ry, rz, k), k)
        found = without_d + without_b + (_U(8) * modulus - without_a - without_c)
        if found % modulus != 0:
            return False
    return True


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
    """`incircle` where stage A fails: by the quantum, as a rectangle, or by stages B and C."""
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
    """`orient3d` where stage A fails: by the quantum, with exact differences, or by stages B and C."""
    adx, ady, adz = ax - dx, ay - dy, az - dz
    bdx, bdy, bdz = bx - dx, by - dy, bz - dz
    cdx, cdy, cdz = cx - dx, cy - dy, cz - dz
    bc, cb = bdx * cdy, cdx * bdy
    ca, ac = cdx * ady, adx * cdy
    ab, ba = adx * bdy, bdx * ady
    permanent = (abs(bc) + abs(cb)) * abs(adz) + (abs(ca) + abs(ac)) * abs(bdz) + (abs(ab) + abs(ba)) * abs(cdz)
    if permanent <= work[EXACT_ORIENT3D]:
        return -(adz * (bc - cb) + bdz * (ca - ac) + cdz * (ab - ba))
    tails = max(abs(two_sum(ax, -dx)[1]), abs(two_sum(ay, -dy)[1]), abs(two_sum(az, -dz)[1]))
    tails = max(tails, abs(two_sum(bx, -dx)[1]), abs(two_sum(by, -dy)[1]), abs(two_sum(bz, -dz)[1]))
    tails = max(tails, abs(two_sum(cx, -dx)[1]), abs(two_sum(cy, -dy)[1]), abs(two_sum(cz, -dz)[1]))
    if tails == 0.0:
        determinant = _orient3d_of_edges(adx, ady, adz, bdx, bdy, bdz, cdx, cdy, cdz)
        if abs(determinant) > DOUBLE_DOUBLE_BOUND * permanent:
            return -determinant
        if _orient3d_is_zero(adx, ady, adz, bdx, bdy, bdz, cdx, cdy, cdz):
            return 0.0
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
    """`insphere` where stage A fails: with exact differences, or by stages B and C."""
    aex, aey, aez = ax - ex, ay - ey, az - ez
    bex, bey, bez = bx - ex, by - ey, bz - ez
    cex, cey, cez = cx - ex, cy - ey, cz - ez
    dex, dey, dez = dx - ex, dy - ey, dz - ez
    tails = max(abs(two_sum(ax, -ex)[1]), abs(two_sum(ay, -ey)[1]), abs(two_sum(az, -ez)[1]))
    tails = max(tails, abs(two_sum(bx, -ex)[1]), abs(two_sum(by, -ey)[1]), abs(two_sum(bz, -ez)[1]))
    tails = max(tails, abs(two_sum(cx, -ex)[1]), abs(two_sum(cy, -ey)[1]), abs(two_sum(cz, -ez)[1]))
    tails = max(tails, abs(two_sum(dx, -ex)[1]), abs(two_sum(dy, -ey)[1]), abs(two_sum(dz, -ez)[1]))
    if tails == 0.0:
        largest = max(max(abs(aex), abs(aey), abs(aez)), max(abs(bex), abs(bey), abs(bez)))
        largest = max(largest, max(abs(cex), abs(cey), abs(cez)), max(abs(dex), abs(dey), abs(dez)))
        determinant = _insphere_of_edges(aex, aey, aez, bex, bey, bez, cex, cey, cez, dex, dey, dez)
        # The permanent has 24 terms with three squares each.
        if abs(determinant) > DOUBLE_DOUBLE_BOUND * 72.0 * (largest * largest) * (largest * largest) * largest:
            return -determinant
        if _insphere_is_zero(aex, aey, aez, bex, bey, bez, cex, cey, cez, dex, dey, dez, largest):
            return 0.0
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
