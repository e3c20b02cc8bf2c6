"""Boolean sums beyond the sides alone: lines inside, slopes at sides, and what they reproduce."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import meshcore as mc
from meshcore import gallery
from meshcore.errors import InvalidGeometry, InvalidInput
from meshcore.geometry.curves import lines_through, resampled
from meshcore.sizing import Spacing, geometric, uniform
from meshcore.structured.algebraic.blending import Direction, Patch, boolean_sum, broken, cardinal, end_derivative
from meshcore.structured.algebraic.interior_lines import nearest
from meshcore.structured.folds import folded_cells

WAVY = tuple(np.round(side, 9) for side in gallery.wavy_sides(12, 8))
ONE = [np.array(side, float) for side in ([[0, 0], [1, 0]], [[1, 0], [1, 1]], [[0, 1], [1, 1]], [[0, 0], [0, 1]])]


@given(st.integers(2, 9), st.booleans(), st.booleans(), st.integers(0, 10**6))
def test_cardinal_splines_reproduce_polynomials_of_the_right_degree(count, at_start, at_end, seed):
    rng = np.random.default_rng(seed)
    stations = np.concatenate([[0.0], np.sort(rng.uniform(0.05, 0.95, count - 2)), [1.0]])
    if (np.diff(stations) < 0.02).any():
        return
    ends = np.array([0.0] * at_start + [1.0] * at_end)
    at = np.linspace(0, 1, 31)
    weights = cardinal(stations, at, slopes=ends)
    degree = min(3, count + len(ends) - 1)
    polynomial = np.polynomial.Polynomial(rng.uniform(-1, 1, degree + 1))
    data = np.concatenate([polynomial(stations), polynomial.deriv()(ends)])
    assert np.abs(weights @ data - polynomial(at)).max() < 1e-10
    on_stations = cardinal(stations, stations, slopes=ends)
    assert np.abs(on_stations - np.eye(count, count + len(ends))).max() < 1e-10


def test_broken_lines_reproduce_straight_ones_and_stay_between_their_data():
    stations, at = np.array([0, 0.2, 0.7, 1]), np.linspace(0, 1, 51)
    weights = broken(stations, at)
    assert np.abs(weights @ (3 * stations - 1) - (3 * at - 1)).max() < 1e-14
    assert (weights >= 0).all() and np.abs(weights.sum(axis=1) - 1).max() < 1e-14


def test_end_derivatives_are_exact_for_cubics_on_any_points():
    u = geometric(9, ratio=1.3)
    values = np.stack([u**3 - u, 2 * u**2 + 1], axis=-1)
    assert np.abs(end_derivative(values, u, 0) - [-1, 0]).max() < 1e-10
    assert np.abs(end_derivative(values, u, 9) - [2, 4]).max() < 1e-10


def tensor(rng, degree_s, degree_t):
    """A map whose coordinates are polynomials in s and t, and its derivatives."""
    coefficients = rng.uniform(-1, 1, (3, degree_s + 1, degree_t + 1))

    def value(s, t, ds=0, dt=0):
        found = []
        for c in coefficients:
            for _ in range(ds):
                c = np.polynomial.polynomial.polyder(c, axis=0)
            for _ in range(dt):
                c = np.polynomial.polynomial.polyder(c, axis=1)
            found.append(np.polynomial.polynomial.polyval2d(s, t, c))
        return np.stack(found, axis=-1)

    return value


@pytest.mark.parametrize(("lines_s", "lines_t"), [((), ()), ((4,), (3,)), ((3, 7), (2, 5)), ((2, 5, 8), (4,))])
@pytest.mark.parametrize("with_slopes", [False, True])
def test_boolean_sums_reproduce_tensor_products_that_each_direction_cannot_alone(lines_s, lines_t, with_slopes):
    """If P reproduces degree p and Q degree q, then P + Q - PQ reproduces any f(s) t^q + s^p g(t): here quartics."""
    rng = np.random.default_rng(5)
    s, t = geometric(11, ratio=1.15), geometric(8, ratio=0.9)
    p = min(3, 1 + len(lines_s) + 2 * with_slopes)
    q = min(3, 1 + len(lines_t) + 2 * with_slopes)
    one, two = tensor(rng, 4 if not with_slopes else 3, q), tensor(rng, p, 4 if not with_slopes else 3)

    def exact(a, b, ds=0, dt=0):
        return one(a, b, ds, dt) + two(a, b, ds, dt)

    u, v = np.meshgrid(s, t, indexing="ij")
    along_i = {k: exact(np.full(9, s[k]), t) for k in (0, *lines_s, 11)}
    along_j = {k: exact(s, np.full(12, t[k])) for k in (0, *lines_t, 8)}
    across_i, across_j = {}, {}
    if with_slopes:
        steps = {0: s[1] - s[0], 11: s[-1] - s[-2]}
        across_i = {k: step * exact(np.full(9, s[k]), t, ds=1) for k, step in steps.items()}
        steps = {0: t[1] - t[0], 8: t[-1] - t[-2]}
        across_j = {k: step * exact(s, np.full(12, t[k]), dt=1) for k, step in steps.items()}
    points = boolean_sum([Direction(s, along_i, across_i, True), Direction(t, along_j, across_j, True)])
    assert np.abs(points - exact(u, v)).max() < 1e-11
    for k, line in along_i.items():
        assert (points[k] == line).all() or np.abs(points[k] - line).max() < 1e-15  # corners belong to both
    for k, line in along_j.items():
        assert (points[:, k] == line).all()


@pytest.mark.parametrize("blending", ["arc length", "linear", "cubic"])
def test_lines_inside_are_kept_to_the_bit(blending):
    column, row, grid = crossing_lines()
    points = mc.transfinite(*WAVY, lines=[row, column], blending=blending).mesh.points[:, :, 0]
    assert (points[5] == column).all() and (points[:, 3] == row).all()
    for face, side in ((points[:, 0], WAVY[0]), (points[-1], WAVY[1]), (points[:, -1], WAVY[2]), (points[0], WAVY[3])):
        assert (face == side).all()
    assert not folded_cells(points).any()
    assert np.abs(points - grid).max() > 0.01  # they matter


def crossing_lines():
    """A line of constant i and one of constant j, other than those of the plain grid, which is returned too."""
    grid = mc.transfinite(*WAVY).mesh.points[:, :, 0]
    i, j = np.arange(13)[:, None], np.arange(9)[None]
    shift = 0.06 * np.sin(np.pi * i / 12) * np.sin(np.pi * j / 8)
    bent = grid + np.stack([shift, shift, 0 * shift], axis=-1)
    bent[0], bent[-1], bent[:, 0], bent[:, -1] = grid[0], grid[-1], grid[:, 0], grid[:, -1]
    return bent[5], bent[:, 3], grid


def test_lines_come_in_any_order_direction_and_form():
    column, row, _ = crossing_lines()
    expected = mc.transfinite(*WAVY, lines=[row, column]).mesh.points
    joined = gallery.joined(lines_through(column[::-1]), lines_through(row[::-1]))
    # Where they cross they share a point in the user's mesh or not: here not.
    assert (mc.transfinite(*WAVY, lines=joined).mesh.points == expected).all()
    mirror = np.array([-1.0, 1, 1])
    turned = mc.transfinite(*(side * mirror for side in WAVY), lines=[row * mirror, column * mirror]).mesh.points
    assert np.abs(turned[::-1] * mirror - expected).max() < 1e-12


@pytest.mark.parametrize("blending", ["arc length", "linear", "cubic"])
def test_sides_and_lines_are_resampled_to_meet_each_other(blending):
    column, row = np.array([[0.33, 0], [0.37, 0.6], [0.43, 1]]), np.array([[0, 0.52], [0.6, 0.6], [1, 0.71]])
    grid, _ = mc.transfinite(*ONE, lines=[column, row], cells_i=15, cells_j=10, blending=blending)
    points = grid.points[:, :, 0, :2]
    i = int(np.argmin(np.abs(points[:, 0, 0] - 0.33)))
    j = int(np.argmin(np.abs(points[0, :, 1] - 0.52)))
    assert np.abs(points[i, 0] - [0.33, 0]).max() < 1e-12 and np.abs(points[i, -1] - [0.43, 1]).max() < 1e-12
    assert np.abs(points[0, j] - [0, 0.52]).max() < 1e-12 and np.abs(points[-1, j] - [1, 0.71]).max() < 1e-12
    for line, known in ((points[i], column), (points[:, j], row)):
        assert max(nearest(point, np.asarray(known))[1] for point in line) < 1e-12


def two_blocks(blending="cubic", slopes=None, n=16):
    """A channel with a kink in its lines, in two blocks that meet at x = 1; the step across the shared side."""
    y = uniform(8)[:, None] * [0, 1.0] + [1, 0]
    shared = y + np.column_stack([0.2 * np.sin(np.pi * y[:, 1]), 0 * y[:, 1]])
    x = uniform(n)
    low = np.column_stack([x, 0.6 * x * (1 - x)])
    high = np.column_stack([x, 1 + 0.1 * x * (1 - x)])
    west = uniform(8)[:, None] * [0, 1.0]
    left = mc.transfinite(low, shared, high, west, blending=blending, slopes=slopes and {"east": slopes(n)})
    low = np.column_stack([1 + x, -0.6 * x * (1 - x)])
    high = np.column_stack([1 + x, 1 - 0.1 * x * (1 - x)])
    right = mc.transfinite(low, west + [2, 0], high, shared, blending=blending, slopes=slopes and {"west": slopes(n)})
    return left.mesh.points[:, :, 0], right.mesh.points[:, :, 0]


def kink(left, right):
    """Largest angle between the lines' derivatives on both sides of the interface, which are of the second order."""
    before = 1.5 * left[-1] - 2 * left[-2] + 0.5 * left[-3]
    after = -1.5 * right[0] + 2 * right[1] - 0.5 * right[2]
    sine = np.linalg.norm(np.cross(before, after), axis=1)
    return np.arctan2(sine, (before * after).sum(axis=1)).max(), before, after


