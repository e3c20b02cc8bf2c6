"""Newest-vertex bisection of triangles: labels, closure, cutting.

Node 0 of a triangle is its newest vertex, the edge opposite is the one that is cut next::

          0                     0
         / \\                   /|\\          the halves are (m, 0, 1) and (m, 2, 0): m is their newest
        /   \\       ->        / | \\         vertex, and each is cut next through one of the old sides
       1-----2               1--m--2

Edge i of a triangle is the one opposite its node i. Orientation is kept.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..mesh.topology import edge_keys

OPPOSITE = np.array([[1, 2], [2, 0], [0, 1]])
"""Nodes of edge i."""


class Edges(NamedTuple):
    """The edges of triangles.

    Attributes
    ----------
    keys : (k,) int
        ``n_points * smaller + larger`` of each edge, sorted.
    of_triangle : (m, 3) int
        Edge opposite each node.
    triangles : (3 m,) int
        Triangles sorted by edge.
    starts : (k + 1,) int
        Where the triangles of each edge begin.
    """

    keys: np.ndarray
    of_triangle: np.ndarray
    triangles: np.ndarray
    starts: np.ndarray


def edges_of(triangles: np.ndarray, n_points: int) -> Edges:
    """The edges of (m, 3) triangles.

    Examples
    --------
    >>> edges_of(np.array([[0, 1, 2], [0, 2, 3]]), 4).of_triangle
    array([[3, 1, 0],
           [4, 2, 1]])
    """
    keys = edge_keys(triangles[:, OPPOSITE], n_points).ravel()
    order = np.argsort(keys)
    in_order = keys[order]
    new = np.concatenate([[True], in_order[1:] != in_order[:-1]])
    of_triangle = np.empty_like(order)
    of_triangle[order] = np.cumsum(new) - 1
    starts = np.append(np.flatnonzero(new), len(order))
    return Edges(in_order[new], of_triangle.reshape(-1, 3), order // 3, starts)


def ragged(starts: np.ndarray, stops: np.ndarray) -> np.ndarray:
    """All numbers of several ranges, one range after the other.

    Examples
    --------
    >>> ragged(np.array([3, 7]), np.array([5, 8]))
    array([3, 4, 7])
    """
    counts = stops - starts
    before = np.cumsum(counts) - counts
    return np.arange(counts.sum()) + np.repeat(starts - before, counts)


def longest_edge_first(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(m, 3) int: triangles turned so that node 0 lies opposite their longest edge.

    Among equally long ones the edge with the smallest point numbers is taken, so that neighbours agree.
    """
    sides = scaled_sides(points, triangles)
    length = np.einsum("mij,mij->mi", sides, sides)
    keys = edge_keys(triangles[:, OPPOSITE], len(points))
    keys[length < length.max(axis=1, keepdims=True)] = np.iinfo(np.int64).max
    first = keys.argmin(axis=1)
    return np.take_along_axis(triangles, (first[:, None] + np.arange(3)) % 3, axis=1)


def scaled_sides(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(m, 3, 3) float: the side opposite each node as a vector, the largest component of each triangle being 1."""
    corners = points[triangles]
    sides = np.roll(corners, 1, axis=1) - np.roll(corners, -1, axis=1)
    largest = np.abs(sides).max(axis=(1, 2), keepdims=True)
    return sides / np.where(largest > 0, largest, 1.0)


def closed(cut: np.ndarray, edges: Edges) -> np.ndarray:
    """(k,) bool: edges to cut so that no node hangs: a triangle that is cut at all is cut at its edge 0.

    Each round looks only at the triangles of the edges added by the last, and ends since edges are finite.
    """
    cut = cut.copy()
    added = np.flatnonzero(cut)
    while len(added):
        touched = edges.triangles[ragged(edges.starts[added], edges.starts[added + 1])]
        first = edges.of_triangle[touched, 0]
        added = np.unique(first[~cut[first]])
        cut[added] = True
    return cut


class Parts(NamedTuple):
    """Cells cut into parts, which stand together in the order of their parents.

    Attributes
    ----------
    nodes : (k, 2) or (k, 3) int
        Nodes of each part.
    parents : (k,) int
        Cell that it is part of.
    cuts : (k,) int
        How often that was halved on the way to it.
    """

    nodes: np.ndarray
    parents: np.ndarray
    cuts: np.ndarray


def bisected(triangles: np.ndarray, middles: np.ndarray) -> Parts:
    """Cut triangles at the given middles of their edges, into two, three or four.

    Parameters
    ----------
    triangles : (m, 3) int
        Newest vertex first.
    middles : (m, 3) int
        Point in the middle of each edge that is cut, else -1; where one is cut, edge 0 is.

    Returns
    -------
    Parts
        Newest vertex first.

    Examples
    --------
    >>> bisected(np.array([[0, 1, 2]]), np.array([[4, -1, 3]])).nodes
    array([[3, 4, 0],
           [3, 1, 4],
           [4, 2, 0]])
    """
    parents, cuts = np.arange(len(triangles)), np.zeros(len(triangles), np.int64)
    for _ in range(2):  # the halves' own cuts are through old sides: two rounds do
        cut = middles[:, 0] >= 0
        (p0, p1, p2), (m0, m1, m2) = triangles[cut].T, middles[cut].T
        none = np.full_like(m0, -1)
        counts = 1 + cut
        left = (np.cumsum(counts) - counts)[cut]
        triangles, middles, parents, cuts = (np.repeat(a, counts, axis=0) for a in (triangles, middles, parents, cuts))
        triangles[left], middles[left] = np.column_stack([m0, p0, p1]), np.column_stack([m2, none, none])
        triangles[left + 1], middles[left + 1] = np.column_stack([m0, p2, p0]), np.column_stack([m1, none, none])
        cuts[left] += 1
        cuts[left + 1] += 1
    return Parts(triangles, parents, cuts)


def halved(lines: np.ndarray, middles: np.ndarray) -> Parts:
    """Cut (k, 2) lines at their (k,) middles, where these are not -1; directions are kept.

    Examples
    --------
    >>> halved(np.array([[0, 1], [1, 2]]), np.array([-1, 3])).nodes
    array([[0, 1],
           [1, 3],
           [3, 2]])
    """
    cut = middles >= 0
    parents = np.repeat(np.arange(len(lines)), 1 + cut)
    second = np.flatnonzero(parents[1:] == parents[:-1]) + 1
    halves = lines[parents]
    halves[second - 1, 1] = halves[second, 0] = middles[cut]
    return Parts(halves, parents, cut.astype(np.int64)[parents])
