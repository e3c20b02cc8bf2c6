"""O-grids: sound cells around airfoils and other loops, walls at right angles, and clear refusals."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import meshcore as mc
from meshcore import gallery
from meshcore.errors import Cancelled, InvalidGeometry, InvalidInput
from meshcore.geometry.curves import lines_through, polyline
from tests import naive

METHODS = ("transfinite", "elliptic", "hyperbolic", "parabolic")


def assert_sound(grid):
    points = grid.points[:, :, 0]
    assert (naive.cross_areas(points) > 0).all()
    assert (points[0] == points[-1]).all() and grid.periodic == (True, False, False)


@pytest.mark.parametrize("method", ["transfinite", "hyperbolic"])
@pytest.mark.parametrize("name", gallery.airfoils())
@pytest.mark.parametrize("keywords", [{}, {"around": 160, "first_height": 1e-5, "layers": 80}, {"radius": 1.5}])
def test_airfoils(name, keywords, method):
    section = gallery.airfoil(name)
    grid, report = mc.o_grid(section, method=method, **keywords)
    assert_sound(grid)
    wall, outer = grid.points[:, 0, 0], grid.points[:, -1, 0]
    height = keywords.get("first_height", 0.001 * section.diagonal)
    assert np.abs(np.linalg.norm(grid.points[:, 1, 0] - wall, axis=1) / height - 1).max() < 1e-5
    nose = wall[np.argmax(np.linalg.norm(wall - wall[0], axis=1))]
    far = np.linalg.norm(outer - 0.5 * (nose + wall[0]), axis=1) / np.linalg.norm(wall[0] - nose)
    within = 1e-3 if method == "transfinite" else 0.08  # of where the march arrives
    assert far == pytest.approx(keywords.get("radius", 10.0), rel=within)
    if "around" not in keywords:
        loop = polyline(section)[:-1]
        assert {tuple(p) for p in wall} == {tuple(p) for p in loop}
    if "layers" not in keywords:
        steps = np.linalg.norm(np.diff(grid.points[:, :, 0], axis=1), axis=-1)
        growth = (steps[:, 1:] / steps[:, :-1]).max(axis=1)
        # More where lines bend, beside the trailing edge.
        assert np.median(growth) <= (1.15 if method == "transfinite" else 1.16)
        assert report.quality["largest growth"] == pytest.approx(growth.max())
    assert wall[0, 0] > 0.99  # cut at the trailing edge


@pytest.mark.parametrize("name", gallery.airfoils())
def test_lines_leave_the_wall_at_right_angles(name):
    grid, _ = mc.o_grid(gallery.airfoil(name), around=200, first_height=1e-4)
    points = grid.points[:, :, 0]
    tangent = points[2:, 0] - points[:-2, 0]
    away = points[1:-1, 1] - points[1:-1, 0]
    cosine = (tangent * away).sum(axis=1) / np.linalg.norm(tangent, axis=1) / np.linalg.norm(away, axis=1)
    assert (np.abs(np.degrees(np.arcsin(cosine)))[5:-5] < 8).all()


def test_skewed_cells_are_few_unless_others_are_asked_for():
    skew = "worst skew of lines (degree)"
    for name in gallery.airfoils():
        for make in (mc.o_grid, mc.c_grid):
            found = {m: make(gallery.airfoil(name), method=m).report.quality[skew] for m in METHODS}
            assert make(gallery.airfoil(name)).report.quality[skew] == min(found.values()) < 20


def test_the_cut_follows_the_trailing_edges_bisector():
    grid, _ = mc.o_grid(gallery.airfoil("rae2822"), method="transfinite")
    points = grid.points[:, :, 0]
    upper, lower = points[-2, 0] - points[0, 0], points[1, 0] - points[0, 0]
    bisector = -(upper / np.linalg.norm(upper) + lower / np.linalg.norm(lower))
    way = points[0, -1] - points[0, 0]
    assert np.cross(bisector, way)[2] / np.linalg.norm(bisector) / np.linalg.norm(way) == pytest.approx(0, abs=1e-9)


def test_around_a_circle_it_is_the_polar_grid():
    grid, _ = mc.o_grid(gallery.circle(40), radius=4, layers=10, first_height=0.1)
    points = grid.points[:, :, 0]
    radii = np.hypot(points[..., 0], points[..., 1])
    assert np.ptp(radii, axis=0).max() < 1e-9  # the chord is the diameter
    assert radii[0, [0, 1, -1]] == pytest.approx([1, 1.1, 8], rel=1e-9)
    angles = np.unwrap(np.arctan2(points[..., 1], points[..., 0]), axis=0)
    assert np.abs(np.diff(angles, axis=0) + 2 * np.pi / 40).max() < 1e-9


@pytest.mark.parametrize(
    "loop",
    [gallery.square(), gallery.square(7), gallery.l_shape(6), gallery.circle(3), gallery.circle(64)],
    ids=["square", "square 7", "L", "triangle", "circle"],
)
def test_other_loops(loop):
    grid, _ = mc.o_grid(loop, radius=3, first_height=0.02)
    assert_sound(grid)
    assert grid.cell_shape[0] == loop.n_cells


@given(st.integers(0, 10**6), st.floats(0, 0.25), st.integers(2, 5), st.integers(24, 90))
@settings(max_examples=25)
def test_wavy_rounds(seed, depth, waves, n):
    rng = np.random.default_rng(seed)
    angle = np.sort(2 * np.pi * (np.arange(n) + 0.4 * rng.random(n)) / n)
    r = 1 + depth * np.sin(waves * angle + rng.random()) / waves
    grid, _ = mc.o_grid(np.column_stack([r * np.cos(angle), r * np.sin(angle)])[np.r_[0:n, 0]], radius=4)
    assert_sound(grid)


def test_direction_start_and_place_of_the_loop_do_not_matter():
    loop = polyline(gallery.airfoil("s1223"))[:-1]
    first, _ = mc.o_grid(np.vstack([loop, loop[:1]]))
    for other in (loop[::-1], np.roll(loop, 37, axis=0)):
        grid, _ = mc.o_grid(np.vstack([other, other[:1]]))
        assert np.abs(grid.points - first.points).max() < 1e-9
    moved, _ = mc.o_grid(np.vstack([loop, loop[:1]]) * 250 + [3, -4, 7])
    assert np.abs(moved.points - (first.points * 250 + [3, -4, 7])).max() < 1e-6


def test_a_section_in_a_tilted_plane_is_gridded_in_that_plane():
    loop = polyline(gallery.airfoil("rae2822"))  # whose edge is one corner
    tilt = np.linalg.qr(np.random.default_rng(5).random((3, 3)))[0]
    flat, _ = mc.o_grid(loop, first_height=0.001)
    tilted, _ = mc.o_grid(loop @ tilt.T + 2, first_height=0.001)
    back = (tilted.points - 2) @ tilt
    assert np.abs(back[..., 2]).max() < 1e-12
    # A plane in space has no upper side, so the grid may run the other way round.
    assert min(np.abs(back - flat.points).max(), np.abs(back[::-1] - flat.points).max()) < 1e-6


@pytest.mark.parametrize("axes", [[0, 2, 1], [1, 2, 0], [2, 0, 1]])
def test_a_section_in_a_plane_of_coordinates_keeps_its_points_to_the_bit(axes):
    loop = polyline(gallery.airfoil("rae2822"))[:, axes] + [0.0, 0.0, 0.0]
    grid, _ = mc.o_grid(loop)
    assert {tuple(p) for p in grid.points[:, 0, 0]} == {tuple(p) for p in loop}


def test_a_mesh_in_any_order_and_a_chosen_cut():
    loop = gallery.circle(24)
    order = np.random.default_rng(3).permutation(24)
    shuffled = mc.Mesh(loop.points[order], {"line": np.argsort(order)[loop.get("line")]})
    grid, _ = mc.o_grid(shuffled, cut=int(np.argsort(order)[9]), radius=3)
    assert (grid.points[0, 0, 0] == loop.points[9]).all()
    assert_sound(grid)


def test_repeated_points_are_left_out_with_a_warning():
    loop = polyline(gallery.circle(12))
    grid, report = mc.o_grid(np.insert(loop, 5, loop[5], axis=0), radius=3)
    assert grid.cell_shape[0] == 12 and "1 repeated" in report.warnings[0]


@pytest.mark.parametrize("tilted", [False, True])
def test_where_an_outline_goes_straight_back_points_are_left_out_with_a_warning(tilted):
    loop = polyline(gallery.airfoil("rae2822"))[:-1]
    seam = loop[0] + [[0.02, 0, 0], [0.05, 0, 0], [0.03, 0, 0], [0.01, 0, 0]]  # as a cusp that has been rounded
    spike = loop[40] + [[0, 0.01, 0], [0, 0, 0]]
    given = np.vstack([loop[:41], spike, loop[41:], loop[:1], seam, loop[:1]])
    if tilted:
        given = 300 + given @ np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    grid, report = mc.o_grid(given)
    assert grid.cell_shape[0] == len(loop)
    assert any("goes straight back" in text for text in report.warnings)


@pytest.mark.parametrize("place", [0, 1e4])
def test_points_on_the_other_side_are_told_even_far_from_the_origin(place):
    given = np.array([[0, 0], [1, -0.1], [3, -0.1], [2, 0.1], [1.5, -0.1], [1, 0.3], [0, 0.0]])
    tilt = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0][:2]
    with pytest.raises(InvalidGeometry, match="touches itself at point 4"):
        mc.o_grid(given @ tilt + place)


def test_what_is_cleaned_is_told():
    loop = polyline(gallery.airfoil("naca0012"))
    _, report = mc.o_grid(loop[:-1])  # the base is missing
    assert "open by 0.00252" in report.warnings[0]
    _, report = mc.o_grid(loop[::-1])
    assert report.warnings == ["the section runs clockwise; it was turned"]
    almost = polyline(gallery.circle(12))
    almost[-1] += 1e-15  # as formulas close it
    grid, report = mc.o_grid(almost, radius=3)
    assert report.warnings == [] and grid.cell_shape[0] == 12


def test_a_crossing_says_where():
    with pytest.raises(InvalidGeometry, match=r"near \(0.857143, 0.857143, 0\)") as caught:
        mc.o_grid(np.array([[0, 0], [2, 2], [2, 0], [0, 1.5], [0, 0]]))
    assert sorted(caught.value.points) == [0, 1, 2, 3]
    touching = np.array([[0, 0], [4, 0], [4, 4], [2, 0], [0, 4], [0, 0.0]])
    with pytest.raises(InvalidGeometry, match="touches itself at point 3"):
        mc.o_grid(touching)


@pytest.mark.parametrize("name", gallery.airfoils())
@pytest.mark.parametrize("method", ["elliptic", "hyperbolic", "parabolic"])
def test_other_methods_hold_heights_and_fold_nothing(name, method):
    grid, _ = mc.o_grid(gallery.airfoil(name), method=method)  # on coarse points, heights larger than they are apart
    assert_sound(grid)
    grid, report = mc.o_grid(
        gallery.airfoil(name), method=method, around=200, first_height=1e-5, trailing_spacing=0.002
    )
    assert_sound(grid)
    away = np.linalg.norm(grid.points[:, 1, 0] - grid.points[:, 0, 0], axis=1)
    assert away == pytest.approx(report.quality["first height"], rel=0.03)
    steps = np.linalg.norm(np.diff(grid.points[:, :, 0], axis=1), axis=-1)
    near = (steps[:, 1:] / steps[:, :-1])[10:-10, :20]  # on the first layers
    if method != "elliptic":
        assert np.abs(near / np.median(near) - 1).max() < 0.02


def test_a_circle_marches_to_the_polar_grid():
    for method in ("hyperbolic", "parabolic", "elliptic"):
        points = mc.o_grid(gallery.circle(40), radius=4, layers=10, first_height=0.1, method=method)[0].points[:, :, 0]
        radii = np.hypot(points[..., 0], points[..., 1])
        assert np.ptp(radii, axis=0).max() < (1e-5 if method == "elliptic" else 1e-9)
        assert radii[0, [0, -1]] == pytest.approx([1, 8], rel=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_a_box_keeps_its_corners(method):
    grid, _ = mc.o_grid(gallery.airfoil("rae2822"), far_field="box", radius=3, method=method)
    assert_sound(grid)
    outer = grid.points[:, -1, 0, :2]
    for corner in ((-2.5, -3), (3.5, -3), (3.5, 3), (-2.5, 3)):
        assert np.linalg.norm(outer - corner, axis=1).min() < 1e-6
    assert np.abs(np.abs(outer - [0.5, 0]).max(axis=1) - 3).max() < 1e-6


@pytest.mark.parametrize("section", [gallery.circle(3), np.array([[0, 0], [1, 0], [0.3, 0.8], [0, 0]])])
def test_where_lines_are_too_few_for_a_box_the_far_field_is_where_they_arrive(section):
    grid, report = mc.o_grid(section, far_field="box")
    assert_sound(grid)
    assert any("the far field is where that arrives" in text for text in report.warnings)


@pytest.mark.parametrize("method", METHODS)
def test_a_given_far_field_is_met(method):
    angle = 2 * np.pi * np.arange(181) / 180
    own = np.column_stack([0.5 + 4 * np.cos(angle), 3 * np.sin(angle)])
    own[-1] = own[0]
    grid, _ = mc.o_grid(gallery.airfoil("naca0012"), own, method=method)
    assert_sound(grid)
    x, y, _ = grid.points[:, -1, 0].T
    assert np.abs(np.hypot((x - 0.5) / 4, y / 3) - 1).max() < 1e-3


@pytest.mark.parametrize(
    ("outer", "words"),
    [
        (np.array([[5, -5], [5, 5], [-5, 5], [-5, -5]]), "outer: is open"),
        (gallery.circle(30, radius=0.2), "does not go round all of the section"),
        (gallery.circle(30, centre=(9, 0)), "does not go round all of the section"),
        (np.array([[5, -5], [5, 5], [-5, 5], [-5, 4], [4, 4], [4, -5], [5, -5.0]]), "outer"),
        (gallery.circle(30, radius=5).points[np.r_[0:30, 0]] + [0, 0, 1], "plane"),
        (gallery.circle(30, radius=5).points[np.r_[0:30, 0]] * 1e70, "lost"),
        (gallery.circle(30, radius=5).points[np.r_[0:30, 0]] * 1e100, "outer: has an extent"),
    ],
)
def test_far_fields_that_do_not_fit(outer, words):
    with pytest.raises(InvalidInput, match=words):
        mc.o_grid(gallery.airfoil("naca0012"), outer)


def bay():
    """A ring with a narrow mouth: no straight ray leads out of it."""
    outer = np.radians(np.linspace(20, 340, 33))
    inner = outer[::-1]
    ring = np.concatenate(
        [np.column_stack([np.cos(outer), np.sin(outer)]), 0.7 * np.column_stack([np.cos(inner), np.sin(inner)])]
    )
    return lines_through(ring, closed=True)


CIRCLE = polyline(gallery.circle(12))


@pytest.mark.parametrize(
    ("section", "keywords", "error", "words"),
    [
        (CIRCLE[:-1], {}, InvalidGeometry, "open"),
        (np.zeros((4, 3)), {}, InvalidGeometry, "different points"),
        (np.array([[0, 0], [1, 0], [2, 0], [0, 0.0]]), {}, InvalidGeometry, "no area"),
        (np.array([[0, 0], [1, 0], [0, 0], [1, 0], [0, 0.0]]), {}, InvalidGeometry, "no area"),
        (np.array([[0, 0], [1, np.nan], [1, 1], [0, 0.0]]), {}, InvalidGeometry, "finite"),
        (CIRCLE + 0.1 * CIRCLE[:, [2, 2, 0]] ** 2, {}, InvalidGeometry, "planar"),
        (gallery.joined(gallery.circle(12), gallery.circle(6)), {}, InvalidGeometry, "one chain"),
        (np.array([[0, 0], [2, 2], [2, 0], [0, 1.5], [0, 0]]), {}, InvalidGeometry, "crosses itself near"),
        (CIRCLE, {"radius": 0.5}, InvalidInput, "radius: must be at least 1"),
        (CIRCLE, {"first_height": 0.0}, InvalidInput, "first_height"),
        (CIRCLE, {"first_height": 15.0}, InvalidInput, "first_height: is 15"),
        (CIRCLE, {"first_height": 9.0, "layers": 200}, InvalidInput, "first_height: 9 does not fit 200"),
        (CIRCLE, {"growth": 1.0}, InvalidInput, "growth"),
        (CIRCLE, {"layers": 0}, InvalidInput, "layers"),
        (CIRCLE, {"cut": 12}, InvalidInput, "cut: 12 is no point"),
        (np.vstack([CIRCLE, CIRCLE[1:]]), {}, InvalidGeometry, "runs round more than once: points 0 and 12"),
        (CIRCLE[[*range(7), 2, *range(8, 13)]], {}, InvalidGeometry, "touches itself: points 2 and 7"),
        (CIRCLE * [1, np.nan, 1], {}, InvalidGeometry, "section: point 0 is .* not finite"),
        (np.zeros((5, 3)), {}, InvalidGeometry, "needs at least two different points, got 1"),
        (CIRCLE, {"leading_spacing": 5e-324}, InvalidInput, "leading_spacing: is 4.94066e-324; give a size between"),
        (CIRCLE, {"trailing_spacing": 1.5}, InvalidInput, "half the chord, 1"),
        (gallery.square(3), {"around": 3}, InvalidInput, "around: 3 cells are too few"),
    ],
)
def test_bad_input_gets_a_clear_error(section, keywords, error, words):
    with pytest.raises(error, match=words):
        mc.o_grid(section, **keywords)


def test_a_bay_that_no_straight_ray_leaves_is_marched_and_says_so():
    grid, report = mc.o_grid(bay(), method="transfinite")
    assert_sound(grid)
    assert "lines crossed in" in report.warnings[0]


def test_stops_when_told():
    with pytest.raises(Cancelled):
        mc.o_grid(gallery.circle(12), progress=lambda fraction, message: fraction < 0.4)


@pytest.mark.parametrize("scale", [1e-200, 1e-80, 1e80, 1e200])
def test_sections_whose_areas_would_over_or_underflow(scale):
    with pytest.raises(InvalidGeometry, match=r"section: has an extent of .*scale it"):
        mc.o_grid(lines_through(scale * gallery.circle(12).points, closed=True))


@pytest.mark.parametrize("keywords", [{"first_height": 1e-30}, {"first_height": 1e-300}, {"radius": 1e300}])
def test_heights_that_rounding_would_lose(keywords):
    with pytest.raises(InvalidInput, match=r"first_height: is .* lost in rounding"):
        mc.o_grid(gallery.circle(12), **keywords)


@pytest.mark.parametrize("name", ["around", "layers"])
def test_grids_too_large_for_the_memory(name):
    with pytest.raises(InvalidInput, match=f"{name}: would make .* points; at most"):
        mc.o_grid(gallery.circle(12), **{name: 10**9})


@pytest.mark.parametrize("name", gallery.airfoils())
def test_layers_of_a_march_grow_evenly_on_every_line(name):
    # A march holds areas: a line from a sharp trailing edge had layers of 1e-3, 1.7e-4, 8e-4.
    _, report = mc.o_grid(gallery.airfoil(name), method="hyperbolic")
    assert report.quality["largest growth"] < 1.2


@pytest.mark.parametrize("order", ["section first", "far field first"])
@pytest.mark.parametrize("turn", [np.eye(4), np.eye(4)[[1, 2, 0, 3]]])
def test_two_loops_of_one_mesh_are_a_section_and_its_far_field(order, turn):
    section, circle = gallery.airfoil("naca0012").transformed(turn), gallery.circle(60, radius=4).transformed(turn)
    both = gallery.joined(*([section, circle] if order == "section first" else [circle, section]))
    grid, _ = mc.o_grid(both, layers=12)
    np.testing.assert_array_equal(grid.points, mc.o_grid(section, circle, layers=12).mesh.points)
    assert np.linalg.norm(grid.points[:, -1, 0], axis=1) == pytest.approx(4, rel=0.01)


def test_faults_of_a_section_in_its_far_field_have_its_own_numbers():
    loop = lines_through(np.array([[1, 0.1], [0, -0.1], [0, 0.1], [1, -0.1]]), closed=True)  # crosses itself
    with pytest.raises(InvalidGeometry, match="section") as caught:
        mc.o_grid(gallery.joined(gallery.circle(30, radius=4), loop))
    assert set(caught.value.points) <= set(range(30, 34)) and len(caught.value.points)


def test_loops_beside_each_other_are_no_section():
    both = gallery.joined(gallery.circle(20), gallery.circle(20, centre=(1.5, 0)))
    with pytest.raises(InvalidGeometry, match="one chain"):
        mc.o_grid(both)
    with pytest.raises(InvalidGeometry, match="one chain"):  # an outer curve is given
        mc.o_grid(gallery.airfoil_in_far_field("naca0012"), gallery.circle(30, radius=20))
