"""The planar Winslow solver: against its twin, known solutions, symmetry, threads, folds."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshcore.structured.algebraic.transfinite import interpolated
from meshcore.structured.poisson import _winslow_kernels, winslow_levels
from meshcore.structured.poisson.winslow import Frame, levels_of, smoothed_grid, winslow
from meshcore.structured.poisson.winslow_levels import Level, Table
from meshcore.threads import Workers
from tests import naive


def between(south, east, north, west, blending="linear"):
    """(ni, nj, 2) transfinite grid between planar sides."""
    spatial = [np.column_stack([side, np.zeros(len(side))]) for side in (south, east, north, west)]
    return interpolated(*spatial, blending=blending)[..., :2]


def wavy(ni, nj, height=0.15):
    s, t = np.linspace(0, 1, ni), np.linspace(0, 1, nj)
    south = np.column_stack([s, height * np.sin(2 * np.pi * s)])
    north = np.column_stack([s, 1 + height * np.sin(3 * np.pi * s)])
    west = np.column_stack([-height * np.sin(2 * np.pi * t), t])
    east = np.column_stack([1 + height * np.sin(2 * np.pi * t), t])
    return between(south, east, north, west)


def annulus(around, out, inner=1.0, outer=4.0, turn=2 * np.pi, radii=None):
    """Clockwise rays of evenly spaced points, or of given ones, from one circle to another."""
    angle = -np.linspace(0, turn, around + 1)
    angle[-1] = 0 if turn == 2 * np.pi else angle[-1]
    radii = np.linspace(inner, outer, out + 1) if radii is None else radii
    return radii[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)[:, None]


def star(rng, n, roughness=0.5):
    """Transfinite grid in a closed curve r(angle), with corners at quarters of its 4 n points."""
    angle = np.linspace(0, 2 * np.pi, 4 * n + 1)[:-1] + rng.uniform(0, 2 * np.pi)
    bumps = sum(
        roughness / k * (rng.normal() * np.cos(k * angle) + rng.normal() * np.sin(k * angle)) for k in range(1, 9)
    )
    radius = np.exp(np.clip(bumps, -1.5, 1.5))
    loop = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    loop = np.vstack([loop, loop[:1]])
    return between(loop[: n + 1], loop[n : 2 * n + 1], loop[2 * n : 3 * n + 1][::-1], loop[3 * n :][::-1])


def areas(points):
    """Signed areas of cells."""
    a, b = points[1:, 1:] - points[:-1, :-1], points[:-1, 1:] - points[1:, :-1]
    return 0.5 * (a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def distance(p, q):
    return float(np.linalg.norm(p - q, axis=-1).max())


# ---- against the twin


@pytest.mark.parametrize("shape", [(3, 3), (3, 9), (9, 4), (8, 11), (12, 10)])
def test_equals_relaxation_point_by_point(shape):
    start = wavy(*shape)
    solution = winslow(start, tolerance=1e-13)
    assert distance(solution.points, naive.winslow(start)) < 1e-11


@pytest.mark.parametrize("around", [12, 17])
def test_a_cyclic_grid_equals_relaxation(around):
    start = annulus(around, 9) * [1.3, 1.0] + np.array([0.4, 0.0]) * np.linspace(0, 1, 10)[:, None]
    found = winslow(start, cyclic=True, tolerance=1e-13).points
    assert distance(found, naive.winslow(start, cyclic=True)) < 1e-11
    assert (found[0] == found[-1]).all()


def test_control_functions_equal_relaxation():
    rng = np.random.default_rng(6)
    start, growth = wavy(10, 12), rng.uniform(-0.3, 0.3, (2, 10, 12))
    found = winslow(start, growth=growth, tolerance=1e-13).points
    assert distance(found, naive.winslow(start, growth)) < 1e-10


# ---- known solutions


@pytest.mark.parametrize("shape", [(4, 4), (33, 20), (50, 129)])
def test_parallelograms_become_uniform(shape):
    s, t = np.meshgrid(*(np.linspace(0, 1, n) for n in shape), indexing="ij")
    exact = np.stack([2 * s + 0.7 * t, 0.3 * s + t], axis=-1)
    start = exact + 0.3 * (s * (1 - s) * t * (1 - t))[..., None] * [1, -2]
    assert distance(winslow(start, tolerance=1e-12).points, exact) < 1e-11


def test_conformal_quadratics_are_exact():
    """Central differences are exact for z = w^2, and a conformal map solves the equations: the grid of w is found."""
    s, t = np.meshgrid(np.linspace(1, 2, 20), np.linspace(0.5, 1.5, 20), indexing="ij")
    exact = np.stack([s**2 - t**2, 2 * s * t], axis=-1)
    start = between(exact[:, 0], exact[-1], exact[:, -1], exact[0])
    start[1:-1, 1:-1] += 0.01 * np.random.default_rng(3).normal(size=(18, 18, 2))
    assert distance(winslow(start, tolerance=1e-12).points, exact) < 1e-10


def test_growth_of_a_rectangle_is_as_asked():
    """On straight sides of geometric spacing with that growth, the product grid is the discrete solution."""
    ni, nj = 24, 31
    x, y = (np.concatenate([[0], np.cumsum(np.exp(theta * np.arange(n - 1)))]) for theta, n in ((0.1, ni), (-0.2, nj)))
    exact = np.stack(np.meshgrid(x / x[-1], y / y[-1], indexing="ij"), axis=-1)
    start = exact + 0.0
    start[1:-1, 1:-1] = between(exact[:, 0], exact[-1], exact[:, -1], exact[0])[1:-1, 1:-1] * 0.9 + 0.05
    growth = np.empty((2, ni, nj))
    growth[0], growth[1] = 0.1, -0.2
    assert distance(winslow(start, growth=growth, tolerance=1e-12).points, exact) < 1e-10


def test_radii_of_the_annulus_converge_at_second_order():
    """The solution is conformal: radii are geometric, whatever the ratio of cells around to cells outwards."""
    errors = []
    for n in (16, 32, 64):
        found = winslow(annulus(2 * n, n), cyclic=True, tolerance=1e-11).points
        errors.append(np.abs(np.linalg.norm(found, axis=-1) - np.geomspace(1, 4, n + 1)).max())
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.abs(rates - 2).max() < 0.1


def test_corners_of_the_boundary_are_smoothed_away_inside():
    """Laplace's lines turn less than the boundary from the first on; those of transfinite interpolation do not."""
    n = 33
    s = np.linspace(0, 1, n)
    roof = np.column_stack([s, 0.4 * np.minimum(s, 1 - s)])
    east, west = np.column_stack([s * 0 + 1, s * 1.5]), np.column_stack([s * 0, s * 1.5])
    start = between(roof, east, np.column_stack([s, s * 0 + 1.5]), west)
    found = smoothed_grid(start)

    def corner(line):
        steps = line[n // 2 : n // 2 + 2] - line[n // 2 - 1 : n // 2 + 1]
        return np.ptp(np.arctan2(steps[:, 1], steps[:, 0]))

    turns = np.array([[corner(grid[:, j]) for j in (0, 4, 8)] for grid in (start, found)])
    assert turns[0, 1] > 0.8 * turns[0, 0]
    assert turns[1, 1] < 0.25 * turns[1, 0]


@pytest.mark.parametrize("seed", range(6))
def test_coarse_levels_that_collapse_do_not_lead_astray(seed):
    """A ring of a wide span has other solutions on few cells; rounding decides whether they are met."""
    start = annulus(120, 60, 1.0, 30.0) + [0.3, 0] * np.linspace(1, 0, 61)[:, None]
    start[1:-1, 1:-1] *= 1 + 1e-12 * np.random.default_rng(seed).standard_normal((119, 59, 2))
    solution = winslow(start, cyclic=True)
    assert np.isfinite(solution.history).all() and solution.converged
    assert (areas(solution.points) > 0).all()


# ---- how it stops


@pytest.mark.parametrize("case", ["wavy", "channel", "annulus"])
def test_by_default_within_a_thousandth_of_the_spacing(case):
    cyclic = case == "annulus"
    if case == "wavy":
        start = wavy(70, 97)
    elif case == "channel":
        s, t = np.linspace(0, 2, 80), np.geomspace(1e-3, 1, 64) - 1e-3
        bump = np.column_stack([s, 0.1 * np.exp(-25 * (s - 1) ** 2)])
        east, west = (np.column_stack([0 * t + x, y + t * (1 - y)]) for x, y in (bump[-1], bump[0]))
        east[-1, 1] = west[-1, 1] = 1
        start = between(bump, east, np.column_stack([s, 0 * s + 1]), west, "arc length")
    else:
        start = annulus(120, 60, 1.0, 30.0) + [0.3, 0] * np.linspace(1, 0, 61)[:, None]
    near, far = winslow(start, cyclic=cyclic), winslow(start, cyclic=cyclic, tolerance=1e-12)
    assert near.converged and len(near.history) < 9
    exact = far.points
    edges = [np.linalg.norm(np.diff(exact, axis=k), axis=-1) for k in (0, 1)]
    spacing = np.minimum.reduce([edges[0][1:, 1:-1], edges[0][:-1, 1:-1], edges[1][1:-1, 1:], edges[1][1:-1, :-1]])
    off = np.linalg.norm(near.points - exact, axis=-1)[1:-1, 1:-1] / spacing
    assert off.max() < 2e-3


def test_history_falls_to_the_tolerance():
    solution = winslow(wavy(65, 65), tolerance=1e-9)
    assert solution.converged and solution.history[0] == 1 and solution.history[-1] <= 1e-9
    assert len(solution.history) < 14


def test_too_few_cycles_are_told():
    assert not winslow(wavy(65, 65), tolerance=1e-10, most_cycles=2).converged


def test_a_solution_stays_as_it_is():
    s, t = np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 9), indexing="ij")
    start = np.stack([s, t], axis=-1)
    assert (winslow(start).points == start).all()


