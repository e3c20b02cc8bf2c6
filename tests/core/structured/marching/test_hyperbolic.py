"""Hyperbolic grids: the equations' own residual, exact circles, symmetry, ends, every airfoil, bays, bad input."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery
from meshcore.errors import Cancelled, GenerationFailed, InvalidGeometry, InvalidInput
from meshcore.geometry.curves import lines_through, polyline, turning
from meshcore.quality import line_angle
from meshcore.sizing.around_loop import respaced_loop
from meshcore.structured.marching._block_tridiagonal_kernels import solve
from meshcore.structured.marching._collision_kernels import collisions
from meshcore.structured.marching.hyperbolic_march import Dissipation, marched
from meshcore.structured.marching.layer_heights import layer_heights
from meshcore.structured.marching.marching_ends import Along, Free, Mirror, OnCurve, Splay
from tests import naive_marching as naive
from tests.outlines import outline, random_outlines


def clockwise_circle(n, radius=1.0):
    angle = -2 * np.pi * np.arange(n) / n
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def section(name, cells=None):
    loop = polyline(gallery.airfoil(name))[:-1, :2]
    return (loop if cells is None else respaced_loop(loop, cells))[::-1]


# ---- the equations


@pytest.mark.parametrize("closed", [False, True])
def test_block_solver_agrees_with_a_dense_one(closed):
    rng = np.random.default_rng(3)
    lower, upper = rng.normal(size=(2, 9, 4))
    diagonal = rng.normal(size=(9, 4)) + [8, 0, 0, 8]
    right = rng.normal(size=(9, 2))
    if not closed:
        lower[0] = upper[-1] = 0
    expected = naive.dense_block_solution(lower, diagonal, upper, right, closed)
    solve(lower, diagonal, upper, right, closed, np.zeros((9, 4)))
    assert np.abs(right - expected).max() < 1e-14


@pytest.mark.parametrize("volume", [(0.0, 0.0), (1.0, 0.0), (0.4, 0.6), (1.0, 1.0)])
@pytest.mark.parametrize("waist", [0.0, 0.25, 0.45], ids=["convex", "shallow bays", "deeper bays"])
def test_a_step_satisfies_the_linearised_equations(volume, waist):
    angle = np.linspace(0, -2 * np.pi, 61)[:-1]
    angle += 0.02 * np.sin(3 * angle)  # unevenly spaced
    radius = 1 + waist * np.cos(2 * angle)
    front = radius[:, None] * np.column_stack([np.cos(angle), 0.6 * np.sin(angle)])
    dissipation = Dissipation(volume_smoothing=volume[0], volume_averaging=volume[1])
    heights = np.array([0.005, 0.02, 0.02])
    points = marched(front, heights, closed=True, dissipation=dissipation).points
    for k, height in enumerate(heights):
        expected = naive.hyperbolic_step(points[:, k], height, Dissipation.base, *volume, front)
        assert np.abs(points[:, k + 1] - expected).max() < 1e-13


def test_dissipation_at_concave_corners_is_that_of_the_twin():
    """They turn by 55 degrees, so that Chan and Steger's a is 1.3."""
    corner = clockwise_circle(10)
    corner[1::2] *= 0.5
    after = np.roll(corner, -1, axis=0)
    front = (corner[:, None] + np.linspace(0, 1, 9)[:-1, None] * (after - corner)[:, None]).reshape(-1, 2)
    assert np.degrees(turning(front)).max() > 55
    points = marched(front, np.array([0.002]), closed=True).points
    assert np.abs(points[:, 1] - naive.hyperbolic_step(front, 0.002, Dissipation.base)).max() < 1e-13


