"""Stretches of a curve between its corners, as `discretised` divides them."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field

import numpy as np

from ..geometry.curves import arc_length, chains
from ..geometry.parametric import ParametricCurve, spline
from ..mesh import Mesh


@dataclass
class Stretch:
    """A piece of a curve from one corner to the next.

    Attributes
    ----------
    curve : ParametricCurve
        Its shape.
    knots : (k,) float
        Parameters between which it is smooth, from first to last.
    corners : tuple of int
        Points of the input at its two ends.
    nodes : (k,) int
        Points of the input at the knots; empty for a parametric curve.
    lines : (k - 1,) int
        Cells of the input between the knots; empty for a parametric curve.
    """

    curve: ParametricCurve
    knots: np.ndarray
    corners: tuple[int, int]
    nodes: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))
    lines: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))

    @property
    def length(self) -> float:
        """Length of the polyline through the knots and the middles between them."""
        middles = 0.5 * (self.knots[1:] + self.knots[:-1])
        return float(arc_length(self.curve.points(np.sort(np.concatenate([self.knots, middles]))))[-1])

    def samples(self, parts: int) -> np.ndarray:
        """(m,) parameters: each interval between knots in so many equal parts."""
        steps = self.knots[:-1, None] + np.diff(self.knots)[:, None] * (np.arange(parts) / parts)
        return np.append(steps.ravel(), self.knots[-1])

    def line_at(self, parameters: np.ndarray) -> np.ndarray:
        """(m,) int: the cell of the input at each parameter."""
        if not len(self.lines):
            return np.zeros(len(parameters), np.int64)
        return self.lines[np.clip(np.searchsorted(self.knots, parameters, side="right") - 1, 0, len(self.lines) - 1)]


def stretches_of(mesh: Mesh, corner_angle: float, smooth: bool) -> list[Stretch]:
    """The stretches of a mesh's line cells; lines without length are passed over.

    Parameters
    ----------
    mesh : Mesh
        "line" cells.
    corner_angle : float
        Degrees; turns by more are corners.
    smooth : bool
        Whether the shape between corners is a spline rather than the lines themselves.

    Returns
    -------
    list of Stretch

    Examples
    --------
    >>> from meshcore.gallery import square
    >>> [stretch.corners for stretch in stretches_of(square(2), 30.0, False)]
    [(0, 2), (2, 4), (4, 6), (6, 0)]
    """
    lines = mesh.get("line")
    start = next((where.start for kind, _, where in mesh.blocks() if kind == "line"), 0)
    real = np.flatnonzero((mesh.points[lines[:, 0]] != mesh.points[lines[:, 1]]).any(axis=1))
    number = {}
    for k in real[::-1].tolist():
        number[frozenset(lines[k].tolist())] = k  # of lines that repeat, the first
    first = np.array(sorted(number.values()), np.int64)
    group = group_of_lines(mesh)
    fixed = np.zeros(mesh.n_points, bool)
    fixed[mesh.get("vertex").ravel()] = True
    fixed |= np.bincount(lines[first].ravel(), minlength=mesh.n_points) > 2  # branches, where chains end
    found = []
    for chain in chains(Mesh(mesh.points, {"line": lines[first]})):
        of = np.array([number[frozenset(pair)] for pair in itertools.pairwise(chain.tolist())])
        closed = chain[0] == chain[-1]
        stops = np.flatnonzero(_corners(mesh.points[chain], group[of], fixed[chain], corner_angle, closed))
        whole = closed and not len(stops)
        if closed:  # begin with a corner, if there is one
            shift = int(stops[0]) if len(stops) else 0
            ring, of = np.roll(chain[:-1], -shift), np.roll(of, -shift)
            chain, stops = np.append(ring, ring[0]), np.append(stops - shift, len(of))
            stops = np.unique(np.append(stops, 0))
        for a, b in itertools.pairwise(stops.tolist()):
            nodes = chain[a : b + 1]
            curve = _shape(mesh.points[nodes], smooth, closed=bool(whole))
            ends = (int(nodes[0]), int(nodes[-1]))
            found.append(Stretch(curve, curve.knots, ends, nodes, start + of[a:b]))
    return found


def _shape(points: np.ndarray, smooth: bool, *, closed: bool) -> ParametricCurve:
    if smooth and len(points) > 2:
        return spline(points[:-1] if closed else points, closed=closed)
    knots = arc_length(points)

    def along(at: np.ndarray) -> np.ndarray:
        return np.column_stack([np.interp(at, knots, x) for x in points.T])

    return ParametricCurve(along, 0.0, float(knots[-1]), knots)


def _corners(points: np.ndarray, group: np.ndarray, fixed: np.ndarray, angle: float, closed: bool) -> np.ndarray:
    """Which points of a chain are corners; the last of a closed one, which is the first, never counts."""
    along = np.diff(points, axis=0)
    along /= np.abs(along).max(axis=1, keepdims=True)  # squares of lengths below 1e-154 would underflow
    before, after = (np.roll(along, 1, axis=0), along) if closed else (along[:-1], along[1:])
    turn = np.degrees(np.arctan2(np.linalg.norm(np.cross(before, after), axis=1), (before * after).sum(axis=1)))
    other = (np.roll(group, 1) != group) if closed else (group[:-1] != group[1:])
    inner = (turn > angle + 1e-9) | other
    if closed:
        return np.append(inner | fixed[:-1], False)
    return np.concatenate([[True], inner | fixed[1:-1], [True]])


def group_of_lines(mesh: Mesh) -> np.ndarray:
    """(m,) int: for each "line" cell, the same number where whole-number data and sets are the same.

    Examples
    --------
    >>> group_of_lines(Mesh([[0, 0], [1, 0], [2, 0]], {"line": [[0, 1], [1, 2]]}, cell_data={"tag": [7, 5]}))
    array([1, 0])
    """
    start = next((where.start for kind, _, where in mesh.blocks() if kind == "line"), 0)
    cells = start + np.arange(len(mesh.get("line")))
    columns = [np.isin(cells, members).astype(np.int64) for members in mesh.sets.values()]
    for values in mesh.cell_data.values():
        if values.dtype.kind in "iub":
            columns += list(values[cells].reshape(len(cells), -1).T.astype(np.int64))
    if not columns or not len(cells):
        return np.zeros(len(cells), np.int64)
    return np.unique(np.column_stack(columns), axis=0, return_inverse=True)[1].ravel()
