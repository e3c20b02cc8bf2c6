"""Walls of elliptic grids round sections: kinks that lines share, dense points, few points, edges unlike their next."""

from __future__ import annotations

import numpy as np
import pytest

import meshcore as mc
from meshcore.structured.sections.section_result import scaled_jacobians
from meshcore.structured.sections.section_walls import shared_turns, wall_of
from tests.section_families import section_of
from tests.section_trials import tried


def airfoil(n: int) -> np.ndarray:
    """(n + 1, 2) points of NACA 0012 with a sharp edge, dense at both ends."""
    x = 0.5 + 0.5 * np.cos(np.linspace(0, np.pi, n // 2 + 1))
    y = 0.6 * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)
    y[0] = 0.0
    return np.vstack([np.column_stack([x, y]), np.column_stack([x, -y])[-2::-1]])


def loop(n: int) -> np.ndarray:
    """(2, n + 1) points of an ellipse."""
    angle = np.linspace(0, 2 * np.pi, n + 1)
    return np.array([np.cos(angle), 0.4 * np.sin(angle)])


@pytest.mark.parametrize("height", [1e-3, 0.2])
def test_turns_shared_round_a_loop_do_not_hang_on_where_it_begins(height):
    line, k = loop(90), 31
    moved = np.concatenate([line[:, k:-1], line[:, : k + 1]], axis=1)
    lean, other = (shared_turns(points, np.full(91, height), True) for points in (line, moved))
    assert np.allclose(np.roll(lean[:-1], -k), other[:-1], atol=1e-12)
    assert lean[0] == pytest.approx(lean[-1], abs=1e-12)
    assert np.allclose(lean[:-1], lean[-2::-1][np.arange(90) - 1] * -1, atol=1e-12)  # as the ellipse is symmetric
    assert (np.abs(lean).max() > 1e-3) == (height > 0.1)


def test_lines_beside_a_kink_turn_evenly_from_one_edge_to_the_other():
    s = np.linspace(-1, 1, 41)  # edges of 0.05
    line = np.array([s, np.where(s > 0, 0.3 * s, 0.0)])
    length = np.hypot(*np.diff(line, axis=1)).cumsum()
    lean = shared_turns(line, np.full(41, 0.1), False)
    edge = np.where(s > 0, np.arctan(0.3), 0.0)
    edge[20] = 0.5 * np.arctan(0.3)
    heading, at = lean + edge, np.concatenate([[0.0], length]) - length[19]
    assert np.allclose(heading, np.arctan(0.3) * np.clip(0.5 + at / 0.4, 0, 1), atol=1e-12)


def test_a_sharp_corner_is_not_shared():
    line = np.array([[0.0, 1, 1.05, 1.1, 1.1, 1.1, 1.1], [0.0, 0, 0, 0, 0.05, 0.1, 1]])
    assert not shared_turns(line, np.full(7, 0.1), False).any()


@pytest.mark.parametrize("make", [mc.o_grid, mc.c_grid])
def test_the_wall_of_a_grid_has_the_same_angle_at_both_ends_of_a_cut(make):
    square = np.array([[1.0, 1], [-1, 1], [-1, -1], [1, -1], [1, 1]])
    if make is mc.c_grid:
        square = square @ np.array([[np.cos(0.3), np.sin(0.3)], [-np.sin(0.3), np.cos(0.3)]])
    grid, _ = make(square, method="transfinite", first_height=0.05)
    block = grid.blocks[0] if isinstance(grid, mc.MultiBlock) else grid
    wall = wall_of(block, np.ones(len(block.points)))
    if block.periodic[0]:
        assert wall.angle[0] == pytest.approx(wall.angle[-1], abs=1e-9) == pytest.approx(90, abs=1e-6)
    assert ((wall.angle >= 10) & (wall.angle <= 170)).all()


@pytest.mark.parametrize("topology", ["O", "C"])
@pytest.mark.parametrize("n", [1000, 2000])
def test_many_points_whose_lines_are_higher_than_they_are_apart_are_held(topology, n):
    trial = tried(topology, "elliptic", airfoil(n))
    assert trial.word == "sound" and trial.converged and trial.heights == 0, trial
    assert not trial.text, trial  # no layers stay


@pytest.mark.parametrize(
    ("family", "seed", "k"),
    [("regular", 4242, 20), ("diamond", 4242, 17), ("few points", 4242, 92), ("deck", 4242, 25), ("plate", 4242, 18)],
)
def test_sections_of_few_points_and_of_edges_unlike_their_next_converge(family, seed, k):
    trial = tried("O", "elliptic", section_of(family, seed, k))
    assert trial.word == "sound" and trial.converged and trial.heights == 0, trial


def test_lines_of_a_c_grid_of_dense_points_keep_their_angles_away_from_the_edge():
    grid, report = mc.c_grid(airfoil(1000), method="elliptic")
    lines = grid.points[:, :2, 0, :2]
    wake = report.counts["wake"]
    edge, wall = lines[:, 1] - lines[:, 0], np.gradient(lines[:, 0], axis=0)
    cosine = (edge * wall).sum(axis=1) / np.hypot(*edge.T) / np.hypot(*wall.T)
    away = slice(wake + 100, len(lines) - wake - 100)
    assert np.degrees(np.abs(np.arcsin(cosine[away]))).max() < 1.0
    assert scaled_jacobians(grid.points[:, :, 0, :2]).min() > 0.7


@pytest.mark.parametrize("make", [mc.o_grid, mc.c_grid])
def test_no_cycle_is_spent_on_heights_that_points_moving_along_lines_reach(make):
    _, report = make(airfoil(200), method="elliptic")
    assert report.converged and report.iterations <= 40
    assert abs(report.quality["largest first height / asked"] - 1) < 1e-3
