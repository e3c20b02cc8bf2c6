"""What makes a complex of simplices the perturbed Delaunay triangulation of its points, in exact arithmetic.

Every interior facet is tested locally (Lawson's lemma holds for lifted points in general position), the boundary for
local convexity and for being one sphere: together that is the whole definition, in linear time.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from meshcore.geometry import predicates


def orientation(points, ids):
    """(k,) int: exact sign of the area or volume of the cells (k, d + 1)."""
    if len(ids) == 0:
        return np.zeros(0, int)
    predicate = predicates.orient2d if points.shape[1] == 2 else predicates.orient3d
    return predicate(*np.moveaxis(points[ids], 1, 0)).astype(int)


def inside(points, ids):
    """(k,) int: 1 or -1, whether the last of (k, d + 2) ids is inside the perturbed sphere of the cell before it."""
    d = points.shape[1]
    predicate = predicates.incircle if d == 2 else predicates.insphere
    found = predicate(*np.moveaxis(points[ids], 1, 0)).astype(int)
    tied = ids[found == 0]
    coefficients = np.column_stack(
        [(-1) ** (k + d + 1) * orientation(points, np.delete(tied, k, axis=1)) for k in range(d + 2)]
    )
    ordered = np.take_along_axis(coefficients, np.argsort(tied, axis=1), axis=1)
    found[found == 0] = -ordered[np.arange(len(tied)), np.argmax(ordered != 0, axis=1)]
    return found


def facets(cells):
    """(k, d) facets with ascending corners, cell and opposite corner of each, those shared in pairs, the rest."""
    corners = cells.shape[1]
    of_cell = np.repeat(np.arange(len(cells)), corners)
    opposite = cells.ravel()
    facet = np.sort(np.concatenate([np.delete(cells, k, axis=1)[:, None] for k in range(corners)], axis=1), axis=2)
    facet = facet.reshape(-1, corners - 1)
    order = np.lexsort(facet.T[::-1])
    same = (facet[order[1:]] == facet[order[:-1]]).all(axis=1)
    assert not (same[1:] & same[:-1]).any(), "three cells share a facet"
    first = np.flatnonzero(same)
    alone = np.ones(len(order), bool)
    alone[first] = alone[first + 1] = False
    return facet, of_cell, opposite, np.column_stack([order[first], order[first + 1]]), order[alone]


def assert_delaunay(points, cells):
    """The cells are positive, conforming, perturbed Delaunay, cover the convex hull, and use every different point."""
    points, cells = np.asarray(points), np.asarray(cells)
    d = points.shape[1]
    assert (orientation(points, cells) > 0).all(), "an inverted or flat cell"
    facet, of_cell, opposite, pairs, alone = facets(cells)
    one, other = pairs.T
    sides = [orientation(points, np.column_stack([facet[k], opposite[k]])) for k in (one, other)]
    assert (sides[0] == -sides[1]).all(), "two cells on one side of their facet"
    asked = np.column_stack([cells[of_cell[one]], opposite[other]])
    assert (inside(points, asked) < 0).all(), "a point inside the sphere of a neighbour"
    used = np.unique(cells)
    assert len(np.unique(points + 0.0, axis=0)) == len(used) == len(np.unique(points[used] + 0.0, axis=0))
    _assert_convex(points, facet[alone], opposite[alone])
    simplices = [len(used), *(_number_of_faces(cells, size) for size in range(2, d + 2))]
    assert sum((-1) ** k * count for k, count in enumerate(simplices)) == 1, "Euler's formula for a ball"


def _number_of_faces(cells, size):
    """How many different faces with ``size`` corners the cells have."""
    faces = np.concatenate([cells[:, list(c)] for c in combinations(range(cells.shape[1]), size)])
    return len(np.unique(np.sort(faces, axis=1), axis=0))


def _assert_convex(points, hull, behind):
    """Each ridge of the hull joins two facets, neither of which sees the other; the hull is one loop or one sphere."""
    d = points.shape[1]
    _, of_facet, opposite, pairs, alone = facets(hull)
    assert len(alone) == 0, "the hull has a border"
    one, other = pairs.T
    beyond = orientation(points, np.column_stack([hull[of_facet[one]], opposite[other]]))
    within = orientation(points, np.column_stack([hull[of_facet[one]], behind[of_facet[one]]]))
    assert (beyond * within >= 0).all(), "the hull is not convex"
    # Closed and locally convex is convex (Tietze and Nakajima) if it winds once: Euler's number of a sphere or loop.
    if d == 3:
        assert len(np.unique(hull)) - len(pairs) + len(hull) == 2
    else:
        middle = points[np.unique(hull)].mean(axis=0)
        angle = np.arctan2(*(points[hull] - middle).transpose(2, 0, 1)[::-1])
        turned = np.abs((np.diff(angle, axis=1) + np.pi) % (2 * np.pi) - np.pi).sum()
        assert turned < 3 * np.pi, "the hull winds twice"
