"""Differences on cuts: the same as inside, to round-off and in their order, in any orientation."""

from dataclasses import replace

import numpy as np
import pytest

from meshcore import Cut, InvalidInput, MultiBlock, StructuredGrid
from meshcore.structured import Curvilinear
from meshcore.structured.operators.joined_lines import on_boundary
from tests.core.structured.operators.test_curvilinear import order
from tests.curved_grids import model, rms
from tests.cut_grids import c_shape, h_cylinder, parabolic, quarter_turned, ring


def fields(points):
    x, y = points[..., 0], points[..., 1]
    return np.sin(0.7 * x + 0.4 * y), np.stack([np.cos(0.5 * y), 0.3 * x * y, 0 * x], axis=-1)


def results(operators, values, vectors):
    return operators.gradient(values), operators.divergence(vectors), operators.laplacian(values)


def close(a, b):
    assert np.abs(a - b).max() <= 1e-11 * max(np.abs(b).max(), 1)


@pytest.mark.parametrize("p", [2, 4])
def test_a_ring_joined_by_a_cut_is_a_periodic_ring(p):
    periodic = ring(16, 7)
    cut = replace(periodic, periodic=(False,) * 3, cuts=periodic.joins)
    given = fields(periodic.points)
    for a, b in zip(results(Curvilinear(cut, p), *given), results(Curvilinear(periodic, p), *given), strict=True):
        close(a, b)


@pytest.mark.parametrize("p", [2, 4])
def test_on_the_wake_of_a_c_grid_it_is_as_inside_a_plain_grid(p):
    grid = c_shape(18, 16, 14, bend=0.01)
    s = 2.0 / 8 * np.arange(8, 27)
    t = np.linspace(0, 1.5, 15)
    plain = StructuredGrid(parabolic(s, np.concatenate([-t[:0:-1], t]), bend=0.01))
    on_cut = results(Curvilinear(grid, p), *fields(grid.points))
    inside = results(Curvilinear(plain, p), *fields(plain.points))
    for a, b in zip(on_cut, inside, strict=True):
        # Within six points of the trailing edge, i = 18 and 34, and of the outer sides, stencils differ by nature.
        close(a[34 + 6 : 47, :8], b[6:13, 14:22])
        close(a[18 - 6 : 5 : -1, :8], b[6:13, 14:6:-1])


@pytest.mark.parametrize("p", [2, 4])
@pytest.mark.parametrize("turn", range(4))
def test_blocks_in_any_orientation_are_one_grid(turn, p):
    blocks = quarter_turned(turn, 7, bend=0.5)
    second = np.rot90(blocks.blocks[1].points, -turn)
    whole = StructuredGrid(np.concatenate([blocks.blocks[0].points, second[1:]]))
    given = [fields(block.points) for block in blocks.blocks]
    found = results(Curvilinear(blocks, p), *map(list, zip(*given, strict=True)))
    for parts, expected in zip(found, results(Curvilinear(whole, p), *fields(whole.points)), strict=True):
        close(np.concatenate([parts[0], np.rot90(parts[1], -turn)[1:]]), expected)
    sources = [values for values, _ in given]
    matrix = Curvilinear(blocks, p).laplacian_matrix() @ np.concatenate([s.ravel() for s in sources])
    close(matrix, np.concatenate([v.ravel() for v in found[2]]))


@pytest.mark.parametrize("p", [2, 4])
@pytest.mark.parametrize("axes", [(1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0)])
def test_volumes_in_any_orientation_are_one_grid(axes, p):
    u, v, w = np.meshgrid(np.arange(15.0), np.arange(7.0), np.arange(8.0), indexing="ij")
    points = np.stack([u + 0.3 * np.sin(0.5 * v), v + 0.2 * np.cos(w), w + 0.2 * np.sin(0.4 * u)], axis=-1)
    first, second = points[:8], points[7:]
    # The second block has its axes in another order, the last of them backwards where that keeps the hand.
    back = 1 if axes in ((1, 2, 0), (2, 0, 1)) else -1
    turned = second.transpose(*axes, 3)[:, :, ::back]

    def place(at):
        there = [at[a] for a in axes]
        there[2] = there[2] if back > 0 else turned.shape[2] - 1 - there[2]
        return np.array(there)

    steps = [place(np.eye(3, dtype=int)[a]) - place(np.zeros(3, int)) for a in range(3)]
    transform = tuple(int(step @ [1, 2, 3]) for step in steps)
    cut = Cut(((7, 0, 0), (7, 6, 7)), (tuple(place((0, 0, 0))), tuple(place((0, 6, 7)))), transform, 0, 1)
    blocks = MultiBlock((StructuredGrid(first), StructuredGrid(turned)), cuts=(cut,))
    value = [model(b.points)[0] for b in blocks.blocks]
    vectors = [v[..., None] * [1, -0.5, 0.7] for v in value]
    whole = Curvilinear(StructuredGrid(points), p)
    expected = results(whole, model(points)[0], model(points)[0][..., None] * [1, -0.5, 0.7])
    for parts, one in zip(results(Curvilinear(blocks, p), value, vectors), expected, strict=True):
        again = np.moveaxis(parts[1][:, :, ::back], (0, 1, 2), axes)
        close(np.concatenate([parts[0], again[1:]]), one)


