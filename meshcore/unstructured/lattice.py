"""Lattice fill: where limits alone drive the size, points of a triangular lattice inside, lines divided evenly."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..errors import InvalidGeometry, InvalidInput
from ..progress import Progress
from . import _lattice_kernels as kernels
from .constrained import ConstrainedTriangulation, constrained
from .domain import Domain
from .planar_graph import divided_graph
from .refiner import acute_vertices, expected_triangles

STEEPEST = 31.0
"""Smallest angle, in degrees, up to which refinement comes to an end beside a lattice; from 32 on it may flood it."""

# Area of the lattice's triangles per largest area, its edges per largest edge: what is left for shaken triangles.
_SHARE_OF_AREA = 0.97
_SHARE_OF_SIZE = 0.97
# Sites nearer to a line than this, per spacing, are left out. A line's points are a spacing apart, so a site that is
# 0.62 from them stays outside the lens of 30 degrees over each part, 0.29 high.
_CLEARANCE = 0.62
_SHAKE = 1e-5
# More sites in the bounding box than this, for each triangle expected, means that the domain fills little of it.
_SITES_A_TRIANGLE = 20
_FEW_SITES = 1_000_000


class Filled(NamedTuple):
    """A domain with a lattice in it.

    Attributes
    ----------
    mesh : ConstrainedTriangulation
        Of divided lines and the sites.
    parts : Domain
        The same faces, as the new triangulation numbers them.
    on_lines, inside : int
        Points added.
    """

    mesh: ConstrainedTriangulation
    parts: Domain
    on_lines: int
    inside: int


def filled(
    mesh: ConstrainedTriangulation, parts: Domain, size: float, progress: Progress, *, worthwhile: bool = False
) -> Filled | None:
    """Divide the lines and fill the faces that have a limit with a lattice, in one triangulation.

    Lines that end in an acute corner are left to refinement, which knows where such are split.

    Parameters
    ----------
    mesh : ConstrainedTriangulation
        Stays as it is.
    parts : Domain
        What is meshed, and its limits.
    size : float
        Largest edge length, possibly infinite.
    progress : Progress
        Called with fraction and message.
    worthwhile : bool
        Whether to answer None where a lattice is of little use, with fewer sites than points on lines, or where lines
        are too near each other to be divided evenly.

    Returns
    -------
    Filled or None
        None if no site fits in.

    Raises
    ------
    InvalidInput
        If there are no limits, or they would make too many triangles.
    InvalidGeometry
        If divided lines cross by rounding, unless it has to be worthwhile.
    """
    if np.isinf(size) and np.isinf(parts.max_area[parts.keep]).all():
        if worthwhile:
            return None
        raise InvalidInput("a lattice needs size, max_area or an area in regions", parameter="placement")
    expected_triangles(mesh, parts, size)  # refuses too many
    spacing = np.where(parts.keep, _spacing(parts.max_area, size), np.inf)
    spacing[spacing > np.ptp(mesh.graph.points, axis=0).max()] = np.inf  # then no site fits in
    left, right = mesh.faces_beside
    wanted = np.minimum(spacing[left], spacing[right])
    ends = mesh.triangulation.order[mesh.pieces[:, :2]]
    points = mesh.graph.points
    length = np.hypot(*(points[ends[:, 1]] - points[ends[:, 0]]).T)
    count = np.maximum(np.ceil(length / wanted - 1e-9), 1).astype(np.int64)
    owner, places = _division(points, ends, count)
    sites = []
    for h in np.unique(spacing[np.isfinite(spacing)]):
        inside = spacing == h
        beside = inside[left] | inside[right]
        border = inside[left] != inside[right]
        near = np.concatenate([places[beside[owner]], points[ends[beside].ravel()]])
        outward = np.where(inside[left[border]], 1.0, -1.0)
        found = _sites(points[ends[border]], outward, near, float(h))
        if found is None:
            return None
        sites.append(found)
    if not sites:
        return None
    sites = np.concatenate(sites)
    acute = acute_vertices(mesh.triangulation).astype(bool)
    whole = acute[mesh.pieces[:, 0]] | acute[mesh.pieces[:, 1]]
    if not len(sites) or (worthwhile and len(sites) < len(places) + len(points)):
        return None
    on_lines = places[~whole[owner]]
    new = np.concatenate([on_lines, sites])
    graph, parent = divided_graph(mesh.graph, ends, mesh.line, np.where(whole, 1, count), new)
    try:
        fine = constrained(graph, split_crossings=False, parameter="boundary", progress=progress)
    except InvalidGeometry:  # lines so near each other that rounding made their parts cross
        if worthwhile:
            return None
        raise
    return Filled(fine, _same_faces(fine, parts, left[parent], right[parent]), len(on_lines), len(sites))


def _spacing(max_area: np.ndarray, size: float) -> np.ndarray:
    """Spacing of a lattice that keeps within the limits."""
    return np.minimum(np.sqrt(_SHARE_OF_AREA * max_area * 4 / np.sqrt(3)), _SHARE_OF_SIZE * size)


def _division(points: np.ndarray, ends: np.ndarray, count: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places that divide each piece into ``count`` equal parts, in order, and the piece of each."""
    owner = np.repeat(np.arange(len(count)), count - 1)
    step = np.arange(len(owner)) - np.repeat(np.cumsum(count - 1) - (count - 1), count - 1) + 1
    a, b = points[ends[owner, 0]], points[ends[owner, 1]]
    return owner, a + (step / count[owner])[:, None] * (b - a)


