"""Whether the lines of an input boundary are still there, each as one edge of the mesh or as several in a row."""

from __future__ import annotations

import numpy as np

from .keys import point_keys


def missing_segments(points: np.ndarray, edges: np.ndarray, where: np.ndarray, lines: np.ndarray) -> np.ndarray:
    """(k,) int: input lines that are no union of mesh edges.

    Parameters
    ----------
    points : (n, 3) float
        Points of the mesh.
    edges : (m,) int64
        Keys ``n smaller + larger`` of all edges of the mesh, sorted, each once.
    where : (p,) int
        Number of the mesh's point for each point of the boundary; -1 where it has none.
    lines : (s, 2) int
        Lines of the boundary, in its own numbers.

    Notes
    -----
    A line that was split is followed from its start: at each point the edge is taken that leads on within the
    tolerance of rounding, 1e-10 of the mesh's diagonal.

    Examples
    --------
    >>> points = np.array([[0.0, 0, 0], [2, 0, 0], [1, 0, 0], [1, 1, 0]])
    >>> edges = np.array([2, 6, 7, 11])  # 0-2, 1-2, 1-3, 2-3
    >>> missing_segments(points, edges, np.arange(4), np.array([[0, 1], [0, 3]]))
    array([1])
    """
    n = len(points)
    at = where[lines]
    found = np.zeros(len(lines), bool)
    known = (at >= 0).all(axis=1)
    found[known] = _contains(edges, n * at[known].min(axis=1) + at[known].max(axis=1))
    left = np.flatnonzero(known & ~found)
    if len(left):
        tolerance = 1e-10 * float(np.linalg.norm(np.ptp(points, axis=0)))
        found[left] = _followed(points, edges, at[left], tolerance)
    return np.flatnonzero(~found)


def _contains(ordered: np.ndarray, values: np.ndarray) -> np.ndarray:
    place = np.searchsorted(ordered, values)
    return (place < len(ordered)) & (ordered[np.minimum(place, len(ordered) - 1)] == values)


def _followed(points: np.ndarray, edges: np.ndarray, lines: np.ndarray, tolerance: float) -> np.ndarray:
    """(k,) bool: whether a chain of edges leads straight from the first to the second point of each line."""
    n = len(points)
    smaller, larger = np.divmod(edges, n)
    both = np.sort(np.concatenate([edges, larger * n + smaller]))
    neighbour = both % n
    start = np.searchsorted(both, np.arange(n + 1) * n)
    here, goal = lines.T.copy()
    origin = points[here]
    direction = points[goal] - origin
    size = np.linalg.norm(direction, axis=1)
    active = np.flatnonzero(size > 0)
    direction[active] /= size[active, None]
    done = np.zeros(len(lines), bool)
    while len(active):
        count = start[here[active] + 1] - start[here[active]]
        row = np.repeat(np.arange(len(active)), count)
        first = np.concatenate([[0], np.cumsum(count)[:-1]])
        to = neighbour[np.arange(len(row)) - np.repeat(first - start[here[active]], count)]
        line = active[row]
        offset = points[to] - origin[line]
        along = np.einsum("ij,ij->i", offset, direction[line])
        aside = np.linalg.norm(offset - along[:, None] * direction[line], axis=1)
        now = np.einsum("ij,ij->i", points[here[line]] - origin[line], direction[line])
        fits = np.flatnonzero((aside <= tolerance) & (along > now) & (along <= size[line] + tolerance))
        fits = fits[np.lexsort((along[fits], line[fits]))]
        active, pick = np.unique(line[fits], return_index=True)
        here[active] = to[fits[pick]]
        done[active] = here[active] == goal[active]
        active = active[~done[active]]
    return done


def same_points(points: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """(k,) int: number of the point with exactly the coordinates of each wanted one; -1 where there is none.

    Examples
    --------
    >>> same_points(np.array([[0.0, 0, 0], [1, 0, 0]]), np.array([[1.0, 0, 0], [2, 0, 0]]))
    array([ 1, -1])
    """
    if not len(points):
        return np.full(len(wanted), -1)
    shared = min(len(points), len(wanted))
    if (points[:shared] == wanted).all() if shared == len(wanted) else False:
        return np.arange(shared)  # generators keep the input's points first
    keys = point_keys(points)
    order = np.argsort(keys, kind="stable")
    place = np.minimum(np.searchsorted(keys[order], point_keys(wanted)), len(points) - 1)
    number = order[place]
    return np.where((points[number] == wanted).all(axis=1), number, -1)
