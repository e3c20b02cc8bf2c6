"""Surfaces that layers are marched from: grids, blocks and meshes read into one graph, and the layers cut back."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

import numpy as np

from ...errors import InvalidGeometry, InvalidInput
from ...mesh import CELL_TYPES, Mesh, MultiBlock, StructuredGrid
from ..limits import check_extent
from .front_graph import FrontGraph, at, front_graph, reversed_faces, turned_alike, welded, without_repeats

FLAT = 1e-9
"""Sine of a face's corner below which the corner counts as flat."""
SEAM = 1e-6
"""Of the surface's diagonal: points of open edges that are nearer belong together."""
_NAMES = {"kmin": "wall", "kmax": "outer"}


@dataclass(frozen=True, eq=False)
class LayerSurface:
    """A surface as a graph, and how the given one sits in it.

    Attributes
    ----------
    graph : FrontGraph
        Nodes and faces, counter-clockwise from the side that is marched to.
    source : Mesh, StructuredGrid or MultiBlock
        The surface.
    given : Mesh, StructuredGrid or MultiBlock
        What layers are given back like: the surface, or a mesh in place of grids with poles.
    number : (points of all blocks,) int
        The node of each point of the given surface; -1 if no face has it.
    cell : (number of the graph's faces,) int
        The number of each face's cell in a given mesh; of grids counted through all blocks, i running slowest.
    reversed : bool
        Whether the surface is marched to the side from which its faces were given clockwise.
    inwards : bool
        Whether closed surfaces are marched into.
    warnings : list of str
        What had to be mended.
    """

    graph: FrontGraph
    source: Mesh | StructuredGrid | MultiBlock
    given: Mesh | StructuredGrid | MultiBlock
    number: np.ndarray
    cell: np.ndarray
    reversed: bool
    inwards: bool = False
    warnings: list[str] = field(default_factory=list)

    @property
    def is_closed(self) -> bool:
        """Whether the surface has no edge."""
        return not self.graph.opened.any()

    def points_at(self, nodes: np.ndarray) -> np.ndarray:
        """(k,) int: numbers of the given points at nodes, i running fastest in each block, as errors name points."""
        there = np.isin(self.number, nodes)
        if not isinstance(self.source, Mesh):
            ends = np.cumsum([block.n_points for block in _blocks(self.source)])[:-1]
            parts = zip(np.split(there, ends), _blocks(self.source), strict=True)
            there = np.concatenate([part.reshape(block.shape[:2]).T.ravel() for part, block in parts])
        return np.flatnonzero(there)

    def layered(self, layers: np.ndarray) -> Mesh | StructuredGrid | MultiBlock:
        """(k + 1, n, 3) layers of nodes as what was given: grids, blocks, or a mesh of wedges and hexahedra."""
        if isinstance(self.given, Mesh):
            return self._mesh(layers)
        starts = np.cumsum([0] + [block.n_points for block in _blocks(self.given)])
        grids = []
        for block, start in zip(_blocks(self.given), starts, strict=False):
            number = self.number[start : start + block.n_points].reshape(block.shape[:2])
            points = np.ascontiguousarray(layers[:, number].transpose(1, 2, 0, 3))
            points[:, :, 0] = block.points[:, :, 0]  # to the last bit, also where blocks meet within rounding
            grid = StructuredGrid(points, names={**block.names, **_NAMES}, periodic=block.periodic)
            grids.append(grid.reversed_along_i() if self.reversed else grid)
        return grids[0] if isinstance(self.given, StructuredGrid) else MultiBlock(tuple(grids), self.given.names)

    def marked(self, result: Mesh | StructuredGrid | MultiBlock, node: int) -> Mesh | StructuredGrid | MultiBlock:
        """The layers with ``cell_data["stopped"]``: 1 at the outermost cells that have a node."""
        if isinstance(result, Mesh):
            top = result.n_points - len(self.graph.points) + node
            return result.with_cell_data(
                stopped=np.concatenate([(c == top).any(axis=1).astype(float) for c in result.cells.values()])
            )
        marked, start = [], 0
        for given, block in zip(_blocks(self.given), _blocks(result), strict=True):
            at_node = (self.number[start : start + given.n_points] == node).reshape(given.shape[:2])
            at_node = at_node[::-1] if self.reversed else at_node
            stopped = np.zeros(block.cell_shape)
            stopped[:, :, -1] = at_node[:-1, :-1] | at_node[1:, :-1] | at_node[1:, 1:] | at_node[:-1, 1:]
            marked.append(block.with_cell_data(stopped=stopped))
            start += given.n_points
        return marked[0] if isinstance(result, StructuredGrid) else replace(result, blocks=tuple(marked))

    def _mesh(self, layers: np.ndarray) -> Mesh:
        count, n = len(layers) - 1, len(self.graph.points)
        cells, layer = {}, []
        triangle = self.graph.faces[:, 3] < 0
        for kind, corners in (
            ("wedge", self.graph.faces[triangle, :3]),
            ("hexahedron", self.graph.faces[~triangle]),
        ):
            if len(corners):
                below = corners + n * np.arange(count)[:, None, None]
                cells[kind] = np.concatenate([below, below + n], axis=2).reshape(-1, 2 * corners.shape[1])
                layer.append(np.repeat(np.arange(count), len(corners)))
        return Mesh.unchecked(layers.reshape(-1, 3), cells, {"layer": np.concatenate(layer)})


