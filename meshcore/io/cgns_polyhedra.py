"""Polygons and polyhedra of CGNS: sections of faces (NGON_n), and of cells that list them (NFACE_n).

A cell lists a face with a sign, + if the face looks out of it. Cells of standard shape become a `Mesh`, whose sets hold
the faces of boundary conditions; a `PolyhedralMesh` has no sets.
"""

from __future__ import annotations

import numpy as np

from ..errors import InvalidInput
from ..mesh import CELL_TYPES, Mesh, PolyhedralMesh, polygons
from .cgns_conditions import read_sets
from .cgns_elements import Elements, add_section
from .cgns_kinds import ELEMENTS, NFACE, NGON
from .cgns_nodes import Node
from .fit import warn_dropped
from .polyhedra import joined_faces
from .ragged import POLYGON, cells_by_kind
from .standard_cells import standard_cells


def write_polyhedra(zone: Node, mesh: PolyhedralMesh) -> None:
    """The faces, and where they lie between cells, the cells that list them."""
    add_section(zone, "faces", NGON, 0, mesh.face_nodes + 1, mesh.face_offsets)
    if mesh.owner is None:
        return
    offsets, faces = mesh.cell_faces
    cell = np.repeat(np.arange(mesh.n_cells), np.diff(offsets))
    listed = np.where(mesh.owner[faces] == cell, faces + 1, -faces - 1)
    add_section(zone, "cells", NFACE, mesh.n_faces, listed, offsets)


# ---- reading


def are_polyhedra(zone: Node, elements: Elements, dimension: int) -> bool:
    """Whether a zone's cells are polyhedra, or polygons of more corners than a `Mesh` holds."""
    if (elements.types == NFACE).any() or _parents(zone) is not None:
        return True
    alone = dimension == 2 and (elements.types == NGON).all()
    return bool(alone and len(elements.types) and np.diff(elements.offsets).max() > 4)


def read_polyhedra(
    zone: Node, elements: Elements, points: np.ndarray, parents: dict[str, list[str]]
) -> tuple[Mesh | PolyhedralMesh, np.ndarray]:
    """The cells of a zone, without data, and the number of each one's element."""
    _check_others(zone, elements.types)
    face = np.flatnonzero(elements.types == NGON)
    offsets, nodes = polygons.taken(elements.offsets, elements.nodes - 1, face)
    number = elements.number[face]
    if not (elements.types == NFACE).any() and _parents(zone) is None:
        _drop(read_sets(zone, number, parents))
        return PolyhedralMesh(points, offsets, nodes), number
    cell, seen, outward, cells = _sides(zone, elements, number)
    rows, corners = polygons.taken(offsets, nodes, seen)
    mesh = joined_faces(points, rows, polygons.turned(rows, corners, ~outward), cell)
    sets = read_sets(zone, number, parents)
    solids = standard_cells(mesh)
    if solids is None:
        _drop(sets)
        return mesh, cells
    bounding = np.unique(np.concatenate([np.empty(0, np.int64), *sets.values()]))
    rows, corners = polygons.taken(offsets, nodes, bounding)
    flat, origin = cells_by_kind(np.full(len(bounding), POLYGON), corners, rows, points)
    element = np.concatenate([cells[solids[1]], number[bounding][origin]])
    sets = {name: _members(number[members], element) for name, members in sets.items()}
    return Mesh(points, {**solids[0], **flat}, sets=sets), element


def _check_others(zone: Node, types: np.ndarray) -> None:
    """`InvalidInput` if other cells stand beside polyhedra; other faces are left out."""
    others = [ELEMENTS[number] for number in np.unique(types).tolist() if number in ELEMENTS]
    if solid := [element.name for element in others if CELL_TYPES[element.kind].dimension == 3]:
        raise InvalidInput(
            f"the zone {zone.name!r} has {', '.join(solid)} beside polyhedra; make all of them polyhedra"
        )
    warn_dropped("elements", [element.name for element in others], "the zone's cells are polyhedra")


def _members(wanted: np.ndarray, element: np.ndarray) -> np.ndarray:
    return np.flatnonzero(np.isin(element, wanted))


def _drop(sets: dict[str, np.ndarray]) -> None:
    warn_dropped("boundary conditions", list(sets), "a PolyhedralMesh has no sets")


def _parents(zone: Node) -> np.ndarray | None:
    """(2, number of faces) int: the elements before and behind each face, 0 for none; None if not all sections tell."""
    sections = [node for node in zone.of("Elements_t") if int(node.whole(2)[0]) == NGON]
    told = [node.find("ParentElements") for node in sections]
    if not told or any(node is None for node in told):
        return None
    return np.concatenate([node.whole(2, -1) for node in told], axis=1)


def _sides(zone: Node, elements: Elements, number: np.ndarray) -> tuple[np.ndarray, ...]:
    """Cell by cell which faces it sees, and whether these look out of it; and the numbers of the cells' elements."""
    listing = np.flatnonzero(elements.types == NFACE)
    if len(listing):
        rows, listed = polygons.taken(elements.offsets, elements.nodes, listing)
        cells = elements.number[listing]
        cell, sought, outward = np.repeat(np.arange(len(cells)), np.diff(rows)), np.abs(listed) - 1, listed > 0
    else:
        told = _parents(zone)
        if told.shape[1] != len(number):
            raise InvalidInput(f"the zone {zone.name!r} has {len(number)} faces, and parents of {told.shape[1]}")
        sought, outward = np.tile(number, 2), np.repeat([True, False], len(number))
        beside = told.ravel() > 0
        cells, cell = np.unique(told.ravel()[beside] - 1, return_inverse=True)
        order = np.argsort(cell, kind="stable")
        cell, sought, outward = cell[order], sought[beside][order], outward[beside][order]
    if not len(number) or not len(cells):
        raise InvalidInput(f"the zone {zone.name!r} has cells that list faces, but no faces (NGON_n)")
    order = np.argsort(number)
    place = order[np.minimum(np.searchsorted(number[order], sought), len(number) - 1)]
    if (number[place] != sought).any():
        bad = int(np.argmax(number[place] != sought))
        raise InvalidInput(f"the cell {cells[cell[bad]] + 1} lists the face {sought[bad] + 1}, which is not there")
    return cell, place, outward, cells