def test_blocks_that_share_slopes_join_smoothly():
    """Slope continuity between blocks (survey 2.4.1): the kink goes with the cells, the slope is the given one."""

    def slopes(n):
        t = uniform(8)
        low, high = np.array([1 / n, -0.6 / n, 0]), np.array([1 / n, -0.1 / n, 0])
        return (1 - t)[:, None] * low + t[:, None] * high + np.outer(np.sin(np.pi * t) ** 2, [0, 0.2 / n, 0])

    assert kink(*two_blocks("arc length"))[0] > 0.1
    angles = []
    for n in (16, 32, 64):
        angle, before, after = kink(*two_blocks(slopes=slopes, n=n))
        angles.append(angle)
        assert np.abs(before - slopes(n)).max() < 0.5 / n**2 and np.abs(after - slopes(n)).max() < 0.5 / n**2
    assert angles[2] < 0.003 and angles[0] / angles[2] > 10  # second order


def test_cubic_blending_leaves_the_sides_at_right_angles():
    sides = [np.round(side, 9) for side in gallery.wavy_sides(96, 48)]

    def angle(blending):
        points = mc.transfinite(*sides, blending=blending).mesh.points[:, :, 0]
        step = (-1.5 * points[:, 0] + 2 * points[:, 1] - 0.5 * points[:, 2])[24:73]
        tangent = np.gradient(points[:, 0], axis=0)[24:73]
        cosine = (step * tangent).sum(axis=1) / np.linalg.norm(step, axis=1) / np.linalg.norm(tangent, axis=1)
        return np.degrees(np.abs(np.arcsin(cosine))).max()

    assert angle("arc length") > 20 and angle("cubic") < 0.3 * angle("arc length")


