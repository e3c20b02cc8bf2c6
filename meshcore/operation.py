"""Operations: ordinary functions whose signature is also their declaration to every host.

A parameter is described once, in its annotation::

    layers: Annotated[int, Param("Cells away from the wall", min=1, soft_max=500)] = 32

and an input that is a mesh is described by a `Port`::

    boundary: Annotated[Mesh, Port("Closed loops of line cells", cells=("line",))]

`operation` reads the signature into an `Operation`; Blender properties, ParaView XML, MeshLab functions,
command-line flags and the reference pages all come from the registry. The vocabulary is closed: bool, int,
float, str, Literal, fixed tuples of int or float, and Length. A parameter with a default but neither Param nor
Port is for Python only.
"""

from __future__ import annotations

import functools
import inspect
import math
import numbers
import time
import types
import typing
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from .errors import InvalidInput
from .report import Result

Unit = Literal["", "degree"]


@dataclass(frozen=True)
class Relative:
    """A length as a fraction of the diagonal of the input's bounding box.

    Examples
    --------
    >>> Relative(0.05)
    Relative(0.05)
    """

    fraction: float

    def __repr__(self) -> str:
        return f"Relative({self.fraction:g})"

    def __str__(self) -> str:
        return f"{100 * self.fraction:g}%"


Length = Union[float, Relative]
"""A length in the input's own unit, or `Relative` to its size; the text ``"5%"`` is read as ``Relative(0.05)``."""


def absolute(length: Length, diagonal: float) -> float:
    """A `Length` as a number, given the diagonal of the input's bounding box.

    Examples
    --------
    >>> absolute(Relative(0.5), 3.0), absolute(0.2, 3.0)
    (1.5, 0.2)
    """
    return length.fraction * diagonal if isinstance(length, Relative) else float(length)


@dataclass(frozen=True)
class Param:
    """What a host must know of a parameter beyond its name, type and default.

    Parameters
    ----------
    description : str
        One sentence for tooltips, flags and reference pages.
    min, max : float, optional
        Limits, inclusive; a value outside raises `InvalidInput`.
    soft_min, soft_max : float, optional
        Comfortable range of a slider.
    unit : str
        ``"degree"`` or empty; a `Length` carries its own unit.
    group : str
        Heading under which a panel shows the parameter.
    advanced : bool
        Hidden until a panel's advanced parameters are shown.
    array : bool
        A str that names a data array of the first input, so that a host can offer a list.
    also : tuple of str
        Other spellings of the command line's flag, such as ``"yplus"``.

    The remaining fields are filled in from the signature: `kind` is one of bool, int, float, str, choice, length,
    `size` is the number of values of a tuple, and `optional` tells that None is allowed (hosts show it as zero).
    """

    description: str
    min: float | None = None
    max: float | None = None
    soft_min: float | None = None
    soft_max: float | None = None
    unit: Unit = ""
    group: str = ""
    advanced: bool = False
    array: bool = False
    also: tuple[str, ...] = ()
    name: str = ""
    kind: str = ""
    choices: tuple[str, ...] = ()
    size: int = 1
    optional: bool = False
    default: Any = None

    @property
    def label(self) -> str:
        """The name in Title Case, as hosts show it."""
        return self.name.replace("_", " ").title()

    def check(self, value: Any) -> Any:
        """``value`` as the declared type, or `InvalidInput` that names the parameter, the value and the limit."""
        if value is None and self.optional:
            return None
        if self.size == 1:
            return self._check_one(value)
        if isinstance(value, str) or not hasattr(value, "__len__") or len(value) != self.size:
            self._fail(f"needs {self.size} values, got {value!r}")
        return tuple(self._check_one(v) for v in value)

    def _check_one(self, value: Any) -> Any:
        if self.kind == "choice":
            if value not in self.choices:
                self._fail(f"{value!r} is not one of {', '.join(self.choices)}")
            return self.choices[self.choices.index(value)]  # a host's own kind of text becomes plain text
        if self.kind == "str":
            if not isinstance(value, str):
                self._fail(f"needs text, got {value!r}")
            return value
        if self.kind == "bool":
            if not isinstance(value, (bool, numbers.Integral)) and type(value).__name__ != "bool_":
                self._fail(f"needs true or false, got {value!r}")
            return bool(value)
        return self._check_number(value)

    def _check_number(self, value: Any) -> Any:
        if self.kind == "length":
            if isinstance(value, str) and value.strip().endswith("%"):
                value = _percentage(value, self._fail)
            if isinstance(value, Relative):
                return Relative(self._limited(float(value.fraction), value))
        if isinstance(value, bool) or not isinstance(value, numbers.Real):
            self._fail(f"needs a number, got {value!r}")
        if self.kind == "int":
            if not math.isfinite(value) or value != int(value):
                self._fail(f"needs a whole number, got {value!r}")
            return self._limited(int(value), value)
        return self._limited(float(value), value)

    def _limited(self, number: float, shown: Any) -> Any:
        if not math.isfinite(number):
            self._fail(f"must be finite, got {shown}")
        if self.min is not None and number < self.min:
            self._fail(f"must be at least {self.min:g}, got {shown}")
        if self.max is not None and number > self.max:
            self._fail(f"must be at most {self.max:g}, got {shown}")
        if self.kind == "length" and number <= 0 and self.min is None:
            self._fail(f"must be greater than zero, got {shown}")
        return number

    def _fail(self, message: str) -> typing.NoReturn:
        raise InvalidInput(message, parameter=self.name)


