"""Slow and obvious twins of what meshcore does fast: the tests hold one against the other.

The twin of the Delaunay engine, with its rule for ties, stands in `naive_delaunay`.
"""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

import numpy as np
import scipy.sparse
import scipy.sparse.linalg


def bisected(function, low, high):
    """Root of a function that changes sign between ``low`` and ``high``, by halving."""
    below = function(low) < 0
    for _ in range(200):
        middle = 0.5 * (low + high)
        if (function(middle) < 0) == below:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def line_integral(function, stops, samples=1000):
    """Integrals of a function between neighbouring stops, by midpoints."""
    parts = []
    for a, b in itertools.pairwise(stops):
        middles = a + (np.arange(samples) + 0.5) / samples * (b - a)
        parts.append(float(sum(function(middles))) * (b - a) / samples)
    return np.array(parts)


def one_sided_tanh(cells, first):
    """``1 + tanh(a (t - 1)) / tanh(a)`` with a found by halving so that the first cell is ``first``."""

    def s(a, t):
        return 1 + math.tanh(a * (t - 1)) / math.tanh(a)

    a = bisected(lambda a: first - s(a, 1 / cells), 1e-3, 17.0)
    return np.array([s(a, k / cells) for k in range(cells + 1)])


def vinokur(cells, first, last):
    """``u / (A + (1 - A) u)`` with Vinokur's u (tanh or tan), A and d found so that the end cells fit."""
    skew = math.sqrt(last / (1 - last) / (first / (1 - first)))

    def s(d, t):
        if d > 0:
            u = 0.5 * (1 + math.tanh(d * (t - 0.5)) / math.tanh(0.5 * d))
        else:
            u = 0.5 * (1 + math.tan(-d * (t - 0.5)) / math.tan(-0.5 * d))
        return u / (skew + (1 - skew) * u)

    def excess(d):
        return first - s(d, 1 / cells)

    d = bisected(excess, 1e-4, 34.0) if excess(1e-4) < 0 else bisected(excess, 1e-4 - math.pi, -1e-4)
    return np.array([s(d, k / cells) for k in range(cells + 1)])


def coons(south, east, north, west, s, t):
    """The Coons patch point by point, from Gordon and Hall's formula; ``s``, ``t`` are (ni, nj) blending values."""
    ni, nj = len(south), len(west)
    points = np.empty((ni, nj, 3))
    for i in range(ni):
        for j in range(nj):
            for x in range(3):
                u, v = s[i][j], t[i][j]
                sides = (1 - u) * west[j][x] + u * east[j][x] + (1 - v) * south[i][x] + v * north[i][x]
                corners = (
                    (1 - u) * (1 - v) * south[0][x]
                    + u * (1 - v) * south[-1][x]
                    + (1 - u) * v * north[0][x]
                    + u * v * north[-1][x]
                )
                points[i, j, x] = sides - corners
    return points


def gordon_hall(faces, u, v, w):
    """A block point by point, by all 26 terms of Gordon and Hall's formula; u, v, w are (ni, nj, nk) values."""
    west, east, front, back, low, high = faces
    ni, nj, nk = len(low), len(low[0]), len(west[0])
    points = np.empty((ni, nj, nk, 3))
    for i, j, k in itertools.product(range(ni), range(nj), range(nk)):
        a, b, c = ((1 - x[i, j, k], x[i, j, k]) for x in (u, v, w))
        ends = (0, 1)
        first = sum(
            a[p] * (west, east)[p][j][k] + b[p] * (front, back)[p][i][k] + c[p] * (low, high)[p][i][j] for p in ends
        )
        second, third = 0.0, 0.0
        for p, q in itertools.product(ends, ends):
            second = second + a[p] * b[q] * (west, east)[p][-q][k]
            second = second + a[p] * c[q] * (west, east)[p][j][-q]
            second = second + b[p] * c[q] * (front, back)[p][i][-q]
            for r in ends:
                third = third + a[p] * b[q] * c[r] * (west, east)[p][-q][-r]
        points[i, j, k] = first - second + third
    return points


