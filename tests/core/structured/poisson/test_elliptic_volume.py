"""Elliptic volume: cages, control by the boundary's spacing, smooth faces, and bad input."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import GenerationFailed, InvalidGeometry, InvalidInput, Mesh, StructuredGrid, gallery, quality
from meshcore.structured.algebraic.blending import blended
from meshcore.structured.poisson.control_functions import from_boundary
from tests import naive


def box(*cells):
    """Unit cube of so many cells."""
    return np.stack(np.meshgrid(*[np.linspace(0, 1, n + 1) for n in cells], indexing="ij"), axis=-1)


def surface_of(points):
    """The cage around a block."""
    return StructuredGrid(points).to_mesh().boundary.compacted()


def same_boundary(a, b):
    """Whether the six faces of two blocks are the same to the last bit."""
    return all((np.moveaxis(a, d, 0)[e] == np.moveaxis(b, d, 0)[e]).all() for d in range(3) for e in (0, -1))


def test_filling_is_the_boolean_sum():
    points = box(4, 5, 6) + 0.1 * np.random.default_rng(5).standard_normal((5, 6, 7, 3))
    np.testing.assert_allclose(blended(points, (0, 1, 2)), naive.filled_box(points), atol=1e-15)
    assert same_boundary(blended(points, (0, 1, 2)), points)


def test_a_grid_its_hexahedra_and_its_surface_have_the_same_result():
    start = naive.filled_box(np.sin(box(6, 7, 8)) + 0.2 * box(6, 7, 8)[..., ::-1] ** 2)
    one, _ = mc.elliptic_volume(StructuredGrid(start), residual=1e-10)
    for other in (StructuredGrid(start).to_mesh(), surface_of(start)):
        same, _ = mc.elliptic_volume(other, residual=1e-10)
        np.testing.assert_allclose(same.points, one.points, atol=1e-10)  # starts differ by rounding
        assert same_boundary(same.points, start)
    assert same_boundary(one.points, start)


def test_a_dented_box_is_filled_where_its_start_is_folded():
    block, _ = mc.transfinite_volume(gallery.dented_box(12, depth=0.7))
    block = block.points.copy()
    block[:, :, 0, 2] += 0.25 * np.sin(2 * np.pi * block[:, :, 0, 0]) * np.sin(np.pi * block[:, :, 0, 1]) ** 2
    start = blended(block, (0, 1, 2))
    grid, report = mc.elliptic_volume(StructuredGrid(start))
    assert report.converged
    assert quality.measure(grid, "scaled_jacobian").min() > 0.05
    assert report.counts == {"points": 13**3, "hexahedra": 12**3}


def test_laplace_evens_spacing_out_and_control_carries_it_inside():
    heights = np.cumsum(np.r_[0, 1.25 ** np.arange(20)])
    heights /= heights[-1]
    points = box(12, 10, 20)
    points[..., 2] = heights
    points[..., 2] += 0.1 * np.sin(np.pi * points[..., 0]) * (1 - points[..., 2])
    grids = {c: mc.elliptic_volume(StructuredGrid(points), control=c)[0].points for c in ("none", "boundary spacing")}
    first = {name: np.linalg.norm(grid[6, 5, 1] - grid[6, 5, 0]) for name, grid in grids.items()}
    assert first["none"] > 2 * heights[1]
    assert abs(first["boundary spacing"] / heights[1] - 1) < 0.3
    straight = box(12, 10, 20)
    straight[..., 2] = heights
    exact, _ = mc.elliptic_volume(StructuredGrid(straight), control="boundary spacing", residual=1e-9)
    np.testing.assert_allclose(exact.points, straight, atol=1e-9)


def test_control_functions_of_your_own():
    points = box(8, 9, 10)
    rate = -2 * np.tanh(np.log(1.2) / 2)
    steps = np.cumsum(np.r_[0, 1.2 ** np.arange(9)])
    points[..., 1] = (steps / steps[-1])[:, None]
    start = points.copy()
    start[1:-1, 1:-1, 1:-1] += 0.01
    for functions in ((0, rate, 0), (0 * points[..., 0], lambda i, j, k: rate + 0 * j, 0)):
        grid, _ = mc.elliptic_volume(StructuredGrid(start), control="none", control_functions=functions, residual=1e-10)
        np.testing.assert_allclose(grid.points, points, atol=1e-9)
    for bad, said in (((0, 0), "each of 3"), ((0, np.zeros(4), 0), "Q needs shape"), ((0, 0, np.nan), "R must stay")):
        with pytest.raises(InvalidInput, match=said):
            mc.elliptic_volume(StructuredGrid(start), control_functions=bad)


def test_control_that_folds_cells_is_weakened():
    start = naive.filled_box(np.sin(box(12, 12, 12)) + 0.2 * box(12, 12, 12)[..., ::-1] ** 2)

    def pull(i, j, k):
        return np.where(j < 6, 1.5, -1.5)

    seen = []
    grid, report = mc.elliptic_volume(
        StructuredGrid(start), control_functions=(pull, 0, 0), progress=lambda done, message: seen.append(done)
    )
    assert "with 0.5 of its strength" in report.warnings[0]
    assert "cells that the discrete equations leave folded were unfolded" in report.warnings[1]
    assert seen == sorted(seen)
    assert (quality.measure(grid, "jacobian") > 0).all()


def test_control_keeps_a_polar_grid_with_any_radial_law():
    r = 1 + np.linspace(0, 1, 30) ** 1.7
    t = np.linspace(0, 1.2, 15)
    z = np.linspace(0, 1, 8)
    R, T, Z = np.meshgrid(r, t, z, indexing="ij")
    points = np.stack([R * np.cos(T), R * np.sin(T), Z], axis=-1)
    # ln r is harmonic: growth of r is counted less that of r dT.
    growth = from_boundary(points)
    np.testing.assert_allclose(growth[1:], 0, atol=1e-12)
    kept, _ = mc.elliptic_volume(StructuredGrid(points), control="boundary spacing")
    moved, _ = mc.elliptic_volume(StructuredGrid(points), control="none")
    error, other = (abs(grid.points - points).max() for grid in (kept, moved))
    assert error < 3e-3 < 0.05 < other


def test_smoothed_faces_lie_on_their_surfaces_and_edges_stay():
    u, v, w = np.moveaxis(box(16, 14, 12), -1, 0)
    twisted = u + 0.12 * np.sin(np.pi * u) * np.sin(2 * np.pi * v) * np.sin(np.pi * w) ** 0
    points = np.stack([twisted, v, w], axis=-1)
    grid, report = mc.elliptic_volume(StructuredGrid(points), faces="smoothed", residual=1e-8)
    assert report.converged
    bottom = grid.points[:, :, 0]
    np.testing.assert_allclose(bottom[..., 2], 0, atol=1e-12)
    assert abs(bottom - points[:, :, 0]).max() > 0.03
    for i, j in ((0, 0), (0, -1), (-1, 0), (-1, -1)):
        assert (grid.points[i, j] == points[i, j]).all()
        assert (grid.points[i, :, j] == points[i, :, j]).all()
        assert (grid.points[:, i, j] == points[:, i, j]).all()
    kept, _ = mc.elliptic_volume(StructuredGrid(points), residual=1e-8)
    assert quality.measure(grid, "scaled_jacobian").min() > quality.measure(kept, "scaled_jacobian").min()


def test_a_left_handed_grid_is_turned_with_its_names():
    start = box(5, 4, 3)[::-1].copy()
    grid, _ = mc.elliptic_volume(StructuredGrid(start, names={"imin": "far", "jmax": "wall"}))
    assert (quality.measure(grid, "jacobian") > 0).all()
    assert grid.names == {"imax": "far", "jmax": "wall"}
    np.testing.assert_allclose(grid.points, box(5, 4, 3), atol=1e-12)


def test_too_few_cycles_are_told():
    points = naive.filled_box(np.sin(box(16, 16, 16)) + 0.2 * box(16, 16, 16)[..., ::-1] ** 2)
    _, report = mc.elliptic_volume(StructuredGrid(points), residual=1e-12, max_cycles=1)
    assert not report.converged
    assert "allow more cycles" in report.warnings[0]
    with pytest.raises(InvalidInput, match="residual: must be at least 1e-13, got 0"):
        mc.elliptic_volume(StructuredGrid(points), residual=0)


def test_folds_that_the_boundary_makes_are_refused_with_their_place():
    points = box(8, 8, 8)
    points[:, :, -1, 2] -= 1.4 * (np.sin(np.pi * points[:, :, -1, 0]) * np.sin(np.pi * points[:, :, -1, 1])) ** 2
    with pytest.raises(GenerationFailed, match="cells are folded or flat, the first at i = ") as failure:
        mc.elliptic_volume(StructuredGrid(points))
    jacobians = quality.measure(failure.value.partial, "jacobian").ravel(order="F")
    assert set(failure.value.cells) == set(np.flatnonzero(jacobians <= 0))


def test_bad_blocks_are_named():
    good = box(3, 3, 3)
    with pytest.raises(InvalidInput, match="block: is a surface"):
        mc.elliptic_volume(StructuredGrid(good[:, :, :1]))
    with pytest.raises(InvalidInput, match="block: needs a StructuredGrid or a Mesh, got ndarray"):
        mc.elliptic_volume(good)
    with pytest.raises(InvalidInput, match="block: needs quads alone, has 0 and 1 other faces"):
        mc.elliptic_volume(Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], {"triangle": [[0, 1, 2]]}))
    nan = good.copy()
    nan[1, 1, 1] = np.nan
    with pytest.raises(InvalidGeometry, match=r"\(1, 1, 1\)"):
        mc.elliptic_volume(StructuredGrid(nan))
    with pytest.raises(GenerationFailed):
        mc.elliptic_volume(StructuredGrid(good * [1, 1, 0]))
    with pytest.raises(InvalidGeometry, match="all its points at one place"):
        mc.elliptic_volume(StructuredGrid(np.zeros((4, 4, 4, 3))))
    with pytest.raises(InvalidInput, match="threads"):
        mc.elliptic_volume(StructuredGrid(good), threads=0)


def test_bad_cages_are_named():
    cage = surface_of(box(3, 3, 3))
    quads = cage.get("quad")
    with pytest.raises(InvalidGeometry, match="block: is open"):
        mc.elliptic_volume(Mesh(cage.points, {"quad": quads[3:]}))
    two = Mesh(np.concatenate([cage.points, cage.points + 5]), {"quad": np.concatenate([quads, quads + cage.n_points])})
    with pytest.raises(InvalidGeometry, match="has 16 points where three quads meet"):
        mc.elliptic_volume(two)


@pytest.mark.parametrize("cells", [(1, 1, 1), (2, 1, 3), (2, 2, 2)])
def test_blocks_almost_without_inside(cells):
    grid, report = mc.elliptic_volume(surface_of(box(*cells)))
    assert report.converged
    assert grid.n_cells == np.prod(cells)


@pytest.mark.parametrize("scale", [1e300, 1e-200])
@pytest.mark.parametrize("as_cage", [True, False])
def test_blocks_beyond_what_arithmetic_can_do_are_refused(scale, as_cage):
    block = mc.StructuredGrid(scale * np.stack(np.meshgrid(*[np.linspace(0, 1, 4)] * 3, indexing="ij"), axis=-1))
    with pytest.raises(InvalidGeometry, match=r"block: has an extent of .*; scale it"):
        mc.elliptic_volume(block.to_mesh().boundary if as_cage else block)


def test_faces_that_did_not_converge_are_told():
    block = np.stack(np.meshgrid(*[np.linspace(0, 1, n) for n in (25, 25, 9)], indexing="ij"), axis=-1)
    bump = (np.sin(np.pi * block[:, :, 0, 0]) * np.sin(np.pi * block[:, :, 0, 1]))[..., None] ** 2
    for height, cycles in ((-2.0, 1), (-2.0, 60)):
        points = block.copy()
        points[..., 2] = height * bump + (1 - height * bump) * block[..., 2]
        _, report = mc.elliptic_volume(StructuredGrid(points), faces="smoothed", max_cycles=cycles)
        told = any("the face kmin has not converged after" in text for text in report.warnings)
        assert told == (cycles == 1) and report.converged == (cycles == 60)
