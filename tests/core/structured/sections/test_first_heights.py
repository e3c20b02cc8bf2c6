"""First heights corrected along lines: exact, without a fold, the same on both sides of a cut."""

from __future__ import annotations

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery
from meshcore.structured.sections.first_heights import with_first_heights, worst_jacobian
from tests.section_families import section_of
from tests.section_trials import to_edges, tried
from tests.soundness import folded


def reached(points: np.ndarray) -> np.ndarray:
    return np.linalg.norm(points[:, 1] - points[:, 0], axis=1)


@pytest.mark.parametrize("factor", [0.8, 0.9, 0.995, 1.1])
def test_lines_get_the_heights_asked_for_and_stay_the_lines_they_are(factor):
    points = mc.o_grid(gallery.airfoil("naca0012"), radius=4)[0].points[:, :, 0]
    asked = reached(points) * np.where(np.arange(len(points)) % 3, 1.0, factor)
    asked[-1] = asked[0]
    found = with_first_heights(points, asked)
    assert np.abs(reached(found) / asked - 1).max() < 0.0101
    assert not folded(found[..., :2]).any()
    assert (found[:, [0, -1]] == points[:, [0, -1]]).all() and (found[0] == found[-1]).all()
    assert (found[1::3] == points[1::3]).all()


def corner(lacks: float) -> tuple[np.ndarray, np.ndarray]:
    """Lines off a wall with a right angle, the one in the corner beginning too high by a factor, and its number."""
    k, height = np.arange(-12, 13), np.append(0.0, np.cumsum(1.15 ** np.arange(18)))
    x, y = np.maximum(2 * k, 0), np.maximum(-2 * k, 0)
    lines = np.zeros((25, 19, 3))
    lines[..., 0], lines[..., 1] = (x[:, None] + height, y[:, None] + height)
    lines[12, 1:6] *= np.linspace(lacks, 1, 5)[:, None]
    return lines, np.full(25, 2**0.5)


def test_a_line_in_a_corner_shares_what_it_lacks_with_its_neighbours_where_it_would_make_a_kink():
    lines, asked = corner(2.0)
    found = with_first_heights(lines, asked)
    assert not folded(lines[..., :2]).any() and not folded(found[..., :2]).any()
    assert np.abs(reached(found) / asked - 1).max() < 0.0101
    assert worst_jacobian(found) > 0.6  # 0.14 if it moves alone
    away = np.abs(found - lines).max(axis=(1, 2))
    assert 0 < away[0] < away[6] < away[11] < away[12]
    assert found[:12] == pytest.approx(found[:12:-1][..., [1, 0, 2]])  # alike on both sides


def test_lines_that_would_fold_all_the_same_stay():
    points = np.zeros((3, 4, 3))
    points[:, 0, 0], points[..., 1] = np.arange(3), [0, 1, 2, 3]
    points[0, 1:, 0] = -0.5
    points[1:, 1:, 0] = [[1.9, 2.8, 3.7], [2.2, 3.2, 4.2]]  # the second's first point would be behind the third
    found = with_first_heights(points, np.array([1.118, 2.7, 1.02]))
    assert (found == points).all()


def test_elliptic_grids_have_the_first_heights_asked_for_at_sharp_edges_too():
    for family, k in (("NACA 6", 2), ("flapped", 12), ("L, T", 22), ("pocket", 27)):
        trial = tried("O", "elliptic", section_of(family, 100, k))
        assert trial.word == "sound" and trial.heights == 0, trial


@pytest.mark.parametrize(("family", "seed", "k"), [("kinked", 100, 26), ("NACA 4", 100, 31), ("plate", 300, 80)])
def test_where_the_wall_of_an_elliptic_grid_cannot_be_held_layers_of_the_start_stay(family, seed, k):
    section = section_of(family, seed, k)
    trial = tried("O", "elliptic", section)
    assert trial.word == "sound" and trial.heights == 0 and trial.converged, trial
    assert "layers on it stay as they were" in trial.text
    grid, flat = (mc.o_grid(section, method=method)[0].points for method in ("elliptic", "transfinite"))
    layers = int(trial.text.split(" layers on it")[0].split()[-1])
    for stayed, line in zip(grid[:, : layers + 1, 0], flat[:, :, 0], strict=True):  # points move along their lines
        assert max(to_edges(point, line[:-1], line[1:]) for point in stayed) < 0.01 * np.ptp(section)
    assert np.abs(grid[:, layers + 2 :] - flat[:, layers + 2 :]).max() > 1e-3 * np.ptp(section)


def test_a_start_that_is_folded_is_smoothed_first_and_then_has_its_wall_held():
    section = section_of("vehicle", 300, 55)
    grid, _ = mc.o_grid(section, method="hyperbolic")
    centre, reach = grid.points[:-1, -1, 0, :2].mean(axis=0), 10 * np.ptp(section, axis=0).max()
    outer = centre + reach * gallery.circle(90).points[np.r_[0:90, 0], :2]
    trial = tried("O", "parabolic", section, outer=outer)
    assert "the elliptic equations took its place" in trial.text
    assert trial.word == "sound" and trial.heights == 0, trial