# ---- invariances


def test_boundary_is_kept_to_the_bit():
    start = wavy(40, 21) * 1e3 + 7
    found = smoothed_grid(start)
    for side in np.s_[0, :], np.s_[-1, :], np.s_[:, 0], np.s_[:, -1]:
        assert (found[side] == start[side]).all()


@settings(max_examples=20)
@given(st.floats(0, 6.3), st.floats(1e-6, 1e6), st.floats(-10, 10))
def test_moves_with_the_boundary(angle, scale, shift):
    c, s = np.cos(angle), np.sin(angle)
    turn = scale * np.array([[c, -s], [s, c]])
    start = wavy(20, 17)
    found = winslow(start, tolerance=1e-12).points
    moved = winslow(start @ turn.T + shift, tolerance=1e-12).points
    assert distance(moved, found @ turn.T + shift) < 1e-9 * scale + 1e-10 * abs(shift)


def test_symmetric_boundaries_have_symmetric_grids():
    n = 41
    s = np.linspace(-1, 1, n)
    south = np.column_stack([s, 0.3 * np.cos(2 * s)])
    north = np.column_stack([s, 1.5 + 0.2 * np.cos(3 * s)])
    t = np.linspace(0, 1, 30)[:, None]
    east = (1 - t) * south[-1] + t * north[-1]
    start = between(south, east, north, east * [-1, 1])
    found = winslow(start, tolerance=1e-11).points
    assert distance(found, found[::-1] * [-1, 1]) < 1e-9
    turned = winslow(np.ascontiguousarray(start.swapaxes(0, 1)), tolerance=1e-11).points
    assert distance(found, turned.swapaxes(0, 1)) < 1e-9


