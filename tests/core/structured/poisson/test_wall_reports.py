"""What reports say of walls is so: nothing is called as asked that nobody looked at."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery
from meshcore.errors import InvalidInput
from meshcore.structured.poisson.wall_control import Wall, measured
from meshcore.structured.poisson.wall_outcome import Controlled


def channel(ni, nj, height):
    """A flat channel with a bump on its south side."""
    x, y = np.linspace(0, 1, ni), np.linspace(0, height, nj)
    ends = np.column_stack([0 * y, y])
    south = np.column_stack([x, 0.2 * height * np.sin(np.pi * x) ** 2])
    return south, ends + [1, 0], np.column_stack([x, 0 * x + height]), ends


def test_a_wall_that_is_short_beside_its_first_heights_is_judged_all_the_same():
    """All nodes stand within two first heights of the ends; the height may be missed, but not in silence."""
    grid, report = mc.elliptic(*channel(65, 17, 1e-3), walls="west", first_height=0.002)
    heights = np.linalg.norm(grid.points[1, 1:-1, 0] - grid.points[0, 1:-1, 0], axis=-1)
    worst = 100 * np.abs(heights / 0.002 - 1).max()
    assert report.quality["error of first heights (%)"] == pytest.approx(worst)
    assert report.converged == (worst < 5) and bool(report.warnings) == (worst >= 5)
    assert report.quality["points at walls that are judged (%)"] == pytest.approx(100 * 15 / 17)


def test_how_many_points_are_judged_is_told():
    _, report = mc.elliptic(*channel(65, 33, 1.0), walls="south", first_height=0.01)
    _, few = mc.elliptic(*channel(9, 9, 1.0), walls="south", first_height=0.1)
    assert report.quality["points at walls that are judged (%)"] == pytest.approx(100 * 59 / 65)
    assert few.quality["points at walls that are judged (%)"] < 60


def test_what_nobody_asked_for_is_not_reported():
    """Angles alone say nothing of heights, in a plane, on a surface, or in space."""
    box = np.stack(np.meshgrid(*[np.linspace(0, 1, 9)] * 3, indexing="ij"), axis=-1)
    curved = mc.transfinite(*gallery.sides_on_torus(12, 8)).mesh
    for report in (
        mc.elliptic(*channel(33, 17, 1.0), walls="south").report,
        mc.elliptically_smoothed(curved, walls="south").report,
        mc.elliptic_volume(mc.StructuredGrid(box), walls="kmin").report,
    ):
        names = {name for name in report.quality if name.startswith("error of")}
        assert names == {"error of wall angles (degree)"}
    went = Controlled((1.0,), 3.0, 0.5, False, asked=(True, False))
    assert "heights" not in went.warnings[0] and "3 degrees" in went.warnings[0]
    assert "heights are off by up to 50.0%" in Controlled((1.0,), 3.0, 0.5, False, asked=(False, True)).warnings[0]


def test_walls_with_few_nodes_are_judged_between_their_ends():
    x = np.stack(np.meshgrid([0.0, 1, 2, 3], [0.0, 1, 2], indexing="ij"))
    assert measured(x, "south", 1.0, False).counts.tolist() == [False, True, True, False]
    turned = x.copy()
    turned[1, 1:3] += [[2.0], [-2.0]]  # both inner nodes are sharp corners
    assert measured(turned, "south", 1.0, False).counts.any()


@pytest.mark.parametrize("equation", ["Poisson", "biharmonic"])
def test_heights_as_long_as_lines_are_refused_in_a_plane(equation):
    with pytest.raises(InvalidInput, match=r"first_height: is 2 at south, where a whole line is .* long"):
        mc.elliptic(*channel(9, 9, 1.0), walls="south", first_height=2.0, equation=equation)


def test_heights_as_long_as_lines_and_those_of_other_points_are_refused_on_surfaces():
    sides = gallery.sides_on_torus(12, 8)
    with pytest.raises(InvalidInput, match="first_height: is 100 at south"):
        mc.elliptic(*sides, walls="south", first_height=100.0)
    grid, _ = mc.transfinite(*sides)
    with pytest.raises(InvalidInput, match=r"south has 13 points, but its first height has shape \(5,\)"):
        mc.elliptically_smoothed(grid, each_wall=[Wall("south", np.full(5, 0.01))])


@pytest.mark.parametrize("lift", [0.0, 0.3])
def test_grids_without_points_inside_do_not_claim_walls(lift):
    x = np.linspace(0, 1, 9)
    points = np.zeros((9, 2, 1, 3))
    points[..., 0], points[:, 1, 0, 1] = x[:, None, None], 1 + 0.5 * x
    points[:, 1, 0, 2] = lift * np.sin(3 * x)
    grid = mc.StructuredGrid(points)
    _, report = mc.elliptically_smoothed(grid, walls="south", first_height=0.1)
    assert not report.converged and "no points inside" in report.warnings[0]
    _, report = mc.elliptically_smoothed(grid)
    assert report.converged and not report.warnings


def test_blocks_without_points_inside_do_not_claim_walls():
    box = np.stack(np.meshgrid([0.0, 1, 2], [0.0, 1, 2], [0.0, 1], indexing="ij"), axis=-1)
    _, report = mc.elliptic_volume(mc.StructuredGrid(box), walls="kmin", first_height=0.1)
    assert not report.converged and "no points inside" in report.warnings[-1]


def test_the_biharmonic_equation_tells_what_walls_became():
    _, report = mc.elliptic(*channel(33, 17, 1.0), equation="biharmonic", walls="south", first_height=0.03)
    assert report.converged and report.quality["error of first heights (%)"] < 1e-6
    grid, report = mc.elliptic(
        *channel(33, 17, 1.0), equation="biharmonic", walls="west and east", first_height=0.03, wall_angle=40.0
    )
    have = measured(np.moveaxis(grid.points[:, :, 0, :2], -1, 0), "west", 1.0, False)
    assert report.quality["error of wall angles (degree)"] >= np.abs(have.angle - 40)[have.counts].max() - 1e-9
