"""The single passes over triangle meshes, against what they replace."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshcore import Mesh, gallery, quality
from meshcore.quality import kept, keys


def random_mesh(seed, space=3):
    """Triangles between random points: flat, obtuse, on a surface or crossing; no two with the same points."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(40, space)) * 10.0 ** rng.integers(-3, 4)
    cells = np.array([rng.choice(40, 3, replace=False) for _ in range(60)])
    return Mesh(points, {"triangle": cells})


@given(st.integers(0, 10**6), st.sampled_from([2, 3]))
def test_summary_is_what_the_measures_say(seed, space):
    mesh = random_mesh(seed, space)
    found = quality.summary(mesh)
    for label, name, reduce in (
        ("smallest angle (degree)", "min_angle", np.min),
        ("largest angle (degree)", "max_angle", np.max),
        ("mean radius ratio", "radius_ratio", np.mean),
        ("worst scaled jacobian", "scaled_jacobian", np.min),
    ):
        assert found[label] == pytest.approx(float(reduce(quality.measure(mesh, name))), rel=1e-9), label


@pytest.mark.parametrize("scale", [1e-150, 1e-75, 1e-60, 1e60, 1e75, 1e150])
def test_summary_of_extreme_sizes_is_what_the_measures_say(scale):
    square = gallery.triangulated_square(2)
    mesh = square.with_points(square.points * scale)
    with np.errstate(all="ignore"):
        found = quality.summary(mesh)
        expected = float(quality.measure(mesh, "min_angle").min())
    assert found["smallest angle (degree)"] == pytest.approx(expected)


def test_summary_of_a_flat_triangle():
    mesh = Mesh([[0, 0], [1, 0], [2, 0], [0, 1]], {"triangle": [[0, 1, 2], [0, 1, 3]]})
    found = quality.summary(mesh)
    assert found["smallest angle (degree)"] == 0 and found["largest angle (degree)"] == 180
    assert found["mean radius ratio"] == np.inf and found["worst scaled jacobian"] == 0


@given(st.integers(0, 10**6))
def test_directed_edges_are_all_edges_in_order(seed):
    mesh = random_mesh(seed)
    n = mesh.n_points
    expected = [
        2 * (n * min(a, b) + max(a, b)) + (a > b)
        for cell in mesh.get("triangle").tolist()
        for a, b in zip(cell, [*cell[1:], cell[0]], strict=True)
    ]
    assert keys.directed_edges(mesh).tolist() == sorted(expected)


def test_directed_edges_at_a_hub():
    """A point with far more edges than a row that is sorted by insertion, in no order."""
    rim = np.random.default_rng(5).permutation(np.arange(1, 301))
    cells = np.column_stack([np.zeros(300, int), rim, np.roll(rim, -1)])
    angle = np.empty(301)
    angle[rim] = 2 * np.pi * np.arange(300) / 300
    points = np.column_stack([np.cos(angle), np.sin(angle)])
    points[0] = 0
    mesh = Mesh(points, {"triangle": cells})
    found = keys.directed_edges(mesh)
    assert len(found) == 900 and (np.diff(found) > 0).all()
    assert quality.validate(mesh) == []


@given(st.lists(st.tuples(*[st.sampled_from([0.0, -0.0, 1.0, 2.0])] * 3), min_size=3, max_size=12))
def test_points_at_one_place_are_found(points):
    mesh = Mesh(np.array(points), {"line": [[k, k + 1] for k in range(len(points) - 1)]})
    faults = [fault for fault in quality.validate(mesh, raise_=False) if fault.name == "duplicate points"]
    count = Counter(tuple(x + 0.0 for x in p) for p in points)
    expected = [k for k, p in enumerate(points) if count[tuple(x + 0.0 for x in p)] > 1]
    assert [k for fault in faults for k in fault.points.tolist()] == expected


@given(st.integers(2, 7), st.integers(0, 100))
def test_lines_are_followed_over_their_points_only(parts, seed):
    """On a grid of points every straight row is kept; a line past the points is not."""
    n = parts + 1
    x, y = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(n * n)])[np.random.default_rng(seed).permutation(n * n)]
    number = {tuple(p): k for k, p in enumerate(points[:, :2].astype(int).tolist())}
    cells = []
    for i in range(parts):
        for j in range(parts):
            a, b, c, d = (number[p] for p in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)))
            cells += [(a, b, c), (a, c, d)]
    mesh = Mesh(points, {"triangle": cells})
    edges = keys.directed_edges(mesh)
    ends = [(0, 0, parts, 0), (0, parts, parts, parts), (0, 0, parts, parts), (0, parts, parts, 0), (1, 0, 0, 1)]
    lines = np.array([(number[a, b], number[c, d]) for a, b, c, d in ends])
    lost = kept.missing_segments(points, edges, np.arange(n * n), lines)
    assert lost.tolist() == [3, 4]  # the diagonals that run the other way
