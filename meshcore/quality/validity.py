"""Validity of a mesh: what every generator's result must pass before it is handed out."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..errors import GenerationFailed, InvalidInput
from ..mesh import CELL_TYPES, Mesh, StructuredGrid
from . import _edge_kernels as edge_kernels
from . import _repeat_kernels as repeat_kernels
from . import embedding
from .block import is_sound
from .given import as_mesh
from .kept import missing_segments, same_points
from .keys import cell_keys, directed_edges, directed_faces, repeats
from .orientation import positive

_NONE = np.empty(0, np.int64)


@dataclass(frozen=True, eq=False)
class Fault:
    """One kind of fault of a mesh.

    Attributes
    ----------
    name : str
        "empty", "orientation", "conformity", "orphan points", "duplicate points", "repeated cells",
        "hanging nodes", "overlap" or "boundary".
    message : str
        What, how many, and where the first is.
    cells, points : (k,) int
        The cells and points at fault; for "boundary" the cells are those of the boundary.
    """

    name: str
    message: str
    cells: np.ndarray = field(default_factory=lambda: _NONE)
    points: np.ndarray = field(default_factory=lambda: _NONE)

    def __str__(self) -> str:
        return self.message


def validate(mesh: Mesh | StructuredGrid, boundary: Mesh | None = None, *, raise_: bool = True) -> list[Fault]:
    """Check that a mesh is one: positive cells, matching facets, nothing twice, nothing astray, boundary kept.

    - Each cell is positively oriented: exactly in the plane and for tetrahedra, at every corner for quads and other
      solids. Cells of a surface in space need an area and no fold.
    - A facet belongs to at most two cells, which see it from opposite sides.
    - No points without cells, no two points at one place, no two cells with the same nodes.
    - In the plane: no point on the inside of an edge, no part of the mesh over another.
    - Each line of ``boundary`` is an edge of the mesh, or several in a row.

    A `StructuredGrid` conforms by its nature and may have cuts where points coincide, so its cells alone are judged.

    Parameters
    ----------
    mesh : Mesh or StructuredGrid
        Curved cells are judged by their corner nodes.
    boundary : Mesh, optional
        "line" cells that must be kept; points are matched by exact coordinates.
    raise_ : bool
        Whether to raise at the first call that finds faults, or to return them.

    Returns
    -------
    list of Fault
        Empty if the mesh is valid.

    Raises
    ------
    GenerationFailed
        Names each kind of fault, how many there are and where; `cells` has their numbers, `partial` the mesh.
    InvalidInput
        If ``boundary`` has no line cells.

    References
    ----------
    Survey, sections 1.2 and 3.1: validity and conformity of meshes.

    Examples
    --------
    >>> from meshcore import Mesh
    >>> points = [[0, 0], [1, 0], [1, 1], [0, 1]]
    >>> validate(Mesh(points, {"triangle": [[0, 1, 2], [0, 2, 3]]}))
    []
    >>> print(*validate(Mesh(points, {"triangle": [[0, 1, 2], [0, 3, 2]]}), raise_=False)[:1])
    1 cell is not positively oriented: cell 1 at (0.333333, 0.666667, 0)
    """
    if boundary is not None and not len(boundary.get("line")):
        raise InvalidInput(f"needs line cells, got {boundary!r}", parameter="boundary")
    if boundary is None and is_sound(mesh):
        return []
    examined = _Examined(as_mesh(mesh))
    checks = (_orientation,) if isinstance(mesh, StructuredGrid) else _CHECKS
    faults = [fault for check in checks for fault in check(examined)]
    if boundary is not None:
        faults += _boundary(examined, boundary)
    if faults and raise_:
        cells = [fault.cells for fault in faults if fault.name != "boundary"]
        raise GenerationFailed(
            "; ".join(map(str, faults)), cells=np.unique(np.concatenate([_NONE, *cells])), partial=mesh
        )
    return faults


@dataclass(frozen=True, eq=False)
class _Examined:
    """A mesh and what several checks need of it, computed once."""

    mesh: Mesh

    @cached_property
    def plane(self) -> np.ndarray | None:
        """(n, 2) float: coordinates in the plane of a planar mesh of dimension 2, cells counter-clockwise there."""
        mesh = self.mesh
        if mesh.dimension != 2:
            return None
        flat = np.flatnonzero(mesh.bounds[0] == mesh.bounds[1])
        if len(flat):
            axis = flat[-1]
            # A slice is copied faster than chosen columns.
            plane = mesh.points[:, :2] if axis == 2 else mesh.points[:, [(axis + 1) % 3, (axis + 2) % 3]]
            plane = np.ascontiguousarray(plane)
            # The plane z = 0 has an upper side; any other plane is seen from where most of the mesh is positive.
            return plane if mesh.is_planar or _signed_area(mesh, plane) > 0 else plane[:, ::-1]
        centred = mesh.points - mesh.points.mean(axis=0)
        _, axes = np.linalg.eigh(centred.T @ centred)
        if np.abs(centred @ axes[:, 0]).max() > 1e-9 * mesh.diagonal:
            return None
        plane = centred @ axes[:, 1:]
        return plane if _signed_area(mesh, plane) > 0 else plane[:, ::-1]

    @cached_property
    def rounding(self) -> float:
        """Length below which a distance in the plane is rounding."""
        bounds = self.mesh.bounds
        scale = float(np.abs(bounds).max())
        exact = (bounds[0] == bounds[1]).any()
        return (4 if exact else 64) * np.finfo(float).eps * scale

    @cached_property
    def edge_keys(self) -> np.ndarray:
        """(k,) int64: `directed_edges`."""
        return directed_edges(self.mesh)

    @cached_property
    def boundary_edges(self) -> np.ndarray:
        """(b, 2) int: edges of one cell, as the cell runs along them."""
        room = 1 << 16
        while True:
            edges = np.empty((room, 2), np.int64)
            count = edge_kernels.unmatched_edges(self.edge_keys, self.mesh.n_points, edges)
            if count <= room:
                return edges[:count]
            room = count

    @cached_property
    def orientation(self) -> np.ndarray:
        """(number of cells,) bool: `positive`."""
        return positive(self.mesh, self.plane)

    @cached_property
    def conforming(self) -> bool:
        """Whether no facet has more than two cells, nor two on one side."""
        if self.mesh.dimension < 2:
            return True  # lines may branch: a planar straight-line graph does
        keys = self.edge_keys if self.mesh.dimension == 2 else directed_faces(self.mesh)
        return not (keys[1:] == keys[:-1]).any()

    def cells_with(self, edges: np.ndarray) -> np.ndarray:
        """(k,) int: for each directed edge, a cell that runs along it."""
        wanted, asked = np.unique(edges[:, 0] * self.mesh.n_points + edges[:, 1], return_inverse=True)
        owner = np.full(len(wanted), -1)
        starts = np.zeros(self.mesh.n_points, bool)
        starts[edges[:, 0]] = True
        for kind, cells, where in self.mesh.blocks():
            if CELL_TYPES[kind].dimension == 2:
                corners = len(CELL_TYPES[kind].edges)
                repeat_kernels.cells_along(cells, corners, self.mesh.n_points, starts, wanted, owner, where.start)
        return owner[asked]


def _signed_area(mesh: Mesh, plane: np.ndarray) -> float:
    """Sum of the signed areas of the cells of dimension 2."""
    total = 0.0
    for kind, cells in mesh.cells.items():
        if CELL_TYPES[kind].dimension == 2:
            x, y = plane[cells[:, : len(CELL_TYPES[kind].edges)]].transpose(2, 1, 0)
            total += float((x * np.roll(y, -1, axis=0) - y * np.roll(x, -1, axis=0)).sum())
    return total


def _many(count: int, one: str, several: str = "") -> str:
    return f"{count} {one}" if count == 1 else f"{count:,} {several or one + 's'}"


def _at(place: np.ndarray) -> str:
    return "(" + ", ".join(f"{float(v):.6g}" for v in place) + ")"


def _cell_at(mesh: Mesh, cell: int) -> str:
    return f"cell {int(cell)} at {_at(mesh.centroids[cell])}"


def _empty(examined: _Examined) -> Iterator[Fault]:
    if not examined.mesh.n_cells:
        yield Fault("empty", "the mesh has no cells")


def _orientation(examined: _Examined) -> Iterator[Fault]:
    bad = np.flatnonzero(~examined.orientation)
    if len(bad):
        what = _many(len(bad), "cell is", "cells are")
        yield Fault("orientation", f"{what} not positively oriented: {_cell_at(examined.mesh, bad[0])}", bad)


def _conformity(examined: _Examined) -> Iterator[Fault]:
    mesh = examined.mesh
    if examined.conforming:
        return
    nodes, owner, neighbour, shared = mesh.facets
    crowded = np.flatnonzero(shared > 2)
    if len(crowded):
        cells = np.unique(np.concatenate([owner[crowded], neighbour[crowded]]))
        what = _many(len(crowded), "facet belongs", "facets belong")
        yield Fault("conformity", f"{what} to more than two cells: {_cell_at(mesh, cells[0])}", cells)
    pairs = np.flatnonzero(shared == 2)
    same = pairs[_same_side(mesh, nodes[pairs], neighbour[pairs])]
    if len(same):
        cells = np.unique(np.concatenate([owner[same], neighbour[same]]))
        what = _many(len(same), "facet is", "facets are")
        yield Fault("conformity", f"{what} seen from the same side by two cells: {_cell_at(mesh, cells[0])}", cells)


def _same_side(mesh: Mesh, nodes: np.ndarray, neighbour: np.ndarray) -> np.ndarray:
    """(k,) bool: whether the neighbour of a facet runs around it as the owner does."""
    forward = {tuple(np.roll(row[row >= 0], -k).tolist()) for row in nodes for k in range((row >= 0).sum())}
    kinds = [(kind, cells, where) for kind, cells, where in mesh.blocks()]
    same = np.zeros(len(nodes), bool)
    for k, cell in enumerate(neighbour.tolist()):
        kind, cells, where = next(b for b in kinds if b[2].start <= cell < b[2].stop)
        wanted = set(nodes[k][nodes[k] >= 0].tolist())
        for local in CELL_TYPES[kind].facets:
            facet = tuple(cells[cell - where.start, list(local)].tolist())
            same[k] |= set(facet) == wanted and facet in forward
    return same


def _orphans(examined: _Examined) -> Iterator[Fault]:
    used = np.zeros(examined.mesh.n_points, bool)
    for cells in examined.mesh.cells.values():
        repeat_kernels.mark_used(cells, used)
    bad = np.flatnonzero(~used)
    if len(bad):
        what = _many(len(bad), "point belongs", "points belong")
        yield Fault(
            "orphan points", f"{what} to no cell: point {bad[0]} at {_at(examined.mesh.points[bad[0]])}", points=bad
        )


def _duplicates(examined: _Examined) -> Iterator[Fault]:
    points = examined.mesh.points
    bits = max(len(points), 1).bit_length() + 1
    repeated = np.zeros(len(points), bool)
    table = np.full(1 << bits, -1, np.int32)
    count = repeat_kernels.repeated_points(points.view(np.uint64), 64 - bits, table, repeated)
    bad = np.flatnonzero(repeated) if count else _NONE
    if len(bad):
        place = points[bad[0]]
        yield Fault("duplicate points", f"{len(bad):,} points share their places with others: {_at(place)}", points=bad)


def _repeated(examined: _Examined) -> Iterator[Fault]:
    mesh, bad = examined.mesh, []
    # Two positive cells in the plane with the same nodes would run along the same edges.
    different = examined.plane is not None and examined.conforming and examined.orientation.all()
    for kind, cells, where in mesh.blocks():
        if different and CELL_TYPES[kind].dimension == 2:
            continue
        again = np.flatnonzero(repeats(cell_keys(cells)))
        if len(again):
            _, group, count = np.unique(np.sort(cells[again], 1), axis=0, return_inverse=True, return_counts=True)
            bad.append(where.start + again[count[group.ravel()] > 1])
    bad = np.concatenate(bad) if bad else _NONE
    if len(bad):
        yield Fault("repeated cells", f"{len(bad):,} cells have the nodes of another: {_cell_at(mesh, bad[0])}", bad)


def _overlap(examined: _Examined) -> Iterator[Fault]:
    mesh, plane = examined.mesh, examined.plane
    if plane is None or not examined.conforming or not examined.orientation.all():
        return  # the argument of `embedding` stands on positive cells and matching edges
    edges = examined.boundary_edges
    hanging, crossing = embedding.overlaps(plane, edges, examined.rounding)
    owners = examined.cells_with(edges[hanging[:, 0]])
    own = [point in _nodes_of(mesh, cell) for cell, point in zip(owners, hanging[:, 1], strict=True)]
    hanging, owners = hanging[~np.array(own, bool)], owners[~np.array(own, bool)]  # a thin cell is no fault
    if len(hanging):
        cells = np.unique(owners)
        points = np.unique(hanging[:, 1])
        what = _many(len(points), "point hangs", "points hang")
        yield Fault(
            "hanging nodes", f"{what} on edges: point {points[0]} at {_at(mesh.points[points[0]])}", cells, points
        )
    if len(crossing):
        cells = np.unique(examined.cells_with(edges[np.unique(crossing)]))
        what = _many(len(crossing), "pair of boundary edges crosses", "pairs of boundary edges cross")
        yield Fault("overlap", f"{what}: {_cell_at(mesh, cells[0])}", cells)
    if not len(hanging) and not len(crossing):
        cells = examined.cells_with(edges[embedding.chain_representatives(edges)])
        centres = np.array([plane[_nodes_of(mesh, cell)].mean(axis=0) for cell in cells]).reshape(-1, 2)
        cells = np.unique(cells[embedding.degree_at(plane, edges, centres) != 1])
        if len(cells):
            yield Fault("overlap", f"parts of the mesh lie over others: {_cell_at(mesh, cells[0])}", cells)


def _nodes_of(mesh: Mesh, cell: int) -> np.ndarray:
    """Corner nodes of one cell."""
    kind, cells, where = next(block for block in mesh.blocks() if block[2].start <= cell < block[2].stop)
    return cells[cell - where.start, : CELL_TYPES[CELL_TYPES[kind].linear or kind].nodes]


def _boundary(examined: _Examined, boundary: Mesh) -> Iterator[Fault]:
    mesh, lines = examined.mesh, boundary.get("line")
    n = mesh.n_points
    edges = examined.edge_keys if mesh.dimension == 2 else mesh.edges @ np.array([2 * n, 2])
    likely = examined.boundary_edges if mesh.dimension == 2 else None
    lost = missing_segments(mesh.points, edges, same_points(mesh.points, boundary.points), lines, likely)
    if len(lost):
        start = next(where.start for kind, _, where in boundary.blocks() if kind == "line")
        a, b = boundary.points[lines[lost[0]]]
        what = _many(len(lost), "line of the boundary is", "lines of the boundary are")
        yield Fault("boundary", f"{what} not kept: line {start + lost[0]} from {_at(a)} to {_at(b)}", start + lost)


_CHECKS: tuple[Callable[[_Examined], Iterator[Fault]], ...] = (
    _empty,
    _orientation,
    _conformity,
    _orphans,
    _duplicates,
    _repeated,
    _overlap,
)
