"""Grids on curved surfaces: structured grids smoothed on their own, and patches on a second input."""

from __future__ import annotations

import numpy as np
import paraview.simple as pv
from datasets import content, dimensions, fetched, of_mesh, points_of, polylines, producer
from harness import load_plugin, run_checks, said
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet, vtkStructuredGrid

import meshcore
from meshcore import gallery
from meshcore.structured.algebraic.quad_nets import grid_of

load_plugin()


def structured(grid):
    dataset = vtkStructuredGrid()
    dataset.SetDimensions(*grid.shape)
    dataset.SetPoints(points_of(grid.flat(grid.points)))
    return dataset


def assert_is(proxy, grid):
    dataset = fetched(proxy)
    assert dimensions(dataset) == grid.shape
    np.testing.assert_allclose(content(dataset)[0], grid.flat(grid.points), atol=1e-12)


def four_sides():
    return [producer(polylines(side.tolist())) for side in gallery.sides_on_torus(12, 10)]


def check_a_curved_structured_grid_is_smoothed_on_its_own_surface():
    tube = grid_of(gallery.rough_tube(24, 10), "grid")
    assert_is(pv.meshcoreEllipticSmoothing(Input=producer(structured(tube))), meshcore.elliptically_smoothed(tube).mesh)


def check_a_curved_structured_grid_is_smoothed_on_a_second_input():
    tube = grid_of(gallery.rough_tube(24, 10), "grid")
    fine = gallery.rough_tube(64, 24)
    proxy = pv.meshcoreEllipticSmoothing(Input=producer(structured(tube)), Surface=producer(of_mesh(fine)))
    assert_is(proxy, meshcore.elliptically_smoothed(tube, fine).mesh)
    proxy.Surface = producer(structured(grid_of(fine, "grid")))
    assert_is(proxy, meshcore.elliptically_smoothed(tube, grid_of(fine, "grid")).mesh)


def check_a_patch_between_curves_lies_on_an_input_of_its_own():
    south, east, north, west = four_sides()
    scan = gallery.bumpy_torus(48, 24)
    for proxy, function in (
        (pv.meshcoreTransfiniteInterpolation, meshcore.transfinite),
        (pv.meshcoreEllipticGrid, meshcore.elliptic),
    ):
        filled = proxy(South=south, East=east, North=north, West=west, Surface=producer(of_mesh(scan)))
        assert_is(filled, function(*gallery.sides_on_torus(12, 10), surface=scan).mesh)


def check_a_sphere_of_paraviews_own_is_a_surface():
    sphere = pv.Sphere(Radius=1.0, ThetaResolution=48, PhiResolution=24)
    angle = np.linspace(0, 1, 9)
    low, high = np.full(9, -0.5), np.full(9, 0.6)

    def line(u, v):
        return producer(polylines(np.column_stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)]).tolist()))

    up = low + 1.1 * angle
    sides = {"South": line(angle, low), "East": line(0 * angle + 1, up), "North": line(angle, high)}
    dataset = fetched(pv.meshcoreEllipticGrid(**sides, West=line(0 * angle, up), Surface=sphere))
    radius = np.linalg.norm(content(dataset)[0], axis=1)
    assert dimensions(dataset) == (9, 9, 1)
    assert radius.min() > 0.98 and radius.max() < 1 + 1e-6


def check_curves_in_place_of_a_surface_are_refused():
    south, east, north, west = four_sides()
    with said() as text:
        pv.meshcoreEllipticGrid(South=south, East=east, North=north, West=west, Surface=south).UpdatePipeline()
    lines = [line for line in text[0].splitlines() if "ERR| meshcore " in line]
    assert len(lines) == 1 and "surface: needs triangles or quads" in lines[0], text[0]


def check_blocks_are_extruded_as_one_surface():
    patches = gallery.six_patches(9)
    blocks, nested = vtkMultiBlockDataSet(), vtkMultiBlockDataSet()
    for k, patch in enumerate(patches.blocks):
        (nested if k else blocks).SetBlock(k, structured(patch))
    blocks.SetBlock(1, nested)
    proxy = pv.meshcoreExtrudeHyperbolic(Input=producer(blocks), FirstHeight=0.01, Layers=4)
    wanted = meshcore.with_named_sides(meshcore.hyperbolic_volume(patches, first_height=0.01, layers=4).mesh)
    dataset = fetched(proxy)
    assert dataset.GetNumberOfCells() == wanted.n_cells
    made, asked = (np.unique(np.round(points, 9), axis=0) for points in (content(dataset)[0], wanted.points))
    assert len(made) == dataset.GetNumberOfPoints()  # none is there twice, where blocks meet
    np.testing.assert_allclose(made, asked, atol=1e-8)


def check_where_layers_stop_is_an_array():
    front = gallery.airfoil("naca0012")
    farther = {"first_height": 0.01, "distance": 1.0, "other_side": True}  # than there is room inside
    grid, report = meshcore.hyperbolic(front, **farther)
    assert not report.converged
    proxy = pv.meshcoreHyperbolicGrid(Front=producer(of_mesh(front)), FirstHeight=0.01, Distance=1.0, OtherSide=1)
    at_points = content(fetched(proxy))[3]
    np.testing.assert_array_equal(at_points["stopped"], grid.flat(grid.point_data["stopped"]))
    places = grid.point_data["stopped"].sum()  # two on a cut, where the first line is the last, else one
    assert places in (1, 2)
    pv.SelectPoints(query="stopped > 0", proxy=proxy)
    assert fetched(pv.ExtractSelection(Input=proxy)).GetNumberOfPoints() == places


if __name__ == "__main__":
    run_checks(globals())
