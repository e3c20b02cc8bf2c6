"""The filters as pymeshlab's users meet them: signatures, help, binding, quality."""

from __future__ import annotations

import inspect
from typing import Annotated

import numpy as np
import pymeshlab
import pytest

import meshlab_filters
from meshcore import Mesh, Report, Result, StructuredGrid, gallery, operations, quality
from meshcore.operation import Param, operation
from meshlab_filters.__main__ import main
from tests.meshlab.conftest import add, model_call


@pytest.mark.parametrize("identifier", tuple(operations()))
def test_signature_and_documentation_tell_every_parameter(identifier):
    function = getattr(meshlab_filters, identifier)
    signature = inspect.signature(function)
    op = operations()[identifier]
    assert next(iter(signature.parameters)) == "ms"
    for name in (*list(op.inputs)[1:], *op.params):
        parameter = signature.parameters[name]
        assert parameter.kind is inspect.Parameter.KEYWORD_ONLY
        assert f"\n{name} : " in function.__doc__
    assert function.__doc__.startswith(op.summary)
    text = meshlab_filters.parameter_list(identifier)
    assert all(f"  {name} : " in text for name in op.params)


def test_relative_defaults_are_percentages():
    default = inspect.signature(meshlab_filters.transfinite).parameters["tolerance"].default
    assert isinstance(default, pymeshlab.PercentageValue)
    assert default.value() == pytest.approx(1e-4)


def test_help_is_printed(capsys):
    meshlab_filters.print_filter_parameter_list("refined")
    assert "fraction : float = 0.5" in capsys.readouterr().out
    meshlab_filters.print_filter_list()
    assert "compute_quality_per_face" in capsys.readouterr().out
    with pytest.raises(pymeshlab.PyMeshLabException, match="no filter 'refine'; try refined"):
        meshlab_filters.print_filter_parameter_list("refine")


def test_binding_is_on_demand_and_can_be_undone(ms):
    assert not hasattr(pymeshlab.MeshSet, "delaunay_refinement")
    names = meshlab_filters.install()
    try:
        assert names == meshlab_filters.install() == meshlab_filters.filter_list()
        add(ms, gallery.square(4), "square")
        assert ms.delaunay_refinement(size=pymeshlab.PercentageValue(20))["triangles"] > 10
    finally:
        assert meshlab_filters.uninstall() == names
    assert not hasattr(pymeshlab.MeshSet, "delaunay_refinement")
    assert meshlab_filters.uninstall() == []


def test_binding_leaves_the_methods_of_others_alone():
    class Other:
        refined = "mine"

    with pytest.raises(pymeshlab.PyMeshLabException, match="has a method refined of its own"):
        meshlab_filters.install(Other)
    assert vars(Other).get("transfinite") is None


def test_results_are_numbers_with_the_whole_beside_them(ms):
    keywords, _, _ = model_call(ms, "delaunay_refinement")
    result = meshlab_filters.delaunay_refinement(ms, label="mine", measure="min_angle", **keywords)
    assert all(isinstance(number, (int, float)) for number in result.values())
    assert result["triangles"] == result.mesh.n_cells
    assert result["smallest angle (degree)"] >= 30
    assert result.report.operation == "Delaunay Refinement"
    assert ms.current_mesh().label() == "mine"
    assert ms.current_mesh().face_scalar_array().min() >= 30


def test_quality_into_face_scalars(ms):
    keywords, _, _ = model_call(ms, "transfinite")
    grid = meshlab_filters.transfinite(ms, **keywords).mesh
    for measure in ("min_angle", "radius_ratio", "min_angle"):
        numbers = meshlab_filters.compute_quality_per_face(ms, measure=measure)
        expected = quality.measure(grid.to_mesh(), measure)
        np.testing.assert_allclose(ms.current_mesh().face_scalar_array(), np.repeat(expected, 2), rtol=1e-6)
        assert numbers["min"] == pytest.approx(expected.min())
        assert numbers["max"] == pytest.approx(expected.max())


def test_selection_of_bad_faces(ms):
    keywords, _, _ = model_call(ms, "transfinite")
    grid = meshlab_filters.transfinite(ms, **keywords).mesh
    ratio = quality.measure(grid.to_mesh(), "radius_ratio")
    assert (
        meshlab_filters.select_faces_by_quality(ms, measure="radius_ratio")["selected"] == 2 * (ratio > 1.3).sum() > 0
    )
    chosen = ms.current_mesh().face_selection_array()
    np.testing.assert_array_equal(chosen, np.repeat(ratio > 1.3, 2))
    few = meshlab_filters.select_faces_by_quality(ms, measure="radius_ratio", maximum=1.7)
    assert few["selected"] == 2 * (ratio > 1.7).sum()
    assert meshlab_filters.select_faces_by_quality(ms, measure="min_angle", minimum=0)["selected"] == 0