def with_known_boundary(grid, values):
    blocks = grid.blocks if isinstance(grid, MultiBlock) else (grid,)
    marks = on_boundary([b.shape for b in blocks], grid.joins)
    return [np.where(mark, value, np.nan) for mark, value in zip(marks, values, strict=True)]


def solved(grid, p, answer, given=lambda points: np.zeros(points.shape[:3], bool)):
    """Root mean square of the error of Laplace's equation, values on the boundary given, and where ``given`` says."""
    blocks = grid.blocks if isinstance(grid, MultiBlock) else (grid,)
    exact = [answer(block.points) for block in blocks]
    known = with_known_boundary(grid, exact)
    known = [np.where(given(b.points), e, k) for b, e, k in zip(blocks, exact, known, strict=True)]
    found = Curvilinear(grid, p).poisson(0.0, known if isinstance(grid, MultiBlock) else known[0])
    found = found if isinstance(grid, MultiBlock) else [found]
    return rms(np.concatenate([(f - e).ravel() for f, e in zip(found, exact, strict=True)]))


def flow(points):
    """Potential of the flow past the unit cylinder."""
    z = points[..., 0] + 1j * points[..., 1]
    return (z + 1 / z).real


def at_the_tail(points):
    return np.hypot(points[..., 0] - 1, points[..., 1]) < 1.6


def at_both_ends(points):
    return np.hypot(np.abs(points[..., 0]) - 1, points[..., 1]) < 1.6


SIZES = (12, 16, 24, 32)


@pytest.mark.parametrize("p", [2, 4])
def test_potential_flow_on_an_o_grid_with_a_cut_converges_in_the_order_of_the_formula(p):
    grids = [ring(4 * n, n) for n in SIZES]
    errors = [solved(replace(g, periodic=(False,) * 3, cuts=g.joins), p, flow) for g in grids]
    assert order(SIZES, errors) > p - 0.3


@pytest.mark.parametrize("p", [2, 4])
def test_potential_flow_on_a_c_grid_converges_in_the_order_of_the_formula(p):
    sizes = (24, 32, 40, 48)
    grids = [c_shape(n, 2 * n, n, bend=0.02) for n in sizes]
    # Where a round wall meets the wake the grid itself is singular: no formula keeps its order there.
    assert order(sizes, [solved(grid, p, flow, at_the_tail) for grid in grids]) > p - 0.3
    errors = [solved(grid, p, flow) for grid in grids]
    assert order(sizes, errors) > 1.1 and errors[-1] < 5e-3


@pytest.mark.parametrize("p", [2, 4])
def test_potential_flow_on_an_h_grid_converges_in_the_order_of_the_formula(p):
    grids = [h_cylinder(n, bend=0.02) for n in SIZES]
    # Where the round wall meets the cuts, ahead and behind, the grid is singular, as the C-grid is at its tail.
    assert order(SIZES, [solved(grid, p, flow, at_both_ends) for grid in grids]) > p - 0.3
    errors = [solved(grid, p, flow) for grid in grids]
    assert order(SIZES, errors) > 1.1 and errors[-1] < 2e-3


@pytest.mark.parametrize("p", [2, 4])
def test_on_the_cuts_of_an_h_grid_it_is_as_inside_a_plain_grid(p):
    n = 16
    grid = h_cylinder(n, bend=0.02)
    lower, upper = (block.points for block in grid.blocks)
    given = [fields(block.points) for block in grid.blocks]
    found = results(Curvilinear(grid, p), *map(list, zip(*given, strict=True)))
    for part in (slice(0, n + 1), slice(3 * n, None)):  # ahead of the cylinder, and behind it
        plain = StructuredGrid(np.concatenate([lower[part], upper[part, 1:]], axis=1))
        for on_cut, inside in zip(found, results(Curvilinear(plain, p), *fields(plain.points)), strict=True):
            # Within six points of the cylinder and of the outer sides stencils differ by nature.
            middle, whole = slice(6, n - 5), np.concatenate([on_cut[0][part], on_cut[1][part, 1:]], axis=1)
            close(whole[middle], inside[middle])
            close(on_cut[0][part][middle, -1], on_cut[1][part][middle, 0])


def test_the_boundary_is_what_no_cut_joins():
    grid = c_shape(6, 10, 4)
    (mark,) = on_boundary([grid.shape], grid.joins)
    assert mark[6:17, 0].all() and not mark[1:6, 0].any() and not mark[17:-1, 0].any() and mark[0].all()


def test_values_of_blocks_are_checked():
    operators = Curvilinear(quarter_turned(1, 7))
    with pytest.raises(InvalidInput, match="one a block"):
        operators.gradient([np.zeros((9, 8, 1))])
    with pytest.raises(InvalidInput, match=r"values\[1\]"):
        operators.gradient([np.zeros((9, 8, 1)), np.zeros((3, 3, 1))])
