"""The ParaView plugin's file is what its generator makes of today's registry, and its panels are sound. No ParaView."""

from __future__ import annotations

import ast
import importlib.util
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Annotated, Literal

import pytest

import meshcore
from meshcore.operation import Length, Param, Port, Relative, operation

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "paraview_plugin"
PROPERTIES = ("IntVectorProperty", "DoubleVectorProperty", "StringVectorProperty")


@pytest.fixture(scope="module")
def generate():
    spec = importlib.util.spec_from_file_location("generate_paraview_plugin", FOLDER / "generate.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def class_of(text: str) -> ast.ClassDef:
    """The one class of a generated text, which must be Python."""
    (node,) = ast.parse(text).body
    return node


def decoration(node: ast.ClassDef, name: str) -> ast.Call:
    """The call of the decorator ``smproxy.filter``, ``smproperty.xml``, ..."""
    (call,) = [d for d in node.decorator_list if ast.unparse(d.func) == name]
    return call


def panel_of(node: ast.ClassDef) -> ET.Element:
    return ET.fromstring(f"<panel>{decoration(node, 'smproperty.xml').args[0].value}</panel>")


def properties(panel: ET.Element) -> dict[str, ET.Element]:
    return {e.get("label"): e for e in panel if e.tag in PROPERTIES}


def attribute(node: ast.ClassDef, name: str):
    (value,) = [s.value for s in node.body if isinstance(s, ast.Assign) and s.targets[0].id == name]
    return ast.literal_eval(value)


def test_the_checked_in_file_is_up_to_date(generate):
    assert generate.PLUGIN.read_text(encoding="utf-8") == generate.plugin(), "run: make paraview-plugin"


@pytest.mark.parametrize("identifier", list(meshcore.operations()))
def test_every_operation_has_a_whole_panel(generate, identifier):
    entry = meshcore.operations()[identifier]
    node = class_of(generate.operation_class(entry))
    panel = panel_of(node)
    asked = [e for e in panel if e.get("information_only")]
    for element in asked:
        panel.remove(element)
    shown = properties(panel)
    assert [e.get("command") for e in asked] == (["GetSetUp"] if entry.output == "grid" else [])
    of_background = [f"{port.label} {p.label}" for port, p in generate._own_arrays(entry)]
    assert [label for label in shown if label not in of_background] == [p.label for p in entry.params.values()]
    assert [label for label in shown if label in of_background] == of_background
    grouped = [member.get("name") for group in panel.iter("PropertyGroup") for member in group]
    assert sorted(grouped) == sorted(e.get("name") for e in shown.values())
    methods = {item.name for item in node.body if isinstance(item, ast.FunctionDef)}
    assert methods == {e.get("command") for e in shown.values()}
    assert all(e.findtext("Documentation") for e in shown.values())
    inputs = [e for e in panel if e.tag == "InputProperty"]
    assert [int(e.get("port_index")) for e in inputs] == list(range(len(entry.inputs)))
    assert [e.find("Hints/Optional") is not None for e in inputs] == [p.optional for p in entry.inputs.values()]
    assert node.name == "meshcore" + entry.label.replace(" ", "")  # the function's name in pvpython


def test_class_names_are_all_different():
    names = [op.label.replace(" ", "") for op in meshcore.operations().values()]
    assert len(set(names)) == len(names)


@pytest.fixture
def awkward(monkeypatch):
    """An operation with every kind of parameter and text that must be escaped."""
    monkeypatch.setattr("meshcore.operation._REGISTRY", {})

    @operation("Awkward", category="Structured")
    def awkward(
        mesh: Annotated[meshcore.Mesh, Port('cells where a < b & "c"')],
        other: Annotated[meshcore.StructuredGrid | None, Port("a grid")] = None,
        *,
        size: Annotated[Length, Param(r'not "far" \n from <here> & """there"""')] = Relative(0.05),
        gap: Annotated[Length, Param("gap", min=0)] = Relative(0.01),
        top: Annotated[float | None, Param("top", min=1, soft_max=9, group="Limits")] = None,
        way: Annotated[Literal["left", "r&b"], Param("way")] = "r&b",
        on: Annotated[bool, Param("on", advanced=True)] = True,
        field: Annotated[str, Param("field", array=True)] = "",
        box: Annotated[tuple[int, int, int], Param("box", min=-1, max=7)] = (1, 2, 3),
    ) -> meshcore.Result:
        """Do 5 < 6 & more."""

    return meshcore.operations()["awkward"]


def test_text_is_escaped(generate, awkward):
    panel = panel_of(class_of(generate.operation_class(awkward)))
    assert panel.findtext("Documentation") == "Do 5 < 6 & more."
    said = " ".join(properties(panel)["Size"].findtext("Documentation").split())
    assert said.startswith(r'not "far" \n from <here> & """there""";')


def test_each_kind_of_parameter_has_its_domain(generate, awkward):
    shown = properties(panel_of(class_of(generate.operation_class(awkward))))
    bounds = shown["Size"].find("BoundsDomain")
    assert (bounds.get("mode"), bounds.get("scale_factor")) == ("scaled_extent", "0.05")
    limits = shown["Top"].find("DoubleRangeDomain")
    assert (limits.get("min"), limits.get("max")) == ("0", "9")  # 0 stands for None
    entries = shown["Way"].find("EnumerationDomain")
    assert [(e.get("value"), e.get("text")) for e in entries] == [("0", "left"), ("1", "r&b")]
    assert shown["Way"].get("default_values") == "1"
    assert shown["On"].find("BooleanDomain") is not None and shown["On"].get("panel_visibility") == "advanced"
    assert shown["Field"].find("ArrayListDomain").get("none_string") == "None"
    box = shown["Box"]
    assert (box.get("number_of_elements"), box.get("default_values")) == ("3", "1 2 3")
    assert box.find("IntRangeDomain").get("max") == "7 7 7"


def test_setters_speak_meshcores_language(generate, awkward):
    source = generate.operation_class(awkward)
    kept = {}

    class Base:
        def set(self, name, *values):
            kept[name] = values[0] if len(values) == 1 else values

    namespace = {"BY_DEFAULT": "default", "NO_ARRAY": "None", "Operation": Base}
    node = class_of(source)
    node.decorator_list = []
    exec(compile(ast.Module([node], []), "plugin", "exec"), namespace)
    instance = namespace["meshcoreAwkward"]()
    calls = {"Size": [-1.0], "Gap": [0.0], "Top": [0.0], "Way": [0], "On": [0], "Field": ["None"], "Box": [4, 5, 6]}
    for name, values in calls.items():
        getattr(instance, f"Set{name}")(*values)
    wanted = {"size": "default", "gap": 0, "top": None, "way": "left", "on": False, "field": "", "box": (4, 5, 6)}
    assert kept == wanted
    assert kept["on"] is False


def test_ports_tell_how_they_are_converted(generate, awkward):
    node = class_of(generate.operation_class(awkward))
    assert attribute(node, "ports") == (("mesh", "mesh", False), ("other", "grid", True))
    panel = panel_of(node)
    inputs = [e for e in panel if e.tag == "InputProperty"]
    assert [(e.get("name"), e.get("label")) for e in inputs] == [("Input", "Mesh"), ("Other", "Other")]
    assert inputs[1].find("DataTypeDomain/DataType").get("value") == "vtkStructuredGrid"


def test_an_operation_without_inputs_is_a_source(generate, monkeypatch):
    monkeypatch.setattr("meshcore.operation._REGISTRY", {})

    @operation("Ball", category="Structured", output="grid")
    def ball(*, size: Annotated[Length, Param("size")] = Relative(0.05)) -> meshcore.Result:
        """Make a ball."""

    node = class_of(generate.operation_class(meshcore.operations()["ball"]))
    assert decoration(node, "smproxy.source")
    assert attribute(node, "output") == "vtkStructuredGrid" and attribute(node, "ports") == ()
    assert properties(panel_of(node))["Size"].find("BoundsDomain") is None  # there is nothing to be relative to
