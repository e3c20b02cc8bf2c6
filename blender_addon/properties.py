# SPDX-License-Identifier: GPL-3.0-or-later
"""From the declared parameters of an operation to Blender's properties, and back to plain values."""

from __future__ import annotations

import functools
import json
from importlib import resources
from typing import Any

import bpy
import numpy as np

from . import inputs

# Blender has no "not set" for numbers: zero stands for None and for a length relative to the input.
_FACTORIES = {
    "bool": ("BoolProperty", "BoolVectorProperty"),
    "int": ("IntProperty", "IntVectorProperty"),
    "float": ("FloatProperty", "FloatVectorProperty"),
    "length": ("FloatProperty", "FloatVectorProperty"),
    "str": ("StringProperty", ""),
    "choice": ("EnumProperty", ""),
}


SIDES = [("BELOW", "Below", "Cells below the threshold"), ("ABOVE", "Above", "Cells above the threshold")]


@functools.cache
def registry() -> dict[str, Any]:
    """Declarations of all operations and names of the quality measures, as written when the zip was built."""
    return json.loads(resources.files(__package__).joinpath("operations.json").read_text(encoding="utf-8"))


def automatic(declared: dict[str, Any]) -> bool:
    """Whether zero is shown for "left to meshcore"."""
    return bool(declared.get("optional")) or isinstance(declared["default"], dict)


def annotation(declared: dict[str, Any]) -> Any:
    """The Blender property of one declared parameter."""
    kind, size = declared["kind"], declared.get("size", 1)
    keywords: dict[str, Any] = {"name": declared["label"], "description": _description(declared)}
    keywords["default"] = _default(declared)
    if kind == "choice":
        keywords["items"] = [(c, c.replace("_", " ").title(), "") for c in declared["choices"]]
    elif kind == "str" and declared.get("array"):
        keywords["search"] = _attribute_names
    elif kind in ("int", "float", "length"):
        keywords |= _limits(declared)
    if kind == "length":
        # A length fits one input only: it is filled in anew for each, never remembered.
        keywords |= {"subtype": "DISTANCE", "unit": "LENGTH", "precision": 5, "options": {"SKIP_SAVE"}}
    if size > 1:
        keywords["size"] = size
    return getattr(bpy.props, _FACTORIES[kind][size > 1])(**keywords)


def value(declared: dict[str, Any], shown: Any) -> Any:
    """What meshcore is to be given for a property's value; ``None`` leaves the parameter at its default."""
    if declared.get("size", 1) > 1:
        return tuple(_one(declared, item) for item in shown)
    if automatic(declared) and declared["kind"] in ("int", "float", "length") and shown == 0:
        return None
    return _one(declared, shown)


def values(declarations: dict[str, dict[str, Any]], properties: Any) -> dict[str, Any]:
    """Keyword arguments for an operation from an operator's properties."""
    given = {name: value(declared, getattr(properties, name)) for name, declared in declarations.items()}
    return {name: one for name, one in given.items() if one is not None}


def _one(declared: dict[str, Any], shown: Any) -> Any:
    if declared["kind"] in ("float", "length"):
        # Blender keeps 32 bits: 0.1 comes back as 0.10000000149, which may even lie beyond a limit of 0.1.
        return float(str(np.float32(shown)))
    return shown


def _default(declared: dict[str, Any]) -> Any:
    default = declared["default"]
    if default is None or isinstance(default, dict):
        size = declared.get("size", 1)
        empty = "" if declared["kind"] == "str" else 0
        return (empty,) * size if size > 1 else empty
    return tuple(default) if isinstance(default, list) else default


def _limits(declared: dict[str, Any]) -> dict[str, Any]:
    limits = {key: declared[key] for key in ("min", "max", "soft_min", "soft_max") if key in declared}
    if declared["kind"] == "length":
        limits.setdefault("min", 0)
    if automatic(declared) and "min" in limits:
        limits["min"] = min(limits["min"], 0)
    if declared["kind"] == "int":
        return {key: int(limit) for key, limit in limits.items()}
    return {key: float(limit) for key, limit in limits.items()}


def _description(declared: dict[str, Any]) -> str:
    text = declared["description"]
    if declared.get("unit"):
        text += f", in {declared['unit']}s"
    if automatic(declared) and declared["kind"] in ("int", "float", "length"):
        text += "; 0 is automatic" if isinstance(declared["default"], dict) else "; 0 leaves it open"
    return text


def object_name(port: dict[str, Any]) -> Any:
    """The Blender property that names the object of an optional input."""
    return bpy.props.StringProperty(
        name=port["label"], description=f"{port['description']}; empty for none", search=_objects_with_faces
    )


def _objects_with_faces(self: Any, context: Any, typed: str) -> list[str]:
    """Names of the scene's meshes that have faces."""
    found = [ob.name for ob in context.scene.objects if ob.type == "MESH" and len(ob.data.polygons)]
    return [name for name in found if typed.lower() in name.lower()]


def _attribute_names(self: Any, context: Any, typed: str) -> list[str]:
    """Number attributes and vertex groups of the active object and of those chosen by name."""
    ports = {name for declared in registry()["operations"].values() for name in inputs.by_name(declared)}
    chosen = [context.scene.objects.get(getattr(self, name, "")) for name in sorted(ports)]
    found = [
        attribute.name
        for ob in (context.object, *chosen)
        for attribute in getattr(ob.data if ob else None, "attributes", ())
        if attribute.domain in ("POINT", "FACE")
        and attribute.data_type in ("FLOAT", "INT")
        and not attribute.name.startswith(".")
    ]
    found += [group.name for ob in (context.object, *chosen) for group in getattr(ob, "vertex_groups", ())]
    return [name for name in dict.fromkeys(found) if typed.lower() in name.lower()]


@functools.cache
def measure_items() -> list[tuple[str, str, str]]:
    """Items of a property that names a quality measure; kept, since Blender holds no reference to their text."""
    names = dict.fromkeys(["scaled_jacobian", *registry()["measures"]])
    return [(name, name.replace("_", " ").title(), "") for name in names]


def measures_shown(self: Any, context: Any) -> list[tuple[str, str, str]]:
    """The same, as Blender calls it."""
    return measure_items()


class MESHCORE_PG_settings(bpy.types.PropertyGroup):
    """What the panel's Select Bad Cells shows."""

    measure: bpy.props.EnumProperty(name="Measure", description="Measure of quality", items=measures_shown)
    side: bpy.props.EnumProperty(name="Select", description="Which cells are bad", items=SIDES)
    threshold: bpy.props.FloatProperty(name="Threshold", description="Limit of the measure", default=0.3, precision=4)


def register() -> None:
    """Forget an older installation's declarations, and add the settings."""
    registry.cache_clear()
    measure_items.cache_clear()
    bpy.utils.register_class(MESHCORE_PG_settings)
    bpy.types.Scene.meshcore = bpy.props.PointerProperty(type=MESHCORE_PG_settings)


def unregister() -> None:
    """Take the settings away."""
    del bpy.types.Scene.meshcore
    bpy.utils.unregister_class(MESHCORE_PG_settings)
