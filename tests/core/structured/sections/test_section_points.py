"""Points of sections by laws of spacing, the same in all three grids, and the wake's cells up to the outflow."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import Relative, Spacing, gallery
from meshcore.errors import InvalidInput
from meshcore.geometry.curves import corners, polyline, turning
from meshcore.geometry.section import Section
from meshcore.sizing import cells_for_ends, hyperbolic_tangent
from meshcore.structured.sections.section_points import Points
from tests import naive

LAWS = ("uniform", "geometric", "hyperbolic tangent", "hyperbolic sine", "cosine", "curvature", "poisson", "copied")
MAKERS = {"O": mc.o_grid, "C": mc.c_grid, "H": mc.h_grid}


def on(section, cells=None, law="as given", leading=None, trailing=None, spacings=None):
    """Steps from the trailing edge to the nose on the upper and on the lower side, and the new section."""
    asked = Points(cells, leading, trailing, law, spacings or {}, 1.0)
    new = Section.of(asked.on(section.loop, section.lower if section.edge == "blunt" else None))
    closed = np.vstack([new.loop, new.loop[:1]])
    steps = np.linalg.norm(np.diff(closed, axis=0), axis=1)
    nose = int(np.argmin(np.linalg.norm(new.loop - section.nose, axis=1)))
    return steps[:nose], steps[nose : new.lower][::-1], new


def airfoil(name):
    return Section.of(polyline(gallery.airfoil(name))[:-1, :2])


@pytest.mark.parametrize("name", gallery.airfoils())
@pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)
@pytest.mark.parametrize("law", LAWS)
def test_grids_take_every_law(law, make, name):
    ends = {"trailing_spacing": 0.006} if law not in ("uniform", "cosine", "curvature", "copied") else {}
    grid, report = make(gallery.airfoil(name), law_i=law, around=120, first_height=0.002, **ends)
    for block in grid.blocks if isinstance(grid, mc.MultiBlock) else (grid,):
        assert (naive.cross_areas(block.points[:, :, 0]) > 0).all()
    assert not report.warnings


@pytest.mark.parametrize("name", gallery.airfoils())
def test_points_stand_as_the_law_says_and_corners_are_kept(name):
    section = airfoil(name)
    kept = {tuple(p) for p in section.loop[corners(turning(section.loop))]} | {tuple(section.nose)}
    for side in on(section, 160, "uniform")[:2]:
        assert side == pytest.approx(side.mean(), rel=0.05)  # chords at the nose are shorter than their arcs
    for side in on(section, 160, "geometric", trailing=0.002)[:2]:
        assert side[0] == pytest.approx(0.002, rel=1e-2)
        assert (side[1:] / side[:-1])[:-3] == pytest.approx(side[1] / side[0], rel=0.02)
    upper, lower, new = on(section, 160, "hyperbolic tangent", leading=0.003, trailing=0.002)
    for side in (upper, lower):
        assert (side[0], side[-1]) == (pytest.approx(0.002, rel=1e-2), pytest.approx(0.003, rel=2e-2))
    assert len(new.loop) == 160 and kept <= {tuple(p) for p in new.loop}


def test_one_side_by_a_law_leaves_the_other_as_it_is():
    section = airfoil("rae2822")
    upper, lower, _ = on(section, spacings={"upper": Spacing("cosine")})
    was = np.linalg.norm(np.diff(np.vstack([section.loop, section.loop[:1]]), axis=0), axis=1)
    assert lower == pytest.approx(was[len(upper) :][::-1])
    assert upper[0] < 0.1 * upper.max() > upper[-1]
    upper, lower, _ = on(section, trailing=0.004, spacings={"upper": Spacing("cosine")})
    assert lower[0] == pytest.approx(0.004, rel=1e-2) and upper[0] < 0.003
    upper, lower, _ = on(section, 101, "copied")
    assert np.abs(len(upper) - len(lower)) <= 1
    upper, lower, _ = on(section, 100, "copied")
    assert lower / lower.sum() == pytest.approx(upper / upper.sum(), rel=0.03)


def test_corners_within_a_side_are_kept():
    shape = gallery.l_shape(4).points[:, :2]
    for cells in (12, 41):
        loop = Points(cells, None, None, "uniform").on(shape)
        assert len(loop) == cells
        assert {tuple(p) for p in shape[corners(turning(shape))]} <= {tuple(p) for p in loop}
    with pytest.raises(InvalidInput, match=r"around: 2 cells are too few for a side with . corners"):
        Points(4, None, None, "uniform").on(shape)


def test_relative_lengths_in_spacings_are_relative_to_the_section():
    asked = Points(120, None, None, spacings={"upper": Spacing(first=Relative(0.004))}, diagonal=2.0)
    loop = asked.on(airfoil("rae2822").loop)
    assert np.linalg.norm(loop[1] - loop[0]) == pytest.approx(0.008, rel=1e-2)


@pytest.mark.parametrize(
    ("keywords", "words"),
    [
        ({"law_i": "uniform", "trailing_spacing": 0.01}, "trailing_spacing: is no number of the law 'uniform'"),
        ({"law_i": "copied", "trailing_spacing": 0.01}, "trailing_spacing: is no number of the law 'copied'"),
        ({"law_i": "cosine", "leading_spacing": 0.01}, "leading_spacing: is no number of the law 'cosine'"),
        (
            {"law_i": "geometric", "leading_spacing": 0.01, "trailing_spacing": 0.01},
            "trailing_spacing: and leading_spacing are both",
        ),
        ({"law_i": "uniform", "around": 3}, "around: 3 cells are too few for two sides"),
        ({"law_i": "parabolic"}, "law_i"),
        ({"spacings": {"north": Spacing()}}, 'spacings: needs a Spacing for "upper" or "lower", got Spacing for'),
        ({"spacings": {"upper": 0.1}}, "spacings: needs a Spacing .* got float for 'upper'"),
        ({"spacings": {"upper": Spacing(first=7.0)}}, "spacings: "),
    ],
)
@pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)
def test_laws_that_do_not_fit_are_told_by_the_users_names(make, keywords, words):
    with pytest.raises(InvalidInput, match=words):
        make(gallery.airfoil("rae2822"), **keywords)


def test_a_slit_says_that_it_keeps_its_points():
    slit = np.array([[0, 0], [0.5, 0.02], [1, 0]])
    assert not mc.h_grid(slit).report.warnings
    assert "a slit keeps its own points" in mc.h_grid(slit, law_i="uniform", around=20).report.warnings[0]


def wake_of(grid, report):
    return np.linalg.norm(np.diff(grid.points[: report.counts["wake"] + 1, 0, 0], axis=0), axis=1)[::-1]


@pytest.mark.parametrize("last", [0.02, 0.3, 1.0])
def test_cells_of_the_wake_grow_from_the_section_to_the_outflow(last):
    grid, report = mc.c_grid(gallery.airfoil("rae2822"), around=120, outflow_spacing=last, wake_growth=1.15)
    steps, first = wake_of(grid, report), report.counts["wake"]
    section = np.linalg.norm(np.diff(grid.points[first : first + 2, 0, 0], axis=0))
    assert steps[0] == pytest.approx(section, rel=0.05) and steps[-1] == pytest.approx(last, rel=1e-6)
    ratio = steps[1:] / steps[:-1]
    assert max(ratio.max(), 1 / ratio.min()) < 1.15


def test_the_wake_has_the_number_of_cells_asked_for_with_both_ends():
    grid, report = mc.c_grid(gallery.airfoil("rae2822"), wake_spacing=0.01, outflow_spacing=0.5, wake_cells=50)
    steps = wake_of(grid, report)
    assert len(steps) == 50 and steps[[0, -1]] == pytest.approx([0.01, 0.5], rel=1e-6)
    with pytest.raises(InvalidInput, match="wake_cells: 2 do not fit"):
        mc.c_grid(gallery.airfoil("rae2822"), outflow_spacing=0.5, wake_cells=2)
    with pytest.raises(InvalidInput, match="outflow_spacing: is 9; give less than half of 10"):
        mc.c_grid(gallery.airfoil("rae2822"), outflow_spacing=9.0)


@pytest.mark.parametrize(("first", "last", "ratio"), [(1e-3, 0.1, 1.2), (1e-5, 1e-3, 1.2), (1e-3, 1e-3, 1.1)])
def test_no_fewer_cells_meet_both_ends_within_the_growth(first, last, ratio):
    def worst(cells):
        steps = np.diff(hyperbolic_tangent(cells, first=first, last=last))
        return max((steps[1:] / steps[:-1]).max(), (steps[:-1] / steps[1:]).max())

    cells = cells_for_ends(first, last, ratio)
    assert worst(cells) <= ratio < worst(cells - 1)
