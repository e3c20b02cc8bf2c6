"""Walls that cannot be had, refused before anything is solved; and walls of grids that have no points inside."""

from __future__ import annotations

import numpy as np

from ...errors import InvalidGeometry, InvalidInput
from .wall_control import Wall, from_wall

NO_INSIDE = "walls are not controlled: the grid has no points inside that could move; take two cells or more each way"


def refuse_wall(points: np.ndarray, wall: Wall) -> None:
    """Refuse a side that has no direction somewhere, values for other points than it has, and impossible heights.

    Parameters
    ----------
    points : (ni, nj, 3) float
        A surface grid.
    wall : Wall
        What is asked at a side.

    Raises
    ------
    InvalidGeometry
        If neighbours on the side are one point.
    InvalidInput
        If heights or angles have another shape, or a height is as long as its line.
    """
    lines = np.moveaxis(from_wall(np.moveaxis(points, -1, 0), wall.side), 0, -1)
    side = lines[:, 0]
    same = np.flatnonzero((side[1:] == side[:-1]).all(axis=1))
    if len(same):
        x, y, z = side[same[0]]
        raise InvalidGeometry(
            f"{wall.side} has two points at ({x:.6g}, {y:.6g}, {z:.6g}), where nothing can leave at an angle; take it "
            "out of the walls, or move its points apart",
            parameter="walls",
        )
    for what, values in (("first height", wall.first_height), ("angle", wall.angle)):
        if np.ndim(values) and np.shape(values) != (len(side),):
            raise InvalidInput(
                f"{wall.side} has {len(side)} points, but its {what} has shape {np.shape(values)}", parameter="walls"
            )
    refuse_heights(np.moveaxis(lines, 1, 0), wall)


def refuse_heights(lines: np.ndarray, wall: Wall) -> None:
    """Refuse first heights that are as long as the whole of a line; lines run along the first axis.

    Examples
    --------
    >>> lines = np.array([[[0.0, 0], [1, 0]], [[0, 1], [1, 1]], [[0, 2], [1, 2]]])
    >>> refuse_heights(lines, Wall("south", first_height=1.0))
    >>> refuse_heights(lines, Wall("south", first_height=2.0))
    Traceback (most recent call last):
    ...
    meshcore.errors.InvalidInput: first_height: is 2 at south, where a whole line is 2 long; ask for less
    """
    if wall.first_height is None:
        return
    length = np.linalg.norm(np.diff(lines, axis=0), axis=-1).sum(axis=0)
    height = np.broadcast_to(wall.first_height, length.shape)
    if ((height >= length) & (length > 0)).any():
        at = np.argmin(np.where(length > 0, length - height, np.inf))
        raise InvalidInput(
            f"is {height.flat[at]:.4g} at {wall.side}, where a whole line is {length.flat[at]:.4g} long; ask for less",
            parameter="first_height",
        )
