"""H-grids: airfoils, slabs and slits between two joined blocks."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery
from meshcore.errors import InvalidGeometry, InvalidInput
from meshcore.geometry.curves import polyline
from meshcore.structured import Curvilinear
from tests import naive

X = np.linspace(0, 1, 21)
SLIT = np.column_stack([X, 0 * X])
SECTIONS = {
    **{name: gallery.airfoil(name) for name in gallery.airfoils()},
    "circle": gallery.circle(40),
    "square": gallery.square(8),
    "slab": np.array([[0, 0], [1, 0], [1, 0.1], [0, 0.1], [0, 0.0]]),
    "slit": SLIT,
    "bent slit": np.column_stack([X, 0.1 * np.sin(np.pi * X)]),
}


def assert_sound(blocks):
    for block in blocks.blocks:
        assert (naive.cross_areas(block.points[:, :, 0]) > 0).all()
    mesh = blocks.to_mesh()
    shared = sum(cut.points[1][0] - cut.points[0][0] + 1 for cut in blocks.cuts)
    assert mesh.n_points == blocks.n_points - shared
    return mesh


@pytest.mark.parametrize("name", SECTIONS)
@pytest.mark.parametrize("height", [0.002, 1e-5])
def test_no_cell_is_folded_and_the_blocks_meet(name, height):
    keywords = {"around": 80} if name == "slab" else {}
    blocks, report = mc.h_grid(SECTIONS[name], first_height=height, **keywords)
    mesh = assert_sound(blocks)
    assert report.quality["first height"] == height and report.quality["largest growth"] <= 1.151
    sides = mc.with_named_sides(blocks)
    assert set(sides.sets) == {"wall", "far field", "inflow", "outflow"}
    on_wall = sides.points[sides.get("line")[sides.sets["wall"] - mesh.n_cells]]
    length = np.linalg.norm(np.diff(on_wall, axis=1), axis=-1).sum()
    loop = polyline(SECTIONS[name])
    whole = np.linalg.norm(np.diff(loop, axis=0), axis=1).sum() * (2 if "slit" in name else 1)
    assert length == pytest.approx(whole, rel=1e-3)


def test_the_box_is_where_it_is_asked():
    blocks, _ = mc.h_grid(gallery.airfoil("naca0012"), radius=4, wake=6, first_height=1e-3)
    low, high = blocks.to_mesh().bounds
    assert low[:2] == pytest.approx([-3.5, -4], rel=1e-6) and high[:2] == pytest.approx([7, 4], rel=1e-6)


def test_a_slit_is_a_cartesian_grid_with_two_sides():
    blocks, _ = mc.h_grid(SLIT, radius=2, first_height=0.01)
    lower, upper = (block.points[:, :, 0] for block in blocks.blocks)
    assert np.ptp(upper[..., 0], axis=1).max() < 1e-12 and np.ptp(upper[..., 1], axis=0).max() < 1e-12
    assert np.abs(lower[:, ::-1] * [1, -1, 1] - upper).max() < 1e-12
    assert blocks.to_mesh().n_points == blocks.n_points - (upper.shape[0] - 19)  # the slit's inner points are two


def test_the_box_turns_with_the_flow():
    blocks, _ = mc.h_grid(gallery.airfoil("rae2822"), flow=10.0, first_height=1e-3)
    assert_sound(blocks)
    inflow = blocks.blocks[1].points[0, :, 0]
    way = inflow[-1] - inflow[0]
    assert np.degrees(np.arctan2(way[1], way[0])) == pytest.approx(100, abs=0.5)


def test_operators_go_through_the_cuts():
    blocks, _ = mc.h_grid(gallery.airfoil("naca0012"), radius=3, first_height=5e-3, around=120)
    values = [b.points[..., 0] ** 2 + b.points[..., 1] ** 2 for b in blocks.blocks]
    lower, upper = Curvilinear(blocks).laplacian(values)
    ahead = blocks.cuts[0].points[1][0]
    assert np.abs(upper[3:5, 0] - 4).max() < 0.1  # nearer to the nose lines bend sharply
    assert np.abs(upper[3 : ahead - 4, 0] - lower[3 : ahead - 4, -1]).max() < 1e-6


@pytest.mark.parametrize(
    ("section", "keywords", "error", "words"),
    [
        (np.array([[0, 0], [2, 2], [2, 0], [0, 1.5], [0, 0]]), {}, InvalidGeometry, "crosses itself"),
        (np.array([[0, 0], [1, 0], [0.5, 0.2], [1.5, 0.3]]), {}, InvalidGeometry, "turns back"),
        (gallery.airfoil("rae2822"), {"first_height": 8.0}, InvalidInput, "first_height"),
        (gallery.airfoil("rae2822"), {"layers": 10**9}, InvalidInput, "layers"),
        (np.zeros((3, 2)), {}, InvalidGeometry, "different points"),
    ],
)
def test_bad_input_gets_a_clear_error(section, keywords, error, words):
    with pytest.raises(error, match=words):
        mc.h_grid(section, **keywords)
