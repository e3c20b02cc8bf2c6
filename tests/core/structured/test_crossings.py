"""Outlines that cross themselves, and outer curves that hold nothing: what is said, where, by the user's numbers."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import InvalidGeometry, gallery

BOW = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.0]])
EIGHT = np.array([[0, 0, 0], [1, 0.5, 0], [2, 0, 0], [2, 1, 0], [1, 0.3, 0], [0, 1, 0.0]])
UPRIGHT = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
CALLS = {
    "section": [mc.o_grid, mc.c_grid, mc.h_grid],
    "front": [mc.hyperbolic, lambda front: mc.parabolic(front, gallery.circle(40, radius=9))],
}
CASES = [(name, call) for name, calls in CALLS.items() for call in calls]


def loop(points, order=None):
    """A mesh of the closed curve through points, whose own numbers are in another order."""
    number = np.arange(len(points)) if order is None else np.asarray(order)
    shuffled = np.empty((len(points), 3))
    shuffled[number] = points
    return mc.Mesh(shuffled, {"line": np.column_stack([number, np.roll(number, -1)])})


@pytest.mark.parametrize(("name", "call"), CASES)
@pytest.mark.parametrize("turned", [False, True])
def test_crossings_are_told_by_place_and_the_users_numbers(name, call, turned):
    points, order = (EIGHT[::-1], [3, 0, 5, 1, 4, 2]) if turned else (EIGHT, range(6))
    with pytest.raises(InvalidGeometry, match=rf"{name}: crosses itself near \(0.833333, 0.416667, 0\)") as caught:
        call(loop(points, order))
    at = {order[5 - k] if turned else k for k in (0, 1, 4, 5)}
    assert set(caught.value.points) == at


@pytest.mark.parametrize(("name", "call"), CASES)
def test_a_bow_tie_crosses_itself_though_it_has_no_area(name, call):
    with pytest.raises(InvalidGeometry, match=rf"{name}: crosses itself near \(0.5, 0.5, 0\)"):
        call(loop(BOW))


def test_places_are_those_of_space():
    with pytest.raises(InvalidGeometry, match=r"near \(0.833333, 0, 2.41667\)"):
        mc.o_grid(loop(EIGHT @ UPRIGHT + [0, 0, 2]))


@pytest.mark.parametrize(("name", "call"), CASES)
def test_a_line_there_and_back_has_too_few_points(name, call):
    with pytest.raises(InvalidGeometry, match=f"{name}: needs at least (3|three) different points, got 2"):
        call(np.array([[0, 0, 0], [1, 0, 0], [0, 0, 0.0]]))


@pytest.mark.parametrize(("name", "call"), CASES)
def test_arrays_at_fault_are_told_by_name(name, call):
    points = gallery.circle(12).points.copy()
    points[3, 0] = np.nan
    with pytest.raises(InvalidGeometry, match=f"^{name}: point 3 is ") as caught:
        call(points)
    assert caught.value.points == (3,)
    with pytest.raises(InvalidGeometry, match=f"^{name}: has triangle cells but no lines"):
        call(gallery.bumpy_ball())


@pytest.mark.parametrize("centre", [(0.0, 0.0), (0.9, 0.0), (5.0, 0.0)])
def test_outer_curves_must_go_round_everything(centre):
    outer = gallery.circle(32, radius=0.5 if centre == (0.0, 0.0) else 1.2, centre=centre)
    for call, what in ((mc.o_grid, "section"), (mc.parabolic, "front")):
        with pytest.raises(InvalidGeometry, match=f"outer: does not go round all of the {what}: .* is outside"):
            call(gallery.circle(32), outer)


def test_an_outer_curve_that_crosses_itself_is_refused():
    with pytest.raises(InvalidGeometry, match=r"outer: crosses itself near \(0.833333, 0.416667, 0\)"):
        mc.parabolic(gallery.circle(32, radius=0.1, centre=(0.3, 0.4)), loop(EIGHT))


@pytest.mark.parametrize("turned", [False, True])
def test_a_front_that_cannot_be_left_names_its_point(turned):
    outline = gallery.airfoil("naca0012").points
    order = np.random.default_rng(0).permutation(len(outline))
    front = loop(outline[::-1] if turned else outline, order)
    with pytest.raises(mc.GenerationFailed, match=r"no layer could be made: .* at the front's point") as caught:
        mc.hyperbolic(front, first_height=1.0, layers=1, other_side=True)
    number = caught.value.points[0]
    x, y, _ = front.points[number]
    assert caught.value.parameter == "front" and f"point {number} near ({x:.6g}, {y:.6g}, 0)" in str(caught.value)


def test_layers_that_do_not_grow_fill_the_distance():
    _, report = mc.hyperbolic(gallery.circle(32), first_height=0.3, growth=1.0, distance=1.0)
    assert report.counts["layers"] == 4
    assert report.quality["first height"] == pytest.approx(0.25)


def test_billions_of_layers_are_refused_before_they_are_made():
    for call in CALLS["front"][0], lambda front, **more: mc.parabolic(front, gallery.circle(9, radius=9), **more):
        with pytest.raises(mc.InvalidInput, match="layers: would make"):
            call(gallery.circle(12), layers=10**9)
