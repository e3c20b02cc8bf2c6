"""delaunay_2d and delaunay_3d against the twin that tries all subsets, on tens of thousands of small sets."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from meshcore import InvalidGeometry, InvalidInput, Tetrahedralization, Triangulation, delaunay_2d, delaunay_3d
from meshcore.unstructured import space_insertion
from meshcore.unstructured import triangulation as plane
from tests import naive_delaunay as twin
from tests import point_sets
from tests.core.unstructured import delaunay_checks

ENGINE = {2: delaunay_2d, 3: delaunay_3d}
CLASS = {2: Triangulation, 3: Tetrahedralization}
CELL = {2: "triangle", 3: "tetra"}
both = pytest.mark.parametrize("d", [2, 3])


def cells_of(points, **options):
    """(m, d + 1) int: the cells of the library."""
    d = np.shape(points)[1]
    return ENGINE[d](points, **options).mesh.cells[CELL[d]]


def as_set(cells):
    """Cells as ordered tuples; asserts that none comes twice."""
    found = set(map(tuple, np.sort(cells, axis=1).tolist()))
    assert len(found) == len(cells)
    return found


def assert_equal_the_twin(clouds):
    """For each of (cases, n, d) points the cells are those of the twin, or refused if there are none."""
    for points, expected in zip(clouds, twin.delaunay_cells_of_each(clouds), strict=True):
        if not expected:
            with pytest.raises(InvalidGeometry):
                cells_of(points)
            continue
        found = as_set(cells_of(points))
        assert found == expected, points.tolist()


@both
@pytest.mark.parametrize("name, cases", [
    ("small_lattice", 450), ("small_repeated", 300), ("small_on_spheres", 300), ("small_uniform", 200),
    ("small_rounded", 30), ("small_near_a_line", 15),
])  # fmt: skip
def test_small_sets(name, cases, d):
    """About twenty thousand sets in all, each of three to ten points."""
    rng = np.random.default_rng(2024)
    for n in range(d + 1, 11):
        clouds = point_sets.SMALL[name](cases, n, d, rng)
        assert_equal_the_twin(clouds + 0.0)


@both
def test_all_subsets_of_a_block(d):
    """The 3 x 3 grid, and the cube with its centre: every subset, numbered at random."""
    sites = np.array(list(itertools.product([0.0, 1.0, 2.0], repeat=2)))
    if d == 3:
        sites = np.array([*itertools.product([0.0, 2.0], repeat=3), (1, 1, 1)])
    rng = np.random.default_rng(7)
    for n in range(d + 1, len(sites) + 1):
        subsets = np.array(list(itertools.combinations(range(len(sites)), n)))
        assert_equal_the_twin(sites[rng.permuted(subsets, axis=1)])


def test_all_orders_of_a_square_with_its_centre():
    orders = np.array(list(itertools.permutations(range(5))))
    assert_equal_the_twin(np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.5]])[orders])


def test_all_orders_of_an_octahedron():
    """The survey's figure 26: six points on a sphere."""
    orders = np.array(list(itertools.permutations(range(6))))
    assert_equal_the_twin(np.concatenate([np.eye(3), -np.eye(3)])[orders])


@both
@pytest.mark.parametrize("scale", [1e-300, 1e-8, 1e8, 1e300])
def test_a_scale_changes_nothing(scale, d):
    """Powers of ten round, so the twin sees what the library sees."""
    clouds = point_sets.small_lattice(30, 8, d, np.random.default_rng(3))
    assert_equal_the_twin(clouds * scale)
    assert_equal_the_twin(1e8 + clouds)


coordinates = st.one_of(st.floats(-1, 1), st.integers(-3, 3).map(float), st.sampled_from([1e-30, 1e30, 0.1, 0.3]))


@both
@settings(max_examples=100)
@given(data=st.data())
def test_any_points(d, data):
    points = data.draw(arrays(np.float64, st.tuples(st.integers(d + 1, 9), st.just(d)), elements=coordinates))
    try:
        assert_equal_the_twin(points[None])
    except InvalidInput as error:
        assert "too far apart" in str(error)


@both
@pytest.mark.parametrize("name", point_sets.PLANE)
def test_larger_sets_are_delaunay(name, d):
    points = point_sets.PLANE[name](3000 if d == 2 else 1200, d, np.random.default_rng(9))
    result = ENGINE[d](points)
    cells = result.mesh.cells[CELL[d]]
    delaunay_checks.assert_delaunay(points, cells)
    different = len(np.unique(points + 0.0, axis=0))
    assert result.report.counts["duplicates"] == len(points) - different
    assert len(np.unique(cells)) == different
    assert result.mesh.n_points == len(points)