def crossing_of_edges(u_edges, v_edges, w_edges):
    """(3, ni, nj, nk) u, v, w of blending by length, by sweeping the equations; edges in the order 00, 10, 01, 11."""

    def between(edges, n, a, b):
        return (1 - b) * ((1 - a) * edges[0][n] + a * edges[1][n]) + b * ((1 - a) * edges[2][n] + a * edges[3][n])

    shape = len(u_edges[0]), len(v_edges[0]), len(w_edges[0])
    found = np.empty((3, *shape))
    for i, j, k in itertools.product(*map(range, shape)):
        u = v = w = 0.5
        for _ in range(500):
            u = between(u_edges, i, v, w)
            v = between(v_edges, j, u, w)
            w = between(w_edges, k, u, v)
        found[:, i, j, k] = u, v, w
    return found


def crossing_of_lengths(south, east, north, west):
    """(ni, nj) s and t of blending by arc length, by sweeping the two equations until they agree."""

    def fractions(side):
        steps = [math.dist(a, b) for a, b in itertools.pairwise(side)]
        return [sum(steps[:k]) / sum(steps) for k in range(len(side))]

    low, right, high, left = (fractions(side) for side in (south, east, north, west))
    s = np.empty((len(low), len(left)))
    t = np.empty_like(s)
    for i in range(len(low)):
        for j in range(len(left)):
            u = v = 0.5
            for _ in range(2000):
                u = (1 - v) * low[i] + v * high[i]
                v = (1 - u) * left[j] + u * right[j]
            s[i, j], t[i, j] = u, v
    return s, t


