"""The elliptic operation: planar patches and grids of any attitude, control, walls, honesty."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import Attractor, Wall, gallery
from meshcore.errors import Cancelled, GenerationFailed, InvalidInput
from meshcore.structured.poisson.barrier import weak_cells
from meshcore.structured.poisson.winslow import winslow
from tests import naive
from tests.core.structured.poisson.test_winslow import annulus, distance, star, wavy

WAVY = tuple(np.round(side, 9) for side in gallery.wavy_sides(24, 14))
TURN = np.array([[2, -1, 2], [2, 2, -1], [-1, 2, 2]]) / 3.0


def planar(grid):
    return grid.points[:, :, 0, :2]


def grid_of(points, **more):
    return mc.StructuredGrid(points, **more)


@pytest.mark.parametrize("control", ["none", "boundary spacing"])
def test_sides_are_kept_to_the_bit_and_cells_are_convex(control):
    grid, report = mc.elliptic(*WAVY, control=control)
    south, east, north, west = WAVY
    assert (grid.points[:, 0, 0] == south).all() and (grid.points[:, -1, 0] == north).all()
    assert (grid.points[0, :, 0] == west).all() and (grid.points[-1, :, 0] == east).all()
    assert report.converged and not report.warnings
    assert not weak_cells(planar(grid), 1.0).any()
    assert grid.names == {"jmin": "south", "imax": "east", "jmax": "north", "imin": "west"}


def test_laplace_grid_is_the_twins():
    grid, report = mc.elliptic(*gallery.wavy_sides(9, 7), control="none", residual=1e-12)
    start, _ = mc.transfinite(*gallery.wavy_sides(9, 7))
    assert distance(planar(grid), naive.winslow(planar(start))) < 1e-10
    assert report.residual <= 1e-12 and report.history[0] == 1 and len(report.history) == report.iterations + 2


def test_any_attitude_gives_the_same_grid():
    flat, _ = mc.elliptic(*WAVY, residual=1e-11)
    turned, _ = mc.elliptic(*(side @ TURN.T + [1, 2, 3] for side in WAVY), residual=1e-11)
    assert np.abs(turned.points - (flat.points @ TURN.T + [1, 2, 3])).max() < 1e-9
    assert (turned.points[:, 0, 0] == WAVY[0] @ TURN.T + [1, 2, 3]).all()


def test_a_closed_loop_is_cut_at_its_corners():
    grid, _ = mc.elliptic(gallery.square(12))
    x, y = np.meshgrid(np.linspace(0, 1, 13), np.linspace(0, 1, 13), indexing="ij")
    found, exact = (np.unique(p.reshape(-1, 2).round(9), axis=0) for p in (planar(grid), np.stack([x, y], axis=-1)))
    assert np.array_equal(found, exact)


def test_where_transfinite_interpolation_spills_over_it_does_not():
    n = 12
    corners = (0, 2 * n, 3 * n, 6 * n)
    with pytest.raises(GenerationFailed):
        mc.transfinite(gallery.l_shape(n), corners=corners)
    grid, report = mc.elliptic(gallery.l_shape(n), corners=corners, control="none")
    assert not weak_cells(planar(grid), 1.0).any() and report.converged
    a, b = planar(grid)[1:, 1:] - planar(grid)[:-1, :-1], planar(grid)[:-1, 1:] - planar(grid)[1:, :-1]
    assert abs(0.5 * (a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]).sum() - 3) < 1e-12


def test_random_stars_give_convex_cells_or_an_error_that_shows_where():
    rng = np.random.default_rng(5)
    sound = 0
    for _ in range(60):
        start = grid_of(star(rng, 20))
        try:
            grid, _ = mc.elliptically_smoothed(start)
        except GenerationFailed as failure:
            # No grid is convex at a corner where the boundary turns by 180 degrees or more; all others are.
            assert set(failure.cells) <= {0, 19, 380, 399}
            at = np.unravel_index(failure.cells, (20, 20), order="F")
            assert weak_cells(planar(failure.partial), 1.0, 1e-12)[at].all()
            continue
        sound += 1
        assert not weak_cells(planar(grid), 1.0, 1e-12).any()
    assert sound > 10


def test_walls_are_reached_from_the_sides():
    sides = gallery.wavy_sides(40, 40)
    grid, report = mc.elliptic(*sides, walls="south and north", first_height=0.005, control="none")
    assert report.converged and report.quality["error of wall angles (degree)"] < 1
    for wall, first in ((0, 1), (-1, -2)):
        edge = planar(grid)[:, first] - planar(grid)[:, wall]
        along = planar(grid)[2:, wall] - planar(grid)[:-2, wall]
        size = np.linalg.norm(edge, axis=1)
        assert np.abs(size / 0.005 - 1)[4:-4].max() < 0.06
        sine = np.abs((edge[1:-1] * along).sum(axis=1)) / size[1:-1] / np.linalg.norm(along, axis=1)
        assert np.degrees(np.arcsin(sine))[3:-3].max() < 1.5


def test_walls_keep_their_names_in_a_patch_that_is_turned():
    sides = [side * [-1, 1, 1] for side in gallery.wavy_sides(32, 32)]
    straight, _ = mc.elliptic(*gallery.wavy_sides(32, 32), walls="east", first_height=0.01, wall_angle=80)
    turned, _ = mc.elliptic(*sides, walls="east", first_height=0.01, wall_angle=80)
    assert turned.names["imin"] == "east"
    assert np.abs(turned.points[::-1] * [-1, 1, 1] - straight.points).max() < 1e-6


def test_sides_that_were_turned_are_told():
    south, east, north, west = WAVY
    grid, report = mc.elliptic(south, east, north[::-1], west)
    assert report.warnings == ["north ran the other way and was reversed"]
    assert np.abs(grid.points - mc.elliptic(*WAVY).mesh.points).max() < 1e-12


def test_an_o_grid_is_smoothed_with_its_cut_free():
    rough, _ = mc.o_grid(
        gallery.airfoil("s1223", cells=96), radius=5, layers=40, first_height=2e-3, method="transfinite"
    )
    grid, report = mc.elliptically_smoothed(rough, each_wall=[Wall("south", first_height=2e-3)])
    assert report.converged and grid.periodic == rough.periodic and grid.names == rough.names
    assert (grid.points[:, 0] == rough.points[:, 0]).all() and (grid.points[:, -1] == rough.points[:, -1]).all()
    assert (grid.points[0] == grid.points[-1]).all()
    assert np.abs(grid.points[0, 1:-1] - rough.points[0, 1:-1]).max() > 1e-4


def test_periodic_along_j_is_periodic_along_i_transposed():
    points = annulus(20, 12) + np.array([0.3, 0]) * np.linspace(1, 0, 13)[:, None]
    walls = {"along_i": [Wall("south", 0.1)], "along_j": [Wall("west", 0.1, 90.0)]}
    one, _ = mc.elliptically_smoothed(
        grid_of(points, periodic=(True, False, False)), each_wall=walls["along_i"], attractors=[Attractor(j=6)]
    )
    other, _ = mc.elliptically_smoothed(
        grid_of(np.ascontiguousarray(points.swapaxes(0, 1)[:, ::-1]), periodic=(False, True, False)),
        each_wall=walls["along_j"],
        attractors=[Attractor(i=6)],
    )
    assert np.abs(one.points.swapaxes(0, 1)[:, ::-1] - other.points).max() < 1e-6


def test_users_functions_follow_a_transposed_grid():
    points = annulus(16, 10)
    p, q = (lambda i, j: 0.1 * np.sin(np.pi * i / 8), np.linspace(-0.2, 0.1, 11) + np.zeros((17, 11)))
    one, _ = mc.elliptically_smoothed(
        grid_of(points, periodic=(True, False, False)), control_functions=(p, q), residual=1e-11
    )
    other, _ = mc.elliptically_smoothed(
        grid_of(np.ascontiguousarray(points.swapaxes(0, 1)[:, ::-1]), periodic=(False, True, False)),
        control_functions=(q.T[:, ::-1], lambda i, j: -p(16 - j, i)),
        residual=1e-11,
    )
    assert np.abs(one.points.swapaxes(0, 1)[:, ::-1] - other.points).max() < 1e-9


def test_users_functions_and_attractors_reach_the_solver():
    start = grid_of(wavy(24, 20, 0.05))
    p = np.full((24, 20), 0.1)
    grid, _ = mc.elliptically_smoothed(start, control_functions=(p, lambda i, j: -0.1 + 0 * i), residual=1e-11)
    growth = np.empty((2, 24, 20))
    growth[0], growth[1] = -2 * np.arctanh(0.05), 2 * np.arctanh(0.05)
    assert distance(planar(grid), winslow(wavy(24, 20, 0.05), growth=growth, tolerance=1e-11).points) < 1e-8
    near, _ = mc.elliptically_smoothed(start, attractors=[Attractor(j=10, strength=0.2)])
    plain, _ = mc.elliptically_smoothed(start)
    assert np.linalg.norm(near.points[12, 11] - near.points[12, 10]) < 0.8 * np.linalg.norm(
        plain.points[12, 11] - plain.points[12, 10]
    )


def test_too_much_control_is_reduced_and_told():
    p = np.where(np.arange(15) < 7, 1.2, -1.2) + np.zeros((25, 15))
    q = np.where(np.arange(25) < 12, 1.2, -1.2)[:, None] + np.zeros((25, 15))
    grid, report = mc.elliptic(*WAVY, control="none", control_functions=(p, q))
    assert any("were reduced to" in text for text in report.warnings)
    assert not weak_cells(planar(grid), 1.0).any()


def test_not_converged_is_a_result_with_a_warning():
    grid, report = mc.elliptic(*WAVY, residual=1e-12, max_cycles=2, control="none")
    assert not report.converged and "not converged after 2 cycles" in report.warnings[0]
    assert not weak_cells(planar(grid), 1.0).any()


def test_an_impossible_height_is_told_not_reached():
    _, report = mc.elliptic(*WAVY, walls="south", first_height=0.8)
    assert not report.converged and "walls not controlled" in report.warnings[0]


def test_a_corner_that_points_inwards_cannot_be_meshed():
    points = wavy(12, 12, 0.0)
    t = np.linspace(0, 1, 12)[:, None]
    points[:, 0] = (1 - t) * [0.6, 0.6] + t * points[-1, 0]
    points[0] = (1 - t) * [0.6, 0.6] + t * points[0, -1]
    with pytest.raises(GenerationFailed, match="folded") as caught:
        mc.elliptically_smoothed(grid_of(points))
    assert 0 in caught.value.cells and caught.value.partial.shape == (12, 12, 1)


@pytest.mark.parametrize("size", [2, 3])
def test_grids_with_few_points_inside_or_none(size):
    x, y = np.meshgrid(np.linspace(0, 1, size), np.linspace(0, 1, 6), indexing="ij")
    points = np.stack([x + 0.1 * y, y], axis=-1)
    grid, report = mc.elliptically_smoothed(grid_of(points))
    assert report.converged and np.abs(planar(grid) - points).max() < 1e-12


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"residual": 0.0}, "residual: must be at least 1e-13"),
        ({"residual": np.nan}, "residual: must be finite"),
        ({"first_height": 0.1}, "first_height: is given, but no walls"),
        ({"walls": "south", "first_height": -1.0}, "first_height: must be greater than zero"),
        ({"walls": "south", "wall_angle": 180.0}, "wall_angle: must be at most 170"),
        ({"walls": "top"}, "walls: 'top' is not one of"),
        ({"control_functions": (np.full((25, 15), 2.0), np.zeros((25, 15)))}, "between -2 and 2"),
        ({"max_cycles": 0}, "max_cycles: must be at least 1"),
        ({"threads": 0}, "threads"),
    ],
)
def test_bad_parameters_are_refused(keywords, message):
    with pytest.raises(InvalidInput, match=message):
        mc.elliptic(*WAVY, **keywords)


def test_bad_geometry_is_refused():
    south, east, north, west = WAVY
    broken = south.copy()
    broken[3, 0] = np.nan
    with pytest.raises(InvalidInput):
        mc.elliptic(broken, east, north, west)
    with pytest.raises(InvalidInput, match="one layer"):
        mc.elliptically_smoothed(mc.StructuredGrid(np.random.default_rng(0).random((3, 3, 3, 3))))
    with pytest.raises(InvalidInput, match="no planar grid"):
        mc.elliptically_smoothed(grid_of(wavy(5, 5), periodic=(True, True, False)))
    with pytest.raises(InvalidInput, match="'roof'"):
        Wall("roof")
    for bad in ({"first_height": 0.0}, {"first_height": np.nan}, {"angle": 0.0}, {"angle": 180.0}):
        with pytest.raises(InvalidInput):
            Wall("south", **bad)


def test_can_be_cancelled():
    with pytest.raises(Cancelled):
        mc.elliptic(*WAVY, residual=1e-10, progress=lambda fraction, message: "residual" not in message)


def blade_row(ni, nj, pitch=1.0):
    """Sides of a passage that repeats along x: a wavy floor, a flat roof, and slanted cuts."""
    s, t = np.linspace(0, 1, ni), np.linspace(0, 1, nj)
    south = np.column_stack([pitch * s, 0.15 * np.sin(2 * np.pi * s)])
    north = np.column_stack([pitch * s + 0.5, 0 * s + 1])
    west = np.column_stack([0.5 * t**2, t])
    return south, west + [pitch, 0], north, west


def test_a_periodic_passage_runs_on_through_its_cut():
    grid, report = mc.elliptic(*blade_row(32, 24), periodic=True, control="none", residual=1e-11)
    west, east = planar(grid)[0], planar(grid)[-1]
    assert report.converged and np.abs(east - west - [1, 0]).max() < 1e-14
    assert np.abs(west - blade_row(32, 24)[3])[1:-1].max() > 0.01
    # The same passage cut elsewhere has the same grid.
    start, _ = mc.transfinite(*blade_row(32, 24))
    moved = np.concatenate([planar(start)[10:-1], planar(start)[:11] + [1, 0]])
    other = winslow(moved, cyclic=True, tolerance=1e-11).points
    assert distance(other[:21], planar(grid)[10:31]) < 1e-8


def test_periodic_walls_are_upright_everywhere():
    grid, report = mc.elliptic(*blade_row(48, 40), periodic=True, control="none", walls="south", first_height=0.005)
    assert report.converged
    edge = planar(grid)[:-1, 1] - planar(grid)[:-1, 0]
    assert np.abs(np.linalg.norm(edge, axis=1) / 0.005 - 1).max() < 0.05


def test_sides_that_do_not_repeat_are_refused():
    with pytest.raises(InvalidInput, match="east to be west moved along"):
        mc.elliptic(*WAVY, periodic=True)


def box_sides(cells_i, cells_j):
    """Sides of a 2 x 1 box with equal cells, which the Laplace equations leave as they are."""
    x, y = np.linspace(0, 2, cells_i + 1), np.linspace(0, 1, cells_j + 1)
    south, west = np.column_stack([x, 0 * x, 0 * x]), np.column_stack([0 * y, y, 0 * y])
    return south, west + [2, 0, 0], south + [0, 1, 0], west


def test_walls_are_reached_from_a_start_that_solves_the_equations():
    grid, report = mc.elliptic(*box_sides(32, 24), walls="south", wall_angle=75)
    assert report.converged is True and 0 < report.residual < 1  # a bool of numpy's breaks hosts
    assert np.abs(mc.quality.face_angle(grid, "jmin")[3:-3] - 75).max() < 1
    as_it_is, report = mc.elliptic(*box_sides(8, 8), walls="south")
    assert report.converged and np.isfinite(report.history).all()
    assert np.ptp(as_it_is.points[..., 1], axis=0).max() < 1e-12


@pytest.mark.parametrize(("cells", "height"), [((16, 8), 0.02), ((64, 64), 1e-3)])
def test_sides_that_get_new_points_begin_with_the_first_height(cells, height):
    given = dict(zip(("cells_i", "cells_j"), cells, strict=True))
    grid, report = mc.elliptic(*box_sides(4, 4), **given, walls="south", first_height=height)
    assert report.converged and not report.warnings
    assert np.abs(mc.quality.first_height(grid, "jmin") / height - 1).max() < 0.05  # at the ends, too
    other, _ = mc.elliptic(*box_sides(4, 4), **given, walls="south", first_height=height, spacing_south=0.01)
    assert np.allclose(np.linalg.norm(other.points[0, 1] - other.points[0, 0]), 0.01)


def test_a_first_height_that_no_side_can_have_is_refused_by_its_own_name():
    with pytest.raises(InvalidInput, match="does not fit a side of length 1 ") as caught:
        mc.elliptic(*box_sides(4, 4), cells_i=8, cells_j=8, walls="south", first_height=2.0)
    assert caught.value.parameter == "first_height"


@pytest.mark.parametrize("law", ["uniform", "hyperbolic sine", "cosine", "curvature", "poisson", "copied"])
def test_sides_get_their_points_by_the_laws_of_transfinite(law):
    given = {"cells_i": 16, "cells_j": 12, "law_i": law, "law_j": law}
    smooth, plain = mc.elliptic(*WAVY, **given).mesh, mc.transfinite(*WAVY, **given).mesh
    for side in (np.s_[:, 0], np.s_[:, -1], np.s_[0], np.s_[-1]):
        assert (smooth.points[side] == plain.points[side]).all()


def test_a_law_without_end_cells_may_stand_beside_a_first_height():
    grid, _ = mc.elliptic(*box_sides(8, 8), cells_i=12, cells_j=12, law_j="cosine", walls="south", first_height=0.02)
    assert np.allclose(grid.points[0, :, 0, 1], np.sin(np.linspace(0, np.pi / 2, 13)) ** 2)


def test_single_sides_have_spacings_of_their_own():
    grid, _ = mc.elliptic(*box_sides(8, 8), spacings={"south": mc.Spacing("geometric", ratio=1.3)})
    steps = np.diff(grid.points[:, 0, 0, 0])
    assert np.allclose(steps[1:] / steps[:-1], 1.3)


def horseshoe(radius, n_leg, n_arc):
    """A leg up, half a circle, and a leg down."""
    up = np.linspace((-radius, -1.5, 0), (-radius, 0, 0), n_leg + 1)
    angle = np.linspace(np.pi, 0, n_arc + 1)
    arc = radius * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    return np.concatenate([up[:-1], arc, (up * [-1, 1, 1])[::-1][1:]])


@pytest.mark.parametrize("control", ["none", "boundary spacing"])
def test_a_horseshoe_is_filled_with_convex_cells(control):
    outer, inner = horseshoe(1.5, 12, 24), horseshoe(0.5, 12, 24)
    grid, report = mc.elliptic(
        outer[::-1],
        np.linspace(outer[0], inner[0], 13),
        inner[::-1],
        np.linspace(outer[-1], inner[-1], 13),
        control=control,
    )
    assert report.converged and not weak_cells(planar(grid), 1.0).any()
    x, y = planar(grid)[..., 0], planar(grid)[..., 1]
    assert np.abs(x + x[::-1]).max() < 2e-3 and np.abs(y - y[::-1]).max() < 2e-3  # as symmetric as it was given


def test_a_sheared_box_is_its_own_laplace_grid():
    south, east, north, west = (side @ np.array([[1, 0, 0], [0.8, 1, 0], [0, 0, 1]]) for side in box_sides(20, 12))
    rough = mc.transfinite(south, east, north, west).mesh.points.copy()
    exact = rough.copy()
    rough[1:-1, 1:-1, 0, :2] += 0.02 * np.random.default_rng(5).normal(size=(19, 11, 2))
    grid, report = mc.elliptically_smoothed(mc.StructuredGrid(rough), residual=1e-11)
    assert report.converged and np.abs(grid.points - exact).max() < 1e-9


def test_a_grid_that_goes_astray_is_no_fault_of_the_users_points(monkeypatch):
    from meshcore.structured.poisson import elliptic_problem

    def astray(points, *arguments):
        return elliptic_problem.Found(np.full_like(points, np.nan), [1.0], False)

    monkeypatch.setattr(elliptic_problem, "_planar", astray)
    with pytest.raises(GenerationFailed, match=r"went astray while walls were controlled; .*ask for less") as caught:
        mc.elliptic(*WAVY, walls="south")
    assert np.isfinite(caught.value.partial.points).all()
