"""What users get wrong: each is answered by one line, and the pipeline lives on."""

from __future__ import annotations

import inspect
from itertools import pairwise

import numpy as np
import paraview.simple as pv
from datasets import fetched, polylines, producer, unstructured
from harness import OUT, load_plugin, run_checks, said
from vtkmodules.vtkCommonCore import VTK_FLOAT
from vtkmodules.vtkCommonDataModel import vtkPolyData

load_plugin()
NAN = float("nan")
SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 0)]


def complaint(proxy):
    """The one line that an update, or already making the proxy, says; the result is empty, and no traceback shows."""
    with said() as text:
        proxy = proxy() if inspect.isfunction(proxy) else proxy
        proxy.UpdatePipeline()
    lines = [line for line in text[0].splitlines() if "ERR| meshcore " in line]
    assert len(lines) == 1, text[0]
    assert "Traceback" not in text[0], text[0]
    assert proxy.GetDataInformation().GetNumberOfCells() == 0
    return lines[0].split("ERR| ")[1]


def transfinite(dataset, **values):
    source = producer(dataset) if isinstance(dataset, vtkPolyData) or hasattr(dataset, "GetPointData") else dataset
    return pv.meshcoreTransfiniteInterpolation(South=source, **values)


def check_empty_polydata():
    assert "south: needs lines" in complaint(transfinite(vtkPolyData()))


def check_points_without_cells():
    data = polylines(SQUARE[:4])
    data.SetLines(None)
    assert "south: is open" in complaint(transfinite(data))  # points in order are a curve, and these do not close
    text = complaint(pv.meshcoreDelaunayRefinement(Input=producer(data)))
    assert "boundary: needs lines" in text and "4 points without cells" in text, text


def check_closed_surface_in_place_of_lines():
    assert "got 96 triangle cells" in complaint(transfinite(pv.Sphere()))


def check_volume_in_place_of_lines():
    tetra = unstructured([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(10, (0, 1, 2, 3))])
    text = complaint(transfinite(tetra))
    assert "south: needs lines" in text and "got 1 tetra cells" in text, text


def check_image_volume():
    text = complaint(transfinite(pv.Wavelet()))
    assert "got 8000 hexahedron cells" in text, text


def check_unknown_kind_of_cell():
    cube = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    hexagon = [(0, 0, 0), (1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 2, 0), (-1, 1, 0)]
    prism = unstructured([*hexagon, *((x, y, 1) for x, y, _ in hexagon), *cube], [(16, range(12))])
    assert "VTK type 16" in complaint(transfinite(prism))


def check_not_a_number_in_points():
    loop = [SQUARE[0], (NAN, 0, 0), *SQUARE[2:]]
    text = complaint(transfinite(polylines(loop)))
    assert "point 1 is [nan, 0.0, 0.0]" in text, text


def check_several_pieces():
    other = [(x + 5, y, z) for x, y, z in SQUARE]
    text = complaint(transfinite(polylines(SQUARE, other)))
    assert "south: needs one closed loop or four chains of line cells, got 2" in text, text
    assert "[at (" in text, text  # says where


def check_open_line_alone():
    assert "south: is open" in complaint(transfinite(polylines(SQUARE[:3])))


def check_sides_that_do_not_meet():
    sides = [polylines([a, b]) for a, b in pairwise(SQUARE)]
    sides[1] = polylines([(7, 0, 0), (7, 1, 0)])
    names = ("South", "East", "North", "West")
    proxy = pv.meshcoreTransfiniteInterpolation(**dict(zip(names, map(producer, sides), strict=True)))
    assert "end 6 apart" in complaint(proxy)


def check_ranges_violated_by_script():
    text = complaint(transfinite(polylines(SQUARE), CellsI=-3))
    assert "cells_i: must be at least 1, got -3" in text, text


def check_absurd_corners():
    text = complaint(transfinite(polylines(SQUARE), CellsI=2, CellsJ=2, Corners=[0, 0, 1, 99]))
    assert "corners: needs four different points" in text, text


def check_section_that_is_not_planar():
    loop = [(0, 0, 0), (1, 0, 0.4), (1, 1, 0), (0, 1, 0.4), (0, 0, 0)]
    text = complaint(pv.meshcoreOGrid(Section=producer(polylines(loop))))
    assert "plane" in text or "planar" in text, text


def check_section_that_crosses_itself():
    bow = [(0, 0, 0), (1, 1, 0), (1, 0, 0), (0, 1, 0), (0, 0, 0)]
    assert complaint(pv.meshcoreOGrid(Section=producer(polylines(bow))))


def delaunay(dataset, **values):
    source = producer(dataset) if hasattr(dataset, "GetPointData") else dataset
    return pv.meshcoreDelaunayRefinement(Input=source, **values)


def check_sphere_to_delaunay_refinement():
    assert "boundary: needs lines" in complaint(delaunay(pv.Sphere()))


def check_volume_to_delaunay_refinement():
    assert "boundary: needs lines" in complaint(delaunay(pv.Wavelet(WholeExtent=[0, 3, 0, 3, 0, 3])))