def _percentage(text: str, fail: Callable[[str], typing.NoReturn]) -> Relative:
    try:
        return Relative(float(text.strip()[:-1]) / 100)
    except ValueError:
        fail(f"{text!r} is not a percentage; write 5%")


@dataclass(frozen=True)
class Port:
    """An input that is a mesh, a grid or points.

    Parameters
    ----------
    description : str
        One sentence: what the input must be.
    cells : tuple of str
        Kinds of cell that are accepted, e.g. ``("line",)``.
    named : bool
        Whether a host that takes inputs from the selection leaves this one to be chosen by name.
    name, type, optional
        Filled in from the signature.
    """

    description: str
    cells: tuple[str, ...] = ()
    named: bool = False
    name: str = ""
    type: Any = None
    optional: bool = False

    @property
    def label(self) -> str:
        """The name in Title Case, as hosts show it."""
        return self.name.replace("_", " ").title()


@dataclass(frozen=True)
class Operation:
    """One entry of the registry: a function and what hosts must know of it."""

    id: str
    label: str
    category: str
    function: Callable[..., Result]
    output: str
    inputs: dict[str, Port] = field(default_factory=dict)
    params: dict[str, Param] = field(default_factory=dict)

    @property
    def summary(self) -> str:
        """First line of the function's docstring."""
        return (inspect.getdoc(self.function) or "").split("\n")[0]

    def declaration(self) -> dict[str, Any]:
        """All that hosts see, as plain JSON-ready data."""
        params = {name: _plain_param(p) for name, p in self.params.items()}
        inputs = {name: _plain_port(port) for name, port in self.inputs.items()}
        return {
            "label": self.label,
            "category": self.category,
            "summary": self.summary,
            "output": self.output,
            "inputs": inputs,
            "params": params,
        }


def _plain_port(port: Port) -> dict[str, Any]:
    plain = {
        "label": port.label,
        "description": port.description,
        "cells": list(port.cells),
        "optional": port.optional,
    }
    return {**plain, "named": True} if port.named else plain


def _plain_param(param: Param) -> dict[str, Any]:
    hidden = ("name", "default")
    plain = {
        k: v
        for k, v in vars(param).items()
        if k not in hidden and v is not None and v is not False and v not in ("", ())
    }
    plain["label"] = param.label
    default = param.default
    plain["default"] = {"relative": default.fraction} if isinstance(default, Relative) else default
    return {k: list(v) if isinstance(v, tuple) else v for k, v in plain.items()}


Output = Literal["mesh", "grid", "blocks", "grid or blocks", "polyhedra", "as given"]
_REGISTRY: dict[str, Operation] = {}