def cross_areas(points):
    """(ni - 1, nj - 1, 4) twice the signed areas of the triangles at the corners of planar cells."""
    ni, nj = len(points), len(points[0])
    areas = np.empty((ni - 1, nj - 1, 4))
    for i in range(ni - 1):
        for j in range(nj - 1):
            quad = [points[i][j], points[i + 1][j], points[i + 1][j + 1], points[i][j + 1]]
            for k in range(4):
                a, b, c = quad[k - 1], quad[k], quad[(k + 1) % 4]
                areas[i, j, k] = (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
    return areas


def smallest_angle_of_star(centre, ring):
    """Radians: smallest angle of the triangles from a centre to the edges of a ring; not above 0 if one turns over."""
    smallest = math.pi
    for a, b in zip(ring, [*ring[1:], ring[0]], strict=True):
        corners = [centre, a, b]
        turn = 1 if side(*corners) > 0 else -1
        for k in range(3):
            p, q, r = corners[k], corners[k - 2], corners[k - 1]
            to_q, to_r = math.atan2(q[1] - p[1], q[0] - p[0]), math.atan2(r[1] - p[1], r[0] - p[0])
            between = abs(to_q - to_r)
            smallest = min(smallest, turn * min(between, 2 * math.pi - between))
    return smallest


# ---- predicates: determinants of whole numbers; tests are (count, points, dimension) float


def whole_numbers(values: np.ndarray) -> np.ndarray:
    """Doubles as exact Python integers, all times one power of two."""
    ratios = [Fraction(x) for x in np.ravel(values).tolist()]
    scale = max((r.denominator for r in ratios), default=1)
    numbers = np.empty(len(ratios), object)
    numbers[:] = [r.numerator * (scale // r.denominator) for r in ratios]
    return numbers.reshape(np.shape(values))


def determinant(matrix: np.ndarray) -> np.ndarray:
    """Laplace's expansion along the first row of (..., k, k) objects."""
    if matrix.shape[-1] == 1:
        return matrix[..., 0, 0]
    minors = [determinant(np.delete(matrix[..., 1:, :], j, axis=-1)) for j in range(matrix.shape[-1])]
    return sum((-1) ** j * matrix[..., 0, j] * minor for j, minor in enumerate(minors))


def _edges(tests: np.ndarray) -> np.ndarray:
    points = whole_numbers(tests)
    return points[:, 1:] - points[:, :1]


def _lifted_edges(tests: np.ndarray) -> np.ndarray:
    """Edges from the first point, each with the square of its length: its place on the paraboloid there."""
    edges = _edges(tests)
    return np.concatenate([edges, (edges**2).sum(axis=2, keepdims=True)], axis=2)


def orient2d(tests: np.ndarray) -> np.ndarray:
    """Sign of the area of a, b, c."""
    return np.sign(determinant(_edges(tests))).astype(int)


def orient3d(tests: np.ndarray) -> np.ndarray:
    """Sign of the volume of a, b, c, d."""
    return np.sign(determinant(_edges(tests))).astype(int)


def incircle(tests: np.ndarray) -> np.ndarray:
    """1 if d lies below the plane through a, b, c on the paraboloid: the volume there is negative."""
    return -np.sign(determinant(_lifted_edges(tests))).astype(int)


def insphere(tests: np.ndarray) -> np.ndarray:
    """1 if e lies below the hyperplane through a, b, c, d on the paraboloid."""
    return -np.sign(determinant(_lifted_edges(tests))).astype(int)


def openfoam_facets(cells, points):
    """Non-orthogonality and skewness of planar polygons' edges, one at a time as OpenFOAM's checkMesh has them.

    ``cells`` are lists of point numbers, counter-clockwise. Returns {frozenset of two points: (angle or None, skew)}.
    """

    def centre(cell):
        x = [points[k] for k in cell]
        area = sum(p[0] * q[1] - q[0] * p[1] for p, q in zip(x, x[1:] + x[:1], strict=True)) / 2
        return [
            sum((p[i] + q[i]) * (p[0] * q[1] - q[0] * p[1]) for p, q in zip(x, x[1:] + x[:1], strict=True)) / (6 * area)
            for i in (0, 1)
        ]

    sides = {}
    for cell in cells:
        for a, b in zip(cell, cell[1:] + cell[:1], strict=True):
            sides.setdefault(frozenset((a, b)), []).append((a, b, centre(cell)))
    found = {}
    for key, owners in sides.items():
        a, b, own = owners[0]
        p, q = points[a], points[b]
        middle = [(p[i] + q[i]) / 2 for i in (0, 1)]
        normal = [q[1] - p[1], p[0] - q[0]]
        to_face = [middle[i] - own[i] for i in (0, 1)]
        through = sum(normal[i] * to_face[i] for i in (0, 1))
        if len(owners) == 2:
            d = [owners[1][2][i] - own[i] for i in (0, 1)]
            cosine = (d[0] * normal[0] + d[1] * normal[1]) / math.hypot(*d) / math.hypot(*normal)
            angle, reach = math.degrees(math.acos(min(1.0, cosine))), 0.2
        else:
            d = [normal[i] * through / (normal[0] ** 2 + normal[1] ** 2) for i in (0, 1)]
            angle, reach = None, 0.4
        step = through / (normal[0] * d[0] + normal[1] * d[1])
        offset = [to_face[i] - step * d[i] for i in (0, 1)]
        size = math.hypot(*offset)
        if size > 0:
            reach = max(
                reach * math.hypot(*d),
                *(abs(sum(offset[i] * (end[i] - middle[i]) for i in (0, 1))) / size for end in (p, q)),
            )
        found[key] = angle, (size / reach if size > 0 else 0.0)
    return found


# ---- adaptivity: triangles as tuples of points, newest vertex first


def newest_vertex_refined(triangles, marked):
    """Newest-vertex bisection by the book: mark edges, close, cut one triangle after the other.

    ``triangles`` are tuples of three points (tuples of float), of which those in ``marked`` get all edges halved.
    """

    def middle(a, b):
        return tuple((x + y) / 2 for x, y in zip(a, b, strict=True))

    def cut(a, b, c):
        if frozenset((b, c)) not in edges:
            return [(a, b, c)]
        m = middle(b, c)
        return cut(m, a, b) + cut(m, c, a)

    edges = {frozenset(pair) for t in marked for pair in itertools.combinations(t, 2)}
    before = -1
    while len(edges) != before:
        before = len(edges)
        for a, b, c in triangles:
            if edges & {frozenset((a, b)), frozenset((a, c))}:
                edges.add(frozenset((b, c)))
    return [part for triangle in triangles for part in cut(*triangle)]


def gradient_jump(points, triangles, values):
    """Kelly's indicator, edge by edge: slopes by least squares, normals by turning the edge in the plane z = 0."""
    slopes = [
        np.linalg.lstsq(np.column_stack([points[t][:, :2], np.ones(3)]), values[t], rcond=None)[0][:2]
        for t in triangles
    ]
    squares = np.zeros(len(triangles))
    for i, j in itertools.combinations(range(len(triangles)), 2):
        shared = sorted(set(triangles[i].tolist()) & set(triangles[j].tolist()))
        if len(shared) == 2:
            edge = (points[shared[1]] - points[shared[0]])[:2]
            length = np.hypot(*edge)
            jump = (slopes[i] - slopes[j]) @ np.array([edge[1], -edge[0]]) / length
            squares[[i, j]] += 0.5 * length * (length * jump**2)
    return np.sqrt(squares)


def poisson(points, triangles, boundary_values):
    """Linear finite elements for Laplace's equation: nodal values, with ``boundary_values`` (nan inside) kept."""
    n = len(points)
    corners = points[triangles][:, :, :2]
    sides = np.roll(corners, 1, axis=1) - np.roll(corners, -1, axis=1)
    twice_area = sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0]
    local = np.einsum("mik,mjk->mij", sides, sides) / (2 * twice_area)[:, None, None]
    rows, columns = np.repeat(triangles, 3, axis=1), np.tile(triangles, 3)
    matrix = scipy.sparse.coo_matrix((local.ravel(), (rows.ravel(), columns.ravel())), (n, n)).tocsr()
    free = np.isnan(boundary_values)
    solution = np.where(free, 0.0, boundary_values)
    load = -(matrix @ solution)[free]
    solution[free] = scipy.sparse.linalg.spsolve(matrix[free][:, free].tocsc(), load)
    return solution


# ---- planar triangulations, in whole numbers or fractions


def side(a, b, c):
    """Twice the signed area of a, b, c, exactly."""
    (ax, ay), (bx, by), (cx, cy) = ([Fraction(v) for v in p] for p in (a, b, c))
    return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)


def in_circle(a, b, c, d):
    """Positive if d is inside the circle of counter-clockwise a, b, c, exactly."""
    rows = []
    for p in (a, b, c):
        x, y = Fraction(p[0]) - Fraction(d[0]), Fraction(p[1]) - Fraction(d[1])
        rows.append((x, y, x * x + y * y))
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = rows
    return az * (bx * cy - cx * by) - bz * (ax * cy - cx * ay) + cz * (ax * by - bx * ay)


def delaunay_circles_are_empty(points, triangles):
    """Whether no point is inside the circle of any triangle: every triangle against every point."""
    return all(
        in_circle(*(points[k] for k in triangle), points[p]) <= 0
        for triangle in triangles
        for p in range(len(points))
        if p not in triangle
    )


def not_locally_delaunay(points, triangles, barriers):
    """Edges, not among the barriers, whose opposite corner is inside the circle of a triangle beside them.

    By Lee and Lin's lemma none is left exactly if no corner that a triangle can see past the barriers is in its circle.
    """
    opposite = {}
    for a, b, c in triangles:
        for u, v, w in ((a, b, c), (b, c, a), (c, a, b)):
            opposite[u, v] = w
    barriers = {frozenset(edge) for edge in barriers}
    return [
        (u, v)
        for (u, v), w in opposite.items()
        if (v, u) in opposite
        and frozenset((u, v)) not in barriers
        and in_circle(points[u], points[v], points[w], points[opposite[v, u]]) > 0
    ]


def is_inside(loops, x, y):
    """Even-odd rule: how many edges a ray to the right crosses."""
    inside = False
    for loop in loops:
        for (ax, ay), (bx, by) in zip(loop, [*loop[1:], loop[0]], strict=True):
            if (ay > y) != (by > y) and x < ax + (y - ay) * (bx - ax) / (by - ay):
                inside = not inside
    return inside


def segments_cross(a, b, c, d):
    """Whether two segments share a point that is not an end of both, exactly."""
    if {tuple(a), tuple(b)} & {tuple(c), tuple(d)}:
        shared = ({tuple(a), tuple(b)} & {tuple(c), tuple(d)}).pop()
        p, q = (next(e for e in pair if tuple(e) != shared) for pair in ((a, b), (c, d)))
        along = sum((Fraction(p[k]) - Fraction(shared[k])) * (Fraction(q[k]) - Fraction(shared[k])) for k in (0, 1))
        return side(shared, p, q) == 0 and along > 0
    s = [side(a, b, c), side(a, b, d), side(c, d, a), side(c, d, b)]
    if s[0] * s[1] < 0 and s[2] * s[3] < 0:
        return True

    def lies_on(p, u, v):
        box = all(min(u[k], v[k]) <= p[k] <= max(u[k], v[k]) for k in (0, 1))
        return side(u, v, p) == 0 and box

    return lies_on(c, a, b) or lies_on(d, a, b) or lies_on(a, c, d) or lies_on(b, c, d)


# ---- insertion order


def first_of_equal(points):
    """For each point the lowest row at its place."""
    seen = {}
    return [seen.setdefault(tuple(float(x) + 0.0 for x in p), row) for row, p in enumerate(points)]


def fitted_line(points):
    """Middle, reach and direction of the line through points in the plane, term after term in doubles."""
    x = y = xx = xy = yy = 0.0
    for p in points.tolist():
        x, y = x + p[0], y + p[1]
    x, y = x / len(points), y / len(points)
    size = max(max(abs(p[0] - x), abs(p[1] - y)) for p in points.tolist())
    for p in points.tolist():
        dx, dy = (p[0] - x) / size, (p[1] - y) / size
        xx, xy, yy = xx + dx * dx, xy + dx * dy, yy + dy * dy
    length = math.sqrt((xx - yy) * (xx - yy) + 4.0 * xy * xy)
    larger = math.sqrt(0.5 + 0.5 * abs(xx - yy) / length)
    smaller = xy / length / larger
    return [x, y, size, *((larger, smaller) if xx >= yy else (smaller, larger))]


def splitmix64(row):
    """The hash of Steele, Lea and Flood, in whole numbers without a limit."""
    mask = 2**64 - 1
    h = (row + 1) * 0x9E3779B97F4A7C15 & mask
    h = (h ^ h >> 30) * 0xBF58476D1CE4E5B9 & mask
    h = (h ^ h >> 27) * 0x94D049BB133111EB & mask
    return h ^ h >> 31


def insertion_round(row, last):
    """``last`` minus the number of coins, the hash's lowest bits, that fell on one before the first zero."""
    coins = f"{splitmix64(row):064b}"[::-1]
    return max(0, last - coins.index("0"))


# ---- point location: every cell tried in turn, by exact numbers


def _exact_rows(*points) -> list[list[Fraction]]:
    rows = [[Fraction(float(x)) for x in p] for p in points]
    return [[int(x) if x.denominator == 1 else x for x in p] for p in rows]


def _orientation(corners: list[list[Fraction]]) -> Fraction:
    """Positive for a counter-clockwise triangle, or a tetrahedron in VTK's order."""
    rows = [[x - y for x, y in zip(p, corners[0], strict=True)] for p in corners[1:]]
    if len(rows) == 2:
        return rows[0][0] * rows[1][1] - rows[0][1] * rows[1][0]
    return sum(rows[0][k] * (rows[1][k - 2] * rows[2][k - 1] - rows[1][k - 1] * rows[2][k - 2]) for k in range(3))


def located(points, cells, queries):
    """(m,) the first cell that holds each query, or -1, and the exact weights of its corners."""
    found, weights = [], []
    corners = _exact_rows(*points)
    for q in _exact_rows(*queries):
        found.append(-1)
        weights.append(None)
        for number, cell in enumerate(cells):
            simplex = [corners[k] for k in cell]
            size = _orientation(simplex)
            if size == 0:
                continue
            share = [Fraction(_orientation([*simplex[:k], q, *simplex[k + 1 :]]), size) for k in range(len(simplex))]
            if min(share) >= 0:
                found[-1], weights[-1] = number, share
                break
    return found, weights


def nearest_on_simplex(corners, point):
    """Distance from a point to a point, segment or triangle: the least over its inside, its edges and its corners."""
    corners = [np.asarray(c, float) for c in corners]
    least = min(float(np.linalg.norm(point - c)) for c in corners)
    for a, b in itertools.combinations(corners, 2):
        along = b - a
        if along @ along > 0:
            t = (point - a) @ along / (along @ along)
            if 0 <= t <= 1:
                least = min(least, float(np.linalg.norm(point - a - t * along)))
    if len(corners) == 3:
        a, b, c = corners
        normal = np.cross(b - a, c - a)
        if normal @ normal > 1e-20:
            foot = point - (point - a) @ normal / (normal @ normal) * normal
            sides = [np.cross(v - u, foot - u) @ normal for u, v in ((a, b), (b, c), (c, a))]
            if min(sides) >= 0:
                least = min(least, float(np.linalg.norm(point - foot)))
    return least


# ---- gradation: sweeps over all edges until nothing changes


def limited(edges, lengths, sizes, gradation):
    """Sizes lowered edge by edge (Borouchaki, Hecht & Frey)."""
    sizes = [float(h) for h in sizes]
    changed = True
    while changed:
        changed = False
        for (a, b), length in zip(edges, lengths, strict=True):
            for p, q in ((a, b), (b, a)):
                if sizes[p] + gradation * length < sizes[q]:
                    sizes[q] = sizes[p] + gradation * length
                    changed = True
    return np.array(sizes)


def pairs(items: list) -> list[tuple]:
    """All pairs of different items."""
    return list(itertools.combinations(items, 2))


def voronoi_areas(sites: list, box: tuple) -> list[Fraction]:
    """The exact area of each site's cell in a box: the box cut by the bisector to every other site."""
    (x0, y0), (x1, y1) = [[Fraction(x) for x in corner] for corner in box]
    places = [(Fraction(x), Fraction(y)) for x, y in sites]
    areas = []
    for a in places:
        cell = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
        for b in places:
            if a != b:
                # Nearer to a: 2 (b - a) . p <= |b|^2 - |a|^2.
                n = (2 * (b[0] - a[0]), 2 * (b[1] - a[1]))
                limit = b[0] ** 2 + b[1] ** 2 - a[0] ** 2 - a[1] ** 2
                cell = _cut_by_line(cell, n, limit)
        turns = zip(cell, cell[1:] + cell[:1], strict=True)
        areas.append(sum((p[0] * q[1] - p[1] * q[0] for p, q in turns), Fraction(0)) / 2)
    return areas


def _cut_by_line(cell: list, n: tuple, limit: Fraction) -> list:
    kept = []
    for p, q in zip(cell, cell[1:] + cell[:1], strict=True):
        hp, hq = (n[0] * c[0] + n[1] * c[1] - limit for c in (p, q))
        if hp <= 0:
            kept.append(p)
        if hp * hq < 0:
            t = hp / (hp - hq)
            kept.append((p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])))
    return kept