def _sites(ends: np.ndarray, outward: np.ndarray, near: np.ndarray, h: float) -> np.ndarray | None:
    """(k, 2) float: lattice sites within closed lines, clear of the places ``near``; None if there are far too many.

    ``outward`` is 1 for lines with the inside on their left, -1 for others.
    """
    (ax, ay), (bx, by) = ends[:, 0].T, ends[:, 1].T
    low, high = ends.min(axis=(0, 1)), ends.max(axis=(0, 1))
    dy = h * np.sqrt(0.75)
    # Off the corners, so that no row runs along a line by chance.
    x0, y0 = low + (0.25 * h, 0.4 * dy)
    columns, rows = np.ceil((high - low) / (h, dy)) + 1
    expected = float((outward * (ax * by - bx * ay)).sum()) / (h * dy)
    if columns * rows > _SITES_A_TRIANGLE * expected + _FEW_SITES:
        return None
    columns, rows = int(columns), int(rows)
    blocked = np.zeros(rows * columns, np.uint8)
    kernels.block_sites(near, _CLEARANCE * h, x0, y0, h, dy, columns, blocked)
    start = np.zeros(rows + 1, np.int64)
    flat = np.ascontiguousarray(ends.reshape(-1, 4))
    kernels.count_crossings(flat, y0, dy, start)
    np.cumsum(start, out=start)
    x = np.empty(start[-1])
    kernels.fill_crossings(flat, y0, dy, start[:-1].copy(), x)
    x = x[np.lexsort((x, np.repeat(np.arange(rows), np.diff(start))))]
    sites = np.empty((int((blocked == 0).sum()), 2))
    count = kernels.take_sites(start, x, x0, y0, h, dy, columns, blocked, _SHAKE * h, sites)
    return sites[:count]


def _same_faces(fine: ConstrainedTriangulation, parts: Domain, left: np.ndarray, right: np.ndarray) -> Domain:
    """The domain with its faces as the new triangulation numbers them, known by the faces beside each segment."""
    old = np.zeros(fine.n_faces, np.int64)
    for new_side, side in zip(fine.faces_beside, (left, right), strict=True):
        old[new_side] = side[fine.pieces[:, 2]]
    return replace(parts, keep=parts.keep[old], tag=parts.tag[old], max_area=parts.max_area[old])
