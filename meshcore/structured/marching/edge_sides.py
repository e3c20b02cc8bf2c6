"""The edges of an open surface as sides: stretches between corners, and the names that users know them by."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Union

import numpy as np

from ...errors import InvalidInput
from ...mesh import CELL_TYPES, Mesh, MultiBlock, StructuredGrid
from .front_graph import FrontGraph, at

CORNER = 40.0
"""Degrees by which an edge turns at the corner between two sides."""
CUT = "cut"
"""The name of edges at cuts that move points."""
FLAT = 1e-6
"""Distance from a plane, in units of a side's length, up to which the side lies in it."""
Surface = Union[Mesh, StructuredGrid, MultiBlock]


class Side(NamedTuple):
    """A stretch of the surface's edge between corners, or between places where its names change.

    Attributes
    ----------
    nodes : (k,) int
        In order along the edge, the surface to the left seen from where it is marched to; of a loop the first is not
        repeated.
    names : frozenset of str
        What users may call it.
    closed : bool
        Whether it is a loop.
    own : str
        The name, or the tag, that the surface itself gives it; empty if it gives none.
    """

    nodes: np.ndarray
    names: frozenset[str] = frozenset()
    closed: bool = False
    own: str = ""

    def told(self, points: np.ndarray) -> str:
        """A place on it, as text."""
        return at(points[self.nodes[len(self.nodes) // 2]])


def sides_of(graph: FrontGraph, surface: Surface | None = None, number: np.ndarray | None = None) -> list[Side]:
    """The sides of a surface.

    Parameters
    ----------
    graph : FrontGraph
        The surface as a graph.
    surface, number : optional
        The surface as given, which has names, and the node of each of its points.
    """
    nodes = np.flatnonzero(graph.opened)
    after, before = graph.ring[graph.start[nodes]], graph.ring[graph.start[nodes + 1] - 1]
    place = graph.points
    leaving, coming = _units(place[after] - place[nodes]), _units(place[nodes] - place[before])
    smooth = np.einsum("ij,ij->i", leaving, coming) > np.cos(np.radians(CORNER))
    named, owned = ({}, {}) if surface is None else _named_edges(surface, number)
    follows = dict(zip(nodes.tolist(), after.tolist(), strict=True))
    names = {a: frozenset(named.get((min(a, b), max(a, b)), ())) for a, b in follows.items()}
    own = {a: owned.get((min(a, b), max(a, b)), "") for a, b in follows.items()}
    turns = zip(nodes.tolist(), before.tolist(), smooth, strict=True)
    begins = [node for node, last, goes_on in turns if not goes_on or names[node] != names[last]]
    sides, seen, corners = [], set(), set(begins)
    for first in [*begins, *nodes.tolist()]:
        if first in seen:
            continue
        chain = [first]
        seen.add(first)
        while (node := follows[chain[-1]]) not in corners and node != first:
            chain.append(node)
            seen.add(node)
        closed = first not in corners
        sides.append(Side(np.array(chain if closed else [*chain, node]), names[first], closed, own[first]))
    return [side._replace(names=side.names | _extremes(place, side.nodes)) for side in sides]


def chosen(sides: Sequence[Side], name: str, surface: Surface, number: np.ndarray, points: np.ndarray) -> list[int]:
    """The sides that a name, or a vertex of theirs, tells; an error if none."""
    word, _, last = name.rpartition(" ")
    if word == "vertex" and last.isdigit() and isinstance(surface, Mesh):
        node = int(number[int(last)]) if int(last) < len(number) else -1
        found = [k for k, side in enumerate(sides) if node in side.nodes]
        if not found:
            raise InvalidInput(f"vertex {last} is on no edge of the surface; name one that is", parameter="each_edge")
        return found
    found = [k for k, side in enumerate(sides) if name in side.names]
    if found:
        return found
    known = sorted(frozenset().union(*(side.names for side in sides)))
    others = " and 'vertex' with the number of one" if isinstance(surface, Mesh) else ""
    where = ", ".join(side.told(points) for side in sides[:8])
    raise InvalidInput(
        f"no edge is called {name!r}; names are {', '.join(known) or 'none'}{others}; the surface has {len(sides)} "
        f"edges, round {where}",
        parameter="each_edge",
    )


def tag_name(tag: float) -> str:
    """What cells of a tag are called that are in no set."""
    return f"tag {tag:g}"


def _extremes(points: np.ndarray, nodes: np.ndarray) -> frozenset[str]:
    """ "xmin" and the like, for a side all of which lies where the whole surface has its least x."""
    low, high = points.min(axis=0), points.max(axis=0)
    gap = FLAT * np.linalg.norm(high - low)
    found = []
    for axis, letter in enumerate("xyz"):
        if high[axis] - low[axis] > gap:
            x = points[nodes, axis]
            found += [f"{letter}min"] * bool((x <= low[axis] + gap).all())
            found += [f"{letter}max"] * bool((x >= high[axis] - gap).all())
    return frozenset(found)


def _named_edges(surface: Surface, number: np.ndarray) -> tuple[dict, dict]:
    """Names of edges, by their two nodes, the lower first; and of these the first that is the surface's own."""
    named: dict[tuple[int, int], list[str]] = {}
    owned: dict[tuple[int, int], str] = {}
    for nodes, names, own in _named_lines(surface, number):
        for a, b in np.sort(nodes, axis=1).tolist():
            named.setdefault((a, b), []).extend(names)
            if own:
                owned.setdefault((a, b), own)
    return named, owned


def _named_lines(surface: Surface, number: np.ndarray):
    """Pairs of nodes (k, 2), the names that they have, and that which the surface itself gives them."""
    if isinstance(surface, Mesh):
        yield from _named_cells(surface, number)
        return
    blocks = surface.blocks if isinstance(surface, MultiBlock) else (surface,)
    start = 0
    for k, block in enumerate(blocks):
        grid = number[start : start + block.n_points].reshape(block.shape[:2])
        start += block.n_points
        for face, line in {"imin": grid[0], "imax": grid[-1], "jmin": grid[:, 0], "jmax": grid[:, -1]}.items():
            own = block.names.get(face, "")
            names = [face, own] if own else [face]
            names += [f"{surface.names[k]} {face}"] if isinstance(surface, MultiBlock) else []
            yield np.column_stack([line[:-1], line[1:]]), names, own
    yield from _moved_cuts(surface, number)


def _moved_cuts(surface: StructuredGrid | MultiBlock, number: np.ndarray):
    """The edges at cuts whose two sides are each other moved or turned."""
    whole = surface if isinstance(surface, MultiBlock) else MultiBlock((surface,))
    starts = np.cumsum([0] + [block.n_points for block in whole.blocks])
    for cut in whole.joins:
        for side in (cut, cut.reversed()) if cut.moves else ():
            shape = whole.blocks[side.block].shape
            nodes = number[starts[side.block] + np.ravel_multi_index(tuple(side.places().T), shape)]
            yield np.column_stack([nodes[:-1], nodes[1:]]), [CUT], ""


def _named_cells(mesh: Mesh, number: np.ndarray):
    """The same of a mesh: its line cells by their sets and tags."""
    first = 0
    for kind, cells in mesh.cells.items():
        last = first + len(cells)
        if CELL_TYPES[kind].dimension == 1 and len(cells):
            lines = number[cells[:, :2]]
            for name, members in mesh.sets.items():
                rows = np.asarray(members)
                rows = rows[(rows >= first) & (rows < last)] - first
                yield lines[rows], [name], name
            tags = mesh.cell_data.get("tag")
            for tag in [] if tags is None else np.unique(tags[first:last]):
                yield lines[tags[first:last] == tag], [tag_name(tag)], tag_name(tag) if tag else ""
        first = last


def _units(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