def connected(pairs, n):
    """(n,) int: the least member of the part that each of n things is in, where pairs are joined."""
    part = list(range(n))
    for a, b in pairs:
        part = [min(part[a], part[b]) if p in (part[a], part[b]) else p for p in part]
    return part


def blocks(edges):
    """Lists of the edges that share cycles: neighbours do, whose far ends are joined without their common vertex."""
    n = 1 + max(map(max, edges))
    pairs = []
    for v in range(n):
        part = connected([e for e in edges if v not in e], n)
        at_v = [(k, sum(e) - v) for k, e in enumerate(edges) if v in e]
        pairs += [(k, j) for k, far in at_v for j, other in at_v if part[far] == part[other]]
    block = connected(pairs, len(edges))
    return [[k for k in range(len(edges)) if block[k] == b] for b in sorted(set(block))]


def nesting_levels(edges, left, right, n_faces):
    """How many loops are around each face, modulo two: blocks, even ones by edges crossed, others by their outline."""
    level = [0] * n_faces
    for members in blocks(edges):
        if len(members) == 1:
            continue
        degree = np.bincount(np.ravel([edges[k] for k in members]))
        others = [(left[k], right[k]) for k in range(len(edges)) if k not in members]
        part = connected(others, n_faces)
        crossed = {part[0]: 0}
        while len(crossed) < len(set(part)):
            for k in members:
                for f, g in ((part[left[k]], part[right[k]]), (part[right[k]], part[left[k]])):
                    if f in crossed and g not in crossed:
                        crossed[g] = crossed[f] + 1
        is_even = not (degree % 2).any()
        level = [a + (crossed[p] if is_even else p != part[0]) for a, p in zip(level, part, strict=True)]
    return [a % 2 for a in level]


