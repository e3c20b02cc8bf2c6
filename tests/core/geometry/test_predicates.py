"""The exact predicates against determinants of whole numbers, where rounding would mislead."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshcore.errors import InvalidGeometry, InvalidInput
from meshcore.geometry import _predicates_kernels as kernels
from meshcore.geometry import predicates
from tests import naive

CASES = 100_000
DIMENSION = {"orient2d": 2, "incircle": 2, "orient3d": 3, "insphere": 3}
POINTS = {"orient2d": 3, "incircle": 4, "orient3d": 4, "insphere": 5}
each_predicate = pytest.mark.parametrize("name", DIMENSION)


def on_one_sphere(shape, rng):
    """Any centre and radius; coordinates are rounded."""
    n, _, dimension = shape
    direction = rng.normal(size=shape)
    direction /= np.linalg.norm(direction, axis=2, keepdims=True)
    return rng.random((n, 1, dimension)) + 10.0 ** rng.uniform(-6, 0, (n, 1, 1)) * direction


def on_a_small_lattice(shape, rng):
    """Many exact zeros, at several scales."""
    return rng.integers(0, 5, shape) * 10.0 ** rng.integers(-3, 3, (shape[0], 1, 1)).astype(float)


def nearly_flat(shape, rng):
    """On one line or plane, moved by a few units in the last place."""
    n, k, dimension = shape
    points = rng.random((n, 1, dimension))
    for _ in range(dimension - 1):
        points = points + rng.random((n, k, 1)) * rng.random((n, 1, dimension))
    return points * (1 + rng.integers(-2, 3, shape) * 2.0**-52)


def on_rounded_boxes(shape, rng):
    """Corners of boxes with rounded coordinates, half of them moved by a unit in the last place."""
    n, _, dimension = shape
    corners = rng.integers(0, 2, shape) * rng.random((n, 1, dimension)) + rng.random((n, 1, dimension))
    moved = rng.random((n, 1, 1)) < 0.5
    return corners * (1 + moved * rng.integers(-1, 2, shape) * 2.0**-52)


def of_mixed_scales(shape, rng):
    """Two points within a few units in the last place of each other, the rest far away (Kettner et al.)."""
    points = rng.random(shape)
    points[:, :2] = 12.0 + points[:, :2] * 2.0**-48
    points[:, 2:] *= 24
    return points


FAMILIES = (on_one_sphere, on_a_small_lattice, nearly_flat, on_rounded_boxes, of_mixed_scales)


def near_degenerate(name, count=CASES, seed=20240611):
    """(count, points, dimension): tests whose answer rounding would get wrong."""
    rng = np.random.default_rng(seed)
    shape = (count // len(FAMILIES), POINTS[name], DIMENSION[name])
    return np.concatenate([family(shape, rng) for family in FAMILIES])


def signs(name, tests):
    return getattr(predicates, name)(*np.moveaxis(tests, 1, 0))


@each_predicate
def test_a_hundred_thousand_near_degenerate_cases_are_exact(name):
    tests = near_degenerate(name)
    expected = getattr(naive, name)(tests)
    assert len(tests) == CASES
    assert min((expected == 0).sum(), (expected > 0).sum(), (expected < 0).sum()) > CASES / 50, "cases are not mixed"
    np.testing.assert_array_equal(signs(name, tests), expected)


@each_predicate
def test_rounding_would_have_misled(name):
    """The cases above are hard: the plain determinant gets many wrong."""
    tests = near_degenerate(name, 5000)
    expected = getattr(naive, name)(tests)
    moved = tests[:, :-1] - tests[:, -1:]
    if name in ("incircle", "insphere"):
        moved = np.concatenate([moved, (moved**2).sum(axis=2, keepdims=True)], axis=2)
    plain = np.sign(np.linalg.det(moved)) * (-1 if DIMENSION[name] == 3 else 1)
    assert (plain != expected).mean() > 0.01


@each_predicate
def test_slow_stages_alone_are_exact(name):
    """Stages B and C without the filter before them, and C without B, on easy cases too."""
    tests = np.concatenate([near_degenerate(name, 2000), np.random.default_rng(3).random((500, *shape_of(name)))])
    expected = getattr(naive, name)(tests)
    slow = getattr(kernels, f"{name}_exact")
    work = predicates.workspace()
    negative = -1 if DIMENSION[name] == 3 else 1
    for test, sign in zip(tests, expected, strict=True):
        assert np.sign(slow(*test.ravel(), work)) == sign
        for (row, column), a in np.ndenumerate(test[:-1]):
            kernels._set_entry(work, row, column, a, test[-1, column])
        assert np.sign(kernels._exact_determinant(work, len(test) - 1, DIMENSION[name])) == negative * sign


def shape_of(name):
    return POINTS[name], DIMENSION[name]


def with_products_of_roundings(name, count, side):
    """(k, POINTS, DIMENSION): cospherical sites of a grid whose coordinates are rounded."""
    rng = np.random.default_rng(12)
    sites = rng.integers(0, side, (count, *shape_of(name)))
    tests = np.linspace(0, 1, 46)[sites + rng.integers(0, 46 - side, (count, 1, DIMENSION[name]))]
    return tests[getattr(naive, name)(sites.astype(float)) == 0]


def with_tiny_volumes(count):
    """(count, 4, 3): whole coordinates around 2^50, and a volume of -1, 0 or 1 sixth."""
    rng = np.random.default_rng(14)
    tests = np.zeros((count, 4, 3))
    for k in range(count):
        rows = np.diag([1, 1, int(rng.integers(-1, 2))]).astype(object)
        while abs(rows).max() < 2**44:
            i, j = rng.permutation(3)[:2]
            rows[i] += int(rng.integers(-255, 256)) * rows[j]
            rows[:, j] += int(rng.integers(-7, 8)) * rows[:, i]
        tests[k, :3] = rows
    return tests


@pytest.mark.parametrize(
    ("name", "degree", "terms", "tests"),
    [
        ("orient3d", 3, 6, with_tiny_volumes(300)),
        ("incircle", 4, 12, with_products_of_roundings("incircle", 90_000, 6)),
        ("insphere", 5, 72, with_products_of_roundings("insphere", 40_000, 4)),
    ],
    ids=["orient3d", "incircle", "insphere"],
)
def test_integers_tell_signs_that_stage_b_cannot(name, degree, terms, tests):
    of_pairs, of_integers = getattr(kernels, f"_{name}_of_pairs"), getattr(kernels, f"_{name}_of_integers")
    negative = -1 if DIMENSION[name] == 3 else 1
    found = {-1: 0, 0: 0, 1: 0}
    for test, sign in zip(tests, getattr(naive, name)(tests), strict=True):
        rows = [kernels._difference(a, b) for point in test[:-1] for a, b in zip(point, test[-1], strict=True)]
        largest = max(abs(row[0]) for row in rows)
        if abs(of_pairs(*rows)) <= kernels.PAIR_BOUND * terms * largest**degree:
            by_integers = of_integers(*rows, *([largest] if name == "insphere" else []))
            assert np.sign(by_integers) == negative * sign or np.isnan(by_integers)
            found[sign] += not np.isnan(by_integers)
    assert min(found.values()) > 20, f"cases are not mixed: {found}"


@each_predicate
def test_swapping_two_points_turns_the_sign(name):
    """Two corners swapped negate every predicate; the last point of incircle and insphere is no corner."""
    tests = near_degenerate(name, 5000, seed=977)
    corners = POINTS[name] - (name in ("incircle", "insphere"))
    reference = signs(name, tests)
    for order in itertools.permutations(range(corners)):
        parity = round(np.linalg.det(np.eye(corners)[list(order)]))
        permuted = tests[:, [*order, *range(corners, POINTS[name])]]
        np.testing.assert_array_equal(signs(name, permuted), parity * reference)


@each_predicate
def test_a_power_of_two_changes_nothing(name):
    """Across nearly all of the doubles' range: each test is rescaled on its own."""
    tests = near_degenerate(name, 2000)
    tests = tests[(np.abs(tests) > 1e-12).all(axis=(1, 2)) | (tests == np.round(tests)).all(axis=(1, 2))]
    reference = signs(name, tests)
    powers = np.random.default_rng(8).integers(-960, 1010, len(tests))
    np.testing.assert_array_equal(signs(name, np.ldexp(tests, powers[:, None, None])), reference)


