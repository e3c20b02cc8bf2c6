"""Cuts as CGNS's 1-to-1 connections, each told by both of its zones, and periodic ones with their turn and shift.

A turn is given by the angles about x, y and z, done in this order. The standard keeps them in single precision; on
reading, turn and shift are corrected by the points that they map onto each other.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from ..errors import InvalidInput
from ..mesh import Cut, StructuredGrid
from ..mesh.cuts import Index, Range, as_index, as_range
from .cgns_abutting import cut_of_lists, is_point_by_point
from .cgns_nodes import Node
from .fit import warn_dropped

_DONOR = " donor"
_UNNAMED = re.compile(r"join( \d+)?")
_LABEL = "GridConnectivity1to1_t"


def index_range(points: ArrayLike, axes: int) -> np.ndarray:
    """(2, axes) int32: first and last of two points, counted from 1."""
    return np.array(points, np.int32)[:, :axes] + 1


def range_of(node: Node, block: StructuredGrid) -> Range:
    """First and last point of a range, counted from 0, in three indices."""
    corners = _indices(node, block)
    if len(corners) != 2:
        raise InvalidInput(f"{node.label} {node.name!r} has {len(corners)} points, a range has two")
    return as_range(corners, block.shape)


def box_of(node: Node, block: StructuredGrid) -> np.ndarray | None:
    """(2, 3) int: least and greatest indices of a range, or of a list that fills what lies between; else None."""
    listed = _indices(node, block)
    if not len(listed):
        return None
    low, high = listed.min(axis=0), listed.max(axis=0)
    filled = node.label == "IndexRange_t" or len(np.unique(listed, axis=0)) == np.prod(high - low + 1)
    return np.array(as_range((low, high), block.shape)) if filled else None


def _indices(node: Node, block: StructuredGrid) -> np.ndarray:
    """(n, 3) int: points from 0."""
    axes = 2 if block.is_surface and np.shape(node.value)[-1:] == (2,) else 3
    listed = node.whole(-1, axes) - 1
    return np.pad(listed, ((0, 0), (0, 3 - axes)))


# ---- writing


def write_joins(zones: Sequence[Node], cuts: Sequence[Cut], axes: int, coordinates: int) -> None:
    """Both sides of each cut, under the zones."""
    mirrored = [cut for cut in cuts if cut.rotation is not None and np.linalg.det(cut.rotation) < 0]
    warn_dropped("cuts", [cut.name or "join" for cut in mirrored], "CGNS knows no mirror images")
    for cut in cuts:
        if cut not in mirrored:
            name = cut.name or "join"
            first = _write_side(zones, cut, name, axes, coordinates)
            _write_side(zones, cut.reversed(), first + _DONOR, axes, coordinates)


def _write_side(zones: Sequence[Node], cut: Cut, name: str, axes: int, coordinates: int) -> str:
    """One side, its range counted up; the name that it got."""
    zone, low, high = zones[cut.block], np.min(cut.points, axis=0), np.max(cut.points, axis=0)
    partner = cut.across(np.array([low, high]))
    joins = zone.find("ZoneGridConnectivity") or zone.add("ZoneGridConnectivity", "ZoneGridConnectivity_t")
    join = joins.add(name, _LABEL, zones[cut.partner_block].name)
    join.add("Transform", '"int[IndexDimension]"', np.array(cut.transform[:axes], np.int32))
    join.add("PointRange", "IndexRange_t", index_range((low, high), axes))
    join.add("PointRangeDonor", "IndexRange_t", index_range(partner, axes))
    if cut.moves:
        moved = join.add("GridConnectivityProperty", "GridConnectivityProperty_t").add("Periodic", "Periodic_t")
        turn = np.eye(3) if cut.rotation is None else np.array(cut.rotation)
        shift = np.zeros(3) if cut.translation is None else np.array(cut.translation)
        numbers = (("RotationCenter", np.zeros(3)), ("RotationAngle", _angles(turn)), ("Translation", shift))
        for key, values in numbers:
            node = moved.add(key, "DataArray_t", values[:coordinates].astype(np.float32))
            if key == "RotationAngle":
                units = ["Null", "Null", "Null", "Null", "Radian"]
                letters = np.array([list(unit.ljust(32)) for unit in units], "S1").view(np.int8)
                node.add("DimensionalUnits", "DimensionalUnits_t", letters)
    return join.name


def _angles(turn: np.ndarray) -> np.ndarray:
    """(3,) angles about x, y and z, in radians, whose turns one after the other make this one."""
    return Rotation.from_matrix(turn).as_euler("xyz")


# ---- reading


def joins_of(zones: Sequence[Node], blocks: Sequence[StructuredGrid]) -> list[Cut]:
    """Each join once, as the zone tells it whose name for it does not end in "donor"."""
    told, others = [], []
    for number, zone in enumerate(zones):
        for node in [node for group in zone.of("ZoneGridConnectivity_t") for node in group.children]:
            cut = None
            if node.label == _LABEL:
                cut = _cut(node, number, zones, blocks)
            elif node.label == "GridConnectivity_t" and is_point_by_point(node):
                cut = _cut_by_lists(node, number, zones, blocks)
            if cut is not None:
                told.append((node.name, _where_told(cut, node, blocks)))
            elif node.label in ("GridConnectivity_t", "OversetHoles_t"):
                others.append(node.name)
    warn_dropped("connections", others, "only those that join rectangles point by point are read")
    told.sort(key=lambda pair: pair[0].endswith(_DONOR))
    cuts: dict[frozenset, Cut] = {}
    for name, cut in told:
        plain = "" if _UNNAMED.fullmatch(name) else name
        cuts.setdefault(_pair(cut), replace(cut, name=plain))
    return list(cuts.values())


def _pair(cut: Cut) -> frozenset:
    """What both sides of a cut have in common."""
    sides = ((cut.block, cut.points), (cut.partner_block, cut.partner))
    return frozenset((block, *map(tuple, np.sort(points, axis=0).tolist())) for block, points in sides)


def _partner(node: Node, zones: Sequence[Node]) -> int:
    """The number of the zone that a connection leads to."""
    donor = node.text().rsplit("/", 1)[-1]
    partner = next((k for k, zone in enumerate(zones) if zone.name == donor), None)
    if partner is None:
        raise InvalidInput(f"the connection {node.name!r} leads to a zone {donor!r}, which the base lacks")
    return partner


def _cut(node: Node, number: int, zones: Sequence[Node], blocks: Sequence[StructuredGrid]) -> Cut:
    partner = _partner(node, zones)
    points = range_of(node.need("PointRange"), blocks[number])
    there = range_of(node.need("PointRangeDonor"), blocks[partner])
    return Cut(points, there, _transform(node), number, partner)


def _cut_by_lists(node: Node, number: int, zones: Sequence[Node], blocks: Sequence[StructuredGrid]) -> Cut | None:
    partner = _partner(node, zones)
    span = node.find("PointRange")
    if span is None:
        here = _indices(node.need("PointList"), blocks[number])
    else:
        here = _points_of_range(range_of(span, blocks[number]))
    there = _indices(node.need("PointListDonor"), blocks[partner])
    return cut_of_lists(here, there, blocks, number, partner) if len(here) else None


def _points_of_range(ends: Range) -> np.ndarray:
    """(m, 3) int: the points between two, i running fastest, as Fortran counts."""
    axes = [np.arange(a, b + (1 if b >= a else -1), 1 if b >= a else -1) for a, b in zip(*ends, strict=True)]
    return np.stack(np.meshgrid(*axes[::-1], indexing="ij")[::-1], axis=-1).reshape(-1, 3)


def _where_told(cut: Cut, node: Node, blocks: Sequence[StructuredGrid]) -> Cut:
    """The cut, turned and moved if the connection says so."""
    for group in node.of("GridConnectivityProperty_t"):
        for periodic in group.of("Periodic_t"):
            return _moved(cut, periodic, blocks)
    return cut


def _transform(node: Node) -> Index:
    """Three signed axes; those that the file leaves out are their own."""
    found = node.find("Transform")
    given = [] if found is None else found.whole(-1).tolist()
    if len(given) > 3:
        raise InvalidInput(f"{node.label} {node.name!r} has a transform of {len(given)} numbers")
    return as_index([*given, *(1, 2, 3)[len(given) :]])


def _moved(cut: Cut, periodic: Node, blocks: Sequence[StructuredGrid]) -> Cut:
    """The cut with its turn and shift, corrected by the points on its two sides."""
    centre, angles, shift = (_triple(periodic, name) for name in ("RotationCenter", "RotationAngle", "Translation"))
    place = cut.places()
    here = blocks[cut.block].points[tuple(place.T)]
    there = blocks[cut.partner_block].points[tuple(cut.across(place).T)]
    units = periodic.find("RotationAngle")
    degrees = units is not None and any("Degree" in str(node.value) for node in units.of("DimensionalUnits_t"))
    turn = Rotation.from_euler("xyz", angles, degrees=degrees).as_matrix()
    if angles.any():
        turn = _corrected(turn, here - here.mean(axis=0), there - there.mean(axis=0))
    moved = (there - here @ turn.T).mean(axis=0)
    coarse = shift + centre - centre @ turn.T
    reach = max(blocks[cut.block].diagonal, blocks[cut.partner_block].diagonal, float(np.abs(coarse).max()))
    if np.abs(moved - coarse).max() > 1e-4 * reach:
        raise InvalidInput(
            f"a periodic connection of zones {cut.block} and {cut.partner_block} does not map its points"
        )
    rotation = tuple(map(tuple, turn.tolist())) if angles.any() else None
    return replace(cut, rotation=rotation, translation=tuple(moved.tolist()))


def _corrected(turn: np.ndarray, here: np.ndarray, there: np.ndarray) -> np.ndarray:
    """The turn nearest to this one that takes points where their partners are, by two steps of Gauss and Newton.

    Points on a line leave turns about it open: the smallest step keeps what the file says of these.
    """
    for _ in range(2):
        x, y, z = (here @ turn.T).T
        zero = np.zeros_like(x)
        across = np.stack([[zero, z, -y], [-z, zero, x], [y, -x, zero]]).transpose(2, 0, 1).reshape(-1, 3)
        step = np.linalg.lstsq(across, (there - here @ turn.T).ravel(), rcond=1e-9)[0]
        turn = Rotation.from_rotvec(step).as_matrix() @ turn
    return turn


def _triple(node: Node, name: str) -> np.ndarray:
    """Three numbers, of which the file may have two."""
    value = node.need(name).value
    if not isinstance(value, np.ndarray) or value.dtype.kind not in "iuf" or value.size > 3:
        raise InvalidInput(f"{name} of a periodic connection needs three numbers")
    return np.append(value.ravel().astype(float), np.zeros(3 - value.size))
