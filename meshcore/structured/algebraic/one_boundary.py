"""A patch's boundary in one piece: a closed loop that is cut at four corners, or four chains in any order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise, permutations

import numpy as np
from scipy.spatial import cKDTree

from ...errors import InvalidGeometry, InvalidInput
from ...geometry.curves import Curve, chains, is_closed, polyline, sharpest_corners
from ...mesh import Mesh
from ...sizing.stretches import group_of_lines

FOUND = (-1, -1, -1, -1)
"""Corners that are not given."""


def four_chains(curve: Curve) -> list[np.ndarray] | None:
    """The chains of a mesh of lines that has four open ones, as (n, 3) points and in order around; else None.

    Examples
    --------
    >>> square = [[0, 0], [1, 0], [1, 1], [0, 1]]
    >>> apart = Mesh(square + square, {"line": [[0, 1], [2, 3], [6, 5], [4, 7]]})
    >>> [chain[:, :2].tolist() for chain in four_chains(apart)][:2]
    [[[0.0, 0.0], [1.0, 0.0]], [[1.0, 1.0], [1.0, 0.0]]]
    """
    if not isinstance(curve, Mesh) or not len(curve.get("line")):
        return None
    pieces = [curve.points[chain] for chain in chains(curve)]
    if len(pieces) != 4 or any(is_closed(piece) for piece in pieces):
        return None
    return [pieces[k] for k in order_around(pieces)]


def joined_ends(curve: Mesh, gap: float) -> Mesh:
    """The same lines, or points in order, with open ends that are no farther apart than ``gap`` made one.

    Examples
    --------
    >>> joined_ends(Mesh([[0, 0], [1, 0], [1, 1], [1e-9, 0]], {}), 1e-6).points[-1]
    array([0., 0., 0.])
    """
    if not len(curve.get("line")):
        points = curve.points.copy()
        if len(points) > 3 and np.linalg.norm(points[-1] - points[0]) <= gap:
            points[-1] = points[0]
        return curve.with_points(points)
    degree = np.bincount(curve.get("line").ravel(), minlength=curve.n_points)
    ends = np.flatnonzero(degree == 1)
    near = cKDTree(curve.points[ends]).query_pairs(gap, output_type="ndarray") if len(ends) else np.empty((0, 2), int)
    number = np.arange(curve.n_points)
    for a, b in ends[near]:
        if number[a] == a and number[b] == b:  # two ends, not three
            number[max(a, b)] = min(a, b)
    return replace(curve, cells={kind: number[cells] for kind, cells in curve.cells.items()})


def order_around(curves: Sequence[np.ndarray]) -> tuple[int, ...]:
    """The order in which curves follow one another around, beginning with the first.

    Of the two ways around, that one is taken in which the second curve touches the last end of the first.

    Parameters
    ----------
    curves : sequence of (n, 3) float
        Points in order, in either direction.

    Examples
    --------
    >>> south, west, north, east = np.array([[[0, 0], [1, 0]], [[0, 0], [0, 1]], [[0, 1], [1, 1]], [[1, 0], [1, 1]]])
    >>> order_around([south, west, north, east])
    (0, 3, 2, 1)
    """
    ends = [curve[[0, -1]] for curve in curves]

    def apart(a: np.ndarray, b: np.ndarray) -> float:
        return float(np.linalg.norm(a[:, None] - b[None], axis=2).min())

    size = float(np.ptp(np.concatenate(ends), axis=0).max()) or 1.0

    def gaps(order: tuple[int, ...]) -> tuple[float, float]:
        around = [ends[k] for k in (0, *order)]
        total = sum(apart(a, b) for a, b in zip(around, around[1:] + around[:1], strict=True))
        return round(total / size, 6), apart(around[0][-1:], around[1])

    return (0, *min(permutations(range(1, len(curves))), key=gaps))


def cut_loop(curve: Curve, corners: tuple[int, ...], shifts: tuple[int, ...]) -> tuple[np.ndarray, ...]:
    """South, east, north and west of a closed loop, each (n, 3) float and directed as drawn.

    Parameters
    ----------
    curve : Curve
        The loop.
    corners : tuple of four int
        Numbers of its points; `FOUND` takes those that the mesh marks, else the sharpest turns.
    shifts : tuple of four int
        Points along the loop by which each corner moves, in the order in which they come along it.

    Raises
    ------
    InvalidGeometry
        If it is open, or has several pieces.
    InvalidInput
        If these are no four corners.

    Examples
    --------
    >>> from meshcore.gallery import square
    >>> south, east, north, west = cut_loop(square(2), FOUND, (0, 0, 1, 0))
    >>> east[:, :2].tolist(), north[:, :2].tolist()
    ([[1.0, 0.0], [1.0, 0.5], [1.0, 1.0], [0.5, 1.0]], [[0.0, 1.0], [0.5, 1.0]])
    """
    number = _only_chain(curve)
    # Points are numbered as the user numbers them: in a mesh, not in the order of the chain.
    loop = polyline(curve if number is None else curve.points[number], "south")
    n = len(loop) - 1
    number = np.arange(n + 1) if number is None else number
    if not is_closed(loop):
        raise InvalidGeometry(
            "is open; close the loop, or give all four sides", parameter="south", points=number[[0, -1]]
        )
    if corners != FOUND:
        at = np.flatnonzero(np.isin(number[:-1], corners))
        if len(at) != 4:
            raise InvalidInput(f"needs four different points of the loop, got {tuple(corners)}", parameter="corners")
    else:
        at = _marked(curve, number)
        at = sharpest_corners(loop) if at is None else at
    moved = at + np.asarray(shifts)
    if (np.diff(moved, append=moved[0] + n) < 1).any():
        raise InvalidInput(
            f"{tuple(shifts)} makes corners meet or change places: they are the points {_listed(at)} of {n} along the "
            "loop; move them less",
            parameter="shift_corners",
        )
    stops = np.append(moved, moved[0] + n)
    south, east, north, west = (loop[np.arange(a, b + 1) % n] for a, b in pairwise(stops))
    return south, east, north[::-1], west[::-1]


def _only_chain(curve: Curve) -> np.ndarray | None:
    """The numbers of the points of a mesh of lines in order; None of points that are in order already."""
    if not isinstance(curve, Mesh) or not len(curve.get("line")):
        return None
    pieces = chains(curve)
    if len(pieces) > 1:
        raise InvalidGeometry(
            f"needs one closed loop or four chains of line cells, got {len(pieces)} pieces; join their ends, or give "
            "all four sides",
            parameter="south",
            points=sorted({int(p) for piece in pieces for p in (piece[0], piece[-1])}),
        )
    return pieces[0]


def _marked(curve: Curve, number: np.ndarray) -> np.ndarray | None:
    """(4,) int: where along a loop there are four "vertex" cells, or whole-number data of its lines change."""
    if not isinstance(curve, Mesh):
        return None
    vertices = np.flatnonzero(np.isin(number[:-1], curve.get("vertex")))
    if len(vertices) == 4:
        return vertices
    lines = np.sort(curve.get("line"), axis=1)
    along = np.sort(np.column_stack([number[:-1], number[1:]]), axis=1)
    if not len(lines):
        return None
    code = curve.n_points
    order = np.argsort(lines @ [code, 1])
    group = group_of_lines(curve)[order[np.searchsorted(lines @ [code, 1], along @ [code, 1], sorter=order)]]
    changes = np.flatnonzero(group != np.roll(group, 1))
    return changes if len(changes) == 4 else None


def _listed(numbers: np.ndarray) -> str:
    return ", ".join(map(str, numbers.tolist()))
