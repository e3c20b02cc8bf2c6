"""Delaunay triangulation of points."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial import ConvexHull, Delaunay

from meshcore import InvalidGeometry, InvalidInput, delaunay_2d
from tests import naive
from tests.core.unstructured import invariants


def used(mesh):
    return mesh.compacted()


@settings(max_examples=60)
@given(arrays(np.float64, st.tuples(st.integers(3, 25), st.just(2)), elements=st.integers(0, 6).map(float)))
def test_small_grids_with_repeats_are_delaunay(points):
    if np.linalg.matrix_rank(points - points[0]) < 2:
        with pytest.raises(InvalidGeometry):
            delaunay_2d(points)
        return
    mesh = used(delaunay_2d(points))
    invariants.assert_is_triangulation(mesh)
    assert mesh.n_points == len(np.unique(points, axis=0))
    assert naive.delaunay_circles_are_empty(mesh.points[:, :2].tolist(), invariants.triangles(mesh))
    assert float(invariants.area(mesh)) == pytest.approx(ConvexHull(points).volume, rel=1e-12)


@settings(max_examples=40)
@given(arrays(np.float64, st.tuples(st.integers(3, 20), st.just(2)), elements=st.floats(-1, 1)))
def test_any_points_are_delaunay(points):
    try:
        mesh = used(delaunay_2d(points))
    except InvalidGeometry:
        different = np.unique(points + 0.0, axis=0)
        a, b = different[0], different[-1]
        assert all(naive.side(a, b, c) == 0 for c in different)
        return
    except InvalidInput as error:
        assert "too far apart" in str(error)
        return
    invariants.assert_is_triangulation(mesh)
    assert naive.delaunay_circles_are_empty(mesh.points[:, :2].tolist(), invariants.triangles(mesh))


@pytest.mark.parametrize("seed", [5, 6])
def test_the_triangles_are_qhulls(seed):
    points = np.random.default_rng(seed).random((500, 2))
    ours = {tuple(sorted(t)) for t in invariants.triangles(delaunay_2d(points))}
    assert ours == {tuple(sorted(t)) for t in Delaunay(points).simplices.tolist()}


@pytest.mark.parametrize("scale", [1e-8, 1.0, 1e8])
def test_degenerate_clouds(scale):
    grid = np.stack(np.meshgrid(np.arange(20.0), np.arange(30.0)), axis=-1).reshape(-1, 2)
    angle = np.linspace(0, 2 * np.pi, 9000, endpoint=False)
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    line = np.column_stack([np.arange(300.0), 0.3 * np.arange(300.0) + 0.1])
    for points in (grid, grid * 0.1, grid @ [[0.6, 0.8], [-0.8, 0.6]], np.append(circle, [[0, 0]], axis=0), line):
        mesh = delaunay_2d(points * scale)
        invariants.assert_is_triangulation(mesh)
    mesh = delaunay_2d(grid * scale)
    assert mesh.n_cells == 2 * 19 * 29


def test_the_same_points_give_the_same_triangles():
    points = np.random.default_rng(7).random((300, 2))
    assert (delaunay_2d(points).cells["triangle"] == delaunay_2d(points).cells["triangle"]).all()


@pytest.mark.parametrize(
    "points, message",
    [
        (np.empty((0, 2)), "three different points, got 0"),
        ([[0, 0], [1, 1]], "three different points, got 2"),
        ([[0, 0], [1, 1], [0, 0]], "three different points, got 2"),
        ([[0, 0], [1, 1], [2, 2], [3, 3]], "one line"),
        ([[0, 0, 0], [1, 0, 2], [0, 1, 0]], "z = 0"),
        ([[0, 0], [1, np.nan], [0, 1]], "not finite"),
    ],
)
def test_bad_points_are_refused(points, message):
    with pytest.raises(InvalidInput, match=message):
        delaunay_2d(points)
