"""A user's whole path, step after step: airfoil, mesh, quality in colour, screenshot, files, state, state again."""

# ruff: noqa: F403, F405  (the star import is how users' scripts for ParaView begin)

from __future__ import annotations

import numpy as np
from datasets import arrays, content, fetched
from harness import OUT, PLUGIN, run_checks, save
from paraview.simple import *
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGReader

LoadPlugin(str(PLUGIN), remote=False, ns=globals())
STATE = str(OUT / "state.pvsm")
PICTURE = str(OUT / "paraview.png")
KEPT = {}


def check_1_mesh_an_airfoil():
    airfoil = meshcoreAirfoil(registrationName="airfoil", Section="rae2822", FarField=3, FarFieldPoints=24)
    mesh = meshcoreDelaunayRefinement(registrationName="mesh", Input=airfoil, MinAngle=28)
    dataset = fetched(mesh)
    assert dataset.GetClassName() == "vtkUnstructuredGrid" and dataset.GetNumberOfCells() > 200
    assert "region" in arrays(dataset.GetCellData())
    KEPT["cells"] = dataset.GetNumberOfCells()


def check_2_look_at_its_quality():
    quality = meshcoreMeshQuality(registrationName="quality", Input=FindSource("mesh"), Measure="min_angle")
    values = arrays(fetched(quality).GetCellData())["min_angle"]
    assert len(values) == KEPT["cells"]
    assert np.median(values) > 35 and values.max() <= 60


def check_3_refine_where_the_triangles_are_worst():
    finer = meshcoreAdaptiveRefinement(registrationName="finer", Input=FindSource("quality"), Indicator="min_angle")
    assert "min_angle" in finer.GetProperty("Indicator").Available
    assert KEPT["cells"] < fetched(finer).GetNumberOfCells() < 4 * KEPT["cells"]


def check_4_wrap_an_o_grid_around_it():
    section = meshcoreAirfoil(registrationName="section", Section="rae2822", FarField=0)
    grid = meshcoreOGrid(registrationName="grid", Section=section, Radius=3, FirstHeight=0.01, Growth=1.3)
    dataset = fetched(grid)
    assert dataset.GetClassName() == "vtkStructuredGrid"
    ni, nj, nk = (high + 1 for high in dataset.GetExtent()[1::2])
    assert ni == fetched(section).GetNumberOfCells() + 1 and nj > 5 and nk == 1


def check_5_take_a_picture():
    quality = FindSource("quality")
    view = CreateRenderView(ViewSize=[900, 600])
    view.UseColorPaletteForBackground = 0
    view.Background = [1, 1, 1]
    view.OrientationAxesVisibility = 0
    display = Show(quality, view)
    display.SetRepresentationType("Surface With Edges")
    ColorBy(display, ("CELLS", "min_angle"))
    display.SetScalarBarVisibility(view, True)
    bar = GetScalarBar(GetColorTransferFunction("min_angle"), view)
    bar.Title, bar.ComponentTitle = "smallest angle (degree)", ""
    bar.TitleColor = bar.LabelColor = [0, 0, 0]
    Render(view)
    view.CameraParallelProjection = 1
    view.CameraPosition, view.CameraFocalPoint = [0.5, 0, 10], [0.5, 0, 0]
    view.CameraParallelScale = 0.62
    Render(view)
    SaveScreenshot(PICTURE, view)
    reader = vtkPNGReader()
    reader.SetFileName(PICTURE)
    reader.Update()
    pixels = vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars()).reshape(600, 900, -1)[:, :, :3]
    colours = np.unique(pixels.reshape(-1, 3), axis=0)
    assert len(colours) > 100, "one colour for all: nothing was drawn"
    middle = pixels[290:310, 420:480].reshape(-1, 3)
    assert (middle == 255).all(axis=1).mean() > 0.9, "the airfoil itself must be empty"
    assert (pixels[100:500, 100:300].reshape(-1, 3) == 255).all(axis=1).mean() < 0.1, "the mesh must be there"


def check_6_save_data_and_read_them_again():
    for name, extension, reader in (
        ("mesh", "vtu", XMLUnstructuredGridReader),
        ("grid", "vts", XMLStructuredGridReader),
    ):
        path = str(OUT / f"{name}.{extension}")
        save(path, FindSource(name))
        again, before = fetched(reader(FileName=[path])), fetched(FindSource(name))
        np.testing.assert_array_equal(content(again)[0], content(before)[0])
        assert content(again)[1].keys() == content(before)[1].keys()
        assert arrays(again.GetCellData()).keys() == arrays(before.GetCellData()).keys()


def check_7_the_state_brings_everything_back():
    FindSource("grid").Cut = 5
    SaveState(STATE)
    wanted = {name: panel(name) for name in ("airfoil", "mesh", "quality", "finer", "grid")}
    ResetSession()
    assert FindSource("mesh") is None
    LoadPlugin(str(PLUGIN), remote=False, ns=globals())
    LoadState(STATE)
    for name, properties in wanted.items():
        assert panel(name) == properties, name
    assert wanted["mesh"]["MinAngle"] == "28.0" and wanted["grid"]["Cut"] == "5"
    assert wanted["quality"]["Measure"] == wanted["finer"]["Indicator"] == "'min_angle'"
    assert fetched(FindSource("mesh")).GetNumberOfCells() == KEPT["cells"]


def panel(name):
    """All values of a filter's panel but its inputs, as they print."""
    proxy = FindSource(name)
    inputs = ("Input", "Section", "Outer")
    return {key: repr(proxy.GetPropertyValue(key)) for key in proxy.ListProperties() if key not in inputs}


if __name__ == "__main__":
    run_checks(globals())
