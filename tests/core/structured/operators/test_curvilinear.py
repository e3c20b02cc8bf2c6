"""Finite differences on curved grids: orders, identities that hold to round-off, and what the survey says of grids."""

import numpy as np
import pytest

from meshcore import InvalidGeometry, InvalidInput, StructuredGrid
from meshcore.structured import Curvilinear
from tests import curved_grids as curved
from tests.curved_grids import inside, model, order, planar_model, rms

TOLERANCE = {2: 0.1, 4: 0.2}
PLANAR = (curved.smooth, curved.stretched, curved.skewed, curved.annulus)
SIZES = {2: (32, 48, 64, 96), 3: (16, 20, 24, 32)}
DIRECTION = np.array([1.0, -0.5, 0.7])


def fields(grid):
    """A scalar with its gradient and Laplacian, and a vector field with its divergence."""
    value, slope, laplacian = (planar_model if grid.is_surface else model)(grid.points)
    direction = DIRECTION * [1, 1, not grid.is_surface]
    return value, slope, laplacian, value[..., None] * direction, slope @ direction


def with_boundary(grid, values):
    """Values on the boundary, nan within."""
    known = values.copy()
    within = [slice(1, -1)] * (2 if grid.is_surface else 3)
    if grid.periodic[0]:
        within[0] = slice(None)
    known[tuple(within)] = np.nan
    return known


@pytest.mark.parametrize("p", [2, 4])
@pytest.mark.parametrize("mapping", [*PLANAR, *curved.VOLUMES])
def test_order_of_truncation(mapping, p):
    errors, whole, sizes = [], [], SIZES[3 if mapping in curved.VOLUMES else 2]
    for n in sizes:
        grid = curved.grid(mapping, n)
        value, slope, laplacian, vectors, divergence = fields(grid)
        operators = Curvilinear(grid, order=p)
        found = (
            operators.gradient(value) - slope,
            operators.divergence(vectors) - divergence,
            operators.laplacian(value) - laplacian,
        )
        errors.append([rms(inside(e)) for e in found])
        whole.append([rms(e) for e in found])
    for name, e, w in zip(
        ("gradient", "divergence", "laplacian"), np.transpose(errors), np.transpose(whole), strict=True
    ):
        assert order(sizes, e) == pytest.approx(p, abs=TOLERANCE[p]), name
        # One-sided differences may only converge faster while they are not in their asymptotic range yet.
        assert order(sizes, w) > p - TOLERANCE[p], name


@pytest.mark.parametrize("p", [2, 4])
@pytest.mark.parametrize("mapping", [curved.smooth, curved.skewed, curved.annulus, curved.shell])
def test_order_of_the_solution_of_poissons_equation(mapping, p):
    in_space = {2: (10, 12, 14, 16), 4: (6, 7, 8, 9)}[p]
    sizes = {curved.annulus: (24, 32, 40, 48), curved.shell: in_space}.get(mapping, (32, 48, 64, 80))
    errors = []
    for n in sizes:
        grid = curved.grid(mapping, n)
        value, _, laplacian, *_ = fields(grid)
        known = with_boundary(grid, value)
        solution = Curvilinear(grid, order=p).poisson(laplacian, known)
        np.testing.assert_array_equal(solution[np.isfinite(known)], value[np.isfinite(known)])
        errors.append(rms((solution - value)[np.isnan(known)]))
    assert order(sizes, errors) == pytest.approx(p, abs=TOLERANCE[p])


@pytest.mark.parametrize("p", [2, 4])
def test_beltramis_operator_on_a_sphere(p):
    """z is an eigenfunction of it, of eigenvalue -2, and its gradient is the upward vector less its normal part."""
    errors, sizes = [], SIZES[2]
    for n in sizes:
        grid = curved.grid(curved.sphere, n)
        operators, z = Curvilinear(grid, order=p), grid.points[..., 2]
        slope = np.array([0.0, 0.0, 1.0]) - z[..., None] * grid.points
        found = operators.gradient(z) - slope, operators.divergence(slope) + 2 * z, operators.laplacian(z) + 2 * z
        errors.append([rms(inside(e)) for e in found])
    for e in np.transpose(errors):
        assert order(sizes, e) == pytest.approx(p, abs=TOLERANCE[p])


