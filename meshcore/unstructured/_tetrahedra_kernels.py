"""Kernels shared by all work on tetrahedra: the layout of the cells, exact sides and spheres, ties.

Layout
------
One buffer of 64-byte records, one a cell, aligned to cache lines, seen as int32 (``cells``) and as float64
(``planes``):

====================  =============================================================================================
cells[16 t + 0..3]    corners in VTK's positive order. A ghost, the cell beyond a facet of the convex hull, has the
                      infinite vertex -1, always as its corner 3. Corner 0 is negative while a cell is no part of the
                      mesh: -1 in a free cell, -2 - v in a cell of the cavity at hand (`marked`).
cells[16 t + 4..7]    neighbour beyond the facet opposite to each corner: ``cell << 3 | constrained << 2 | facet``,
                      where ``facet`` is its facet on this side. The bit ``constrained`` is the same on both sides.
planes[8 t + 4..7]    the sphere through the corners, or a ghost's plane, seen from corner 0: see `sphere_value`.
====================  =============================================================================================

Free cells are a list through ``cells[16 t + 4]`` that ends with -1; its head, like all of a triangulation's counters,
stands in an int64 array ``state`` (`NEXT`, `END`, `FREE`, ...). Points are records of four doubles (x, y, z, size).
Side arrays exist only where asked for, else they are empty: ``region`` (one a cell), ``facet_id`` (four a cell),
``cell_of`` (one a vertex: any cell at it).

Facet k of a cell has the corners ``(FACET_A[k], FACET_B[k], FACET_C[k])``, in positive order with corner k before
them; the infinite vertex, where it is one of them, is the last.

The filter's bound
------------------
Let L bound all differences of coordinates, u = 2^-53. The sphere of a cell (o, a, b, c) is kept as the cofactors of
the last row of ::

    | a_x  a_y  a_z  |a|^2 |
    | b_x  b_y  b_z  |b|^2 |         all points relative to o, the cell's corner 0
    | c_x  c_y  c_z  |c|^2 |
    | q_x  q_y  q_z  |q|^2 |

so that four products give the determinant for any q. Multiplied out it is a sum of terms of degree five. Each
computed term has been rounded once in each of its 5 differences, and on the longest path (a cofactor with |.|^2) 3
times in the square, 2 in the 2 x 2 minor, 3 in the 3 x 3 minor, and 4 times in the last product and sums: 17 factors
(1 + d), |d| <= u, whatever is cancelled in between. So

    |computed - exact| <= ((1 + u)^17 - 1) * (sum of the terms' absolute values).

With A a bound of the nine differences of a, b, c, and s = |q_x| + |q_y| + |q_z|, the terms of the cofactors of q_x,
q_y, q_z (6 products of two differences and a square |.|^2 <= 3 A^2) sum to 18 A^4 each at most, and those of |q|^2 to
6 A^3: the sum is below ::

    T = 6 A^3 (3 A s + |q|^2) <= 24 L^4 s            as A <= L and |q|^2 <= L s.

17 * 24 = 408; 412 u leaves room for the rounding of the bound itself. A ghost's value, the triple product of two
edges and q, is a sum of 6 terms, |.| below 2 L^2 s together, with at most 9 roundings each: 18 u L^2 s, which is less
as long as L >= 1/4. `tetrahedralization` scales points by a power of two so that L >= 1/2; nothing underflows, since
`predicates.rescaled` makes all coordinates multiples of 2^-214, hence all terms multiples of 2^-1070. An orientation
has 6 terms of at most L^3 with 3 + 5 roundings each: 48 u L^3.

Where L is too coarse, in clumps, the same bound is taken with the cell's own A. Where all coordinates are multiples
of a power of two g, and T < 2^53 g^5, all intermediate results are multiples of g^k below 2^53 g^k: nothing was
rounded, and the value is exact.
"""

import numpy as np

from .._numba import kernel
from ..geometry._predicates_kernels import (
    EXACT_INSPHERE,
    EXACT_ORIENT3D,
    ORIENT3D_BOUND,
    insphere_exact,
    orient2d,
    orient3d_exact,
)

FACET_A = np.array([1, 2, 0, 0], np.int64)
FACET_B = np.array([2, 0, 1, 2], np.int64)
FACET_C = np.array([3, 3, 3, 1], np.int64)

CONSTRAINED = 4
INFINITE = -1