@each_predicate
def test_widest_allowed_spread_is_exact(name):
    """Coordinates from 2^-214 to 2^202 in one test, where expansions reach the ends of the doubles' range."""
    rng = np.random.default_rng(31)
    mantissa = rng.integers(-(2**53) + 2, 2**53, (2000, *shape_of(name)))
    exponent = np.where(rng.random(mantissa.shape) < 0.5, -214, 149)
    exponent[:, 0] = np.where(rng.random(exponent[:, 0].shape) < 0.5, 149, exponent[:, 0])
    mantissa[::3, 1], exponent[::3, 1] = mantissa[::3, 0] - 1, exponent[::3, 0]  # differences that cancel
    tests = np.ldexp(mantissa.astype(float), exponent)
    np.testing.assert_array_equal(signs(name, tests), getattr(naive, name)(tests))


whole = st.integers(-(2**20), 2**20)


@settings(deadline=None, max_examples=200)
@given(st.lists(st.tuples(whole, whole, whole), min_size=6, max_size=6), st.sampled_from(list(DIMENSION)))
def test_moving_all_points_changes_nothing(points, name):
    """Whole numbers move without rounding."""
    points = np.array(points, float)[:, : DIMENSION[name]]
    test, shift = points[None, : POINTS[name]], points[-1]
    assert signs(name, test) == signs(name, test + shift) == getattr(naive, name)(test)


