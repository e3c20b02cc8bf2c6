"""Bounding boxes by long rows are those of the points one by one."""

import numpy as np
import pytest

from meshcore.mesh.extent import bounds, extents


@pytest.mark.parametrize("n", [1, 2, 63, 64, 65, 128, 1000])
@pytest.mark.parametrize("d", [2, 3])
def test_box(n, d):
    points = np.random.default_rng(n).normal(size=(n, d))
    for given in (points, np.asfortranarray(points), points.reshape(1, n, d), points[::-1]):
        assert bounds(given).tolist() == [points.min(axis=0).tolist(), points.max(axis=0).tolist()]
        assert extents(given).tolist() == np.ptp(points, axis=0).tolist()


def test_numbers_that_are_none_are_not_hidden():
    points = np.ones((200, 3))
    points[70, 1] = np.nan
    assert np.isnan(bounds(points)).tolist() == [[False, True, False]] * 2
