"""Four sides as ParaView's users have them: several sources, polylines appended, splines, tables, grids to smooth."""

# ruff: noqa: F403, F405  (the star import is how users' scripts for ParaView begin)

from __future__ import annotations

import numpy as np
from datasets import arrays, fetched, polylines, producer
from harness import PLUGIN, run_checks
from paraview.simple import *
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkPolyData

LoadPlugin(str(PLUGIN), remote=False, ns=globals())
CIRCLE = np.column_stack([np.cos(t := np.linspace(0, 2 * np.pi, 33)), np.sin(t), 0 * t])


def sides():
    """Sources of the four sides of a 2 x 1 box."""
    south = Line(Point1=(0, 0, 0), Point2=(2, 0, 0), Resolution=16)
    east = Line(Point1=(2, 0, 0), Point2=(2, 1, 0), Resolution=8)
    north = Line(Point1=(0, 1, 0), Point2=(2, 1, 0), Resolution=16)
    return south, east, north, Line(Point1=(0, 0, 0), Point2=(0, 1, 0), Resolution=8)


def corners_of(dataset):
    """The four corner points of a structured surface."""
    ni, nj, _ = dataset.GetDimensions()
    points = vtk_to_numpy(dataset.GetPoints().GetData()).reshape(nj, ni, 3)[[0, 0, -1, -1], [0, -1, 0, -1]]
    return {tuple(point) for point in points.round(5).tolist()}


def on_circle(*numbers):
    return {tuple(CIRCLE[k].round(5).tolist()) for k in numbers}


def check_four_sources_with_a_wall_by_name():
    south, east, north, west = sides()
    grid = meshcoreEllipticGrid(
        South=south, East=east, North=north, West=west, Walls="south", FirstHeight=0.01, CellsI=30, CellsJ=20
    )
    dataset = fetched(grid)
    assert dataset.GetClassName() == "vtkStructuredGrid" and dataset.GetDimensions() == (31, 21, 1)
    assert arrays(dataset.GetFieldData())["error of first heights (%)"] < 5
    names = dataset.GetFieldData().GetAbstractArray("face_names")
    face = 1 + [names.GetValue(k) for k in range(6)].index("south")
    at_south = vtk_to_numpy(dataset.GetPoints().GetData())[arrays(dataset.GetPointData())["face"] == face]
    assert len(at_south) >= 29 and (at_south[:, 1] == 0).all()  # seen and picked; a corner belongs to one of two sides


def check_sides_appended_to_one():
    assert fetched(meshcoreEllipticGrid(South=AppendGeometry(Input=list(sides())))).GetDimensions() == (17, 9, 1)


def check_a_spline_as_a_side():
    spline = SplineSource()
    spline.ParametricFunction.Points = [0, 0, 0, 1, 0.3, 0, 2, 0, 0]
    _, east, north, west = sides()
    grid = meshcoreEllipticGrid(South=spline, East=east, North=north, West=west, CellsI=20, CellsJ=10)
    assert fetched(grid).GetDimensions() == (21, 11, 1)


def check_ends_of_polylines_are_corners():
    arcs = polylines(*(CIRCLE[a : b + 1] for a, b in ((0, 6), (6, 16), (16, 25), (25, 32))))
    grid = meshcoreTransfiniteInterpolation(South=producer(arcs), CellsI=8, CellsJ=8)
    assert corners_of(fetched(grid)) == on_circle(0, 6, 16, 25)


def check_points_in_order_as_from_a_table():
    points = vtkPolyData()
    points.SetPoints(polylines(CIRCLE).GetPoints())
    grid = meshcoreEllipticGrid(South=producer(points), CellsI=8, CellsJ=8)
    assert corners_of(fetched(grid)) == on_circle(0, 8, 16, 24)
    grid.ShiftCorners = [0, 1, 0, -2]
    assert corners_of(fetched(grid)) == on_circle(0, 9, 16, 22)


if __name__ == "__main__":
    run_checks(globals())
