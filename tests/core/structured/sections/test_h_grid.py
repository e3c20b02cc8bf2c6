"""H-grids: airfoils, slabs and slits between two joined blocks."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery
from meshcore.errors import InvalidGeometry, InvalidInput
from meshcore.geometry.curves import polyline
from meshcore.structured import Curvilinear
from tests import naive
from tests.section_families import section_of
from tests.section_trials import tried

X = np.linspace(0, 1, 21)
SLIT = np.column_stack([X, 0 * X])
SECTIONS = {
    **{name: gallery.airfoil(name) for name in gallery.airfoils()},
    "circle": gallery.circle(40),
    "square": gallery.square(8),
    "slab": np.array([[0, 0], [1, 0], [1, 0.1], [0, 0.1], [0, 0.0]]),
    "slit": SLIT,
    "bent slit": np.column_stack([X, 0.1 * np.sin(np.pi * X)]),
}
ZIGZAG = [[3, -2], [3, 2], [-4, 2], [-2, 0.5], [-3, -0.2], [-2, 0.2], [-3, -0.5], [-4, -2], [3, -2.0]]


def assert_sound(blocks):
    for block in blocks.blocks:
        assert (naive.cross_areas(block.points[:, :, 0]) > 0).all()
    mesh = blocks.to_mesh()
    shared = sum(cut.points[1][0] - cut.points[0][0] + 1 for cut in blocks.cuts)
    assert mesh.n_points == blocks.n_points - shared
    return mesh


@pytest.mark.parametrize("name", SECTIONS)
@pytest.mark.parametrize("height", [0.002, 1e-5])
def test_no_cell_is_folded_and_the_blocks_meet(name, height):
    keywords = {"around": 80} if name == "slab" else {}
    blocks, report = mc.h_grid(SECTIONS[name], first_height=height, **keywords)
    mesh = assert_sound(blocks)
    assert report.quality["first height"] == height and report.quality["largest growth"] <= 1.02 * 1.15
    sides = mc.with_named_sides(blocks)
    assert set(sides.sets) == {"wall", "far field", "inflow", "outflow"}
    on_wall = sides.points[sides.get("line")[sides.sets["wall"] - mesh.n_cells]]
    length = np.linalg.norm(np.diff(on_wall, axis=1), axis=-1).sum()
    loop = polyline(SECTIONS[name])
    whole = np.linalg.norm(np.diff(loop, axis=0), axis=1).sum() * (2 if "slit" in name else 1)
    assert length == pytest.approx(whole, rel=1e-3)


METHODS = ("elliptic", "hyperbolic", "parabolic")
CHANNEL = np.array([[-2, -1.2], [0.5, -1.0], [3, -1.4], [3.2, 1.5], [0, 1.1], [-2.2, 1.4], [-2, -1.2]])


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", SECTIONS)
def test_each_method_fills_the_box_without_a_folded_cell(name, method):
    keywords = {"around": 80} if name == "slab" else {}
    blocks, report = mc.h_grid(SECTIONS[name], method=method, first_height=1e-4, radius=5, **keywords)
    assert_sound(blocks)
    assert not report.warnings or method == "elliptic"
    plain, _ = mc.h_grid(SECTIONS[name], first_height=1e-4, radius=5, **keywords)
    for block, flat in zip(blocks.blocks, plain.blocks, strict=True):
        assert block.shape == flat.shape
        assert block.to_mesh().bounds == pytest.approx(flat.to_mesh().bounds, abs=1e-9)
        for end in (0, -1):  # inflow and outflow are where they were
            assert distance_to(flat.points[end, :, 0, :2], block.points[end, :, 0, :2]).max() < 1e-9
        wall = -1 if block.names["jmax"] == "wall" else 0
        assert np.array_equal(block.points[:, wall], flat.points[:, wall])
        assert np.abs(block.points - flat.points).max() > 1e-3 or "slit" in name


@pytest.mark.parametrize("method", ["hyperbolic", "parabolic"])
@pytest.mark.parametrize("name", ["circle", "square", "slit", "bent slit", "rae2822", "s1223"])
def test_marches_leave_section_and_cuts_with_the_height_asked_for(name, method):
    """Alike on both sides of the cuts, and growing as asked on the way."""
    blocks, report = mc.h_grid(SECTIONS[name], method=method, first_height=1e-5)
    lower, upper = blocks.blocks[0].points[:, ::-1, 0], blocks.blocks[1].points[:, :, 0]
    for points in (lower, upper):
        heights = np.linalg.norm(np.diff(points, axis=1), axis=2)
        assert np.abs(heights[:, 0] / 1e-5 - 1).max() < 0.02
        mean = heights[report.counts["ahead"] : len(points) - report.counts["wake"]].mean(axis=0)
        growth = mean[1:] / mean[:-1]
        off = np.abs(growth / np.median(growth) - 1)
        assert off.max() < 0.04 and (off < 0.02).mean() > 0.94 and np.median(growth) < 1.151
    ahead = blocks.cuts[0].points[1][0]
    apart = upper[1 : ahead - 1, 1] - lower[1 : ahead - 1, 1]
    assert np.abs(apart[:, 0]).max() < 1e-5


@pytest.mark.parametrize("method", ["hyperbolic", "parabolic"])
def test_where_layers_fold_at_a_thin_edge_lines_far_along_the_wake_stay_where_they_are(method):
    """Long flat cells do not need the dissipation that unfolds those at the edge; it made them lean by 89.9 degrees."""
    loop = np.array([[1, 0.00025], [0.7, 0.04], [0.3, 0.06], [0, 0], [0.3, -0.06], [0.7, -0.04], [1, -0.00025]])
    blocks, report = mc.h_grid(np.vstack([loop, loop[:1]]), method=method, first_height=1e-5)
    assert report.counts["layers in smaller steps"] > 0
    wake = report.counts["wake"]
    for block in blocks.blocks:
        away = np.diff(block.points[-(wake // 2) :, :, 0], axis=1)
        assert np.abs(away[..., 0] / away[..., 1]).max() < 3


@pytest.mark.parametrize("name", ["circle", "square", "rae2822", "s1223", "slit"])
def test_the_elliptic_equations_hold_right_angles_and_heights(name):
    blocks, _ = mc.h_grid(SECTIONS[name], method="elliptic", first_height=1e-4)
    for points in (blocks.blocks[0].points[:, ::-1, 0], blocks.blocks[1].points[:, :, 0]):
        heights = np.linalg.norm(points[:, 1] - points[:, 0], axis=1) / 1e-4
        assert (np.abs(heights - 1) < 0.02).mean() > 0.9
        along, away = points[2:, 0] - points[:-2, 0], (points[:, 1] - points[:, 0])[1:-1]
        sine = (along * away).sum(axis=1) / np.linalg.norm(along, axis=1) / np.linalg.norm(away, axis=1)
        assert np.median(np.abs(np.degrees(np.arcsin(sine)))) < 1


@pytest.mark.parametrize("method", ["transfinite", *METHODS])
def test_a_channel_of_your_own_is_met_on_all_four_sides(method):
    blocks, _ = mc.h_grid(gallery.airfoil("rae2822"), CHANNEL, method=method, first_height=1e-3)
    assert_sound(blocks)
    lower, upper = (block.points[:, :, 0, :2] for block in blocks.blocks)
    for line in (lower[0], lower[-1], lower[:, 0], upper[0], upper[-1], upper[:, -1]):
        assert distance_to(CHANNEL, line).max() < 1e-9
    corners = lower[0, 0], lower[-1, 0], upper[-1, -1], upper[0, -1]
    assert np.abs(np.array(corners) - CHANNEL[[0, 2, 3, 5]]).max() < 1e-9
    heights = np.linalg.norm(upper[:, 1] - upper[:, 0], axis=1)
    assert np.median(heights) == pytest.approx(1e-3, rel=0.02)


def distance_to(line, points):
    """Of points from a polyline."""
    start, edge = line[:-1], np.diff(line, axis=0)
    away = points[:, None] - start
    share = np.clip((away * edge).sum(axis=2) / (edge**2).sum(axis=1), 0, 1)
    return np.linalg.norm(away - share[..., None] * edge, axis=2).min(axis=1)


def test_a_round_far_field_has_corners_where_it_is_diagonal():
    blocks, _ = mc.h_grid(gallery.airfoil("naca0012"), gallery.circle(80, radius=4, centre=(0.5, 0)), first_height=1e-3)
    assert_sound(blocks)
    assert blocks.blocks[1].points[0, -1, 0] == pytest.approx([0.5 - 8**0.5, 8**0.5, 0], abs=1e-9)


def test_the_box_is_where_it_is_asked():
    blocks, _ = mc.h_grid(gallery.airfoil("naca0012"), radius=4, wake=6, first_height=1e-3)
    low, high = blocks.to_mesh().bounds
    assert low[:2] == pytest.approx([-3.5, -4], rel=1e-6) and high[:2] == pytest.approx([7, 4], rel=1e-6)


def test_a_slit_is_a_cartesian_grid_with_two_sides():
    blocks, _ = mc.h_grid(SLIT, radius=2, first_height=0.01)
    lower, upper = (block.points[:, :, 0] for block in blocks.blocks)
    assert np.ptp(upper[..., 0], axis=1).max() < 1e-12 and np.ptp(upper[..., 1], axis=0).max() < 1e-12
    assert np.abs(lower[:, ::-1] * [1, -1, 1] - upper).max() < 1e-12
    assert blocks.to_mesh().n_points == blocks.n_points - (upper.shape[0] - 19)  # the slit's inner points are two


def test_the_box_turns_with_the_flow():
    blocks, _ = mc.h_grid(gallery.airfoil("rae2822"), flow=10.0, first_height=1e-3)
    assert_sound(blocks)
    inflow = blocks.blocks[1].points[0, :, 0]
    way = inflow[-1] - inflow[0]
    assert np.degrees(np.arctan2(way[1], way[0])) == pytest.approx(100, abs=0.5)


def test_operators_go_through_the_cuts():
    blocks, _ = mc.h_grid(gallery.airfoil("naca0012"), radius=3, first_height=5e-3, around=120)
    values = [b.points[..., 0] ** 2 + b.points[..., 1] ** 2 for b in blocks.blocks]
    lower, upper = Curvilinear(blocks).laplacian(values)
    ahead = blocks.cuts[0].points[1][0]
    assert np.abs(upper[3:5, 0] - 4).max() < 0.1  # nearer to the nose lines bend sharply
    assert np.abs(upper[3 : ahead - 4, 0] - lower[3 : ahead - 4, -1]).max() < 1e-6


@pytest.mark.parametrize(
    ("section", "keywords", "error", "words"),
    [
        (np.array([[0, 0], [2, 2], [2, 0], [0, 1.5], [0, 0]]), {}, InvalidGeometry, "crosses itself"),
        (np.array([[0, 0], [1, 0], [0.5, 0.2], [1.5, 0.3]]), {}, InvalidGeometry, "turns back"),
        (gallery.airfoil("rae2822"), {"first_height": 8.0}, InvalidInput, "first_height"),
        (gallery.airfoil("rae2822"), {"layers": 10**9}, InvalidInput, "layers"),
        (np.zeros((3, 2)), {}, InvalidGeometry, "different points"),
        (SLIT, {"outer": CHANNEL[:-1]}, InvalidGeometry, "outer: is open"),
        (SLIT, {"outer": CHANNEL + [9, 0]}, InvalidGeometry, "does not go round all of the section"),
        (SLIT, {"outer": [[-1, -1], [2, -1], [0, 2], [-1, -1]]}, InvalidGeometry, "four corners"),
        (SLIT, {"outer": ZIGZAG}, InvalidGeometry, "crossed 3 times at its inflow"),
        (SLIT, {"outer": CHANNEL, "first_height": 2.0}, InvalidInput, "first_height"),
    ],
)
def test_bad_input_gets_a_clear_error(section, keywords, error, words):
    with pytest.raises(error, match=words):
        mc.h_grid(section, **keywords)


@pytest.mark.parametrize("method", ["transfinite", *METHODS])
def test_layers_begin_as_asked_beside_blunt_edges_and_grow_evenly(method):
    """They were up to 2.2 times as high, and grew by 1.5 where the march went on from the layers round the edge."""
    blocks, report = mc.h_grid(SECTIONS["naca0012"], method=method)
    assert_sound(blocks)
    assert report.quality["least first height / asked"] > 0.98
    assert report.quality["largest first height / asked"] < 1.02
    assert report.quality["largest growth"] < 1.31


@pytest.mark.parametrize(
    ("family", "k", "method"),
    [
        ("NACA 5", 1, "transfinite"),
        ("NACA 5", 1, "elliptic"),
        ("PARSEC", 5, "parabolic"),
        ("measured", 7, "hyperbolic"),
        ("ellipse", 19, "hyperbolic"),
        ("vehicle", 24, "parabolic"),
        ("Bezier", 66, "parabolic"),
        ("plate", 111, "transfinite"),
    ],
)
def test_first_heights_in_the_corners_between_section_and_cuts_are_those_asked_for(family, k, method):
    trial = tried("H", method, section_of(family, 900, k))
    assert trial.word == "sound" and trial.heights == 0, trial


def test_two_tips_with_a_bay_between_them_are_no_flat_front():
    # Five spikes, two of them at the same x: the bay was bridged by a straight front.
    angle = np.pi / 5 * (np.arange(10) + 1)
    loop = np.where(np.arange(10) % 2, 0.75, 1.0)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    outline = np.vstack([loop, loop[:1]])
    blocks, _ = mc.h_grid(outline, method="hyperbolic", first_height=0.02)
    lower, upper = blocks.blocks
    wall = np.concatenate([lower.points[:, -1, 0, :2], upper.points[:, 0, 0, :2]])
    assert np.linalg.norm(wall[:, None] - loop, axis=-1).min(axis=0).max() < 1e-12


def test_a_round_nose_of_many_points_is_no_flat_front():
    angle = np.linspace(0, 2 * np.pi, 4001)
    ellipse = np.column_stack([np.cos(angle), 0.2 * np.sin(angle)])
    blocks, _ = mc.h_grid(ellipse, layers=8, first_height=0.01)
    wall = np.concatenate([blocks.blocks[0].points[:, -1, 0, :2], blocks.blocks[1].points[:, 0, 0, :2]])
    for end in (ellipse[0], ellipse[2000]):
        assert np.linalg.norm(wall - end, axis=1).min() < 1e-12
