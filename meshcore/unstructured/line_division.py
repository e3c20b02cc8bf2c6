"""Lines divided for a front, as the survey has it: N_s = nint(A_s) parts, A_s the integral of 1 / length."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ._splitting_kernels import split_place
from .constrained import ConstrainedTriangulation
from .domain import Domain
from .planar_graph import PlanarGraph, divided_graph
from .refiner import MAX_TRIANGLES, Refiner, too_many

# From this much above a whole number on there is one part more. Somewhat below a half, so that parts are never longer
# than the limit, which is 1 / 0.68 of the length wanted.
_ROUND_UP = 0.45


@dataclass
class Ground:
    """A triangulation with a length at each vertex, linear in between.

    Attributes
    ----------
    xy, origin, twin : arrays
        As `Triangulation` has them.
    length : (n,) float
        At the vertices; without any, only the limits of faces count.
    near : (k,) int32
        For each vertex, or each point of a divided graph, a triangle at it.
    exponent : int
        Coordinates and lengths are scaled by two to this power.
    """

    xy: np.ndarray
    origin: np.ndarray
    twin: np.ndarray
    length: np.ndarray
    near: np.ndarray
    exponent: int


@dataclass
class Division:
    """Lines divided.

    Attributes
    ----------
    graph : PlanarGraph
        Its last points are the new ones, its segments the parts.
    owner : (k,) int
        Piece that each new point divides.
    count : (p,) int
        Parts of each piece.
    """

    graph: PlanarGraph
    owner: np.ndarray
    count: np.ndarray


def divided(
    mesh: ConstrainedTriangulation, parts: Domain, limits: np.ndarray, ground: Ground | None, coarse: Refiner
) -> Division:
    """Divide the pieces of all lines by the lengths wanted along them (survey, 3.2.3).

    Lines that meet others under small angles are split at round distances from there, as refinement does it, so that
    points on neighbouring lines are equally far from the corner.

    Parameters
    ----------
    mesh : ConstrainedTriangulation
        Its pieces are divided.
    parts : Domain
        Lines beside faces that are not meshed stay as they are.
    limits : (n_faces,) float
        Length wanted in each face.
    ground : Ground, optional
        Lengths that vary; its ``near`` is changed to that of the graph's points.
    coarse : Refiner
        Knows the piece that each vertex of the ground stands on, and the corners with small angles.
    """
    graph, order, pieces = mesh.graph, mesh.triangulation.order, mesh.pieces[:, :2]
    ends = order[pieces]
    along = graph.points[ends[:, 1]] - graph.points[ends[:, 0]]
    whole = np.hypot(*along.T)
    left, right = mesh.faces_beside
    wanted = np.minimum(*(np.where(parts.keep[side], limits[side], np.inf) for side in (left, right)))
    piece, share, vertex = _nodes(mesh, ground, coarse.stands_on, whole)
    length = wanted[piece]
    if ground is not None:
        length = np.minimum(length, np.ldexp(ground.length[vertex], -ground.exponent))
        length[~mesh.pieces_beside(parts.keep)[piece]] = np.inf
    sums = _Sums(piece, share, length, whole)
    owner, where, node, count = sums.places(_shells(mesh, coarse, sums))
    points = graph.points[ends[owner, 0]] + where[:, None] * along[owner]
    if ground is not None:
        ground.near = np.concatenate([ground.near[mesh.triangulation.vertex_of], ground.near[vertex[node]]])
    return Division(divided_graph(graph, ends, mesh.line, count, points)[0], owner, count)


def _nodes(mesh: ConstrainedTriangulation, ground: Ground | None, stands_on: np.ndarray, whole: np.ndarray):
    """Vertices of the ground along each piece, ends included: the piece, the share of its length, the vertex."""
    n = len(mesh.pieces)
    piece, share, vertex = np.tile(np.arange(n), 2), np.repeat([0.0, 1.0], n), mesh.pieces[:, :2].T.ravel()
    if ground is not None:
        inner = np.flatnonzero(stands_on[: len(ground.length)] >= 0)
        on = stands_on[inner].astype(np.int64)
        place = np.ldexp(ground.xy.reshape(-1, 2)[inner], -ground.exponent)
        start = mesh.graph.points[mesh.triangulation.order[mesh.pieces[on, 0]]]
        part = np.hypot(*(place - start).T) / whole[on]
        piece, share = np.concatenate([piece, on]), np.concatenate([share, np.clip(part, 0.0, 1.0)])
        vertex = np.concatenate([vertex, inner])
    sorting = np.lexsort((share, piece))
    return piece[sorting], share[sorting], vertex[sorting]


class _Sums:
    """The integral of 1 / length along pieces: between nodes the length is linear, so that it is a logarithm."""

    def __init__(self, piece: np.ndarray, share: np.ndarray, length: np.ndarray, whole: np.ndarray):
        self.share, self.pieces = share, len(whole)
        self.node = np.flatnonzero(piece[1:] == piece[:-1])
        self.piece = piece[self.node]
        self.step = (share[self.node + 1] - share[self.node]) * whole[piece[self.node]]
        self.low, high = length[self.node], length[self.node + 1]
        with np.errstate(invalid="ignore", divide="ignore"):
            self.rise = np.where(np.isfinite(self.low) & np.isfinite(high), high / self.low - 1, 0.0)
            self.flat = np.abs(self.rise) < 1e-9
            slope = np.log1p(self.rise) / np.where(self.flat, 1.0, self.rise)
            self.integral = self.step / self.low * np.where(self.flat, 1.0, slope)
        self.total = np.bincount(piece[self.node], self.integral, minlength=len(whole))
        if not self.total.sum() < MAX_TRIANGLES:
            raise too_many(float(self.total.sum()) ** 2, "size")
        self.after = np.cumsum(self.integral)
        self.before = np.cumsum(self.total) - self.total

    def between(self, piece: int, a: float, b: float) -> float:
        """The integral over a part of a piece, between two shares of its length; linear between nodes."""
        rows = slice(*np.searchsorted(self.piece, [piece, piece + 1]))
        share = np.append(self.share[self.node[rows]], 1.0)
        sums = np.append(0.0, np.cumsum(self.integral[rows]))
        return float(np.interp(b, share, sums) - np.interp(a, share, sums))

    def places(self, shells: dict[int, np.ndarray]):
        """Where pieces are divided: the piece, the share of its length, the node before; and parts of each piece.

        ``shells`` has the shares of those that are not divided evenly.
        """
        count = np.maximum(np.ceil(self.total - _ROUND_UP), 1).astype(np.int64)
        count[list(shells)] = [len(shares) + 1 for shares in shells.values()]
        first = np.cumsum(count - 1) - (count - 1)
        owner = np.repeat(np.arange(self.pieces), count - 1)
        number = np.arange(len(owner)) - first[owner] + 1
        wanted = self.before[owner] + number * self.total[owner] / count[owner]
        interval = np.minimum(np.searchsorted(self.after, wanted), len(self.node) - 1)
        low, rise, flat, step = (a[interval] for a in (self.low, self.rise, self.flat, self.step))
        rest = np.clip(wanted - (self.after - self.integral)[interval], 0.0, self.integral[interval])
        part = rest * low / step
        part = np.where(flat, part, np.expm1(part * rise) / np.where(flat, 1.0, rise))
        node = self.node[interval]
        where = self.share[node] + np.clip(part, 0.0, 1.0) * (self.share[node + 1] - self.share[node])
        for piece, shares in shells.items():
            where[first[piece] : first[piece] + len(shares)] = shares
        return owner, where, node, count


def _shells(mesh: ConstrainedTriangulation, coarse: Refiner, sums: _Sums) -> dict[int, np.ndarray]:
    """Shares of the length at which pieces that end at small angles are split."""
    acute = coarse.acute[mesh.pieces[:, :2]] != 0
    shells = {}
    xy = mesh.triangulation.xy.reshape(-1, 2)
    for piece in np.flatnonzero(acute.any(axis=1) & (sums.total > 1 + _ROUND_UP)):
        p, q = xy[mesh.pieces[piece, :2]]
        length = float(np.hypot(*(q - p)))
        shares, open_ = [], [(0.0, 1.0)]
        while open_:
            a, b = open_.pop()
            if sums.between(piece, a, b) <= 1 + _ROUND_UP:
                continue
            corners = np.concatenate([p, q, p + a * (q - p), p + b * (q - p)])
            x, y = split_place(corners, 2, 3, 0, 1, bool(acute[piece, 0]), bool(acute[piece, 1]))
            middle = float(np.hypot(x - p[0], y - p[1])) / length
            shares.append(middle)
            open_ += [(a, middle), (middle, b)]
        shells[int(piece)] = np.sort(shares)
    return shells
