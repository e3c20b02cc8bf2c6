"""Transfer between grids of any sizes along one direction, and sums over long vectors in a fixed order."""

from __future__ import annotations

import numpy as np

from .._numba import kernel

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
def products(change, history, count, first, stop, sums):
    """``sums[k, h]``: product of chunk k of ``change`` with that of each of the first ``count`` vectors.

    Summed in `LANES` parts, so that machine code adds several numbers at once and still always in the same order.
    """
    n = len(change)
    lanes = np.zeros(LANES)
    for k in range(first, stop):
        for h in range(count):
            lanes[:] = 0.0
            end = min((k + 1) * CHUNK, n)
            for i in range(k * CHUNK, end, LANES):
                for t in range(min(LANES, end - i)):
                    lanes[U(t)] += change[U(i) + U(t)] * history[U(h), U(i) + U(t)]
            sums[k, h] = lanes.sum()


@kernel
def subtract(x, history, factors, first, stop):
    """``x -= factors @ history`` in the chunks first..stop."""
    n = len(x)
    for k in range(first, stop):
        for h in range(len(factors)):
            factor = factors[h]
            for i in range(k * CHUNK, min((k + 1) * CHUNK, n)):
                x[U(i)] -= factor * history[U(h), U(i)]