def test_without_volume_smoothing_heights_are_kept_at_each_point_and_with_it_areas():
    front = section("naca0012", 120)
    heights = layer_heights(2e-3, 1.2, layers=12)
    growth = {}
    for share in (0.0, 1.0):
        points = marched(front, heights, closed=True, dissipation=Dissipation(0.0, volume_smoothing=share)).points
        lines = np.linalg.norm(np.diff(points, axis=1), axis=2)
        growth[share] = np.abs(np.log(lines / heights)).max()
    assert growth[0.0] < 0.5 * growth[1.0]


@pytest.mark.parametrize(("base", "limits"), [(0.0, (0.003, 0.02)), (Dissipation.base, (0.003, 0.025))])
def test_lines_become_orthogonal_and_areas_as_asked_as_steps_get_smaller(base, limits):
    errors = []
    for n in (80, 160, 320):
        angle = np.linspace(0, -2 * np.pi, n + 1)[:-1]
        front = np.column_stack([np.cos(angle), 0.6 * np.sin(angle)])
        height = 4 / n
        points = marched(front, np.full(n // 8, height), closed=True, dissipation=Dissipation(base)).points
        along = 0.5 * (np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0))
        layer, middle = np.diff(points, axis=1), 0.5 * (along[:, 1:] + along[:, :-1])
        size = np.linalg.norm(middle, axis=2)
        orthogonality = np.abs((middle * layer).sum(axis=2) / size).max() / height
        area = middle[..., 0] * layer[..., 1] - middle[..., 1] * layer[..., 0]
        errors.append((orthogonality, np.abs(area / (height * size) - 1).max()))
    errors = np.array(errors)
    print(errors)
    assert (errors[-1] < limits).all() and (errors[1:, 1] < 0.6 * errors[:-1, 1]).all()


@pytest.mark.parametrize("n", [12, 65, 400])
@pytest.mark.parametrize("inwards", [False, True])
def test_a_circle_gives_the_polar_grid(n, inwards):
    heights = layer_heights(0.01, 1.1, layers=8 if inwards else 60)
    front = clockwise_circle(n)[:: -1 if inwards else 1]
    points = marched(front, heights, closed=True).points
    radius = 1 + (-1 if inwards else 1) * np.concatenate([[0], np.cumsum(heights)])
    assert points.shape == (n, len(heights) + 1, 2)
    assert np.abs(points - radius[:, None] * front[:, None]).max() < 1e-13 * radius.max()


def test_symmetric_sections_give_symmetric_grids():
    half = section("naca0012", 120)
    upper = half[half[:, 1] > 1e-9]
    upper = upper[np.argsort(-upper[:, 0])]
    front = np.concatenate([[[1.002, 0]], upper * [1, -1], [[-0.001, 0]], upper[::-1]])
    points = marched(front, layer_heights(1e-4, 1.15, layers=80), closed=True).points
    mirrored = np.roll(points[::-1], 1, axis=0) * [1, -1]
    assert np.abs(points - mirrored).max() < 1e-9 * np.abs(points).max()


@pytest.mark.parametrize(("points", "height"), [(90, 0.06), (530, 0.06), (90, 0.045)])
def test_fronts_about_to_meet_are_found_as_windows_and_pairs_across_bays_find_them(points, height):
    front = np.ascontiguousarray(horseshoe(0.35, 0.9, points))
    n = len(front)
    after = np.roll(front, -1, axis=0) - front
    normals = np.column_stack([-after[:, 1], after[:, 0]]) + np.roll(np.column_stack([-after[:, 1], after[:, 0]]), 1, 0)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    turn = turning(front)
    heights = np.full(n, height)
    windows = naive.handed_down(naive.windows(front, normals, heights, turn), n)
    pairs = naive.across_bays(front, normals, heights, turn, stride=1 + n // 513)
    expected = np.maximum(windows[0], pairs[0]), np.minimum(windows[1], pairs[1])
    r, t = np.zeros((2, n + 4)), np.zeros((2, n + 4))
    r[:, 2:-2], t[:, 2:-2] = front.T, np.column_stack([normals[:, 1], -normals[:, 0]]).T
    strength, shrink, turned, h = np.zeros((4, n + 4))
    turned[2:-2], h[2:-2] = np.cumsum(turn), heights
    collisions(r, t, turned, h, True, strength, shrink, np.zeros((4, n + 4)))
    assert (expected[0] > 0).sum() > n / 6 and expected[1].min() < 0.9
    assert (pairs[1] < windows[1]).any()
    assert np.abs(shrink[2:-2] - expected[1]).max() < 1e-12
    edges = strength[2:-2] > expected[0] + 1e-9  # those that vanish have a strength of their own
    assert (strength[2:-2] >= expected[0] - 1e-9).all() and (strength[2:-2][edges] <= 1).all()


# ---- any section


@pytest.mark.parametrize("name", gallery.airfoils())
@pytest.mark.parametrize("cells", [None, 101, 401])
@pytest.mark.parametrize("first", [1e-3, 1e-6])
def test_airfoils_with_default_parameters(name, cells, first):
    front = section(name, cells)
    heights = layer_heights(first, 1.3, layers=100, distance=15.0)
    result = marched(front, heights, closed=True)
    assert result.stop is None and naive.sound(result.points, True)
    assert (result.points[:, 0] == front).all()
    mean = np.linalg.norm(np.diff(result.points, axis=1), axis=2).mean(axis=0)
    assert np.abs(mean[1:] / mean[:-1] / (heights[1] / heights[0]) - 1).max() < 0.005


def cusped(n=100):
    centre = -0.08 + 0.1j
    circle = centre + abs(1 - centre) * np.exp(1j * (np.angle(1 - centre) - np.linspace(0, 2 * np.pi, n + 1)[:-1]))
    return (lambda w: np.column_stack([w.real, w.imag]))(circle + 1 / circle)


def star(arms, inner, n):
    angle = -np.pi * np.arange(2 * arms) / arms
    corners = np.where(np.arange(2 * arms) % 2, inner, 1.0)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    return subdivided(corners, n)


def subdivided(corners, n):
    corners = np.asarray(corners, float)
    after = np.roll(corners, -1, axis=0)
    length = np.linalg.norm(after - corners, axis=1)
    counts = np.maximum(1, np.round(n * length / length.sum()).astype(int))
    shares = [np.arange(m)[:, None] / m for m in counts]
    return np.concatenate([a + s * (b - a) for a, b, s in zip(corners, after, shares, strict=True)])


def horseshoe(width, depth, n):
    w, top = width / 2, 1 - depth
    return subdivided([(-1, -1), (-1, 1), (-w, 1), (-w, top), (w, top), (w, 1), (1, 1), (1, -1)], n)


@pytest.mark.parametrize(
    "front",
    [cusped(), cusped(400), star(5, 0.3, 200), star(8, 0.4, 500), section("s1223")[::3], horseshoe(0.6, 0.5, 200)],
    ids=["cusp", "fine cusp", "star", "eight arms", "coarse s1223", "bay"],
)
@pytest.mark.parametrize("first", [1e-2, 1e-4])
def test_other_sections(front, first):
    size = np.linalg.norm(np.ptp(front, axis=0))
    result = marched(front, layer_heights(first * size, 1.3, layers=80, distance=10 * size), closed=True)
    assert result.stop is None and naive.sound(result.points, True)


def test_edges_of_a_coarse_notch_that_vanish():
    front = np.array(
        [
            (0.43, -0.18),
            (0.11, -0.11),
            (0.22, -0.53),
            (-0, -0.8),
            (-0.31, -0.75),
            (-0.46, -0.46),
            (-0.73, -0.3),
            (-1.07, 0),
            (-1.12, 0.46),
            (-0.98, 0.98),
            (-0.48, 1.16),
            (0, 1.28),
            (0.45, 1.09),
            (1.11, 1.11),
            (1.38, 0.57),
            (1.33, 0),
        ]
    )
    size = np.linalg.norm(np.ptp(front, axis=0))
    result = marched(front, layer_heights(1e-4 * size, 1.5, layers=80, distance=10 * size), closed=True)
    assert result.stop is None and naive.sound(result.points, True)


def blob(seed, n=60):
    """A clockwise smooth body with narrow bays of few points."""
    rng, angle = np.random.default_rng(seed), -2 * np.pi * np.arange(n) / n
    waves = sum(rng.normal() / m * np.cos(m * angle + rng.uniform(0, 7)) for m in range(1, 12))
    return np.maximum(1 + 0.4 * waves, 0.15)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])


