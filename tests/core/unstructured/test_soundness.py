"""The check at the end: triangles turned over or torn apart, lines lost."""

import numpy as np
import pytest

from meshcore import GenerationFailed, Mesh
from meshcore.gallery import joined, square, square_with_hole
from meshcore.progress import silent
from meshcore.unstructured import _half_edge_kernels as half_edges
from meshcore.unstructured._refinement_kernels import FREE_VERTEX
from meshcore.unstructured.constrained import constrained
from meshcore.unstructured.domain import Seeds, domain
from meshcore.unstructured.planar_graph import planar_graph
from meshcore.unstructured.refiner import Refiner
from meshcore.unstructured.soundness import check

NO_SEEDS = Seeds(None, np.empty((0, 2)), np.empty(0, np.int64), np.empty(0))
DIVIDED_SQUARE = joined(square(), Mesh([[0.0, 0.0], [1.0, 1.0]], {"line": [[0, 1]]}))


def triangulation(boundary):
    """A constrained triangulation, and which faces are meshed."""
    graph = planar_graph(boundary.points[:, :2], boundary.get("line"), np.arange(boundary.n_points), "boundary")
    mesh = constrained(graph, split_crossings=False, parameter="boundary", progress=silent)
    return mesh, domain(mesh, NO_SEEDS, np.inf)


def refined(boundary, size=0.1):
    """The same with points on the lines and inside, and without what is not meshed; number of vertices, faces."""
    mesh, parts = triangulation(boundary)
    refiner = Refiner(
        mesh, parts, min_angle=30.0, size=size, placement="off-centre", split_boundary=True, size_field=None,
        progress=silent,
    )  # fmt: skip
    n = len(refiner.run().xy)
    return mesh, refiner, n


def inner_edges(mesh):
    """Half-edges between two triangles without lines."""
    whole = mesh.triangulation
    half_edge = np.arange(4 * whole.n_triangles)
    other = whole.twin[half_edge]
    inside = (half_edge & 3 < 3) & (other >= 0) & (whole.origin[half_edge | 3] == 0)
    return half_edge[inside][whole.origin[other[inside] | 3] == 0]


@pytest.mark.parametrize("exponent", [0, -200])
@pytest.mark.parametrize("boundary", [DIVIDED_SQUARE, square_with_hole()])
def test_what_is_made_is_sound(boundary, exponent):
    boundary = boundary.with_points(np.ldexp(boundary.points, exponent))
    mesh, parts = triangulation(boundary)
    check(mesh, len(mesh.triangulation.order), parts.keep)
    mesh, refiner, n = refined(boundary, float(np.ldexp(0.1, exponent)))
    check(mesh, n, refiner.domain.keep)


def test_a_triangle_turned_over_is_found():
    mesh, refiner, n = refined(square_with_hole())
    inner = int(np.flatnonzero(refiner.stands_on[:n] == FREE_VERTEX)[-1])
    mesh.triangulation.xy[2 * inner] += 5.0
    with pytest.raises(GenerationFailed, match="turned"):
        check(mesh, n, refiner.domain.keep)


def point_elsewhere(whole, e, g):
    whole.twin[e] = g


def swap_neighbours(whole, e, g):
    f, h = whole.twin[[e, g]]
    whole.twin[[e, h, g, f]] = h, e, f, g


def cut(whole, e, g):
    whole.twin[whole.twin[e]] = whole.twin[e] = -1


def kill(whole, e, g):
    whole.origin[e | 3] |= half_edges.DEAD


@pytest.mark.parametrize("spoil", [point_elsewhere, swap_neighbours, cut, kill])
def test_triangles_torn_apart_are_found(spoil):
    for last in (False, True):
        mesh, refiner, n = refined(square_with_hole())
        edges = inner_edges(mesh)
        spoil(mesh.triangulation, edges[-last], edges[len(edges) // 2])
        with pytest.raises(GenerationFailed, match="torn"):
            check(mesh, n, refiner.domain.keep)


def test_a_line_flipped_away_is_found():
    mesh, parts = triangulation(DIVIDED_SQUARE)
    whole = mesh.triangulation
    half_edge = mesh.constrained_half_edges
    on_diagonal = half_edge[mesh.line[mesh.piece_of[half_edge]] == 4]
    assert len(on_diagonal) == 2
    half_edges.flip(whole.origin, whole.twin, mesh.piece_of, np.empty(5, np.int32), int(on_diagonal[0]))
    with pytest.raises(GenerationFailed, match="lost a line"):
        check(mesh, len(whole.order), parts.keep)


def test_a_gap_in_a_line_is_found():
    mesh, refiner, n = refined(DIVIDED_SQUARE)
    whole = mesh.triangulation
    half_edge = mesh.constrained_half_edges
    half_edge = half_edge[whole.origin[half_edge | 3] & half_edges.DEAD == 0]
    e = int(half_edge[whole.twin[half_edge] >= 0][3])
    for side in (e, int(whole.twin[e])):
        half_edges.set_constrained(whole.origin, side, 0)
    with pytest.raises(GenerationFailed, match="lost a line"):
        check(mesh, n, refiner.domain.keep)


@pytest.mark.parametrize("distance", [1e-9, 1e-3])
def test_a_point_beside_its_line_is_found(distance):
    mesh, refiner, n = refined(square_with_hole())
    middle = int(np.flatnonzero(refiner.stands_on[:n] >= 0)[0])
    p, q = mesh.triangulation.xy.reshape(-1, 2)[mesh.pieces[refiner.stands_on[middle], :2]]
    normal = np.array([p[1] - q[1], q[0] - p[0]]) / np.hypot(*(q - p))
    mesh.triangulation.xy[2 * middle : 2 * middle + 2] += distance * normal
    with pytest.raises(GenerationFailed, match="lost a line"):
        check(mesh, n, refiner.domain.keep)
