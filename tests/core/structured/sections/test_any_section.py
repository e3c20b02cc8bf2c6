"""Grids round sections as users bring them: first heights of marches, blunt and cusped edges, what is told."""

from __future__ import annotations

import re

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery
from meshcore.quality import line_angle
from meshcore.structured.marching import hyperbolic_march, parabolic_march
from meshcore.structured.sections.section_result import scaled_jacobians
from tests.bodies import BODIES, random_bodies
from tests.section_families import FAMILIES, section_of
from tests.section_trials import METHODS, tried
from tests.sections import random_sections


def first_heights(grid, report) -> np.ndarray:
    """Of what was asked for, at the wall."""
    wake = report.counts.get("wake", 0)
    lines = grid.points[wake : len(grid.points) - wake, :2, 0]
    return np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1) / report.quality["first height"]


@pytest.mark.parametrize("method", ["hyperbolic", "parabolic"])
@pytest.mark.parametrize("name", ["naca0012", "rae2822", "s1223"])
def test_marches_on_coarse_points_have_the_first_heights_asked_for(name, method):
    heights = first_heights(*mc.o_grid(gallery.airfoil(name), method=method))
    assert heights.min() > 0.97 and heights.max() < 1.03


@pytest.mark.parametrize("method", ["elliptic", "hyperbolic", "parabolic"])
def test_grids_round_blunt_edges_of_c_grids_keep_the_layers_that_round_its_corners(method):
    section = gallery.airfoil("naca0012")  # whose base is thinner than the first height
    grid, report = mc.c_grid(section, method=method, base="wrapped")
    assert all("beyond the" in text for text in report.warnings)
    assert scaled_jacobians(grid.points[:, :, 0, :2]).min() > 0.05
    assert first_heights(grid, report).min() > 0.97
    flat, _ = mc.c_grid(section, method="transfinite", base="wrapped")
    assert np.array_equal(flat.points[:, 1], grid.points[:, 1])
    assert np.abs(flat.points - grid.points).max() > 0.1


def test_where_walls_of_a_cusp_cannot_be_held_they_are_left_and_that_is_told():
    _, cusped = list(random_sections(7, 1))[-1]
    grid, report = mc.o_grid(cusped, method="elliptic")
    assert scaled_jacobians(grid.points[:, :, 0, :2]).min() > 0
    assert "could not be held" in report.warnings[0]


@pytest.mark.parametrize("method", ["transfinite", "elliptic", "hyperbolic", "parabolic"])
@pytest.mark.parametrize("make", [mc.o_grid, mc.c_grid])
def test_random_bodies_get_sound_grids(make, method):
    for _, body in random_bodies(len(BODIES), 5):
        grid, _ = make(body, method=method, first_height=0.005)
        for block in grid.blocks if isinstance(grid, mc.MultiBlock) else (grid,):
            assert scaled_jacobians(block.points[:, :, 0, :2]).min() > 0


@pytest.mark.parametrize("corners", [[[0, 0], [1, 0], [0.3, 0.8], [0, 0]], [[0, 0], [1, 0], [0, 0.4], [0, 0]]])
@pytest.mark.parametrize("around", [None, 12, 60])
def test_c_grids_of_triangles_open_behind_the_nose_even_if_the_chord_runs_along_a_side(corners, around):
    grid, report = mc.c_grid(np.array(corners, float), around=around)
    assert not report.warnings
    assert scaled_jacobians(grid.points[:, :, 0, :2]).min() > 0


@pytest.mark.parametrize("kind", ["ellipse", "star", "L-shape"])
def test_h_grids_march_where_straight_lines_cross_and_tell_on_which_side(kind):
    marched = 0
    for number in range(3):
        loop = BODIES[kind](np.random.default_rng(number))
        blocks, report = mc.h_grid(np.vstack([loop, loop[:1]]))
        for block in blocks.blocks:
            assert scaled_jacobians(block.points[:, :, 0, :2]).min() > 0
        marched += sum("the section: lines crossed" in text for text in report.warnings)
    assert marched


def test_reports_tell_heights_reached_skew_and_wall_units():
    grid, report = mc.c_grid(gallery.airfoil("rae2822"), y_plus=1.0, method="hyperbolic", around=120)
    heights = first_heights(grid, report)
    assert report.quality["least first height / asked"] == pytest.approx(heights.min())
    assert report.quality["largest first height / asked"] == pytest.approx(heights.max())
    assert report.quality["y+"] == 1.0
    angle = line_angle(grid)[:, 1:-1]
    assert report.quality["worst skew of lines (degree)"] == pytest.approx(90 - angle.min())


@pytest.mark.parametrize(("make", "blocks"), [(mc.o_grid, 1), (mc.c_grid, 1), (mc.h_grid, 2)])
def test_reports_tell_what_a_march_did_so_that_no_cell_folds(make, blocks, monkeypatch):
    marched = hyperbolic_march.marched
    monkeypatch.setattr(hyperbolic_march, "marched", lambda *a, **k: marched(*a, **k)._replace(split=3, raised=1.5))
    _, report = make(gallery.airfoil("rae2822"), method="hyperbolic")
    assert report.counts["layers in smaller steps"] == 3 * blocks
    assert sum("smoothed 1.5 times as much as asked" in text for text in report.warnings) == blocks