@pytest.mark.parametrize(("seed", "raised"), [(0, False), (543, True), (640, True), (998, True)])
def test_where_cells_would_fold_a_march_is_tried_with_more_dissipation(seed, raised):
    """With a fifteenth of the default, with which these bodies do not need it."""
    heights, smoothing = layer_heights(1e-4, 3.0, layers=80, distance=20.0), 0.02
    result = marched(blob(seed), heights, closed=True, dissipation=Dissipation(smoothing))
    assert result.stop is None and (result.raised > 1) == raised
    assert naive.sound(result.points, True)
    front = np.concatenate([blob(seed), blob(seed)[:1]])
    _, report = mc.hyperbolic(front, heights=heights, smoothing=smoothing)
    assert report.converged and any("times as much as asked" in text for text in report.warnings) == raised


def test_deep_bays_with_narrow_mouths_get_all_layers():
    stopped = 0
    for kind, front in random_outlines(40, seed=20):
        size = np.linalg.norm(np.ptp(front, axis=0))
        result = marched(front, layer_heights(1e-3 * size, 3.0, layers=60, distance=10 * size), closed=True)
        assert result.points.shape[1] == 1 or naive.sound(result.points, True)
        stopped += result.stop is not None and kind != "spiral"  # whose bays wind by more than a turn
    assert stopped == 0


