"""The exact and slow twin of the Delaunay engine: ties by symbolic perturbation, cells by trying every subset.

The rule
--------
Point number i is lifted to ``z_i = |p_i|^2 + eps^(i + 1)``, eps > 0 smaller than anything: the lowest number is lifted
most. A point is inside the sphere of a positively oriented cell if it lies below the hyperplane through the lifted
corners. The determinant of the d + 2 lifted points is linear in the lifts, so where the points are cospherical the
coefficient of the lowest number decides, if it is zero that of the next: it is the orientation of the other d + 1
points. In the plane the lowest number always decides (three of four different cocircular points never lie on one
line); in space at most two numbers are asked, and the answer is never zero, since the coefficient of the point asked
about is the volume of the cell.

What follows
------------
The cells are the lower convex hull of points in general position over the ordered field of the polynomials in eps. So
they tile the convex hull exactly, each different point is a corner, and no cell is flat. In a plane that touches the
hull the same holds one dimension lower with the same lifts: hull facets are the Delaunay triangles of the points of
that plane. Hence a ghost whose facet is coplanar with a new point is in conflict exactly if the cell behind it is
(the coefficient of that cell's fourth corner vanishes, whatever the corner), and no facet of a cavity is coplanar with
the new point. The triangulation does not depend on the order of insertion.

References
----------
H. Edelsbrunner, E. P. Muecke, "Simulation of simplicity", ACM Trans. Graphics 9 (1990). O. Devillers, M. Teillaud,
"Perturbations for Delaunay and weighted Delaunay 3D triangulations", Computational Geometry 44 (2011).
"""

from __future__ import annotations

import itertools

import numpy as np

from tests import naive


def exact(points):
    """(n, d) whole numbers with the shape of the points: machine integers where five factors fit, else Python's."""
    whole = naive.whole_numbers(np.asarray(points, float))
    return whole.astype(np.int64) if np.abs(whole).max(initial=0) <= 400 else whole


def orientation(corners):
    """(k,) sign of the area or volume of (k, d + 1, d) corners."""
    return np.sign(naive.determinant(corners[:, 1:] - corners[:, :1])).astype(int)


def perturbed_inside(whole, ids):
    """(k,) 1 or -1: whether the last of (k, d + 2) ids is inside the sphere of the others, a positive cell."""
    corners = whole[ids]
    edges = corners[:, 1:] - corners[:, :1]
    lifted = np.concatenate([edges, (edges**2).sum(axis=2, keepdims=True)], axis=2)
    above = np.sign(naive.determinant(lifted)).astype(int)
    tied = above == 0
    if tied.any():
        d = whole.shape[1]
        coefficients = [(-1) ** (k + d + 1) * orientation(np.delete(corners[tied], k, axis=1)) for k in range(d + 2)]
        by_number = np.take_along_axis(np.column_stack(coefficients), np.argsort(ids[tied], axis=1), axis=1)
        above[tied] = by_number[np.arange(len(by_number)), np.argmax(by_number != 0, axis=1)]
    return -above


def perturbed_in_circle(points, a, b, c, d):
    """1 if d is inside the perturbed circle of the counter-clockwise a, b, c, -1 if outside; numbers of points."""
    return int(perturbed_inside(exact(points), np.array([[a, b, c, d]]))[0])


def perturbed_in_sphere(points, a, b, c, d, e):
    """1 if e is inside the perturbed sphere of the positive tetrahedron a, b, c, d, -1 if outside."""
    return int(perturbed_inside(exact(points), np.array([[a, b, c, d, e]]))[0])


def first_of_their_place(points):
    """(n,) bool: False for a point where another of lower number is."""
    seen = set()
    return np.array([not (place in seen or seen.add(place)) for place in map(tuple, np.asarray(points).tolist())], bool)


