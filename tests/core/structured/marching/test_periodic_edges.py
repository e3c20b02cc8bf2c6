"""Periodic edges of surfaces: a sector marches as the whole does, and its cut is recorded."""

from functools import partial

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery, quality
from meshcore.errors import InvalidInput
from meshcore.structured.marching import layer_equations

PERIODIC = "imin = periodic, imax = periodic"


def turned(parts):
    a = 2 * np.pi / parts
    return np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])


def sector(radius, height, parts, n=7, m=9, low=0.3):
    """Part of a body of revolution, with waves that repeat from part to part."""
    t, s = np.meshgrid(np.linspace(0, 2 * np.pi / parts, n), np.linspace(low, 1, m), indexing="ij")
    r, z = radius(s, parts * t), height(s, parts * t)
    return mc.StructuredGrid(np.stack([r * np.cos(t), r * np.sin(t), z], axis=-1))


SECTORS = {
    "hub": (10, partial(sector, lambda s, t: 1 + 0.04 * np.cos(t + 0.7) * np.sin(3 * s), lambda s, t: 2 * s)),
    "cylinder": (8, partial(sector, lambda s, t: 1 + 0 * s, lambda s, t: s)),
    "cone": (7, partial(sector, lambda s, t: s, lambda s, t: -0.8 * s)),
    "disk": (9, partial(sector, lambda s, t: s, lambda s, t: 0 * s)),
    "nose": (5, partial(sector, lambda s, t: np.sin(s), lambda s, t: -np.cos(s), low=0.0)),
    "half": (2, partial(sector, lambda s, t: s, lambda s, t: 0.1 * np.cos(t) * s, n=17)),
}


def whole(part, parts):
    turn = turned(parts)
    points = np.concatenate([part.points[:-1] @ np.linalg.matrix_power(turn.T, k) for k in range(parts)])
    return mc.StructuredGrid(np.concatenate([points, points[:1]]))


@pytest.fixture
def exactly(monkeypatch):
    """Steps whose equations are solved to round-off."""
    monkeypatch.setattr(layer_equations, "ENOUGH", 1e-13)
    monkeypatch.setattr(layer_equations, "ITERATIONS", 300)


@pytest.mark.parametrize("other_side", [False, True])
@pytest.mark.parametrize("name", SECTORS)
def test_a_sector_marches_as_the_whole_does(name, other_side, exactly):
    parts, make = SECTORS[name]
    part = make(parts)
    asked = {"first_height": 0.01, "layers": 10, "edges": "free", "other_side": other_side}
    grid, report = mc.hyperbolic_volume(part, each_edge=PERIODIC, **asked)
    expected, _ = mc.hyperbolic_volume(whole(part, parts), **asked)
    assert report.converged and quality.validate(grid) == []
    if name == "nose":
        away = np.linalg.norm(grid.points[:, None] - expected.points[None], axis=2).min(axis=1)
        assert away.max() < 1e-11
        return
    same = expected.points[::-1] if other_side else expected.points
    mine = grid.points[::-1] if other_side else grid.points
    assert np.abs(mine - same[: len(mine)]).max() < 1e-11
    (cut,) = grid.cuts
    assert np.abs(np.abs(np.array(cut.rotation)) - np.abs(turned(parts))).max() < 1e-12
    assert {cut.points[1][2], cut.partner[1][2]} == {10}


def wave(n=9, m=12):
    u, v = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 2, m), indexing="ij")
    return mc.StructuredGrid(np.stack([u, v, 0.1 * np.sin(2 * np.pi * u + 1) * np.cos(np.pi * v)], axis=-1))


def test_a_patch_may_repeat_both_ways(exactly):
    patch = wave()
    grid, _ = mc.hyperbolic_volume(patch, first_height=0.01, layers=15, edges="periodic")
    assert np.allclose(sorted(cut.translation for cut in grid.cuts), [[0, 2, 0], [1, 0, 0]], rtol=0, atol=1e-15)
    # The same patch, cut elsewhere.
    rolled = np.concatenate([patch.points[4:], patch.points[1:5] + [1, 0, 0]])
    other, _ = mc.hyperbolic_volume(mc.StructuredGrid(rolled), first_height=0.01, layers=15, edges="periodic")
    assert np.abs(other.points[:5] - grid.points[4:]).max() < 1e-11


def test_blocks_that_run_against_each_other_are_cut_rightly():
    h = SECTORS["hub"][1](10, n=9).points
    blocks = mc.MultiBlock((mc.StructuredGrid(h[:5]), mc.StructuredGrid(h[4:][::-1, ::-1])))
    asked = "block 0 imin = periodic, block 1 imin = periodic"
    for other_side in (False, True):
        made, report = mc.hyperbolic_volume(blocks, first_height=0.01, layers=6, each_edge=asked, other_side=other_side)
        seam, cut = made.cuts  # whose places are checked by MultiBlock
        assert seam.points[0][0] == seam.partner[0][0] and seam.transform == (-1, -2, 3) and not seam.moves
        assert (cut.block, cut.partner_block, cut.transform) == (0, 1, (-1, -2, 3)) and not report.warnings[1:]


