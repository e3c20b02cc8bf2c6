"""Layers off surfaces that end on an outer one: straight between spheres, sound between bodies, told folds."""

import numpy as np
import pytest

import meshcore as mc
from meshcore import gallery, quality
from meshcore.errors import Cancelled, InvalidInput
from meshcore.geometry.closest import FacetedSurface
from meshcore.sizing import geometric
from meshcore.structured.marching.layer_surface import read_surface
from meshcore.structured.marching.outer_surface import fractions
from tests.core.structured.marching.test_hyperbolic_volume import body
from tests.named_sides import solid


def ball(radius=3.0, centre=(0, 0, 0), n=1500):
    mesh = gallery.bumpy_ball(n, bump=0.0)
    return mesh.with_points(mesh.points / np.linalg.norm(mesh.points, axis=1)[:, None] * radius + np.array(centre))


def box(low, high, n=4):
    mesh = gallery.bricks(np.ones((n, n, n), bool), size=1 / n)
    points = (mesh.points - mesh.points.min(axis=0)) / np.ptp(mesh.points, axis=0)
    return mesh.with_points(np.array(low) + points * (np.array(high) - np.array(low)))


def layers_of(mesh, surface):
    return mesh.points.reshape(-1, len(surface), 3)


def test_fractions_are_geometric_on_each_line():
    first = np.array([1e-4, 0.01, 0.2])
    for k, found in enumerate(fractions(5, first).T):
        assert np.abs(found - geometric(5, first=first[k])).max() < 1e-9


@pytest.mark.parametrize("outer", [ball(4), ball(3, (1, 0, 0)), box((-2, -2, -2), (3, 3, 3))])
def test_layers_end_on_the_outer_surface(outer):
    inner = gallery.six_patches(9)
    blocks, report = mc.hyperbolic_volume(inner, outer=outer, first_height=0.01)
    assert report.converged and not report.warnings
    for block in blocks.blocks:
        assert quality.validate(block) == [] and block.names["kmax"] == "outer"
        assert FacetedSurface(outer).closest(block.points[:, :, -1].reshape(-1, 3)).distance.max() < 1e-12
        first = np.linalg.norm(block.points[:, :, 1] - block.points[:, :, 0], axis=-1)
        assert np.abs(first - 0.01).max() < 1e-6
    assert blocks.to_mesh().n_points == (6 * 49 + 12 * 7 + 8) * (report.counts["layers"] + 1)


def test_between_spheres_lines_are_straight():
    """But for the outer sphere's facets."""
    blocks, report = mc.hyperbolic_volume(gallery.six_patches(9), outer=ball(3, n=4000), first_height=0.01, layers=25)
    assert report.counts["layers"] == 25
    for block in blocks.blocks:
        heading = block.points / np.linalg.norm(block.points, axis=-1, keepdims=True)
        assert np.abs(heading - heading[:, :, :1]).max() < 5e-3


@pytest.mark.parametrize("name", ["cube", "ledge", "inner corner", "saddles", "notch"])
@pytest.mark.parametrize("outer", ["ball", "box"])
def test_bodies_with_corners_reach_it(name, outer):
    surface = body(name)
    there = ball(6, (1, 1, 0.5)) if outer == "ball" else box((-3, -3, -3), (5, 5, 5))
    mesh, report = mc.hyperbolic_volume(surface, outer=there, first_height=0.01)
    assert report.converged and quality.validate(mesh) == []
    assert (quality.measure(solid(mesh), "jacobian") > 0).all()
    assert (mesh.points[: surface.n_points] == surface.points).all()
    assert FacetedSurface(there).closest(layers_of(mesh, surface.points)[-1]).distance.max() < 1e-12


def test_edges_keep_their_conditions_on_the_way():
    hub, wall = gallery.hub_sector(), gallery.conical_wall(240)
    t, z = np.meshgrid(np.linspace(-1, 2, 400), np.linspace(-1, 2, 3), indexing="ij")
    casing = mc.StructuredGrid(np.stack([1.6 * np.cos(t), 1.6 * np.sin(t), z], axis=-1))
    asked = "imin = periodic, imax = periodic, jmin = guide, jmax = constant z"
    grid, report = mc.hyperbolic_volume(hub, wall, casing, first_height=0.01, each_edge=asked)
    assert report.converged and quality.validate(grid) == []
    assert np.abs(np.hypot(*grid.points[:, :, -1, :2].reshape(-1, 2).T) - 1.6).max() < 1e-4
    (cut,) = grid.cuts
    assert np.abs(cut.moved(grid.points[0, :, 1:]) - grid.points[-1, :, 1:]).max() < 1e-14
    assert np.abs(grid.points[:, -1, :, 2] - 1).max() < 1e-14
    foot = grid.points[:, 0]
    assert np.abs(foot[..., 2] - 0.4 * (1 - np.hypot(foot[..., 0], foot[..., 1]))).max() < 2e-4


