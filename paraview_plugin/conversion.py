"""VTK datasets to meshcore meshes and back, by whole arrays."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
from paraview import print_warning
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
from vtkmodules.vtkCommonCore import VTK_BIT, vtkDataArray, vtkPoints, vtkStringArray
from vtkmodules.vtkCommonDataModel import (
    vtkCellArray,
    vtkCompositeDataSet,
    vtkDataSet,
    vtkDataSetAttributes,
    vtkMultiBlockDataSet,
    vtkPartitionedDataSet,
    vtkPartitionedDataSetCollection,
    vtkPolyData,
    vtkStructuredGrid,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkFiltersCore import vtkAppendFilter

GHOST = vtkDataSetAttributes.GhostArrayName()
NOT_MINE = vtkDataSetAttributes.DUPLICATECELL | vtkDataSetAttributes.HIDDENCELL
FACE = "face"
SOURCE_CELL = "meshcore source cell"


def mesh_of(dataset, *, known_only=False):
    """The dataset as a `Mesh`, and for each of its cells the number of the VTK cell that it comes from.

    Polylines, strips and polygons of more than four corners come apart into simpler cells. Ghost cells are left out,
    and with ``known_only`` so are kinds that meshcore does not know; otherwise these raise `InvalidInput`.
    """
    from meshcore.io.vtk_data import MESH, DataSet, decoded

    grid = _unstructured(dataset)
    if not grid.GetNumberOfPoints():
        return decoded(DataSet(MESH, np.empty((0, 3)))), np.empty(0, np.int64)
    keep, types, connectivity, offsets = _listed_cells(grid, known_only)
    cell_data = {name: values[keep] for name, values in arrays_of(grid.GetCellData()).items()}
    data = DataSet(
        MESH,
        vtk_to_numpy(grid.GetPoints().GetData()),
        types=types,
        connectivity=connectivity,
        offsets=offsets,
        point_data=arrays_of(grid.GetPointData()),
        cell_data={**cell_data, SOURCE_CELL: keep},
        field_data=arrays_of(dataset.GetFieldData()),
    )
    mesh = decoded(data)
    cell_data = dict(mesh.cell_data)
    source = cell_data.pop(SOURCE_CELL)
    return replace(mesh, cell_data=cell_data), source


def boundary_of(dataset, **data):
    """The dataset's lines as a `Mesh` without repeated points; where it has none, the outline of its surface.

    More cell ``data`` are those of the cells of `mesh_of`.
    """
    from meshcore import InvalidGeometry, Mesh

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that polygons are cut into triangles does not change the outline
        mesh, _ = mesh_of(dataset)
    mesh = mesh.with_cell_data(**data)
    lines = mesh.get("line")
    if len(lines):
        where = {kind: place for kind, _, place in mesh.blocks()}["line"]
        source = np.arange(where.start, where.stop)
        first, number = _first_of_each(mesh.points)
    elif mesh.dimension == 2:
        first, number = _first_of_each(mesh.points)
        whole = Mesh(mesh.points[first], {kind: number[cells] for kind, cells in mesh.cells.items()}).boundary
        lines, source, number = whole.get("line"), whole.cell_data["cell"], np.arange(len(first))
    if not len(lines):
        raise InvalidGeometry(f"needs lines, or a surface with an open boundary; got {_content(mesh)}")
    lines = number[lines]
    long = lines[:, 0] != lines[:, 1]
    return Mesh(
        mesh.points[first],
        {"line": lines[long]},
        {name: values[first] for name, values in mesh.point_data.items()},
        {name: values[source[long]] for name, values in mesh.cell_data.items()},
        field_data=mesh.field_data,
    ).compacted()


def curve_of(dataset):
    """The dataset as one curve or several: its lines, or the outline of its surface, or its points in order.

    Where there are several polylines the cell data "polyline" number them, so that their ends are not lost where they
    meet: four that close are four sides.
    """
    from meshcore import Mesh

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # as in `boundary_of`
        mesh, source = mesh_of(dataset)
    if mesh.n_points and mesh.dimension == 0:
        return Mesh(mesh.points, {}, mesh.point_data)
    where = {kind: place for kind, _, place in mesh.blocks()}.get("line", slice(0, 0))
    numbers, count = np.unique(source[where], return_counts=True)
    if len(numbers) < 2 or count.min() < 2:  # single lines are no curves of their own
        return boundary_of(dataset)
    number = np.zeros(mesh.n_cells, np.int64)
    number[where] = np.searchsorted(numbers, source[where])
    return boundary_of(dataset, polyline=number)


def grid_of(dataset):
    """A vtkStructuredGrid as a `StructuredGrid`."""
    from meshcore import InvalidGeometry
    from meshcore.io.vtk_data import GRID, DataSet, decoded

    shape = [0, 0, 0]
    dataset.GetDimensions(shape)
    if sum(n > 1 for n in shape) < 2:
        raise InvalidGeometry(f"needs a grid of at least 2 x 2 points, got {' x '.join(map(str, shape))}")
    return decoded(
        DataSet(
            GRID,
            vtk_to_numpy(dataset.GetPoints().GetData()),
            dimensions=tuple(shape),
            point_data=arrays_of(dataset.GetPointData()),
            cell_data=arrays_of(dataset.GetCellData()),
            field_data={**arrays_of(dataset.GetFieldData()), **_texts_of(dataset.GetFieldData())},
        )
    )


def blocks_of(dataset):
    """A composite dataset as a `MultiBlock` if all of its parts are structured grids, one alone as what it is.

    Other parts become one `Mesh`, with a set for each.
    """
    from meshcore import MultiBlock
    from meshcore.io.vtk_data import together, with_cuts

    parts = {}
    for name, leaf in _leaves(dataset, ""):
        name = name or f"block {len(parts)}"
        name = name if name not in parts else f"{name} {len(parts)}"
        parts[name] = grid_of(leaf) if isinstance(leaf, vtkStructuredGrid) else mesh_of(leaf)[0]
    if len(parts) == 1:
        return next(iter(parts.values()))
    whole = together(parts)
    return with_cuts(whole, _texts_of(dataset.GetFieldData())) if isinstance(whole, MultiBlock) else whole


def _leaves(data, name):
    """The datasets with points of a composite one, with their names; those inside others have the outer ones' before.

    The one piece of a partitioned dataset has the name of the whole.
    """
    if not isinstance(data, vtkCompositeDataSet):
        if isinstance(data, vtkDataSet) and data.GetNumberOfPoints():
            yield name, data
        return
    if isinstance(data, vtkPartitionedDataSetCollection):
        count, child = data.GetNumberOfPartitionedDataSets(), data.GetPartitionedDataSet
    elif isinstance(data, vtkPartitionedDataSet):
        count, child = data.GetNumberOfPartitions(), data.GetPartition
    else:
        count, child = data.GetNumberOfBlocks(), data.GetBlock
    for k in range(count):
        own = data.GetMetaData(k).Get(data.NAME()) if data.HasMetaData(k) else None
        yield from _leaves(child(k), "/".join(part for part in (name, own) if part))


def _texts_of(attributes):
    """The named arrays of text of a dataset's field data, such as names of faces."""
    arrays = [attributes.GetAbstractArray(k) for k in range(attributes.GetNumberOfArrays())]
    return {
        array.GetName(): np.array([array.GetValue(k) for k in range(array.GetNumberOfValues())])
        for array in arrays
        if isinstance(array, vtkStringArray) and array.GetName()
    }


