"""Cleaning of planar graphs: points at one place."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from meshcore.unstructured.planar_graph import SAME_POINT, planar_graph


@given(st.integers(0, 10**6), st.integers(2, 20), st.integers(1, 4), st.sampled_from([0.45, 1.5]))
def test_points_nearer_than_rounding_are_one_and_others_are_not(seed, places, copies, spread):
    random = np.random.default_rng(seed)
    distance = SAME_POINT * 100
    at = random.integers(-1000, 1000, (places, 2)) * 20 * distance  # far apart, on borders of any grid
    at = np.concatenate([np.unique(at, axis=0), [[100.0, 100.0]]])
    angle = 2 * np.pi * np.arange(copies) / copies + random.uniform(0, 6.3)
    offsets = spread * distance * np.column_stack([np.cos(angle), np.sin(angle)])
    points = np.concatenate([(at[:-1, None] + offsets).reshape(-1, 2), at[-1:]])
    lines = np.column_stack([np.arange(len(points) - 1), np.full(len(points) - 1, len(points) - 1)])
    graph = planar_graph(points, lines, np.arange(len(points)), "boundary")
    gaps = np.linalg.norm(points[:, None] - points[None], axis=2)
    reach = gaps <= distance  # what is near, and near to what is near
    for _ in range(copies):
        reach = reach @ reach
    assert graph.source.tolist() == sorted({int(np.argmax(row)) for row in reach})
