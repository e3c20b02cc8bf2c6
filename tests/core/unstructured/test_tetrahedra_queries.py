"""Stars, rings, faces and walks in a triangulation of space, against all cells asked one by one in fractions."""

import itertools
from collections import Counter
from fractions import Fraction

import numpy as np
import pytest

from meshcore import Tetrahedralization
from meshcore.geometry import predicates
from meshcore.unstructured import _tetrahedra_kernels as layout
from meshcore.unstructured import _tetrahedra_query_kernels as queries
from tests import naive, point_sets
from tests import naive_delaunay as twin


class Space:
    """Cells laid out as the kernels expect them, ghosts included, with the lists that questions need."""

    def __init__(self, points, cells):
        self.points = np.asarray(points, float)
        whole = twin.exact(points)
        corners = [list(c) if twin.orientation(whole[[list(c)]])[0] > 0 else [c[1], c[0], *c[2:]] for c in cells]
        facets = Counter(frozenset(c) - {v} for c in corners for v in c)
        for c in corners[:]:
            for k, around in enumerate(zip(layout.FACET_A, layout.FACET_B, layout.FACET_C, strict=True)):
                if facets[frozenset(c) - {c[k]}] == 1:
                    corners.append([c[i] for i in around] + [-1])
        self.corners = np.array(corners)
        self.cells = np.zeros(16 * len(corners), np.int32)
        beyond = {}
        for t, c in enumerate(corners):
            self.cells[16 * t : 16 * t + 4] = c
            for k in range(4):
                beyond.setdefault(frozenset(c) - {c[k]}, []).append((t, k))
        for (t, k), (u, j) in beyond.values():
            self.cells[16 * t + 4 + k] = u << 3 | j
            self.cells[16 * u + 4 + j] = t << 3 | k
        self.cell_of = np.empty(len(points), np.int32)
        queries.map_vertices(self.cells, len(corners), self.cell_of)
        self.records = np.column_stack([self.points, np.zeros(len(points))]).ravel()
        self.marks, self.stamp = np.zeros(len(corners), np.int32), np.zeros(1, np.int32)
        self.found, self.link = np.empty(len(corners), np.int32), np.empty(len(corners), np.int32)
        self.faces = np.empty(8 * len(corners), np.int64)
        self.work = predicates.workspace()

    def vertices(self, face):
        """The vertices of a face as the kernels write it."""
        return frozenset(int(v) for k, v in enumerate(self.corners[face >> 4]) if face >> k & 1)

    def walk(self, a, b, room=None):
        faces = self.faces[:room]
        count = queries.walk_segment(
            self.records, self.cells, self.cell_of, a, b, self.marks, self.stamp, self.found, self.link, faces,
            self.work,
        )  # fmt: skip
        return count if count < 0 else [self.vertices(face) for face in faces[:count]]


def met_by_segment(points, cells, a, b):
    """The faces whose insides the open segment from a to b meets, in order: barycentric coordinates cell by cell."""
    whole, cells = twin.exact(points), np.array(cells)
    volumes = {}
    for p in (a, b):
        replaced = np.where(np.eye(4, dtype=bool), p, cells[:, None])
        corners = whole[np.concatenate([cells[:, None], replaced], axis=1)]
        volumes[p] = naive.determinant(corners[:, :, 1:] - corners[:, :, :1]).tolist()
    met = {}
    for cell, at_a, at_b in zip(cells.tolist(), volumes[a], volumes[b], strict=True):
        ends = [[Fraction(volume, at[0]) for volume in at[1:]] for at in (at_a, at_b)]
        roots = {Fraction(x, x - y) for x, y in zip(*ends, strict=True) if x != y}
        stops = sorted({Fraction(0), Fraction(1)} | {r for r in roots if 0 < r < 1})
        for t in [s for s in stops if 0 < s < 1] + [(s + e) / 2 for s, e in itertools.pairwise(stops)]:
            weights = [x + t * (y - x) for x, y in zip(*ends, strict=True)]
            if min(weights) >= 0:
                met[frozenset(v for v, weight in zip(cell, weights, strict=True) if weight > 0)] = t
    return sorted(met, key=met.get)


def sets():
    rng = np.random.default_rng(17)
    for name in ("small_lattice", "small_on_spheres", "small_uniform"):
        for points in point_sets.SMALL[name](2, 13, 3, rng):
            yield name, points
    yield "grid", point_sets.integer_grid(27, 3, None)
    yield "octahedra", point_sets.octahedra(7 * 8, 3, None)[:14]
    yield "rotated", point_sets.rotated_grid(27, 3, None)[:18]


def spaces():
    for name, points in sets():
        cells = sorted(twin.delaunay_cells(points))
        if cells:
            yield name, points, cells, Space(points, cells)


CASES = list(spaces())
each_set = pytest.mark.parametrize("points, cells, space", [c[1:] for c in CASES], ids=[c[0] for c in CASES])


