"""What the registry does not hold: models to begin with, quality, a reader and a writer."""

from __future__ import annotations

from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
from paraview.util.vtkAlgorithm import smdomain, smhint, smproperty, smproxy
from vtkmodules.vtkCommonDataModel import (
    vtkDataObject,
    vtkMultiBlockDataSet,
    vtkStructuredGrid,
    vtkUnstructuredGrid,
)

from .conversion import add_arrays, fill, grid_of, mesh_of
from .meshcore_plugin import MEASURES, READS, SECTIONS, WRITES  # written by generate.py
from .runtime import Algorithm, put_extent

MODELS = {
    "Square": "square",
    "Circle": "circle",
    "Square with Hole": "square_with_hole",
    "L Shape": "l_shape",
    "Triangulated Square": "triangulated_square",
}


def text_choice(name, values, default, description):
    """The XML of a property that is one of several texts."""
    entries = "".join(f"<String value={quoteattr(value)}/>" for value in values)
    return (
        f'<StringVectorProperty name="{name}" command="Set{name}" number_of_elements="1" default_values="{default}">'
        f'<StringListDomain name="list">{entries}</StringListDomain>'
        f"<Documentation>{description}</Documentation></StringVectorProperty>"
    )


@smproxy.source(name="meshcoreAirfoil", label="meshcore Airfoil", support_reload=False)
@smhint.xml('<ShowInMenu category="meshcore"/>')
@smproperty.xml(
    text_choice("Section", SECTIONS, "rae2822", "Section that meshcore ships; chord 1 from the origin along x.")
    + """
    <StringVectorProperty name="CoordinateFile" label="Coordinate File" command="SetCoordinateFile"
                          number_of_elements="1" default_values="">
      <FileListDomain name="files"/>
      <Hints><FileChooser extensions="dat" file_description="Airfoil coordinates"/></Hints>
      <Documentation>Your own airfoil .dat file (Selig or Lednicer layout), in place of the section.</Documentation>
    </StringVectorProperty>
    <DoubleVectorProperty name="FarField" label="Far Field" command="SetFarField" number_of_elements="1"
                          default_values="10">
      <DoubleRangeDomain name="range" min="0" max="100"/>
      <Documentation>Radius of the circle around the section, centred at mid-chord; 0 gives the section alone.
      </Documentation>
    </DoubleVectorProperty>
    <IntVectorProperty name="FarFieldPoints" label="Far Field Points" command="SetFarFieldPoints"
                       number_of_elements="1" default_values="48">
      <IntRangeDomain name="range" min="3" max="1000"/>
      <Documentation>Points on the far field's circle.</Documentation>
    </IntVectorProperty>
    <Documentation short_help="An airfoil in its far field">An airfoil as one closed loop of lines, in a circular far
    field. The cell array "tag" is 1 on the far field and 2 on the airfoil.</Documentation>
    """
)
class meshcoreAirfoil(Algorithm):
    label = "meshcore Airfoil"
    output = "vtkPolyData"

    def SetSection(self, value):
        self.set("section", value)

    def SetCoordinateFile(self, value):
        self.set("file", value)

    def SetFarField(self, value):
        self.set("far_field", value)

    def SetFarFieldPoints(self, value):
        self.set("far_field_points", value)

    def make(self, inputs):
        import meshcore

        own = self.values["file"]
        section = meshcore.io.read(own) if own else meshcore.gallery.airfoil(self.values["section"])
        if not self.values["far_field"]:
            return section, None
        low, high = section.bounds
        circle = meshcore.gallery.circle(
            self.values["far_field_points"],
            radius=self.values["far_field"],
            centre=tuple((low[:2] + high[:2]) / 2),
        )
        return meshcore.gallery.joined(circle, section), None


