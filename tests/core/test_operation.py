"""The registry: the signature is the declaration, the check is the truth."""

import json
import math
from typing import Annotated, Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshcore import operation as module
from meshcore.errors import InvalidInput
from meshcore.operation import Length, Param, Port, Relative, absolute, operation, operations
from meshcore.report import Report, Result


@pytest.fixture
def register(monkeypatch):
    """Register into an empty registry, so that tests leave none of their own behind."""
    monkeypatch.setattr(module, "_REGISTRY", {})
    return operation("Sample", category="Test")


@pytest.fixture
def sample(register):
    @register
    def sample(
        boundary: Annotated[list, Port("Anything", cells=("line",))],
        other: Annotated[list | None, Port("More")] = None,
        *,
        count: Annotated[int, Param("How many", min=1, max=9)] = 3,
        angle: Annotated[float, Param("Angle", min=0, max=34, unit="degree")] = 30,
        size: Annotated[Length, Param("Size")] = Relative(0.05),
        limit: Annotated[Length | None, Param("Limit")] = None,
        mode: Annotated[Literal["fast", "good"], Param("Mode")] = "fast",
        shape: Annotated[tuple[int, int], Param("Shape", min=1)] = (2, 3),
        name: Annotated[str, Param("Array", array=True)] = "",
        on: Annotated[bool, Param("Switch")] = True,
        python_only=None,
    ) -> Result:
        """Return what came in."""
        return Result(dict(locals()), Report())

    return sample


def params():
    return module._REGISTRY["sample"].params


def test_kinds_come_from_the_signature(sample):
    kinds = {name: (p.kind, p.size, p.optional) for name, p in params().items()}
    assert kinds == {
        "count": ("int", 1, False),
        "angle": ("float", 1, False),
        "size": ("length", 1, False),
        "limit": ("length", 1, True),
        "mode": ("choice", 1, False),
        "shape": ("int", 2, False),
        "name": ("str", 1, False),
        "on": ("bool", 1, False),
    }
    assert params()["mode"].choices == ("fast", "good")


def test_ports_come_from_the_signature(sample):
    inputs = module._REGISTRY["sample"].inputs
    assert [(p.name, p.optional, p.cells) for p in inputs.values()] == [
        ("boundary", False, ("line",)),
        ("other", True, ()),
    ]


def test_a_call_is_an_ordinary_call_with_checked_values(sample):
    seen, report = sample([1], count=np.int64(4), size="2%", shape=[5, 6], python_only=any)
    assert seen["boundary"] == [1] and seen["python_only"] is any
    assert seen["count"] == 4 and type(seen["count"]) is int
    assert seen["size"] == Relative(0.02)
    assert seen["shape"] == (5, 6)
    assert report.operation == "Sample" and report.seconds > 0
    assert sample.__doc__ == "Return what came in."


def test_a_hosts_own_kind_of_text_becomes_plain_text(sample):
    class Enumeration:  # like ParaView's: equal to a text, but not one, and not hashable
        __hash__ = None

        def __eq__(self, other):
            return other == "good"

    assert type(sample([1], mode=Enumeration()).mesh["mode"]) is str


@pytest.mark.parametrize(
    ("keyword", "value", "text"),
    [
        ("count", 0, "at least 1, got 0"),
        ("count", 10, "at most 9, got 10"),
        ("count", 2.5, "whole number, got 2.5"),
        ("count", math.nan, "whole number"),
        ("count", "3", "needs a number, got '3'"),
        ("count", True, "needs a number, got True"),
        ("count", None, "needs a number, got None"),
        ("angle", math.nan, "finite"),
        ("angle", math.inf, "finite"),
        ("angle", 34.1, "at most 34"),
        ("angle", 1j, "needs a number"),
        ("size", 0.0, "greater than zero"),
        ("size", -1.0, "greater than zero"),
        ("size", "-1%", "greater than zero"),
        ("size", "big%", "'big%' is not a percentage"),
        ("size", "big", "needs a number"),
        ("mode", "slow", "'slow' is not one of fast, good"),
        ("mode", 1, "1 is not one of"),
        ("shape", (1,), "needs 2 values"),
        ("shape", (1, 0), "at least 1, got 0"),
        ("shape", "12", "needs 2 values"),
        ("name", 5, "needs text"),
        ("on", "yes", "needs true or false"),
    ],
)
def test_what_is_refused(sample, keyword, value, text):
    with pytest.raises(InvalidInput, match=text) as caught:
        sample([], **{keyword: value})
    assert caught.value.parameter == keyword
    assert str(caught.value).startswith(f"{keyword}: ")


@given(st.floats() | st.integers() | st.text(max_size=3) | st.none() | st.booleans())
def test_a_checked_number_lies_within_its_limits(value):
    param = Param("", min=-2, max=5, kind="float", name="x")
    try:
        checked = param.check(value)
    except InvalidInput:
        assert isinstance(value, (str, bool)) or value is None or not -2 <= value <= 5
    else:
        assert type(checked) is float and -2 <= checked <= 5 and checked == value


def test_none_is_for_optional_parameters_only(sample):
    assert sample([], limit=None).mesh["limit"] is None
    with pytest.raises(InvalidInput):
        sample([], size=None)


def test_wrong_names_are_wrong_calls(sample):
    with pytest.raises(TypeError, match="coutn"):
        sample([], coutn=3)
    with pytest.raises(TypeError, match="boundary"):
        sample()


def test_the_declaration_is_plain_data(sample):
    declared = json.loads(json.dumps(module._REGISTRY["sample"].declaration()))
    assert declared["params"]["size"]["default"] == {"relative": 0.05}
    assert declared["params"]["angle"] == {
        "description": "Angle",
        "min": 0,
        "max": 34,
        "unit": "degree",
        "kind": "float",
        "size": 1,
        "label": "Angle",
        "default": 30,
    }
    assert declared["summary"] == "Return what came in."


def test_what_the_vocabulary_refuses(register):
    def with_hint(hint, default):
        def sample(*, value=default):
            """Do nothing."""

        sample.__annotations__ = {"value": Annotated[hint, Param("A value")]}
        return sample

    for hint in (dict, list[int], tuple[int, str], complex):
        with pytest.raises(TypeError, match="outside the vocabulary"):
            register(with_hint(hint, None))
    with pytest.raises(InvalidInput, match="at most"):

        @register
        def wrong_default(*, value: Annotated[int, Param("A value", max=1)] = 2):
            """Do nothing."""

    with pytest.raises(TypeError, match="needs a default"):

        @register
        def no_default(*, value: Annotated[int, Param("A value")]):
            """Do nothing."""

    with pytest.raises(TypeError, match="needs a Port"):

        @register
        def no_port(mesh: list):
            """Do nothing."""


def test_one_identifier_is_one_operation(sample, register):
    with pytest.raises(TypeError, match="twice"):
        register(sample)


def test_lengths_are_absolute_or_relative():
    assert absolute(Relative(0.25), 8.0) == 2.0
    assert absolute(3, 8.0) == 3.0
    assert (str(Relative(0.05)), repr(Relative(0.05))) == ("5%", "Relative(0.05)")


def test_the_registry_is_sorted_by_category():
    order = [op.category for op in operations().values()]
    assert order == sorted(order, key=["Structured", "Unstructured", "Adaptive"].index)
    assert all(op.summary for op in operations().values())
