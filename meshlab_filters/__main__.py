"""``python -m meshlab_filters IN OUT --filter NAME``: a filter between MeshLab scripts, on meshes and projects."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import pymeshlab

from meshcore import InvalidInput
from meshcore.operation import Param

from . import binding, files
from .filters import FilterResult, meshlab_errors

USAGE, FAILED = 2, 1


def parser() -> argparse.ArgumentParser:
    """The command line."""
    made = argparse.ArgumentParser(
        prog="python -m meshlab_filters",
        description="Run a mesh generator on a mesh or project, before it and after it MeshLab scripts.",
        epilog=f"Filters: {', '.join(binding.filter_list())}. Exit codes: 0 done, 1 failed, 2 wrong arguments.",
    )
    made.add_argument(
        "input",
        nargs="?",
        help="mesh or project (.mlp); its current layer is the input; left out if the filter needs none",
    )
    made.add_argument("output", nargs="?", help="mesh for the new layer, project for all layers, or .vtu and others")
    made.add_argument("--filter", metavar="NAME", help="filter to run")
    made.add_argument("-p", action="append", default=[], metavar="KEY=VALUE", help="parameter; lengths take 5%%")
    made.add_argument("--pre", metavar="FILE.mlx", help="MeshLab script to run before")
    made.add_argument("--post", metavar="FILE.mlx", help="MeshLab script to run after, on the new layer")
    made.add_argument("--layer", metavar="LAYER", help="id or label of the input layer of a project")
    made.add_argument("--list", action="store_true", help="list the filters and leave")
    made.add_argument("--parameters", metavar="NAME", help="list the parameters of a filter and leave")
    return made


def value(text: str, param: Param | None) -> Any:
    """A parameter's text as its declared type.

    Raises
    ------
    InvalidInput
        If it cannot be read so.
    """
    if param is None:
        return int(text) if text.lstrip("-").isdigit() else text
    try:
        parts = [_one(part.strip(), param) for part in text.split(",")] if param.size > 1 else [_one(text, param)]
    except ValueError:
        raise InvalidInput(f"cannot read {text!r} as {param.kind}", parameter=param.name) from None
    return tuple(parts) if param.size > 1 else parts[0]


def _one(text: str, param: Param) -> Any:
    if param.optional and text.lower() in ("", "none"):
        return None
    if param.kind == "length" and text.endswith("%"):
        return pymeshlab.PercentageValue(float(text[:-1]))
    if param.kind == "bool":
        if text.lower() not in ("true", "false", "1", "0", "yes", "no"):
            raise ValueError(text)
        return text.lower() in ("true", "1", "yes")
    return {"int": int, "float": float, "length": float}.get(param.kind, str)(text)


def keywords(function: Any, pairs: list[str]) -> dict[str, Any]:
    """The parameters of the command line as keywords of a filter."""
    params = function.operation.params if hasattr(function, "operation") else {}
    found = {}
    for pair in pairs:
        name, equals, text = pair.partition("=")
        if not equals:
            raise InvalidInput(f"needs KEY=VALUE, got {pair!r}", parameter="-p")
        if not params and name in ("minimum", "maximum"):
            found[name] = float(text)
        elif name == "attributes":
            found[name] = tuple(text.split(","))
        else:
            found[name] = value(text, params.get(name))
    return found


def _needs_no_input(name: str | None) -> bool:
    """Whether a filter makes its mesh from parameters alone."""
    return name is not None and not getattr(getattr(binding.find(name), "operation", None), "inputs", True)


def run(options: argparse.Namespace) -> dict[str, Any]:
    """Load, run scripts and filter, save; return the filter's numbers."""
    function = binding.find(options.filter)
    with meshlab_errors(options.filter):
        given = keywords(function, options.p)
    ms = pymeshlab.MeshSet(verbose=False)
    if options.input is not None:
        files.load(ms, options.input)
    if options.layer is not None:
        with meshlab_errors("--layer"):
            layer = int(options.layer) if options.layer.isdigit() else options.layer
            ms.set_current_mesh(files.conversion.layer_of(ms, layer).id())
    if options.pre:
        files.apply_script(ms, options.pre)
    result = function(ms, **given)
    if options.post:
        files.apply_script(ms, options.post)
    suffix = Path(options.output).suffix.lower()
    if suffix in (*files.SURFACE_FORMATS, ".mlp"):
        files.save(ms, options.output)
    elif not isinstance(result, FilterResult) or options.post:
        reason = "the layer was changed by --post" if options.post else f"{options.filter} makes no mesh"
        raise pymeshlab.PyMeshLabException(f"cannot write {suffix or 'this'}: {reason}; use .ply or .mlp")
    else:
        files.write(result, options.output)
    return result


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; return its exit code."""
    options = parser().parse_args(arguments)
    try:
        if options.list:
            binding.print_filter_list()
            return 0
        if options.parameters:
            binding.print_filter_parameter_list(options.parameters)
            return 0
        needed = ["input", "output", "filter"]
        if _needs_no_input(options.filter):
            needed.remove("input")
            if options.output is None:
                options.input, options.output = None, options.input
        missing = [name for name in needed if getattr(options, name) is None]
        if missing:
            print(f"meshlab_filters: {missing[0]} is missing; see --help", file=sys.stderr)
            return USAGE
        for name, number in run(options).items():
            print(f"{name}: {number:.6g}" if isinstance(number, float) else f"{name}: {number}")
    except pymeshlab.PyMeshLabException as error:
        line = " ".join(str(error).split())
        print(f"meshlab_filters: {line}", file=sys.stderr)
        return FAILED
    return 0


if __name__ == "__main__":
    sys.exit(main())