@each_set
def test_star_of_a_vertex(points, cells, space):
    for v in range(len(points)):
        expected = {t for t, c in enumerate(space.corners.tolist()) if v in c}
        assert space.cell_of[v] in expected
        for start in expected:
            count = queries.star(space.cells, start, v, space.marks, space.stamp, space.found)
            assert sorted(space.found[:count].tolist()) == sorted(expected)
        short = np.empty(len(expected) - 1, np.int32)
        assert queries.star(space.cells, start, v, space.marks, space.stamp, short) == queries.FULL_LIST


@each_set
def test_ring_of_an_edge_is_in_order(points, cells, space):
    """Links turn once round the edge: each cell is positive with the next link, ghosts where the hull is."""
    for p, q in itertools.permutations(range(len(points)), 2):
        expected = {t for t, c in enumerate(space.corners.tolist()) if {p, q} <= set(c)}
        for start in expected:
            count = queries.ring(space.cells, start, p, q, space.found, space.link)
            found, link = space.found[:count].tolist(), space.link[:count].tolist()
            assert sorted(found) == sorted(expected)
            for t, r, s in zip(found, link, [*link[1:], link[0]], strict=True):
                assert {p, q, r, s} == set(space.corners[t].tolist())
                if -1 not in (r, s):
                    assert twin.orientation(twin.exact(points)[[[p, q, r, s]]])[0] > 0
        if expected:
            short = np.empty(len(expected) - 1, np.int32)
            assert queries.ring(space.cells, start, p, q, short, space.link) == queries.FULL_LIST


@each_set
def test_edges_and_facets_are_found(points, cells, space):
    edges = {frozenset(e) for c in cells for e in itertools.combinations(c, 2)}
    facets = {frozenset(f) for c in cells for f in itertools.combinations(c, 3)}
    for size, faces in ((2, edges), (3, facets)):
        for asked in itertools.combinations(range(len(points)), size):
            v, a, b = (*asked, -1)[:3]
            face = queries.find_face(space.cells, space.cell_of[v], v, a, b, space.marks, space.stamp, space.found)
            if frozenset(asked) in faces:
                assert space.vertices(face) == frozenset(asked)
            else:
                assert face == queries.ABSENT


@each_set
def test_walk_meets_what_the_segment_meets(points, cells, space):
    pairs = list(itertools.permutations(range(len(points)), 2))
    for a, b in np.random.default_rng(1).permutation(pairs)[:60].tolist():
        assert space.walk(a, b) == met_by_segment(points, cells, a, b), (a, b)


def test_walk_asks_for_longer_lists():
    _, points, _, space = CASES[-1]
    a, b = 0, len(points) - 1
    whole = space.walk(a, b)
    assert len(whole) > 4
    for room in range(len(whole)):
        assert space.walk(a, b, room) == queries.FULL_LIST
    assert space.walk(a, b, len(whole) + 1) == whole


def test_segment_and_facet():
    """Every way of passing a triangle on a lattice, against the place where the line meets its plane."""
    rng = np.random.default_rng(4)
    found = Counter()
    for points in rng.integers(0, 4, (3000, 5, 3)).astype(float):
        a, b, *corners = naive.whole_numbers(points)
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        slope = (b - a) @ normal
        if slope == 0:
            continue
        place = a * slope + (b - a) * ((corners[0] - a) @ normal)  # times slope
        weights = [
            np.cross(corners[i] * slope - place, corners[j] * slope - place) @ normal
            for i, j in ((1, 2), (2, 0), (0, 1))
        ]
        expected = 0 if min(weights) < 0 else sum(1 << k for k, weight in enumerate(weights) if weight > 0)
        records = np.column_stack([points, np.zeros(5)]).ravel()
        face = queries.segment_and_facet(records, 0, 1, 2, 3, 4, predicates.workspace())
        assert face == expected
        found[face] += 1
    assert set(found) == set(range(8))


@pytest.mark.parametrize("name", ["uniform", "shuffled_grid", "sphere"])
def test_map_of_vertices_is_kept_while_points_are_added(name):
    points = point_sets.SPACE[name](400, 3, np.random.default_rng(2))
    triangulation = Tetrahedralization.from_points(points[:200])
    cell_of = triangulation._space.map_vertices()
    for portion in [points[:200], *np.array_split(points[200:], 4), points[:9]]:  # the first and last are known
        triangulation.add(portion)
        space = triangulation._space
        assert len(space.cell_of) == space.n_vertices >= len(cell_of)
        used = np.flatnonzero(space.cell_of >= 0)
        assert len(used) == len(np.unique(triangulation.points, axis=0))
        corners = space.cells.reshape(-1, 16)[space.cell_of[used], :4]
        assert (corners == used[:, None]).any(axis=1).all()
        assert (corners[:, 0] >= 0).all(), "a free cell"
