"""What a format can hold, and the checks that nothing is lost without a word."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..errors import InvalidInput
from ..mesh import CELL_TYPES, Mesh, MultiBlock, PolyhedralMesh, StructuredGrid, with_named_sides

ALL_CELLS = tuple(CELL_TYPES)
SURFACE_CELLS = ("vertex", "line", "triangle", "quad")


class FormatWarning(UserWarning):
    """Something was changed or left out, because the file's format and a `Mesh` do not hold the same."""


@dataclass(frozen=True)
class Holds:
    """What a format can hold.

    Attributes
    ----------
    cells : tuple of str
        Kinds of cell; empty for formats of structured grids.
    blocks : int
        How many structured grids: 0 none, 1 one, 2 any number.
    point_data, cell_data, field_data : bool or tuple of str
        Whether data are held: all, none, or the arrays of these names.
    sets : bool
        Whether named sets are held.
    sides : bool
        Whether named sides of structured grids are held: as sets of boundary cells, or with cuts where blocks are.
    planar : bool
        The format has no z.
    polygons, polyhedra : bool
        Whether a `PolyhedralMesh` of these is held; without polyhedra their faces are, each once.
    """

    cells: tuple[str, ...] = ()
    blocks: int = 0
    point_data: bool | tuple[str, ...] = False
    cell_data: bool | tuple[str, ...] = False
    field_data: bool | tuple[str, ...] = False
    sets: bool = False
    sides: bool = False
    planar: bool = False
    polygons: bool = False
    polyhedra: bool = False


def warn_dropped(what: str, names: Sequence[str], reason: str) -> None:
    """Warn, once for all, that some arrays are left out."""
    if names:
        listed = ", ".join(repr(name) for name in names)
        warnings.warn(f"{what} {listed} left out: {reason}", FormatWarning, stacklevel=2)


def fitted(mesh: Any, holds: Holds, name: str) -> Mesh | PolyhedralMesh | StructuredGrid | MultiBlock:
    """``mesh`` as the type that a format takes, without the data that it cannot hold.

    Cells that it cannot hold are an error, data are left out with a `FormatWarning`.
    """
    if isinstance(mesh, tuple) and hasattr(mesh, "report"):
        raise InvalidInput("is a Result; write its first part: mesh, report = ...", parameter="mesh")
    if isinstance(mesh, PolyhedralMesh):
        return _fitted_polygons(mesh, holds, name)
    if not isinstance(mesh, (Mesh, StructuredGrid, MultiBlock)):
        raise InvalidInput(f"needs a Mesh, StructuredGrid or MultiBlock, got {type(mesh).__name__}", parameter="mesh")
    several = isinstance(mesh, MultiBlock) and len(mesh.blocks) > 1
    if holds.blocks and not (holds.cells and (isinstance(mesh, Mesh) or (several and holds.blocks == 1))):
        return _fitted_grid(mesh, holds, name)
    if holds.sides and isinstance(mesh, (StructuredGrid, MultiBlock)):
        mesh = with_named_sides(mesh)
    elif isinstance(mesh, MultiBlock) and mesh.joins:
        mesh = mesh.to_mesh()
    elif isinstance(mesh, MultiBlock):
        from .vtk_data import joined

        mesh = joined(dict(zip(mesh.names, mesh.blocks, strict=True)))
    elif isinstance(mesh, StructuredGrid):
        mesh = mesh.to_mesh()
    return _fitted_mesh(mesh, holds, name)


def _fitted_mesh(mesh: Mesh, holds: Holds, name: str) -> Mesh:
    mesh = replace(mesh, cells={kind: c for kind, c in mesh.cells.items() if len(c)})
    if wrong := [kind for kind in mesh.cells if kind not in holds.cells]:
        raise InvalidInput(
            f"has {len(mesh.cells[wrong[0]])} {wrong[0]} cells, which {name} does not hold; it holds "
            f"{', '.join(holds.cells)}; .vtu holds every kind",
            parameter="mesh",
        )
    if holds.planar and not mesh.is_planar:
        raise InvalidInput(f"is not planar, and {name} has no z; .vtu holds it", parameter="mesh")
    reason = f"{name} does not hold them; .vtu does"
    if mesh.sets and not holds.sets:
        warn_dropped("sets", list(mesh.sets), reason)
        mesh = replace(mesh, sets={})
    return replace(
        mesh,
        point_data=_kept(mesh.point_data, holds.point_data, "point data", reason),
        cell_data=_kept(mesh.cell_data, holds.cell_data, "cell data", reason),
        field_data=_kept(mesh.field_data, holds.field_data, "field data", reason),
    )