def test_meshes_repeat_too():
    part = SECTORS["hub"][1](10)
    mesh = part.to_mesh()
    low, high = (int(np.argmin(np.linalg.norm(mesh.points - part.points[i, 4, 0], axis=1))) for i in (0, -1))
    asked = f"vertex {low} = periodic, vertex {high} = periodic"
    made, _ = mc.hyperbolic_volume(mesh, first_height=0.01, layers=10, each_edge=asked)
    grid, _ = mc.hyperbolic_volume(part, first_height=0.01, layers=10, each_edge=PERIODIC)
    assert (made.points[: mesh.n_points] == mesh.points).all()
    assert np.abs(np.sort(made.points, axis=0) - np.sort(grid.points.reshape(-1, 3), axis=0)).max() < 1e-12


def test_layers_do_not_depend_on_the_number_of_threads():
    part = SECTORS["hub"][1](10, n=90, m=90)
    one, two = (
        mc.hyperbolic_volume(part, first_height=0.001, layers=6, each_edge=PERIODIC, threads=k).mesh for k in (1, 2)
    )
    assert (one.points == two.points).all()


def test_cuts_of_the_surface_run_through_the_layers():
    t, z = np.meshgrid(np.linspace(0, 2 * np.pi, 17), [0.0, 0.5, 1.0], indexing="ij")
    tube = np.stack([np.cos(t), np.sin(t), z], axis=-1)
    cut = mc.Cut(((8, 0, 0), (8, 2, 0)), ((0, 0, 0), (0, 2, 0)), (1, 2, 3), 0, 1, name="seam")
    blocks = mc.MultiBlock((mc.StructuredGrid(tube[:9]), mc.StructuredGrid(tube[8:])), cuts=(cut,))
    for other_side in (False, True):
        made, _ = mc.hyperbolic_volume(blocks, first_height=0.01, layers=4, other_side=other_side)
        kept, other = made.cuts  # the other is found: the blocks meet twice
        assert kept.name == "seam" and not other.name and kept.points[1][2] == 4 and len(kept.places()) == 3 * 5


def test_cuts_of_the_surface_that_move_points_make_edges_periodic():
    part = SECTORS["hub"][1](10)
    expected, _ = mc.hyperbolic_volume(part, first_height=0.01, layers=5, edges="automatic", each_edge=PERIODIC)
    turn = tuple(map(tuple, turned(10).tolist()))
    cut = mc.Cut(((0, 0, 0), (0, 8, 0)), ((6, 0, 0), (6, 8, 0)), rotation=turn, name="seam")
    told = mc.StructuredGrid(part.points, cuts=(cut,))
    for other_side in (False, True):
        grid, report = mc.hyperbolic_volume(told, first_height=0.01, layers=5, other_side=other_side)
        (kept,) = grid.cuts
        assert kept.name == "seam" and kept.points[1][2] == 5 and not any("cut" in text for text in report.warnings)
        assert other_side or np.abs(grid.points - expected.points).max() < 1e-12
    _, report = mc.hyperbolic_volume(told, first_height=0.01, layers=5, edges="free")
    assert any("not recorded" in text for text in report.warnings)


def test_blocks_that_meet_are_joined_by_cuts():
    six = gallery.six_patches(5)
    for other_side in (False, True):
        made, _ = mc.hyperbolic_volume(six, first_height=0.01, layers=3, other_side=other_side)
        assert len(made.cuts) == 12 and made.to_mesh().n_points == 4 * (6 * 9 + 12 * 3 + 8)
    t, z = np.meshgrid(np.linspace(0, 2 * np.pi, 17), [0.0, 0.5, 1.0], indexing="ij")
    tube = mc.StructuredGrid(np.stack([np.cos(t), np.sin(t), z], axis=-1))
    (cut,) = mc.hyperbolic_volume(tube, first_height=0.01, layers=3).mesh.cuts
    assert (cut.points, cut.partner) == (((0, 0, 0), (0, 2, 3)), ((16, 0, 0), (16, 2, 3)))
    ring = mc.StructuredGrid(tube.points, periodic=(True, False, False))
    assert not mc.hyperbolic_volume(ring, first_height=0.01, layers=3).mesh.cuts  # periodic already


def test_a_stop_beside_a_periodic_edge_is_told_at_the_surface():
    part = sector(lambda s, t: 1 + 0.5 * np.cos(t) ** 20, lambda s, t: 2 * s, 6, n=33)
    made, report = mc.hyperbolic_volume(part, first_height=0.05, growth=1.0, layers=60, each_edge=PERIODIC)
    assert not report.converged and made.shape[2] > 1
    place = np.array([report.quality[f"stopped at {axis}"] for axis in "xyz"])
    assert np.linalg.norm(made.points[:, :, -1] - place, axis=-1).min() < 1e-12


def test_edges_that_are_not_alike_are_refused():
    with pytest.raises(InvalidInput, match="none of the other periodic edges"):
        mc.hyperbolic_volume(wave(), each_edge="imin = periodic, jmin = periodic")
    with pytest.raises(InvalidInput, match="none of the other periodic edges"):
        mc.hyperbolic_volume(wave(), each_edge="imin = periodic")
