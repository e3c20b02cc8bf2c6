"""Edges of a surface that are each other moved or turned: the front runs on through them.

One of the two edges marches, together with images of the faces that touch the other; what it does is repeated there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...errors import InvalidInput
from ..poisson.periodic_faces import ALIKE, Motion
from .edge_sides import FLAT, Side
from .front_graph import FrontGraph, front_graph

MOST_SECTORS = 720


class EdgePair(NamedTuple):
    """Two edges that are alike.

    Attributes
    ----------
    first, last : (k,) int
        Nodes of the one, and those of the other at their images.
    motion : Motion
        From the first to the last.
    """

    first: np.ndarray
    last: np.ndarray
    motion: Motion


class Images(NamedTuple):
    """Nodes that are images of others under motions.

    Attributes
    ----------
    nodes, sources : (m,) int
        The nodes, the last ones of all, and those whose images they are.
    turn, way : (m, 3, 3), (m, 3) float
        Their rotations, and what is added after them.
    """

    nodes: np.ndarray
    sources: np.ndarray
    turn: np.ndarray
    way: np.ndarray

    def set_places(self, points: np.ndarray) -> None:
        """Put the nodes where they belong."""
        if len(self.nodes):
            self.set_vectors(points)
            points[self.nodes] += self.way

    def set_vectors(self, vectors: np.ndarray) -> None:
        """Give the nodes the turned vectors of their sources."""
        if len(self.nodes):
            vectors[self.nodes] = np.einsum("mpq,mq->mp", self.turn, vectors[self.sources])

    def set_numbers(self, numbers: np.ndarray) -> None:
        """Give the nodes the numbers of their sources."""
        if len(self.nodes):
            numbers[self.nodes] = numbers[self.sources]


NO_IMAGES = Images(*(np.empty(0, np.int64) for _ in range(2)), np.empty((0, 3, 3)), np.empty((0, 3)))


def pairs_of(graph: FrontGraph, normals: np.ndarray, sides: Sequence[Side]) -> list[EdgePair]:
    """The pairs that periodic sides make.

    Raises
    ------
    InvalidInput
        If a side is not like any other.
    """
    left, pairs = list(sides), []
    extent = float(np.ptp(graph.points, axis=0).max())
    while left:
        side = left.pop(0)
        tries = []
        for k, other in enumerate(left):
            if len(other.nodes) == len(side.nodes) and not side.closed and not other.closed:
                pair = EdgePair(side.nodes, other.nodes[::-1], _motion(graph, normals, side, other))
                off = np.abs(pair.motion.moved(graph.points[pair.first]) - graph.points[pair.last]).max()
                tries.append((off, k, pair))
        off, k, pair = min(tries, key=lambda found: found[:2], default=(np.inf, -1, None))
        if off > ALIKE * extent:
            raise InvalidInput(
                f"is periodic at the edge round {side.told(graph.points)}, but none of the other periodic edges is its "
                f"image, moved or turned{f' (points differ by {off:.4g})' if tries else ''}; they need as many points "
                "and the same shape",
                parameter="edges",
            )
        pairs.append(pair)
        del left[k]
    return pairs


def _motion(graph: FrontGraph, normals: np.ndarray, side: Side, other: Side) -> Motion:
    """The motion that brings a side to another, whose nodes run the other way."""
    points = graph.points
    first, last = points[side.nodes], points[other.nodes[::-1]]
    centred = first - first.mean(axis=0)
    bent = np.linalg.svd(centred, compute_uv=False)[1] if len(first) > 2 else 0.0
    if bent > FLAT * np.linalg.norm(np.ptp(first, axis=0)):
        return Motion.between(first, last)
    (normal, flat), (beyond, even) = (_normal_beside(graph, normals, s.nodes) for s in (side, other))
    return _of_straight_sides(first, last, normal, beyond, flat and even)


def _normal_beside(graph: FrontGraph, normals: np.ndarray, nodes: np.ndarray) -> tuple[np.ndarray, bool]:
    """A straight side's normal, and whether the surface is flat there.

    Those at its nodes are of the faces beside it; what turns from there inwards goes on outwards.
    """
    inner = [graph.ring[graph.start[node] + 1 : graph.start[node + 1] - 1] for node in nodes[1:-1].tolist()]
    inwards = [normals[ring].mean(axis=0) for ring in inner if len(ring)]
    here = normals[nodes[1:-1] if inwards else nodes].mean(axis=0)
    beside = 2 * here - np.mean(inwards, axis=0) if inwards else here
    return beside, bool(np.linalg.norm(beside - here) < 1e-9)


def _of_straight_sides(first: np.ndarray, last: np.ndarray, normal: np.ndarray, other: np.ndarray, flat: bool):
    """The motion between straight sides: of all those round the second one, that which also turns the normals.

    Of curved surfaces normals at edges tell the angle round the side but roughly: it is taken to be such that the
    whole turn is the nearest whole part of a full one, or none.
    """
    along = last[-1] - last[0]
    along /= np.linalg.norm(along)
    turn = _frame(along, other) @ _frame(first[-1] - first[0], normal).T
    parts = np.concatenate([[0.0], 2 * np.pi / np.arange(2, MOST_SECTORS)])
    whole = float(parts[np.argmin(np.abs(parts - _angle_and_axis(turn)[0]))])
    if not flat:
        turn = _rotation(along, _angle_to(whole, turn, along)) @ turn
    if _angle_and_axis(turn)[0] < 1e-9:
        turn = np.eye(3)
    return Motion(turn, last.mean(axis=0) - turn @ first.mean(axis=0))


def _angle_to(whole: float, turn: np.ndarray, along: np.ndarray) -> float:
    """The least angle about a direction that makes a rotation, followed by it, one by a whole angle; or 0.

    As quaternions, cos(whole / 2) = w cos(a / 2) - v sin(a / 2) with w = cos(angle / 2), v = sin(angle / 2) axis.along.
    """
    angle, axis = _angle_and_axis(turn)
    w, v = np.cos(angle / 2), np.sin(angle / 2) * float(axis @ along)
    size, phase = np.hypot(w, v), np.arctan2(v, w)
    half = np.arccos(min(1.0, np.cos(whole / 2) / size))
    tries = [2 * (sign * half - phase) for sign in (1, -1)]
    return min(((a + np.pi) % (2 * np.pi) - np.pi for a in tries), key=abs)


def _frame(along: np.ndarray, up: np.ndarray) -> np.ndarray:
    """(3, 3): a right-handed frame by columns, from a direction and one that is roughly square to it."""
    x = along / np.linalg.norm(along)
    z = up - (up @ x) * x
    z /= np.linalg.norm(z)
    return np.column_stack([x, np.cross(z, x), z])


def _angle_and_axis(turn: np.ndarray) -> tuple[float, np.ndarray]:
    """Angle from 0 to pi and unit axis of a rotation."""
    _values, vectors = np.linalg.eigh(0.5 * (turn + turn.T))
    axis = vectors[:, -1]
    skew = 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    axis = axis if axis @ skew >= 0 else -axis
    tidy = int(np.argmax(np.abs(axis)))
    if abs(axis[tidy]) > 1 - 1e-9:
        axis = np.eye(3)[tidy] * np.sign(axis[tidy])
    return float(np.arctan2(np.linalg.norm(skew), 0.5 * (np.trace(turn) - 1))), axis


def _rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """The rotation about a unit axis (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)