def _fitted_polygons(mesh: PolyhedralMesh, holds: Holds, name: str) -> PolyhedralMesh:
    if not holds.polygons:
        raise InvalidInput(
            f"is a PolyhedralMesh, which {name} does not hold; .vtu does, or write its to_mesh()", parameter="mesh"
        )
    reason = f"{name} does not hold them; .vtu does"
    if mesh.dimension == 3 and not holds.polyhedra:
        faces = PolyhedralMesh(mesh.points, mesh.face_offsets, mesh.face_nodes, point_data=mesh.point_data)
        warn_dropped("cells", [f"{mesh.n_cells} polyhedra"], f"{name} holds their faces only; .vtu holds them")
        mesh = replace(faces, field_data=mesh.field_data)
    return replace(
        mesh,
        point_data=_kept(mesh.point_data, holds.point_data, "point data", reason),
        cell_data=_kept(mesh.cell_data, holds.cell_data, "cell data", reason),
        field_data=_kept(mesh.field_data, holds.field_data, "field data", reason),
    )


def _fitted_grid(mesh: Mesh | StructuredGrid | MultiBlock, holds: Holds, name: str) -> StructuredGrid | MultiBlock:
    if isinstance(mesh, Mesh):
        raise InvalidInput(f"is a Mesh, and {name} holds structured grids only; .vtu holds it", parameter="mesh")
    if holds.blocks == 1 and isinstance(mesh, MultiBlock):
        if len(mesh.blocks) > 1:
            raise InvalidInput(f"has {len(mesh.blocks)} blocks, {name} holds one; .vtm holds them", parameter="mesh")
        mesh = mesh.blocks[0]
    if holds.point_data is True:
        return mesh
    blocks = mesh.blocks if isinstance(mesh, MultiBlock) else (mesh,)
    reason = f"{name} does not hold them; .vts and .vtm do"
    for what, attribute in (("point data", "point_data"), ("cell data", "cell_data"), ("face names", "names")):
        if attribute == "names" and holds.sides:
            continue
        kept = getattr(holds, attribute, False) or ()
        held = dict.fromkeys(key for block in blocks for key in getattr(block, attribute))
        warn_dropped(what, [key for key in held if key not in kept], reason)
    if any(any(block.periodic) for block in blocks) and not holds.sides:
        warn_dropped("the property", ["periodic"], reason)
    if (any(block.cuts for block in blocks) or (isinstance(mesh, MultiBlock) and mesh.cuts)) and not holds.sides:
        warn_dropped("the property", ["cuts"], reason)
    if isinstance(mesh, MultiBlock) and not holds.sides:
        warn_dropped("block names", [n for k, n in enumerate(mesh.names) if n != f"block {k}"], reason)
    return mesh


def _kept(data: Mapping[str, np.ndarray], held: bool | tuple[str, ...], what: str, reason: str) -> dict[str, Any]:
    if held is True:
        return dict(data)
    kept = {key: values for key, values in data.items() if key in (held or ())}
    warn_dropped(what, [key for key in data if key not in kept], reason)
    return kept


def sets_as_tags(mesh: Mesh, name: str) -> tuple[np.ndarray | None, list[str]]:
    """For formats with one number a cell: ``cell_data["tag"]``, or else the sets, counted from 1.

    Returns
    -------
    tags : (number of cells,) int or None
        None if there are neither whole-number tags nor sets.
    names : list of str
        Names of the tags 1, 2, ... if they come from sets.
    """
    if (tag := mesh.cell_data.get("tag")) is not None:
        if tag.dtype.kind in "iub" and tag.ndim == 1:
            warn_dropped("sets", list(mesh.sets), f"{name} has one number a cell, which cell_data['tag'] takes")
            return tag.astype(np.int64), []
        warn_dropped("cell data", ["tag"], f"{name} needs whole numbers")
    tags, names = np.zeros(mesh.n_cells, np.int64), []
    for key, members in mesh.sets.items():
        if tags[members].any() or not len(members):
            why = "they share cells with other sets" if len(members) else "they are empty"
            warn_dropped("sets", [key], f"{why}, and {name} has one number a cell")
            continue
        names.append(key)
        tags[members] = len(names)
    return (tags, names) if names else (None, [])


def columns_of(data: Mapping[str, np.ndarray], what: str, name: str) -> dict[str, np.ndarray]:
    """Those data arrays that are one real number a row; the others are left out with a `FormatWarning`."""
    kept = {key: v for key, v in data.items() if v.ndim == 1 and v.dtype.kind in "biuf"}
    warn_dropped(what, [key for key in data if key not in kept], f"{name} holds one number a row")
    return kept
