"""Anderson mixing of the cycles of `winslow`: differences, inner products and combinations of long vectors.

Sums run over blocks of a fixed length and, in each, in `LANES` parts, which machine code adds at once: always in the
same order, however threads share the work.
"""

import numpy as np

from .._numba import kernel

U = np.uint64  # for subscripts, as in `_winslow_kernels`
BLOCK = 4096
LANES = 8


@kernel
def remember(r, before, step, result, steps, results, slot, first, last):
    """Keep how a cycle's step (its result less its start) and result differ from those of the last cycle, in blocks."""
    kept_step, kept_result = steps[slot], results[slot]
    for i in range(first * BLOCK, min(last * BLOCK, r.size)):
        k = U(i)
        new = r[k] - before[k]
        kept_step[k] = new - step[k]
        kept_result[k] = r[k] - result[k]
        step[k] = new
        result[k] = r[k]


@kernel
def inner(a, b, start, stop, lanes):
    """Inner product of a part of two vectors."""
    for lane in range(LANES):
        lanes[lane] = 0.0
    whole = start + (stop - start) // LANES * LANES
    for i in range(start, whole, LANES):
        for lane in range(LANES):
            lanes[lane] += a[U(i + lane)] * b[U(i + lane)]
    total = 0.0
    for lane in range(LANES):
        total += lanes[lane]
    for i in range(whole, stop):
        total += a[U(i)] * b[U(i)]
    return total


@kernel
def products(steps, step, slot, lanes, sums, first, last):
    """Per block, the inner products of each remembered difference with that in ``slot``, and with ``step``."""
    m = steps.shape[0]
    for block in range(first, last):
        start, stop = block * BLOCK, min((block + 1) * BLOCK, step.size)
        for p in range(m):
            sums[block, p] = inner(steps[p], steps[slot], start, stop, lanes)
            sums[block, m + p] = inner(steps[p], step, start, stop, lanes)


@kernel
def mix(r, before, results, share, first, last):
    """Take ``share`` of each remembered difference of results off a cycle's result, and note where the next starts."""
    for block in range(first, last):
        start, stop = block * BLOCK, min((block + 1) * BLOCK, r.size)
        for p in range(share.size):
            if share[p] != 0.0:
                part, kept = share[p], results[p]
                for k in range(start, stop):
                    r[U(k)] -= part * kept[U(k)]
        for k in range(start, stop):
            before[U(k)] = r[U(k)]
