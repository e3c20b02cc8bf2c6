"""StructuredGrid and MultiBlock."""

import numpy as np
import pytest

from meshcore import InvalidGeometry, InvalidInput, MultiBlock, StructuredGrid
from tests.core.mesh.test_topology import enclosed_volume


def box(ni: int, nj: int, nk: int) -> StructuredGrid:
    axes = (np.arange(n, dtype=float) for n in (ni, nj, nk))
    return StructuredGrid(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1))


def annulus(n: int) -> StructuredGrid:
    angle, radius = np.meshgrid(-2 * np.pi * np.arange(n + 1) / n, [1.0, 2.0], indexing="ij")
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
    points[-1] = points[0]
    return StructuredGrid(points, periodic=(True, False, False))


def test_a_box_becomes_positive_hexahedra():
    grid = box(4, 3, 5)
    mesh = grid.to_mesh()
    assert grid.n_cells == 3 * 2 * 4 and mesh.n_cells == grid.n_cells and mesh.n_points == grid.n_points
    assert enclosed_volume(mesh.boundary) == pytest.approx(3 * 2 * 4)


def test_points_run_fastest_along_i_as_in_vtk():
    grid = box(2, 3, 4)
    flat = grid.flat(grid.points)
    assert flat[:3].tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert flat[1 + 2 * (2 + 3 * 3)].tolist() == [1, 2, 3]


def test_data_follow_their_points_and_cells():
    grid = box(3, 3, 2)
    number = np.arange(4.0).reshape(2, 2, 1)
    mesh = grid.with_point_data(x=grid.points[..., 0]).with_cell_data(number=number).to_mesh()
    assert np.array_equal(mesh.point_data["x"], mesh.points[:, 0])
    for value, centre in zip(mesh.cell_data["number"], mesh.centroids, strict=True):
        assert value == number[int(centre[0]), int(centre[1]), 0]


def test_a_surface_has_quads():
    grid = StructuredGrid(box(4, 3, 1).points[:, :, 0, :2])
    assert grid.is_surface and grid.cell_shape == (3, 2, 1)
    assert grid.to_mesh().cells["quad"][0].tolist() == [0, 1, 5, 4]
    assert repr(grid) == "StructuredGrid(4 x 3 points)"


def test_the_cut_of_an_o_grid_closes():
    mesh = annulus(8).to_mesh()
    assert mesh.n_points == 16 and mesh.n_cells == 8
    assert mesh.boundary.n_cells == 16  # two circles, no cut


@pytest.mark.parametrize(
    ("points", "error", "text"),
    [
        (np.zeros((3, 3)), InvalidInput, "needs shape"),
        (np.zeros((1, 3, 3)), InvalidInput, "at least 2 x 2 points"),
        (np.zeros((2, 2, 2, 4)), InvalidInput, "needs shape"),
        ("points", InvalidInput, "needs real numbers"),
        (np.full((2, 2, 3), np.nan), InvalidGeometry, r"point \(0, 0, 0\)"),
    ],
)
def test_what_the_constructor_refuses(points, error, text):
    with pytest.raises(error, match=text):
        StructuredGrid(points)


def test_a_bad_point_is_named_by_its_number_in_vtk_order():
    points = box(3, 2, 2).points.copy()
    points[2, 1, 1] = np.inf
    with pytest.raises(InvalidGeometry) as caught:
        StructuredGrid(points)
    assert caught.value.points == (2 + 3 * (1 + 2 * 1),)


def test_data_and_names_must_fit():
    with pytest.raises(InvalidInput, match=r"cell_data\['q'\]: needs shape \(2, 1, 1\)"):
        box(3, 2, 2).with_cell_data(q=np.zeros(2))
    with pytest.raises(InvalidInput, match="'wall' is no face"):
        StructuredGrid(box(2, 2, 2).points, names={"wall": "jmin"})


def test_blocks_have_different_names():
    blocks = MultiBlock((box(2, 2, 2), box(3, 2, 2)))
    assert blocks.names == ("block 0", "block 1") and blocks.n_cells == 3 and blocks.n_points == 20
    with pytest.raises(InvalidInput, match="2 different names"):
        MultiBlock(blocks.blocks, ("a", "a"))
    with pytest.raises(InvalidInput, match="at least one block"):
        MultiBlock(())


def test_complex_points_are_refused_not_cut_to_their_real_parts():
    with pytest.raises(InvalidInput, match="points: needs real numbers"):
        StructuredGrid(np.zeros((3, 3, 1, 3), complex))
