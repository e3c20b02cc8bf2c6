"""A client of a pvserver on the port named by PORT."""

from __future__ import annotations

import os

import numpy as np
import paraview.simple as pv
from datasets import content, dimensions, fetched
from harness import OUT, load_plugin, run_checks, save

from meshcore import gallery, transfinite

pv.Connect("localhost", int(os.environ["PORT"]))
load_plugin(remote=True)  # to run on the server
load_plugin()  # to be known to the client


def check_model_is_made_on_the_server():
    source = pv.meshcoreModel(Model="L Shape", Resolution=3)
    points = content(fetched(source))[0]
    np.testing.assert_array_equal(points, gallery.l_shape(3).points)
    assert source.GetClientSideObject() is None  # it lives in the other process


def check_filter_runs_on_the_server():
    proxy = pv.meshcoreTransfiniteInterpolation(South=pv.meshcoreModel(Model="Square", Resolution=4))
    grid, _ = transfinite(gallery.square(4))
    dataset = fetched(proxy)
    assert dimensions(dataset) == grid.shape
    np.testing.assert_array_equal(content(dataset)[0], grid.flat(grid.points))


def check_error_on_the_server_leaves_it_alive():
    bad = pv.meshcoreTransfiniteInterpolation(South=pv.Sphere())
    bad.UpdatePipeline()
    assert bad.GetDataInformation().GetNumberOfCells() == 0
    good = pv.meshcoreModel(Model="Square", Resolution=3)
    good.UpdatePipeline()
    assert good.GetDataInformation().GetNumberOfCells() == 12


def check_saved_by_the_server():
    path = str(OUT / "remote.vts")
    save(path, pv.meshcoreTransfiniteInterpolation(South=pv.Plane(XResolution=3, YResolution=2)))
    assert fetched(pv.XMLStructuredGridReader(FileName=[path])).GetNumberOfCells() == 6


if __name__ == "__main__":
    run_checks(globals())
    pv.Disconnect()