def test_slopes_follow_a_patch_that_is_turned():
    slopes = np.tile([0.1, 0.05, 0.0], (9, 1)), np.tile([0.02, 0.1, 0.0], (13, 1))
    mirror = np.array([-1.0, 1, 1])
    grid, _ = mc.transfinite(*WAVY, blending="cubic", slopes={"west": slopes[0], "south": slopes[1]})
    turned, report = mc.transfinite(
        *(side * mirror for side in WAVY),
        blending="cubic",
        slopes={"west": slopes[0] * mirror, "south": slopes[1] * mirror},
    )
    assert np.abs(turned.points[::-1] * mirror - grid.points).max() < 1e-12
    assert report.warnings == ["the sides run clockwise: i was reversed, and runs from east to west"]


def test_laws_and_single_spacings_of_sides():
    ones = [np.array(side, float) for side in ([[0, 0], [2, 0]], [[2, 0], [2, 1]], [[0, 1], [2, 1]], [[0, 0], [0, 1]])]
    grid, _ = mc.transfinite(*ones, cells_i=8, cells_j=6, law_i="geometric", spacing_west=0.05, law_j="cosine")
    steps = np.diff(grid.points[:, 0, 0, 0])
    assert steps[0] == pytest.approx(0.05) and np.ptp(steps[1:] / steps[:-1]) < 1e-9
    assert grid.points[0, 1, 0, 1] == pytest.approx(np.sin(np.pi / 12) ** 2)
    own = {"south": Spacing("poisson", first=0.1, last=0.4)}
    grid, _ = mc.transfinite(*ones, cells_i=8, cells_j=6, spacings=own)
    assert np.diff(grid.points[:, 0, 0, 0])[[0, -1]] == pytest.approx([0.1, 0.4])
    assert np.ptp(np.diff(grid.points[:, -1, 0, 0])) < 1e-12
    mirror = np.array([-1.0, 1])
    turned, _ = mc.transfinite(*(side * mirror for side in ones), cells_i=8, cells_j=6, spacings=own)
    assert np.abs(turned.points[::-1] * [-1, 1, 1] - grid.points).max() < 1e-12
    stretched = resampled(np.column_stack([ones[0], [0, 0]]), geometric(8, ratio=1.2))
    grid, _ = mc.transfinite(stretched, *ones[1:], cells_i=8, cells_j=2, law_i="copied")
    assert np.abs(grid.points[:, -1, 0, 0] - grid.points[:, 0, 0, 0]).max() < 1e-12