def test_any_number_of_threads_gives_the_same_bits(monkeypatch):
    monkeypatch.setattr(winslow_levels, "POINTS_A_THREAD", 200)
    for start, cyclic in ((wavy(301, 210), False), (annulus(240, 300), True)):
        one = winslow(start, cyclic=cyclic, tolerance=1e-8, threads=1).points
        for threads in (2, 3, 5):
            assert np.array_equal(winslow(start, cyclic=cyclic, tolerance=1e-8, threads=threads).points, one)


def test_workers_do_all_rows_once():
    with Workers(4) as four:
        seen: list[tuple[int, int]] = []
        for last in (2, 30, 33, 500):
            seen.clear()
            four.run(lambda a, b: seen.append((a, b)), 1, last, grain=16)
            stops = sorted(seen)
            assert stops[0][0] == 1 and stops[-1][1] == last
            assert all(a[1] == b[0] and (b[0] - 1) % 16 == 0 for a, b in itertools.pairwise(stops))


# ---- folds


def test_random_stars_are_not_folded():
    """The extremum principle, as far as the discrete equations have it."""
    rng = np.random.default_rng(20)
    folded = 0
    for _ in range(300):
        start = star(rng, 24)
        solution = winslow(start)
        assert solution.converged
        folded += bool((areas(start) <= 0).any())
        assert (areas(solution.points) > 0).all()
    assert folded > 30  # of transfinite interpolation


