"""The discrete Winslow equations of a planar grid: their defect, their smoothing by lines, and what tells a fold.

    N(r) = a (r_ii + p r_i) - 2 b r_ij + g (r_jj + q r_j) = f,      a = r_j.r_j,  b = r_i.r_j,  g = r_i.r_i

in central differences of index units: J. F. Thompson, Z. U. A. Warsi, C. W. Mastin, "Numerical Grid Generation" (1985),
chapter VI, equation (18), with control functions p and q that are factored as the survey's 2.5.1 does.

Arrays are (2, ni, nj): coordinates ``r``, right-hand sides ``f``, control functions ``c`` = (p, q). Rows and columns 0
and -1 are data: a boundary, or ghosts, where row 0 stands for row ni - 2 and row ni - 1 for row 1. Each kernel does the
rows or columns from ``first`` to ``last``, so that threads share the work, and results do not depend on how. ``f`` and
``c`` may have a single row, which then stands for all: where they are zero, reading them would take most of the time.
"""

import numpy as np

from ..._numba import kernel

U = np.uint64  # subscripts of this type need no look at negative ones, which would keep loops from becoming vectors
TINY = 1e-300  # keeps a division by the size of a collapsed cell finite
# Share of |r_ii|^2 that joins g = |r_i|^2 (and a likewise) where a line turns back on itself, as at a sharp trailing
# edge: the central difference vanishes there, and a quarter makes g the mean of the one-sided squares.
CORNER = 0.25
# Lines that are solved abreast. Scratch is one flat array of records, so that the compiler knows what does not overlap;
# lanes that are not used hold what they held.
LANES = 16
BELOW, DIAGONAL, ABOVE, DX, DY, FAR = (LANES * k for k in range(6))
RECORD = 6 * LANES


@kernel(inline=True)
def metric(ri, rj, rii, rjj, si, sj, sii, sjj, corner):
    """a, b, g from the differences of x (r) and of y (s)."""
    a = rj * rj + sj * sj + corner * (rjj * rjj + sjj * sjj)
    g = ri * ri + si * si + corner * (rii * rii + sii * sii)
    return a, ri * rj + si * sj, g


@kernel(inline=True)
def equation(x0, x1, x2, y0, y1, y2, p, q, j, corner):
    """a, g, N(r) in x and in y, at column j of the middle of three rows."""
    xi = 0.5 * (x2[U(j)] - x0[U(j)])
    yi = 0.5 * (y2[U(j)] - y0[U(j)])
    xj = 0.5 * (x1[U(j + 1)] - x1[U(j - 1)])
    yj = 0.5 * (y1[U(j + 1)] - y1[U(j - 1)])
    xii = (x2[U(j)] - x1[U(j)]) - (x1[U(j)] - x0[U(j)])
    yii = (y2[U(j)] - y1[U(j)]) - (y1[U(j)] - y0[U(j)])
    xjj = (x1[U(j + 1)] - x1[U(j)]) - (x1[U(j)] - x1[U(j - 1)])
    yjj = (y1[U(j + 1)] - y1[U(j)]) - (y1[U(j)] - y1[U(j - 1)])
    xij = 0.25 * ((x2[U(j + 1)] - x2[U(j - 1)]) - (x0[U(j + 1)] - x0[U(j - 1)]))
    yij = 0.25 * ((y2[U(j + 1)] - y2[U(j - 1)]) - (y0[U(j + 1)] - y0[U(j - 1)]))
    a, b, g = metric(xi, xj, xii, xjj, yi, yj, yii, yjj, corner)
    nx = a * (xii + p[U(j)] * xi) - 2 * b * xij + g * (xjj + q[U(j)] * xj)
    ny = a * (yii + p[U(j)] * yi) - 2 * b * yij + g * (yjj + q[U(j)] * yj)
    return a, g, nx, ny


@kernel
def defect(r, f, c, d, sharp, first, last):
    """d = f - N(r) in rows ``first`` to ``last``."""
    for i in range(first, last):
        x0, x1, x2, y0, y1, y2 = r[0, i - 1], r[0, i], r[0, i + 1], r[1, i - 1], r[1, i], r[1, i + 1]
        fx, fy, dx, dy, p, q = (
            f[0, i % f.shape[1]],
            f[1, i % f.shape[1]],
            d[0, i],
            d[1, i],
            c[0, i % c.shape[1]],
            c[1, i % c.shape[1]],
        )
        corner = CORNER if i == sharp else 0.0
        for j in range(1, x1.size - 1):
            _, _, nx, ny = equation(x0, x1, x2, y0, y1, y2, p, q, j, corner)
            dx[j] = fx[j] - nx
            dy[j] = fy[j] - ny


