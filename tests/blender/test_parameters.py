"""Blender's properties say what the registry says, and give meshcore the numbers that the user typed."""

from __future__ import annotations

import json
from pathlib import Path

import bpy
import numpy as np
import pytest

from tests.blender import scene

OPERATIONS = json.loads((Path(__file__).parent.parent / "registry.json").read_text())
PARAMS = [(identifier, name) for identifier, op in OPERATIONS.items() for name in op["params"]]
NUMBERS = [(i, n) for i, n in PARAMS if OPERATIONS[i]["params"][n]["kind"] in ("int", "float", "length")]
TYPES = {"bool": "BOOLEAN", "int": "INT", "float": "FLOAT", "length": "FLOAT", "str": "STRING", "choice": "ENUM"}
HARD = {"INT": 2**31 - 1, "FLOAT": np.finfo(np.float32).max}


def shown(identifier):
    """The properties that an operator shows."""
    rna = scene.operator(identifier).get_rna_type()
    return {p.identifier: p for p in rna.properties if p.identifier != "rna_type"}


@pytest.mark.parametrize("identifier", OPERATIONS)
def test_names_in_order_and_no_other(identifier):
    named = scene.addon("inputs").by_name(OPERATIONS[identifier])
    assert list(shown(identifier)) == [*named, *OPERATIONS[identifier]["params"]]
    assert all(named[name]["optional"] and shown(identifier)[name].type == "STRING" for name in named)


@pytest.mark.parametrize("identifier", OPERATIONS)
def test_no_parameter_has_a_name_of_blenders_own(identifier):
    taken = set(dir(bpy.types.Operator)) | {"execute", "invoke", "modal", "draw", "poll", "cancel", "check"}
    assert not taken & set(OPERATIONS[identifier]["params"])


@pytest.mark.parametrize(("identifier", "name"), PARAMS)
def test_label_type_and_description(identifier, name):
    declared, here = OPERATIONS[identifier]["params"][name], shown(identifier)[name]
    assert here.name == declared["label"]
    assert here.type == TYPES[declared["kind"]]
    assert here.description.startswith(declared["description"])
    if declared["kind"] == "length":
        assert (here.subtype, here.unit) == ("DISTANCE", "LENGTH")
    if declared["kind"] == "choice":
        assert [item.identifier for item in here.enum_items] == declared["choices"]
        assert here.default == declared["default"]


@pytest.mark.parametrize(("identifier", "name"), NUMBERS)
def test_limits_are_the_registrys_with_zero_for_automatic(identifier, name):
    declared, here = OPERATIONS[identifier]["params"][name], shown(identifier)[name]
    left_open = declared.get("optional") or isinstance(declared["default"], dict)
    low = declared.get("min", 0 if declared["kind"] == "length" else None)
    if left_open and low is not None:
        low = min(low, 0)
    assert here.hard_min == pytest.approx(-HARD[here.type] if low is None else low, rel=1e-6)
    assert here.hard_max == pytest.approx(declared.get("max", HARD[here.type]), rel=1e-6)
    if "soft_max" in declared:
        assert here.soft_max == pytest.approx(declared["soft_max"], rel=1e-6)
    default = declared["default"]
    if declared.get("size", 1) > 1:
        assert list(here.default_array) == pytest.approx(list(default))
    else:
        assert here.default == pytest.approx(0 if left_open and not isinstance(default, (int, float)) else default)


@pytest.mark.parametrize(("identifier", "name"), NUMBERS)
def test_meshcore_takes_all_that_blender_lets_through(core, identifier, name):
    """Blender clamps silently; what it clamps to must not be refused behind it."""
    declared, here = OPERATIONS[identifier]["params"][name], shown(identifier)[name]
    properties = scene.addon("properties")
    param = core.operations()[identifier].params[name]
    for end in (here.hard_min, here.hard_max):
        value = properties.value(declared, [end] * param.size if param.size > 1 else end)
        param.check(value) if value is not None else None


def test_numbers_arrive_as_they_were_typed(installed):
    properties = scene.addon("properties")
    declared = {"kind": "float", "default": 1.0}
    for typed in (0.1, 20.7, 1e-6, 34.0, 123456.0):
        assert properties.value(declared, float(np.float32(typed))) == typed


def test_zero_leaves_an_optional_number_out(installed):
    properties = scene.addon("properties")
    params = {
        "size": {"kind": "length", "default": {"relative": 0.1}},
        "count": {"kind": "int", "default": None, "optional": True},
        "levels": {"kind": "int", "default": 1},
    }
    zeros = type("Zeros", (), {"size": 0.0, "count": 0, "levels": 0})
    assert properties.values(params, zeros) == {"levels": 0}


def test_absurd_values_are_clamped_not_crashed(installed):
    scene.add_mesh("square", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], faces=[(0, 1, 2, 3)])
    assert bpy.ops.meshcore.transfinite(cells_i=-5, cells_j=-(2**31)) == {"FINISHED"}
    assert len(scene.active().data.polygons) == 1


def test_wrong_types_are_refused_by_blender(installed):
    scene.add_mesh("square", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], faces=[(0, 1, 2, 3)])
    with pytest.raises(TypeError):
        bpy.ops.meshcore.transfinite(cells_i="many")
    with pytest.raises(TypeError):
        bpy.ops.meshcore.transfinite(blending="magic")
