"""Edges, facets, boundary and orientation of every kind of cell."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshcore import Mesh, gallery
from meshcore.mesh import CELL_TYPES, topology

CUBE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
SOLIDS = {
    "tetra": (CUBE[[0, 1, 3, 4]], 1 / 6),
    "hexahedron": (CUBE, 1.0),
    "wedge": (CUBE[[0, 1, 3, 4, 5, 7]], 1 / 2),
    "pyramid": (CUBE[[0, 1, 2, 3, 4]], 1 / 3),
}


def enclosed_volume(surface: Mesh) -> float:
    """Volume by the divergence theorem; positive where the facets look outward."""
    total = 0.0
    for kind in ("triangle", "quad"):
        p = surface.points[surface.get(kind)]
        for k in range(1, p.shape[1] - 1):
            total += (np.cross(p[:, k] - p[:, 0], p[:, k + 1] - p[:, 0]) * p[:, 0]).sum() / 6
    return total


@pytest.mark.parametrize("kind", SOLIDS)
def test_facets_of_a_solid_look_outward_and_close(kind):
    points, volume = SOLIDS[kind]
    mesh = Mesh(points + 5, {kind: [range(len(points))]})
    assert enclosed_volume(mesh.boundary) == pytest.approx(volume)
    assert len(mesh.edges) == len(CELL_TYPES[kind].edges)
    # Euler: points - edges + faces = 2
    assert mesh.n_points - len(mesh.edges) + mesh.boundary.n_cells == 2


@pytest.mark.parametrize("kind", SOLIDS)
def test_turning_inside_out_and_back(kind):
    points, volume = SOLIDS[kind]
    mesh = Mesh(points, {kind: [range(len(points))]})
    turned = mesh.reoriented()
    assert enclosed_volume(turned.boundary) == pytest.approx(-volume)
    assert turned.reoriented().cells[kind].tolist() == mesh.cells[kind].tolist()


def test_two_hexahedra_share_one_face():
    points = np.concatenate([CUBE, CUBE[[1, 2, 5, 6]] + [1, 0, 0]])
    mesh = Mesh(points, {"hexahedron": [[0, 1, 2, 3, 4, 5, 6, 7], [1, 8, 9, 2, 5, 10, 11, 6]]})
    inner = mesh.facets.shared == 2
    assert inner.sum() == 1 and mesh.boundary.n_cells == 10
    assert sorted([mesh.facets.owner[inner][0], mesh.facets.neighbour[inner][0]]) == [0, 1]
    assert enclosed_volume(mesh.boundary) == pytest.approx(2)


def test_a_pyramid_on_a_hexahedron_matches_triangles_and_quads():
    points = np.concatenate([CUBE, [[0.5, 0.5, 2]]])
    mesh = Mesh(points, {"hexahedron": [range(8)], "pyramid": [[4, 5, 6, 7, 8]]})
    assert {k: len(c) for k, c in mesh.boundary.cells.items()} == {"triangle": 4, "quad": 5}
    assert enclosed_volume(mesh.boundary) == pytest.approx(1 + 1 / 3)
    owner = dict(
        zip(map(tuple, mesh.boundary.cells["triangle"].tolist()), mesh.boundary.cell_data["cell"], strict=False)
    )
    assert set(owner.values()) == {1}


def test_the_boundary_of_a_triangulation_runs_counter_clockwise():
    boundary = gallery.triangulated_square(3).boundary
    a, b = boundary.points[boundary.cells["line"][:, 0]], boundary.points[boundary.cells["line"][:, 1]]
    assert boundary.n_cells == 12
    assert (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum() / 2 == pytest.approx(1)


def test_facets_tell_when_a_mesh_is_no_manifold():
    mesh = Mesh(CUBE, {"triangle": [[0, 1, 2], [0, 1, 4], [0, 1, 7]]})
    assert sorted(mesh.facets.shared.tolist()) == [1, 1, 1, 1, 1, 1, 3]


def test_only_cells_of_the_highest_dimension_have_facets():
    mesh = Mesh(CUBE, {"line": [[0, 1]], "triangle": [[0, 1, 2]]})
    assert mesh.boundary.n_cells == 3 and set(mesh.boundary.cell_data["cell"].tolist()) == {1}


def test_curved_cells_have_the_facets_of_their_corners():
    mesh = Mesh(np.random.default_rng(7).random((10, 3)), {"tetra10": [range(10)]})
    assert len(mesh.edges) == 6 and mesh.boundary.n_cells == 4


@given(st.integers(1, 30), st.lists(st.tuples(st.integers(0, 29), st.integers(0, 29)), max_size=40))
def test_connected_parts_against_a_plain_search(count, pairs):
    pairs = [(a % count, b % count) for a, b in pairs]
    label = topology.connected(np.array(pairs, int).reshape(-1, 2), count)
    reached = {k: {k} for k in range(count)}
    for _ in range(count):
        for a, b in pairs:
            both = reached[a] | reached[b]
            for k in both:
                reached[k] = both
    firsts = sorted({min(part) for part in reached.values()})
    assert label.tolist() == [firsts.index(min(reached[k])) for k in range(count)]


def test_a_long_chain_is_one_part_in_any_order():
    pairs = np.column_stack([np.arange(99_999), np.arange(1, 100_000)])
    for order in (slice(None), slice(None, None, -1), np.random.default_rng(5).permutation(99_999)):
        assert not topology.connected(pairs[order], 100_000).any()


def test_edges_are_unique_and_sorted():
    edges = gallery.triangulated_square(4).edges
    assert len(edges) == 16 + 2 * 4 * 5  # one diagonal a square, and the grid lines
    assert (edges[:, 0] < edges[:, 1]).all() and len(np.unique(edges, axis=0)) == len(edges)