def winslow(points, growth=None, cyclic=False, sweeps=20_000):
    """The discrete Winslow equations by point relaxation until nothing moves, with Thompson's control functions."""
    r = np.array(points, float)
    ni, nj, _ = r.shape
    theta = np.zeros((2, ni, nj)) if growth is None else growth
    for _ in range(sweeps):
        largest = 0.0
        for i in range(1, ni if cyclic else ni - 1):
            before, after = i - 1, (1 if i == ni - 1 else i + 1)
            for j in range(1, nj - 1):
                ri, rj = (r[after, j] - r[before, j]) / 2, (r[i, j + 1] - r[i, j - 1]) / 2
                rij = (r[after, j + 1] - r[after, j - 1] - r[before, j + 1] + r[before, j - 1]) / 4
                a, b, g = rj @ rj, ri @ rj, ri @ ri
                p, q = -2 * np.tanh(theta[:, i, j] / 2)
                along_i = a * (r[after, j] + r[before, j] + p * ri)
                along_j = g * (r[i, j + 1] + r[i, j - 1] + q * rj)
                new = (along_i + along_j - 2 * b * rij) / (2 * (a + g))
                largest = max(largest, np.abs(new - r[i, j]).max())
                r[i, j] = new
            if cyclic and i == ni - 1:
                r[0] = r[i]
        if largest < 1e-14:
            break
    return r


