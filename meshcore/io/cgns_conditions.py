"""Boundary conditions of CGNS: names of a block's faces, or sets of a mesh's cells.

A condition is called by its family, or else by its own name.
"""

from __future__ import annotations

import numpy as np

from ..mesh import Patch, StructuredGrid
from ..mesh.cuts import Range, as_range
from ..mesh.patches import UNNAMED
from ..mesh.structured_grid import FACES
from .cgns_joins import box_of
from .cgns_nodes import Node
from .fit import warn_dropped


def names_of(condition: Node, parents: dict[str, list[str]]) -> list[str]:
    """A condition's family and the families above it; without one its own name."""
    named = [node.text() for label in ("FamilyName_t", "AdditionalFamilyName_t") for node in condition.of(label)]
    found = dict.fromkeys(named or [condition.name])
    ahead = list(found)
    while ahead:
        for name in parents.get(ahead.pop(), []):
            if name not in found:
                found[name] = None
                ahead.append(name)
    return list(found)


def _conditions(zone: Node) -> list[Node]:
    return [condition for group in zone.of("ZoneBC_t") for condition in group.of("BC_t")]


def _location(condition: Node) -> str:
    found = condition.find("GridLocation")
    return found.text() if found else "Vertex"


def patches_of(zone: Node, number: int, block: StructuredGrid) -> list[Patch]:
    """The conditions of a structured zone that are rectangles of points, or of faces between them, on a side."""
    found, odd = [], []
    for condition in _conditions(zone):
        listed = condition.find("PointRange") or condition.find("PointList")
        box = box_of(listed, block) if listed else None
        side = _side(box, block.shape, _location(condition)) if box is not None else None
        if side is None:
            odd.append(condition.name)
            continue
        name = names_of(condition, {})[0]
        found.append(Patch(number, *side, "" if name == UNNAMED else name))
    warn_dropped("boundary conditions", odd, "they are no rectangle of points or faces on a side")
    return found


def _side(box: np.ndarray, shape: tuple[int, int, int], location: str) -> tuple[str, Range] | None:
    """The side on which a rectangle lies, and its first and last point; None if there is none."""
    by_faces = location.endswith(("FaceCenter", "EdgeCenter"))
    if not by_faces and location != "Vertex":
        return None
    axes = ["IJK".index(location[0])] if location[1:] == "FaceCenter" and location[0] in "IJK" else range(3)
    for axis in [a for a in axes if shape[a] > 1]:
        across = [k for k in range(3) if k != axis and shape[k] > 1]
        first, last = box[0], box[1] + [by_faces and k in across for k in range(3)]
        on_side = first[axis] == last[axis] and first[axis] in (0, shape[axis] - 1)
        if on_side and (last > first)[across].all() and (last < shape).all():
            return FACES[2 * axis + int(first[axis] > 0)], as_range((first, last), shape)
    return None


def read_sets(zone: Node, element: np.ndarray, parents: dict[str, list[str]]) -> dict[str, np.ndarray]:
    """The conditions that list elements, as sets of cells by the names of their families and of families of these.

    Parameters
    ----------
    zone : Node
        The zone.
    element : (number of cells,) int
        The number of each cell's element, from 0.
    parents : dict of str to list of str
        The families that each family belongs to.
    """
    sets: dict[str, list[np.ndarray]] = {}
    odd = []
    for condition in _conditions(zone):
        span = condition.find("PointRange") or condition.find("ElementRange")
        listed = condition.find("PointList") or condition.find("ElementList")
        by_points = condition.find("ElementRange") is None and condition.find("ElementList") is None
        if (span is None and listed is None) or (by_points and _location(condition) == "Vertex"):
            odd.append(condition.name)
            continue
        told = span or listed
        numbers = told.whole(*(-1 for _ in np.shape(told.value))).ravel() - 1
        if span is not None and len(numbers):
            members = np.flatnonzero((element >= numbers[0]) & (element <= numbers[-1]))
        else:
            members = np.flatnonzero(np.isin(element, numbers))
        for name in names_of(condition, parents):
            sets.setdefault(name, []).append(members)
    warn_dropped("boundary conditions", odd, "they list points, and a set of a Mesh holds cells")
    return {name: np.unique(np.concatenate(parts)) for name, parts in sets.items()}
