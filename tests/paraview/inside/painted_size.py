"""Refinement and curves by point arrays of the input, or of a second input."""

from __future__ import annotations

import numpy as np
import paraview.simple as pv
from datasets import content, fetched, of_mesh, producer
from harness import load_plugin, run_checks, said

import meshcore
from meshcore import Mesh, gallery

load_plugin()
BIG = Mesh(
    [[-1, -1], [4, -1], [-1, 4]],
    {"triangle": [[0, 1, 2]]},
    {"coarse": np.array([0.2, 0.2, 0.2]), "h": np.array([0.04, 0.29, 0.04])},
)


def domain_of(proxy, name):
    """What the panel's list offers for a property."""
    domain = proxy.SMProxy.GetProperty(name).FindDomain("vtkSMStringListDomain")
    return [domain.GetString(k) for k in range(domain.GetNumberOfStrings())]


def assert_same(proxy, mesh):
    points, *_ = content(fetched(proxy))
    np.testing.assert_allclose(points, mesh.points, atol=1e-12)
    assert proxy.GetDataInformation().GetNumberOfCells() == mesh.n_cells


def complaint(proxy):
    with said() as text:
        proxy.UpdatePipeline()
    lines = [line for line in text[0].splitlines() if "ERR| meshcore " in line]
    assert len(lines) == 1 and "Traceback" not in text[0], text[0]
    return lines[0]


def check_point_array_of_the_input():
    square = gallery.square(2)
    square = square.with_point_data(h=0.05 + 0.2 * square.points[:, 0])
    proxy = pv.meshcoreDelaunayRefinement(Input=producer(of_mesh(square)), SizeArray="h")
    assert_same(proxy, meshcore.delaunay_refinement(square, size_array="h").mesh)


def check_point_array_of_the_second_input():
    outline = gallery.square_with_hole()
    proxy = pv.meshcoreDelaunayRefinement(Input=producer(of_mesh(outline)), Background=producer(of_mesh(BIG)))
    proxy.BackgroundSizeArray = "h"
    assert_same(proxy, meshcore.delaunay_refinement(outline, BIG, size_array="h").mesh)
    proxy.BackgroundSizeArray = "coarse"
    proxy.Gradation = 0.3
    assert_same(proxy, meshcore.delaunay_refinement(outline, BIG, size_array="coarse", gradation=0.3).mesh)


def check_the_lists_offer_the_arrays_of_their_own_input():
    square = gallery.square(2).with_point_data(mine=np.ones(8))
    proxy = pv.meshcoreDelaunayRefinement(Input=producer(of_mesh(square)), Background=producer(of_mesh(BIG)))
    proxy.UpdatePipelineInformation()
    assert domain_of(proxy, "SizeArray") == ["None", "mine"]
    assert domain_of(proxy, "BackgroundSizeArray") == ["None", "coarse", "h"]


def check_an_array_calculated_in_paraview():
    outline = producer(of_mesh(gallery.square(2)))
    plane = pv.Plane(Origin=[-1, -1, 0], Point1=[2, -1, 0], Point2=[-1, 2, 0], XResolution=6, YResolution=6)
    size = pv.Calculator(Input=plane, ResultArrayName="size", Function="0.05 + 0.1*coordsX*coordsX")
    proxy = pv.meshcoreDelaunayRefinement(Input=outline, Background=size, BackgroundSizeArray="size")
    points, cells, *_ = content(fetched(proxy))
    corners = points[cells["triangle"]]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    assert (longest <= 0.05 + 0.1 * (corners.mean(axis=1)[:, 0] ** 2 + 0.25 / 4) + 1e-6).all()
    assert len(longest) > 500


def check_a_curve_is_divided_by_a_background():
    outline = gallery.square_with_hole()
    proxy = pv.meshcoreDiscretisedCurve(Input=producer(of_mesh(outline)), Background=producer(of_mesh(BIG)))
    proxy.BackgroundSizeArray = "h"
    assert_same(proxy, meshcore.discretised(outline, BIG, size_array="h").mesh)


def check_what_is_wrong_is_said_in_one_line():
    outline = producer(of_mesh(gallery.square(2).with_point_data(zero=np.zeros(8))))
    text = complaint(pv.meshcoreDelaunayRefinement(Input=outline, SizeArray="zero"))
    assert "'zero' is 0 at point 0" in text and "[at (0, 0, 0)" in text, text
    background = producer(of_mesh(BIG))
    text = complaint(pv.meshcoreDelaunayRefinement(Input=outline, Background=background))
    assert "name the point array of the background" in text and "coarse, h" in text, text
    tiny = producer(of_mesh(BIG.with_point_data(h=np.full(3, 1e-7))))
    text = complaint(pv.meshcoreDelaunayRefinement(Input=outline, Background=tiny, BackgroundSizeArray="h"))
    assert "triangles; at most" in text and "smallest size is 1e-07, at (" in text, text


run_checks(globals())