def check_loop_that_is_not_planar():
    loop = [(0, 0, 0), (1, 0, 0.4), (1, 1, 0), (0, 1, 0.4), (0, 0, 0)]
    text = complaint(delaunay(polylines(loop)))
    assert "plan" in text and "0.2" in text, text  # names the deviation


def check_open_loop_to_delaunay_refinement():
    assert complaint(delaunay(polylines(SQUARE[:3])))


def check_empty_input_to_delaunay_refinement():
    assert "boundary: needs lines" in complaint(delaunay(vtkPolyData()))


def check_all_points_in_one_line():
    assert complaint(delaunay(polylines([(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 0, 0)])))


def check_angle_out_of_range():
    text = complaint(delaunay(polylines(SQUARE), MinAngle=50))
    assert "min_angle: must be at most" in text, text


def check_size_that_is_not_a_number():
    assert "size: " in complaint(delaunay(polylines(SQUARE), Size=NAN))


def check_repeated_points_and_lines_are_no_error():
    doubled = [SQUARE[0], SQUARE[0], *SQUARE[1:]]
    assert fetched(delaunay(polylines(doubled, SQUARE))).GetNumberOfCells() >= 2


def check_unknown_array():
    model = pv.meshcoreModel(Model="Triangulated Square")
    text = complaint(pv.meshcoreAdaptiveRefinement(Input=model, Indicator="pressure"))
    assert "pressure" in text and "front" in text, text  # names what there is


def check_lines_to_adaptive_refinement():
    assert "triangle" in complaint(pv.meshcoreAdaptiveRefinement(Input=pv.meshcoreModel(Model="Square")))


def check_volume_to_adaptive_refinement():
    wavelet = pv.Wavelet(WholeExtent=[0, 3, 0, 3, 0, 3])
    assert "triangle" in complaint(pv.meshcoreAdaptiveRefinement(Input=wavelet))


def check_indicator_with_a_hole():
    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)]
    mesh = unstructured(points, [(5, (0, 1, 2)), (5, (1, 3, 2))], {"error": np.array([1.0, NAN])})
    assert complaint(pv.meshcoreAdaptiveRefinement(Input=producer(mesh), Indicator="error"))


def check_single_precision_is_planar_enough():
    tilted = [(0.1 * k, (0.1 * k) ** 2, 0.3 * k) for k in range(7)]
    data = polylines([*tilted, (0.9, 0.1, 1.2), tilted[0]], data_type=VTK_FLOAT)
    proxy = transfinite(data, CellsI=6, CellsJ=5)
    assert fetched(proxy).GetNumberOfCells() == 30


def check_pipeline_lives_on_after_an_error():
    proxy = transfinite(polylines(SQUARE), CellsI=-3)
    complaint(proxy)
    proxy.CellsI, proxy.CellsJ = 4, 3
    assert fetched(proxy).GetNumberOfCells() == 12


def check_error_does_not_touch_the_input():
    source = producer(polylines(SQUARE))
    complaint(pv.meshcoreTransfiniteInterpolation(South=source, CellsI=-3))
    assert fetched(source).GetNumberOfPoints() == 5


def check_airfoil_file_that_is_missing():
    text = complaint(pv.meshcoreAirfoil(CoordinateFile="/nowhere/wing.dat"))
    assert "/nowhere/wing.dat does not exist" in text, text


def check_airfoil_file_that_is_something_else():
    path = OUT / "wing.dat"
    path.write_text("this is\nnot an airfoil\nat all\n")
    assert "wing.dat" in complaint(pv.meshcoreAirfoil(CoordinateFile=str(path)))


def check_airfoil_far_field_too_small():
    text = complaint(pv.meshcoreOGrid(Section=pv.meshcoreAirfoil(FarField=0), Radius=-1))
    assert "radius: must be at least" in text, text


def check_model_of_no_name():
    text = complaint(pv.meshcoreModel(Model="Teapot"))
    assert "'Teapot' is not one of Square" in text, text


def check_reader_of_a_cut_off_file():
    path = OUT / "cut.poly"
    path.write_text("5 2 0 0\n1 0 0\n2 1 0\n")
    assert "cut.poly" in complaint(lambda: pv.meshcoreReader(FileName=str(path)))


def check_quality_of_no_such_measure():
    with said() as text:
        pv.meshcoreMeshQuality(Input=pv.Sphere(), Measure="beauty").UpdatePipeline()
    assert "'beauty'" in text[0] and "Traceback" not in text[0], text[0]


def check_writer_of_cells_that_the_format_lacks():
    wedge = pv.meshcoreModel(Model="Triangulated Square")
    path = OUT / "model.dat"
    with said() as text:
        pv.SaveData(str(path), proxy=wedge)
    assert "ERR| meshcore Writer: " in text[0] and "Traceback" not in text[0], text[0]
    assert not path.exists()


if __name__ == "__main__":
    run_checks(globals())