# What a kernel that works in steps answers: finished, call again, a buffer must grow first, impossible state.
DONE, MORE, FULL, FAILED = 0, 1, 2, 3
# Which buffer must grow: the cells, or the lists of a cavity.
FULL_CELLS, FULL_CAVITY = 4, 5

# The counters of a triangulation, or of a thread's part of it: first unused cell, end of the cells that may be used,
# head of the list of free cells, cell from which the next point is looked for.
NEXT, END, FREE, HINT = 0, 1, 2, 3

U = np.uint64
EPSILON = 2.0**-53
SPHERE_BOUND = 412 * EPSILON  # times L^4 (|q_x| + |q_y| + |q_z|)
SIDE_BOUND = 49 * EPSILON  # times L^3
LOCAL_SPHERE_BOUND = 17.5 * EPSILON  # times T

# Places in the array ``limits``: the filters' bounds for all of the points and, as scratch, the coordinates of five.
SPHERE_LIMIT, SIDE_LIMIT, FIVE = 0, 1, 2
LIMITS_SIZE = FIVE + 15


@kernel
def set_limits(limits, extent):
    """Write the filters' limits for differences up to ``extent``, at least 1/2."""
    limits[SPHERE_LIMIT] = SPHERE_BOUND * (extent * extent) * (extent * extent)
    limits[SIDE_LIMIT] = SIDE_BOUND * extent * extent * extent


@kernel(inline=True)
def marked(vertex):
    """Corner 0 of a cell of the cavity at hand; the same function takes the mark away."""
    return -2 - vertex


@kernel(inline=True)
def sphere_of(ax, ay, az, aw, bx, by, bz, bw, cx, cy, cz, cw):
    """The four cofactors of the sphere through 0, a, b, c, w being the squared lengths; the last is the volume."""
    ab = ax * by - ay * bx
    bc = bx * cy - by * cx
    ca = cx * ay - cy * ax
    abw = az * bw - aw * bz
    bcw = bz * cw - bw * cz
    caw = cz * aw - cw * az
    return (
        -(ay * bcw + by * caw + cy * abw),
        ax * bcw + bx * caw + cx * abw,
        -(aw * bc + bw * ca + cw * ab),
        az * bc + bz * ca + cz * ab,
    )


@kernel(inline=True)
def plane_of(ax, ay, az, bx, by, bz):
    """The same of a ghost: the plane through 0, a, b, negative on the side of the infinite vertex."""
    return az * by - ay * bz, ax * bz - az * bx, ay * bx - ax * by, 0.0


@kernel
def set_plane(points, cells, planes, t):
    """Write the cached sphere or plane of cell t."""
    o, a, b, c = cells[16 * t], cells[16 * t + 1], cells[16 * t + 2], cells[16 * t + 3]
    ox, oy, oz = points[4 * o], points[4 * o + 1], points[4 * o + 2]
    ax, ay, az = points[4 * a] - ox, points[4 * a + 1] - oy, points[4 * a + 2] - oz
    bx, by, bz = points[4 * b] - ox, points[4 * b + 1] - oy, points[4 * b + 2] - oz
    if c < 0:
        x, y, z, w = plane_of(ax, ay, az, bx, by, bz)
    else:
        cx, cy, cz = points[4 * c] - ox, points[4 * c + 1] - oy, points[4 * c + 2] - oz
        aw, bw, cw = ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz, cx * cx + cy * cy + cz * cz
        x, y, z, w = sphere_of(ax, ay, az, aw, bx, by, bz, bw, cx, cy, cz, cw)
    planes[8 * t + 4], planes[8 * t + 5], planes[8 * t + 6], planes[8 * t + 7] = x, y, z, w


@kernel
def side(points, a, b, c, d, work):
    """Exact sign of ``orient3d(a, b, c, d)`` of four vertices: positive if they are in VTK's order."""
    dx, dy, dz = points[U(4 * d)], points[U(4 * d + 1)], points[U(4 * d + 2)]
    ax, ay, az = points[U(4 * a)], points[U(4 * a + 1)], points[U(4 * a + 2)]
    bx, by, bz = points[U(4 * b)], points[U(4 * b + 1)], points[U(4 * b + 2)]
    cx, cy, cz = points[U(4 * c)], points[U(4 * c + 1)], points[U(4 * c + 2)]
    return _side(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz, work, work[EXACT_ORIENT3D])


