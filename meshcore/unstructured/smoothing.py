"""Guarded smoothing: better triangles by moving points inside, with a mesh that stays valid and Delaunay."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from .. import quality
from ..errors import InvalidGeometry, InvalidInput
from ..geometry import predicates
from ..geometry.location import Locator
from ..geometry.plane import Plane, fitted_plane
from ..mesh import Mesh
from ..mesh.topology import edge_keys
from ..operation import Param, Port, operation
from ..progress import Progress, advance, part_of, silent
from ..report import Report, Result
from . import _half_edge_kernels as half_edges
from . import _smoothing_kernels as kernels
from .planar_graph import NOTHING
from .triangulation import Scratch

_KINDS = ("triangle", "line", "vertex")
_VERTICES_A_CHUNK = 100_000
_EDGES_A_CHUNK = 1_000_000
# Stars with a smaller angle are searched for the best place, others see the mean of their neighbours only.
_POOR_ANGLE = 42.0
# Stars without a smaller angle than this are good as they are: half of the work for a ten-thousandth of the mean shape.
_GOOD_ANGLE = 55.0
_MODEST_EXPONENT = 150


@operation("Smoothing", category="Unstructured")
def smoothed(
    mesh: Annotated[Mesh, Port("Triangles in a plane; lines and vertices among the cells stay", cells=("triangle",))],
    *,
    rounds: Annotated[int, Param("How often each point is looked at", min=1, soft_max=10)] = 3,
    fixed: Annotated[str, Param("Point array: points where it is not zero stay; empty fixes none", array=True)] = "",
    progress: Progress = silent,
) -> Result:
    """Move the points inside so that triangles get better, without ever making the smallest angle smaller.

    Each round looks at every free point: it goes to the mean of its neighbours if the smallest angle around it grows by
    that; where angles stay poor, to the best place nearby. Then edges are flipped to Delaunay. Laplacian smoothing may
    turn triangles over where the points around make no convex polygon; here such a move is refused:

    ::

            *                      the mean of the neighbours of o lies in the
           / \\  *                  notch between them, outside their polygon
          /   \\/ \\
         *--o     *

    Points on the outline, on line cells, and between parts that differ in a set or in a cell array of whole numbers
    (such as "region") stay where they are, and those lines stay edges. In a mesh that was not Delaunay, flips alone
    make the angles larger.

    Parameters
    ----------
    mesh : Mesh
        "triangle" cells in one plane, also "line" and "vertex" ones.
    rounds : int
        Two to five are usual.
    fixed : str
        Name of a point array; points where it is not zero stay.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Result
        As many points and triangles as before, in their order; flipped triangles have other corners. Point data of
        floating-point numbers are interpolated at the new places, others stay. Cell arrays of whole numbers and sets
        stay true; those of floating-point numbers are left out with a warning where triangles changed.
        `Report.counts` tells how many points moved, and how many edges were flipped.

    Raises
    ------
    InvalidInput
        If there are no triangles, cells of other kinds, or no such array.
    InvalidGeometry
        If triangles do not lie in one plane, are not positively oriented, overlap, or do not conform.

    References
    ----------
    Survey, section 3.2.6. L. A. Freitag, "On combining Laplacian and optimization-based mesh smoothing techniques",
    AMD-220 (1997). N. Amenta, M. Bern, D. Eppstein, "Optimal point placement for mesh smoothing", J. Algorithms 30
    (1999).

    Examples
    --------
    >>> from meshcore.gallery import square_with_hole
    >>> from meshcore.unstructured import delaunay_refinement
    >>> rough, before = delaunay_refinement(square_with_hole(), size=0.1, placement="off-centre")
    >>> mesh, after = smoothed(rough, rounds=5)
    >>> before.quality["smallest angle (degree)"] < 40 < after.quality["smallest angle (degree)"]
    True
    """
    _check_kinds(mesh)
    stays = _fixed(mesh, fixed)
    exponent = int(np.frexp(np.abs(mesh.points).max())[1])
    if abs(exponent) > _MODEST_EXPONENT:  # squares of lengths would over- or underflow
        near_one = mesh.with_points(np.ldexp(mesh.points, -exponent))
        result, report = _smoothed(near_one, stays, rounds, progress)
        return Result(result.with_points(np.ldexp(result.points, exponent)), report)
    return _smoothed(mesh, stays, rounds, progress)


def _smoothed(mesh: Mesh, stays: np.ndarray, rounds: int, progress: Progress) -> Result:
    """The same of modest coordinates."""
    advance(progress, 0.0, "checking the mesh")
    plane = fitted_plane(mesh.points[np.unique(mesh.cells["triangle"])], parameter="mesh")
    _check_geometry(mesh)
    flat = plane.to_plane(mesh.points)
    flat = np.where(np.abs(flat) < NOTHING * np.abs(flat).max(), 0.0, flat)
    turned = _is_turned(flat, mesh.cells["triangle"])
    flat = flat[:, ::-1] if turned else flat
    _check_orientation(flat, mesh)
    half = _half_edges(mesh, flat, stays)
    moved, flips = smooth_in_place(half, rounds, part_of(progress, 0.1, 0.9))
    advance(progress, 0.9, "checking the mesh")
    result, warnings = _rebuilt(mesh, plane, half, flat, turned)
    quality.validate(result, mesh if len(mesh.get("line")) else None)
    return Result(
        result,
        Report(
            counts={
                "points": result.n_points,
                "triangles": len(result.cells["triangle"]),
                "points moved": moved,
                "edges flipped": flips,
            },
            iterations=rounds,
            quality=quality.summary(result),
            warnings=warnings,
        ),
    )


@dataclass
class HalfEdges:
    """A mesh to be smoothed in place, as `_half_edge_kernels` lays it out, without ghosts.

    Attributes
    ----------
    xy : (2 * n,) float
        Coordinates, safe for exact predicates.
    origin, twin, piece_of : (4 * m,) int32
        Half-edges; constrained ones stay, and so do their ends.
    n_vertices, n_triangles : int
        How much of the arrays is in use.
    fixed : (n,) uint8
        1 for further vertices that stay.
    edge_limit : (m,) float
        Squared longest edge that each triangle may have; empty for no limits.
    face : (m,) int32
        Face of each triangle.
    area_limit : (f,) float
        Twice the largest area of a triangle in each face; empty for no limits.
    scratch : Scratch
        Buffers.
    exponent : int
        Coordinates are scaled by two to this power.
    is_delaunay : bool
        Whether the mesh is known to be constrained Delaunay.
    """

    xy: np.ndarray
    origin: np.ndarray
    twin: np.ndarray
    piece_of: np.ndarray
    n_vertices: int
    n_triangles: int
    fixed: np.ndarray
    edge_limit: np.ndarray
    face: np.ndarray
    area_limit: np.ndarray
    scratch: Scratch
    exponent: int = 0
    is_delaunay: bool = False


def smooth_in_place(mesh: HalfEdges, rounds: int, progress: Progress) -> tuple[int, int]:
    """Smooth and flip in turn; the number of vertices that moved at all, and of flips."""
    n = mesh.n_vertices
    vertex_edge = np.full(n, -1, np.int32)
    reach2 = np.full(n if len(mesh.edge_limit) else 0, np.inf)
    kernels.link(mesh.origin, mesh.twin, mesh.n_triangles, mesh.edge_limit, mesh.fixed, reach2, vertex_edge)
    before = mesh.xy[: 2 * n].copy()
    poor, good = np.sin(np.radians([_POOR_ANGLE, _GOOD_ANGLE])) ** 2
    ring = np.empty(2 * kernels.MOST_NEIGHBOURS + 2)
    around = np.empty(kernels.MOST_NEIGHBOURS + 1, np.int32)
    restless = np.ones(n, np.uint8)
    flips = 0
    if not mesh.is_delaunay:
        flips = _flip(mesh, vertex_edge, np.ones(n, np.uint8), restless, part_of(progress, 0.0, 0.5 / (rounds + 0.5)))
    for round_ in range(rounds):
        step = part_of(progress, (round_ + 0.5) / (rounds + 0.5), (round_ + 1.5) / (rounds + 0.5))
        count, moved = 0, np.zeros(n, np.uint8)
        for first in range(0, n, _VERTICES_A_CHUNK):
            advance(step, 0.5 * first / n, f"smoothing, round {round_ + 1} of {rounds}")
            count += kernels.smooth(
                mesh.xy, mesh.origin, mesh.twin, mesh.face, vertex_edge, mesh.fixed, restless, moved, reach2,
                mesh.area_limit, poor, good, ring, around, mesh.scratch.work, first, min(first + _VERTICES_A_CHUNK, n),
            )  # fmt: skip
        flips += _flip(mesh, vertex_edge, moved, restless, part_of(step, 0.5, 1.0))
        if not count:
            break
    changed = (mesh.xy[: 2 * n] != before).reshape(-1, 2).any(axis=1)
    return int(changed.sum()), flips


def _flip(mesh: HalfEdges, vertex_edge: np.ndarray, moved: np.ndarray, restless: np.ndarray, progress: Progress) -> int:
    """Make the mesh constrained Delaunay around moved vertices; the number of flips."""
    state = np.zeros(3, np.int64)
    status = half_edges.MORE
    while status != half_edges.DONE:
        advance(progress, state[kernels.TRIANGLE] / max(mesh.n_triangles, 1), "flipping edges")
        status = kernels.flip_to_delaunay(
            mesh.xy, mesh.origin, mesh.twin, mesh.piece_of, vertex_edge, mesh.n_triangles, moved, restless,
            mesh.scratch.stack, mesh.scratch.work, state, _EDGES_A_CHUNK,
        )  # fmt: skip
        if status == half_edges.FULL:
            mesh.scratch.grow()
    return int(state[kernels.FLIPS])


def _check_kinds(mesh: Mesh) -> None:
    if not isinstance(mesh, Mesh):
        raise InvalidInput(f"needs a Mesh of triangles, got {type(mesh).__name__}", parameter="mesh")
    others = [kind for kind, cells in mesh.cells.items() if kind not in _KINDS and len(cells)]
    if others:
        raise InvalidInput(f"smooths triangles only, got {', '.join(others)}; split these first", parameter="mesh")
    if not len(mesh.get("triangle")):
        raise InvalidInput(f"needs triangles, got {mesh!r}", parameter="mesh")


def _fixed(mesh: Mesh, name: str) -> np.ndarray:
    """(n,) uint8: 1 for points that the named array and "vertex" cells fix."""
    stays = np.zeros(mesh.n_points, np.uint8)
    stays[mesh.get("vertex").ravel()] = 1
    if name:
        if name not in mesh.point_data:
            known = ", ".join(mesh.point_data) or "none"
            raise InvalidInput(f"is no point array of the mesh: {name!r}; there are: {known}", parameter="fixed")
        values = mesh.point_data[name]
        if values.ndim != 1:
            raise InvalidInput(f"{name!r} must have one value a point, got {values.shape}", parameter="fixed")
        stays[values != 0] = 1
    return stays


def _check_geometry(mesh: Mesh) -> None:
    """Refuse what is no mesh, before anything is moved."""
    faults = quality.validate(mesh, raise_=False)
    if faults:
        raise InvalidGeometry(
            f"is no valid mesh: {faults[0]}; repair it first",
            parameter="mesh",
            cells=faults[0].cells,
            points=faults[0].points,
        )


def _is_turned(flat: np.ndarray, triangles: np.ndarray) -> bool:
    """Whether the plane's own normal looks away from the triangles' upper side; all have the same by now."""
    a, b, c = flat[triangles].transpose(1, 0, 2)
    return bool(((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]).sum() < 0)


def _check_orientation(flat: np.ndarray, mesh: Mesh) -> None:
    """Refuse what projection onto the fitted plane turned over."""
    bad = np.flatnonzero(predicates.orient2d(*flat[mesh.cells["triangle"]].transpose(1, 0, 2)) <= 0)
    if len(bad):
        where = next(where for kind, _, where in mesh.blocks() if kind == "triangle")
        raise InvalidGeometry(
            f"has triangles without area in its plane, the first is cell {where.start + bad[0]}; remove them",
            parameter="mesh",
            cells=where.start + bad,
        )


def _half_edges(mesh: Mesh, flat: np.ndarray, stays: np.ndarray) -> HalfEdges:
    """The mesh's triangles as half-edges, constrained on outline, lines and interfaces."""
    triangles = mesh.cells["triangle"]
    n, m = mesh.n_points, len(triangles)
    origin = np.zeros((m, 4), np.int32)
    origin[:, :3] = triangles
    twin = np.full((m, 4), -1, np.int32)
    twin[:, 3] = 0
    edge = (4 * np.arange(m)[:, None] + np.arange(3)).ravel()
    key = edge_keys(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=-1), n).ravel()
    order = np.argsort(key, kind="stable")
    pair = np.flatnonzero(key[order][1:] == key[order][:-1])
    one, other = edge[order[pair]], edge[order[pair + 1]]
    flat_twin = twin.ravel()
    flat_twin[one], flat_twin[other] = other, one
    held = twin[:, :3].ravel() < 0
    held |= np.isin(key, edge_keys(mesh.get("line"), n))
    part = _parts(mesh)
    held |= part[edge >> 2] != part[np.maximum(flat_twin[edge], 0) >> 2]
    held = held.reshape(m, 3)
    origin[:, 3] = held[:, 0] | (held[:, 1] << 1) | (held[:, 2] << 2)
    scaled, exponent = predicates.rescaled(flat)
    return HalfEdges(
        scaled.ravel().copy(),
        origin.ravel(),
        flat_twin,
        np.full(4 * m, -1, np.int32),
        n,
        m,
        stays,
        np.empty(0),
        np.zeros(m, np.int32),
        np.empty(0),
        Scratch(),
        exponent,
    )


