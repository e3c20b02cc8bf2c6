"""First heights corrected along lines: exact, without a fold, the same on both sides of a cut."""

from __future__ import annotations

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery
from meshcore.structured.sections.first_heights import with_first_heights
from tests.section_families import section_of
from tests.section_trials import tried
from tests.soundness import folded


def reached(points: np.ndarray) -> np.ndarray:
    return np.linalg.norm(points[:, 1] - points[:, 0], axis=1)


@pytest.mark.parametrize("factor", [0.5, 0.9, 0.995, 1.1])
def test_lines_get_the_heights_asked_for_and_stay_the_lines_they_are(factor):
    points = mc.o_grid(gallery.airfoil("naca0012"), radius=4)[0].points[:, :, 0]
    asked = reached(points) * np.where(np.arange(len(points)) % 3, 1.0, factor)
    asked[-1] = asked[0]
    found = with_first_heights(points, asked)
    assert np.abs(reached(found) / asked - 1).max() < 0.0101
    assert not folded(found[..., :2]).any()
    assert (found[:, [0, -1]] == points[:, [0, -1]]).all() and (found[0] == found[-1]).all()
    assert (found[1::3] == points[1::3]).all()


def test_lines_that_would_fold_stay():
    points = np.zeros((3, 4, 3))
    points[..., 0] = np.arange(3)[:, None]
    points[..., 1] = [0, 1, 2, 3]
    points[1, 1:, 0] += 1.5  # leans so far that its first point, lower, is beyond the next line
    points[2, 1:, 0] += 2.0
    found = with_first_heights(points, np.array([1.0, 1.0, 0.01]))
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
    assert np.abs(grid[:, : layers + 1] - flat[:, : layers + 1]).max() < 0.01 * np.ptp(section)  # along their lines
    assert np.abs(grid[:, layers + 2 :] - flat[:, layers + 2 :]).max() > 1e-3 * np.ptp(section)


def test_a_start_that_is_folded_is_smoothed_first_and_then_has_its_wall_held():
    section = section_of("vehicle", 300, 55)
    grid, _ = mc.o_grid(section, method="hyperbolic")
    centre, reach = grid.points[:-1, -1, 0, :2].mean(axis=0), 10 * np.ptp(section, axis=0).max()
    outer = centre + reach * gallery.circle(90).points[np.r_[0:90, 0], :2]
    trial = tried("O", "parabolic", section, outer=outer)
    assert "the elliptic equations took its place" in trial.text
    assert trial.word == "sound" and trial.heights == 0, trial
