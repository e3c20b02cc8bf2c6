"""Every public name stands in the API page, and every parameter of every public function is documented."""

import inspect
import pkgutil
import re
from importlib import import_module
from pathlib import Path

import pytest
from numpydoc.docscrape import FunctionDoc

import meshcore

API = Path(__file__).resolve().parents[2] / "docs" / "reference" / "api.rst"
ROOMS = ("meshcore", "meshcore.adapt", "meshcore.io", "meshcore.quality", "meshcore.sizing", "meshcore.structured")
ROOMS += ("meshcore.unstructured", "meshcore.mesh", "meshcore.picture", "meshcore.gallery", "meshcore.demo")


def listed() -> set[str]:
    """All names that the API page lists, with their modules."""
    module, names = "", set()
    for line in API.read_text().splitlines():
        if line.startswith(".. currentmodule::"):
            module = line.split()[-1]
        elif re.fullmatch(r"   \w+", line):
            names.add(f"{module}.{line.strip()}")
    return names


def public(room: str) -> dict[str, object]:
    """Functions and classes that a room offers, by the place where they are defined."""
    module = import_module(room)
    names = getattr(module, "__all__", None) or [
        name for name, value in vars(module).items() if getattr(value, "__module__", "") == room and name[0] != "_"
    ]
    values = {name: getattr(module, name) for name in names}
    return {name: v for name, v in values.items() if inspect.isfunction(v) or inspect.isclass(v)}


def functions():
    """Every public function of every module, and every public method of every public class."""
    for info in pkgutil.walk_packages(meshcore.__path__, "meshcore."):
        parts = info.name.split(".")
        if any(part.startswith("_") for part in parts) or parts[1] in ("cli", "install"):
            continue
        module = import_module(info.name)
        for name, value in vars(module).items():
            if name.startswith("_") or getattr(value, "__module__", None) != info.name:
                continue
            if inspect.isfunction(value):
                yield pytest.param(value, id=f"{info.name}.{name}")
            elif inspect.isclass(value):
                methods = ((m, f) for m, f in vars(value).items() if inspect.isfunction(f) and not m.startswith("_"))
                for method, function in methods:
                    yield pytest.param(function, id=f"{info.name}.{name}.{method}")


@pytest.mark.parametrize("room", ROOMS)
def test_every_public_name_is_in_the_api_page(room):
    found = {getattr(import_module(name.rpartition(".")[0]), name.rpartition(".")[2]) for name in listed()}
    missing = [name for name, value in public(room).items() if value not in found]
    assert not missing


def test_the_api_page_lists_only_what_there_is():
    for name in listed():
        module, _, attribute = name.rpartition(".")
        assert hasattr(import_module(module), attribute), name


@pytest.mark.parametrize("function", list(functions()))
def test_documented_parameters_are_the_real_ones(function):
    """A docstring is there; if it has a table of parameters, that is complete and invents none."""
    text = inspect.getdoc(function)
    assert text
    named = [
        name.strip().lstrip("*") for entry in FunctionDoc(function)["Parameters"] for name in entry.name.split(",")
    ]
    real = [name for name in inspect.signature(function).parameters if name not in ("self", "cls")]
    if named:
        assert sorted(named) == sorted(real)


@pytest.mark.parametrize("name", sorted(name for room in ROOMS[:1] for name in public(room)))
def test_top_level_functions_document_every_parameter(name):
    value = getattr(meshcore, name)
    if inspect.isfunction(value):
        document = FunctionDoc(value)
        named = {n.strip() for entry in document["Parameters"] for n in entry.name.split(",")}
        real = set(inspect.signature(value).parameters)
        few = real <= {"fraction", "message"}  # the progress callback itself
        assert few or named == real
        assert document["Examples"]


@pytest.mark.parametrize("name", meshcore.operations())
def test_operations_say_what_they_return_raise_and_follow(name):
    document = FunctionDoc(meshcore.operations()[name].function)
    for part in ("Returns", "Raises", "References", "Examples"):
        assert document[part], part
