"""Measures between neighbouring cells."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from meshcore import Mesh, StructuredGrid, quality
from meshcore.quality.neighbours import geometry
from tests import naive


def random_triangles(seed, count=30):
    points = np.random.default_rng(seed).random((count, 2))
    return Mesh(points, {"triangle": Delaunay(points).simplices.astype(np.int64)})


def box(n=3, stretch=1.0):
    """Bricks, whose sizes grow along x."""
    x = np.cumsum(np.concatenate([[0.0], stretch ** np.arange(n)]))
    axes = np.meshgrid(x, np.arange(n + 1.0), np.arange(n + 1.0), indexing="ij")
    return StructuredGrid(np.stack(axes, axis=-1))


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 100_000))
def test_planar_meshes_as_the_plain_twin(seed):
    mesh = random_triangles(seed)
    twin = naive.openfoam_facets(mesh.get("triangle").tolist(), mesh.points[:, :2].tolist())
    angles, skews = quality.non_orthogonality(mesh), quality.face_skewness(mesh)
    for k, ends in enumerate(mesh.facets.nodes[:, :2].tolist()):
        angle, skew = twin[frozenset(ends)]
        assert np.isnan(angles[k]) if angle is None else angles[k] == pytest.approx(angle, abs=1e-5)
        assert skews[k] == pytest.approx(skew, rel=1e-7, abs=1e-9)


def test_quads_as_the_plain_twin():
    points = [[0, 0], [1, 0], [2.5, 0.2], [0, 1], [1.2, 0.9], [2.2, 1.4], [0.1, 2], [1, 2.2], [2, 2]]
    cells = [[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]]
    mesh = Mesh(points, {"quad": cells})
    twin = naive.openfoam_facets(cells, points)
    for ends, angle, skew in zip(
        mesh.facets.nodes[:, :2].tolist(), quality.non_orthogonality(mesh), quality.face_skewness(mesh), strict=True
    ):
        assert skew == pytest.approx(twin[frozenset(ends)][1], rel=1e-9, abs=1e-12)
        assert np.isnan(angle) or angle == pytest.approx(twin[frozenset(ends)][0], rel=1e-7)


def test_bricks_are_orthogonal_and_not_skewed():
    mesh = box(3, 2.0).to_mesh()
    assert np.nanmax(quality.non_orthogonality(mesh)) == 0
    assert quality.face_skewness(mesh).max() < 1e-12
    assert np.nanmax(quality.size_jump(mesh)) == pytest.approx(2.0)
    assert (~np.isnan(quality.size_jump(mesh))).sum() == (mesh.facets.shared == 2).sum() == 3 * 9 * 2


def test_sheared_bricks_lean_by_the_angle_of_shear():
    mesh = box(3).to_mesh()
    sheared = mesh.with_points(mesh.points + mesh.points[:, [2]] * [[0.5, 0, 0]])
    angles = quality.non_orthogonality(sheared)
    assert np.nanmax(angles) == pytest.approx(np.degrees(np.arctan(0.5)))


def test_a_layer_of_prisms_is_as_the_plane_it_stands_on():
    """OpenFOAM's own way of doing two dimensions."""
    plane = random_triangles(5)
    n, cells = plane.n_points, plane.get("triangle")
    solid = Mesh(np.concatenate([plane.points, plane.points + [0, 0, 1e-3]]), {"wedge": np.hstack([cells, cells + n])})
    for name in ("non_orthogonality", "size_jump"):
        np.testing.assert_allclose(quality.measure(solid, name), quality.measure(plane, name), rtol=1e-7, atol=1e-7)


def test_centres_and_volumes_of_mixed_solids():
    points = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [0, 0, 2], [2, 0, 2], [2, 2, 2], [0, 2, 2], [1, 1, 3.5]]
    mesh = Mesh(points, {"hexahedron": [[0, 1, 2, 3, 4, 5, 6, 7]], "pyramid": [[4, 5, 6, 7, 8]]})
    _, _, centres, sizes = geometry(mesh)
    np.testing.assert_allclose(sizes, [8, 2])
    np.testing.assert_allclose(centres, [[1, 1, 1], [1, 1, 2 + 1.5 / 4]])
    np.testing.assert_allclose(sizes, quality.measure(mesh, "volume"))


@settings(deadline=None, max_examples=10)
@given(st.integers(0, 1000))
def test_turning_a_plane_into_space_changes_nothing(seed):
    turn, _ = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))
    mesh = random_triangles(seed)
    turned = mesh.with_points(mesh.points @ turn.T)
    for name in ("non_orthogonality", "face_skewness", "size_jump", "edge_jump"):
        np.testing.assert_allclose(
            quality.measure(turned, name), quality.measure(mesh, name), rtol=1e-6, atol=1e-6, err_msg=name
        )


def test_per_cell_is_the_worst_facet():
    grid = box(3, 3.0)
    jumps = quality.measure(grid, "size_jump")
    assert jumps.shape == (3, 3, 3)
    np.testing.assert_allclose(jumps, 3.0)
    alone = Mesh([[0, 0], [1, 0], [0, 1]], {"triangle": [[0, 1, 2]]})
    assert np.isnan(quality.measure(alone, "size_jump")).all()
    assert np.isfinite(quality.measure(alone, "face_skewness")).all()
    lines = Mesh([[0, 0], [1, 0]], {"line": [[0, 1]]})
    assert np.isnan(quality.measure(lines, "size_jump")).all()


def test_jump_beside_an_inverted_or_flat_cell_is_infinite():
    points = [[0, 0], [1, 0], [0, 1], [2, -1]]
    flat = Mesh(points, {"triangle": [[0, 1, 2], [1, 3, 2]]})
    assert np.isinf(np.nanmax(quality.size_jump(flat)))