@kernel
def _side(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz, work, exact_limit):
    """`orient3d` with the short cut for coordinates on a grid, and for points in an axis-parallel plane."""
    adx, ady, adz = ax - dx, ay - dy, az - dz
    bdx, bdy, bdz = bx - dx, by - dy, bz - dz
    cdx, cdy, cdz = cx - dx, cy - dy, cz - dz
    bc, cb = bdx * cdy, cdx * bdy
    ca, ac = cdx * ady, adx * cdy
    ab, ba = adx * bdy, bdx * ady
    determinant = adz * (bc - cb) + bdz * (ca - ac) + cdz * (ab - ba)
    permanent = (abs(bc) + abs(cb)) * abs(adz) + (abs(ca) + abs(ac)) * abs(bdz) + (abs(ab) + abs(ba)) * abs(cdz)
    if abs(determinant) > ORIENT3D_BOUND * permanent or permanent <= exact_limit or permanent == 0.0:
        return -determinant
    return orient3d_exact(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz, work)


# ---- the sphere, where the filter could not tell


@kernel
def conflict(points, rows, cells, planes, t, q, work, limits):
    """Negative if vertex q is in conflict with cell t: inside its sphere, or beyond a ghost's facet. Never zero.

    Ties are decided as if the lifted coordinate of each point were raised by an infinitesimal that is the larger the
    lower the point's row in the caller's array (Edelsbrunner & Muecke 1990; Devillers & Teillaud 2011). A point in
    the plane of a ghost's facet gets the answer of the cell behind it.
    """
    if cells[U(16 * t + 3)] < 0:
        a, b, c = cells[U(16 * t)], cells[U(16 * t + 1)], cells[U(16 * t + 2)]
        beyond = side(points, a, b, c, q, work)
        if beyond != 0.0:
            return -beyond
        t = np.int64(cells[U(16 * t + 7)]) >> 3
        if cells[U(16 * t)] < 0:
            return -1.0  # in the cavity already
    five = limits[FIVE:]
    for j in range(5):
        v = np.int64(cells[U(16 * t + j)]) if j < 4 else q
        for k in range(3):
            five[3 * j + k] = points[U(4 * v + k)]
    largest = 0.0
    for j in range(3, 12):
        largest = max(largest, abs(five[j] - five[j % 3]))
    x, y, z = five[12] - five[0], five[13] - five[1], five[14] - five[2]
    square = x * x + y * y + z * z
    i = 8 * t
    value = planes[U(i + 4)] * x + planes[U(i + 5)] * y + planes[U(i + 6)] * z + planes[U(i + 7)] * square
    terms = 6.0 * largest * largest * largest * (3.0 * largest * (abs(x) + abs(y) + abs(z)) + square)
    if abs(value) > LOCAL_SPHERE_BOUND * terms:
        return value
    exact_side = work[EXACT_ORIENT3D]
    if not terms < work[EXACT_INSPHERE]:
        value = 0.0
        if _corners_of_a_box(five):
            exact_side = np.inf
        else:
            value = -insphere_exact(
                five[0], five[1], five[2], five[3], five[4], five[5], five[6], five[7], five[8], five[9], five[10],
                five[11], five[12], five[13], five[14], work,
            )  # fmt: skip
    if value != 0.0:
        return value
    return _tie(five, rows, cells, t, q, exact_side, work)


@kernel
def _corners_of_a_box(five):
    """Whether five points take at most two values along each axis; if so, their coordinates become 0 and 1.

    Corners of a box are cospherical however they were rounded, and stretching an axis keeps orientations.
    """
    two = True
    for k in range(3):
        low = min(min(min(five[k], five[3 + k]), min(five[6 + k], five[9 + k])), five[12 + k])
        high = max(max(max(five[k], five[3 + k]), max(five[6 + k], five[9 + k])), five[12 + k])
        for j in range(5):
            two &= (five[3 * j + k] == low) | (five[3 * j + k] == high)  # without branches, which nobody could predict
    if two:
        for k in range(3):
            low = min(min(min(five[k], five[3 + k]), min(five[6 + k], five[9 + k])), five[12 + k])
            for j in range(5):
                five[3 * j + k] = 0.0 if five[3 * j + k] == low else 1.0
    return two