@pytest.mark.parametrize(("name", "most"), [("naca0012", 11.5), ("rae2822", 11.8)])
def test_lines_off_airfoils_are_hardly_skew(name, most):
    """A third less than Construct2D's 17.3 and 17.7 degrees, away from the wall."""
    points = marched(section(name, 250), layer_heights(1e-5, 3.0, layers=100, distance=15.0), closed=True).points
    ring = np.concatenate([points, points[:1]])
    grid = mc.StructuredGrid(ring, periodic=(True, False, False))
    assert 90 - line_angle(grid)[:, 1:-1].min() < most


def test_a_march_that_cannot_go_on_stops_with_a_valid_grid_and_says_where():
    grid, report = mc.hyperbolic(gallery.l_shape(8), other_side=True, distance=3.0)
    assert not report.converged and "concave by" in report.warnings[-1] and "the front's point" in report.warnings[-1]
    (i, j, _) = np.argwhere(grid.point_data["stopped"])[0]
    assert j == grid.shape[1] - 1 and all(f"{x:.6g}" in report.warnings[-1] for x in grid.points[i, j, 0])
    assert 3 < grid.shape[1] < 60 and naive.sound(grid.points[:-1, :, 0, :2], True)


# ---- outer curves


@pytest.mark.parametrize("layers", [None, 2, 30])
@pytest.mark.parametrize("far", [1.0, 12.0])
def test_layers_end_on_the_outer_curve_if_there_is_one(layers, far):
    outer = gallery.circle(90, radius=far, centre=(0.5, 0))
    grid, report = mc.hyperbolic(gallery.airfoil("rae2822"), outer=outer, first_height=1e-3, layers=layers)
    assert report.converged and not [text for text in report.warnings if "clockwise" not in text]
    assert np.abs(np.linalg.norm(grid.points[:, -1, 0] - [0.5, 0, 0], axis=1) / far - 1).max() < 1e-3
    assert naive.sound(grid.points[:-1, :, 0, :2], True)
    first = np.linalg.norm(grid.points[:, 1, 0] - grid.points[:, 0, 0], axis=1)
    assert layers == 2 or np.abs(np.median(first) / 1e-3 - 1) < 0.02
    steps = np.linalg.norm(np.diff(grid.points[:, :, 0], axis=1), axis=-1)
    assert layers or np.median(steps[:, 1:] / steps[:, :-1], axis=0).max() < 1.32
    assert grid.shape[1] == (layers or {1.0: 36, 12.0: 54}[far]) + 1
    assert layers == 2 or report.quality["worst skew of lines (degree)"] < 35


