"""Topology derived from cells: edges, facets, neighbours, boundary, orientation."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ._topology_kernels import join
from .cells import CELL_TYPES

if TYPE_CHECKING:
    from .mesh import Mesh

_FACET_KIND = {1: "vertex", 2: "line", 3: "triangle", 4: "quad"}


class Facets(NamedTuple):
    """Facets of the cells of highest dimension, each once.

    Attributes
    ----------
    nodes : (k, 4) int
        Nodes as the first cell sees them, outward; -1 fills the rows of facets with fewer nodes.
    owner : (k,) int
        Number of the first cell.
    neighbour : (k,) int
        Number of the other cell; -1 on the boundary.
    shared : (k,) int
        How many cells have the facet; more than 2 means the mesh is not a manifold.
    """

    nodes: np.ndarray
    owner: np.ndarray
    neighbour: np.ndarray
    shared: np.ndarray


def edges(mesh: Mesh) -> np.ndarray:
    """(k, 2) int: each edge of all cells once, smaller point first, sorted."""
    parts = [
        cells[:, np.array(CELL_TYPES[kind].edges, int)].reshape(-1, 2)
        for kind, cells in mesh.cells.items()
        if CELL_TYPES[kind].edges
    ]
    if not parts:
        return np.empty((0, 2), np.int64)
    pairs = np.sort(np.concatenate(parts), axis=1)
    n = mesh.n_points
    key = distinct(pairs[:, 0] * n + pairs[:, 1])  # one number a pair sorts ten times faster than rows
    return np.column_stack([key // n, key % n])


def distinct(values: np.ndarray) -> np.ndarray:
    """(k,) sorted values without repeats; `numpy.unique` hashes them first, which is slower where most differ.

    Examples
    --------
    >>> distinct(np.array([3, 1, 3]))
    array([1, 3])
    """
    ordered = np.sort(values)
    first = np.ones(len(ordered), bool)
    np.not_equal(ordered[1:], ordered[:-1], out=first[1:])
    return ordered[first]


def edge_keys(nodes: np.ndarray, n_points: int) -> np.ndarray:
    """(...) int: one whole number for each pair of points (..., 2), whatever its direction.

    Examples
    --------
    >>> edge_keys(np.array([[0, 2], [2, 0], [1, 2]]), 3).tolist()
    [2, 2, 5]
    """
    a, b = nodes[..., 0], nodes[..., 1]
    return np.minimum(a, b) * n_points + np.maximum(a, b)


def facets(mesh: Mesh) -> Facets:
    """Facets of the cells of highest dimension, matched by their sorted nodes."""
    nodes, owner = _all_facets(mesh)
    if not len(nodes):
        none = np.empty(0, np.int64)
        return Facets(np.empty((0, 4), np.int64), none, none, none)
    key = _packed(np.sort(nodes, axis=1), mesh.n_points)
    order = np.lexsort(key.T)  # stable, so that of the cells that share a facet the first one owns it
    key = key[order]
    first = np.concatenate([[True], (key[1:] != key[:-1]).any(axis=1)])
    starts = np.flatnonzero(first)
    shared = np.diff(np.append(starts, len(key)))
    second = order[np.minimum(starts + 1, len(order) - 1)]
    neighbour = np.where(shared > 1, owner[second], -1)
    return Facets(nodes[order[starts]], owner[order[starts]], neighbour, shared)


def boundary(mesh: Mesh) -> Mesh:
    """Mesh of the facets that belong to one cell only, on the points of ``mesh``."""
    found = mesh.facets
    outer = found.shared == 1
    return facet_mesh(mesh, found.nodes[outer], {"cell": found.owner[outer]})


def facet_mesh(mesh: Mesh, nodes: np.ndarray, data: dict[str, np.ndarray]) -> Mesh:
    """Facets given as (k, 4) rows padded by -1, as a mesh on the points of ``mesh``; ``data`` are per facet."""
    from .mesh import Mesh

    count = (nodes >= 0).sum(axis=1)
    cells, order = {}, []
    for n in np.unique(count):
        rows = np.flatnonzero(count == n)
        cells[_FACET_KIND[int(n)]] = nodes[rows, :n]
        order.append(rows)
    order = np.concatenate(order) if order else np.empty(0, np.int64)
    cell_data = {name: np.asarray(values)[order] for name, values in data.items()}
    return Mesh(mesh.points, cells, point_data=mesh.point_data, cell_data=cell_data)


def turned(kind: str, cells: np.ndarray, flip: np.ndarray) -> np.ndarray:
    """``cells`` with those of ``flip`` given the opposite orientation."""
    order = {
        "line": (1, 0),
        "triangle": (0, 2, 1),
        "quad": (0, 3, 2, 1),
        "tetra": (0, 2, 1, 3),
        "hexahedron": (0, 3, 2, 1, 4, 7, 6, 5),
        "wedge": (0, 2, 1, 3, 5, 4),
        "pyramid": (0, 3, 2, 1, 4),
        "line3": (1, 0, 2),
        "triangle6": (0, 2, 1, 5, 4, 3),
        "quad8": (0, 3, 2, 1, 7, 6, 5, 4),
        "quad9": (0, 3, 2, 1, 7, 6, 5, 4, 8),
        "tetra10": (0, 2, 1, 3, 6, 5, 4, 7, 9, 8),
    }.get(kind)
    if order is None or not flip.any():
        return cells
    return np.where(flip[:, None], cells[:, order], cells)


def connected(pairs: np.ndarray, count: int) -> np.ndarray:
    """(count,) int: number of the connected part that each of ``count`` things belongs to, by first members.

    Parameters
    ----------
    pairs : (k, 2) int
        Things that are connected.
    count : int
        How many things there are.

    Examples
    --------
    >>> connected(np.array([[0, 2], [2, 3]]), 5).tolist()
    [0, 1, 0, 0, 2]
    """
    first, second = np.ascontiguousarray(np.asarray(pairs, np.int64).reshape(-1, 2).T)
    root = np.arange(count)
    join(first, second, root)
    return (np.cumsum(root == np.arange(count)) - 1)[root]


def _packed(nodes: np.ndarray, n_points: int) -> np.ndarray:
    """(k, 4) sorted nodes as (k, 1) or (k, 2) numbers, two nodes in each; -1 pads."""
    n = n_points + 1
    low, high = nodes[:, 0] * n + nodes[:, 1], nodes[:, 2] * n + nodes[:, 3]
    return high[:, None] if (low == low[0]).all() else np.column_stack([low, high])


def _all_facets(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Every facet of every cell of highest dimension, as (k, 4) nodes padded by -1, and its cell."""
    dimension = mesh.dimension
    nodes, owner = [], []
    for kind, cells, where in mesh.blocks():
        if CELL_TYPES[kind].dimension != dimension:
            continue
        for local in CELL_TYPES[kind].facets:
            rows = np.full((len(cells), 4), -1, np.int64)
            rows[:, : len(local)] = cells[:, local]
            nodes.append(rows)
            owner.append(np.arange(where.start, where.stop))
    if not nodes:
        return np.empty((0, 4), np.int64), np.empty(0, np.int64)
    return np.concatenate(nodes), np.concatenate(owner)
