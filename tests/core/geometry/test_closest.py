"""Closest points of surfaces of facets: against a search of all facets, and normals against known ones."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery
from meshcore.errors import InvalidGeometry, InvalidInput
from meshcore.geometry.closest import FacetedSurface
from tests import naive


def sphere(n=24, m=12):
    """Half a unit sphere and more, as a grid of quads with poles left out."""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, n + 1), np.linspace(-1.2, 1.2, m + 1), indexing="ij")
    points = np.stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)], axis=-1)
    points[-1] = points[0]
    return mc.StructuredGrid(points, periodic=(True, False, False))


def triangles(mesh):
    """The quads of the sphere are wider below and above: both diagonals are equally long."""
    quads = mesh.get("quad")
    return mc.Mesh(mesh.points, {"triangle": np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])})


def test_the_closest_point_is_that_of_all_facets():
    mesh = triangles(sphere().to_mesh())
    points = np.random.default_rng(1).uniform(-1.5, 1.5, (60, 3))
    foot = FacetedSurface(mesh).closest(points)
    for p, at, distance in zip(points, foot.points, foot.distance, strict=True):
        nearest = min(naive.nearest_on_simplex(x, p) for x in mesh.points[mesh.get("triangle")])
        assert abs(distance - nearest) < 1e-12 and abs(np.linalg.norm(p - at) - nearest) < 1e-12


def test_normals_are_those_of_the_sphere_to_second_order():
    errors = []
    for n in (24, 48, 96):
        foot = FacetedSurface(sphere(n, n // 2)).closest(1.1 * sphere(37, 11).points[:, 2:-2].reshape(-1, 3))
        out = foot.points / np.linalg.norm(foot.points, axis=1)[:, None]
        errors.append(
            np.linalg.norm(foot.normals * np.sign((foot.normals * out).sum(axis=1))[:, None] - out, axis=1).max()
        )
    assert (np.log2(np.divide(errors[:-1], errors[1:])) > 1.8).all(), errors


def test_lifts_reach_the_smooth_surface_but_not_over_a_ridge():
    """Facets are off the sphere to second order, what is above them to more than that."""
    at = sphere(37, 11).points[:, 2:-2].reshape(-1, 3)
    errors = {"facets": [], "smooth": []}
    for n in (24, 48, 96):
        foot = FacetedSurface(sphere(n, n // 2)).closest(at)
        errors["facets"].append(abs(np.linalg.norm(foot.points, axis=1) - 1).max())
        errors["smooth"].append(abs(np.linalg.norm(foot.points + foot.lifts, axis=1) - 1).max())
    assert (np.divide(errors["smooth"], errors["facets"]) < [0.2, 0.1, 0.05]).all(), errors
    box = mc.Mesh(gallery.dented_box(2, depth=0.0).points, gallery.dented_box(2, depth=0.0).cells)
    foot = FacetedSurface(box).closest(np.random.default_rng(4).random((50, 3)))
    assert abs(foot.lifts).max() < 1e-12


def test_facets_of_any_orientation_agree():
    mesh = triangles(sphere().to_mesh())
    rng = np.random.default_rng(2)
    cells = mesh.get("triangle").copy()
    turned = rng.random(len(cells)) < 0.5
    turned[0] = False
    cells[turned] = cells[turned][:, [0, 2, 1]]
    surface, mixed = FacetedSurface(mesh), FacetedSurface(mc.Mesh(mesh.points, {"triangle": cells}))
    assert turned.any()
    points = rng.uniform(-1, 1, (50, 3))
    np.testing.assert_allclose(mixed.closest(points).normals, surface.closest(points).normals, atol=1e-12)
    # Files of triangles repeat their points: the normals are smooth all the same.
    soup = mc.Mesh(
        mesh.points[mesh.get("triangle")].reshape(-1, 3), {"triangle": np.arange(3 * len(cells)).reshape(-1, 3)}
    )
    np.testing.assert_allclose(
        FacetedSurface(soup).closest(points).normals, surface.closest(points).normals, atol=1e-12
    )


def test_quads_are_cut_alike_whichever_corner_is_their_first():
    mesh = sphere().to_mesh()
    quads = mesh.get("quad")
    points = np.random.default_rng(3).uniform(-1.5, 1.5, (50, 3))
    foot = FacetedSurface(mesh).closest(points)
    for turn in (1, 2, 3):
        turned = FacetedSurface(mc.Mesh(mesh.points, {"quad": np.roll(quads, turn, axis=1)})).closest(points)
        np.testing.assert_allclose(turned.points, foot.points, atol=1e-14)
    bent = mc.Mesh([[0, 0, 0], [2, 0, 1], [2.2, 2, 0], [0, 2, 1]], {"quad": [[0, 1, 2, 3]]})
    assert FacetedSurface(bent).closest(np.array([[1.0, 1, 1]])).points[0, 2] > 0.9  # along the diagonal from 1 to 3


def test_normals_turn_without_jumps_over_a_ridge():
    roof = mc.Mesh(
        [[0, 0, 0], [1, 0, 1], [2, 0, 0], [0, 1, 0], [1, 1, 1], [2, 1, 0]], {"quad": [[0, 1, 4, 3], [1, 2, 5, 4]]}
    )
    x = np.linspace(0.3, 1.7, 2001)
    foot = FacetedSurface(roof).closest(np.column_stack([x, 0 * x + 0.5, 1 - abs(x - 1)]))
    assert np.linalg.norm(np.diff(foot.normals, axis=0), axis=1).max() < 5e-3
    assert abs(abs(foot.normals[1000] @ [0, 0, 1]) - 1) < 1e-9
    assert foot.distance.max() < 1e-12


def test_what_is_no_surface_is_refused():
    with pytest.raises(InvalidInput, match="needs triangles or quads"):
        FacetedSurface(gallery.circle())
    with pytest.raises(InvalidInput, match="needs a Mesh or a StructuredGrid, got list"):
        FacetedSurface([[0, 0, 0]])
    with pytest.raises(InvalidGeometry, match="none of which has an area"):
        FacetedSurface(mc.Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], {"triangle": [[0, 1, 2]]}))
    angle = np.linspace(0, 2 * np.pi, 13)[:-1]
    rim = []
    for width in (-1, 1):
        radius = 2 + width * np.cos(angle / 2)
        rim.append(np.column_stack([radius * np.cos(angle), radius * np.sin(angle), width * np.sin(angle / 2)]))
    k = np.arange(11)
    quads = np.column_stack([k, k + 1, k + 13, k + 12]).tolist() + [[11, 12, 0, 23]]
    with pytest.raises(InvalidGeometry, match="one side only"):
        FacetedSurface(mc.Mesh(np.concatenate(rim), {"quad": quads}))