def test_half_of_the_way_to_an_outer_curve_is_marched_as_without_one():
    body, heights = gallery.airfoil("naca0012"), layer_heights(1e-3, 1.2, layers=30)
    outer = gallery.circle(90, radius=2.0, centre=(0.5, 0))
    grid, _ = mc.hyperbolic(body, outer=outer, heights=heights)
    alone, _ = mc.hyperbolic(body, heights=heights)
    marched_layers = int(np.searchsorted(np.cumsum(heights), 0.5 * 1.5))
    assert marched_layers > 20
    assert np.array_equal(grid.points[:, : marched_layers + 1], alone.points[:, : marched_layers + 1])


def test_an_open_front_ends_on_an_open_outer_curve():
    roof = np.column_stack([np.linspace(-0.5, 1.5, 9), 1 + 0.2 * np.linspace(-1, 1, 9) ** 2])
    grid, report = mc.hyperbolic(LINE, outer=roof, first_height=0.01, growth=1.2)
    assert report.converged and naive.sound(grid.points[:, :, 0, :2], False)
    assert (grid.points[[0, -1], -1, 0, :2] == roof[[0, -1]]).all()


@pytest.mark.parametrize("far", [1.0, 3.0])
@pytest.mark.parametrize(("seed", "kind"), [([3, 3], "comb"), ([3, 1], "narrow C"), ([5, 241], "narrow C")])
def test_outer_curves_are_met_round_deep_bays(seed, kind, far):
    front = outline(np.random.default_rng(seed), kind)
    size, middle = np.linalg.norm(np.ptp(front, axis=0)), 0.5 * (front.max(axis=0) + front.min(axis=0))
    outer = gallery.circle(128, radius=far * size, centre=tuple(middle))
    grid, report = mc.hyperbolic(lines_through(front[::-1], closed=True), outer=outer, first_height=1e-4, layers=60)
    assert report.converged and grid.shape[1] == 61
    assert naive.sound(grid.points[:-1, :, 0, :2], True)
    assert np.abs(np.linalg.norm(grid.points[:, -1, 0, :2] - middle, axis=1) / (far * size) - 1).max() < 2e-3


def test_an_outer_curve_that_is_not_reached_leaves_a_sound_grid_and_is_told():
    front = outline(np.random.default_rng([3, 2]), "spiral")[::3]
    size = np.linalg.norm(np.ptp(front, axis=0))
    outer = gallery.circle(64, radius=2 * size)
    grid, report = mc.hyperbolic(lines_through(front[::-1], closed=True), outer=outer, first_height=1e-3, layers=20)
    assert not report.converged and "stopped after" in report.warnings[-1]
    assert 1 < grid.shape[1] < 21 and naive.sound(grid.points[:-1, :, 0, :2], True)


