"""Faces around walls: their points, respaced so that the cells that touch a wall begin as high as those inside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...errors import InvalidInput
from ...geometry.curves import resampled
from ...sizing import hyperbolic_tangent
from ..algebraic.block_faces import end
from .wall_control import Wall


def respaced(points: np.ndarray, walls: Sequence[Wall]) -> np.ndarray:
    """A block whose lines on the four faces around a wall begin with the wall's first height.

    Points move along their lines; cells grow by Vinokur's hyperbolic tangent from there to the size that the last ones
    have, or to the first height of the wall that is opposite. The inside is left alone.

    Parameters
    ----------
    points : (ni, nj, nk, 3) float
        The block.
    walls : sequence of Wall
        Those with a first height count.

    Raises
    ------
    InvalidInput
        If no spacing has such first heights.

    Examples
    --------
    >>> box = np.stack(np.meshgrid(*[np.linspace(0, 1, 5)] * 3, indexing="ij"), axis=-1)
    >>> respaced(box, [Wall("kmin", 0.1)])[0, 2, :, 2].round(3)
    array([0.   , 0.1  , 0.366, 0.75 , 1.   ])
    """
    points = points.copy()
    heights = {wall.side: wall.first_height for wall in walls if wall.first_height is not None}
    for axis in range(3):
        names = end(axis, 0), end(axis, 1)
        if not heights.keys() & names or points.shape[axis] < 3:
            continue
        lines = np.moveaxis(points, axis, -2)
        rim = np.ones(lines.shape[:2], bool)
        rim[1:-1, 1:-1] = False
        firsts = [_over_face(heights, name, rim.shape) for name in names]
        for at in map(tuple, np.argwhere(rim)):
            lines[at] = _line(lines[at], *(None if first is None else first[at] for first in firsts), names)
    return points


def _over_face(heights: Mapping[str, float | np.ndarray], name: str, shape: tuple[int, ...]) -> np.ndarray | None:
    return np.broadcast_to(np.asarray(heights[name], float), shape) if name in heights else None


def _line(points: np.ndarray, first: float | None, last: float | None, names: tuple[str, str]) -> np.ndarray:
    """(n, 3) points moved along their line to given end cells; a line that is a point stays."""
    length = np.linalg.norm(np.diff(points, axis=0), axis=1)
    total = float(length.sum())
    if total == 0:
        return points
    ends = [
        float(own if given is None else given) / total
        for own, given in zip(length[[0, -1]], (first, last), strict=True)
    ]
    try:
        fractions = hyperbolic_tangent(len(length), first=ends[0], last=ends[1])
    except InvalidInput as failure:
        which = " and ".join(name for name, given in zip(names, (first, last), strict=True) if given is not None)
        raise InvalidInput(
            f"no spacing of {len(length)} cells begins with those of {which}, {ends[0] * total:.4g} and "
            f"{ends[1] * total:.4g}, on a line of length {total:.4g}: {failure}",
            parameter="first_height",
        ) from failure
    return resampled(points, fractions)


def mismatch(points: np.ndarray, walls: Sequence[Wall]) -> float:
    """The largest factor between a wall's first heights and the first edges on the faces around it; 1 if they agree.

    Examples
    --------
    >>> box = np.stack(np.meshgrid(*[np.linspace(0, 1, 5)] * 3, indexing="ij"), axis=-1)
    >>> round(mismatch(box, [Wall("kmin", 0.1)]), 3)
    2.5
    """
    worst = 1.0
    for wall in walls:
        if wall.first_height is None:
            continue
        axis = "ijk".index(wall.side[0])
        lines = np.moveaxis(points, axis, 0)[:: -1 if wall.side.endswith("max") else 1]
        edge = np.linalg.norm(lines[1] - lines[0], axis=-1)
        factor = edge / np.broadcast_to(np.asarray(wall.first_height, float), edge.shape)
        factor[1:-1, 1:-1] = 1.0
        worst = max(worst, float(factor.max()), 1 / max(float(factor[factor > 0].min(initial=1.0)), 1e-300))
    return worst