def delaunay_cells_of_each(clouds):
    """For each of (cases, n, d) points the set of cells, as ordered tuples of numbers; all cases at once, for speed."""
    cases, n, d = np.shape(clouds)
    whole = exact(clouds).reshape(cases * n, d)
    kept = np.concatenate([first_of_their_place(points) for points in clouds])
    subsets = np.array(list(itertools.combinations(range(n), d + 1))).reshape(-1, d + 1)
    cells = (subsets[None] + n * np.arange(cases)[:, None, None]).reshape(-1, d + 1)
    cells = cells[kept[cells].all(axis=1)]
    turn = orientation(whole[cells])
    cells[turn < 0, :2] = cells[turn < 0, 1::-1]
    cells = cells[turn != 0]
    for q in range(n):
        other = cells[:, 0] // n * n + q
        asked = kept[other] & (cells != other[:, None]).all(axis=1)
        asked[asked] = perturbed_inside(whole, np.column_stack([cells[asked], other[asked]])) > 0
        cells = cells[~asked]
    found = [set() for _ in range(cases)]
    for cell in np.sort(cells, axis=1).tolist():
        found[cell[0] // n].add(tuple(k % n for k in cell))
    return found


def delaunay_cells(points):
    """The set of triangles or tetrahedra of (n, d) points, as ordered tuples of numbers."""
    return delaunay_cells_of_each(np.asarray(points, float)[None])[0]


def measure(points, cells):
    """d! times the sum of the cells' areas or volumes, exactly, in units of the points' common denominator."""
    whole = naive.whole_numbers(np.asarray(points, float))
    corners = whole[np.array(sorted(cells), int).reshape(-1, whole.shape[1] + 1)]
    return sum(abs(naive.determinant(corners[:, 1:] - corners[:, :1])), 0)


def hull_measure(points):
    """d! times the area or volume of the convex hull, by Jarvis' march or plane by plane; units as in `measure`."""
    whole = naive.whole_numbers(np.asarray(points, float))
    whole = [list(p) for p in sorted({tuple(p) for p in whole.tolist()})]
    return _twice_hull_area(whole) if len(whole[0]) == 2 else _six_hull_volume(whole)


def _turn(a, b, c):
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _hull_loop(points):
    """Corners of the hull of different planar points, counter-clockwise."""
    loop = [min(points)]
    while True:
        best = None
        for p in points:
            if p == loop[-1]:
                continue
            turn = 1 if best is None else -_turn(loop[-1], best, p)
            if turn > 0 or (turn == 0 and _farther(loop[-1], p, best)):
                best = p
        if best is None or best == loop[0]:
            return loop
        loop.append(best)


def _farther(a, p, q):
    return sum((x - y) ** 2 for x, y in zip(p, a, strict=True)) > sum((x - y) ** 2 for x, y in zip(q, a, strict=True))


def _twice_hull_area(points):
    loop = _hull_loop(points)
    return sum(_turn(loop[0], b, c) for b, c in itertools.pairwise(loop[1:]))


def _six_hull_volume(points):
    """Sum over the planes with all points on one side of the pyramids from the first point."""
    apex, total, done = points[0], 0, set()
    for a, b, c in itertools.permutations(range(len(points)), 3):
        if a > b or a > c or (a, b, c) in done:
            continue
        u, v = ([y - x for x, y in zip(points[a], points[k], strict=True)] for k in (b, c))
        normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
        heights = [sum(n * (y - x) for n, x, y in zip(normal, points[a], p, strict=True)) for p in points]
        if not any(normal) or max(heights) > 0:
            continue
        inside = [k for k, height in enumerate(heights) if height == 0]
        done.update(itertools.permutations(inside, 3))
        axis = next(k for k in range(3) if normal[k])
        flat = {tuple(points[k][x] for x in range(3) if x != axis): points[k] for k in inside}
        loop = [flat[tuple(p)] for p in _hull_loop([list(p) for p in flat])]
        for p, q in itertools.pairwise(loop[1:]):
            rows = np.array([[x - y for x, y in zip(r, apex, strict=True)] for r in (loop[0], p, q)], object)
            total += abs(naive.determinant(rows))
    return total