@smproxy.source(name="meshcoreModel", label="meshcore Model", support_reload=False)
@smhint.xml('<ShowInMenu category="meshcore"/>')
@smproperty.xml(
    text_choice("Model", MODELS, "Square with Hole", "The model.")
    + """
    <IntVectorProperty name="Resolution" command="SetResolution" number_of_elements="1" default_values="8">
      <IntRangeDomain name="range" min="3" max="200"/>
      <Documentation>Lines along a side, or around the circle.</Documentation>
    </IntVectorProperty>
    <Documentation short_help="A small model to try generators on">A small model to try generators on: outlines as
    lines, or a triangulated square with a field that is steep along a circle.</Documentation>
    """
)
class meshcoreModel(Algorithm):
    label = "meshcore Model"
    output = "vtkPolyData"

    def SetModel(self, value):
        self.set("model", value)

    def SetResolution(self, value):
        self.set("resolution", value)

    def make(self, inputs):
        import meshcore

        if self.values["model"] not in MODELS:
            raise meshcore.InvalidInput(
                f"{self.values['model']!r} is not one of {', '.join(MODELS)}", parameter="Model"
            )
        return getattr(meshcore.gallery, MODELS[self.values["model"]])(max(self.values["resolution"], 3)), None


@smproxy.filter(name="meshcoreMeshQuality", label="meshcore Mesh Quality", support_reload=False)
@smhint.xml('<ShowInMenu category="meshcore"/>')
@smproperty.input(name="Input", port_index=0)
@smdomain.datatype(dataTypes=["vtkDataSet"], composite_data_supported=False)
@smproperty.xml(
    text_choice("Measure", MEASURES, "min_angle", "Measure of each cell, by Verdict's names and definitions.")
    + """
    <Documentation short_help="One measure of quality of every cell">Adds a cell array with one measure of quality,
    called by the measure's name; nan where the measure is not defined for the kind of cell. The field data get the
    summary that meshcore's reports give.</Documentation>
    """
)
class meshcoreMeshQuality(Algorithm):
    label = "meshcore Mesh Quality"
    output = "vtkDataSet"  # whatever the input is
    ports = (("mesh", "mesh", False),)

    def SetMeasure(self, value):
        self.set("measure", value)

    def RequestDataObject(self, request, inInfo, outInfo):
        given = inInfo[0].GetInformationObject(0).Get(vtkDataObject.DATA_OBJECT())
        return put_output(outInfo, type(given))

    def RequestInformation(self, request, inInfo, outInfo):
        return 1  # as the input's: cells are measured where they are, piece by piece

    def RequestUpdateExtent(self, request, inInfo, outInfo):
        return 1

    def RequestData(self, request, inInfo, outInfo):
        return self.guarded(self.run, inInfo, outInfo.GetInformationObject(0))

    def run(self, inInfo, info):
        import meshcore

        dataset = self.datasets(inInfo)["mesh"]
        mesh, source = mesh_of(dataset, known_only=True)
        of_part = meshcore.quality.measure(mesh, self.values["measure"])
        values = np.full(dataset.GetNumberOfCells(), np.nan)
        # A cell that came apart into several has no measure of its own.
        whole = np.bincount(source, minlength=len(values))[source] == 1
        values[source[whole]] = of_part[whole]
        output = info.Get(vtkDataObject.DATA_OBJECT())
        output.ShallowCopy(dataset)
        add_arrays(output.GetCellData(), {self.values["measure"]: values})
        output.GetCellData().SetActiveScalars(self.values["measure"])
        summary = meshcore.quality.summary(mesh).items()
        add_arrays(output.GetFieldData(), {name: np.array([float(value)]) for name, value in summary})


