"""Every operation: geometry in ParaView, through the filter, back, written, read again."""

from __future__ import annotations

import gc

import numpy as np
import paraview.simple as pv
from datasets import (
    arrays,
    assert_same,
    assert_same_polyhedra,
    content,
    dimensions,
    fetched,
    of_mesh,
    points_of,
    polylines,
    producer,
    texts,
    unstructured,
)
from harness import OUT, input_names, load_plugin, run_checks, save
from vtkmodules.vtkCommonCore import vtkStringArray, vtkUnsignedCharArray
from vtkmodules.vtkCommonDataModel import (
    vtkMultiBlockDataSet,
    vtkPartitionedDataSetCollection,
    vtkStructuredGrid,
)

import meshcore
from meshcore import gallery
from meshcore.geometry.curves import lines_through
from meshcore.io.vtk_data import FACE_NAMES, encoded

load_plugin()


def camel(name):
    return name.title().replace("_", "")


def panel_value(param, value):
    """What a user would type in the panel for a value of meshcore's."""
    return 0 if value is None else value


def meshcore_value(param, value):
    """What a value in the panel means to meshcore."""
    if param.array:
        return "" if value == "None" else str(next(iter(value)))  # ParaView's value is a list that prints as text
    if param.size > 1:
        return tuple(value)
    if param.kind == "bool":
        return bool(value)
    return None if param.optional and not value else value


def filter_and_call(identifier, inputs=None, **more):
    """The filter on the gallery's model, and meshcore called with what its panel says."""
    operation = meshcore.operations()[identifier]
    given, keywords = gallery.arguments(identifier)
    given = given if inputs is None else inputs
    keywords = {**keywords, **more}
    sources = [producer(of_mesh(mesh)) for mesh in given]
    create = getattr(pv, "meshcore" + operation.label.replace(" ", ""))
    shown = {camel(name): panel_value(operation.params[name], value) for name, value in keywords.items()}
    proxy = create(**dict(zip(input_names(operation), sources, strict=False)), **shown)
    values = {p.name: meshcore_value(p, getattr(proxy, camel(p.name))) for p in operation.params.values()}
    return proxy, operation.function(*given, **values).mesh


def assert_same_mesh(dataset, mesh):
    if isinstance(mesh, meshcore.StructuredGrid):
        assert dataset.GetClassName() == "vtkStructuredGrid"
        assert dimensions(dataset) == mesh.shape
        points = [
            mesh.points[i, j, k]
            for k in range(mesh.shape[2])
            for j in range(mesh.shape[1])
            for i in range(mesh.shape[0])
        ]
        np.testing.assert_array_equal(content(dataset)[0], points)
        assert dataset.GetNumberOfCells() == mesh.n_cells
    elif isinstance(mesh, meshcore.MultiBlock):
        assert dataset.GetClassName() == "vtkMultiBlockDataSet" and dataset.GetNumberOfBlocks() == len(mesh.blocks)
        for number, (name, block) in enumerate(zip(mesh.names, mesh.blocks, strict=True)):
            assert dataset.GetMetaData(number).Get(dataset.NAME()) == name
            assert_same_mesh(dataset.GetBlock(number), block)
    elif isinstance(mesh, meshcore.PolyhedralMesh):
        assert_same_polyhedra(dataset, mesh)
    else:
        assert dataset.GetClassName() == "vtkUnstructuredGrid"
        assert_same(dataset, mesh.points, mesh.cells, mesh.cell_data, mesh.point_data)


def check_every_operation_is_there(operation):
    label = meshcore.operations()[operation].label
    assert callable(getattr(pv, "meshcore" + label.replace(" ", "")))


def check_round_trip(operation):
    proxy, mesh = filter_and_call(operation)
    assert mesh.n_cells > 3
    assert_same_mesh(fetched(proxy), mesh)