def read_surface(
    surface: Mesh | StructuredGrid | MultiBlock, *, other_side: bool = False, gap: float = 1e-9
) -> LayerSurface:
    """A surface as a graph: coincident points glued, faces turned alike, closed surfaces outwards.

    Parameters
    ----------
    surface : Mesh, StructuredGrid or MultiBlock
        Quads and triangles.
    other_side : bool
        March into closed surfaces, and to the back of open ones.
    gap : float
        Points no farther apart, in units of the surface's diagonal, are one.

    Raises
    ------
    InvalidInput, InvalidGeometry
        If it is no surface, or one that has no two sides; the message says where.
    """
    points, faces, cell = _faces(surface)
    diagonal = check_extent(points, parameter="surface")
    warnings = []
    points, number = welded(points, gap * diagonal)
    glued = len(number) - len(points)
    if glued and isinstance(surface, Mesh):
        warnings.append(f"{glued:,} points that share their places with others were made one with these")
    faces = without_repeats(np.where(faces < 0, -1, number[faces]))
    if isinstance(surface, Mesh):
        points, faces, seam = _sewn(points, faces, SEAM * diagonal, warnings)
        number = seam[number]
    collapsed = faces[:, 2] < 0
    if collapsed.any():
        if collapsed.all():
            raise InvalidGeometry("has no face with an area", parameter="surface")
        warnings.append(f"{collapsed.sum():,} faces without area were left out")
        faces, cell = faces[~collapsed], cell[~collapsed]
    with _points_as_given(number):
        faces, part, turned = turned_alike(faces, points)
    if turned:
        warnings.append(f"{turned:,} faces were turned to agree with their neighbours")
    used = np.zeros(len(points), bool)
    used[faces[faces >= 0]] = True
    rank = np.where(used, np.cumsum(used) - 1, -1)
    points, number = np.ascontiguousarray(points[used]), rank[number]
    faces = np.where(faces < 0, -1, rank[faces])
    faces, inward = _outwards(points, faces, part, warnings)
    faces = reversed_faces(faces) if other_side else faces
    with _points_as_given(number):
        graph = front_graph(points, faces, part)
        _refuse_flat(graph)
    given = _without_collapse(surface, faces, warnings)
    return LayerSurface(graph, surface, given, number, cell, inward ^ other_side, other_side, warnings)


@contextmanager
def _points_as_given(number: np.ndarray) -> Iterator[None]:
    """Errors inside name glued points; these become all of the user's that are one of them."""
    try:
        yield
    except InvalidGeometry as error:
        at = np.flatnonzero(np.isin(number, error.points))
        raise InvalidGeometry(str(error).removeprefix("surface: "), parameter="surface", points=at) from None