@kernel
def _tie(five, rows, cells, t, q, exact_side, work):
    """The perturbed `conflict` of five cospherical points: the first minor, by ascending rows, that is not zero.

    Raising corner k raises the sphere's hyperplane at q by q's barycentric coordinate for k, whose sign is that of the
    cell with q in place of k. Raising q itself takes it out of the sphere.
    """
    last = -1
    while True:
        lowest = rows[U(q)]
        at = 4
        for k in range(4):
            row = rows[U(cells[U(16 * t + k)])]
            if last < row < lowest:
                lowest = row
                at = k
        if at == 4:
            return 1.0
        a, b, c, d = 0, 3, 6, 9
        if at == 0:
            a = 12
        elif at == 1:
            b = 12
        elif at == 2:
            c = 12
        else:
            d = 12
        orientation = _side(
            five[a], five[a + 1], five[a + 2], five[b], five[b + 1], five[b + 2], five[c], five[c + 1], five[c + 2],
            five[d], five[d + 1], five[d + 2], work, exact_side,
        )  # fmt: skip
        if orientation != 0.0:
            return -orientation
        last = lowest


# ---- the beginning


@kernel
def first_cell(points, n, work, corners):
    """Write the first four of n vertices that span space, in positive order; return how many there are (below 4)."""
    corners[0], corners[1] = 0, 1
    found = min(n, 2)
    for v in range(2, n):
        if found == 2:
            for k in range(3):
                i, j = k, (k + 1) % 3
                at = 4 * v
                turn = orient2d(
                    points[i], points[j], points[4 + i], points[4 + j], points[at + i], points[at + j], work
                )
                if turn != 0.0:
                    found = 3
                    corners[2] = v
        else:
            turn = side(points, 0, 1, corners[2], v, work)
            if turn != 0.0:
                corners[3] = v
                if turn < 0.0:
                    corners[0], corners[1] = 1, 0
                return 4
    return found


@kernel
def set_first_cells(points, cells, planes, corners):
    """Write the cell of four vertices and the ghosts beyond its facets as cells 0 to 4."""
    for k in range(4):
        cells[k] = corners[k]
        ghost = 16 * (k + 1)
        cells[ghost], cells[ghost + 1], cells[ghost + 2] = FACET_A[k], FACET_B[k], FACET_C[k]
        cells[ghost + 3] = INFINITE
        cells[4 + k] = (k + 1) << 3 | 3
        cells[ghost + 7] = k
        for j in range(3):  # beyond the edge without cells[ghost + j] is the ghost whose facet lacks that corner
            other = cells[ghost + j]
            for i in range(3):
                corner = FACET_A[other] if i == 0 else (FACET_B[other] if i == 1 else FACET_C[other])
                if corner == k:
                    cells[ghost + 4 + j] = (other + 1) << 3 | i
    for ghost in range(16, 80, 16):
        for j in range(3):
            cells[ghost + j] = corners[cells[ghost + j]]
    for t in range(5):
        set_plane(points, cells, planes, t)


# ---- parts of the cells for threads


@kernel
def is_own(cells, part_of, part, t):
    """Whether all finite corners of cell t belong to a part."""
    c = np.int64(cells[U(16 * t + 3)])
    return (
        part_of[U(cells[U(16 * t)])] == part
        and part_of[U(cells[U(16 * t + 1)])] == part
        and part_of[U(cells[U(16 * t + 2)])] == part
        and (c < 0 or part_of[U(c)] == part)
    )


@kernel
def first_own(cells, n_cells, part_of, part):
    """The first finite cell of a part, or -1."""
    for t in range(n_cells):
        if cells[U(16 * t)] >= 0 and cells[U(16 * t + 3)] >= 0 and is_own(cells, part_of, part, t):
            return t
    return -1


@kernel
def free_unused(cells, state):
    """Put the unused cells of a part into its list of free ones."""
    free = state[FREE]
    for t in range(state[NEXT], state[END]):
        cells[U(16 * t)] = -1
        cells[U(16 * t + 4)] = free
        free = t
    state[FREE] = free
    state[NEXT] = state[END]


@kernel
def take_range(cells, state, whole, size):
    """Give a part the next ``size`` cells of the triangulation."""
    free_unused(cells, state)
    state[NEXT] = whole[NEXT]
    whole[NEXT] += size
    state[END] = whole[NEXT]


@kernel
def give_back(cells, state, whole):
    """Put all cells that a part has left into the triangulation's list of free ones."""
    free_unused(cells, state)
    free = whole[FREE]
    t = state[FREE]
    while t >= 0:
        following = np.int64(cells[U(16 * t + 4)])
        cells[U(16 * t + 4)] = free
        free = t
        t = following
    whole[FREE] = free
    state[FREE] = -1
