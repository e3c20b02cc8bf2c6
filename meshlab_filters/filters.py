"""A function on a MeshSet for each operation of meshcore's registry."""

from __future__ import annotations

import contextlib
import difflib
import inspect
import textwrap
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pymeshlab

import meshcore
from meshcore import InvalidInput, MeshcoreError, Relative
from meshcore.operation import Operation, Param, Port

from . import conversion

SELECTED = "selected"
"""Given as marks, stands for the selected faces of the current layer."""


class FilterResult(dict):
    """What a filter returns: its report as a dict of numbers, with the whole result beside it.

    Attributes
    ----------
    mesh : Mesh, StructuredGrid or MultiBlock
        The result itself; `write` writes it, where MeshLab's own writers know its layers only.
    report : Report
        The report in full, with its warnings.
    """

    mesh: Any = None
    report: Any = None


@contextlib.contextmanager
def meshlab_errors(name: str) -> Iterator[None]:
    """Turn meshcore's errors into pymeshlab's, with the same message."""
    try:
        yield
    except MeshcoreError as error:
        raise pymeshlab.PyMeshLabException(f"{name}: {error}") from error


def length(value: Any) -> Any:
    """A length as meshcore takes it: percentages of the bounding box's diagonal become `Relative`.

    Examples
    --------
    >>> length(pymeshlab.PercentageValue(5)), length(pymeshlab.PureValue(0.2)), length(0.3)
    (Relative(0.05), 0.2, 0.3)
    """
    if isinstance(value, pymeshlab.PercentageValue):
        return Relative(_written(value) / 100)
    return _written(value) if isinstance(value, pymeshlab.PureValue) else value


def _written(value: pymeshlab.PercentageValue | pymeshlab.PureValue) -> float:
    """The number as it was written: both kinds hold it in single precision."""
    return float(str(np.float32(value.value())))


def _default(param: Param) -> Any:
    """A parameter's default as MeshLab writes it."""
    relative = param.kind == "length" and isinstance(param.default, Relative)
    return pymeshlab.PercentageValue(100 * param.default.fraction) if relative else param.default


_TYPES = {"choice": "str", "length": "pymeshlab.PercentageValue | pymeshlab.PureValue | float"}


def _type(param: Param) -> str:
    name = _TYPES.get(param.kind, param.kind)
    name = f"tuple[{', '.join([name] * param.size)}]" if param.size > 1 else name
    return f"{name} | None" if param.optional else name


class Percentage(pymeshlab.PercentageValue):
    """A percentage that shows its value in a signature."""

    def __repr__(self) -> str:
        return f"PercentageValue({self.value():g})"


def signature(op: Operation) -> inspect.Signature:
    """The filter's signature: the MeshSet, then layers, parameters and how to show the result, by keyword."""

    def keyword(name: str, default: Any, annotation: str) -> inspect.Parameter:
        if isinstance(default, pymeshlab.PercentageValue):
            default = Percentage(default.value())
        return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation)

    ports = list(op.inputs)[1:]
    own = inspect.signature(op.function).parameters
    python_only = {name: p.default for name, p in own.items() if name not in op.inputs and name not in op.params}
    return inspect.Signature(
        [
            inspect.Parameter("ms", inspect.Parameter.POSITIONAL_OR_KEYWORD, annotation="pymeshlab.MeshSet"),
            *(keyword(name, None, "int | str | None") for name in ports),
            *(keyword(name, _default(param), _type(param)) for name, param in op.params.items()),
            *(keyword(name, default, "Any") for name, default in python_only.items()),
            keyword("label", "", "str"),
            keyword("measure", "scaled_jacobian", "str"),
            keyword("attributes", (), "tuple[str, ...]"),
        ],
        return_annotation="FilterResult",
    )


def make_filter(op: Operation) -> Callable[..., FilterResult]:
    """The filter of an operation."""
    declared = signature(op)

    def run(ms: pymeshlab.MeshSet, **keywords: Any) -> FilterResult:
        with meshlab_errors(op.id):
            check_mesh_set(ms)
            check_keywords(keywords, declared)
            return _run(op, ms, keywords)

    run.__name__ = run.__qualname__ = op.id
    run.__module__ = __package__
    run.__signature__ = declared
    run.__doc__ = documentation(op)
    run.operation = op
    return run


def check_mesh_set(ms: Any) -> None:
    """Refuse what is no MeshSet."""
    if not isinstance(ms, pymeshlab.MeshSet):
        raise InvalidInput(f"needs a pymeshlab.MeshSet, got {type(ms).__name__}", parameter="ms")


def check_keywords(keywords: dict[str, Any], declared: inspect.Signature) -> None:
    """Refuse keywords that a filter does not have, and say which it has."""
    known = [name for name in declared.parameters if name != "ms"]
    for name in keywords:
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1)
            hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(known)}"
            raise InvalidInput(f"is no parameter of this filter; {hint}", parameter=name)