coordinate = st.floats(-1e30, 1e30).filter(lambda x: x == 0 or abs(x) > 1e-30)


@settings(deadline=None, max_examples=300)
@given(st.data(), st.sampled_from(list(DIMENSION)))
def test_any_finite_points(data, name):
    points = data.draw(st.lists(coordinate, min_size=POINTS[name] * DIMENSION[name], max_size=15))
    test = np.array(points[: POINTS[name] * DIMENSION[name]]).reshape(1, *shape_of(name))
    assert signs(name, test) == getattr(naive, name)(test)


def test_conventions():
    assert predicates.orient2d([0, 0], [1, 0], [0, 1]) == 1
    assert predicates.incircle([1, 0], [0, 1], [-1, 0], [0, 0]) == 1
    assert predicates.orient3d([0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]) == 1
    tetra = [0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]
    assert predicates.insphere(*tetra, [0.1, 0.1, 0.1]) == 1


def test_arrays_are_broadcast_and_keep_their_shape():
    found = predicates.orient2d(np.zeros(2), np.ones((4, 1, 2)), np.random.default_rng(1).random((3, 2)))
    assert found.shape == (4, 3)
    assert found.dtype == np.int8
    assert predicates.orient2d(np.empty((0, 2)), np.zeros(2), np.ones(2)).shape == (0,)


@each_predicate
def test_bad_points_are_named(name):
    good = [np.random.default_rng(k).random((3, DIMENSION[name])) for k in range(POINTS[name])]
    function = getattr(predicates, name)
    for value in (np.nan, np.inf):
        bad = [p.copy() for p in good]
        bad[1][2, 0] = value
        with pytest.raises(InvalidGeometry, match="b: point 2 is") as caught:
            function(*bad)
        assert caught.value.points == (2,)
    with pytest.raises(InvalidInput, match=r"a: needs shape \(n, "):
        function(np.zeros((3, 4)), *good[1:])
    with pytest.raises(InvalidInput, match="a: needs numbers"):
        function("corner", *good[1:])
    with pytest.raises(InvalidInput, match=r"do not fit: a \(7, "):
        function(np.zeros((7, DIMENSION[name])), *good[1:])
    with pytest.raises(InvalidInput, match="too far apart"):
        function(*good[:-1], np.full(DIMENSION[name], 1e-200))


@pytest.mark.parametrize("scale", [1e-310, 1e-200, 1e-40, 1.0, 1e40, 1e200, 1e300])
def test_rescaled_is_exact_and_safe(scale):
    points = scale * np.random.default_rng(6).uniform(0.01, 1, (50, 3))
    safe, exponent = predicates.rescaled(points)
    np.testing.assert_array_equal(np.ldexp(safe, -exponent), points)
    assert (exponent == 0) == (1e-45 < scale < 1e60)
    assert np.abs(safe).max() < 2.0**predicates.HIGHEST_BIT
    grains = np.ldexp(safe, -predicates.LOWEST_BIT)
    np.testing.assert_array_equal(grains, np.round(grains))


