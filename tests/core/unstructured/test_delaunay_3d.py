"""Delaunay triangulation of points in space."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from meshcore import Cancelled, InvalidGeometry, InvalidInput, Mesh, Tetrahedralization, delaunay_3d
from meshcore.unstructured import _delaunay_3d_kernels as kernels
from meshcore.unstructured import space_insertion
from meshcore.unstructured.space_cells import SpaceCells
from meshcore.unstructured.thin_clouds import places_along_line_in_space
from tests import naive, naive_delaunay, point_sets
from tests.core.unstructured import delaunay_checks


def tetrahedra(points, **keywords):
    return delaunay_3d(points, **keywords).mesh.cells["tetra"]


def as_set(cells):
    return {tuple(sorted(cell)) for cell in cells.tolist()}


def spans_space(points):
    return len(points) > 0 and np.linalg.matrix_rank(points - points[0]) == 3


@pytest.fixture
def small_chunks(monkeypatch):
    """Few points a chunk and a thread, so that small sets take the ways of large ones."""
    monkeypatch.setattr(space_insertion, "_POINTS_A_CHUNK", 40)
    monkeypatch.setattr(space_insertion, "_CELLS_A_RANGE", 64)


@pytest.mark.parametrize("name", point_sets.SMALL)
def test_small_sets_are_those_of_the_twin(name):
    clouds = point_sets.SMALL[name](150, 9, 3, np.random.default_rng(4))
    for points, expected in zip(clouds, naive_delaunay.delaunay_cells_of_each(clouds), strict=True):
        if expected:
            assert as_set(tetrahedra(points)) == expected
        else:
            with pytest.raises(InvalidGeometry):
                delaunay_3d(points)


@settings(max_examples=80, deadline=None)
@given(arrays(np.float64, st.tuples(st.integers(4, 12), st.just(3)), elements=st.integers(0, 3).map(float)))
def test_lattice_points_with_repeats(points):
    if not spans_space(points):
        with pytest.raises(InvalidGeometry):
            delaunay_3d(points)
        return
    cells = tetrahedra(points)
    assert as_set(cells) == naive_delaunay.delaunay_cells(points)
    assert naive_delaunay.measure(points, cells.tolist()) == naive_delaunay.hull_measure(points)


@pytest.mark.parametrize("name", [name for name in point_sets.SPACE if name not in ("tiny", "huge")])
def test_degenerate_sets(name):
    points = point_sets.SPACE[name](1500, 3, np.random.default_rng(2))
    delaunay_checks.assert_delaunay(points, tetrahedra(points))


@pytest.mark.parametrize("scale", [1e-300, 1e-9, 1e9, 1e300])
def test_scale_does_not_matter(scale):
    grid = point_sets.shuffled_grid(200, 3, np.random.default_rng(5))
    exact = np.ldexp(grid, int(np.log2(scale)))
    assert (tetrahedra(exact) == tetrahedra(grid)).all()


@pytest.mark.parametrize("name", ["uniform", "shuffled_grid", "sphere", "clumps", "duplicates"])
def test_threads_change_nothing(name, small_chunks):
    points = point_sets.SPACE[name](1500, 3, np.random.default_rng(6))
    one = tetrahedra(points, threads=1)
    for threads in (2, 3, 4):
        assert np.array_equal(tetrahedra(points, threads=threads), one)


@pytest.mark.parametrize("name", ["uniform", "shuffled_grid", "linspace_grid", "duplicates", "octahedra"])
def test_adding_is_as_giving_all_at_once(name):
    points = np.random.default_rng(8).permutation(point_sets.SPACE[name](600, 3, np.random.default_rng(7)))
    whole = Tetrahedralization.from_points(points)
    grown = Tetrahedralization.from_points(points[:50])
    for start, stop in ((50, 60), (60, 61), (61, 400), (400, len(points))):
        grown.add(points[start:stop])
    assert np.array_equal(grown.mesh().cells["tetra"], whole.mesh().cells["tetra"])
    assert np.array_equal(grown.merged, whole.merged) and np.array_equal(grown.kept, whole.kept)
    assert np.array_equal(grown.points, points)


def test_adding_points_of_another_magnitude():
    points = np.random.default_rng(9).random((60, 3))
    grown = Tetrahedralization.from_points(1e-70 * points[:30])
    grown.add(1e-20 * points[30:])
    together = np.concatenate([1e-70 * points[:30], 1e-20 * points[30:]])
    assert np.array_equal(grown.mesh().cells["tetra"], tetrahedra(together))


def test_located_points_lie_in_their_cells():
    rng = np.random.default_rng(10)
    points = rng.permutation(point_sets.integer_grid(343, 3, rng))
    triangulation = Tetrahedralization.from_points(points)
    asked = np.concatenate([points[:40], (points[:40] + points[40:80]) / 2, rng.uniform(-3, 9, (100, 3))])
    cell, weights = triangulation.locate(asked)
    inside = ((asked >= 0) & (asked <= 6)).all(axis=1)
    assert np.array_equal(cell >= 0, inside) and np.isnan(weights[~inside]).all()
    corners = triangulation.points[triangulation.mesh().cells["tetra"][cell[inside]]]
    assert weights[inside].min() >= -1e-12
    assert np.allclose(np.einsum("ij,ijk->ik", weights[inside], corners), asked[inside])


def test_points_near_a_line_are_inserted_along_it():
    """Along a Hilbert curve the slivers that are crossed and removed are ever more with more points."""
    x = np.random.default_rng(12).random(4000)
    found = []
    for n in (1000, 4000):
        line = np.column_stack([x[:n], 0.3 * x[:n] + 0.1, -0.7 * x[:n] + 0.2])
        order = space_insertion.space_order(line)
        assert len(order.todo) == n - 4 and (np.diff(order.points.reshape(-1, 4)[order.todo, 0]) > 0).all()
        space = SpaceCells(order.points, order.rows, order.first, order.quantum, order.extent)
        space_insertion.insert(space, order.todo, 1)
        found.append(space.state[[kernels.STEPS, kernels.REMOVED]] / n)
    assert (found[1] < [8, 15]).all() and (found[1] < 1.2 * found[0]).all()
    for name in ("uniform", "integer_grid", "clumps"):
        assert places_along_line_in_space(point_sets.SPACE[name](500, 3, np.random.default_rng(1))) is None


@pytest.mark.parametrize("name", ["integer_grid", "octahedra", "uniform"])
def test_between_cells_the_lowest_is_located(name):
    """Places on corners, edges and facets, whatever the walk came by; with more at one place than a list takes."""
    rng = np.random.default_rng(6)
    triangulation = Tetrahedralization.from_points(point_sets.SPACE[name](64, 3, rng))
    mesh = triangulation.mesh()
    cells = rng.permutation(mesh.cells["tetra"])[:30]
    corners = np.round(8 * mesh.points[cells]) / 8 if name != "uniform" else mesh.points[cells]
    asked = np.concatenate([corners[:, 0], corners[:, :2].mean(axis=1), corners[:, [0, 1, 2, 2]].mean(axis=1)])
    expected, _ = naive.located(mesh.points, mesh.cells["tetra"], asked)
    assert triangulation.locate(asked).cell.tolist() == expected
    assert triangulation.locate(asked[::-1]).cell.tolist() == expected[::-1]


def test_a_corner_of_many_cells_is_located():
    """The hub of a ball: more cells than the list has room for at first."""
    ball = point_sets.sphere(300, 3, np.random.default_rng(8))
    triangulation = Tetrahedralization.from_points(np.concatenate([ball, np.zeros((1, 3))]))
    cells = triangulation.mesh().cells["tetra"]
    assert (cells == 300).any(axis=1).sum() > 500
    lowest = np.flatnonzero((cells == 300).any(axis=1))[0]
    assert triangulation.locate([[0, 0, 0], [0, 0, 0.1], [0, 0, 0]]).cell[[0, 2]].tolist() == [lowest, lowest]


def test_the_caller_may_change_his_points():
    points = np.random.default_rng(3).random((50, 3))
    triangulation = Tetrahedralization.from_points(points)
    before = triangulation.mesh()
    more = points[:5] + 0.01
    triangulation.add(more)
    for array in (points, more, before.points):
        array[:] = 7.0
    after = triangulation.mesh()
    delaunay_checks.assert_delaunay(after.points, after.cells["tetra"])
    assert after.points.max() < 2.0


def test_adding_takes_no_copy_of_what_is_there():
    """Cost in proportion to what is added: all large buffers stay where they are, once they have room."""
    rng = np.random.default_rng(3)
    triangulation = Tetrahedralization.from_points(rng.random((2000, 3)))
    triangulation.add(rng.random((1, 3)))
    space = triangulation._space
    names = ("points", "rows", "cells", "planes", "place")
    buffers = [triangulation._buffer, *(getattr(space, name) for name in names)]
    for _ in range(20):
        triangulation.add(rng.random((3, 3)))
    assert triangulation._space is space
    for buffer, now in zip(buffers, [triangulation._buffer, *(getattr(space, name) for name in names)], strict=True):
        assert buffer is now
    delaunay_checks.assert_delaunay(triangulation.points, triangulation.mesh().cells["tetra"])


@pytest.mark.parametrize("threads", [1, 2])
def test_adding_that_is_broken_off_adds_nothing(threads, small_chunks):
    rng = np.random.default_rng(7)
    points, more = rng.random((300, 3)), rng.random((400, 3))
    triangulation = Tetrahedralization.from_points(points)
    triangulation.add(points[:5] + 0.01)
    before = triangulation.mesh().cells["tetra"]
    triangulation.locate(points)
    with pytest.raises(Cancelled):
        triangulation.add(more, threads=threads, progress=lambda fraction, message: fraction < 0.5)
    assert np.array_equal(triangulation.mesh().cells["tetra"], before)
    assert np.array_equal(
        (before[triangulation.locate(points).cell] == np.arange(300)[:, None]).sum(axis=1), np.ones(300)
    )
    triangulation.add(more, threads=threads)
    expected = Tetrahedralization.from_points(np.concatenate([points, points[:5] + 0.01, more]))
    assert np.array_equal(triangulation.mesh().cells["tetra"], expected.mesh().cells["tetra"])


def test_repeated_points_are_reported():
    cube = point_sets.integer_grid(8, 3, None)
    mesh, report = delaunay_3d(np.concatenate([cube, cube[[3, 5]]]))
    assert report.counts == {"points": 10, "tetrahedra": mesh.n_cells, "duplicates": 2}
    assert report.warnings == ["2 points at the place of others got no tetrahedra: 8 on 3, 9 on 5"]


@pytest.mark.parametrize(
    "points, message",
    [
        (np.empty((0, 3)), "four different points, got 0"),
        (np.eye(3), "four different points, got 3"),
        (np.tile(np.eye(3), (3, 1)), "four different points, got 3"),
        (np.outer(np.arange(9.0), [1.0, 2.0, 3.0]), "all 9 points lie on one line"),
        (np.random.default_rng(0).random((20, 2)), "all 20 points lie in one plane; use delaunay_2d"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, np.nan]], "point 3 is"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, np.inf]], "point 3 is"),
    ],
)
def test_points_that_do_not_span_space(points, message):
    with pytest.raises(InvalidGeometry, match=message):
        delaunay_3d(points)


@pytest.mark.parametrize(
    "points, keywords",
    [
        (np.zeros(3), {}),
        (np.zeros((4, 4)), {}),
        ("points", {}),
        (np.eye(4, 3), {"threads": 0}),
        (np.eye(4, 3), {"threads": 1.5}),
        (np.eye(4, 3), {"threads": 256}),
        ([[0, 0, 0], [1e-200, 0, 0], [0, 1, 0], [0, 0, 1]], {}),
    ],
)
def test_what_is_no_input(points, keywords):
    with pytest.raises(InvalidInput):
        delaunay_3d(points, **keywords)


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("fraction", [0.0, 0.3, 0.6])
def test_cancelling(threads, fraction, small_chunks):
    points = np.random.default_rng(1).random((5000, 3))
    with pytest.raises(Cancelled):
        delaunay_3d(points, threads=threads, progress=lambda done, message: done < fraction)


@pytest.mark.parametrize("threads", [0, 256, 2.0, True, "two", np.nan])
def test_bad_numbers_of_threads_are_refused(threads):
    with pytest.raises(InvalidInput, match="threads"):
        Tetrahedralization.from_points(np.eye(4, 3), threads=threads)


def test_a_mesh_gives_its_points():
    points = np.random.default_rng(1).random((50, 3))
    assert np.array_equal(tetrahedra(Mesh(points, {"vertex": [[0]]})), tetrahedra(points))