def _sewn(
    points: np.ndarray, faces: np.ndarray, reach: float, warnings: list[str]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points and faces whose open edges are glued where they lie within reach, and the new number of each point.

    Rounding moves the points of faces that were written one by one, as in STL files of scans and CAD programs.
    """
    after, single = _open_sides(faces, len(points))
    rim = np.unique(np.concatenate([faces[single], after[single]]))
    merged, of_rim = welded(points[rim], reach)
    if len(merged) == len(rim):
        return points, faces, np.arange(len(points))
    warnings.append(f"{len(rim) - len(merged):,} points of open edges were within {reach:.2g} of others and made one")
    first = np.full(len(merged), len(points))
    np.minimum.at(first, of_rim, rim)
    number = np.arange(len(points))
    number[rim] = first[of_rim]
    return points, without_repeats(np.where(faces < 0, -1, number[faces])), number


def _blocks(surface: StructuredGrid | MultiBlock) -> tuple[StructuredGrid, ...]:
    return surface.blocks if isinstance(surface, MultiBlock) else (surface,)


def _faces(surface: Mesh | StructuredGrid | MultiBlock) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points and (m, 4) faces of what was given, triangles with -1 last, and the numbers of these cells."""
    if isinstance(surface, Mesh):
        wrong = [k for k, c in surface.cells.items() if len(c) and CELL_TYPES[k].dimension > 1]
        wrong = [kind for kind in wrong if kind not in ("triangle", "quad")]
        if wrong or not len(surface.get("triangle")) + len(surface.get("quad")):
            what = f"has {wrong[0]} cells" if wrong else "has no faces"
            raise InvalidInput(f"{what}; layers need a surface of triangles and quads", parameter="surface")
        # In the order of the mesh's cells, so that numbers of faces are the user's.
        shown = [(c, where) for k, c, where in surface.blocks() if k in ("triangle", "quad")]
        parts = [np.pad(c, ((0, 0), (0, 4 - c.shape[1])), constant_values=-1) for c, _ in shown]
        numbers = [np.arange(where.start, where.stop) for _, where in shown]
        return surface.points, np.concatenate(parts), np.concatenate(numbers)
    if not isinstance(surface, (StructuredGrid, MultiBlock)):
        raise InvalidInput(
            f"needs a Mesh, a StructuredGrid or a MultiBlock, got {type(surface).__name__}", parameter="surface"
        )
    points, faces, start = [], [], 0
    for block in _blocks(surface):
        if not block.is_surface:
            raise InvalidInput(f"has a block of {block!r}; layers need surfaces (nk = 1)", parameter="surface")
        number = start + np.arange(block.n_points).reshape(block.shape[:2])
        corners = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
        faces.append(np.stack(corners, axis=-1).reshape(-1, 4))
        points.append(block.points.reshape(-1, 3))
        start += block.n_points
    return np.concatenate(points), np.concatenate(faces), np.arange(sum(map(len, faces)))


def _outwards(points: np.ndarray, faces: np.ndarray, part: np.ndarray, warnings: list[str]) -> tuple[np.ndarray, bool]:
    """Faces of closed parts turned outwards, and whether the first part was turned."""
    a, b, c = points[faces[:, 0]], points[faces[:, 1]], points[faces[:, 2]]
    d = points[np.where(faces[:, 3] < 0, faces[:, 2], faces[:, 3])]
    middle = points.mean(axis=0)
    volume = np.einsum("ij,ij->i", a - middle, np.cross(b - middle, c - middle))
    volume += np.einsum("ij,ij->i", a - middle, np.cross(c - middle, d - middle))
    volume = np.bincount(part, weights=volume)
    inward = (volume < 0) & _closed_parts(faces, part, len(points))
    if inward.any():
        warnings.append(f"{inward.sum()} closed surfaces faced inwards and were turned")
    return np.where(inward[part][:, None], reversed_faces(faces), faces), bool(inward[0])


def _closed_parts(faces: np.ndarray, part: np.ndarray, n: int) -> np.ndarray:
    """(parts,) bool: whether each edge of a part has two faces."""
    return np.bincount(part, weights=_open_sides(faces, n)[1].any(axis=1)) == 0


def _open_sides(faces: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """(m, 4) int: the node after each in its face; (m, 4) bool: whether the edge between them has one face only."""
    after = np.roll(faces, -1, axis=1)
    triangle = faces[:, 3] < 0
    after[triangle, 2] = faces[triangle, 0]
    where = (faces >= 0) & (after >= 0)
    key = np.minimum(faces, after) * n + np.maximum(faces, after)
    _, inverse, count = np.unique(key[where], return_inverse=True, return_counts=True)
    single = np.zeros(faces.shape, bool)
    single[where] = (count == 1)[inverse.ravel()]
    return after, single


def _refuse_flat(graph: FrontGraph) -> None:
    """Faces must have an angle between 0 and 180 degrees at each corner."""
    faces, points = graph.faces, graph.points
    quad = faces[:, 3] >= 0
    size = np.where(quad, 4, 3)
    normal = np.zeros((len(faces), 3))
    corners = []
    for k in range(4):
        here = faces[:, k]
        after, before = faces[np.arange(len(faces)), (k + 1) % size], faces[np.arange(len(faces)), (k - 1) % size]
        u, v = points[after] - points[here], points[before] - points[here]
        cross = np.cross(u, v)
        cross[here < 0] = 0
        normal += cross
        corners.append((here, cross, np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1)))
    length = np.linalg.norm(normal, axis=1)
    bad = np.zeros(len(faces), bool)
    for here, cross, scale in corners:
        bad |= (here >= 0) & (np.einsum("ij,ij->i", cross, normal) <= FLAT * scale * length)
    if bad.any():
        face = faces[bad][0]
        raise InvalidGeometry(
            f"{bad.sum()} faces are flat, folded or have a corner of 180 degrees or more, the first near "
            f"{at(points[face[face >= 0]].mean(axis=0))}; move their points, or split them into triangles",
            parameter="surface",
            points=face[face >= 0],
        )


def _without_collapse(surface, faces: np.ndarray, warnings: list[str]):
    """The given surface, or as a mesh if quads of its grids have collapsed to triangles, as at a pole."""
    if isinstance(surface, Mesh) or not (faces[:, 3] < 0).any():
        return surface
    warnings.append("quads of the grid have collapsed sides, as at a pole: the layers there are wedges of a mesh")
    return Mesh(np.zeros((0, 3)), {})