def elliptic_defects(points, control):
    """(ni, nj, nk, 3) left sides of the equations ``g^ij (r_ij + P_i r_i)`` times J^2 at interior nodes, node by node.

    ``g^ij`` is the inverse of the metric tensor, by numpy; differences are central, in index units.
    """
    defects = np.zeros_like(points)
    for node in itertools.product(*(range(1, n - 1) for n in points.shape[:3])):
        defects[node] = _elliptic_terms(points, control, node)[0]
    return defects


def _elliptic_terms(points, control, node):
    """The left side at a node, and what multiplies the node in it."""

    def at(*steps):
        return points[tuple(np.add(node, np.sum(steps, axis=0)))]

    e = np.eye(3, dtype=int)
    first = np.array([(at(d) - at(-d)) / 2 for d in e])
    metric = first @ first.T
    inverse = np.linalg.inv(metric) * np.linalg.det(metric)
    left = np.zeros(3)
    for i, j in itertools.product(range(3), repeat=2):
        if i == j:
            second = at(e[i]) - 2 * at(0 * e[i]) + at(-e[i]) + control[node][i] * first[i]
        else:
            second = (at(e[i], e[j]) - at(e[i], -e[j]) - at(-e[i], e[j]) + at(-e[i], -e[j])) / 4
        left += inverse[i, j] * second
    return left, -2 * np.trace(inverse)


