"""What of a constrained triangulation is meshed: holes, regions, and their limits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import InvalidGeometry, InvalidInput
from ..geometry.plane import Plane
from ..mesh import Mesh
from . import _half_edge_query_kernels as queries
from .constrained import ConstrainedTriangulation, faces_of_points, levels, loose_ends

# Beyond this, not every whole number is a double.
_LARGEST_TAG = 2.0**53


@dataclass
class Seeds:
    """Points that mark holes and regions, in the plane of the boundary.

    Attributes
    ----------
    holes : (k, 2) float or None
        None: closed loops nest by the even-odd rule.
    regions : (k, 2) float
        A point in each region.
    tags : (k,) int
        Number of each region.
    max_areas : (k,) float
        Largest area of a triangle there; infinite where none is asked for.
    """

    holes: np.ndarray | None
    regions: np.ndarray
    tags: np.ndarray
    max_areas: np.ndarray


@dataclass
class Domain:
    """The faces to be meshed.

    Attributes
    ----------
    keep : (n_faces,) bool
        Whether a face is meshed.
    tag : (n_faces,) int
        Region that its triangles get.
    max_area : (n_faces,) float
        Largest area of a triangle.
    warnings : list of str
        Seeds that had no effect and the like.
    """

    keep: np.ndarray
    tag: np.ndarray
    max_area: np.ndarray
    warnings: list[str]


def collected_seeds(boundary: Mesh, holes: Any, regions: Any, plane: Plane, points: Mesh | None = None) -> Seeds:
    """Holes and regions as given, else as ``boundary.field_data`` has them, and those that ``points`` mark.

    Each point of ``points`` marks a hole, or, if there is a point array "tag" or "max_area", a region; in that case
    those mark holes whose point array "hole" is not zero.
    """
    if holes is None:
        holes = boundary.field_data.get("holes")
    if regions is None:
        regions = boundary.field_data.get("regions")
    if points is not None:
        holes, regions = _with_points(holes, regions, points, plane)
    if holes is not None:
        holes = _rows("holes", holes, (2, 3))
        holes = plane.to_plane(holes) if holes.shape[1] == 3 else holes
        holes = holes if len(holes) else None
    if regions is None:
        return Seeds(holes, np.empty((0, 2)), np.empty(0, np.int64), np.empty(0))
    regions = _rows("regions", regions, (2, 3, 4))
    number = np.arange(1.0, len(regions) + 1)
    tags = regions[:, 2] if regions.shape[1] > 2 else number
    if (tags != np.rint(tags)).any():
        raise InvalidInput(f"tags must be whole numbers, got {tags[tags != np.rint(tags)][0]:g}", parameter="regions")
    if (np.abs(tags) > _LARGEST_TAG).any():
        raise InvalidInput(
            f"tags must be within 2^53 of zero, got {tags[np.abs(tags).argmax()]:g}; give smaller ones",
            parameter="regions",
        )
    areas = np.full(len(regions), np.inf)
    if regions.shape[1] > 3:
        areas = np.where(regions[:, 3] > 0, regions[:, 3], np.inf)  # as in Triangle, no limit is written as -1
    return Seeds(holes, regions[:, :2], tags.astype(np.int64), areas)


def _with_points(holes: Any, regions: Any, points: Mesh, plane: Plane) -> tuple[Any, Any]:
    """Rows of holes and of regions, with those that the points of a mesh mark at the end."""
    if not isinstance(points, Mesh):
        raise InvalidInput(f"needs a Mesh of points, got {type(points).__name__}", parameter="seeds")
    values = {
        name: np.ravel(points.point_data[name]) for name in ("tag", "max_area", "hole") if name in points.point_data
    }
    for name, given in values.items():
        if len(given) != points.n_points or given.dtype.kind not in "iufb":
            raise InvalidInput(f"point array {name!r} needs one number a point", parameter="seeds")
    is_region = np.full(points.n_points, "tag" in values or "max_area" in values)
    if "hole" in values:
        is_region &= values["hole"] == 0
    at = plane.to_plane(points.points)
    more = np.column_stack(
        [at, values.get("tag", np.arange(1, len(at) + 1)), values.get("max_area", np.full(len(at), -1.0))]
    )
    more[np.isnan(more[:, 3]), 3] = -1.0
    old = _rows("holes", holes if holes is not None else [], (2, 3))
    old = plane.to_plane(old) if old.shape[1] == 3 else old
    given = _rows("regions", regions if regions is not None else [], (2, 3, 4))
    # Regions without tag count from 1, and those without limit have none.
    padding = np.column_stack([np.arange(1.0, len(given) + 1), np.full(len(given), -1.0)])
    given = np.column_stack([given, padding[:, given.shape[1] - 2 :]])
    return np.concatenate([old, at[~is_region]]), np.concatenate([given, more[is_region]])


def _rows(name: str, values: Any, widths: tuple[int, ...]) -> np.ndarray:
    try:
        rows = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InvalidInput(f"needs numbers, as a (k, {widths[-1]}) array: rows of one length", parameter=name) from None
    if rows.size == 0:
        return np.empty((0, widths[0]))
    if rows.ndim != 2 or rows.shape[1] not in widths:
        raise InvalidInput(
            f"needs shape (k, {' or '.join(map(str, widths))}), got {rows.shape}; one row a point", parameter=name
        )
    if not np.isfinite(rows).all():
        raise InvalidInput(f"row {np.flatnonzero(~np.isfinite(rows).all(axis=1))[0]} is not finite", parameter=name)
    return rows


def domain(mesh: ConstrainedTriangulation, seeds: Seeds, max_area: float, *, keep_hull: bool = False) -> Domain:
    """The faces that are meshed, with their regions.

    Parameters
    ----------
    mesh : ConstrainedTriangulation
        With all its faces.
    seeds : Seeds
        Holes and regions.
    max_area : float
        Largest area of a triangle.
    keep_hull : bool
        Mesh all of the convex hull but for the holes, whatever the loops enclose. A hole outside all loops then takes
        the outside away.

    Raises
    ------
    InvalidGeometry
        If nothing is enclosed, or holes leave nothing.
    """
    warnings: list[str] = []
    hole_faces = _faces_of(mesh, "hole", seeds.holes, keep_hull, warnings)
    region_faces = _faces_of(mesh, "region", seeds.regions, keep_hull, warnings)
    marked = np.flatnonzero(region_faces >= 0) if len(region_faces) else ()
    if seeds.holes is None and not keep_hull:
        keep = levels(mesh) == 1
        if len(marked):
            keep[region_faces[marked]] = True
    else:
        keep = np.ones(mesh.n_faces, bool)
        if len(hole_faces):
            keep[hole_faces[hole_faces >= 0]] = False
    if not keep_hull:
        keep[0] = False
    first = np.empty(mesh.n_faces, np.int64)
    count, outside = queries.first_lines(mesh.faces_beside, mesh.pieces, mesh.graph.line, keep, first)
    if not count and not keep[0]:
        _refuse(mesh)
    if outside:
        warnings.append(_lines_outside(mesh, keep))
    tag = np.zeros(mesh.n_faces, np.int64)
    limit = np.full(mesh.n_faces, max_area)
    if len(marked):
        faces, tags = region_faces[marked], seeds.tags[marked]
        tag[faces] = tags
        for k in np.flatnonzero((tag[faces] != tags) & (faces > (-1 if keep_hull else 0))):
            warnings.append(f"region {marked[k]} lies in one part with a later one, so its tag {tags[k]} has no effect")
        np.minimum.at(limit, faces, seeds.max_areas[marked])
    else:  # the parts count from 1 by the first line beside each
        tag[1:] = keep[1:]
        if count > 1:
            kept = np.flatnonzero(tag)
            tag[kept[np.argsort(first[kept], kind="stable")]] = np.arange(1, count + 1)
    return Domain(keep, tag, limit, warnings)


def _faces_of(
    mesh: ConstrainedTriangulation, name: str, points: np.ndarray | None, keep_hull: bool, warnings: list[str]
) -> np.ndarray:
    """(k,) int: the face of each seed, -1 outside the hull; warns of seeds without effect."""
    if points is None or not len(points):
        return np.empty(0, np.int64)
    faces = faces_of_points(mesh, points, f"{name}s")
    for k in np.flatnonzero(faces < (0 if keep_hull else 1)):
        warnings.append(f"{name} {k} at ({points[k, 0]:.6g}, {points[k, 1]:.6g}) lies outside and has no effect")
    return faces


def _lines_outside(mesh: ConstrainedTriangulation, keep: np.ndarray) -> str:
    """The warning of lines with nothing that is meshed beside them."""
    lines = np.unique(mesh.line[~keep[mesh.faces_beside].any(axis=0)])
    more = "; the outline may be open" if len(loose_ends(mesh.graph)) else ""
    return f"{len(lines)} lines lie outside what is meshed, the first is line {lines[0]}{more}"


def _refuse(mesh: ConstrainedTriangulation) -> None:
    graph = mesh.graph
    ends = loose_ends(graph)
    places = ", ".join(f"({x:.6g}, {y:.6g})" for x, y in graph.points[ends[:4]])
    is_open = f"the outline is open, with {len(ends)} loose ends, at {places}{', ...' * (len(ends) > 4)}; close it"
    if mesh.n_faces > 1:
        raise InvalidGeometry(
            "the hole points leave nothing to mesh; "
            + (f"{is_open}, or move them" if len(ends) else "move or remove them"),
            parameter="holes",
        )
    raise InvalidGeometry(
        f"encloses no area: {is_open}",
        parameter="boundary",
        points=graph.source[ends[graph.source[ends] >= 0]],
        cells=np.unique(graph.line[np.isin(graph.segments, ends).any(axis=1)]),
    )
