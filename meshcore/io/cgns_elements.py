"""Unstructured zones of CGNS: a `Mesh` as sections of elements, sets of its boundary's cells as boundary conditions.

Elements are counted through the sections, from 1. Corners of linear elements stand in the order of a `Mesh`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..errors import InvalidInput
from ..mesh import CELL_TYPES, Mesh
from .cgns_nodes import Node
from .fit import warn_dropped
from .ragged import cells_by_kind

KINDS = {
    "vertex": 2,
    "line": 3,
    "triangle": 5,
    "quad": 7,
    "tetra": 10,
    "pyramid": 12,
    "wedge": 14,
    "hexahedron": 17,
}
"""CGNS's numbers of the linear elements."""
_BY_NUMBER = {number: CELL_TYPES[kind] for kind, number in KINDS.items()}
_MIXED = 20
_LOCATIONS = {1: "EdgeCenter", 2: "FaceCenter"}


def write_sections(zone: Node, mesh: Mesh, family: Callable[[str], str]) -> np.ndarray:
    """Sections of one kind each, the boundary's by sets, and the sets as conditions; the domain's cells, by section."""
    is_domain = np.zeros(mesh.n_cells, bool)
    for kind, _, where in mesh.blocks():
        is_domain[where] = CELL_TYPES[kind].dimension == mesh.dimension
    sets = _boundary_sets(mesh)
    owner = np.full(mesh.n_cells, len(sets))
    for number, members in reversed(list(enumerate(sets.values()))):
        owner[members] = number
    owner[is_domain] = -1
    names = ["", *sets, "boundary"]
    element, count, domain = np.zeros(mesh.n_cells, np.int64), 0, []
    for part in np.unique(owner).tolist():
        for kind, cells, where in mesh.blocks():
            inside = np.flatnonzero(owner[where] == part)
            if len(inside):
                section = zone.add(names[part + 1] or kind, "Elements_t", np.array([KINDS[kind], 0], np.int32))
                span = np.array([count + 1, count + len(inside)], np.int32)
                section.add("ElementRange", "IndexRange_t", span)
                section.add("ElementConnectivity", "DataArray_t", (cells[inside].ravel() + 1).astype(np.int32))
                element[where.start + inside] = np.arange(count, count + len(inside)) + 1
                count += len(inside)
                domain += [where.start + inside] if part < 0 else []
    for name, members in sets.items():
        conditions = zone.find("ZoneBC") or zone.add("ZoneBC", "ZoneBC_t")
        condition = conditions.add(name, "BC_t", "FamilySpecified")
        listed = np.sort(element[members]).astype(np.int32)
        if listed[-1] - listed[0] + 1 == len(listed):
            condition.add("PointRange", "IndexRange_t", listed[[0, -1]][:, None])
        else:
            condition.add("PointList", "IndexArray_t", listed[:, None])
        condition.add("GridLocation", "GridLocation_t", _LOCATIONS[mesh.dimension - 1])
        condition.add("FamilyName", "FamilyName_t", family(name))
    return np.concatenate(domain)


def _boundary_sets(mesh: Mesh) -> dict[str, np.ndarray]:
    """The sets that conditions can be: of faces or edges of the domain's cells, and not empty."""
    fit = np.zeros(mesh.n_cells, bool)
    for kind, _, where in mesh.blocks():
        fit[where] = CELL_TYPES[kind].dimension == mesh.dimension - 1 > 0
    sets = {name: members for name, members in mesh.sets.items() if len(members) and fit[members].all()}
    dropped = [name for name in mesh.sets if name not in sets]
    warn_dropped("sets", dropped, "boundary conditions of CGNS hold cells of the boundary; .vtu holds all sets")
    return sets


# ---- reading


def read_sections(zone: Node, points: np.ndarray) -> tuple[Mesh, np.ndarray]:
    """The cells and sets of a zone, without data, and for each cell its element's number, from 0."""
    types, corners, sizes, numbers = [], [], [], []
    for section in zone.of("Elements_t"):
        first, last = section.need("ElementRange").whole(2).tolist()
        kinds, nodes = _section(section, last - first + 1)
        types.append(kinds)
        corners.append(nodes)
        sizes.append([_BY_VTK_SIZE[kind] for kind in kinds.tolist()])
        numbers.append(np.arange(first, last + 1) - 1)
    if not types:
        raise InvalidInput(f"the zone {zone.name!r} has no Elements_t")
    offsets = np.concatenate([[0], np.cumsum(np.concatenate(sizes))]).astype(np.int64)
    cells, origin = cells_by_kind(np.concatenate(types), np.concatenate(corners), offsets, points)
    element = np.concatenate(numbers)[origin]
    return Mesh(points, cells, sets=_sets(zone, element)), element


_BY_VTK_SIZE = {kind.vtk: kind.nodes for kind in _BY_NUMBER.values()}


def _section(section: Node, count: int) -> tuple[np.ndarray, np.ndarray]:
    """VTK's types of a section's elements, and their corners, from 0."""
    number = int(section.whole(2)[0])
    nodes = section.need("ElementConnectivity").whole(-1)
    if number == _MIXED:
        return _mixed(section, nodes, count)
    if number not in _BY_NUMBER:
        raise InvalidInput(
            f"the section {section.name!r} has elements of type {number}; linear ones are read, of one kind or mixed"
        )
    kind = _BY_NUMBER[number]
    if count < 0 or len(nodes) != count * kind.nodes:
        raise InvalidInput(
            f"the section {section.name!r} promises {count} {kind.name} elements, got {len(nodes)} corners"
        )
    return np.full(count, kind.vtk), nodes - 1


def _mixed(section: Node, nodes: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Elements that each begin with the number of their type."""
    types, corners, at, listed = [], [], 0, nodes.tolist()
    while at < len(listed):
        kind = _BY_NUMBER.get(listed[at])
        if kind is None or at + kind.nodes >= len(listed):
            raise InvalidInput(f"the section {section.name!r} has an element of type {listed[at]}, or ends within one")
        types.append(kind.vtk)
        corners += listed[at + 1 : at + 1 + kind.nodes]
        at += 1 + kind.nodes
    if len(types) != count:
        raise InvalidInput(f"the section {section.name!r} promises {count} elements, got {len(types)}")
    return np.array(types, np.int64), np.array(corners, np.int64) - 1


def _sets(zone: Node, element: np.ndarray) -> dict[str, np.ndarray]:
    """The conditions that list elements, by the names of their families."""
    sets: dict[str, list[np.ndarray]] = {}
    odd = []
    for condition in [c for group in zone.of("ZoneBC_t") for c in group.of("BC_t")]:
        location = condition.find("GridLocation")
        span = condition.find("PointRange") or condition.find("ElementRange")
        listed = condition.find("PointList") or condition.find("ElementList")
        if (span is None and listed is None) or (location is None or location.text() == "Vertex"):
            odd.append(condition.name)
            continue
        if span is not None:
            low, high = span.whole(*(-1 for _ in np.shape(span.value))).ravel()[[0, -1]] - 1
            members = np.flatnonzero((element >= low) & (element <= high))
        else:
            members = np.flatnonzero(np.isin(element, listed.whole(*(-1 for _ in np.shape(listed.value))).ravel() - 1))
        family = condition.find("FamilyName")
        sets.setdefault(family.text() if family else condition.name, []).append(members)
    warn_dropped("boundary conditions", odd, "they list points, and a set of a Mesh holds cells")
    return {name: np.unique(np.concatenate(parts)) for name, parts in sets.items()}
