"""Whether planar grids are sound, in exact arithmetic and by the plainest tests, with nothing of meshcore's own."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

_BOUND = 3.4e-16
"""Of the sum of the products' sizes: the largest error of a determinant of differences (Shewchuk 1997, section 4.3)."""


def orientations(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """(n,) int: 1 where (n, 2) points a, b, c turn left, -1 where right, 0 where they are in line, exactly."""
    left = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1])
    right = (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    found = np.sign(left - right).astype(int)
    for k in np.flatnonzero(np.abs(left - right) <= _BOUND * (np.abs(left) + np.abs(right))):
        (ax, ay), (bx, by), (cx, cy) = ([Fraction(float(v)) for v in p[k]] for p in (a, b, c))
        whole = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        found[k] = (whole > 0) - (whole < 0)
    return found


def folded(points: np.ndarray) -> np.ndarray:
    """(ni - 1, nj - 1) bool: cells of (ni, nj, 2) points with a corner that does not turn left."""
    corners = [points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]]
    flat = [corner.reshape(-1, 2) for corner in corners]
    bad = np.zeros(len(flat[0]), bool)
    for k in range(4):
        bad |= orientations(flat[k], flat[(k + 1) % 4], flat[k - 1]) <= 0
    return bad.reshape(corners[0].shape[:2])


def crossings(loop: np.ndarray) -> np.ndarray:
    """(m, 2) int: pairs of edges of a closed (n, 2) loop that cross or touch, neighbours left out unless they fold."""
    n = len(loop)
    after = np.roll(loop, -1, axis=0)
    low, high = np.minimum(loop, after), np.maximum(loop, after)
    i, j = np.triu_indices(n, 2)
    apart = ~((i == 0) & (j == n - 1))
    i, j = i[apart], j[apart]
    near = ((low[i] <= high[j]) & (low[j] <= high[i])).all(axis=1)
    i, j = i[near], j[near]
    one = orientations(loop[i], after[i], loop[j]) * orientations(loop[i], after[i], after[j]) <= 0
    other = orientations(loop[j], after[j], loop[i]) * orientations(loop[j], after[j], after[i]) <= 0
    pairs = np.column_stack([i, j])[one & other]
    turn = orientations(np.roll(loop, 1, axis=0), loop, after)
    back = ((after - loop) * (loop - np.roll(loop, 1, axis=0))).sum(axis=1) < 0
    spikes = np.flatnonzero((turn == 0) & back)
    return np.vstack([pairs, np.column_stack([(spikes - 1) % n, spikes])])
