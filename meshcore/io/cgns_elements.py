"""Unstructured zones of CGNS: a `Mesh` as sections of elements, sets of its boundary's cells as boundary conditions.

Elements are counted through the sections, from 1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..errors import InvalidInput
from ..mesh import CELL_TYPES, Mesh
from .cgns_kinds import ELEMENTS, MIXED, NFACE, NGON, NUMBERS
from .cgns_nodes import Node
from .fit import warn_dropped
from .ragged import POLYGON, cells_by_kind

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
                order = np.argsort(ELEMENTS[NUMBERS[kind]].order)
                add_section(zone, names[part + 1] or kind, NUMBERS[kind], count, cells[inside][:, order] + 1)
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


def add_section(
    zone: Node, name: str, number: int, before: int, listed: np.ndarray, offsets: np.ndarray | None = None
) -> None:
    """A section of elements of one type, behind ``before`` others; ``offsets`` of those that list any number."""
    count = len(listed) if offsets is None else len(offsets) - 1
    section = zone.add(name, "Elements_t", np.array([number, 0], np.int32))
    section.add("ElementRange", "IndexRange_t", np.array([before + 1, before + count], np.int32))
    if offsets is not None:
        section.add("ElementStartOffset", "DataArray_t", offsets.astype(np.int32))
    section.add("ElementConnectivity", "DataArray_t", listed.ravel().astype(np.int32))


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


@dataclass(frozen=True)
class Elements:
    """The elements of a zone: numbers from 0, types of CGNS, and what each lists, from 1, as compressed rows."""

    number: np.ndarray
    types: np.ndarray
    offsets: np.ndarray
    nodes: np.ndarray

    def rows(self, where: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """(m, k) int: some of what each of some elements lists."""
        return self.nodes[self.offsets[where][:, None] + columns]


def read_elements(zone: Node) -> Elements:
    """All sections together."""
    sections = [_section(node) for node in zone.of("Elements_t")]
    if not sections:
        raise InvalidInput(f"the zone {zone.name!r} has no Elements_t")
    number, types, sizes, nodes = (np.concatenate(parts) for parts in zip(*sections, strict=True))
    return Elements(number, types, np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64), nodes)


def read_sections(elements: Elements, points: np.ndarray) -> tuple[Mesh, np.ndarray, np.ndarray]:
    """The cells of a zone, for each the number of its element, and (n,) bool: which points are left out with nodes."""
    types, sizes = np.zeros(len(elements.types), np.int64), np.diff(elements.offsets)
    found = np.unique(elements.types).tolist()
    for number in found:
        where = elements.types == number
        types[where] = POLYGON if number == NGON else CELL_TYPES[ELEMENTS[number].kind].vtk
        sizes[where] = sizes[where] if number == NGON else len(ELEMENTS[number].order)
    offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    corners = np.zeros(offsets[-1], np.int64)
    for number in found:
        some = np.flatnonzero(elements.types == number)
        for size in np.unique(sizes[some]).tolist():
            where = some[sizes[some] == size]
            order = np.arange(size) if number == NGON else np.array(ELEMENTS[number].order)
            corners[offsets[where][:, None] + np.arange(size)] = elements.rows(where, order)
    _warn_of_nodes(found)
    cells, origin = cells_by_kind(types, corners - 1, offsets, points)
    lost = np.zeros(len(points), bool)
    lost[elements.nodes[(elements.nodes > 0) & (elements.nodes <= len(points))] - 1] = True
    lost[corners - 1] = False
    return Mesh(points, cells), elements.number[origin], lost


def _warn_of_nodes(numbers: list[int]) -> None:
    reduced = [ELEMENTS[n] for n in numbers if n != NGON and len(ELEMENTS[n].order) < ELEMENTS[n].nodes]
    for element in reduced:
        warn_dropped("nodes of the elements", [element.name], f"they are read as {element.kind} cells")


def _section(section: Node) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Numbers, types and lengths of a section's elements, and what they list one after the other."""
    number = int(section.whole(2)[0])
    first, last = section.need("ElementRange").whole(2).tolist()
    nodes = section.need("ElementConnectivity").whole(-1)
    count = last - first + 1
    if first < 1 or not 0 <= count <= len(nodes):  # each lists a node at least
        raise InvalidInput(
            f"the section {section.name!r} promises the elements {first} to {last}, got {len(nodes)} nodes"
        )
    if number in ELEMENTS:
        types, sizes = np.full(count, number), np.full(count, ELEMENTS[number].nodes)
    elif number in (MIXED, NGON, NFACE):
        types, sizes, nodes = _of_any_length(section, number, nodes, count)
    else:
        raise InvalidInput(f"the section {section.name!r} has elements of the unknown type {number}")
    if len(nodes) != sizes.sum():
        raise InvalidInput(f"the section {section.name!r} promises {count} elements, which does not fit its nodes")
    return np.arange(first, last + 1) - 1, types, sizes, nodes


def _of_any_length(
    section: Node, number: int, listed: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Types, lengths and nodes of elements that stand behind their types, or (before CGNS 4) behind their lengths."""
    starts = section.find("ElementStartOffset")
    begins = _begins(section, number, listed) if starts is None else starts.whole(-1)
    ends = begins[1:]
    if len(begins) != count + 1 or begins[0] != 0 or begins[-1] != len(listed) or (np.diff(begins) < 1).any():
        raise InvalidInput(f"the section {section.name!r} promises {count} elements, but begins {len(ends)}")
    heads = number == MIXED or starts is None
    sizes = np.diff(begins) - heads
    types = listed[begins[:-1]] if number == MIXED else np.full(count, number)
    nodes = np.delete(listed, begins[:-1]) if heads else listed
    known = np.array([ELEMENTS[n].nodes if n in ELEMENTS else -1 for n in np.unique(types).tolist()])
    expected = known[np.searchsorted(np.unique(types), types)]
    if number == MIXED and (expected != sizes).any():
        odd = int(types[np.argmax(expected != sizes)])
        raise InvalidInput(f"the section {section.name!r} has an element of type {odd} with another number of nodes")
    return types, sizes, nodes


def _begins(section: Node, number: int, listed: np.ndarray) -> np.ndarray:
    """Where elements begin that each have their type, or the number of their nodes, before them."""
    begins, at, heads = [0], 0, listed.tolist()
    while at < len(heads):
        head = heads[at]
        size = head if number != MIXED else ELEMENTS[head].nodes if head in ELEMENTS else 0
        if size < 1:
            raise InvalidInput(f"the section {section.name!r} has an element of type {head}, or ends within one")
        at += 1 + size
        begins.append(at)
    return np.array(begins)