def check_saved_and_read_again(operation):
    proxy, mesh = filter_and_call(operation)
    suffix, reader = {
        meshcore.StructuredGrid: ("vts", pv.XMLStructuredGridReader),
        meshcore.MultiBlock: ("vtm", pv.XMLMultiBlockDataReader),
    }.get(type(mesh), ("vtu", pv.XMLUnstructuredGridReader))
    path = str(OUT / f"{operation}.{suffix}")
    save(path, proxy)
    assert_same_mesh(fetched(reader(FileName=[path])), mesh)


def check_report_is_in_the_field_data(operation):
    proxy, mesh = filter_and_call(operation)
    rows = texts(fetched(proxy).GetFieldData(), "report")
    assert f"points: {mesh.n_points:,}" in rows, rows
    assert any(row.startswith("seconds: ") for row in rows), rows


def check_cells_reach_the_next_filter(operation):
    """At once, and after a change: filters of ParaView's own see no more of a grid than its extent told before."""
    proxy, mesh = filter_and_call(operation)
    shrunk = pv.Shrink(Input=proxy)
    assert fetched(shrunk).GetNumberOfCells() == fetched(proxy).GetNumberOfCells() >= mesh.n_cells > 0
    surface = pv.ExtractSurface(Input=proxy)
    assert fetched(surface).GetNumberOfCells() > 0


def check_survives_garbage_collection(operation):
    proxy, mesh = filter_and_call(operation)
    proxy.UpdatePipeline()
    for _ in range(3):
        gc.collect()
        np.random.default_rng(7).random(1_000_000)  # so that freed memory is written over
    assert_same_mesh(fetched(proxy), mesh)


def check_vectors_choices_and_numbers_reach_the_operation():
    loop = lines_through([[0, 0], [2, 0], [3, 0.2], [3, 1], [2, 1.5], [0, 1], [-0.2, 0.5]], closed=True)
    corners = (0, 2, 4, 5)
    proxy, mesh = filter_and_call("transfinite", (loop,), cells_i=5, cells_j=4, corners=corners, blending="linear")
    assert mesh.shape == (6, 5, 1)
    assert_same_mesh(fetched(proxy), mesh)
    _, other = filter_and_call("transfinite", (loop,), cells_i=5, cells_j=4, corners=corners, blending="arc length")
    assert not np.array_equal(mesh.points, other.points)


def check_polylines_without_shared_points_make_one_loop():
    sides = [
        [(0, 0, 0), (1, 0, 0), (2, 0, 0)],
        [(2, 0, 0), (2, 1, 0)],
        [(2, 1, 0), (1, 1, 0), (0, 1, 0)],
        [(0, 1, 0), (0, 0, 0)],
    ]
    loop = producer(polylines(*sides))
    dataset = fetched(pv.meshcoreTransfiniteInterpolation(South=loop))
    assert dimensions(dataset) == (3, 2, 1)
    assert sorted(content(dataset)[0].tolist()) == sorted([float(x), float(y), 0.0] for x in range(3) for y in range(2))


def check_outline_of_a_surface_is_its_boundary():
    plane = pv.Plane(XResolution=5, YResolution=3)
    dataset = fetched(pv.meshcoreTransfiniteInterpolation(South=plane))
    wanted = fetched(plane)
    got, given = (sorted(content(d)[0].round(12).tolist()) for d in (dataset, wanted))
    np.testing.assert_allclose(got, given, atol=1e-7)
    assert dataset.GetNumberOfCells() == 15


def check_outline_of_an_unstructured_surface_with_a_pentagon():
    points = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (1, 2, 0), (0, 2, 0), (-1, 0, 0), (-1, 2, 0)]
    surface = producer(unstructured(points, [(7, (0, 1, 2, 3, 4)), (9, (5, 0, 4, 6))]))
    proxy = pv.meshcoreTransfiniteInterpolation(South=surface, CellsI=3, CellsJ=2)
    low, high = content(fetched(proxy))[0].min(axis=0), content(fetched(proxy))[0].max(axis=0)
    assert (low.tolist(), high.tolist()) == ([-1, 0, 0], [2, 2, 0])


