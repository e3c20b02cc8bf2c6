"""Planar straight-line graphs: line cells made clean enough to be triangulated."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..errors import InvalidGeometry
from ..geometry import predicates
from ..mesh import topology

# Shares of the largest coordinate; a double's own rounding is 1.1e-16 of it. Points nearer than the first are one; a
# point nearer to a segment than the second lies on it. The first is larger, so that a walk along a segment from
# one point on it to the next makes headway.
SAME_POINT = 2.0**-47
ON_SEGMENT = 2.0**-49
# Beyond these, areas and products of them would over- or underflow.
_LARGEST, _SMALLEST = 1e75, 1e-75
# A share of the largest coordinate that counts as zero: exact arithmetic over more than that would be slow.
_NOTHING = 2.0**-200


@dataclass
class PlanarGraph:
    """Different points and different segments between them.

    Attributes
    ----------
    points : (n, 2) float
        Coordinates.
    source : (n,) int
        Number of the input point that each is; -1 for a crossing that was added.
    segments : (m, 2) int
        Ends of the segments; they may still touch, overlap and cross.
    line : (m,) int
        Number of the input line that each is part of.
    warnings : list of str
        What was repaired.
    """

    points: np.ndarray
    source: np.ndarray
    segments: np.ndarray
    line: np.ndarray
    warnings: list[str] = field(default_factory=list)


def planar_graph(points: np.ndarray, lines: np.ndarray, vertices: np.ndarray, parameter: str) -> PlanarGraph:
    """The graph of line cells: equal points merged, empty and repeated lines dropped.

    Parameters
    ----------
    points : (n, 2) float
        Coordinates.
    lines : (m, 2) int
        Ends of the line cells.
    vertices : (k,) int
        Points to keep although no line may use them.
    parameter : str
        Name of the input, for messages.
    """
    if not len(lines):
        raise InvalidGeometry("has no line cells; give closed loops of lines", parameter=parameter)
    used = np.unique(np.concatenate([lines.ravel(), vertices]))
    largest = float(np.abs(points[used]).max())
    if not (_SMALLEST < largest < _LARGEST or largest == 0):
        raise InvalidGeometry(
            f"has coordinates up to {largest:.3g}; scale them to between {_SMALLEST:g} and {_LARGEST:g}",
            parameter=parameter,
        )
    same = _merged(points[used])
    source = used[np.unique(same)]  # the first of each group
    number = np.searchsorted(source, used[same])
    at = np.full(len(points), -1)
    at[used] = number
    segments = at[lines]
    warnings = []
    if len(source) < len(used):
        warnings.append(f"{len(used) - len(source)} points at the place of others were merged with them")
    real = np.flatnonzero(segments[:, 0] != segments[:, 1])
    if len(real) < len(segments):
        warnings.append(f"{len(segments) - len(real)} lines without length were dropped")
    segments = segments[real]
    _, first = np.unique(np.sort(segments, axis=1), axis=0, return_index=True)
    first = np.sort(first)
    if len(first) < len(segments):
        warnings.append(f"{len(segments) - len(first)} lines that repeat others were dropped")
    if not len(first):
        raise InvalidGeometry("has only lines without length", parameter=parameter, cells=range(len(lines)))
    clean = np.where(np.abs(points[source]) < _NOTHING * largest, 0.0, points[source])
    return PlanarGraph(clean, source, segments[first], real[first], warnings)


def _merged(points: np.ndarray) -> np.ndarray:
    """(n,) int: for each point the first point of the group of points at its place."""
    distance = SAME_POINT * float(np.abs(points).max())
    if not distance:
        return np.zeros(len(points), int)
    pairs = []
    # Two points that near each other lie in one cell of at least one of four grids, shifted by half a cell.
    for shift in np.ndindex(2, 2):
        cell = np.floor(points / (2 * distance) + 0.5 * np.array(shift))
        order = np.lexsort(cell.T)
        together = (cell[order][1:] == cell[order][:-1]).all(axis=1)
        pairs.append(np.column_stack([order[:-1], order[1:]])[together])
    pairs = np.concatenate(pairs)
    near = np.linalg.norm((points[pairs[:, 0]] - points[pairs[:, 1]]) / distance, axis=1) <= 1
    group = topology.connected(pairs[near], len(points))
    first = np.unique(group, return_index=True)[1]
    return first[group]


def crossing_pairs(graph: PlanarGraph, failed: np.ndarray) -> np.ndarray:
    """(k, 2) int: pairs of segments that cross inside both, each with one of ``failed``."""
    low = graph.points[graph.segments].min(axis=1)
    high = graph.points[graph.segments].max(axis=1)
    pairs = []
    for s in failed:
        near = np.flatnonzero(((low <= high[s]) & (high >= low[s])).all(axis=1))
        a, b = graph.points[graph.segments[s]]
        c, d = graph.points[graph.segments[near, 0]], graph.points[graph.segments[near, 1]]
        apart = predicates.orient2d(a, b, c) * predicates.orient2d(a, b, d)
        across = predicates.orient2d(c, d, a) * predicates.orient2d(c, d, b)
        pairs += [(min(s, t), max(s, t)) for t in near[(apart < 0) & (across < 0)]]
    return np.unique(np.array(pairs, np.int64).reshape(-1, 2), axis=0)


def crossing_points(graph: PlanarGraph, pairs: np.ndarray) -> np.ndarray:
    """(k, 2) float: where pairs of segments cross."""
    (a, b), (c, d) = (graph.points[graph.segments[pairs[:, k]]].transpose(1, 0, 2) for k in (0, 1))
    along, other = b - a, d - c
    denominator = along[:, 0] * other[:, 1] - along[:, 1] * other[:, 0]
    share = ((c - a)[:, 0] * other[:, 1] - (c - a)[:, 1] * other[:, 0]) / denominator
    return a + np.clip(share, 0, 1)[:, None] * along


def split_at_crossings(graph: PlanarGraph, pairs: np.ndarray) -> PlanarGraph:
    """The graph with a point where each pair of segments crosses, and both split there."""
    where = crossing_points(graph, pairs)
    n = len(graph.points)
    added = n + np.arange(len(pairs))
    points = np.concatenate([graph.points, where])
    same = _merged(points)
    owner = np.concatenate([pairs[:, 0], pairs[:, 1]])
    stop = np.concatenate([added, added])
    start = graph.points[graph.segments[owner, 0]]
    order = np.lexsort((np.linalg.norm(points[stop] - start, axis=1), owner))
    owner, stop = owner[order], stop[order]
    parts, line = [], []
    for s in np.unique(owner):
        chain = np.concatenate([graph.segments[s, :1], stop[owner == s], graph.segments[s, 1:]])
        parts.append(np.column_stack([chain[:-1], chain[1:]]))
        line.append(np.full(len(chain) - 1, graph.line[s]))
    whole = np.setdiff1d(np.arange(len(graph.segments)), owner)
    segments = same[np.concatenate([graph.segments[whole], *parts])]
    line = np.concatenate([graph.line[whole], *line])
    keep = np.unique(same)
    source = np.concatenate([graph.source, np.full(len(pairs), -1)])[keep]
    segments = np.searchsorted(keep, segments)
    real = segments[:, 0] != segments[:, 1]
    segments, line = segments[real], line[real]
    _, first = np.unique(np.sort(segments, axis=1), axis=0, return_index=True)
    first = np.sort(first)
    return PlanarGraph(points[keep], source, segments[first], line[first], graph.warnings)