@both
@pytest.mark.parametrize("name", ["uniform", "shuffled_grid", "rotated_grid", "sphere", "clumps", "duplicates"])
def test_threads_change_no_bit(name, d, monkeypatch):
    # Few points a thread are enough here.
    monkeypatch.setattr(plane, "_POINTS_A_THREAD", 1000)
    monkeypatch.setattr(space_insertion, "_POINTS_A_CHUNK", 200)
    monkeypatch.setattr(space_insertion, "_CELLS_A_RANGE", 1024)
    on_threads = []
    for module, function in ((plane, "insert_on_threads"), (space_insertion, "_insert_in_parts")):
        insertion = getattr(module, function)
        monkeypatch.setattr(module, function, lambda *a, run=insertion: on_threads.append(1) or run(*a))
    points = point_sets.PLANE[name](40_000 if d == 2 else 20_000, d, np.random.default_rng(1))
    alone = cells_of(points, threads=1)
    assert not on_threads
    for threads in (2, 3):
        np.testing.assert_array_equal(cells_of(points, threads=threads), alone)
    assert len(on_threads) >= 2


@both
@pytest.mark.parametrize("name", point_sets.PLANE)
def test_adding_is_as_if_all_had_been_given_at_once(name, d):
    points = point_sets.PLANE[name](400, d, np.random.default_rng(4))
    expected = cells_of(points)
    at = np.flatnonzero([len(np.unique(points[:k], axis=0)) > d + 20 for k in range(len(points))])[0]
    triangulation = None
    for cut in (at, len(points) // 2, len(points) - 1):
        try:
            triangulation = CLASS[d].from_points(points[:cut])
        except InvalidGeometry:  # the first rows of a grid lie in a plane
            continue
        for portion in np.array_split(points[cut:], 3):
            triangulation.add(portion)
        np.testing.assert_array_equal(triangulation.mesh().cells[CELL[d]], expected)
    assert triangulation is not None


@both
@pytest.mark.parametrize("name", ["uniform", "integer_grid", "sphere", "clumps"])
def test_small_sets_grow_one_by_one(name, d):
    points = point_sets.PLANE[name](60, d, np.random.default_rng(8))
    points = np.random.default_rng(8).permutation(points)
    triangulation = CLASS[d].from_points(points[: 4 * d])
    for k in range(4 * d, len(points)):
        triangulation.add(points[k : k + 1])
    np.testing.assert_array_equal(triangulation.mesh().cells[CELL[d]], cells_of(points))


@both
def test_numbers_of_points_do_not_matter_in_general_position(d):
    rng = np.random.default_rng(12)
    points = rng.random((500, d))
    order = rng.permutation(500)
    back = np.argsort(order)
    assert {tuple(sorted(back[list(c)].tolist())) for c in as_set(cells_of(points))} == as_set(cells_of(points[order]))


@both
@pytest.mark.parametrize("name", ["uniform", "integer_grid", "sphere", "duplicates"])
def test_located_cells_hold_their_point(name, d):
    """Inside, on corners, edges and facets, and outside."""
    rng = np.random.default_rng(6)
    points = point_sets.PLANE[name](300, d, rng)
    triangulation = CLASS[d].from_points(points)
    cells = triangulation.mesh().cells[CELL[d]]
    low, high = points.min(axis=0), points.max(axis=0)
    asked = np.concatenate(
        [rng.uniform(low - 0.3, high + 0.3, (100, d)), points[:60], points[cells[:60, :2]].mean(axis=1)]
    )
    found, weights = triangulation.locate(asked)
    for query, cell, weight in zip(asked, found, weights, strict=True):
        holders = _cells_that_hold(points, cells, query)
        assert (cell in holders) if len(holders) else cell == -1
        if cell >= 0:
            assert weight.sum() == pytest.approx(1)
            np.testing.assert_allclose(weight @ points[cells[cell]], query, atol=1e-12)


def _cells_that_hold(points, cells, query):
    """Numbers of the cells with the point inside or on their boundary, exactly, of those whose box holds it."""
    corners = points[cells]
    near = np.flatnonzero(((corners.min(axis=1) <= query) & (corners.max(axis=1) >= query)).all(axis=1))
    with_query = np.vstack([points, query])
    holds = np.ones(len(near), bool)
    for k in range(cells.shape[1]):
        replaced = cells[near].copy()
        replaced[:, k] = len(points)
        holds &= delaunay_checks.orientation(with_query, replaced) >= 0
    return near[holds]
