"""What the elliptic equations are asked at the walls of grids round sections: first heights, and angles that can be."""

from __future__ import annotations

import numpy as np

from ...geometry.plane import fitted_plane
from ...mesh import StructuredGrid
from ..poisson.wall_control import CORNER_REACH, SHARP, Wall, from_wall, measured, neighbouring_edges, tangents
from ..poisson.winslow import orientation


def wall_of(grid: StructuredGrid, kept: np.ndarray | None) -> Wall:
    """The first heights of a grid, and right angles but where they are kept.

    Parameters
    ----------
    grid : StructuredGrid
        Its wall is j = 0.
    kept : (ni,) float, optional
        How far, from 0 to 1, the angles of its lines are kept.
    """
    points, closed = grid.points[:, :, 0], grid.periodic[0]
    plane = fitted_plane(grid.flat(grid.points), parameter="grid")
    flat = plane.to_plane(points.reshape(-1, 3)).reshape(*points.shape[:2], 2)
    r, sign = np.moveaxis(flat, -1, 0), orientation(flat)
    have = measured(r, "south", sign, closed)
    if kept is not None and kept.any():
        return Wall("south", first_height=have.height, angle=90 + kept * (np.clip(have.angle, 10, 170) - 90))
    line = from_wall(r, "south")[..., 0]
    lean = tangents(line, "south", sign, closed)[1] * np.degrees(shared_turns(line, have.height, closed))
    return Wall("south", first_height=have.height, angle=np.clip(90 + lean, 10, 170))


def shared_turns(line: np.ndarray, height: np.ndarray, closed: bool) -> np.ndarray:
    """(n,) float: by how many radians the lines from points of a curve lean so that neighbours share its kinks.

    Lines that are nearer to each other than they are high cannot be at right angles to edges that differ by more than a
    hair: of the curve's heading the mean over `CORNER_REACH` heights is taken. Where edges are longer than that it is
    what it was. Sharp corners, beside which neither angles nor heights are judged, are not shared.

    Parameters
    ----------
    line : (2, n) float
        The points. If closed, the last is the first.
    height : (n,) float
        Of the first cells.
    closed : bool
        Whether it is a loop.

    Examples
    --------
    >>> x = np.arange(7.0)
    >>> roof = np.array([x, -0.2 * abs(x - 3)])
    >>> shared_turns(roof, np.full(7, 0.4), False).round(3) + 0.0
    array([0., 0., 0., 0., 0., 0., 0.])
    >>> shared_turns(roof, np.full(7, 0.8), False).round(3) + 0.0
    array([ 0.   ,  0.   , -0.072,  0.   ,  0.072,  0.   ,  0.   ])
    """
    ahead, behind, _, _ = neighbouring_edges(line, closed)
    turn = np.arctan2(behind[0] * ahead[1] - behind[1] * ahead[0], (ahead * behind).sum(axis=0))
    turn[np.abs(turn) > SHARP] = 0.0
    step, heading = np.linalg.norm(np.diff(line, axis=1), axis=0), np.cumsum(turn[:-1])
    own = np.append(heading, heading[-1] + turn[-1]) - 0.5 * turn
    first = 0
    if closed:  # once more to both sides
        first = len(step)
        step, heading = np.tile(step, 3), np.concatenate([heading + k * turn[1:].sum() for k in (-1, 0, 1)])
    length = np.concatenate([[0.0], np.cumsum(step)])
    whole = np.concatenate([[0.0], np.cumsum(step * heading)])
    at = length[first : first + len(turn)]
    low, high = (np.clip(at + k * CORNER_REACH * height, 0, length[-1]) for k in (-1, 1))
    return (np.interp(high, length, whole) - np.interp(low, length, whole)) / (high - low) - own


def first_heights(grid: StructuredGrid, past: int) -> np.ndarray:
    """(ni,) float: lengths of the first cells of the lines beyond layers that stay."""
    return np.linalg.norm(grid.points[:, past + 1, 0] - grid.points[:, past, 0], axis=1)
