"""The filters as methods of MeshSet, on demand, and help on them in pymeshlab's own way."""

from __future__ import annotations

import difflib
import inspect
import sys
from collections.abc import Callable

import pymeshlab

from . import face_quality, filters

ALL: dict[str, Callable] = {**filters.FILTERS, **face_quality.FILTERS}
"""All filters of the package, by name."""


def filter_list() -> list[str]:
    """Names of all filters of this package.

    Examples
    --------
    >>> "delaunay_refinement" in filter_list()
    True
    """
    return sorted(ALL)


def find(name: str) -> Callable:
    """A filter by name.

    Raises
    ------
    pymeshlab.PyMeshLabException
        If there is none; the message names the nearest.
    """
    if name not in ALL:
        near = difflib.get_close_matches(str(name), ALL, n=3) or filter_list()
        raise pymeshlab.PyMeshLabException(f"no filter {name!r}; try {', '.join(near)}")
    return ALL[name]


def parameter_list(name: str) -> str:
    """The parameters of a filter with type and default, as text.

    Raises
    ------
    pymeshlab.PyMeshLabException
        If there is no such filter.
    """
    lines = [f"{name}:"]
    for parameter in list(inspect.signature(find(name)).parameters.values())[1:]:
        lines.append(f"  {parameter.name} : {parameter.annotation} = {parameter.default!r}")
    return "\n".join(lines)


def print_filter_parameter_list(name: str) -> None:
    """Print the parameters of a filter, as ``pymeshlab.print_filter_parameter_list`` does for its own.

    Raises
    ------
    pymeshlab.PyMeshLabException
        If there is no such filter.
    """
    sys.stdout.write(parameter_list(name) + "\n")


def print_filter_list() -> None:
    """Print the names and the first lines of all filters."""
    width = max(map(len, ALL))
    for name in filter_list():
        first = (inspect.getdoc(ALL[name]) or "").split("\n")[0]
        sys.stdout.write(f"{name:<{width}}  {first}\n")


def install(cls: type = pymeshlab.MeshSet) -> list[str]:
    """Bind the filters as methods, so that ``ms.delaunay_refinement(...)`` works; return their names.

    Raises
    ------
    pymeshlab.PyMeshLabException
        If a method of the same name is there that is not ours; nothing is bound then.
    """
    taken = [name for name in ALL if hasattr(cls, name) and getattr(cls, name) is not ALL[name]]
    if taken:
        raise pymeshlab.PyMeshLabException(f"{cls.__name__} has a method {taken[0]} of its own; nothing was installed")
    for name, function in ALL.items():
        setattr(cls, name, function)
    return filter_list()


def uninstall(cls: type = pymeshlab.MeshSet) -> list[str]:
    """Take the filters off again; return the names of those that were bound."""
    bound = [name for name in filter_list() if cls.__dict__.get(name) is ALL[name]]
    for name in bound:
        delattr(cls, name)
    return bound
