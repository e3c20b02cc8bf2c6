"""Fronts that pass through each other, also between two layers, and parts that others swallow."""

import numpy as np
import pytest

import meshcore as mc
from meshcore.errors import GenerationFailed
from meshcore.geometry import predicates
from meshcore.geometry.alternating_digital_tree import Tree
from meshcore.structured.marching import _front_crossing_kernels as kernels
from meshcore.structured.marching.front_crossing import clear_layers, overlapping_node
from meshcore.structured.marching.layer_surface import read_surface
from tests import naive_layers as naive


def plates(gap, size=1.0):
    """Two plates that face each other, the second of another size."""
    u, v = np.meshgrid(np.linspace(-1, 1, 5), np.linspace(-1, 1, 5), indexing="ij")
    low = mc.StructuredGrid(np.stack([u, v, 0 * u], axis=-1))
    high = mc.StructuredGrid(np.stack([v * size, u * size, 0 * u + gap], axis=-1))
    return mc.MultiBlock((low, high), ("low", "high"))


@pytest.mark.parametrize("size", [1.0, 0.4])
def test_fronts_that_have_passed_through_each_other_are_found(size):
    """Far beyond each other plates do not cross any more: no layer tells by itself."""
    asked = {"growth": 1.0, "edges": "free"}
    made, report = mc.hyperbolic_volume(plates(0.3, size), first_height=0.04, layers=40, **asked)
    assert not report.converged and "meet another part" in report.warnings[-1]
    assert report.counts["layers"] == 3  # 0.12 from each
    assert made.blocks[0].points[..., 2].max() < made.blocks[1].points[..., 2].min()
    with pytest.raises(GenerationFailed, match="meet another part"):
        mc.hyperbolic_volume(plates(0.3, size), first_height=0.4, layers=5, **asked)


def test_a_part_that_another_swallows_is_found():
    ready = read_surface(plates(0.9, 0.1))
    n = len(ready.graph.points)
    low = ready.graph.points[:, 2] == 0
    layers = np.repeat(ready.graph.points[None], 3, axis=0)
    layers[1:, low, 2] += [[1.0], [2.0]]
    layers[1:, ~low, 2] -= [[1e-3], [2e-3]]
    node = overlapping_node(ready.graph, layers)
    assert 0 <= node < n and not low[node]
    assert clear_layers(ready.graph, layers) == (0, node)


def test_edges_beside_triangles_in_their_plane_do_not_cross():
    """Straight lines of cylinders lie in the planes of facets beside them, but for rounding."""
    for n in (8, 24, 80):
        t, z = np.meshgrid(np.linspace(0, 2 * np.pi, n + 1), np.linspace(0, 2, 13), indexing="ij")
        tube = mc.StructuredGrid(np.stack([np.cos(t), np.sin(t), z], axis=-1))
        grid, report = mc.hyperbolic_volume(tube, first_height=0.01, layers=6)
        assert report.converged and grid.shape[2] == 7


def test_a_sheet_that_closes_on_itself_is_found():
    """The two lips of a bent strip, whose fronts pass by each other."""
    t, z = np.meshgrid(np.linspace(0.1, 2 * np.pi - 0.1, 41), np.linspace(0, 1, 4), indexing="ij")
    r = 1 + 0.12 * t / (2 * np.pi)
    strip = mc.StructuredGrid(np.stack([r * np.cos(t), r * np.sin(t), z], axis=-1))
    _, report = mc.hyperbolic_volume(strip, first_height=0.02, growth=1.0, layers=20, edges="splay", splay=60.0)
    assert not report.converged and "meet another part" in report.warnings[-1]


@pytest.mark.parametrize("seed", range(6))
def test_the_kernel_agrees_with_its_twin(seed):
    """On coarse lattices, so that most edges touch triangles, lie in their planes, or end on them."""
    rng = np.random.default_rng(seed)
    points = rng.integers(0, 4, (14, 3)).astype(float) * rng.choice([1.0, 0.1])
    column = rng.integers(0, 10, 14)
    triangles, edges = (rng.integers(0, 14, (30, k)) for k in (3, 2))
    corners = points[triangles]
    tree, crossed = Tree(corners.min(axis=1), corners.max(axis=1)), np.empty(30, np.int64)
    kernels.crossings(
        0, 30, points, column, edges, triangles, tree.order, tree.right, tree.first, tree.bounds,
        np.empty(kernels.DEPTH, np.int64), predicates.workspace(), crossed,
    )  # fmt: skip
    assert (crossed >= 0).tolist() == naive.crossings(points, column.tolist(), edges.tolist(), triangles.tolist())
