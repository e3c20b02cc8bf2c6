"""What users say of the edges of a surface that is marched from, made a condition of each of its sides."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Literal, NamedTuple, Union

import numpy as np

from ...errors import InvalidGeometry, InvalidInput
from ...mesh import Mesh, StructuredGrid
from .edge_guides import Guide
from .edge_sides import CUT, FLAT, Side, chosen, sides_of
from .front_edges import Condition, Hold, free_edges, hold_of
from .front_graph import FrontGraph, at
from .layer_sides import name_of_side
from .layer_surface import LayerSurface
from .periodic_edges import EdgePair, extended, pairs_of

EdgeChoice = Literal[
    "automatic", "free", "plane", "constant x", "constant y", "constant z", "splay", "guide", "periodic"
]
_CHOICES = EdgeChoice.__args__
UPRIGHT = 30.0
"""Degrees by which a surface may miss the right angle with its plane of symmetry."""
SQUARE = 5.0
"""The same for constant coordinates, which are planes of symmetry if the surface meets them so."""
MOST_SPLAY = 80.0


class Asked(NamedTuple):
    """What is said of a side: one of the choices, and degrees if it splays."""

    choice: str
    splay: float


class FrontEdges(NamedTuple):
    """A front with its conditions.

    Attributes
    ----------
    graph : FrontGraph
        Extended beyond periodic sides.
    hold : Hold
    place : (n,) int
        Where the surface's nodes stand in it.
    sides : list of Side
        With the surface's nodes.
    conditions : list of Condition
    pairs : list of EdgePair
        Of periodic sides.
    called : list of str
        The name of each side in the layers.
    warnings : list of str
    """

    graph: FrontGraph
    hold: Hold
    place: np.ndarray
    sides: list[Side]
    conditions: list[Condition]
    pairs: list[EdgePair]
    called: list[str]
    warnings: list[str]

    def of_surface(self, layers: np.ndarray, node: int) -> tuple[np.ndarray, int]:
        """The layers of the surface's own nodes, and a node of the front, or -1, by its number there."""
        if not self.pairs:
            return layers, node
        return layers[:, self.place], -1 if node < 0 else int(np.flatnonzero(self.place == node)[0])


def front_edges(
    ready: LayerSurface,
    normals: np.ndarray,
    choice: str,
    each: str,
    splay: float,
    guide: Union[Mesh, StructuredGrid, None] = None,
) -> FrontEdges:
    """The front of a surface, with what its edges do.

    Parameters
    ----------
    ready : LayerSurface
        The surface.
    normals : (n, 3) float
        Its normals at the nodes.
    choice : str
        What edges do of which nothing else is said. "automatic" makes edges periodic at cuts that move points, keeps
        edges on the guide that lie on it, and finds planes of symmetry: sides in a plane that the surface meets nearly
        at right angles. Other sides are free.
    each : str
        What single edges do, such as "imin = plane, zmax = splay 20".
    splay : float
        Degrees.
    guide : Mesh or StructuredGrid, optional
        What edges stay on.

    Raises
    ------
    InvalidInput
        If edges are spoken of that are not there, a side lies in no plane as was asked, or on no guide.
    """
    graph = ready.graph
    given = parsed(each, splay)
    if ready.is_closed:
        if choice not in ("automatic", "free") or given:
            what = ("edges", choice) if not given else ("each_edge", each)
            raise InvalidInput(f"is {what[1]!r}, but the surface is closed and has no edges", parameter=what[0])
        return FrontEdges(graph, free_edges(graph), np.arange(len(graph.points)), [], [], [], [], [])
    sides = sides_of(graph, ready.source, ready.number)
    asked = _asked(ready, sides, given, Asked(choice, splay))
    rails = None if guide is None else Guide(guide, float(np.linalg.norm(np.ptp(graph.points, axis=0))))
    if rails is None and any(a.choice == "guide" for a in asked):
        raise InvalidInput("is needed, since edges shall stay on it", parameter="guide")
    conditions = [_condition(ready, normals, side, a, rails) for side, a in zip(sides, asked, strict=True)]
    periodic = [side for side, condition in zip(sides, conditions, strict=True) if condition.kind == "periodic"]
    pairs = pairs_of(graph, normals, periodic)
    front = extended(graph, pairs)
    moved = [side._replace(nodes=front.place[side.nodes]) for side in sides]
    hold = hold_of(front.graph, moved, conditions, guide=rails, images=front.images, axes=front.axes)
    _refuse_stuck(front.graph, hold)
    told = _told(graph, sides, asked, conditions)
    spoken = _spoken(ready, sides, [name for name, _ in given])
    called = [name_of_side(side, pairs, name) for side, name in zip(sides, spoken, strict=True)]
    return FrontEdges(front.graph, hold, front.place, sides, conditions, pairs, called, told)


