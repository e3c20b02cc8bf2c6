"""Parabolic grids: the outer curve met exactly, lines square to the front, every airfoil, sides, bad input."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery
from meshcore.errors import Cancelled, InvalidGeometry, InvalidInput
from meshcore.geometry.curves import lines_through, polyline
from meshcore.sizing import Spacing, geometric
from meshcore.structured.marching.parabolic_march import marched
from tests import naive_marching as naive
from tests.sections import EDGES, KINDS, section

LIFTED = polyline(gallery.circle(9, radius=2)) + [0, 0, 1]
LINE = np.column_stack([np.linspace(0, 1, 21), np.zeros(21)])


def test_between_straight_lines_it_is_the_rectangle():
    fractions = geometric(12, first=0.01)
    points = marched(LINE, LINE + [0, 2], fractions).points
    assert np.abs(points - (LINE[:, None] + 2 * fractions[:, None] * [0, 1])).max() < 1e-14


@pytest.mark.parametrize("n", [12, 65])
def test_between_circles_it_is_the_polar_grid(n):
    angle = -2 * np.pi * np.arange(n) / n
    front = np.column_stack([np.cos(angle), np.sin(angle)])
    points = marched(front, 4 * front, geometric(20, first=0.01), closed=True).points
    direction = points / np.linalg.norm(points, axis=2)[..., None]
    assert np.abs(direction - front[:, None]).max() < 1e-13
    assert np.ptp(np.linalg.norm(points, axis=2), axis=0).max() < 1e-13
    assert (points[:, -1] == 4 * front).all()


@pytest.mark.parametrize("name", gallery.airfoils())
@pytest.mark.parametrize("radius", [1.5, 15.0])
@pytest.mark.parametrize("cells", [None, 201])
def test_airfoils_meet_their_far_field(name, radius, cells):
    section = gallery.airfoil(name, cells=cells)
    far_field = gallery.circle(64, radius=radius, centre=(0.5, 0.0))
    grid, report = mc.parabolic(section, far_field, first_height=1e-4)
    points = grid.points[:, :, 0, :2]
    assert naive.sound(points[:-1], True) and report.converged
    assert {tuple(p) for p in points[:, 0]} == {tuple(p) for p in polyline(section)[:, :2]}
    chord = radius * np.cos(np.pi / 64)
    assert (np.linalg.norm(points[:, -1] - [0.5, 0], axis=1) > chord - 1e-9).all()
    first = np.linalg.norm(points[:, 1] - points[:, 0], axis=1)
    assert np.median(first) == pytest.approx(1e-4, rel=0.02) and first.max() < 1.2e-4
    tangent, away = points[2:, 0] - points[:-2, 0], points[1:-1, 1] - points[1:-1, 0]
    cosine = (tangent * away).sum(axis=1) / np.linalg.norm(tangent, axis=1) / np.linalg.norm(away, axis=1)
    assert np.median(np.abs(cosine)) < 0.01


@pytest.mark.parametrize("k", range(30))
def test_any_section_reaches_circles_and_boxes(k):
    rng = np.random.default_rng([4, k])
    front = section(rng, KINDS[k % 3], EDGES[k // 3 % 3])
    far = rng.uniform(0.8, 10)
    box = np.array([[-far, -far], [far, -far], [far, far], [-far, far], [-far, -far]]) * [rng.uniform(1, 2), 1]
    outer = gallery.circle(int(rng.integers(12, 200)), radius=far, centre=(0.5, 0.0)) if k % 2 else box + [0.5, 0]
    grid, _ = mc.parabolic(front, outer, first_height=1e-3)
    assert naive.sound(grid.points[:-1, :, 0, :2], True)
    first = np.linalg.norm(grid.points[:, 1, 0] - grid.points[:, 0, 0], axis=1)
    assert np.median(first) == pytest.approx(1e-3, rel=0.02)


@pytest.mark.parametrize("k", range(12))
def test_open_fronts_that_bend_reach_roofs_that_are_shifted(k):
    rng = np.random.default_rng([5, k])
    x = np.linspace(0, 1, int(rng.integers(20, 120)))
    front = np.column_stack([x, rng.uniform(0, 0.15) * np.sin(rng.uniform(1, 12) * x + rng.uniform(0, 7))])
    roof = np.column_stack([x * rng.uniform(0.7, 1.3) + rng.uniform(-0.3, 0.3), rng.uniform(0.5, 2) + 0 * x])
    grid, report = mc.parabolic(front, roof[:: (-1) ** k], first_height=1e-3)
    assert report.converged and naive.sound(grid.points[:, :, 0, :2], False)


def test_points_of_the_outer_curve_are_kept_and_paired():
    inner, outer = gallery.circle(24), gallery.circle(24, radius=3.0, centre=(0.3, 0.0))
    grid, _ = mc.parabolic(inner, outer, layers=8, first_height=0.05)
    assert {tuple(p) for p in grid.points[:, -1, 0]} == {tuple(p) for p in outer.points}
    assert np.linalg.norm(grid.points[0, -1, 0] - [3.3, 0, 0]) < 1e-12


def test_corners_of_the_outer_curve_are_points_of_the_grid():
    box = polyline(gallery.square(size=6.0)) - [2.5, 3, 0]
    grid, _ = mc.parabolic(gallery.airfoil("rae2822"), box, first_height=1e-3)
    outer = {tuple(p) for p in grid.points[:, -1, 0].round(9)}
    assert {tuple(p) for p in box.round(9)} <= outer and naive.sound(grid.points[:-1, :, 0, :2], True)


def test_sides_and_spacing_of_an_open_front():
    wave = LINE + [0, 0.1] * np.sin(2 * np.pi * LINE[:, :1])
    roof = np.array([[0.0, 1.0], [0.4, 1.3], [1.2, 1.0]])
    side = np.array([[1.0, 0], [1.2, 0.4], [1.2, 1.0]])
    spacing = Spacing("hyperbolic tangent", first=0.02, last=0.05)
    grid, _ = mc.parabolic(wave, roof[::-1], last_side=side, layers=20, spacing=spacing)
    points = grid.points[:, :, 0, :2]
    assert naive.sound(points, False) and (points[-1, -1] == roof[-1]).all() and (points[0, -1] == roof[0]).all()
    bent = points[-1][points[-1, :, 1] > 0.4]
    assert len(bent) > 5 and np.abs(bent[:, 0] - 1.2).max() < 1e-13 and np.abs(points[0, :, 0]).max() < 1e-13
    steps = np.linalg.norm(np.diff(points, axis=1), axis=2)
    assert np.median(steps[:, 0]) == pytest.approx(0.02, rel=0.05) and np.median(steps[:, -1]) < 0.1


@pytest.mark.parametrize(
    ("front", "outer", "keywords", "error", "words"),
    [
        (gallery.circle(12), LINE, {}, InvalidGeometry, "is open, but the front is closed"),
        (LINE, gallery.circle(12), {}, InvalidGeometry, "is closed, but the front is open"),
        (gallery.circle(12), LIFTED, {}, InvalidGeometry, "off the front's plane"),
        (gallery.circle(12), gallery.circle(12, radius=2.0), {"first_height": 2.0}, InvalidInput, "comes as near"),
        (gallery.circle(12), gallery.circle(12, radius=2.0), {"first_height": 0.0}, InvalidInput, "greater than zero"),
        (gallery.circle(12), gallery.circle(12, radius=2.0), {"spacing": Spacing()}, InvalidInput, "layers"),
        (
            LINE,
            LINE * [1, 0] + LINE[:, :1] * [0, 1],
            {"layers": 5},
            InvalidGeometry,
            "touches the front at its point 0",
        ),
        (LINE, LINE + [0, 1], {"first_side": [[0, 0.5], [0, 1.0]]}, InvalidInput, "away from"),
        (LINE, [[0, np.nan], [1, 1]], {}, InvalidInput, "nan"),
    ],
)
def test_bad_input(front, outer, keywords, error, words):
    with pytest.raises(error, match=words):
        mc.parabolic(front, outer if not isinstance(outer, list) else np.array(outer, float), **keywords)


def test_an_outer_curve_inside_the_body_is_refused():
    with pytest.raises(mc.MeshcoreError):
        mc.parabolic(gallery.circle(24), gallery.circle(24, radius=0.5), layers=5)


@pytest.mark.parametrize("fractions", [[0, 0.5, 0.5, 1], [0.1, 1], [0, 0.9], np.zeros((3, 4))])
def test_fractions_must_increase_from_0_to_1(fractions):
    with pytest.raises(InvalidInput, match="fractions"):
        marched(LINE, LINE + [0, 1], np.asarray(fractions, float))


def test_progress_can_cancel():
    with pytest.raises(Cancelled):
        mc.parabolic(lines_through(LINE), LINE + [0, 1], progress=lambda fraction, message: False)
