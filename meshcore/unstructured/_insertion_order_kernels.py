"""Kernels that order points for insertion: Hilbert keys, a stable radix sort, merging of equal points, random rounds.

A point is carried through the sort as one number: its key in the upper 32 bits, its row in the lower ones.

References
----------
C. Hamilton, "Compact Hilbert indices", Dalhousie University, CS-2006-07, for the curve in any dimension.
N. Amenta, S. Choi, G. Rote, "Incremental constructions con BRIO", Proc. 19th Symp. Computational Geometry (2003).
G. Steele, D. Lea, C. Flood, "Fast splittable pseudorandom number generators", OOPSLA (2014), for the hash.
"""

import math

import numpy as np

from .._numba import kernel

# Runs of equal keys up to this length are left alone; longer ones get keys of their own.
LONG_RUN = 16
SMALL_SORT = 48
SHORT_KEY_BITS = 24
# The table of the curve has at most 8 states of 2^8 cells in the plane and 24 states of 2^6 cells in space.
TABLE_SIZE = 2048
COUNTERS = 4096
# Bits an axis that one look-up of the table takes.
_PLANE_STEP = 4
_SPACE_STEP = 2
_ROW = np.uint64(0xFFFFFFFF)
_MERGED = np.uint64(0xFFFFFFFFFFFFFFFF)

U = np.uint64


