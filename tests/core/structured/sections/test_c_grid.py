"""C-grids: any airfoil and trailing edge, wakes that are cuts, far fields, heights in wall units, and refusals."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery
from meshcore.errors import GenerationFailed, InvalidGeometry, InvalidInput
from meshcore.geometry.curves import polyline
from meshcore.quality import line_angle
from meshcore.structured.sections.wall_units import height_for
from tests import naive
from tests.core.geometry.test_section import joukowski


def closed(loop):
    return np.vstack([loop, loop[:1]])


SECTIONS = {
    **{name: gallery.airfoil(name) for name in gallery.airfoils()},
    "cusped": closed(joukowski(120)),
    "plate": np.array([[0, 0], [1, 0], [1, 0.01], [0, 0.01], [0, 0.0]]),
}


def assert_sound(grid):
    """No fold, and cuts that are one line to the last bit: cells of the wake."""
    blocks = grid.blocks if isinstance(grid, mc.MultiBlock) else (grid,)
    for block in blocks:
        assert (naive.cross_areas(block.points[:, :, 0]) > 0).all()
    copies = 0
    for cut in grid.cuts:
        here, there = cut.places(), cut.across(cut.places())
        ours, theirs = blocks[cut.block].points, blocks[cut.partner_block].points
        assert (ours[tuple(here.T)] == theirs[tuple(there.T)]).all()
        copies += len(here)
    assert grid.to_mesh().n_points == grid.n_points - copies
    return copies // len(grid.cuts) - 1


def around(grid):
    """The block round the section."""
    return grid.blocks[0] if isinstance(grid, mc.MultiBlock) else grid


@pytest.mark.parametrize("method", ["transfinite", "elliptic", "hyperbolic", "parabolic"])
@pytest.mark.parametrize("keywords", [{}, {"around": 200, "first_height": 1e-5, "trailing_spacing": 0.002}])
@pytest.mark.parametrize("name", SECTIONS)
def test_no_cell_is_folded_and_the_heights_are_those_asked(name, keywords, method):
    if name == "plate" and "around" not in keywords:
        keywords = {"around": 60, "first_height": 0.001}
    grid, report = mc.c_grid(SECTIONS[name], method=method, **keywords)
    wake = assert_sound(grid)
    points = around(grid).points[:, :, 0]
    section = slice(wake, len(points) - wake)
    away = np.linalg.norm(points[section, 1] - points[section, 0], axis=1)
    if name == "plate":
        return  # lines fan out at its front
    near = 0.02 if method == "hyperbolic" else 1e-3
    assert away == pytest.approx(report.quality["first height"], rel=near)
    mean = np.linalg.norm(np.diff(points[section], axis=1), axis=-1).mean(axis=0)
    growth = mean[1:] / mean[:-1]
    if method != "hyperbolic" or (name in gallery.airfoils() and keywords == {}):
        assert growth == pytest.approx(np.median(growth), rel=0.005)
    assert report.converged and not report.warnings
    if method == "transfinite" and name in gallery.airfoils():
        assert report.quality["largest growth"] <= 1.151
        steps = np.linalg.norm(np.diff(points[section], axis=1), axis=-1)
        ratio = steps[:, 1:] / steps[:, :-1]
        assert np.ptp(ratio, axis=1).max() < 0.005  # constant along each line


def test_points_are_kept_and_the_blunt_edge_has_its_base():
    section = gallery.airfoil("naca0012")
    blocks, _ = mc.c_grid(section)
    wall = {tuple(p) for p in blocks.blocks[0].points[:, 0, 0]}
    assert {tuple(p) for p in polyline(section)} <= wall
    grid, _ = mc.c_grid(section, base="wrapped")
    wall = {tuple(p) for p in grid.points[:, 0, 0]}
    assert {tuple(p) for p in polyline(section)} <= wall
    wake = grid.cuts[0].points[1][0]
    assert grid.points[wake, 0, 0] == pytest.approx([1, 0, 0]) and grid.points[wake + 2, 0, 0, 1] < -0.001


def test_lines_leave_section_and_wake_at_right_angles():
    grid, _ = mc.c_grid(gallery.airfoil("rae2822"), around=300, first_height=1e-5)
    points = grid.points[:, :, 0]
    along = points[2:, 0] - points[:-2, 0]
    away = points[1:-1, 1] - points[1:-1, 0]
    cosine = (along * away).sum(axis=1) / np.linalg.norm(along, axis=1) / np.linalg.norm(away, axis=1)
    off = np.degrees(np.abs(np.arcsin(cosine)))
    off[np.abs(np.arange(len(off)) - grid.cuts[0].points[1][0]) < 3] = 0
    off[np.abs(np.arange(len(off)) - (len(off) - grid.cuts[0].points[1][0])) < 4] = 0
    assert off.max() < 8


@pytest.mark.parametrize("height", [1e-3, 1e-5])
@pytest.mark.parametrize("name", gallery.airfoils())
def test_lines_of_marches_do_not_lean_beside_those_from_the_trailing_edge(name, height):
    grid, _ = mc.c_grid(gallery.airfoil(name), method="hyperbolic", first_height=height)
    assert (90 - line_angle(around(grid))[:, 1:-1]).max() < 20  # was 58


@pytest.mark.parametrize("method", ["transfinite", "elliptic", "hyperbolic", "parabolic"])
@pytest.mark.parametrize("shape", ["C", "box"])
def test_far_fields(shape, method):
    grid, _ = mc.c_grid(gallery.airfoil("rae2822"), far_field=shape, radius=4, wake=6, method=method)
    assert_sound(grid)
    outer = grid.points[:, -1, 0]
    within = 0.1 if (shape, method) == ("C", "hyperbolic") else 1e-2  # of where the march arrives
    assert outer[:, 0].max() == pytest.approx(7, rel=1e-6) and np.abs(outer[:, 1]).max() == pytest.approx(4, rel=within)
    assert np.ptp(grid.points[0, :, 0, 0]) < 1e-9 and np.ptp(grid.points[-1, :, 0, 0]) < 1e-9  # outflow


@pytest.mark.parametrize("method", ["transfinite", "elliptic", "hyperbolic", "parabolic"])
def test_a_far_field_of_ones_own_is_met(method):
    angle = np.linspace(np.radians(-60), np.radians(-300), 200)
    own = np.column_stack([0.5 + 5 * np.cos(angle), 4 * np.sin(angle)])
    grid, _ = mc.c_grid(gallery.airfoil("rae2822"), own, wake=2, method=method)
    assert_sound(grid)
    distance = np.min(np.linalg.norm(grid.points[:, -1, 0, None, :2] - own[None], axis=-1), axis=1)
    assert distance.max() < 0.1


def test_symmetric_sections_get_symmetric_grids():
    blocks, _ = mc.c_grid(gallery.airfoil("naca0012"))
    points, base = (block.points[:, :, 0] for block in blocks.blocks)
    assert np.abs(points - points[::-1] * [1, -1, 1]).max() < 1e-5
    assert np.abs(base - base[:, ::-1] * [1, -1, 1]).max() < 1e-12


def test_turned_moved_and_scaled_sections_get_the_same_grid():
    loop = polyline(gallery.airfoil("rae2822"))
    first, _ = mc.c_grid(loop)
    a = np.radians(25)
    turn = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    other, _ = mc.c_grid(
        30 * np.roll(loop[:-1], 40, axis=0)[np.r_[0 : len(loop) - 1, 0]] @ turn.T + [5, 6, 7],
        first_height=30 * 0.001 * np.linalg.norm(np.ptp(loop, axis=0)),
    )
    assert np.abs(other.points - (30 * first.points @ turn.T + [5, 6, 7])).max() < 1e-6


def test_heights_in_wall_units():
    grid, report = mc.c_grid(gallery.airfoil("rae2822"), y_plus=1.0, reynolds=6.5e6, around=200)
    height = height_for(1.0, 6.5e6, 1.0)
    assert report.quality["first height"] == pytest.approx(height, rel=1e-3) and 3e-6 < height < 6e-6
    assert_sound(grid)


@pytest.mark.parametrize("section", [gallery.circle(40), gallery.l_shape(6)])
def test_where_lines_cross_the_grid_is_marched_and_says_so(section):
    grid, report = mc.c_grid(section, around=60, first_height=0.005, method="transfinite")
    assert_sound(grid)
    assert "parabolic march took their place" in report.warnings[0]


@pytest.mark.parametrize(
    ("section", "keywords", "error", "words"),
    [
        (gallery.circle(12).points, {}, InvalidGeometry, "open"),
        (np.array([[0, 0], [2, 2], [2, 0], [0, 1.5], [0, 0]]), {}, InvalidGeometry, "crosses itself"),
        (np.array([[0, 0], [1, 0], [2, 0], [0, 0.0]]), {}, InvalidGeometry, "no area"),
        (gallery.airfoil("rae2822"), {"radius": 0.1}, InvalidInput, "radius"),
        (gallery.airfoil("rae2822"), {"first_height": -1.0}, InvalidInput, "first_height"),
        (gallery.airfoil("rae2822"), {"first_height": 8.0}, InvalidInput, "first_height"),
        (gallery.airfoil("rae2822"), {"first_height": 1e-14}, InvalidInput, "lost in rounding"),
        (gallery.airfoil("rae2822"), {"growth": 4.0}, InvalidInput, "growth"),
        (gallery.airfoil("rae2822"), {"y_plus": 0.0}, InvalidInput, "y_plus"),
        (gallery.airfoil("rae2822"), {"around": 30, "trailing_spacing": 1e-6}, InvalidInput, "around: 30 cells"),
        (gallery.airfoil("rae2822"), {"trailing_spacing": 3.0}, InvalidInput, "trailing_spacing"),
        (gallery.airfoil("rae2822"), {"layers": 10**9}, InvalidInput, "layers"),
    ],
)
def test_bad_input_gets_a_clear_error(section, keywords, error, words):
    with pytest.raises(error, match=words):
        mc.c_grid(section, **keywords)


def test_a_far_field_inside_the_section_is_refused():
    with pytest.raises(InvalidGeometry, match="does not go round all of the section"):
        mc.c_grid(gallery.airfoil("rae2822"), np.array([[0.5, -0.01], [0.3, -0.01], [0.3, 0.01], [0.5, 0.01]]))


def horseshoe(gap: float = 0.2) -> np.ndarray:
    """A ring with a narrow gap, whose inside no C-grid reaches."""
    angle = np.linspace(gap, 2 * np.pi - gap, 40)
    outside = np.column_stack([np.cos(angle), np.sin(angle)])
    return np.vstack([outside, 0.8 * outside[::-1], outside[:1]])


def test_a_failure_shows_where():
    with pytest.raises(GenerationFailed, match="cells are folded") as caught:
        mc.c_grid(horseshoe(0.02), first_height=0.005)
    partial = caught.value.partial
    bad = (naive.cross_areas(partial.points[:, :, 0]) <= 0).any(axis=-1)
    assert bad.any() and set(caught.value.cells) >= set(np.flatnonzero(bad.ravel(order="F")))


@pytest.mark.parametrize("name", ["rae2822", "s1223", "cusped"])
def test_lines_of_elliptic_grids_run_through_the_wake(name):
    grid, report = mc.c_grid(SECTIONS[name], method="elliptic", first_height=1e-4, wake_height=1e-3)
    points, wake, n = grid.points[:, :, 0], report.counts["wake"], grid.cell_shape[0]
    k = np.arange(1, wake)
    above, below = points[n - k, 1] - points[n - k, 0], points[k, 0] - points[k, 1]
    turn = np.cross(below, above)[:, 2] / (np.linalg.norm(above, axis=1) * np.linalg.norm(below, axis=1))
    assert np.degrees(np.abs(np.arcsin(turn))).max() < 1
    assert np.linalg.norm(above, axis=1) == pytest.approx(np.linalg.norm(below, axis=1), rel=2e-3)
    # What the equations ask of the cut, across it: lines bend there no more than beside it.
    rows = np.concatenate([points[wake::-1, 2:0:-1], points[n - wake :, :3]], axis=1)[1:-1]
    step = 0.5 * (rows[:, 2:] - rows[:, :-2])
    bend = np.cross(step, rows[:, 2:] - 2 * rows[:, 1:-1] + rows[:, :-2])[..., 2] / (step**2).sum(axis=-1)
    assert np.abs(bend[:, 1]).max() < max(0.02, 2 * np.abs(bend[:, [0, 2]]).max())


def test_the_wake_of_a_symmetric_section_is_straight_and_its_grid_symmetric():
    grid, report = mc.c_grid(closed(joukowski(120, -0.1 + 0j)), method="elliptic")
    points = grid.points[:, :, 0]
    assert np.abs(points[: report.counts["wake"], 0, 1]).max() < 1e-9
    assert np.abs(points - points[::-1] * [1, -1, 1]).max() < 1e-3


def test_layers_of_a_march_reach_the_outflow_without_a_kink():
    points = mc.c_grid(gallery.airfoil("rae2822"), first_height=1e-5).mesh.points[..., 0, :2]
    for ends in (points[:3], points[-1:-4:-1]):
        last, before = ends[1] - ends[0], ends[2] - ends[1]
        turn = np.arctan2(last[:, 0] * before[:, 1] - last[:, 1] * before[:, 0], (last * before).sum(axis=1))
        assert np.degrees(np.abs(turn)).max() < 5  # 12.6 where the outflow's line alone keeps its heights
