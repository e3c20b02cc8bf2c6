"""Planar grids marched from a front to an outer one, as arrays: what `parabolic` and the block topologies call."""

from __future__ import annotations

import numpy as np

from ...errors import InvalidInput
from ...progress import Progress, silent
from .hyperbolic_march import Dissipation, Marched, checked_front, run_until_whole
from .marching_ends import End, OnCurve, as_numbers

Side = np.ndarray


def marched(
    front: np.ndarray,
    outer: np.ndarray,
    fractions: np.ndarray,
    *,
    closed: bool = False,
    sides: tuple[Side | None, Side | None] = (None, None),
    dissipation: Dissipation = Dissipation(),
    progress: Progress = silent,
) -> Marched:
    """Layers that march from a front to an outer front, and end on its points.

    They leave the front by the hyperbolic equations, at right angles, and the farther they have come the more by a
    parabolic one: the elliptic equation's smoothing along the front, while what lies ahead is a local reference grid,
    straight to the outer front.

    Parameters
    ----------
    front, outer : (n, 2) float
        Points in order, the grid to the left; around a section clockwise. Lines join points of the same number. The
        first point of closed fronts is not repeated.
    fractions : (layers + 1,) or (layers + 1, n) float
        From 0 to 1, increasing: the share of the way that each layer ends at, the same along the front or its own for
        each line.
    closed : bool
        Whether the last points are joined to the first.
    sides : two of (m, 2) float or None
        Curves from the first, and the last, point of an open front to the outer one's; by default straight.
    dissipation : Dissipation
        How much the front is smoothed while it is hyperbolic.
    progress : Progress, optional
        Called with fraction and message.

    Returns
    -------
    Marched
        Its last layer is ``outer`` exactly, unless it had to stop.

    Raises
    ------
    InvalidInput
        If shapes do not fit, or fractions do not increase from 0 to 1.
    InvalidGeometry
        If points repeat, or a closed front crosses itself.

    References
    ----------
    S. Nakamura, in "Numerical Grid Generation" (ed. Thompson, 1982). T. A. Edwards, AIAA 85-0485.
    R. W. Noack, D. A. Anderson, AIAA J. 28 (1990).

    Examples
    --------
    >>> x = np.linspace(0, 1, 5)
    >>> south, north = np.column_stack([x, 0 * x]), np.column_stack([x, 1 + 0 * x])
    >>> marched(south, north, np.array([0, 0.25, 1])).points[2]
    array([[0.5 , 0.  ],
           [0.5 , 0.25],
           [0.5 , 1.  ]])
    """
    front, outer = checked_front(front, closed), checked_front(outer, closed, "outer")
    if len(outer) != len(front):
        raise InvalidInput(f"has {len(outer)} points, the front {len(front)}; give as many", parameter="outer")
    shares = _checked_fractions(fractions, len(front))
    ends: list[End] = []
    for k, side in ((0, sides[0]), (-1, sides[1])):
        ends.append(OnCurve(np.array([front[k], outer[k]]) if side is None else _fitted(side, front[k], outer[k])))
    conditions = as_numbers((ends[0], ends[1]), front, closed)
    for curve, end in zip(conditions.curves, ends, strict=True):
        if not closed:
            curve[:, 2] /= curve[len(end.points) - 1, 2]
    return run_until_whole(front, shares[1:], np.ascontiguousarray(outer.T), conditions, dissipation, progress)


def _fitted(side: Side, start: np.ndarray, stop: np.ndarray) -> np.ndarray:
    """A side from the front to the outer front, with its ends on theirs."""
    side = np.array(side, float)
    extent = float(np.ptp(side, axis=0).max())
    if np.linalg.norm(side[0] - start) > np.linalg.norm(side[-1] - start):
        side = side[::-1]
    for k, corner in ((0, start), (-1, stop)):
        gap = float(np.linalg.norm(side[k] - corner))
        if gap > 1e-6 * extent:
            raise InvalidInput(f"ends {gap:.4g} away from {corner.tolist()}; move it there", parameter="side")
        side[k] = corner
    return side[np.concatenate([[True], (np.diff(side, axis=0) != 0).any(axis=1)])]


def _checked_fractions(fractions: np.ndarray, n: int) -> np.ndarray:
    shares = np.asarray(fractions, float)
    if shares.ndim not in (1, 2) or len(shares) < 2 or shares.shape[1:] not in ((), (1,), (n,)):
        raise InvalidInput(f"needs shape (layers + 1,) or (layers + 1, {n}), got {shares.shape}", parameter="fractions")
    shares = np.ascontiguousarray(shares.reshape(len(shares), -1))
    if (shares[0] != 0).any() or (shares[-1] != 1).any() or not (np.diff(shares, axis=0) > 0).all():
        raise InvalidInput("must increase from 0 to 1", parameter="fractions")
    return shares