def _run(op: Operation, ms: pymeshlab.MeshSet, keywords: dict[str, Any]) -> FilterResult:
    keywords = dict(keywords)
    label, measure = keywords.pop("label", ""), keywords.pop("measure", "scaled_jacobian")
    if measure and measure not in meshcore.quality.measures():
        near = difflib.get_close_matches(str(measure), meshcore.quality.measures(), n=3)
        raise InvalidInput(f"{measure!r} is no quality measure; try {', '.join(near) or 'shape'}", parameter="measure")
    attributes, named = list(_names(keywords.pop("attributes", ()))), []
    for name, param in op.params.items():
        value = keywords.get(name)
        if param.kind == "length":
            keywords[name] = length(value) if name in keywords else param.default
        own = (conversion.VERTEX_SCALAR, conversion.FACE_SCALAR)
        if param.array and isinstance(value, str) and value and value not in (*own, *attributes):
            named.append(value)
    layers = {name: keywords.pop(name, None) for name in op.inputs}
    given = [name for number, name in enumerate(op.inputs) if number == 0 or layers[name] is not None]
    inputs = {}
    for number, name in enumerate(given):
        layer = conversion.layer_of(ms, layers[name], name)
        # An array that a parameter names may belong to any of several inputs; meshcore says so if none has it.
        wanted = [*([] if number else attributes), *(n for n in named if len(given) == 1 or conversion.has(layer, n))]
        inputs[name] = _input(layer, op.inputs[name], wanted)
    if isinstance(keywords.get("marks"), str) and keywords["marks"] == SELECTED:
        keywords["marks"] = ms.current_mesh().face_selection_array()
    source = ms.current_mesh().label() if inputs else ""
    mesh, report = op.function(**inputs, **keywords)
    return add_layers(ms, mesh, report, label or f"{source} {op.label}".strip(), measure)


def _names(value: Any) -> tuple[str, ...]:
    if isinstance(value, str):
        return (value,)
    names = tuple(value)
    if not all(isinstance(name, str) for name in names):
        raise InvalidInput(f"needs names, got {value!r}", parameter="attributes")
    return names


def _input(layer: pymeshlab.Mesh, port: Port, attributes: Any) -> meshcore.Mesh:
    """A layer as a port wants it."""
    if port.cells == ("line",):
        return conversion.to_boundary(layer, port.name, attributes)
    mesh = conversion.to_mesh(layer, attributes, polygons="quad" in port.cells or not port.cells)
    if port.cells and not any(len(mesh.get(kind)) for kind in port.cells):
        found = ", ".join(f"{len(c)} {kind}" for kind, c in mesh.cells.items()) or "no cells"
        raise InvalidInput(
            f"the layer {layer.label()!r} has {found}; this filter needs {' or '.join(port.cells)} cells",
            parameter=port.name,
        )
    return mesh


def add_layers(ms: pymeshlab.MeshSet, mesh: Any, report: Any, label: str, measure: str) -> FilterResult:
    """Add the layers that show a result, the first of them current, and tell its numbers."""
    ids = conversion.add(ms, mesh, label, measure)
    result = FilterResult({**report.counts, **report.quality})
    result.update(layer=ids[0], added_layers=len(ids))
    result.update(converged=int(report.converged), warnings=len(report.warnings), seconds=report.seconds)
    result.mesh, result.report = mesh, report
    return result


def documentation(op: Operation) -> str:
    """The docstring: what the operation says of itself, and each parameter with unit and limits."""
    ports = list(op.inputs.values())
    lines = [
        op.summary,
        "",
        "Adds the result as a new layer with quality in its face scalars.",
        "",
        "Parameters",
        "-" * 10,
    ]

    def entry(name: str, kind: str, text: str) -> None:
        lines.append(f"{name} : {kind}")
        lines.extend(textwrap.wrap(text, 100, initial_indent="    ", subsequent_indent="    "))

    role = f"Its current layer is the input. {ports[0].description}." if ports else "Takes the new layer."
    entry("ms", "pymeshlab.MeshSet", role)
    for port in ports[1:]:
        entry(port.name, "int or str, optional", f"Id or label of a layer. {port.description}.")
    for param in op.params.values():
        entry(param.name, _type(param), f"{param.description}{_limits(param)}.")
    if "marks" in signature(op).parameters:
        entry("marks", "array or str, optional", f"Cells by number or flag; '{SELECTED}' takes the selected faces.")
    entry("label", "str", "Label of the new layer; by default the input's with the operation's name.")
    entry("measure", "str", "Quality measure for the face scalars, by Verdict's name; empty for none.")
    entry("attributes", "tuple of str", "Custom attributes of the layer to take along.")
    lines += ["", "Returns", "-" * 7, "FilterResult", "    Counts, quality and seconds; `mesh` and `report` in full."]
    lines += ["", "Raises", "-" * 6, "pymeshlab.PyMeshLabException", "    With meshcore's message of what is wrong."]
    return "\n".join(lines)


def _limits(param: Param) -> str:
    parts = [f"one of {', '.join(param.choices)}"] if param.choices else []
    parts += [f"at least {param.min:g}"] if param.min is not None else []
    parts += [f"at most {param.max:g}"] if param.max is not None else []
    parts += [param.unit] if param.unit else []
    return f" ({', '.join(parts)})" if parts else ""


FILTERS: dict[str, Callable[..., FilterResult]] = {name: make_filter(op) for name, op in meshcore.operations().items()}
"""The filters of all operations, by name."""