@pytest.mark.parametrize("k", [2, 6, 10, 14])
def test_fronts_that_meet_are_told_with_both_points_and_the_bay_between(k):
    front = outline(np.random.default_rng([3, k]), "spiral")
    size = np.linalg.norm(np.ptp(front, axis=0))
    result = marched(front, layer_heights(1e-3 * size, 3.0, layers=80, distance=10 * size), closed=True)
    stop, last = result.stop, result.points[:, -1]
    assert stop.reason == "fronts meet" and (stop.place == last[stop.point]).all()
    assert np.linalg.norm(last[stop.point] - last[stop.other]) < 0.5 * size
    first, second = sorted((stop.point, stop.other))
    turn = np.degrees(turning(last))
    bay = max(turn[first + 1 : second].sum(), turn.sum() - turn[first : second + 1].sum())
    assert 90 < stop.concavity < 400 and abs(bay - stop.concavity) < 180
    ring = np.concatenate([front[::-1], front[-1:]])
    try:
        text = mc.hyperbolic(ring, heights=layer_heights(1e-3 * size, 3.0, layers=80, distance=10 * size))[1].warnings[
            -1
        ]
    except GenerationFailed as error:
        text = str(error)
    given = sorted(len(front) - 1 - np.array([stop.point, stop.other]))
    assert f"fronts meet at the front's points {given[0]} and {given[1]} near" in text and "across a bay" in text


def test_the_point_told_is_numbered_as_in_the_mesh_that_was_given():
    corner = polyline(gallery.l_shape(8))[:-1]
    order = np.random.default_rng(0).permutation(len(corner))
    place = np.argsort(order)  # of each point of the loop in the mesh
    mesh = mc.Mesh(corner[order], {"line": np.column_stack([place, np.roll(place, -1)])})
    grid, report = mc.hyperbolic(mesh, other_side=True, distance=3.0)
    (i, *_) = np.argwhere(grid.point_data["stopped"])[0]
    told = int(report.warnings[-1].split("front's point")[1].split()[0].strip("s"))
    assert np.array_equal(mesh.points[told], grid.points[i, 0, 0])


# ---- open fronts and their ends

LINE = np.column_stack([np.linspace(0, 1, 21), np.zeros(21)])
HEIGHTS = layer_heights(0.01, 1.2, layers=12)


def test_a_straight_front_gives_straight_lines():
    points = marched(LINE, HEIGHTS).points
    expected = LINE[:, None] + np.concatenate([[0], np.cumsum(HEIGHTS)])[:, None] * [0, 1]
    assert np.abs(points - expected).max() < 1e-14


def test_dissipation_leaves_a_straight_front_alone_however_its_points_are_spaced():
    x = np.cumsum(np.concatenate([[0.0], np.geomspace(0.01, 1, 15), np.geomspace(1, 0.02, 12)]))
    points = marched(np.column_stack([x, 0 * x]), np.full(20, 0.5), dissipation=Dissipation(1.0)).points
    assert np.abs(points[..., 0] - x[:, None]).max() < 1e-12


@pytest.mark.parametrize("n", [9, 40])
def test_half_a_circle_with_planes_of_symmetry_is_half_the_polar_grid(n):
    angle = np.pi * (1 - np.arange(n + 1) / n)
    front = np.column_stack([np.cos(angle), np.sin(angle)])
    radius = 1 + np.concatenate([[0], np.cumsum(HEIGHTS)])
    for ends in ((Mirror((1, 0)), Mirror((-2, 0))), (Mirror(), Mirror())):
        points = marched(front, HEIGHTS, ends=ends).points
        limit = 1e-13 if ends[0].direction else 0.2  # square to the first edge is not quite square to the circle
        assert np.abs(points - radius[:, None] * front[:, None]).max() < limit


def test_ends_keep_their_lines():
    wave = LINE + [0, 0.05] * np.sin(5 * LINE[:, :1])
    points = marched(wave, HEIGHTS, ends=(Along((0, 1)), Along((1, 3)))).points
    assert np.abs(points[0, :, 0]).max() < 1e-15
    away = points[-1] - wave[-1]
    assert np.abs(3 * away[:, 0] - away[:, 1]).max() < 1e-14 and naive.sound(points, False)


