"""Which faces of a planar graph are inside: closed loops nest by the even-odd rule."""

from __future__ import annotations

import numpy as np

from . import _nesting_kernels as kernels


def nesting_levels(edges: np.ndarray, sides: np.ndarray, n_vertices: int, n_faces: int) -> np.ndarray:
    """How many closed loops lie around each face, modulo two.

    Each block of the graph (edges that share cycles) counts as one loop. If all its vertices have an even number of its
    edges it is a closed curve, which may cross itself, and each edge is a step from outside to inside. If not, it is
    an outline with partitions: only its outer edges are steps, its inner edges part what is inside.

    Parameters
    ----------
    edges : (m, 2) or more int
        Ends of the edges, in the first two columns.
    sides : (2, m) int
        The faces on either side; face 0 is the outside.
    n_vertices, n_faces : int
        Numbers of vertices and faces.

    Returns
    -------
    (n_faces,) int
        0 outside and in holes, 1 inside.

    Examples
    --------
    A triangle within a triangle is a hole:

    >>> edges = np.array([[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3]])
    >>> nesting_levels(edges, np.array([[1, 1, 1, 2, 2, 2], [0, 0, 0, 1, 1, 1]]), 6, 3)
    array([0, 1, 0])
    """
    m = len(edges)
    of_vertex = np.empty((kernels.VERTEX_ROWS, n_vertices + 1), np.int64)
    path, block, both = np.empty(m, np.int64), np.empty(m, np.int64), np.empty(2 * m, np.int64)
    is_even = np.empty(m, bool)
    count = kernels.find_blocks(edges, of_vertex, both, path, block, is_even)
    start, around = np.empty(n_faces + 1, np.int64), np.empty(count, np.int64)
    queue, level = np.empty((2, n_faces), np.int64)
    kernels.set_levels(sides, block, is_even, start, both, around, queue, level)
    return level
