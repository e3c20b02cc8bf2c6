"""Finite volumes on curved grids: orders, and balances that hold to round-off."""

import numpy as np
import pytest

from meshcore import InvalidGeometry, InvalidInput, StructuredGrid, quality
from meshcore.structured import FiniteVolumes
from tests import curved_grids as curved
from tests.curved_grids import cell_means, inside, model, order, planar_model, rms

TOLERANCE = {2: 0.1, 4: 0.2}
PLANAR = (curved.smooth, curved.stretched, curved.skewed, curved.annulus)
DIRECTION = np.array([1.0, -0.5, 0.7])


def on_the_sphere(points):
    """z, its surface gradient, and Beltrami's operator of it."""
    z = points[..., 2]
    return z, np.array([0.0, 0.0, 1.0]) - z[..., None] * points, -2 * z


def means(mapping, n):
    """Means over cells of a scalar, its gradient and Laplacian, and of a vector field and its divergence."""
    planar = mapping not in curved.VOLUMES
    functions = on_the_sphere if mapping is curved.sphere else planar_model if planar else model
    value, slope, laplacian = (cell_means(mapping, lambda p, k=k: functions(p)[k], n) for k in range(3))
    if mapping is curved.sphere:
        return value, slope, laplacian, slope, laplacian
    direction = DIRECTION * [1, 1, not planar]
    return value, slope, laplacian, value[..., None] * direction, slope @ direction


@pytest.mark.parametrize("p", [2, 4])
@pytest.mark.parametrize("mapping", [*PLANAR, curved.sphere, curved.passage])
def test_order_of_truncation(mapping, p):
    errors, whole, sizes = [], [], (10, 12, 16, 20) if mapping in curved.VOLUMES else (32, 48, 64, 80)
    for n in sizes:
        value, slope, laplacian, vectors, divergence = means(mapping, n)
        volumes = FiniteVolumes(curved.grid(mapping, n), order=p)
        found = (
            volumes.gradient(value) - slope,
            volumes.divergence(vectors) - divergence,
            volumes.laplacian(value) - laplacian,
        )
        errors.append([rms(inside(e)) for e in found])
        whole.append([rms(e) for e in found])
    for name, e, w in zip(
        ("gradient", "divergence", "laplacian"), np.transpose(errors), np.transpose(whole), strict=True
    ):
        assert order(sizes, e) == pytest.approx(p, abs=TOLERANCE[p]), name
        assert order(sizes, w) > p - TOLERANCE[p], name


def random_fields(grid):
    rng = np.random.default_rng(11)
    return rng.normal(size=grid.cell_shape), rng.normal(size=(*grid.cell_shape, 3))


def through_the_boundary(fluxes, periodic):
    """What flows out through all faces of the boundary; the two sides of a cut are none."""
    return sum(
        np.take(flux, -1, axis).sum() - np.take(flux, 0, axis).sum()
        for axis, flux in enumerate(fluxes)
        if not periodic[axis]
    )


@pytest.mark.parametrize("p", [2, 4])
@pytest.mark.parametrize("mapping", [*PLANAR, curved.sphere, *curved.VOLUMES])
def test_the_divergence_theorem_holds_to_round_off(mapping, p):
    """Whatever the fields: what flows out of a cell flows into the next one."""
    grid = curved.grid(mapping, 9)
    volumes = FiniteVolumes(grid, order=p)
    scalar, vectors = random_fields(grid)
    for fluxes, rate in (
        (volumes.fluxes(vectors), volumes.divergence(vectors)),
        (volumes.diffusive_fluxes(scalar), volumes.laplacian(scalar)),
    ):
        size = sum(np.abs(flux).sum() for flux in fluxes)
        total = (rate * volumes.volumes).sum()
        assert abs(total - through_the_boundary(fluxes, grid.periodic)) < 1e-14 * size
        assert abs(total) > 1e-3 * size / grid.n_cells  # it is not that nothing flows


@pytest.mark.parametrize("p", [2, 4])
@pytest.mark.parametrize("mapping", [*PLANAR, *curved.VOLUMES])
def test_a_uniform_flow_is_kept_to_round_off(mapping, p):
    grid = curved.grid(mapping, 24)
    volumes = FiniteVolumes(grid, order=p)
    flow = np.broadcast_to(DIRECTION * [1, 1, not grid.is_surface], (*grid.cell_shape, 3))
    assert np.abs(volumes.divergence(flow)).max() < 1e-12
    closed = volumes.gradient(np.ones(grid.cell_shape))
    assert np.abs(closed).max() < 1e-12


@pytest.mark.parametrize("p", [2, 4])
@pytest.mark.parametrize("mapping", [curved.smooth, curved.sphere, curved.passage])
def test_the_hand_of_the_grid_does_not_matter(mapping, p):
    grid = curved.grid(mapping, 9)
    scalar, vectors = random_fields(grid)
    plain, mirrored = FiniteVolumes(grid, order=p), FiniteVolumes(StructuredGrid(grid.points[::-1]), order=p)
    if mapping is not curved.sphere:  # whose sides are alike
        np.testing.assert_allclose(mirrored.volumes[::-1], -plain.volumes, rtol=1e-12)
    for name, values in (("gradient", scalar), ("laplacian", scalar), ("divergence", vectors)):
        expected = getattr(plain, name)(values)
        found = getattr(mirrored, name)(values[::-1])[::-1]
        np.testing.assert_allclose(found, expected, atol=1e-10 * np.abs(expected).max())


@pytest.mark.parametrize("mapping", [*PLANAR, *curved.VOLUMES])
def test_volumes_of_the_second_order_are_those_of_the_cells(mapping):
    grid = curved.grid(mapping, 9)
    expected = quality.measure(grid, "volume" if mapping in curved.VOLUMES else "area")
    found = FiniteVolumes(grid).volumes
    np.testing.assert_allclose(np.abs(found), np.abs(expected), rtol=1e-12)


