"""Between the levels of `winslow`: samples and averages of finer arrays, corrections from coarser ones.

Levels need not be nested: along each direction a table tells, for each node, its neighbours on the other level and
their weights (`winslow_levels.Table`). Arrays are (2, ni, nj) as in `_winslow_kernels`.
"""

import numpy as np

from ..._numba import kernel

U = np.uint64  # for subscripts, as in `_winslow_kernels`

HAT = 5  # nodes under the hat function of a coarse node


@kernel
def sample(fine, coarse, left_i, share_i, left_j, share_j):
    """Linear interpolation of a finer array at coarse nodes."""
    for x in range(2):
        for i in range(left_i.size):
            low, high = fine[x, left_i[i]], fine[x, left_i[i] + 1]
            a = share_i[i]
            for j in range(left_j.size):
                k = left_j[j]
                b = share_j[j]
                coarse[x, i, j] = a * (b * low[k] + (1 - b) * low[k + 1]) + (1 - a) * (
                    b * high[k] + (1 - b) * high[k + 1]
                )


@kernel
def average(fine, coarse, hat_i, weight_i, hat_j, weight_j, scale, row, first, last):
    """Means of a finer array under hat functions, times ``scale``, at the coarse nodes inside rows first to last."""
    for x in range(2):
        for i in range(first, last):
            row[:] = 0.0
            for k in range(HAT):
                if weight_i[i, k] != 0.0:
                    share, line = weight_i[i, k] * scale, fine[x, hat_i[i, k]]
                    for j in range(line.size):
                        row[j] += share * line[j]
            for j in range(1, coarse.shape[2] - 1):
                total = 0.0
                for k in range(HAT):
                    total += weight_j[j, k] * row[U(hat_j[j, k])]
                coarse[x, i, j] = total


@kernel
def correct(coarse, before, fine, left_i, share_i, left_j, share_j, step, row, first, last):
    """Add ``step`` times the linear interpolant of what changed on the coarser level, in rows first to last."""
    for x in range(2):
        for i in range(first, last):
            low, high = coarse[x, left_i[i]], coarse[x, left_i[i] + 1]
            low_before, high_before = before[x, left_i[i]], before[x, left_i[i] + 1]
            a = share_i[i]
            for j in range(low.size):
                row[j] = step * (a * (low[j] - low_before[j]) + (1 - a) * (high[j] - high_before[j]))
            target = fine[x, i]
            for j in range(1, target.size - 1):
                k = left_j[j]
                b = share_j[j]
                target[j] += b * row[U(k)] + (1 - b) * row[U(k + 1)]
