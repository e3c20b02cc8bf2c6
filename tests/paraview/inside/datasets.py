"""VTK datasets made and read cell by cell: the slow, obvious twin of the plugin's conversion."""

from __future__ import annotations

import numpy as np
from paraview import servermanager
from paraview.simple import TrivialProducer
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import VTK_DOUBLE, vtkIdList, vtkPoints, vtkStringArray
from vtkmodules.vtkCommonDataModel import vtkPolyData, vtkUnstructuredGrid

from meshcore.mesh import BY_VTK, CELL_TYPES


def points_of(rows, data_type=VTK_DOUBLE):
    """vtkPoints from (n, 3) rows."""
    points = vtkPoints()
    points.SetDataType(data_type)
    for row in rows:
        points.InsertNextPoint(*map(float, row))
    return points


def unstructured(points, cells, cell_data=None, point_data=None):
    """A vtkUnstructuredGrid from points and a list of (VTK type, nodes)."""
    grid = vtkUnstructuredGrid()
    grid.SetPoints(points_of(points))
    for number, nodes in cells:
        ids = vtkIdList()
        for node in nodes:
            ids.InsertNextId(int(node))
        grid.InsertNextCell(number, ids)
    _add(grid.GetCellData(), cell_data)
    _add(grid.GetPointData(), point_data)
    return grid


def polylines(*loops, data_type=VTK_DOUBLE):
    """A vtkPolyData with one polyline for each list of points; points are not shared."""
    data = vtkPolyData()
    data.SetPoints(points_of([p for loop in loops for p in loop], data_type))
    data.AllocateExact(len(loops), sum(map(len, loops)))
    start = 0
    for loop in loops:
        ids = vtkIdList()
        for k in range(len(loop)):
            ids.InsertNextId(start + k)
        data.InsertNextCell(4, ids)
        start += len(loop)
    return data


def of_mesh(mesh):
    """A meshcore Mesh as a vtkUnstructuredGrid."""
    cells = [(CELL_TYPES[kind].vtk, row) for kind, rows in mesh.cells.items() for row in rows]
    return unstructured(mesh.points, cells, mesh.cell_data, mesh.point_data)


def producer(dataset):
    """A pipeline source that holds a dataset."""
    source = TrivialProducer()
    source.GetClientSideObject().SetOutput(dataset)
    source.UpdatePipeline()
    return source


def fetched(proxy):
    """The output of a proxy, as VTK data in this process."""
    proxy.UpdatePipeline()
    return servermanager.Fetch(proxy)


def content(dataset):
    """Points, {kind: rows of nodes} with kinds by first appearance, cell and point data; read cell by cell."""
    points = [dataset.GetPoint(k) for k in range(dataset.GetNumberOfPoints())]
    cells: dict[str, list] = {}
    order: dict[str, list] = {}
    for k in range(dataset.GetNumberOfCells()):
        kind = BY_VTK[dataset.GetCellType(k)].name
        ids = vtkIdList()
        dataset.GetCellPoints(k, ids)
        cells.setdefault(kind, []).append([ids.GetId(n) for n in range(ids.GetNumberOfIds())])
        order.setdefault(kind, []).append(k)
    rows = [k for kind in cells for k in order[kind]]
    cell_data = {name: values[rows] for name, values in arrays(dataset.GetCellData()).items()}
    cells = {kind: np.array(found) for kind, found in cells.items()}
    return np.array(points).reshape(-1, 3), cells, cell_data, arrays(dataset.GetPointData())


def dimensions(grid):
    """Points of a structured dataset along i, j, k."""
    low, high = grid.GetExtent()[::2], grid.GetExtent()[1::2]
    return tuple(b - a + 1 for a, b in zip(low, high, strict=True))


def arrays(attributes):
    """Numeric arrays by name."""
    found = {}
    for k in range(attributes.GetNumberOfArrays()):
        array = attributes.GetArray(k)
        if array is not None and array.GetName():
            found[array.GetName()] = vtk_to_numpy(array).copy()
    return found


def texts(attributes, name):
    """The strings of a text array."""
    array = attributes.GetAbstractArray(name)
    assert isinstance(array, vtkStringArray), f"no text {name!r}"
    return [array.GetValue(k) for k in range(array.GetNumberOfValues())]


def assert_same(dataset, points, cells, cell_data, point_data):
    """A dataset holds exactly these points, cells and (at least) these data."""
    got_points, got_cells, got_cell_data, got_point_data = content(dataset)
    np.testing.assert_array_equal(got_points, points)
    assert list(got_cells) == [kind for kind, rows in cells.items() if len(rows)], list(got_cells)
    for kind, rows in got_cells.items():
        np.testing.assert_array_equal(rows, cells[kind])
    for got, wanted in ((got_cell_data, cell_data), (got_point_data, point_data)):
        for name, values in wanted.items():
            np.testing.assert_array_equal(got[name], np.asarray(values), err_msg=name)


def assert_same_polyhedra(dataset, mesh):
    """A dataset holds exactly the polygons or polyhedra, and (at least) the data, of a PolyhedralMesh."""
    assert dataset.GetNumberOfCells() == mesh.n_cells
    np.testing.assert_array_equal([dataset.GetPoint(k) for k in range(dataset.GetNumberOfPoints())], mesh.points)
    offsets, faces = mesh.cell_faces
    rows = [nodes.tolist() for nodes in np.split(mesh.face_nodes, mesh.face_offsets[1:-1])]
    for cell in range(mesh.n_cells):
        own = faces[offsets[cell] : offsets[cell + 1]]
        found = [rows[f] if mesh.owner is None or mesh.owner[f] == cell else [rows[f][0], *rows[f][:0:-1]] for f in own]
        ids = vtkIdList()
        if mesh.dimension == 2:
            assert dataset.GetCellType(cell) == 7
            dataset.GetCellPoints(cell, ids)
            wanted = found[0]
        else:
            assert dataset.GetCellType(cell) == 42
            dataset.GetFaceStream(cell, ids)
            wanted = [len(found), *(n for face in found for n in (len(face), *face))]
        assert [ids.GetId(k) for k in range(ids.GetNumberOfIds())] == wanted, cell
    for attributes, data in ((dataset.GetCellData(), mesh.cell_data), (dataset.GetPointData(), mesh.point_data)):
        for name, values in data.items():
            np.testing.assert_array_equal(arrays(attributes)[name], values, err_msg=name)


def _add(attributes, arrays):
    for name, values in (arrays or {}).items():
        array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
        array.SetName(name)
        attributes.AddArray(array)
