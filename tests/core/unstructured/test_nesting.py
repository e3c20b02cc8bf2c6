"""Which faces are inside, against the slow twin."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshcore.unstructured.constrained import constrained, levels
from meshcore.unstructured.planar_graph import planar_graph
from tests import naive


def graph_of(points, lines):
    graph = planar_graph(np.array(points, float), np.array(lines), np.unique(lines), "lines")
    return constrained(graph, split_crossings=True, parameter="lines", progress=lambda fraction, message: True)


def expected(mesh):
    left, right = mesh.faces_beside.tolist()
    return naive.nesting_levels([tuple(p) for p in mesh.pieces[:, :2].tolist()], left, right, mesh.n_faces)


@settings(max_examples=150, deadline=None)
@given(st.integers(0, 10**6), st.integers(3, 14), st.integers(2, 5))
def test_any_lines(seed, n, side):
    random = np.random.default_rng(seed)
    points = [[-1, -1], [side, -1], *random.integers(0, side, (n, 2))]
    lines = [(0, 1), (0, 2), *random.integers(2, n + 2, (n, 2)).tolist()]
    mesh = graph_of(points, lines)
    assert levels(mesh).tolist() == expected(mesh)


SQUARE = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
LOOP = np.array([[0, 1], [1, 2], [2, 3], [3, 0]])


@pytest.mark.parametrize(
    "points, lines, inside",
    [
        (np.concatenate([9 * SQUARE, 3 + SQUARE]), np.concatenate([LOOP, LOOP + 4]), 1),  # a hole
        (np.concatenate([9 * SQUARE, 7 * SQUARE]), np.concatenate([LOOP, LOOP + 4]), 2),  # a part beside
        (np.concatenate([9 * SQUARE, 3 + SQUARE]), np.concatenate([LOOP, LOOP + 4, [[0, 4]]]), 1),  # on a bridge
        ([[0, 0], [2, 2], [2, 0], [0, 2]], [(0, 1), (1, 2), (2, 3), (3, 0)], 2),  # crosses itself
        ([[0, 0], [1, 1]], [(0, 1)], 0),
    ],
)
def test_loops(points, lines, inside):
    points = np.concatenate([points, [[20, -5], [20, 5], [-20, 0]]])  # no loop, but not on one line
    mesh = graph_of(points, np.concatenate([lines, [[len(points) - 3, len(points) - 2], [0, len(points) - 1]]]))
    assert levels(mesh).tolist() == expected(mesh) and levels(mesh).sum() == inside