@pytest.mark.parametrize(
    ("keywords", "error", "parameter", "words"),
    [
        ({"lines": [[[0.5, 0], [0.5, 0.9]]]}, InvalidGeometry, "lines", "an end is 0.1 away"),
        ({"lines": [[[0.5, 0], [1, 0.5]]]}, InvalidGeometry, "lines", "does not connect opposite sides"),
        ({"lines": [[[0, 0], [1, 1]]]}, InvalidGeometry, "lines", "corner"),
        ({"lines": [[[0.4, 0], [0.6, 1]], [[0.6, 0], [0.4, 1]]]}, InvalidGeometry, "lines", "0 and 1 cross"),
        ({"lines": [[[0.5, 0], [0.5, 1]]], "cells_i": 1}, InvalidInput, "cells_i", "too few for 1 lines"),
        ({"lines": [[[float("nan"), 0], [0.5, 1]]]}, InvalidGeometry, "lines", "finite|nan"),
        ({"lines": [[[0.5, 0]]]}, InvalidGeometry, "lines", "two different points"),
        ({"slopes": {"west": np.zeros((5, 3))}}, InvalidInput, "slopes", "cubic"),
        ({"slopes": {"west": np.zeros((4, 3))}, "blending": "cubic"}, InvalidInput, "slopes", "4 vectors for 5 points"),
        ({"slopes": {"up": np.zeros((5, 3))}, "blending": "cubic"}, InvalidInput, "slopes", "'up' is no side"),
        ({"slopes": {"west": "steep"}, "blending": "cubic"}, InvalidInput, "slopes", "numbers"),
        ({"spacings": {"up": Spacing()}}, InvalidInput, "spacings", "'up' is no side"),
        ({"spacings": {"north": Spacing("geometric", first=2.0)}}, InvalidInput, "north", "less than 1"),
        ({"law_i": "cosine", "spacing_east": 0.1}, InvalidInput, "spacing_east", "no number of the law"),
        ({"law_i": "geometric", "spacing_east": 0.1, "spacing_west": 0.1}, InvalidInput, "spacing_west", "both given"),
        ({"law_j": "hyperbolic sine", "spacing_north": 0.9}, InvalidInput, "spacing_north", "does not fit"),
        ({"cure": "prayer"}, InvalidInput, "cure", "not one of"),
    ],
)
def test_bad_lines_slopes_and_spacings_get_a_clear_error(keywords, error, parameter, words):
    keywords = {"cells_i": 6, "cells_j": 4, **keywords}
    with pytest.raises(error, match=words) as caught:
        mc.transfinite(*ONE, **keywords)
    assert caught.value.parameter == parameter


def test_lines_that_pass_each_other_in_space_are_refused():
    column, row = np.array([[0.5, 0, 0], [0.5, 0.5, 0.2], [0.5, 1, 0]]), np.array([[0.0, 0.5, 0], [1, 0.5, 0]])
    with pytest.raises(InvalidGeometry, match="lines 0 and 1 pass each other at a distance of 0"):
        mc.transfinite(*ONE, lines=[column, row], cells_i=6, cells_j=4)


def test_a_line_between_two_points_of_a_side_needs_cells():
    sides = [resampled(np.column_stack([side, [0, 0]]), uniform(4)) for side in ONE]
    with pytest.raises(InvalidGeometry, match="line 0 ends between two points of south"):
        mc.transfinite(*sides, lines=[[[0.4, 0], [0.5, 1]]])
    grid, _ = mc.transfinite(*sides, lines=[[[0.5, 0], [0.4, 0.5], [0.5, 1]]])
    assert np.abs(grid.points[2, 2, 0] - [0.4, 0.5, 0]).max() < 1e-12


def test_a_patch_is_what_the_operation_makes():
    assert (Patch(*WAVY).points() == mc.transfinite(*WAVY).mesh.points[:, :, 0]).all()


def test_a_side_that_turns_back_on_itself_is_refused_without_a_warning():
    there_and_back = np.array([[0, 0], [0.6, 0], [0.4, 0], [0.6, 0], [1, 0]], float)
    with np.errstate(all="raise"), pytest.raises(mc.GenerationFailed):
        mc.transfinite(there_and_back, *ONE[1:], cells_i=4, cells_j=4, blending="cubic")