class Extended(NamedTuple):
    """A front that runs on through its periodic edges.

    Attributes
    ----------
    graph : FrontGraph
        Nodes that march come first; those of second edges, and images of the faces that touch these, have no ring.
    images : Images
    place : (n,) int
        Where the nodes of the surface stand in it.
    axes : dict of int to (3,) float
        Nodes that both edges share, which are on the axis of a turn, and this axis.
    """

    graph: FrontGraph
    images: Images
    place: np.ndarray
    axes: dict[int, np.ndarray]


def extended(graph: FrontGraph, pairs: Sequence[EdgePair]) -> Extended:
    """A front with images of the faces beyond its periodic edges.

    Each node is known by the one that marches of which it is an image, and how many times it is moved by each pair. For
    each corner of a face that is moved, an image of the face is added by which the corner comes to where it marches.
    """
    n = len(graph.points)
    if not pairs:
        return Extended(graph, NO_IMAGES, np.arange(n), {})
    root, moved = _roots(n, pairs)
    fixed = np.array([np.isin(np.arange(n), pair.first[pair.first == pair.last]) for pair in pairs]).T
    valid = graph.faces >= 0
    corners = np.where(valid, graph.faces, 0)
    by = np.where(valid[..., None], moved[corners], 0)
    face, corner = np.nonzero(by.any(axis=-1))
    images = np.unique(np.column_stack([face, by[face, corner]]), axis=0)
    face, back = images[:, 0], images[:, 1:]
    beyond = np.where(fixed[root[corners[face]]], 0, by[face] - back[:, None])
    keys = np.concatenate(
        [np.column_stack([root, moved]), np.column_stack([root[corners[face]].ravel(), beyond.reshape(-1, len(pairs))])]
    )
    keys, number = np.unique(keys, axis=0, return_inverse=True)
    is_image = keys[:, 1:].any(axis=1)
    order = np.argsort(is_image, kind="stable")  # nodes that march come first
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    number = rank[number.ravel()]
    place, ghosts = number[:n], number[n:].reshape(-1, 4)
    found = _images(keys[order], int((~is_image).sum()), place, pairs)
    faces = np.where(np.concatenate([valid, valid[face]]), np.concatenate([place[corners], ghosts]), -1)
    seen = (faces >= 0) & (faces < len(order) - len(found.nodes))
    poles = place[fixed.any(axis=1)]  # see only the faces that are their own, as nodes on planes of symmetry do
    seen[len(valid) :] &= ~np.isin(faces[len(valid) :], poles)
    points = np.empty((len(order), 3))
    points[place] = graph.points
    given = points.copy()
    found.set_places(points)
    if np.abs(points[place] - graph.points).max() > 10 * ALIKE * np.ptp(graph.points, axis=0).max():
        raise InvalidInput("are periodic by motions that do not agree at their corners", parameter="edges")
    points[place] = given[place]
    part = np.concatenate([graph.part, graph.part[face]])
    front = front_graph(points, faces, part, corners=seen, marching=len(order) - len(found.nodes))
    axes = {int(place[a]): _angle_and_axis(p.motion.turn)[1] for p in pairs for a in p.first[p.first == p.last]}
    return Extended(front, found, place, axes)


