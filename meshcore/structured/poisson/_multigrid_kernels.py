"""Transfer between grids of any sizes along one direction, and sums over long vectors in a fixed order."""

from __future__ import annotations

import numpy as np

from ..._numba import kernel

U = np.uint64
CHUNK = 1 << 14
LANES = 64


@kernel
def combine(source, index, weight, factor, add, target, first, stop):
    """``target[o, k] = factor * sum_t weight[k, t] source[o, index[k, t]]``, or added to it, for o in first..stop.

    source (outer, n, inner) and target (outer, m, inner): the middle axis is the one along which is transferred.
    """
    m, taps = weight.shape
    inner = source.shape[2]
    for o in range(first, stop):
        for k in range(m):
            if inner == 1:
                total = 0.0
                for t in range(taps):
                    total += weight[U(k), U(t)] * source[U(o), U(index[U(k), U(t)]), U(0)]
                target[U(o), U(k), U(0)] = factor * total + (target[U(o), U(k), U(0)] if add else 0.0)
                continue
            if not add:
                target[U(o), U(k), :] = 0.0
            for t in range(taps):
                share = factor * weight[U(k), U(t)]
                if share != 0.0:
                    j = index[U(k), U(t)]
                    for i in range(inner):
                        target[U(o), U(k), U(i)] += share * source[U(o), U(j), U(i)]


@kernel
def remember(x, before, change, last, changes, steps, slot, first, stop):
    """How a step from ``before`` to x, and its result, differ from those of the step before it: kept in the slot.

    ``change`` and ``last`` hold the former step's change and result, and then this one's. In chunks first..stop.
    """
    for i in range(first * CHUNK, min(stop * CHUNK, len(x))):
        k = U(i)
        new = x[k] - before[k]
        changes[U(slot), k] = new - change[k]
        steps[U(slot), k] = x[k] - last[k]
        change[k] = new
        last[k] = x[k]


@kernel
def products(changes, count, slot, change, lanes, sums, first, stop):
    """``sums[k]``: products of each of ``count`` remembered changes with that in the slot, and then with ``change``.

    Over chunk k alone, and in `LANES` parts: so machine code adds several numbers at once, always in the same order.
    """
    n = len(change)
    for k in range(first, stop):
        end = min((k + 1) * CHUNK, n)
        for h in range(count):
            lanes[:] = 0.0
            for i in range(k * CHUNK, end, LANES):
                for t in range(min(LANES, end - i)):
                    lanes[0, U(t)] += changes[U(h), U(i) + U(t)] * changes[U(slot), U(i) + U(t)]
                    lanes[1, U(t)] += changes[U(h), U(i) + U(t)] * change[U(i) + U(t)]
            for half in range(2):
                total = 0.0
                for t in range(LANES):
                    total += lanes[U(half), U(t)]
                sums[k, half, h] = total


@kernel
def subtract(x, steps, factors, first, stop):
    """``x -= factors @ steps`` in the chunks first..stop."""
    n = len(x)
    for k in range(first, stop):
        for h in range(len(factors)):
            factor = factors[U(h)]
            for i in range(k * CHUNK, min((k + 1) * CHUNK, n)):
                x[U(i)] -= factor * steps[U(h), U(i)]