@pytest.mark.parametrize("p", [2, 4])
@pytest.mark.parametrize("mapping", [*PLANAR, curved.sphere, *curved.VOLUMES])
def test_identities_of_the_metrics(mapping, p):
    operators = Curvilinear(curved.grid(mapping, 9), order=p)
    d = operators.dimension
    unit = np.eye(d).reshape(d, d, 1, 1, 1)
    dual = np.einsum("a...x,b...x->ab...", operators.contravariant, operators.covariant)
    np.testing.assert_allclose(dual, np.broadcast_to(unit, dual.shape), atol=1e-12)
    product = np.einsum("ab...,bc...->ac...", operators.metric, operators.inverse_metric)
    np.testing.assert_allclose(product, np.broadcast_to(unit, dual.shape), atol=1e-9)
    determinant = np.linalg.det(np.moveaxis(operators.metric, (0, 1), (-2, -1)))
    np.testing.assert_allclose(determinant, operators.jacobian**2, rtol=1e-9)


@pytest.mark.parametrize("p", [2, 4])
@pytest.mark.parametrize("mapping", [*PLANAR, *curved.VOLUMES])
def test_linear_functions_have_their_gradient_exactly(mapping, p):
    grid = curved.grid(mapping, 10)
    slope = DIRECTION * [1, 1, not grid.is_surface]
    found = Curvilinear(grid, order=p).gradient(grid.points @ slope)
    np.testing.assert_allclose(found, np.broadcast_to(slope, found.shape), atol=1e-11)


@pytest.mark.parametrize("p", [2, 4])
@pytest.mark.parametrize("mapping", [*PLANAR, *curved.VOLUMES])
def test_a_uniform_flow_is_kept_to_round_off(mapping, p):
    """Relative to the flux through a cell's faces over its volume, of which the divergence is the difference."""
    grid = curved.grid(mapping, 32)
    operators = Curvilinear(grid, order=p)
    flow = np.broadcast_to(DIRECTION * [1, 1, not grid.is_surface], grid.points.shape)
    flux = np.abs((operators.area_vectors * flow).sum(axis=-1)).max(axis=0) / np.abs(operators.jacobian)
    assert np.abs(operators.divergence(flow) / flux.max()).max() < 1e-12
    assert np.abs(operators.divergence(flow)).max() < 5e-11


def test_products_of_base_vectors_do_not_keep_a_uniform_flow_in_space():
    """Why area vectors are differences themselves (Thomas and Lombard)."""
    operators = Curvilinear(curved.grid(curved.bent_box, 16))
    products = operators.jacobian[..., None] * operators.contravariant
    closing = sum(operators.derivative(products[i], i) for i in range(3)) / operators.jacobian[..., None]
    assert np.abs(closing).max() > 1e-4
    kept = sum(operators.derivative(operators.area_vectors[i], i) for i in range(3)) / operators.jacobian[..., None]
    assert np.abs(kept).max() < 1e-11
    np.testing.assert_allclose(products, operators.area_vectors, atol=0.05 * np.abs(products).max())


@pytest.mark.parametrize("p", [2, 4])
@pytest.mark.parametrize("mapping", [curved.smooth, curved.annulus, curved.sphere, curved.bent_box])
def test_the_matrix_is_the_laplacian(mapping, p):
    grid = curved.grid(mapping, 8)
    operators = Curvilinear(grid, order=p)
    value = model(grid.points)[0]
    found = (operators.laplacian_matrix() @ value.ravel()).reshape(grid.shape)
    np.testing.assert_allclose(found, operators.laplacian(value), rtol=1e-9, atol=1e-9 * np.abs(found).max())


@pytest.mark.parametrize("mapping", [curved.smooth, curved.bent_box])
def test_the_order_of_indices_and_the_hand_of_the_grid_do_not_matter(mapping):
    grid = curved.grid(mapping, 10)
    value, _, _, vectors, _ = fields(grid)
    plain = Curvilinear(grid, order=4)
    turned = Curvilinear(StructuredGrid(grid.points[::-1].swapaxes(0, 1)[::-1][::-1]), order=4)
    assert np.sign(plain.jacobian.sum()) in (1, -1)
    back = lambda a: a.swapaxes(0, 1)[::-1]  # noqa: E731
    forth = lambda a: a[::-1].swapaxes(0, 1)  # noqa: E731
    np.testing.assert_allclose(back(turned.laplacian(forth(value))), plain.laplacian(value), rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(back(turned.gradient(forth(value))), plain.gradient(value), atol=1e-10)
    np.testing.assert_allclose(back(turned.divergence(forth(vectors))), plain.divergence(vectors), atol=1e-10)
    mirrored = Curvilinear(StructuredGrid(grid.points[::-1]), order=4)
    assert mirrored.jacobian.sum() * plain.jacobian.sum() < 0
    np.testing.assert_allclose(mirrored.laplacian(value[::-1])[::-1], plain.laplacian(value), rtol=1e-6, atol=1e-7)


def test_a_plane_of_any_attitude_is_as_the_plane():
    turn, _ = np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))
    grid = curved.grid(curved.smooth, 16)
    value, *_, vectors, _ = fields(grid)
    plain, turned = Curvilinear(grid), Curvilinear(StructuredGrid(grid.points @ turn.T + 3.0))
    np.testing.assert_allclose(turned.laplacian(value), plain.laplacian(value), rtol=1e-9, atol=1e-10)
    np.testing.assert_allclose(turned.gradient(value), plain.gradient(value) @ turn.T, atol=1e-12)
    np.testing.assert_allclose(turned.divergence(vectors @ turn.T), plain.divergence(vectors), atol=1e-11)


