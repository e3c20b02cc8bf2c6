"""Model sources, quality, reader and writer."""

from __future__ import annotations

import numpy as np
import paraview.simple as pv
from datasets import arrays, assert_same, content, dimensions, fetched, polylines, producer, texts, unstructured
from harness import OUT, load_plugin, run_checks, said

import meshcore
from meshcore import gallery

load_plugin()


def check_airfoil_in_its_far_field():
    dataset = fetched(pv.meshcoreAirfoil(Section="naca0012", FarField=5, FarFieldPoints=30))
    points, cells, cell_data, _ = content(dataset)
    section = gallery.airfoil("naca0012")
    tag = cell_data["tag"]
    assert list(cells) == ["line"] and len(tag) == 30 + section.n_cells
    np.testing.assert_array_equal(points[np.unique(cells["line"][tag == 2])], section.points)
    circle = points[np.unique(cells["line"][tag == 1])]
    np.testing.assert_allclose(np.hypot(circle[:, 0] - 0.5, circle[:, 1]), 5, rtol=1e-2)


def check_an_airfoil_in_its_far_field_is_all_that_an_o_grid_needs():
    """The circle is its outer curve, as if both came from sources of their own."""
    dataset = fetched(pv.meshcoreOGrid(Section=pv.meshcoreAirfoil(Section="naca0012", FarField=5, FarFieldPoints=90)))
    circle = gallery.circle(90, radius=5, centre=(0.5, 0))
    expected = meshcore.o_grid(gallery.airfoil("naca0012"), circle).mesh
    assert dataset.GetClassName() == "vtkStructuredGrid"
    np.testing.assert_allclose(content(dataset)[0], expected.flat(expected.points), atol=1e-9)


def check_airfoil_from_a_file_of_the_users_own():
    path = OUT / "own.dat"
    rows = [(1, 0), (0.5, 0.06), (0, 0), (0.5, -0.05), (1, 0)]
    path.write_text("own section\n" + "".join(f"{x} {y}\n" for x, y in rows))
    points, cells, _, _ = content(fetched(pv.meshcoreAirfoil(CoordinateFile=str(path), FarField=0)))
    assert len(cells["line"]) == 4
    assert {tuple(p) for p in points.tolist()} == {(x, y, 0.0) for x, y in rows}


def check_every_section_and_model_is_offered_and_works():
    for name in gallery.airfoils():
        assert fetched(pv.meshcoreAirfoil(Section=name, FarField=0)).GetNumberOfCells() > 50, name
    models = pv.meshcoreModel().GetProperty("Model").Available
    assert len(models) > 3
    for name in models:
        assert fetched(pv.meshcoreModel(Model=name, Resolution=5)).GetNumberOfCells() >= 5, name


def check_triangulated_model_keeps_its_field():
    mesh = gallery.triangulated_square(6)
    dataset = fetched(pv.meshcoreModel(Model="Triangulated Square", Resolution=6))
    assert dataset.GetClassName() == "vtkPolyData"
    assert_same(dataset, mesh.points, mesh.cells, {}, mesh.point_data)


def mixed():
    points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0), (2, 1, 0), (3, 0, 0), (3, 1, 0), (2.5, 2, 0)]
    cells = [(9, (0, 1, 2, 3)), (5, (1, 4, 2)), (3, (0, 1)), (7, (4, 6, 7, 8, 5)), (5, (4, 5, 2))]
    return unstructured(points, cells, {"mark": np.arange(5)})


def check_quality_of_each_cell():
    dataset = fetched(pv.meshcoreMeshQuality(Input=producer(mixed()), Measure="min_angle"))
    values = arrays(dataset.GetCellData())["min_angle"]
    np.testing.assert_allclose(values[[0, 1, 4]], [90, 45, 45])
    assert np.isnan(values[[2, 3]]).all()  # a line, and a polygon that meshcore takes apart
    assert arrays(dataset.GetCellData())["mark"].tolist() == [0, 1, 2, 3, 4]


def check_quality_keeps_the_type_of_its_input():
    kinds = {
        "vtkPolyData": pv.Sphere(),
        "vtkStructuredGrid": pv.meshcoreTransfiniteInterpolation(South=pv.Plane(XResolution=3, YResolution=2)),
        "vtkImageData": pv.Wavelet(WholeExtent=[0, 3, 0, 3, 0, 3]),
        "vtkUnstructuredGrid": producer(mixed()),
    }
    for kind, source in kinds.items():
        dataset = fetched(pv.meshcoreMeshQuality(Input=source, Measure="scaled_jacobian"))
        assert dataset.GetClassName() == kind
        assert dataset.GetNumberOfCells() == fetched(source).GetNumberOfCells() > 0
        values = arrays(dataset.GetCellData())["scaled_jacobian"]
        assert np.nanmax(values) <= 1 + 1e-12 and np.isfinite(values).any(), kind


