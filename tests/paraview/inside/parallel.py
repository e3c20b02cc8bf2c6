"""Two ranks, each running this script: ``mpirun -np 2 pvbatch --sym``."""

from __future__ import annotations

import paraview.simple as pv
from datasets import of_mesh, producer
from harness import OUT, input_names, load_plugin, rank, run_checks, save
from vtkmodules.vtkCommonCore import vtkIntArray
from vtkmodules.vtkParallelCore import vtkCommunicator, vtkMultiProcessController

import meshcore
from meshcore import gallery

load_plugin()


def cells_here(proxy):
    """Cells of this rank's piece."""
    return proxy.GetClientSideObject().GetOutputDataObject(0).GetNumberOfCells()


def cells_in_all(proxy):
    """Cells of all ranks' pieces; every rank must ask."""
    mine, total = vtkIntArray(), vtkIntArray()
    mine.InsertNextValue(cells_here(proxy))
    vtkMultiProcessController.GetGlobalController().AllReduce(mine, total, vtkCommunicator.SUM_OP)
    return total.GetValue(0)


def assert_all_on_rank_0(proxy, cells):
    proxy.UpdatePipeline()
    wanted = 0 if rank() else cells
    assert cells_here(proxy) == wanted, f"{cells_here(proxy)} cells in place of {wanted}"


def distributed_square():
    """A square of 20 x 20 cells, half of it on each rank."""
    image = pv.Wavelet(WholeExtent=[-10, 10, -10, 10, 0, 0])
    surface = pv.ExtractSurface(Input=image)
    surface.UpdatePipeline()
    assert cells_here(surface) == 200, "the input is not distributed, so that the check shows nothing"
    return surface


def check_every_operation(operation):
    inputs, keywords = gallery.arguments(operation)
    entry = meshcore.operations()[operation]
    mesh = entry.function(*inputs, **keywords).mesh
    sources = dict(zip(input_names(entry), (producer(of_mesh(m)) for m in inputs), strict=False))
    shown = {name.title().replace("_", ""): value for name, value in keywords.items()}
    create = getattr(pv, "meshcore" + entry.label.replace(" ", ""))
    assert_all_on_rank_0(create(**sources, **shown), mesh.n_cells)


def check_whole_of_a_distributed_input_is_meshed():
    proxy = pv.meshcoreTransfiniteInterpolation(South=distributed_square(), CellsI=20, CellsJ=20)
    assert_all_on_rank_0(proxy, 400)
    bounds = proxy.GetClientSideObject().GetOutputDataObject(0).GetBounds()
    assert rank() or bounds == (-10, 10, -10, 10, 0, 0), bounds  # not the half that lies on this rank


def check_a_filter_feeds_the_next():
    first = pv.meshcoreTransfiniteInterpolation(South=distributed_square(), CellsI=6, CellsJ=5)
    assert_all_on_rank_0(pv.meshcoreTransfiniteInterpolation(South=first), 30)


def check_source():
    assert_all_on_rank_0(pv.meshcoreModel(Model="Square", Resolution=7), 28)


def check_quality_stays_distributed():
    proxy = pv.meshcoreMeshQuality(Input=distributed_square())
    proxy.UpdatePipeline()
    assert cells_here(proxy) == 200 and cells_in_all(proxy) == 400
    assert proxy.CellData["min_angle"].GetRange() == (90, 90)


def check_saved_in_parallel_and_read_again():
    proxy = pv.meshcoreTransfiniteInterpolation(South=distributed_square(), CellsI=8, CellsJ=4)
    path = str(OUT / "parallel.pvts")
    save(path, proxy)
    vtkMultiProcessController.GetGlobalController().Barrier()  # each rank writes its piece, and one of them the whole
    reader = pv.XMLPartitionedStructuredGridReader(FileName=[path])
    reader.UpdatePipeline()
    assert cells_in_all(reader) == 32


def check_error_on_both_ranks_leaves_them_alive():
    proxy = pv.meshcoreTransfiniteInterpolation(South=pv.Sphere())
    proxy.UpdatePipeline()
    assert cells_in_all(proxy) == 0
    assert_all_on_rank_0(pv.meshcoreModel(Model="Square", Resolution=3), 12)


if __name__ == "__main__":
    run_checks(globals())