# ---- convection


@pytest.mark.parametrize("p", [2, 4])
def test_convection_on_a_moving_grid_keeps_its_order(p):
    """Points that move with W see d(rho)/dt + W . grad(rho), whatever their movement."""
    errors, sizes = [], SIZES[2]
    for n in sizes:
        grid = curved.grid(curved.smooth, n)
        density, slope, _ = planar_model(grid.points)
        x, y, _ = np.moveaxis(grid.points, -1, 0)
        velocity = np.stack([1 + y, 0.5 - x, 0 * x], axis=-1)  # without divergence
        moving = np.stack([np.sin(x * y), x**2, 0 * x], axis=-1)
        expected = 2.0 - ((velocity - moving) * slope).sum(axis=-1)
        found = Curvilinear(grid, order=p).convection(density, velocity, source=2.0, grid_velocity=moving)
        errors.append(rms(found - expected))
    assert order(sizes, errors) == pytest.approx(p, abs=TOLERANCE[p])


@pytest.mark.parametrize("p", [2, 4])
@pytest.mark.parametrize("mapping", [curved.smooth, curved.bent_box])
def test_a_uniform_flow_stays_on_any_moving_grid(mapping, p):
    grid = curved.grid(mapping, 16)
    moving = np.random.default_rng(2).normal(size=grid.points.shape) * [1, 1, not grid.is_surface]
    flow = np.broadcast_to(DIRECTION * [1, 1, not grid.is_surface], grid.points.shape)
    operators = Curvilinear(grid, order=p)
    rate = operators.convection(np.full(grid.shape, 3.0), flow, grid_velocity=moving)
    assert np.abs(rate).max() < 1e-12 * np.abs(operators.divergence(moving)).max() + 5e-11


def test_the_geometric_conservation_law_is_the_jacobians_rate():
    """dJ/dt = d(J a^i . W)/di, but for the truncation by which differences of products are not those of factors."""
    grid = curved.grid(curved.smooth, 16)
    x, y, _ = np.moveaxis(grid.points, -1, 0)
    moving = np.stack([np.sin(y), x * y, 0 * x], axis=-1)
    operators, step = Curvilinear(grid, order=4), 1e-4
    later, before = (Curvilinear(grid.with_points(grid.points + s * step * moving), order=4).jacobian for s in (1, -1))
    rate = operators.jacobian * operators.divergence(moving)
    np.testing.assert_allclose((later - before) / (2 * step), rate, atol=2e-3 * np.abs(rate).max())


# ---- what the survey says of grids (2.2)


@pytest.mark.parametrize("p", [2, 4])
def test_skewness_raises_the_coefficient_but_not_the_order(p):
    sizes, angles = (32, 48, 64, 96), (90, 45, 30, 20)
    errors = np.empty((len(angles), len(sizes)))
    for a, angle in enumerate(angles):
        for k, n in enumerate(sizes):
            t = np.linspace(0, 1, n + 1)
            grid = StructuredGrid(curved.skewed(*np.meshgrid(t, t, np.zeros(1), indexing="ij"), angle=angle))
            value, _, laplacian, *_ = fields(grid)
            errors[a, k] = rms(inside(Curvilinear(grid, order=p).laplacian(value) - laplacian))
        assert order(sizes, errors[a]) == pytest.approx(p, abs=TOLERANCE[p])
    coefficient = errors[:, -1] / errors[0, -1]
    assert (np.diff(coefficient) > 0).all()
    assert coefficient[-1] > 5