def test_a_plane_of_symmetry_reaches_a_whole_ball():
    half = gallery.six_patches(9).to_mesh()
    half = half.selected((half.points[half.get("quad")][:, :, 2] > -1e-9).all(axis=1)).compacted()
    half = half.with_points(np.where(np.abs(half.points) < 1e-9, 0.0, half.points))
    mesh, report = mc.hyperbolic_volume(half, outer=ball(3), first_height=0.01)
    layers = layers_of(mesh, read_surface(half).graph.points)
    rim = layers[0, :, 2] == 0
    assert report.converged and rim.sum() == 32
    assert np.abs(layers[:, rim, 2]).max() == 0
    assert FacetedSurface(ball(3)).closest(layers[-1]).distance.max() < 1e-9


def test_layers_may_end_inside():
    blocks, report = mc.hyperbolic_volume(
        gallery.six_patches(9), outer=ball(0.3, (0.1, 0, 0)), first_height=0.01, other_side=True
    )
    assert report.converged
    for block in blocks.blocks:
        assert quality.validate(block) == []


def test_where_it_cannot_be_reached_is_told():
    surface = body("inner corner")
    tight = box((-0.3, -0.3, -0.3), (2.4, 2.3, 2.3))
    mesh, report = mc.hyperbolic_volume(surface, outer=tight, first_height=0.01)
    assert not report.converged and "on its way to the outer surface" in report.warnings[-1]
    assert quality.validate(mesh) == [] and (quality.measure(solid(mesh), "jacobian") > 0).all()


@pytest.mark.filterwarnings("error")
def test_a_shell_that_lines_pass_by_is_told():
    u, v = np.meshgrid(np.linspace(0, 1, 6), np.linspace(0, 1, 6), indexing="ij")
    plate = mc.StructuredGrid(np.stack([u, v, 0 * u], axis=-1))
    aside = mc.Mesh(np.array([[0, 0, 5.0], [0.1, 0, 5], [0, 0.1, 5]]), {"triangle": [[0, 1, 2]]})
    _, report = mc.hyperbolic_volume(plate, outer=aside, first_height=0.05, layers=6)
    assert not report.converged and "on its way to the outer surface" in report.warnings[-1]


def test_surfaces_that_do_not_fit_are_refused():
    inner = gallery.six_patches(5)
    for outer, match in (
        (ball(3, (10, 0, 0)), "does not go round"),
        (mc.Mesh(np.eye(3), {"line": [[0, 1]]}), "needs triangles or quads"),
        (inner, "touches the surface"),
    ):
        with pytest.raises(InvalidInput, match=match):
            mc.hyperbolic_volume(inner, outer=outer, first_height=0.01)
    two = mc.MultiBlock(tuple(mc.StructuredGrid(b.points + [s, 0, 0]) for s in (0, 5) for b in inner.blocks))
    with pytest.raises(InvalidInput, match="2 parts"):
        mc.hyperbolic_volume(two, outer=ball(20), first_height=0.01)


@pytest.mark.parametrize(
    "arguments", [{"distance": 1.0}, {"largest_height": 0.1}, {"first_height": 5.0}, {"growth": 1.0}]
)
def test_heights_that_it_contradicts_are_refused(arguments):
    with pytest.raises(InvalidInput):
        mc.hyperbolic_volume(gallery.six_patches(5), outer=ball(3), **{"first_height": 0.01, **arguments})


def test_one_layer_and_two():
    for layers in (1, 2):
        blocks, report = mc.hyperbolic_volume(gallery.six_patches(5), outer=ball(3), first_height=0.1, layers=layers)
        assert report.converged and blocks.blocks[0].shape[2] == layers + 1


def test_it_can_be_cancelled_on_the_way():
    with pytest.raises(Cancelled):
        mc.hyperbolic_volume(
            gallery.six_patches(5), outer=ball(3), first_height=0.1, progress=lambda done, _: done < 0.4
        )