def check_quality_agrees_with_paraviews_own():
    sphere = pv.Sphere(ThetaResolution=11)
    own = pv.MeshQuality(Input=sphere, TriangleQualityMeasure="Minimum Angle")
    ours = pv.meshcoreMeshQuality(Input=sphere, Measure="min_angle")
    wanted = arrays(fetched(own).GetCellData())["Quality"]
    np.testing.assert_allclose(arrays(fetched(ours).GetCellData())["min_angle"], wanted, rtol=1e-5)


def check_every_measure_is_offered():
    proxy = pv.meshcoreMeshQuality(Input=pv.Sphere())
    assert tuple(proxy.GetProperty("Measure").Available) == meshcore.quality.measures()


def check_quality_summary_is_in_the_field_data():
    dataset = fetched(pv.meshcoreMeshQuality(Input=pv.Sphere()))
    assert "smallest angle (degree)" in arrays(dataset.GetFieldData())


def check_written_and_read_again():
    model = pv.meshcoreModel(Model="Triangulated Square", Resolution=4)
    mesh = gallery.triangulated_square(4)
    for extension in ("off", "su2"):
        path = OUT / f"model.{extension}"
        with said() as text:
            pv.SaveData(str(path), proxy=model)
        dataset = fetched(pv.meshcoreReader(FileName=str(path)))
        points, cells, _, _ = content(dataset)
        np.testing.assert_allclose(points, mesh.points, rtol=1e-12, err_msg=extension)
        np.testing.assert_array_equal(cells["triangle"], mesh.cells["triangle"], err_msg=extension)
        assert "'front'" in text[0], text[0]  # the array that the format cannot hold is named


def check_poly_keeps_its_boundary():
    square = pv.meshcoreModel(Model="Square with Hole", Resolution=4)
    path = OUT / "square.poly"
    pv.SaveData(str(path), proxy=square)
    points, cells, _, _ = content(fetched(pv.meshcoreReader(FileName=str(path))))
    mesh = gallery.square_with_hole(4)
    np.testing.assert_array_equal(points, mesh.points)
    np.testing.assert_array_equal(cells["line"], mesh.cells["line"])


def check_reader_notices_that_the_file_changed():
    path = OUT / "changing.poly"
    pv.SaveData(str(path), proxy=pv.meshcoreModel(Model="Square", Resolution=4))
    reader = pv.meshcoreReader(FileName=str(path))
    assert fetched(reader).GetNumberOfPoints() == 16
    pv.SaveData(str(path), proxy=pv.meshcoreModel(Model="Square", Resolution=5))
    pv.ReloadFiles(reader)
    assert fetched(reader).GetNumberOfPoints() == 20


def check_structured_grids_in_plot3d():
    grid = pv.meshcoreTransfiniteInterpolation(South=pv.Plane(XResolution=3, YResolution=2))
    path = OUT / "grid.xyz"
    pv.SaveData(str(path), proxy=grid)
    dataset = fetched(pv.meshcoreReader(FileName=str(path)))
    assert dataset.GetClassName() == "vtkStructuredGrid" and dimensions(dataset) == (4, 3, 1)
    np.testing.assert_allclose(content(dataset)[0], content(fetched(grid))[0], atol=1e-7)


def check_blocks_in_plot3d():
    x, y = np.meshgrid([0.0, 1, 2], [0.0, 1], indexing="ij")
    block = meshcore.StructuredGrid(np.stack([x, y], axis=-1))
    path = OUT / "blocks.xyz"
    meshcore.io.write(path, meshcore.MultiBlock((block, block.with_points(block.points + [2, 0, 0]))))
    reader = pv.meshcoreReader(FileName=str(path))
    dataset = fetched(reader)
    assert dataset.GetClassName() == "vtkMultiBlockDataSet" and dataset.GetNumberOfBlocks() == 2
    assert content(dataset.GetBlock(1))[0][:, 0].max() == 4


def check_warnings_of_a_report_are_shown():
    # A kite with a deep notch: interpolation spills over, which the report warns of or an error tells.
    notched = [(0, 0, 0), (4, 0, 0), (1, 1, 0), (0, 4, 0), (0, 0, 0)]
    proxy = pv.meshcoreTransfiniteInterpolation(South=producer(polylines(notched)), CellsI=12, CellsJ=12)
    with said() as text:
        proxy.UpdatePipeline()
    if "ERR| meshcore Transfinite Interpolation: " not in text[0]:
        rows = texts(fetched(proxy).GetFieldData(), "report")
        warned = [row[len("warning: ") :] for row in rows if row.startswith("warning: ")]
        assert warned and all(f": {warning}" in text[0] for warning in warned), (rows, text[0])


if __name__ == "__main__":
    run_checks(globals())