@pytest.mark.parametrize("end", [Along((1, 3)), OnCurve(np.array([[0.0, 0], [5, 9]]))], ids=["along", "curve"])
def test_lines_beside_an_end_that_leaves_its_normal_do_not_crowd_however_far_the_front_comes(end):
    x = np.linspace(0, 1, 61)
    result = marched(np.column_stack([x, 0 * x]), np.full(40, 0.02), ends=(end, Free()))
    assert result.stop is None and naive.sound(result.points, False)


def test_an_end_follows_its_curve_by_the_heights():
    curve = np.array([[1.0, 0], [1.1, 0.1], [1.1, 5]])
    points = marched(LINE, HEIGHTS, ends=(Splay(30.0), OnCurve(curve[::-1]))).points
    total, knee = np.cumsum(HEIGHTS)[:, None], np.hypot(0.1, 0.1)
    expected = np.where(total < knee, [1.0, 0] + total / np.sqrt(2), [1.1, 0.1 - knee] + total * [0, 1])
    assert np.abs(points[-1, 1:] - expected).max() < 1e-14
    leaning = points[0, 1] - points[0, 0]
    assert np.degrees(np.arctan2(-leaning[0], leaning[1])) == pytest.approx(30)


def test_a_c_shaped_front_with_both_halves_of_its_wake_in_one_place():
    body = section("rae2822", 160)
    cut = np.argmax(body[:, 0])
    body = np.roll(body, -cut, axis=0)
    body = np.concatenate([body, body[:1]])
    wake = body[0] + np.linspace(0, 1, 30)[1:, None] ** 2 * [4.0, 0]
    front = np.concatenate([wake[::-1], body, wake])
    result = marched(front, layer_heights(1e-4, 1.15, layers=60), ends=(Along((0, 1)), Along((0, 1))))
    assert result.stop is None and naive.sound(result.points, False)
    assert np.abs(result.points[[0, -1], :, 0] - front[0, 0]).max() < 1e-12


# ---- heights


def test_heights():
    heights = layer_heights(1e-5, 1.2, distance=1.0)
    assert heights.sum() == pytest.approx(1) and heights[0] == 1e-5 and heights[1] / heights[0] <= 1.2
    assert len(heights) == 55
    assert layer_heights(0.1, 1.2, distance=1.0, largest=0.15).max() <= 0.15
    assert layer_heights(0.25, 1.0, distance=1.0).tolist() == [0.25] * 4


def test_heights_of_their_own_at_each_point():
    circle = gallery.circle(24)
    own = np.linspace(1, 2, 24) * np.full((3, 1), 0.01)
    grid, _ = mc.hyperbolic(circle, heights=own, smoothing=0.0)
    points = polyline(circle)[:-1]
    first = np.linalg.norm(grid.points[:-1, 1, 0] - grid.points[:-1, 0, 0], axis=1)
    given = [int(np.flatnonzero((points == p).all(axis=1))[0]) for p in grid.points[:-1, 0, 0]]
    assert np.abs(first / own[0][given] - 1)[2:-2].max() < 0.05


# ---- the operation


def test_the_front_is_kept_and_turned_as_said():
    square = polyline(gallery.square(6))
    grid, report = mc.hyperbolic(square)
    assert {tuple(p) for p in grid.points[:, 0, 0]} == {tuple(p) for p in square} and not report.warnings
    turned, report = mc.hyperbolic(square[::-1])
    assert "clockwise" in report.warnings[0] and np.allclose(turned.points[0, -1], grid.points[0, -1])
    assert grid.periodic == (True, False, False) and grid.names == {"jmin": "wall", "jmax": "outer"}


def test_any_plane():
    flat = polyline(gallery.airfoil("rae2822", cells=60))
    axes = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    lengths = {"first_height": 1e-3, "distance": 1.0}  # relative ones would turn with the bounding box
    grid, _ = mc.hyperbolic(flat @ axes.T, **lengths)
    expected, _ = mc.hyperbolic(flat, **lengths)
    same = expected.points @ axes.T
    assert min(np.abs(grid.points - same).max(), np.abs(grid.points[::-1] - same).max()) < 1e-9


