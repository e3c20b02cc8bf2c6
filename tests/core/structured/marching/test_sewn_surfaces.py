"""Surfaces written face by face, with rounded points, are one surface; slits that are meant stay open."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

import meshcore as mc
from meshcore import gallery


def soup(mesh, noise):
    """Triangles that share no points, each of which is moved by up to ``noise``."""
    corners = mesh.points[mesh.get("triangle")].reshape(-1, 3)
    moved = corners + np.random.default_rng(0).uniform(-noise, noise, corners.shape)
    return mc.Mesh(moved, {"triangle": np.arange(len(corners)).reshape(-1, 3)})


@pytest.mark.parametrize("noise", [0.0, 1e-12, 1e-7])
def test_triangles_without_common_points_are_one_closed_surface(noise):
    ball = gallery.bumpy_ball()
    wanted = mc.hyperbolic_volume(ball, first_height=0.01, layers=5).mesh
    made, report = mc.hyperbolic_volume(soup(ball, noise), first_height=0.01, layers=5)
    assert made.n_points == wanted.n_points and made.n_cells == wanted.n_cells
    assert report.converged and any("made one" in text for text in report.warnings)
    apart, _ = cKDTree(wanted.points).query(made.points)
    assert apart.max() < 1e-9 + 100 * noise


def plates(gap):
    """Two square plates side by side, so far apart."""
    x, y = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 1, 5), indexing="ij")
    one = mc.StructuredGrid(np.stack([x, y, 0 * x], axis=-1)).to_mesh()
    points = np.vstack([one.points, one.points + [1 + gap, 0, 0]])
    return mc.Mesh(points, {"quad": np.vstack([one.get("quad"), one.get("quad") + 25])})


@pytest.mark.parametrize(("gap", "points"), [(0.0, 45), (1e-7, 45), (1e-4, 50)])
def test_only_open_edges_within_rounding_are_sewn(gap, points):
    made, _ = mc.hyperbolic_volume(plates(gap), first_height=1e-6, layers=1)
    assert made.n_points == 2 * points


def test_fine_cells_of_grids_are_never_sewn():
    x = np.concatenate([[0], np.geomspace(1e-7, 1, 20)])
    x, y = np.meshgrid(x, np.linspace(0, 1, 5), indexing="ij")
    grid = mc.StructuredGrid(np.stack([x, y, 0 * x], axis=-1))
    assert mc.hyperbolic_volume(grid, first_height=1e-3, layers=1).mesh.shape == (21, 5, 2)


CORNERS = np.array([[9, 9, 9], [0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2], [0, -2, -2.0], [1, 1, 3], [3, 0, 0]])
"""Of which the first is in no face."""


@pytest.mark.parametrize(
    ("faces", "words", "there"),
    [
        ([(1, 2, 3), (1, 2, 4), (1, 2, 5)], "more than two faces meet", [1, 2]),
        ([(2, 1, 3), (4, 2, 6)], "touch in a single point", [2]),
        ([(1, 2, 7), (1, 3, 2)], "are flat", [1, 2, 7]),
    ],
)
def test_faults_are_told_by_the_users_own_points(faces, words, there):
    separate = mc.Mesh(CORNERS[np.array(faces)].reshape(-1, 3), {"triangle": np.arange(3 * len(faces)).reshape(-1, 3)})
    for surface in (mc.Mesh(CORNERS, {"triangle": faces}), separate):
        with pytest.raises(mc.InvalidGeometry, match=words) as caught:
            mc.hyperbolic_volume(surface, first_height=0.1, layers=2)
        named = {tuple(place) for place in surface.points[list(caught.value.points)]}
        assert named == {tuple(place) for place in CORNERS[there]}
