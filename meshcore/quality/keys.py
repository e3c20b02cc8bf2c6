"""Integer keys of edges, facets, cells and points, so that a sort of whole numbers finds what is there twice."""

from __future__ import annotations

import numpy as np

from ..mesh import CELL_TYPES, Mesh
from . import _edge_kernels as kernels


def directed_edges(mesh: Mesh) -> np.ndarray:
    """(k,) int64, sorted: ``2 (n smaller + larger) + turned`` for each edge of each cell of dimension 2.

    `turned` is 1 where the cell runs from the larger point to the smaller.

    Examples
    --------
    >>> mesh = Mesh([[0, 0], [1, 0], [0, 1]], {"triangle": [[0, 1, 2]]})
    >>> [(key // 2 // 3, key // 2 % 3, key % 2) for key in directed_edges(mesh).tolist()]
    [(0, 1, 0), (0, 2, 1), (1, 2, 0)]
    """
    n = mesh.n_points
    flat = [(c, len(CELL_TYPES[kind].edges)) for kind, c in mesh.cells.items() if CELL_TYPES[kind].dimension == 2]
    start = np.zeros(n + 1, np.int64)
    for cells, corners in flat:
        kernels.count_edges(cells, corners, start)
    np.cumsum(start, out=start)
    keys = np.empty(start[-1], np.int64)
    place = start[:-1].copy()
    for cells, corners in flat:
        kernels.fill_edges(cells, corners, n, place, keys)
    long_rows = np.empty(len(keys) // kernels.SHORT, np.int64)
    for v in long_rows[: kernels.sort_rows(start, keys, long_rows)]:
        keys[start[v] : start[v + 1]].sort()
    return keys


def directed_faces(mesh: Mesh) -> np.ndarray:
    """(k,) uint64, sorted: a hash of the nodes of each face of each solid cell, and the sense of turning as last bit.

    Two different faces may share a key, once in 10^19 pairs: a finding needs to be looked at, none is missed.
    """
    parts = []
    for kind, cells in mesh.cells.items():
        if CELL_TYPES[kind].dimension == 3:
            nodes = np.ascontiguousarray(cells.T)
            for local in CELL_TYPES[kind].facets:
                face = nodes[list(local)]
                columns = np.arange(face.shape[1])
                first = face.argmin(axis=0)
                after, before = (face[(first + step) % len(face), columns] for step in (1, -1))
                key = hashed(np.sort(face, axis=0)) if len(face) == 3 else _quad_key(face, first, after, before)
                parts.append((key << np.uint64(1)) | (after > before).astype(np.uint64))
    return np.sort(np.concatenate(parts)) if parts else np.empty(0, np.uint64)


def _quad_key(face: np.ndarray, first: np.ndarray, after: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Hash of the nodes of quadrilaterals in cyclic order, so that a twisted neighbour does not match."""
    columns = np.arange(face.shape[1])
    opposite = face[(first + 2) % 4, columns]
    return hashed(np.stack([face[first, columns], np.minimum(after, before), opposite, np.maximum(after, before)]))


def cell_keys(cells: np.ndarray) -> np.ndarray:
    """(m,) uint64: a hash of each cell's set of nodes."""
    return hashed(np.sort(np.ascontiguousarray(cells.T), axis=0))


def point_keys(points: np.ndarray) -> np.ndarray:
    """(n,) uint64: a hash of each point's coordinates; 0.0 and -0.0 are the same."""
    return hashed(np.ascontiguousarray((points + 0.0).T).view(np.uint64))


def hashed(rows: np.ndarray) -> np.ndarray:
    """(m,) uint64: one number for each column of a (k, m) integer array.

    The mixing step is the finalizer of MurmurHash3 (A. Appleby, public domain).

    Examples
    --------
    >>> a, b, c = hashed(np.array([[1, 1, 2], [2, 2, 1]])).tolist()
    >>> a == b, a == c
    (True, False)
    """
    value = np.zeros(rows.shape[1], np.uint64)
    for row in rows.astype(np.uint64, copy=False):
        value = (value ^ row) * np.uint64(0x9E3779B97F4A7C15)
        for shift, factor in ((33, 0xFF51AFD7ED558CCD), (33, 0xC4CEB9FE1A85EC53)):
            value ^= value >> np.uint64(shift)
            value *= np.uint64(factor)
        value ^= value >> np.uint64(33)
    return value


def repeats(keys: np.ndarray) -> np.ndarray:
    """(m,) bool: whether a key stands more than once; False throughout costs one sort only.

    Examples
    --------
    >>> repeats(np.array([3, 1, 3]))
    array([ True, False,  True])
    """
    ordered = np.sort(keys)
    again = ordered[1:][ordered[1:] == ordered[:-1]]
    return np.isin(keys, again) if len(again) else np.zeros(len(keys), bool)
