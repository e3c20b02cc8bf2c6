"""Degenerate points of structured grids: faces and edges that are collapsed, corners that are none (figure 9)."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np

from .structured_grid import FACES, StructuredGrid

_SAME = 1e-12
"""Of the grid's extent: points so near each other are one."""
_FLAT = 1e-6
"""Sine of the angle between two lines below which they go the same way or straight on."""


class Degenerate(NamedTuple):
    """One degeneracy, where difference formulas need care.

    Attributes
    ----------
    place : str
        The face, edge or corner of the block: "imin", "imin jmax", "imin jmin kmax".
    kind : {"point", "line", "straight", "cusp"}
        Collapsed to a point or (a face of a volume) to a line; or a corner at which two lines of the grid go straight
        on, or leave in the same direction.
    points : tuple of two (int, int, int)
        First and last point of the range, both included.
    """

    place: str
    kind: str
    points: tuple[tuple[int, int, int], tuple[int, int, int]]


def degenerate(grid: StructuredGrid) -> tuple[Degenerate, ...]:
    """Find the degenerate places of a grid's boundary; those on closed sides do not count.

    Parameters
    ----------
    grid : StructuredGrid
        A surface or a volume.

    Returns
    -------
    tuple of Degenerate
        Faces first, then edges that belong to no collapsed face, then corners of surfaces.

    References
    ----------
    Survey, section 2.8.1 (figure 9).

    Examples
    --------
    >>> r, t = np.meshgrid([0.0, 1, 2], [0.0, 0.5, 1], indexing="ij")
    >>> degenerate(StructuredGrid(np.stack([r * np.cos(t), r * np.sin(t)], axis=-1)))
    (Degenerate(place='imin', kind='point', points=((0, 0, 0), (0, 2, 0))),)
    """
    axes = [axis for axis in range(3) if grid.shape[axis] > 1]
    open_axes = [axis for axis in axes if not grid.periodic[axis]]
    found = [
        Degenerate(FACES[2 * axis + last], kind, ends)
        for axis in open_axes
        for last in (0, 1)
        for ends in [_ends(grid, {axis: last})]
        for kind in [_collapsed(grid, ends)]
        if kind
    ]
    if not grid.is_surface:
        found += [edge for edge in _edges(grid, open_axes) if not any(_within(edge, face) for face in found)]
    else:
        found += _corners(grid, found)
    return tuple(found)


def _ends(grid: StructuredGrid, fixed: dict[int, int]):
    """First and last point of the part of the block where some axes are at their first (0) or last (1) point."""
    end = [n - 1 for n in grid.shape]
    first = tuple(end[a] * fixed[a] if a in fixed else 0 for a in range(3))
    last = tuple(end[a] * fixed[a] if a in fixed else end[a] for a in range(3))
    return first, last


def _collapsed(grid: StructuredGrid, ends) -> str:
    """Whether a range of points is one "point", or of two directions a "line"; else empty."""
    first, last = ends
    part = grid.points[tuple(slice(a, b + 1) for a, b in zip(first, last, strict=True))]
    near = _SAME * grid.diagonal
    if np.ptp(part.reshape(-1, 3), axis=0).max() <= near:
        return "point"
    long = [axis for axis in range(3) if part.shape[axis] > 1]
    along = [np.ptp(part, axis=axis).max() <= near for axis in long]
    return "line" if len(long) == 2 and any(along) else ""


def _edges(grid: StructuredGrid, axes: list[int]) -> list[Degenerate]:
    found = []
    for n, a in enumerate(axes):
        for b in axes[n + 1 :]:
            for at in product((0, 1), repeat=2):
                ends = _ends(grid, {a: at[0], b: at[1]})
                if kind := _collapsed(grid, ends):
                    found.append(Degenerate(f"{FACES[2 * a + at[0]]} {FACES[2 * b + at[1]]}", kind, ends))
    return found


def _within(edge: Degenerate, face: Degenerate) -> bool:
    return set(face.place.split()) <= set(edge.place.split())


def _corners(grid: StructuredGrid, collapsed: list[Degenerate]) -> list[Degenerate]:
    """Corners of a surface at which its two sides go straight on, or leave in one direction."""
    found = []
    if any(grid.periodic):
        return found
    for last_i, last_j in product((0, 1), repeat=2):
        places = (FACES[last_i], FACES[2 + last_j])
        i, j = -last_i, -last_j
        if any(side.place in places for side in collapsed):
            continue
        along_i = grid.points[i + (-1 if last_i else 1), j, 0] - grid.points[i, j, 0]
        along_j = grid.points[i, j + (-1 if last_j else 1), 0] - grid.points[i, j, 0]
        size = float(np.linalg.norm(along_i) * np.linalg.norm(along_j))
        if size > 0 and np.linalg.norm(np.cross(along_i, along_j)) <= _FLAT * size:
            kind = "cusp" if along_i @ along_j > 0 else "straight"
            found.append(Degenerate(" ".join(places), kind, _ends(grid, {0: last_i, 1: last_j})))
    return found
