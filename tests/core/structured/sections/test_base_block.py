"""The block behind blunt trailing edges of C-grids: smooth corners, matched heights, joined to the last bit."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery
from meshcore.errors import GenerationFailed, InvalidInput
from meshcore.geometry.curves import polyline
from meshcore.geometry.section import Section
from meshcore.quality import line_angle
from meshcore.structured.sections.base_block import base_points, wake_sides
from tests import naive
from tests.sections import random_sections


def lengths(points):
    return np.linalg.norm(points, axis=-1)


@pytest.mark.parametrize("method", ["transfinite", "elliptic", "hyperbolic", "parabolic"])
def test_no_line_is_skewed_at_a_blunt_corner_and_no_growth_jumps(method):
    blocks, report = mc.c_grid(gallery.airfoil("naca0012"), method=method)
    section, base = blocks.blocks
    wake = report.counts["wake"]
    corners = [wake, section.shape[0] - 1 - wake]
    skew = 90 - line_angle(section)[:, 1:-1]
    for layers, most in ((6, 12), (25, 25)):
        assert all(skew[corner - 3 : corner + 4, :layers].max() < most for corner in corners)
    steps = lengths(np.diff(section.points[wake:-wake, :, 0], axis=1))
    growth = steps[:, 1:] / steps[:, :-1]
    assert np.abs(growth[:, :20] / np.median(growth) - 1).max() < 0.06
    assert (90 - line_angle(base)[1:]).max() < 1
    assert report.converged and not report.warnings


def test_both_blocks_run_downstream_and_up_from_the_base():
    section = gallery.airfoil("naca0012")
    blocks, report = mc.c_grid(section, radius=4)
    around, base = blocks.blocks
    assert base.names == {"imin": "wall", "imax": "outflow"} and blocks.names == ("section", "base")
    assert np.abs(base.points[0, [0, -1], 0] - [[1, -0.00126, 0], [1, 0.00126, 0]]).max() < 1e-9
    assert (naive.cross_areas(base.points[:, :, 0]) > 0).all()
    for cut in blocks.cuts:
        here, there = cut.places(), cut.across(cut.places())
        assert np.array_equal(around.points[tuple(here.T)], base.points[tuple(there.T)])
        # Beyond the cut is what the partner has there: below the upper side, above the lower one.
        x, y, _ = base.points[tuple(cut.across(here - [0, 1, 0]).T)].T
        assert np.abs(y).max() < 0.00126 and np.abs(x - around.points[tuple(here.T)][:, 0]).max() < 1e-3
    sides = mc.with_named_sides(blocks).sets
    assert len(sides["wall"]) == report.counts["around"] + report.counts["across the base"]
    assert len(sides["outflow"]) == 2 * report.counts["layers"] + report.counts["across the base"]


@pytest.mark.parametrize("height", [1e-3, 1e-4, 1e-6])
def test_cells_on_both_sides_of_the_wake_are_of_one_height(height):
    blocks, report = mc.c_grid(gallery.airfoil("naca0012"), first_height=height)
    section, base = (block.points[:, :, 0] for block in blocks.blocks)
    wake = report.counts["wake"]
    outside = lengths(section[: wake + 1, 1] - section[: wake + 1, 0])[::-1]
    inside = lengths(base[:, 1] - base[:, 0])
    assert np.abs(inside / outside - 1).max() < (0.5 if height == 1e-3 else 0.02)
    steps = lengths(np.diff(base, axis=1))
    growth = steps[:, 1:] / steps[:, :-1]
    assert np.maximum(growth, 1 / growth).max() < 1.25


def test_cells_relax_along_the_wake_to_the_height_at_its_end():
    blocks, report = mc.c_grid(gallery.airfoil("naca0012"), first_height=1e-5, wake_height=2e-4, method="elliptic")
    section, base = (block.points[:, :, 0] for block in blocks.blocks)
    wake = report.counts["wake"]
    for side in (section[wake::-1], section[-1 - wake :]):
        height, along = lengths(side[:, 1] - side[:, 0]), lengths(side[:, 0] - side[0, 0])
        assert height == pytest.approx(1e-5 + (2e-4 - 1e-5) * along / along[-1], rel=1e-3)
    assert lengths(base[:, 1] - base[:, 0])[-1] == pytest.approx(2e-4, rel=0.01)


def test_points_of_an_oblique_base_are_on_it():
    loop = Section.of(polyline(gallery.airfoil("naca0012"))[:-1, :2]).loop
    loop = np.vstack([loop[0] - [0.001, 0], loop[1:]])
    section = Section.of(np.vstack([loop, 0.3 * loop[0] + 0.7 * loop[-1]]))
    assert section.edge == "blunt" and section.lower == len(section.loop) - 2
    line = np.column_stack([np.linspace(section.tail[0], 4, 30), np.zeros(30)])
    lower, upper = wake_sides(section, line, np.zeros(30))
    points = base_points(lower, upper, np.full(30, 1e-3), 16)
    from_corner = points[0] - loop[-1]
    along = loop[0] - loop[-1]
    assert np.abs(from_corner[:, 0] * along[1] - from_corner[:, 1] * along[0]).max() < 1e-15
    assert (naive.cross_areas(np.concatenate([points, 0 * points[..., :1]], axis=-1)) > 0).all()


def test_random_blunt_sections_get_blocks_without_folds():
    made = 0
    for kind, loop in random_sections(60, 4):
        try:
            grid, _ = mc.c_grid(loop, method="hyperbolic")
        except GenerationFailed as error:
            raise AssertionError(kind) from error
        if isinstance(grid, mc.MultiBlock):
            made += 1
            assert all((naive.cross_areas(block.points[:, :, 0]) > 0).all() for block in grid.blocks)
    assert made > 5


@pytest.mark.parametrize("keywords", [{"wake_spacing": 50.0}, {"wake_height": 8.0}, {"wake_height": -1.0}])
def test_impossible_wakes_are_named(keywords):
    with pytest.raises(InvalidInput, match=next(iter(keywords))):
        mc.c_grid(gallery.airfoil("naca0012"), **keywords)


@pytest.mark.parametrize("angle", [-20.0, 12.0])
def test_the_wake_goes_where_it_is_asked_to(angle):
    blocks, report = mc.c_grid(gallery.airfoil("naca0012"), wake_angle=angle, wake_spacing=2e-3, method="elliptic")
    section, base = blocks.blocks
    middle = 0.5 * (base.points[:, 0, 0] + base.points[:, -1, 0])
    last = middle[-1] - middle[-2]
    assert np.degrees(np.arctan2(last[1], last[0])) == pytest.approx(angle, abs=0.1)
    assert lengths(middle[1] - middle[0]) == pytest.approx(2e-3, rel=0.01)
    assert report.converged and (90 - line_angle(section)[:, 1:-1]).max() < 45
