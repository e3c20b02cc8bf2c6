"""The biharmonic equation: positions and slopes at all sides at once, in place of control functions (survey 2.5.1)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse
from scipy.sparse.linalg import splu

from ...errors import InvalidInput
from .wall_control import Wall, from_wall, tangents
from .winslow import orientation

MOST_POINTS = 200_000
"""A direct solver's memory and time grow faster than the number of points."""


def biharmonic(points: np.ndarray, walls: Sequence[Wall] = (), *, cyclic: bool = False) -> np.ndarray:
    """The grid ``r_ssss + 2 r_sstt + r_tttt = 0`` with two lines given along each side.

    s and t are lengths: they run over a rectangle as long and as wide as the given grid on the average.

    J. B. Bell, G. R. Shubin, A. B. Stephens, J. Comput. Phys. 47 (1982). Being of fourth order and linear, it takes
    slopes at the boundary as they are asked, but nothing keeps it from folding where Laplace's grid would not.

    Parameters
    ----------
    points : (ni, nj, 2) float
        A grid; its outermost lines are kept, and the next ones too at sides that are no walls.
    walls : sequence of Wall
        Sides whose next line gets the angle and the height asked; what is left out stays that of the given grid.
    cyclic : bool
        Whether the last row along i is the first.

    Returns
    -------
    (ni, nj, 2) float

    Raises
    ------
    InvalidInput
        If there are more than `MOST_POINTS` points.

    Examples
    --------
    >>> x, y = np.meshgrid(np.linspace(0, 1, 7), np.linspace(0, 1, 6), indexing="ij")
    >>> exact = np.stack([x + 0.1 * x**3, y + 0.2 * x * y**2], axis=-1)
    >>> start = exact.copy()
    >>> start[2:-2, 2:-2] += 0.1
    >>> bool(abs(biharmonic(start) - exact).max() < 1e-12)
    True
    """
    ni, nj = points.shape[:2]
    if ni * nj > MOST_POINTS:
        raise InvalidInput(
            f"has {ni * nj:,} points, the biharmonic equation is solved for at most {MOST_POINTS:,}; take fewer cells, "
            "or Poisson's equation",
            parameter="equation",
        )
    result = _with_second_lines(points, walls, cyclic)
    lengths = [float(np.linalg.norm(np.diff(points, axis=k), axis=2).sum(axis=k).mean()) for k in (0, 1)]
    if nj >= 5 and (ni >= 5 or cyclic):
        solve(result, lengths, cyclic)
    return result


def solve(points: np.ndarray, lengths: Sequence[float], cyclic: bool) -> None:
    """Set all points of a (ni, nj, 2) grid but the two outermost lines, on a rectangle of the given ``lengths``.

    Examples
    --------
    >>> line = np.linspace(0, 1, 7)
    >>> points = np.stack(np.meshgrid(line, line, indexing="ij"), axis=-1)
    >>> points[3, 3] = 5
    >>> solve(points, (1.0, 1.0), False)
    >>> points[3, 3].round(9)
    array([0.5, 0.5])
    """
    ni, nj = points.shape[:2]
    rows = ni - 1 if cyclic else ni
    second_i = _differences(rows, (ni - 1) / lengths[0], cyclic)
    second_j = _differences(nj, (nj - 1) / lengths[1], False)
    one_i, one_j = scipy.sparse.identity(rows), scipy.sparse.identity(nj)
    operator = (
        scipy.sparse.kron(second_i @ second_i, one_j)
        + 2 * scipy.sparse.kron(second_i, second_j)
        + scipy.sparse.kron(one_i, second_j @ second_j)
    ).tocsr()
    free = np.zeros((rows, nj), bool)
    free[slice(None) if cyclic else slice(2, -2), 2:-2] = True
    inside = free.ravel()
    values = points[:rows].reshape(-1, 2)
    equations = operator[inside]
    values[inside] = splu(equations[:, inside].tocsc()).solve(-equations[:, ~inside] @ values[~inside])
    points[:rows] = values.reshape(rows, nj, 2)
    if cyclic:
        points[-1] = points[0]


def _differences(n: int, density: float, cyclic: bool) -> scipy.sparse.csr_matrix:
    """(n, n) second differences with so many cells a length; if it is not cyclic, the outermost rows mean nothing."""
    matrix = scipy.sparse.diags([1.0, -2.0, 1.0], [-1, 0, 1], shape=(n, n), format="lil")
    if cyclic:
        matrix[0, -1] = matrix[-1, 0] = 1.0
    return matrix.tocsr() * density**2


def _with_second_lines(points: np.ndarray, walls: Sequence[Wall], cyclic: bool) -> np.ndarray:
    """The grid with the lines next to walls where they are asked; where two of them cross, half way."""
    result = points.copy()
    moved, times = np.zeros_like(points), np.zeros(points.shape[:2])
    sign = orientation(points)
    for wall in walls:
        view = np.moveaxis(from_wall(np.moveaxis(points, -1, 0), wall.side), 0, -1)
        closed = cyclic and wall.side in ("south", "north")
        edge = view[:, 1] - view[:, 0]
        along, facing = tangents(np.moveaxis(view[:, 0], -1, 0), wall.side, sign, closed)
        out = facing * np.stack([-along[1], along[0]])
        height = np.linalg.norm(edge, axis=1) if wall.first_height is None else wall.first_height
        if wall.angle is None:
            direction = (edge / np.linalg.norm(edge, axis=1)[:, None]).T
        else:
            turn = np.radians(wall.angle)
            direction = np.cos(turn) * along + np.sin(turn) * out
        inner = slice(None) if closed else slice(1, -1)
        new = view[:, 0] + (height * direction).T - view[:, 1]
        np.moveaxis(from_wall(np.moveaxis(moved, -1, 0), wall.side), 0, -1)[inner, 1] += new[inner]
        from_wall(times, wall.side)[inner, 1] += 1
    result += moved / np.maximum(times, 1)[..., None]
    return result
