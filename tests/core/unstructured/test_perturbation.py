"""The twin of the Delaunay engine is right itself: its cells tile the hull, in any order of insertion."""

import itertools
from fractions import Fraction

import numpy as np
import pytest

from tests import naive, point_sets
from tests import naive_delaunay as twin
from tests.core.unstructured import delaunay_checks

both = pytest.mark.parametrize("d", [2, 3])


def facets_of(cell):
    """Each facet with the corner opposite to it."""
    return [(cell[:k] + cell[k + 1 :], cell[k]) for k in range(len(cell))]


def side(points, facet, p):
    """On which side of a facet, its corners in ascending order, a point is."""
    return int(twin.orientation(points[[[*facet, p]]])[0])


def assert_tiles_the_hull(points, cells):
    """Volumes add up, neighbours lie on two sides of their facet, the rest of the facets on the hull."""
    whole = twin.exact(points)
    kept = set(np.flatnonzero(twin.first_of_their_place(points)).tolist())
    assert twin.measure(points, cells) == twin.hull_measure(points)
    owners = {}
    for cell in cells:
        for facet, opposite in facets_of(cell):
            owners.setdefault(facet, []).append(side(whole, facet, opposite))
    for facet, sides in owners.items():
        assert 0 not in sides
        if len(sides) == 1:
            assert {side(whole, facet, p) for p in kept} <= {0, sides[0]}
        else:
            assert sorted(sides) == [-1, 1]
    if cells:
        assert {k for cell in cells for k in cell} == kept


@both
def test_rule_is_a_small_lift(d):
    """With a true small number for eps instead of a symbol, determinants have the sign that the rule says."""
    eps = Fraction(1, 10**6)
    tied = 0
    for points in point_sets.small_lattice(300, d + 2, d, np.random.default_rng(1)):
        ids = list(range(d + 2))
        if side(twin.exact(points), ids[:-2], ids[-2]) == 0:
            continue
        if side(twin.exact(points), ids[:-2], ids[-2]) < 0:
            points[[0, 1]] = points[[1, 0]]
        lifted = [
            [1, *map(Fraction, p), sum(Fraction(x) ** 2 for x in p) + eps ** (i + 1)] for i, p in enumerate(points)
        ]
        above = naive.determinant(np.array(lifted, object))
        function = twin.perturbed_in_circle if d == 2 else twin.perturbed_in_sphere
        assert function(points, *ids) == (-1 if above > 0 else 1)
        tied += abs(above) < 1  # without eps it would be a whole number
    assert tied > 20


@both
@pytest.mark.parametrize("name", point_sets.SMALL)
def test_cells_tile_the_hull(name, d):
    rng = np.random.default_rng(11)
    for n in (d + 1, d + 2, 8, 11):
        for points in point_sets.SMALL[name](8, n, d, rng):
            assert_tiles_the_hull(points, twin.delaunay_cells(points))


def test_figures_of_the_survey():
    """Four points on a circle, octahedron, cube: the lowest number is lifted, so its corner is cut off."""
    square = [[0, 0], [1, 0], [1, 1], [0, 1]]
    assert twin.delaunay_cells(square) == {(0, 1, 3), (1, 2, 3)}
    orders = np.array(list(itertools.permutations(range(6))))
    octahedra = np.concatenate([np.eye(3), -np.eye(3)])[orders]
    for number, cells in enumerate(twin.delaunay_cells_of_each(octahedra)):
        assert len(cells) == 4
        if number % 24 == 0:
            assert_tiles_the_hull(octahedra[number], cells)
    cube = np.array(list(itertools.product([0.0, 1.0], repeat=3)))
    assert_tiles_the_hull(cube, twin.delaunay_cells(cube))


@both
def test_flat_sets_have_no_cells(d):
    line = np.arange(7.0)[:, None] * np.array([1.0, 2.0, -1.0])[:d]
    assert twin.delaunay_cells(line) == set()
    assert twin.delaunay_cells(np.column_stack([np.random.default_rng(2).random((8, d - 1)), np.zeros(8)])) == set()