def arrays_of(attributes):
    """The named numeric arrays of a dataset's point, cell or field data."""
    found = {}
    for k in range(attributes.GetNumberOfArrays()):
        array = attributes.GetAbstractArray(k)
        numeric = isinstance(array, vtkDataArray) and array.GetDataType() != VTK_BIT
        if numeric and array.GetName() not in (None, "", GHOST):
            found[array.GetName()] = vtk_to_numpy(array)
    return found


def fill(output, result):
    """Put a `Mesh`, a `PolyhedralMesh`, a `StructuredGrid` or a `MultiBlock` into the VTK dataset that stands for it.

    VTK gets copies of the arrays. On numpy's own memory it would crash: a shallow copy of such an array, as
    vtkCellArray and some filters make, does not keep that memory alive.
    """
    from meshcore import MultiBlock, StructuredGrid
    from meshcore.io.vtk_data import encoded, encoded_cuts

    if isinstance(output, vtkMultiBlockDataSet):
        result = MultiBlock((result,)) if isinstance(result, StructuredGrid) else result
        for k, (name, block) in enumerate(zip(result.names, result.blocks, strict=True)):
            grid = vtkStructuredGrid()
            fill(grid, block)
            output.SetBlock(k, grid)
            output.GetMetaData(k).Set(output.NAME(), name)
        add_arrays(output.GetFieldData(), encoded_cuts(result.cuts))
        return
    if isinstance(result, (StructuredGrid, MultiBlock)) and not isinstance(output, vtkStructuredGrid):
        result = _with_sets(result)  # of an operation that gives what it was given, and has one type of output here
    data = encoded(result)
    if isinstance(output, vtkStructuredGrid) and result.names:
        data = replace(data, point_data={**data.point_data, FACE: _faces_of(result)})
    points = vtkPoints()
    points.SetData(numpy_to_vtk(data.points, deep=True))
    if isinstance(output, vtkStructuredGrid):
        output.SetDimensions(*data.dimensions)
    elif isinstance(output, vtkPolyData):
        data = _fill_polydata(output, data)
    else:
        faces = [numpy_to_vtkIdTypeArray(values, deep=True) for values in (data.face_starts, data.faces)]
        cells = numpy_to_vtk(data.types, deep=True), _cell_array(data.offsets, data.connectivity)
        output.SetCells(*cells, *(faces if len(data.faces) else ()))
    output.SetPoints(points)
    add_arrays(output.GetPointData(), data.point_data)
    add_arrays(output.GetCellData(), data.cell_data)
    add_arrays(output.GetFieldData(), data.field_data)