@pytest.mark.parametrize("growth, sign", [(1.1, 1), (1 / 1.1, -1)])
def test_variation_of_cell_size_acts_like_diffusion(growth, sign):
    """The central difference errs by x_ii / 2 times the second derivative: a diffusion, or with the other sign none."""
    x = np.cumsum(np.concatenate([[0.0], growth ** np.arange(20.0)]))
    grid = StructuredGrid(np.stack(np.meshgrid(x, np.arange(6.0), indexing="ij"), axis=-1))
    operators = Curvilinear(grid)
    density = grid.points[..., 0] ** 2
    flow = np.broadcast_to([1.0, 0.0, 0.0], grid.points.shape)
    error = operators.convection(density, flow) + 2 * grid.points[..., 0]
    second = grid.points[2:, ..., 0] - 2 * grid.points[1:-1, ..., 0] + grid.points[:-2, ..., 0]
    diffusion = error[1:-1] / 2  # over the second derivative of the density
    np.testing.assert_allclose(diffusion, -0.5 * second, rtol=1e-9)
    assert (sign * diffusion < 0).all()  # growing cells along the flow: anti-diffusion, which is unstable


# ---- bad input


def square(n=6):
    return curved.grid(curved.smooth, n)


@pytest.mark.parametrize(
    "wrong, error, text",
    [
        (
            lambda: Curvilinear(np.zeros((5, 5, 1, 3))),
            InvalidInput,
            "needs a StructuredGrid or",
        ),
        (lambda: Curvilinear(square(), order=3), InvalidInput, "is 3; the operators are of order 2 or 4"),
        (lambda: Curvilinear(square(3)), InvalidInput, "has 4 points along i; order 2 needs 5"),
        (lambda: Curvilinear(square(5), order=4), InvalidInput, "has 6 points along i; order 4 needs 7"),
        (lambda: Curvilinear(square()).gradient(np.zeros((2, 2, 1))), InvalidInput, r"needs shape \(7, 7, 1\)"),
        (lambda: Curvilinear(square()).gradient("no"), InvalidInput, "values: needs numbers"),
        (lambda: Curvilinear(square()).divergence(np.zeros((7, 7, 1, 2))), InvalidInput, r"needs shape \(7, 7, 1, 3\)"),
        (lambda: Curvilinear(square()).laplacian(np.full((7, 7, 1), np.nan)), InvalidInput, r"is nan at \(0, 0, 0\)"),
        (
            lambda: Curvilinear(square()).poisson(0, np.full((7, 7, 1), np.nan)),
            InvalidInput,
            "has no value on the boundary at",
        ),
        (lambda: Curvilinear(square()).poisson(0, np.full((7, 7, 1), np.inf)), InvalidInput, r"is inf at \(0, 0, 0\)"),
    ],
)
def test_bad_input_is_named(wrong, error, text):
    with pytest.raises(error, match=text):
        wrong()


def test_folded_grids_are_refused_with_their_points():
    points = square(8).points.copy()
    points[4, 4] = points[0, 0]
    with pytest.raises(InvalidGeometry, match="Jacobian that is zero or of the other sign") as caught:
        Curvilinear(StructuredGrid(points))
    assert len(caught.value.points)
    flat = points * [1, 0, 0]
    with pytest.raises(InvalidGeometry, match="does not fold or collapse"):
        Curvilinear(StructuredGrid(flat))


def test_a_periodic_grid_that_is_not_closed_is_refused():
    with pytest.raises(InvalidGeometry, match="periodic along i, but its last points are not where"):
        Curvilinear(StructuredGrid(square(8).points, periodic=(True, False, False)))


def test_values_given_at_either_side_of_a_cut_or_inside():
    """The first side of a cut counts; a value inside is kept, too."""
    grid = curved.grid(curved.annulus, 8)
    value = planar_model(grid.points)[0]
    known = with_boundary(grid, value)
    operators = Curvilinear(grid)
    plain = operators.poisson(0.0, known)
    known[-1] = np.nan
    np.testing.assert_array_equal(operators.poisson(0.0, known), plain)
    known[3, 4] = 7.0
    assert operators.poisson(np.zeros(grid.shape[:2]), known)[3, 4, 0] == 7.0


def test_values_of_a_surface_may_leave_out_its_layer():
    grid = square(8)
    value = model(grid.points)[0]
    np.testing.assert_array_equal(Curvilinear(grid).gradient(value[:, :, 0]), Curvilinear(grid).gradient(value))