def _images(keys: np.ndarray, marching: int, place: np.ndarray, pairs: Sequence[EdgePair]) -> Images:
    """The nodes from ``marching`` on as images of those whose numbers, and motions, their keys tell."""
    words, which = np.unique(keys[marching:, 1:], axis=0, return_inverse=True)
    turns, ways = np.empty((len(words), 3, 3)), np.empty((len(words), 3))
    for k, word in enumerate(words):
        turns[k], ways[k] = np.eye(3), 0.0
        for times, pair in zip(word.tolist(), pairs, strict=True):
            motion = pair.motion if times > 0 else pair.motion.inverse
            for _ in range(abs(times)):
                turns[k], ways[k] = motion.turn @ turns[k], motion.turn @ ways[k] + motion.way
    which = which.ravel()
    return Images(np.arange(marching, len(keys)), place[keys[marching:, 0]], turns[which], ways[which])


def _roots(n: int, pairs: Sequence[EdgePair]) -> tuple[np.ndarray, np.ndarray]:
    """The marching node of which each is an image, and how many times each pair's motion was taken."""
    root, moved = np.arange(n), np.zeros((n, len(pairs)), np.int64)
    for _ in range(2 * len(pairs) + 1):
        before = root.copy()
        for k, pair in enumerate(pairs):
            to = np.arange(n)
            to[pair.last] = pair.first
            moved[:, k] += to[root] != root
            root = to[root]
        if (root == before).all():
            return root, moved
    raise InvalidInput("have corners that are images of each other in circles", parameter="edges")