def _with_sets(grid):
    """A grid or blocks as a mesh, in which blocks are sets of cells and named sides sets of their lines or faces."""
    from meshcore import MultiBlock, with_named_sides

    sides = with_named_sides(grid)
    return replace(sides, sets={**(grid.to_mesh().sets if isinstance(grid, MultiBlock) else {}), **sides.sets})


def _faces_of(grid):
    """Where the named faces of a grid are, by colour or threshold: 1 to 6 for imin to kmax, 0 elsewhere."""
    from meshcore.mesh.structured_grid import FACES

    number = np.zeros(grid.shape, np.uint8)
    for face in grid.names:
        axis, last = divmod(FACES.index(face), 2)
        np.moveaxis(number, axis, 0)[-last] = 1 + FACES.index(face)
    return grid.flat(number)


def fill_report(output, report):
    """Put a report into the field data: its numbers by name, and the whole as rows of text."""
    numbers = {**report.counts, **report.quality, "seconds": report.seconds}
    add_arrays(output.GetFieldData(), {name: np.array([value]) for name, value in numbers.items()})
    add_arrays(output.GetFieldData(), {"report": np.array([f"{name}: {text}" for name, text in report.rows()])})
    for text in report.warnings:
        print_warning(f"{report.operation}: {text}")


def add_arrays(attributes, arrays):
    """Add copies of numpy arrays by name."""
    for name, values in arrays.items():
        if values.dtype.kind == "U":
            array = vtkStringArray()
            for text in values.ravel().tolist():
                array.InsertNextValue(text)
        else:
            array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
        array.SetName(name)
        attributes.AddArray(array)


def _unstructured(dataset):
    """Any dataset as a vtkUnstructuredGrid, cell for cell."""
    if isinstance(dataset, vtkUnstructuredGrid):
        return dataset
    append = vtkAppendFilter()
    append.SetInputData(dataset)
    append.Update()
    return append.GetOutput()


def _listed_cells(grid, known_only):
    """Numbers, types, connectivity and offsets of the cells that are neither empty nor another process's ghosts."""
    from meshcore.io import ragged
    from meshcore.mesh import BY_VTK

    if not grid.GetNumberOfCells():
        empty = np.empty(0, np.int64)
        return empty, empty, empty, np.zeros(1, np.int64)
    types = vtk_to_numpy(grid.GetCellTypesArray())
    offsets = vtk_to_numpy(grid.GetCells().GetOffsetsArray())
    connectivity = vtk_to_numpy(grid.GetCells().GetConnectivityArray())
    keep = types != 0
    ghost = grid.GetCellData().GetArray(GHOST)
    if ghost is not None:
        keep &= (vtk_to_numpy(ghost) & NOT_MINE) == 0
    if known_only:
        taken_apart = (ragged.POLY_VERTEX, ragged.POLY_LINE, ragged.TRIANGLE_STRIP, ragged.POLYGON)
        keep &= np.isin(types, [*BY_VTK, *taken_apart, ragged.PIXEL, ragged.VOXEL])
    if not keep.all():
        sizes = np.diff(offsets)
        connectivity = connectivity[np.repeat(keep, sizes)]
        offsets = np.concatenate([[0], np.cumsum(sizes[keep])])
    return np.flatnonzero(keep), types[keep], connectivity, offsets


def _first_of_each(points):
    """Points at the very same place made one: the first of each in order, and for every point its new number."""
    # Adding zero makes -0.0 and 0.0 the same bits.
    _, first, number = np.unique(points + 0.0, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return first[order], rank[number.reshape(-1)]


def _content(mesh):
    """What a mesh holds, in a few words."""
    kinds = [f"{len(cells)} {kind}" for kind, cells in mesh.cells.items()]
    return f"{', '.join(kinds)} cells" if kinds else f"{mesh.n_points} points without cells"


def _fill_polydata(output, data):
    """Vertices, lines and polygons of an unstructured layout; cell data in the order in which VTK counts these."""
    from meshcore.mesh import BY_VTK

    sizes = np.diff(data.offsets)
    dimension = np.array([BY_VTK[t].dimension if t in BY_VTK else -1 for t in range(256)])[data.types]
    setters = (output.SetVerts, output.SetLines, output.SetPolys)
    for k, setter in enumerate(setters):
        which = dimension == k
        offsets = np.concatenate([[0], np.cumsum(sizes[which])])
        setter(_cell_array(offsets, data.connectivity[np.repeat(which, sizes)]))
    order = np.concatenate([np.flatnonzero(dimension == k) for k in range(len(setters))])
    return replace(data, cell_data={name: values[order] for name, values in data.cell_data.items()})


def _cell_array(offsets, connectivity):
    array = vtkCellArray()
    array.SetData(numpy_to_vtkIdTypeArray(offsets, deep=True), numpy_to_vtkIdTypeArray(connectivity, deep=True))
    return array