def _parts(mesh: Mesh) -> np.ndarray:
    """(m,) int: a number for each triangle, equal where all whole-number arrays and all sets agree."""
    where = next(where for kind, _, where in mesh.blocks() if kind == "triangle")
    columns = [
        values[where].reshape(len(mesh.cells["triangle"]), -1)
        for values in mesh.cell_data.values()
        if values.dtype.kind in "iub"
    ]
    for members in mesh.sets.values():
        inside = np.zeros(mesh.n_cells, np.int64)
        inside[members] = 1
        columns.append(inside[where][:, None])
    part = np.zeros(len(mesh.cells["triangle"]), np.int64)
    for column in (c for block in columns for c in block.T):
        _, level = np.unique(column, return_inverse=True)
        _, part = np.unique(part * (int(level.max()) + 1) + level, return_inverse=True)
    return part


def _rebuilt(mesh: Mesh, plane: Plane, half: HalfEdges, old: np.ndarray, turned: bool) -> tuple[Mesh, list[str]]:
    """The smoothed mesh with what data remain true, and warnings about those that do not."""
    flat = np.ldexp(half.xy.reshape(-1, 2), -half.exponent)
    moved = (flat != old).any(axis=1)
    flat = flat[:, ::-1] if turned else flat
    points = mesh.points.copy()
    points[moved] = plane.to_space(flat[moved])
    triangles = half.origin.reshape(-1, 4)[:, :3].astype(np.int64)
    changed = (triangles != mesh.cells["triangle"]).any() or moved.any()
    point_data = dict(mesh.point_data)
    floating = [name for name, values in point_data.items() if values.dtype.kind == "f"]
    if floating and moved.any():
        locator = Locator(Mesh(mesh.points, {"triangle": mesh.cells["triangle"]}))
        for name in floating:
            values = point_data[name].copy()
            values[moved] = locator.interpolated(values, points[moved])
            point_data[name] = values
    stale = [name for name, values in mesh.cell_data.items() if values.dtype.kind not in "iub"] if changed else []
    cell_data = {name: values for name, values in mesh.cell_data.items() if name not in stale}
    warnings = [f"cell array {name!r} is left out: its values belong to the triangles as they were" for name in stale]
    cells = {**mesh.cells, "triangle": triangles}
    return Mesh(points, cells, point_data, cell_data, mesh.sets, mesh.field_data), warnings
