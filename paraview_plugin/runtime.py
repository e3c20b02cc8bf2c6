"""What all of the plugin's sources and filters share: requests of the pipeline, progress, abort, errors."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np
from paraview import print_error, print_warning
from paraview.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonDataModel import vtkCompositeDataSet, vtkDataObject, vtkStructuredGrid
from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm, vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkParallelCore import vtkMultiProcessController

from .conversion import blocks_of, boundary_of, curve_of, fill, fill_report, grid_of, mesh_of
from .meshcore_plugin import paraview_plugin_version  # written by generate.py

NO_ARRAY = "None"
BY_DEFAULT = object()
UNKNOWN_EXTENT = (0, -1, 0, -1, 0, -1)

# Libraries that the installer put beside this file; those that ParaView has itself come first.
if (Path(__file__).parent / "packages").is_dir():
    sys.path.append(str(Path(__file__).parent / "packages"))


class Refused(Exception):
    """The filter cannot do its work; the text is for the user."""


def meshcore_itself():
    """The package meshcore, or `Refused` with the cure. Imported late, so that the plugin loads without it."""
    try:
        import meshcore
        import meshcore.gallery
        import meshcore.io
        import meshcore.quality
    except ImportError as error:
        raise Refused(
            f"ParaView's Python cannot import {error.name or 'meshcore'} ({error}). Run `meshcore install paraview` "
            "and start ParaView again, or put meshcore, numba and llvmlite on PYTHONPATH."
        ) from error
    if meshcore.__version__ != paraview_plugin_version:
        raise Refused(
            f"this plugin belongs to meshcore {paraview_plugin_version}, but ParaView's Python has meshcore "
            f"{meshcore.__version__}. Run `meshcore install paraview` and start ParaView again."
        )
    return meshcore


class Kept(NamedTuple):
    """A structured result, or why there is none, and what its inputs were."""

    key: dict | None = None
    dataset: vtkStructuredGrid | None = None
    error: Exception | None = None
    said: list = []


class Algorithm(VTKPythonAlgorithmBase):
    """Base of all: keeps the properties, runs `make`, and tells its errors in one line.

    A mesh generator needs its whole input, and gives its whole output: both belong to piece 0 of a parallel
    pipeline, the other pieces are empty.
    """

    ports = ()  # of (name, cells, optional): what `conversion` makes of an input depends on its cells
    output = "vtkUnstructuredGrid"
    label = ""

    def __init__(self):
        super().__init__(nInputPorts=len(self.ports), nOutputPorts=1, outputType=self.output)
        self.values = {}
        self.kept = Kept()
        # Only one of several processes is asked whether it is set up; there all work from the start.
        self.set_up = vtkMultiProcessController.GetGlobalController().GetNumberOfProcesses() > 1

    def set(self, name, *values):
        """Keep a property's value, and run again if it is new."""
        value = values[0] if len(values) == 1 else values
        if name not in self.values or self.values[name] != value:
            self.values[name] = value
            self.changed()

    def changed(self):
        """A property is new: what was made with the old one is out of date."""
        self.kept = Kept()
        self.Modified()

    def make(self, inputs):
        """The mesh or grid, and its report or None, of the inputs given by port name."""
        raise NotImplementedError

    # ---- the pipeline's requests

    def FillInputPortInformation(self, port, info):
        info.Set(vtkAlgorithm.INPUT_REQUIRED_DATA_TYPE(), "vtkDataSet")
        if self.ports[port][1] == "blocks":  # without it, VTK would call the filter for one block after the other
            info.Append(vtkAlgorithm.INPUT_REQUIRED_DATA_TYPE(), "vtkCompositeDataSet")
        info.Set(vtkAlgorithm.INPUT_IS_OPTIONAL(), int(self.ports[port][2]))
        return 1

    def RequestInformation(self, request, inInfo, outInfo):
        info = outInfo.GetInformationObject(0)
        info.Set(vtkAlgorithm.CAN_HANDLE_PIECE_REQUEST(), 1)
        if self.output == "vtkStructuredGrid":
            put_extent(info, self.extent_made(inInfo) if self.set_up else UNKNOWN_EXTENT)
        return 1

    def GetSetUp(self):
        """ParaView reads this when a new filter is set up, before its parameters are applied: no time to work yet.

        What it was told of the extent until then would hold until something changes.
        """
        if not self.set_up:
            self.set_up = True
            self.Modified()
        return 1

    def RequestUpdateExtent(self, request, inInfo, outInfo):
        # Piece 0 asks for all, the others for a piece past the end, so that nobody meshes a part as if it were all.
        piece = outInfo.GetInformationObject(0).Get(vtkStreamingDemandDrivenPipeline.UPDATE_PIECE_NUMBER())
        for port in range(len(self.ports)):
            for k in range(inInfo[port].GetNumberOfInformationObjects()):
                info = inInfo[port].GetInformationObject(k)
                info.Set(vtkStreamingDemandDrivenPipeline.UPDATE_PIECE_NUMBER(), min(piece or 0, 1))
                info.Set(vtkStreamingDemandDrivenPipeline.UPDATE_NUMBER_OF_PIECES(), 1)
                info.Set(vtkStreamingDemandDrivenPipeline.UPDATE_NUMBER_OF_GHOST_LEVELS(), 0)
                if info.Has(vtkStreamingDemandDrivenPipeline.WHOLE_EXTENT()):
                    whole = info.Get(vtkStreamingDemandDrivenPipeline.WHOLE_EXTENT())
                    extent = UNKNOWN_EXTENT if piece else whole
                    info.Set(vtkStreamingDemandDrivenPipeline.UPDATE_EXTENT(), extent, 6)
        return 1

    def RequestData(self, request, inInfo, outInfo):
        info = outInfo.GetInformationObject(0)
        if info.Get(vtkStreamingDemandDrivenPipeline.UPDATE_PIECE_NUMBER()):
            return 1
        return self.guarded(self.run, inInfo, info)

    # ---- the work

    def guarded(self, work, *arguments):
        """Do some work; 1 if it went well, else 0 and one line for the user."""
        self.SetAbortExecute(0)  # an abort that came when the last run was done is not meant for this one
        try:
            core = meshcore_itself()
            with warnings.catch_warnings(record=True) as said:
                warnings.simplefilter("always")
                work(*arguments)
        except Refused as error:
            print_error(f"{self.label}: {error}")
            return 0
        except core.Cancelled:
            print_warning(f"{self.label}: aborted, the result is empty")
            return 1
        except core.MeshcoreError as error:
            print_error(f"{self.label}: {error}")
            return 0
        for warning in said:
            if issubclass(warning.category, UserWarning):  # others are for developers
                print_warning(f"{self.label}: {warning.message}")
        return 1

    def run(self, inInfo, info):
        """Make the result from the inputs and put it into the output."""
        output = info.Get(vtkDataObject.DATA_OBJECT())
        if self.output != "vtkStructuredGrid":
            self.work(inInfo, output)
            return
        self.keep(inInfo)
        if self.kept.error is not None:
            error, self.kept = self.kept.error, Kept()
            raise error
        for warning in self.kept.said:
            warnings.warn(warning.message, warning.category, stacklevel=1)
        output.ShallowCopy(self.kept.dataset)
        put_extent(info, output.GetExtent())

    def extent_made(self, inInfo):
        """The extent of a structured result, for which it has to be made.

        ParaView asks for extents before data, and hands on what it was told: of a grid whose extent is told later
        nothing is drawn. Errors are told when the data are asked for.
        """
        piece = min(vtkMultiProcessController.GetGlobalController().GetLocalProcessId(), 1)
        for port in range(len(self.ports)):
            if self.GetNumberOfInputConnections(port):
                self.GetInputAlgorithm(port, 0).UpdatePiece(piece, 1, 0)
        if piece:
            return UNKNOWN_EXTENT
        self.SetAbortExecute(0)
        self.keep(inInfo)
        return UNKNOWN_EXTENT if self.kept.error else self.kept.dataset.GetExtent()

    def keep(self, inInfo):
        """Make the structured result and keep it, unless the one there is belongs to these inputs."""
        key = {name: self.stamp(port, inInfo[port]) for port, (name, _, _) in enumerate(self.ports)}
        if self.kept.key == key:
            return
        dataset, error = vtkStructuredGrid(), None
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            try:
                meshcore_itself()
                self.work(inInfo, dataset)
            except Exception as raised:  # whatever it is, `run` raises it
                error = raised
        self.kept = Kept(key, dataset, error, said)

    def stamp(self, port, infos):
        """When anything before an input was last changed, and the time that its data are of."""
        if not infos.GetNumberOfInformationObjects():
            return None
        dataset = infos.GetInformationObject(0).Get(vtkDataObject.DATA_OBJECT())
        time = dataset.GetInformation().Get(vtkDataObject.DATA_TIME_STEP()) if dataset else None
        return self.GetInputExecutive(port, 0).GetPipelineMTime(), time

    def work(self, inInfo, output):
        """Fill the output with what `make` makes of the inputs."""
        import meshcore

        datasets = self.datasets(inInfo)
        inputs = {}
        try:
            for name, cells, _ in self.ports:
                if name in datasets:
                    inputs[name] = converted(datasets[name], cells, name)
            mesh, report = self.make(inputs)
        except meshcore.InvalidGeometry as error:
            raise Refused(f"{error}{place_of(error, inputs)}") from error
        fill(output, mesh)
        if report is not None:
            fill_report(output, report)

    def datasets(self, inInfo):
        """The connected inputs by the name of their port."""
        found = {}
        for (name, _, _), infos in zip(self.ports, inInfo or (), strict=False):
            if infos.GetNumberOfInformationObjects():
                found[name] = infos.GetInformationObject(0).Get(vtkDataObject.DATA_OBJECT())
        return found

    def progress(self, fraction, message):
        """Tell ParaView how far things are; False once the user has asked to stop."""
        self.SetProgressText(message)
        self.UpdateProgress(fraction)
        return not self.GetAbortExecute()