@pytest.mark.parametrize("p", [2, 4])
@pytest.mark.parametrize("mapping, size", [(curved.annulus, 3 * np.pi), (curved.skewed, np.sqrt(0.5))])
def test_volumes_sum_to_the_whole_in_their_order(mapping, size, p):
    errors, sizes = [], (12, 16, 24, 32)
    for n in sizes:
        errors.append(abs(abs(FiniteVolumes(curved.grid(mapping, n), order=p).volumes.sum()) - size))
    if mapping is curved.skewed:
        assert max(errors) < 1e-12
    else:
        assert order(sizes, errors) == pytest.approx(p, abs=TOLERANCE[p])


# ---- moving grids


def shaken(grid, amount, seed=5):
    """The grid with every point moved at random; a closed one stays closed."""
    shift = np.random.default_rng(seed).normal(size=grid.points.shape) * [1, 1, not grid.is_surface]
    points = grid.points + amount * shift
    if grid.periodic[0]:
        points[-1] = points[0]
    return grid.with_points(points)


@pytest.mark.parametrize("mapping", [*PLANAR, *curved.VOLUMES])
def test_cells_grow_by_what_their_faces_sweep(mapping):
    grid = curved.grid(mapping, 9)
    moved = shaken(grid, 0.01)
    before, after = FiniteVolumes(grid), FiniteVolumes(moved)
    swept = before.balance(before.swept(moved))
    assert np.abs(swept).max() > 1e-2 * np.abs(before.volumes).max()
    np.testing.assert_allclose(before.volumes + swept, after.volumes, atol=1e-14)


@pytest.mark.parametrize("mapping", [curved.smooth, curved.annulus, curved.passage])
def test_a_uniform_density_stays_uniform_while_the_grid_moves(mapping):
    grid, density, step = curved.grid(mapping, 9), 3.0, 0.25
    for seed in range(3):
        moved = shaken(grid, 0.005, seed)
        volumes = FiniteVolumes(grid)
        swept = tuple(s / step for s in volumes.swept(moved))
        flow = np.broadcast_to(DIRECTION * [1, 1, not grid.is_surface], (*grid.cell_shape, 3))
        held = np.full(grid.cell_shape, density)
        rate = volumes.convection(held, flow, swept=swept)
        held = (held * volumes.volumes + step * rate) / FiniteVolumes(moved).volumes
        np.testing.assert_allclose(held, density, rtol=1e-11)
        grid = moved


def test_a_source_fills_the_cells():
    grid = curved.grid(curved.smooth, 8)
    volumes = FiniteVolumes(grid, order=4)
    rest = np.zeros((*grid.cell_shape, 3))
    np.testing.assert_allclose(volumes.convection(np.ones(grid.cell_shape), rest, source=2.0), 2 * volumes.volumes)


@pytest.mark.parametrize("p", [2, 4])
def test_convection_keeps_its_order(p):
    """d(rho)/dt = S - U . grad(rho) for a velocity without divergence."""

    def velocity(points):
        x, y, _ = np.moveaxis(points, -1, 0)
        return np.stack([1 + y, 0.5 - x, 0 * x], axis=-1)

    def rate(points):
        return 2.0 - (velocity(points) * planar_model(points)[1]).sum(axis=-1)

    errors, sizes = [], (32, 48, 64, 80)
    for n in sizes:
        volumes = FiniteVolumes(curved.grid(curved.smooth, n), order=p)
        density, flow, expected = (
            cell_means(curved.smooth, f, n) for f in (lambda p: planar_model(p)[0], velocity, rate)
        )
        found = volumes.convection(density, flow, source=2.0) / volumes.volumes
        errors.append(rms(inside(found - expected)))
    assert order(sizes, errors) == pytest.approx(p, abs=TOLERANCE[p])


def test_folded_cells_are_refused_with_their_numbers():
    points = curved.grid(curved.smooth, 8).points.copy()
    points[4, 4] = points[2, 4]
    grid = StructuredGrid(points)
    x, y = np.moveaxis(points[:, :, 0, :2], -1, 0)
    area = 0.5 * (
        (x[1:, 1:] - x[:-1, :-1]) * (y[:-1, 1:] - y[1:, :-1]) - (y[1:, 1:] - y[:-1, :-1]) * (x[:-1, 1:] - x[1:, :-1])
    )
    folded = np.flatnonzero(area.ravel(order="F") <= 0)
    with pytest.raises(InvalidGeometry, match="volume that is zero or of the other sign at 2 of 64 cells") as caught:
        FiniteVolumes(grid)
    assert sorted(caught.value.cells) == folded.tolist()


@pytest.mark.parametrize(
    "wrong, text",
    [
        (lambda g: FiniteVolumes(g).divergence(np.zeros((9, 9, 1, 3))), r"needs shape \(8, 8, 1, 3\), got"),
        (lambda g: FiniteVolumes(g, order=4).swept(g), "is 4; moving cells have straight edges"),
        (lambda g: FiniteVolumes(g).swept(curved.grid(curved.smooth, 9)), "has shape"),
        (lambda g: FiniteVolumes(g).swept(g.with_points(g.points + [0, 0, 1])), "out of a plane"),
        (lambda g: FiniteVolumes(curved.grid(curved.sphere, 8)).swept(g), "out of a plane"),
        (lambda g: FiniteVolumes(g.to_mesh()), "needs a StructuredGrid or a MultiBlock, got Mesh"),
    ],
)
def test_bad_input_is_named(wrong, text):
    with pytest.raises(InvalidInput, match=text):
        wrong(curved.grid(curved.smooth, 8))
