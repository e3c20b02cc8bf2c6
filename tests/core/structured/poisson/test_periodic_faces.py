"""Blocks that run on through opposite faces: moved, turned, or coinciding."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import InvalidInput, StructuredGrid, Wall, gallery, quality
from meshcore.structured.algebraic.blending import blended
from meshcore.structured.poisson.face_measures import measured
from meshcore.structured.poisson.periodic_faces import CyclicLine, Ghosts, Motion, Pair, pairs_of
from meshcore.structured.poisson.winslow_3d import solved
from tests import naive
from tests.core.structured.poisson.test_wall_control_3d import box

TURN = np.radians(40)
ROTATION = np.array([[np.cos(TURN), 0, np.sin(TURN)], [0, 1, 0], [-np.sin(TURN), 0, np.cos(TURN)]])
SCREW = Motion(ROTATION, np.array([0.1, 0.5, -0.2]))


def channel(ni, nj, nk):
    """Waves of period 1 along i on all other faces, and a cut that is bent."""
    u, v, w = np.moveaxis(box(ni, nj, nk), -1, 0)
    wave = 0.12 * np.sin(2 * np.pi * u) * (1 + v) * np.cos(w)
    x = u + 0.15 * v * (1 - v) + 0.1 * w
    return blended(np.stack([x, v + wave, w + 0.5 * wave], axis=-1), (1, 2))


def row_passage(n=16, blades=9):
    """A passage of an annular row of blades that turns the flow, half-way between two blades."""
    t, s, h = np.moveaxis(box(n, n + 4, n - 2), -1, 0)
    pitch = 2 * np.pi / blades
    angle = pitch * (t - 0.5) + 0.4 * s**2 + 0.1 * h * np.sin(np.pi * s)
    radius = 1 + h * (0.5 + 0.1 * s) + 0.05 * np.sin(np.pi * s) * (1 - h)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), 1.2 * s], axis=-1)


def o_block(n=20):
    """Between two cylinders of which the outer one is off centre, and its cut is bent."""
    t, r, z = np.moveaxis(box(n, n // 2, n // 2), -1, 0)
    angle = -2 * np.pi * t + 0.4 * np.sin(np.pi * r)
    points = np.stack([(1 + r) * np.cos(angle) + 0.3 * r, (1 + r) * np.sin(angle), z], axis=-1)
    points[-1] = points[0]
    return points


@pytest.mark.parametrize("motion", [SCREW, Motion(way=np.array([0.0, 2, 0.5])), Motion()])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_the_motion_between_two_faces_is_found(motion, axis):
    first = np.random.default_rng(5).standard_normal((6, 7, 3))
    points = np.moveaxis(np.stack([first, first + 1, first + 2, motion.moved(first)]), 0, axis)
    pair = Pair.found(points, axis)
    np.testing.assert_allclose(pair.motion.turn, motion.turn, atol=1e-12)
    np.testing.assert_allclose(pair.motion.way, motion.way, atol=1e-12)
    assert pair.motion.is_turn == motion.is_turn and pair.motion.is_none == motion.is_none
    np.testing.assert_allclose(pair.motion.inverse.moved(motion.moved(first)), first, atol=1e-12)
    scaled = motion.scaled(np.array([1.0, 2, 3]), 5.0)
    np.testing.assert_allclose(scaled.moved((first - [1, 2, 3]) / 5), (motion.moved(first) - [1, 2, 3]) / 5, atol=1e-12)


def test_flat_faces_are_turned_not_mirrored():
    flat = box(5, 4, 1)[:, :, 0] * [1, 2, 0]
    points = np.stack([flat, flat, flat, SCREW.moved(flat)])
    assert np.linalg.det(Pair.found(points, 0).motion.turn) == pytest.approx(1)


def test_ghosts_are_images():
    points = row_passage()
    pair = pairs_of(points, [0])[0]
    ghosts = Ghosts([pair])
    x = ghosts.added(np.moveaxis(points, -1, 0))
    ghosts.wrap(x)
    assert x.shape == (3, 18, 21, 15) and ghosts.without(x).shape == (3, 17, 21, 15)
    np.testing.assert_allclose(np.moveaxis(x[:, -1], 0, -1), pair.motion.moved(points[1]), atol=1e-12)
    np.testing.assert_allclose(x[:, 0], np.moveaxis(points, -1, 0)[:, 0], atol=1e-12)
    # Differences of points are turned only: those from the images of a moved block.
    d = ghosts.added(np.moveaxis(2 * points, -1, 0)) - x
    ghosts.wrap_vectors(d)
    np.testing.assert_allclose(d[:, -1], np.moveaxis(pair.motion.turned(points[1]), -1, 0), atol=1e-12)
    np.testing.assert_allclose(np.moveaxis(d[:, 0], 0, -1), pair.motion.inverse.turned(points[-1]), atol=1e-12)


@pytest.mark.parametrize("cells", [(16, 8), (17, 9), (15, 8)])
def test_transfer_runs_on_through_the_cut(cells):
    line = CyclicLine(*cells)
    fine, coarse = (np.cos(2 * np.pi * np.arange(n + 2) / n) for n in cells)
    index, weight = line.averages
    mean = (fine[index] * weight).sum(axis=1)
    assert abs(mean[0] - mean[-2]) < 1e-12 and abs(mean[1] - mean[-1]) < 1e-12  # ghosts are averaged like their images
    assert abs(mean[0] - mean[1:-1].max()) < 1e-12  # symmetric about the cut
    for table, source, target in ((line.to_fine, coarse, fine), (line.to_coarse, fine, coarse)):
        index, weight = table
        assert abs(((source[index] * weight).sum(axis=1) - target)[:-1]).max() < 0.1


@pytest.mark.parametrize("anisotropy", [1.0, 20.0])
def test_where_a_block_is_cut_does_not_matter(anisotropy):
    start = channel(24, 12, 14) * [anisotropy, 1, 1]
    shift = 10
    way = np.array([anisotropy, 0, 0])
    rolled = np.concatenate([start[shift:-1], start[: shift + 1] + way])
    found = [solved(p, pairs=pairs_of(p, [0]), tolerance=1e-11) for p in (start, rolled)]
    assert all(outcome.converged for _, outcome in found)
    (one, _), (other, _) = found
    np.testing.assert_allclose(other, np.concatenate([one[shift:-1], one[: shift + 1] + way]), atol=1e-8)
    assert (one[-1, 1:-1, 1:-1] == one[0, 1:-1, 1:-1] + pairs_of(start, [0])[0].motion.way).all()
    assert abs(one[0] - start[0])[1:-1, 1:-1].max() > 0.02


def test_a_passage_between_blades_stays_alike_to_the_last_bit():
    start = row_passage()
    grid, report = mc.elliptic_volume(StructuredGrid(start), periodic="i", residual=1e-9)
    assert report.converged
    motion = pairs_of(start, [0])[0].motion
    points = grid.points
    assert motion.is_turn
    assert (points[-1, 1:-1, 1:-1] == motion.moved(points[0, 1:-1, 1:-1])).all()
    assert (points[0, [0, -1]] == start[0, [0, -1]]).all() and (points[:, :, 0] == start[:, :, 0]).all()
    assert abs(points[0] - start[0])[1:-1, 1:-1].max() > 0.01
    # The lines run on: what is bent at the cut is not sharper than elsewhere.
    lines = np.concatenate([points[:-1], motion.moved(points[:2])])[:, 3:-3, 3:-3]
    edges = np.diff(lines, axis=0)
    edges /= np.linalg.norm(edges, axis=-1, keepdims=True)
    turn = np.arccos(np.clip((edges[1:] * edges[:-1]).sum(axis=-1), -1, 1))
    assert turn[-1].max() < 1.2 * turn[:-1].max()
    kept, _ = mc.elliptic_volume(StructuredGrid(start))
    assert quality.measure(grid, "scaled_jacobian").min() > quality.measure(kept, "scaled_jacobian").min() - 1e-3


def test_rotated_passages_give_rotated_grids():
    start = row_passage(12)
    moved = SCREW.moved(start)
    one, other = (mc.elliptic_volume(StructuredGrid(p), periodic="i", residual=1e-10)[0].points for p in (start, moved))
    np.testing.assert_allclose(other, SCREW.moved(one), atol=1e-8)


def test_the_cut_of_an_o_block_is_free_by_itself():
    start = o_block()
    grid, report = mc.elliptic_volume(StructuredGrid(start), residual=1e-10, control="none")
    assert report.converged and grid.periodic == (True, False, False)
    assert (grid.points[-1] == grid.points[0]).all()
    assert abs(grid.points[0] - start[0])[1:-1, 1:-1].max() > 0.05
    # Cut elsewhere, it is the same grid.
    shifted = np.concatenate([start[7:-1], start[:8]])
    other, _ = mc.elliptic_volume(StructuredGrid(shifted), residual=1e-10, control="none")
    np.testing.assert_allclose(other.points[: 20 - 7], grid.points[7:-1], atol=1e-7)


def test_two_directions_at_once():
    u, v, w = np.moveaxis(box(12, 13, 10), -1, 0)
    height = w + 0.1 * np.sin(2 * np.pi * u) * np.sin(2 * np.pi * v) * (1 - w) + 0.05 * np.sin(9 * w) * u * (1 - u)
    start = np.stack([u, v, height], axis=-1)
    grid, report = mc.elliptic_volume(StructuredGrid(start), periodic="i and j", residual=1e-9, control="none")
    assert report.converged
    points = grid.points
    np.testing.assert_allclose(points[-1], points[0] + [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(points[:, -1], points[:, 0] + [0, 1, 0], atol=1e-12)
    shifted = np.concatenate([start[5:-1], start[:6] + [1, 0, 0]])
    other, _ = mc.elliptic_volume(StructuredGrid(shifted), periodic="i and j", residual=1e-9, control="none")
    np.testing.assert_allclose(other.points, np.concatenate([points[5:-1], points[:6] + [1, 0, 0]]), atol=1e-7)


def test_walls_run_on_through_the_cut():
    start = row_passage(20)
    grid, report = mc.elliptic_volume(
        StructuredGrid(start), periodic="i", walls="kmin", first_height=0.004, faces="respaced", lean_at_edges=True
    )
    assert report.converged
    motion = pairs_of(start, [0])[0].motion
    assert (grid.points[-1, 1:-1, 1:-1] == motion.moved(grid.points[0, 1:-1, 1:-1])).all()
    hub = np.linalg.norm(grid.points[:, 4:-4, 1] - grid.points[:, 4:-4, 0], axis=-1)
    assert abs(hub / 0.004 - 1).max() < 0.05  # up to the cut
    x = np.concatenate([grid.points, motion.moved(grid.points[1:2])])
    found = measured(np.ascontiguousarray(np.moveaxis(x, -1, 0)), "kmin", 1.0, (True, False, False))
    assert found.counts[0, 8:-8].all() and found.off(90.0)[:, 10].max() < 1.5
    every, _ = mc.elliptic_volume(StructuredGrid(o_block()), walls="all", first_height=0.05, faces="respaced")
    assert (every.points[-1] == every.points[0]).all()


def test_bad_periods_are_named():
    start = row_passage(8)
    with pytest.raises(InvalidInput, match=r"periodic: needs jmin and jmax to be alike.*differ by up to 0\.\d+"):
        mc.elliptic_volume(StructuredGrid(start), periodic="j")
    with pytest.raises(InvalidInput, match="periodic: needs three cells or more between kmin and kmax, got 2"):
        mc.elliptic_volume(StructuredGrid(box(4, 4, 2)), periodic="k")
    with pytest.raises(InvalidInput, match="walls: imax is where the block runs on"):
        mc.elliptic_volume(StructuredGrid(start), periodic="i", each_wall=[Wall("imax")])
    mirrored = channel(8, 8, 8)
    mirrored[-1] = mirrored[0][::-1] * [1, 1, 1] + [1, 0, 0]
    with pytest.raises(InvalidInput, match="periodic: needs imin and imax to be alike"):
        mc.elliptic_volume(StructuredGrid(mirrored), periodic="i")
    with pytest.raises(InvalidInput, match="periodic: 'all' is not one of"):
        mc.elliptic_volume(StructuredGrid(start), periodic="all")


def test_blades_on_the_cut_are_walls_and_the_rest_runs_on():
    start = gallery.blade_row(14, 30, 10)
    pair = pairs_of(start.points, [0])[0]
    on_blade = np.zeros(31, bool)
    on_blade[9:22] = True  # with both ends, where the faces meet the cut
    assert (pair.kept == on_blade[:, None]).all()
    np.testing.assert_allclose(pair.motion.turn[:2, 0], [np.cos(2 * np.pi / 11), np.sin(2 * np.pi / 11)], atol=1e-12)
    grid, report = mc.elliptic_volume(start, periodic="i", control="none", residual=1e-10)
    assert report.converged
    assert "imin and imax are alike but for walls, whose points stay: 143 of 341" in report.warnings
    points = grid.points
    for layer in (0, -1):
        assert (points[layer, on_blade] == start.points[layer, on_blade]).all()
    free = np.s_[~on_blade, 1:-1]
    inner = ~on_blade & (np.arange(31) > 0) & (np.arange(31) < 30)
    assert (points[-1, inner, 1:-1] == pair.motion.moved(points[0, inner, 1:-1])).all()
    assert abs(points[0] - start.points[0])[free].max() > 1e-3
    # The equations hold on the cut, too.
    across = np.concatenate([points[-3:], pair.motion.moved(points[1:3])])
    defects = naive.elliptic_defects(across, 0 * across)
    scale = abs(naive.elliptic_defects(points, 0 * points)).max() + 1e-18
    assert abs(defects[2, inner, 1:-1]).max() < 1e3 * scale
    shifted = across.copy()
    shifted[2] += 1e-5
    assert abs(naive.elliptic_defects(shifted, 0 * shifted)[2, inner, 1:-1]).max() > 1e5 * scale


def test_blades_and_hub_are_walls_of_given_height():
    height = 0.004
    grid, report = mc.elliptic_volume(
        gallery.blade_row(20, 40, 16),
        periodic="i",
        each_wall=[Wall(face, height, lean_at_edges=True) for face in ("imin", "imax", "kmin")],
        faces="respaced",
    )
    assert report.quality["points at walls as asked (%)"] > 90
    assert report.quality["error of first heights (%)"] < 5 and report.quality["error of wall angles (degree)"] < 3
    points = grid.points
    blade = np.s_[17:24, 4:-4]  # three points away from both ends
    for first, second in ((points[0], points[1]), (points[-1], points[-2])):
        assert abs(np.linalg.norm(second - first, axis=-1)[blade] / height - 1).max() < 0.05
    hub = np.linalg.norm(points[4:-4, 4:-4, 1] - points[4:-4, 4:-4, 0], axis=-1)
    assert abs(hub / height - 1).max() < 0.05


def test_walls_in_part_cannot_slide_and_few_alike_points_are_no_cut():
    start = gallery.blade_row(8, 16, 6)
    with pytest.raises(InvalidInput, match="sliding: imin is a wall in part only"):
        mc.elliptic_volume(start, periodic="i", walls="imin", sliding=True)
    moved = start.points.copy()
    moved[-1, 2:] += 0.01 * np.random.default_rng(4).standard_normal(moved[-1, 2:].shape)
    with pytest.raises(InvalidInput, match="needs imin and imax to be alike"):
        mc.elliptic_volume(StructuredGrid(moved), periodic="i")