def elliptic_grid_3d(points, control, sweeps=200):
    """The solution of these equations, by so many sweeps of Gauss and Seidel."""
    points = points.copy()
    for _ in range(sweeps):
        for node in itertools.product(*(range(1, n - 1) for n in points.shape[:3])):
            left, diagonal = _elliptic_terms(points, control, node)
            points[node] -= left / diagonal
    return points


def filled_box(points):
    """The block whose inside is the Boolean sum of linear projections between opposite faces of a given one."""
    filled = np.zeros_like(points)
    for axis in range(3):
        rest = np.moveaxis(points - filled, axis, 0)
        t = np.linspace(0, 1, len(rest))[:, None, None, None]
        filled += np.moveaxis((1 - t) * rest[:1] + t * rest[-1:], 0, axis)
    return filled


def tangential_defects(points, tangents):
    """(ni, nj, 2) of ``g_22 r_11 - 2 g_12 r_12 + g_11 r_22``: in the tangents, less the grid's normal."""
    defects = np.zeros((*points.shape[:2], 2))
    for i, j in itertools.product(*(range(1, n - 1) for n in points.shape[:2])):
        p = points[i - 1 : i + 2, j - 1 : j + 2]
        by_i, by_j = (p[2, 1] - p[0, 1]) / 2, (p[1, 2] - p[1, 0]) / 2
        left = (by_j @ by_j) * (p[2, 1] - 2 * p[1, 1] + p[0, 1]) + (by_i @ by_i) * (p[1, 2] - 2 * p[1, 1] + p[1, 0])
        left -= 2 * (by_i @ by_j) * (p[2, 2] - p[2, 0] - p[0, 2] + p[0, 0]) / 4
        directions = [*(t[i, j] for t in tangents), np.cross(by_i, by_j)]
        defects[i, j] = np.linalg.solve(np.stack(directions, axis=-1), left)[:2]
    return defects