class Operation(Algorithm):
    """Base of the generated classes: one operation of meshcore's registry."""

    operation = ""
    called = set()  # operations that have run in this process, and are compiled

    def __init__(self):
        super().__init__()
        self.preferred = {}

    def prefer(self, name, port, value):
        """Keep the array of an optional input, which goes before one of the first input if both are there."""
        if self.preferred.get((name, port), "") != value:
            self.preferred[name, port] = value
            self.changed()

    def make(self, inputs):
        import meshcore

        operation = meshcore.operations()[self.operation]
        values = {name: value for name, value in self.values.items() if value is not BY_DEFAULT}
        values |= {name: value for (name, port), value in self.preferred.items() if value and port in inputs}
        if self.operation not in self.called:
            self.progress(0.0, "compiling, which the first call alone needs")
        mesh, report = operation.function(**inputs, **values, progress=self.progress)
        self.called.add(self.operation)
        return mesh, report


def put_extent(info, extent):
    """Tell the pipeline the whole extent of a structured output; what was asked for before is out of date with it."""
    info.Set(vtkStreamingDemandDrivenPipeline.WHOLE_EXTENT(), extent, 6)
    info.Set(vtkStreamingDemandDrivenPipeline.UPDATE_EXTENT(), extent, 6)


def converted(dataset, cells, name):
    """What meshcore takes in place of the dataset at a port that wants ``cells``; an error names the port."""
    from meshcore import InvalidGeometry

    try:
        if cells == "blocks" and isinstance(dataset, vtkCompositeDataSet):
            return blocks_of(dataset)
        if cells == "grid" or (cells in ("either", "blocks") and isinstance(dataset, vtkStructuredGrid)):
            return grid_of(dataset)
        kinds = {"lines": boundary_of, "curve": curve_of}
        return kinds[cells](dataset) if cells in kinds else mesh_of(dataset)[0]
    except InvalidGeometry as error:
        raise type(error)(f"{name}: {error}", points=error.points, cells=error.cells) from error


def place_of(error, inputs):
    """Where the error lies, as the coordinates of a few points; empty if it does not say."""
    from meshcore import MultiBlock

    mesh = inputs.get(error.parameter) or next(iter(inputs.values()), None)
    points = [k for k in error.points if mesh is not None and k < mesh.n_points]
    if not points:
        return ""
    parts = mesh.blocks if isinstance(mesh, MultiBlock) else (mesh,)
    flat = np.concatenate([part.points.swapaxes(0, -2).reshape(-1, 3) for part in parts])
    shown = ", ".join("({:.6g}, {:.6g}, {:.6g})".format(*flat[k]) for k in points[:3])
    return f" [at {shown}{' and elsewhere' if len(points) > 3 else ''}]"
