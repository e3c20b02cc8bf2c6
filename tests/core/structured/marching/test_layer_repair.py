"""Lines that see all faces, and layers that are repaired where cells would fold."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery, quality
from meshcore.structured.marching import _layer_kernels, _layer_repair_kernels
from meshcore.structured.marching.front_edges import free_edges
from meshcore.structured.marching.layer_marching import first_normals
from meshcore.structured.marching.layer_repair import repair
from meshcore.structured.marching.layer_surface import read_surface
from tests import naive_layers as naive
from tests.named_sides import solid
from tests.surfaces import SURFACES

HEIGHT = 0.15


def fan(rng):
    """A point with its ring, of which faces may stand steeply."""
    m = int(rng.integers(3, 8))
    angle = np.sort(rng.uniform(0, 2 * np.pi, m))
    heights = rng.normal(size=m) * rng.choice([0.3, 1, 3])
    ring = np.column_stack([np.cos(angle), np.sin(angle), heights]) * rng.uniform(0.2, 3, m)[:, None]
    return np.concatenate([np.zeros((1, 3)), ring])


def test_lines_see_all_faces_as_well_as_asked_or_as_any_line_does():
    rng, asked, less = np.random.default_rng(0), 0, 0
    for _ in range(400):
        points = fan(rng)
        m = len(points) - 1
        ring, normal = np.arange(1, m + 1), np.zeros((m + 1, 3))
        start = np.concatenate([[0], np.full(m + 1, m)])
        alone = (np.zeros(m + 1, np.int64), np.full(m + 1, -1), np.zeros((1, 3, 3)))
        _layer_kernels.normals(0, 1, points, start, ring, *alone, 0.5, normal)
        faces = np.cross(points[1:], np.roll(points[1:], -1, axis=0))
        faces /= np.linalg.norm(faces, axis=1)[:, None]
        mine, best = (faces @ normal[0]).min(), naive.best_seen(faces)
        if best >= 0.5:
            assert mine > 0.499
            asked += 1
        elif best > 0:
            assert mine > best - 0.03
            less += 1
    assert asked > 100 and less > 100


@pytest.fixture(params=["closed", "open"])
def layer(request):
    """A surface, its graph, a layer one of whose nodes has been thrown over its neighbours, and the twin's rings."""
    surface = gallery.bumpy_ball(60)
    if request.param == "open":
        u, v = np.meshgrid(np.linspace(0, 1, 7), np.linspace(0, 1, 8), indexing="ij")
        surface = mc.StructuredGrid(np.stack([u, v, 0.1 * np.sin(4 * u)], axis=-1))
    graph = read_surface(surface).graph
    above = graph.points + HEIGHT * first_normals(graph)
    node = int(np.flatnonzero(graph.opened == 0)[20])
    above[node] += 1.2 * (above[graph.ring[graph.start[node]]] - above[node])
    return graph, above, node, naive.rings(graph.faces.tolist(), len(graph.points))


def test_shares_and_costs_agree_with_the_twins(layer):
    graph, above, node, found = layer
    n, wall, ring = len(graph.points), graph.points, (graph.start, graph.ring, graph.opened)
    below, worst = wall + 0.01 * np.random.default_rng(1).normal(size=wall.shape) * HEIGHT, np.empty(n)
    _layer_repair_kernels.worst_shares(0, n, wall, below, above, *ring, worst)
    expected = naive.shares(wall, below, above, found)
    assert np.abs(worst - [values.min() for values in expected]).max() < 1e-9
    target, other = above.copy(), above.copy()
    other[node] += 0.3 * HEIGHT

    def costs(layer):
        return (
            _layer_repair_kernels.node_cost(node, wall, below, layer, target, HEIGHT, *ring),
            naive.repair_cost(wall, below, layer, target, HEIGHT, found),
        )

    (mine, total), (after, total_after) = costs(above), costs(other)
    assert after - mine == pytest.approx(total_after - total, rel=1e-6)


def test_a_folded_layer_is_repaired_where_it_folds(layer):
    graph, above, node, found = layer
    before, hold = above.copy(), free_edges(graph)
    assert naive.corner_volumes(graph.points, above, found).min() < 0
    repair(graph, hold, graph.points, above, HEIGHT)
    assert naive.corner_volumes(graph.points, above, found).min() > 0.02
    costs = [naive.repair_cost(graph.points, graph.points, x, before, HEIGHT, found) for x in (before, above)]
    assert costs[1] < costs[0]
    moved = np.flatnonzero((above != before).any(axis=1))
    assert node in moved and len(moved) < 0.6 * len(above)
    kept = above.copy()
    repair(graph, hold, graph.points, above, HEIGHT)
    assert (above == kept).all()


def test_held_nodes_stay_in_their_planes(layer):
    graph, above, node, _ = layer
    hold = free_edges(graph)
    hold.row[node] = 0
    hold.projectors[0] = np.diag([1.0, 1.0, 0.0])
    height = above[node, 2]
    repair(graph, hold, graph.points, above, HEIGHT)
    assert above[node, 2] == height


@pytest.mark.parametrize(("kind", "k", "made"), [("spiked", 12, 5), ("bricks", 26, 16), ("extruded", 21, 13)])
def test_bodies_whose_layers_folded_are_whole(kind, k, made):
    """Random surfaces whose layers stopped after so many, for lines that saw little or a few nodes that folded."""
    asked = {"first_height": mc.Relative(1e-3), "layers": 30, "distance": mc.Relative(1.0)}
    mesh, report = mc.hyperbolic_volume(SURFACES[kind](np.random.default_rng([77, k])), **asked)
    assert report.converged and report.counts["layers"] == 30
    assert quality.validate(mesh) == []
    assert (quality.measure(solid(mesh), "jacobian") > 0).all()