def test_rescaled_keeps_zeros_and_empty_arrays():
    for points in (np.zeros((3, 2)), np.empty((0, 3))):
        safe, exponent = predicates.rescaled(points)
        assert exponent == 0
        np.testing.assert_array_equal(safe, points)


@pytest.mark.parametrize("small", [5e-324, 1e-200, 1e-120])
def test_rescaled_refuses_extreme_spreads(small):
    with pytest.raises(InvalidInput, match=r"too far apart .* set the small ones to zero"):
        predicates.rescaled(np.array([[1.0, small], [0.0, 3.0]]))


def test_rescaled_refuses_what_is_not_finite():
    with pytest.raises(InvalidGeometry, match="point 1 is") as caught:
        predicates.rescaled(np.array([[0.0, 1.0], [np.nan, 2.0]]))
    assert caught.value.points == (1,)


@each_predicate
def test_kernels_stay_in_their_workspace_on_any_number(name):
    """Coordinates that nobody rescaled: the answer may be wrong, memory stays untouched."""
    rng = np.random.default_rng(12)
    values = np.array([np.nan, np.inf, -np.inf, 1e308, -1.7e308, 5e-324, -3e-310, 1e200, 1e-200, 0.1, 0.3, 7.0])
    guarded = np.full(kernels.WORK_SIZE + 100, 77.0)
    rows = np.concatenate(
        [
            rng.choice(values, (3000, POINTS[name] * DIMENSION[name])),
            rng.uniform(-1, 1, (500, POINTS[name] * DIMENSION[name])) * 1.7e308,
            rng.choice([0.1, 0.2, 0.3], (500, POINTS[name] * DIMENSION[name])) * 2.0**205,
        ]
    )
    found = np.zeros(len(rows), np.int8)
    with np.errstate(all="ignore"):
        getattr(kernels, f"{name}_signs")(rows, found, guarded[: kernels.WORK_SIZE])
    assert (guarded[kernels.WORK_SIZE :] == 77.0).all()


@pytest.mark.parametrize("name", DIMENSION)
@pytest.mark.parametrize("quantum", [1.0, 2.0**-30, 2.0**40])
def test_determinants_on_a_grid_are_exact_in_doubles_up_to_the_limit_and_everywhere(name, quantum):
    dimension, count = DIMENSION[name], POINTS[name]
    rng = np.random.default_rng(7)
    # From grids whose determinants fit doubles to such as do not.
    size = 2.0 ** rng.integers(1, 27, (4000, 1, 1))
    cells = np.floor(rng.random((4000, count, dimension)) * size)
    tests = quantum * np.concatenate([cells, np.floor(cells / (size / 2))])
    work = predicates.workspace(quantum)
    found = np.zeros(len(tests), np.int8)
    getattr(kernels, f"{name}_signs")(np.ascontiguousarray(tests.reshape(len(tests), -1)), found, work)
    np.testing.assert_array_equal(found, getattr(naive, name)(tests))


@settings(max_examples=200)
@given(
    st.lists(st.tuples(st.integers(-(2**20), 2**20), st.integers(0, 19)), min_size=2, max_size=8), st.integers(-90, 90)
)
def test_the_quantum_divides_all_coordinates_and_is_the_largest_that_does(parts, scale):
    values = [n * 2**e for n, e in parts]
    points = np.ldexp(np.array([values, values], float), scale)[:, : len(values) // 2 * 2].reshape(-1, 2)
    used = [n for n in values[: len(values) // 2 * 2] if n]
    found = predicates.quantum_of(points)
    if not used:
        assert found == 0.0
        return
    largest = max(map(abs, used)).bit_length() - 1
    divides = [e for e in range(-4, 64) if all((n * 16) % 2 ** (e + 4) == 0 for n in used) and e <= largest]
    expected = max(divides) if max(divides) >= largest - 40 else None
    assert found == (0.0 if expected is None else 2.0 ** (expected + scale))
