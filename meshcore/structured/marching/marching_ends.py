"""What happens at the ends of an open front that marches: the boundary conditions of marching grids (survey 2.7)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, Union

import numpy as np

from ...errors import InvalidInput
from ...geometry.curves import arc_length
from . import _marching_front_kernels as kernels


@dataclass(frozen=True)
class Free:
    """The end goes along the front's normal there, drawn towards what its neighbour does."""


@dataclass(frozen=True)
class Mirror:
    """The front meets a plane of symmetry.

    Parameters
    ----------
    direction : tuple of two float, optional
        Along the plane; by default square to the front's end.
    """

    direction: tuple[float, float] | None = None


@dataclass(frozen=True)
class Along:
    """The end keeps to a straight line, going as far as its neighbour.

    Parameters
    ----------
    direction : tuple of two float
        Along the line: (0, 1) is constant x, (1, 0) constant y.
    """

    direction: tuple[float, float]


@dataclass(frozen=True)
class OnCurve:
    """The end goes along a given curve, by the heights of the layers.

    Parameters
    ----------
    points : (m, 2) float
        The curve, from the front's end on; past its last point it goes straight on.
    """

    points: np.ndarray


@dataclass(frozen=True)
class Splay:
    """The end leans outwards, so that the grid spreads.

    Parameters
    ----------
    degrees : float
        Angle from the front's normal, between 0 and 80.
    """

    degrees: float = 15.0


End = Union[Free, Mirror, Along, OnCurve, Splay]


class Conditions(NamedTuple):
    """Conditions at both ends as kernels take them.

    Attributes
    ----------
    kinds : (2,) int
    directions : (2, 2) float
        Unit vectors; of a splay, cosine and sine.
    curves : (2, m, 3) float
        x, y and the length up to there.
    """

    kinds: np.ndarray
    directions: np.ndarray
    curves: np.ndarray


def as_numbers(ends: tuple[End, End], front: np.ndarray, closed: bool = False) -> Conditions:
    """Conditions as kernels take them; those of a closed front are none.

    Raises
    ------
    InvalidInput
        If a direction is zero, an angle too large, or a curve does not begin at the front's end.

    Examples
    --------
    >>> front = np.array([[0.0, 0], [1, 0], [2, 0]])
    >>> as_numbers((Along((0, 2)), Free()), front).directions
    array([[0., 1.],
           [0., 0.]])
    """
    kinds, directions = np.full(2, kernels.CLOSED), np.zeros((2, 2))
    if closed:
        return Conditions(kinds, directions, np.zeros((2, 2, 3)))
    curves = [np.array([[0.0, 0, 0], [1, 0, 1]])] * 2
    for k, end in enumerate(ends):
        at, beside = (front[0], front[1]) if k == 0 else (front[-1], front[-2])
        if isinstance(end, Splay):
            if not 0 <= end.degrees <= 80:
                raise InvalidInput(f"must lie between 0 and 80 degrees, got {end.degrees:g}", parameter="splay")
            kinds[k] = kernels.SPLAY
            directions[k] = math.cos(math.radians(end.degrees)), math.sin(math.radians(end.degrees))
        elif isinstance(end, Mirror):
            kinds[k] = kernels.MIRROR
            x, y = beside - at
            directions[k] = _unit((-y, x) if end.direction is None else end.direction)
        elif isinstance(end, Along):
            kinds[k], directions[k] = kernels.ALONG, _unit(end.direction)
        elif isinstance(end, OnCurve):
            kinds[k], curves[k] = kernels.ON_CURVE, _measured(end.points, at, np.ptp(front, axis=0).max())
        else:
            kinds[k] = kernels.FREE
    longest = max(len(curve) for curve in curves)
    return Conditions(kinds, directions, np.stack([_padded(curve, longest) for curve in curves]))


def _unit(direction) -> np.ndarray:
    vector = np.asarray(direction, float)
    size = float(np.linalg.norm(vector))
    if vector.shape != (2,) or not np.isfinite(size) or size == 0:
        raise InvalidInput(f"needs two numbers that are not both zero, got {direction!r}", parameter="direction")
    return vector / size


def _measured(points: np.ndarray, start: np.ndarray, extent: float) -> np.ndarray:
    """(m, 3) float: the curve's points and its length up to each, turned so that it begins at ``start``."""
    curve = np.asarray(points, float)
    curve = curve[np.concatenate([[True], (np.diff(curve, axis=0) != 0).any(axis=1)])]
    if len(curve) < 2:
        raise InvalidInput("needs at least two different points", parameter="curve")
    gaps = np.linalg.norm(curve[[0, -1]] - start, axis=1)
    if gaps.min() > 1e-6 * extent:
        raise InvalidInput(
            f"begins {gaps.min():.4g} away from the front's end; move an end of it there", parameter="curve"
        )
    curve = curve if gaps[0] <= gaps[1] else curve[::-1]
    return np.column_stack([curve, arc_length(curve)])


def _padded(curve: np.ndarray, count: int) -> np.ndarray:
    """The curve with further points on its straight continuation."""
    extra = np.arange(1, count - len(curve) + 1)[:, None]
    return np.concatenate([curve, curve[-1] + extra * (curve[-1] - curve[-2])])
