"""A user's way: make, change in the redo panel, undo, look at quality, save, open again."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from tests.blender import scene

L_SHAPE = [(0, 0, 0), (2, 0, 0), (2, 1, 0), (1.2, 0.6, 0), (0, 2, 0)]


@pytest.fixture
def patch(installed):
    """A patch of 8 x 6 quads with a strong kink."""
    scene.add_mesh("outline", L_SHAPE, [(k, (k + 1) % 5) for k in range(5)])
    bpy.ops.meshcore.transfinite(cells_i=8, cells_j=6, corners=(0, 1, 2, 4))
    return scene.active()


def measured(core, ob, name):
    """A quality measure of the quads of an object."""
    mesh = core.Mesh(scene.world_points(ob), {"quad": np.array(scene.faces(ob))})
    return core.quality.measure(mesh, name)


def test_redo_and_undo(installed):
    scene.add_mesh("outline", L_SHAPE, [(k, (k + 1) % 5) for k in range(5)])
    bpy.ops.ed.undo_push(message="outline")
    bpy.ops.meshcore.transfinite("EXEC_DEFAULT", True, cells_i=8, cells_j=6)
    assert len(scene.active().data.polygons) == 48
    # The redo panel undoes the operator and runs it again with the new value.
    bpy.ops.ed.undo()
    assert scene.names() == {"outline"}
    bpy.ops.meshcore.transfinite("EXEC_DEFAULT", True, cells_i=5, cells_j=6)
    assert len(scene.active().data.polygons) == 30
    bpy.ops.ed.undo()
    assert scene.names() == {"outline"}
    bpy.ops.ed.redo()
    assert len(bpy.data.objects["outline Transfinite Interpolation"].data.polygons) == 30


def test_operator_registers_for_redo_and_undo(installed):
    assert bpy.types.MESHCORE_OT_transfinite.bl_options == {"REGISTER", "UNDO"}


def test_quality_is_a_face_attribute(core, patch):
    attribute = patch.data.attributes["quality"]
    assert (attribute.domain, attribute.data_type) == ("FACE", "FLOAT")
    np.testing.assert_allclose(scene.values(patch, "quality"), measured(core, patch, "scaled_jacobian"), atol=1e-5)


@pytest.mark.parametrize("measure", ["scaled_jacobian", "max_angle", "area"])
@pytest.mark.parametrize("side", ["BELOW", "ABOVE"])
def test_select_bad_cells(core, patch, measure, side):
    values = measured(core, patch, measure)
    threshold = float(np.float32(np.median(values) + 1e-4))
    assert bpy.ops.meshcore.select_bad_cells(measure=measure, side=side, threshold=threshold) == {"FINISHED"}
    assert patch.mode == "EDIT"
    assert tuple(bpy.context.tool_settings.mesh_select_mode) == (False, False, True)
    bpy.ops.object.mode_set(mode="OBJECT")
    wanted = values < threshold if side == "BELOW" else values > threshold
    assert 0 < wanted.sum() < len(wanted)
    assert [face.select for face in patch.data.polygons] == wanted.tolist()


def test_select_bad_cells_again_from_edit_mode(patch):
    bpy.ops.meshcore.select_bad_cells(measure="scaled_jacobian", side="ABOVE", threshold=-2)
    bpy.ops.meshcore.select_bad_cells(measure="scaled_jacobian", side="BELOW", threshold=-2)
    bpy.ops.object.mode_set(mode="OBJECT")
    assert not any(face.select for face in patch.data.polygons)


def test_faces_without_a_measure_are_never_bad(installed):
    angle = 2 * np.pi * np.arange(5) / 5
    scene.add_mesh("pentagon", np.column_stack([np.cos(angle), np.sin(angle), 0 * angle]), faces=[range(5)])
    for side in ("BELOW", "ABOVE"):
        bpy.ops.meshcore.select_bad_cells(side=side, threshold=0)
        bpy.ops.object.mode_set(mode="OBJECT")
        assert not scene.active().data.polygons[0].select


def test_mesh_whose_edges_blender_made(installed):
    """Blender 5.0 gives such edges a selection of the wrong type, and crashes when it is written to."""
    data = bpy.data.meshes.new("made")
    data.from_pydata(L_SHAPE, [], [(0, 1, 3), (3, 4, 0)])
    scene.link(bpy.data.objects.new("made", data))
    assert bpy.ops.meshcore.select_bad_cells(side="ABOVE", threshold=-2) == {"FINISHED"}


def test_select_bad_cells_needs_faces(installed):
    with pytest.raises(RuntimeError, match="Select a mesh with faces"):
        bpy.ops.meshcore.select_bad_cells()
    scene.add_mesh("line", [(0, 0, 0), (1, 0, 0)], [(0, 1)])
    with pytest.raises(RuntimeError, match="line has no faces"):
        bpy.ops.meshcore.select_bad_cells()
    assert scene.active().mode == "OBJECT"


def test_saved_file_keeps_quality_and_report(core, patch, tmp_path):
    name, quality, points = patch.name, scene.values(patch, "quality"), scene.world_points(patch)
    report = patch.data["meshcore_report"].to_dict()
    assert report["counts"] == {"points": 63, "quads": 48}
    assert report["quality"]
    file = str(tmp_path / "patch.blend")
    bpy.ops.wm.save_as_mainfile(filepath=file)
    bpy.ops.wm.open_mainfile(filepath=file)
    again = bpy.data.objects[name]
    np.testing.assert_array_equal(scene.values(again, "quality"), quality)
    np.testing.assert_array_equal(scene.world_points(again), points)
    assert again.data["meshcore_report"].to_dict() == report
    scene.activate(again)
    assert bpy.ops.meshcore.select_bad_cells(threshold=0.5) == {"FINISHED"}


def test_result_goes_into_the_sources_collection(installed):
    ob = scene.add_mesh("outline", L_SHAPE, [(k, (k + 1) % 5) for k in range(5)])
    collection = bpy.data.collections.new("parts")
    bpy.context.scene.collection.children.link(collection)
    collection.objects.link(ob)
    bpy.context.scene.collection.objects.unlink(ob)
    scene.activate(ob)
    bpy.ops.meshcore.transfinite(cells_i=3, cells_j=3)
    assert [c.name for c in scene.active().users_collection] == ["parts"]
    assert not ob.select_get()


def test_from_edit_mode_the_result_is_shown_in_object_mode(installed):
    ob = scene.add_mesh("outline", L_SHAPE, [(k, (k + 1) % 5) for k in range(5)])
    bpy.ops.object.mode_set(mode="EDIT")
    assert bpy.ops.meshcore.transfinite(cells_i=3, cells_j=3) == {"FINISHED"}
    assert ob.mode == "OBJECT"
    assert scene.active() != ob


# ---- menus and panels, drawn into a layout that takes notes


class Notes:
    """Stands in for a layout."""

    def __init__(self, taken=None):
        self.taken = [] if taken is None else taken

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)

        def note(*arguments, **keywords):
            self.taken.append((name, [a for a in arguments if isinstance(a, str)], keywords))
            return Notes(self.taken)

        return note

    def texts(self):
        """All that would be read."""
        return [k["text"] for _, _, k in self.taken if "text" in k] + [a for _, args, _ in self.taken for a in args]


def drawn(cls, **fields):
    """What a class draws."""
    stand_in = type("Drawn", (), {"layout": Notes(), **fields})()
    cls.draw(stand_in, bpy.context)
    return stand_in.layout.texts()


def test_menu_lists_every_operation(core):
    texts = drawn(bpy.types.MESHCORE_MT_operations)
    for identifier, operation in core.operations().items():
        assert f"meshcore.{identifier}" in texts
        assert operation.label in texts


def test_panel_says_what_to_select(core):
    assert any("select 4 curves" in text.lower() for text in drawn(bpy.types.VIEW3D_PT_meshcore))


def test_quality_panel_shows_the_report(patch):
    texts = drawn(bpy.types.VIEW3D_PT_meshcore_quality)
    assert "quads" in texts
    assert "48" in texts
    assert any("jacobian" in text for text in texts)
    assert "meshcore.select_bad_cells" in texts


def test_redo_panel_shows_every_parameter(core):
    for identifier, operation in core.operations().items():
        cls = getattr(bpy.types, f"MESHCORE_OT_{identifier}")
        assert set(operation.params) <= set(drawn(cls, declaration=cls.declaration))


def test_preferences_tell_versions(installed, core):
    preferences = scene.addon("preferences")
    cls = preferences.MESHCORE_AP_preferences
    assert "bl_ext.user_default.meshcore" in bpy.context.preferences.addons
    assert bpy.context.preferences.addons["bl_ext.user_default.meshcore"].preferences is not None
    texts = drawn(cls)
    assert f"meshcore {core.__version__}" in texts
    assert "meshcore.compile_kernels" in texts


def test_attribute_field_offers_number_attributes(installed):
    properties = scene.addon("properties")
    ob = scene.add_mesh("tagged", L_SHAPE[:3], faces=[(0, 1, 2)])
    for name, kind, domain in [("heat", "FLOAT", "POINT"), ("load", "FLOAT", "FACE"), ("way", "FLOAT_VECTOR", "POINT")]:
        ob.data.attributes.new(name, kind, domain)
    assert set(properties._attribute_names(None, bpy.context, "")) == {"heat", "load"}
    assert properties._attribute_names(None, bpy.context, "HE") == ["heat"]
