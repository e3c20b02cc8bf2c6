"""Points that slide on faces of blocks until lines leave them at right angles."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import InvalidInput, StructuredGrid
from meshcore.structured.algebraic.blending import blended
from meshcore.structured.poisson.periodic_faces import pairs_of
from meshcore.structured.poisson.sliding_faces import FaceSlide, _spread
from meshcore.structured.poisson.surface_levels import corner_jacobians
from meshcore.structured.poisson.winslow_3d import count_folded
from tests.core.structured.poisson.test_periodic_faces import row_passage
from tests.core.structured.poisson.test_wall_control_3d import bent, box, cap, naive_angles, passage


def between_cylinders(n, inner=1.0, outer=2.0):
    """A quarter of a tube whose outer points stand askew inside the outer face."""
    t, h, r = np.moveaxis(box(n, n, n), -1, 0)
    skew = np.sin(np.pi * t) * np.sin(np.pi * h) * (r == 1)
    angle, z = 0.5 * np.pi * (t + 0.12 * skew), h - 0.15 * skew
    radius = inner * (outer / inner) ** r
    points = np.stack([radius * np.sin(angle), radius * np.cos(angle), -z], axis=-1)
    return blended(points, (0, 1, 2))


@pytest.mark.parametrize("n", [12, 24, 40])
def test_lines_between_cylinders_become_radii(n):
    start = between_cylinders(n)
    grid, report = mc.elliptic_volume(StructuredGrid(start), walls="kmax", sliding=True, control="none")
    assert report.converged and report.iterations < 40
    outer = grid.points[:, :, -1]
    t, h, _ = np.moveaxis(box(n, n, 1), -1, 0)[..., 0]
    assert abs(np.arctan2(outer[..., 0], outer[..., 1]) - 0.5 * np.pi * t).max() < 4e-3
    assert abs(outer[..., 2] + h).max() < 4e-3
    # The surface is the cylinder, as near as a bicubic one through so many points comes to it.
    assert abs(np.hypot(outer[..., 0], outer[..., 1]) - 2).max() < 40 / n**4
    assert (outer[0] == start[0, :, -1]).all() and (outer[:, -1] == start[:, -1, -1]).all()
    assert (grid.points[:, :, :-1][[0, -1]] == start[:, :, :-1][[0, -1]]).all()
    assert (grid.points[:, :, 0] == start[:, :, 0]).all()
    before, after = (naive_angles(points, "kmax") for points in (start, grid.points))
    assert before[4:-4, 4:-4].max() > 4 > 1.5 > after[4:-4, 4:-4].max()


@pytest.mark.parametrize("shape", [bent, passage, cap])
@pytest.mark.parametrize("face", ["kmax", "imin"])
def test_sliding_and_first_heights_at_once(shape, face):
    start = shape(20)
    grid, report = mc.elliptic_volume(
        StructuredGrid(start), walls=face, sliding=True, first_height=0.01, faces="respaced", lean_at_edges=True
    )
    assert report.converged and report.iterations < 30
    assert report.quality["error of wall angles (degree)"] < 1 and report.quality["error of first heights (%)"] < 5
    # What is asked leans a little even there, since lines on the faces beside it do.
    leaning = naive_angles(start, face)[[1, -2], 1:-1].max()
    assert naive_angles(grid.points, face)[8:-8, 8:-8].max() < 1.5 + 0.2 * leaning
    assert count_folded(grid.points) == 0


def test_a_wave_is_moved_by_its_lean_over_its_share():
    n, m = 24, 17
    a, b = np.pi * np.arange(1, n) / n, np.pi * np.arange(1, m) / m
    wave = np.stack([np.sin(3 * a)[:, None] * np.sin(2 * b), np.sin(a)[:, None] * np.sin(5 * b)])
    k = np.hypot(np.pi * np.array([3, 1]) / n * 0.4, np.pi * np.array([2, 5]) / m * 0.7)[:, None, None]
    np.testing.assert_allclose(_spread(wave, [0.4, 0.7]) * (1 - np.exp(-k)), wave, atol=1e-12)


def test_cells_of_a_face_keep_some_area():
    slide = FaceSlide(np.moveaxis(box(10, 10, 1)[:, :, 0], -1, 0))
    change = np.zeros((2, 11, 11))
    change[0, 5, 5] = 0.3  # over the next points
    slide._at += slide._held_back(change)
    assert (corner_jacobians(np.moveaxis(slide._at, 0, -1)) > 0.2 * 0.01).all()
    assert 0 < slide._at[0, 5, 5] - 0.5 < 0.1


def test_faces_of_a_passage_slide_between_its_cuts():
    start = row_passage(16)
    grid, report = mc.elliptic_volume(
        StructuredGrid(start), periodic="i", walls="kmin", sliding=True, lean_at_edges=True, control="none"
    )
    assert report.converged
    motion = pairs_of(start, [0])[0].motion
    assert (grid.points[-1, 1:-1, 1:-1] == motion.moved(grid.points[0, 1:-1, 1:-1])).all()
    assert (grid.points[0, :, 0] == start[0, :, 0]).all() and (grid.points[:, 0, 0] == start[:, 0, 0]).all()


def test_sliding_needs_walls():
    with pytest.raises(InvalidInput, match="sliding: is given, but no walls"):
        mc.elliptic_volume(StructuredGrid(box(4, 4, 4)), sliding=True)
