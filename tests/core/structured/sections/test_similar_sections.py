"""What is made round a section goes with it as it moves, turns, scales, begins elsewhere or runs the other way."""

from __future__ import annotations

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery
from meshcore.geometry.curves import polyline
from tests.section_trials import MAKERS, METHODS

MILLIMETRES, UPRIGHT = np.diag([1e3, 1e3, 1e3]), np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
TURN = np.array([[np.cos(0.5), -np.sin(0.5), 0], [np.sin(0.5), np.cos(0.5), 0], [0, 0, 1]])
CHANGES = {
    "a millionth": (np.eye(3) * 1e-6, 0.0),
    "a million times": (np.eye(3) * 1e6, 0.0),
    "millimetres": (MILLIMETRES, 0.0),
    "turned": (TURN, 0.0),
    "upright": (UPRIGHT, 0.0),
    "upright, turned about z": (TURN @ UPRIGHT, 0.0),
    "far away": (np.eye(3), np.array([1e7, -1e7, 0])),
}


def blocks_of(topology: str, method: str, section: np.ndarray, height: float) -> list[np.ndarray]:
    """Points of the blocks of a grid."""
    grid, _ = MAKERS[topology](section, method=method, first_height=height, radius=5)
    return [block.points[:, :, 0] for block in (grid.blocks if isinstance(grid, mc.MultiBlock) else [grid])]


def farthest(ones: list[np.ndarray], others: list[np.ndarray]) -> float:
    """The largest distance between points of grids of the same shape."""
    assert [one.shape for one in ones] == [other.shape for other in others]
    return max(float(np.linalg.norm(a - b, axis=-1).max()) for a, b in zip(ones, others, strict=True))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("topology", MAKERS)
def test_grids_go_with_their_section(topology, method):
    section = polyline(gallery.airfoil("naca0012"))  # whose base has two corners alike
    expected = blocks_of(topology, method, section, 2e-3)
    for name, (turn, move) in CHANGES.items():
        size = np.cbrt(np.linalg.det(turn))
        found = blocks_of(topology, method, section @ turn.T + move, 2e-3 * size)
        back = [(points - move) @ np.linalg.inv(turn).T for points in found]
        assert farthest(back, expected) < (1e-2 if name == "far away" else 1e-5), name


@pytest.mark.parametrize("topology", MAKERS)
def test_neither_the_first_point_nor_the_direction_matters(topology):
    section = polyline(gallery.airfoil("naca0012"))
    expected = blocks_of(topology, "hyperbolic", section, 2e-3)
    for given in (section[::-1], np.roll(section[:-1], 7, axis=0)[np.r_[0 : len(section) - 1, 0]]):
        assert farthest(blocks_of(topology, "hyperbolic", given, 2e-3), expected) < 1e-9


@pytest.mark.parametrize("turn", [UPRIGHT, np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])])
def test_what_lies_above_is_called_upper_in_upright_planes(turn):
    for section in (polyline(gallery.airfoil("s1223")), polyline(gallery.circle(24))):
        blocks, _ = mc.h_grid(section @ turn.T, radius=3, first_height=0.01)
        lower, upper = (block.points[..., 2].mean() for block in blocks.blocks)
        assert blocks.names == ("lower", "upper") and lower < -0.5 < 0.5 < upper


def test_a_slit_in_an_upright_plane_runs_with_the_flow():
    blocks, _ = mc.h_grid(np.array([[0.0, 0, 0], [0.5, 0, -0.02], [1, 0, -0.1]]), radius=2, first_height=0.01)
    inflow, outflow = blocks.blocks[0].points[0, 0, 0], blocks.blocks[0].points[-1, 0, 0]
    assert outflow[0] - inflow[0] > 4 and abs(outflow[2] - inflow[2]) < 1e-9 + 0.2 * (outflow[0] - inflow[0])


@pytest.mark.parametrize("topology", MAKERS)
def test_a_point_between_the_corners_of_a_base_stays(topology):
    side = polyline(gallery.airfoil("naca0012"))[:-1]
    section = np.vstack([[[1.0005, 0.0004, 0]], side, [[1.0005, 0.0004, 0]]])  # beyond its base, which is 0.0025 wide
    blocks = blocks_of(topology, "hyperbolic", section, 2e-3)
    assert min(float(np.linalg.norm(points - section[0], axis=-1).min()) for points in blocks) < 1e-12