def test_the_wake_of_a_circle_goes_along_x():
    for turn in (0.0, 0.7):
        angle = np.linspace(0, 2 * np.pi, 41) + turn
        grid, _ = mc.c_grid(np.column_stack([np.cos(angle), np.sin(angle)]))
        assert grid.points[0, 0, 0, 0] > 10 and abs(grid.points[0, 0, 0, 1]) < 2


@pytest.mark.parametrize("method", ["elliptic", "hyperbolic"])
def test_layers_round_blunt_edges_are_kept_only_if_they_are_sound(method):
    # A turbine blade on few points, whose straight lines cross beside what is taken for its trailing edge.
    loop = BODIES["turbine"](np.random.default_rng([11, 3]))
    loop = np.vstack([loop, loop[:1]])
    grid, _ = mc.c_grid(loop, y_plus=1.0, reynolds=1.64e5, around=60, method=method, base="wrapped")
    assert scaled_jacobians(grid.points[:, :, 0, :2]).min() > 0


@pytest.mark.parametrize("layers", [2, 3])
@pytest.mark.parametrize("method", ["elliptic", "hyperbolic", "parabolic"])
def test_few_layers_round_a_blunt_edge(method, layers):
    keywords = {"layers": layers, "radius": 2, "first_height": 0.3, "method": method}
    grid, _ = mc.c_grid(gallery.airfoil("naca0012"), base="wrapped", **keywords)
    assert grid.cell_shape[1] == layers
    blocks, _ = mc.c_grid(gallery.airfoil("naca0012"), **keywords)
    assert blocks.blocks[0].cell_shape[1] == layers


@pytest.mark.parametrize("family", [name for name in FAMILIES if name != "many points"])  # seconds
def test_sections_of_every_family_get_sound_o_grids(family):
    section = section_of(family, 8, 0)
    for method in METHODS:
        trial = tried("O", method, section)
        assert trial.word == "sound", trial
        assert method == "elliptic" or trial.heights <= 0.1, trial  # what is missed is beside concave corners


@pytest.mark.parametrize(
    ("family", "seed", "k"),
    [
        ("noisy", 500, 40),
        ("plate", 500, 49),
        ("L, T", 500, 54),
        ("ellipse", 300, 50),
        ("sail", 100, 28),
        ("pocket", 100, 58),
    ],
)
def test_c_grids_open_round_a_point_inside_thin_noses(family, seed, k):
    for method in METHODS:
        trial = tried("C", method, section_of(family, seed, k))
        assert trial.word == "sound" and trial.heights < 0.05, trial


@pytest.mark.parametrize("method", ["transfinite", "elliptic", "parabolic"])
def test_where_no_march_reaches_the_far_field_a_hyperbolic_one_makes_its_own_and_that_is_told(method):
    angle = np.linspace(0.4, 2 * np.pi - 0.4, 40)
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    section = np.vstack([ring, 0.9 * ring[::-1], ring[:1]])
    grid, report = mc.o_grid(section, method=method, first_height=0.005)
    assert scaled_jacobians(grid.points[:, :, 0, :2]).min() > 0
    assert any("the far field is where that arrives" in text for text in report.warnings)
    circle = 8 * gallery.circle(40).points[np.r_[0:40, 0]]  # on which lines have to end
    with pytest.raises(mc.GenerationFailed, match="cells are folded"):
        mc.o_grid(section, circle, method=method, first_height=0.005)


@pytest.mark.parametrize("make", [mc.o_grid, mc.c_grid, mc.h_grid])
def test_where_a_march_stopped_is_told_in_the_user_s_own_coordinates(make, monkeypatch):
    march = parabolic_march.marched

    def stopping(front, *args, **options):
        half = len(front) // 2
        stop = hyperbolic_march.Stop(half, 3, front[half], 0.0, "cells fold")
        return march(front, *args, **options)._replace(stop=stop)

    monkeypatch.setattr(parabolic_march, "marched", stopping)
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    turn[:, 2] *= np.linalg.det(turn)
    flat = gallery.airfoil("naca0012")
    section = flat.with_points(flat.points @ turn.T + [5, 6, 7])
    _, report = make(section, method="parabolic", first_height=0.01)
    told = [re.search(r"stopped at layer \d+ near \(([^)]*)\)", text) for text in report.warnings]
    places = [[float(x) for x in found[1].split(",")] for found in told if found]
    assert places
    for place in places:
        assert np.linalg.norm(section.points - place, axis=1).min() < 0.04  # layers round an H-grid's edge are kept


def test_lines_that_end_out_of_order_are_put_in_order_before_a_march_onto_the_far_field():
    # A gear on some hundred points, whose straight lines cross up to the far field.
    for k in (22, 53):
        trial = tried("O", "parabolic", section_of("gear", 600, k))
        assert trial.word == "sound", trial
