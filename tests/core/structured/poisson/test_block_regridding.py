"""Edges of a block gridded anew, and faces on the surfaces through their points."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import meshcore as mc
from meshcore import InvalidInput, StructuredGrid, gallery, quality
from meshcore.sizing import Spacing, poisson
from meshcore.structured.algebraic.block_edges import Asked
from meshcore.structured.algebraic.block_faces import PLACES
from meshcore.structured.poisson.block_regridding import regridded
from meshcore.structured.poisson.winslow_3d import count_folded
from tests import naive

NONE = dict.fromkeys(PLACES)


def box(*cells):
    """Unit cube of so many cells."""
    return np.stack(np.meshgrid(*[np.linspace(0, 1, n + 1) for n in cells], indexing="ij"), axis=-1)


def shell(*cells):
    """Part of a thick cylinder round the z axis, its radii 1 and 2 at imin and imax."""
    u, v, w = np.moveaxis(box(*cells), -1, 0)
    angle = 1.5 * v + 0.3 * w
    return np.stack([(1 + u) * np.cos(angle), (1 + u) * np.sin(angle), w + 0.2 * v * v], axis=-1)


def edges_of(points):
    """The twelve edges, along i, then j, then k."""
    return [np.moveaxis(points, axis, 0)[:, a, b] for axis in range(3) for a in (0, -1) for b in (0, -1)]


def test_nothing_asked_keeps_the_boundary_to_the_bit():
    points = shell(5, 6, 7)
    new = regridded(points, Asked((5, None, 7), "as given", NONE, 1.0))
    inside = np.zeros(points.shape[:3], bool)
    inside[1:-1, 1:-1, 1:-1] = True
    np.testing.assert_allclose(new[~inside], points[~inside], atol=1e-14)
    for one, two in zip(edges_of(new), edges_of(points), strict=True):
        assert (one == two).all()


def test_edges_get_the_law_that_is_asked_and_others_stay():
    points = shell(6, 24, 8)
    new = regridded(points, Asked((None, None, 10), "as given", NONE | {"kmin": 0.02, "imax": 0.05}, 1.0))
    assert new.shape == (7, 25, 11, 3)
    for one, two in zip(edges_of(new)[4:8], edges_of(points)[4:8], strict=True):
        assert (one == two).all()
    for line in edges_of(new)[:4]:
        assert np.linalg.norm(line[-1] - line[-2]) == pytest.approx(0.05, rel=1e-6)
    for line in edges_of(new)[8:]:
        assert np.linalg.norm(line[1] - line[0]) == pytest.approx(0.02, rel=1e-3)  # along a curve


def test_the_one_dimensional_poisson_equation_grids_edges():
    ends = NONE | {"kmin": 0.01, "kmax": 0.04}
    grid, report = mc.elliptic_volume(
        StructuredGrid(box(4, 4, 12)), edges="poisson", spacing_kmin=0.01, spacing_kmax=0.04, residual=1e-10
    )
    expected = poisson(12, first=0.01, last=0.04)
    np.testing.assert_allclose(grid.points[2, 2, :, 2], expected, atol=1e-8)
    np.testing.assert_allclose(grid.points[2, 2, :, :2], 0.5, atol=1e-9)
    assert report.converged
    asked = Asked((None,) * 3, "as given", ends, 1.0, {"k": Spacing("poisson", first=0.01, last=0.04)})
    np.testing.assert_allclose(regridded(box(4, 4, 12), asked)[0, 0, :, 2], expected, atol=1e-12)


def test_faces_stay_on_their_surfaces_with_fourth_order():
    errors = []
    for n in (6, 12, 24):
        new = regridded(shell(n, n, n), Asked((None, 20, 20), "as given", NONE | {"jmin": 0.02}, 1.0))
        assert new.shape == (n + 1, 21, 21, 3)
        errors.append([abs(np.linalg.norm(new[end, ..., :2], axis=-1) - r).max() for end, r in ((0, 1), (-1, 2))])
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert (orders > 3.5).all(), orders
    assert np.max(errors[-1]) < 1e-6


def test_smoothed_faces_follow_edges_that_were_gridded_anew():
    start = shell(8, 16, 12)
    grid, report = mc.elliptic_volume(StructuredGrid(start), edges="poisson", spacing_jmin=0.02, faces="smoothed")
    assert report.converged
    assert abs(np.linalg.norm(grid.points[0, ..., :2], axis=-1) - 1).max() < 1e-4
    first = np.linalg.norm(grid.points[:, 1] - grid.points[:, 0], axis=-1)
    assert first[[0, -1]][:, [0, -1]] == pytest.approx(0.02, rel=0.02)
    assert first.max() < 0.06


@settings(max_examples=25, deadline=None)
@given(
    counts=st.tuples(*[st.one_of(st.none(), st.integers(1, 9))] * 3),
    law=st.sampled_from(["as given", "uniform", "poisson", "cosine", "curvature"]),
)
def test_faces_meet_at_their_new_edges_and_corners_stay(counts, law):
    points = shell(4, 5, 3)
    new = regridded(points, Asked(counts, law, NONE, 1.0))
    assert new.shape[:3] == tuple((n or m) + 1 for n, m in zip(counts, (4, 5, 3), strict=True))
    assert (new[:: new.shape[0] - 1, :: new.shape[1] - 1, :: new.shape[2] - 1] == points[::4, ::5, ::3]).all()
    np.testing.assert_allclose(new, naive.filled_box(new), atol=1e-12)
    assert count_folded(new) == 0


def test_a_wedge_keeps_its_axis():
    u, v, w = np.moveaxis(box(4, 5, 6), -1, 0)
    points = np.stack([u * np.cos(v), u * np.sin(v), w], axis=-1)
    new = regridded(points, Asked((None, 7, None), "uniform", NONE, 1.0))
    assert (new[0, ..., :2] == 0).all()
    np.testing.assert_allclose(np.linalg.norm(new[-1, ..., :2], axis=-1), 1, atol=1e-4)


def test_a_coarse_cage_is_filled_with_a_fine_grid():
    grid, report = mc.elliptic_volume(gallery.dented_box(8, depth=0.5), cells_i=20, cells_j=18, cells_k=16)
    assert grid.shape == (21, 19, 17)
    assert report.converged
    assert quality.measure(grid, "scaled_jacobian").min() > 0.1


def test_what_edges_cannot_have_is_told():
    block = StructuredGrid(box(4, 4, 4), names={"kmin": "wall"})
    with pytest.raises(InvalidInput, match="spacing_kmin: is given, but edges are kept; choose a law"):
        mc.elliptic_volume(block, spacing_kmin=0.1)
    with pytest.raises(InvalidInput, match=r"spacing_kmax: .*does not fit an edge of length 1 with 4 cells"):
        mc.elliptic_volume(block, edges="poisson", spacing_kmax=2.0)
    with pytest.raises(InvalidInput, match="spacing_jmax: is no number of the law 'uniform'"):
        mc.elliptic_volume(block, edges="uniform", spacing_jmax=0.2)
    with pytest.raises(InvalidInput, match='spacings: needs a Spacing for "i", "j" or "k", got float'):
        mc.elliptic_volume(block, spacings={"k": 0.1})
    with pytest.raises(InvalidInput, match="spacings: needs a Spacing"):
        mc.elliptic_volume(block, spacings={"kmin": Spacing()})
    with pytest.raises(InvalidInput, match="cells_k: would make"):
        mc.elliptic_volume(block, cells_k=10**8)
    grid, _ = mc.elliptic_volume(block, edges="poisson", cells_k=6)
    assert grid.names == {"kmin": "wall"}