def test_refinement_by_the_layers_own_scalars(ms):
    plate = gallery.triangulated_square(6)
    add(ms, plate, "plate")
    ms.compute_scalar_by_function_per_face(q="x0 * x0")
    by_faces = meshlab_filters.refined(ms, indicator="face_scalar", fraction=0.3)
    assert 72 < by_faces["triangles"] < 288
    new = by_faces.mesh.points[plate.n_points :]
    assert new[:, 0].mean() > 0.7
    ms.set_current_mesh(0)
    ms.compute_scalar_by_function_per_vertex(q="x > 0.6 ? 1 : 0")
    by_points = meshlab_filters.refined(ms, indicator="vertex_scalar", fraction=0.5)
    assert np.abs(by_points.mesh.points[plate.n_points :, 0] - 0.6).max() < 0.3


def test_attributes_are_taken_along(ms):
    add(ms, gallery.triangulated_square(3), "plate")
    result = meshlab_filters.refined(ms, attributes=("front",))
    again = ms.current_mesh().vertex_custom_scalar_attribute_array("front")
    np.testing.assert_array_equal(again, result.mesh.point_data["front"])


def test_write_keeps_what_layers_lose(ms, tmp_path):
    from meshcore import io

    keywords, _, _ = model_call(ms, "transfinite")
    result = meshlab_filters.transfinite(ms, **keywords)
    meshlab_filters.write(result, tmp_path / "grid.vts")
    again = io.read(tmp_path / "grid.vts")
    assert isinstance(again, StructuredGrid)
    np.testing.assert_array_equal(again.points, result.mesh.points)
    with pytest.raises(pymeshlab.PyMeshLabException, match="write: "):
        meshlab_filters.write(result, tmp_path / "grid.nonsense")
    with pytest.raises(pymeshlab.PyMeshLabException, match="write: "):
        meshlab_filters.write(result, tmp_path / "nowhere" / "grid.vts")
    meshlab_filters.write(Mesh([[0, 0], [1, 0], [0, 1]], {"triangle": [[0, 1, 2]]}), tmp_path / "one.vtu")
    assert (tmp_path / "one.vtu").stat().st_size


@pytest.fixture
def plate(monkeypatch):
    """The filter of an operation that has parameters only."""
    monkeypatch.setattr("meshcore.operation._REGISTRY", {})

    @operation("Plate", category="Unstructured")
    def plate(*, size: Annotated[float, Param("size", min=0.1)] = 1.0) -> Result:
        """Make a plate."""
        mesh = gallery.triangulated_square(2)
        return Result(Mesh(size * mesh.points, mesh.cells), Report(counts={"points": mesh.n_points}))

    return meshlab_filters.filters.make_filter(operations()["plate"])


def test_an_operation_without_inputs_makes_a_layer_from_nothing(ms, plate):
    assert list(inspect.signature(plate).parameters)[:2] == ["ms", "size"]
    assert "\nsize : float\n" in plate.__doc__
    result = plate(ms, size=3.0)
    assert (ms.mesh_number(), result["layer"], ms.current_mesh().label()) == (1, ms.current_mesh_id(), "Plate")
    assert ms.current_mesh().vertex_matrix().max() == 3
    plate(ms)
    assert ms.mesh_number() == 2 and ms.current_mesh().vertex_matrix().max() == 1


def test_an_operation_without_inputs_needs_no_file(plate, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(meshlab_filters.binding.ALL, "plate", plate)
    out = tmp_path / "plate.ply"
    assert main([str(out), "--filter", "plate", "-p", "size=2"]) == 0
    scene = pymeshlab.MeshSet(verbose=False)
    scene.load_new_mesh(str(out))
    assert scene.current_mesh().vertex_matrix().max() == 2
    assert main([str(out), str(tmp_path / "both.mlp"), "--filter", "plate"]) == 0  # added to what is there
    meshlab_filters.load(scene, tmp_path / "both.mlp")
    assert [m.label() for m in scene][1:] == ["plate.ply", "Plate"]
    assert main(["--filter", "plate"]) == 2
    assert "output is missing" in capsys.readouterr().err