@smproxy.reader(
    name="meshcoreReader",
    label="meshcore Reader",
    extensions=READS,
    file_description="Meshes that meshcore reads",
    support_reload=False,
)
@smproperty.xml(
    f"""
    <StringVectorProperty name="FileName" command="SetFileName" animateable="1" number_of_elements="1"
                          panel_visibility="never">
      <FileListDomain name="files"/>
      <Hints><FileChooser extensions="{READS}" file_description="Meshes that meshcore reads"/></Hints>
      <Documentation>The file; its extension tells the format.</Documentation>
    </StringVectorProperty>
    <Documentation short_help="Read a mesh file">Reads the formats that meshcore knows and ParaView does not.
    </Documentation>
    """
)
class meshcoreReader(Algorithm):
    label = "meshcore Reader"
    output = "vtkDataObject"  # whatever the file holds

    def __init__(self):
        super().__init__()
        self.content = None
        self.stamp = None

    def SetFileName(self, value):
        self.set("file", value)

    def RequestDataObject(self, request, inInfo, outInfo):
        if not self.guarded(self.read):
            self.content = self.stamp = None
        return put_output(outInfo, vtk_type_of(self.content))

    def RequestInformation(self, request, inInfo, outInfo):
        if vtk_type_of(self.content) is vtkStructuredGrid:
            put_extent(outInfo.GetInformationObject(0), [k for n in self.content.shape for k in (0, n - 1)])
        return super().RequestInformation(request, inInfo, outInfo)

    def read(self):
        """Read the file, if it is another one than last time or was written since."""
        import meshcore

        path = Path(self.values.get("file") or "")
        stamp = (path, path.stat().st_mtime_ns) if path.is_file() else None
        if stamp is None or stamp != self.stamp:
            self.content = meshcore.io.read(path)
            self.stamp = stamp

    def run(self, inInfo, info):
        output = info.Get(vtkDataObject.DATA_OBJECT())
        if self.content is not None:
            fill(output, self.content)


@smproxy.writer(
    name="meshcoreWriter",
    label="meshcore Writer",
    extensions=WRITES,
    file_description="Meshes that meshcore writes",
    support_reload=False,
)
@smproperty.input(name="Input", port_index=0)
@smdomain.datatype(
    dataTypes=["vtkPolyData", "vtkUnstructuredGrid", "vtkStructuredGrid"], composite_data_supported=False
)
@smproperty.xml(
    """
    <StringVectorProperty name="FileName" command="SetFileName" number_of_elements="1" panel_visibility="never">
      <FileListDomain name="files"/>
      <Documentation>The file; its extension tells the format.</Documentation>
    </StringVectorProperty>
    """
)
class meshcoreWriter(Algorithm):
    label = "meshcore Writer"
    ports = (("mesh", "mesh", False),)

    def __init__(self):
        super().__init__()
        self.SetNumberOfOutputPorts(0)

    def SetFileName(self, value):
        self.set("file", value)

    def RequestInformation(self, request, inInfo, outInfo):
        return 1

    def RequestUpdateExtent(self, request, inInfo, outInfo):
        return 1  # ParaView offers this writer where there is one process, and so one piece

    def Write(self):
        """Called by ParaView: write whatever the input is now."""
        self.Modified()
        self.Update()

    def RequestData(self, request, inInfo, outInfo):
        return self.guarded(self.run, inInfo, None)

    def run(self, inInfo, info):
        import meshcore

        dataset = self.datasets(inInfo)["mesh"]
        content = grid_of(dataset) if isinstance(dataset, vtkStructuredGrid) else mesh_of(dataset)[0]
        meshcore.io.write(self.values["file"], content)


def put_output(outInfo, vtk_type):
    """Make sure that the output is of a type; 1, as RequestDataObject answers."""
    info = outInfo.GetInformationObject(0)
    if type(info.Get(vtkDataObject.DATA_OBJECT())) is not vtk_type:
        info.Set(vtkDataObject.DATA_OBJECT(), vtk_type())
    return 1


def vtk_type_of(content):
    """The VTK class that stands for what a file holds."""
    return {"StructuredGrid": vtkStructuredGrid, "MultiBlock": vtkMultiBlockDataSet}.get(
        type(content).__name__, vtkUnstructuredGrid
    )