@pytest.mark.parametrize(
    ("front", "keywords", "error", "words"),
    [
        ([[0, 0], [1, 1], [1, 0], [0, 2], [-1, 1], [0, 0]], {}, InvalidGeometry, "crosses itself"),
        ([[0, 0], [1, 0], [2, 0], [0, 0]], {}, InvalidGeometry, "no area"),
        ([[0, 0], [np.nan, 0], [2, 0]], {}, InvalidInput, "nan"),
        ([[0, 0], [0, 0]], {}, InvalidGeometry, "two different"),
        (LINE, {"first_height": 0.0}, InvalidInput, "greater than zero"),
        (LINE, {"first_height": -1.0}, InvalidInput, "greater than zero"),
        (LINE, {"growth": 0.9}, InvalidInput, "at least 1"),
        (LINE, {"growth": 3.1}, InvalidInput, "at most 3"),
        (LINE, {"first_height": 2.0, "layers": 3, "distance": 1.0}, InvalidInput, "reach past"),
        (LINE, {"first_height": 1e-9, "layers": 3, "distance": 1.0}, InvalidInput, "give more layers"),
        (LINE, {"first_end": "curve"}, InvalidInput, "first_curve"),
        (LINE, {"last_end": "curve", "last_curve": [[3, 0], [3, 1]]}, InvalidInput, "away from the front's end"),
        (polyline(gallery.square()), {"first_end": "plane"}, InvalidInput, "has no ends"),
        (LINE, {"heights": np.zeros(4)}, InvalidInput, "greater than zero"),
        (LINE, {"heights": np.ones((4, 3))}, InvalidInput, "needs shape"),
        (LINE, {"heights": np.array(0.1)}, InvalidInput, "needs shape"),
        (LINE, {"heights": np.empty(0)}, InvalidInput, "needs shape"),
        (LINE, {"heights": np.ones((2, 2, 2))}, InvalidInput, "needs shape"),
        (LINE, {"heights": np.full(3, 0.1 + 0j)}, InvalidInput, "real numbers"),
        (LINE, {"heights": [[0.1], [0.1, 0.2]]}, InvalidInput, "real numbers"),
        (LINE, {"outer": [[0, 1e300], [1, 1e300]]}, InvalidGeometry, "outer: has an extent"),
        (LINE, {"outer": [[0, 1], [1, 1]], "distance": 2.0}, InvalidInput, "distance: is given beside an outer curve"),
        (LINE, {"outer": [[0, 1], [1, 1]], "largest_height": 2.0}, InvalidInput, "largest_height: is given beside"),
        (LINE, {"outer": [[0, 1], [1, 1]], "first_height": 2.0}, InvalidInput, "comes as near as 1"),
        (LINE, {"outer": [[0, 0], [1, 1]]}, InvalidGeometry, "outer: touches the front"),
    ],
)
def test_bad_input(front, keywords, error, words):
    with pytest.raises(error, match=words):
        mc.hyperbolic(np.asarray(front, float), **keywords)


def test_three_points_and_repeated_ones_are_enough():
    triangle = np.array([[0.0, 0], [1, 0], [1, 0], [0.3, 0.8], [0, 0]])
    grid, report = mc.hyperbolic(triangle, layers=10, first_height=0.01)
    assert report.converged and grid.shape == (4, 11, 1) and "repeated" in report.warnings[0]


def test_progress_can_cancel():
    with pytest.raises(Cancelled):
        mc.hyperbolic(gallery.circle(32), progress=lambda fraction, message: False)


def test_not_even_one_layer():
    needle = np.array([[0.0, 0], [1, 0], [1, 1], [0.501, 1], [0.5, 1e-7], [0.499, 1], [0, 1], [0, 0]])
    with pytest.raises(GenerationFailed, match="the front's point"):
        mc.hyperbolic(needle, first_height=0.5, layers=2)
