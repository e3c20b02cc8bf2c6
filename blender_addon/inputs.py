# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects are an operation's inputs, and what to tell the user who selected others."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np

from .convert import ReadingFailed, Source, read

if TYPE_CHECKING:
    from meshcore import Mesh

READABLE = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
_MODES = {"OBJECT", "EDIT"}


def by_name(declaration: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """The inputs that are objects chosen by name, not by selection.

    They are those that say so, and optional ones of faces where the first is lines.
    """
    ports = declaration["inputs"]
    first = next(iter(ports.values()), None)
    return {
        name: port
        for name, port in ports.items()
        if port is not first
        and port["optional"]
        and (port.get("named") or (_lines_only(first) and not _lines_only(port)))
    }


def _selected_ports(declaration: dict[str, Any]) -> dict[str, dict[str, Any]]:
    named = by_name(declaration)
    return {name: port for name, port in declaration["inputs"].items() if name not in named}


def problem(context: Any, declaration: dict[str, Any]) -> str:
    """Why the operation cannot run on what is selected; empty if it can."""
    ob = context.active_object
    wanted = wanted_text(declaration)
    if not declaration["inputs"]:
        return ""
    if ob is None:
        return f"Select {wanted}"
    if ob.type not in READABLE:
        return f"{ob.name} ({ob.type.lower().replace('_', ' ')}) has no lines or faces; select {wanted}"
    if not ob.visible_get():
        return f"{ob.name} is hidden; show it first"
    if ob.mode not in _MODES:
        return "Go to Object Mode or Edit Mode first"
    return ""


def wanted_text(declaration: dict[str, Any]) -> str:
    """What to select, in words."""
    ports = _selected_ports(declaration)
    first = next(iter(ports.values()), None)
    if first is None:
        return "nothing"
    if not first["cells"]:
        return "a mesh; its vertices are taken"
    if not _lines_only(first):
        return (
            f"a mesh with faces, or {len(ports)} of them ({', '.join(ports)})"
            if len(ports) > 2
            else "a mesh with faces"
        )
    if len(ports) == 1:
        return "a curve, or a mesh with open edges"
    both = f"{len(ports)} curves ({', '.join(ports)}"
    if len(ports) > 2:
        return f"{both}), or one closed curve or four chains of edges in one object"
    both += f"; make the {next(iter(ports))} the active one)"
    optional = any(port["optional"] for port in ports.values())
    return f"a curve, or a mesh with open edges, or {both}" if optional else both


def gather(
    context: Any, declaration: dict[str, Any], chosen: dict[str, str] | None = None, groups: Sequence[str] = ()
) -> list[Source]:
    """The inputs in the order of the ports: the active object first, then the other selected ones.

    A single input of lines takes all selected objects together, such as an outline and its holes. Inputs `by_name` come
    last; ``chosen`` has the names of their objects, and these do not count as selected. Vertex groups among ``groups``
    are read as point data.

    Raises
    ------
    ReadingFailed
        If the selection does not fit; the text says what to select.
    """
    if text := problem(context, declaration):
        raise ReadingFailed(text)
    named = {
        name: _object(chosen[name], port) for name, port in by_name(declaration).items() if (chosen or {}).get(name)
    }
    sources = _gathered(context, declaration, list(named.values()), groups)
    ports = declaration["inputs"]
    return sources + [read(context, ob, ports[name]["cells"], groups) for name, ob in named.items()]


def _object(name: str, port: dict[str, Any]) -> Any:
    """An object by its name."""
    ob = bpy.data.objects.get(name)
    if ob is None:
        raise ReadingFailed(f"there is no object {name!r}; {port['description'].lower()}")
    if ob.type not in READABLE:
        raise ReadingFailed(f"{name} ({ob.type.lower()}) has no faces; {port['description'].lower()}")
    return ob


def _gathered(context: Any, declaration: dict[str, Any], left_out: list[Any], groups: Sequence[str]) -> list[Source]:
    """The inputs that are selected."""
    ports = list(_selected_ports(declaration).values())
    if not ports:
        return []
    active = context.active_object
    if active in left_out:
        raise ReadingFailed(f"{active.name} is the active object and chosen by name, too; make the other one active")
    others = []
    if active.mode == "OBJECT":
        others = [ob for ob in context.selected_objects if ob is not active and ob.type in READABLE]
        others = [ob for ob in others if ob not in left_out]
        others.sort(key=lambda ob: ob.name)
    if len(ports) == 1:
        everything = [active, *others] if _lines_only(ports[0]) else [active]
        return [_joined([read(context, ob, ports[0]["cells"], groups) for ob in everything])]
    if 1 + len(others) not in (1, len(ports)):
        raise ReadingFailed(f"{1 + len(others)} objects are selected; select {wanted_text(declaration)}")
    sources = [read(context, ob, port["cells"], groups) for ob, port in zip([active, *others], ports, strict=False)]
    return in_order(sources) if all(map(_lines_only, ports)) else sources


def in_order(sides: list[Source]) -> list[Source]:
    """Curves in the order in which they follow one another around, beginning with the first.

    Blender does not tell in which order objects were selected. Of the two ways around, the one is taken in which the
    second curve begins where the first ends.
    """
    if len(sides) < 3:
        return sides
    from meshcore.structured.algebraic.one_boundary import order_around

    return [sides[k] for k in order_around([_ends(side.mesh) for side in sides])]


def _ends(mesh: Mesh) -> np.ndarray:
    """(2, 3) float: where a chain of lines begins and ends; its first two points if it does neither."""
    lines = mesh.get("line")
    count = np.bincount(lines.ravel(), minlength=mesh.n_points)
    ends = np.flatnonzero(count == 1)
    if len(ends) != 2:
        return mesh.points[:2]
    forwards = lines[:, 0].tolist().count(ends[0]) == 1 or lines[0, 0] == ends[0]
    return mesh.points[ends if forwards else ends[::-1]]


def _joined(sources: list[Source]) -> Source:
    """Several boundaries as one, with the data that all of them have and a tag for each."""
    from meshcore import Mesh

    if len(sources) == 1:
        return sources[0]
    meshes = [source.mesh for source in sources]
    starts = np.cumsum([0, *[mesh.n_points for mesh in meshes[:-1]]])
    lines = np.concatenate([mesh.get("line") + start for mesh, start in zip(meshes, starts, strict=True)])
    data = {"tag": np.repeat(np.arange(1, len(meshes) + 1), [mesh.n_cells for mesh in meshes])}
    for name in set.intersection(*[set(mesh.cell_data) for mesh in meshes]):
        data[name] = np.concatenate([mesh.cell_data[name] for mesh in meshes])
    points = np.concatenate([mesh.points for mesh in meshes])
    at_points = {
        name: np.concatenate([mesh.point_data[name] for mesh in meshes])
        for name in set.intersection(*[set(mesh.point_data) for mesh in meshes])
    }
    joined = Mesh(points, {"line": lines}, point_data=at_points, cell_data=data)
    return Source(joined, sources[0].name, parts=tuple(sources))


def _lines_only(port: dict[str, Any]) -> bool:
    return bool(port["cells"]) and set(port["cells"]) <= {"line"}
