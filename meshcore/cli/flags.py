"""Flags from the registry: what a Param tells becomes an option, its limits and default the help text."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

from ..operation import Operation, Param

LENGTHS = "A LENGTH is a number in the file's own unit, or a share of the input's bounding box diagonal such as 2%."
_OUTPUTS = {"grid": "out.vts", "blocks": "out.vtm", "grid or blocks": "out.vtm"}
_METAVARS = {"int": "INT", "float": "NUMBER", "str": "TEXT", "length": "LENGTH"}
_WANTED = {"int": "a whole number", "float": "a number", "length": "a number or a percentage such as 2%"}


def escaped(text: str) -> str:
    """Text for argparse, which would take a lone % for a format."""
    return text.replace("%", "%%")


def add_params(command: argparse.ArgumentParser, operation: Operation) -> None:
    """One flag a parameter, under the headings that the registry gives."""
    groups: dict[str, Any] = {}
    for param in operation.params.values():
        heading = param.group or ("advanced parameters" if param.advanced else "parameters")
        if heading not in groups:
            groups[heading] = command.add_argument_group(heading)
        _add_param(groups[heading], param)


def values(arguments: argparse.Namespace, operation: Operation) -> dict[str, Any]:
    """The parameters of an operation, checked against its limits before any file is opened."""
    checked = {}
    for param in operation.params.values():
        value = getattr(arguments, f"param:{param.name}")
        if param.optional and value in ("none", [None]):
            value = None
        checked[param.name] = param.check(tuple(value) if isinstance(value, list) else value)
    return checked


def example(operation: Operation) -> str:
    """A command line that shows how an operation is called, for the foot of its help.

    Examples
    --------
    >>> from meshcore import operations
    >>> print(example(operations()["transfinite"]).splitlines()[1])
      meshcore transfinite south.vtp -o out.vts --picture out.png
    """
    words = ["meshcore", operation.id.replace("_", "-")]
    words += [port.name + ".vtp" for port in operation.inputs.values() if not port.optional]
    words += ["-o", _OUTPUTS.get(operation.output, "out.vtu")]
    for param in operation.params.values():
        if param.kind in ("int", "float") and param.size == 1 and param.default is not None:
            words += [_flag(param), _shown(param.default)]
            break
    text = "example:\n  " + " ".join([*words, "--picture", "out.png"])
    has_lengths = any(param.kind == "length" for param in operation.params.values())
    return f"{text}\n\n{LENGTHS}" if has_lengths else text


def help_text(param: Param) -> str:
    """Description, unit, limits and default.

    Examples
    --------
    >>> help_text(Param("Smallest angle", min=0, max=34, unit="degree", default=30.0))
    'Smallest angle (degree, 0 to 34, default 30)'
    >>> help_text(Param("Layers; by default as many as growth needs", min=1, default=None))
    'Layers; by default as many as growth needs (at least 1)'
    """
    facts = [param.unit] if param.unit else []
    if param.min is not None and param.max is not None:
        facts.append(f"{param.min:g} to {param.max:g}")
    elif param.min is not None:
        facts.append(f"at least {param.min:g}")
    elif param.max is not None:
        facts.append(f"at most {param.max:g}")
    told = param.default is None and "by default" in param.description
    if param.default != "" and not told:
        facts.append(f"default {_shown(param.default)}")
    return f"{param.description} ({', '.join(facts)})" if facts else param.description


def _flag(param: Param) -> str:
    return "--" + param.name.replace("_", "-")


def _spellings(param: Param) -> list[str]:
    return [_flag(param), *(f"--{other}" for other in param.also)]


def _shown(value: Any) -> str:
    if isinstance(value, tuple):
        return " ".join(_shown(v) for v in value)
    if isinstance(value, float):
        return f"{value:g}"
    return "none" if value is None else str(value)


def _add_param(group: Any, param: Param) -> None:
    options: dict[str, Any] = {
        "default": param.default,
        "dest": f"param:{param.name}",
        "help": escaped(help_text(param)),
    }
    if param.kind == "bool":
        group.add_argument(*_spellings(param), action=argparse.BooleanOptionalAction, **options)
        return
    if param.kind == "choice":
        options["choices"] = [*param.choices, "none"] if param.optional else list(param.choices)
    else:
        options["metavar"] = _METAVARS[param.kind]
    if param.kind in _WANTED:
        options["type"] = _number_reader(param)
    if param.size > 1:
        options["nargs"] = "+" if param.optional else param.size
    group.add_argument(*_spellings(param), **options)


def _number_reader(param: Param) -> Callable[[str], Any]:
    """Turns a word of the command line into a number; limits are left to `Param.check`."""

    def read(text: str) -> Any:
        if param.optional and text.lower() == "none":
            return None
        try:
            if param.kind == "length" and text.endswith("%"):
                float(text[:-1])
                return text
            return int(text) if param.kind == "int" else float(text)
        except ValueError:
            wanted = _WANTED[param.kind] + (" or none" if param.optional else "")
            raise argparse.ArgumentTypeError(f"{text!r} is not {wanted}") from None

    return read
