# SPDX-License-Identifier: GPL-3.0-or-later
"""Results as Blender objects: placed on their source, with quality and report kept on the mesh."""

from __future__ import annotations

import dataclasses
from typing import Any

import bpy
import numpy as np

REPORT = "meshcore_report"
QUALITY = "quality"
MEASURE = "scaled_jacobian"
STOPPED = "stopped"


def show(context: Any, label: str, source: str, result: Any) -> tuple[Any, list[str]]:
    """A new object with the result's mesh, made active, and warnings.

    It stands at the source's place, without rotation or scale, so that its coordinates coincide with the source's in
    the world and keep as many digits.
    """
    from meshcore import Mesh, MultiBlock, StructuredGrid, quality

    from . import convert, volume

    mesh, sides = result.mesh, {}
    if isinstance(mesh, (StructuredGrid, MultiBlock)):
        mesh, sides = _with_named_faces(mesh)
    elif isinstance(mesh, Mesh):
        sides = volume.sides(mesh)
    parent = bpy.data.objects.get(source)
    origin = np.array(parent.matrix_world.translation) if parent else np.zeros(3)
    report = result.report
    if isinstance(mesh, Mesh) and mesh.n_cells and mesh.dimension > 1:
        mesh = mesh.with_cell_data(**{QUALITY: quality.measure(mesh, MEASURE)})
        report = dataclasses.replace(report, quality=report.quality or quality.summary(mesh))
    name = f"{source} {label}" if source else label
    write = convert.write if isinstance(mesh, Mesh) else convert.write_polygons
    data, warnings = write(name, mesh, origin)
    _keep_report(data, report)
    ob = bpy.data.objects.new(name, data)
    ob.location = origin
    for side, vertices in sides.items():
        ob.vertex_groups.new(name=side).add(vertices, 1.0, "REPLACE")
    _home(context, parent).objects.link(ob)
    _make_active(context, ob)
    if marked := _select_stopped(data):
        warnings = [*warnings, f"{marked} {'vertex' if marked == 1 else 'vertices'} selected there"]
    return ob, warnings


def _select_stopped(data: Any) -> int:
    """Select the vertices at which a march stopped, and nothing else; return how many there are."""
    from . import convert, selection

    at_vertices, at_faces = (convert.attributes(data, domain).get(STOPPED) for domain in ("POINT", "FACE"))
    if at_vertices is not None:
        stopped = np.flatnonzero(at_vertices > 0)
    elif at_faces is not None:
        stopped = np.unique([v for face in np.flatnonzero(at_faces > 0) for v in data.polygons[int(face)].vertices])
    else:
        return 0
    selection.select_only(data, "vertices", stopped)
    return len(stopped)


def _with_named_faces(grid: Any) -> tuple[Any, dict[str, list[int]]]:
    """A grid as a glued mesh, and the vertices of its named sides: in Blender they are vertex groups."""
    from meshcore import with_named_sides

    sides = with_named_sides(grid)
    kind = "line" if "line" in sides.cells else "quad"
    start = {name: where.start for name, _, where in sides.blocks()}.get(kind, 0)
    faces = {
        name: np.unique(sides.cells[kind][cells - start]).tolist()
        for name, cells in sides.sets.items()
        if name != "boundary"
    }
    return grid.to_mesh(), faces


def _home(context: Any, source: Any) -> Any:
    """The source's collection where one may be added to, so that the result is shown where the source is."""
    for collection in source.users_collection if source else ():
        if collection.library is None and collection.override_library is None:
            return collection
    return context.collection or context.scene.collection


def _make_active(context: Any, ob: Any) -> None:
    if context.active_object and context.active_object.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    context.view_layer.update()  # it does not know what was just linked or removed
    for other in context.view_layer.objects:
        other.select_set(False)
    # An excluded collection is not part of the view layer: the object is there, but cannot be made active.
    if ob.name in context.view_layer.objects:
        ob.select_set(True)
        context.view_layer.objects.active = ob


def _keep_report(data: Any, report: Any) -> None:
    """The report as ID properties, for the panel; they are saved with the file."""
    data[REPORT] = {
        "operation": report.operation,
        "seconds": report.seconds,
        "converged": bool(report.converged),
        "warnings": "\n".join(report.warnings),
        "counts": {name[:63]: int(number) for name, number in report.counts.items()},
        "quality": {name[:63]: float(number) for name, number in report.quality.items()},
    }


def summary(data: Any) -> list[tuple[str, str]]:
    """The kept report as rows of text; none if the mesh is not from meshcore."""
    kept = data.get(REPORT)
    if kept is None:
        return []
    rows = [(name, f"{number:,}") for name, number in kept["counts"].items()]
    rows += [(name, f"{number:.4g}") for name, number in kept["quality"].items()]
    if not kept["converged"]:
        rows.append(("converged", "no"))
    rows += [("warning", text) for text in kept["warnings"].splitlines()]
    return [*rows, ("seconds", f"{kept['seconds']:.3g}")]