@kernel
def row_equations(r, f, c, i, sharp, out):
    """a, g and N(r) - f in x and y of row i, at the same columns of ``out``: a loop that compilers make vectors of."""
    x0, x1, x2, y0, y1, y2 = r[0, i - 1], r[0, i], r[0, i + 1], r[1, i - 1], r[1, i], r[1, i + 1]
    fx, fy, p, q = f[0, i % f.shape[1]], f[1, i % f.shape[1]], c[0, i % c.shape[1]], c[1, i % c.shape[1]]
    out_a, out_g, out_x, out_y = out[0], out[1], out[2], out[3]
    corner = CORNER if i == sharp else 0.0
    for j in range(1, x1.size - 1):
        a, g, nx, ny = equation(x0, x1, x2, y0, y1, y2, p, q, j, corner)
        out_a[j] = a
        out_g[j] = g
        out_x[j] = nx - fx[j]
        out_y[j] = ny - fy[j]


@kernel
def jacobi_moves(r, f, c, sharp, out, squares, first, last):
    """Per row, the sum of squares of the way that a step of point Jacobi would move its nodes."""
    n = r.shape[2]
    for i in range(first, last):
        row_equations(r, f, c, i, sharp, out)
        a, g, nx, ny = out[0], out[1], out[2], out[3]
        total = 0.0
        for j in range(1, n - 1):
            size = 2 * (a[j] + g[j]) + TINY
            a[j] = (nx[j] * nx[j] + ny[j] * ny[j]) / (size * size)
        for j in range(1, n - 1):
            total += a[j]
        squares[i] = total