def check_extent_follows_the_parameters_downstream():
    plane = pv.Plane(XResolution=4, YResolution=3)
    proxy = pv.meshcoreTransfiniteInterpolation(South=plane, CellsI=4, CellsJ=3)
    subset = pv.ExtractSubset(Input=proxy, VOI=[0, 99, 0, 99, 0, 0])
    for cells in (4, 9, 2, 7):
        proxy.CellsI = cells
        assert dimensions(fetched(subset)) == (cells + 1, 4, 1)
        path = str(OUT / "extent.vts")
        save(path, proxy)
        assert dimensions(fetched(pv.XMLStructuredGridReader(FileName=[path]))) == (cells + 1, 4, 1)
    proxy.CellsI = proxy.CellsJ = 0
    plane.XResolution = 11  # a change of the input, not of the filter
    assert dimensions(fetched(subset)) == (12, 4, 1)


def check_a_filter_feeds_the_next():
    plane = pv.Plane(XResolution=4, YResolution=3)
    first = pv.meshcoreTransfiniteInterpolation(South=plane)
    second = pv.meshcoreTransfiniteInterpolation(South=first, CellsI=8, CellsJ=6)
    assert fetched(second).GetNumberOfCells() == 48


def check_thousands_of_edges():
    angle = 2 * np.pi * np.arange(4000) / 4000
    loop = [(np.cos(a), np.sin(a), 0.0) for a in angle]
    dataset = fetched(pv.meshcoreDelaunayRefinement(Input=producer(polylines([*loop, loop[0]])), MinAngle=25))
    points, cells, _, _ = content(dataset)
    kept = {tuple(p) for p in points.tolist()}
    assert kept.issuperset(tuple(map(float, p)) for p in loop)
    a, b, c = (points[cells["triangle"][:, k], :2] for k in range(3))
    area = 0.5 * np.sum((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    np.testing.assert_allclose(area, 0.5 * 4000 * np.sin(2 * np.pi / 4000), rtol=1e-12)


def check_tilted_plane_stays_where_it_is():
    corners = np.array([(0, 0), (2, 0), (2, 1), (0, 1), (0, 0)], float)
    tilted = [(x, 0.6 * y + 3, 0.8 * y - 1) for x, y in corners]
    dataset = fetched(pv.meshcoreDelaunayRefinement(Input=producer(polylines(tilted)), Size=0.2))
    points = content(dataset)[0]
    np.testing.assert_allclose(0.8 * (points[:, 1] - 3), 0.6 * (points[:, 2] + 1), atol=1e-12)
    assert dataset.GetNumberOfCells() > 100


def check_single_precision_geometry_of_paraviews_own():
    disk = pv.Disk(InnerRadius=0.5, OuterRadius=1.0, CircumferentialResolution=24)
    turned = pv.Transform(Input=disk, Transform="Transform")
    turned.Transform.Rotate = [35.0, 20.0, 10.0]
    dataset = fetched(pv.meshcoreDelaunayRefinement(Input=turned, MinAngle=25))
    points, cells, _, _ = content(dataset)
    radius = np.linalg.norm(points[cells["triangle"]].mean(axis=1), axis=1)
    assert 0.5 * np.cos(np.pi / 24) < radius.min() and radius.max() < 1  # the hole is kept, both rims as well


def check_regions_and_cell_data_come_back():
    proxy, mesh = filter_and_call("delaunay_refinement", max_area=0.01)
    dataset = fetched(proxy)
    assert_same_mesh(dataset, mesh)
    assert "region" in content(dataset)[2]


def structured(grid, *, with_fields=True):
    """A vtkStructuredGrid of a meshcore grid, with what only field data can say or without."""
    dataset = vtkStructuredGrid()
    dataset.SetDimensions(*grid.shape)
    dataset.SetPoints(points_of(grid.flat(grid.points)))
    if with_fields:
        for name, values in encoded(grid).field_data.items():
            array = vtkStringArray() if values.dtype.kind == "U" else vtkUnsignedCharArray()
            array.SetName(name)
            for value in values.tolist():
                array.InsertNextValue(value)
            dataset.GetFieldData().AddArray(array)
    return dataset


def field_numbers(dataset, name):
    """A numeric array of the field data."""
    array = dataset.GetFieldData().GetArray(name)
    return [int(array.GetTuple1(k)) for k in range(array.GetNumberOfTuples())]


def check_a_structured_grid_is_smoothed_with_its_cut_free():
    rough, _ = meshcore.o_grid(gallery.airfoil("naca0012", cells=48), radius=4, layers=16, first_height=0.02)
    mesh, _ = meshcore.elliptically_smoothed(rough, walls="south", first_height=0.02)
    assert abs(mesh.points[0, 1:-1] - rough.points[0, 1:-1]).max() > 1e-4
    for with_fields in (True, False):
        given = producer(structured(rough, with_fields=with_fields))
        dataset = fetched(pv.meshcoreEllipticSmoothing(Input=given, Walls="south", FirstHeight=0.02))
        assert_same_mesh(dataset, mesh)
        assert field_numbers(dataset, "periodic") == [1, 0, 0]
    given = producer(structured(rough))
    names = texts(fetched(pv.meshcoreEllipticSmoothing(Input=given)).GetFieldData(), FACE_NAMES)
    assert names == ["", "", "wall", "far field", "", ""], names


def check_a_disk_of_paraviews_own_is_smoothed():
    disk = pv.Disk(InnerRadius=0.5, OuterRadius=1.0, RadialResolution=6, CircumferentialResolution=24)
    dataset = fetched(pv.meshcoreEllipticSmoothing(Input=disk))
    assert dimensions(dataset) == (25, 7, 1)
    radius = np.linalg.norm(content(dataset)[0], axis=1).reshape(7, 25)
    even = np.sort(0.5 * 2 ** (np.arange(7) / 6))  # for ln r is harmonic
    np.testing.assert_allclose(np.sort(radius.mean(axis=1)), even, rtol=5e-3)


def check_a_volume_keeps_its_inside_as_start():
    passage = gallery.turbine_passage(6, 10, 5)
    dataset = fetched(pv.meshcoreEllipticVolume(Input=producer(structured(passage))))
    assert_same_mesh(dataset, meshcore.elliptic_volume(passage).mesh)


def check_layers_of_a_structured_surface_are_unstructured():
    patch = gallery.six_patches(5).blocks[0]
    given = producer(structured(patch))
    dataset = fetched(pv.meshcoreExtrudeHyperbolic(Input=given, FirstHeight=0.01, Layers=3))
    grid, _ = meshcore.hyperbolic_volume(patch, first_height=0.01, layers=3)
    assert_same_mesh(dataset, meshcore.with_named_sides(grid))
    assert named(dataset) == {"wall": 16, "outer": 16, "boundary": 4 * 12}


def named(dataset):
    """Number of cells of each set."""
    data = arrays(dataset.GetCellData())
    return {name.removeprefix("set:"): int(values.sum()) for name, values in data.items() if name.startswith("set:")}


def composite(leaves, names):
    """A vtkMultiBlockDataSet of datasets with names."""
    blocks = vtkMultiBlockDataSet()
    for k, (leaf, name) in enumerate(zip(leaves, names, strict=True)):
        blocks.SetBlock(k, leaf)
        blocks.GetMetaData(k).Set(blocks.NAME(), name)
    return blocks


def multi_block(surface):
    return composite([structured(block) for block in surface.blocks], surface.names)


def nested(surface):
    """Two of the blocks in a composite of their own, and an empty place between."""
    leaves = [structured(block) for block in surface.blocks]
    inner = composite(leaves[:2], surface.names[:2])
    return composite([inner, None, *leaves[2:]], ["first", "nothing", *surface.names[2:]])


def partitioned(surface):
    collection = vtkPartitionedDataSetCollection()
    for k, (block, name) in enumerate(zip(surface.blocks, surface.names, strict=True)):
        collection.SetPartition(k, 0, structured(block))
        collection.GetMetaData(k).Set(collection.NAME(), name)
    return collection


def check_blocks_become_layers_of_one_front():
    surface = gallery.six_patches(5)
    blocks, _ = meshcore.hyperbolic_volume(surface, first_height=0.01, layers=3)
    expected = blocks.to_mesh()
    assert expected.n_points == 4 * (6 * 9 + 12 * 3 + 8)  # no copies where blocks meet
    for composite in (multi_block(surface), nested(surface), partitioned(surface)):
        dataset = fetched(pv.meshcoreExtrudeHyperbolic(Input=producer(composite), FirstHeight=0.01, Layers=3))
        assert dataset.GetClassName() == "vtkUnstructuredGrid"
        np.testing.assert_array_equal(content(dataset)[0], expected.points)
        assert dataset.GetNumberOfCells() == expected.n_cells + 2 * 6 * 16
        found = named(dataset)
        assert found.pop("wall") == found.pop("outer") == 6 * 16 and list(found.values()) == 6 * [16 * 3]


def check_blocks_read_from_a_file_become_layers():
    surface = gallery.six_patches(5)
    path = str(OUT / "patches.vtm")
    meshcore.io.write(path, surface)
    dataset = fetched(pv.meshcoreExtrudeHyperbolic(Input=pv.XMLMultiBlockDataReader(FileName=[path]), Layers=3))
    assert dataset.GetNumberOfCells() == 6 * 16 * (3 + 2)


def check_composites_of_meshes_are_one_surface():
    surface = gallery.six_patches(5)
    given = composite([of_mesh(block.to_mesh()) for block in surface.blocks], surface.names)
    dataset = fetched(pv.meshcoreExtrudeHyperbolic(Input=producer(given), FirstHeight=0.01, Layers=3))
    assert dataset.GetNumberOfPoints() == 4 * (6 * 9 + 12 * 3 + 8)
    assert named(dataset) == {"outer": 6 * 16, **dict.fromkeys(surface.names, 16)}  # parts of the wall
    assert dataset.GetNumberOfCells() == 6 * 16 * (3 + 2)


def check_layers_end_on_a_second_input():
    surface = gallery.six_patches(5)
    sphere = pv.Sphere(Radius=3.0, ThetaResolution=64, PhiResolution=32)
    proxy = pv.meshcoreExtrudeHyperbolic(Input=producer(multi_block(surface)), Outer=sphere, FirstHeight=0.05, Layers=8)
    points = content(fetched(proxy))[0]
    radius = np.linalg.norm(points, axis=1)
    assert len(points) == 9 * (6 * 9 + 12 * 3 + 8) and 2.97 < radius.max() < 3 + 1e-6
    assert (radius > 2.97).sum() == 6 * 9 + 12 * 3 + 8


def check_edges_of_blocks_are_named_and_stay_on_a_second_input():
    u, v = np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 2, 7), indexing="ij")
    points = np.stack([u, v, 0.1 * np.sin(4 * u)], axis=-1)
    surface = meshcore.MultiBlock(
        tuple(meshcore.StructuredGrid(part) for part in (points[:5], points[4:])), ("low", "high")
    )
    y, z = np.meshgrid([-1.0, 3.0], [0.0, 1.0], indexing="ij")
    wall = meshcore.StructuredGrid(np.stack([-0.3 * z, y, z], axis=-1))
    asked = "high imax = constant x, jmin = periodic, jmax = periodic"
    proxy = pv.meshcoreExtrudeHyperbolic(
        Input=producer(multi_block(surface)), Guide=producer(structured(wall)), FirstHeight=0.01, Layers=5
    )
    proxy.EachEdge = asked
    blocks, _ = meshcore.hyperbolic_volume(surface, wall, first_height=0.01, layers=5, each_edge=asked)
    np.testing.assert_array_equal(content(fetched(proxy))[0], blocks.to_mesh().points)
    x, _, z = blocks.blocks[0].points[0].reshape(-1, 3).T
    assert np.abs(x + 0.3 * z).max() < 1e-12


if __name__ == "__main__":
    run_checks(globals())
