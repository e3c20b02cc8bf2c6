"""Model inputs are what they say."""

import numpy as np
import pytest

from meshcore import InvalidInput, gallery
from meshcore.geometry.curves import chains


def signed_area(mesh) -> float:
    a, b = (mesh.points[mesh.cells["line"][:, k]] for k in (0, 1))
    return float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum() / 2)


@pytest.mark.parametrize(
    ("mesh", "area"),
    [
        (gallery.square(3, size=2), 4),
        (gallery.circle(1000), np.pi),
        (gallery.l_shape(4), 3),
        (gallery.square_with_hole(64), 1 + np.pi / 16),
    ],
)
def test_loops_are_closed_and_counter_clockwise(mesh, area):
    assert all(chain[0] == chain[-1] for chain in chains(mesh))
    assert signed_area(mesh) == pytest.approx(area, rel=1e-3)


def test_loops_carry_their_number():
    mesh = gallery.square_with_hole(4)
    assert len(chains(mesh)) == 2
    assert mesh.cell_data["tag"].tolist() == [1] * 16 + [2] * 8


def test_sides_meet():
    south, east, north, west = gallery.wavy_sides()
    for a, b in ((south[0], west[0]), (south[-1], east[0]), (east[-1], north[-1]), (west[-1], north[0])):
        assert np.allclose(a, b, atol=1e-12)


def test_the_triangulated_square_is_one():
    mesh = gallery.triangulated_square(5)
    a, b, c = (mesh.points[mesh.cells["triangle"][:, k]] for k in range(3))
    assert np.cross(b - a, c - a)[:, 2] == pytest.approx(1 / 25)
    assert np.ptp(mesh.point_data["front"]) > 1.5


def test_an_unknown_operation_has_no_model_call():
    with pytest.raises(InvalidInput, match="no model call of 'whisker'"):
        gallery.arguments("whisker")
