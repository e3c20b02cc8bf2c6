"""Stars, faces and walks in a planar triangulation, against all triangles asked one by one in fractions."""

import itertools
from fractions import Fraction

import numpy as np
import pytest

from meshcore.geometry import predicates
from meshcore.unstructured import _half_edge_kernels as layout
from meshcore.unstructured import _half_edge_query_kernels as queries
from tests import naive, point_sets
from tests import naive_delaunay as twin


class Plane:
    """Triangles laid out as the kernels expect them, with ghosts or a border, and the lists that questions need."""

    def __init__(self, points, cells, ghosts=True):
        whole = twin.exact(points)
        corners = [list(c) if twin.orientation(whole[[list(c)]])[0] > 0 else [c[1], c[0], c[2]] for c in cells]
        directed = {(c[k - 1], c[k]) for c in corners for k in range(3)}
        if ghosts:
            corners += [[v, u, -1] for u, v in sorted(directed) if (v, u) not in directed]
        self.corners = corners
        self.origin, self.twin = np.zeros(4 * len(corners), np.int32), np.full(4 * len(corners), -1, np.int32)
        half_edge = {(c[k], c[(k + 1) % 3]): 4 * t + k for t, c in enumerate(corners) for k in range(3)}
        for (u, v), e in half_edge.items():
            self.origin[e] = u
            self.twin[e] = half_edge.get((v, u), -1)
        self.origin[3::4] = layout.CONSTRAINED  # flags are nobody's corner
        self.vertex_edge = np.empty(len(points), np.int32)
        queries.map_edges(self.origin, len(corners), self.vertex_edge)
        self.xy = np.asarray(points, float).ravel()
        self.found, self.faces = np.empty(len(corners), np.int32), np.empty(6 * len(corners), np.int64)
        self.work = predicates.workspace()

    def vertices(self, face):
        """The vertices of a face as the kernels write it."""
        return frozenset(v for k, v in enumerate(self.corners[face >> 3]) if face >> k & 1)

    def walk(self, a, b, room=None):
        faces = self.faces[:room]
        count = queries.walk_segment(
            self.xy, self.origin, self.twin, self.vertex_edge, a, b, self.found, faces, self.work
        )  # fmt: skip
        return count if count < 0 else [self.vertices(face) for face in faces[:count]]


def met_by_segment(points, cells, a, b):
    """The faces whose insides the open segment from a to b meets, in order: barycentric coordinates cell by cell."""
    met = {}
    for cell in cells:
        area = naive.side(*(points[v] for v in cell))
        ends = [
            [naive.side(*(points[p if i == k else v] for i, v in enumerate(cell))) / area for k in range(3)]
            for p in (a, b)
        ]
        roots = {x / (x - y) for x, y in zip(*ends, strict=True) if x != y}
        stops = sorted({Fraction(0), Fraction(1)} | {r for r in roots if 0 < r < 1})
        for t in [s for s in stops if 0 < s < 1] + [(s + e) / 2 for s, e in itertools.pairwise(stops)]:
            weights = [x + t * (y - x) for x, y in zip(*ends, strict=True)]
            if min(weights) >= 0:
                met[frozenset(v for v, weight in zip(cell, weights, strict=True) if weight > 0)] = t
    return sorted(met, key=met.get)


def planes():
    rng = np.random.default_rng(23)
    for name in ("small_lattice", "small_on_spheres", "small_uniform", "small_rounded"):
        for points in point_sets.SMALL[name](2, 9, 2, rng):
            yield name, points
    yield "grid", point_sets.integer_grid(16, 2, None)
    yield "octahedra", point_sets.octahedra(20, 2, None)


CASES = [(name, points, sorted(twin.delaunay_cells(points))) for name, points in planes()]
each_set = pytest.mark.parametrize("points, cells", [c[1:] for c in CASES], ids=[c[0] for c in CASES])


@each_set
def test_star_of_a_vertex_turns_once(points, cells):
    plane = Plane(points, cells)
    for v in range(len(points)):
        expected = {4 * t + c.index(v) for t, c in enumerate(plane.corners) if v in c}
        assert plane.vertex_edge[v] in expected
        for start in expected:
            count = queries.star(plane.origin, plane.twin, start, plane.found)
            found = plane.found[:count].tolist()
            assert set(found) == expected
            assert len(found) == len(expected)
            for e, after in zip(found, [*found[1:], found[0]], strict=True):
                assert plane.corners[e >> 2][((e & 3) + 2) % 3] == plane.corners[after >> 2][((after & 3) + 1) % 3]
        short = np.empty(len(expected) - 1, np.int32)
        assert queries.star(plane.origin, plane.twin, min(expected), short) == queries.FULL_LIST


@each_set
def test_star_at_a_border_begins_at_its_clockwise_end(points, cells):
    plane = Plane(points, cells, ghosts=False)
    for v in range(len(points)):
        expected = {4 * t + c.index(v) for t, c in enumerate(plane.corners) if v in c}
        for start in expected:
            count = queries.star(plane.origin, plane.twin, start, plane.found)
            found = plane.found[:count].tolist()
            assert set(found) == expected
            assert (plane.twin[found[0]] < 0) == any(plane.twin[e] < 0 for e in expected)


@each_set
@pytest.mark.parametrize("ghosts", [True, False])
def test_edges_and_triangles_are_found(points, cells, ghosts):
    plane = Plane(points, cells, ghosts)
    faces = {frozenset(f) for c in cells for size in (2, 3) for f in itertools.combinations(c, size)}
    for size in (2, 3):
        for asked in itertools.permutations(range(len(points)), size):
            v, a, b = (*asked, -1)[:3]
            face = queries.find_face(plane.origin, plane.twin, plane.vertex_edge[v], a, b, plane.found)
            if frozenset(asked) in faces:
                assert plane.vertices(face) == frozenset(asked)
            else:
                assert face == queries.ABSENT


@each_set
@pytest.mark.parametrize("ghosts", [True, False])
def test_walk_meets_what_the_segment_meets(points, cells, ghosts):
    plane = Plane(points, cells, ghosts)
    pairs = list(itertools.permutations(range(len(points)), 2))
    for a, b in np.random.default_rng(1).permutation(pairs)[:40].tolist():
        assert plane.walk(a, b) == met_by_segment(points, cells, a, b), (a, b)


def test_walk_ends_where_triangles_are_missing():
    """A frame of a grid without its middle: only segments along the frame get through."""
    points = point_sets.integer_grid(16, 2, None)
    cells = [c for c in twin.delaunay_cells(points) if not set(c) <= {5, 6, 9, 10}]
    plane = Plane(points, cells, ghosts=False)
    assert plane.walk(0, 15) == queries.ABSENT
    assert plane.walk(5, 10) == queries.ABSENT
    assert len(plane.walk(5, 6)) == 1


def test_walk_asks_for_longer_lists():
    points = point_sets.integer_grid(16, 2, None)
    plane = Plane(points, twin.delaunay_cells(points))
    whole = plane.walk(1, 14)
    assert len(whole) > 4
    for room in range(len(whole)):
        assert plane.walk(1, 14, room) == queries.FULL_LIST
    assert plane.walk(1, 14, len(whole) + 1) == whole
