"""Polygons cut into triangles, and listed cells sorted by kind."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshcore.errors import InvalidInput
from meshcore.io.fit import FormatWarning
from meshcore.io.ragged import POLY_LINE, POLYGON, cells_by_kind, polygon_triangles


def twice_areas(triangles: np.ndarray) -> np.ndarray:
    """(m, 3) float: vector areas, twice."""
    return np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])


@given(st.lists(st.floats(0.2, 1), min_size=5, max_size=20), st.integers(0, 2**31))
def test_star_shaped_polygons_are_covered_once(radii: list[float], seed: int) -> None:
    """No triangle is turned over, and their areas add up: then they cover the polygon, each place once."""
    n = len(radii)
    angle = 2 * np.pi * np.arange(n) / n
    flat = np.array(radii)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    frame = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    corners = flat @ frame[:2] + frame[2]
    triangles = polygon_triangles(corners)
    assert triangles.shape == (n - 2, 3)
    normal = np.cross(frame[0], frame[1])
    areas = twice_areas(corners[triangles]) @ normal
    after = np.roll(flat, -1, axis=0)
    assert (areas > -1e-12).all()
    assert areas.sum() == pytest.approx(float((flat[:, 0] * after[:, 1] - flat[:, 1] * after[:, 0]).sum()))
    assert set(triangles.ravel()) == set(range(n))


def test_degenerate_polygons_end() -> None:
    for corners in (
        np.zeros((6, 3)),
        np.outer(np.arange(6.0), [1, 2, 3]),
        np.array([[0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1, 0], [0.5, 2, 0]]),
    ):
        assert polygon_triangles(corners).shape == (len(corners) - 2, 3)


def test_order_and_origin() -> None:
    points = np.random.default_rng(3).random((9, 3))
    lists = [[0, 1, 2, 3], [0, 1, 2], [3, 4, 5, 6, 7], [4, 5, 6], [1, 2, 3]]
    types = [POLYGON, POLYGON, POLYGON, POLYGON, POLY_LINE]
    offsets = np.cumsum([0, *map(len, lists)])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FormatWarning)
        cells, origin = cells_by_kind(np.array(types), np.concatenate(lists), offsets, points)
    assert list(cells) == ["quad", "triangle", "line"]
    assert origin.tolist() == [0, 1, 2, 2, 2, 3, 4, 4]
    assert cells["triangle"][[0, 4]].tolist() == [[0, 1, 2], [4, 5, 6]]
    assert cells["line"].tolist() == [[1, 2], [2, 3]]


@pytest.mark.parametrize(
    ("types", "connectivity", "offsets", "message"),
    [
        ([5], [0, 1, 7], [0, 3], "point 7"),
        ([5], [0, 1, -1], [0, 3], "point -1"),
        ([5], [0, 1], [0, 2], "3 nodes"),
        ([7], [0, 1], [0, 2], "at least three"),
        ([5], [0, 1, 2], [0, 9], "9 corners"),
        ([5, 5], [0, 1, 2], [0, 3, 1], "begins"),
        ([42], [0, 1, 2], [0, 3], "type 42"),
        ([0], [], [0, 0], "empty"),
        ([4], [0], [0, 1], "needs 2"),
    ],
)
def test_faults(types: list, connectivity: list, offsets: list, message: str) -> None:
    with pytest.raises(InvalidInput, match=message):
        cells_by_kind(np.array(types), np.array(connectivity, int), np.array(offsets), np.zeros((3, 3)))
