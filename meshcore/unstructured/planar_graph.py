"""Planar straight-line graphs: line cells made clean enough to be triangulated."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ..errors import InvalidGeometry
from ..mesh import topology
from . import _planar_graph_kernels as kernels

# Shares of the largest coordinate; a double's own rounding is 1.1e-16 of it. Points nearer than the first are one; a
# point nearer to a segment than the second lies on it. The first is larger, so that a walk along a segment from
# one point on it to the next makes headway.
SAME_POINT = 2.0**-47
ON_SEGMENT = 2.0**-49
# Beyond these, areas and products of them would over- or underflow.
_LARGEST, _SMALLEST = 1e75, 1e-75
# A share of the largest coordinate that counts as zero: exact arithmetic over more than that would be slow.
NOTHING = 2.0**-200
# A direction along which hardly two points of a drawing agree, and the one across it.
_SKEW, _ACROSS = (0.7653668647, 0.6435942529), np.array([-0.6435942529, 0.7653668647])


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


def planar_graph(
    points: np.ndarray, lines: np.ndarray, used: np.ndarray, parameter: str, *, may_lack_lines: bool = False
) -> PlanarGraph:
    """The graph of line cells: equal points merged, empty and repeated lines dropped.

    Parameters
    ----------
    points : (n, 2) float
        Coordinates.
    lines : (m, 2) int
        Ends of the line cells.
    used : (k,) int
        Points to keep, ascending, those of the lines among them.
    parameter : str
        Name of the input, for messages.
    may_lack_lines : bool
        Whether points alone will do.
    """
    if not len(lines) and not (may_lack_lines and len(used)):
        raise InvalidGeometry("has no line cells; give closed loops of lines", parameter=parameter)
    clean = points.take(used, axis=0)
    same, largest = _merged(clean)
    if not (_SMALLEST < largest < _LARGEST or largest == 0):
        raise InvalidGeometry(
            f"has coordinates up to {largest:.3g}; scale them to between {_SMALLEST:g} and {_LARGEST:g}",
            parameter=parameter,
        )
    warnings = []
    number = np.arange(len(used))
    source = used
    if same is not None:
        is_first = same == number
        number = (np.cumsum(is_first) - 1)[same]
        source, clean = used[is_first], clean[is_first]
        warnings.append(f"{len(used) - len(source)} points at the place of others were merged with them")
    at = np.empty(len(points), np.int64)
    at[used] = number
    segments = np.empty((len(lines), 2), np.int64)
    real, keys = np.empty((2, len(lines)), np.int64)
    count = kernels.number_lines(lines, at, len(source), segments, real, keys)
    if count < len(lines):
        warnings.append(f"{len(lines) - count} lines without length were dropped")
        if not count:
            raise InvalidGeometry("has only lines without length", parameter=parameter, cells=range(len(lines)))
        segments, real, keys = segments[:count], real[:count], keys[:count]
    first = _first_of_each(keys)
    if first is not None:
        warnings.append(f"{count - len(first)} lines that repeat others were dropped")
        segments, real = segments[first], real[first]
    kernels.clear_tiny(clean, NOTHING * largest)
    return PlanarGraph(clean, source, segments, real, warnings)


def _first_of_each(keys: np.ndarray) -> np.ndarray | None:
    """Numbers of the keys that repeat no earlier one, in order; None if none does."""
    ordered = np.sort(keys)  # a plain sort is far faster than one that returns numbers, and mostly enough
    if kernels.least_gap(ordered) > 0:
        return None
    return np.sort(np.unique(keys, return_index=True)[1])


def _merged(points: np.ndarray) -> tuple[np.ndarray | None, float]:
    """For each point the first point of the group of points at its place, None if each has its own; largest coordinate.

    Points at one place are not farther apart than `SAME_POINT` of the largest coordinate, or connected by such.
    """
    skew = np.empty(len(points))
    largest = kernels.project(points, *_SKEW, skew)
    distance = SAME_POINT * largest
    if not distance:
        return np.zeros(len(points), int), largest
    # Points at one place have nearly the same coordinate along any direction. Along a skew one, few others have.
    ordered = np.sort(skew)
    if kernels.least_gap(ordered) > 2 * distance:
        return None, largest
    close = ordered[1:] - ordered[:-1] <= 2 * distance
    starts = ordered[np.flatnonzero(close & ~np.append(False, close[:-1]))]
    stops = ordered[1:][np.flatnonzero(close & ~np.append(close[1:], False))]
    cluster = np.searchsorted(starts, skew, side="right") - 1
    some = np.flatnonzero((cluster >= 0) & (skew <= stops[np.maximum(cluster, 0)]))
    pairs = some[_near_pairs(points[some] / distance, cluster[some])]
    if not len(pairs):
        return None, largest
    group = topology.connected(pairs, len(points))
    return np.unique(group, return_index=True)[1][group], largest


def _near_pairs(points: np.ndarray, cluster: np.ndarray) -> np.ndarray:
    """(k, 2) int: pairs of points of one cluster not farther than 1 apart, enough of them to connect all such."""
    order = np.lexsort((points @ _ACROSS, cluster))
    across = points[order] @ _ACROSS
    together = (cluster[order][1:] == cluster[order][:-1]) & (across[1:] - across[:-1] <= 2)
    pairs = np.column_stack([order[:-1], order[1:]])[together]
    near = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1) <= 1
    # Now only points side by side in this order are found. Where one such pair is not near, look at all.
    part = np.cumsum(np.append(True, ~together))
    doubtful = order[np.isin(part, part[1:][together][~near])]
    found = [pairs[near]]
    # Two points that near each other lie in one cell of at least one of four grids, shifted by half a cell.
    for shift in np.ndindex(2, 2):
        cell = np.floor(points[doubtful] / 2 + 0.5 * np.array(shift))
        by_cell = np.lexsort(cell.T)
        same = (cell[by_cell][1:] == cell[by_cell][:-1]).all(axis=1)
        both = doubtful[np.column_stack([by_cell[:-1], by_cell[1:]])[same]]
        found.append(both[np.linalg.norm(points[both[:, 0]] - points[both[:, 1]], axis=1) <= 1])
    return np.concatenate(found)


@dataclass
class Crossings:
    """Pairs of segments that cross.

    Attributes
    ----------
    pairs : (k, 2) int
        Segments, each pair once.
    places : (k, 2) float
        Where they cross.
    """

    pairs: np.ndarray
    places: np.ndarray


def split_at_crossings(graph: PlanarGraph, crossings: Crossings) -> PlanarGraph:
    """The graph with a point where each pair of segments crosses, and both split there."""
    points = np.concatenate([graph.points, crossings.places])
    same = _merged(points)[0]
    if same is None:
        same = np.arange(len(points))
    owner = crossings.pairs.T.ravel()
    stop = np.tile(len(graph.points) + np.arange(len(crossings.pairs)), 2)
    start = graph.points[graph.segments[owner, 0]]
    order = np.lexsort((np.linalg.norm(points[stop] - start, axis=1), owner))
    owner, stop = owner[order], stop[order]
    is_first = np.append(True, owner[1:] != owner[:-1])
    is_last = np.append(is_first[1:], True)
    parts = np.column_stack([np.where(is_first, graph.segments[owner, 0], np.roll(stop, 1)), stop])
    ends = np.column_stack([stop[is_last], graph.segments[owner[is_last], 1]])
    whole = np.setdiff1d(np.arange(len(graph.segments)), owner)
    segments = same[np.concatenate([graph.segments[whole], parts, ends])]
    line = graph.line[np.concatenate([whole, owner, owner[is_last]])]
    keep = np.unique(same)
    source = np.concatenate([graph.source, np.full(len(crossings.pairs), -1)])[keep]
    segments = np.searchsorted(keep, segments)
    real = segments[:, 0] != segments[:, 1]
    segments, line = segments[real], line[real]
    first = _first_of_each(segments.min(axis=1) * len(keep) + segments.max(axis=1))
    if first is not None:
        segments, line = segments[first], line[first]
    return PlanarGraph(points[keep], source, segments, line, graph.warnings)


def divided_graph(
    graph: PlanarGraph, ends: np.ndarray, line: np.ndarray, count: np.ndarray, points: np.ndarray
) -> tuple[PlanarGraph, np.ndarray]:
    """The graph with each of some pieces of its lines divided.

    Parameters
    ----------
    graph : PlanarGraph
        Whose points stay, in front of the new ones.
    ends : (p, 2) int
        Points at the ends of each piece.
    line : (p,) int
        Number of the input line that each is part of.
    count : (p,) int
        Parts of each piece.
    points : (k, 2) float
        New points: those on the pieces, piece by piece and in order, then any others.

    Returns
    -------
    graph : PlanarGraph
        Its segments are the parts.
    piece : (m,) int
        The piece that each segment is part of.

    Examples
    --------
    >>> line = PlanarGraph(np.array([[0.0, 0.0], [3.0, 0.0]]), np.arange(2), np.array([[0, 1]]), np.array([7]))
    >>> new = np.array([[1.0, 0.0], [2.0, 0.0]])
    >>> finer, piece = divided_graph(line, line.segments, line.line, np.array([3]), new)
    >>> finer.segments.tolist(), finer.source.tolist(), finer.line.tolist()
    ([[0, 2], [2, 3], [3, 1]], [0, 1, -1, -1], [7, 7, 7])
    """
    piece = np.repeat(np.arange(len(count)), count)
    number = np.arange(len(piece)) - np.repeat(np.cumsum(count) - count, count)
    new = len(graph.points) + np.cumsum(count - 1)[piece] - (count - 1)[piece] + number
    start = np.where(number == 0, ends[piece, 0], new - 1)
    stop = np.where(number == count[piece] - 1, ends[piece, 1], new)
    divided = replace(
        graph,
        points=np.concatenate([graph.points, points]),
        source=np.concatenate([graph.source, np.full(len(points), -1)]),
        segments=np.column_stack([start, stop]),
        line=line[piece],
    )
    return divided, piece