@kernel
def smooth_along_i(r, f, c, sharp, cyclic, step, work, first, last):
    """Solve the columns ``first``, ``first`` + 2, ... before ``last`` for their correction, coefficients frozen.

    Only ``step`` of the correction is made.
    """
    n = r.shape[1]
    for start in range(first, last, 2 * LANES):
        used = min(LANES, (last - start + 1) // 2)
        for i in range(1, n - 1):
            x0, x1, x2, y0, y1, y2 = r[0, i - 1], r[0, i], r[0, i + 1], r[1, i - 1], r[1, i], r[1, i + 1]
            fx, fy, p, q = f[0, i % f.shape[1]], f[1, i % f.shape[1]], c[0, i % c.shape[1]], c[1, i % c.shape[1]]
            corner = CORNER if i == sharp else 0.0
            row = i * RECORD
            for k in range(used):
                j = start + 2 * k
                a, g, nx, ny = equation(x0, x1, x2, y0, y1, y2, p, q, j, corner)
                work[U(row + BELOW + k)] = a * (1 - 0.5 * p[U(j)])
                work[U(row + DIAGONAL + k)] = 2 * (a + g) + TINY
                work[U(row + ABOVE + k)] = a * (1 + 0.5 * p[U(j)])
                work[U(row + DX + k)] = nx - fx[U(j)]
                work[U(row + DY + k)] = ny - fy[U(j)]
        solve_lines(work, n - 2, cyclic)
        for i in range(1, n - 1):
            x, y = r[0, i], r[1, i]
            for k in range(used):
                x[U(start + 2 * k)] += step * work[U(i * RECORD + DX + k)]
                y[U(start + 2 * k)] += step * work[U(i * RECORD + DY + k)]


@kernel
def smooth_along_j(r, f, c, sharp, step, out, work, first, last):
    """The same of the rows ``first``, ``first`` + 2, ... before ``last``."""
    n = r.shape[2]
    for start in range(first, last, 2 * LANES):
        used = min(LANES, (last - start + 1) // 2)
        for k in range(used):
            i = start + 2 * k
            row_equations(r, f, c, i, sharp, out)
            a, g, nx, ny, q = out[0], out[1], out[2], out[3], c[1, i % c.shape[1]]
            for j in range(1, n - 1):
                half = 0.5 * q[U(j)]
                row = j * RECORD + k
                work[U(row + BELOW)] = g[U(j)] * (1 - half)
                work[U(row + DIAGONAL)] = 2 * (a[U(j)] + g[U(j)]) + TINY
                work[U(row + ABOVE)] = g[U(j)] * (1 + half)
                work[U(row + DX)] = nx[U(j)]
                work[U(row + DY)] = ny[U(j)]
        solve_lines(work, n - 2, False)
        for k in range(used):
            x, y = r[0, start + 2 * k], r[1, start + 2 * k]
            for j in range(1, n - 1):
                x[U(j)] += step * work[U(j * RECORD + DX + k)]
                y[U(j)] += step * work[U(j * RECORD + DY + k)]


@kernel
def solve_lines(work, n, cyclic):
    """Thomas algorithm of ``-below u[t-1] + diagonal u[t] - above u[t+1] = (dx, dy)``, t = 1 to n, in all lanes.

    Elimination leaves ``u[t] = above u[t+1] + (dx, dy) + far u[n]``. Cyclic lines have u[0] = u[n] and u[n+1] = u[1];
    their last equation is eliminated along with the others, its coefficient of u[t] being kept in row n + 1.
    """
    end, over = n * RECORD, (n + 1) * RECORD
    for k in range(LANES):
        work[U(ABOVE + k)] = work[U(DX + k)] = work[U(DY + k)] = 0.0
        work[U(FAR + k)] = 1.0 if cyclic else 0.0
        work[U(over + k)] = work[U(end + ABOVE + k)] if cyclic else 0.0
    for t in range(1, n):
        row = t * RECORD
        for k in range(LANES):
            below = work[U(row + BELOW + k)]
            scale = 1.0 / (work[U(row + DIAGONAL + k)] - below * work[U(row - RECORD + ABOVE + k)])
            work[U(row + ABOVE + k)] *= scale
            work[U(row + DX + k)] = (work[U(row + DX + k)] + below * work[U(row - RECORD + DX + k)]) * scale
            work[U(row + DY + k)] = (work[U(row + DY + k)] + below * work[U(row - RECORD + DY + k)]) * scale
            work[U(row + FAR + k)] = below * work[U(row - RECORD + FAR + k)] * scale
        if cyclic:
            for k in range(LANES):
                work[U(end + DX + k)] += work[U(over + k)] * work[U(row + DX + k)]
                work[U(end + DY + k)] += work[U(over + k)] * work[U(row + DY + k)]
                work[U(end + DIAGONAL + k)] -= work[U(over + k)] * work[U(row + FAR + k)]
                work[U(over + k)] *= work[U(row + ABOVE + k)]
    row = end - RECORD
    for k in range(LANES):
        below = work[U(end + BELOW + k)]
        left = (
            work[U(end + DIAGONAL + k)]
            - work[U(over + k)]
            - below * (work[U(row + ABOVE + k)] + work[U(row + FAR + k)])
        )
        work[U(end + DX + k)] = (work[U(end + DX + k)] + below * work[U(row + DX + k)]) / left
        work[U(end + DY + k)] = (work[U(end + DY + k)] + below * work[U(row + DY + k)]) / left
    for t in range(n - 1, 0, -1):
        row = t * RECORD
        for k in range(LANES):
            above, far = work[U(row + ABOVE + k)], work[U(row + FAR + k)]
            work[U(row + DX + k)] += above * work[U(row + RECORD + DX + k)] + far * work[U(end + DX + k)]
            work[U(row + DY + k)] += above * work[U(row + RECORD + DY + k)] + far * work[U(end + DY + k)]


@kernel
def count_folds(r, sign, counts, first, last):
    """Per row of cells, how many have no area of the given sign."""
    for i in range(first, last):
        x0, x1, y0, y1 = r[0, i], r[0, i + 1], r[1, i], r[1, i + 1]
        folds = 0
        for j in range(x0.size - 1):
            area = (x1[j + 1] - x0[j]) * (y0[j + 1] - y1[j]) - (y1[j + 1] - y0[j]) * (x0[j + 1] - x1[j])
            if not sign * area > 0:
                folds += 1
        counts[i] = folds


@kernel
def largest_moves(r, before, largest, first, last):
    """Per row, the largest square of a node's way since ``before``, in units of the shortest edge at the node."""
    for i in range(first, last):
        x0, x1, x2, y0, y1, y2 = r[0, i - 1], r[0, i], r[0, i + 1], r[1, i - 1], r[1, i], r[1, i + 1]
        bx, by = before[0, i], before[1, i]
        most = 0.0
        for j in range(1, x1.size - 1):
            edge = min(
                (x2[j] - x1[j]) ** 2 + (y2[j] - y1[j]) ** 2,
                (x1[j] - x0[j]) ** 2 + (y1[j] - y0[j]) ** 2,
                (x1[j + 1] - x1[j]) ** 2 + (y1[j + 1] - y1[j]) ** 2,
                (x1[j] - x1[j - 1]) ** 2 + (y1[j] - y1[j - 1]) ** 2,
            )
            way = ((x1[j] - bx[j]) ** 2 + (y1[j] - by[j]) ** 2) / (edge + TINY)
            most = max(most, way)
        largest[i] = most


@kernel
def wrap(r, shift):
    """Set the ghost rows of a grid that repeats along i, each time moved by ``shift``."""
    n = r.shape[1]
    for x in range(2):
        for j in range(r.shape[2]):
            r[x, 0, j] = r[x, n - 2, j] - shift[x]
            r[x, n - 1, j] = r[x, 1, j] + shift[x]
