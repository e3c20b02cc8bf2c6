"""Anderson mixing of the cycles of `winslow`: differences, inner products and combinations of long vectors.

Sums run over blocks of a fixed length, so that they do not depend on how threads share the work.
"""

from .._numba import kernel

BLOCK = 4096


@kernel
def remember(r, before, step, result, steps, results, slot, first, last):
    """Keep how a cycle's step (its result less its start) and result differ from those of the last cycle, in blocks."""
    for k in range(first * BLOCK, min(last * BLOCK, r.size)):
        new = r[k] - before[k]
        steps[slot, k] = new - step[k]
        results[slot, k] = r[k] - result[k]
        step[k] = new
        result[k] = r[k]


@kernel
def products(steps, step, slot, sums, first, last):
    """Per block, the inner products of each remembered difference with that in ``slot``, and with ``step``."""
    m = steps.shape[0]
    for block in range(first, last):
        stop = min((block + 1) * BLOCK, step.size)
        for p in range(m):
            with_slot = with_step = 0.0
            for k in range(block * BLOCK, stop):
                with_slot += steps[p, k] * steps[slot, k]
                with_step += steps[p, k] * step[k]
            sums[block, p] = with_slot
            sums[block, m + p] = with_step


@kernel
def mix(r, before, results, share, first, last):
    """Take ``share`` of each remembered difference of results off a cycle's result, and note where the next starts."""
    for block in range(first, last):
        stop = min((block + 1) * BLOCK, r.size)
        for p in range(share.size):
            if share[p] != 0.0:
                for k in range(block * BLOCK, stop):
                    r[k] -= share[p] * results[p, k]
        for k in range(block * BLOCK, stop):
            before[k] = r[k]