@kernel
def fill_curve_table(dimension, table):
    """Tabulate some levels of the Hilbert curve at once (Hamilton, algorithm 2).

    ``table[state << bits | cell]`` is ``next_state << bits | place``; a state is the corner where the curve enters,
    times the dimension, plus the axis along which it leaves.
    """
    step = _PLANE_STEP if dimension == 2 else _SPACE_STEP
    bits = dimension * step
    mask = (1 << dimension) - 1
    for state in range(dimension << dimension):
        for cell in range(1 << bits):
            entry = state // dimension
            axis = state % dimension
            place = 0
            for level in range(step - 1, -1, -1):
                corner = 0
                for k in range(dimension):
                    corner |= ((cell >> (k * step + level)) & 1) << k
                corner ^= entry
                turn = (axis + 1) % dimension
                gray = ((corner >> turn) | (corner << (dimension - turn))) & mask
                w = gray ^ (gray >> 1) ^ (gray >> 2)
                place = (place << dimension) | w
                # Where the curve enters the part w and along which axis it leaves (theorems 2.10 and 2.12).
                even = 2 * ((w - 1) // 2) if w > 0 else 0
                first = even ^ (even >> 1)
                ones = 0
                odd = (w if w & 1 else w - 1) if w > 0 else 0
                while odd & 1:
                    ones += 1
                    odd >>= 1
                entry ^= ((first << turn) | (first >> (dimension - turn))) & mask
                axis = (axis + ones + 1) % dimension
            table[(state << bits) | cell] = ((entry * dimension + axis) << bits) | place


@kernel
def set_box(points, dimension, packed, start, stop, box):
    """Lower corner, and longest side of the bounding box of some points, as ``box[0..2]`` and ``box[3]``."""
    box[3] = 0.0
    for k in range(dimension):
        low = points[packed[U(start)] & _ROW, k]
        high = low
        for i in range(start, stop):
            x = points[packed[U(i)] & _ROW, k]
            low = min(low, x)
            high = max(high, x)
        box[k] = low
        box[3] = max(box[3], high - low)


@kernel
def set_keys(points, dimension, box, table, key_bits, packed, start, stop):
    """Write the keys of some points above their rows."""
    axis_bits = key_bits // dimension
    scale = ((1 << axis_bits) - 1) / box[3] if box[3] > 0.0 else 0.0
    low_x = box[0]
    low_y = box[1]
    if dimension == 2:
        for i in range(start, stop):
            row = packed[U(i)] & _ROW
            x = U((points[row, 0] - low_x) * scale)
            y = U((points[row, 1] - low_y) * scale)
            state = U(0)
            key = U(0)
            for level in range(axis_bits - _PLANE_STEP, -1, -_PLANE_STEP):
                cell = ((x >> U(level)) & U(15)) | (((y >> U(level)) & U(15)) << U(4))
                found = U(table[(state << U(8)) | cell])
                state = found >> U(8)
                key = (key << U(8)) | (found & U(255))
            packed[U(i)] = (key << U(32)) | row
        return
    low_z = box[2]
    for i in range(start, stop):
        row = packed[U(i)] & _ROW
        x = U((points[row, 0] - low_x) * scale)
        y = U((points[row, 1] - low_y) * scale)
        z = U((points[row, 2] - low_z) * scale)
        state = U(0)
        key = U(0)
        for level in range(axis_bits - _SPACE_STEP, -1, -_SPACE_STEP):
            cell = ((x >> U(level)) & U(3)) | (((y >> U(level)) & U(3)) << U(2)) | (((z >> U(level)) & U(3)) << U(4))
            found = U(table[(state << U(6)) | cell])
            state = found >> U(6)
            key = (key << U(6)) | (found & U(63))
        packed[U(i)] = (key << U(32)) | row


@kernel
def sort_by_key(packed, other, key_bits, counts, start, stop):
    """Sort some points by their keys, stably; ``other`` is as long as ``packed``."""
    if stop - start <= SMALL_SORT:
        for i in range(start + 1, stop):
            item = packed[U(i)]
            j = i - 1
            while j >= start and (packed[U(j)] >> U(32)) > (item >> U(32)):
                packed[U(j + 1)] = packed[U(j)]
                j -= 1
            packed[U(j + 1)] = item
        return
    passes = 2 if key_bits <= SHORT_KEY_BITS else 3
    digit_bits = (key_bits + passes - 1) // passes
    mask = U((1 << digit_bits) - 1)
    a = packed
    b = other
    for digit in range(passes):
        shift = U(32 + digit * digit_bits)
        counts[:] = 0
        for i in range(start, stop):
            counts[(a[U(i)] >> shift) & mask] += 1
        total = start
        for k in range(1 << digit_bits):
            count = counts[U(k)]
            counts[U(k)] = total
            total += count
        for i in range(start, stop):
            item = a[U(i)]
            place = (item >> shift) & mask
            b[U(counts[place])] = item
            counts[place] += 1
        a, b = b, a
    if passes & 1:
        for i in range(start, stop):
            packed[U(i)] = other[U(i)]


@kernel
def split_runs(points, dimension, table, key_bits, packed, other, counts, box, stack, start, stop):
    """Give long runs of equal keys (clumps) finer keys, in boxes of their own, until none is left but of equal points.

    A box with two different points puts them into different cells, since its longest side is cut from end to end.
    """
    depth = 0
    first = start
    last = stop
    while True:
        i = first
        while i < last:
            key = packed[U(i)] >> U(32)
            j = i + 1
            while j < last and packed[U(j)] >> U(32) == key:
                j += 1
            if j - i > LONG_RUN:
                stack[U(2 * depth)] = i
                stack[U(2 * depth + 1)] = j
                depth += 1
            i = j
        found = False
        while depth > 0 and not found:
            depth -= 1
            first = int(stack[U(2 * depth)])
            last = int(stack[U(2 * depth + 1)])
            set_box(points, dimension, packed, first, last, box)
            found = box[3] > 0.0
        if not found:
            return
        set_keys(points, dimension, box, table, key_bits, packed, first, last)
        sort_by_key(packed, other, key_bits, counts, first, last)


@kernel
def merge_equal(points, dimension, packed, merged, n):
    """Mark all but the first of equal points, and list them in ``merged``: row above, row that stays below.

    Equal points have equal keys, and the sort was stable: the lowest row of them comes first in its run.
    """
    count = 0
    start = 0
    key = U(0)
    for i in range(n):
        item = packed[U(i)]
        if i == 0 or item >> U(32) != key:
            key = item >> U(32)
            start = i
            continue
        row = item & _ROW
        for j in range(start, i):
            if packed[U(j)] == _MERGED:
                continue
            other = packed[U(j)] & _ROW
            same = points[row, 0] == points[other, 0] and points[row, 1] == points[other, 1]
            if dimension == 3:
                same = same and points[row, 2] == points[other, 2]
            if same:
                merged[U(count)] = (row << U(32)) | other
                count += 1
                packed[U(i)] = _MERGED
                break
    return count


@kernel
def number_rows(points, dimension, packed, box):
    """Begin the sort: write the row of each point, and the bounding box."""
    for i in range(len(points)):
        packed[U(i)] = i
    set_box(points, dimension, packed, 0, len(points), box)


@kernel
def sort_and_merge(points, dimension, table, key_bits, packed, other, counts, box, stack):
    """Sort points that have keys, as finely as needed, and mark equal ones, listed in ``other``; return how many."""
    n = len(packed)
    sort_by_key(packed, other, key_bits, counts, 0, n)
    split_runs(points, dimension, table, SHORT_KEY_BITS, packed, other, counts, box, stack, 0, n)
    return merge_equal(points, dimension, packed, other, n)


@kernel
def round_of(row, last):
    """The round in which a point is inserted: the last with probability 1/2, the one before with 1/4, and so on.

    The random number is a hash of the row (splitmix64), so that it is the same on every platform.
    """
    h = (row + U(1)) * U(0x9E3779B97F4A7C15)
    h = (h ^ (h >> U(30))) * U(0xBF58476D1CE4E5B9)
    h = (h ^ (h >> U(27))) * U(0x94D049BB133111EB)
    h = h ^ (h >> U(31))
    number = last
    while number > 0 and h & U(1):
        number -= 1
        h >>= U(1)
    return number


@kernel
def write_order(points, dimension, packed, last_round, places, order, coordinates):
    """Write rows and coordinates of the points that are not merged, by rounds and within each along the curve."""
    n = len(packed)
    places[: last_round + 2] = 0
    for i in range(n):
        if packed[U(i)] != _MERGED:
            places[round_of(packed[U(i)] & _ROW, last_round) + 1] += 1
    for k in range(last_round):
        places[k + 1] += places[k]
    for i in range(n):
        item = packed[U(i)]
        if item != _MERGED:
            number = round_of(item & _ROW, last_round)
            order[U(places[number])] = np.int32(item & _ROW)
            places[number] += 1
    gather(points, dimension, order, coordinates)


@kernel
def gather(points, dimension, order, coordinates):
    """Copy the coordinates of points in their order."""
    if dimension == 2:
        for i in range(len(order)):
            row = U(order[U(i)])
            coordinates[U(2 * i)] = points[row, U(0)]
            coordinates[U(2 * i + 1)] = points[row, U(1)]
        return
    for i in range(len(order)):
        row = U(order[U(i)])
        coordinates[U(3 * i)] = points[row, U(0)]
        coordinates[U(3 * i + 1)] = points[row, U(1)]
        coordinates[U(3 * i + 2)] = points[row, U(2)]


@kernel
def fit_line(points, step, line):
    """Write the line through every so many points in the plane: a point x, y of it, their reach, its direction x, y.

    Sums one after the other, and square roots instead of angles: the same numbers on every platform.
    """
    x = y = 0.0
    count = 0
    for i in range(0, len(points), step):
        x += points[U(i), U(0)]
        y += points[U(i), U(1)]
        count += 1
    x /= count
    y /= count
    size = 0.0
    for i in range(0, len(points), step):
        size = max(size, abs(points[U(i), U(0)] - x), abs(points[U(i), U(1)] - y))
    if size == 0.0:
        size = 1.0
    xx = xy = yy = 0.0
    for i in range(0, len(points), step):
        dx = (points[U(i), U(0)] - x) / size
        dy = (points[U(i), U(1)] - y) / size
        xx += dx * dx
        xy += dx * dy
        yy += dy * dy
    # The long axis of the ellipse of inertia: with its angle t, cos 2t = (xx - yy) / length, sin 2t = 2 xy / length.
    length = math.sqrt((xx - yy) * (xx - yy) + 4.0 * xy * xy)
    line[0], line[1], line[2], line[3], line[4] = x, y, size, 1.0, 0.0
    if length > 0.0:
        larger = math.sqrt(0.5 + 0.5 * abs(xx - yy) / length)
        smaller = xy / length / larger
        line[3], line[4] = (larger, smaller) if xx >= yy else (smaller, larger)


@kernel
def is_surely_thick(points, step, n, outliers, line):
    """Whether more than ``outliers`` of a sample are farther from the line that fits it than n points are apart on it.

    The sample is every so many points; `thin_clouds` says what for, and `fit_line` what is written to ``line``.
    """
    fit_line(points, step, line)
    low = math.inf
    high = -math.inf
    for i in range(0, len(points), step):
        along = line[3] * (points[U(i), U(0)] - line[0]) + line[4] * (points[U(i), U(1)] - line[1])
        low = min(low, along)
        high = max(high, along)
    far = 0
    count = 0
    for i in range(0, len(points), step):
        across = line[3] * (points[U(i), U(1)] - line[1]) - line[4] * (points[U(i), U(0)] - line[0])
        if abs(across) * n > high - low:
            far += 1
        count += 1
    return far > min(outliers, (count - 1) // 2)