def inserted_one_by_one(points, order):
    """Bowyer-Watson with ghosts by the contract: a coplanar ghost takes the answer of the cell behind it."""
    whole = twin.exact(points)
    d = whole.shape[1]
    cells = {tuple(sorted(order[: d + 1]))}
    for p in order[d + 1 :]:
        owners = {}
        for cell in cells:
            for facet, opposite in facets_of(cell):
                owners.setdefault(facet, []).append((cell, opposite))
        positive = [list(c) if side(whole, c[:-1], c[-1]) > 0 else [c[1], c[0], *c[2:]] for c in sorted(cells)]
        asked = np.array([[*cell, p] for cell in positive])
        dug = {tuple(sorted(row[:-1])) for row in asked[twin.perturbed_inside(whole, asked) > 0].tolist()}
        hull = {facet: found[0] for facet, found in owners.items() if len(found) == 1}
        ghosts = set()
        for facet, (cell, opposite) in hull.items():
            beyond = -side(whole, facet, p) * side(whole, facet, opposite)
            if beyond > 0 or (beyond == 0 and cell in dug):
                ghosts.add(facet)
        new = []
        for facet, found in owners.items():
            inside = [cell in dug for cell, _ in found] + [facet in ghosts] * (len(found) == 1)
            if inside[0] != inside[1]:
                assert side(whole, facet, p) != 0, "a flat cell"
                new.append(tuple(sorted([*facet, p])))
        cells = (cells - dug) | set(new)
    return cells


@both
@pytest.mark.parametrize("name", ["small_lattice", "small_on_spheres", "small_uniform"])
def test_any_order_of_insertion_gives_the_same_cells(name, d):
    rng = np.random.default_rng(5)
    for points in point_sets.SMALL[name](20, 8, d, rng):
        cells = twin.delaunay_cells(points)
        if not cells:
            continue
        for _ in range(2):
            order = rng.permutation(len(points)).tolist()
            first = next(c for c in itertools.combinations(order, d + 1) if side(twin.exact(points), c[:-1], c[-1]))
            rest = [k for k in order if k not in first]
            assert inserted_one_by_one(points, [*first, *rest]) == cells


def positive(points, cells):
    """(m, d + 1) int: the cells, each turned so that its volume is positive."""
    cells = np.array(sorted(cells))
    turned = delaunay_checks.orientation(points, cells) < 0
    cells[turned, :2] = cells[turned, 1::-1]
    return cells


@both
@pytest.mark.parametrize("name", sorted(set(point_sets.PLANE) - {"duplicates"}))
def test_local_checks_pass_on_the_twin_and_see_every_fault(name, d):
    """The checks for large sets: a lost cell, a turned one, and another number for a corner must each be seen."""
    points = point_sets.PLANE[name](13, d, np.random.default_rng(3))[:16]
    cells = positive(points, twin.delaunay_cells(points))
    delaunay_checks.assert_delaunay(points, cells)
    for fault in range(len(cells)):
        with pytest.raises(AssertionError):
            delaunay_checks.assert_delaunay(points, np.delete(cells, fault, axis=0))
    turned = cells.copy()
    turned[0, :2] = turned[0, 1::-1]
    with pytest.raises(AssertionError):
        delaunay_checks.assert_delaunay(points, turned)


@both
def test_local_checks_see_another_tie(d):
    """The Delaunay cells of other numbers are not those of the rule."""
    points = point_sets.integer_grid(9 if d == 2 else 8, d, None)
    order = np.random.default_rng(1).permutation(len(points))
    back = positive(points, {tuple(sorted(order[list(c)].tolist())) for c in twin.delaunay_cells(points[order])})
    with pytest.raises(AssertionError, match="inside the sphere"):
        delaunay_checks.assert_delaunay(points, back)
