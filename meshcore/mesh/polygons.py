"""Polygons in compressed rows: taken, turned, cut into fans, matched along edges, measured."""

from __future__ import annotations

import numpy as np

from . import _polygon_kernels as kernels


def taken(offsets: np.ndarray, nodes: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Offsets and nodes of some rows, in the order given.

    Examples
    --------
    >>> taken(np.array([0, 3, 7]), np.array([0, 1, 2, 3, 4, 5, 6]), np.array([1]))
    (array([0, 4]), array([3, 4, 5, 6]))
    """
    new = np.zeros(len(rows) + 1, np.int64)
    np.cumsum((offsets[1:] - offsets[:-1])[rows], out=new[1:])
    values = np.empty(new[-1], np.int64)
    kernels.take_rows(offsets, nodes, rows, new, values)
    return new, values


def numbered(nodes: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Which of ``count`` points are used, in the order in which they first appear, and the nodes by these numbers.

    Examples
    --------
    >>> numbered(np.array([5, 2, 5]), 7)
    (array([5, 2]), array([0, 1, 0]))
    """
    new, number, old = nodes.copy(), np.full(count, -1), np.empty(count, np.int64)
    used = kernels.number_by_appearance(new, number, old)
    return old[:used], new


def turned(offsets: np.ndarray, nodes: np.ndarray, which: np.ndarray) -> np.ndarray:
    """Nodes with the rows of ``which`` run through backwards, their first node kept.

    Examples
    --------
    >>> turned(np.array([0, 4]), np.array([5, 6, 7, 8]), np.array([True]))
    array([5, 8, 7, 6])
    """
    sizes = np.diff(offsets)
    place = np.arange(len(nodes)) - np.repeat(offsets[:-1], sizes)
    back = np.where(place > 0, np.repeat(sizes, sizes) - place, 0)
    return nodes[np.repeat(offsets[:-1], sizes) + np.where(np.repeat(which, sizes), back, place)]


def following(offsets: np.ndarray, values: np.ndarray) -> np.ndarray:
    """For each entry of each row the next one around.

    Examples
    --------
    >>> following(np.array([0, 3, 7]), np.array([0, 1, 2, 3, 4, 5, 6]))
    array([1, 2, 0, 4, 5, 6, 3])
    """
    after = np.append(values[1:], values[:1])
    full = offsets[1:] > offsets[:-1]
    after[offsets[1:][full] - 1] = values[offsets[:-1][full]]
    return after


def fans(offsets: np.ndarray, nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(t, 3) int: each polygon cut into triangles from its first node; and (t,) int: the polygon of each.

    Examples
    --------
    >>> fans(np.array([0, 4]), np.array([5, 6, 7, 8]))[0].tolist()
    [[5, 6, 7], [5, 7, 8]]
    """
    count = np.maximum(np.diff(offsets) - 2, 0)
    row = np.repeat(np.arange(len(count)), count)
    first = offsets[:-1][row]
    at = first + 1 + np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
    return np.column_stack([nodes[first], nodes[at], nodes[at + 1]]), row


def edges(offsets: np.ndarray, nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(k, 2) int: the edges of all polygons as each runs through them; and (k,) int: the polygon of each."""
    return np.column_stack([nodes, following(offsets, nodes)]), np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))


def _matched(offsets: np.ndarray, nodes: np.ndarray, n_points: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Edges, polygons, and for each edge whether the next one in the order of `edges` sorted is the same."""
    pairs, row = edges(offsets, nodes)
    key = pairs.min(axis=1) * n_points + pairs.max(axis=1)
    order = np.argsort(key, kind="stable")
    same = np.zeros(len(key), bool)
    same[:-1] = key[order][1:] == key[order][:-1]
    return pairs[order], row[order], same


def pairs_across_edges(offsets: np.ndarray, nodes: np.ndarray, n_points: int) -> np.ndarray:
    """(k, 2) int: polygons that share an edge, the smaller first; once for every edge that they share."""
    _, row, same = _matched(offsets, nodes, n_points)
    at = np.flatnonzero(same)
    return np.sort(np.column_stack([row[at], row[at + 1]]).reshape(-1, 2), axis=1)


def single_edges(offsets: np.ndarray, nodes: np.ndarray, n_points: int) -> tuple[np.ndarray, np.ndarray]:
    """(k, 2) int: the edges of one polygon only, as it runs through them; and (k,) int: that polygon."""
    pairs, row, same = _matched(offsets, nodes, n_points)
    single = ~(same | np.append(False, same)[:-1])
    order = np.argsort(row[single], kind="stable")
    return pairs[single][order], row[single][order]


def areas_and_centroids(
    points: np.ndarray, offsets: np.ndarray, nodes: np.ndarray, planar: bool
) -> tuple[np.ndarray, np.ndarray]:
    """(m,) areas, with sign if planar, and (m, 3) centres of mass of polygons; of those without area the mean."""
    area, centre = np.empty(len(offsets) - 1), np.empty((len(offsets) - 1, 3))
    kernels.polygon_moments(points, offsets, nodes, planar, area, centre)
    return area, centre


def volumes_and_centroids(
    points: np.ndarray,
    offsets: np.ndarray,
    nodes: np.ndarray,
    owner: np.ndarray,
    neighbour: np.ndarray,
    n_cells: int,
) -> tuple[np.ndarray, np.ndarray]:
    """(m,) volumes and (m, 3) centres of mass of polyhedra; of those without volume the mean of their corners."""
    start, volume, count = np.full(n_cells, -1), np.zeros(n_cells), np.zeros(n_cells)
    moment, mean = np.zeros((n_cells, 3)), np.zeros((n_cells, 3))
    kernels.polyhedron_moments(points, offsets, nodes, owner, neighbour, start, volume, moment, mean, count)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        centre = moment / (4 * volume)[:, None]
    good = np.isfinite(centre).all(axis=1) & (volume > 0)
    return volume, points[start] + np.where(good[:, None], centre, mean / count[:, None])
