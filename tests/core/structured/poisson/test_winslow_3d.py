"""The elliptic equations in space: solver against its slow twin, known solutions, and what must hold of any grid."""

import numpy as np
import pytest

from meshcore import Cancelled, StructuredGrid, quality
from meshcore.structured.poisson import _winslow_3d_kernels as kernels
from meshcore.structured.poisson.winslow_3d import count_folded, solved
from tests import naive


def box(*cells):
    """Unit cube of so many cells."""
    return np.stack(np.meshgrid(*[np.linspace(0, 1, n + 1) for n in cells], indexing="ij"), axis=-1)


def bent(*cells):
    """A smoothly bent block without any symmetry."""
    u, v, w = np.moveaxis(box(*cells), -1, 0)
    return np.stack(
        [u + 0.1 * np.sin(2 * v + w), 0.8 * v + 0.15 * np.sin(3 * u) * w, 1.3 * w + 0.1 * np.cos(2 * u * v)], axis=-1
    )


def passage(n, m, twist=1.2):
    """A passage of n x n cells across and m along: twisted by so many radians, curved, with a bump."""
    u, v, w = np.moveaxis(box(n, n, m), -1, 0)
    p = (u - 0.5) * (1 + 0.3 * np.sin(np.pi * w))
    q = v - 0.5 + 0.15 * np.sin(2 * np.pi * u) * v
    a = twist * w
    x, y = p * np.cos(a) - q * np.sin(a), p * np.sin(a) + q * np.cos(a)
    return naive.filled_box(np.stack([x + 0.4 * np.sin(2 * w), y, 2.5 * w + 0.2 * u * np.sin(3 * v)], axis=-1))


def cylinder(n):
    """Sector of a hollow cylinder whose coordinates ln r, angle and height are harmonic."""
    u, v, w = np.moveaxis(box(n, n, n), -1, 0)
    r = 3.0**u
    return np.stack([r * np.cos(1.5 * v), r * np.sin(1.5 * v), w], axis=-1)


def shell(n):
    """Part of a spherical shell whose coordinates 1/r, longitude and ln tan(colatitude / 2) are harmonic."""
    u, v, w = np.moveaxis(box(n, n, n), -1, 0)
    r = 1 / (1 - 0.5 * u)
    colatitude = 2 * np.arctan(np.exp(-0.8 + 1.5 * w))
    return r[..., None] * np.stack(
        [np.sin(colatitude) * np.cos(1.2 * v), np.sin(colatitude) * np.sin(1.2 * v), -np.cos(colatitude)], axis=-1
    )


def test_the_defect_is_that_of_the_slow_twin():
    points = bent(4, 141, 5)  # more nodes along j than are dealt with at once
    control = np.random.default_rng(3).uniform(-0.8, 0.8, points.shape)
    for order in ((0, 1, 2), (2, 1, 0), (1, 0, 2)):
        turned = np.ascontiguousarray(points.transpose(*order, 3))
        rates = np.ascontiguousarray(control.transpose(*order, 3))
        x, r = np.moveaxis(turned, -1, 0).ravel(), np.zeros(turned.size)
        row, squares = np.empty(kernels.FIELDS * kernels.NODES), np.zeros(len(turned))
        flat = np.moveaxis(rates, -1, 0).ravel()
        kept = np.zeros(turned.shape[:3], np.uint8)
        kept[2:3, 1:4, 2] = 1
        kernels.defect(x, 0 * x, flat, kept.ravel(), turned.shape[:3], 1, len(turned) - 1, row, r, squares)
        expected = -naive.elliptic_defects(turned, rates)
        expected[kept == 1] = 0  # no unknowns
        np.testing.assert_allclose(np.moveaxis(r.reshape(3, *turned.shape[:3]), 0, -1), expected, atol=1e-15)
        assert abs(expected).max() > 1e-6


