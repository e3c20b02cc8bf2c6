"""Overspill is found, and cured when asked: by other parameters of the sides, by lines of constraint, or not at all."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery
from meshcore.errors import GenerationFailed
from meshcore.geometry.curves import arc_length
from meshcore.structured.algebraic.interior_lines import nearest
from meshcore.structured.algebraic.overspill import matching
from tests import naive

LOOP = gallery.l_shape(10)
SIX_SIDED = (0, 20, 30, 60)
"""Corners of the L without its re-entrant one: that stands in the middle of the north side."""
RE_ENTRANT = (0, 20, 40, 60)
"""A corner of 270 degrees, which no quadrilateral has."""


def failure(*sides, **keywords):
    with pytest.raises(GenerationFailed) as caught:
        mc.transfinite(*sides, **keywords)
    return caught.value


def area(points):
    return 0.5 * (naive.cross_areas(points)[..., [0, 2]]).sum()


@pytest.mark.parametrize("blending", ["arc length", "linear", "cubic"])
def test_an_l_shape_is_cured(blending):
    with pytest.raises(GenerationFailed):
        mc.transfinite(LOOP, corners=SIX_SIDED, blending=blending)
    grid, report = mc.transfinite(LOOP, corners=SIX_SIDED, blending=blending, cure="automatic")
    points = grid.points[:, :, 0]
    assert (naive.cross_areas(points) > 0).all()
    assert area(points) == pytest.approx(3, rel=0.01)  # sides may cut a corner of the outline by less than a cell
    assert report.warnings and all(text.startswith("overspill: ") for text in report.warnings)
    outline = LOOP.points[np.append(np.arange(LOOP.n_points), 0)]
    for side in (points[0], points[-1], points[:, 0], points[:, -1]):
        assert max(nearest(point, outline)[1] for point in side) < 1e-12


def test_lines_of_constraint_alone_keep_the_sides_to_the_bit():
    failed = failure(LOOP, corners=SIX_SIDED).partial
    grid, report = mc.transfinite(LOOP, corners=SIX_SIDED, cure="lines")
    for face in (np.s_[0], np.s_[-1], np.s_[:, 0], np.s_[:, -1]):
        assert (grid.points[face] == failed.points[face]).all()
    assert (naive.cross_areas(grid.points[:, :, 0]) > 0).all()
    assert area(grid.points[:, :, 0]) == pytest.approx(3, rel=1e-12)
    assert report.warnings == ["overspill: 1 line of constraint inside the patch"]


def test_ill_spaced_sides_are_cured_by_moving_their_points():
    """Lines between two half circles, aslant by up to 69 degrees, cross the inner one; 60 are the limit."""
    s = np.linspace(0, 1, 41)
    inner, outer = (
        radius * np.column_stack([np.cos(a), np.sin(a)]) for radius, a in ((1, np.pi * s), (2, np.pi * s**3))
    )
    sides = inner, [inner[-1], outer[-1]], outer, [inner[0], outer[0]]
    assert len(failure(*sides, cells_j=10).cells) > 10
    grid, report = mc.transfinite(*sides, cells_j=10, cure="sides")
    assert (naive.cross_areas(grid.points[:, :, 0]) > 0).all()
    assert len(report.warnings) == 2 and "moved along them" in report.warnings[1]


@pytest.mark.parametrize("height", [1.0, 1.5, 2.5])
@pytest.mark.parametrize("foot", [0.7, 0.8, 0.9])
def test_a_step_in_a_channel_is_cured_whatever_its_height_and_steepness(height, foot):
    floor = np.column_stack([np.linspace(0, 2, 31), np.zeros(31)])
    roof = np.array([[0, height], [0.7, height], [foot, 0.6], [2, 0.6]])
    sides = floor, [[2, 0], [2, 0.6]], roof, [[0, 0], [0, height]]
    assert failure(*sides, cells_i=30, cells_j=12).cells
    grid, report = mc.transfinite(*sides, cells_i=30, cells_j=12, cure="automatic")
    assert (naive.cross_areas(grid.points[:, :, 0]) > 0).all()
    assert report.warnings[0] == "overspill: points of south and north were moved along them"


@pytest.mark.parametrize("cure", ["sides", "lines", "automatic"])
def test_what_cannot_be_cured_is_refused_with_its_place(cure):
    worst = failure(LOOP, corners=RE_ENTRANT)
    left = failure(LOOP, corners=RE_ENTRANT, cure=cure)
    assert "did not suffice" in str(left) and "the first at i = " in str(left)
    assert 0 < len(left.cells) < len(worst.cells)  # better at least
    bad = (naive.cross_areas(left.partial.points[:, :, 0]) <= 0).any(axis=-1)
    assert set(left.cells) == set(np.flatnonzero(bad.ravel(order="F")))


@pytest.mark.parametrize("cure", ["none", "sides", "lines", "smoothing", "automatic"])
def test_a_sound_grid_is_left_alone(cure):
    sides = gallery.wavy_sides(12, 7)
    sides = [np.round(side, 9) for side in sides]
    grid, report = mc.transfinite(*sides, cure=cure)
    assert (grid.points == mc.transfinite(*sides).mesh.points).all() and not report.warnings


@pytest.mark.parametrize("turn", [np.eye(3), np.array([[2, -1, 2], [2, 2, -1], [-1, 2, 2]]) / 3.0])
def test_smoothing_keeps_the_sides_to_the_bit(turn):
    s = np.linspace(0, 1, 31)
    crowded = s**3
    floor = np.column_stack([s, 0.9 * np.sin(np.pi * s) ** 8, 0 * s]) @ turn.T
    roof = np.column_stack([crowded, 1 + 0.3 * np.sin(np.pi * crowded), 0 * s]) @ turn.T
    sides = floor, np.array([floor[-1], roof[-1]]), roof, np.array([floor[0], roof[0]])
    folded = failure(*sides, cells_j=20)
    grid, report = mc.transfinite(*sides, cells_j=20, cure="smoothing")
    assert report.warnings == ["overspill: the grid was smoothed by the Laplace equations"]
    assert (grid.points[:, [0, -1]] == folded.partial.points[:, [0, -1]]).all()
    assert (grid.points[[0, -1]] == folded.partial.points[[0, -1]]).all()


def test_matching_is_even_for_parallel_lines_and_turns_with_the_curves():
    x = np.linspace(0, 1, 40)
    line = np.column_stack([x, 0 * x, 0 * x])
    up = np.array([0.0, 0, 1])
    assert np.abs(matching(line, line + [0, 1, 0], up)).max() == 0
    step = np.array([[0, 2.0, 0], [1, 2, 0], [1, 1, 0], [2, 1, 0]])
    shift = matching(2 * line, step, up)
    middle = np.linspace(0, 1, len(shift))
    assert (np.diff(middle + shift) >= -1e-12).all() and (np.diff(middle - shift) >= -1e-12).all()
    # Points of the riser, whose fractions are between 1/3 and 2/3, are matched with x < 1: they face that way.
    riser = np.interp([0.4, 0.6], middle - shift, middle + shift)
    assert (riser < 0.5).all()
    mirrored = matching(step, 2 * line, -up)
    assert np.abs(mirrored + shift).max() < 0.02


def test_reversed_sides_are_turned_and_told():
    south, east, north, west = (np.round(side, 9) for side in gallery.wavy_sides(12, 7))
    plain, quiet = mc.transfinite(south, east, north, west)
    grid, report = mc.transfinite(south, east[::-1], north[::-1], west)
    assert (grid.points == plain.points).all() and not quiet.warnings
    assert report.warnings == [f"{name} ran the other way and was reversed" for name in ("east", "north")]
    assert arc_length(grid.points[:, -1, 0])[-1] == arc_length(north)[-1]


@pytest.mark.parametrize(("make", "height"), [(mc.transfinite, 0.0), (mc.elliptic, 0.0), (mc.elliptic, 0.3)])
def test_a_corner_of_270_degrees_is_named(make, height):
    """Of an L whose inner corner is taken as a corner of the block; flat and curved."""
    t, half = np.linspace(0, 1, 9)[:, None], np.linspace(0, 1, 5)[:, None]

    def line(a, b, at=t):
        return np.array(a, float) + at * (np.array(b, float) - a)

    south, west = line((1, 1), (2, 1)), line((1, 1), (1, 0))
    east = np.concatenate([line((2, 1), (2, 2), half)[:-1], line((2, 2), (0, 2), half)])
    north = np.concatenate([line((1, 0), (0, 0), half)[:-1], line((0, 0), (0, 2), half)])
    south, east, north, west = (
        np.column_stack([side, height * side[:, 0] ** 2]) for side in (south, east, north, west)
    )
    for sides, names in (
        ((south, east, north, west), "south and west"),
        ((west[::-1], south, east[::-1], north[::-1]), "south and east"),
        ((north[::-1], west[::-1], south[::-1], east[::-1]), "north and east"),
        ((east, north, west, south), "north and west"),
    ):
        with pytest.raises(GenerationFailed, match="angle of 270 degrees inside the grid") as error:
            make(*sides)
        assert f"at the corner of {names}, (1, 1," in str(error.value), names
        assert "blocks have to be split there" in str(error.value)
