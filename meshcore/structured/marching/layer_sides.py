"""Named boundaries of layers that are a mesh: the wall, the outer side, and the sides above edges, as sets of faces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...mesh import Mesh
from ...mesh.patches import UNNAMED
from .edge_sides import Side, tag_name
from .front_graph import reversed_faces
from .layer_surface import LayerSurface
from .periodic_edges import EdgePair

WALL, OUTER, PERIODIC = "wall", "outer", "periodic"
_EXTREMES = ("xmin", "xmax", "ymin", "ymax", "zmin", "zmax")


def name_of_side(side: Side, pairs: Sequence[EdgePair], spoken: str) -> str:
    """What a side is called in layers: first as the surface calls it, at last "boundary", as nameless sides of grids.

    Parameters
    ----------
    side : Side
        The side.
    pairs : sequence of EdgePair
        The periodic ones, whose sides are called as `patches` calls those of cuts.
    spoken : str
        How the user spoke of it, or nothing.
    """
    if side.own:
        return side.own
    for k, pair in enumerate(pairs, 1):
        name = PERIODIC if k == 1 else f"{PERIODIC} {k}"
        if np.array_equal(pair.first, side.nodes):
            return name
        if np.array_equal(pair.last[::-1], side.nodes):
            return f"{name} donor"
    return spoken or next((name for name in _EXTREMES if name in side.names), UNNAMED)


def with_sides(ready: LayerSurface, sides: Sequence[Side], called: Sequence[str], mesh: Mesh) -> tuple[Mesh, list[str]]:
    """Layers with the faces of their boundary as cells too, each in one set, and what had to be called otherwise.

    Parameters
    ----------
    ready : LayerSurface
        The surface.
    sides : sequence of Side
        Its edges.
    called : sequence of str
        Their names.
    mesh : Mesh
        Its layers, of volume cells only.
    """
    faces, n = ready.graph.faces, len(ready.graph.points)
    count = mesh.n_points // n - 1
    top = np.where(faces < 0, -1, faces + count * n)
    walls, wall = _wall_names(ready)
    nodes, name = [reversed_faces(faces), top], [wall, np.full(len(faces), len(walls))]
    layer = [np.full(len(faces), k) for k in (0, count - 1)]
    for k, side in enumerate(sides, len(walls) + 1):
        begin, end = (side.nodes, np.roll(side.nodes, -1)) if side.closed else (side.nodes[:-1], side.nodes[1:])
        low = n * np.arange(count)[:, None]
        nodes.append(np.stack([begin + low, end + low, end + low + n, begin + low + n], axis=-1).reshape(-1, 4))
        name.append(np.full(count * len(begin), k))
        layer.append(np.repeat(np.arange(count), len(begin)))
    names, warnings = _told_apart(walls, called)
    return _with_faces(mesh, *map(np.concatenate, (nodes, name, layer)), names), warnings


def _wall_names(ready: LayerSurface) -> tuple[list[str], np.ndarray]:
    """Names of the parts of the wall, and the number of each face's: the first set that has it, its tag, or "wall"."""
    found: dict[str, int] = {}
    part = np.full(len(ready.cell), -1)
    if isinstance(ready.source, Mesh):
        for name, members in ready.source.sets.items():
            inside = (part < 0) & np.isin(ready.cell, members)
            if inside.any():
                part[inside] = found.setdefault(name, len(found))
        tags = ready.source.cell_data.get("tag")
        if tags is not None and tags.ndim == 1 and tags.dtype.kind in "iuf":
            of_face = tags[ready.cell]
            for tag in np.unique(of_face[(part < 0) & (of_face != 0)]):
                part[(part < 0) & (of_face == tag)] = found.setdefault(tag_name(tag), len(found))
    if (part < 0).any():
        part[part < 0] = found.setdefault(WALL, len(found))
    return list(found), part


def _told_apart(walls: Sequence[str], sides: Sequence[str]) -> tuple[list[str], list[str]]:
    """Names of the parts of the wall, of the outer side and of those above edges, and what was called otherwise.

    Sides of one name are one; but none has the outer side's or that of a part of the wall.
    """
    asked = [(OUTER, ""), *((name, "the part of the wall") for name in walls)]
    asked += [(name, "the side above an edge") for name in sides]
    kept: dict[tuple[str, str], str] = {}
    warnings = []
    for name, what in dict.fromkeys(asked):
        number, free = 1, name
        while free in kept.values():
            number += 1
            free = f"{name} {number}"
        kept[name, what] = free
        if free != name:
            warnings.append(f"{what} that is called {name!r} is called {free!r} in the layers, which have that already")
    outer, *others = (kept[key] for key in asked)
    return [*others[: len(walls)], outer, *others[len(walls) :]], warnings


def _with_faces(mesh: Mesh, nodes: np.ndarray, name: np.ndarray, layer: np.ndarray, names: Sequence[str]) -> Mesh:
    """The mesh with faces (k, 4), triangles with -1 last, of names by number, as cells behind its own."""
    cells, order = dict(mesh.cells), []
    for kind, corners in (("triangle", 3), ("quad", 4)):
        of_kind = np.flatnonzero((nodes[:, 3] < 0) == (corners == 3))
        if len(of_kind):
            cells[kind] = np.ascontiguousarray(nodes[of_kind, :corners])
            order.append(of_kind)
    order = np.concatenate(order)
    sets: dict[str, list[np.ndarray]] = {}
    for k, title in enumerate(names):
        sets.setdefault(title, []).append(mesh.n_cells + np.flatnonzero(name[order] == k))
    return Mesh.unchecked(
        mesh.points,
        cells,
        {**mesh.cell_data, "layer": np.concatenate([mesh.cell_data["layer"], layer[order]])},
        {title: np.sort(np.concatenate(members)) for title, members in sets.items()},
    )
