"""Deleting vertices from constrained Delaunay triangulations, against the triangulation without them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from meshcore import Mesh, delaunay_refinement
from meshcore.unstructured import _half_edge_kernels as half_edges
from meshcore.unstructured import _vertex_deletion_kernels as kernels
from meshcore.unstructured.constrained import constrained
from meshcore.unstructured.planar_graph import planar_graph
from meshcore.unstructured.soundness import check
from tests import naive
from tests.core.unstructured.planar_graphs import loop_lines

NO_VERTEX = np.array([[-9, -9], [9, -9], [9, 9], [-9, 9]], float)


def made(points, lines):
    graph = planar_graph(points, lines, np.arange(len(points)), "lines")
    mesh = constrained(graph, split_crossings=True, parameter="lines", progress=lambda fraction, message: True)
    return mesh, mesh.graph.source[mesh.triangulation.order]


def triangles(mesh, number):
    corners = number[mesh.triangulation.live()[0]]
    return {tuple(np.roll(c, -c.argmin()).tolist()) for c in corners}


def deleted(mesh, v):
    """Delete a vertex, and check what the kernel answers."""
    whole, scratch = mesh.triangulation, mesh.triangulation.scratch
    opposite = next(e for e in range(4 * whole.n_triangles) if e & 3 < 3 and whole.origin[half_edges_before(e)] == v)
    ends = whole.origin[[opposite, half_edges_after(opposite)]].tolist()
    free = np.zeros(10, np.int32)
    ears = np.empty(scratch.size, np.int32)
    count, again = kernels.delete_vertex(
        opposite, whole.xy, whole.origin, whole.twin, mesh.piece_of, free, 3, scratch.cavity, scratch.stack, ears,
        scratch.ring, scratch.work,
    )  # fmt: skip
    assert whole.origin[[again, half_edges_after(again)]].tolist() == ends
    if count:
        assert (whole.origin[4 * free[3:5] + 3] & half_edges.DEAD).all() and not free[[0, 1, 2, 5]].any()
    return count


def check_all(mesh):
    """Every face counts as meshed."""
    check(mesh, len(mesh.triangulation.order), np.ones(mesh.n_faces, bool))


def half_edges_before(e):
    return e + 2 if e & 3 == 0 else e - 1


def half_edges_after(e):
    return e - 2 if e & 3 == 2 else e + 1


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(5, 25), st.booleans())
def test_the_rest_is_as_if_it_had_never_been(seed, n, on_lattice):
    random = np.random.default_rng(seed)
    points = random.permutation(49)[:n]
    points = np.column_stack([points // 7, points % 7]) if on_lattice else random.random((n, 2))
    points = np.concatenate([points.astype(float), NO_VERTEX])
    lines = np.concatenate([loop_lines(4, n), random.integers(0, n // 2, (n // 4, 2))])
    lines = lines[lines[:, 0] != lines[:, 1]]
    mesh, number = made(points, lines)
    alone = np.setdiff1d(np.arange(len(number)), mesh.pieces[:, :2])
    for v in alone[:3]:
        before = triangles(mesh, number)
        if not deleted(mesh, v):
            assert triangles(mesh, number) == before
            continue
        check_all(mesh)
        assert v not in mesh.triangulation.live()[0]
        xy = mesh.triangulation.xy.reshape(-1, 2).tolist()
        corners = mesh.triangulation.live()[0].tolist()
        kept = mesh.pieces[:, :2].tolist()
        edges = {(t[k], t[k - 2]) for t in corners for k in range(3)}
        assert all((a, b) in edges or (b, a) in edges for a, b in kept)
        assert naive.not_locally_delaunay(xy, corners, kept) == []


@pytest.mark.parametrize("n", [3, 5, 40])
def test_hubs(n):
    angle = 2 * np.pi * np.arange(n) / n
    points = np.concatenate([np.column_stack([np.cos(angle), np.sin(angle)]), [[0.01, 0.02]], NO_VERTEX])
    mesh, number = made(points, np.array(loop_lines(4, n + 1)))
    assert deleted(mesh, int(np.flatnonzero(number == n)[0])) == n - 2
    check_all(mesh)


def test_points_of_the_input_stay():
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.02], [0.3, 0.01]])
    boundary = Mesh(square, {"line": loop_lines(4), "vertex": np.arange(6)[:, None]})
    mesh = delaunay_refinement(boundary, min_angle=30).mesh
    assert (mesh.points[:6, :2] == square).all() and set(range(6)) <= set(np.unique(mesh.cells["triangle"]).tolist())