def operation(
    label: str, *, category: str, output: Output = "mesh"
) -> Callable[[Callable[..., Result]], Callable[..., Result]]:
    """Register a function as an operation and check each of its calls.

    Parameters
    ----------
    label : str
        Name in Title Case, as hosts show it. It becomes part of users' files: change it as rarely as an identifier.
    category : str
        Menu under which hosts show it.
    output : {"mesh", "grid", "blocks", "grid or blocks", "polyhedra", "as given"}
        Whether the function makes a `Mesh`, a `StructuredGrid`, a `MultiBlock`, the one or the other of these, or a
        `PolyhedralMesh`, or what its first input is: a mesh from a mesh, a grid from a grid, blocks from blocks. Hosts
        whose outputs have one type show a mesh, or a grid as the only block.

    Returns
    -------
    decorator
        The decorated function stays an ordinary function: each `Param` is checked, times and label go to the report.

    Raises
    ------
    TypeError
        At import, if the signature leaves the closed vocabulary.
    """

    def decorate(function: Callable[..., Result]) -> Callable[..., Result]:
        signature = inspect.signature(function)
        inputs, params = _read_signature(function, signature)
        names = tuple(signature.parameters)

        def check(name: str, value: Any) -> Any:
            return params[name].check(value) if name in params else value

        @functools.wraps(function)
        def checked(*args: Any, **kwargs: Any) -> Result:
            # The call itself finds out, faster than `Signature.bind`, whether the arguments fit the signature.
            args = (*map(check, names, args), *args[len(names) :])
            kwargs = {name: check(name, value) for name, value in kwargs.items()}
            start = time.perf_counter()
            result = function(*args, **kwargs)
            result.report.operation = label
            result.report.seconds = time.perf_counter() - start
            return result

        op = Operation(function.__name__, label, category, checked, output, inputs, params)
        if op.id in _REGISTRY:
            raise TypeError(f"operation {op.id} is registered twice")
        _REGISTRY[op.id] = op
        return checked

    return decorate


def operations() -> dict[str, Operation]:
    """All registered operations by identifier, in the order of their categories.

    Examples
    --------
    >>> import meshcore
    >>> "transfinite" in operations()
    True
    """
    order = ("Structured", "Unstructured", "Adaptive")
    rank = {name: k for k, name in enumerate(order)}
    return dict(sorted(_REGISTRY.items(), key=lambda item: (rank.get(item[1].category, len(order)), item[0])))


def _read_signature(function: Callable[..., Any], signature: inspect.Signature) -> tuple[dict, dict]:
    hints = typing.get_type_hints(function, include_extras=True)
    inputs: dict[str, Port] = {}
    params: dict[str, Param] = {}
    for name, parameter in signature.parameters.items():
        hint, info = _annotation(hints.get(name))
        if isinstance(info, Port):
            optional = parameter.default is not inspect.Parameter.empty
            inputs[name] = replace(info, name=name, type=hint, optional=optional)
        elif isinstance(info, Param):
            params[name] = _completed(info, name, hint, parameter.default)
        elif parameter.kind is not inspect.Parameter.KEYWORD_ONLY and parameter.default is inspect.Parameter.empty:
            raise TypeError(f"{function.__name__}: input {name} needs a Port, as in Annotated[Mesh, Port(...)]")
    return inputs, params


def _annotation(hint: Any) -> tuple[Any, Param | Port | None]:
    """The bare type and the Param or Port of a type hint."""
    # Python 3.10 wraps the hint of a parameter that defaults to None in Optional.
    for candidate in (hint, *get_args(hint)):
        for info in getattr(candidate, "__metadata__", ()):
            if isinstance(info, (Param, Port)):
                return get_args(candidate)[0], info
    return hint, None


_KINDS = {bool: "bool", int: "int", float: "float", str: "str"}


def _completed(info: Param, name: str, hint: Any, default: Any) -> Param:
    """``info`` with what the type and the default tell."""
    if default is inspect.Parameter.empty:
        raise TypeError(f"{name}: a parameter needs a default; without one it is an input")
    optional = False
    if get_origin(hint) in (Union, types.UnionType) and type(None) in get_args(hint):
        optional = True
        hint = Union[tuple(a for a in get_args(hint) if a is not type(None))]
    kind, size, choices = _vocabulary(name, hint)
    done = replace(info, name=name, kind=kind, size=size, choices=choices, optional=optional, default=default)
    done.check(default)
    return done


def _vocabulary(name: str, hint: Any) -> tuple[str, int, tuple[str, ...]]:
    if hint == Length:
        return "length", 1, ()
    if get_origin(hint) is Literal:
        return "choice", 1, get_args(hint)
    if get_origin(hint) is tuple and set(get_args(hint)) in ({int}, {float}):
        return _KINDS[get_args(hint)[0]], len(get_args(hint)), ()
    if hint in _KINDS:
        return _KINDS[hint], 1, ()
    raise TypeError(f"{name}: {hint} is outside the vocabulary that hosts can show")


__all__ = ["Annotated", "Length", "Operation", "Param", "Port", "Relative", "absolute", "operation", "operations"]