def parsed(text: str, splay: float = 0.0) -> list[tuple[str, Asked]]:
    """Names of edges, and what is asked of them, from text such as "imin = plane, zmax = splay 20".

    Examples
    --------
    >>> parsed("imin = constant  z; vertex 3=splay 20")
    [('imin', Asked(choice='constant z', splay=0.0)), ('vertex 3', Asked(choice='splay', splay=20.0))]
    """
    found = []
    for part in filter(str.strip, re.split("[,;]", text)):
        name, equals, condition = (" ".join(word.split()) for word in part.partition("="))
        word, _, last = condition.rpartition(" ")
        degrees = splay
        if word == "splay":
            condition, degrees = word, _degrees(last)
        if not equals or not name or condition not in _CHOICES:
            raise InvalidInput(
                f"has {part.strip()!r}; write the name of an edge, '=', and one of {', '.join(_CHOICES)}, such as "
                "'imin = plane, jmax = splay 20'",
                parameter="each_edge",
            )
        found.append((name, Asked(condition, degrees)))
    return found


def _degrees(text: str) -> float:
    try:
        degrees = float(text)
    except ValueError:
        degrees = np.nan
    if not 0 <= degrees <= MOST_SPLAY:
        raise InvalidInput(f"splays by {text!r}; give degrees from 0 to {MOST_SPLAY:g}", parameter="each_edge")
    return degrees


def _asked(ready: LayerSurface, sides: list[Side], given: list[tuple[str, Asked]], others: Asked) -> list[Asked]:
    """What is asked of each side."""
    asked: list[Asked | None] = [None] * len(sides)
    for name, what in given:
        for k in chosen(sides, name, ready.source, ready.number, ready.graph.points):
            if asked[k] not in (None, what):
                raise InvalidInput(
                    f"asks both {asked[k].choice!r} and {what.choice!r} of the edge round "
                    f"{sides[k].told(ready.graph.points)}",
                    parameter="each_edge",
                )
            asked[k] = what
    found = [others if a is None else a for a in asked]
    return [
        Asked("periodic", 0.0) if a.choice == "automatic" and CUT in side.names else a
        for side, a in zip(sides, found, strict=True)
    ]


def _spoken(ready: LayerSurface, sides: list[Side], names: list[str]) -> list[str]:
    """The first name by which each side was spoken of; empty if by none."""
    found = [""] * len(sides)
    for name in names:
        for k in chosen(sides, name, ready.source, ready.number, ready.graph.points):
            found[k] = found[k] or name
    return found


def _condition(ready: LayerSurface, normals: np.ndarray, side: Side, asked: Asked, guide: Guide | None) -> Condition:
    """The condition that is asked of a side."""
    choice, points = asked.choice, ready.graph.points[side.nodes]
    if choice.startswith("constant"):
        plane = np.eye(3)["xyz".index(choice[-1])]
        square = np.abs(normals[side.nodes] @ plane).max() <= np.sin(np.radians(SQUARE))
        return Condition("plane" if square else "constant", plane)
    if choice == "splay":
        return Condition("splay" if asked.splay else "free", splay=asked.splay)
    if choice == "automatic" and guide is not None and guide.holds(points):
        return Condition("guide")
    if choice in ("automatic", "plane"):
        plane = _plane_of(points, normals[side.nodes])
        if plane is None and choice == "plane":
            raise InvalidGeometry(
                f"the edge near {side.told(ready.graph.points)} lies in no plane that the surface meets at a "
                "right angle; ask something else of this edge, or take edges='automatic'",
                parameter="surface",
                points=ready.points_at(side.nodes),
            )
        return Condition() if plane is None else Condition("plane", plane)
    return Condition(choice)


def _plane_of(points: np.ndarray, normals: np.ndarray) -> np.ndarray | None:
    """Normal of the plane of symmetry in which a side lies, or None."""
    centred = points - points.mean(axis=0)
    size, axes = np.linalg.svd(centred, full_matrices=True)[1:]
    size = np.append(size, np.zeros(3))
    extent = np.linalg.norm(np.ptp(points, axis=0))
    if size[1] <= FLAT * extent * np.sqrt(len(points)):
        plane = np.cross(axes[0], normals.mean(axis=0))
        plane /= np.linalg.norm(plane) or 1.0
    else:
        plane = axes[2]
    flat = np.abs(centred @ plane).max() <= FLAT * extent
    upright = np.abs(normals @ plane).max() <= np.sin(np.radians(UPRIGHT))
    # A tidy normal keeps a coordinate of the plane to the last bit.
    axis = int(np.argmax(np.abs(plane)))
    plane = np.eye(3)[axis] if abs(plane[axis]) > 1 - 1e-12 else plane
    return plane if flat and upright else None


def _refuse_stuck(graph: FrontGraph, hold: Hold) -> None:
    stuck = hold.stuck(graph.points)
    if len(stuck):
        raise InvalidInput(
            f"leave no way to go at {at(graph.points[stuck[0]])}, where edges meet; let one of them be free",
            parameter="edges",
        )


def _told(graph: FrontGraph, sides: list[Side], asked: list[Asked], conditions: Sequence[Condition]) -> list[str]:
    """What was found at edges that were left to us."""
    ours = [k for k, a in enumerate(asked) if a.choice == "automatic"]
    free = [k for k in ours if conditions[k].kind == "free"]
    if not free:
        return []
    names = sorted(sides[free[0]].names)
    called = f", called {' or '.join(names)}," if names else ""
    return [
        f"the surface is open: {len(ours) - len(free)} of {len(ours)} edges stay in planes of symmetry or on the "
        f"guide, the others are free, the first{called} near {sides[free[0]].told(graph.points)}; close holes, or "
        "choose what edges do"
    ]
