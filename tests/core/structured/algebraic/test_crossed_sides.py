"""Sides that cross are named at once, with the place; those that touch, as at cuts, are not."""

import re

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery
from meshcore.errors import GenerationFailed, InvalidGeometry
from meshcore.structured.algebraic.crossed_sides import crossing, refuse_crossed_sides

TURN = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])


def straight(a, b, n):
    return np.linspace((*a, 0.0), (*b, 0.0), n + 1)


def patch(south, n):
    """A unit square with another south."""
    return south, straight((1, 0), (1, 1), n), straight((0, 1), (1, 1), n), straight((0, 0), (0, 1), n)


def hill(height, n):
    x = np.linspace(0, 1, n + 1)
    return np.column_stack([x, height * np.sin(np.pi * x), 0 * x])


def looped(n):
    x = np.linspace(0, 1, n + 1)
    return np.column_stack([x + 0.3 * np.sin(4 * np.pi * x), 0.1 * np.sin(2 * np.pi * x), 0 * x])


@pytest.mark.parametrize("operation", [mc.transfinite, mc.elliptic])
@pytest.mark.parametrize(
    ("sides", "parameter", "text"),
    [
        (patch(hill(1.5, 32), 32), "south", "crosses north near "),
        (patch(hill(1.01, 33), 33), "south", "crosses north near "),
        (patch(looped(32), 32), "south", "crosses itself near "),
        (  # two ends of north exchanged: a bow tie, whose sides cross between points, or at a point of both
            (
                straight((0, 0), (1, 1), 7),
                straight((1, 1), (1, 0), 7),
                straight((0, 1), (1, 0), 7),
                straight((0, 0), (0, 1), 7),
            ),
            "south",
            r"crosses north near \(0.5, 0.5, 0\)",
        ),
        (
            (
                straight((0, 0), (1, 1), 8),
                straight((1, 1), (1, 0), 8),
                straight((0, 1), (1, 0), 8),
                straight((0, 0), (0, 1), 8),
            ),
            "south",
            r"crosses north near \(0.5, 0.5, 0\)",
        ),
    ],
)
def test_sides_that_cross_are_named_with_the_place(operation, sides, parameter, text):
    with pytest.raises(InvalidGeometry, match=text) as caught:
        operation(*sides)
    assert caught.value.parameter == parameter
    ends = sides[0][list(caught.value.points), :2]
    place = np.array(re.findall(r"near \((\S+), (\S+), ", str(caught.value))[0], float)
    assert len(ends) == 2 and np.abs(np.diff(ends, axis=0)).max() < 0.2
    assert np.linalg.norm(ends - place, axis=1).sum() == pytest.approx(np.linalg.norm(ends[1] - ends[0]), rel=1e-3)
    with pytest.raises(InvalidGeometry, match=text.split(r" \(")[0]):
        operation(*(side @ TURN.T for side in sides))


def test_a_cure_is_not_tried_where_sides_cross():
    with pytest.raises(InvalidGeometry, match="crosses north"):
        mc.transfinite(*patch(hill(1.2, 16), 16), cure="automatic")


def test_a_given_grid_whose_boundary_crosses_itself_is_not_smoothed():
    try:
        mc.structured.transfinite(*patch(hill(0.9, 16), 16))
    except GenerationFailed as failure:
        grid = failure.partial
    else:
        grid = mc.transfinite(*patch(hill(0.9, 16), 16)).mesh
    crossed = grid.points.copy()
    crossed[:, 0, 0, 1] *= 1.5
    with pytest.raises(InvalidGeometry, match="south: crosses north") as caught:
        mc.elliptically_smoothed(mc.StructuredGrid(crossed))
    ends = crossed.reshape(17, 17, 3).swapaxes(0, 1).reshape(-1, 3)[list(caught.value.points)]
    assert ends[:2, 1].min() < 1 < ends[:2, 1].max() and (ends[2:, 1] == 1).all()


def test_points_of_one_boundary_are_those_of_the_mesh():
    """Whose points may stand in any order."""
    south, east, north, west = patch(hill(1.5, 32), 32)
    loop = np.concatenate([south[:-1], east[:-1], north[:0:-1], west[:0:-1]])
    order = np.random.default_rng(0).permutation(len(loop))
    number = np.argsort(order)
    mesh = mc.Mesh(loop[order], {"line": np.column_stack([number, np.roll(number, -1)])})
    corners = tuple(int(number[k]) for k in (0, 32, 64, 96))
    with pytest.raises(InvalidGeometry, match="crosses") as caught:
        mc.transfinite(mesh, corners=corners)
    assert np.abs(mesh.points[list(caught.value.points), 1] - 1).max() < 0.15


def test_both_sides_of_a_cut_may_run_along_each_other():
    """A C-grid's south goes along the wake, round the section, and back along the wake, up to rounding."""
    wake = straight((3, 0), (1, 0), 12)
    angle = np.linspace(0, -2 * np.pi, 33)
    section = np.column_stack([0.5 + 0.5 * np.cos(angle), 0.3 * np.sin(angle), 0 * angle])
    back = wake[::-1] + 1e-16 * np.random.default_rng(0).normal(size=wake.shape) * [1, 1, 0]
    loop = np.concatenate(
        [wake, section[1:-1], back, straight((3, 0), (3, 2), 4)[1:], straight((3, -2), (3, 0), 4)[:-1]]
    )
    assert crossing(loop[:, :2], np.arange(len(loop) - 1)) is None
    grid, _ = mc.o_grid(gallery.circle(24), radius=3, layers=8)
    refuse_crossed_sides(grid)  # cut along a ray


def test_a_side_in_space_is_nobodys_outside():
    bent = np.stack(np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 1, 5), [0.0], indexing="ij"), axis=-1)
    bent[..., 2] = bent[..., 0] ** 2
    refuse_crossed_sides(mc.StructuredGrid(bent))


def test_a_boundary_without_area_is_told():
    flat = np.stack(np.meshgrid(np.linspace(0, 1, 5), [0.0, 0.0, 0.0], [0.0], indexing="ij"), axis=-1)
    with pytest.raises(InvalidGeometry, match="grid: has no area"):
        mc.elliptically_smoothed(mc.StructuredGrid(flat))


@pytest.mark.parametrize("operation", [mc.transfinite, mc.elliptic])
@pytest.mark.parametrize("n", [32, 33])  # at a point of north, and between two
def test_opposite_sides_that_touch_leave_no_room(operation, n):
    tent = np.array([[0, 0, 0], [0.5, 1, 0], [1, 0, 0]])
    south = np.concatenate([np.linspace(tent[k], tent[k + 1], 17)[k:] for k in (0, 1)])
    sides = south, straight((1, 0), (1, 1), 8), straight((0, 1), (1, 1), n), straight((0, 0), (0, 1), 8)
    with pytest.raises(InvalidGeometry, match=r"touches (north|south) near \(0.5, 1, 0\); move them apart"):
        operation(*sides, cells_i=32)
    turned = tuple(side * [-1, 1, 1] for side in sides)  # clockwise
    with pytest.raises(InvalidGeometry, match=r"touches (north|south) near \(-0.5, 1, 0\)"):
        operation(*turned, cells_i=32)
