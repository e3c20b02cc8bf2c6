"""Corners of cells that the boundary of a block alone makes: beyond 180 degrees nothing can help."""

from __future__ import annotations

from collections.abc import Collection
from itertools import product

import numpy as np

from ...errors import GenerationFailed
from ...mesh import StructuredGrid
from .block_faces import AXES, end


def refuse_corners(grid: StructuredGrid, free: Collection[str] = ()) -> None:
    """Raise `GenerationFailed` if the boundary folds cells at the edges of a block, whatever stands inside.

    At an edge, two faces give a corner of a cell all its points. The message names the edge where the boundary turns
    farthest, by more than 180 degrees measured inside the block.

    Parameters
    ----------
    grid : StructuredGrid
        A right-handed block.
    free : collection of str
        Faces whose points will be moved, so that nothing is known of their edges.

    Raises
    ------
    GenerationFailed
        `cells` are those at which the boundary turns too far, `partial` is the grid.

    Examples
    --------
    >>> points = np.stack(np.meshgrid(*[np.arange(4.0)] * 3, indexing="ij"), axis=-1)
    >>> refuse_corners(StructuredGrid(points))
    >>> points[:, 0, 1, 1] += 2.5
    >>> refuse_corners(StructuredGrid(points))
    Traceback (most recent call last):
    ...
    meshcore.errors.GenerationFailed: the boundary turns by 270 degrees at the edge of imin and jmin at k = 1, ...
    """
    cells, worst = set(), (-1.0, "")
    for axis, low, high in product(range(3), (0, 1), (0, 1)):
        if {end((axis + 1) % 3, low), end((axis + 2) % 3, high)} & set(free):
            continue
        folded, angle, number = _at_edge(grid.points, axis, low, high)
        sides = [0, 0, 0]
        sides[(axis + 1) % 3], sides[(axis + 2) % 3] = low, high
        at = [side * (n - 1) for side, n in zip(sides, grid.cell_shape, strict=True)]
        cells |= {(*at[:axis], int(k), *at[axis + 1 :]) for k in folded}
        if len(folded) and angle > worst[0]:
            worst = angle, _named(grid, axis, sides, number)
    if not cells:
        return
    angle, place = worst
    turns = f"turns by {angle:.0f} degrees" if angle else "has no angle, since points coincide or faces touch,"
    raise GenerationFailed(
        f"the boundary {turns} {place}, and makes {len(cells)} cells folded or flat whatever stands inside; cut the "
        "block there, or move its edge to where faces meet at less than 180 degrees",
        cells=np.sort(np.ravel_multi_index(np.array(sorted(cells)).T, grid.cell_shape, order="F")),
        partial=grid,
    )


def _at_edge(points: np.ndarray, axis: int, low: int, high: int) -> tuple[np.ndarray, float, int]:
    """Cells along an edge with a folded or flat corner at it, the largest angle between the faces there, and where.

    The edge runs along an axis, at the start (0) or end (1) of the next axis, and of the one after that.
    """
    turned = points.transpose(*np.roll(range(3), -axis), 3)
    rows = [(0, 1), (-1, -2)]
    line = turned[:, rows[low][0], rows[high][0]]
    first = turned[:, rows[low][1], rows[high][0]] - line
    second = turned[:, rows[low][0], rows[high][1]] - line
    along = np.diff(line, axis=0)
    length = np.linalg.norm(along, axis=1)
    along /= np.where(length > 0, length, 1.0)[:, None]
    # Two corners of each cell: at the start of its part of the edge, and at the end.
    a, b = np.stack([first[:-1], first[1:]]), np.stack([second[:-1], second[1:]])
    volume = (1 if low == high else -1) * (along * np.cross(a, b)).sum(axis=-1)
    in_plane = (a * b).sum(axis=-1) - (a * along).sum(axis=-1) * (b * along).sum(axis=-1)
    bad = ~((volume > 0) & (length > 0))
    angle = np.where(bad, np.degrees(np.arctan2(volume, in_plane)) % 360, 0.0)
    at_end, cell = divmod(int(angle.argmax()), len(along))
    return np.flatnonzero(bad.any(axis=0)), float(angle.max()), cell + at_end


def _named(grid: StructuredGrid, axis: int, sides: list[int], number: int) -> str:
    """Where a point of an edge is."""
    last = grid.shape[axis] - 1
    faces = [end(a, sides[a]) for a in range(3) if a != axis]
    what = "edge"
    if number in (0, last):
        faces, what = sorted([*faces, end(axis, int(number > 0))]), "corner"
    at = [sides[a] * (grid.shape[a] - 1) for a in range(3)]
    at[axis] = number
    x, y, z = grid.points[tuple(at)]
    names = [grid.names.get(face, face) for face in faces]
    where = "" if what == "corner" else f" at {AXES[axis]} = {number}"
    return f"at the {what} of {', '.join(names[:-1])} and {names[-1]}{where}, near ({x:.6g}, {y:.6g}, {z:.6g})"