@pytest.mark.parametrize("strength", [0, 0.5])
def test_the_solution_is_that_of_the_slow_twin(strength):
    points = bent(4, 6, 5)
    control = strength * np.stack([np.sin(points[..., 1]), np.cos(points[..., 0]), points[..., 2] - 0.5], axis=-1)
    growth = -2 * np.arctanh(np.moveaxis(control, -1, 0) / 2)
    found, outcome = solved(points, growth=growth if strength else None, tolerance=1e-12)
    assert outcome.converged
    np.testing.assert_allclose(found, naive.elliptic_grid_3d(points, control), atol=1e-10)
    assert abs(found - points).max() > 1e-3


@pytest.mark.parametrize("exact", [cylinder, shell])
def test_known_solutions_are_met_with_second_order(exact):
    errors = []
    for n in (11, 22, 44):
        true = exact(n)
        found, outcome = solved(naive.filled_box(true), tolerance=1e-9)
        assert outcome.converged
        errors.append(abs(found - true).max())
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert ((orders > 1.85) & (orders < 2.15)).all(), orders


def test_affine_boxes_are_exact_from_any_start():
    matrix = np.array([[3, 0.4, -0.2], [0.1, 1, 0.5], [-0.3, 0.2, 0.5]])
    exact = box(17, 9, 30) @ matrix + 5
    start = exact.copy()
    start[1:-1, 1:-1, 1:-1] += 0.03 * np.random.default_rng(8).standard_normal(start[1:-1, 1:-1, 1:-1].shape)
    found, outcome = solved(start, tolerance=1e-13)
    assert outcome.residuals[-1] < 1e-12
    np.testing.assert_allclose(found, exact, atol=1e-11)


def test_constant_control_gives_a_geometric_law():
    ratio = 1.15
    growing = np.cumsum(np.r_[0, ratio ** np.arange(24)])
    growing /= growing[-1]
    for axis in range(3):
        lines = [np.linspace(0, 1, 21), np.linspace(0, 1, 18), np.linspace(0, 1, 15)]
        lines[axis] = growing
        exact = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1)
        start = exact.copy()
        start[1:-1, 1:-1, 1:-1] += 0.003
        growth = np.zeros((3, *start.shape[:3]))
        growth[axis] = np.log(ratio)
        found, outcome = solved(start, growth=growth, tolerance=1e-11)
        assert outcome.converged
        np.testing.assert_allclose(found, exact, atol=1e-9)


def test_the_passage_has_no_folded_hexahedron_and_converges_fast():
    start = passage(32, 48)
    found, outcome = solved(start, tolerance=1e-8)
    assert outcome.converged
    assert outcome.cycles <= 10
    assert (quality.measure(StructuredGrid(found), "scaled_jacobian") > 0).all()
    assert (found[[0, -1]] == start[[0, -1]]).all()
    assert (found[:, [0, -1]] == start[:, [0, -1]]).all()
    assert (found[:, :, [0, -1]] == start[:, :, [0, -1]]).all()


@pytest.mark.parametrize("make", [lambda: passage(24, 40), lambda: passage(20, 20, twist=0.3) * [1, 1, 20]])
def test_by_default_the_grid_is_within_a_thousandth_of_the_spacing(make):
    start = make()
    quick, outcome = solved(start)
    converged, _ = solved(start, tolerance=1e-12)
    spacing = np.min([np.linalg.norm(np.gradient(converged, axis=d), axis=-1) for d in range(3)], axis=0)
    assert outcome.converged
    assert (np.linalg.norm(quick - converged, axis=-1) / spacing).max() < 2e-3


def test_symmetric_input_gives_a_symmetric_grid():
    start = box(20, 16, 24)
    start[..., 2] += 0.3 * np.sin(np.pi * start[..., 0]) * np.sin(np.pi * start[..., 1]) ** 2 * (start[..., 2] - 0.5)
    found, _ = solved(start, tolerance=1e-12)
    for axis in range(3):
        mirrored = np.flip(found, axis=axis).copy()
        mirrored[..., axis] = 1 - mirrored[..., axis]
        np.testing.assert_allclose(mirrored, found, atol=1e-11)


