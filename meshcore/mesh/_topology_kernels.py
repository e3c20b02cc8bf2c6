"""Kernels of topology: connected parts."""

import numpy as np

from .._numba import kernel

U = np.uint64


@kernel
def join(first, second, parent):
    """Join the trees of each pair; ``parent`` begins as 0, 1, 2, ... and ends as the least member of each part.

    Union-find with path halving (R. E. Tarjan, J. van Leeuwen, "Worst-case analysis of set union algorithms",
    J. ACM 31, 1984). The smaller number becomes the root, so that roots do not depend on the order of pairs.
    """
    for k in range(len(first)):
        a = first[U(k)]
        b = second[U(k)]
        while parent[U(a)] != a:
            parent[U(a)] = parent[U(parent[U(a)])]
            a = parent[U(a)]
        while parent[U(b)] != b:
            parent[U(b)] = parent[U(parent[U(b)])]
            b = parent[U(b)]
        parent[U(max(a, b))] = min(a, b)
    for a in range(len(parent)):  # parents are smaller, so theirs are known
        parent[U(a)] = parent[U(parent[U(a)])]