def test_boundaries_that_make_smoothing_go_in_circles():
    """Lines solved with coefficients that change on the way can go to and fro between grids: shorter steps settle."""
    rng = np.random.default_rng(20)
    for number in range(1912):
        start = star(rng, 16)
        if number in (492, 703, 1043, 1642, 1866, 1911):
            solution = winslow(start)
            assert solution.converged
            assert (areas(solution.points) > 0).all()


# ---- parts


@pytest.mark.parametrize("along_i", [False, True])
def test_smoothing_makes_the_share_of_the_steps_that_is_asked(along_i):
    start = Frame.of(wavy(12, 9)).inside(wavy(12, 9))
    still = np.zeros((2, 1, start.shape[2]))
    found = []
    for step in (0.0, 0.5, 1.0):
        r, rows = start.copy(), np.empty((4, start.shape[2]))
        work = np.empty(_winslow_kernels.RECORD * max(start.shape))
        if along_i:
            _winslow_kernels.smooth_along_i(r, still, still, 0, False, step, work, 1, r.shape[2] - 1)
        else:
            _winslow_kernels.smooth_along_j(r, still, still, 0, step, rows, work, 1, r.shape[1] - 1)
        found.append(r)
    assert np.array_equal(found[0], start)
    assert np.abs(0.5 * (found[0] + found[2]) - found[1]).max() < 1e-15 < np.abs(found[2] - start).max()


@pytest.mark.parametrize(("fine", "coarse"), [(16, 8), (17, 9), (9, 5), (8, 8)])
@pytest.mark.parametrize("cyclic", [False, True])
def test_transfer_keeps_constants_and_lines(fine, coarse, cyclic):
    table = Table(fine, coarse, cyclic)
    for (left, share), nodes, other in (
        (table.to_coarse, np.arange(coarse + 1) * table.ratio, np.arange(fine + 1.0)),
        (table.to_fine, np.arange(fine + 1) / table.ratio, np.arange(coarse + 1.0)),
    ):
        assert np.abs(share * other[left] + (1 - share) * other[left + 1] - nodes).max() < 1e-12
    nodes, weights = table.hats
    assert np.abs(weights.sum(axis=1) - 1).max() < 1e-14
    inside = np.arange(1, coarse) if not cyclic else np.arange(2, coarse - 1)
    assert np.abs((weights * nodes).sum(axis=1) - np.arange(coarse + 1) * table.ratio)[inside].max() < 0.3


@pytest.mark.parametrize("cyclic", [False, True])
def test_a_sweep_of_lines_solves_its_last_lines(cyclic):
    """After lines along i, the equations frozen before hold on the even columns: a linear problem is solved there."""
    start = annulus(14, 9) if cyclic else wavy(15, 10)
    frame = Frame.of(start)
    with Workers(1) as one:
        level: Level = levels_of(frame.inside(start), cyclic, one).levels[0]
        n = level.r.shape[1]
        for _ in range(200):
            level.smooth()
        level.find_defect()
        assert np.abs(level.d[:, 1 : n - 1, 1:-1]).max() < 1e-12