def test_threads_do_not_change_a_bit():
    start = passage(30, 41)
    growth = np.full((3, *start.shape[:3]), 0.05)
    grids = [solved(start, growth=growth, threads=threads)[0] for threads in (1, 2, 5)]
    assert (grids[0] == grids[1]).all()
    assert (grids[0] == grids[2]).all()


def test_a_folded_start_unfolds():
    start = box(16, 16, 16)
    exact = start.copy()
    start[5:12, 5:12, 5:12] = start[5:12, 5:12, 5:12][::-1].copy()
    assert (quality.measure(StructuredGrid(start), "jacobian") < 0).any()
    found, outcome = solved(start, tolerance=1e-10)
    assert outcome.converged
    np.testing.assert_allclose(found, exact, atol=1e-8)


def test_thin_cells_at_a_wall_and_needles_converge():
    walls, needles = box(16, 16, 40), box(20, 20, 20)
    w = walls[..., 2] = 1 + np.tanh(5.5 * (walls[..., 2] - 1)) / np.tanh(5.5)  # the first cell is 2e-5 high
    walls[..., 2] = w + 0.15 * np.sin(np.pi * walls[..., 0]) * (1 - w)
    walls[..., 0] += 0.1 * np.sin(np.pi * walls[..., 1]) * np.sin(2 * w)
    needles[..., 0] += 0.2 * np.sin(np.pi * needles[..., 1]) * np.sin(2 * needles[..., 2])
    needles[..., 2] *= 1000
    for points in (walls, needles):
        for order in ((0, 1, 2), (2, 0, 1), (1, 2, 0)):
            start = naive.filled_box(np.ascontiguousarray(points.transpose(*order, 3)))
            found, outcome = solved(start, tolerance=1e-8)
            assert outcome.converged
            assert outcome.cycles <= 13
            assert count_folded(found) == 0


def test_a_rough_block_converges_by_shorter_corrections():
    rng = np.random.default_rng(0)
    centred = 2 * box(20, 20, 20) - 1
    way = centred / np.maximum(np.linalg.norm(centred, axis=-1, keepdims=True), 1e-30)
    size = 1 + sum(
        0.35 * rng.normal() * np.sin(way @ rng.normal(size=3) * rng.uniform(2, 6) + rng.uniform(0, 6)) for _ in range(4)
    )
    start = naive.filled_box(centred * np.clip(size, 0.2, 3)[..., None])
    _, outcome = solved(start, tolerance=1e-6, most=25)  # with whole corrections alone, the residual stays at 1e-3
    assert outcome.converged
    assert outcome.guarded > 0


@pytest.mark.parametrize("cells", [(2, 2, 2), (2, 9, 40), (1, 5, 5), (3, 2, 65), (15, 16, 17)])
def test_any_size_will_do(cells):
    exact = box(*cells)
    start = exact.copy()
    start[1:-1, 1:-1, 1:-1] += 0.02 / max(cells)
    found, outcome = solved(start, tolerance=1e-9)
    assert outcome.converged
    np.testing.assert_allclose(found, exact, atol=1e-9)


def test_far_from_the_origin_and_of_any_size_the_grid_is_the_same():
    start = passage(12, 20)
    found, _ = solved(start, tolerance=1e-9)
    for scale, shift in ((1e-30, 0.0), (1e30, 0.0), (1.0, 1e4)):
        moved, outcome = solved(start * scale + shift, tolerance=1e-9)
        assert outcome.converged
        np.testing.assert_allclose((moved - shift) / scale, found, atol=1e-8 if shift == 0 else 1e-7)


def test_progress_may_cancel():
    with pytest.raises(Cancelled):
        solved(passage(12, 12), progress=lambda fraction, message: False)