def corners_of_hexahedra(points):
    """For each cell of a block and each of its corners: the node, and the three nodes beside it along i, j and k."""
    for cell in itertools.product(*(range(n - 1) for n in points.shape[:3])):
        for bits in itertools.product((0, 1), repeat=3):
            node = tuple(np.add(cell, bits))
            beside = [tuple(np.add(node, (1 - 2 * bits[d]) * np.eye(3, dtype=int)[d])) for d in range(3)]
            yield cell, bits, node, beside


def moves_freely(shape, node, beside):
    """Whether one of the nodes of a corner is inside the block."""
    return any(all(0 < k < n - 1 for k, n in zip(p, shape, strict=False)) for p in (node, *beside))


def barrier_functional(points, lengths, delta):
    """Sum of ``|edges|^3 / h(J)`` over corners with a free node, edges by ``lengths``; and the least J."""
    total, least = 0.0, np.inf
    for cell, bits, node, beside in corners_of_hexahedra(points):
        if moves_freely(points.shape, node, beside):
            edges = np.array([(points[p] - points[node]) / lengths[d][cell[d]] for d, p in enumerate(beside)])
            volume = np.linalg.det(edges) * np.prod(1 - 2 * np.array(bits))
            least = min(least, volume)
            total += np.linalg.norm(edges) ** 3 / (0.5 * (volume + np.sqrt(volume**2 + 4 * delta**2)))
    return total, least


def weak_hexahedra(points, sine, free=True):
    """Cells with a corner, free or not, whose scaled Jacobian is no more than ``sine``."""
    weak = np.zeros(tuple(n - 1 for n in points.shape[:3]), bool)
    for cell, bits, node, beside in corners_of_hexahedra(points):
        edges = np.array([points[p] - points[node] for p in beside])
        volume = np.linalg.det(edges) * np.prod(1 - 2 * np.array(bits))
        if moves_freely(points.shape, node, beside) == free:
            weak[cell] |= not volume > sine * np.prod(np.linalg.norm(edges, axis=1))
    return weak


def quasi_newton_step(slope, steps, changes):
    """The BFGS approximation of the inverse Hessian, as a matrix, times the slope."""
    s, y = steps[-1], changes[-1]
    inverse = np.eye(len(slope)) * (s @ y) / (y @ y)
    for s, y in zip(steps, changes, strict=True):
        project = np.eye(len(slope)) - np.outer(y, s) / (y @ s)
        inverse = project.T @ inverse @ project + np.outer(s, s) / (y @ s)
    return inverse @ slope
